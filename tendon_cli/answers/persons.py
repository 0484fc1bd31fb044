"""The table of persons, or of draws, under the choice that an answer names first: a row each."""

from __future__ import annotations

from typing import Any

import numpy as np

from tendon_cli.answers.candidates import Columns, numbers_of
from tendon_cli.answers.coverage import share_served
from tendon_cli.answers.population import GroupWindows
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.setting import settings_of
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMIT_NAMES
from tendon_cli.quantities import QUANTITIES
from tendon_cli.space.axis import DRAW_AXIS, PERSON_AXIS, PRETENSION, Axis, Rows
from tendon_cli.tables.schema import Column

_LIMITS = ("", *LIMIT_NAMES)
_SET = ("set_flexor_tension", "set_extensor_tension", "set_flexor_tension_motor", "set_extensor_tension_motor")


def one_by_one(problem: Problem) -> Axis | None:
    """The axis of persons, or if there are none of draws; None if there are neither."""
    axes = {axis.key: axis for axis in problem.conditions.axes}
    return axes.get(PERSON_AXIS) or axes.get(DRAW_AXIS)


def person_columns(problem: Problem, axis: Axis) -> tuple[Column, ...]:
    """Columns of `persons.parquet`, or of `draws.parquet`."""
    people = problem.study.people.population if axis.key == PERSON_AXIS and problem.study.people is not None else None
    bodies = () if people is None else tuple(Column.of(QUANTITIES[name]) for name in DIMENSIONS)
    sexes = () if people is None or not people.sexes else (_SEX,)
    ends = ((end, word) for end, word in (("from", "below"), ("to", "above")))
    return (
        Column(axis.column, "text", "1", f"name of the {axis.key}", is_axis=True, choices=axis.names),
        *sexes,
        Column("weighting", "number", "1", "how much it counts in a share"),
        *bodies,
        Column.of(QUANTITIES["pretension_from"]),
        Column.of(QUANTITIES["pretension_to"]),
        *(Column(f"{end}_by", "text", "1", f"limit that binds {word}", choices=_LIMITS) for end, word in ends),
        *(Column(f"{end}_condition", "count", "1", "row of conditions that binds") for end in ("from", "to")),
        Column("served", "number", "1", "whether the pretension of the choice serves it; of several draws the share"),
        *(Column.of(QUANTITIES[name]) for name in _SET),
    )


_SEX = Column("sex", "text", "1", "sex", choices=("male", "female"))


def person_rows(problem: Problem, axis: Axis, windows: GroupWindows, columns: Columns, pretension: float) -> Columns:
    """A row per person under one choice at its pretension (N): its window is of at least `serve` of its draws."""
    count = len(axis)
    served = windows.served(pretension).reshape(count, -1)
    low, high, first, last = _windows(problem, windows, served.shape)
    rows: Columns = {
        axis.column: np.arange(count),
        "weighting": np.ones(count) if axis.weighting is None else axis.weighting,
        "pretension_from": low,
        "pretension_to": np.where(np.isinf(high), np.nan, high),
        "from_by": windows.low_by[first].astype(np.int64) + 1,
        "to_by": windows.high_by[last].astype(np.int64) + 1,
        "from_condition": windows.low_condition[first],
        "to_condition": windows.high_condition[last],
        "served": served.mean(axis=1),
    }
    if axis.key == PERSON_AXIS and problem.study.people is not None:
        people = problem.study.people.population
        rows |= {name: people.values[:, at] for at, name in enumerate(DIMENSIONS)}
        rows |= {"sex": np.array([_SEX.choices.index(sex) for sex in people.sexes])} if people.sexes else {}
    return rows | dict(zip(_SET, _set(problem, axis, columns, pretension), strict=True))


def _windows(problem: Problem, windows: GroupWindows, shape: tuple[int, ...]) -> tuple[Array, Array, Rows, Rows]:
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


def _set(problem: Problem, axis: Axis, columns: Columns, pretension: float) -> tuple[Array, ...]:
    """What to set on each person."""
    others = (each for each in problem.conditions.axes if each.key not in (PERSON_AXIS, DRAW_AXIS))
    under = {key: np.repeat(values[:1], len(axis)) for other in others for key, values in other.numbers.items()}
    under |= dict(axis.numbers)
    numbers = {**numbers_of(problem, columns), PRETENSION: np.array([pretension])}
    values = settings_of(problem.points(numbers, under).design(), len(axis))
    return values.flexor, values.extensor, values.flexor_motor, values.extensor_motor


def members(rows: Any, reason: Any, pretension: float) -> Rows:
    """Who of a table is not served for a reason of the record, as places in it; `rows` has arrays by column."""
    low, high, limits = rows["pretension_from"], rows["pretension_to"], [*map(_LIMITS.index, reason["limits"])]
    with np.errstate(invalid="ignore"):
        has_window = ~np.isnan(low) & ~(low > high)
        out = rows["served"] < 1.0
        chosen = {
            "more": has_window & (low > pretension) & (rows["from_by"] == limits[0]),
            "less": has_window & (high < pretension) & (rows["to_by"] == limits[0]),
            "another suit": ~has_window & (rows["from_by"] == limits[0]) & np.isin(rows["to_by"], [*limits, 0]),
        }[reason["needs"]]
    return np.flatnonzero(out & chosen)
