"""What cannot be fitted honestly is refused here, with the reason."""

from __future__ import annotations

import math

import numpy as np

from tendon_cli.errors import InputError
from tendon_cli.friction.effects import Fitted
from tendon_cli.friction.estimate import Slipping
from tendon_cli.friction.reading.readings import Floats, Integers, Readings
from tendon_cli.friction.resolution import resolution_of

_PLAUSIBLE_GAIN = math.log(1.1)
_MANY = 40
_WEAKEST, _STRONGEST = 1e-9, 1e12
_FINE = 30
_LARGEST_RATIO = 20.0


def check_forces(readings: Readings) -> None:
    """Refuse forces that no two working cells give."""
    cells = (readings.cell_1, readings.cell_2)
    for cell in cells:
        pulled, largest = np.nanmax(cell, initial=0.0), np.nanmax(np.abs(cell), initial=0.0)
        if 0.0 < pulled <= _WEAKEST or largest >= _STRONGEST:
            reached = largest if largest >= _STRONGEST else pulled
            raise InputError(
                f"forces reach {reached:.3g}, which no load cell reads",
                where=readings.source,
                hint="is the unit right?",
            )
    many = len(readings.lines) >= _MANY
    counts = [len(np.unique(cell[np.isfinite(cell)])) for cell in cells]
    fixed = [column for column, count in enumerate(counts, start=1) if count == 1]
    # A constant weight reads the same in a cell of coarse steps; where the other has fine ones, the cell is dead.
    if fixed and ((many and max(counts) > _FINE) or (len(fixed) == 2 and len(set(readings.directions or ())) > 1)):
        both = "both cells read" if len(fixed) == 2 else f'cell {fixed[0]} ("{readings.names[fixed[0] - 1]}") reads'
        raise InputError(
            f"{both} the same in every row", where=readings.source, hint="is the right column read, the cell alive?"
        )
    _check_ratio(readings)


def check_order(readings: Readings) -> None:
    """Refuse a log whose rows are not in order of time."""
    back = np.flatnonzero(np.diff(readings.time if readings.time is not None else np.zeros(1)) < 0.0)
    if len(back):
        raise InputError(
            "time goes back in this row, so strokes cannot be told",
            where=readings.place(int(back[0]) + 1),
            hint="give one log per file, its rows in order of time",
        )


def _check_ratio(readings: Readings) -> None:
    """Refuse whole numbers with an absurd ratio, which is what a decimal comma leaves of "1,236"."""
    known = (readings.cell_1 > 0.0) & (readings.cell_2 > 0.0)
    if not known.any():
        return
    one, two = readings.cell_1[known], readings.cell_2[known]
    ratio = float(np.exp(np.median(np.abs(np.log(one / two)))))
    whole = bool(np.all(one == np.round(one)) and np.all(two == np.round(two)))
    if whole and ratio > _LARGEST_RATIO:
        raise InputError(
            f"one cell reads {ratio:.0f} times the other, in whole numbers",
            where=readings.source,
            hint="a decimal comma read as a separator? separate the columns by semicolons",
        )


def check_strokes(slipping: Slipping, readings: Readings, *, with_gain: bool, is_log: bool) -> None:
    """Refuse what cannot answer: too few rows, or none in a bend."""
    if is_log:
        check_order(readings)
    if not len(slipping.stroke):
        what = "no stroke with slipping rows was found" if is_log else "no reading is left"
        raise InputError(what, where=readings.source, hint="strokes go on until the force ratio no longer changes")
    if not np.any(slipping.bend_angle > 0.0):
        raise InputError("every bend angle is 0", where=readings.source)
    if not np.isfinite(slipping.log_ratio).all():
        hint = "is the right column read, the cell alive?"
        raise InputError("the two forces of a reading are too far apart for a ratio", where=readings.source, hint=hint)
    used, needed = len(slipping.stroke), 3 if with_gain else 2
    if used < needed:
        noun = "reading" if used == 1 else "readings"
        raise InputError(
            f"{used} {noun} used, fewer than the {needed} needed to tell how they scatter",
            where=readings.source,
            hint="repeat the measurement: five strokes or more in each direction are good",
        )


def check_result(fitted: Fitted, slipping: Slipping, readings: Readings, rows: Integers, *, is_log: bool) -> None:
    """Refuse forces that say friction helps the motion."""
    travel = slipping.way * (slipping.log_ratio - fitted.log_gain)
    noise = 2.0 * _rounding(slipping)
    if not is_log and not fitted.effects:
        wrong = np.flatnonzero(travel < -noise - 0.25 * abs(fitted.friction) * slipping.bend_angle)
        if len(wrong) and len(wrong) < len(travel):
            raise InputError(
                "friction would help the motion in this reading, against the others",
                where=readings.place(int(rows[wrong[0]])),
                hint="are its two forces, or its direction, swapped?",
            )
    if fitted.friction <= 0.0:
        raise InputError(
            f"friction would help the motion: the coefficient comes out as {fitted.friction:.4g}",
            where=readings.source,
            hint="check the directions, and which cell is at the motor (--motor)",
        )
    gain = abs(fitted.log_gain)
    judged = fitted.with_gain and not is_log
    if judged and gain > max(fitted.friction * float(slipping.bend_angle.max()), _PLAUSIBLE_GAIN):
        raise InputError(
            "friction would help the motion in one direction, unless the cells' gains differ by"
            f" {100.0 * (math.exp(gain) - 1.0):.0f} %",
            where=readings.source,
            hint="check the directions; calibrate the cells against each other with the same weight",
        )


def _rounding(slipping: Slipping) -> Floats:
    """Standard deviation of each log ratio from the rounding of the two readings."""
    parts = [resolution_of(cell) / cell for cell in (slipping.motor, slipping.load)]
    return np.asarray(np.hypot(*parts) / math.sqrt(12.0))
