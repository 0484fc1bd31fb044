"""Rows on the limit, the line through them, what the line says of the rows, and again until they agree."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tendon_cli.friction.effects import DELAY, PER_STROKE, Points, bend_groups, candidates_of
from tendon_cli.friction.limits import Strokes, on_limit
from tendon_cli.friction.models import Average, average_of
from tendon_cli.friction.reading.readings import Floats, Integers
from tendon_cli.friction.rows import noise_of, rates_of

_ROUNDS = 6
"""Rows and effects settle in two or three rounds; what has not by six goes to and fro between two like choices."""
_RATE_WINDOW = 16
"""BudgetPart of a stroke over which a rate is taken: half of a point's rows on either side."""
_LATE = 0.10
"""Of a stroke: a delay up to which a cell can be shifted and leave most of the stroke to compare."""


@dataclass(frozen=True, eq=False)
class Log:
    """Rows that can be readings, stroke after stroke: what the estimator sees."""

    motor: Floats
    load: Floats
    way: Integers
    """+1 pulled toward the motor, -1 let go toward the load."""
    bend: Floats
    stroke: Integers
    """0, 1, ... rising."""
    place: Floats
    """Along the file, from -1/2 to 1/2."""
    middle: Floats
    half: Floats
    """Per row: of the log ratio's two limits at its bend."""
    noise: Floats
    """Per row: standard deviation of the log ratio, rounding included."""
    time: Floats | None
    """None if rows are no log in order of time."""
    settled: bool

    @property
    def log_ratio(self) -> Floats:
        """ln(F_motor/F_load)."""
        return np.asarray(np.log(self.motor / self.load))

    @property
    def first(self) -> Integers:
        """First row of each stroke, and one past the last row."""
        return np.searchsorted(self.stroke, np.arange(self.stroke[-1] + 2))

    def strokes(self) -> Strokes:
        """How the rows are cut."""
        first = self.first[:-1]
        _, group = np.unique(self.way[first] * bend_groups(self.bend)[first], return_inverse=True)
        return Strokes(self.stroke, group, (self.noise / self.half)[first])


@dataclass(frozen=True, eq=False)
class Estimated:
    """What the loop ends with."""

    average: Average
    points: Points
    part: Integers
    """Point of each used row."""
    used: npt.NDArray[np.bool_]
    reached: npt.NDArray[np.bool_]
    """Per stroke."""
    shape: Floats
    """Per row: what the best model's effects add to the log ratio."""
    delay: float = 0.0
    """By which the load's cell was late and was shifted before the last fit."""


def estimate(log: Log, zero: float | None) -> Estimated | None:
    """Fit; `zero` is the stated uncertainty of the cells' zero. None if no stroke has a limit."""
    found = _settle(log, zero)
    if found is None or DELAY not in found.average.best.effects:
        return found
    delay = found.average.best.value(DELAY)[0]
    if abs(delay) > _LATE * found.points.duration:
        return found
    shifted = _shifted(log, delay)
    again = _settle(shifted, zero)
    if again is None:
        return found
    return replace(again, delay=delay, shape=again.shape + log.log_ratio - shifted.log_ratio)


def _shifted(log: Log, delay: float) -> Log:
    """With the late cell's readings at the time they are of."""
    time = np.arange(len(log.way), dtype=float) if log.time is None else log.time
    moved = np.interp(time + abs(delay), time, log.load if delay > 0.0 else log.motor)
    return replace(log, load=moved) if delay > 0.0 else replace(log, motor=moved)


def _settle(log: Log, zero: float | None) -> Estimated | None:
    """Pick rows, fit, take off what the effects do to them, and again."""
    strokes, log_ratio, rate = log.strokes(), log.log_ratio, _rate(log)
    shape, used = np.zeros(len(log_ratio)), np.zeros(len(log_ratio), dtype=bool)
    result = None
    for _ in range(1 if log.settled else _ROUNDS):
        picked, reached = ~used, np.ones(len(strokes.group), dtype=bool)
        if not log.settled:
            picked, reached = on_limit(log.way * (log_ratio - shape - log.middle) / log.half, strokes)
        if not picked.any():
            return None
        if result is not None and np.array_equal(picked, used):
            break
        used = picked
        points, part = _points(log, used, rate)
        turn = np.abs(points.log_ratio - np.median(points.log_ratio)) / np.maximum(points.bend, 1e-9)
        average = average_of(points, candidates_of(points, max(float(np.median(turn)), 1e-9), zero))
        shape = average.best.shape(log.motor, log.load, log.way, log.bend, rate, points.mean_force)
        result = Estimated(average, points, part, used, reached, shape)
    return result


def _rate(log: Log) -> Floats | None:
    """d ln F/dt of the load of each row, over a part of its stroke."""
    if log.time is None or log.settled:
        return None
    width = max(1, int(np.median(np.diff(log.first))) // _RATE_WINDOW)
    return rates_of(log.time, np.log(log.load), log.stroke, width)


def _points(log: Log, used: npt.NDArray[np.bool_], rate: Floats | None) -> tuple[Points, Integers]:
    """The used rows, each stroke cut into up to eight parts of as many rows."""
    _, stroke = np.unique(log.stroke[used], return_inverse=True)
    length = np.bincount(stroke)[stroke]
    position = np.arange(len(stroke)) - np.searchsorted(stroke, stroke)
    _, part = np.unique(stroke * PER_STROKE + position * np.minimum(PER_STROKE, length) // length, return_inverse=True)
    count = np.bincount(part)

    def mean(column: npt.NDArray[np.generic]) -> Floats:
        return np.asarray(np.bincount(part, column[used].astype(np.float64)) / count)

    of_point = np.asarray(np.bincount(part, stroke) // count, dtype=np.int64)
    duration = 1.0
    if log.time is not None:
        duration = max(float(np.median(log.time[log.first[1:] - 1] - log.time[log.first[:-1]])), 1e-300)
    noise = 0.0 if log.settled else noise_of(np.log(log.load)) / math.sqrt(float(np.median(count)))
    points = Points(
        mean(log.motor), mean(log.load), np.rint(mean(log.way)).astype(np.int64), mean(log.bend), of_point,
        None if rate is None else mean(rate), mean(log.place), duration, noise,
    )  # fmt: skip
    return points, part
