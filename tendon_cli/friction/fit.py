"""From readings to a friction coefficient: what slips, its strokes, the effects of the rig, what to say about it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import UsageError
from tendon_cli.friction import remarks
from tendon_cli.friction.bend import BendAngle, bend_angle_of, bend_angles, parse_bend_angle
from tendon_cli.friction.checks import check_forces, check_result, check_strokes
from tendon_cli.friction.directions import Directions, find_motor
from tendon_cli.friction.effects import DELAY, OFFSETS, Fitted, fit_effects
from tendon_cli.friction.estimate import Slipping, log_ratio_of, points_of, solve
from tendon_cli.friction.reading.readings import Floats, Readings, read_readings
from tendon_cli.friction.result import DirectionFit, Fit, FittedRows, FrictionUncertainty, Parts, SetAside
from tendon_cli.friction.selection import Selection, drop_inside, select
from tendon_cli.friction.uncertainty import uncertainty_of


def fit_file(
    path: Path,
    *,
    bend_angle: str | float | None,
    route: Path | None = None,
    path_smoothing: str | float | None = None,
    cell_1: str | None = None,
    cell_2: str | None = None,
    motor: str | None = None,
    offset: bool | None = None,
    delay: bool | None = None,
    robust: bool = False,
) -> Fit:
    """μ from a CSV of two load cells' readings; raises UsageError for options and InputError for the file.

    `offset` and `delay` force these effects of the rig into the fit, or bar them; None fits them where they are found.
    `route` is a file of way-points along the sheath, which stands for the bend angle, and `path_smoothing` their noise.
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
    readings = read_readings(path, cell_1=cell_1, cell_2=cell_2)
    # Forces of 1e-320 are above zero, and their ratios overflow: the checks refuse them, and need no warning beside.
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        return fit_readings(readings, bend=bend, motor=motor, offset=offset, delay=delay, robust=robust)


def fit_readings(
    readings: Readings,
    *,
    bend: BendAngle | None,
    motor: str | None = None,
    offset: bool | None = None,
    delay: bool | None = None,
    robust: bool = False,
) -> Fit:
    """μ from readings that are already in memory; `bend` is needed where they have no bend angle of their own."""
    angles, angle_share = bend_angles(readings, bend)
    check_forces(readings)
    chosen = select(readings)
    way = find_motor(readings, chosen.side, chosen.meaning, chosen.stroke >= 0, motor)
    cells = (readings.cell_1, readings.cell_2) if way.motor == "1" else (readings.cell_2, readings.cell_1)
    asked = {OFFSETS: offset, DELAY: delay}
    forced = tuple(name for name, wish in asked.items() if wish)
    barred = tuple(name for name, wish in asked.items() if wish is False)
    for again in (True, False):
        slipping = _slipping(readings, cells, way.way, angles, chosen)
        with_gain = len(np.unique(slipping.way[slipping.bend_angle > 0.0])) == 2
        check_strokes(slipping, readings, with_gain=with_gain, is_log=chosen.is_log)
        points = points_of(slipping, robust=robust)
        fitted, known = fit_effects(points, with_gain=with_gain, robust=robust, forced=forced, barred=barred)
        rows = _rows(readings, cells, way.way, angles, chosen, fitted)
        dropped = drop_inside(chosen, rows, fitted.friction) if again else chosen
        if dropped is chosen:
            break
        chosen = dropped
    check_result(fitted, slipping, readings, np.flatnonzero(chosen.stroke >= 0), is_log=chosen.is_log)
    open_to_doubt = {name: effect for name, effect in known.items() if name not in barred}
    uncertainty = uncertainty_of(fitted.linear, slipping, angle_share, fitted.doubt(open_to_doubt))
    fit = _result(readings, bend, way, chosen, slipping, fitted, rows, uncertainty)
    return remarks.judged(fit, fitted, known)


