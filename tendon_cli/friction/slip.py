"""Slip told from stick in rows of two cells, by what the forces do.

After a reversal the tendon sticks first, bit by bit from the motor on: the motor's cell moves alone, and the log ratio
of the forces goes from one limit, +μφ, to the other, -μφ. Only on the limit does the whole tendon slip. The move ends
with a corner and not smoothly, so each stroke is a rise and a level with a corner between them, and rows are kept by
where they stand in the stroke: choosing rows by their own value would choose their noise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.friction.levels import levels_of, noise_of, smoothed
from tendon_cli.friction.reading.readings import Floats, Integers

NOT_YET = "not yet slipping (before the first full stroke)"
STICKING = "sticking after a reversal"
TURNING = "turning (next to a reversal)"
PARTIAL = "sticking, slip was not reached in this stroke"
INSIDE = "inside both limits (at rest or sticking within a stroke)"

_OUTER = 0.5
"""A stroke's rows lie beyond this share of the way from the middle to the limit."""
_MARGIN = 0.3
"""Share of the rise that is left out after the corner, since the corner itself is found from noisy rows."""
_FEWEST_FOR_CORNER = 16
_PAUSED = 0.4
"""Where less than this share of a run is left, the motor may have paused on the way."""
_BINS = 96
_LONG, _STRAY = 5, 0.3
"""Where runs have several rows, one with less than this share of the usual number is what is left of another."""


@dataclass(frozen=True, eq=False)
class Slip:
    """What each row of a block is."""

    run: Integers
    """Number of the run of slipping rows, from 0; -1 for a row that is set aside."""
    side: Integers
    """+1 on the upper limit of the log ratio, -1 on the lower, 0 for a row that is set aside."""
    reasons: npt.NDArray[np.object_]
    """Why a row is set aside, "" for one that is used."""
    one_sided: bool
    """Whether the rows may show one direction only: no return to a limit was seen, and the levels lie unevenly."""
    moving: float
    """How far the ratio still moves, the motor's cell alone, where it should rest: 0 in slip, 0.5 in stick.

    In shares of the way from limit to limit, over one stroke; NaN where no rise was found.
    """
    against: npt.NDArray[np.bool_]
    """Rows on the limit of the other direction than the file gives them."""


def separate(
    log_ratio: Floats, forces: tuple[Floats, Floats], named: Integers | None, border: Integers, step: float
) -> Slip:
    """Slip of one block of rows in order of time, at one bend angle.

    `named` has the side that the file gives each row, `border` a number that changes where a stroke must end, `step` is
    the resolution of the log ratio.
    """
    size = len(log_ratio)
    noise = max(noise_of(log_ratio), step / np.sqrt(12.0))
    smooth, left, width = smoothed(log_ratio, noise)
    middle, half = levels_of(smooth)
    one_name = named is not None and len(set(named) - {0}) < 2
    way_of = np.zeros(size, dtype=np.int64) if one_name else _sides(smooth, middle, half, left)
    if not np.any(way_of):  # the noise hides the limits: all rows are of one direction, or as the file says
        side = np.full(size, 1 if middle > 0.0 else -1) if named is None else named
    else:
        side = way_of if named is None else np.where(way_of == named, way_of, 0)
    runs = _runs(side, border, 2 * width + 1 if width > 1 else 0)
    kept = [_trim(log_ratio, smooth, run, half, noise, left) for run in runs]
    levels = np.array([np.median(log_ratio[a:b]) if b > a else np.nan for a, b in kept])
    number, reasons = np.full(size, -1, dtype=np.int64), np.full(size, NOT_YET, dtype=object)
    found = {way: [level for level, run in zip(levels, runs, strict=True) if run[2] == way and np.isfinite(level)]
             for way in (1, -1)}  # fmt: skip
    typical = {way: float(np.median(mine)) if mine else np.nan for way, mine in found.items()}
    usual = float(np.median([b - a for a, b in kept if b > a] or [0]))
    count, before = 0, (0, 0)
    for (first, last, way), (begin, end), level in zip(runs, kept, levels, strict=True):
        reasons[first:last] = STICKING if count else NOT_YET
        if (
            begin == end
            or (usual >= _LONG and end - begin < _STRAY * usual)
            or way * (typical[way] - level) > max(0.2 * half, 4.0 * noise)
        ):
            reasons[first:last] = PARTIAL
            continue
        reasons[end:] = STICKING
        reasons[end:last] = TURNING
        reasons[begin:end] = ""
        # A pause within a stroke does not make two of it.
        count += int(before != (way, int(border[begin])))
        before = way, int(border[begin])
        number[begin:end] = count - 1
    side = np.where(number >= 0, side, 0)
    sides = np.array([way for (_, _, way), (begin, end) in zip(runs, kept, strict=True) if end > begin])
    turns = int(np.count_nonzero(np.diff(sides)))
    one_sided = turns < 2 and (half == 0.0 or abs(middle) > 0.5 * half or turns == 0)
    against = np.zeros(size, dtype=bool) if named is None else way_of * named < 0
    return Slip(number, side, reasons, one_sided, _still_moving(log_ratio, forces, runs, kept, half), against)


