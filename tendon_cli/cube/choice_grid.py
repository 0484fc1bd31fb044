"""The choices of an answer by the axes of their grid, and the window over the motion."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.cube.axes import ANGLE, TIME
from tendon_cli.cube.columns import ColumnArray
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import drawn_name, reading
from tendon_cli.errors import InputError
from tendon_cli.model.kinematics import Array, Flags, Rows
from tendon_cli.studies import limit_phrases
from tendon_cli.studies.fields import hint_at_nearest
from tendon_cli.studies.space.axis import Axis
from tendon_cli.studies.values import RIGID
from tendon_cli.units import shorten
from tendon_cli.verbs.answer_record import AnswerRecord, ChoiceRecord, CurvesRecord


def position(axis: Axis, value: Any) -> Rows:
    """Return the position of a value on an axis, or of the nearest value, as an array of one.

    Raises:
        InputError: The axis has names, and the value is none of them.
    """
    wanted = value if axis.is_text else recorded_number(value)
    is_same = np.asarray(axis.values == wanted)
    if is_same.any():
        return np.array([int(np.argmax(is_same))], dtype=np.int64)
    if axis.is_text:
        hint = hint_at_nearest(str(value), axis.names) or f"{', '.join(axis.names[:20])}"
        raise InputError(f'there is no {axis.key} "{shorten(str(value))}"', hint=hint)
    distance = np.abs(axis.values - wanted)
    return np.array([int(np.argmin(distance))], dtype=np.int64)


def value_text(cube: Cube, axis: Axis, value: Any) -> str:
    """Return one value of an axis, or of a record on it, as titles have it."""
    if axis.is_text:
        return drawn_name(axis, str(value))
    return cube.shown(axis.column).equation(recorded_number(value))


def recorded_number(value: Any) -> float:
    """Return a number of a record, in which an infinite stiffness is a word."""
    return math.inf if value == RIGID else float(value)


def upper_ends(low: ColumnArray, high: ColumnArray) -> ColumnArray:
    """Return upper ends of windows, infinite where nothing bounds one: a table has NaN there."""
    return np.where(np.isnan(high) & ~np.isnan(low), np.inf, high)


def conflicts_of(read: Mapping[str, ColumnArray], bounds: limit_phrases.LimitValues) -> ColumnArray:
    """Say for each choice why it has no window; empty if it has one.

    Args:
        read: Columns of choices: both ends of the window (an end that nothing bounds is NaN, as
            in the table) and the limits that set them.
        bounds: Limits of the study, SI; None for one that differs between choices.

    Returns:
        Texts in the shape of the columns.
    """
    low = read["pretension_from"]
    high = read["pretension_to"]
    has_window = low <= upper_ends(low, high)
    texts = np.full(low.shape, "", dtype=object)
    for index in np.argwhere(~has_window):
        place = tuple(index)
        both = [read[name][place] for name in ("from_by", "to_by")]
        limits = list(dict.fromkeys(str(limit) for limit in both if limit))
        if not np.isfinite(low[place]):
            limits = limits[:1]
        elif high[place] < 0.0:
            # No pretension at all keeps the upper limit, so that the lower one does not matter.
            limits = limits[-1:]
        texts[place] = limit_phrases.conflict_label(limits, bounds) if limits else "no window"
    return texts


def pretension_name(document: Mapping[str, Any]) -> str:
    """Return the label of an axis of pretensions, by what the resolved study sets.

    It is "pretension F₀", or for example "tension in the flexor at the joint".
    """
    words = reading(document)
    return "pretension F₀" if words == "pretension" else words


# --- The window over the motion -------------------------------------------------------------------

_ROOM = 1.6
"""Height of the picture over the top of the window, as a factor."""


@dataclass(frozen=True)
class OverMotion:
    """Window of the best choice over the motion: the pretensions that keep its limits, N.

    It is over the elbow angle, or over the time of a motion in time. In a pair the lower end comes
    first, then the upper one.
    """

    place: str
    """Column of the places: elbow_angle or time."""
    along: Array
    """Elbow angles, deg, or times, s."""
    does_count: Flags
    """False at the ends of the record of a motion in time, which count for nothing."""
    ends: tuple[dict[str, Array], dict[str, Array]]
    """Ends by limit; NaN where a limit sets none."""
    tightest: tuple[Array, Array]
    """Largest of the lower ends, smallest of the upper ones."""
    samples: Array
    """Elbow angles of the study, deg; none along a motion in time, where all places are samples."""
    at_samples: tuple[Array, Array]
    """Tightest ends at the samples; NaN above the picture."""
    window: tuple[float, float]
    """Window of the choice over all places; its upper end is infinite if nothing bounds it."""
    top: float
    """Pretension at the upper edge of the picture."""
    texts: tuple[str, str]
    """Sentences about the proof and about the meaning of the lines."""
    works: tuple[str, str]
    """Words for the window, and for the room between the tightest lines: "works at every angle"."""

    @property
    def is_in_time(self) -> bool:
        """True along a motion in time."""
        return self.place == TIME

    @property
    def word(self) -> str:
        """Noun for a place: "angle" or "time"."""
        return "time" if self.is_in_time else "angle"

    @property
    def axis_label(self) -> str:
        """Label of the axis of places."""
        return "time (s)" if self.is_in_time else "elbow angle θ (deg)"

    def shown(self, values: Array) -> Array:
        """Return the values that lie in the picture; the others are NaN."""
        return np.where((values >= 0.0) & (values <= 1.02 * self.top), values, np.nan)


def over_motion(record: AnswerRecord) -> OverMotion | None:
    """Return the best choice's window over the motion; None if the record of an answer has none."""
    between = record.between_samples
    best = record.best
    if between is None or best is None:
        return None
    curves = between.curves
    low = math.nan if best.pretension_from is None else best.pretension_from
    high = math.inf if best.pretension_to is None else best.pretension_to
    top = _ROOM * (high if math.isfinite(high) else max(2.0 * low, 1.0))
    is_in_time = curves.time is not None
    angle = np.degrees(curves.elbow_angle)
    along = np.array(curves.time) if is_in_time else angle
    samples = np.zeros(0) if is_in_time else np.degrees(curves.samples)
    lower = _arrays(curves.lower)
    upper = _arrays(curves.upper)
    floor = np.fmax.reduce([*lower.values(), np.zeros(len(along))])
    roof = np.fmin.reduce([*upper.values(), np.full(len(along), np.inf)])
    floor_at_samples = np.interp(samples, along, floor)
    roof_at_samples = np.interp(samples, along, roof)
    scope, works = _scope_texts(record, best, curves)
    return OverMotion(
        place=TIME if is_in_time else ANGLE,
        along=along,
        does_count=~np.array(curves.at_record_end or np.zeros(len(along)), dtype=np.bool_),
        ends=(lower, upper),
        tightest=(floor, roof),
        samples=samples,
        at_samples=(
            np.where(floor_at_samples <= top, floor_at_samples, np.nan),
            np.where(roof_at_samples <= top, roof_at_samples, np.nan),
        ),
        window=(low, high),
        top=top,
        texts=(limit_phrases.proof_sentence(between), scope),
        works=works,
    )


