"""The fit of the limits: select rows on a limit, fit the line through them, correct, and repeat.

Between reversals the log ratio ln(F_motor/F_load) climbs, while the tendon sticks, to a limit and
rests there while it slips: the limit is the outermost dense plateau. Beyond it only noise can be,
so its width comes from what lies beyond, and not from what lies inside, where sticking, pauses and
creep are. Heights are in shares of the half distance of the two limits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from tendon_cli.fits.friction.effects import DELAY, priors_of
from tendon_cli.fits.friction.models import ModelAverage, average_of
from tendon_cli.fits.friction.usable_rows import Log, bend_groups, rates_of
from tendon_cli.fits.log_rows import Floats, Integers, Mask, noise_of

_BLOCK_NOISE = 0.006
"""Noise of a block over the half distance; longer blocks than it asks for would blur corners."""
_BLOCKS = 25
"""Least number of blocks of a stroke, so that a plateau is several."""
_MOST_BLOCKS = 120
"""Largest number of blocks of a stroke: more of them show no more."""
_COARSE = 0.08
"""Noise of a block beyond which plateau and ramp run into each other."""
_LEAST_BLOCKS = 8
"""Least number of blocks of a stroke whose blocks are as noisy as `_COARSE`."""
_START = 0.85
"""Quantile where the search for the limit begins: outside of what sticks, inside of overshoots."""
_WIDE = 2.2
"""Standard deviations kept on both sides: 97 % of what slips, and little of what sticks."""
_TAIL = 0.02
"""Share of what slips that noise throws beyond the width, to where the ramp is counted."""
_FLAT = 0.004
"""Least width of a plateau: friction along a sheath varies by 0.4 %."""
_WIDEST = 0.35
"""Largest width of a plateau: a wider one reaches half way to the middle."""
_DENSE = 3.5
"""Density of a plateau over that of the rows inside of it. A ramp is as dense inside as at its end,
a sine 3.2 times less."""
_INSIDE = 0.10
"""Least distance by which the limit of a partial stroke lies inside the others'."""
_DEVIATIONS = 4.0
"""The same in median deviations of the strokes' limits; both must be exceeded."""
_FURTHEST = 0.5
"""Distance from which a stroke is partial whatever the deviations are: friction does not halve from
stroke to stroke."""
_SHORT = 0.25
"""Share of the usual length under which a stroke is partial."""
_ROUNDS = 6
"""Largest number of rounds: rows and effects settle in two or three; what has not settled by six
alternates between two equally good choices."""
_PER_STROKE = 8
"""Points of a stroke: enough for the force within it to show, few enough that each
averages neighbouring rows."""
_RATE_WINDOWS = (16, 8, 4)
"""Parts of a stroke over which a rate is taken: half of a point's rows on either side, or more."""
_RATE_NOISE = 0.2
"""Noise of a rate over its spread, from which a longer part is taken: noise of what a line is drawn
over passes for no delay at all."""
_CERTAIN = 0.9
"""Probability of a delay from which a cell is shifted: an explanation that looks the same as a
delay would be lost."""
_LATE = 0.10
"""Delay, as a share of a stroke, up to which a cell can be shifted and leave most of the stroke to
compare."""
_CLIMBS = 0.02
"""Climb over a whole stroke, as a share of the way from limit to limit, from which rows have not
settled."""
_NEVER_RESTS = 0.10
"""The same climb from which there is no limit at all."""
_FEW_ROWS = 0.10
"""Share of rows on a limit under which they do not represent the others."""
_SOME_ROWS = 0.25
"""Share of rows on a limit under which they may be the turn of a crank."""


@dataclass(frozen=True, eq=False)
class FrictionEstimate:
    """Estimate of μ from a log, and the rows and points that it is fitted to."""

    average: ModelAverage
    """Fitted models, and their mean."""
    points: Log
    """Means over parts of strokes."""
    used: Mask
    """True for each row that the line goes through."""
    reached: Mask
    """True for each stroke that reached its limit."""
    shape: Floats
    """Part of the log ratio that the best model's effects add in each row."""
    delay: float = 0.0
    """Delay of the load's cell, in the unit of the time, that was taken out before the last fit."""
    delay_error: float = 0.0
    """Standard error of μ from that of this delay."""

    @property
    def friction(self) -> float:
        """μ."""
        return self.average.friction


