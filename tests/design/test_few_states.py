"""Limits of studies with few states: one elbow angle, one direction, two angles."""

import pytest

import tendon_cli as tendon
from tendon_cli.model.limits import LIMITS
from tests.sampled import quick_and_torture

BOUNDS = {
    "min_flexor_tension": "1 N",
    "min_extensor_tension": "1 N",
    "max_tension": "900 N",
    "max_spring_extension": "300 mm",
    "peak_motor_torque": "30 N m",
    "max_contact_pressure": "500 kPa",
    "min_spring_room": "0 mm",
    "min_elbow_stiffness": "0 N m/rad",
    "max_pretension": "900 N",
    "min_spool_to_tendon": 1,
    "peak_motor_speed": "50 rad/s",
    "peak_motor_power": "300 W",
}
"""A bound for each limit that a suit keeps."""
STILL = {"elbow_angle": "45 deg"}
MOTIONS = {
    "one angle": STILL,
    "one angle in flexion": {**STILL, "direction": "flexion"},
    "one angle in extension": {**STILL, "direction": "extension"},
    "flexion": {"elbow_angle": ["0 deg", "90 deg"], "direction": "flexion"},
    "extension": {"elbow_angle": ["0 deg", "90 deg"], "direction": "extension"},
    "two angles": {"elbow_angle": ["0 deg", "90 deg"]},
}


def suit(limit, motion):
    """Return a study of a suit with a window, under one limit."""
    return {
        "arm": {"contact_width": "40 mm"},
        "spring": {"stiffness": "5 kN/m", "free_length": "5 mm"},
        "spool": {"ratio": 0.6},
        "load": {"mass": ["0 kg", "3 kg"]},
        "motion": {"speed": "60 deg/s", **MOTIONS[motion]},
        "limits": {limit: BOUNDS[limit]},
    }


def test_every_limit_has_a_bound():
    assert BOUNDS.keys() == LIMITS.keys()


PAIRS = [(limit, motion) for limit in LIMITS for motion in MOTIONS]
FEW = [
    [pair for pair in PAIRS if pair[0] == limit][place % 2 * -1]
    for place, limit in enumerate(LIMITS)
]
"""Every limit in its first motion or its last."""
REST = [pair for pair in PAIRS if pair not in FEW]


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize(("limit", "motion"), quick_and_torture(FEW, REST))
def test_every_limit_is_judged(limit, motion):
    content = suit(limit, motion)
    answer = tendon.design(content)
    between = answer.record["between_samples"]
    if "one angle" in motion and between is not None:
        assert between["estimate"] is None
    assert len(tendon.sweep(content).designs) == 2
