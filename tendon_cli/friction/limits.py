"""The limit of each stroke: the outermost dense plateau of its log ratio.

Between reversals the log ratio ln(F_motor/F_load) climbs, while the tendon sticks, to a limit and rests there while it
slips. Beyond the limit only noise can be, so its width is told from what lies beyond, and not from what lies inside,
where sticking, pauses and creep are. Heights are in shares of the half distance of the two limits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.friction.reading.readings import Floats, Integers

Mask = npt.NDArray[np.bool_]

_TRIGGER = 0.3
"""Of the half distance: how far past the middle the ratio turns a stroke. Noise below a tenth of it never does."""
_FINE = 0.006
"""Noise of a block over the half distance; a block is no longer than it need be, or corners blur."""
_BLOCKS, _MOST_BLOCKS = 25, 120
"""Of a stroke: at least 25, so that 8 % of them are two; more than 120 tell no more."""
_COARSE, _LEAST_BLOCKS = 0.08, 8
"""Noise of a block beyond which plateau and ramp run into each other: then a stroke may have as few as 8 blocks."""
_NOISY = 4.0
"""Times the median noise of blocks: such a block has a jump in it."""
_STARTS = (0.85, 0.92, 0.75, 0.60, 0.50)
"""Quantiles at which the limit is looked for: outside of what sticks, inside of what overshoots; then further off."""
_LEAST = 0.08
"""Of a stroke's blocks on its plateau; fewer are what noise piles up."""
_WIDE = 2.2
"""Standard deviations kept on both sides: 97 % of what slips, and little of what sticks."""
_TAIL = 0.02
"""Share of what slips that noise throws beyond the width, to where the ramp is counted."""
_FLAT, _SCATTER, _MOST_SCATTER = 0.004, 2.0, 0.12
"""A plateau is at least 0.4 % wide, as friction along a sheath varies, and as wide as the strokes scatter, up to 12
%."""
_WIDEST, _DENSE = 0.35, 3.5
"""A plateau wider than 0.35 reaches half way to the middle. A ramp is as dense inside as at its end, a sine 3.2 times
less."""
_INSIDE, _DEVIATIONS, _SHORT = 0.10, 4.0, 0.25
"""A stroke is partial if its limit lies 10 % and 4 median deviations inside the others', or its length is under a
quarter."""
_HALF = 0.5
"""Further inside than half way no limit lies, however the strokes scatter: friction does not halve from stroke to
stroke."""
_FEW = 14
"""Blocks under which a stroke's own plateau is three rows or noise; the strokes of one way are then pooled."""
_SETTLED = 3
"""Rows of a stroke in which no climb can be told from a level: they are readings of what has settled."""


