"""Fits of simulated logs, counted: how often the interval covers the truth, and how far the mean is from it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_cli.friction.bend import BendAngle
from tendon_cli.friction.fit import fit_readings
from tendon_cli.friction.reading.readings import Readings
from tendon_cli.friction.result import FrictionFit

from .rig import Logs, Rig, simulate


@dataclass(frozen=True)
class Coverage:
    """What many fits of one rig say together."""

    mean: float
    """Mean of the estimates over the true coefficient."""
    share: float
    """Share of the 95 % intervals that hold the true coefficient."""
    sticking_used: float
    """Largest share of rows that stick among the rows used by a fit."""


def readings_of(logs: Logs, seed: int) -> Readings:
    """One seed's log as it would be read from a file."""
    rows = len(logs.toward)
    return Readings(
        source="rig.csv",
        sha256="0" * 64,
        lines=np.arange(2, rows + 2),
        cell_1=logs.motor_cell[:, seed],
        cell_2=logs.load_cell[:, seed],
        names=("force_motor", "force_load"),
        timed=True,
        motor="1",
    )


def fit_seed(rig: Rig, logs: Logs, seed: int) -> FrictionFit:
    """The fit of one seed's log."""
    bend = BendAngle(rig.bend_angle, 0.0, f"{rig.bend_angle} rad")
    return fit_readings(readings_of(logs, seed), bend=bend)


def measure(rig: Rig, seeds: int, first_seed: int = 0) -> Coverage:
    """Fit `seeds` logs of a rig."""
    logs = simulate(rig, seeds, first_seed)
    estimates, covered, sticking = [], [], []
    for seed in range(seeds):
        fit = fit_seed(rig, logs, seed)
        low, high = fit.uncertainty.interval_95
        used = fit.rows.used
        estimates.append(fit.friction)
        covered.append(low <= rig.friction <= high)
        sticking.append(np.mean(~logs.slipping[used, seed]))
    return Coverage(float(np.mean(estimates)) / rig.friction, float(np.mean(covered)), float(np.max(sticking)))
