"""From readings to a friction coefficient: prepare, estimate, put the uncertainty together, remark."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from os import PathLike
from typing import Any, TypeAlias

import numpy as np
import pandas as pd

from tendon_cli.errors import InputError, UsageError
from tendon_cli.files import path_of
from tendon_cli.friction.budget import FrictionUncertainty, uncertainty_of
from tendon_cli.friction.estimate import FrictionEstimate, estimate, never_rests
from tendon_cli.friction.fit_result import DirectionFit, Fit, Plain
from tendon_cli.friction.models import fit_model
from tendon_cli.friction.prepare import Prepared, prepare
from tendon_cli.friction.reading.readings import Floats, Readings, concatenate, read_readings
from tendon_cli.friction.remarks import Remarks
from tendon_cli.friction.rig import BendAngle, bend_angle_of, bend_angles, cells_of, force_of
from tendon_cli.friction.strokes import by_file, presliding_of, speed_of, strokes_of
from tendon_cli.friction.usable_rows import INSIDE, PARTIAL, USED, Log

Name: TypeAlias = str | PathLike[str]
_PLAUSIBLE_GAIN = math.log(1.1)


def fit_friction(
    path: Name | Sequence[Name] | pd.DataFrame | Mapping[str, Any],
    bend_angle: str | float | None = None,
    *,
    route: Name | None = None,
    path_smoothing: str | float | None = None,
    cell_1: str | None = None,
    cell_2: str | None = None,
    motor: str | None = None,
    position: str | None = None,
    zero_motor: str | float | None = None,
    zero_load: str | float | None = None,
    cell_uncertainty: str | None = None,
) -> Fit:
    """The friction coefficient from the readings of two load cells, with its uncertainty.

    `path` is a CSV, a list of CSVs that are one fit, a DataFrame or a mapping of names to arrays. `position` names the
    column of the motor's position or speed, `zero_motor` and `zero_load` are what the cells read without load,
    `cell_uncertainty` is that of a cell's zero and gain, "0.2 N, 0.5 %".

    `bend_angle` is a text such as "144 deg +/- 2 deg", or a number in rad. Instead, `route` is a CSV of way-points x, y
    and z along the sheath, whose bend angle is taken with its uncertainty, and `path_smoothing` their noise, such as
    "0.5 mm". Without a bend angle the answer is μφ. Raises UsageError for what is asked, InputError for the files.

    >>> import tendon_cli as tendon
    >>> fit = tendon.fit_friction("readings.csv", bend_angle="144 deg")
    >>> round(fit.friction, 3)
    0.074
    """
    if motor not in {None, "1", "2"}:
        raise UsageError(f'"{motor}" is no load cell', where="--motor", hint='"1" or "2"')
    bend = bend_angle_of(bend_angle, None if route is None else path_of(route), path_smoothing)
    sources: list[Any] = list(path) if isinstance(path, list | tuple) else [path]
    sources = [path_of(each) if isinstance(each, str | PathLike) else each for each in sources]
    readings = concatenate(
        [read_readings(each, cell_1=cell_1, cell_2=cell_2, position=position) for each in sources]
    )
    zeros = (
        force_of(zero_motor, "--zero-motor", readings.unit),
        force_of(zero_load, "--zero-load", readings.unit),
    )
    cells = cells_of(cell_uncertainty, readings.unit)
    # Forces of 1e-320 are above zero, and their ratios overflow: the checks refuse them, and need no other warning.
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        angles, angle_share, bend = bend_angles(readings, bend)
        prepared = prepare(readings, angles, motor, zeros)
        result = _estimated(readings, prepared, cells)
        error = uncertainty_of(
            result, prepared.log, readings.unit or "unit of the file", angle_share, cells
        )
        fit = _assembled(
            readings, prepared, result, error, bend, _rows(readings, prepared, result, angles)
        )
        seen = Remarks(fit, prepared.log, result, readings.time_unit, any(zeros))
        return replace(
            fit, checks=tuple(seen.checks), notes=tuple(seen.notes), warnings=tuple(seen.warnings)
        )


def _estimated(
    readings: Readings, prepared: Prepared, cells: tuple[float, float] | None
) -> FrictionEstimate:
    """The estimate; refused if nothing slips, or if friction would help the motion."""
    log, source = prepared.log, readings.source
    result = estimate(log, cells[0] if cells else None)
    moves = (
        "no stroke slips: the force ratio reaches no limit"
        if result is None
        else never_rests(log, result)
    )
    if result is None or moves:
        raise InputError(
            moves or "", where=source, hint="make the strokes longer, until the force ratio rests"
        )
    average, hint = result.average, "check the directions, and which cell is at the motor (--motor)"
    if log.settled and not average.best.effects:
        rounding = np.hypot(log.steps[0] / log.motor, log.steps[1] / log.load) / math.sqrt(3.0)
        travel = log.way * (log.log_ratio - average.log_gain)
        wrong = np.flatnonzero(travel < -rounding - 0.25 * abs(average.friction) * log.bend)
        if 0 < len(wrong) < len(travel):
            problem = "friction would help the motion in this reading, against the others"
            raise InputError(problem, where=readings.place(int(prepared.rows[wrong[0]])), hint=hint)
    if average.friction <= 0.0:
        problem = (
            f"friction would help the motion: the coefficient comes out as {average.friction:.4g}"
        )
        raise InputError(problem, where=source, hint=hint)
    gain = abs(average.log_gain)
    if log.settled and gain > max(average.friction * float(log.bend.max()), _PLAUSIBLE_GAIN):
        unless = f"unless the cells' gains differ by {100.0 * (math.exp(gain) - 1.0):.0f} %"
        hint = "check the directions; calibrate the cells against each other with the same weight"
        raise InputError(
            f"friction would help the motion in one direction, {unless}", where=source, hint=hint
        )
    return result


def _assembled(
    readings: Readings,
    prepared: Prepared,
    result: FrictionEstimate,
    error: FrictionUncertainty,
    bend: BendAngle | None,
    rows: pd.DataFrame,
) -> Fit:
    """What is reported of an estimate, but for what is remarked of it."""
    log, average, points = prepared.log, result.average, result.points
    ways = {"toward_motor": 1, "toward_load": -1}
    directions = {
        name: part
        for name, way in ways.items()
        if (part := _direction(log, result, way)) is not None
    }
    strokes = strokes_of(rows, average.friction, bend is not None, readings.files)
    mean = float(np.mean(points.bend))
    about = bend or BendAngle(None, 0.0, "not given")
    return Fit(
        friction_bend=average.friction * mean,
        bend_angle=mean if bend else None,
        uncertainty=error,
        gain_ratio=math.exp(average.log_gain),
        by_direction=directions,
        plain=_plain(log, result, directions),
        bend=about,
        motor=prepared.motor,
        is_log=not log.settled,
        rows=rows,
        stroke_table=strokes,
        speed=speed_of(strokes),
        presliding=None if log.settled else presliding_of(rows),
        files=by_file(strokes, readings.files),
        points=_table(result),
        checks=(),
        notes=(*about.notes, *prepared.notes),
        warnings=(*about.warnings, *prepared.warnings),
        unit=readings.unit,
        source=readings.source,
        sha256=readings.sha256,
    )


def _table(result: FrictionEstimate) -> pd.DataFrame:
    """The means that the line goes through, with what it misses them by and what effects do to them."""
    points, best = result.points, result.average.best
    effects = best.shape(points)
    columns = {
        "way": points.way,
        "force": points.load,
        "misfit": best.residual + effects,
        "effects": effects,
    }
    return pd.DataFrame(columns | ({} if points.rate is None else {"rate": points.rate}))


def _direction(log: Log, result: FrictionEstimate, way: int) -> DirectionFit | None:
    """μ of one direction with a gain of 1 and no offsets, as the paper has it, and its plain answer."""
    mine = (result.points.way == way) & (result.points.bend > 0.0)
    if not mine.any():
        return None
    part = result.points.select(mine)
    model = fit_model(part, (), {}, 1.0)
    beyond = (log.bend > 0.0) & ((log.log_ratio > log.middle) == (way > 0))
    beyond &= log.way == way if not beyond.any() or log.settled else True
    plain = (
        float(np.median((way * log.log_ratio[beyond]) / log.bend[beyond]))
        if beyond.any()
        else math.nan
    )
    used = int((log.way[result.used] == way).sum())
    return DirectionFit(model.friction, model.error if part.strokes > 1 else None, plain, used)


def _plain(log: Log, result: FrictionEstimate, directions: dict[str, DirectionFit]) -> Plain:
    """The plain answer, and what moves the fit from it."""
    plain = float(np.mean([part.plain for part in directions.values()]))
    used = result.used & (log.bend > 0.0)
    turn = log.way[used] * log.log_ratio[used] / log.bend[used]
    kept = float(
        np.mean([np.median(turn[log.way[used] == way]) for way in np.unique(log.way[used])])
    )
    return Plain(
        plain, (kept - plain) / result.friction, (result.friction - kept) / result.friction
    )


def _rows(
    readings: Readings, prepared: Prepared, result: FrictionEstimate, angles: Floats
) -> pd.DataFrame:
    """Every reading with what became of it; what effects of the rig do is in the line, not taken off the readings."""
    log, (motor, load) = prepared.log, prepared.cells
    line = result.friction * log.way * log.bend + result.average.log_gain + result.shape
    both = (motor > 0.0) & (load > 0.0)
    not_read = ["cell_1", "cell_2", "direction", "stroke", "bend_uncertainty"]
    stated = readings.rows.drop(columns=not_read, errors="ignore")

    def placed(values: Any, elsewhere: Any) -> Any:
        column = np.array(np.broadcast_to(elsewhere, len(motor)))
        column[prepared.rows] = values
        return column

    inside = np.where(result.reached[log.stroke], INSIDE, PARTIAL)
    return stated.rename(
        columns={"position": "speed"} if readings.position_is_speed else {}
    ).assign(
        file=stated.get("file", 0),
        motor=motor,
        load=load,
        way=placed(log.way, 0),
        bend_angle=angles,
        run=placed(log.stroke, -1),
        residual=placed(np.where(result.used, log.log_ratio - line, np.nan), np.nan),
        code=placed(
            np.where(result.used, USED, inside),
            np.where(prepared.codes == USED, INSIDE, prepared.codes),
        ),
        used=placed(result.used, elsewhere=False),
        log_ratio=np.log(np.where(both, motor, np.nan)) - np.log(np.where(both, load, np.nan)),
    )
