"""From readings to the log that is fitted: zeros taken off, rows set aside, directions, strokes, refusals."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import InputError
from tendon_cli.friction.directions import (
    levels_of,
    motor_cell,
    sides_by_sign,
    stated_motion,
    stated_sides,
    triggered_sides,
    usual_run,
)
from tendon_cli.friction.reading.readings import Floats, Integers, Mask, Readings, check_forces
from tendon_cli.friction.usable_rows import (
    SATURATED,
    USED,
    Log,
    bend_groups,
    noise_of,
    resolution_of,
    unusable,
)
from tendon_cli.units import counted, shorten

_MOSTLY = 0.5
"""Share of saturated rows from which the rest is not the log, but what the range left of it."""
_MANY = 40
"""Rows in which a cell that works reads two values at least."""
_TYPED, _SETTLED = 60, 3
"""Rows of a file without time up to which a person typed it: the sign of the log ratio is the direction, and with named
directions every row is a settled reading, as are strokes of up to three rows, in which no climb shows."""
_TWO_LIMITS = 2.0
"""Mean distance from the middle over its standard deviation: 1.3 in noise alone, over 4 about two limits."""
_SHOWN = 3.0
"""Half distance of the limits over the noise of a row, under which rows do not show the strokes."""
_FINE, _NOISY, _NOISELESS = 0.002, 1e-4, 200
"""Step and noise of the motor's cell over its force: if it is finer and noisier, so is that of a hanging weight, unless
it is dead. Fewer than 200 rows may be noiseless by chance."""
_FOLLOWS, _FAR_GAIN, _AGAINST = 0.1, 0.2, 0.5
"""A load's cell that moves by less than a tenth of what the motor's does over all rows, while their levels differ by
over 20 %, weighs nothing of what the motor pulls; a hanging weight moves as little, but both cells read it. One that
goes against it, correlated by half, is another tendon's."""


@dataclass(frozen=True, eq=False)
class Prepared:
    """A log, and where it comes from: `rows` are those of the readings that its rows are.

    `codes` say per reading why it is set aside, `USED` for what is in the log; `cells` are the motor's and the load's
    of all readings, zeros taken off; `motor` is "1" or "2", the cell at the motor.
    """

    log: Log
    rows: Integers
    codes: npt.NDArray[np.int8]
    cells: tuple[Floats, Floats]
    motor: str
    notes: list[str]
    warnings: list[str]


def prepare(
    readings: Readings, bend: Floats, motor: str | None, zeros: tuple[float, float]
) -> Prepared:
    """`zeros` are what the motor's and the load's cell read without load, in the unit of the file."""
    check_forces(readings)
    first = motor or readings.motor or "1"
    cells, names = (
        (readings.cells, readings.names)
        if first == "1"
        else (readings.cells[::-1], readings.names[::-1])
    )
    cells = _zeroed(cells, zeros)
    steps = resolution_of(cells[0]), resolution_of(cells[1])
    way, rest = stated_motion(readings)
    codes = unusable(cells, steps, rest)
    good = _good(codes, readings.source)
    forces = cells[0][good], cells[1][good]
    log_ratio = np.log(forces[0] / forces[1])
    known, group = stated_sides(readings, way, log_ratio, good), bend_groups(bend[good])
    known = None if known is None else np.where(rest[good], 0, known)
    rounding = sum(
        0.5 * step / float(np.median(force)) for step, force in zip(steps, forces, strict=True)
    )
    middle, half, noise = levels = _levels(log_ratio, known, group, rounding)
    side, settled = _sides(readings, log_ratio, known, group, levels, good)
    cell, notes, warnings = motor_cell(
        readings, first, way[good], side, forces, is_stated=motor is not None
    )
    if cell != first:
        return replace(prepare(readings, bend, cell, zeros), notes=notes)
    stroke = _strokes(readings, side, bend, good, settled)
    at = np.argsort(stroke, kind="stable")
    at = at[side[at] != 0]
    rows = np.flatnonzero(good)[at]
    _check_enough(side[at], bend[rows], readings.source)
    log = Log(
        forces[0][at],
        forces[1][at],
        side[at],
        bend[rows],
        np.unique(stroke[at], return_inverse=True)[1],
        np.linspace(-0.5, 0.5, len(good))[rows],
        middle[at],
        half[at],
        noise[at],
        steps,
        None if settled else readings.times[rows],
        settled,
        float(np.mean(np.log(forces[1][at]))),
    )
    _check_follows(log, names, readings.source)
    return Prepared(log, rows, codes, cells, cell, notes, warnings)


