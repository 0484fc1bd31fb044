"""Rows on the limit, the line through them, what the line says of the rows, and again until they agree."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from tendon_cli.friction.effects import DELAY, PER_STROKE, Forces, Points
from tendon_cli.friction.models import Average, average_of
from tendon_cli.friction.plateaus import Log, on_limit
from tendon_cli.friction.reading.readings import Floats, Mask
from tendon_cli.friction.rows import noise_of, rates_of

_ROUNDS = 6
"""Rows and effects settle in two or three rounds; what has not by six goes to and fro between two like choices."""
_RATE_WINDOW = 16
"""Part of a stroke over which a rate is taken: half of a point's rows on either side."""
_LATE = 0.10
"""Of a stroke: a delay up to which a cell can be shifted and leave most of the stroke to compare."""


@dataclass(frozen=True, eq=False)
class Estimated:
    """What the loop ends with."""

    average: Average
    points: Points
    used: Mask
    reached: Mask
    """Per stroke."""
    shape: Floats
    """Per row: what the best model's effects add to the log ratio."""
    delay: float = 0.0
    """By which the load's cell was late and was shifted before the last fit."""

    @property
    def friction(self) -> float:
        """μ."""
        return self.average.friction


def estimate(log: Log, zero: float | None) -> Estimated | None:
    """Fit; `zero` is the stated uncertainty of the cells' zero. None if no stroke has a limit."""
    first = _settle(log, zero)
    if first is None or DELAY not in first.average.best.effects:
        return first
    delay = first.average.best.value(DELAY)[0]
    if abs(delay) > _LATE * first.points.duration:
        return first
    # The late cell's readings at the time they are of.
    time = np.arange(len(log.way), dtype=float) if log.time is None else log.time
    moved = np.interp(time + abs(delay), time, log.load if delay > 0.0 else log.motor)
    shifted = replace(log, load=moved) if delay > 0.0 else replace(log, motor=moved)
    again = _settle(shifted, zero)
    if again is None:
        return first
    return replace(again, delay=delay, shape=again.shape + log.log_ratio - shifted.log_ratio)


def _settle(log: Log, zero: float | None) -> Estimated | None:
    """Pick rows, fit, take off what the effects do to them, and again."""
    rate = None
    if log.time is not None:
        width = max(1, int(np.median(np.diff(log.first))) // _RATE_WINDOW)
        rate = rates_of(log.time, np.log(log.load), log.stroke, width)
    shape, result = np.zeros(len(log.way)), None
    for _ in range(1 if log.settled else _ROUNDS):
        used, reached = np.ones(len(log.way), dtype=bool), np.ones(int(log.stroke[-1]) + 1, dtype=bool)
        if not log.settled:
            used, reached = on_limit(log, shape)
        if not used.any():
            return None
        if result is not None and np.array_equal(used, result.used):
            break
        points = _points(log, used, rate)
        average = average_of(points, points.priors(zero))
        shape = average.best.shape(Forces(log.motor, log.load, log.way, log.bend, rate, points.mean_force))
        result = Estimated(average, points, used, reached, shape)
    return result


def _points(log: Log, used: Mask, rate: Floats | None) -> Points:
    """The used rows, each stroke cut into up to eight parts of as many rows."""
    _, stroke = np.unique(log.stroke[used], return_inverse=True)
    length = np.bincount(stroke)[stroke]
    position = np.arange(len(stroke)) - np.searchsorted(stroke, stroke)
    _, part = np.unique(stroke * PER_STROKE + position * np.minimum(PER_STROKE, length) // length, return_inverse=True)
    count = np.bincount(part)
    columns = [log.motor, log.load, log.way, log.bend, log.place, *([] if rate is None else [rate])]
    motor, load, way, bend, place, *rates = [np.bincount(part, column[used]) / count for column in columns]
    duration = 1.0
    if log.time is not None:
        duration = max(float(np.median(log.time[log.first[1:] - 1] - log.time[log.first[:-1]])), 1e-300)
    noise = 0.0 if log.settled else noise_of(np.log(log.load)) / math.sqrt(float(np.median(count)))
    return Points(
        motor, load, np.rint(way).astype(np.int64), bend, rates[0] if rates else None, float(np.mean(np.log(load))),
        np.bincount(part, stroke).astype(np.int64) // count, place, duration, noise,
    )  # fmt: skip


def climbing(log: Log, result: Estimated) -> float:
    """How far the ratio surely climbs on the limit, the motor's cell alone, over a stroke: 0 in slip, 1 in stick."""
    from scipy.special import stdtrit

    points = result.points
    count = np.bincount(points.stroke)
    full = count >= 4
    if log.settled or np.count_nonzero(full) < 2:
        return 0.0
    every, kept = np.bincount(log.stroke), np.bincount(log.stroke[result.used], minlength=int(log.stroke[-1]) + 1)
    stretch = (every / np.maximum(kept, 1))[kept > 0][full] / 0.75
    at = np.arange(len(points.stroke)) - np.searchsorted(points.stroke, points.stroke)
    ends = [(at >= (0.75 * count)[points.stroke]), (at < (0.25 * count)[points.stroke])]

    def change(column: Floats) -> Floats:
        late, early = (np.bincount(points.stroke, column * end) / np.bincount(points.stroke, end) for end in ends)
        return np.asarray((late - early)[full])

    height = 2.0 * max(abs(result.friction) * float(np.mean(points.bend)), 1e-12)
    climbs = change(points.way * points.log_ratio) * stretch / height
    steps = [float(np.mean(np.abs(change(np.log(cell))))) for cell in (points.motor, points.load)]
    alone = 1.0 - min(steps) / max(steps) if max(steps) > 0.0 else 0.0
    error = float(np.std(climbs, ddof=1)) / math.sqrt(len(climbs)) * float(stdtrit(len(climbs) - 1, 0.975))
    return max(0.0, float(np.mean(climbs)) - error) * max(0.0, 2.0 * alone - 1.0)
