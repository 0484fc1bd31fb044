"""What is known of the load cells before they are read: their zeros and their uncertainty."""

from __future__ import annotations

import math

from tendon_cli.errors import UsageError
from tendon_cli.friction.reading.header import force_factor
from tendon_cli.units import UnitError, parse_measure


def force_of(given: str | float | None, option: str, unit: str | None) -> float:
    """A force, or a mass as its weight, in the unit of the file, in which a bare number is; 0 if it is not given."""
    if given is None:
        return 0.0
    if not isinstance(given, str):
        number = float(given)
    elif not given.strip():
        raise UsageError("is empty", where=option, hint='write "0.4 N"')
    else:
        number = _measured(given, option, unit)
    if not math.isfinite(number):
        raise UsageError(f'"{given}" is not a finite number', where=option)
    return number


def _measured(text: str, option: str, unit: str | None) -> float:
    try:
        return float(text)
    except ValueError:
        pass
    for dimension, factor in (("force", 1.0), ("mass", 9.80665)):
        try:
            newton = parse_measure(text, dimension).si * factor
        except UnitError as error:
            problem = error
            continue
        scale = force_factor(unit) if unit else None
        if scale is None:
            hint = f'the file gives no unit of force; write the number alone: {option} "0.4"'
            raise UsageError(f'"{text}" cannot be compared with the readings', where=option, hint=hint)
        return newton / scale
    raise UsageError(problem.problem, where=option, hint=problem.hint or 'write "0.4 N" or "0.4 kgf"')


def cells_of(text: str | None, unit: str | None) -> tuple[float, float] | None:
    """Standard uncertainty of a cell's zero, in the unit of the file, and of its gain, as a share."""
    if text is None:
        return None
    option, zero, gain = "--cell-uncertainty", 0.0, 0.0
    for part in text.split(","):
        if part.strip().endswith("%"):
            gain = _percent(part, option)
        else:
            zero = force_of(part.strip(), option, unit)
    if zero < 0.0 or not 0.0 <= gain < 1.0:
        raise UsageError(f'"{text}" is no uncertainty: it is 0 or more', where=option, hint='write "0.2 N, 0.5 %"')
    return zero, gain


def _percent(text: str, option: str) -> float:
    try:
        return float(parse_measure(text.strip(), "number").si)
    except UnitError as error:
        raise UsageError(error.problem, where=option, hint='write "0.2 N, 0.5 %"') from error
