"""From readings to the log that is fitted: zeros taken off, rows set aside, directions, strokes, refusals."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import InputError
from tendon_cli.friction.directions import MotorCell, find_motor, named_ways, resting, sides_by_sign
from tendon_cli.friction.effects import bend_groups
from tendon_cli.friction.estimate import Log
from tendon_cli.friction.limits import is_settled, levels_of, ways_of
from tendon_cli.friction.reading.readings import Floats, Integers, Readings
from tendon_cli.friction.rows import USED, noise_of, resolution_of, unusable
from tendon_cli.units import shorten

Mask = npt.NDArray[np.bool_]

_MANY = 40
"""Rows in which a cell that works reads two values at least."""
_WEAKEST, _STRONGEST = 1e-9, 1e12
_LARGEST_RATIO = 20.0
"""Of one cell over the other: what a decimal comma leaves of "1,236" is a thousand."""
_TYPED = 60
"""Rows of a file without time up to which a person typed it: the sign of the log ratio is the direction, and with named
directions every row is a settled reading."""
_TWO_LIMITS = 2.0
"""Mean distance from the middle over its standard deviation: 1.3 in noise alone, over 4 about two limits."""
_FINE, _NOISY, _NOISELESS = 0.002, 1e-4, 200
"""Step and noise of the motor's cell over its force: if it is finer and noisier, so is that of a hanging weight, unless
it is dead. Fewer than 200 rows may be noiseless by chance."""
_FOLLOWS, _FAR_GAIN = 0.1, 0.2
"""A load's cell that moves by less than a tenth of what the motor's does over all rows, while their levels differ by
over 20 %,
weighs nothing of what the motor pulls; a hanging weight moves as little, but both cells read it."""


@dataclass(frozen=True, eq=False)
class Prepared:
    """A log, and where its rows are in the file."""

    log: Log
    rows: Integers
    """Row of the readings that each row of the log is."""
    codes: npt.NDArray[np.int8]
    """Per reading: why it is set aside, `USED` for what is in the log."""
    motor: MotorCell
    cells: tuple[Floats, Floats]
    """The motor's and the load's, zeros taken off, of all readings."""
    noise_hides: bool
    """Whether two limits do not show."""


def prepare(readings: Readings, bend: Floats, motor: str | None, zeros: tuple[float, float]) -> Prepared:
    """`zeros` are what the motor's and the load's cell read without load, in the unit of the file."""
    _check_forces(readings)
    readings = _zeroed(readings, motor, zeros)
    cells = readings.cell_1, readings.cell_2
    codes = unusable(cells, resting(readings))
    good = codes == USED
    if not good.any():
        raise InputError("no row has two forces above zero", where=readings.source, hint="check the sign of the cells")
    log_ratio = np.log(cells[0][good] / cells[1][good])
    if not np.isfinite(log_ratio).all():
        hint = "is the right column read, the cell alive?"
        raise InputError("the two forces of a reading are too far apart for a ratio", where=readings.source, hint=hint)
    named = named_ways(readings, log_ratio, good)
    known = None if named.way is None else named.way[good]
    group = bend_groups(bend[good])
    step = sum(0.5 * resolution_of(cell[good]) / float(np.median(cell[good])) for cell in cells)
    side, levels, settled = _sides(readings, log_ratio, known, group, step, good)
    whole = np.zeros(len(good), dtype=np.int64)
    whole[good] = side
    found = find_motor(readings, whole, named.meaning, good, motor)
    if any(zeros) and not (motor or readings.motor or zeros[0] == zeros[1]) and found.cell == "2":
        return prepare(readings=replace(readings, motor="2"), bend=bend, motor=motor, zeros=zeros)
    sign = 1 if found.cell == "1" else -1
    ordered = cells if found.cell == "1" else cells[::-1]
    border = _borders(readings, bend)[good]
    stroke = _strokes(readings, side, border, good)
    order = np.argsort(stroke, kind="stable")
    order = order[side[order] != 0]
    rows = np.flatnonzero(good)[order]
    middle, half, noise = (column[order] for column in levels)
    _, number = np.unique(stroke[order], return_inverse=True)
    timed = not settled and (readings.time is not None)
    if timed:
        _check_order(readings)
    log = Log(
        ordered[0][rows], ordered[1][rows], sign * side[order], bend[rows], np.asarray(number, dtype=np.int64),
        np.linspace(-0.5, 0.5, len(good))[rows], sign * middle, half, noise,
        readings.time[rows] if timed and readings.time is not None else None if settled else rows.astype(np.float64),
        settled,
    )  # fmt: skip
    _check_follows(readings, log, found)
    return Prepared(log, rows, codes, found, ordered, bool(np.any(half <= 3.0 * noise)))


def _zeroed(readings: Readings, motor: str | None, zeros: tuple[float, float]) -> Readings:
    """The readings less what the cells read without load."""
    if not any(zeros):
        return readings
    ordered = (motor or readings.motor or "1") == "1"
    cells = [readings.cell_1, readings.cell_2] if ordered else [readings.cell_2, readings.cell_1]
    left = [cell - zero for cell, zero in zip(cells, zeros, strict=True)]
    for name, zero, cell in zip(("motor", "load"), zeros, left, strict=True):
        if zero and np.nanquantile(cell, 0.9) <= 0.0:
            raise InputError(
                f"the stated zero of the {name}'s cell, {zero:g}, is larger than its forces",
                where=f"--zero-{name}",
                hint="it is what the cell reads without load",
            )
    return replace(readings, cell_1=left[0 if ordered else 1], cell_2=left[1 if ordered else 0])


def _sides(
    readings: Readings, log_ratio: Floats, known: Integers | None, group: Integers, step: float, good: Mask
) -> tuple[Integers, tuple[Floats, Floats, Floats], bool]:
    """Which limit each row belongs to; middle, half distance and noise of each; whether rows are settled readings."""
    side = np.zeros(len(log_ratio), dtype=np.int64)
    middle, half, noise = (np.zeros(len(log_ratio)) for _ in range(3))
    typed = readings.time is None and len(log_ratio) <= _TYPED
    short = known is None and typed
    for each in np.unique(group):
        mine = group == each
        y = log_ratio[mine]
        middle[mine], half[mine] = levels_of(y)
        if known is not None and len(np.unique(known[mine & (known != 0)])) < 2:
            middle[mine], half[mine] = 0.0, float(np.quantile(np.abs(y), 0.8))
        noise[mine] = max(
            noise_of(y, np.sign(y - middle[mine]) if known is None else known[mine]), min(step, 0.1 * half[mine][0])
        )
    half = np.maximum(half, 1e-12)
    raw = ways_of(log_ratio, middle, half) if known is None else known
    if short:
        raw = sides_by_sign(readings, log_ratio)
    other = np.cumsum(np.concatenate([[0], np.diff(group) != 0]))
    settled = (typed and known is not None) or is_settled(raw + 3 * other)
    if settled and known is None and not short:
        away = np.abs(log_ratio - middle)
        if float(np.mean(away)) < _TWO_LIMITS * float(np.std(away)):
            raise _no_limits(readings, np.flatnonzero(good))
    if known is not None or settled:
        return raw, (middle, half, noise), settled
    for each in np.unique(group):
        mine = group == each
        y, m, h = log_ratio[mine], float(middle[mine][0]), float(half[mine][0])
        side[mine] = ways_of(y, m, h, float(noise[mine][0])) if h > 3.0 * noise[mine][0] else np.sign(m) or 1
        turns = int(np.count_nonzero(np.diff(side[mine])))
        if turns == 0 or (turns < 2 and abs(m) > 0.5 * h):
            raise _no_limits(readings, np.flatnonzero(good)[mine])
    return side, (middle, half, noise), settled


def _no_limits(readings: Readings, rows: Integers) -> InputError:
    return InputError(
        "the log does not go back and forth between two limits, so the forces do not show the directions",
        where=f"{readings.source}, lines {readings.lines[rows[0]]} to {readings.lines[rows[-1]]}",
        hint='log at least two strokes each way, or add a column "direction" with "pull" and "release"',
    )


def _borders(readings: Readings, bend: Floats) -> Integers:
    """A number that changes from row to row where another stroke begins: another bend, or another name of a stroke."""
    border = np.zeros(len(bend), dtype=np.int64)
    columns = [bend_groups(bend)] + ([readings.strokes.code] if readings.strokes is not None else [])
    columns += [readings.file] if readings.file is not None else []
    for column in columns:
        border[1:] += np.cumsum(column[1:] != column[:-1])
    return border


def _strokes(readings: Readings, side: Integers, border: Integers, good: Mask) -> Integers:
    """Number of the stroke of each good row, in order: a run on one side, or what a column of strokes says."""
    moving = side != 0
    last = np.maximum.accumulate(np.where(moving, np.arange(len(side)), 0))
    held = side[last]  # a rest does not end a stroke
    number = np.concatenate([[0], np.cumsum((np.diff(held) != 0) | (np.diff(border) != 0))]) if len(side) else side
    if readings.strokes is None:
        return np.asarray(number)
    key = (readings.strokes.code[good] * 3 + held + 1) * (int(border.max()) + 1) + border
    if len(readings.lines) < 10**5:  # the same name again, as in a table in any order, is the same stroke
        key = readings.strokes.code[good] * 3 + held + 1
    _, first, place = np.unique(key, return_index=True, return_inverse=True)
    return np.asarray(np.argsort(np.argsort(first))[place])


def _check_forces(readings: Readings) -> None:
    """Refuse forces that no two working cells give."""
    cells = (readings.cell_1, readings.cell_2)
    for cell in cells:
        pulled, largest = np.nanmax(cell, initial=0.0), np.nanmax(np.abs(cell), initial=0.0)
        if 0.0 < pulled <= _WEAKEST or largest >= _STRONGEST:
            reached = largest if largest >= _STRONGEST else pulled
            problem = f"forces reach {reached:.3g}, which no load cell reads"
            raise InputError(problem, where=readings.source, hint="is the unit right?")
    fixed = [cell for cell in cells if np.nanmin(cell, initial=np.inf) == np.nanmax(cell, initial=-np.inf)]
    many = len(readings.lines) >= _MANY or (readings.directions is not None and len(readings.directions.names) > 1)
    if len(fixed) == 2 and many:
        hint = "are the right columns read, the cells alive?"
        raise InputError("both cells read the same in every row", where=readings.source, hint=hint)
    known = (cells[0] > 0.0) & (cells[1] > 0.0)
    one, two = cells[0][known], cells[1][known]
    if not known.any() or np.any(one != np.round(one)) or np.any(two != np.round(two)):
        return
    ratio = float(np.exp(np.median(np.abs(np.log(one / two)))))
    if ratio > _LARGEST_RATIO:
        raise InputError(
            f"one cell reads {ratio:.0f} times the other, in whole numbers",
            where=readings.source,
            hint="a decimal comma read as a separator? separate the columns by semicolons",
        )


def _check_order(readings: Readings) -> None:
    """Refuse a log whose rows are not in order of time."""
    back = np.flatnonzero(np.diff(readings.time if readings.time is not None else np.zeros(1)) < 0.0)
    if len(back):
        raise InputError(
            "time goes back in this row, so strokes cannot be told",
            where=readings.place(int(back[0]) + 1),
            hint="give one log per file, its rows in order of time",
        )


def _check_follows(readings: Readings, log: Log, motor: MotorCell) -> None:
    """Refuse a load's cell that does not weigh what the motor's pulls."""
    if log.settled or len(log.way) < _MANY:
        return
    pulled, weighed = np.log(log.motor), np.log(log.load)
    usual = float(np.median(log.motor))
    fine = (
        len(pulled) >= _NOISELESS
        and resolution_of(log.motor) < _FINE * usual
        and noise_of(log.motor, log.way) > _NOISY * usual
    )
    for end, cell, dead in (("motor", pulled, True), ("load", weighed, fine)):
        if not np.ptp(cell) and dead:
            name = shorten(readings.names[int(motor.cell) - 1 if end == "motor" else 2 - int(motor.cell)], 30)
            problem = f'the {end}\'s cell ("{name}") reads the same in every row'
            raise InputError(problem, where=readings.source, hint="is the right column read, the cell alive?")
    pulled, weighed = pulled - pulled.mean(), weighed - weighed.mean()
    slope = float(pulled @ weighed) / max(float(pulled @ pulled), 1e-300)
    gain = abs(float(np.median(log.middle)))
    against = slope < -_FOLLOWS and float(pulled @ weighed) ** 2 > 0.25 * float(pulled @ pulled) * float(
        weighed @ weighed
    )
    if against or (abs(slope) < _FOLLOWS and gain > _FAR_GAIN):
        name = shorten(readings.names[1 if motor.cell == "1" else 0], 30)
        raise InputError(
            f"the load's cell (\"{name}\") does not follow the motor's",
            where=readings.source,
            hint="is the right column read, is the cell connected, are both of the same tendon?",
        )
