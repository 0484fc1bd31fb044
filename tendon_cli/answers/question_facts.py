"""Facts of a question in the record of its answer: axes, limits, and what a share counts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.engine.windows.points import Points
from tendon_cli.engine.windows.question import Goal, Question
from tendon_cli.engine.windows.solutions import NEEDED
from tendon_cli.model.design import F0
from tendon_cli.quantities import unit_of_reading
from tendon_cli.studies.space.axis import SAMPLE_AXES, Axis, NamedAxis, limit_of
from tendon_cli.studies.space.space import Carried
from tendon_cli.studies.values import RIGID
from tendon_cli.verbs.answer_record import (
    AccuracyRecord,
    AxisRecord,
    CarriedRecord,
    GoalRecord,
    QuestionRecord,
    Value,
    Values,
)
from tendon_cli.verbs.typed_record import to_json

_MOST_TOLD_ROWS = 1000
"""Rows of the largest table all of whose rows are told in a record."""


def question_record(question: Question) -> QuestionRecord:
    """Return the record of a question."""
    study = question.study
    groups = question.groups
    return QuestionRecord(
        joint=str(study.joint.name),
        own_words=list(say.joint_name(study).own_words),
        read=study.setting.read,
        set_by_sample=question.sample.sets_by_sample,
        shows_own_f0=question.sample.shows_own_f0,
        unit=unit_of_reading(study.setting.read),
        pretension=question.placement.given,
        limits=dict(study.limits.items()),
        own_limits=list(question.choices.limits),
        choices=[_axis_record(axis, study.setting.read) for axis in question.choices.axes],
        conditions=[_axis_record(axis, study.setting.read) for axis in question.conditions.axes],
        counted=groups.noun,
        groups=len(groups),
        counts=dict(groups.counts),
        ranked_by=[goal_record(goal) for goal in question.ranking],
        accuracy=AccuracyRecord(
            length=study.setting.accuracy.length,
            tension=study.setting.accuracy.tension,
        ),
        needed=NEEDED,
        has_goals=bool(question.goals),
        place=question.placement.point,
        carried={
            column.column: _carried_record(question, column)
            for column in question.choices.carried
            if not column.first.words
        },
        intervals=[axis.key for axis in question.conditions.axes if axis.is_interval],
    )


def with_named_rows(question: QuestionRecord, said: Any) -> QuestionRecord:
    """Return the record of a question that tells of large tables only the rows that are named.

    Args:
        question: The record.
        said: What the answer says, with the names of rows in it.
    """
    if all(len(axis.sets or ()) <= _MOST_TOLD_ROWS for axis in question.choices):
        return question
    named = set(_texts_in(to_json(said)))
    choices = []
    for axis in question.choices:
        told = replace(axis)
        if axis.sets is not None:
            told.sets = {name: sets for name, sets in axis.sets.items() if name in named}
        if axis.carries is not None:
            told.carries = {name: words for name, words in axis.carries.items() if name in named}
        choices.append(told)
    return replace(question, choices=choices)


def _texts_in(value: Any) -> Iterator[str]:
    """Yield every text among the values of a record, but not its keys."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping):
        for inner in value.values():
            yield from _texts_in(inner)
    elif isinstance(value, list | tuple):
        for inner in value:
            yield from _texts_in(inner)


def goal_record(goal: Goal) -> GoalRecord:
    """Return the record of a goal."""
    return GoalRecord(column=goal.column, maximise=goal.maximise)


def _axis_record(axis: Axis, read: str) -> AxisRecord:
    """Return the record of an axis in a question in which a gauge is read."""
    both_ends = None
    step = None
    if axis.is_range:
        both_ends = [float(axis.values.min()), float(axis.values.max())]
        larger = np.maximum(np.abs(axis.values[:-1]), np.abs(axis.values[1:]))
        step = float(np.max(np.abs(np.diff(axis.values)) / larger, initial=0.0))
    record = AxisRecord(
        key=axis.key,
        column=axis.column,
        named=axis.is_text,
        range=both_ends,
        step=step,
        sets=None,
        limits={},
        drawn=axis.role == "draw" and axis.key not in SAMPLE_AXES,
    )
    if limit_of(axis.key) == "max_pretension" and read != F0:
        record.read = read
    if isinstance(axis, NamedAxis):
        record.sets = _told(axis)
        if axis.role != "choice":
            record.limits = _limits(axis)
        if axis.carried:
            record.carries = _carried(axis)
    return record


def _limits(axis: NamedAxis) -> dict[str, dict[str, float]]:
    """Return the limits that rows of a named axis set, SI, by the row's name."""
    of_rows: dict[str, dict[str, float]] = {}
    for key, values in axis.numbers.items():
        limit = limit_of(key)
        if limit is not None:
            for row in np.flatnonzero(~np.isnan(values)):
                of_rows.setdefault(axis.names[row], {})[limit] = float(values[row])
    return of_rows


def _told(axis: NamedAxis) -> dict[str, dict[str, float]]:
    """Return the numbers that tell each row of a named axis from the others, SI, by its name."""
    told = {name: axis.told_by(row) for row, name in enumerate(axis.names)}
    return {name: numbers for name, numbers in told.items() if numbers}


def _carried_record(question: Question, carried: Carried) -> CarriedRecord:
    """Return the record of a number that rows carry along; a sum says how many parts it counts."""
    axes = {axis.key: axis for axis in question.choices.axes if isinstance(axis, NamedAxis)}
    is_sum = carried.column == carried.first.name
    pieces = {key: axes[key].pieces for key in carried.tables if is_sum and axes[key].pieces > 1}
    return CarriedRecord(
        name=carried.first.name,
        unit=carried.first.unit,
        tables=list(carried.tables),
        pieces=pieces,
    )


def _carried(axis: NamedAxis) -> dict[str, list[str]]:
    """Return what each row of a named axis carries along in words, by its name."""
    carried = {name: list(axis.carried_by(row)) for row, name in enumerate(axis.names)}
    return {name: words for name, words in carried.items() if words}


def value_at(axis: Axis, place: int) -> Value:
    """Return the value of an axis at a place, as recorded."""
    return axis.names[place] if axis.names else recorded_number(float(axis.values[place]))


def recorded_number(value: float) -> Value:
    """Return a number of an axis as recorded: "rigid" for infinity."""
    return RIGID if value == np.inf else value


def choice_values(question: Question, points: Points, row: int) -> Values:
    """Return the values of a choice by the columns of its axes.

    Args:
        question: The question.
        points: Choices.
        row: Place of the choice among them.
    """
    values: Values = {}
    for axis in question.choices.axes:
        place_or_number = points.columns[axis.column][row]
        if axis.names:
            values[axis.column] = axis.names[place_or_number]
        else:
            values[axis.column] = recorded_number(float(place_or_number))
    return values


def condition_values(question: Question, condition: int) -> Values:
    """Return the values of a condition by the columns of `conditions.parquet`.

    Args:
        question: The question.
        condition: Row of the condition.
    """
    places = question.conditions.places(np.array([condition]))
    return {
        axis.column: value_at(axis, int(places[axis.key][0])) for axis in question.conditions.axes
    }
