"""Slip told from stick in a raw log, stroke by stroke.

After a reversal the tendon sticks first, piece by piece from the motor on, and the log ratio of the forces moves from
one limit, +μφ, to the other, -μφ. Only on the limit does the whole tendon slip. The move ends with a corner and not
smoothly, so each stroke is described by a rise and a level with a corner between them, and rows are kept by where they
stand in the stroke, never by their own value: choosing rows by their value would choose their noise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_cli.friction.corner import find_corner
from tendon_cli.friction.reading.readings import Floats, Integers

NOT_YET = "not yet slipping (before the first full stroke)"
STICKING = "sticking after a reversal"
TURNING = "turning (next to a reversal)"
PARTIAL = "sticking, slip was not reached in this stroke"
TOO_SHORT = "too few slipping rows in the stroke"

_WIDEST = 501
_FEWEST_IN_STROKE = 8
_OUTER = 0.5
"""A stroke's rows lie beyond this share of the way from the middle to the limit."""
_MARGIN = 0.3
"""Share of the rise that is left out after the corner, since the corner itself is found from noisy rows."""


@dataclass(frozen=True, eq=False)
class Strokes:
    """What each row of a log is."""

    stroke: Integers
    """Number of the slipping stroke, from 0; -1 for a row that is set aside."""
    side: Integers
    """+1 on the upper limit of the log ratio, -1 on the lower, 0 for a row that is set aside."""
    reasons: tuple[str, ...]
    """Why a row is set aside, "" for one that is used."""
    one_sided: bool
    """Whether the log may show one direction only: no return to a limit was seen, and the levels lie unevenly."""


def separate(log_ratio: Floats) -> Strokes:
    """Strokes of one block of rows in order of time, at one bend angle, all finite."""
    size = len(log_ratio)
    smooth, noise = _smooth(log_ratio)
    middle, half = _levels(smooth)
    side = np.zeros(size, dtype=np.int64)
    if half > 3.0 * noise:
        side[smooth > middle + _OUTER * half] = 1
        side[smooth < middle - _OUTER * half] = -1
    else:
        side[:] = 1
    runs = _runs(side)
    kept = [_trim(log_ratio, smooth, first, last, way, half, noise) for first, last, way in runs]
    levels = np.array([np.median(log_ratio[a:b]) if b > a else np.nan for a, b in kept])
    return _assemble(size, runs, kept, levels, middle, half)


def _smooth(log_ratio: Floats) -> tuple[Floats, float]:
    """A running median wide enough for the noise, and the noise that is left in it."""
    from scipy.ndimage import median_filter

    size = len(log_ratio)
    steps = np.diff(log_ratio)
    noise = 1.4826 * float(np.median(np.abs(steps - np.median(steps)))) / np.sqrt(2.0) if size > 1 else 0.0
    noise = max(noise, float(np.std(steps)) / 10.0 if size > 1 else 0.0)
    low, high = np.quantile(log_ratio, (0.02, 0.98))
    wanted = (noise / max(0.03 * (high - low), 1e-12)) ** 2
    width = int(np.clip(2 * round(wanted / 2.0) + 1, 5, min(max(5, size // 60 * 2 + 1), _WIDEST)))
    return median_filter(log_ratio, size=width, mode="nearest"), 1.25 * noise / np.sqrt(width)


def _levels(smooth: Floats) -> tuple[float, float]:
    """Middle and half distance of the two levels, by the outer quartiles of the two sides in turn.

    Outer quartiles and not medians, so that the level is met even where more than half of a stroke sticks.
    """
    middle = float(np.mean(np.quantile(smooth, (0.02, 0.98))))
    half = 0.0
    for _ in range(20):
        above, below = smooth[smooth > middle], smooth[smooth <= middle]
        if not len(above) or not len(below):
            return middle, 0.0
        upper, lower = float(np.quantile(above, 0.75)), float(np.quantile(below, 0.25))
        half = (upper - lower) / 2.0
        if (upper + lower) / 2.0 == middle:
            break
        middle = (upper + lower) / 2.0
    return middle, half


def _runs(side: Integers) -> list[tuple[int, int, int]]:
    """First row, row after the last, and side of each run of rows on one side."""
    edges = np.flatnonzero(np.diff(side)) + 1
    starts = np.concatenate([[0], edges])
    ends = np.concatenate([edges, [len(side)]])
    return [(int(a), int(b), int(side[a])) for a, b in zip(starts, ends, strict=True) if side[a] != 0]


def _trim(
    log_ratio: Floats, smooth: Floats, first: int, last: int, way: int, half: float, noise: float
) -> tuple[int, int]:
    """The slipping rows of one run: from the corner where the rise ends to the one where the next reversal begins."""
    if last - first < _FEWEST_IN_STROKE:
        return first, first
    height = way * log_ratio[first:last]
    level = float(np.median(height[len(height) // 3 :]))
    step = max(0.15 * half, min(4.0 * noise, 0.3 * half))
    begin, end = 0, len(height)
    if level - way * smooth[last - 1] > step:
        end -= find_corner(height[::-1][: len(height) // 2 + 1])
        end -= 2 + (len(height) - end) // 2
    if level - way * smooth[first] > step and end > 4:
        begin = find_corner(height[:end])
        # The run begins at three quarters of the rise (half way from the middle to the limit): in a tendon that lets
        # go piece by piece, 0.56 of the time has then passed.
        begin += 2 + int(np.ceil(_MARGIN * begin / 0.44))
    return (first + begin, first + end) if end - begin >= _FEWEST_IN_STROKE else (first, first)


def _assemble(
    size: int,
    runs: list[tuple[int, int, int]],
    kept: list[tuple[int, int]],
    levels: Floats,
    middle: float,
    half: float,
) -> Strokes:
    stroke = np.full(size, -1, dtype=np.int64)
    side = np.zeros(size, dtype=np.int64)
    reasons = np.full(size, NOT_YET, dtype=object)
    ways = np.array([way for *_, way in runs])
    typical = {way: float(np.nanmedian(levels[ways == way])) if np.any(np.isfinite(levels[ways == way])) else np.nan
               for way in (1, -1)}  # fmt: skip
    number = 0
    for (first, last, way), (begin, end), level in zip(runs, kept, levels, strict=True):
        # Rows from here on follow a stroke; those that slip again are named by the runs to come.
        reasons[first:last] = STICKING if number else NOT_YET
        if begin == end:
            reasons[first:last] = TOO_SHORT
            continue
        if way * (typical[way] - level) > 0.2 * half:
            reasons[first:last] = PARTIAL
            continue
        reasons[end:] = STICKING
        reasons[end:last] = TURNING
        reasons[begin:end] = ""
        stroke[begin:end] = number
        side[begin:end] = way
        number += 1
    sides = side[np.flatnonzero(np.diff(stroke, prepend=-1) * (stroke >= 0))]
    turns = int(np.count_nonzero(np.diff(sides)))
    one_sided = turns < 2 and (half == 0.0 or abs(middle) > 0.5 * half or turns == 0)
    return Strokes(stroke, side, tuple(reasons), one_sided)