def estimate(log: Log, zero: float | None) -> FrictionEstimate | None:
    """Fit a log; if one cell is late, shift its readings in time and fit again.

    Args:
        log: Usable rows of the file.
        zero: Stated standard uncertainty of the cells' zero, in the unit of the file; None if it is
            not stated.

    Returns:
        The estimate; None if no stroke has a limit.
    """
    first = _settle(log, zero)
    if first is None or first.average.share_of(DELAY) < _CERTAIN:
        return first
    delay = first.average.best.value(DELAY)[0]
    if log.time is None or abs(delay) > _LATE * log.duration:
        return first
    # Each reading of the late cell is moved to the time at which its force acted.
    measured = log.time + abs(delay)
    if delay > 0.0:
        shifted = replace(log, load=np.interp(measured, log.time, log.load))
    else:
        shifted = replace(log, motor=np.interp(measured, log.time, log.motor))
    again = _settle(shifted, zero)
    if again is None:
        return first
    shape = again.shape + log.log_ratio - shifted.log_ratio
    error = first.average.best.error_from(DELAY)
    return replace(again, delay=delay, delay_error=error, shape=shape)


def _settle(log: Log, zero: float | None) -> FrictionEstimate | None:
    """Select rows on a limit, fit, subtract the effects, and repeat until the selection settles."""
    log = _with_rates(log)
    shape = np.zeros(len(log.way))
    used = np.ones(len(log.way), dtype=bool)
    reached = np.ones(log.strokes, dtype=bool)
    result: FrictionEstimate | None = None
    rounds = 1 if log.settled else _ROUNDS
    for _ in range(rounds):
        if not log.settled:
            used, reached = on_limit(log, shape)
        if not used.any():
            return None
        if result is not None and np.array_equal(used, result.used):
            break
        points = _points(_with_rates_of_slip(log, used).select(used))
        average = average_of(points, priors_of(points, log.duration, zero))
        shape = average.best.shape(log)
        result = FrictionEstimate(average, points, used, reached, shape)
    return result