def _result(
    readings: Readings,
    bend: BendAngle | None,
    way: Directions,
    chosen: Selection,
    slipping: Slipping,
    fitted: Fitted,
    rows: FittedRows,
    uncertainty: FrictionUncertainty,
) -> Fit:
    """The fit without its checks, and with what is known of its directions as notes and warnings."""
    return Fit(
        friction=fitted.friction,
        uncertainty=uncertainty,
        gain_ratio=math.exp(fitted.log_gain),
        gain_estimated=fitted.with_gain,
        by_direction=_by_direction(slipping, uncertainty.bend_angle / abs(fitted.friction)),
        bend_angle_text=bend.text if bend else _angles_text(slipping.bend_angle),
        bend_angle_uncertainty_text=bend.uncertainty_text if bend else None,
        bend_angles=tuple(float(angle) for angle in np.unique(slipping.bend_angle)),
        motor=way.motor,
        is_log=chosen.is_log,
        robust=fitted.robust,
        strokes=int(slipping.stroke.max()) + 1,
        rows=rows,
        parts=_parts(fitted),
        set_aside=_set_aside(readings, chosen.reasons),
        checks=(),
        notes=(*(bend.notes if bend else ()), *way.notes),
        warnings=(*(bend.warnings if bend else ()), *way.warnings),
        unit=readings.unit,
        source=readings.source,
        sha256=readings.sha256,
    )


def _slipping(
    readings: Readings, cells: tuple[Floats, Floats], way: npt.NDArray[np.int64], angles: Floats, chosen: Selection
) -> Slipping:
    used = chosen.stroke >= 0
    place = np.linspace(-0.5, 0.5, len(way))
    time = readings.time[used] if readings.time is not None and chosen.is_log else None
    return Slipping(cells[0][used], cells[1][used], way[used], angles[used], chosen.stroke[used], place[used], time)


def _angles_text(angles: Floats) -> str:
    degrees = [f"{math.degrees(angle):.10g} deg" for angle in np.unique(angles)]
    return ", ".join(degrees) if len(degrees) <= 6 else f"{len(degrees)} angles, {degrees[0]} to {degrees[-1]}"


def _by_direction(slipping: Slipping, angle_share: float) -> dict[str, DirectionFit]:
    """μ of each direction with a gain of 1 and no offsets, as the paper has it."""
    found = {}
    for name, way in (("toward_motor", 1), ("toward_load", -1)):
        mine = (slipping.way == way) & (slipping.bend_angle > 0.0)
        if mine.any():
            part = slipping.of(mine)
            points = points_of(part)
            linear = solve(points, [points.way * points.bend_angle])
            uncertainty = None if linear.assumed else uncertainty_of(linear, part, angle_share)
            found[name] = DirectionFit(float(linear.values[0]), uncertainty, int(mine.sum()))
    return found


def _rows(
    readings: Readings,
    cells: tuple[Floats, Floats],
    way: npt.NDArray[np.int64],
    angles: Floats,
    chosen: Selection,
    fitted: Fitted,
) -> FittedRows:
    """Every reading with what became of it; what effects of the rig do is in the line, not taken off the readings."""
    log_ratio = np.full(len(way), np.nan)
    positive = (cells[0] > 0.0) & (cells[1] > 0.0)
    log_ratio[positive] = np.log(cells[0][positive] / cells[1][positive])
    line = log_ratio_of(fitted.friction, fitted.log_gain, way, angles)
    used = chosen.stroke >= 0
    line[used] += fitted.of_effects()
    residual = np.where(used, log_ratio - line, np.nan)
    force = np.sqrt(np.where(positive, cells[0] * cells[1], np.nan))
    return FittedRows(readings.lines, log_ratio, way, angles, chosen.stroke, residual, force, readings.time)


def _parts(fitted: Fitted) -> Parts:
    points = fitted.points
    effects = fitted.of_effects(per_point=True)
    return Parts(points.way, points.force, points.rate, fitted.linear.residual + effects, effects)


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
