"""Strokes of a suit's logs: rows that slide, averaged over parts of each stroke.

Friction has its full size only while the tendons slide, so rows are used from where the sheaths
have turned after each turn of the joint. Rows of one stroke are not independent, and their means
over parts of the stroke hold all that they tell.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tendon_cli import say
from tendon_cli.errors import InputError
from tendon_cli.fits.log_rows import Floats, Integers, LogRows, Mask, means_by
from tendon_cli.fits.suit.log_columns import SPOOL_ANGLE
from tendon_cli.fits.suit.parameters import range_of
from tendon_cli.fits.suit.suit_log import SuitLog
from tendon_cli.model.design import map_arrays
from tendon_cli.units import counted

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
_SLID = 3.0
"""Way of the spool after a turn, over that in which the sheath turns, from which rows are used."""
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
    rows: SuitLog
    is_first: bool
    """True for the first stroke of a log and after a gap, before which nothing is known."""

    @property
    def sign(self) -> float:
        """1 in flexion, -1 in extension."""
        angle = self.rows.elbow_angle
        return 1.0 if angle[-1] > angle[0] else -1.0


@dataclass(frozen=True, eq=False)
class Parts(LogRows):
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


@dataclass(frozen=True, eq=False)
class Selection:
    """Means over parts of strokes, of the rows that slide."""

    logs: tuple[SuitLog, ...]
    parts: Parts
    set_aside: Mapping[str, int]
    """Number of rows set aside, by reason."""
    notes: tuple[str, ...]

    @property
    def used(self) -> int:
        """Number of rows used."""
        return round(float(self.parts.count.sum()))

    def without(self, is_left_out: Mask, reason: int) -> Selection:
        """Return the selection without some parts, for the reason with this code."""
        rows = round(float(self.parts.count[is_left_out].sum()))
        if not rows:
            return self
        aside = dict(Counter(self.set_aside) + Counter({REASONS[reason]: rows}))
        return replace(self, parts=self.parts.select(~is_left_out), set_aside=aside)


def strokes_of(logs: Sequence[SuitLog]) -> tuple[LogStroke, ...]:
    """Return the strokes of logs, between the turns of the joint, changes of load and gaps in time.

    Raises:
        InputError: if there is a single stroke, or none.
    """
    strokes = []
    for number, log in enumerate(logs):
        angle = log.elbow_angle
        turns = _turns(angle, max(_TURN, _TURN_SHARE * range_of(angle)))
        after_gap = _gaps_of(log) + 1
        breaks = after_gap
        if log.load_mass is not None:
            breaks = np.union1d(breaks, np.flatnonzero(np.diff(log.load_mass)) + 1)
        for first, last in itertools.pairwise([0, *turns, len(angle) - 1]):
            within = breaks[(breaks > first) & (breaks <= last)].tolist()
            for start, end in itertools.pairwise([first, *within, last + 1]):
                is_first = start == 0 or start in after_gap
                if end - start > 4:
                    strokes.append(LogStroke(number, log.select(slice(start, end)), is_first))
    if len(strokes) < 2:
        raise InputError(
            f"{counted(len(strokes), 'stroke')}: friction cannot be told from the load",
            where=logs[0].source,
            hint="log two strokes or more, to and fro through most of the joint's range",
        )
    return tuple(strokes)


def _gaps_of(log: SuitLog) -> Integers:
    """Return the rows after which the log has a gap in time."""
    if log.time is None or len(log) < 3:
        return np.empty(0, dtype=np.int64)
    steps = np.diff(log.time)
    usual = np.quantile(steps, _USUAL_STEPS)
    return np.flatnonzero(steps > _GAP * max(usual, 1e-12))


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


def selected(
    logs: tuple[SuitLog, ...],
    strokes: Sequence[LogStroke],
    spool_turn: float,
    spool_per_joint: float,
) -> Selection:
    """Select the rows that slide, once the sheaths have turned, and average them over parts.

    Args:
        logs: Logs.
        strokes: Their strokes.
        spool_turn: Way of the spool in which the sheaths turn, rad.
        spool_per_joint: Way of the spool per way of the joint.

    Raises:
        InputError: if nothing slides, or only in one direction.
    """
    way = _SLID * spool_turn
    lengths = np.array([np.ptp(stroke.rows.elbow_angle) for stroke in strokes])
    log_of = np.array([stroke.log for stroke in strokes])
    used = []
    for stroke in strokes:
        usual = np.median(lengths[log_of == stroke.log])
        codes = _usable(stroke, usual, way / max(spool_per_joint, 0.2), way)
        if np.any(codes == USED):
            used.append((stroke, codes))
    notes = [text for log in logs for text in _note_on_gaps(log)]
    if len(used) > MOST_STROKES:
        notes.append(
            f"{MOST_STROKES} of {len(used)} strokes are fitted, evenly spaced: more would not"
            " narrow what the model's own misfit leaves open"
        )
        kept = np.unique(np.round(np.linspace(0, len(used) - 1, MOST_STROKES)).astype(int))
        used = [used[place] for place in kept.tolist()]
    set_aside = Counter({"without a number": sum(log.missing for log in logs)})
    for _, codes in used:
        reasons, rows = np.unique(codes[codes != USED], return_counts=True)
        for reason, count in zip(reasons.tolist(), rows.tolist(), strict=True):
            set_aside[REASONS[reason]] += count
    found = [
        _parts_of(stroke, codes == USED, number)
        for number, (stroke, codes) in enumerate(used)
        if np.count_nonzero(codes == USED) >= 2 * PARTS // 3
    ]
    if not found:
        raise InputError(
            "no stroke slides long enough: nothing is left after the turns",
            where=logs[0].source,
            hint="move the joint slowly through most of its range, several times to and fro",
        )
    first, *others = found
    parts: Parts = map_arrays(first, lambda *means: np.concatenate(means), *others)
    if len(np.unique(parts.flexion)) < 2:
        way_used = "flexion" if parts.flexion[0] else "extension"
        raise InputError(
            f"{counted(len(found), 'stroke')} can be used, in {way_used} alone, so friction cannot"
            " be told from the load",
            where=logs[0].source,
            hint="log two strokes or more, to and fro",
        )
    return Selection(logs, parts, dict(+set_aside), tuple(notes))


def _note_on_gaps(log: SuitLog) -> list[str]:
    """Return a note on gaps in time, where and how long; none where the load was changed."""
    gaps = _gaps_of(log)
    if log.load_mass is not None:
        gaps = gaps[log.load_mass[gaps] == log.load_mass[gaps + 1]]
    if not len(gaps) or log.time is None:
        return []
    lasts = np.diff(log.time)[gaps]
    longest = gaps[int(np.argmax(lasts))]
    text = (
        f"{log.source}: {counted(len(gaps), 'gap')} in the time, the longest of"
        f" {say.number(float(lasts.max()), 3)} s after line {log.line[longest]}; rows after a gap"
        " count once the tendons slide again"
    )
    return [text]


def _usable(stroke: LogStroke, usual_length: float, least_way: float, spool_way: float) -> Integers:
    """Return why each row of a stroke is set aside, a code per row.

    Where the elbow is unstable the spool turns back while the joint goes on, and friction with it.

    Args:
        stroke: The stroke.
        usual_length: Median length of the strokes of the log, rad.
        least_way: Way of the joint after a turn until the tendons slide, rad.
        spool_way: Way of the spool after a turn until they slide, rad.
    """
    log = stroke.rows
    place = np.arange(len(log))
    way = stroke.sign * (log.elbow_angle - log.elbow_angle[0])
    codes = np.full(len(log), USED)
    if way[-1] < _SHORT_SHARE * usual_length:
        codes[:] = SHORT
        return codes
    has_slid = way >= max(_LEAST_WAY, least_way)
    goes_along = np.ones(len(log), dtype=bool)
    if SPOOL_ANGLE in log.channels:
        wound = stroke.sign * log.channels[SPOOL_ANGLE]
        least = int(np.argmin(wound))
        has_slid &= (wound - wound[least] >= spool_way) & (place > least)
        speed = _speed(wound, place.astype(np.float64))
        goes_along = speed > _BACK_SHARE * np.median(speed)
    first = int(np.argmax(has_slid)) if has_slid.any() else len(log)
    codes[:first] = STARTING if stroke.is_first else TURNING
    codes[~goes_along & (codes == USED)] = AGAINST
    codes[first:][way[first:] > (1.0 - _END_SHARE) * way[-1]] = TURNING
    if log.time is not None and first < len(log) - 8:
        speed = _speed(way, log.time)[first:]
        codes[first:][speed < _REST_SHARE * np.median(speed)] = RESTING
    return codes


def _speed(way: Floats, time: Floats) -> Floats:
    """Return the speed along a stroke from rows a fortieth of it to either side."""
    reach = max(2, len(way) // 40)
    after = np.minimum(np.arange(len(way)) + reach, len(way) - 1)
    before = np.maximum(np.arange(len(way)) - reach, 0)
    step = time[after] - time[before]
    moved = way[after] - way[before]
    return np.divide(moved, step, out=np.zeros(len(way)), where=step > 0.0)


def _parts_of(stroke: LogStroke, kept: Mask, number: int) -> Parts:
    """Return the means of the rows that are kept over the parts of a stroke with a number."""
    speed, acceleration = _derivatives(stroke.rows)
    rows = stroke.rows.select(kept)
    angle = rows.elbow_angle
    low = angle.min()
    part = np.minimum((PARTS * (angle - low) / (angle.max() - low)).astype(np.int64), PARTS - 1)
    _, part = np.unique(part, return_inverse=True)
    count = np.bincount(part).astype(np.float64)
    middle = means_by(part, angle)
    load = np.nan
    if stroke.rows.load_mass is not None:
        load = np.median(stroke.rows.load_mass)
    return Parts(
        log=np.full(len(count), stroke.log),
        stroke=np.full(len(count), number),
        flexion=np.full(len(count), stroke.sign > 0.0),
        load=np.full(len(count), load),
        angle=middle,
        spread=np.sqrt(np.maximum(means_by(part, np.square(angle - middle[part])), 1e-10)),
        speed=means_by(part, speed[kept]),
        acceleration=means_by(part, acceleration[kept]),
        place=means_by(part, rows.place),
        count=count,
        values={name: means_by(part, column) for name, column in rows.channels.items()},
    )


def _derivatives(log: SuitLog) -> tuple[Floats, Floats]:
    """Return speed and acceleration of the joint in a stroke, of a polynomial over it."""
    if log.time is None:
        return np.zeros(len(log)), np.zeros(len(log))
    middle = 0.5 * (log.time[0] + log.time[-1])
    half = max(0.5 * (log.time[-1] - log.time[0]), 1e-12)
    degree = min(_SHAPE_DEGREE, len(log) // 4)
    at = (log.time - middle) / half
    fit = np.polynomial.Legendre.fit(at, log.elbow_angle, degree, domain=[-1.0, 1.0])
    return fit.deriv()(at) / half, fit.deriv(2)(at) / half**2
