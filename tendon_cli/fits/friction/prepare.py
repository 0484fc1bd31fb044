"""Preparation of readings for the fit: zeros, rows set aside, directions, strokes, refusals."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import InputError
from tendon_cli.fits.friction.directions import (
    levels_of,
    motor_cell,
    sides_by_sign,
    stated_motion,
    stated_sides,
    triggered_sides,
    usual_run,
)
from tendon_cli.fits.friction.readings import ENOUGH_ROWS, Readings, check_forces
from tendon_cli.fits.friction.usable_rows import (
    SATURATED,
    USED,
    Log,
    bend_groups,
    resolutions_of,
    unusable,
    without_hum,
)
from tendon_cli.fits.log_rows import Floats, Integers, Mask, noise_of
from tendon_cli.units import counted, shorten

_MOSTLY = 0.5
"""Share of saturated rows from which the other rows do not represent the log."""
_TYPED = 60
"""Rows up to which a file without time was typed by a person: the sign of the log ratio is the
direction, and with named directions every row is a settled reading."""
_SETTLED = 3
"""Number of rows up to which a stroke consists of settled readings: they show no climb."""
_TWO_LIMITS = 2.0
"""Mean distance from the middle over its standard deviation: 1.3 in noise alone, over 4 about two
limits."""
_SHOWN = 3.0
"""Half distance of the limits over the noise of a row, under which rows do not show the strokes."""
_FINE = 0.002
"""Step of the motor's cell over its force under which the cell is fine. If it is fine and noisy,
the load's cell is noisy, too, even under a hanging weight, unless it is dead."""
_NOISY = 1e-4
"""Noise of the motor's cell over its force above which it is noisy."""
_NOISELESS = 200
"""Number of rows under which a cell may be noiseless by chance."""
_FOLLOWS = 0.1
"""Change of the load's cell over that of the motor's, under which it does not measure what the
motor pulls, if their levels also differ by more than `_FAR_GAIN`: under a hanging weight the load's
cell changes as little, but both cells read the weight."""
_FAR_GAIN = 0.2
"""Difference of the cells' levels that no calibration leaves, as a share."""
_AGAINST = 0.5
"""Correlation from which a load's cell that falls as the motor's rises is another tendon's."""
_MAINS = 50.0  # Hz
SECONDS = {"s": 1.0, "ms": 1e3, "us": 1e6}
"""Units of time in a second."""
_WRONG_COLUMN = (
    "is this the right column, is the cell connected, and do both cells measure the same tendon?"
)


@dataclass(frozen=True, eq=False)
class PreparedLog:
    """Log that is fitted, and the readings that it comes from."""

    log: Log
    rows: Integers
    """Row of the readings for each row of the log."""
    codes: npt.NDArray[np.int8]
    """Code of the reason why each reading is set aside; `USED` if it is in the log."""
    cells: tuple[Floats, Floats]
    """Forces at the motor and at the load in all readings, zeros taken off."""
    motor: str
    """"1" or "2", the cell at the motor."""
    notes: list[str]
    warnings: list[str]


def prepare(
    readings: Readings, bend: Floats, motor: str | None, zeros: tuple[float, float]
) -> PreparedLog:
    """Prepare readings for the fit.

    Args:
        readings: All readings.
        bend: Bend angle of each reading, rad.
        motor: "1" or "2", the cell at the motor; None to infer it.
        zeros: Readings of the motor's and of the load's cell without load, in the unit of the file.

    Raises:
        InputError: if the readings cannot show friction.
    """
    check_forces(readings)
    first = motor or readings.motor or "1"
    cells = readings.cells
    names = readings.names
    if first == "2":
        cells = cells[::-1]
        names = names[::-1]
    written = cells
    hums = [without_hum(cell) for cell in _zeroed(cells, zeros)]
    cells = (hums[0][0], hums[1][0])
    hum = max(frequency for _, frequency in hums)
    stroke_of_row = np.full(len(readings.rows), -1, dtype=np.int64)
    steps, _ = resolutions_of(written, stroke_of_row)
    way, rest = stated_motion(readings)
    codes = unusable(cells, steps, rest)
    good = _good_rows(codes, readings.source)
    forces = (cells[0][good], cells[1][good])
    log_ratio = np.log(forces[0] / forces[1])
    group = bend_groups(bend[good])
    stated = stated_sides(readings, way, log_ratio, good)
    if stated is not None:
        stated = np.where(rest[good], 0, stated)
    rounding = sum(0.5 * step / np.median(force) for step, force in zip(steps, forces, strict=True))
    levels = _levels(log_ratio, stated, group, rounding)
    side, is_settled = _sides(readings, log_ratio, stated, group, levels, good)
    cell, notes, warnings = motor_cell(
        readings, first, way[good], side, forces, is_stated=motor is not None
    )
    if cell != first:
        again = prepare(readings, bend, cell, zeros)
        return replace(again, notes=[*notes, *again.notes])
    stroke = _strokes(readings, side, bend, good, is_settled)
    stroke_of_row[good] = stroke
    steps, shows_steps = resolutions_of(written, stroke_of_row)
    if hum:
        notes.append(_note_on_hum(readings, hum))
    order = np.argsort(stroke, kind="stable")
    order = order[side[order] != 0]
    rows = np.flatnonzero(good)[order]
    _check_enough(side[order], bend[rows], readings.source)
    middle, half, noise = levels
    log = Log(
        motor=forces[0][order],
        load=forces[1][order],
        way=side[order],
        bend=bend[rows],
        stroke=np.unique(stroke[order], return_inverse=True)[1],
        place=np.linspace(-0.5, 0.5, len(good))[rows],
        middle=middle[order],
        half=half[order],
        noise=noise[order],
        steps=steps,
        shows_steps=shows_steps,
        time=None if is_settled else readings.times[rows],
        settled=is_settled,
        mean_force=np.mean(np.log(forces[1][order])),
    )
    _check_follows(log, names, readings.source)
    return PreparedLog(log, rows, codes, cells, cell, notes, warnings)


