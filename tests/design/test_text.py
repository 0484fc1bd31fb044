"""The text of an answer follows from `design.json` alone, and the record is as it is declared."""

import json
import math
import re
import shutil

import pytest

import tendon_cli as tendon
from tendon_cli.answers.phrases import condition_of_group, condition_words
from tendon_cli.answers.text import answer_blocks, answer_text
from tendon_cli.cube.choice_grid import served_words
from tendon_cli.engine.records import checksum
from tendon_cli.errors import FolderError
from tendon_cli.verbs.answer_record import as_answer, as_read
from tendon_cli.verbs.typed_record import to_json
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
    "limits": {"max_tension": "460 N"},
    "setting": {"read": "pretension"},
    "design": {"serve": 0.5},
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
    "postures": {**ONE_SUIT, "arm": {"upper_arm_angle": ["0 deg", "45 deg"]}},
}


@pytest.mark.parametrize("name", KINDS)
def test_text_and_record_of_any_answer(name):
    """The text follows from the record as its file has it, and the record is as declared."""
    file = answered(KINDS[name]).folder / "design.json"
    record = json.loads(file.read_text(encoding="utf-8"))
    answer = as_answer(record)
    assert answer_text(answer) == record["text"]
    assert to_json([*answer_blocks(answer)]) == record["blocks"]
    written = to_json(answer)
    assert written == {name: record[name] for name in written}
    check_who_is_on_the_front(record)
    assert max(map(len, record["text"].splitlines())) <= 100
    counted = f"at least {100 * record['serve']:g} % of the {record['question']['counted']}"
    assert served_words(answer) == (counted if record["serve"] < 1.0 else "all conditions")


# --- The record is read by its types --------------------------------------------------------------


def places(value, path=()):
    """Yield the place of everything in a record of JSON."""
    if isinstance(value, dict):
        for name, inner in value.items():
            yield (*path, name)
            yield from places(inner, (*path, name))
    elif isinstance(value, list):
        for place, inner in enumerate(value[:2]):
            yield (*path, place)
            yield from places(inner, (*path, place))


OF_THE_RUN = ("study", "blocks")
"""Entries whose types are not those of the answer."""


def test_what_does_not_fit_its_type_is_refused():
    """Wherever a list stands for a number or a text, or a number for a list, it is refused."""
    record = json.loads(json.dumps(to_json(as_answer(answered(PAIRS).record))))
    described = {name: value for name, value in record.items() if name not in OF_THE_RUN}
    read = []
    for path in [*places(described)]:
        *above, name = path
        if name in ("spring_stiffness", "spool_ratio"):
            continue  # columns of choices are as their study has them
        inner = record
        for outer in above:
            inner = inner[outer]
        value = inner[name]
        inner[name] = 5 if isinstance(value, list | dict) else [{"of": "another type"}]
        try:
            as_answer(record)
        except ValueError:
            pass
        else:
            read.append(path)
        inner[name] = value
    assert read == []


def test_a_record_forged_with_its_own_checksum_is_refused(tmp_path):
    folder = tmp_path / "answer"
    shutil.copytree(answered(ONE_SUIT).folder, folder)
    file = folder / "design.json"
    known = json.loads(file.read_text(encoding="utf-8"))
    for forged in ({"best": 5}, {"question": []}, {"front": [{}]}, {"fixes": "x"}):
        record = known | forged
        record["checksum"] = checksum(record)
        file.write_text(json.dumps(record), encoding="utf-8")
        with pytest.raises(FolderError, match="not as tendon wrote it"):
            tendon.open(folder)


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
    text = " ".join(answer.short.split())
    assert answer.conflicts[0]["nearest"]["pretension_to"] < 0.0
    assert "at any pretension, even 0 N, a tendon carries more than 100 N (10 kg load" in text
    assert "apart" not in text


