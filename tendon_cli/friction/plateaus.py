"""A log cut into strokes, and the limit of each stroke: the outermost dense plateau of its log ratio.

Between reversals the log ratio ln(F_motor/F_load) climbs, while the tendon sticks, to a limit and rests there while it
slips. Beyond the limit only noise can be, so its width comes from what lies beyond, and not from what lies inside,
where sticking, pauses and creep are. Heights are in shares of the half distance of the two limits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_cli.friction.reading.readings import Floats, Integers, Mask

SAME_BEND = 0.02
"""Bend angles that differ by less are one: nobody measures them better."""
_BLOCK_NOISE = 0.006
"""Noise of a block over the half distance; a block is no longer than it need be, or corners blur."""
_BLOCKS, _MOST_BLOCKS = 25, 120
"""Of a stroke: at least 25, so that 8 % of them are two; more than 120 show no more."""
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
"""A plateau is at least 0.4 % wide, as friction along a sheath varies, and as wide as the strokes scatter, to 12 %."""
_WIDEST, _DENSE = 0.35, 3.5
"""A plateau wider than 0.35 reaches half way to the middle. A ramp is as dense inside as at its end, a sine 3.2 times
less."""
_INSIDE, _DEVIATIONS, _FURTHEST, _SHORT = 0.10, 4.0, 0.5, 0.25
"""A stroke is partial if its limit lies 10 % and 4 median deviations inside the others', or half way whatever they are
(friction does not halve from stroke to stroke), or if it is under a quarter as long as usual."""
_FEW = 14
"""Blocks under which a stroke's plateau is three rows or noise; the strokes of one way are then pooled."""


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
    """Per row: middle and half distance of the log ratio's two limits at its bend."""
    noise: Floats
    """Per row: standard deviation of the log ratio, rounding included."""
    steps: tuple[float, float]
    """Resolution of the motor's and of the load's cell."""
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


def bend_groups(bend: Floats) -> Integers:
    """A number from 1 for each angle, the same for angles that are one."""
    values, place = np.unique(bend, return_inverse=True)
    steps = np.diff(values, prepend=values[:1]) > SAME_BEND * values
    return np.asarray(1 + np.cumsum(steps), dtype=np.int64)[place]


