"""Limits on the motor in `tendon design`.

Windows end where the cycle reaches them, and conflicts name them.
"""

from dataclasses import replace

import numpy as np
import pytest

from tendon_cli import design
from tendon_cli.answers.sensitivity import sensitivities
from tendon_cli.engine.windows.question import question_of
from tendon_cli.engine.windows.solutions import solve
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.model.limits import LIMIT_NAMES
from tendon_cli.model.motor import cycle_columns
from tendon_cli.studies.load import study_from
from tendon_cli.verbs.typed_record import to_json
from tests.sampled import quick_and_torture

SUIT = {
    "load": {"mass": ["0 kg", "3 kg"]},
    "spool": {"ratio": [0.6, 0.7]},
    "spring": {"stiffness": "5 kN/m"},
    "motion": {"speed": "60 deg/s", "elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 10}},
}


def solved(**limits):
    """Return the question of the suit under limits, and its solutions."""
    question = question_of(study_from({**SUIT, "limits": limits}))
    return question, solve(Solver(question), question.all_points())


@pytest.mark.parametrize(
    ("name", "most", "column", "end"),
    [
        ("peak_motor_speed", "4 rad/s", "peak_motor_speed", "from"),
        ("peak_motor_power", "13 W", "peak_motor_power", "from"),
    ],
)
def test_a_window_ends_where_the_cycle_reaches_the_limit(name, most, column, end):
    question, solutions = solved(**{name: most})
    _, unlimited = solved()
    ends = solutions.pretension_at(end)
    conditions = solutions.binding(end).condition
    is_set_by_limit = [LIMIT_NAMES[code] == name for code in solutions.binding(end).by]
    binds = is_set_by_limit & ~np.isnan(ends)
    assert binds.any()
    for row in np.flatnonzero(binds):
        assert ends[row] != unlimited.pretension_at(end)[row]
        points = question.points(np.array([row]))
        suit = question.designs(points.at_pretension(ends[[row]]))
        values = cycle_columns(suit, question.angles, question.flexion, np.radians(60.0))[
            column
        ].ravel()
        assert values[conditions[row]] == pytest.approx(question.bounds[name], rel=1e-6)


def test_limits_of_the_motor_are_in_words_as_others_are():
    content = {**SUIT, "spool": {"ratio": 0.6}}
    broken = design({**content, "limits": {"peak_motor_power": "1 W"}})
    assert not broken.feasible
    assert "the motor gives more than 1 W" in broken.text
    kept = design({**content, "limits": {"peak_motor_power": "40 W"}})
    assert kept.feasible
    assert any("peak_motor_power" in note for note in kept.record["notes"])


SET_BY_THE_MOTOR = [
    ("peak_motor_speed", "4 rad/s", "from"),
    ("peak_motor_power", "13.5 W", "from"),
]


@pytest.mark.parametrize("step", quick_and_torture([16], [1]))
@pytest.mark.parametrize(("limit", "value", "end"), SET_BY_THE_MOTOR)
def test_ends_that_a_limit_on_the_motor_sets_have_their_slopes(limit, value, end, step):
    """Compare every number in `step`, and those of the motion and the limit in any case."""
    question = question_of(study_from({**SUIT, "spool": {"ratio": 0.6}, "limits": {limit: value}}))
    choice = solve(Solver(question), question.all_points())
    assert LIMIT_NAMES[choice.binding(end).by[0]] == limit
    rows = {
        row["key"]: row
        for row in to_json(sensitivities(Solver(question), choice))
        if row["end"] == end
    }
    always = {"motion.speed", f"limits.{limit}", "spring.stiffness", "load.mass"}
    assert always <= set(rows)
    first = SET_BY_THE_MOTOR.index((limit, value, end)) % step
    compared = always | set(sorted(rows)[first::step])
    masses = question.condition_numbers["load.mass"]
    binding = choice.binding(end).condition[0]

    def end_at(key, number):
        if key == "motion.speed":
            changed = replace(question, bounds=question.bounds.changed("speed", number))
        elif key.startswith("limits."):
            changed = replace(question, bounds=question.bounds.changed(limit, number))
        elif key == "load.mass":
            changed = question.with_numbers(
                {key: np.where(np.arange(2) == binding, number, masses)}
            )
        else:
            changed = question.with_numbers({key: np.full(2, number)})
        return solve(Solver(changed), changed.all_points()).pretension_at(end)[0]

    for key in compared:
        row = rows[key]
        number = row["value"]
        width = 2e-5 * number
        if not width:
            continue
        near = end_at(key, number + width) - end_at(key, number - width)
        far = end_at(key, number + 2 * width) - end_at(key, number - 2 * width)
        slope = (8 * near - far) / (12 * width)
        assert row["slope"] * number == pytest.approx(slope * number, rel=1e-5, abs=1e-4), key
