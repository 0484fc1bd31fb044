"""The bend angle of the sheath on the rig: given on the command line, or by way-points along the sheath."""

from __future__ import annotations

import math
import os
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tendon_cli.errors import InputError, UsageError
from tendon_cli.files import read_file
from tendon_cli.friction.reading.readings import LARGEST, Floats, Readings
from tendon_cli.units import UnitError, parse_measure, shorten

SMALLEST = 1e-3
"""In rad: no friction shows in a sheath that is straighter."""


@dataclass(frozen=True)
class BendAngle:
    """Total curvature ∫κ ds of the sheath between the two cells."""

    radians: float | None
    """None where only an uncertainty is given, for a column of angles."""
    uncertainty: float
    """Standard uncertainty, rad; 0 where none is given."""
    text: str
    """As written, without the uncertainty."""
    uncertainty_text: str | None = None
    notes: tuple[str, ...] = ()
    """Where it comes from, if not from the command line."""
    warnings: tuple[str, ...] = ()


def parse_bend_angle(text: str) -> BendAngle:
    """Read "144 deg", "144 deg +/- 2 deg", or "+/- 2 deg" beside a column of angles; raises UsageError."""
    parts = re.split(r"\+/-|\+-|±", text, maxsplit=1) if len(text) <= 200 else [text]
    only = len(parts) == 2 and not parts[0].strip()
    try:
        angle = LARGEST if only else parse_measure(parts[0], "angle").si
        uncertainty = parse_measure(parts[1], "angle").si if len(parts) == 2 else 0.0
    except UnitError as error:
        raise UsageError(error.problem, where="--bend-angle", hint=_advice(parts, error)) from error
    if not SMALLEST <= angle <= LARGEST:
        raise UsageError(
            f'"{shorten(text)}" is not the bend angle of a sheath: it is at least {SMALLEST:g} and at most'
            f" {LARGEST:g} rad",
            where="--bend-angle",
            hint="half a turn is 180 deg",
        )
    if not 0.0 <= uncertainty < angle / 2.0:
        raise UsageError(
            f'"{shorten(text)}": the uncertainty is 0 or more and less than half the angle', where="--bend-angle"
        )
    return BendAngle(
        None if only else angle, uncertainty, parts[0].strip(), parts[1].strip() if len(parts) == 2 else None
    )


def bend_angle_of(route: Path, smoothing: str | float | None = None) -> BendAngle:
    """The bend angle of way-points along the sheath, a file as of `[sheath] path`, with its own uncertainty.

    `smoothing` is the noise of the way-points, a text with a unit or a number in m, where it is known. Raises
    InputError for a file that is no route, or that bends too little or too much for a sheath, UsageError for a noise
    that is none.
    """
    from tendon_cli.studies.route import MAX_BYTES, measure_route, route_note

    name = shorten(os.fsencode(route.name).decode("utf-8", "replace"), 200)
    try:
        content = read_file(route, MAX_BYTES)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "the name is not one"
        raise InputError(f"cannot be read: {reason}", where=name, hint="--route names a CSV of x, y and z") from None
    found, warnings = measure_route(content, name, _noise(smoothing))
    if found.bend_angle < SMALLEST or found.standard_error >= found.bend_angle / 2.0:
        raise InputError(
            f"bends by {found.bend_angle:.3g} rad ± {found.standard_error:.2g} rad: not enough to show friction",
            where=name,
            hint="measure friction on a sheath that bends by half a turn or more",
        )
    angle, uncertainty = (math.degrees(value) for value in (found.bend_angle, found.standard_error))
    return BendAngle(
        found.bend_angle, found.standard_error, f"{angle:.2f} deg of {name}", f"{uncertainty:.2g} deg",
        (route_note(found, name),), tuple(warnings),
    )  # fmt: skip


def _noise(given: str | float | None) -> float:
    """Standard deviation of way-points, m; 0 where it is not given."""
    if given is None:
        return 0.0
    where = "--path-smoothing"
    try:
        noise = parse_measure(given, "length").si if isinstance(given, str) else float(given)
    except UnitError as error:
        raise UsageError(error.problem, where=where, hint=error.hint or 'write "0.5 mm"') from error
    if not 0.0 <= noise < math.inf:
        raise UsageError(f'"{given}" is no noise of way-points: it is 0 or more', where=where)
    return noise


def _advice(parts: list[str], error: UnitError) -> str:
    """A bare number may be degrees or radians: both are offered, and neither is guessed."""
    bare = [part.strip() for part in parts if re.fullmatch(r"[+-]?\d{1,20}(?:\.\d{0,20})?", part.strip(), re.ASCII)]
    if not bare:
        return error.hint or 'write "144 deg" or "144 deg +/- 2 deg"'
    degrees = " +/- ".join(part.strip() + (" deg" if part.strip() in bare else "") for part in parts)
    radians = f', in radians "{degrees.replace("deg", "rad")}"' if float(bare[0]) <= LARGEST else ""
    return f'in degrees "{degrees}"{radians}'


def bend_angles(readings: Readings, bend: BendAngle | None) -> tuple[Floats, float, bool]:
    """The bend angle of each reading, their standard uncertainty as a share of them, and whether there are any.

    Angles are never guessed and never taken from both the option and a column; without any, all are 1 and the
    coefficient is μφ. Their errors are counted as if all had the same one.
    """
    own = readings.bend_angle
    if own is None:
        if bend is not None and bend.radians is None:
            raise UsageError(
                f"the bend angle of the sheath is not given, and {readings.source} has no column for it",
                where="--bend-angle",
                hint='measure it between the cells: --bend-angle "144 deg", --route, or a column bend_angle_deg',
            )
        if bend is None or bend.radians is None:
            return np.ones(len(readings.lines)), 0.0, False
        return np.full(len(readings.lines), bend.radians), bend.uncertainty / bend.radians, True
    if bend is not None and bend.radians is not None and not np.allclose(own, bend.radians, rtol=1e-6, atol=0.0):
        raise UsageError(
            f"the bend angle is given twice: {bend.text} and by a column of {readings.source} that says otherwise",
            where="--bend-angle",
            hint='leave the option out to use the column; "+/- 2 deg" alone says how well the column is known',
        )
    known = readings.bend_uncertainty
    if bend is not None and bend.uncertainty:
        if known is not None:
            raise UsageError(
                f"the uncertainty of the bend angle is given twice: here and by a column of {readings.source}",
                where="--bend-angle",
            )
        known = np.full(len(own), bend.uncertainty)
    bent = own > 0.0
    return own, 0.0 if known is None else float(np.mean(known[bent] / own[bent])), True
