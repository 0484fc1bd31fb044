"""A check names what breaks which limit, by how much, in which state, the worst first."""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.checks.check import check
from tendon_cli.checks.check_text import as_markdown
from tendon_cli.errors import UsageError
from tests.check.conftest import swept


def test_a_run_within_its_limits_holds(tmp_path):
    folder = swept(tmp_path / "good", tendon={"pretension": "165 N"}, load={"mass": "5 kg"})
    result = check(folder)
    assert result.holds
    assert result.text == "suit: the design is within its limits"
    assert result.record["breaches"] == []


def test_every_broken_design_is_counted_and_the_worst_come_first(limited):
    designs = tendon.open(limited).designs
    result = check(limited, worst=1000)
    assert not result.holds
    record = result.record
    assert record["designs"] - record["feasible"] == (~designs["feasible"]).sum()
    broken = record["broken"]
    assert broken["slack"] == (~designs["taut"]).sum()
    missing = designs["required_pretension"] - designs["pretension"]
    for breach in record["breaches"]:
        if breach["limit"] == "slack":
            assert -breach["value"] == pytest.approx(missing[breach["design"]])
    assert broken["max_tension"] == (designs["max_tension"] > 300.0).sum()
    assert broken["peak_motor_torque"] == (designs["peak_motor_torque"].abs() > 5.8).sum()
    assert broken["max_pretension"] == (designs["pretension"] > 230.0).sum()
    excess = [breach["excess"] for breach in record["breaches"]]
    assert excess == sorted(excess, reverse=True)
    assert len(check(limited, worst=3).record["breaches"]) == 3


def test_a_draw_is_named_once(tmp_path):
    drawn = {"uncertainty": {"draws": 8}, "sheath": {"friction": "0.07 +/- 0.01"}}
    folder = swept(tmp_path / "drawn", tendon={"pretension": "20 N"}, **drawn)
    lines = check(folder).text.splitlines()
    named = [line for line in lines if line.startswith("  design ")]
    assert named
    assert all(line.count("draw ") == 1 for line in named)


BADNESS = {
    "max_tension": lambda states: states.filter(like="tension_").max(axis=1),
    "peak_motor_torque": lambda states: states["motor_torque"].abs(),
    "min_elbow_stiffness": lambda states: -states["elbow_stiffness"],
    "min_flexor_tension": lambda states: -states.filter(like="flexor_tension_").min(axis=1),
    "min_extensor_tension": lambda states: -states.filter(like="extensor_tension_").min(axis=1),
    # The springs are equal: the larger tension stretches its spring more.
    "max_spring_extension": lambda states: states.filter(like="tension_distal").max(axis=1),
    # The strap presses from 10 degrees on.
    "max_contact_pressure": lambda states: states["extensor_tension_distal"].where(
        states["elbow_angle"] > np.radians(9.99), 0.0
    ),
}
"""Functions of the table of states that are largest in the state that breaks a limit most."""


def test_the_state_that_is_named_is_the_worst_of_its_design(limited):
    states = tendon.open(limited).states
    breaches = check(limited, worst=1000).record["breaches"]
    assert {breach["limit"] for breach in breaches} >= {*BADNESS}
    for breach in breaches:
        if breach["limit"] not in BADNESS:
            continue
        of_design = states[states["design"] == breach["design"]]
        badness = BADNESS[breach["limit"]](of_design)
        has_direction = of_design["direction"] == breach["direction"]
        has_angle = np.isclose(of_design["elbow_angle"], breach["elbow_angle"])
        is_named = has_direction & has_angle
        assert badness[is_named].item() == pytest.approx(badness.max(), rel=1e-12), breach["limit"]


def test_a_design_without_equilibrium_is_worst_of_all(tmp_path):
    far = {"elbow_angle": {"from": "0 deg", "to": "170 deg", "num": 18}}
    record = check(swept(tmp_path / "far", motion=far)).record
    worst = record["breaches"][0]
    assert worst["limit"] == "no equilibrium"
    assert np.rad2deg(worst["elbow_angle"]) == pytest.approx(160.0)


def test_a_run_without_designs_is_refused(tmp_path):
    folder = swept(tmp_path / "states", output={"tables": ["states"]})
    with pytest.raises(UsageError, match="no table of designs"):
        check(folder)


def test_names_say_no_markdown():
    text = as_markdown("<b>suit</b> [x](y): 1 design\n  `slack`", "negative result")
    assert "<b>" not in text
    assert "\\[x](y)" in text


def test_a_design_that_breaks_a_limit_on_both_sides_counts_once(tmp_path):
    sides = {"flexor": {"pretension": "100 N"}, "extensor": {"pretension": "120 N"}}
    folder = swept(tmp_path / "both", tendon=sides, limits={"max_pretension": "50 N"})
    record = check(folder, worst=10).record
    broken = [breach for breach in record["breaches"] if breach["limit"] == "max_pretension"]
    assert record["designs"] == 2
    assert len(broken) == 4  # both designs on both sides
    assert record["broken"]["max_pretension"] == 2