def _good(codes: npt.NDArray[np.int8], source: str) -> Mask:
    """The rows that can be readings; refused if there are none, or if most are saturated."""
    saturated, good = float(np.mean(codes == SATURATED)), np.asarray(codes == USED)
    if saturated > _MOSTLY:
        problem = f"{100.0 * saturated:.0f} % of the rows are saturated, and what slips there is not known"
        raise InputError(problem, where=source, hint="use cells of a larger range")
    if not good.any():
        raise InputError(
            "no row has two forces above zero", where=source, hint="check the sign of the cells"
        )
    return good


def _check_enough(side: Integers, bend: Floats, source: str) -> None:
    """Refuse rows too few to show how they scatter, and rows of straight sheaths alone."""
    needed = 3 if len(np.unique(side)) == 2 else 2
    if len(side) < needed:
        problem = f"{counted(len(side), 'reading')} used, fewer than the {needed} needed to show how they scatter"
        hint = "repeat the measurement: five strokes or more in each direction are good"
        raise InputError(problem, where=source, hint=hint)
    if not np.any(bend > 0.0):
        raise InputError("every bend angle is 0", where=source)


def _zeroed(cells: tuple[Floats, Floats], zeros: tuple[float, float]) -> tuple[Floats, Floats]:
    """The readings of the motor's and the load's cell less what they read without load."""
    for end, zero, cell in zip(("motor", "load"), zeros, cells, strict=True):
        if zero and np.nanquantile(cell, 0.9) <= zero:
            problem = f"the stated zero of the {end}'s cell, {zero:g}, is larger than its forces"
            raise InputError(
                problem, where=f"--zero-{end}", hint="it is what the cell reads without load"
            )
    return cells[0] - zeros[0], cells[1] - zeros[1]


def _levels(
    log_ratio: Floats, known: Integers | None, group: Integers, rounding: float
) -> tuple[Floats, Floats, Floats]:
    """Middle and half distance of the two limits at each row's bend, and the noise of its log ratio."""
    levels = np.zeros((3, len(log_ratio)))
    for each in np.unique(group):
        mine = group == each
        y, sides = log_ratio[mine], None if known is None else known[mine]
        middle, half = levels_of(y)
        if sides is None:
            sides = np.sign(y - middle).astype(np.int64)
        elif len(np.unique(sides[sides != 0])) < 2:
            middle, half = 0.0, float(np.quantile(np.abs(y), 0.8))
        levels[:, mine] = [
            [middle],
            [max(half, 1e-12)],
            [max(noise_of(y, sides), min(rounding, 0.1 * half))],
        ]
    return levels[0], levels[1], levels[2]


