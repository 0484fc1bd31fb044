"""The bend angle of the sheath on the rig, as it is given on the command line."""

from __future__ import annotations

import re
from dataclasses import dataclass

from tendon_cli.errors import UsageError
from tendon_cli.units import UnitError, parse_measure, shorten

SMALLEST = 1e-3
"""In rad: no friction shows in a sheath that is straighter."""
LARGEST = 100.0
"""More than fifteen turns, in rad: no sheath on a rig, but a number in degrees taken for radians."""


@dataclass(frozen=True)
class BendAngle:
    """Total curvature ∫κ ds of the sheath between the two cells."""

    radians: float
    uncertainty: float
    """Standard uncertainty, rad; 0 where none is given."""
    text: str
    """As written, without the uncertainty."""
    uncertainty_text: str | None = None


def parse_bend_angle(text: str) -> BendAngle:
    """Read "144 deg" or "144 deg +/- 2 deg"; raises UsageError."""
    parts = re.split(r"\+/-|\+-|±", text, maxsplit=1) if len(text) <= 200 else [text]
    try:
        angle = parse_measure(parts[0], "angle").si
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
    return BendAngle(angle, uncertainty, parts[0].strip(), parts[1].strip() if len(parts) == 2 else None)


def _advice(parts: list[str], error: UnitError) -> str:
    """A bare number may be degrees or radians: both are offered, and neither is guessed."""
    bare = [part.strip() for part in parts if re.fullmatch(r"[+-]?\d{1,20}(?:\.\d{0,20})?", part.strip(), re.ASCII)]
    if not bare:
        return error.hint or 'write "144 deg" or "144 deg +/- 2 deg"'
    degrees = " +/- ".join(part.strip() + (" deg" if part.strip() in bare else "") for part in parts)
    radians = f', in radians "{degrees.replace("deg", "rad")}"' if float(bare[0]) <= LARGEST else ""
    return f'in degrees "{degrees}"{radians}'
