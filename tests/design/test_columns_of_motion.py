"""Choices have the columns of motion that designs have, at the worst of the conditions served."""

import numpy as np
import pandas as pd
import pytest

import tendon_cli as tendon
from tendon_cli.engine.windows import question
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.quantities import OF_CYCLES, OF_TRAJECTORIES
from tests.answers import answered

TIME = np.linspace(0.0, 2.0, 41)
MOTION = {
    "speed": "60 deg/s",
    "elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 91},
}
REACH = {
    "trajectory": {
        "time": TIME.tolist(),
        "angle": [f"{angle} deg" for angle in 45.0 - 40.0 * np.cos(np.pi * TIME)],
    },
    "cutoff": "6 Hz",
}
SUIT = {
    "spring": {"stiffness": ["5 kN/m", "8 kN/m"]},
    "spool": {"ratio": 0.6},
    "load": {"mass": ["0 kg", "3 kg"]},
    "motion": MOTION,
}


def swept(content, choice):
    """Return the rows of designs of a choice at its pretension, one for each condition."""
    at_choice = {
        "spring": {"stiffness": float(choice["spring_stiffness"])},
        "tendon": {"pretension": float(choice["pretension"])},
    }
    return tendon.sweep({**content, **at_choice}, jobs=1).designs


@pytest.mark.parametrize("motion", [MOTION, REACH], ids=["speed", "trajectory"])
def test_a_choice_has_the_worst_of_what_its_designs_have(motion):
    content = {**SUIT, "motion": motion}
    answer = answered(content)
    columns = OF_CYCLES if motion is MOTION else (*OF_CYCLES, *OF_TRAJECTORIES)
    assert answer.choices["feasible"].all()
    for _, choice in answer.choices.iterrows():
        designs = swept(content, choice)
        for name in columns:
            worst = designs[name].min() if name == "efficiency" else designs[name].max()
            assert choice[name] == pytest.approx(worst, rel=1e-9, nan_ok=True), name
    best = answer.record["best"]
    assert best["friction_loss"] == answer.choices["friction_loss"][best["choice"]]


def test_a_condition_that_is_not_served_does_not_count():
    both = question.question_of(tendon.study(SUIT))
    solver = Solver(both, with_motion=True)
    points = both.all_points()
    pretension = np.array([150.0, 200.0])
    served = np.array([[True, False], [False, False]])
    work = ("motor_work_in",)
    found = solver.worst_of_motion(points, pretension, served, work)
    light = solver.for_question(both.for_conditions(np.array([0])))
    alone = light.worst_of_motion(points, pretension, np.ones((2, 1), dtype=np.bool_), work)
    assert found["motor_work_in"][0] == pytest.approx(alone["motor_work_in"][0], rel=1e-12)
    assert np.isnan(found["motor_work_in"][1])


@pytest.mark.parametrize("goal", ["friction_loss", "spool_travel", "max_backlash"])
def test_a_goal_may_be_a_column_of_motion(goal):
    choices = answered(SUIT).choices
    best = tendon.design({**SUIT, "design": {"minimise": goal}}, jobs=1).record["best"]
    assert best["choice"] == choices[goal].idxmin()
    worst = tendon.design({**SUIT, "design": {"maximise": goal}}, jobs=1).record["best"]
    assert worst["choice"] == choices[goal].idxmax()


@pytest.mark.parametrize(
    ("goal", "motion", "words"),
    [
        ("friction_loss", {}, "no choice has a friction_loss without motion.speed"),
        ("rms_motor_torque", MOTION, "without motion.trajectory"),
        ("max_torque_band", {**MOTION, "direction": "flexion"}, "moves in flexion alone"),
        ("efficiency", {**MOTION, "elbow_angle": "30 deg"}, "a single elbow angle"),
    ],
)
def test_a_goal_that_is_null_in_all_choices_is_refused(goal, motion, words):
    content = {**SUIT, "motion": motion, "design": {"minimise": goal}}
    with pytest.raises(tendon.StudyError, match=words):
        tendon.study(content)


def test_what_takes_too_long_for_all_choices_is_told_and_known_of_the_best_and_of_goals(
    monkeypatch,
):
    whole = answered(SUIT)
    assert not any("take too long" in note for note in whole.record["notes"])
    monkeypatch.setattr(question, "_STATES_WITH_MOTION", 2 * 182)
    few = tendon.design(SUIT, jobs=1)
    assert any("take too long for all 2 choices" in note for note in few.record["notes"])
    assert few.choices["max_backlash"].isna().all()
    with_goal = tendon.design({**SUIT, "design": {"minimise": "max_backlash"}}, jobs=1)
    assert with_goal.choices["max_backlash"].notna().all()
    others = [name for name in whole.choices if name not in OF_CYCLES]
    pd.testing.assert_frame_equal(few.choices[others], whole.choices[others])