def _sides(
    readings: Readings,
    log_ratio: Floats,
    known: Integers | None,
    group: Integers,
    levels: tuple[Floats, Floats, Floats],
    good: Mask,
) -> tuple[Integers, bool]:
    """Which limit each row belongs to, 0 at rest; and whether rows are settled readings."""
    typed = "time" not in readings.rows and len(log_ratio) <= _TYPED
    other = 3 * np.cumsum(np.diff(group, prepend=group[:1]) != 0)
    if known is not None:
        return known, typed or usual_run(known + other) <= _SETTLED
    if typed:
        side = sides_by_sign(readings, log_ratio)
        if usual_run(side + other) <= _SETTLED:
            return side, True
    side, moved = np.zeros(len(log_ratio), dtype=np.int64), True
    for each in np.unique(group):
        mine = group == each
        middle, half, noise = (float(level[mine][0]) for level in levels)
        shown = half > _SHOWN * noise
        side[mine] = (
            triggered_sides(log_ratio[mine], middle, half, noise) if shown else np.sign(middle) or 1
        )
        turns = np.count_nonzero(np.diff(side[mine]))
        moved = bool(moved and turns > 0 and (turns > 1 or abs(middle) <= 0.5 * half))
    settled = usual_run(side + other) <= _SETTLED
    away = np.abs(log_ratio - levels[0])
    if not (moved or settled) or (
        settled and float(np.mean(away)) < _TWO_LIMITS * float(np.std(away))
    ):
        lines = readings.rows["line"].to_numpy()[good]
        raise InputError(
            "the log does not go back and forth between two limits, so the forces do not show the directions",
            where=f"{readings.source}, lines {lines[0]} to {lines[-1]}",
            hint='log at least two strokes each way, or add a column "direction" with "pull" and "release"',
        )
    return side, settled


def _strokes(
    readings: Readings, side: Integers, bend: Floats, good: Mask, settled: bool
) -> Integers:
    """Number of the stroke of each good row, in order: a run on one side at one bend, or what a column says."""
    border = [np.diff(bend_groups(bend), prepend=0) != 0]
    for name in {"stroke", "file"} & set(readings.rows):
        codes = readings.codes(name)[1] if name == "stroke" else readings.rows[name].to_numpy()
        border.append(np.diff(codes, prepend=codes[:1]) != 0)
    part = np.cumsum(np.logical_or.reduce(border))[good]
    last = np.maximum.accumulate(np.where(side != 0, np.arange(len(side)), 0))
    held = side[last]  # a rest does not end a stroke
    if (
        settled and "stroke" in readings.rows
    ):  # the same name again, as in a table in any order, is the same stroke
        key = readings.codes("stroke")[1][good] * 3 + held
        first, place = np.unique(key, return_index=True, return_inverse=True)[1:]
        return np.asarray(np.argsort(np.argsort(first))[place])
    return np.cumsum(
        (np.diff(held, prepend=held[:1]) != 0) | (np.diff(part, prepend=part[:1]) != 0)
    )


def _check_follows(log: Log, names: tuple[str, str], source: str) -> None:
    """Refuse a motor's cell that stands still, and a load's that does not weigh what the motor's pulls."""
    if log.settled or len(log.way) < _MANY:
        return
    motor, load = (f'cell ("{shorten(name, 30)}")' for name in names)
    usual = float(np.median(log.motor))
    fine = (
        len(log.way) >= _NOISELESS
        and log.steps[0] < _FINE * usual
        and noise_of(log.motor, log.way) > _NOISY * usual
    )
    hint = "is the right column read, is the cell connected, are both of the same tendon?"
    if not np.ptp(log.motor):
        raise InputError(
            f"the motor's {motor} reads the same in every row", where=source, hint=hint
        )
    if not np.ptp(log.load) and fine:
        raise InputError(f"the load's {load} reads the same in every row", where=source, hint=hint)
    pulled, weighed = (np.log(cell) - np.mean(np.log(cell)) for cell in (log.motor, log.load))
    both, square = float(pulled @ weighed), float(pulled @ pulled)
    against = both < -_FOLLOWS * square and -both > _AGAINST * np.sqrt(
        square * float(weighed @ weighed)
    )
    if against or (abs(both) < _FOLLOWS * square and abs(float(np.median(log.middle))) > _FAR_GAIN):
        raise InputError(f"the load's {load} does not follow the motor's", where=source, hint=hint)
