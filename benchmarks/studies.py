"""Studies that are measured, as text for a study file, by the number of values on each axis."""

from __future__ import annotations

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


def written(text: str, path: Path) -> Path:
    """Write a study to a file, and return its path."""
    path.write_text(text, encoding="utf-8")
    return path
