"""A limit on power binds however far beyond the other limits."""

import numpy as np
import pytest

import tendon_cli as tendon

FAR = 1000.0
"""Pretension far beyond the other limits, N."""


@pytest.fixture
def suit(tmp_path):
    """Return a suit of constant moment arms, whose window along a motion has no upper end."""
    angle = np.arange(-40.0, 41.0, 10.0)
    rows = np.column_stack([angle, 0.8 * angle, 0.6 * angle])
    excursion = tmp_path / "excursion.csv"
    write_rows(excursion, rows, "angle (deg),flexor (mm),extensor (mm)")
    time = np.arange(0.0, 4.0, 0.01)
    trajectory = tmp_path / "motion.csv"
    write_rows(
        trajectory, np.column_stack([time, 20.0 * np.sin(np.pi * time)]), "time (s),angle (deg)"
    )
    return {
        "joint": {
            "name": "ankle",
            "excursion": str(excursion),
            "stiffness": "8 N m/rad",
            "rest_angle": "0 deg",
        },
        "arm": {"forearm_mass": "1 kg", "forearm_com": "60 mm", "upper_arm_angle": "90 deg"},
        "spring": {"stiffness": "20 kN/m"},
        "motion": {"trajectory": str(trajectory), "cutoff": "6 Hz"},
    }


def write_rows(file, rows, header):
    """Write rows as a CSV with a header."""
    np.savetxt(file, rows, delimiter=",", header=header, comments="")


def peaks(suit, pretension):
    """Return the row of designs of a suit at a pretension."""
    content = suit | {"tendon": {"pretension": pretension}}
    return tendon.sweep(content, jobs=1).designs.iloc[0]


def test_a_window_ends_where_the_motion_breaks_a_limit_far_away(suit):
    assert tendon.design(suit, jobs=1).record["best"]["pretension_to"] is None
    bound = float(peaks(suit, FAR)["peak_motor_power"])
    limited = tendon.design(suit | {"limits": {"peak_motor_power": bound}}, jobs=1)
    assert limited.record["best"]["pretension_to"] == pytest.approx(FAR, rel=1e-6)
