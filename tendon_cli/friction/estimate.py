"""Rows on the limit, the line through them, what the line says of the rows, and again until they agree.

Between reversals the log ratio ln(F_motor/F_load) climbs, while the tendon sticks, to a limit and rests there while it
slips: the limit is the outermost dense plateau. Beyond it only noise can be, so its width comes from what lies beyond,
and not from what lies inside, where sticking, pauses and creep are. Heights are in shares of the half distance of the
two limits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from tendon_cli.friction.effects import DELAY, priors_of
from tendon_cli.friction.models import Average, average_of
from tendon_cli.friction.reading.readings import Floats, Integers, Mask
from tendon_cli.friction.usable_rows import Log, bend_groups, rates_of

_BLOCK_NOISE = 0.006
"""Noise of a block over the half distance; a block is no longer than it need be, or corners blur."""
_BLOCKS, _MOST_BLOCKS = 25, 120
"""Of a stroke: at least 25, so that a plateau is several; more than 120 show no more."""
_COARSE, _LEAST_BLOCKS = 0.08, 8
"""Noise of a block beyond which plateau and ramp run into each other: then a stroke may have as few as 8 blocks."""
_START = 0.85
"""Quantile at which the limit is looked for: outside of what sticks, inside of what overshoots."""
_WIDE = 2.2
"""Standard deviations kept on both sides: 97 % of what slips, and little of what sticks."""
_TAIL = 0.02
"""Share of what slips that noise throws beyond the width, to where the ramp is counted."""
_FLAT = 0.004
"""A plateau is at least 0.4 % wide, as friction along a sheath varies."""
_WIDEST, _DENSE = 0.35, 3.5
"""A plateau wider than 0.35 reaches half way to the middle. A ramp is as dense inside as at its end, a sine 3.2 times
less."""
_INSIDE, _DEVIATIONS, _FURTHEST, _SHORT = 0.10, 4.0, 0.5, 0.25
"""A stroke is partial if its limit lies 10 % and 4 median deviations inside the others', or half way whatever they are
(friction does not halve from stroke to stroke), or if it is under a quarter as long as usual."""
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
    """What the loop ends with: rows used, strokes that reached their limit, and `points`, means over parts of strokes.

    `shape` is per row what the best model's effects add to the log ratio, `delay` by how much the load's cell was late
    and was shifted before the last fit.
    """

    average: Average
    points: Log
    used: Mask
    reached: Mask
    shape: Floats
    delay: float = 0.0

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
    if log.time is None or abs(delay) > _LATE * log.duration:
        return first
    # The late cell's readings at the time they are of.
    moved = np.interp(log.time + abs(delay), log.time, log.load if delay > 0.0 else log.motor)
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
        points = _points(log.select(used))
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


def on_limit(log: Log, shape: Floats) -> tuple[Mask, Mask]:
    """Rows on the limit of their stroke, and strokes that reach theirs; `shape` is what effects add to log ratios."""
    height = log.way * (log.log_ratio - shape - log.middle) / log.half
    first, size = log.first[:-1], np.diff(log.first)
    group = np.unique(log.way[first] * bend_groups(log.bend)[first], return_inverse=True)[1]
    noise = (log.noise / log.half)[first]
    # Blocks of rows, as long as their noise asks for and no longer than leaves enough of them.
    most = np.maximum(size / _BLOCKS, np.minimum((noise / _COARSE) ** 2, size / _LEAST_BLOCKS))
    wanted = np.clip((noise / _BLOCK_NOISE) ** 2, size / _MOST_BLOCKS, most)
    length = np.maximum(wanted, 1.0).astype(np.int64)
    count = -(-size // length)
    place = np.arange(len(height)) - np.repeat(first, size)
    block = np.repeat(np.cumsum(count) - count, size) + place // length[log.stroke]
    mean, of = (
        np.bincount(block, height) / np.bincount(block),
        np.repeat(np.arange(len(size)), count),
    )
    floor = np.maximum(_FLAT, _WIDE * noise / np.sqrt(length))
    width = _plateaus(mean, of, floor)[1]
    level, width, dense = _plateaus(mean, of, np.maximum(floor, _median(width, group)))
    by_size = np.sort(size)
    long = size >= _SHORT * by_size[np.searchsorted(np.cumsum(by_size), size.sum() / 2.0)]
    usual = _median(np.where(long, level, np.nan), group)
    away = np.abs(np.where(long, level, np.nan) - usual)
    good = (
        dense
        & long
        & (level >= usual - np.clip(_DEVIATIONS * _median(away, group), _INSIDE, _FURTHEST))
    )
    ramp = (mean < (level - width)[of]) & (mean >= (level - 2.0 * width)[of])
    kept = _eroded((np.abs(mean - level[of]) <= width[of]) & good[of], of, np.bincount(of, ramp))
    return kept[block], np.asarray(good & (np.bincount(of[kept], minlength=len(size)) > 0))


def _median(values: Floats, group: Integers) -> Floats:
    """Per stroke: the median over its group; NaN do not count, and 0 if all are."""
    medians = np.zeros(int(group.max()) + 1)
    for each in np.unique(group[~np.isnan(values)]):
        medians[each] = np.nanmedian(values[group == each])
    return medians[group]


def _plateaus(mean: Floats, of: Integers, floor: Floats) -> tuple[Floats, Floats, Mask]:
    """Height and half width of the plateau of each stroke, and whether it is one; its width is `floor` at least."""
    order = np.lexsort((mean, of))
    h, seg, size = mean[order], of[order], len(floor)
    last = np.searchsorted(seg, np.arange(size), "right")
    total = np.bincount(seg)
    level, width = h[last - np.maximum(1, np.round((1.0 - _START) * total).astype(np.int64))], floor
    for _ in range(30):
        above = h > level[seg]
        many = np.maximum(np.bincount(seg[above], minlength=size), 1)
        median = np.maximum(h[last - 1 - (many - 1) // 2] - level, 0.0)
        beyond = np.minimum(h - level[seg], 4.0 * median[seg])
        width = np.maximum(
            _WIDE * np.sqrt(np.bincount(seg, np.where(above, beyond**2, 0.0)) / many), floor
        )
        inside = np.abs(h - level[seg]) <= width[seg]
        count = np.bincount(seg, inside)
        before, level = (
            level,
            np.where(count > 0, np.bincount(seg, inside * h) / np.maximum(count, 1), level),
        )
        if np.max(np.abs(level - before)) < 1e-6:
            break
    within = np.bincount(seg, np.abs(h - level[seg]) <= width[seg]) / (2.0 * width)
    below = np.bincount(seg, (h >= level[seg] - 1.2) & (h <= level[seg] - 0.3)) / 0.9
    return level, width, (width <= _WIDEST) & (within > _DENSE * below)


def _eroded(inside: Mask, of: Integers, ramp: Integers) -> Mask:
    """Without the first and last block of each stay on the plateau, in which corners are; one block out is noise.

    Noise keeps some of the ramp up to the limit, and of the fall from it. A ramp has as many blocks in one width as in
    the next, `ramp`, so that many are dropped at the ends of a stroke, half at each.
    """
    same = of[1:] == of[:-1]

    def neighbours(kept: Mask) -> tuple[Mask, Mask]:
        return np.append(kept[1:] & same, False), np.append(False, kept[:-1] & same)

    ahead, behind = neighbours(inside)
    closed = inside | (ahead & behind)
    ahead, behind = neighbours(closed)
    kept = np.asarray(closed & ahead & behind)
    many = np.bincount(of[kept], minlength=len(ramp))
    drop = np.minimum(np.ceil(0.5 * (ramp - _TAIL * many)), many // 4)[of]
    before = np.cumsum(kept) - 1 - (np.cumsum(many) - many)[of]
    return np.asarray(kept & (before >= drop) & (many[of] - 1 - before >= drop))


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
        ends = (
            np.bincount(stroke, column * end) / np.maximum(np.bincount(stroke, end), 1)
            for end in (late, early)
        )
        return np.asarray(np.subtract(*ends)[full])

    every, kept = (
        np.bincount(log.stroke),
        np.bincount(log.stroke[result.used], minlength=log.strokes),
    )
    stretch = (every / np.maximum(kept, 1))[kept > 0][full] / 0.75
    climbs = (
        change(points.way * points.log_ratio)
        * stretch
        / (2.0 * result.friction * float(np.mean(points.bend)))
    )
    steps = [float(np.mean(np.abs(change(np.log(cell))))) for cell in (points.motor, points.load)]
    alone = 1.0 - min(steps) / max(
        *steps, 1e-300
    )  # in stick the load's cell rests, in slip both move
    error = (
        float(np.std(climbs, ddof=1))
        / math.sqrt(len(climbs))
        * float(stdtrit(len(climbs) - 1, 0.975))
    )
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
