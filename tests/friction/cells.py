"""What a pair of load cells and their logger make of the forces on them: no mechanics, and nothing of any fit."""

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
    most: Any = np.inf  # where a cell saturates
    spikes: float | None = 0.0  # share of the rows; None draws no random numbers for faults of rows
    missing: float = 0.0  # share of the rows
    dead: bool = False  # the load's cell says nothing but noise about what it once read
    hum: float = 0.0  # of 13 Hz

    def read(
        self, motor: Floats, load: Floats, random: np.random.Generator
    ) -> tuple[Floats, Floats]:
        """Readings of both: a row per reading, and a column per rig if there are several."""
        late = _late(np.full_like(load, load[0]) if self.dead else load, self.delay * RATE)
        if self.filter:
            motor, late = (
                _lagged(force, 1.0 / (1.0 + self.filter * RATE)) for force in (motor, late)
            )
        drift = np.linspace(1.0, 1.0 + self.gain_drift, len(motor))
        motor = ((motor * self.gain[0] + self.zero[0]).T * drift).T
        return self._shown(motor, random), self._shown(late * self.gain[1] + self.zero[1], random)

    def _shown(self, force: Floats, random: np.random.Generator) -> Floats:
        """One cell, with what is random of it."""
        count, white = len(force), random.standard_normal(force.shape)
        if self.correlation:
            white[1:] *= np.sqrt(1.0 - self.correlation**2)
            white = lfilter([1.0], [1.0, -self.correlation], white, axis=0)
        force = force + (self.noise + self.relative_noise * force) * white
        if self.slow_noise:
            slow = _lagged(random.normal(size=count), 0.1)
            force = force + self.slow_noise * slow / slow.std()
        if self.hum:
            force = force + self.hum * np.sin(2 * np.pi * 13.0 * np.arange(count) / RATE)
        if self.spikes is not None:
            hit = random.random(count) < self.spikes
            force = np.where(hit, force * random.uniform(0.2, 3.0, count), force)
        force = np.minimum(force, self.most)
        force = np.round(force / self.step) * self.step if self.step else force
        return (
            force
            if self.spikes is None
            else np.where(random.random(count) < self.missing, np.nan, force)
        )


def _late(force: Floats, delay: float) -> Floats:
    """What was there `delay` rows before."""
    rows = np.arange(len(force), dtype=float)
    return np.apply_along_axis(lambda one: np.interp(rows - delay, rows, one), 0, force)


def _lagged(values: Floats, share: float) -> Floats:
    """Through a low-pass that takes so much of each new value."""
    passed, last = np.empty(len(values)), values[0]
    for row, value in enumerate(values):
        last = last + share * (value - last)
        passed[row] = last
    return passed
