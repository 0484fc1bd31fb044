"""The least change of one number of a study that gives one of its choices a window.

A `Change` says which number moves, and how far; `least_change` searches along it for the value at
which the first window opens.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tendon_cli import say
from tendon_cli.answers.text_remedies import quantity_of_demand
from tendon_cli.model.kinematics import Array
from tendon_cli.quantities import Quantity
from tendon_cli.space.axis import limit_of
from tendon_cli.units import parse_measure
from tendon_cli.windows.points import Points
from tendon_cli.windows.question import Question
from tendon_cli.windows.solutions import Solutions, solve
from tendon_cli.windows.solver import Solver
from tendon_cli.windows.verification import Verified, Verifier

_BEYOND = (0.0, 0.01, 0.03, 0.1, 0.3, 1.0)
"""Shares of the way to the farthest value at which a fresh sample tries whether enough is served,
where the study's own sample has found a value too little."""
_DIGITS = range(3, 16)
"""Numbers of significant digits with which a value is printed."""


class Effort(NamedTuple):
    """Effort of a search: the values that it tries."""

    values: int
    """Values tried on the way to the farthest one; a single value is the farthest."""
    zooms: int
    """Most times that a narrow window is sought around the most promising value."""
    sections: int
    """Values between two neighbours in each zoom and each round, both included."""
    rounds: int
    """Rounds in which the value at which a window opens is narrowed down."""


SCAN = Effort(values=65, zooms=4, sections=16, rounds=14)
"""Effort for a change that may open a window and then close it again."""
BISECTION = Effort(values=1, zooms=0, sections=3, rounds=12)
"""Effort for a change that opens the more windows, the larger it is."""


@dataclass(frozen=True, eq=False)
class Change:
    """A change of one number of a study: a number of its choices or conditions, or a limit."""

    key: str
    """Dotted key of the number, such as that of a limit."""
    before: float
    """Value in the study, SI; of several values the largest magnitude, of limits the loosest."""
    farthest: float
    """Farthest plausible value, SI."""
    points: Points
    """Choices for which it counts."""
    effort: Effort
    is_geometric: bool = False
    """True if the values tried grow by equal factors, not by equal steps."""

    @property
    def quantity(self) -> Quantity:
        """Quantity of the value."""
        return quantity_of_demand(self.key)

    @property
    def toward(self) -> float:
        """Infinity or minus infinity: the direction of the change."""
        return np.inf if self.farthest > self.before else -np.inf

    def beyond(self, value: float, share: float) -> float:
        """Return the value at a share of the way from a value to the farthest, SI."""
        if self.is_geometric:
            return float(value * (self.farthest / value) ** share)
        return value + share * (self.farthest - value)

    def applied(self, question: Question, value: float, points: Points) -> tuple[Question, Points]:
        """Return a question and choices with a value of the number, SI."""
        if self._is_of_choices(question):
            return question, points.with_numbers({self.key: np.full(len(points), value)})
        return self._changed(question, value), points

    def solve(
        self, solver: Solver, values: Array, points: Points, *, with_worst: bool = False
    ) -> Solutions:
        """Solve choices with some values of the number, one value after the other.

        Args:
            solver: Solver of the question.
            values: The values, SI.
            points: The choices.
            with_worst: True to work out worst values, too.
        """
        if self._is_of_choices(solver.question):
            rows = np.tile(np.arange(len(points)), len(values))
            of_rows = np.repeat(values, len(points))
            changed = points.select(rows).with_numbers({self.key: of_rows})
            return solve(solver, changed, with_worst=with_worst)
        parts = [
            solve(solver.for_question(question), points, with_worst=with_worst)
            for question in (self._changed(solver.question, float(value)) for value in values)
        ]
        return parts[0] if len(parts) == 1 else Solutions.concatenate(parts)

    def _is_of_choices(self, question: Question) -> bool:
        """Return True if choices set the number, so that the question stays the same."""
        return self.key not in question.condition_numbers

    def _changed(self, question: Question, value: float) -> Question:
        """Return the question with another value of a number that its conditions set.

        Their values are scaled together. A limit becomes the same under all of them.
        """
        of_conditions = question.condition_numbers[self.key]
        if limit_of(self.key) is not None:
            changed = np.full(len(of_conditions), value)
        else:
            changed = of_conditions * (value / np.abs(of_conditions).max())
        return question.with_numbers({self.key: changed})


class Opening(NamedTuple):
    """The least change that gives a choice a window."""

    value: float
    """Value of the number, SI."""
    points: Points
    """Choices with a window at it."""


class PrintedValue(NamedTuple):
    """A value as a study can have it, at which a choice has a window."""

    text: str
    value: float
    """Value of the text, SI."""
    solved: Solutions
    """The choices at this value."""

    @property
    def pretension(self) -> str:
        """Pretension in the window of the first choice, N; empty if it has none."""
        if not self.solved.feasible[0]:
            return ""
        low = float(self.solved.pretension_from[0])
        high = float(self.solved.pretension_to[0])
        return say.number_within(float(self.solved.pretension[0]), low, high, digits=3)


