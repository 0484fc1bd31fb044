"""Answers of questions whose choices have limits of their own."""

import json

import pytest

import tendon_cli as tendon

from .suits import LOOSER_AND_TIGHTER, limited

STUDY_ALONE = {"study_hash", "seconds", "versions", "text", "blocks", "question", "study", "axes"}
CONFLICT = {"load": {"mass": ["0 kg", "12 kg"]}}
PEOPLE = {
    "people": {"count": 4},
    "sheath": {"friction": "0.07 +/- 0.02"},
    "uncertainty": {"draws": 4},
    "design": {"verify": 20},
}
SHORT = {
    "load": {"mass": "12 kg"},
    "spring": {"stiffness": "5 kN/m"},
    "motion": {"elbow_angle": "60 deg"},
}
GIVEN = {"design": {"pretension": "90 N"}}
QUESTIONS = {
    "a window": ("max_tension", 0, {}),
    "a window for which stiffness is limited": ("min_elbow_stiffness", 0, {}),
}
LONG_QUESTIONS = {
    "a sampled window": ("peak_motor_power", 0, {}),
    "a conflict": ("max_tension", 1, CONFLICT),
    "a conflict on stiffness": ("min_elbow_stiffness", 1, CONFLICT),
    "people and draws": ("max_tension", 1, PEOPLE),
    "a given pretension": ("max_tension", 1, GIVEN),
}
LONG = [pytest.param(name, marks=pytest.mark.torture) for name in LONG_QUESTIONS]


def facts(answer, limit):
    """Return the record of an answer without what says that the limit is an axis."""

    def without(value):
        if isinstance(value, dict):
            kept = value.keys() - STUDY_ALONE - {f"limit_{limit}", "title", "trade_offs"}
            return {key: without(value[key]) for key in kept}
        return [without(item) for item in value] if isinstance(value, list) else value

    return without(json.loads(json.dumps(answer.record, default=str)))


@pytest.mark.parametrize("name", [*QUESTIONS, *LONG])
def test_an_answer_with_one_limit_on_an_axis_is_that_of_the_limit(name):
    limit, place, study = (QUESTIONS | LONG_QUESTIONS)[name]
    value = LOOSER_AND_TIGHTER[limit][place]
    alone = tendon.design(limited(limit, value, study))
    on_axis = tendon.design(limited(limit, [value], study))
    assert facts(on_axis, limit) == facts(alone, limit)


UNADVISED = {"design": {"advice": False}}
"""No word of springs of 5 mm, which nobody can wind."""


@pytest.fixture(scope="module")
def conflict():
    """Return an answer without a window under either of two limits."""
    return tendon.design(limited("max_tension", ["60 N", "70 N"], SHORT, UNADVISED))


def test_words_have_the_limit_of_the_choice_in_question(conflict):
    nearest = conflict.conflicts[0]["nearest"]["limit_max_tension"]
    text = " ".join(conflict.text.split())
    assert f"carries more than {nearest:.0f} N" in text


def test_a_limit_is_relaxed_from_its_loosest_value(conflict):
    changes = {change["key"]: change for change in conflict.record["would_take"]}
    relaxed = changes["limits.max_tension"]
    assert relaxed["before"] == 70.0
    solved = tendon.design(limited("max_tension", relaxed["after"], SHORT, UNADVISED))
    assert solved.feasible
    tighter = tendon.design(limited("max_tension", 0.98 * relaxed["after"], SHORT, UNADVISED))
    assert not tighter.feasible
