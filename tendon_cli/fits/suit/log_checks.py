"""Checks of a suit's log by itself: order, units and sizes that no log of a suit has."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tendon_cli import say
from tendon_cli.errors import InputError
from tendon_cli.fits.log_rows import Floats, Integers
from tendon_cli.fits.suit.log_columns import CHANNELS, COUNTS, ELBOW_ANGLE, LOAD_MASS, TIME
from tendon_cli.fits.suit.parameters import range_of
from tendon_cli.quantities import PLAUSIBLE
from tendon_cli.readers.clock import first_back
from tendon_cli.readers.heading import Heading

_LARGEST_ANGLE = 7.0
"""Largest angle of a joint, rad: more is an angle in degrees."""
_LEAST_MOTION = np.radians(5.0)
"""Least range of the joint, rad."""


def note_on_time(source: str, column: Heading, time: Floats) -> str:
    """Return a note on a time without a unit, which is taken in seconds."""
    lasts = say.number(float(np.ptp(time)), 3)
    return (
        f"{source}: {column.shown} has no unit, so it is read in seconds: the log takes {lasts} s"
    )


def check_values(
    source: str,
    headings: Mapping[str, Heading],
    values: Mapping[str, Floats],
    lines: Integers,
) -> None:
    """Refuse values that no log of a suit has.

    Args:
        source: Name of the log.
        headings: Columns that are read, by what they give.
        values: Their values, SI.
        lines: Line of each row.

    Raises:
        InputError: if there are such values.
    """
    _check_order(source, values.get(TIME), lines)
    _check_load(source, headings.get(LOAD_MASS), values.get(LOAD_MASS))
    _check_angle(source, headings[ELBOW_ANGLE], values[ELBOW_ANGLE])
    for role in CHANNELS:
        channel = values.get(role)
        if channel is not None and np.ptp(channel) <= 1e-9 * np.max(np.abs(channel), initial=1e-12):
            raise InputError(
                f"{headings[role].shown} is the same in every row",
                where=source,
                hint="is it connected, and the right column?",
            )


def _check_order(source: str, time: Floats | None, lines: Integers) -> None:
    """Refuse a time that goes back."""
    if time is None:
        return
    back = first_back(time)
    if back is not None:
        row, problem = back
        raise InputError(
            problem,
            where=f"{source}, line {lines[row]}",
            hint="give one log per file, its rows in order of time",
        )


def _check_load(source: str, column: Heading | None, load: Floats | None) -> None:
    """Refuse a load that nobody holds."""
    if load is None or column is None:
        return
    low, high = PLAUSIBLE["load_mass"]
    worst = load[np.argmax(np.abs(load))]
    if load.min() < low or worst > high:
        shown = f"{say.number(float(load.min() if load.min() < low else worst), 4)} kg"
        problem = f"{column.shown} has a load of {shown}"
        hint = f"expected {low:g} to {high:g} kg"
        if worst > high:
            hint += "; are these grams?"
        raise InputError(problem, where=source, hint=hint)


def _check_angle(source: str, column: Heading, angle: Floats) -> None:
    """Refuse an angle that no joint has, and one that hardly changes."""
    if np.max(np.abs(angle)) > _LARGEST_ANGLE:
        problem = f"{column.shown} reaches {np.max(np.abs(angle)):.4g} rad, which no joint does"
        hint = "is the unit right?"
        if column.unit == "rad":
            hint = "are these degrees?"
        elif column.unit == COUNTS:
            hint = "is fit.counts_per_turn right?"
        raise InputError(problem, where=source, hint=hint)
    span = range_of(angle)
    if span < _LEAST_MOTION:
        problem = (
            f"{column.shown} moves by {np.degrees(span):.2g} deg alone, expected 5 deg or more"
        )
        is_degrees = column.unit == "deg" and 0.05 < np.degrees(span) < 4.0
        hint = "are these radians?" if is_degrees else "move the joint through most of its range"
        raise InputError(problem, where=source, hint=hint)
