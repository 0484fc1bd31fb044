"""Valid studies by chance are answered, swept and worked out, and what is said of them is true."""

import json
from pathlib import Path

import pytest

from tests.sampled import quick_and_torture
from tools.torture.hostile.tally import LONGEST_ANSWER, MOST_MEGABYTES_OF_AN_ANSWER
from tools.torture.hostile.valid import Maker

from .test_fuzz import fuzzed

FIRST = 10_000
CASES = 1_000
PROCESSES = 4
SHARES = [(first, CASES // PROCESSES) for first in range(FIRST, FIRST + CASES, CASES // PROCESSES)]
"""First seed and number of cases of each process of `make torture`, which can run side by side."""

SCHEMA = Path(__file__).parents[2] / "configs" / "tendon.schema.json"
NOT_STATED = {
    "people.statistics",
    "correlation.keys",
    "correlation.matrix",
    "fit.columns",
    "fit.counts_per_turn",
    "fit.torque_constant",
}
"""Keys of records, of a file of statistics, which is large, and of fits to logs."""


@pytest.mark.parametrize(("first", "cases"), quick_and_torture([(3004, 1)], [(3000, 10), *SHARES]))
def test_valid_studies_by_chance_are_answered_and_what_is_said_of_them_is_true(
    tmp_path, first, cases
):
    longest = LONGEST_ANSWER
    most = MOST_MEGABYTES_OF_AN_ANSWER
    words = ("valid", f"{first}:{cases}", tmp_path)
    tally, _ = fuzzed(tmp_path, *words, longest=longest, most=most)
    assert tally["cases"] == cases
    assert tally["taken"] >= 0.75 * cases, tally["refused"]


def test_studies_by_chance_state_every_key_of_the_schema():
    stated = set()
    for seed in range(400):
        for name, table in Maker(seed).study().items():
            if isinstance(table, dict):
                stated.update(f"{name}.{key}" for key in table)
    assert keys_of_schema() - stated == NOT_STATED


def keys_of_schema():
    """Return the keys of the tables of a study, such as `arm.b1`, without those of cases."""
    schema = json.loads(SCHEMA.read_text("utf-8"))
    known = set()
    for name, entry in schema["properties"].items():
        reference = entry.get("anyOf", [entry])[0].get("$ref", "")
        table = schema["$defs"].get(reference.rpartition("/")[2], {})
        known.update(f"{name}.{key}" for key in table.get("properties", {}))
    return known