def on_limit(log: Log, shape: Floats) -> tuple[Mask, Mask]:
    """Rows on the limit of their stroke, and strokes that reach theirs; `shape` is what effects add to log ratios."""
    height = log.way * (log.log_ratio - shape - log.middle) / log.half
    first, size = log.first[:-1], np.diff(log.first)
    group = np.unique(log.way[first] * bend_groups(log.bend)[first], return_inverse=True)[1]
    noise = (log.noise / log.half)[first]
    # Blocks of rows, as long as their noise asks for and no longer than leaves enough of them.
    most = np.maximum(size / _BLOCKS, np.minimum((noise / _COARSE) ** 2, size / _LEAST_BLOCKS))
    wanted = np.clip((noise / _BLOCK_NOISE) ** 2, np.maximum(size / _MOST_BLOCKS, 1.0), np.maximum(most, 1.0))
    length = wanted.astype(np.int64)
    count = -(-size // length)
    place = np.arange(len(height)) - np.repeat(first, size)
    block = np.repeat(np.cumsum(count) - count, size) + place // length[log.stroke]
    rows = np.bincount(block)
    mean = np.bincount(block, height) / rows
    quiet = _quiet(height, mean, block, rows)
    # Strokes of few blocks are pooled by way and bend.
    few, of = count < _FEW, np.repeat(np.arange(len(size)), count)
    pool = np.where(few, len(size) + group, np.arange(len(size)))
    segment, floor = pool[of], np.maximum(_FLAT, _WIDE * noise / np.sqrt(length))
    level, width, dense = _plateaus(mean, segment, quiet, floor[of])
    away = np.abs(level[pool] - _median(level[pool], group, ~few))
    scatter = np.minimum(_SCATTER * 1.4826 * _median(away, group, ~few), _MOST_SCATTER)
    floor = np.maximum.reduce([floor, scatter, _median(width[pool], group, ~few)])
    level, width, dense = _plateaus(mean, segment, quiet, floor[of])
    by_size = np.sort(size)
    long = size >= _SHORT * by_size[np.searchsorted(np.cumsum(by_size), size.sum() / 2.0)]
    whole, height_of = ~few & long, level[pool]
    usual = _median(height_of, group, whole)
    inside = np.clip(_DEVIATIONS * _median(np.abs(height_of - usual), group, whole), _INSIDE, _FURTHEST)
    several = np.bincount(group, whole)[group] > 1
    good = dense[pool] & long & (~several | (height_of >= usual - inside))
    flat = quiet & (np.abs(mean - level[segment]) <= width[segment]) & good[of]
    ramp = quiet & (mean < (level - width)[segment]) & (mean >= (level - 2.0 * width)[segment])
    kept = _eroded(flat, of, few, np.bincount(of, ramp, minlength=len(size)))
    return kept[block], np.asarray(good & (np.bincount(of[kept], minlength=len(size)) > 0))


def _median(values: Floats, group: Integers, counted: Mask) -> Floats:
    """Per stroke: the median over those of its group that count; 0 if none does."""
    medians = np.zeros(int(group.max()) + 1)
    for each in np.unique(group[counted]):
        medians[each] = np.median(values[counted & (group == each)])
    return medians[group]


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
    level, width, done = np.zeros(size), np.zeros(size), total == 0
    for start in _STARTS:
        at = np.clip(last - np.maximum(1, np.round((1.0 - start) * total).astype(np.int64)), 0, max(len(h) - 1, 0))
        trial, wide = _settle(h, seg, np.where(done, 0.0, h[at]), least, last)
        share = np.bincount(seg, np.abs(h - trial[seg]) <= wide[seg], minlength=size) / np.maximum(total, 1)
        take = ~done & ((share >= _LEAST) | (start == _STARTS[-1]))
        level[take], width[take], done = trial[take], wide[take], done | take
        if done.all():
            break
    within = np.bincount(seg, np.abs(h - level[seg]) <= width[seg], minlength=size) / np.maximum(2.0 * width, 1e-12)
    below = np.bincount(seg, (h >= level[seg] - 1.2) & (h <= level[seg] - 0.3), minlength=size) / 0.9
    return level, width, np.asarray((total > 0) & (width <= _WIDEST) & (within > _DENSE * below))


def _settle(h: Floats, seg: Integers, level: Floats, least: Floats, last: Integers) -> tuple[Floats, Floats]:
    """Iterate: width from what lies beyond the level, the level as the mean within the width."""
    size, width = len(level), least
    for _ in range(30):
        above = h > level[seg]
        many = np.maximum(np.bincount(seg[above], minlength=size), 1)
        half = np.clip(last - 1 - (many - 1) // 2, 0, len(h) - 1)
        median = np.maximum(h[half] - level, 0.0)
        beyond = np.minimum(h - level[seg], 4.0 * median[seg])
        spread = np.bincount(seg, np.where(above, beyond**2, 0.0), minlength=size) / many
        width = np.maximum(_WIDE * np.sqrt(spread), least)
        inside = np.abs(h - level[seg]) <= width[seg]
        count = np.bincount(seg, inside, minlength=size)
        mean = np.bincount(seg, np.where(inside, h, 0.0), minlength=size) / np.maximum(count, 1)
        before, level = level, np.where(count > 0, mean, level)
        if np.max(np.abs(level - before), initial=0.0) < 1e-6:
            break
    return level, width


def _eroded(inside: Mask, of: Integers, few: Mask, ramp: Integers) -> Mask:
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
    kept = np.asarray(closed & ((ahead & behind) | few[of]))
    many = np.bincount(of[kept], minlength=len(few))
    drop = np.minimum(np.ceil(0.5 * (ramp - _TAIL * many)), many // 4)[of]
    rank = np.cumsum(kept) - 1
    first = (np.cumsum(many) - many)[of]
    return np.asarray(kept & (few[of] | ((rank - first >= drop) & (first + many[of] - 1 - rank >= drop))))
