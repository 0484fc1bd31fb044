"""The strap presses from an angle on: windows and pressures against an independent computation.

The tensions of single states are those of the plain arm, at angles that include the one from
which on the strap presses.
"""

import numpy as np
import pytest
from scipy.optimize import brentq

import tendon_cli as tendon
from tests.answers import solved
from tests.people import plain_suit

WIDTH = 0.08  # m
RADIUS = 0.045  # m
MOST = 52.9e3  # Pa
RATIO = 0.6
LAST = 95.0  # deg; the grid of 91 angles has no round number
CONTENT = {
    "spring": {"stiffness": "8 kN/m"},
    "spool": {"ratio": RATIO},
    "load": {"mass": ["0 kg", "5 kg"]},
    "arm": {"contact_width": WIDTH},
    "motion": {"elbow_angle": {"from": "0 deg", "to": f"{LAST} deg", "num": 20}},
    "limits": {"max_contact_pressure": MOST},
}


def largest_pressure(pretension, first):
    """Return the largest pressure from an angle, deg, to the last, that angle included."""
    arm = plain_suit.papers_arm(8e3)
    angles = np.radians(np.append(first, np.linspace(first, LAST, 97)))
    tensions = []
    for load in (0.0, 5.0):
        for sign in plain_suit.DIRECTIONS:
            _, (at_zero, slope), _ = arm.lines(angles, 0.0, load, sign)
            tensions.append(at_zero + slope * pretension)
    return np.max(tensions) / (RADIUS * WIDTH)


def answered(**arm):
    return tendon.design(tendon.study({**CONTENT, "arm": {**CONTENT["arm"], **arm}}))


@pytest.mark.parametrize("first", [0.3, 77.77])
def test_the_angle_at_which_contact_begins_counts_between_the_angles_of_the_grid(first):
    best = answered(contact_from=f"{first} deg").best
    assert best["between_samples"] == "proven"
    expected = brentq(lambda at: largest_pressure(at, first) - MOST, 50.0, 400.0, rtol=1e-12)
    within = 2e-6 if first > 60.0 else 5e-5  # 97 angles miss a little of a peak between them
    assert best["pretension_to"] == pytest.approx(expected, rel=within)
    assert best["to_by"] == "max_contact_pressure"
    if first > 60.0:  # the pressure falls from there on
        assert best["to_elbow_angle"] == pytest.approx(np.radians(first), rel=1e-9)
    at_pretension = largest_pressure(best["pretension"], first)
    assert best["max_contact_pressure"] == pytest.approx(at_pretension, rel=1e-5)


def test_it_is_10_degrees_by_default_and_the_first_angle_if_that_is_larger():
    late = {"elbow_angle": {"from": "75 deg", "to": "95 deg", "num": 5}}
    stated = {"contact_from": "75 deg"}
    arms = [{}, {"contact_from": "-40 deg"}, stated]
    windows = [
        tendon.design({**CONTENT, "motion": late, "arm": {**CONTENT["arm"], **arm}}).best
        for arm in arms
    ]
    assert windows[0]["pretension_to"] == windows[1]["pretension_to"]
    assert windows[0]["pretension_to"] == pytest.approx(windows[2]["pretension_to"], rel=1e-12)
    by_default = answered().best
    at_10 = answered(contact_from="10 deg").best
    assert by_default["max_contact_pressure"] == at_10["max_contact_pressure"]
    # At rest, arm hanging, nothing wraps: a motion that ends before does not press at all.
    early = {"elbow_angle": {"from": "0 deg", "to": "9 deg", "num": 5}}
    still = tendon.design({**CONTENT, "motion": early}).best
    assert still["max_contact_pressure"] == 0.0
    assert still["to_by"] != "max_contact_pressure"


