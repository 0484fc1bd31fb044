"""What is known of the rig before its readings: the bend angle of its sheath, its cells' zeros and uncertainty."""

from __future__ import annotations

import contextlib
import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tendon_cli.errors import InputError, UsageError
from tendon_cli.friction.reading.header import STANDARD_GRAVITY, force_factor
from tendon_cli.friction.reading.readings import LARGEST_BEND, Floats, Readings
from tendon_cli.friction.reading.table import content_of, name_of
from tendon_cli.units import UnitError, parse_measure, shorten

_SMALLEST_BEND = 1e-3
"""In rad: no friction shows in a sheath that is straighter."""


@dataclass(frozen=True)
class BendAngle:
    """Total curvature ∫κ ds of the sheath between the two cells."""

    radians: float | None
    """None if only an uncertainty is given, for a column of angles."""
    uncertainty: float
    """Standard uncertainty, rad; 0 if none is given."""
    text: str
    """As written, without the uncertainty."""
    uncertainty_text: str | None = None
    notes: tuple[str, ...] = ()
    """Where it comes from, if not from the command line."""
    warnings: tuple[str, ...] = ()


def bend_angle_of(
    given: str | float | None, route: Path | None, smoothing: str | float | None
) -> BendAngle | None:
    """The bend angle as a text, a number in rad, or by a file of way-points; None if it is not given.

    `smoothing` is the noise of the way-points, a text with a unit or a number in m. Raises UsageError for what is no
    angle or no noise, InputError for a file that is no route, or that bends too little or too much for a sheath.
    """
    if route is not None and given is not None:
        raise UsageError(
            "the bend angle is given twice: by a route, too", where="--bend-angle, --route"
        )
    if route is not None:
        return _bend_of_route(route, smoothing)
    if smoothing is not None:
        raise UsageError(
            "there is no route to smooth", where="--path-smoothing", hint="--route names its file"
        )
    if given is None:
        return None
    return _parsed(given if isinstance(given, str) else f"{float(given)!r} rad")


def _parsed(text: str) -> BendAngle:
    """Of "144 deg", "144 deg +/- 2 deg", or "+/- 2 deg" for a column of angles."""
    parts = (
        [part.strip() for part in re.split(r"\+/-|\+-|±", text, maxsplit=1)]
        if len(text) <= 200
        else [text]
    )
    only = len(parts) == 2 and not parts[0]
    try:
        angle = LARGEST_BEND if only else parse_measure(parts[0], "angle").si
        uncertainty = parse_measure(parts[1], "angle").si if len(parts) == 2 else 0.0
    except UnitError as error:
        hint = error.hint or 'write "144 deg" or "144 deg +/- 2 deg"'
        raise UsageError(error.problem, where="--bend-angle", hint=hint) from error
    if not _SMALLEST_BEND <= angle <= LARGEST_BEND:
        size = f"it is at least {_SMALLEST_BEND:g} and at most {LARGEST_BEND:g} rad"
        problem = f'"{shorten(text)}" is not the bend angle of a sheath: {size}'
        raise UsageError(problem, where="--bend-angle", hint="half a turn is 180 deg")
    if not 0.0 <= uncertainty < angle / 2.0:
        problem = f'"{shorten(text)}": the uncertainty is 0 or more and less than half the angle'
        raise UsageError(problem, where="--bend-angle")
    return BendAngle(None if only else angle, uncertainty, *parts)


def _bend_of_route(route: Path, smoothing: str | float | None) -> BendAngle:
    from tendon_cli.studies.way_points import MAX_BYTES, measure_route, route_note

    name = name_of(route)
    content = content_of(route, MAX_BYTES, "--route names a CSV of x, y and z")
    try:
        noise = (
            parse_measure(smoothing, "length").si
            if isinstance(smoothing, str)
            else float(smoothing or 0.0)
        )
    except UnitError as error:
        raise UsageError(
            error.problem, where="--path-smoothing", hint=error.hint or 'write "0.5 mm"'
        ) from error
    if not 0.0 <= noise < math.inf:
        raise UsageError(
            f'"{smoothing}" is no noise of way-points: it is 0 or more', where="--path-smoothing"
        )
    measured, warnings = measure_route(content, name, noise)
    bend, error_of = measured.bend_angle, measured.standard_error
    if bend < _SMALLEST_BEND or error_of >= bend / 2.0:
        problem = f"bends by {bend:.3g} rad ± {error_of:.2g} rad: not enough to show friction"
        raise InputError(
            problem,
            where=name,
            hint="measure friction on a sheath that bends by half a turn or more",
        )
    texts = f"{math.degrees(bend):.2f} deg of {name}", f"{math.degrees(error_of):.2g} deg"
    return BendAngle(bend, error_of, *texts, (route_note(measured, name),), tuple(warnings))


