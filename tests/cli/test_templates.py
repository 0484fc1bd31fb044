"""Starter studies of each question, and a study from standard input."""

import io
import json
import re
import tomllib
from pathlib import Path

import jsonschema
import pytest

from tendon_cli.commands.starter import TEMPLATES, starter
from tendon_cli.studies.json_schema import schema_text
from tendon_cli.studies.load import load_study
from tendon_cli.studies.study_file import read_yaml
from tests.cli.conftest import set_options

ROOT = Path(__file__).parents[2]
STUDY = '[load]\nmass = ["0 kg", "5 kg"]\n'
SMALLER = {
    "design": ["uncertainty.draws=32", "design.verify=500"],
    "people": ["people.count=20"],
    "friction": ["uncertainty.draws=8"],
    "robust": [
        "people.count=20",
        "uncertainty.draws=16",
        "spring.stiffness=[6000, 7000]",
        "arm.contact_width=100 mm",
    ],
    "motor": ["spring.stiffness=[5000, 8000]"],
}


def test_a_template_is_a_valid_study_that_names_its_schema(tendon, workplace):
    schema = jsonschema.Draft202012Validator(json.loads(schema_text()))
    file = workplace / "mine.toml"
    for template in TEMPLATES:
        assert tendon("init", "mine.toml", "--for", template).exit == 0
        text = file.read_text(encoding="utf-8")
        assert "#:schema ./tendon.schema.json" in text.splitlines()
        schema.validate(tomllib.loads(text))
        study = load_study(file)
        assert (study.name, study.warnings) == ("mine", ())
        file.unlink()


@pytest.mark.parametrize("template", TEMPLATES)
def test_a_template_in_yaml_is_the_same_study(template):
    text = starter(Path("mine.yaml"), template)
    in_yaml = read_yaml(text).content
    in_toml = tomllib.loads(starter(Path("mine.toml"), template))
    assert in_yaml == in_toml
    assert list(in_yaml) == list(in_toml)
    assert "# yaml-language-server: $schema=./tendon.schema.json" in text.splitlines()


@pytest.mark.parametrize("template", [name for name in TEMPLATES if name != "sweep"])
def test_a_template_has_an_answer(tendon, template):
    tendon("init", "mine.toml", "--for", template)
    smaller = set_options(*SMALLER.get(template, []))
    ran = tendon("design", "mine.toml", "--no-figures", "--json", *smaller)
    # Nothing promises that some suit serves enough of the arms of the robust study, nor that a
    # fresh sample confirms what the few persons of the smaller study chose.
    finished = (0, 4) if template in ("robust", "people") else (0,)
    assert ran.exit in finished
    assert ran.err == ""
    assert ran.json["name"] == "mine"


def test_the_tutorial_ends_with_the_starter_of_one_elbow():
    """Whoever asks for the study of the tutorial gets it, but for the friction of the fit."""
    page = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
    shown = re.search(r"^```toml\n(# file: mine.toml\n.*?)^```", page, re.DOTALL | re.MULTILINE)
    assert shown is not None
    in_tutorial = tomllib.loads(shown[1])
    written = tomllib.loads(starter(Path("mine.toml"), "design"))
    assert in_tutorial["sheath"].pop("friction_from") == "friction.toml"
    del written["sheath"]["friction"]
    assert in_tutorial == written


@pytest.mark.parametrize("name", ["suit", "suit.toml"])
def test_the_study_of_the_readme_is_the_one_that_its_name_copies(tendon, workplace, configs, name):
    assert tendon("init", "--from", name).exit == 0
    assert (workplace / "suit.toml").read_bytes() == (configs / "suit.toml").read_bytes()


def test_a_study_from_standard_input_is_the_study_of_the_file(outside, tendon, write_study):
    write_study(STUDY)
    words = ("--no-figures", "--json", "--set", "tendon.pretension=170 N")
    from_input = outside("sweep", "-", "--out", "one", *words, input=STUDY)
    from_file = tendon("sweep", "study.toml", "--out", "other", *words)
    assert (from_input.exit, from_input.err) == (0, "")
    assert from_input.json["name"] == "study"
    assert from_input.json["study_hash"] == from_file.json["study_hash"]


ROUTE = """\
x_mm,y_mm,z_mm
0,0,0
100,0,0
200,50,0
200,150,0
"""
IN_TOML = """
[load]
mass = [0, 5]
[sheath]
path = "route.csv"
"""
IN_YAML = """\
load:
  mass: [0 kg, 5 kg]
sheath:
  path: route.csv
"""


def test_yaml_from_standard_input_is_read_as_such_with_files_of_the_working_directory(
    tendon, workplace, write_study, monkeypatch
):
    (workplace / "route.csv").write_text(ROUTE, encoding="utf-8")
    write_study(IN_TOML)
    from_file = tendon("state", "study.toml", "--json")
    for before in ("", "# a comment\n\n", "---\n"):
        typed = io.TextIOWrapper(io.BytesIO((before + IN_YAML).encode()))
        monkeypatch.setattr("sys.stdin", typed)
        from_input = tendon("state", "-", "--json")
        assert (from_input.exit, from_input.err) == (0, "")
        assert from_input.json == from_file.json


@pytest.mark.parametrize(
    ("name", "verb"),
    [
        ("design/universal.toml", "design"),
        ("universal", "design"),
        ("table_a1.csv", "fit-friction"),
        ("fig07", "sweep"),
    ],
)
def test_a_file_of_the_documentation_is_copied_by_its_name(tendon, configs, name, verb):
    ran = tendon("init", "--from", name)
    assert ran.exit == 0, ran.err
    (copied,) = Path().iterdir()
    original = next(configs.rglob(copied.name))
    assert copied.read_bytes() == original.read_bytes()
    assert f"tendon {verb} {copied}" in ran.out
    assert tendon("init", "--from", name).exit == 2, "an existing file is not written over"


def test_questions_and_what_can_be_copied_are_listed(tendon, workplace, configs):
    lines = tendon("init", "--list").out.splitlines()
    listed = {line.split()[0] for line in lines if line.strip()}
    studies = {file.relative_to(configs).as_posix() for file in configs.rglob("*.toml")}
    assert {*TEMPLATES, *studies} <= listed
    assert list(workplace.iterdir()) == []
