"""Strokes of a suit's logs: rows that slide, averaged over parts of each stroke.

Friction has its full size only while the tendons slide, so rows are used from where the sheaths
have turned after each turn of the joint. Rows of one stroke are not independent, and their means
over parts of the stroke hold all that they tell.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tendon_cli.errors import InputError
from tendon_cli.fits.log_rows import Floats, Integers, Mask
from tendon_cli.fits.suit.parameters import range_of
from tendon_cli.fits.suit.suit_log import SuitLog
from tendon_cli.units import counted

MOST_ROWS = 30_000
"""Rows of a log that are kept: of a longer one neighbours are averaged."""
PARTS = 8
"""Parts of a stroke, of equal angle, over which rows are averaged."""
MOST_STROKES = 48
"""Strokes of all logs that are fitted by themselves; more of a kind are averaged."""
_TURN = np.radians(3.0)
"""Least angle by which the joint comes back in a turn, rad."""
_TURN_SHARE = 0.08
"""Share of the range of the joint by which it comes back in a turn."""
_END_SHARE = 0.015
"""Share of a stroke before its end that is set aside: the row of the turn is known no better."""
_REST_SHARE = 0.1
"""Speed over the usual speed under which the joint rests."""
_BACK_SHARE = 0.1
"""Speed of the spool over its usual speed under which it does not go the way of its stroke."""
_SHORT_SHARE = 0.4
"""Share of the usual length of a stroke under which it is set aside."""
_LEAST_WAY = np.radians(4.0)
"""Least way of the joint after a turn until the tendons slide, rad."""
_USUAL_STEPS = 0.9
"""Share of the steps in time that are no gaps."""
_GAP = 10.0
"""Step in time, over the largest usual one, from which it is a gap."""
_SHAPE_DEGREE = 9
"""Degree of the polynomial in time that gives speed and acceleration in a stroke."""

REASONS = (
    "",
    "near a reversal, while friction changes direction along the sheath",
    "at rest",
    "in a short stroke",
    "slack",
    "at the start, before the tendons slide",
    "where the spool rests or turns against the joint",
)
USED, TURNING, RESTING, SHORT, SLACK, STARTING, AGAINST = range(7)
"""Reasons for which a row is set aside, by code."""


@dataclass(frozen=True, eq=False)
class LogStroke:
    """Rows of one stroke of one log, from a turn to the next."""

    log: int
    """Number of its log."""
    rows: Integers
    """Rows of the thinned log, (rows,)."""
    is_flexion: bool
    load: float
    """Mass of the load, kg; NaN if the log does not say."""
    is_first: bool
    """True for the first stroke of a log and after a gap, before which nothing is known."""


@dataclass(frozen=True, eq=False)
class Parts:
    """Means over parts of strokes, the data of a fit; a value per part."""

    log: Integers
    """Number of the log."""
    stroke: Integers
    """Number of the stroke."""
    flexion: Mask
    """True in flexion."""
    load: Floats
    """Mass of the load, kg; NaN if the log does not say."""
    angle: Floats
    """Mean angle of the joint, rad."""
    spread: Floats
    """Standard deviation of the angle within the part, rad."""
    speed: Floats
    """Mean speed of the joint, rad/s; 0 without a time."""
    acceleration: Floats
    """Mean acceleration of the joint, rad/s²; 0 without a time."""
    place: Floats
    """Place in the log in time, 0 to 1."""
    count: Floats
    """Number of rows."""
    values: Mapping[str, Floats]
    """Means of the channels, SI."""

    def __len__(self) -> int:
        return len(self.angle)

    @property
    def sign(self) -> Floats:
        """1 in flexion, -1 in extension."""
        return np.where(self.flexion, 1.0, -1.0)

    def select(self, rows: Mask | Integers) -> Parts:
        """Select parts by mask or index."""
        columns: dict[str, Any] = {
            name: column[rows]
            for name, column in vars(self).items()
            if isinstance(column, np.ndarray)
        }
        values = {name: column[rows] for name, column in self.values.items()}
        return Parts(**columns, values=values)


def thinned(log: SuitLog) -> tuple[SuitLog, int]:
    """Return a log with the means of neighbouring rows, and how many of them a mean has."""
    every = -(-len(log) // MOST_ROWS)
    if every == 1:
        return log, 1
    whole = len(log) // every * every

    def means(values: Floats) -> Floats:
        """Return the means of neighbours."""
        return np.asarray(values[:whole].reshape(-1, every).mean(axis=1))

    thin = replace(
        log,
        line=log.line[:whole:every],
        elbow_angle=means(log.elbow_angle),
        channels={name: means(values) for name, values in log.channels.items()},
        time=None if log.time is None else means(log.time),
        load_mass=None if log.load_mass is None else log.load_mass[:whole:every],
    )
    return thin, every


def strokes_of(number: int, log: SuitLog) -> list[LogStroke]:
    """Return the strokes of a log between the turns of its joint.

    Args:
        number: Number of the log.
        log: The log, thinned.
    """
    angle = log.elbow_angle
    span = range_of(angle)
    turns = _turns(angle, max(_TURN, _TURN_SHARE * span))
    ends = [0, *turns, len(angle) - 1]
    strokes = []
    gaps = gaps_of(log)
    after_gap = {0, *(gaps + 1).tolist()}
    for first, last in itertools.pairwise(ends):
        rows = np.arange(first, last + 1)
        for part in _without_breaks(log, rows, gaps):
            change = angle[part[-1]] - angle[part[0]]
            load = np.nan if log.load_mass is None else np.median(log.load_mass[part])
            is_first = int(part[0]) in after_gap
            strokes.append(LogStroke(number, part, bool(change > 0.0), load, is_first=is_first))
    return [stroke for stroke in strokes if len(stroke.rows) > 4]


def gaps_of(log: SuitLog) -> Integers:
    """Return the rows after which the log has a gap in time."""
    if log.time is None or len(log) < 3:
        return np.empty(0, dtype=np.int64)
    steps = np.diff(log.time)
    usual = np.quantile(steps, _USUAL_STEPS)
    return np.flatnonzero(steps > _GAP * max(usual, 1e-12))


def _without_breaks(log: SuitLog, rows: Integers, gaps: Integers) -> list[Integers]:
    """Cut rows where the load changes, and at gaps in time."""
    is_break = np.isin(rows[:-1], gaps)
    if log.load_mass is not None:
        is_break |= np.diff(log.load_mass[rows]) != 0.0
    return list(np.split(rows, np.flatnonzero(is_break) + 1))


def _turns(angle: Floats, least: float) -> list[int]:
    """Return the rows at which the joint turns, coming back by at least an angle."""
    turns = []
    values = angle.tolist()
    way = 0
    low = 0
    high = 0
    for row, value in enumerate(values):
        if value > values[high]:
            high = row
        if value < values[low]:
            low = row
        if way >= 0 and value < values[high] - least:
            if way > 0 or high > 0:
                turns.append(high)
            way = -1
            low = row
        elif way <= 0 and value > values[low] + least:
            if way < 0 or low > 0:
                turns.append(low)
            way = 1
            high = row
        if way > 0 and row == high:
            low = row
        if way < 0 and row == low:
            high = row
    return turns


def usable(
    stroke: LogStroke, log: SuitLog, usual_length: float, least_way: float, spool_way: float
) -> Integers:
    """Return why each row of a stroke is set aside, a code per row.

    Args:
        stroke: The stroke.
        log: Its log, thinned.
        usual_length: Median length of the strokes of the log, rad.
        least_way: Way of the joint after a turn until the tendons slide, rad.
        spool_way: Way of the spool after a turn until they slide, rad.
    """
    rows = stroke.rows
    angle = log.elbow_angle[rows]
    sign = 1.0 if stroke.is_flexion else -1.0
    way = sign * (angle - angle[0])
    codes = np.full(len(rows), USED)
    if way[-1] < _SHORT_SHARE * usual_length:
        codes[:] = SHORT
        return codes
    has_slid = way >= max(_LEAST_WAY, least_way)
    goes_along = np.ones(len(rows), dtype=bool)
    if "spool_angle" in log.channels:
        wound = sign * log.channels["spool_angle"][rows]
        least = int(np.argmin(wound))
        has_slid &= (wound - wound[least] >= spool_way) & (np.arange(len(rows)) > least)
        goes_along = _goes_along(wound)
    first = int(np.argmax(has_slid)) if has_slid.any() else len(rows)
    codes[:first] = STARTING if stroke.is_first else TURNING
    codes[~goes_along & (codes == USED)] = AGAINST
    codes[first:][way[first:] > (1.0 - _END_SHARE) * way[-1]] = TURNING
    if log.time is not None and first < len(rows) - 8:
        speed = _speed(way, log.time[rows])
        usual = np.median(speed[first:])
        codes[first:][speed[first:] < _REST_SHARE * usual] = RESTING
    return codes


def _goes_along(wound: Floats) -> Mask:
    """Return True where the spool turns the way of its stroke.

    Where the elbow is unstable the spool turns back while the joint goes on, and friction with it.

    Args:
        wound: Angle of the spool, positive the way of the stroke, rad.
    """
    speed = _speed(wound, np.arange(len(wound), dtype=np.float64))
    return speed > _BACK_SHARE * np.median(speed)


def _speed(way: Floats, time: Floats) -> Floats:
    """Return the speed along a stroke from rows a fortieth of it to either side."""
    reach = max(2, len(way) // 40)
    after = np.minimum(np.arange(len(way)) + reach, len(way) - 1)
    before = np.maximum(np.arange(len(way)) - reach, 0)
    step = time[after] - time[before]
    moved = way[after] - way[before]
    return np.divide(moved, step, out=np.zeros(len(way)), where=step > 0.0)


def parts_of(
    logs: Sequence[SuitLog],
    every: Sequence[int],
    strokes: Sequence[LogStroke],
    codes: Sequence[Integers],
) -> Parts:
    """Average the rows that slide over parts of their strokes.

    Args:
        logs: The logs, thinned.
        every: Rows of each log that a row of the thinned one is the mean of.
        strokes: All strokes.
        codes: Why rows are set aside, for each stroke.

    Raises:
        InputError: if nothing slides, or only in one direction.
    """
    names = tuple(logs[0].channels)
    found = []
    for number, (stroke, code) in enumerate(zip(strokes, codes, strict=True)):
        kept = code == USED
        if np.count_nonzero(kept) < 2 * PARTS // 3:
            continue
        columns = _parts_of_stroke(logs[stroke.log], stroke, kept, names, number)
        columns["count"] = columns["count"] * every[stroke.log]
        found.append(columns)
    if not found:
        raise InputError(
            "no stroke slides long enough: nothing is left after the turns",
            where=logs[0].source,
            hint="move the joint slowly through most of its range, several times to and fro",
        )
    joined: dict[str, Any] = {
        name: np.concatenate([columns[name] for columns in found]) for name in found[0]
    }
    values = {name: joined.pop(f"value {name}") for name in names}
    parts = Parts(**joined, values=values)
    ways = np.unique(parts.flexion)
    if len(ways) < 2:
        way = "flexion" if ways[0] else "extension"
        used = counted(len(np.unique(parts.stroke)), "stroke")
        raise InputError(
            f"{used} can be used, in {way} alone, so friction cannot be told from the load",
            where=logs[0].source,
            hint="log two strokes or more, to and fro",
        )
    return parts


def _parts_of_stroke(
    log: SuitLog, stroke: LogStroke, kept: Mask, names: Sequence[str], number: int
) -> dict[str, Any]:
    """Return the means over the parts of one stroke, by column."""
    rows = stroke.rows[kept]
    angle = log.elbow_angle[rows]
    low = angle.min()
    high = angle.max()
    part = np.minimum((PARTS * (angle - low) / (high - low)).astype(np.int64), PARTS - 1)
    _, part = np.unique(part, return_inverse=True)
    count = np.bincount(part).astype(np.float64)

    def mean(values: Floats) -> Floats:
        """Return the mean of each part."""
        return np.bincount(part, values) / count

    middle = mean(angle)
    speed, acceleration = _derivatives(log, stroke, rows)
    time = np.arange(len(log)) / len(log)
    if log.time is not None:
        time = (log.time - log.time[0]) / max(np.ptp(log.time), 1e-12)
    columns = {
        "log": np.full(len(count), stroke.log),
        "stroke": np.full(len(count), number),
        "flexion": np.full(len(count), stroke.is_flexion),
        "load": np.full(len(count), stroke.load),
        "angle": middle,
        "spread": np.sqrt(np.maximum(mean(np.square(angle - middle[part])), 1e-10)),
        "speed": mean(speed),
        "acceleration": mean(acceleration),
        "place": mean(time[rows]),
        "count": count,
    }
    for name in names:
        columns[f"value {name}"] = mean(log.channels[name][rows])
    return columns


def _derivatives(log: SuitLog, stroke: LogStroke, rows: Integers) -> tuple[Floats, Floats]:
    """Return speed and acceleration of the joint at rows, of a polynomial over their stroke."""
    if log.time is None:
        return np.zeros(len(rows)), np.zeros(len(rows))
    time = log.time[stroke.rows]
    middle = 0.5 * (time[0] + time[-1])
    half = max(0.5 * (time[-1] - time[0]), 1e-12)
    degree = min(_SHAPE_DEGREE, len(time) // 4)
    angle = log.elbow_angle[stroke.rows]
    fit = np.polynomial.Legendre.fit((time - middle) / half, angle, degree, domain=[-1.0, 1.0])
    at = (log.time[rows] - middle) / half
    return fit.deriv()(at) / half, fit.deriv(2)(at) / half**2
