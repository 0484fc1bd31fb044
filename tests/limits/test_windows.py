"""Limits that differ between choices or conditions: each window is held to its own."""

import numpy as np
import pytest

from tendon_cli.engine.windows.question import question_of
from tendon_cli.engine.windows.solutions import solve
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.studies.load import study_from
from tests.answers import merged

from .suits import LOOSER_AND_TIGHTER, SUIT, limited

OF_PEOPLE = {"people": {"count": 3}, "sheath": {"friction": "0.07 +/- 0.02"}}
VARIANTS = {
    "as it is": {},
    "people and draws": {**OF_PEOPLE, "uncertainty": {"draws": 4}},
    "sides differ": {
        "sheath": {"flexor": {"friction": 0.12}},
        "spring": {"extensor": {"stiffness": "9 kN/m"}},
    },
    "a given pretension": {"design": {"pretension": "90 N"}},
    "another reading": {"setting": {"read": "extensor at joint"}},
    "a spring at the motor": {"spring": {"extensor": {"at": "motor"}}},
}


def solutions(content, rows=None):
    """Return the solved choices of a study, or of some rows of it, as plain arrays."""
    question = question_of(study_from(content))
    points = question.all_points() if rows is None else question.points(rows)
    solved = solve(Solver(question), points)
    return {
        "from": solved.pretension_from,
        "to": solved.pretension_to,
        "from by": solved.from_binding.by,
        "to by": solved.to_binding.by,
        "from state": solved.from_binding.state,
        "to state": solved.to_binding.state,
        "from angle": solved.from_binding.angle,
        "served": solved.served,
        "at": solved.pretension,
        "served at": solved.served_at,
        "feasible": solved.feasible,
        "tension": solved.worst.max_tension,
    }


def check_equal(found, expected):
    """Check that two sets of solutions are the same to the last bit."""
    for name, values in expected.items():
        np.testing.assert_array_equal(found[name], values, err_msg=name)


def of_row(solved, row):
    """Return the choices of one row of a table, which is slower than the two springs."""
    return {name: values[2 * row : 2 * row + 2] for name, values in solved.items()}


@pytest.mark.parametrize("limit", LOOSER_AND_TIGHTER)
def test_a_limit_on_an_axis_or_in_a_row_is_the_study_with_that_limit(limit):
    values = LOOSER_AND_TIGHTER[limit]
    alone = [solutions(limited(limit, value)) for value in values]
    looser, tighter = alone
    assert any((looser[name] != tighter[name]).any() for name in ("from", "to", "feasible"))
    widths = [np.where(one["feasible"], one["to"] - one["from"], -1.0) for one in alone]
    assert (widths[1] <= widths[0] + 1e-9).all()
    both = solutions(limited(limit, list(values)))
    for place, expected in enumerate(alone):
        check_equal({name: rows[place::2] for name, rows in both.items()}, expected)
    rows = [{"name": "free"}]
    rows += [{"name": f"row {value}", f"limits.{limit}": value} for value in values]
    in_rows = solutions(merged(SUIT, {"table": [{"name": "motor", "rows": rows}]}))
    for row, expected in enumerate([solutions(SUIT), *alone]):
        check_equal(of_row(in_rows, row), expected)


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("limit", ["max_tension", "max_pretension", "max_contact_pressure"])
def test_it_is_so_in_any_question(limit, variant):
    values = LOOSER_AND_TIGHTER[limit]
    both = solutions(limited(limit, list(values), VARIANTS[variant]))
    for place, value in enumerate(values):
        expected = solutions(limited(limit, value, VARIANTS[variant]))
        check_equal({name: rows[place::2] for name, rows in both.items()}, expected)


def test_a_limit_of_the_conditions_bounds_each_by_its_own():
    """Give one of two conditions a limit: the window is that of both studies at once."""
    load = {"load": {"mass": "5 kg"}}
    cases = [{"name": "a"}, {"name": "b", "limits": {"max_tension": "205 N"}}]
    together = solutions(merged(SUIT, load, {"cases": cases}))
    free = solutions(merged(SUIT, load))
    bound = solutions(limited("max_tension", "205 N", load))
    assert (free["to"] != bound["to"]).any()
    np.testing.assert_array_equal(together["from"], np.maximum(free["from"], bound["from"]))
    np.testing.assert_array_equal(together["to"], np.minimum(free["to"], bound["to"]))


def test_a_limit_may_be_a_condition_which_holds_for_the_tightest():
    conditions = {"design": {"conditions": ["load.mass", "limits.max_tension"]}}
    both = solutions(limited("max_tension", ["240 N", "205 N"], conditions))
    tightest = solutions(limited("max_tension", "205 N"))
    for end in ("from", "to", "from by", "to by"):
        np.testing.assert_array_equal(both[end], tightest[end])


def test_two_limits_are_the_product_of_both():
    both = solutions(
        limited("max_tension", ["240 N", "205 N"], {"limits": {"peak_motor_torque": [5.5, 4.8]}})
    )
    for row, (force, torque) in enumerate([(240, 5.5), (240, 4.8), (205, 5.5), (205, 4.8)]):
        alone = solutions(limited("max_tension", force, {"limits": {"peak_motor_torque": torque}}))
        check_equal({name: rows[row::4] for name, rows in both.items()}, alone)


def test_an_empty_cell_leaves_the_limit_of_the_study():
    rows = [{"name": "stiff", "limits.max_tension": "205 N"}, {"name": "other"}]
    table = {"table": [{"name": "motor", "rows": rows}]}
    in_rows = solutions(limited("max_tension", "240 N", table))
    for row, value in enumerate(["205 N", "240 N"]):
        check_equal(of_row(in_rows, row), solutions(limited("max_tension", value)))
