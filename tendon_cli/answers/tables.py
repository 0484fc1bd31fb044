"""The tables of an answer: a row per choice, per condition, and per person or draw under the choice named first."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.answers.coverage import share_served
from tendon_cli.answers.people import GroupWindows, people_of
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.question import ColumnArrays
from tendon_cli.answers.setup import SET, setting_columns, settings, study_arm
from tendon_cli.answers.solve import WORST, Solutions
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.model.design import F0
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.limits import LIMIT_NAMES
from tendon_cli.quantities import QUANTITIES
from tendon_cli.space.axis import Axis, Rows
from tendon_cli.studies.study import keys
from tendon_cli.studies.values import RIGID
from tendon_cli.tables.schema import Column

_LIMITS = ("", *LIMIT_NAMES)  # by a limit's code and one: NOTHING is -1
_BINDS = tuple(
    Column(f"{end}_condition", "count", "1", "row of conditions that binds")
    for end in ("from", "to")
)
_SEX = Column("sex", "text", "1", "sex", choices=("male", "female"))


def choice_columns(problem: Problem) -> tuple[Column, ...]:
    """Columns of `choices.parquet`."""
    directions, neither = ("", *problem.study.motion.direction), "or what no pretension could keep"
    read = problem.study.setting.read
    of_state = "direction of the state that binds; empty where the limit belongs to none"
    return (
        *map(_of_axis, problem.choices.axes),
        Column("refined", "truth", "1", "a point between those of the grid"),
        *_of_quantities("pretension_from", "pretension_to", read=read),
        Column(
            "windows",
            "count",
            "1",
            "intervals of pretension that serve enough; the widest is the window",
        ),
        *_of_quantities("tolerance"),
        Column("from_by", "text", "1", f"limit that binds below, {neither}", choices=_LIMITS),
        Column("to_by", "text", "1", f"limit that binds above, {neither}", choices=_LIMITS),
        *_BINDS,
        *(
            Column(f"{end}_direction", "text", "1", of_state, choices=directions)
            for end in ("from", "to")
        ),
        *(Column.of(QUANTITIES["elbow_angle"], f"{end}_elbow_angle") for end in ("from", "to")),
        *_of_quantities(
            "served", "served_at", "pretension", *WORST, *SET, "tolerance_length", read=read
        ),
        Column(
            "between_samples",
            "text",
            "1",
            "whether the window is proved between the samples",
            choices=say.STATUSES,
        ),
        Column(
            "feasible",
            "truth",
            "1",
            "it has a window; if the pretension is given, that serves enough",
        ),
        Column(
            "on_front", "truth", "1", "no other choice is as good in every goal and better in one"
        ),
    )


def choice_rows(
    problem: Problem, choices: Solutions, refined: Flags, on_front: Flags
) -> ColumnArrays:
    """Rows of `choices.parquet`; text as positions among the column's words."""
    rows = choices.results | choices.columns | {"refined": refined, "on_front": on_front}
    low, high, at = (choices[name] for name in ("pretension_from", "pretension_to", "pretension"))
    rows["pretension_to"] = _finite(high)
    for end in ("from", "to"):
        state, angle = choices[f"{end}_state"], choices[f"{end}_angle"]
        direction, place = np.divmod(state, problem.angles.size)
        rows[f"{end}_by"] = choices[f"{end}_by"].astype(np.int64) + 1
        if problem.study.trajectory is not None:
            direction = np.where(problem.flexion[0, place], 0, 1)
        rows[f"{end}_direction"] = np.where(state < 0, 0, direction + 1)
        of_state = np.where(state < 0, np.nan, problem.angles[0, place])
        rows[f"{end}_elbow_angle"] = np.where(np.isnan(angle), of_state, angle)
    return rows | setting_columns(problem, problem.numbers_of(choices.columns), low, high, at)


def condition_columns(problem: Problem) -> tuple[Column, ...]:
    """Columns of `conditions.parquet`."""
    weighting = Column("weighting", "number", "1", "how much the condition counts in a share")
    return (*map(_of_axis, problem.conditions.axes), weighting)


def condition_rows(problem: Problem) -> ColumnArrays:
    """Rows of `conditions.parquet`."""
    count, given = len(problem.conditions), problem.conditions.weighting
    columns: ColumnArrays = problem.conditions.columns(np.arange(count))
    return columns | {"weighting": np.ones(count) if given is None else given}


# --- Persons and draws -----------------------------------------------------------------------------------------------


