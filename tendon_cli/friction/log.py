"""A log: rows that can be readings, stroke after stroke, or means over parts of strokes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tendon_cli.friction.reading.readings import Floats, Integers, Mask

_SAME_BEND = 0.02
"""Bend angles that differ by less are one: nobody measures them better."""


@dataclass(frozen=True, eq=False)
class Log:
    """What the estimator sees of a file; a value per row."""

    motor: Floats
    load: Floats
    way: Integers
    """+1 pulled toward the motor, -1 let go toward the load."""
    bend: Floats
    stroke: Integers
    """0, 1, ... rising, without gaps."""
    place: Floats
    """Along the file, from -1/2 to 1/2."""
    middle: Floats
    half: Floats
    """Middle and half distance of the log ratio's two limits at the bend of the row."""
    noise: Floats
    """Standard deviation of the log ratio, rounding included."""
    steps: tuple[float, float]
    """Resolution of the motor's and of the load's cell."""
    time: Floats | None
    """None if rows are no log in order of time."""
    settled: bool
    mean_force: float
    """Mean of ln F at the load, from which a power of the force counts."""
    rate: Floats | None = None
    """d ln F/dt."""

    @property
    def log_ratio(self) -> Floats:
        """ln(F_motor/F_load)."""
        return np.asarray(np.log(self.motor / self.load))

    @property
    def first(self) -> Integers:
        """First row of each stroke, and one past the last row."""
        return np.searchsorted(self.stroke, np.arange(self.stroke[-1] + 2))

    @property
    def strokes(self) -> int:
        """How many."""
        return int(self.stroke[-1]) + 1

    @property
    def duration(self) -> float:
        """Of a usual stroke, in the unit of the time; 1 without one."""
        if self.time is None:
            return 1.0
        return max(float(np.median(self.time[self.first[1:] - 1] - self.time[self.first[:-1]])), 1e-300)

    @property
    def both_ways(self) -> bool:
        """Whether gain and friction can be separated."""
        return len(np.unique(self.way[self.bend > 0.0])) == 2

    def taken(self, rows: Mask) -> Log:
        """Some of the rows, their strokes counted anew."""
        columns = self._columns()
        columns = {name: column[rows] for name, column in columns.items()}
        columns["stroke"] = np.unique(columns["stroke"], return_inverse=True)[1]
        return replace(self, **columns)

    def means(self, part: Integers) -> Log:
        """Means over the parts 0, 1, ... of strokes; noise becomes that of a mean."""
        count = np.bincount(part)
        columns: dict[str, Any] = {name: np.bincount(part, column) / count for name, column in self._columns().items()}
        columns["noise"] /= np.sqrt(count)
        columns |= {name: np.rint(columns[name]).astype(np.int64) for name in ("way", "stroke")}
        return replace(self, **columns)

    def _columns(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if isinstance(value, np.ndarray)}


def bend_groups(bend: Floats) -> Integers:
    """A number from 1 for each angle, the same for angles that are one."""
    values, place = np.unique(bend, return_inverse=True)
    steps = np.diff(values, prepend=values[:1]) > _SAME_BEND * values
    return np.asarray(1 + np.cumsum(steps), dtype=np.int64)[place]