def least_change(solver: Solver, change: Change) -> Opening | None:
    """Return the value nearest to that of the study at which a choice has a window.

    Args:
        solver: Solver of the question.
        change: The change; a window that opens and closes again between two neighbours of all
            values tried may be missed.

    Returns:
        The value and the choices with a window; None if no value tried opens one.
    """
    effort = change.effort
    space = np.geomspace if change.is_geometric else np.linspace
    values = np.array([change.farthest])
    if effort.values > 1:
        values = space(change.before, change.farthest, effort.values)
    trial = _try_values(solver, change, values, change.points)
    # A narrow window may hide on either side of the value that is nearest to opening one.
    for _ in range(effort.zooms):
        if trial.place is not None:
            break
        below = values[max(trial.nearest - 1, 0)]
        above = values[min(trial.nearest + 1, len(values) - 1)]
        values = space(below, above, effort.sections)
        trial = _try_values(solver, change, values, change.points)
    if trial.place is None:
        return None
    open_value = float(values[trial.place])
    if trial.place > 0:
        last_empty = float(values[trial.place - 1])
    elif effort.values > 1:
        return Opening(open_value, trial.points)
    else:
        last_empty = change.before
    return _narrow_down(solver, change, space, last_empty, Opening(open_value, trial.points))


def least_on_fresh_sample(verifier: Verifier, change: Change, opening: Opening) -> Opening | None:
    """Return the least value, from an opening on, that serves enough of a fresh sample.

    A value that is just enough for the sample by which it was found is as often too little for
    another.

    Args:
        verifier: Judge by the fresh sample.
        change: The change.
        opening: Opening by the study's own sample.

    Returns:
        The value and the choices with a window; None if no value up to the farthest serves enough.
    """
    for share in _BEYOND:
        value = change.beyond(opening.value, share)
        solved = change.solve(verifier.solver, np.array([value]), opening.points)
        if solved.feasible.any():
            return Opening(value, opening.points.select(solved.feasible))
    return None


def judge_change(
    verifier: Verifier, change: Change, printed: PrintedValue, points: Points
) -> Verified | None:
    """Return the judgement of a fresh sample on the first of some choices at a printed value."""
    question, changed = change.applied(verifier.solver.question, printed.value, points)
    pretension = float(printed.solved.pretension[0])
    return verifier.for_question(question).judge_at(changed.select([0]), pretension)


def printed_value(solver: Solver, change: Change, opening: Opening) -> PrintedValue:
    """Return the value of an opening with as few digits as give a window when they are typed in.

    It is rounded in the direction of the change.
    """
    for digits in _DIGITS:
        text = say.quantity(change.quantity, opening.value, digits, toward=change.toward)
        value = parse_measure(text.replace(",", ""), change.quantity.dimension).si
        solved = change.solve(solver, np.array([value]), opening.points)
        if solved.feasible.any():
            break
    return PrintedValue(text, value, solved)


# --- The search -----------------------------------------------------------------------------------


class _Trial(NamedTuple):
    """Result of several values of a number."""

    place: int | None
    """Place of the first value that opens a window; None if none does."""
    nearest: int
    """Place of the value that is nearest to opening one."""
    points: Points
    """Choices with a window at the first value; all if there is none."""


def _try_values(solver: Solver, change: Change, values: Array, points: Points) -> _Trial:
    """Try values of the number that changes for some choices."""
    solved = change.solve(solver, values, points)
    shape = (len(values), len(points))
    feasible = solved.feasible.reshape(shape)
    opens = feasible.any(axis=1)
    width = _width(solver.question, solved).reshape(shape).max(axis=1)
    nearest = int(np.argsort(width, kind="stable")[-1])
    if not opens.any():
        return _Trial(None, nearest, points)
    place = int(np.argmax(opens))
    return _Trial(place, nearest, points.select(feasible[place]))


def _width(question: Question, solutions: Solutions) -> Array:
    """Return the width of windows, N; if a share is enough, the share served in excess of it."""
    if question.serve < 1.0:
        return solutions.served - question.serve
    with np.errstate(invalid="ignore"):
        width = solutions.pretension_to - solutions.pretension_from
    return np.where(np.isnan(width), -np.inf, width)


def _narrow_down(
    solver: Solver,
    change: Change,
    space: Callable[[float, float, int], Array],
    empty: float,
    opening: Opening,
) -> Opening:
    """Narrow down the value at which a window opens.

    Args:
        solver: Solver of the question.
        change: The change.
        space: Function that spaces a number of values between two.
        empty: A value without a window.
        opening: A value with one.
    """
    for _ in range(change.effort.rounds):
        values = space(empty, opening.value, change.effort.sections)
        values[-1] = opening.value
        trial = _try_values(solver, change, values[1:-1], opening.points)
        place = len(values) - 1 if trial.place is None else trial.place + 1
        if (empty, opening.value) == (values[place - 1], values[place]):
            break
        empty = float(values[place - 1])
        opening = Opening(float(values[place]), trial.points)
    return opening
