"""Shares served on arms that scatter, against a Monte Carlo in plain NumPy (`plain_suit`)."""

from functools import cache

import numpy as np
import pytest

from tendon_cli.engine.windows.question import question_of
from tendon_cli.engine.windows.solutions import solve_windows
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.studies.load import study_from
from tests.people import plain_suit

PERSONS = 1000
PLAIN_PERSONS = 4000

FIT = {
    "a1": {"value": "40 mm", "tolerance": "15 %"},
    "a2": {"value": "20 mm", "tolerance": "15 %"},
    "b1": {"value": "150 mm", "tolerance": "10 %"},
    "b2": {"value": "150 mm", "tolerance": "10 %"},
    "elbow_radius": {"value": "45 mm", "tolerance": "10 %"},
}
SUIT = {
    "people": {"count": PERSONS, "seed": 5},
    "spring": {"stiffness": "7 kN/m"},
    "spool": {"ratio": 0.6},
    "arm": FIT | {"contact_width": "100 mm", "upper_arm_angle": ["-15 deg", "0 deg", "15 deg"]},
    "load": {"mass": ["0 kg", "5 kg"]},
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 31}},
    "limits": {"max_contact_pressure": "52.9 kPa"},
    "design": {"pretension": "116 N"},
}
ALIKE = {
    "anchor": {"stiffness": "10 kN/m"},
    "joint": {"stiffness": "1.1 N m/rad", "rest_angle": "73 deg"},
    "setting": {"read": "flexor at joint"},
}
SCATTERED = {
    "anchor": {
        "flexor": {"stiffness": "5 kN/m to 20 kN/m"},
        "extensor": {"stiffness": "5 kN/m to 20 kN/m"},
    },
    "joint": {
        "stiffness": "1.1 N m/rad",
        "stiffness_with": "arm_volume",
        "rest_angle": "73 deg +/- 10 deg",
    },
    "setting": {"read": "flexor at joint", "reading_error": "5 N"},
}
KINDS = {"alike": ALIKE, "scattered": SCATTERED}


@cache
def shares_of(name):
    """Return the shares of all persons, of men and of women that the suit serves."""
    return served_by_sex(SUIT | KINDS[name])


def served_by_sex(content):
    """Return the shares of all persons, of men and of women that a study's one choice serves."""
    question = question_of(study_from(content))
    solver = Solver(question)
    points = question.all_points()
    solved, _ = solve_windows(solver, points)
    low, high = question.groups.windows(*_ends(solver, points))
    served = (low[0] <= 116.0) & (high[0] >= 116.0)
    is_woman = np.array(question.study.people.population.sexes) == "female"
    assert served.mean() == pytest.approx(solved.served_at.item(), abs=1e-12)
    return np.array([served.mean(), served[~is_woman].mean(), served[is_woman].mean()])


def _ends(solver, points):
    """Return both ends of the windows under all conditions, (1, conditions)."""
    ends = solver.ends(points)
    return ends.low, ends.high


@pytest.mark.parametrize("name", KINDS)
def test_a_suit_serves_the_share_that_a_plain_monte_carlo_finds(name):
    found = shares_of(name)
    served, is_woman = plain_suit.robust(PLAIN_PERSONS, 8, scatter=name == "scattered")
    plain = np.array([served.mean(), served[~is_woman].mean(), served[is_woman].mean()])
    women = plain_suit.survey()["female"]["persons"] / 6068
    sizes = np.array([1.0, 1.0 - women, women])
    variance = plain * (1.0 - plain) / sizes * (1.0 / PERSONS + 1.0 / PLAIN_PERSONS)
    assert np.all(np.abs(found - plain) < 4.0 * np.sqrt(variance))


def test_each_scatter_moves_the_share_by_what_it_moves_in_the_monte_carlo():
    # The scatter of SCATTERED loses some 6 points of ALIKE's 95 %: far more than chance.
    alike = shares_of("alike")
    scattered = shares_of("scattered")
    assert 0.03 < alike[0] - scattered[0] < 0.1
    assert np.all(scattered < alike)