def bend_angles(
    readings: Readings, bend: BendAngle | None
) -> tuple[Floats, float, BendAngle | None]:
    """The bend angle of each reading, their standard uncertainty as a share of them, and where they come from.

    Angles are never guessed and never taken from both the option and a column; without any, all are 1 and the
    coefficient is μφ. Their errors are counted as if all had the same one.
    """
    angles, known = readings.column("bend_angle"), readings.column("bend_uncertainty")
    source, total, where = readings.source, len(readings.rows), "--bend-angle"
    if angles is None:
        if bend is None:
            return np.ones(total), 0.0, None
        if bend.radians is None:
            problem = (
                f"the bend angle of the sheath is not given, and {source} has no column for it"
            )
            hint = 'measure it between the cells: --bend-angle "144 deg", --route, or a column bend_angle_deg'
            raise UsageError(problem, where=where, hint=hint)
        return np.full(total, bend.radians), bend.uncertainty / bend.radians, bend
    if (
        bend is not None
        and bend.radians is not None
        and not np.allclose(angles, bend.radians, rtol=1e-6, atol=0.0)
    ):
        problem = f"the bend angle is given twice: {bend.text} and by a column of {source} that says otherwise"
        hint = 'leave the option out to use the column; "+/- 2 deg" alone says how well the column is known'
        raise UsageError(problem, where=where, hint=hint)
    if bend is not None and bend.uncertainty:
        if known is not None:
            problem = f"the uncertainty of the bend angle is given twice: here and by a column of {source}"
            raise UsageError(problem, where=where)
        known = np.full(total, bend.uncertainty)
    bent, degrees = angles > 0.0, [f"{math.degrees(angle):.10g} deg" for angle in np.unique(angles)]
    text = (
        ", ".join(degrees)
        if len(degrees) <= 6
        else f"{len(degrees)} angles, {degrees[0]} to {degrees[-1]}"
    )
    share = 0.0 if known is None else float(np.mean(known[bent] / angles[bent]))
    return angles, share, bend or BendAngle(None, 0.0, text)


def force_of(given: str | float | None, option: str, unit: str | None) -> float:
    """A force, or a mass as its weight, in the unit of the file, in which a bare number is; 0 if it is not given."""
    text, scale = str(0.0 if given is None else given), force_factor(unit)
    with contextlib.suppress(ValueError):
        if math.isfinite(number := float(text)):
            return number
    for dimension, weight in (("force", 1.0), ("mass", float(STANDARD_GRAVITY))):
        with contextlib.suppress(UnitError):
            newton = parse_measure(text, dimension).si * weight
            if scale is None:
                hint = f'the file gives no unit of force; write the number alone: {option} "0.4"'
                raise UsageError(
                    f'"{shorten(text)}" cannot be compared with the readings',
                    where=option,
                    hint=hint,
                )
            return newton / scale
    raise UsageError(
        f'"{shorten(text)}" is no force', where=option, hint='write "0.4 N" or "0.4 kgf"'
    )


def cells_of(text: str | None, unit: str | None) -> tuple[float, float] | None:
    """Standard uncertainty of a cell's zero, in the unit of the file, and of its gain, as a share."""
    if text is None:
        return None
    option, hint, zero, gain = "--cell-uncertainty", 'write "0.2 N, 0.5 %"', 0.0, 0.0
    for part in map(str.strip, text.split(",")):
        if not part.endswith("%"):
            zero = force_of(part, option, unit)
            continue
        try:
            gain = parse_measure(part, "number").si
        except UnitError as error:
            raise UsageError(error.problem, where=option, hint=hint) from error
    if zero < 0.0 or not 0.0 <= gain < 1.0:
        raise UsageError(
            f'"{shorten(text)}" is no uncertainty: it is 0 or more', where=option, hint=hint
        )
    return zero, gain
