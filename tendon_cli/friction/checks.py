"""What cannot be fitted honestly is refused here, with the reason."""

from __future__ import annotations

import math

import numpy as np

from tendon_cli.errors import InputError
from tendon_cli.friction.estimate import Estimate, Slipping
from tendon_cli.friction.reading.readings import Floats, Integers, Readings
from tendon_cli.friction.resolution import resolution_of

_PLAUSIBLE_GAIN = math.log(1.1)
_LEVELS_FOR_OFFSET = 1.25
_LARGEST_RATIO = 20.0


def check_forces(readings: Readings, *, raw_log: bool) -> None:
    """Refuse forces that no two working cells give."""
    cells = (readings.cell_1, readings.cell_2)
    if not raw_log:
        for column, cell in enumerate(cells, start=1):
            bad = np.flatnonzero(~(cell > 0.0))
            if len(bad):
                row = int(bad[0])
                wrong = "is missing" if math.isnan(cell[row]) else f"is {cell[row]:g}, at or below zero"
                raise InputError(
                    f'cell {column} ("{readings.names[column - 1]}") {wrong}',
                    where=readings.place(row),
                    hint="a tendon only pulls; check the zero and the sign of the cell",
                )
    if raw_log and readings.time is not None:
        back = np.flatnonzero(np.diff(readings.time) < 0.0)
        if len(back):
            raise InputError(
                "time goes back in this row, so strokes cannot be told",
                where=readings.place(int(back[0]) + 1),
                hint="give one log per file, its rows in order of time",
            )
    fixed = [column for column, cell in enumerate(cells, start=1) if len(np.unique(cell)) == 1]
    if fixed and (raw_log or (len(fixed) == 2 and len(set(readings.directions or ())) > 1)):
        both = "both cells read" if len(fixed) == 2 else f'cell {fixed[0]} ("{readings.names[fixed[0] - 1]}") reads'
        raise InputError(
            f"{both} the same in every row", where=readings.source, hint="is the right column read, the cell alive?"
        )
    _check_ratio(readings)


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


def check_strokes(slipping: Slipping, readings: Readings, *, with_gain: bool, raw_log: bool, resampled: bool) -> None:
    """Refuse too few strokes to tell their scatter."""
    if not len(slipping.stroke):
        what = "no stroke with slipping rows was found" if raw_log else "no reading is left"
        raise InputError(what, where=readings.source, hint="strokes go on until the force ratio no longer changes")
    if not np.any(slipping.bend_angle > 0.0):
        raise InputError("every bend angle is 0", where=readings.source)
    if not np.isfinite(slipping.log_ratio).all():
        hint = "is the right column read, the cell alive?"
        raise InputError("the two forces of a reading are too far apart for a ratio", where=readings.source, hint=hint)
    ways = [len(np.unique(slipping.stroke[slipping.way == way])) for way in (1, -1)]
    total, needed = sum(ways), 3 if with_gain else 2
    if total < needed:
        raise InputError(
            f"{_count(total, raw_log)} used, fewer than the {needed} needed to tell how they scatter",
            where=readings.source,
            hint="repeat the measurement: five or more in each direction is good",
        )
    if resampled and min(way for way in ways if way or with_gain) < 3:
        raise InputError(
            f"{ways[0]} and {ways[1]} strokes in the two directions: robust and offset fits need 3 in each",
            where=readings.source,
        )


def _count(number: int, raw_log: bool) -> str:
    noun = "slipping stroke" if raw_log else "settled reading"
    return f"{number} {noun}{'' if number == 1 else 's'}"


def check_offset(slipping: Slipping, readings: Readings) -> None:
    """Refuse zero offsets where the force levels are too alike: a shift of zero then looks like another gain."""
    for way, name in ((1, "toward the motor"), (-1, "toward the load")):
        load = slipping.load[slipping.way == way]
        span = float(np.quantile(load, 0.98) / np.quantile(load, 0.02)) if len(load) else 0.0
        if span < _LEVELS_FOR_OFFSET:
            seen = f"span a factor of {span:.2f}" if span else "are missing"
            raise InputError(
                f"the zero offsets cannot be told: forces {seen} {name}, and {_LEVELS_FOR_OFFSET} is needed",
                where=readings.source,
                hint="measure with several weights, or zero the cells unloaded and leave --offset out",
            )


def check_result(
    estimate: Estimate,
    slipping: Slipping,
    readings: Readings,
    rows: Integers,
    *,
    with_gain: bool,
    raw_log: bool,
) -> None:
    """Refuse forces that say friction helps the motion."""
    travel = slipping.way * (slipping.log_ratio - estimate.log_gain)
    noise = 2.0 * _rounding(slipping)
    if not raw_log and estimate.offsets is None:
        wrong = np.flatnonzero(travel < -noise - 0.25 * abs(estimate.friction) * slipping.bend_angle)
        if len(wrong) and len(wrong) < len(travel):
            raise InputError(
                "friction would help the motion in this reading, against the others",
                where=readings.place(int(rows[wrong[0]])),
                hint="are its two forces, or its direction, swapped?",
            )
    if estimate.friction <= 0.0:
        raise InputError(
            f"friction would help the motion: the coefficient comes out as {estimate.friction:.4g}",
            where=readings.source,
            hint="check the directions, and which cell is at the motor (--motor)",
        )
    _check_gain(estimate, slipping, readings, with_gain and not raw_log and estimate.offsets is None)


def _check_gain(estimate: Estimate, slipping: Slipping, readings: Readings, judge: bool) -> None:
    """Refuse both directions on the same side of ratio 1, unless a small mismatch of the cells explains it."""
    gain = abs(estimate.log_gain)
    if judge and gain > max(estimate.friction * float(slipping.bend_angle.max()), _PLAUSIBLE_GAIN):
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