def _good_rows(codes: npt.NDArray[np.int8], source: str) -> Mask:
    """Select the rows that can be readings; refuse a file with none, or with too many saturated."""
    saturated = np.mean(codes == SATURATED)
    good = np.asarray(codes == USED)
    if saturated > _MOSTLY:
        raise InputError(
            f"{100.0 * saturated:.0f} % of the rows are saturated, so what slips there is unknown",
            where=source,
            hint="use cells of a larger range",
        )
    if not good.any():
        raise InputError(
            "no row has both forces above zero", where=source, hint="check the sign of the cells"
        )
    return good


def _check_enough(side: Integers, bend: Floats, source: str) -> None:
    """Refuse rows too few to show how they scatter, and rows with straight sheaths only."""
    needed = 3 if len(np.unique(side)) == 2 else 2
    if len(side) < needed:
        raise InputError(
            f"{counted(len(side), 'reading')} used,"
            f" fewer than the {needed} needed to show how they scatter",
            where=source,
            hint="repeat the measurement with five strokes or more in each direction",
        )
    if not np.any(bend > 0.0):
        raise InputError("every bend angle is 0", where=source)


def _zeroed(cells: tuple[Floats, Floats], zeros: tuple[float, float]) -> tuple[Floats, Floats]:
    """Subtract from the motor's and the load's cell what they read without load."""
    for end, zero, cell in zip(("motor", "load"), zeros, cells, strict=True):
        if zero and np.nanquantile(cell, 0.9) <= zero:
            raise InputError(
                f"the stated zero of the {end}'s cell, {zero:g}, is larger than its forces",
                where=f"--zero-{end}",
                hint="it is what the cell reads without load",
            )
    return cells[0] - zeros[0], cells[1] - zeros[1]


def _note_on_hum(readings: Readings, hum: float) -> str:
    """Return a note on a hum that is filtered out, `hum` in periods a row."""
    shown = f"a period of {1.0 / hum:.3g} rows"
    time = readings.column("time")
    if time is not None and readings.time_unit in SECONDS:
        rate = SECONDS[readings.time_unit] / np.median(np.diff(time))
        shown = f"{hum * rate:.3g} Hz at {rate:.3g} readings a second"
        alias = abs(round(_MAINS / rate) * rate - _MAINS)
        if abs(alias - hum * rate) < 0.02 * rate:
            shown += f", as {_MAINS:g} Hz of the mains would show"
    return f"a hum of {shown} is filtered out of the cells; shield their cables"


def _levels(
    log_ratio: Floats, stated: Integers | None, group: Integers, rounding: float
) -> tuple[Floats, Floats, Floats]:
    """Find the two limits at each bend.

    Args:
        log_ratio: ln(F_motor/F_load) of each row.
        stated: Limit that each row belongs to by the file: +1, -1 or 0; None if it does not say.
        group: Number of each row's bend angle.
        rounding: Half a step over the usual force, summed over both cells.

    Returns:
        Middle and half distance of the two limits, and the noise of the log ratio, per row.
    """
    levels = np.zeros((3, len(log_ratio)))
    for number in np.unique(group):
        at_bend = group == number
        ratios = log_ratio[at_bend]
        middle, half = levels_of(ratios)
        if stated is None:
            sides = np.sign(ratios - middle).astype(np.int64)
        else:
            sides = stated[at_bend]
            if len(np.unique(sides[sides != 0])) < 2:
                middle = 0.0
                half = np.quantile(np.abs(ratios), 0.8)
        levels[0, at_bend] = middle
        levels[1, at_bend] = max(half, 1e-12)
        levels[2, at_bend] = max(noise_of(ratios, sides), min(rounding, 0.1 * half))
    return levels[0], levels[1], levels[2]


