"""Fit of a friction coefficient: read, prepare, estimate, add up the uncertainty, remark."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import replace
from os import PathLike
from typing import Any, TypeAlias

import numpy as np
import pandas as pd

from tendon_cli.errors import InputError, UsageError
from tendon_cli.files import path_of
from tendon_cli.fits.friction.budget import (
    FrictionUncertainty,
    late_error_of,
    readings_without_load,
    uncertainty_of,
    zero_errors_of,
)
from tendon_cli.fits.friction.directions import unread_direction
from tendon_cli.fits.friction.effects import DELAY
from tendon_cli.fits.friction.estimate import FrictionEstimate, estimate, why_no_limit
from tendon_cli.fits.friction.fit_result import DirectionFit, Fit, PlainAnswer
from tendon_cli.fits.friction.friction_remarks import Remarks, doubts_of, strokes_used
from tendon_cli.fits.friction.models import fit_model
from tendon_cli.fits.friction.prepare import SECONDS, PreparedLog, prepare
from tendon_cli.fits.friction.readings import Readings, concatenate, read_readings
from tendon_cli.fits.friction.rig import (
    BendAngle,
    bend_angle_of,
    bend_angles,
    cell_uncertainty_of,
    force_of,
)
from tendon_cli.fits.friction.strokes import by_file, presliding_of, speed_of, strokes_of
from tendon_cli.fits.friction.usable_rows import INSIDE, PARTIAL, USED, Log
from tendon_cli.fits.given_logs import given_logs
from tendon_cli.fits.log_rows import Floats
from tendon_cli.units import shorten

_FAR_FROM_PLAIN = 1.0
"""Difference from the plain answer, as a share of it, from which the two have nothing in common."""
Name: TypeAlias = str | PathLike[str]
_PLAUSIBLE_GAIN = math.log(1.1)
"""Log of the largest ratio of the cells' gains that calibration may leave."""


def fit_friction(
    path: Name | Sequence[Name] | pd.DataFrame | Mapping[str, Any],
    bend_angle: str | float | None = None,
    *,
    route: Name | None = None,
    path_smoothing: str | float | None = None,
    cell_1: str | int | None = None,
    cell_2: str | int | None = None,
    motor: str | None = None,
    direction: str | None = None,
    position: str | None = None,
    zero_motor: str | float | None = None,
    zero_load: str | float | None = None,
    cell_uncertainty: str | None = None,
) -> Fit:
    """Fit the friction coefficient, with its uncertainty, to the readings of two load cells.

    Without a bend angle the answer is μφ.

    Args:
        path: A CSV, a list of CSVs that are one fit, a DataFrame or a mapping of names to arrays.
        bend_angle: A text such as "144 deg +/- 2 deg", or a number in rad.
        route: A CSV of way-points x, y and z along the sheath, instead of `bend_angle`; the bend
            angle is taken from it with its uncertainty.
        path_smoothing: Noise of the way-points, such as "0.5 mm", or a number in m.
        cell_1: Header of the first cell's column, or its number from 1, if it is not a known one.
        cell_2: Header of the column of the second cell.
        motor: "1" or "2", the cell at the motor; inferred if it is not given.
        direction: Header of the column that says when the motor pulls, releases and rests.
        position: Name of the column of the motor's position or speed.
        zero_motor: Reading of the motor's cell without load.
        zero_load: Reading of the load's cell without load.
        cell_uncertainty: Standard uncertainty of a cell's zero, gain and delay, such as
            "0.2 N, 0.5 %, 5 ms".

    Raises:
        UsageError: if an argument is wrong.
        InputError: if a file is wrong, or shows no friction.

    >>> import tendon_cli as tendon
    >>> fit = tendon.fit_friction("readings.csv", bend_angle="144 deg")
    >>> round(fit.friction, 3)
    0.074
    """
    if motor not in {None, "1", "2"}:
        raise UsageError(f'"{motor}" is not a load cell', where="--motor", hint='"1" or "2"')
    bend = bend_angle_of(bend_angle, None if route is None else path_of(route), path_smoothing)
    sources = given_logs(path)
    parts = []
    for source in sources:
        read = read_readings(
            source, cell_1=cell_1, cell_2=cell_2, direction=direction, position=position
        )
        parts.append(read)
    readings = concatenate(parts)
    zeros = (
        force_of(zero_motor, "--zero-motor", readings.unit),
        force_of(zero_load, "--zero-load", readings.unit),
    )
    are_stated = (zero_motor is not None, zero_load is not None)
    zero_error, gain_error, delay_error = cell_uncertainty_of(cell_uncertainty, readings.unit)
    # Forces of 1e-320 are above zero, and their ratios overflow: the checks refuse them, and need
    # no other warning.
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        angles, angle_share, bend = bend_angles(readings, bend)
        prepared = prepare(readings, angles, motor, zeros)
        result = _estimated(readings, prepared, zero_error)
        time_unit = readings.time_unit or "unit of the file's time"
        rows = _rows(readings, prepared, result, angles)
        bare = readings_without_load(rows)
        error = uncertainty_of(
            result,
            prepared.log,
            unit=readings.unit or "unit of the file",
            time_unit=time_unit,
            bend_share=angle_share,
            zero_errors=zero_errors_of(result, zero_error, are_stated, bare),
            gain_error=gain_error,
            late_error=late_error_of(
                result, prepared.log, delay_error, SECONDS.get(readings.time_unit or "")
            ),
        )
        fit = _assembled(readings, prepared, result, error, bend, rows)
        column = unread_direction(readings)
        _check_strokes(fit, column)
        fit = replace(fit, warnings=(*doubts_of(fit, column), *fit.warnings))
        remarks = Remarks(fit, prepared.log, result, time_unit, zeros, any(are_stated), bare)
        return replace(
            fit,
            checks=tuple(remarks.checks),
            notes=tuple(remarks.notes),
            warnings=tuple(remarks.warnings),
        )


