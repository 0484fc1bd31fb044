"""The bend angle of the sheath on the rig, as it is given on the command line."""

from __future__ import annotations

import re
from dataclasses import dataclass

from tendon_cli.errors import UsageError
from tendon_cli.units import UnitError, parse_measure, shorten

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
        raise UsageError(
            error.problem,
            where="--bend-angle",
            hint=error.hint or 'write "144 deg" or "144 deg +/- 2 deg"',
        ) from error
    if not 0.0 < angle <= LARGEST:
        raise UsageError(
            f'"{shorten(text)}" is not the bend angle of a sheath: it is above 0 and at most {LARGEST:g} rad',
            where="--bend-angle",
            hint="half a turn is 180 deg",
        )
    if not 0.0 <= uncertainty < angle / 2.0:
        raise UsageError(
            f'"{shorten(text)}": the uncertainty is 0 or more and less than half the angle', where="--bend-angle"
        )
    return BendAngle(angle, uncertainty, parts[0].strip(), parts[1].strip() if len(parts) == 2 else None)
