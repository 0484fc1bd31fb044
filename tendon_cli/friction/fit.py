"""From readings to a friction coefficient: what is used, what is set aside, the estimate and what to say about it."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import UsageError
from tendon_cli.friction import remarks
from tendon_cli.friction.bend import BendAngle, parse_bend_angle
from tendon_cli.friction.checks import check_forces, check_offset, check_result, check_strokes
from tendon_cli.friction.directions import find_motor
from tendon_cli.friction.estimate import Estimate, Slipping, by_least_squares, by_leaving_out, log_ratio_of
from tendon_cli.friction.reading.readings import Floats, Readings, read_readings
from tendon_cli.friction.result import DirectionFit, FrictionFit, Rows, SetAside
from tendon_cli.friction.selection import Selection, is_raw_log, select_log, select_settled
from tendon_cli.friction.uncertainty import uncertainty_of


def fit_file(
    path: Path,
    *,
    bend_angle: str | None,
    cell_1: str | None = None,
    cell_2: str | None = None,
    motor: str | None = None,
    offset: bool = False,
    robust: bool = False,
) -> FrictionFit:
    """μ from a CSV of two load cells' readings; raises UsageError for options and InputError for the file."""
    if motor not in {None, "1", "2"}:
        raise UsageError(f'"{motor}" is no load cell', where="--motor", hint='"1" or "2"')
    bend = parse_bend_angle(bend_angle) if bend_angle is not None else None
    readings = read_readings(path, cell_1=cell_1, cell_2=cell_2)
    # Forces of 1e-320 are above zero, and their ratios overflow: the checks refuse them, and need no warning beside.
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        return fit_readings(readings, bend=bend, motor=motor, offset=offset, robust=robust)


def fit_readings(
    readings: Readings,
    *,
    bend: BendAngle | None,
    motor: str | None = None,
    offset: bool = False,
    robust: bool = False,
) -> FrictionFit:
    """μ from readings that are already in memory; `bend` is needed where they have no bend angle of their own."""
    angles = _bend_angles(readings, bend)
    raw_log = is_raw_log(readings)
    check_forces(readings, raw_log=raw_log)
    chosen = select_log(readings) if raw_log else select_settled(readings)
    used = chosen.stroke >= 0
    way = find_motor(readings, chosen.side, chosen.meaning, used, motor)
    cells = (readings.cell_1, readings.cell_2) if way.motor == "1" else (readings.cell_2, readings.cell_1)
    slipping = Slipping(cells[0][used], cells[1][used], way.way[used], angles[used], chosen.stroke[used])
    with_gain = len(np.unique(slipping.way[slipping.bend_angle > 0.0])) == 2
    check_strokes(slipping, readings, with_gain=with_gain, raw_log=raw_log, resampled=offset or robust)
    estimate = _estimate(slipping, readings, with_gain=with_gain, offset=offset, robust=robust)
    check_result(estimate, slipping, readings, np.flatnonzero(used), with_gain=with_gain, raw_log=raw_log)
    fit = FrictionFit(
        friction=estimate.friction,
        uncertainty=uncertainty_of(estimate, slipping, bend),
        gain_ratio=math.exp(estimate.log_gain),
        gain_estimated=with_gain,
        offsets=estimate.offsets,
        by_direction=_by_direction(slipping, bend),
        bend_angle_text=bend.text if bend else _angles_text(angles[used]),
        bend_angle_uncertainty_text=bend.uncertainty_text if bend else None,
        bend_angles=tuple(float(angle) for angle in np.unique(angles[used])),
        motor=way.motor,
        is_log=raw_log,
        robust=robust,
        strokes=int(slipping.stroke.max()) + 1,
        rows=_rows(readings, cells, way.way, angles, chosen, estimate),
        set_aside=_set_aside(readings, chosen.reasons),
        warnings=way.notes,
        source=readings.source,
        sha256=readings.sha256,
    )
    return replace(fit, warnings=fit.warnings + remarks.about(fit))


