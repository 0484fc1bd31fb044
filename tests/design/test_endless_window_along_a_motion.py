"""A limit on power binds however far beyond the other limits."""

import numpy as np
import pytest

import tendon_cli as tendon
from tests.answers import solved

FAR = 1000.0
"""Pretension far beyond the other limits, N."""
ANGLES = np.arange(-40.0, 41.0, 10.0)
TIME = np.arange(0.0, 2.0, 0.05)
SUIT = {
    "joint": {
        "name": "ankle",
        "excursion": {
            "angle": [f"{angle} deg" for angle in ANGLES],
            "flexor": [f"{0.8 * angle} mm" for angle in ANGLES],
            "extensor": [f"{0.6 * angle} mm" for angle in ANGLES],
        },
        "stiffness": "8 N m/rad",
        "rest_angle": "0 deg",
    },
    "arm": {"forearm_mass": "1 kg", "forearm_com": "60 mm", "upper_arm_angle": "90 deg"},
    "spring": {"stiffness": "20 kN/m"},
    "motion": {
        "trajectory": {
            "time": TIME.tolist(),
            "angle": [f"{20.0 * np.sin(np.pi * moment)} deg" for moment in TIME],
        },
        "cutoff": "6 Hz",
    },
}
"""Suit of constant moment arms, whose window along a motion has no upper end."""


def test_a_window_ends_where_the_motion_breaks_a_limit_far_away():
    assert solved(SUIT).pretension_to[0] == np.inf
    far = tendon.sweep(SUIT | {"tendon": {"pretension": FAR}}, jobs=1).designs.iloc[0]
    limited = solved(SUIT | {"limits": {"peak_motor_power": float(far["peak_motor_power"])}})
    assert limited.pretension_to[0] == pytest.approx(FAR, rel=1e-6)
