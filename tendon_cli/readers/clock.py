"""Times and angles that start again: counters that roll over, days that end, encoders that wrap."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_DAY = 86_400.0  # s
_COUNTS = 2.0**32
"""Values of a counter of 32 bits."""
_OF_DAY = re.compile(r"\d[:-]\d")
"""Part of a date or a time of day that no number has."""
_CLOCK = re.compile(r"(?:(\d{1,3}):)?(\d{1,2}):(\d{1,2}(?:[.,]\d*)?)")
"""Time as hours, minutes and seconds, or minutes and seconds."""
_SHARED = 3
"""Rows that share each time, from which the clock is coarser than the log."""
_ENOUGH = 40
"""Rows from which a log shows how it is sampled, and that an encoder wraps."""
_JUMP = 0.75
"""Step between two rows, in turns, from which an encoder started again."""
_SMOOTH = 0.25
"""Largest other step, in turns."""
_RARE = 0.2
"""Largest share of the rows in which an encoder starts again."""


def stamps(values: Sequence[str] | npt.NDArray[np.datetime64]) -> Floats | None:
    """Return seconds from the first of dates or times of day; None if they are none.

    A time of day that ends begins a new day.
    """
    if isinstance(values, np.ndarray):
        return np.asarray((values - values[0]) / np.timedelta64(1, "s"), dtype=np.float64)
    if not values or not all(map(_OF_DAY.search, values)):
        return None
    clocks = [_CLOCK.fullmatch(value.strip()) for value in values]
    fields = [match.groups() for match in clocks if match is not None]
    has_hours_or_parts = all(hours or re.search("[.,]", second) for hours, _, second in fields)
    if len(fields) == len(values) and has_hours_or_parts:
        seconds = np.array(
            [
                3600.0 * int(hours or 0) + 60.0 * int(minutes) + float(second.replace(",", "."))
                for hours, minutes, second in fields
            ]
        )
        ended = np.append(0.0, np.diff(seconds) < -0.5 * _DAY)
        return np.asarray(seconds - seconds[0] + _DAY * np.cumsum(ended))
    import pandas as pd  # only dates pay for its import

    instants = pd.to_datetime(list(values), errors="coerce", format="mixed")
    if instants.isna().any():
        return None
    return np.asarray((instants - instants[0]).total_seconds(), dtype=np.float64)


def counted_on(times: Floats) -> tuple[Floats, Integers]:
    """Return a counter that goes on where one of 32 bits rolls over, and the rows where it does."""
    steps = np.diff(times, prepend=times[:1])
    rolls = (steps < -0.5 * _COUNTS) & (steps > -_COUNTS) & (times == np.round(times))
    return times + _COUNTS * np.cumsum(rolls), np.flatnonzero(rolls)


def evenly(times: Floats) -> tuple[Floats, float] | None:
    """Return times at equal steps if many rows share each time, and how many do.

    Return None unless about as many rows share every time but the first and the last.
    """
    changes = np.flatnonzero(np.diff(times)) + 1
    shared = np.diff(changes)
    if len(times) < _ENOUGH or len(shared) < 2:
        return None
    usual = float(np.median(shared))
    if usual < _SHARED or np.any(np.abs(shared - usual) > max(1.0, 0.1 * usual)):
        return None
    first, last = changes[[0, -1]]
    step = (times[last] - times[first]) / (last - first)
    return times[first] + step * (np.arange(len(times)) - first), usual


def unwrapped(values: Floats, turn: float) -> tuple[Floats, Integers]:
    """Return an angle that goes on where an encoder starts again, and the rows where it does.

    Args:
        values: Angles; NaN where there is none.
        turn: One turn of the encoder.
    """
    none = np.array([], dtype=np.int64)
    known = np.flatnonzero(np.isfinite(values))
    angles = values[known]
    if len(angles) < _ENOUGH or np.ptp(angles) > turn * (1.0 + 1e-9):
        return values, none
    steps = np.diff(angles, prepend=angles[0]) / turn
    is_jump = np.abs(steps) > _JUMP
    is_rare = 0 < np.count_nonzero(is_jump) < _RARE * len(angles)
    if not is_rare or np.any(np.abs(steps[~is_jump]) > _SMOOTH):
        return values, none
    whole = values.copy()
    whole[known] -= turn * np.cumsum(np.where(is_jump, np.sign(steps), 0.0))
    return whole, known[is_jump]


def first_back(times: Floats) -> tuple[int, str] | None:
    """Return the first row at which time goes back, and the problem; None if it never does."""
    back = np.flatnonzero(np.diff(times) < 0.0) + 1
    if not len(back):
        return None
    row = int(back[0])
    starts_again = times[row] - times[:row].min() <= 0.02 * np.ptp(times[:row])
    if starts_again and row > 2:
        return row, "time starts again in this row, as after a restart of the logger"
    return row, "time goes back in this row"
