"""A check names what breaks which limit, by how much, in which state, the worst first."""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.checks.check import check
from tendon_cli.checks.check_text import as_markdown
from tendon_cli.errors import UsageError
from tests.check.conftest import swept


def test_a_run_within_its_limits_holds(tmp_path):
    found = check(swept(tmp_path / "good", tendon={"pretension": "165 N"}, load={"mass": "5 kg"}))
    assert found.holds
    assert found.text == "suit: the design is within its limits"
    assert found.record["breaches"] == []


def test_every_broken_design_is_counted_and_the_worst_come_first(limited):
    designs = tendon.open_run(limited).designs
    found = check(limited, worst=1000)
    assert not found.holds
    record = found.record
    assert record["designs"] - record["feasible"] == (~designs["feasible"]).sum()
    assert record["broken"]["slack"] == (~designs["taut"]).sum()
    needed = designs["required_pretension"] - designs["pretension"]
    for breach in record["breaches"]:
        assert breach["limit"] != "slack" or -breach["value"] == pytest.approx(
            needed[breach["design"]]
        )
    assert record["broken"]["max_tension"] == (designs["max_tension"] > 300.0).sum()
    assert record["broken"]["peak_motor_torque"] == (designs["peak_motor_torque"].abs() > 5.8).sum()
    assert record["broken"]["max_pretension"] == (designs["pretension"] > 230.0).sum()
    excess = [breach["excess"] for breach in record["breaches"]]
    assert excess == sorted(excess, reverse=True)
    assert len(check(limited, worst=3).record["breaches"]) == 3


COLUMNS = {
    "max_tension": lambda states: states.filter(like="tension_").max(axis=1),
    "peak_motor_torque": lambda states: states["motor_torque"].abs(),
    "min_elbow_stiffness": lambda states: -states["elbow_stiffness"],
    "min_flexor_tension": lambda states: -states.filter(like="flexor_tension_").min(axis=1),
    "min_extensor_tension": lambda states: -states.filter(like="extensor_tension_").min(axis=1),
    "max_spring_extension": lambda states: states.filter(regex="tension_distal").max(
        axis=1
    ),  # springs are equal
    "max_contact_pressure": lambda states: states["extensor_tension_distal"],
}


@pytest.mark.parametrize("limit", COLUMNS)
def test_the_state_that_is_named_is_the_worst_of_its_design(limited, limit):
    states = tendon.open_run(limited).states
    told = [
        breach
        for breach in check(limited, worst=1000).record["breaches"]
        if breach["limit"] == limit
    ]
    assert told
    for breach in told:
        own = states[states["design"] == breach["design"]]
        badness = COLUMNS[limit](own)
        here = (own["direction"] == breach["direction"]) & np.isclose(
            own["elbow_angle"], breach["elbow_angle"]
        )
        assert badness[here].item() == pytest.approx(badness.max(), rel=1e-12)


def test_a_design_without_equilibrium_is_worst_of_all(tmp_path):
    far = {"elbow_angle": {"from": "0 deg", "to": "170 deg", "num": 18}}
    first = check(swept(tmp_path / "far", motion=far)).record["breaches"][0]
    assert first["limit"] == "no equilibrium"
    assert np.rad2deg(first["elbow_angle"]) == pytest.approx(160.0)


def test_an_answer_holds_where_a_choice_has_a_window(tmp_path):
    study = {"spring": {"stiffness": "5 kN/m"}, "load": {"mass": ["0 kg", "3 kg", "5 kg", "10 kg"]}}
    tendon.design(tendon.study(study | {"spool": {"ratio": 0.6}}), tmp_path / "good")
    assert check(tmp_path / "good").holds
    tendon.design(tendon.study(study | {"spool": {"ratio": 1.0}}), tmp_path / "bad")
    found = check(tmp_path / "bad")
    assert not found.holds
    assert "extensor slack against min_elbow_stiffness" in found.text


def test_a_run_without_designs_is_refused(tmp_path):
    with pytest.raises(UsageError, match="no table of designs"):
        check(swept(tmp_path / "states", output={"tables": ["states"]}))


def test_names_say_no_markdown():
    text = as_markdown("<b>suit</b> [x](y): 1 design\n  `slack`", holds=False)
    assert "<b>" not in text
    assert "\\[x](y)" in text
