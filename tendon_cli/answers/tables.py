"""Tables of an answer: a row per choice, per condition, and per person or draw.

Rows of persons or draws are under the choice that the answer names first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from tendon_cli.answers.people import GroupWindows, people_of
from tendon_cli.answers.setup import SETTING_COLUMNS, settings
from tendon_cli.answers.text_bench import SET_AT_JOINT
from tendon_cli.engine.plan import columns_of_motion
from tendon_cli.engine.table_columns import (
    axis_column,
    carried_columns,
    columns_set_by_names,
)
from tendon_cli.engine.windows.advice import ADVICE
from tendon_cli.engine.windows.by_choice import ColumnArrays
from tendon_cli.engine.windows.coverage import share_served
from tendon_cli.engine.windows.points import Points, set_by_names
from tendon_cli.engine.windows.question import Question, column_read
from tendon_cli.engine.windows.solutions import ENDS, End, Solutions
from tendon_cli.engine.windows.study_arm import own_f0, study_arm
from tendon_cli.engine.windows.worst import WORST
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.model.design import F0
from tendon_cli.model.kinematics import Array, Rows
from tendon_cli.model.limits import LIMIT_NAMES
from tendon_cli.quantities import QUANTITIES, bound_name, unit_of_reading
from tendon_cli.studies import limit_phrases
from tendon_cli.studies.space.axis import Axis
from tendon_cli.studies.space.space import Space
from tendon_cli.studies.values import RIGID
from tendon_cli.tables.schema import Column, finite_or_none
from tendon_cli.verbs.answer_record import ChoiceRecord
from tendon_cli.verbs.typed_record import to_json

_LIMITS = ("", *LIMIT_NAMES)
"""Names of limits by their code plus one, because the code NOTHING is -1."""
VERIFIED = (
    "served_verified",
    "served_verified_low",
    "served_verified_high",
    "verified_from",
    "verified_to",
)
"""Columns of the judgement of a fresh sample: share, its 95 % interval, and window."""
_BINDS = tuple(
    Column(f"{end}_condition", "count", "1", "row of conditions that binds")
    for end in ("from", "to")
)
FLEXOR_TO_SET = SET_AT_JOINT[0]
"""Column of the tension to set in the flexor at the joint; with an end, of that at an end."""
_SEX = Column("sex", "text", "1", "sex", choices=("male", "female"))


def choice_columns(question: Question) -> tuple[Column, ...]:
    """Return the columns of `choices.parquet`, those that say what a choice is first."""
    read = column_read(question)
    return (*_row_columns(question.choices, read), *_solved_columns(question))


def _solved_columns(question: Question) -> tuple[Column, ...]:
    """Return the columns of what is found for a choice."""
    directions = ("", *question.study.motion.direction)
    or_impossible = "or what no pretension could keep"
    of_state = "direction of the state that binds; empty where the limit belongs to none"
    read = column_read(question)
    return (
        *_of_quantities("pretension_from", "pretension_to", read=read),
        Column(
            "windows",
            "count",
            "1",
            "intervals of pretension that serve enough; the widest is the window",
        ),
        *_of_quantities("tolerance"),
        Column(
            "from_by",
            "text",
            "1",
            f"limit that sets the lower end, {or_impossible}",
            choices=_LIMITS,
        ),
        Column(
            "to_by", "text", "1", f"limit that sets the upper end, {or_impossible}", choices=_LIMITS
        ),
        *_BINDS,
        Column("from_direction", "text", "1", of_state, choices=directions),
        Column("to_direction", "text", "1", of_state, choices=directions),
        Column.of(QUANTITIES["elbow_angle"], "from_elbow_angle"),
        Column.of(QUANTITIES["elbow_angle"], "to_elbow_angle"),
        *_times(question),
        *_of_quantities("served", "served_at", "pretension", *WORST, read=read),
        *_of_quantities(*columns_of_motion(question.study)),
        *_settings_of_choices(),
        *_of_quantities("tolerance_length", read=read),
        Column("advice", "text", "1", "advice that it fails; empty if none", choices=ADVICE),
        Column(
            "between_samples",
            "text",
            "1",
            "whether the window is proved between the samples",
            choices=limit_phrases.STATUSES,
        ),
        Column(
            "feasible",
            "truth",
            "1",
            "has a window; if the pretension is given, it serves enough",
        ),
        Column(
            "on_front", "truth", "1", "no other choice is as good in all goals and better in one"
        ),
        *_of_quantities(*VERIFIED, read=read),
    )


def _times(question: Question) -> tuple[Column, ...]:
    """Return the columns of the moments that bind along a trajectory."""
    if question.study.trajectory is None:
        return ()
    return tuple(Column.of(QUANTITIES["time"], f"{end}_time") for end in ("from", "to"))


def choice_rows(question: Question, choices: Solutions) -> ColumnArrays:
    """Return rows of `choices.parquet` without what only the whole answer knows of them.

    Texts are places among the `choices` of their column.
    """
    at_pretension = choices.points.at_pretension(choices.pretension)
    unknown = np.full(len(choices), np.nan)
    counts = question.conditions.groups is not None
    readings = np.stack([choices.pretension_from, choices.pretension_to, choices.pretension])
    low, high, pretension = own_f0(question, choices.points, readings)
    return {
        **choices.points.columns,
        "pretension_from": low,
        "pretension_to": _finite(high),
        "windows": choices.windows,
        "tolerance": choices.tolerance,
        **_of_end(question, choices, "from"),
        **_of_end(question, choices, "to"),
        "served": np.where(counts, choices.served, np.nan),
        "served_at": np.where(counts, choices.served_at, np.nan),
        "pretension": pretension,
        **{name: getattr(choices.worst, name) for name in WORST},
        **{
            name: choices.worst.motion.get(name, unknown)
            for name in columns_of_motion(question.study)
        },
        "advice": choices.advice,
        **settings(study_arm(question, at_pretension), _to_set(question, choices), len(choices)),
        **{f"{FLEXOR_TO_SET}_{end}": _flexor_at(question, choices, end) for end in ENDS},
        "tolerance_length": _finite(choices.tolerance_length),
        "between_samples": choices.between_samples,
        "feasible": choices.feasible,
        "on_front": np.zeros(len(choices), dtype=np.bool_),
        **dict.fromkeys(VERIFIED, np.full(len(choices), np.nan)),
    }


def completed_rows(
    question: Question, solved: Solutions, named: Sequence[ChoiceRecord], rows: range
) -> ColumnArrays:
    """Return rows of `choices.parquet`, with those that the answer names as it records them.

    Args:
        question: The question.
        solved: The choices as they were solved.
        named: Those of them that the answer names.
        rows: Their numbers.
    """
    values = {name: np.array(column) for name, column in choice_rows(question, solved).items()}
    flat_rows = [flat(record) for record in named]
    places = [row.choice - rows.start for row in named]
    for column in _solved_columns(question):
        values[column.name][places] = [as_value(column, row[column.name]) for row in flat_rows]
    return values


def _to_set(question: Question, choices: Solutions) -> Array:
    """Return the pretensions to set, N; NaN for a choice without a window, unless it is given.

    Where suits are drawn, a choice without a window is set to what serves most of them.
    """
    if question.placement.given is not None or question.sample.sets_by_sample:
        return choices.pretension
    return np.where(choices.has_window, choices.pretension, np.nan)


def _flexor_at(question: Question, choices: Solutions, end: End) -> Array:
    """Return what a gauge in the flexor at the joint shows at an end of windows, (choices,), N."""
    ends = _finite(choices.pretension_at(end))
    at_end = study_arm(question, choices.points.at_pretension(np.nan_to_num(ends)))
    return settings(at_end, ends, len(choices))[FLEXOR_TO_SET]


def _of_end(question: Question, choices: Solutions, end: End) -> ColumnArrays:
    """Return the columns of the limit that sets one end of each window."""
    binding = choices.binding(end)
    has_state = binding.state >= 0
    direction, place = np.divmod(binding.state, question.angles.size)
    trajectory = question.study.trajectory
    of_time: ColumnArrays = {}
    if trajectory is not None:
        direction = np.where(trajectory.is_flexing[place], 0, 1)
        of_time = {f"{end}_time": np.where(has_state, trajectory.time[place], np.nan)}
    angle_of_state = np.where(has_state, question.angles[0, place], np.nan)
    return {
        f"{end}_by": binding.by.astype(np.int64) + 1,
        f"{end}_condition": binding.condition,
        f"{end}_direction": np.where(has_state, direction + 1, 0),
        f"{end}_elbow_angle": np.where(np.isnan(binding.angle), angle_of_state, binding.angle),
        **of_time,
    }


def condition_columns(question: Question) -> tuple[Column, ...]:
    """Return the columns of `conditions.parquet`."""
    weighting = Column("weighting", "number", "1", "how much the condition counts in a share")
    read = column_read(question)
    return (*_row_columns(question.conditions, read), weighting)


def condition_rows(question: Question) -> ColumnArrays:
    """Return the rows of `conditions.parquet`."""
    count = len(question.conditions)
    weighting = question.conditions.weighting
    rows: ColumnArrays = question.conditions.columns(np.arange(count))
    rows["weighting"] = np.ones(count) if weighting is None else weighting
    return rows | set_by_names(question.conditions, question.conditions)


# --- Persons and draws ----------------------------------------------------------------------------


def person_columns(question: Question, axis: Axis) -> tuple[Column, ...]:
    """Return the columns of `persons.parquet`, or of `draws.parquet`."""
    people = people_of(question)
    names = axis.names if people is None else people.persons
    sex = (_SEX,) if people is not None and people.sexes else ()
    dimensions = DIMENSIONS if people is not None else ()
    return (
        replace(axis_column(axis), choices=names),
        *sex,
        Column("weighting", "number", "1", "how much it counts in a share"),
        *_of_quantities(*dimensions),
        *_of_quantities("pretension_from", "pretension_to", read=column_read(question)),
        Column("from_by", "text", "1", "limit that binds below", choices=_LIMITS),
        Column("to_by", "text", "1", "limit that binds above", choices=_LIMITS),
        *_BINDS,
        Column(
            "served",
            "number",
            "1",
            "whether the pretension of the choice serves it; of several draws the share",
        ),
        *_of_quantities(*SETTING_COLUMNS),
    )


def person_rows(
    question: Question, axis: Axis, windows: GroupWindows, points: Points, pretension: float
) -> ColumnArrays:
    """Return a row per person, or per draw, under one choice.

    The window of a person serves at least the share `serve` of that person's draws. Several bodies
    drawn for one person count as draws, too; dimensions and tensions to set are their means.

    Args:
        question: The question.
        axis: Axis of the persons or draws.
        windows: Windows of the choice for all groups.
        points: The choice.
        pretension: Its pretension, N.
    """
    people = people_of(question)
    bodies = 1 if people is None else people.completions
    count = len(axis) // bodies
    weighting = np.ones(count)
    if axis.weighting is not None:
        weighting = axis.weighting.reshape(count, -1).sum(axis=1)
    served = windows.served(pretension).reshape(count, -1)  # (persons, draws)
    low, high, low_group, high_group = _person_windows(question, windows, served.shape)
    rows: ColumnArrays = {
        axis.column: np.arange(count),
        "weighting": weighting,
        "pretension_from": _own_f0_of_one(question, points, low),
        "pretension_to": _own_f0_of_one(question, points, _finite(high)),
        "from_by": windows.low_by[low_group].astype(np.int64) + 1,
        "to_by": windows.high_by[high_group].astype(np.int64) + 1,
        "from_condition": windows.low_condition[low_group],
        "to_condition": windows.high_condition[high_group],
        "served": served.mean(axis=1),
    }
    if people is not None:
        mean = people.values.reshape(count, bodies, -1).mean(axis=1)
        for place, dimension in enumerate(DIMENSIONS):
            rows[dimension] = mean[:, place]
        if people.sexes:
            sexes = people.sexes[::bodies]
            rows["sex"] = np.array([_SEX.choices.index(sex) for sex in sexes])
    set_to = np.array([pretension])
    design = study_arm(question, points.at_pretension(set_to), axis)
    for name, values in settings(design, set_to, len(axis)).items():
        rows[name] = values.reshape(count, -1).mean(axis=1)
    return rows


def _own_f0_of_one(question: Question, points: Points, readings: Array) -> Array:
    """Return readings of one choice as columns of pretension have them, (readings,), N."""
    repeated = points.select(np.zeros(len(readings), dtype=np.int64))
    return own_f0(question, repeated, readings)


def _person_windows(
    question: Question, windows: GroupWindows, shape: tuple[int, ...]
) -> tuple[Array, Array, Rows, Rows]:
    """Return the ends of each person's window, N, and the group that binds at each end.

    Args:
        question: The question.
        windows: Windows of one choice for all groups.
        shape: Number of persons, and of the draws of each.
    """
    persons, draws = shape
    low = windows.low.reshape(shape)
    high = windows.high.reshape(shape)
    rows = np.arange(persons)
    low_draw = np.argmax(low, axis=1)
    high_draw = np.argmin(high, axis=1)
    common_low = low[rows, low_draw]
    common_high = high[rows, high_draw]
    if draws > 1:
        covered = share_served(low, high, np.ones(draws), serve=question.serve)
        has_window = ~np.isnan(covered.low)
        at_low = np.argmax(low == covered.low[:, np.newaxis], axis=1)
        at_high = np.argmax(high == covered.high[:, np.newaxis], axis=1)
        low_draw = np.where(has_window, at_low, low_draw)
        high_draw = np.where(has_window, at_high, high_draw)
        common_low = np.where(has_window, covered.low, common_low)
        common_high = np.where(has_window, covered.high, common_high)
    first_group = rows * draws
    return common_low, common_high, first_group + low_draw, first_group + high_draw


# --- Columns and values ---------------------------------------------------------------------------


def _of_quantities(*names: str, read: str = F0) -> tuple[Column, ...]:
    """Return columns of quantities; those of pretension say how it is read."""
    columns = []
    for name in names:
        column = Column.of(QUANTITIES[name])
        if name.startswith("pretension") and read != F0:
            long_name = f"{column.long_name}, read as {read}"
            column = replace(column, unit=unit_of_reading(read), long_name=long_name)
        columns.append(column)
    return tuple(columns)


def _settings_of_choices() -> tuple[Column, ...]:
    """Return the columns of the tensions to set, which say when they are null."""
    ends = (f"{FLEXOR_TO_SET}_{end}" for end in ENDS)
    return tuple(
        replace(column, long_name=f"{column.long_name}; null without a window, see from_by, to_by")
        for column in _of_quantities(*SETTING_COLUMNS, *ends)
    )


def _row_columns(space: Space, read: str) -> tuple[Column, ...]:
    """Return the columns that say what a row of a space is: its axes, and what their names set.

    Args:
        space: The space.
        read: Gauge by which a pretension is read, and so the limit on it.
    """
    columns = (*map(axis_column, space.axes), *columns_set_by_names(space).values())
    of_reading = bound_name("max_pretension")
    as_read = [
        replace(column, unit=unit_of_reading(read)) if column.name == of_reading else column
        for column in columns
    ]
    return (*as_read, *carried_columns(space))


def _finite(ends: Array) -> Array:
    """Return ends with NaN for infinity."""
    return np.where(np.isinf(ends), np.nan, ends)


def as_records(columns: tuple[Column, ...], rows: ColumnArrays) -> list[dict[str, Any]]:
    """Return rows for JSON: texts for their places, None for missing or infinite numbers."""
    lists = {column.name: _as_list(column, np.asarray(rows[column.name])) for column in columns}
    return [dict(zip(lists, values, strict=True)) for values in zip(*lists.values(), strict=True)]


def _as_list(column: Column, values: np.ndarray[Any, Any]) -> list[Any]:
    """Return the values of a column for JSON."""
    if column.kind == "text":
        return [column.choices[place] or None for place in values]
    if column.kind != "number":
        return list(values.tolist())
    infinite = RIGID if column.is_axis else None
    return [infinite if value == np.inf else finite_or_none(value) for value in values.tolist()]


def flat(record: ChoiceRecord) -> dict[str, Any]:
    """Return a recorded choice with the judgement of a fresh sample in columns of its own."""
    judged = record.served_verified
    values: Sequence[float | None] = [None] * len(VERIFIED)
    if judged is not None:
        values = [judged.value, *judged.interval_95, judged.from_, judged.to]
    return {**to_json(record), **dict(zip(VERIFIED, values, strict=True))}


def as_value(column: Column, value: Any) -> Any:
    """Convert a value of a record to the one that its column stores."""
    if column.kind == "text":
        return column.choices.index(value or "")
    if value == RIGID:
        return np.inf
    return np.nan if value is None else value