def test_reasons_are_said_without_the_person_and_the_draw():
    record = as_answer(answered(PAIRS).record)
    reasons = record.population.not_served
    question = record.question
    assert [axis.key for axis in question.conditions] == ["person", "draw", "load.mass"]
    assert reasons
    for reason in reasons:
        for condition in reason.under:
            assert condition_words(question, condition).count(",") == 2
            assert condition_of_group(question, condition) in ("0 kg load", "10 kg load")
        assert "draw " not in reason.text


def test_one_choice_on_the_front_gives_nothing_up():
    goals = {"minimise": ["max_spring_extension"], "maximise": ["tolerance"]}
    answer = tendon.design(tendon.study({**SUITS, "design": goals}))
    text = " ".join(answer.short.split())
    assert len(answer.front) == 1
    assert "This choice is the best in every goal." in text
    assert "gives up" not in text


# --- The record as tables -------------------------------------------------------------------------


def tables_of(record):
    """Return the tables of a record by their headings."""
    tables = {}
    heading = ""
    for block in record["blocks"]:
        heading = block.get("heading", heading)
        if "table" in block:
            tables[heading] = block["table"]
    return tables


@pytest.mark.parametrize("name", ["given", "pairs", "tension", "draws"])
def test_the_table_of_the_best_choice_has_its_numbers_with_their_units(name):
    """A number of the table, in its unit, is that of the record; what the gauge shows leads."""
    answer = answered(KINDS[name])
    best = to_json(as_read(answer.answer).best)
    head, *rows = tables_of(answer.record)["The choice named first"]
    assert head == ["name", "value", "unit", "meaning"]
    factors = {"N": 1.0, "mm": 1e-3, "N m": 1.0, "deg": 0.017453292519943295, "kPa": 1e3}
    numbers = {
        row[0]: float(row[1].replace(",", "")) * factors[row[2]]
        for row in rows
        if row[2] in factors
    }
    known = {key: best[key] for key in numbers if key in best and key != "tolerance_length"}
    assert len(known) > 10
    assert {key: numbers[key] for key in known} == pytest.approx(known, rel=1e-3, abs=1e-9)
    names = [row[0] for row in rows]
    assert names.index("set_flexor_tension") < names.index("pretension")
    assert all(row[3] for row in rows if row[2])


def test_sobol_indices_are_a_table_for_each_end():
    record = answered(PAIRS).record
    tables = tables_of(record)
    ends = record["population"]["sobol"]
    assert len(ends) == 2
    for place, end in enumerate(ends):
        head, *rows = tables[f"For whom, or how sure: sobol: {place + 1}, inputs"]
        total = {row[0]: float(row[head.index("total")]) for row in rows}
        assert total == pytest.approx(
            {key: index["total"] for key, index in end["inputs"].items()}, rel=1e-3
        )


@pytest.mark.parametrize("stiffness", [4000.0, 5000.0, 7000.0])
def test_the_travel_of_springs_is_rounded_up_at_its_third_digit(stiffness):
    """Springs are bought by it: more than is needed is safe, and much more is dear."""
    answer = tendon.design({"spring": {"stiffness": stiffness}, "spool": {"ratio": 0.5}})
    travel = answer.record["parts_needed"]["spring"]["travel"] * 1e3  # mm
    said = float(
        re.search(r"springs with ([\d.]+) mm of travel", " ".join(answer.short.split()))[1]
    )
    third_digit = 10.0 ** (math.floor(math.log10(travel)) - 2)
    assert travel <= said < travel + third_digit


def test_conditions_are_not_counted_where_all_values_of_an_interval_are_meant():
    loads = {"from": "0 kg", "to": "10 kg"}
    motion = COARSE["motion"]
    given = {"pretension": "230 N"}
    counted = tendon.design(
        {"load": {"mass": [*loads.values()]}, "design": given, "motion": motion}
    ).short
    assert "does not work for both conditions" in counted
    assert "230 N does not work in 1 of 2 conditions: 0 kg load" in " ".join(counted.split())
    countless = tendon.design({"load": {"mass": loads}, "design": given, "motion": motion}).short
    assert "does not work for all conditions" in countless
    assert "1 of 2" not in countless
