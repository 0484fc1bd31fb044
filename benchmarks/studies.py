"""Studies that are measured, as text for a study file, by the number of values on each axis."""

from __future__ import annotations

import math
from pathlib import Path

LOADS = '["0 kg", "3 kg", "5 kg", "10 kg"]'
STATES_PER_DESIGN = 182
"""Two directions and 91 angles, the default."""

MANY_PARTS = "10^7, both tables"
"""Smallest study whose peak the larger ones are compared with; one of a single part, as 10^6 is,
takes less."""

KEPT = '[output]\nstates = ["status", "flexor_tension_distal", "motor_torque"]\n'
"""End of a study that writes only three columns of its states."""

ONE_SUIT = f"""
name = "one-suit"
[people]
count = 500
[spring]
stiffness = "7 kN/m"
[spool]
ratio = 0.6
[load]
mass = {LOADS}
[design]
serve = 0.5
"""
"""Study of one choice for people, which serves enough of them."""


def states_study(pretensions: int, springs: int, ratios: int) -> str:
    """Return a study with both tables, over pretension, springs, spool and four loads.

    `expert.py` computes the same designs.
    """
    return f"""
name = "states"
[tendon]
pretension = {{ from = "20 N", to = "260 N", num = {pretensions} }}
[spring]
stiffness = {{ from = "1 kN/m", to = "8 kN/m", num = {springs} }}
[spool]
ratio = {{ from = 0.6, to = 1.2, num = {ratios} }}
[load]
mass = {LOADS}
"""


def designs_study(pretensions: int, springs: int, ratios: int, frictions: int) -> str:
    """Return a study with one axis more, and only the designs table.

    `fused.c` computes the same designs.
    """
    return f"""
name = "designs"
[tendon]
pretension = {{ from = "20 N", to = "300 N", num = {pretensions} }}
[spring]
stiffness = {{ from = "0.5 kN/m", to = "8 kN/m", num = {springs}, spacing = "log" }}
[spool]
ratio = {{ from = 0.5, to = 1.2, num = {ratios} }}
[sheath]
friction = {{ from = 0.02, to = 0.2, num = {frictions} }}
[load]
mass = {LOADS}
[output]
tables = ["designs"]
"""


def windows_study(springs: int, ratios: int, frictions: int) -> str:
    """Return such a study without the axis of pretension, which windows are found along."""
    text = designs_study(1, springs, ratios, frictions)
    start = text.index("[tendon]")
    stop = text.index("[spring]")
    return text[:start] + text[stop:]


SAMPLES = 1000
"""Samples of a motion in time, and angles of the same number of states without one."""


def motion_study(pretensions: int, ratios: int, *, motion: str) -> str:
    """Return a study with both tables and a motor, over pretension and spool.

    Args:
        pretensions: Number of pretensions.
        ratios: Number of spool ratios.
        motion: Content of `[motion]`, of as many states as there are samples.
    """
    return f"""
name = "motion"
[tendon]
pretension = {{ from = "100 N", to = "200 N", num = {pretensions} }}
[spring]
stiffness = "5 kN/m"
[spool]
ratio = {{ from = 0.5, to = 0.9, num = {ratios} }}
[load]
mass = "2 kg"
[motion]
{motion}
"""


ALONG = """
trajectory = "swing.csv"
inertia = "0.08 kg m2"
"""
"""Motion in time, whose file `swing` writes beside the study."""
STILL = f"""
elbow_angle = {{ from = "10 deg", to = "80 deg", num = {SAMPLES} }}
direction = "flexion"
speed = "60 deg/s"
"""
"""Motion of as many states at a constant speed: the tables have the motor's columns, too."""


def swing(path: Path) -> None:
    """Write a swing of 0.75 Hz at 100 samples a second."""
    rows = ["time (s),angle (deg)"]
    for sample in range(SAMPLES):
        angle = 45.0 - 35.0 * math.cos(2.0 * math.pi * 0.75 * 0.01 * sample)
        rows.append(f"{0.01 * sample:.2f},{angle:.6f}")
    path.write_text("\n".join(rows), encoding="utf-8")


def written(text: str, path: Path) -> Path:
    """Write a study to a file, and return its path."""
    path.write_text(text, encoding="utf-8")
    return path