def _estimated(readings: Readings, prepared: PreparedLog, zero: float | None) -> FrictionEstimate:
    """Estimate μ; refuse readings in which nothing slips, or friction would help the motion.

    `zero` is the stated standard uncertainty of the cells' zero; None if it is not stated.
    """
    result = estimate(prepared.log, zero)
    reason: str | None = "no stroke slips: the force ratio reaches no limit"
    if result is not None:
        reason = why_no_limit(prepared.log, result)
    if result is None or reason:
        raise InputError(
            str(reason),
            where=readings.source,
            hint="make the strokes longer, until the force ratio settles",
        )
    _check_resists(readings, prepared, result)
    return result


def _check_resists(readings: Readings, prepared: PreparedLog, result: FrictionEstimate) -> None:
    """Refuse readings in which friction would help the motion."""
    log = prepared.log
    average = result.average
    hint = "check the directions, and which cell is at the motor (--motor)"
    if log.settled and not average.best.effects:
        rounding = np.hypot(log.steps[0] / log.motor, log.steps[1] / log.load) / math.sqrt(3.0)
        travel = log.way * (log.log_ratio - average.log_gain)
        wrong = np.flatnonzero(travel < -rounding - 0.25 * abs(average.friction) * log.bend)
        if 0 < len(wrong) < len(travel):
            problem = "friction would help the motion in this reading, but not in the others"
            where = readings.place(int(prepared.rows[wrong[0]]))
            raise InputError(problem, where=where, hint=hint)
    if average.friction <= 0.0:
        raise InputError(
            f"friction would help the motion: the coefficient comes out as {average.friction:.4g}",
            where=readings.source,
            hint=hint,
        )
    gain = abs(average.log_gain)
    if log.settled and gain > max(average.friction * float(log.bend.max()), _PLAUSIBLE_GAIN):
        differ = f"the cells' gains differ by {100.0 * (math.exp(gain) - 1.0):.0f} %"
        raise InputError(
            f"friction would help the motion in one direction, unless {differ}",
            where=readings.source,
            hint="check the directions;"
            " calibrate the cells against each other with the same weight",
        )


def _check_strokes(fit: Fit, column: str) -> None:
    """Refuse a log most of whose strokes are left out, if the rows show another number.

    `column` may say the direction but is not read; "" if there is none.
    """
    if not fit.leaves_out_most or abs(fit.from_plain) < _FAR_FROM_PLAIN:
        return
    problem = (
        f"{strokes_used(fit)} found can be used, and the rows as a whole show another coefficient"
    )
    hint = "rows without load may be read as strokes: cut them off, or name them rest in a column"
    if column:
        name = shlex.quote(column)
        hint = (
            f'"{shorten(column, 30)}" looks like the direction but is not read: --direction {name}'
        )
    raise InputError(problem, where=fit.source, hint=hint)


def _assembled(
    readings: Readings,
    prepared: PreparedLog,
    result: FrictionEstimate,
    error: FrictionUncertainty,
    bend: BendAngle | None,
    rows: pd.DataFrame,
) -> Fit:
    """Put the result together, still without checks and their remarks."""
    log = prepared.log
    average = result.average
    directions = {}
    for name, way in (("toward_motor", 1), ("toward_load", -1)):
        direction = _direction(log, result, way)
        if direction is not None:
            directions[name] = direction
    strokes = strokes_of(rows, average.friction, bend is not None, readings.files)
    mean = float(np.mean(result.points.bend))
    stated = bend or BendAngle(None, 0.0, "not given")
    return Fit(
        friction_bend=average.friction * mean,
        bend_angle=mean if bend else None,
        uncertainty=error,
        gain_ratio=math.exp(average.log_gain),
        by_direction=directions,
        plain=_plain(log, result, directions),
        bend=stated,
        motor=prepared.motor,
        is_log=not log.settled,
        rows=rows,
        stroke_table=strokes,
        speed=speed_of(strokes),
        presliding=None if log.settled else presliding_of(rows),
        files=by_file(strokes, readings.files),
        points=_point_table(result),
        checks=(),
        notes=(*stated.notes, *readings.notes, *prepared.notes),
        warnings=(*stated.warnings, *prepared.warnings),
        unit=readings.unit,
        source=readings.source,
        sha256=readings.sha256,
    )


