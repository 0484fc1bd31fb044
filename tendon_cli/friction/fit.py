"""From readings to a friction coefficient: prepare, estimate, put the uncertainty together, remark."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli.errors import InputError, UsageError
from tendon_cli.friction import remarks
from tendon_cli.friction.bend import BendAngle, bend_angle_of, bend_angles, parse_bend_angle
from tendon_cli.friction.budget import uncertainty_of
from tendon_cli.friction.cells import cells_of, force_of
from tendon_cli.friction.effects import EffectPriors, Points
from tendon_cli.friction.estimate import Estimated, Log, estimate
from tendon_cli.friction.models import fit_model
from tendon_cli.friction.prepare import Prepared, prepare
from tendon_cli.friction.reading.readings import Floats, Readings, frame_readings, joined, read_readings
from tendon_cli.friction.result import DirectionFit, Fit, Parts, Plain, SetAside
from tendon_cli.friction.rows import INSIDE, PARTIAL, REASONS, FittedRows, resolution_of
from tendon_cli.friction.strokes import by_file, disagreement, presliding_of, speed_of, strokes_of

_PLAUSIBLE_GAIN = math.log(1.1)
_MOST_STRETCHES = 20


def fit_file(
    path: Path | Sequence[Path] | Any,
    *,
    bend_angle: str | float | None = None,
    route: Path | None = None,
    path_smoothing: str | float | None = None,
    cell_1: str | None = None,
    cell_2: str | None = None,
    motor: str | None = None,
    position: str | None = None,
    zero_motor: str | float | None = None,
    zero_load: str | float | None = None,
    cell_uncertainty: str | None = None,
) -> Fit:
    """μ from CSVs of two load cells' readings, or from a DataFrame or a mapping of arrays.

    `route` is a file of way-points along the sheath, which stands for the bend angle, and `path_smoothing` their noise.
    `position` names the column of the motor's position or speed. `zero_motor` and `zero_load` are what the cells read
    without load ("0.4 kgf", or a number in the unit of the file), `cell_uncertainty` is the standard uncertainty of a
    cell's zero and gain ("0.2 N, 0.5 %"). Several files are one fit. Raises UsageError for options and InputError.
    """
    if motor not in {None, "1", "2"}:
        raise UsageError(f'"{motor}" is no load cell', where="--motor", hint='"1" or "2"')
    given = bend_angle if isinstance(bend_angle, str | None) else f"{float(bend_angle)!r} rad"
    if route is not None and given is not None:
        raise UsageError("the bend angle is given twice: by a route, too", where="--bend-angle, --route")
    if route is None and path_smoothing is not None:
        raise UsageError("there is no route to smooth", where="--path-smoothing", hint="--route names its file")
    bend = parse_bend_angle(given) if given is not None else None
    if route is not None:
        bend = bend_angle_of(route, path_smoothing)
    columns = {"cell_1": cell_1, "cell_2": cell_2, "position": position}
    if isinstance(path, Path):
        parts = [read_readings(path, **columns)]
    elif isinstance(path, Sequence):
        parts = [read_readings(each, **columns) for each in path]
    else:
        parts = [frame_readings(path, **columns)]
    readings = joined(parts)
    zeros = force_of(zero_motor, "--zero-motor", readings.unit), force_of(zero_load, "--zero-load", readings.unit)
    cells = cells_of(cell_uncertainty, readings.unit)
    return fit_readings(readings, bend=bend, motor=motor, zeros=zeros, cells=cells)


def fit_readings(
    readings: Readings,
    *,
    bend: BendAngle | None,
    motor: str | None = None,
    zeros: tuple[float, float] = (0.0, 0.0),
    cells: tuple[float, float] | None = None,
) -> Fit:
    """μ from readings that are in memory.

    `zeros` are the readings of the motor's and the load's cell without load, `cells` the standard uncertainty of a
    cell's zero and, as a share, of its gain.
    """
    # Forces of 1e-320 are above zero, and their ratios overflow: the checks refuse them, and need no warning beside.
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        angles, angle_share, given = bend_angles(readings, bend)
        prepared = prepare(readings, angles, motor, zeros)
        log = prepared.log
        _check_enough(readings, log)
        found = estimate(log, cells[0] if cells else None)
        moves = (
            "no stroke slips: the force ratio reaches no limit" if found is None else remarks.never_rests(log, found)
        )
        if found is None or moves:
            hint = "make the strokes longer, until the force ratio rests"
            raise InputError(moves or "", where=readings.source, hint=hint)
        _check_result(readings, prepared, found)
        error = uncertainty_of(found.average, found, log, readings.unit or "unit of the file", angle_share, cells)
        directions = {name: part for name, way in (("toward_motor", 1), ("toward_load", -1))
                      if (part := _direction(log, found, way)) is not None}  # fmt: skip
        plain = _plain(log, found, directions)
        codes = _codes(prepared, found)
        seen = remarks.Remarks(
            log, found, error, directions, plain, codes, readings.unit, readings.time_unit, any(zeros), given
        )  # fmt: skip
    mean = float(np.mean(found.points.bend))
    rows = _rows(readings, prepared, found, angles)
    files = readings.files or (readings.source,)
    strokes = strokes_of(rows, found.average.friction, given, files, readings.file)
    each_file = by_file(strokes, files) if len(files) > 1 else ()
    apart = disagreement(each_file)
    return Fit(
        friction_bend=found.average.friction * mean,
        bend_angle=mean if given else None,
        uncertainty=error,
        gain_ratio=math.exp(found.average.log_gain),
        gain_estimated=found.points.both_ways,
        by_direction=directions,
        plain=plain,
        bend_angle_text=bend.text if bend else _angles_text(found.points.bend) if given else "not given",
        bend_angle_uncertainty_text=bend.uncertainty_text if bend else None,
        bend_angles=tuple(float(angle) for angle in np.unique(log.bend[found.used])) if given else (),
        motor=prepared.motor.cell,
        is_log=not log.settled,
        strokes=found.points.strokes,
        rows=rows,
        stroke_table=strokes,
        speed=speed_of(strokes),
        presliding=presliding_of(rows) if not log.settled else None,
        files=each_file,
        parts=_parts(found),
        set_aside=_set_aside(codes, readings),
        checks=tuple(seen.checks),
        notes=(*(bend.notes if bend else ()), *prepared.motor.notes, *seen.notes),
        warnings=(*(bend.warnings if bend else ()), *prepared.motor.warnings, *seen.warnings, *filter(None, [apart])),
        unit=readings.unit,
        source=readings.source,
        sha256=readings.sha256,
    )


def _check_enough(readings: Readings, log: Log) -> None:
    """Refuse too few rows."""
    used, needed = len(log.way), 3 if len(np.unique(log.way)) == 2 else 2
    if used < needed:
        noun = "reading" if used == 1 else "readings"
        raise InputError(
            f"{used} {noun} used, fewer than the {needed} needed to tell how they scatter",
            where=readings.source,
            hint="repeat the measurement: five strokes or more in each direction are good",
        )
    if not np.any(log.bend > 0.0):
        raise InputError("every bend angle is 0", where=readings.source)


def _check_result(readings: Readings, prepared: Prepared, found: Estimated) -> None:
    """Refuse forces that say friction helps the motion."""
    log, average = prepared.log, found.average
    travel = log.way * (log.log_ratio - average.log_gain)
    if log.settled and not average.best.effects:
        rounding = np.hypot(*(resolution_of(cell) / cell for cell in (log.motor, log.load))) / math.sqrt(3.0)
        wrong = np.flatnonzero(travel < -rounding - 0.25 * abs(average.friction) * log.bend)
        if len(wrong) and len(wrong) < len(travel):
            raise InputError(
                "friction would help the motion in this reading, against the others",
                where=readings.place(int(prepared.rows[wrong[0]])),
                hint="are its two forces, or its direction, swapped?",
            )
    if average.friction <= 0.0:
        raise InputError(
            f"friction would help the motion: the coefficient comes out as {average.friction:.4g}",
            where=readings.source,
            hint="check the directions, and which cell is at the motor (--motor)",
        )
    gain = abs(average.log_gain)
    if log.settled and gain > max(average.friction * float(log.bend.max()), _PLAUSIBLE_GAIN):
        raise InputError(
            "friction would help the motion in one direction, unless the cells' gains differ by"
            f" {100.0 * (math.exp(gain) - 1.0):.0f} %",
            where=readings.source,
            hint="check the directions; calibrate the cells against each other with the same weight",
        )


def _angles_text(angles: Floats) -> str:
    degrees = [f"{math.degrees(angle):.10g} deg" for angle in np.unique(angles)]
    return ", ".join(degrees) if len(degrees) <= 6 else f"{len(degrees)} angles, {degrees[0]} to {degrees[-1]}"


def _direction(log: Log, found: Estimated, way: int) -> DirectionFit | None:
    """μ of one direction with a gain of 1 and no offsets, as the paper has it, and its plain answer."""
    points = found.points
    mine = (points.way == way) & (points.bend > 0.0)
    if not mine.any():
        return None
    _, stroke = np.unique(points.stroke[mine], return_inverse=True)
    part = Points(
        points.motor[mine], points.load[mine], points.way[mine], points.bend[mine], stroke, None, points.place[mine],
        points.duration, points.noise,
    )  # fmt: skip
    model = fit_model(part, (), EffectPriors({}), 1.0)
    error = math.sqrt(max(float(model.covariance[0, 0]), 0.0)) if part.strokes > 1 else None
    beyond = (log.bend > 0.0) & ((log.log_ratio > log.middle) == (way > 0))
    beyond &= log.way == way if not beyond.any() or log.settled else True
    plain = float(np.median((way * log.log_ratio[beyond]) / log.bend[beyond])) if beyond.any() else math.nan
    return DirectionFit(model.friction, error, int((log.way[found.used] == way).sum()), plain)


def _plain(log: Log, found: Estimated, directions: dict[str, DirectionFit]) -> Plain:
    """The plain answer, and what moves the fit from it."""
    plain = float(np.mean([part.plain for part in directions.values()]))
    used = found.used & (log.bend > 0.0)
    turn = log.way[used] * log.log_ratio[used] / log.bend[used]
    kept = float(np.mean([np.median(turn[log.way[used] == way]) for way in np.unique(log.way[used])]))
    friction = found.average.friction
    return Plain(plain, (kept - plain) / friction, (friction - kept) / friction)


def _codes(prepared: Prepared, found: Estimated) -> np.ndarray:
    """Why each reading is set aside."""
    codes = prepared.codes.copy()
    log = prepared.log
    codes[prepared.codes == 0] = INSIDE
    codes[prepared.rows] = np.where(found.used, 0, np.where(found.reached[log.stroke], INSIDE, PARTIAL))
    return codes


def _rows(readings: Readings, prepared: Prepared, found: Estimated, angles: Floats) -> FittedRows:
    """Every reading with what became of it; what effects of the rig do is in the line, not taken off the readings."""
    log, rows, total = prepared.log, prepared.rows, len(readings.lines)
    motor, load = prepared.cells
    log_ratio, residual = np.full(total, np.nan), np.full(total, np.nan)
    positive = (motor > 0.0) & (load > 0.0)
    log_ratio[positive] = np.log(motor[positive]) - np.log(load[positive])
    way, run, stroke = np.zeros(total, dtype=np.int64), np.full(total, -1), np.full(total, -1)
    way[rows], run[rows] = log.way, log.stroke
    used = rows[found.used]
    line = found.average.friction * log.way * log.bend + found.average.log_gain + found.shape
    residual[used] = (log.log_ratio - line)[found.used]
    _, stroke[used] = np.unique(log.stroke[found.used], return_inverse=True)
    return FittedRows(
        readings.lines, motor, load, log_ratio, way, angles, run, stroke, residual, _codes(prepared, found),
        readings.time, readings.position, readings.position_is_speed,
    )  # fmt: skip


def _parts(found: Estimated) -> Parts:
    points, best = found.points, found.average.best
    effects = best.shape(points.motor, points.load, points.way, points.bend, points.rate, points.mean_force)
    return Parts(points.way, points.load, points.rate, best.residual + effects, effects)


def _set_aside(codes: np.ndarray, readings: Readings) -> tuple[SetAside, ...]:
    """The readings not used, by reason, in the order in which the reasons first come."""
    present = [int(code) for code in np.unique(codes) if code]
    found = []
    for code in sorted(present, key=lambda each: int(np.argmax(codes == each))):
        mine = np.flatnonzero(codes == code)
        first = np.concatenate([[0], np.flatnonzero(np.diff(mine) > 1) + 1])
        last = np.concatenate([first[1:] - 1, [len(mine) - 1]])
        lines = [(int(readings.lines[mine[a]]), int(readings.lines[mine[b]])) for a, b in zip(first, last, strict=True)]
        found.append(SetAside(REASONS[code], len(mine), tuple(lines[:_MOST_STRETCHES])))
    return tuple(found)
