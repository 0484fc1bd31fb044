"""Truths of any question: a tighter limit never widens a window, a lower share never narrows it."""

from itertools import pairwise

import numpy as np
import pytest

from tests import answers

COARSE = {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}}
LIMITS = {
    "max_tension": [420.0, 400.0, 380.0, 350.0],
    "max_spring_extension": [0.09, 0.07, 0.06],
    "peak_motor_torque": [12.0, 11.0, 9.0],
    "min_elbow_stiffness": [-2.0, 0.0, 1.0, 3.0],
    "min_extensor_tension": [0.0, 5.0, 20.0],
    "max_pretension": [200.0, 150.0, 120.0],
}


def solved(**content):
    """Solve the twelve choices of a study with some tables replaced."""
    base = {
        "spring": {"stiffness": [3e3, 5e3, 8e3]},
        "spool": {"ratio": [1.0, 0.7, 0.6, 0.5]},
        "motion": COARSE,
        "load": {"mass": [0.0, 5.0, 10.0]},
    }
    return answers.solved({**base, **content})


def widths(solutions):
    """Return the width of each window, N; below 0 if there is none."""
    return np.where(solutions.feasible, solutions.pretension_to - solutions.pretension_from, -1.0)


def check_never_widens(looser, tighter):
    """Check that no window is wider in the tighter solutions; return true if any differs."""
    before = widths(looser)
    after = widths(tighter)
    assert (after <= before + 1e-9).all()
    return (after != before).any()


DRAWN_LOADS = {
    "load": {},
    "table": [
        {
            "name": "load",
            "role": "draw",
            "rows": [{"name": str(mass), "load.mass": mass} for mass in (0.0, 5.0, 10.0)],
        }
    ],
}
"""The same loads, of which a share may be enough."""


@pytest.mark.parametrize(
    "whom", [{}, {**DRAWN_LOADS, "design": {"serve": 0.6}}], ids=["all", "60 %"]
)
@pytest.mark.parametrize("limit", LIMITS)
def test_a_tighter_limit_never_widens_a_window(limit, whom):
    solutions = [solved(limits={limit: value}, **whom) for value in LIMITS[limit]]
    differ = [check_never_widens(looser, tighter) for looser, tighter in pairwise(solutions)]
    assert any(differ)


MASSES = [5.0, 0.0, 10.0, 3.0, 12.0]


@pytest.mark.parametrize(
    "contents",
    [
        [{"load": {"mass": MASSES[: 1 + count]}} for count in range(len(MASSES))],
        [{"people": {"count": count}, "design": {"serve": 1.0}} for count in (1, 2, 5, 20, 80)],
    ],
    ids=["conditions", "persons"],
)
def test_one_more_never_widens_a_window_of_all(contents):
    solutions = [solved(**content) for content in contents]
    for fewer, more in pairwise(solutions):
        check_never_widens(fewer, more)


@pytest.mark.parametrize(
    "whom",
    [
        DRAWN_LOADS,
        {"people": {"count": 60}},
        {"people": {"count": 60}, "limits": {"max_tension": 380.0}},
        {"sheath": {"friction": {"mean": 0.07, "std": 0.02}}, "uncertainty": {"draws": 64}},
    ],
    ids=["loads", "people", "limited people", "draws"],
)
def test_a_lower_share_never_narrows_a_window_and_is_served_in_all_of_it(whom):
    """Judge by the sample itself: without a fresh one, it need not show that so many are served."""
    shares = (1.0, 0.99, 0.95, 0.9, 0.75, 0.5, 0.3)
    solutions = [solved(**whom, design={"serve": share, "verify": 0}) for share in shares]
    for more, less in pairwise(solutions):
        assert (widths(less) >= widths(more) - 1e-9).all()
        np.testing.assert_allclose(less.served, more.served, atol=1e-12)
    for share, solution in zip(shares, solutions, strict=True):
        served_inside = solution.served_at[solution.feasible]
        assert (served_inside >= share - 1e-9).all()
        assert (solution.served_at <= solution.served + 1e-12).all()
        assert (solution.feasible == (solution.served >= share - 1e-9)).all()
