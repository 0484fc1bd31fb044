"""Slip told from stick in rows of two cells, by what the forces do.

After a reversal the tendon sticks first, bit by bit from the motor on: the motor's cell moves alone, and the log ratio
of the forces goes from one limit, +μφ, to the other, -μφ. Only on the limit does the whole tendon slip. The move ends
with a corner and not smoothly, so each stroke is a rise and a level with a corner between them, and rows are kept by
where they stand in the stroke: choosing rows by their own value would choose their noise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.friction.corner import FEWEST_FOR_CORNER, LONG, trimmed
from tendon_cli.friction.levels import levels_of, noise_of, smoothed
from tendon_cli.friction.reading.readings import Floats, Integers

NOT_YET = "not yet slipping (before the first full stroke)"
STICKING = "sticking after a reversal"
TURNING = "turning (next to a reversal)"
PARTIAL = "sticking, slip was not reached in this stroke"
INSIDE = "inside both limits (at rest or sticking within a stroke)"

_OUTER = 0.5
"""A stroke's rows lie beyond this share of the way from the middle to the limit."""
_WITHIN = 0.35
"""A run that falls back no further than to this share goes on."""
_SETTLED = 3
"""Rows of a stroke in which no rise can be told from a level: they are readings of what has settled."""
_STRAY = 0.3
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
    fewest = _fewest_rows(log_ratio, named, noise)
    settled = fewest <= _SETTLED
    smooth, left, width = smoothed(log_ratio, noise, 2 * fewest - 1)
    middle, half = levels_of(smooth)
    one_name = named is not None and len(set(named) - {0}) < 2
    way_of = np.zeros(size, dtype=np.int64) if one_name else _sides(smooth, middle, half, left)
    if not np.any(way_of):  # the noise hides the limits: all rows are of one direction, or as the file says
        side = np.full(size, 1 if middle > 0.0 else -1) if named is None else named
    else:
        side = way_of if named is None else np.where((way_of == named) | (settled & (way_of == 0)), named, 0)
    runs = _runs(side, border, 2 * width + 1 if width > 1 else 0)
    if settled:
        kept, far, moving = [(first, last) for first, last, _ in runs], math.inf, math.nan
    else:
        runs = _begun_anew(runs, border)
        kept, far = [trimmed(log_ratio, smooth, run, half, noise, left) for run in runs], max(0.2 * half, 4.0 * noise)
        moving = _still_moving(log_ratio, forces, runs, kept, half)
    number, reasons = _numbered(log_ratio, runs, kept, border, far)
    side = np.where(number >= 0, side, 0)
    sides = np.array([way for (_, _, way), (begin, end) in zip(runs, kept, strict=True) if end > begin])
    turns = int(np.count_nonzero(np.diff(sides)))
    one_sided = turns < 2 and (half == 0.0 or abs(middle) > 0.5 * half or turns == 0)
    against = np.zeros(size, dtype=bool) if named is None else way_of * named < 0
    return Slip(number, side, reasons, one_sided, moving, against)


def _fewest_rows(log_ratio: Floats, named: Integers | None, noise: float) -> int:
    """How many rows a stroke has at least that nine of ten rows belong to, by their names or their side of the middle.

    Where the noise hides the sides, as many as there are rows.
    """
    side = named
    if side is None:
        middle, half = levels_of(log_ratio)
        if half <= 3.0 * noise:
            return len(log_ratio)
        side = np.where(log_ratio > middle, 1, -1)
    edges = np.flatnonzero(side[1:] != side[:-1]) + 1
    rows = np.diff(np.concatenate([[0], edges, [len(side)]]))
    return int(np.quantile(np.repeat(rows, rows), 0.1, method="lower"))


