"""Starter studies of each question, and a study from standard input."""

import json
import tomllib
from pathlib import Path

import jsonschema
import pytest

from tendon_cli.studies.json_schema import schema_text
from tendon_cli.studies.load import load_study
from tendon_cli.studies.starter import TEMPLATES, starter
from tendon_cli.studies.study_file import read_yaml

STUDY = b'[load]\nmass = ["0 kg", "5 kg"]\n'
SMALLER = {
    "design": ["spring.stiffness=[4000, 6000]"],
    "people": ["people.count=20"],
    "friction": ["uncertainty.draws=8"],
    "robust": [
        "people.count=40",
        "uncertainty.draws=32",
        "spring.stiffness=[6000, 7000]",
        "arm.contact_width=100 mm",
    ],
    "motor": ["spring.stiffness=[5000, 8000]"],
}


@pytest.mark.parametrize("template", TEMPLATES)
def test_a_template_is_a_valid_study_that_names_its_schema(tendon, workplace, template):
    assert tendon("init", "mine.toml", "--template", template).exit == 0
    text = (workplace / "mine.toml").read_text(encoding="utf-8")
    assert "#:schema ./tendon.schema.json" in text.splitlines()
    jsonschema.validate(tomllib.loads(text), json.loads(schema_text()))
    study = load_study(workplace / "mine.toml")
    assert (study.name, study.warnings) == ("mine", ())


@pytest.mark.parametrize("template", TEMPLATES)
def test_a_template_in_yaml_is_the_same_study(template):
    text = starter(Path("mine.yaml"), template)
    in_yaml, in_toml = read_yaml(text).content, tomllib.loads(starter(Path("mine.toml"), template))
    assert (in_yaml, list(in_yaml)) == (in_toml, list(in_toml))
    assert "# yaml-language-server: $schema=./tendon.schema.json" in text.splitlines()


@pytest.mark.parametrize("template", [name for name in TEMPLATES if name != "sweep"])
def test_a_template_has_an_answer(tendon, template):
    tendon("init", "mine.toml", "--template", template)
    smaller = [word for setting in SMALLER.get(template, []) for word in ("--set", setting)]
    ran = tendon("design", "mine.toml", "--no-figures", "--json", *smaller)
    assert (ran.exit, ran.err) == (0, "")
    assert ran.json["name"] == "mine"


@pytest.mark.parametrize("command", ["sweep", "design"])
def test_a_study_from_standard_input_is_the_study_of_the_file(outside, workplace, command):
    (workplace / "study.toml").write_bytes(STUDY)
    words = (
        "--no-figures",
        "--json",
        "--set",
        "spring.stiffness=5 kN/m",
        "--set",
        "spool.ratio=0.6",
    )
    piped = outside(command, "-", "--out", "one", *words, input=STUDY.decode())
    filed = outside(command, "study.toml", "--out", "other", *words)
    assert (piped.exit, piped.err, piped.json["name"]) == (0, "", "study")
    assert piped.json["study_hash"] == filed.json["study_hash"]


@pytest.mark.parametrize("before", ["", "# a comment\n\n", "---\n"])
def test_yaml_from_standard_input_is_read_as_such_with_files_of_the_working_directory(
    outside, workplace, before
):
    (workplace / "route.csv").write_text(
        "x_mm,y_mm,z_mm\n0,0,0\n100,0,0\n200,50,0\n200,150,0\n", encoding="utf-8"
    )
    (workplace / "study.toml").write_text(
        '[load]\nmass = [0, 5]\n[sheath]\npath = "route.csv"\n', encoding="utf-8"
    )
    piped = outside(
        "state",
        "-",
        "--json",
        input=f"{before}load:\n  mass: [0 kg, 5 kg]\nsheath:\n  path: route.csv\n",
    )
    assert (piped.exit, piped.err) == (0, "")
    assert piped.json == outside("state", "study.toml", "--json").json


@pytest.mark.parametrize("name", ["design/universal.toml", "universal", "table_a1.csv", "fig07"])
def test_a_file_of_the_documentation_is_copied_by_its_name(tendon, configs, name):
    ran = tendon("init", "--from", name)
    assert ran.exit == 0, ran.err
    (copied,) = Path().iterdir()
    assert copied.read_bytes() == next(configs.rglob(copied.name)).read_bytes()
    verb = {".csv": "fit-friction"}.get(copied.suffix, "design" if "uni" in name else "sweep")
    assert f"tendon {verb} {copied}" in ran.out
    assert tendon("init", "--from", name).exit == 2, "what stands there is not written over"


def test_questions_and_what_can_be_copied_are_listed(tendon, workplace, configs):
    listed = {
        word for line in tendon("init", "--list").out.splitlines() for word in line.split()[:1]
    }
    assert {
        *TEMPLATES,
        *(file.relative_to(configs).as_posix() for file in configs.rglob("*.toml")),
    } <= listed
    assert list(workplace.iterdir()) == []
