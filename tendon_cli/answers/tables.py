"""The tables of an answer: a row per choice, and a row per condition."""

from __future__ import annotations

from typing import Any

import numpy as np

from tendon_cli.answers.candidates import Candidates, Columns, numbers_of
from tendon_cli.answers.problem import Flags, Problem
from tendon_cli.answers.setting import COLUMNS as SETTING
from tendon_cli.answers.setting import setting_columns
from tendon_cli.answers.solve import WORST
from tendon_cli.model.limits import LIMIT_NAMES
from tendon_cli.quantities import QUANTITIES
from tendon_cli.space.axis import Axis
from tendon_cli.studies.study import keys
from tendon_cli.studies.values import RIGID
from tendon_cli.tables.schema import Column

_LIMITS = ("", *LIMIT_NAMES)
"""By a limit's code and one: NOTHING is -1."""


def choice_columns(problem: Problem) -> tuple[Column, ...]:
    """Columns of `choices.parquet`."""
    directions = ("", *problem.study.motion.direction)
    number = {name: Column.of(QUANTITIES[name]) for name in ("tolerance", "served", "served_at", "pretension", *WORST)}
    return (
        *map(_of_axis, problem.choices.axes),
        Column("refined", "truth", "1", "a point between those of the grid"),
        Column.of(QUANTITIES["pretension_from"]),
        Column.of(QUANTITIES["pretension_to"]),
        Column("windows", "count", "1", "intervals of pretension that serve enough; the widest is the window"),
        number["tolerance"],
        Column("from_by", "text", "1", "limit that binds below, or what no pretension could keep", choices=_LIMITS),
        Column("to_by", "text", "1", "limit that binds above, or what no pretension could keep", choices=_LIMITS),
        *(Column(f"{end}_condition", "count", "1", "row of conditions that binds") for end in ("from", "to")),
        *(Column(f"{end}_direction", "text", "1", _OF_STATE, choices=directions) for end in ("from", "to")),
        *(Column.of(QUANTITIES["elbow_angle"], f"{end}_elbow_angle") for end in ("from", "to")),
        number["served"],
        number["served_at"],
        number["pretension"],
        *(number[name] for name in WORST),
        *(Column.of(QUANTITIES[name]) for name in SETTING),
        Column("feasible", "truth", "1", "it has a window; if the pretension is given, that serves enough"),
        Column("on_front", "truth", "1", "no other choice is as good in every goal and better in one"),
    )


_OF_STATE = "direction of the state that binds; empty where the limit belongs to none"


def choice_rows(problem: Problem, candidates: Candidates, refined: Flags, on_front: Flags) -> Columns:
    """Rows of `choices.parquet`; text as positions among the column's words."""
    found = candidates.solutions
    rows: Columns = {**candidates.columns, "refined": refined}
    rows |= {"pretension_from": found.pretension_from, "windows": found.windows, "tolerance": found.tolerance}
    rows["pretension_to"] = np.where(np.isinf(found.pretension_to), np.nan, found.pretension_to)
    for end in ("from", "to"):
        state = getattr(found, f"{end}_state")
        direction, angle = np.divmod(state, problem.angles.size)
        rows[f"{end}_by"] = getattr(found, f"{end}_by").astype(np.int64) + 1
        rows[f"{end}_condition"] = getattr(found, f"{end}_condition")
        rows[f"{end}_direction"] = np.where(state < 0, 0, direction + 1)
        beside = getattr(found, f"{end}_angle")
        of_state = np.where(state < 0, np.nan, problem.angles[0, angle])
        rows[f"{end}_elbow_angle"] = np.where(np.isnan(beside), of_state, beside)
    rows |= {name: getattr(found, name) for name in ("served", "served_at", "pretension", *WORST)}
    rows |= setting_columns(
        problem, numbers_of(problem, candidates.columns), found.pretension_from, found.pretension_to, found.pretension
    )
    return rows | {"feasible": found.feasible, "on_front": on_front}


def condition_columns(problem: Problem) -> tuple[Column, ...]:
    """Columns of `conditions.parquet`."""
    weighting = Column("weighting", "number", "1", "how much the condition counts in a share")
    return (*map(_of_axis, problem.conditions.axes), weighting)


def condition_rows(problem: Problem) -> Columns:
    """Rows of `conditions.parquet`."""
    count = len(problem.conditions)
    given = problem.conditions.weighting
    weighting = np.ones(count) if given is None else given
    return problem.conditions.columns(np.arange(count)) | {"weighting": weighting}


def as_records(columns: tuple[Column, ...], rows: Columns) -> list[dict[str, Any]]:
    """Rows as a JSON text has them: words for positions, null for what is not a number."""
    listed = {column.name: _as_list(column, np.asarray(rows[column.name])) for column in columns}
    return [dict(zip(listed, values, strict=True)) for values in zip(*listed.values(), strict=True)]


def _as_list(column: Column, values: np.ndarray[Any, Any]) -> list[Any]:
    if column.kind == "text":
        return [column.choices[at] or None for at in values]
    if column.kind == "number":
        endless = RIGID if column.is_axis else None
        return [value if np.isfinite(value) else endless if value == np.inf else None for value in values.tolist()]
    return list(values.tolist())


def _of_axis(axis: Axis) -> Column:
    if axis.names:
        return Column(axis.column, "text", "1", f"name of the {axis.key}", is_axis=True, choices=axis.names)
    return Column.of(keys()[axis.key].number.quantity, axis.column, is_axis=True)


def as_value(column: Column, value: Any) -> Any:
    """A value of a record as its column holds it."""
    if column.kind == "text":
        return column.choices.index(value or "")
    return np.inf if value == RIGID else np.nan if value is None else value
