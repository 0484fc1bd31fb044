"""Rows on the limit, the line through them, what the line says of the rows, and again until they agree."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from tendon_cli.friction.effects import DELAY, priors_of
from tendon_cli.friction.log import Log
from tendon_cli.friction.models import Average, average_of
from tendon_cli.friction.plateaus import on_limit
from tendon_cli.friction.reading.readings import Floats, Mask
from tendon_cli.friction.rows import rates_of

_ROUNDS = 6
"""Rows and effects settle in two or three rounds; what has not by six goes to and fro between two like choices."""
_PER_STROKE = 8
"""Points of a stroke: enough for the force within it to show, few enough that neighbouring rows are one."""
_RATE_WINDOW = 16
"""Part of a stroke over which a rate is taken: half of a point's rows on either side."""
_LATE = 0.10
"""Of a stroke: a delay up to which a cell can be shifted and leave most of the stroke to compare."""

_CLIMBS, _NEVER_RESTS = 0.02, 0.10
"""Of the way from limit to limit, over a whole stroke: what climbs by more has not settled, or has no limit at all."""
_FEW_ROWS, _SOME_ROWS = 0.10, 0.25
"""Shares of rows on a limit: under a tenth do not answer for the others; under a quarter may be the turn of a crank."""


@dataclass(frozen=True, eq=False)
class Estimated:
    """What the loop ends with."""

    average: Average
    points: Log
    """Means over parts of strokes, on the limit."""
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
    if abs(delay) > _LATE * log.duration:
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
    if log.time is not None:
        width = max(1, int(np.median(np.diff(log.first))) // _RATE_WINDOW)
        log = replace(log, rate=rates_of(log.time, np.log(log.load), log.stroke, width))
    shape, result = np.zeros(len(log.way)), None
    used, reached = np.ones(len(log.way), dtype=bool), np.ones(log.strokes, dtype=bool)
    for _ in range(1 if log.settled else _ROUNDS):
        if not log.settled:
            used, reached = on_limit(log, shape)
        if not used.any():
            return None
        if result is not None and np.array_equal(used, result.used):
            break
        points = _points(log.taken(used))
        average = average_of(points, priors_of(points, log.duration, zero))
        shape = average.best.shape(log)
        result = Estimated(average, points, used, reached, shape)
    return result


def _points(log: Log) -> Log:
    """Each stroke as the means of up to eight parts of as many rows."""
    size = np.diff(log.first)[log.stroke]
    position = np.arange(len(size)) - log.first[log.stroke]
    part = log.stroke * _PER_STROKE + position * np.minimum(_PER_STROKE, size) // size
    return log.means(np.unique(part, return_inverse=True)[1])


def climbing(log: Log, result: Estimated) -> float:
    """How far the ratio surely climbs over a whole stroke on the limit, of its way: 0 in slip, 1 in stick."""
    from scipy.special import stdtrit

    points, stroke = result.points, result.points.stroke
    count = np.bincount(stroke)
    full = count >= 4
    if log.settled or np.count_nonzero(full) < 2:
        return 0.0
    along = (np.arange(len(stroke)) - points.first[stroke]) / count[stroke]
    late, early = along >= 0.75, along < 0.25

    def change(column: Floats) -> Floats:
        ends = (np.bincount(stroke, column * end) / np.maximum(np.bincount(stroke, end), 1) for end in (late, early))
        return np.asarray(np.subtract(*ends)[full])

    every, kept = np.bincount(log.stroke), np.bincount(log.stroke[result.used], minlength=log.strokes)
    stretch = (every / np.maximum(kept, 1))[kept > 0][full] / 0.75
    climbs = change(points.way * points.log_ratio) * stretch / (2.0 * result.friction * float(np.mean(points.bend)))
    steps = [float(np.mean(np.abs(change(np.log(cell))))) for cell in (points.motor, points.load)]
    alone = 1.0 - min(steps) / max(*steps, 1e-300)  # in stick the load's cell rests, in slip both move
    error = float(np.std(climbs, ddof=1)) / math.sqrt(len(climbs)) * float(stdtrit(len(climbs) - 1, 0.975))
    return max(0.0, float(np.mean(climbs)) - error) * max(0.0, 2.0 * alone - 1.0)


def never_rests(log: Log, result: Estimated) -> str | None:
    """Why there is no limit at all; None if there is one."""
    if log.settled:
        return None
    share, climb = float(np.mean(result.used)), climbing(log, result)
    if climb > _NEVER_RESTS or (climb > _CLIMBS and share < _SOME_ROWS):
        return "no stroke slips: the force ratio still moves where each of them ends"
    if share < _FEW_ROWS:
        return f"only {result.used.sum()} of {len(log.way)} rows slip, which is too few to answer for the others"
    return None