def _sides(smooth: Floats, middle: float, half: float, noise: float) -> Integers:
    """+1 and -1 beyond half the way to a limit, 0 between and where noise hides the limits."""
    side = np.zeros(len(smooth), dtype=np.int64)
    if half > 3.0 * noise:
        side[smooth > middle + _OUTER * half] = 1
        side[smooth < middle - _OUTER * half] = -1
    return side


def _runs(side: Integers, border: Integers, gap: int) -> list[tuple[int, int, int]]:
    """First row, row after the last, and side of each run of rows on one side, over gaps that noise makes."""
    edges = np.flatnonzero((np.diff(side) != 0) | (np.diff(border) != 0)) + 1
    starts = np.concatenate([[0], edges])
    ends = np.concatenate([edges, [len(side)]])
    runs: list[tuple[int, int, int]] = []
    for first, last in zip(starts, ends, strict=True):
        run = (int(first), int(last), int(side[first]))
        if run[2] == 0:
            continue
        if runs and runs[-1][2] == run[2] and first - runs[-1][1] <= gap and border[first] == border[runs[-1][0]]:
            run = (runs.pop()[0], *run[1:])
        runs.append(run)
    sides = {(int(border[first]), side) for first, _, side in runs}
    # What a stroke begins with on the other limit, going on from the stroke before, is not yet its own slip.
    return [
        run for before, run in zip([(0, -1, 0), *runs], runs, strict=False)
        if (before[1:], (int(border[run[0]]), -run[2]) in sides) != ((run[0], run[2]), True)
    ]  # fmt: skip