def test_later_contact_never_narrows_a_window_nor_raises_a_pressure():
    answers = [answered(contact_from=f"{first} deg").best for first in (0, 45, 96)]
    ends = [best["pretension_to"] for best in answers]
    assert ends == sorted(ends)
    assert ends[-1] > ends[0] + 50.0
    assert len({best["pretension_from"] for best in answers}) == 1


def test_a_listed_angle_counts_in_spite_of_rounding_in_a_sweep():
    angles = [f"{angle} deg" for angle in (5, 10, 20, 30)]
    swept = tendon.sweep(
        {
            **CONTENT,
            "motion": {"elbow_angle": angles},
            "arm": {**CONTENT["arm"], "elbow_radius": 0.05},
            "tendon": {"pretension": "300 N"},
            "load": {"mass": "0 kg"},
        }
    )
    states = swept.states
    at = states[states.elbow_angle > np.radians(9.999)].extensor_tension_distal
    expected = at.max() / (0.05 * WIDTH)
    assert swept.designs.max_contact_pressure.item() == pytest.approx(expected, rel=1e-14)


def test_measured_travels_press_from_the_first_angle_unless_the_study_says_from_where():
    angle = np.linspace(0.0, 1.6, 9)
    table = {
        "angle": [f"{value} rad" for value in angle],
        "flexor": [f"{0.04 * value} m" for value in angle],
        "extensor": [f"{0.045 * value} m" for value in angle],
    }
    base = {
        "joint": {"excursion": table},
        "arm": {"contact_width": WIDTH, "contact_radius": RADIUS},
        "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 10}},
        "tendon": {"pretension": "200 N"},
    }

    def pressed(**arm):
        swept = tendon.sweep({**base, "arm": {**base["arm"], **arm}})
        return swept.designs.max_contact_pressure.item(), swept.states

    everywhere, states = pressed()
    assert everywhere == pytest.approx(states.extensor_tension_distal.max() / (RADIUS * WIDTH))
    late, _ = pressed(contact_from="85 deg")
    at_last = states[states.elbow_angle > 1.55].extensor_tension_distal.max()
    assert late == pytest.approx(at_last / (RADIUS * WIDTH))
    assert late != everywhere


def test_the_angle_of_contact_may_differ_among_conditions_and_the_width_among_choices():
    """The worst under all conditions is the worst of those under each of them."""
    angles = ["10 deg", "60 deg"]
    widths = {"contact_width": ["60 mm", "80 mm"]}

    def solved_from(contact):
        design = {"conditions": ["arm.contact_from", "load.mass"], "pretension": "100 N"}
        arm = widths | {"contact_from": contact}
        return solved(CONTENT | {"arm": arm, "design": design})

    together = solved_from(angles)
    apart = [solved_from(angle) for angle in angles]
    first = [solutions.pretension_from for solutions in apart]
    last = [solutions.pretension_to for solutions in apart]
    pressure = [solutions.worst.max_contact_pressure for solutions in apart]
    assert together.pretension_from == pytest.approx(np.max(first, axis=0), rel=1e-9)
    assert together.pretension_to == pytest.approx(np.min(last, axis=0), rel=1e-9)
    assert together.worst.max_contact_pressure == pytest.approx(np.max(pressure, axis=0), rel=1e-9)
    assert len(np.unique(together.worst.max_contact_pressure)) == len(widths["contact_width"])


@pytest.mark.parametrize("contact_from", ["10 deg", "80 deg"])
def test_a_strap_that_never_presses_is_none_of_the_parts_needed(contact_from):
    content = {
        "spring": {"stiffness": "5 kN/m"},
        "spool": {"ratio": 0.6},
        "load": {"mass": "5 kg"},
        "motion": {"elbow_angle": "60 deg"},
        "arm": {"contact_radius": "40 mm", "contact_from": contact_from},
    }
    answer = tendon.design(content)
    is_pressed = answer.record["parts_needed"]["strap"]["least_width"] > 0.0
    assert is_pressed == (contact_from == "10 deg")
    assert ("strap" in answer.short) == is_pressed
