"""The short answer: fourteen lines of a hundred characters, whatever the question."""

import copy
import json
import re

import pytest

import tendon_cli as tendon
from tendon_cli.answers.text import MOST_LINES, WIDTH, short_text
from tendon_cli.errors import TendonError
from tendon_cli.say import Clause, Section, fit
from tendon_cli.verbs.answer_record import as_answer
from tests.answers import answered
from tests.sampled import quick_and_torture
from tools.torture.hostile.valid import FILES, Maker

from .test_text import COARSE, KINDS, ONE_SUIT, SUITS

FOUR_LOADS = {"load": {"mass": [0.0, 3.0, 5.0, 10.0]}}
SUIT = {
    **COARSE,
    "spring": {"stiffness": ["1 kN/m", "3 kN/m", "5 kN/m"]},
    "spool": {"ratio": [1.0, 0.7, 0.6]},
    **FOUR_LOADS,
}
READ = ("extensor at joint", "flexor at motor")
LONG_SPRING = {
    **COARSE,
    "arm": {"b1": "80 mm", "b2": "60 mm"},
    "spring": {"stiffness": "0.6 kN/m"},
    "spool": {"ratio": 0.5},
    "load": {"mass": ["0 kg", "5 kg"]},
}
"""Suit whose spring is stretched by more than its anchors are apart."""
MORE = {
    "catalogue": SUIT,
    "one condition": {**ONE_SUIT, "load": {"mass": 3.0}},
    "rigid": {**COARSE, "spring": {"stiffness": "rigid"}, "load": {"mass": [0.0, 5.0]}},
    "at the motor": {**SUITS, "spring": {"stiffness": [3e3, 8e3], "at": "motor"}},
    "narrow strap": {**ONE_SUIT, "arm": {"contact_width": "40 mm"}},
    "cannot be built": LONG_SPRING,
    "people": {**SUITS, "people": {"count": 30}},
    "refuted": {**ONE_SUIT, "people": {"count": 2}, "design": {"serve": 0.99}},
    "unjudged": {**SUITS, "people": {"count": 20}, "design": {"verify": 0}},
    **{f"read {read}": {**SUIT, "setting": {"read": read}} for read in READ},
}
ODD = re.compile(r"\b(nan|inf|None(?! of [0-9]))\b|_\b|\(-\)")
"""Words that no text for a reader holds."""
NUMBER = r"([\d,.]+)"


def said(record):
    """Return the short answer in one line."""
    return " ".join(short_text(as_answer(record)).split())


def number(text):
    return float(text.replace(",", ""))


def assert_fits(text):
    lines = [line for line in text.splitlines() if line.strip()]
    assert 2 <= len(lines) <= MOST_LINES
    assert max(map(len, lines)) <= WIDTH
    assert ODD.search(text) is None, text


# --- Fourteen lines -------------------------------------------------------------------------------


@pytest.mark.parametrize("content", [*KINDS.values(), *MORE.values()], ids=[*KINDS, *MORE])
def test_a_short_answer_fits_and_says_what_its_record_has(content):
    answer = answered(content)
    record = json.loads(json.dumps(answer.record))
    assert answer.short == short_text(as_answer(record))
    assert_fits(answer.short)
    check_what_is_to_be_set(record)
    if record["best"] is not None:
        check_tensions_to_set(record)
        check_fresh_sample(record)
    check_indents(answer.short)


