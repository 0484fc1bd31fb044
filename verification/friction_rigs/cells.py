"""Readings that a pair of load cells and their logger make of the forces on them.

Nothing here knows the mechanics of a sheath or how readings are fitted.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.signal import lfilter

Floats = npt.NDArray[np.float64]

RATE = 50.0
"""Readings a second."""


@dataclass(frozen=True)
class Cells:
    """The cells at the motor and at the load; forces in any one unit."""

    noise: float = 0.05  # standard deviation of a reading
    relative_noise: float = 0.0  # the same over the force, beside `noise`
    correlation: float = 0.0  # of the noise of two successive rows
    slow_noise: float = 0.0  # standard deviation of more noise, which lasts a fifth of a second
    gain: tuple[float, float] = (1.0, 1.0)
    gain_drift: float = 0.0  # of the motor's cell over the log, as a share
    zero: tuple[float, float] = (0.0, 0.0)
    delay: float = 0.0  # of the load's cell, s
    filter: float = 0.0  # time constant of the low-pass of both cells, s
    step: float = 0.0  # of the converter
    most: Any = np.inf  # force at which a cell saturates
    spikes: float | None = 0.0  # share of the rows; None draws no random numbers for faults of rows
    missing: float = 0.0  # share of the rows
    dead: bool = False  # the load's cell reads its first force and noise, whatever pulls on it
    hum: float = 0.0  # amplitude at 13 Hz

    def read(
        self, motor: Floats, load: Floats, random: np.random.Generator
    ) -> tuple[Floats, Floats]:
        """Return readings of both: a row per reading, and a column per rig if there are several."""
        if self.dead:
            load = np.full_like(load, load[0])
        load = _delayed(load, self.delay * RATE)
        if self.filter:
            share = 1.0 / (1.0 + self.filter * RATE)
            motor = _low_passed(motor, share)
            load = _low_passed(load, share)
        drift = np.linspace(1.0, 1.0 + self.gain_drift, len(motor))
        motor = ((motor * self.gain[0] + self.zero[0]).T * drift).T
        load = load * self.gain[1] + self.zero[1]
        motor_readings = self._with_faults(motor, random)
        load_readings = self._with_faults(load, random)
        return motor_readings, load_readings

    def _with_faults(self, force: Floats, random: np.random.Generator) -> Floats:
        """Return the readings of one cell, with all that is random in them."""
        count = len(force)
        white = random.standard_normal(force.shape)
        if self.correlation:
            white[1:] *= np.sqrt(1.0 - self.correlation**2)
            white = lfilter([1.0], [1.0, -self.correlation], white, axis=0)
        force = force + (self.noise + self.relative_noise * force) * white
        if self.slow_noise:
            slow = _low_passed(random.normal(size=count), 0.1)
            force = force + self.slow_noise * slow / slow.std()
        if self.hum:
            force = force + self.hum * np.sin(2 * np.pi * 13.0 * np.arange(count) / RATE)
        if self.spikes is not None:
            is_spike = random.random(count) < self.spikes
            force = np.where(is_spike, force * random.uniform(0.2, 3.0, count), force)
        force = np.minimum(force, self.most)
        if self.step:
            force = np.round(force / self.step) * self.step
        if self.spikes is not None:
            is_missing = random.random(count) < self.missing
            force = np.where(is_missing, np.nan, force)
        return force


def _delayed(force: Floats, delay: float) -> Floats:
    """Return the forces of `delay` rows before."""
    rows = np.arange(len(force), dtype=float)
    return np.apply_along_axis(lambda column: np.interp(rows - delay, rows, column), 0, force)


def _low_passed(values: Floats, share: float) -> Floats:
    """Return the values after a low-pass that takes this share of every new value."""
    passed = np.empty(len(values))
    last = values[0]
    for row, value in enumerate(values):
        last = last + share * (value - last)
        passed[row] = last
    return passed