def _point_table(result: FrictionEstimate) -> pd.DataFrame:
    """Tabulate the means that the line goes through, their misfit, and the fitted effects."""
    points = result.points
    best = result.average.best
    # A delay that was found is taken out of the readings before the last fit.
    seconds = result.delay
    if DELAY in best.effects:
        seconds += best.value(DELAY)[0]
    delay = np.zeros(len(points.way)) if points.rate is None else seconds * points.rate
    effects = best.shape(points)
    if points.rate is not None:
        effects = effects + result.delay * points.rate
    columns: dict[str, Any] = {
        "way": points.way,
        "force": points.load,
        "misfit": best.residual + effects,
        "effects": effects,
        "delay": delay,
    }
    if points.rate is not None:
        columns["rate"] = points.rate
    return pd.DataFrame(columns)


def _direction(log: Log, result: FrictionEstimate, way: int) -> DirectionFit | None:
    """Fit μ of one direction as the paper does, and find its plain answer.

    The gain is taken as 1, and cells have no offsets. Return None if no reading of the direction
    is used.
    """
    selected = (result.points.way == way) & (result.points.bend > 0.0)
    if not selected.any():
        return None
    points = result.points.select(selected)
    model = fit_model(points, (), {}, 1.0)
    beyond = (log.bend > 0.0) & ((log.log_ratio > log.middle) == (way > 0))
    if log.settled or not beyond.any():
        beyond &= log.way == way
    plain = math.nan
    if beyond.any():
        plain = float(np.median((way * log.log_ratio[beyond]) / log.bend[beyond]))
    return DirectionFit(
        friction=model.friction,
        standard_error=model.error if points.strokes > 1 else None,
        plain=plain,
        used=int((log.way[result.used] == way).sum()),
    )


def _plain(log: Log, result: FrictionEstimate, directions: dict[str, DirectionFit]) -> PlainAnswer:
    """Return the plain answer, and the reasons why the fit differs from it."""
    plain = float(np.mean([direction.plain for direction in directions.values()]))
    used = result.used & (log.bend > 0.0)
    ways = log.way[used]
    frictions = ways * log.log_ratio[used] / log.bend[used]
    medians = [np.median(frictions[ways == way]) for way in np.unique(ways)]
    without_rows = float(np.mean(medians))
    return PlainAnswer(
        friction=plain,
        moved_by_rows=(without_rows - plain) / result.friction,
        moved_by_fit=(result.friction - without_rows) / result.friction,
    )


def _rows(
    readings: Readings, prepared: PreparedLog, result: FrictionEstimate, angles: Floats
) -> pd.DataFrame:
    """Tabulate every reading with its use, as `Fit.rows` has it.

    Effects of the rig are part of the line, and are not subtracted from the readings.
    """
    log = prepared.log
    motor, load = prepared.cells
    line = result.friction * log.way * log.bend + result.average.log_gain + result.shape
    has_ratio = (motor > 0.0) & (load > 0.0)
    left_out = ["cell_1", "cell_2", "direction", "stroke", "bend_uncertainty"]
    stated = readings.rows.drop(columns=left_out, errors="ignore")
    if readings.position_is_speed:
        stated = stated.rename(columns={"position": "speed"})

    def placed(values: Any, elsewhere: Any) -> Any:
        """Return a column with values in the rows of the log, and others elsewhere."""
        column = np.array(np.broadcast_to(elsewhere, len(motor)))
        column[prepared.rows] = values
        return column

    unused = np.where(result.reached[log.stroke], INSIDE, PARTIAL)
    set_aside = np.where(prepared.codes == USED, INSIDE, prepared.codes)
    log_motor = np.log(np.where(has_ratio, motor, np.nan))
    log_load = np.log(np.where(has_ratio, load, np.nan))
    return stated.assign(
        file=stated.get("file", 0),
        motor=motor,
        load=load,
        way=placed(log.way, 0),
        bend_angle=angles,
        run=placed(log.stroke, -1),
        residual=placed(np.where(result.used, log.log_ratio - line, np.nan), np.nan),
        code=placed(np.where(result.used, USED, unused), set_aside),
        used=placed(result.used, elsewhere=False),
        log_ratio=log_motor - log_load,
    )