def _numbered(
    log_ratio: Floats,
    runs: list[tuple[int, int, int]],
    kept: list[tuple[int, int]],
    border: Integers,
    far: float,
) -> tuple[Integers, npt.NDArray[np.object_]]:
    """Number of the stroke of each row, -1 for none, and why; strokes whose level is `far` inside are left out."""
    number, reasons = np.full(len(log_ratio), -1, dtype=np.int64), np.full(len(log_ratio), NOT_YET, dtype=object)
    levels = np.array([np.median(log_ratio[a:b]) if b > a else np.nan for a, b in kept])
    ways = np.array([way for _, _, way in runs])
    typical = {way: float(np.median(mine)) if len(mine) else np.nan
               for way in (1, -1) for mine in [levels[(ways == way) & np.isfinite(levels)]]}  # fmt: skip
    usual = float(np.median([b - a for a, b in kept if b > a] or [0]))
    count, before = 0, (0, 0)
    for (first, last, way), (begin, end), level in zip(runs, kept, levels, strict=True):
        reasons[first:last] = STICKING if count else NOT_YET
        short = usual >= LONG and end - begin < _STRAY * usual
        if begin == end or short or way * (typical[way] - level) > far:
            reasons[first:last] = PARTIAL
            continue
        reasons[end:] = STICKING
        reasons[end:last] = TURNING
        reasons[begin:end] = ""
        # A pause within a stroke does not make two of it.
        count += int(before != (way, int(border[begin])))
        before = way, int(border[begin])
        number[begin:end] = count - 1
    return number, reasons


def _sides(smooth: Floats, middle: float, half: float, noise: float) -> Integers:
    """+1 and -1 beyond half the way to a limit, 0 between and where noise hides the limits."""
    side = np.zeros(len(smooth), dtype=np.int64)
    if half > 3.0 * noise:
        for way in (1, -1):
            height = way * (smooth - middle) / half
            beyond = np.flatnonzero(height > _OUTER)
            # Noise about the border does not end a run.
            fallen = np.concatenate([[0], np.cumsum(height <= _WITHIN)])
            joined = np.flatnonzero(np.diff(fallen[beyond]) == 0)
            for first, last in zip(beyond[joined], beyond[joined + 1], strict=True):
                side[first:last] = way
            side[beyond] = way
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
    return runs


def _begun_anew(runs: list[tuple[int, int, int]], border: Integers) -> list[tuple[int, int, int]]:
    """Runs but what a stroke begins with on the other limit, going on from the stroke before: not yet its own slip."""
    sides = {(int(border[first]), side) for first, _, side in runs}
    return [
        run for before, run in zip([(0, -1, 0), *runs], runs, strict=False)
        if (before[1:], (int(border[run[0]]), -run[2]) in sides) != ((run[0], run[2]), True)
    ]  # fmt: skip


def _still_moving(
    log_ratio: Floats,
    forces: tuple[Floats, Floats],
    runs: list[tuple[int, int, int]],
    kept: list[tuple[int, int]],
    half: float,
) -> float:
    """Mean of what the ratio surely climbs in the kept rows, stretched to a whole stroke, less what both cells do."""
    from scipy.special import stdtrit

    climbs, weights, errors, before = [], [], [], 0
    left, free = 0.0, 0
    steps = np.zeros(2)
    for (first, last, way), (start, end) in zip(runs, kept, strict=True):
        # A short run was trimmed by the value of its rows, which says nothing about how they move.
        begin = max(first, end - max(3, (end - first) // 3)) if last - first < FEWEST_FOR_CORNER else start
        rise = start - before
        if end - begin >= 3 and (begin > first or rise > 0) and half > 0.0:
            quarter = max(1, (end - begin) // 4)
            climb = way * float(np.mean(log_ratio[end - quarter : end]) - np.mean(log_ratio[begin : begin + quarter]))
            steps += [abs(np.log(np.mean(cell[end - quarter : end]) / np.mean(cell[begin : begin + quarter])))
                      for cell in forces]  # fmt: skip
            stretch = (rise + end - begin) / (end - begin - quarter) / (2.0 * half)
            climbs.append(climb * stretch)
            weights.append(end - begin)
            errors.append((end - begin) * math.sqrt(2.0 / quarter) * stretch)
            left += float(np.polyfit(np.arange(end - begin), log_ratio[begin:end], 1, full=True)[1][0])
            free += end - begin - 2
        before = last
    if not climbs:
        return float("nan")
    alone = 1.0 - float(steps.min() / steps.max()) if steps.max() > 0.0 else 0.0
    by_chance = float(stdtrit(free, 0.975)) * math.sqrt(left / free) * math.hypot(*errors) / sum(weights)
    return max(0.0, float(np.average(climbs, weights=weights)) - by_chance) * max(0.0, 2.0 * alone - 1.0)
