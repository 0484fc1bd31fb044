"""The limit of each stroke: the outermost dense plateau of its log ratio.

Between reversals the log ratio ln(F_motor/F_load) climbs, while the tendon sticks, to a limit and rests there while it
slips. Beyond the limit only noise can be, so its width comes from what lies beyond, and not from what lies inside,
where sticking, pauses and creep are. Heights are in shares of the half distance of the two limits.
"""

from __future__ import annotations

import numpy as np

from tendon_cli.friction.log import Log, bend_groups
from tendon_cli.friction.reading.readings import Floats, Integers, Mask

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
    mean, of = np.bincount(block, height) / np.bincount(block), np.repeat(np.arange(len(size)), count)
    floor = np.maximum(_FLAT, _WIDE * noise / np.sqrt(length))
    width = _plateaus(mean, of, floor)[1]
    level, width, dense = _plateaus(mean, of, np.maximum(floor, _median(width, group)))
    by_size = np.sort(size)
    long = size >= _SHORT * by_size[np.searchsorted(np.cumsum(by_size), size.sum() / 2.0)]
    usual = _median(np.where(long, level, np.nan), group)
    away = np.abs(np.where(long, level, np.nan) - usual)
    good = dense & long & (level >= usual - np.clip(_DEVIATIONS * _median(away, group), _INSIDE, _FURTHEST))
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
        width = np.maximum(_WIDE * np.sqrt(np.bincount(seg, np.where(above, beyond**2, 0.0)) / many), floor)
        inside = np.abs(h - level[seg]) <= width[seg]
        count = np.bincount(seg, inside)
        before, level = level, np.where(count > 0, np.bincount(seg, inside * h) / np.maximum(count, 1), level)
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
