"""The JSON Schema of a study takes what a study takes, and refuses what it refuses."""

import jsonschema
import pytest
from hypothesis import given

from tendon_cli.studies.load import study_from
from tendon_cli.studies.study import Study, keys
from tendon_cli.units import UNITS
from tests.sampled import check_all

from .test_study import BASELINE, contents

SCHEMA = Study.model_json_schema()
CHECK = jsonschema.Draft202012Validator(SCHEMA)


def resolved(node):
    """Yield a node and every node that it may stand for."""
    yield node
    if "$ref" in node:
        yield from resolved(SCHEMA["$defs"][node["$ref"].rpartition("/")[2]])
    for choice in node.get("anyOf", []):
        yield from resolved(choice)


def tables():
    """Return the keys of every table of the schema by the table's name."""
    parts = {name: part["properties"] for name, part in SCHEMA["$defs"].items()}
    return {"Study": SCHEMA["properties"], **parts}


def test_it_is_a_schema():
    jsonschema.Draft202012Validator.check_schema(SCHEMA)


def test_every_key_is_described():
    described = {}
    for table, properties in tables().items():
        for key, property_of_key in properties.items():
            nodes = resolved(property_of_key)
            described[table, key] = any(node.get("description") for node in nodes)
    assert [name for name, is_described in described.items() if not is_described] == []
    assert len(described) > 150


def test_every_number_says_its_symbol_and_unit():
    for path, key in keys().items():
        node = SCHEMA
        for part in path.split("."):
            table = next(choice for choice in resolved(node) if "properties" in choice)
            node = table["properties"][part]
        (number,) = [choice for choice in resolved(node) if "x-unit" in choice]
        assert number["x-unit"] == key.number.quantity.unit
        assert key.number.quantity.symbol in number["description"]


def test_no_table_takes_unknown_keys():
    assert SCHEMA["additionalProperties"] is False
    for name, part in SCHEMA["$defs"].items():
        assert part.get("additionalProperties") is False, name


@given(contents())
def test_it_takes_every_valid_study_as_written_and_as_resolved(content):
    study = study_from(content)
    assert list(CHECK.iter_errors(content)) == []
    assert list(CHECK.iter_errors(study.document())) == []


def test_it_takes_every_unit_of_a_key_and_no_other():
    def check(symbol, dimension):
        for key in BASELINE:
            table, name = key.split(".")
            is_of_key = dimension in keys()[key].number.dimensions
            for text in (f"1 {symbol}", f"1{symbol}", f"1.5e0  {symbol}"):
                assert CHECK.is_valid({"name": "a", table: {name: text}}) is is_of_key, key

    units = [(unit.symbol, unit.dimension) for unit in UNITS.values() if unit.symbol != "1"]
    check_all(check, units)


@pytest.mark.parametrize(
    "content",
    [
        {
            "name": "a",
            "sheath": {
                "path": "route.csv",
                "path_smoothing": "1 mm",
                "friction_from": "friction.toml",
            },
        },
        {
            "name": "a",
            "cases": [{"name": "b", "arm": {"b1": "160 mm"}, "model": {"slack": "bilateral"}}],
        },
        {},
        {"motion": {"elbow_angle": {"from": 0, "to": "90 deg", "step": "1 deg"}}},
        {"load": {"mass": {"value": "5 kg", "tolerance": "10 %"}}, "sheath": {"bend_angle": 0}},
        {
            "load": {"mass": {"value": "5 kg", "tolerance": "100 g"}},
            "sheath": {"friction": {"mean": 0.07, "std": 0.002}},
        },
        {
            "limits": {"max_tension": ["300 N", "400 N"], "peak_motor_power": 40},
            "motion": {"speed": "60 deg/s"},
        },
        {"output": {"states": ["status", "flexor_tension_distal"]}},
        {
            "design": {
                "conditions": "load.mass",
                "serve": "95 %",
                "minimise": ["pretension"],
                "maximise": [],
            }
        },
        {"uncertainty": {"draws": 128, "seed": 0, "exact": ["arm"]}},
    ],
)
def test_it_takes_what_a_study_file_may_say(content):
    assert list(CHECK.iter_errors(content)) == []


@pytest.mark.parametrize(
    "content",
    [
        {"colour": "red"},
        {"limits": {"max_tension": "300 N +/- 10 N"}},
        {"limits": {"max_tension": {"from": "300 N", "to": "400 N"}}},
        {"output": {"states": []}},
        {"design": {"serve": 1.1}},
        {"design": {"minimise": ["tolerance", "tolerance"]}},
        {"uncertainty": {"draws": 100}},
        {"arm": 3},
        {"tendon": {"flexor": {"lenght": 1}}},
        {"name": "a/b"},
        {"name": "a" * 65},
        {"title": 3},
        {"load": {"mass": "1,5 kg"}},
        {"load": {"mass": True}},
        {"load": {"mass": -1}},
        {"load": {"mass": []}},
        {"load": {"mass": [[1]]}},
        {"load": {"mass": {"from": 0, "to": 1, "spacing": "log"}}},
        {"load": {"mass": {"from": 0, "to": 1, "num": 0}}},
        {"load": {"mass": {"from": 0, "to": 1, "num": 2, "step": 1}}},
        {"load": {"mass": {"value": 1, "tolerance": "10 %", "std": 1}}},
        {"load": {"mass": {"mean": 1}}},
        {"sheath": {"bend_angle": 144}},
        {"motion": {"elbow_angle": {"mean": "9 deg", "std": "1 deg"}}},
        {"model": {"slack": "both"}},
        {"motion": {"direction": ["up"]}},
        {"cases": {"name": "a"}},
        {"cases": [{"arm": {"b1": 1}}]},
        {"cases": [{"name": "a", "arm": {"bb1": 1}}]},
        {"sheath": {"path": 3}},
    ],
)
def test_it_refuses_what_a_study_refuses(content):
    assert not CHECK.is_valid({"name": "a", **content})