def _sides(
    readings: Readings,
    log_ratio: Floats,
    stated: Integers | None,
    group: Integers,
    levels: tuple[Floats, Floats, Floats],
    good: Mask,
) -> tuple[Integers, bool]:
    """Find the limit that each row belongs to.

    Returns:
        +1, -1, or 0 at rest, per good row; and True if the rows are settled readings.
    """
    is_typed = "time" not in readings.rows and len(log_ratio) <= _TYPED
    # A change of the bend ends a run, too.
    bends = 3 * np.cumsum(np.diff(group, prepend=group[:1]) != 0)
    if stated is not None:
        return stated, is_typed or usual_run(stated + bends) <= _SETTLED
    if is_typed:
        side = sides_by_sign(readings, log_ratio)
        if usual_run(side + bends) <= _SETTLED:
            return side, True
    side = np.zeros(len(log_ratio), dtype=np.int64)
    has_moved = True
    for number in np.unique(group):
        at_bend = group == number
        middle, half, noise = (level[at_bend][0] for level in levels)
        if half > _SHOWN * noise:
            side[at_bend] = triggered_sides(log_ratio[at_bend], middle, half, noise)
        else:
            side[at_bend] = np.sign(middle) or 1
        turns = np.count_nonzero(np.diff(side[at_bend]))
        has_turned = turns > 1 or (turns == 1 and abs(middle) <= 0.5 * half)
        has_moved = bool(has_moved and has_turned)
    is_settled = usual_run(side + bends) <= _SETTLED
    away = np.abs(log_ratio - levels[0])
    has_two_limits = not np.mean(away) < _TWO_LIMITS * np.std(away)
    shows_directions = has_two_limits if is_settled else has_moved
    if not shows_directions:
        lines = readings.rows["line"].to_numpy()[good]
        problem = (
            "the log does not go back and forth between two limits,"
            " so the forces do not show the directions"
        )
        hint = (
            "log at least two strokes each way,"
            ' or add a column "direction" with "pull" and "release"'
        )
        where = f"{readings.source}, lines {lines[0]} to {lines[-1]}"
        raise InputError(problem, where=where, hint=hint)
    return side, is_settled


def _strokes(
    readings: Readings, side: Integers, bend: Floats, good: Mask, is_settled: bool
) -> Integers:
    """Number the stroke of each good row, in order.

    A stroke is a run of rows at one limit and one bend; a column of the file may divide it. In a
    table of settled readings, in any order, the same name means the same stroke.
    """
    numbers = bend_groups(bend)
    borders = [np.diff(numbers, prepend=0) != 0]
    if "stroke" in readings.rows:
        numbers = readings.codes("stroke")[1]
        borders.append(np.diff(numbers, prepend=numbers[:1]) != 0)
    if "file" in readings.rows:
        numbers = readings.rows["file"].to_numpy()
        borders.append(np.diff(numbers, prepend=numbers[:1]) != 0)
    part = np.cumsum(np.logical_or.reduce(borders))[good]
    last = np.maximum.accumulate(np.where(side != 0, np.arange(len(side)), 0))
    held = side[last]  # a rest does not end a stroke
    if is_settled and "stroke" in readings.rows:
        key = readings.codes("stroke")[1][good] * 3 + held
        _, first, place = np.unique(key, return_index=True, return_inverse=True)
        return np.argsort(np.argsort(first))[place]
    turns = np.diff(held, prepend=held[:1]) != 0
    changes = np.diff(part, prepend=part[:1]) != 0
    return np.cumsum(turns | changes)


def _check_follows(log: Log, names: tuple[str, str], source: str) -> None:
    """Refuse a motor's cell that never changes, and a load's cell that does not follow it."""
    if log.settled or len(log.way) < ENOUGH_ROWS:
        return
    motor, load = (f'cell ("{shorten(name, 30)}")' for name in names)
    if not np.ptp(log.motor):
        raise InputError(
            f"the motor's {motor} reads the same in every row", where=source, hint=_WRONG_COLUMN
        )
    usual = np.median(log.motor)
    is_fine = len(log.way) >= _NOISELESS and log.steps[0] < _FINE * usual
    is_noisy = noise_of(log.motor, log.way) > _NOISY * usual
    if not np.ptp(log.load) and is_fine and is_noisy:
        raise InputError(
            f"the load's {load} reads the same in every row", where=source, hint=_WRONG_COLUMN
        )
    motor_change = np.log(log.motor) - np.mean(np.log(log.motor))
    load_change = np.log(log.load) - np.mean(np.log(log.load))
    product = motor_change @ load_change
    square = motor_change @ motor_change
    largest_product = np.sqrt(square * float(load_change @ load_change))
    goes_against = product < -_FOLLOWS * square and -product > _AGAINST * largest_product
    is_far = abs(np.median(log.middle)) > _FAR_GAIN
    hardly_changes = abs(product) < _FOLLOWS * square and is_far
    if goes_against or hardly_changes:
        raise InputError(
            f"the load's {load} does not follow the motor's", where=source, hint=_WRONG_COLUMN
        )
