"""The text of an answer follows from `design.json` alone, and the record is as it is declared."""

import builtins
import copy
import json
import math
import re
import types
import typing
from collections import abc
from typing import get_args, get_origin, get_type_hints, is_typeddict

import pytest

import tendon_cli as tendon
from tendon_cli.answer_record import AnswerRecord, ChoiceRecord, as_answer
from tendon_cli.answers.phrases import condition_of_group, condition_words
from tendon_cli.answers.text import answer_blocks, answer_text
from tendon_cli.cube.choice_grid import served_words
from tests.answers import answered

COARSE = {"motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}}}
SUITS = {
    **COARSE,
    "spring": {"stiffness": [3e3, 5e3, 8e3]},
    "spool": {"ratio": [0.6, 0.5]},
    "load": {"mass": [0.0, 10.0]},
}
RANGES = {
    **COARSE,
    "spring": {"stiffness": {"from": "1 kN/m", "to": "8 kN/m", "num": 3}},
    "spool": {"ratio": {"from": 0.5, "to": 1.0, "num": 3}},
    "load": {"mass": [0.0, 10.0]},
}
ONE_SUIT = {**SUITS, "spring": {"stiffness": 5e3}, "spool": {"ratio": 0.6}}
RUBBING = {"sheath": {"friction": {"mean": 0.08, "std": 0.01}}}
PAIRS = {
    **ONE_SUIT,
    **RUBBING,
    "people": {"count": 4},
    "uncertainty": {"draws": 16},
    "limits": {"max_tension": "480 N"},
}
GOALS = {"minimise": ["max_tension"], "maximise": ["tolerance"]}
KINDS = {
    "front": {**RANGES, "design": GOALS},
    "prove": {**SUITS, "design": {"maximise": ["tolerance"], "prove": ["0", "3"]}},
    "prove one of a front": {**SUITS, "design": {**GOALS, "prove": ["0", "3"]}},
    "given": {**SUITS, "design": {"pretension": "150 N"}},
    "given too small": {**ONE_SUIT, "design": {"pretension": "90 N"}},
    "no window": {**ONE_SUIT, "limits": {"max_tension": "100 N"}},
    "pairs": PAIRS,
    "draws": {**ONE_SUIT, **RUBBING, "uncertainty": {"draws": 32}},
    "ankle": {**SUITS, "joint": {"name": "ankle"}},
    "tension": {**ONE_SUIT, "setting": {"read": "flexor at joint"}},
    "postures": {**SUITS, "arm": {"upper_arm_angle": ["0 deg", "45 deg"]}},
}


@pytest.mark.parametrize("name", KINDS)
def test_text_and_record_of_any_answer(name):
    """The text follows from the record as its file has it, and the record is as declared."""
    file = answered(KINDS[name]).folder / "design.json"
    record = json.loads(file.read_text(encoding="utf-8"))
    assert answer_text(record) == record["text"]
    assert [*answer_blocks(record)] == record["blocks"]
    assert wrong_keys(record, AnswerRecord) == []
    check_who_is_on_the_front(record)
    text = " ".join(record["text"].split())
    assert not re.search(r"(below|above|from|to) -\d", text)
    assert not re.search(r"\de-\d", text)
    # Numbers that hardly move the window are left out.
    moves = re.findall(r" ([+-][\d.]+(?:e[+-]\d+)?) N", record["text"])
    assert all(abs(float(move)) >= 1e-3 for move in moves)
    counted = f"at least 95 % of the {record['question']['counted']}"
    assert served_words(record) == (counted if record["serve"] < 1.0 else "all conditions")


# --- The record is as declared --------------------------------------------------------------------


def has_type(value, kind):
    """Return True if a value of JSON has a type, which may be a TypedDict."""
    inner = get_args(kind)
    if is_typeddict(kind):
        return isinstance(value, dict) and wrong_keys(value, kind) == []
    match get_origin(kind):
        case typing.Union | types.UnionType:
            return any(has_type(value, option) for option in inner)
        case typing.Literal:
            return value in inner
        case builtins.dict:
            is_table = isinstance(value, dict)
            return is_table and all(has_type(item, inner[1]) for item in value.values())
        case builtins.list | abc.Sequence:
            return isinstance(value, list) and all(has_type(item, inner[0]) for item in value)
    if kind is float:
        return isinstance(value, (int, float))
    return kind is typing.Any or isinstance(value, kind)


def wrong_keys(value, kind):
    """Return the keys that a TypedDict does not have, and those of another type."""
    declared = get_type_hints(kind)
    hints = get_type_hints(kind, include_extras=True)
    optional = {name for name, hint in hints.items() if get_origin(hint) is typing.NotRequired}
    may_be_more = kind is ChoiceRecord  # columns of axes
    unknown = [] if may_be_more else sorted(value.keys() - declared.keys())
    missing = sorted(declared.keys() - value.keys() - optional)
    present = declared.keys() & value.keys()
    return [*unknown, *missing, *(k for k in present if not has_type(value[k], declared[k]))]


# --- Rules of the words ---------------------------------------------------------------------------


def named_choices(record):
    """Return all rows of choices that a record names."""
    best = [record["best"]] if record["best"] else []
    nearest = [conflict["nearest"] for conflict in record["conflicts"]]
    return [*best, *record["best_by"].values(), *record["front"], *record["proved"], *nearest]


def check_who_is_on_the_front(record):
    """Check that a choice is on the front only if the answer has it there."""
    on_front = {row["choice"] for row in record["front"]}
    if len(record["goals"]) == 1:
        on_front = {record["best"]["choice"]}
    for row in named_choices(record):
        assert row["on_front"] == (row["choice"] in on_front)


def test_a_limit_that_no_pretension_keeps_is_said_so():
    answer = answered(KINDS["no window"])
    text = " ".join(answer.text.split())
    assert answer.conflicts[0]["nearest"]["pretension_to"] < 0.0
    assert "at any pretension, even 0 N, a tendon carries more than 100 N (10 kg load" in text
    assert "apart" not in text


def test_reasons_are_said_without_the_person_and_the_draw():
    record = as_answer(answered(PAIRS).record)
    reasons = record["population"]["not_served"]
    question = record["question"]
    assert [axis["key"] for axis in question["conditions"]] == ["person", "draw", "load.mass"]
    assert reasons
    for reason in reasons:
        for condition in reason["under"]:
            assert condition_words(question, condition).count(",") == 2
            assert condition_of_group(question, condition) in ("0 kg load", "10 kg load")
        assert "draw " not in reason["text"]


def test_one_choice_on_the_front_gives_nothing_up():
    goals = {"minimise": ["max_spring_extension"], "maximise": ["tolerance"]}
    answer = tendon.design(tendon.study({**SUITS, "design": goals}))
    text = " ".join(answer.text.split())
    assert len(answer.front) == 1
    assert "This choice is the best in every goal." in text
    assert "gives up" not in text


def test_sobol_indices_are_a_table_for_each_end_the_largest_first():
    record = as_answer(answered(PAIRS).record)
    tables = [block["table"] for block in record["blocks"] if "table" in block]
    of_ends = [rows for rows in tables if rows[0][1:] == ["first order", "total"]]
    assert len(of_ends) == len(record["population"]["sobol"]) == 2
    for rows, end in zip(of_ends, record["population"]["sobol"], strict=True):
        indices = sorted(end["inputs"].values(), key=lambda index: -index["total"])
        assert [row[0].strip() for row in rows[1:]] == [index["name"] for index in indices]
        which = "lower" if end["end"] == "pretension_from" else "upper"
        assert rows[0][0].startswith(f"{which} end, ")


def test_an_index_below_a_hundredth_of_a_percent_is_not_printed():
    record = as_answer(copy.deepcopy(answered(PAIRS).record))
    for end in record["population"]["sobol"]:
        end["inputs"]["sheath.friction"] |= {"total": 5.6e-8, "total_standard_error": 1e-9}
        end["inputs"]["body"] |= {"total": 0.5, "total_standard_error": 1e-9}
    text = answer_text(record)
    assert text.count("  below 0.01 %\n") == 2
    assert text.count("  50 %\n") == 2


@pytest.mark.parametrize("stiffness", [4000.0, 5000.0, 7000.0])
def test_the_travel_of_springs_is_rounded_up_at_its_third_digit(stiffness):
    """Springs are bought by it: more than is needed is safe, and much more is dear."""
    answer = tendon.design({"spring": {"stiffness": stiffness}, "spool": {"ratio": 0.5}})
    travel = answer.record["parts_needed"]["spring"]["travel"] * 1e3  # mm
    said = float(re.search(r"springs:.* ([\d.]+) mm of travel", " ".join(answer.text.split()))[1])
    third_digit = 10.0 ** (math.floor(math.log10(travel)) - 2)
    assert travel <= said < travel + third_digit


def test_conditions_are_not_counted_where_all_values_of_an_interval_are_meant():
    loads = {"from": "0 kg", "to": "10 kg"}
    motion = COARSE["motion"]
    given = {"pretension": "230 N"}
    counted = tendon.design(
        {"load": {"mass": [*loads.values()]}, "design": given, "motion": motion}
    ).text
    assert "does not work for both conditions" in counted
    assert "230 N does not work in 1 of 2 conditions: 0 kg load" in " ".join(counted.split())
    countless = tendon.design({"load": {"mass": loads}, "design": given, "motion": motion}).text
    assert "does not work for all conditions" in countless
    assert "1 of 2" not in countless