def _trim(
    log_ratio: Floats, smooth: Floats, run: tuple[int, int, int], half: float, noise: float, left: float
) -> tuple[int, int]:
    """The slipping rows of one run: from the corner where the rise ends to the one where the next reversal begins."""
    first, last, way = run
    height = way * log_ratio[first:last]
    if len(height) < _FEWEST_FOR_CORNER:
        return _trim_short(height, first, half, noise)
    level = float(np.median(height[len(height) // 3 :]))
    step = max(0.15 * half, min(4.0 * left, 0.3 * half))
    begin, end = 0, len(height)
    if level - way * smooth[last - 1] > step:
        end -= _corner(height[::-1][: len(height) // 2 + 1])
        end -= 2 + (len(height) - end) // 2
    if level - way * smooth[first] > step and end > 4:
        begin = _corner(height[:end])
        # The run begins at three quarters of the rise (half way from the middle to the limit): in a tendon that lets
        # go bit by bit, 0.56 of the time has then passed.
        begin += 2 + int(np.ceil(_MARGIN * begin / 0.44))
        if end - begin < _PAUSED * end:
            begin = min(begin, _after_pause(height[:end], way * smooth[first : first + end], level, step))
    fewest = min(_FEWEST_FOR_CORNER // 2, len(height) // 4)
    return (first + begin, first + end) if end - begin >= fewest else (first, first)


def _after_pause(height: Floats, smooth: Floats, level: float, step: float) -> int:
    """Where a rise that was held up ends: its last bit takes as long as the bit of the same height before it."""
    below = [np.flatnonzero(smooth < level - deep) for deep in (step, 2.0 * step)]
    near, far = (int(rows[-1]) if len(rows) else 0 for rows in below)
    return min(near + 2 + int(np.ceil(1.5 * (near - far))), len(height))


def _trim_short(height: Floats, first: int, half: float, noise: float) -> tuple[int, int]:
    """The same where a corner cannot be fitted: rows at either end that lie well inside the level."""
    level = float(np.median(height[len(height) // 3 :]))
    near = np.flatnonzero(height >= level - max(3.0 * noise, 0.03 * half, 1e-12))
    begin, end = first + int(near[0]), first + int(near[-1]) + 1
    # The first of many may have been on its way.
    return (begin + 1, end) if end - begin >= _LONG else (begin, end)


def _corner(height: Floats) -> int:
    """Row at which a rise turns into a level; 0 where the rows do not bend that way.

    Two straight lines that meet are fitted by least squares, for each meeting point on a grid at once: what a bend at
    one point explains beyond one straight line is its projection.
    """
    size = len(height)
    bins = min(_BINS, size)
    if bins < 4:
        return 0
    edges = np.linspace(0, size, bins + 1).astype(np.int64)
    y = np.add.reduceat(height, edges[:-1]) / np.diff(edges)
    t = (edges[:-1] + edges[1:] - 1) / 2.0
    straight, _ = np.linalg.qr(np.stack([np.ones(bins), t], axis=1))
    bends = np.maximum(t[:, None] - t[None, 1:-1], 0.0)
    bends -= straight @ (straight.T @ bends)
    along = bends.T @ y
    # Only a bend downward, from a rise to a level, is a corner of this kind.
    explained = np.where(along < 0.0, along**2 / np.maximum(np.sum(bends**2, axis=0), 1e-300), 0.0)
    best = int(np.argmax(explained))
    return int(np.ceil(t[best + 1])) + 1 if explained[best] > 0.0 else 0


def _still_moving(
    log_ratio: Floats,
    forces: tuple[Floats, Floats],
    runs: list[tuple[int, int, int]],
    kept: list[tuple[int, int]],
    half: float,
) -> float:
    """Mean of what the ratio still climbs in the kept rows, stretched to a whole stroke, less what both cells do."""
    climbs, weights, before = [], [], 0
    steps = np.zeros(2)
    for (first, last, way), (start, end) in zip(runs, kept, strict=True):
        # A short run was trimmed by the value of its rows, which says nothing about how they move.
        begin = max(first, end - max(3, (end - first) // 3)) if last - first < _FEWEST_FOR_CORNER else start
        rise = start - before
        if end - begin >= 3 and (begin > first or rise > 0) and half > 0.0:
            quarter = max(1, (end - begin) // 4)
            climb = way * float(np.mean(log_ratio[end - quarter : end]) - np.mean(log_ratio[begin : begin + quarter]))
            steps += [abs(np.log(np.mean(cell[end - quarter : end]) / np.mean(cell[begin : begin + quarter])))
                      for cell in forces]  # fmt: skip
            climbs.append(climb * (rise + end - begin) / (end - begin - quarter) / (2.0 * half))
            weights.append(end - begin)
        before = last
    if not climbs:
        return float("nan")
    alone = 1.0 - float(steps.min() / steps.max()) if steps.max() > 0.0 else 0.0
    return float(np.average(climbs, weights=weights)) * max(0.0, 2.0 * alone - 1.0)
