"""Limits on the motor in `tendon design`.

Windows end where the cycle reaches them, and conflicts name them.
"""

import numpy as np
import pytest

from tendon_cli import design
from tendon_cli.answers.problem import question_of
from tendon_cli.answers.sensitivity import sensitivities
from tendon_cli.answers.solve import solve, solve_columns
from tendon_cli.model.limits import LIMIT_NAMES
from tendon_cli.model.motor import cycle_columns
from tendon_cli.studies.load import study_from

SUIT = {
    "load": {"mass": ["0 kg", "3 kg"]},
    "spool": {"ratio": [0.6, 0.7]},
    "spring": {"stiffness": "5 kN/m"},
    "motion": {"speed": "60 deg/s", "elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 10}},
}


def solved(**limits):
    """Return the problem of the suit under limits, and its solutions."""
    problem = question_of(study_from({**SUIT, "limits": limits}))
    return problem, solve(problem, problem.choices.numbers(np.arange(2)), 2)


@pytest.mark.parametrize(
    ("name", "most", "column", "end"),
    [
        ("max_friction_loss", "13 J", "friction_loss", "to"),
        ("max_backlash", "0.5 deg", "max_backlash", "to"),
        ("peak_motor_speed", "4 rad/s", "peak_motor_speed", "from"),
        ("peak_motor_power", "13 W", "peak_motor_power", "from"),
    ],
)
def test_a_window_ends_where_the_cycle_reaches_the_limit(name, most, column, end):
    problem, solutions = solved(**{name: most})
    _, unlimited = solved()
    ends = solutions[f"pretension_{end}"]
    conditions = solutions[f"{end}_condition"]
    is_set_by_limit = [LIMIT_NAMES[code] == name for code in solutions[f"{end}_by"]]
    binds = is_set_by_limit & ~np.isnan(ends)
    assert binds.any()
    for row in np.flatnonzero(binds):
        assert ends[row] != unlimited[f"pretension_{end}"][row]
        numbers = problem.choices.numbers(np.array([row]))
        suit = problem.design(numbers, pretension=ends[[row]])
        values = cycle_columns(suit, problem.angles, problem.flexion, np.radians(60.0))[
            column
        ].ravel()
        assert values[conditions[row]] == pytest.approx(problem.bounds[name], rel=1e-6)


def test_limits_of_the_motor_are_in_words_as_others_are():
    content = {**SUIT, "spool": {"ratio": 0.6}}
    broken = design({**content, "limits": {"max_friction_loss": "1 J"}})
    assert not broken.feasible
    assert "friction takes more than 1 J per cycle" in broken.text
    kept = design({**content, "limits": {"max_friction_loss": "40 J"}})
    assert kept.feasible
    assert any("max_friction_loss" in note for note in kept.record["notes"])


SET_BY_THE_MOTOR = [
    ("max_friction_loss", "13 J", "to"),
    ("max_backlash", "0.5 deg", "to"),
    ("peak_motor_speed", "4 rad/s", "from"),
    ("peak_motor_power", "13.5 W", "from"),
    ("max_motor_work_in", "17 J", "to"),
    ("max_spool_travel", "230 deg", "from"),
    ("max_torque_band", "4 N m", "to"),
    ("min_efficiency", 0.02, "to"),
]


@pytest.mark.parametrize(("limit", "value", "end"), SET_BY_THE_MOTOR)
def test_ends_that_a_limit_on_the_motor_sets_have_their_slopes(limit, value, end):
    problem = question_of(study_from({**SUIT, "spool": {"ratio": 0.6}, "limits": {limit: value}}))
    choice = solve_columns(problem, {}, 1)
    assert LIMIT_NAMES[choice[f"{end}_by"][0]] == limit
    rows = {row["key"]: row for row in sensitivities(problem, choice) if row["end"] == end}
    assert {"motion.speed", f"limits.{limit}", "spring.stiffness", "load.mass"} <= set(rows)
    masses = problem.condition_numbers["load.mass"]
    binding = choice[f"{end}_condition"][0]

    def end_at(key, number):
        if key == "motion.speed":
            changed = problem.bounded("speed", number)
        elif key.startswith("limits."):
            changed = problem.bounded(limit, number)
        elif key == "load.mass":
            changed = problem.saying({key: np.where(np.arange(2) == binding, number, masses)})
        else:
            changed = problem.saying({key: np.full(2, number)})
        return solve_columns(changed, {}, 1)[f"pretension_{end}"][0]

    for key, row in rows.items():
        number = row["value"]
        step = 2e-5 * number
        if not step:
            continue
        near = end_at(key, number + step) - end_at(key, number - step)
        far = end_at(key, number + 2 * step) - end_at(key, number - 2 * step)
        slope = (8 * near - far) / (12 * step)
        assert row["slope"] * number == pytest.approx(slope * number, rel=1e-5, abs=1e-4), key
