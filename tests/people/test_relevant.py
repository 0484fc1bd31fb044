"""An answer about very many choices works out the worst values of the promising ones alone.

It is the same answer, and the table says so.
"""

import pandas as pd
import pytest

import tendon_cli as tendon
from tendon_cli.answers import choices as choices_module
from tendon_cli.answers.text_order import why_first
from tendon_cli.windows import candidates as candidates_module
from tendon_cli.windows.worst import WORST
from tests.sampled import quick_and_torture

SUITS = {
    "arm": {"contact_width": 0.04},
    "people": {"count": 12},
    "load": {"mass": [0.0, 5.0]},
    "motion": {"elbow_angle": {"from": 0.0, "to": "90 deg", "num": 7}},
    "spring": {"stiffness": [3e3, 4.7e3, 5.6e3, 7.3e3, 9e3]},
    "spool": {"ratio": [0.5, 0.55, 0.6]},
    "tendon": {"diameter": [1e-3, 1.5e-3]},
}
"""30 choices for 12 persons with two loads."""
BETWEEN = {"spring": {"stiffness": {"from": 3e3, "to": 9e3, "num": 5}}}
"""The same with choices between the springs, too, which takes longer."""
ADVISED = {
    "rope": {"tendon": {"diameter": [1e-3, 1.5e-3], "breaking_force": "1.6 kN"}},
    "strap": {"arm": {"contact_width": 0.025}},
    "spring": {"spring": {**SUITS["spring"], "free_length": [0.03, 0.06, 0.09]}},
    # No window, tension or torque depends on how long the spring is without load.
    "tie": {
        "spring": {"stiffness": [5e3, 6e3], "free_length": [0.01 + 1e-4 * n for n in range(12)]},
        "spool": {"ratio": 0.6},
        "tendon": {"diameter": 1.5e-3},
    },
    "nothing": {"tendon": {"breaking_force": "10 N"}},
}
"""Parts that a study states, on which the advice that choices fail depends."""

GOALS = [
    {},
    {"maximise": ["min_elbow_stiffness"]},
    {"minimise": ["peak_motor_torque", "max_contact_pressure"]},
    {"minimise": ["max_spring_extension", "pretension"], "maximise": ["tolerance"]},
]


@pytest.fixture
def answered(monkeypatch):
    """Return a function that answers; beyond so many states only promising choices are done."""

    def answer(states, content=SUITS, **design):
        monkeypatch.setattr(candidates_module, "STATES_FOR_ALL", states)
        return tendon.design(content | {"design": {"verify": 0, **design}}, jobs=1)

    monkeypatch.setattr(choices_module, "CHOICES_PER_PART", 10)
    return answer


def common_record(answer):
    """Return the entries of a record that may not depend on how much is worked out."""
    differing = {"seconds", "checksum", "notes", "blocks", "text", "decided"}
    return {name: value for name, value in answer.record.items() if name not in differing}


def assert_same_decision(partial, full):
    """Assert that the same rule decides, against as many choices if their number is known.

    A rule before it may drop only choices that need not be worked out: then it is not named.
    """
    of_all = full.record["decided"]
    decided = partial.record["decided"]
    is_known = decided["choices"] is not None
    assert set(decided["after"]) <= set(of_all["after"])
    unknown = {"after": decided["after"]} | ({} if is_known else {"choices": None})
    assert decided == of_all | unknown
    if not is_known:
        assert f"{of_all['choices']} choices" not in why_first(partial.answer)


@pytest.mark.parametrize(
    ("goals", "springs"),
    quick_and_torture(
        [(GOALS[0], {}), (GOALS[2], {}), (GOALS[1], BETWEEN)],
        [(GOALS[1], {}), (GOALS[3], {})],
    ),
    ids=str,
)
def test_the_answer_is_the_one_of_working_out_all(answered, goals, springs):
    content = {**SUITS, **springs}
    full = answered(2**62, content, **goals)
    partial = answered(0, content, **goals)
    assert common_record(partial) == common_record(full)
    assert_same_decision(partial, full)
    assert len(partial.record["notes"]) == len(full.record["notes"]) + 1
    worked_out = ~partial.choices["max_tension"].isna()
    assert 5 <= worked_out.sum() < len(worked_out)
    pd.testing.assert_frame_equal(
        partial.choices[worked_out], full.choices[worked_out], check_exact=True
    )
    others = [name for name in partial.choices if name not in WORST]
    pd.testing.assert_frame_equal(partial.choices[others], full.choices[others], check_exact=True)


@pytest.mark.parametrize(
    ("stated", "goals"),
    quick_and_torture(
        [(stated, GOALS[place % 2]) for place, stated in enumerate(ADVISED)],
        [(stated, GOALS[1 - place % 2]) for place, stated in enumerate(ADVISED)],
    ),
    ids=str,
)
def test_the_decision_is_the_one_of_working_out_all_with_advice(answered, stated, goals):
    content = {**SUITS, "people": {"count": 8}}
    for table, numbers in ADVISED[stated].items():
        content[table] = content.get(table, {}) | numbers
    full = answered(2**62, content, **goals)
    partial = answered(0, content, **goals)
    assert common_record(partial) == common_record(full)
    assert_same_decision(partial, full)


def test_without_advice_the_number_of_choices_is_known(answered):
    decided = answered(0, {**SUITS, "people": {"count": 8}}, advice=False).record["decided"]
    assert decided["rule"] == "max_tension"
    assert decided["choices"] is not None


def test_a_goal_that_no_bound_serves_has_all_worked_out(answered):
    choices = answered(0, maximise=["max_tension"]).choices
    assert not choices[list(WORST)].isna().any(axis=None)
    tension = choices["max_tension"]
    assert tension[choices["feasible"]].max() == tension[choices["on_front"]].max()


def test_nothing_is_left_out_without_people_and_a_choice_that_serves_nobody_has_no_worst(
    monkeypatch,
):
    monkeypatch.setattr(candidates_module, "STATES_FOR_ALL", 0)
    without_people = {"spool": {"ratio": 0.6}, "spring": {"stiffness": [5e3, 8e3]}}
    choices = tendon.design(tendon.study(without_people)).choices
    assert not choices["max_tension"].isna().any()
    # The extensor's spool of the first choice is too thin for its tendon.
    thin = {"limits": {"min_spool_to_tendon": 30}, "spool": {"ratio": [0.6, 0.8]}}
    content = {**without_people, **thin, "people": {"count": 3}, "load": {"mass": 1.0}}
    choices = tendon.design(tendon.study(content)).choices
    is_thin = choices["spool_ratio"] == 0.6
    assert choices.loc[is_thin, list(WORST)].isna().all(axis=None)
    assert choices.loc[~is_thin, "max_tension"].notna().any()
