"""The bend angle of the sheath on the rig, as it is given on the command line."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from tendon_cli.errors import UsageError
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


def _advice(parts: list[str], error: UnitError) -> str:
    """A bare number may be degrees or radians: both are offered, and neither is guessed."""
    bare = [part.strip() for part in parts if re.fullmatch(r"[+-]?\d{1,20}(?:\.\d{0,20})?", part.strip(), re.ASCII)]
    if not bare:
        return error.hint or 'write "144 deg" or "144 deg +/- 2 deg"'
    degrees = " +/- ".join(part.strip() + (" deg" if part.strip() in bare else "") for part in parts)
    radians = f', in radians "{degrees.replace("deg", "rad")}"' if float(bare[0]) <= LARGEST else ""
    return f'in degrees "{degrees}"{radians}'


def bend_angles(readings: Readings, bend: BendAngle | None) -> tuple[Floats, float]:
    """The bend angle of each reading, from the option or the column, and their standard uncertainty as a share of them.

    Angles are never guessed and never taken from both; their errors are counted as if all had the same one.
    """
    own = readings.bend_angle
    if own is None:
        if bend is None or bend.radians is None:
            raise UsageError(
                f"the bend angle of the sheath is not given, and {readings.source} has no column for it",
                where="--bend-angle",
                hint='measure the total bend between the cells: --bend-angle "144 deg", or a column bend_angle_deg',
            )
        return np.full(len(readings.lines), bend.radians), bend.uncertainty / bend.radians
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
    return own, 0.0 if known is None else float(np.mean(known[bent] / own[bent]))
