"""A choice of an answer by its row, as the record has those that it names."""

from __future__ import annotations

import math

import numpy as np

from tendon_cli.answers.answer import Answer
from tendon_cli.answers.choose import choice_records
from tendon_cli.answers.record import named_rows
from tendon_cli.engine.windows.question import affords_motion, question_of
from tendon_cli.engine.windows.solutions import solve
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.errors import UsageError
from tendon_cli.studies.space.axis import Axis
from tendon_cli.studies.values import RIGID
from tendon_cli.verbs.answer_record import AxisRecord, ChoiceRecord, value_of


def choice_in_row(answer: Answer, row: int) -> ChoiceRecord:
    """Return the choice in a row of `choices.parquet`; one that is not named is solved again.

    Raises:
        UsageError: The answer has no such row.
    """
    question = question_of(answer.study)
    if not 0 <= row < len(question.choices):
        raise _no_choice(answer, f"{row}, expected 0 to {len(question.choices) - 1}")
    for named in named_rows(answer.answer):
        if named.choice == row:
            return named
    solver = Solver(question, with_motion=affords_motion(question, 1))
    solved = solve(solver, question.points(np.array([row])))
    return choice_records(question, solved)[0]


def same_choice(answer: Answer, choice: ChoiceRecord, axes: list[AxisRecord]) -> ChoiceRecord:
    """Return the choice of an answer with the values of another answer's choice.

    Args:
        answer: The answer.
        choice: The choice of the other one.
        axes: Axes of the choices of the other one.

    Raises:
        UsageError: The answer has no such choice.
    """
    values = {axis.column: value_of(choice, axis.column) for axis in axes}
    space = question_of(answer.study).choices
    places = []
    for axis in space.axes:
        of_axis = np.array([0])
        if axis.column in values:
            of_axis = _places(axis, values[axis.column])
        places.append(of_axis)
    if any(not len(of_axis) for of_axis in places):
        ours = {axis.column for axis in space.axes}
        named = [f"{column} {value}" for column, value in values.items() if column in ours]
        raise _no_choice(answer, f"with {', '.join(named)}")
    first = tuple(int(of_axis[0]) for of_axis in places)
    row = int(np.ravel_multi_index(first, space.shape)) if first else 0
    return choice_in_row(answer, row)


def _places(axis: Axis, value: float | str) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Return the places of a value on an axis, apart from rounding; none if it has no such."""
    if axis.names:
        is_same = np.array([name == value for name in axis.names])
    else:
        wanted = math.inf if value == RIGID else float(value)
        is_same = np.isclose(axis.values, wanted, rtol=1e-12, atol=0.0)
    return np.flatnonzero(is_same).astype(np.int64)


def _no_choice(answer: Answer, which: str) -> UsageError:
    return UsageError(
        f"{answer.record['name']} has no choice {which}",
        where="--choice",
        hint="`tendon show` lists the choices of an answer",
    )
