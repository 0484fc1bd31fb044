"""Every shipped study loads, names its schema, and says what the schema allows."""

import json
import tomllib
from pathlib import Path

import jsonschema
import pytest

from tendon_cli.engine.plan import Plan
from tendon_cli.studies.load import load_study
from tendon_cli.studies.schema import schema_text

CONFIGS = Path(__file__).parents[2] / "configs"
STUDIES = sorted(str(file.relative_to(CONFIGS)) for file in CONFIGS.rglob("*.toml"))


def test_the_studies_of_the_paper_and_two_more_are_there():
    paper = {f"paper/fig{number}.toml" for number in ("04", "06", "07", "08", "09", "10", "11")}
    assert paper | {"quickstart.toml", "large.toml"} <= set(STUDIES)


@pytest.mark.parametrize("name", STUDIES)
def test_a_shipped_study_loads(name):
    study = load_study(CONFIGS / name)
    assert Plan(study).designs >= 1
    assert study.title


@pytest.mark.parametrize("name", STUDIES)
def test_a_shipped_study_names_its_schema_in_the_first_line(name):
    file = CONFIGS / name
    mark, _, path = file.read_text(encoding="utf-8").splitlines()[0].partition(" ")
    assert mark == "#:schema"
    assert (file.parent / path).resolve() == CONFIGS / "tendon.schema.json"


@pytest.mark.parametrize("name", STUDIES)
def test_a_shipped_study_fits_the_schema(name):
    jsonschema.validate(tomllib.loads((CONFIGS / name).read_text(encoding="utf-8")), json.loads(schema_text()))


@pytest.mark.parametrize("name", STUDIES)
def test_a_shipped_study_is_named_after_its_file(name):
    assert load_study(CONFIGS / name).name == Path(name).stem


def test_the_shipped_schema_is_what_the_command_prints(tendon, configs):
    assert (configs / "tendon.schema.json").read_text(encoding="utf-8").rstrip("\n") == tendon("schema").out.rstrip(
        "\n"
    )


def test_the_schema_is_a_schema(tendon):
    jsonschema.Draft202012Validator.check_schema(tendon("schema").json)


def test_large_is_about_a_million_designs_and_only_their_table(configs):
    study = load_study(configs / "large.toml")
    assert 0.9e6 < Plan(study).designs < 1.2e6
    assert study.output.tables == ("designs",)