def _estimate(slipping: Slipping, readings: Readings, *, with_gain: bool, offset: bool, robust: bool) -> Estimate:
    """The estimate that was asked for; offsets are refused where they cannot be told."""
    if offset:
        check_offset(slipping, readings)
    if offset or robust:
        return by_leaving_out(slipping, with_gain, offset, robust)
    return by_least_squares(slipping, with_gain)


def _bend_angles(readings: Readings, bend: BendAngle | None) -> Floats:
    """The bend angle of each reading: from the option or from the column, never guessed and never from both."""
    if readings.bend_angle is None:
        if bend is None:
            raise UsageError(
                f"the bend angle of the sheath is not given, and {readings.source} has no column for it",
                where="--bend-angle",
                hint='measure the total bend between the cells: --bend-angle "144 deg", or a column bend_angle_deg',
            )
        return np.full(len(readings.lines), bend.radians)
    if bend is not None and not np.allclose(readings.bend_angle, bend.radians, rtol=1e-6, atol=0.0):
        raise UsageError(
            f"the bend angle is given twice: {bend.text} and by a column of {readings.source} that says otherwise",
            where="--bend-angle",
            hint="leave the option out to use the column",
        )
    return readings.bend_angle


def _angles_text(angles: Floats) -> str:
    degrees = [f"{math.degrees(angle):.10g} deg" for angle in np.unique(angles)]
    return ", ".join(degrees) if len(degrees) <= 6 else f"{len(degrees)} angles, {degrees[0]} to {degrees[-1]}"


def _by_direction(slipping: Slipping, bend: BendAngle | None) -> dict[str, DirectionFit]:
    found = {}
    for name, way in (("toward_motor", 1), ("toward_load", -1)):
        mine = (slipping.way == way) & (slipping.bend_angle > 0.0)
        if not mine.any():
            continue
        part = slipping.of(mine)
        if part.stroke.max() == 0:
            ratio = float(np.mean(part.log_ratio) / np.mean(part.bend_angle))
            found[name] = DirectionFit(way * ratio, None, int(mine.sum()))
        else:
            estimate = by_least_squares(part, with_gain=False)
            found[name] = DirectionFit(estimate.friction, uncertainty_of(estimate, part, bend), int(mine.sum()))
    return found


def _rows(
    readings: Readings,
    cells: tuple[Floats, Floats],
    way: npt.NDArray[np.int64],
    angles: Floats,
    chosen: Selection,
    estimate: Estimate,
) -> Rows:
    """Every reading with what became of it; the cells' offsets, if estimated, are taken off."""
    less = estimate.offsets or (0.0, 0.0)
    forces = np.stack([cells[0] - less[0], cells[1] - less[1]])
    log_ratio = np.full(len(way), np.nan)
    positive = np.all(forces > 0.0, axis=0)
    log_ratio[positive] = np.log(forces[0, positive] / forces[1, positive])
    line = log_ratio_of(estimate.friction, estimate.log_gain, way, angles)
    residual = np.where(chosen.stroke >= 0, log_ratio - line, np.nan)
    return Rows(readings.lines, log_ratio, way, angles, chosen.stroke, residual, readings.time)


def _set_aside(readings: Readings, reasons: tuple[str, ...]) -> tuple[SetAside, ...]:
    """The readings not used, by reason, in the order in which the reasons first come."""
    why = np.array(reasons, dtype=object)
    found = []
    for reason in dict.fromkeys(reasons):
        if not reason:
            continue
        mine = np.flatnonzero(why == reason)
        stretches = np.split(mine, np.flatnonzero(np.diff(mine) > 1) + 1)
        lines = tuple((int(readings.lines[part[0]]), int(readings.lines[part[-1]])) for part in stretches)
        found.append(SetAside(reason, len(mine), lines))
    return tuple(found)
