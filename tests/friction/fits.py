"""Fits of simulated logs, as they would be read from a file."""

from __future__ import annotations

import numpy as np

from tendon_cli.friction.bend import BendAngle
from tendon_cli.friction.fit import fit_readings
from tendon_cli.friction.reading.readings import Readings
from tendon_cli.friction.result import Fit

from .rig import Logs, Rig


def readings_of(logs: Logs, seed: int, part: slice = slice(None)) -> Readings:
    """One seed's log as it would be read from a file."""
    rows = len(logs.toward[part])
    return Readings(
        source="rig.csv",
        sha256="0" * 64,
        lines=np.arange(2, rows + 2),
        cell_1=logs.motor_cell[part, seed],
        cell_2=logs.load_cell[part, seed],
        names=("force_motor", "force_load"),
        time=0.02 * np.arange(rows),
        motor="1",
    )


def fit_seed(rig: Rig, logs: Logs, seed: int) -> Fit:
    """The fit of one seed's log."""
    bend = BendAngle(rig.bend_angle, 0.0, f"{rig.bend_angle} rad")
    return fit_readings(readings_of(logs, seed), bend=bend)
