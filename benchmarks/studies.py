"""The studies that are measured, as text for a study file, by the number of values on each axis."""

from __future__ import annotations

from pathlib import Path

LOADS = '["0 kg", "3 kg", "5 kg", "10 kg"]'
STATES_PER_DESIGN = 182
"""Two directions and 91 angles, the default."""


MANY_PARTS = "10^7, both tables"
"""The least study whose peak the larger ones are held to: one of a single part, as 10^6 is, takes less."""

KEPT = '[output]\nstates = ["status", "flexor_tension_distal", "motor_torque"]\n'
"""At the end of a study: three columns of its states."""


def states_study(pretensions: int, springs: int, ratios: int) -> str:
    """Pretension, springs, spool and four loads, with both tables; `expert.py` computes the same designs."""
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
    """One axis more, and only the designs table; `fused.c` computes the same designs."""
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
    """Without the axis of pretension, which a window is over."""
    text = designs_study(1, springs, ratios, frictions)
    return text.replace(text[text.index("[tendon]") : text.index("[spring]")], "")


def written(text: str, path: Path) -> Path:
    """The study as a file."""
    path.write_text(text, encoding="utf-8")
    return path