def person_columns(problem: Problem, axis: Axis) -> tuple[Column, ...]:
    """Columns of `persons.parquet`, or of `draws.parquet`."""
    people = people_of(problem)
    ends = (("from", "below"), ("to", "above"))
    names = axis.names if people is None else people.persons
    return (
        Column(axis.column, "text", "1", axis.meaning, is_axis=True, choices=names),
        *((_SEX,) if people is not None and people.sexes else ()),
        Column("weighting", "number", "1", "how much it counts in a share"),
        *_of_quantities(*(DIMENSIONS if people is not None else ())),
        *_of_quantities("pretension_from", "pretension_to", read=problem.study.setting.read),
        *(
            Column(f"{end}_by", "text", "1", f"limit that binds {word}", choices=_LIMITS)
            for end, word in ends
        ),
        *_BINDS,
        Column(
            "served",
            "number",
            "1",
            "whether the pretension of the choice serves it; of several draws the share",
        ),
        *_of_quantities(*SET),
    )


def person_rows(
    problem: Problem, axis: Axis, windows: GroupWindows, columns: ColumnArrays, pretension: float
) -> ColumnArrays:
    """A row per person under one choice at its pretension (N): its window is of at least `serve` of its draws.

    With completions the bodies drawn of a person are draws, too; body and tensions to set are their means.
    """
    people = people_of(problem)
    bodies = 1 if people is None else people.completions
    count = len(axis) // bodies
    served = windows.served(pretension).reshape(count, -1)
    low, high, first, last = _windows(problem, windows, served.shape)
    rows: ColumnArrays = {
        axis.column: np.arange(count),
        "weighting": np.ones(count)
        if axis.weighting is None
        else axis.weighting.reshape(count, -1).sum(axis=1),
        "pretension_from": low,
        "pretension_to": _finite(high),
        "from_by": windows.low_by[first].astype(np.int64) + 1,
        "to_by": windows.high_by[last].astype(np.int64) + 1,
        "from_condition": windows.low_condition[first],
        "to_condition": windows.high_condition[last],
        "served": served.mean(axis=1),
    }
    if people is not None:
        mean = people.values.reshape(count, bodies, -1).mean(axis=1)
        rows |= {name: mean[:, at] for at, name in enumerate(DIMENSIONS)}
        sexes = people.sexes[::bodies]
        rows |= {"sex": np.array([_SEX.choices.index(sex) for sex in sexes])} if sexes else {}
    design = study_arm(problem, problem.numbers_of(columns), np.array([pretension]), axis)
    set_ = settings(design, len(axis))
    return rows | {name: values.reshape(count, -1).mean(axis=1) for name, values in set_.items()}


def _windows(
    problem: Problem, windows: GroupWindows, shape: tuple[int, ...]
) -> tuple[Array, Array, Rows, Rows]:
    """The window of each person, and the group that binds at each end of it."""
    low, high = windows.low.reshape(shape), windows.high.reshape(shape)
    first, last = np.argmax(low, axis=1), np.argmin(high, axis=1)
    start, rows = np.arange(shape[0]) * shape[1], np.arange(shape[0])
    ends = low[rows, first], high[rows, last]
    if shape[1] > 1:
        covered = share_served(low, high, np.ones(shape[1]), enough=problem.enough)
        some = ~np.isnan(covered.low)
        first = np.where(some, np.argmax(low == covered.low[:, np.newaxis], axis=1), first)
        last = np.where(some, np.argmax(high == covered.high[:, np.newaxis], axis=1), last)
        ends = np.where(some, covered.low, ends[0]), np.where(some, covered.high, ends[1])
    return *ends, start + first, start + last


# --- Columns and values ----------------------------------------------------------------------------------------------


def _of_quantities(*names: str, read: str = F0) -> tuple[Column, ...]:
    """Columns of quantities; those of pretension say how it is read."""
    of = (
        (Column.of(QUANTITIES[name]), name.startswith("pretension") and read != F0)
        for name in names
    )
    return tuple(
        replace(each, long_name=f"{each.long_name}, read as {read}") if other else each
        for each, other in of
    )


def _of_axis(axis: Axis) -> Column:
    if axis.names:
        return Column(axis.column, "text", "1", axis.meaning, is_axis=True, choices=axis.names)
    return Column.of(keys()[axis.key].number.quantity, axis.column, is_axis=True)


def _finite(ends: Array) -> Array:
    return np.where(np.isinf(ends), np.nan, ends)


def as_records(columns: tuple[Column, ...], rows: ColumnArrays) -> list[dict[str, Any]]:
    """Rows as a JSON text has them: words for positions, null for what is not a number."""
    listed = {column.name: _as_list(column, np.asarray(rows[column.name])) for column in columns}
    return [dict(zip(listed, values, strict=True)) for values in zip(*listed.values(), strict=True)]


def _as_list(column: Column, values: np.ndarray[Any, Any]) -> list[Any]:
    if column.kind == "text":
        return [column.choices[at] or None for at in values]
    if column.kind == "number":
        endless = RIGID if column.is_axis else None
        return [
            value if np.isfinite(value) else endless if value == np.inf else None
            for value in values.tolist()
        ]
    return list(values.tolist())


def as_value(column: Column, value: Any) -> Any:
    """A value of a record as its column holds it."""
    if column.kind == "text":
        return column.choices.index(value or "")
    return np.inf if value == RIGID else np.nan if value is None else value
