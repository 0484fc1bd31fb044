"""The least change of one number of a study that gives one of its choices a window.

A `Change` says which number moves, and how far; a `ChangeSearch` seeks along it the value at which
the first window opens.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tendon_cli import say
from tendon_cli.answers.text_parts import quantity_of_demand
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.quantities import Quantity
from tendon_cli.space.axis import limit_of
from tendon_cli.units import parse_measure
from tendon_cli.windows.points import Points
from tendon_cli.windows.question import Question
from tendon_cli.windows.solutions import Solutions, solve
from tendon_cli.windows.solver import Solver
from tendon_cli.windows.verification import Verified

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
    first: float | None = None
    """Share of the way of the first value beyond that of the study, from which on the shares grow
    by equal factors; None if the values are evenly spaced."""
    tolerance: float = 0.0
    """Relative width at which a value is narrow enough."""

    @property
    def at_once(self) -> int:
        """Number of values that are tried together."""
        return self.sections - 2


SCAN = Effort(values=65, zooms=4, sections=16, rounds=14)
"""Effort for a change that may open a window and then close it again."""
SPARING_SCAN = Effort(values=13, zooms=1, sections=8, rounds=7, tolerance=1e-3)
"""Effort for the same where each window is sought pretension by pretension."""
BISECTION = Effort(values=1, zooms=0, sections=3, rounds=12)
"""Effort for a change that opens the more windows, the larger it is."""
SPARING_BISECTION = Effort(values=1, zooms=0, sections=3, rounds=7)
"""Effort for the same where each window is sought pretension by pretension."""


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

    def is_reached(self, value: float) -> bool:
        """Return True if a value is the farthest, or lies beyond it."""
        return abs(value - self.before) >= abs(self.farthest - self.before)

    def on_the_way(self) -> Array:
        """Return the values to try first, from the value of the study to the farthest, SI."""
        effort = self.effort
        if effort.values == 1:
            return np.array([self.farthest])
        if effort.first is None:
            return self.spacing(self.before, self.farthest, effort.values)
        shares = np.geomspace(effort.first, 1.0, effort.values - 1)
        return np.array([self.beyond(self.before, share) for share in [0.0, *shares]])

    @property
    def spacing(self) -> Callable[[float, float, int], Array]:
        """Function that spaces a number of values between two."""
        return np.geomspace if self.is_geometric else np.linspace

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
            with_worst: True to work out the worst values of feasible choices, too.
        """
        if self._is_of_choices(solver.question):
            rows = np.tile(np.arange(len(points)), len(values))
            of_rows = np.repeat(values, len(points))
            changed = points.select(rows).with_numbers({self.key: of_rows})
            return solve(solver, changed, with_worst=with_worst, of_feasible=True)
        parts = [
            solve(solver.for_question(question), points, with_worst=with_worst, of_feasible=True)
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


def printed_pretension(question: Question, solved: Solutions, digits: int) -> str:
    """Return the pretension of the first of some choices, N, so that it serves as printed, too.

    Args:
        question: The question.
        solved: The choices.
        digits: Number of significant digits, or more if needed.

    Returns:
        The pretension; empty if the choice has no window.
    """
    if not solved.feasible[0]:
        return ""
    exact = float(solved.pretension[0])
    low = float(solved.pretension_from[0])
    high = float(solved.pretension_to[0])
    if question.placement.given is not None:
        low = exact
        high = exact
    return say.number_within(exact, low, high, digits)


def overlap(question: Question, solved: Solutions, other: Solutions) -> Solutions | None:
    """Return a choice with the part of its window that lies in the window of another sample.

    Args:
        question: The question.
        solved: The choice.
        other: The same choice, solved for the other sample.

    Returns:
        The choice at a pretension in this part; None if there is none.
    """
    if not _overlaps(question, solved, other)[0]:
        return None
    if question.placement.given is not None:
        return solved
    low = np.maximum(solved.pretension_from, other.pretension_from)
    high = np.minimum(solved.pretension_to, other.pretension_to)
    pretension = np.clip(solved.pretension, low, high)
    return replace(solved, pretension_from=low, pretension_to=high, pretension=pretension)


def _overlaps(question: Question, solved: Solutions, other: Solutions) -> Flags:
    """Return True where one pretension suits the same choices for two samples, (choices,)."""
    is_feasible = solved.feasible & other.feasible
    if question.placement.given is not None:
        return is_feasible
    low = np.maximum(solved.pretension_from, other.pretension_from)
    high = np.minimum(solved.pretension_to, other.pretension_to)
    return is_feasible & (low <= high)


class Opening(NamedTuple):
    """The least change that gives a choice a window."""

    value: float
    """Value of the number, SI."""
    points: Points
    """Choices with a window at it."""


class PrintedChange(NamedTuple):
    """A change as a study can have it, with which a choice has a window."""

    text: str
    """The value with its unit."""
    value: float
    """Value of the text, SI."""
    least: float
    """The least value before it was rounded, SI."""
    solved: Solutions
    """Choices with a window at the value, with their worst values; those tried if none has one."""
    judged: Verified | None = None
    """Judgement of a fresh sample on the first of them; None without one."""
    judged_at: str = ""
    """Pretension at which it judged, as printed, N."""

    @property
    def at(self) -> Array:
        """Value of the text in an array of its own, (1,), SI."""
        return np.array([self.value])

    @property
    def can_be_built(self) -> bool:
        """True if the first of the choices can be built."""
        return bool(self.solved.can_be_built[0])


@dataclass(frozen=True, eq=False)
class ChangeSearch:
    """Search for the least change that gives a choice a window."""

    solver: Solver
    """Solver of the question."""
    change: Change
    sieve: Solver | None = None
    """Solver of a question with fewer conditions and weaker demands: where it finds no window,
    there is none. None to solve the question alone."""
    must_be_buildable: bool = False
    """True if a choice that cannot be built does not count."""
    beside: Solver | None = None
    """Solver of the question for another sample, whose window has to overlap; None without one."""

    def least(self) -> Opening | None:
        """Return the value nearest to that of the study at which a choice has a window.

        A window that opens and closes again between two neighbours of all values tried may be
        missed.

        Returns:
            The value and the choices with a window; None if no value tried opens one.
        """
        change = self.change
        effort = change.effort
        values = change.on_the_way()
        trial = self._try_in_order(values)
        # A narrow window may hide on either side of the value that is nearest to opening one.
        for _ in range(effort.zooms):
            if trial.place is not None or trial.nearest is None:
                break
            below = values[max(trial.nearest - 1, 0)]
            above = values[min(trial.nearest + 1, len(values) - 1)]
            values = change.spacing(below, above, effort.sections)
            trial = self._try_values(values, change.points)
        if trial.place is None:
            return None
        opening = Opening(float(values[trial.place]), trial.points)
        if trial.place > 0:
            return self._narrow_down(float(values[trial.place - 1]), opening)
        return opening if effort.values > 1 else self._narrow_down(change.before, opening)

    def printed(self, opening: Opening) -> PrintedChange:
        """Return the value of an opening with as few digits as give a window when typed in.

        It is rounded in the direction of the change.
        """
        change = self.change
        for digits in _DIGITS:
            text = say.quantity(change.quantity, opening.value, digits, toward=change.toward)
            value = parse_measure(text.replace(",", ""), change.quantity.dimension).si
            solved = change.solve(self.solver, np.array([value]), opening.points, with_worst=True)
            opens = self._opens(solved, np.array([value]), opening.points)
            if opens.any():
                solved = solved.select(opens)
                break
        return PrintedChange(text, value, opening.value, solved)

    def _opens(self, solved: Solutions, values: Array, points: Points) -> Flags:
        """Return True for choices that have a window, and keep the other demands of the search.

        Args:
            solved: The solved choices, all with one value after the other.
            values: These values, SI.
            points: The choices.
        """
        opens = solved.feasible
        if self.must_be_buildable:
            opens = opens & solved.can_be_built
        if self.beside is not None and opens.any():
            other = self.change.solve(self.beside, values, points)
            opens = opens & _overlaps(self.solver.question, solved, other)
        return opens

    def _try_in_order(self, values: Array) -> _Trial:
        """Try values, some at once, until one opens a window."""
        nearest: _Trial | None = None
        for start in range(0, len(values), self.change.effort.at_once):
            part = values[start : start + self.change.effort.at_once]
            trial = self._try_values(part, self.change.points).shifted(start)
            if trial.place is not None:
                return trial
            if nearest is None or trial.width >= nearest.width:
                nearest = trial
        return nearest or _Trial(self.change.points)

    def _try_values(self, values: Array, points: Points, *, sift: bool = True) -> _Trial:
        """Try values of the number that changes for some choices.

        Args:
            values: The values, SI.
            points: The choices.
            sift: False to leave out the sieve.
        """
        tried = np.arange(len(values))
        if self.sieve is not None and sift:
            passed = self.change.solve(self.sieve, values, points).feasible
            tried = np.flatnonzero(passed.reshape(len(values), -1).any(axis=1))
            if not len(tried):
                return _Trial(points)
        solved = self.change.solve(
            self.solver, values[tried], points, with_worst=self.must_be_buildable
        )
        shape = (len(tried), len(points))
        opens = self._opens(solved, values[tried], points).reshape(shape)
        width = _width(self.solver.question, solved).reshape(shape).max(axis=1)
        widest = int(np.argsort(width, kind="stable")[-1])
        nearest = int(tried[widest])
        if not opens.any():
            return _Trial(points, None, nearest, float(width[widest]))
        first = int(np.argmax(opens.any(axis=1)))
        return _Trial(points.select(opens[first]), int(tried[first]), nearest)

    def _narrow_down(self, empty: float, opening: Opening) -> Opening:
        """Narrow down the value at which a window opens.

        Args:
            empty: A value without a window.
            opening: A value with one.
        """
        change = self.change
        for _ in range(change.effort.rounds):
            if abs(opening.value - empty) < change.effort.tolerance * abs(opening.value):
                break
            values = change.spacing(empty, opening.value, change.effort.sections)
            values[-1] = opening.value
            trial = self._try_values(values[1:-1], opening.points, sift=False)
            place = len(values) - 1 if trial.place is None else trial.place + 1
            if (empty, opening.value) == (values[place - 1], values[place]):
                break
            empty = float(values[place - 1])
            opening = Opening(float(values[place]), trial.points)
        return opening


class _Trial(NamedTuple):
    """Result of several values of a number."""

    points: Points
    """Choices with a window at the first value that opens one; all if none does."""
    place: int | None = None
    """Place of this value; None if no value opens a window."""
    nearest: int | None = None
    """Place of the value that is nearest to opening one; None if none passes the sieve."""
    width: float = -np.inf
    """Width of the window there, N, or the share served in excess, if none is open."""

    def shifted(self, start: int) -> _Trial:
        """Return the same result with places among values of which these are a part."""
        place = None if self.place is None else self.place + start
        nearest = None if self.nearest is None else self.nearest + start
        return self._replace(place=place, nearest=nearest)


def _width(question: Question, solutions: Solutions) -> Array:
    """Return the width of windows, N; if a share is enough, the share served in excess of it."""
    if question.serve < 1.0:
        return solutions.served - question.serve
    with np.errstate(invalid="ignore"):
        width = solutions.pretension_to - solutions.pretension_from
    return np.where(np.isnan(width), -np.inf, width)