def levels_of(log_ratio: Floats) -> tuple[float, float]:
    """Middle and half distance, by the outer fifths of the two sides in turn: more than half of a stroke may stick."""
    sample = log_ratio[:: max(1, len(log_ratio) // 100_000)]
    middle, half = float(np.mean(np.quantile(sample, (0.02, 0.98)))), 0.0
    for _ in range(20):
        above, below = sample[sample > middle], sample[sample <= middle]
        if not len(above) or not len(below):
            return middle, 0.0
        upper, lower = float(np.quantile(above, 0.8)), float(np.quantile(below, 0.2))
        half, before, middle = (upper - lower) / 2.0, middle, (upper + lower) / 2.0
        if middle == before:
            break
    return middle, half


def rows_of_runs(side: Integers) -> int:
    """How many rows a run has at least that nine of ten rows belong to."""
    edges = np.flatnonzero(side[1:] != side[:-1]) + 1
    rows = np.diff(np.concatenate([[0], edges, [len(side)]]))
    return int(np.quantile(np.repeat(rows, rows), 0.1, method="lower")) if len(side) else 0


def is_settled(side: Integers) -> bool:
    """Whether runs are so short that each row is a reading by itself."""
    return rows_of_runs(side) <= _SETTLED


def ways_of(log_ratio: Floats, middle: Floats | float, half: Floats | float, noise: float = 0.0) -> Integers:
    """+1 and -1 by a trigger about the middle, so that noise does not turn a stroke."""
    height = (log_ratio - middle) / half
    ways = _triggered(height)
    width = int(np.clip((noise / (0.1 * float(np.min(half)))) ** 2, 1, min(15, max(rows_of_runs(ways), 1))))
    if width == 1:
        return ways
    padded = np.pad(height, (width // 2, width - 1 - width // 2), mode="edge")
    return _triggered(np.convolve(padded, np.full(width, 1.0 / width), mode="valid"))


def _triggered(height: Floats) -> Integers:
    """The side on which each row last was beyond the trigger; the first rows are on that of those after them."""
    beyond = np.where(height > _TRIGGER, 1, np.where(height < -_TRIGGER, -1, 0))
    last = np.maximum.accumulate(np.where(beyond != 0, np.arange(len(beyond)), -1))
    return np.asarray(beyond[np.maximum(last, int(np.argmax(beyond != 0)))], dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Strokes:
    """Rows cut into strokes: numbers from 0 without gaps, rows in order of time, and what stands alike."""

    number: Integers
    group: Integers
    """Per stroke: strokes of one way at one bend angle have one number."""
    noise: Floats
    """Per stroke: of a row, in shares of the half distance, rounding included."""

    @property
    def rows(self) -> Integers:
        """Rows of each stroke."""
        return np.bincount(self.number, minlength=len(self.group))


def on_limit(height: Floats, strokes: Strokes) -> tuple[Mask, Mask]:
    """Rows on the limit of their stroke, and strokes that reach theirs.

    `height` is each row's log ratio toward its limit, in shares of the half distance.
    """
    number, size = strokes.number, strokes.rows
    place = np.arange(len(number)) - np.repeat(np.concatenate([[0], np.cumsum(size)[:-1]]), size)
    most = np.maximum(size / _BLOCKS, np.minimum((strokes.noise / _COARSE) ** 2, size / _LEAST_BLOCKS))
    wanted = np.clip((strokes.noise / _FINE) ** 2, np.maximum(size / _MOST_BLOCKS, 1.0), np.maximum(most, 1.0))
    per_block = np.asarray(wanted, dtype=np.int64)
    count = -(-size // per_block)
    block = np.repeat(np.concatenate([[0], np.cumsum(count)[:-1]]), size) + place // per_block[number]
    rows = np.bincount(block)
    mean = np.bincount(block, height) / rows
    of = np.repeat(np.arange(len(size)), count)
    quiet = _quiet(height, mean, block, rows)
    few = count < _FEW
    segment = np.where(few, len(size) + strokes.group, np.arange(len(size)))[of]
    floor = np.maximum(_FLAT, _WIDE * strokes.noise / np.sqrt(per_block))
    level, width, dense = _plateaus(mean, segment, quiet, floor[of])
    own = np.where(few, len(size) + strokes.group, np.arange(len(size)))
    scatter = np.minimum(_SCATTER * _scatter(level[own], strokes.group, few), _MOST_SCATTER)
    usual = _usual_width(width[own], strokes.group, few)
    level, width, dense = _plateaus(mean, segment, quiet, np.maximum(np.maximum(floor, scatter), usual)[of])
    long = size >= _SHORT * _usual(size)
    good = dense[own] & long & _reached(level[own], strokes.group, few | ~long)
    inside = quiet & (np.abs(mean - level[segment]) <= width[segment]) & good[of]
    ramp = quiet & (mean < (level - width)[segment]) & (mean >= (level - 2.0 * width)[segment])
    kept = _eroded(inside, of, few, np.bincount(of, ramp, minlength=len(size)))
    return np.asarray(kept[block]), np.asarray(good & (np.bincount(of[kept], minlength=len(size)) > 0))


def _quiet(height: Floats, mean: Floats, block: Integers, rows: Integers) -> Mask:
    """Blocks without a jump inside."""
    spread = np.sqrt(np.maximum(np.bincount(block, (height - mean[block]) ** 2) / rows, 0.0))
    full = rows > 3
    usual = float(np.median(spread[full])) if full.any() else 0.0
    return np.asarray((spread <= _NOISY * usual) | ~full | (usual == 0.0))


def _plateaus(mean: Floats, segment: Integers, quiet: Mask, floor: Floats) -> tuple[Floats, Floats, Mask]:
    """Height and half width of the plateau of each segment, and whether it is one."""
    size = int(segment.max()) + 1
    order = np.lexsort((mean, segment))
    order = order[quiet[order]]
    h, seg = mean[order], segment[order]
    least = np.zeros(size)
    np.maximum.at(least, segment, floor)
    last = np.searchsorted(seg, np.arange(size), "right")
    total = last - np.searchsorted(seg, np.arange(size), "left")
    level, width, done = np.full(size, np.nan), np.full(size, np.nan), total == 0
    for start in _STARTS:
        todo = ~done
        at = np.clip(last - np.maximum(1, np.round((1.0 - start) * total).astype(np.int64)), 0, max(len(h) - 1, 0))
        trial, wide = _settle(h, seg, np.where(todo, h[at], 0.0), least, last)
        share = np.bincount(seg, np.abs(h - trial[seg]) <= wide[seg], minlength=size) / np.maximum(total, 1)
        take = todo & ((share >= _LEAST) | (start == _STARTS[-1]))
        level[take], width[take], done = trial[take], wide[take], done | take
        if done.all():
            break
    found = np.isfinite(level)
    up, out = np.where(found, level, 0.0), np.where(found, width, 0.0)
    within = np.bincount(seg, np.abs(h - up[seg]) <= out[seg], minlength=size) / np.maximum(2.0 * out, 1e-12)
    below = np.bincount(seg, (h >= up[seg] - 1.2) & (h <= up[seg] - 0.3), minlength=size) / 0.9
    return up, out, np.asarray(found & (out <= _WIDEST) & (within > _DENSE * below))


def _settle(h: Floats, seg: Integers, level: Floats, least: Floats, last: Integers) -> tuple[Floats, Floats]:
    """Iterate: width from what lies beyond the level, the level as the mean within the width."""
    size, width = len(level), least
    for _ in range(30):
        above = h > level[seg]
        many = np.bincount(seg, above, minlength=size)
        half = np.clip(last - 1 - (np.maximum(many, 1).astype(np.int64) - 1) // 2, 0, len(h) - 1)
        median = np.maximum(h[half] - level, 0.0)
        beyond = np.minimum(h - level[seg], 4.0 * median[seg])
        spread = np.bincount(seg, np.where(above, beyond**2, 0.0), minlength=size) / np.maximum(many, 1)
        width = np.maximum(_WIDE * np.sqrt(spread), least)
        inside = np.abs(h - level[seg]) <= width[seg]
        count = np.bincount(seg, inside, minlength=size)
        new = np.where(
            count > 0, np.bincount(seg, np.where(inside, h, 0.0), minlength=size) / np.maximum(count, 1), level
        )
        moved, level = float(np.max(np.abs(new - level), initial=0.0)), new
        if moved < 1e-6:
            break
    return level, width


def _scatter(level: Floats, group: Integers, few: Mask) -> Floats:
    """Robust standard deviation of the limits within each group, per stroke."""
    scatter = np.zeros(len(level))
    for each in np.unique(group):
        mine = (group == each) & ~few
        if np.count_nonzero(mine) > 2:
            scatter[group == each] = 1.4826 * np.median(np.abs(level[mine] - np.median(level[mine])))
    return scatter


def _usual_width(width: Floats, group: Integers, few: Mask) -> Floats:
    """Median width of the plateaus of each group, per stroke: few blocks hardly show the noise, which all have."""
    usual = np.zeros(len(width))
    for each in np.unique(group):
        mine = (group == each) & ~few
        if mine.any():
            usual[mine] = np.median(width[mine])
    return usual


def _reached(level: Floats, group: Integers, few: Mask) -> Mask:
    """Strokes whose limit does not lie inside that of the others of their group."""
    good = np.ones(len(level), dtype=bool)
    for each in np.unique(group):
        mine = (group == each) & ~few
        if np.count_nonzero(mine) > 1:
            middle = float(np.median(level[mine]))
            away = float(np.median(np.abs(level[mine] - middle)))
            good[group == each] = level[group == each] >= middle - min(max(_INSIDE, _DEVIATIONS * away), _HALF)
    return good


def _usual(size: Integers) -> int:
    """Length of the strokes that most rows are in."""
    ordered = np.sort(size)
    return int(ordered[np.searchsorted(np.cumsum(ordered), ordered.sum() / 2.0)])


def _eroded(inside: Mask, of: Integers, few: Mask, ramp: Integers) -> Mask:
    """Without the first and last block of each stay on the plateau, in which corners are; one block out is noise.

    Noise keeps some of the ramp up to the limit, and of the fall from it. A ramp has as many blocks in one width as in
    the
    next, `ramp`, so that many are dropped at the ends of a stroke, half at each.
    """
    same = of[1:] == of[:-1]
    ahead, behind = np.append(inside[1:] & same, False), np.append(False, inside[:-1] & same)
    closed = inside | (ahead & behind)
    ahead, behind = np.append(closed[1:] & same, False), np.append(False, closed[:-1] & same)
    kept = np.asarray(closed & ((ahead & behind) | few[of]))
    many = np.bincount(of[kept], minlength=len(few))
    drop = np.minimum(np.ceil(0.5 * (ramp - _TAIL * many)), many // 4)[of]
    rank = np.cumsum(kept) - 1
    first = np.concatenate([[0], np.cumsum(many)[:-1]])[of]
    return np.asarray(kept & ((few[of]) | ((rank - first >= drop) & (first + many[of] - 1 - rank >= drop))))
