"""Bend angle of the sheath on a rig, and zeros and uncertainty of its cells."""

from __future__ import annotations

import contextlib
import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tendon_cli.errors import InputError, UsageError
from tendon_cli.fits.friction.readings import LARGEST_BEND, Readings
from tendon_cli.fits.log_rows import Floats
from tendon_cli.readers.table import content_of, name_of
from tendon_cli.units import (
    STANDARD_GRAVITY,
    UnitError,
    force_factor,
    parse_measure,
    shorten,
)

_TIME = re.compile(r"[\d\s][mu]?s$")
_SMALLEST_BEND = 1e-3
"""Least bend angle, rad: no friction shows in a sheath that is straighter."""


@dataclass(frozen=True)
class BendAngle:
    """Total curvature ∫κ ds of the sheath between the two cells."""

    radians: float | None
    """Bend angle, rad; None if only an uncertainty is given, for a column of angles."""
    uncertainty: float
    """Standard uncertainty, rad; 0 if none is given."""
    text: str
    """Bend angle as written, without the uncertainty."""
    uncertainty_text: str | None = None
    notes: tuple[str, ...] = ()
    """Notes on the route that it comes from."""
    warnings: tuple[str, ...] = ()


def bend_angle_of(
    given: str | float | None, route: Path | None, smoothing: str | float | None
) -> BendAngle | None:
    """Return the bend angle; None if it is not given.

    Args:
        given: Text such as "144 deg +/- 2 deg", or a number in rad.
        route: File of way-points, instead of `given`.
        smoothing: Noise of the way-points, as a text with a unit or a number in m.

    Raises:
        UsageError: if a text is not an angle or a length, or the angle is given twice.
        InputError: if the file is not a route, or the route bends too little or too much for a
            sheath.
    """
    if route is not None and given is not None:
        raise UsageError(
            "the bend angle is given twice, by an angle and by a route",
            where="--bend-angle, --route",
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
    """Parse "144 deg", "144 deg +/- 2 deg", or "+/- 2 deg" for a column of angles."""
    parts = [text]
    if len(text) <= 200:
        parts = [part.strip() for part in re.split(r"\+/-|\+-|±", text, maxsplit=1)]
    has_uncertainty = len(parts) == 2
    has_angle = not has_uncertainty or bool(parts[0])
    like = ("--bend-angle", 'write "144 deg" or "144 deg +/- 2 deg"')
    angle = _measure(parts[0], "angle", *like) if has_angle else LARGEST_BEND
    uncertainty = _measure(parts[1], "angle", *like) if has_uncertainty else 0.0
    if not _SMALLEST_BEND <= angle <= LARGEST_BEND:
        size = f"it is at least {_SMALLEST_BEND:g} and at most {LARGEST_BEND:g} rad"
        raise UsageError(
            f'"{shorten(text)}" is not the bend angle of a sheath: {size}',
            where="--bend-angle",
            hint="half a turn is 180 deg",
        )
    if not 0.0 <= uncertainty < angle / 2.0:
        raise UsageError(
            f'"{shorten(text)}": the uncertainty is 0 or more and less than half the angle',
            where="--bend-angle",
        )
    return BendAngle(
        radians=angle if has_angle else None,
        uncertainty=uncertainty,
        text=parts[0],
        uncertainty_text=parts[1] if has_uncertainty else None,
    )


def _bend_of_route(route: Path, smoothing: str | float | None) -> BendAngle:
    """Measure the bend angle of a file of way-points."""
    from tendon_cli.studies.way_points import MAX_BYTES, measure_route, read_route, route_note

    name = name_of(route)
    content = content_of(route, MAX_BYTES, "--route names a CSV of x, y and z")
    if isinstance(smoothing, str):
        noise = _measure(smoothing, "length", "--path-smoothing", 'write "0.5 mm"')
    else:
        noise = float(smoothing or 0.0)
    if not 0.0 <= noise < math.inf:
        raise UsageError(
            f'"{smoothing}" is not a noise of way-points, expected 0 or more',
            where="--path-smoothing",
        )
    measured, warnings = measure_route(read_route(content, name), name, noise)
    bend = measured.bend_angle
    error = measured.standard_error
    if bend < _SMALLEST_BEND or error >= bend / 2.0:
        raise InputError(
            f"bends by {bend:.3g} rad ± {error:.2g} rad: not enough to show friction",
            where=name,
            hint="measure friction on a sheath that bends by half a turn or more",
        )
    return BendAngle(
        radians=bend,
        uncertainty=error,
        text=f"{math.degrees(bend):.2f} deg of {name}",
        uncertainty_text=f"{math.degrees(error):.2g} deg",
        notes=(route_note(measured, name),),
        warnings=tuple(warnings),
    )


def _measure(text: str, dimension: str, option: str, hint: str) -> float:
    """Return a number with a unit in SI; the hint shows one that is right.

    Raises:
        UsageError: if the text is none.
    """
    try:
        return parse_measure(text, dimension).si
    except UnitError as error:
        raise UsageError(error.problem, where=option, hint=error.hint or hint) from error


def bend_angles(
    readings: Readings, bend: BendAngle | None
) -> tuple[Floats, float, BendAngle | None]:
    """Return the bend angle of each reading, by the option or by a column.

    Angles are never guessed and never taken from both. Without any, all are 1, and the coefficient
    is μφ. Their errors count as one error that all angles share.

    Returns:
        Bend angles, rad; their standard uncertainty as a share of them; and their source, None if
        they are not known.
    """
    angles = readings.column("bend_angle")
    if angles is not None:
        return _angles_of_column(readings, angles, bend)
    total = len(readings.rows)
    if bend is None:
        return np.ones(total), 0.0, None
    if bend.radians is None:
        raise UsageError(
            "the bend angle of the sheath is not given,"
            f" and {readings.source} has no column for it",
            where="--bend-angle",
            hint='measure it between the cells: --bend-angle "144 deg", --route,'
            " or a column bend_angle_deg",
        )
    return np.full(total, bend.radians), bend.uncertainty / bend.radians, bend


def _angles_of_column(
    readings: Readings, angles: Floats, bend: BendAngle | None
) -> tuple[Floats, float, BendAngle]:
    """Return the angles of a column; the option may give their uncertainty."""
    source = readings.source
    uncertainty = readings.column("bend_uncertainty")
    if bend is not None and bend.radians is not None:
        agrees = np.allclose(angles, bend.radians, rtol=1e-6, atol=0.0)
        if not agrees:
            raise UsageError(
                f"the bend angle is given twice: as {bend.text},"
                f" and differently by a column of {source}",
                where="--bend-angle",
                hint="leave the option out to use the column;"
                ' "+/- 2 deg" alone says how well the column is known',
            )
    if bend is not None and bend.uncertainty:
        if uncertainty is not None:
            raise UsageError(
                "the uncertainty of the bend angle is given twice:"
                f" here and by a column of {source}",
                where="--bend-angle",
            )
        uncertainty = np.full(len(angles), bend.uncertainty)
    share = 0.0
    if uncertainty is not None:
        bent = angles > 0.0
        share = float(np.mean(uncertainty[bent] / angles[bent]))
    if bend is not None:
        return angles, share, bend
    degrees = [f"{math.degrees(angle):.10g} deg" for angle in np.unique(angles)]
    text = ", ".join(degrees)
    if len(degrees) > 6:
        text = f"{len(degrees)} angles, {degrees[0]} to {degrees[-1]}"
    return angles, share, BendAngle(None, 0.0, text)


def force_of(given: str | float | None, option: str, unit: str | None) -> float:
    """Return a force in the unit of the file; 0 if it is not given.

    Args:
        given: Force, mass (which counts as its weight), or bare number in the unit of the file.
        option: Name of the option, for messages.
        unit: Unit of the file; None if it does not say.

    Raises:
        UsageError: if it is not a force, or the file gives no unit to compare it with.
    """
    text = str(0.0 if given is None else given)
    scale = force_factor(unit)
    with contextlib.suppress(ValueError):
        number = float(text)
        if math.isfinite(number):
            return number
    for dimension, weight in (("force", 1.0), ("mass", float(STANDARD_GRAVITY))):
        with contextlib.suppress(UnitError):
            newton = parse_measure(text, dimension).si * weight
            if scale is None:
                raise UsageError(
                    f'"{shorten(text)}" cannot be compared with the readings',
                    where=option,
                    hint=f'the file gives no unit of force; write the number alone: {option} "0.4"',
                )
            return newton / scale
    raise UsageError(
        f'"{shorten(text)}" is not a force', where=option, hint='write "0.4 N" or "0.4 kgf"'
    )


def cell_uncertainty_of(
    text: str | None, unit: str | None
) -> tuple[float | None, float, float | None]:
    """Parse the standard uncertainty of a cell's zero, gain and delay, "0.2 N, 0.5 %, 5 ms".

    Returns:
        Standard uncertainty of the zero, in the unit of the file, None if the text does not give
        it, of the gain, as a share, and of the delay, s, None if the text does not give it.

    Raises:
        UsageError: if the text is not an uncertainty.
    """
    zero = None
    gain = 0.0
    delay = None
    if text is None:
        return zero, gain, delay
    option = "--cell-uncertainty"
    hint = 'write "0.2 N, 0.5 %, 5 ms"'
    for part in map(str.strip, text.split(",")):
        if part.endswith("%"):
            gain = _measure(part, "number", option, hint)
        elif _TIME.search(part):
            delay = _measure(part, "time", option, hint)
        else:
            zero = force_of(part, option, unit)
    if min(zero or 0.0, delay or 0.0) < 0.0 or not 0.0 <= gain < 1.0:
        raise UsageError(
            f'"{shorten(text)}" is not an uncertainty, expected 0 or more', where=option, hint=hint
        )
    return zero, gain, delay
