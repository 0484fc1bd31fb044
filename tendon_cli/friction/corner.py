"""Where in one run of rows the tendon slips: from the corner at which the ratio stops rising to the next reversal.

The rise ends with a corner and not smoothly. A motor that pauses on the way holds the ratio up where it is; it goes on
from there when the motor does, so the corner is the end of the last rise.
"""

from __future__ import annotations

import numpy as np

from tendon_cli.friction.reading.readings import Floats

_MARGIN = 0.3
"""Share of the rise that is left out after the corner, since the corner itself is found from noisy rows."""
FEWEST_FOR_CORNER = 16
_STEEP = 0.33
"""A rise goes on where the ratio climbs by at least this share of the fastest climb."""
_BINS = 96
_FEWEST_FOR_STEP, _CLEAR = 12, 5.0
"""Rows in which a step can be told, and its least height in standard deviations of what is left."""
LONG = 5
"""Rows of a run of which the first may have been on its way."""


def trimmed(
    log_ratio: Floats, smooth: Floats, run: tuple[int, int, int], half: float, noise: float, left: float
) -> tuple[int, int]:
    """The slipping rows of one run: from the corner where the rise ends to the one where the next reversal begins."""
    first, last, way = run
    height = way * log_ratio[first:last]
    if len(height) < FEWEST_FOR_CORNER:
        return _trim_short(height, first, half, noise)
    level = float(np.median(height[len(height) // 3 :]))
    step = max(0.15 * half, min(4.0 * left, 0.3 * half))
    begin, end = 0, len(height)
    if level - way * smooth[last - 1] > step:
        end -= _corner(height[::-1][: len(height) // 2 + 1])
        end -= 2 + (len(height) - end) // 2
    if level - way * smooth[first] > step and end > 4:
        start, corner = _last_rise(height[:end], noise)
        # A tendon that lets go bit by bit has the share h of its rise behind it after h² of the time. A run begins at
        # three quarters of the rise, half way from the middle to the limit; after a pause it goes on from where it was.
        behind = 0.75 if start == 0 else 1.0 - (level - way * smooth[first + start]) / (2.0 * half)
        margin = int(np.ceil(_MARGIN * (corner - start) / max(1.0 - behind**2, 0.1)))
        begin = corner + 2 + min(margin, (end - corner) // 2)
        begin += _last_step(height[begin:end], 0.015 * half)
    fewest = min(FEWEST_FOR_CORNER // 2, len(height) // 4)
    return (first + begin, first + end) if end - begin >= fewest else (first, first)


def _last_rise(height: Floats, noise: float) -> tuple[int, int]:
    """Where the last rise of a run starts, 0 but after a pause of the motor, and the corner at its end."""
    corner = _corner(height)
    wide = max(len(height) // 16, 2)
    total = np.concatenate([[0.0], np.cumsum(height)])
    mean = (total[wide:] - total[:-wide]) / wide
    steps = mean[wide:] - mean[:-wide]
    if not len(steps):
        return 0, corner
    steep = np.concatenate([[0], np.flatnonzero(steps > _STEEP * np.max(steps)) + wide])
    for at in np.flatnonzero(np.diff(steep) > 1.5 * wide)[::-1]:
        rests, goes_on = height[steep[at] : steep[at + 1]], height[steep[-1] + wide // 2 :]
        clear = 6.0 * noise * np.sqrt(1.0 / len(rests) + 1.0 / max(len(goes_on), 1))
        if len(goes_on) >= wide and np.mean(goes_on) - np.mean(rests) > clear:
            start = max(int(steep[at + 1]) - wide // 2, 0)
            return start, start + _corner(height[start:])
    return 0, corner


def _trim_short(height: Floats, first: int, half: float, noise: float) -> tuple[int, int]:
    """The same where a corner cannot be fitted: rows at either end that lie well inside the level."""
    level = float(np.median(height[len(height) // 3 :]))
    near = np.flatnonzero(height >= level - max(3.0 * noise, 0.03 * half, 1e-12))
    begin, end = first + int(near[0]), first + int(near[-1]) + 1
    # The first of many may have been on its way.
    return (begin + 1, end) if end - begin >= LONG else (begin, end)


def _last_step(height: Floats, least: float) -> int:
    """Row after which rows that rested just below the limit, in a pause, have got there; 0 where they had been.

    A step up is told from a level that slopes, and from noise, by what it explains beyond a straight line.
    """
    t, y, straight = _binned(height)
    if len(t) < _FEWEST_FOR_STEP:
        return 0
    steps = np.tri(len(t), len(t) - 4, -2)[:, 1:]
    steps -= straight @ (straight.T @ steps)
    size = np.sum(steps**2, axis=0)
    along = steps.T @ y
    best = int(np.argmax(along * np.abs(along) / size))
    explained = along[best] ** 2 / size[best]
    left = y - straight @ (straight.T @ y) - steps[:, best] * along[best] / size[best]
    alike = float(np.clip(left[1:] @ left[:-1] / max(left @ left, 1e-300), 0.0, 0.9))
    noise = (left @ left) / (len(t) - 3) * (1.0 + alike) / (1.0 - alike)
    if along[best] / size[best] < least or explained < _CLEAR**2 * noise:
        return 0
    return int(np.ceil(t[best + 3])) + 1


def _corner(height: Floats) -> int:
    """Row at which a rise turns into a level; 0 where the rows do not bend that way.

    Two straight lines that meet are fitted by least squares, for each meeting point on a grid at once: what a bend at
    one point explains beyond one straight line is its projection.
    """
    t, y, straight = _binned(height)
    if len(t) < 4:
        return 0
    bends = np.maximum(t[:, None] - t[None, 1:-1], 0.0)
    bends -= straight @ (straight.T @ bends)
    along = bends.T @ y
    # Only a bend downward, from a rise to a level, is a corner of this kind.
    explained = np.where(along < 0.0, along**2 / np.maximum(np.sum(bends**2, axis=0), 1e-300), 0.0)
    best = int(np.argmax(explained))
    return int(np.ceil(t[best + 1])) + 1 if explained[best] > 0.0 else 0


def _binned(height: Floats) -> tuple[Floats, Floats, Floats]:
    """Places and means of rows in bins, and an orthonormal basis of straight lines through them."""
    bins = min(_BINS, len(height))
    edges = np.linspace(0, len(height), bins + 1).astype(np.int64)
    t = (edges[:-1] + edges[1:] - 1) / 2.0
    straight, _ = np.linalg.qr(np.stack([np.ones(bins), t], axis=1))
    return t, np.add.reduceat(height, edges[:-1]) / np.diff(edges) if bins else height, straight