def _with_rates(log: Log) -> Log:
    """Return the log with the rate of its load within each stroke, if it has a time."""
    if log.time is None:
        return log
    rows = int(np.median(np.diff(log.first)))
    log_force = np.log(log.load)
    noise = noise_of(log_force, log.stroke) / max(np.median(np.diff(log.time)), 1e-300)
    rate = np.zeros(len(log.time))
    for part in _RATE_WINDOWS:
        width = max(1, rows // part)
        rate = rates_of(log.time, log_force, log.stroke, width)
        of_rate = noise * math.sqrt(2.0 / width) / (width + 1.0)
        spread = min(np.std(rate[log.way == way]) for way in np.unique(log.way))
        if of_rate <= _RATE_NOISE * spread:
            break
    return replace(log, rate=rate)


def _with_rates_of_slip(log: Log, used: Mask) -> Log:
    """Return the log with rates that look back no further than the first used row of a stroke.

    While the tendon sticks the load's cell rests, and a rate across both is of neither.
    """
    if log.rate is None:
        return log
    used_so_far = np.cumsum(used)
    before: Integers = (used_so_far - used)[log.first[:-1]]
    slips = used_so_far > before[log.stroke]
    rate = log.rate.copy()
    rate[slips] = _with_rates(log.select(slips)).rate
    return replace(log, rate=rate)


def _points(log: Log) -> Log:
    """Divide each stroke into up to eight equal parts, and return the means over them."""
    size = np.diff(log.first)[log.stroke]
    position = np.arange(len(size)) - log.first[log.stroke]
    part = log.stroke * _PER_STROKE + position * np.minimum(_PER_STROKE, size) // size
    return log.means(np.unique(part, return_inverse=True)[1])


def on_limit(log: Log, shape: Floats) -> tuple[Mask, Mask]:
    """Select the rows on the limit of their stroke, and the strokes that reach theirs.

    Args:
        log: Usable rows of the file.
        shape: Part of the log ratio that effects of the rig add in each row.

    Returns:
        True for each row on its limit, and True for each stroke that reaches its limit.
    """
    height = log.way * (log.log_ratio - shape - log.middle) / log.half
    first = log.first[:-1]
    size = np.diff(log.first)
    group = np.unique(log.way[first] * bend_groups(log.bend)[first], return_inverse=True)[1]
    noise = (log.noise / log.half)[first]

    # Blocks of rows, as long as their noise asks for and no longer than leaves enough of them.
    most = np.maximum(size / _BLOCKS, np.minimum((noise / _COARSE) ** 2, size / _LEAST_BLOCKS))
    wanted = np.clip((noise / _BLOCK_NOISE) ** 2, size / _MOST_BLOCKS, most)
    length = np.maximum(wanted, 1.0).astype(np.int64)
    count = -(-size // length)
    place = np.arange(len(height)) - np.repeat(first, size)
    block = np.repeat(np.cumsum(count) - count, size) + place // length[log.stroke]
    mean = np.bincount(block, height) / np.bincount(block)
    stroke = np.repeat(np.arange(len(size)), count)  # of each block

    # A second look with the usual width of the strokes at one limit.
    floor = np.maximum(_FLAT, _WIDE * noise / np.sqrt(length))
    width = _plateaus(mean, stroke, floor)[1]
    floor = np.maximum(floor, _group_medians(width, group))
    level, width, is_dense = _plateaus(mean, stroke, floor)

    # Strokes that are long enough, and whose limit is that of the others.
    by_size = np.sort(size)
    usual_size = by_size[np.searchsorted(np.cumsum(by_size), size.sum() / 2.0)]
    is_long = size >= _SHORT * usual_size
    long_level = np.where(is_long, level, np.nan)
    usual = _group_medians(long_level, group)
    deviation = _group_medians(np.abs(long_level - usual), group)
    inside = np.clip(_DEVIATIONS * deviation, _INSIDE, _FURTHEST)
    is_whole = is_dense & is_long & (level >= usual - inside)

    on_plateau = np.abs(mean - level[stroke]) <= width[stroke]
    is_ramp = (mean < (level - width)[stroke]) & (mean >= (level - 2.0 * width)[stroke])
    ramp = np.bincount(stroke, is_ramp)
    selected = _eroded(on_plateau & is_whole[stroke], stroke, ramp)
    has_blocks = np.bincount(stroke[selected], minlength=len(size)) > 0
    return selected[block], is_whole & has_blocks


def _group_medians(values: Floats, group: Integers) -> Floats:
    """Return the median of each stroke's group, without NaN; 0 if all its values are NaN."""
    medians = np.zeros(int(group.max()) + 1)
    for number in np.unique(group[~np.isnan(values)]):
        medians[number] = np.nanmedian(values[group == number])
    return medians[group]


def _plateaus(mean: Floats, stroke: Integers, floor: Floats) -> tuple[Floats, Floats, Mask]:
    """Find the plateau of each stroke.

    Args:
        mean: Height of each block.
        stroke: Stroke of each block.
        floor: Least half width of the plateau of each stroke.

    Returns:
        Height and half width of the plateau of each stroke, and True if it is dense and narrow
        enough to be one.
    """
    order = np.lexsort((mean, stroke))
    mean = mean[order]
    stroke = stroke[order]
    strokes = len(floor)
    last = np.searchsorted(stroke, np.arange(strokes), "right")
    total = np.bincount(stroke)
    outer = np.maximum(1, np.round((1.0 - _START) * total).astype(np.int64))
    level = mean[last - outer]
    width = floor
    for _ in range(30):
        above = mean > level[stroke]
        count_above = np.maximum(np.bincount(stroke[above], minlength=strokes), 1)
        median = np.maximum(mean[last - 1 - (count_above - 1) // 2] - level, 0.0)
        beyond = np.minimum(mean - level[stroke], 4.0 * median[stroke])
        squares = np.bincount(stroke, np.where(above, beyond**2, 0.0))
        width = np.maximum(_WIDE * np.sqrt(squares / count_above), floor)
        inside = np.abs(mean - level[stroke]) <= width[stroke]
        count = np.bincount(stroke, inside)
        mean_inside = np.bincount(stroke, inside * mean) / np.maximum(count, 1)
        before = level
        level = np.where(count > 0, mean_inside, level)
        if np.max(np.abs(level - before)) < 1e-6:
            break
    on_plateau = np.abs(mean - level[stroke]) <= width[stroke]
    density = np.bincount(stroke, on_plateau) / (2.0 * width)
    is_below = (mean >= level[stroke] - 1.2) & (mean <= level[stroke] - 0.3)
    density_below = np.bincount(stroke, is_below) / 0.9
    return level, width, (width <= _WIDEST) & (density > _DENSE * density_below)


def _eroded(inside: Mask, stroke: Integers, ramp: Integers) -> Mask:
    """Drop the first and last block of each stay on the plateau, which may hold its corners.

    One block that lies outside between two inside is noise. Noise also keeps some of the ramp up to
    the limit, and of the fall from it. A ramp has as many blocks in one width as in the next,
    `ramp`, so this number is dropped in each stroke, half at each end.
    """
    is_same = stroke[1:] == stroke[:-1]

    def neighbours(blocks: Mask) -> tuple[Mask, Mask]:
        """Return the mask of the next block, and that of the one before, of the same stroke."""
        ahead = np.append(blocks[1:] & is_same, False)
        behind = np.append(False, blocks[:-1] & is_same)
        return ahead, behind

    ahead, behind = neighbours(inside)
    closed = inside | (ahead & behind)
    ahead, behind = neighbours(closed)
    core = closed & ahead & behind
    count = np.bincount(stroke[core], minlength=len(ramp))
    drop = np.minimum(np.ceil(0.5 * (ramp - _TAIL * count)), count // 4)[stroke]
    before = np.cumsum(core) - 1 - (np.cumsum(count) - count)[stroke]
    after = count[stroke] - 1 - before
    return core & (before >= drop) & (after >= drop)


def climbing(log: Log, result: FrictionEstimate) -> float:
    """Return the climb of the log ratio on the limit, over a whole stroke.

    It is a share of the way from limit to limit: 0 in slip, 1 in stick. It is the lower end of the
    95 % interval, less if both cells move, as they do in slip.
    """
    from scipy.special import stdtrit

    points = result.points
    stroke = points.stroke
    count = np.bincount(stroke)
    is_full = count >= 4
    if log.settled or np.count_nonzero(is_full) < 2:
        return 0.0
    along = (np.arange(len(stroke)) - points.first[stroke]) / count[stroke]
    is_late = along >= 0.75
    is_early = along < 0.25

    def quarter_mean(column: Floats, quarter: Mask) -> Floats:
        """Mean of a column over a quarter of each stroke."""
        total = np.bincount(stroke, column * quarter)
        return total / np.maximum(np.bincount(stroke, quarter), 1)

    def change(column: Floats) -> Floats:
        """Change of a column from the first to the last quarter of each full stroke."""
        return (quarter_mean(column, is_late) - quarter_mean(column, is_early))[is_full]

    rows = np.bincount(log.stroke)
    used = np.bincount(log.stroke[result.used], minlength=log.strokes)
    stretch = (rows / np.maximum(used, 1))[used > 0][is_full] / 0.75
    distance = 2.0 * result.friction * np.mean(points.bend)  # from limit to limit
    climbs = change(points.way * points.log_ratio) * stretch / distance

    # In stick the load's cell rests, in slip both move.
    steps = [float(np.mean(np.abs(change(np.log(cell))))) for cell in (points.motor, points.load)]
    alone = 1.0 - min(steps) / max(*steps, 1e-300)
    standard_error = float(np.std(climbs, ddof=1)) / math.sqrt(len(climbs))
    error = standard_error * float(stdtrit(len(climbs) - 1, 0.975))
    return max(0.0, float(np.mean(climbs)) - error) * max(0.0, 2.0 * alone - 1.0)


def why_no_limit(log: Log, result: FrictionEstimate) -> str | None:
    """Return the reason why the ratio has no limit at all; None if it has one."""
    if log.settled:
        return None
    share = np.mean(result.used)
    climb = climbing(log, result)
    if climb > _NEVER_RESTS or (climb > _CLIMBS and share < _SOME_ROWS):
        return "no stroke slips: the force ratio is still moving at the end of each"
    if share < _FEW_ROWS:
        return (
            f"only {result.used.sum()} of {len(log.way)} rows slip,"
            " which is too few to represent the others"
        )
    return None