def _arrays(curves: Mapping[str, Any]) -> dict[str, Array]:
    """Return curves of a record as arrays; null becomes NaN."""
    return {name: np.array(values, dtype=np.float64) for name, values in curves.items()}


def served_words(record: AnswerRecord) -> str:
    """Say what a window suits: "all conditions", "at least 95 % of the draws"."""
    if record.serve >= 1.0:
        return "all conditions"
    return f"at least {say.percent(record.serve)} of the {record.question.counted}"


def _scope_texts(
    record: AnswerRecord, best: ChoiceRecord, curves: CurvesRecord
) -> tuple[str, tuple[str, str]]:
    """Say for which conditions the lines are, and what the window and the room between them do.

    Args:
        record: Record of an answer.
        best: The choice that it names first.
        curves: Its lines.
    """
    of_all = curves.all_conditions
    pretension = "the pretension"
    if best.pretension is not None:
        pretension = f"{say.number(best.pretension, 3)} {record.question.unit}"
    lines = "all conditions" if of_all else f"the conditions that {pretension} serves"
    is_in_time = curves.time is not None
    place = "time" if is_in_time else "angle"
    window = "works at every angle"
    if is_in_time:
        window = "works at all times"
    elif len(set(curves.elbow_angle)) == 1:
        window = "works at this angle"
    room = f"works at that {place}" if of_all else f"works at that {place} for those served"
    remark = ""
    if record.serve < 1.0:
        share = f"at least {say.percent(record.serve)}"
        window = f"{window} for {share}"
        remark = f" The window serves {served_words(record)}."
        if of_all:
            room = f"{room} for all"
    elif not of_all:
        remark = " The window is that of all conditions."
    directions = "" if is_in_time else " and both directions"
    return f"Each line is the worst over {lines}{directions}.{remark}", (window, room)