@pytest.mark.parametrize("seed", quick_and_torture([3], [1, 8, 9, 13]))
def test_a_short_answer_of_any_study_fits(seed, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    try:
        answer = tendon.design(tendon.study(Maker(seed).study()), jobs=1)
    except TendonError:
        pytest.skip("the study is refused")
    assert_fits(answer.short)


def test_long_names_of_cases_are_cut_not_printed_beyond_the_line():
    name = "a-case-whose-name-nobody-would-print-" * 5
    cases = [{"name": f"{name}{place}", "arm": {"b1": 0.1 + 0.01 * place}} for place in range(3)]
    suit = {"spring": {"stiffness": 5e3}, "spool": {"ratio": 0.6}}
    answer = tendon.design({**COARSE, **suit, "cases": cases})
    lines = answer.short.splitlines()
    assert max(map(len, lines)) <= WIDTH
    assert len([line for line in lines if line]) <= MOST_LINES


def test_what_matters_least_is_left_out_first():
    clauses = [Clause("first"), Clause("x" * 57, 2), Clause("y" * 50, 1), Clause("z" * 5, 3)]
    sections = [Section("", clauses, " ")]
    assert fit(sections, 9, 60).split() == ["first", "x" * 57, "y" * 50, "z" * 5]
    assert fit(sections, 2, 60).split() == ["first", "y" * 50, "z" * 5]
    assert fit(sections, 1, 60).split() == ["first", "y" * 50]


def test_words_that_must_stand_are_cut_if_they_are_too_long():
    text = fit([Section("Why", [Clause("word " * 100)], "")], 2, 40)
    assert len(text.splitlines()) == 2
    assert text.endswith(" ...")


# --- What it says is in the record ----------------------------------------------------------------


def check_tensions_to_set(record):
    """Check the tensions that are said against the record, and F0 against the window."""
    best = record["best"]
    end = "_motor" if record["question"]["read"].endswith("motor") else ""
    place = "motor" if end else "joint"
    pattern = rf"{NUMBER} N in the flexor \({NUMBER} N in the extensor\) at the {place}"
    names = ("flexor", "extensor")
    if record["question"]["read"].startswith("extensor"):
        pattern = rf"{NUMBER} N in the extensor \({NUMBER} N in the flexor\) at the {place}"
        names = ("extensor", "flexor")
    found = re.search(pattern, said(record))
    assert found is not None, said(record)
    for text, name in zip(found.groups(), names, strict=True):
        assert number(text) == pytest.approx(best[f"set_{name}_tension{end}"], rel=5e-3)
    if record["question"]["read"] == "pretension":
        found = re.search(rf"a pretension of {NUMBER} N;", said(record))
        assert best["pretension_from"] <= number(found[1]) <= (best["pretension_to"] or 1e9)


def test_tendons_as_short_and_as_long_as_they_may_be_are_at_the_ends_of_the_window():
    record = answered(SUIT).record
    pattern = rf"adds {NUMBER} N of .* {NUMBER} mm too long or {NUMBER} mm too short"
    rate, too_long, too_short = map(number, re.search(pattern, said(record)).groups())
    best = record["best"]
    low = best["pretension"] - rate * too_long
    high = best["pretension"] + rate * too_short
    assert low == pytest.approx(best["pretension_from"], abs=0.1 * rate)
    assert high == pytest.approx(best["pretension_to"], abs=0.1 * rate)


def test_the_rate_is_said_of_what_is_read():
    by_f0 = said(answered(SUIT).record)
    by_gauge = said(answered({**SUIT, "setting": {"read": "flexor at joint"}}).record)
    of_f0 = re.search(rf"by 1 mm adds {NUMBER} N of pretension;", by_f0)[1]
    assert re.search(rf"adds {NUMBER} N of tension in the flexor at the joint", by_gauge)[1] > of_f0
    assert f"({of_f0} N of F0)" in by_gauge


# --- It recommends nothing that a line below refutes ----------------------------------------------


def check_what_is_to_be_set(record):
    """Check that only what is feasible, can be built and can be set is to be set."""
    best = record["best"]
    text = said(record)
    if best is None:
        assert text.startswith(("No ", "A "))
        assert "Would help" in text
        return
    can_be_built = "spring" not in record["parts_needed"]["fails"]
    can_be_set = record["decided"]["can_be_set"]
    assert text.startswith("Set ") == (best["feasible"] and can_be_built and can_be_set)
    assert ("cannot be set" in text.partition("Why")[0]) == (not can_be_set)
    if record["parts_needed"]["fails"]:
        assert "but" in text.partition("Why")[0]


def check_fresh_sample(record):
    """Check that the judgement of a fresh sample stands in the first sentence."""
    best = record["best"]
    if best["served_verified"] is None:
        return
    first = said(record).partition("Why")[0]
    count = f"{best['served_verified']['of']:,}"
    if record["question"]["counted"] == "draws" and best["feasible"]:
        assert re.search(rf"works? in (\d+ of 100|all of {count}) suits so built", first)
        return
    assert f"{count} new" in first
    assert re.search(r"\((at least |at most )?[\d.]+ (to [\d.]+ )?%\)", first)
    if not best["feasible"]:
        assert "asked for" in first or "too close to" in first


def test_a_share_that_is_too_small_turns_set_into_but():
    record = answered(MORE["people"]).record
    refuted = copy.deepcopy(record)
    judged = refuted["best"]["served_verified"]
    judged.update({"value": 0.6, "interval_95": [0.59, 0.61]})
    refuted["best"]["feasible"] = False
    assert said(record).startswith("Set ")
    assert "come closest, but serve only 60 % of 500 newly drawn persons" in said(refuted)


def test_an_answer_of_one_suit_does_not_speak_of_choices():
    text = said(answered(ONE_SUIT).record)
    assert "this suit works for both loads" in text
    assert "choice" not in text


def test_two_ends_conflict_and_three_changes_help():
    soft = {**SUIT, "spring": {"stiffness": ["1 kN/m", "2 kN/m"]}}
    answer = answered(soft)
    text = said(answer.record)
    nearest = min(answer.conflicts, key=lambda conflict: conflict["gap"])["nearest"]
    below, above = re.search(rf"below {NUMBER} N .* above {NUMBER} N", text).groups()
    assert number(below) == pytest.approx(nearest["pretension_from"], rel=1e-3)
    assert number(above) == pytest.approx(nearest["pretension_to"], rel=1e-3)
    assert number(below) > number(above)
    for fix in [fix for fix in answer.fixes if fix["after"] is not None][:3]:
        assert f"to {fix['printed']}, set to {fix['printed_pretension']} N" in text


# --- Where it is shown ----------------------------------------------------------------------------


def test_a_session_shows_and_prints_the_short_answer():
    answer = answered(SUIT)
    assert repr(answer) == str(answer) == answer.short
    assert answer.text == answer.record["text"]
    assert "short" not in answer.record


LABELS = re.compile(r"  (Why|To set it|Parts|Rests on|Would help) +")


def check_indents(text):
    """Check that further lines of a section begin below its first."""
    _, *sections = text.split("\n\n")
    lines = [line for section in sections for line in section.splitlines()]
    firsts = {found.end() for found in map(LABELS.match, lines) if found}
    further = {len(line) - len(line.lstrip()) for line in lines if not LABELS.match(line)}
    assert further <= firsts
