"""The shipped studies load, name their schema, and say what the schema allows."""

import json
import tomllib
from pathlib import Path

import jsonschema
import pytest

from tendon_cli.engine.plan import Plan
from tendon_cli.studies.json_schema import schema_text
from tendon_cli.studies.load import load_study

CONFIGS = Path(__file__).parents[2] / "configs"
STUDIES = sorted(str(file.relative_to(CONFIGS)) for file in CONFIGS.rglob("*.toml"))


def test_the_studies_of_the_paper_and_two_more_are_there():
    paper = {f"paper/fig{number}.toml" for number in ("04", "06", "07", "08", "09", "10", "11")}
    assert paper | {"quickstart.toml", "large.toml"} <= set(STUDIES)


@pytest.fixture(scope="module")
def validator():
    """Return the validator of the schema that the command prints."""
    return jsonschema.Draft202012Validator(json.loads(schema_text()))


@pytest.mark.parametrize("name", STUDIES)
def test_a_shipped_study_loads_is_named_after_its_file_and_fits_the_schema_of_its_first_line(
    name, validator
):
    file = CONFIGS / name
    study = load_study(file)
    text = file.read_text(encoding="utf-8")
    assert Plan(study).designs >= 1
    assert study.title
    assert study.name == file.stem
    mark, _, path = text.splitlines()[0].partition(" ")
    assert mark == "#:schema"
    assert (file.parent / path).resolve() == CONFIGS / "tendon.schema.json"
    validator.validate(tomllib.loads(text))


def test_the_shipped_schema_is_a_schema_and_what_the_command_prints(tendon, configs):
    ran = tendon("init", "--schema")
    assert (ran.exit, ran.err) == (0, "")
    shipped = (configs / "tendon.schema.json").read_text(encoding="utf-8")
    assert shipped.rstrip("\n") == ran.out.rstrip("\n")


def test_large_is_about_a_million_designs_and_only_their_table(configs):
    study = load_study(configs / "large.toml")
    assert 0.9e6 < Plan(study).designs < 1.2e6
    assert study.output.tables == ("designs",)
