"""The order of choices: which one an answer names first, by which rule, and what ties with it.

A choice comes before another if it can be built, serves more up to the share that is enough, keeps
the rest of the advice, can be set, and needs less tension, in this order. Stated goals replace the
last two rules. Values that are equal to `EQUAL` are a tie, which the smaller motor torque breaks,
then the smaller values of the axes by key. So neither the order of a list in a study nor the way in
which work is cut decides anything.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tendon_cli.model.kinematics import Array, Flags, Rows
from tendon_cli.windows.by_choice import Selection
from tendon_cli.windows.points import Points
from tendon_cli.windows.question import Goal, Question
from tendon_cli.windows.solutions import Solutions

EQUAL = 1e-9
"""Relative difference up to which two values are a tie."""
CANNOT_BE_BUILT = 1
"""Code of advice: the flexor's spring has no room between its anchors."""
BUILT = "built"
SERVED_ENOUGH = "served_enough"
ADVISED = "advised"
_FIRST_RULES = (BUILT, SERVED_ENOUGH, ADVISED)
"""Rules that come before all goals."""
SETTABLE = Goal("settable", maximise=True)
"""The largest tolerance of setting as far as it is needed."""
LEAST_TENSION = Goal("max_tension", maximise=False)
LEAST_TORQUE = Goal("peak_motor_torque", maximise=False)
USUAL_ORDER = (SETTABLE, LEAST_TENSION)
"""Rules that stated goals replace."""
MOST_TIED = 8
"""Most choices of a part that are kept because they tie."""

Stages = list[Counter[tuple[float, ...]]]
"""For each rule: numbers of choices that it may leave, by their scores by this rule and those
before it."""


@dataclass(frozen=True, eq=False)
class Order:
    """Order of the choices of a question by goals, after the rules that come before all goals."""

    question: Question
    goals: tuple[Goal, ...]
    """Goals in the order in which they decide; the motor torque breaks their ties."""

    @classmethod
    def of(cls, question: Question) -> Order:
        """Return the order by which the choice named first is chosen, unless there is a front."""
        return cls(question, question.goals or USUAL_ORDER)

    @cached_property
    def rules(self) -> tuple[str, ...]:
        """Rules in the order in which they decide, by name; a goal has that of its column."""
        return (*_FIRST_RULES, *(goal.column for goal in self.goals), LEAST_TORQUE.column)

    @property
    def is_front(self) -> bool:
        """True if the goals are those of the study, none of which decides before another."""
        return len(self.goals) > 1 and self.goals == self.question.goals

    # --- Scores -----------------------------------------------------------------------------------

    def first_scores(self, solutions: Solutions) -> Array:
        """Return the scores by the rules before all goals, (choices, 3), the larger the better."""
        heeded = solutions.advice if self.question.study.design.advice else 0
        can_be_built = np.bitwise_and(heeded, CANNOT_BE_BUILT) == 0
        keeps_rest = np.bitwise_and(heeded, ~CANNOT_BE_BUILT) == 0
        columns = np.broadcast_arrays(
            can_be_built.astype(np.float64),
            np.minimum(solutions.served_at, self.question.serve),
            keeps_rest.astype(np.float64),
        )
        return np.column_stack(columns)

    def scores(self, solutions: Solutions) -> Array:
        """Return the scores by each rule, (choices, rules), the larger the better."""
        by_goals = solutions.scores((*self.goals, LEAST_TORQUE))
        return np.column_stack([self.first_scores(solutions), by_goals])

    def with_first(self, solutions: Solutions) -> Solutions:
        """Select the choices that are best by the rules before all goals."""
        return solutions.select(last_stage(self.first_scores(solutions)))

    # --- Choosing ---------------------------------------------------------------------------------

    def best(self, solutions: Solutions) -> int:
        """Return the place of the choice that comes first; there is at least one."""
        tied = last_stage(self.scores(solutions))
        return int(tied[np.argmin(self.rank(solutions.points, tied))])

    def precedes(self, solutions: Solutions, other: Solutions) -> bool:
        """Return True if a choice comes before another by a rule; ties are broken by none."""
        both = np.vstack([self.scores(solutions), self.scores(other)])
        return last_stage(both[:, :-1]).tolist() == [0]

    def rank(self, points: Points, rows: Selection) -> Rows:
        """Return the ranks of choices by the values of their axes, the axes in order of their keys.

        The smaller value comes first, and the name that comes first in the alphabet.
        """
        columns = []
        for axis in sorted(self.question.choices.axes, key=lambda axis: axis.key):
            values = points.columns[axis.column][rows]
            if axis.names:
                in_alphabet = np.argsort(np.argsort(np.array(axis.names), kind="stable"))
                values = in_alphabet[values]
            columns.append(values)
        count = len(points.row[rows])
        ranks = np.zeros(count, dtype=np.int64)
        if columns:
            ranks[np.lexsort(columns[::-1])] = np.arange(count)
        return ranks

    def may_be_first(self, solutions: Solutions) -> Rows:
        """Return the places of choices of a part that may come first of all, or tie with that one.

        Others of the same part come before each choice that is left out, whatever other parts hold.
        Of those that tie, the first few by their axes are kept.
        """
        scores = self.scores(solutions)
        places = np.flatnonzero(self._may_be_left(scores)[-1])
        tie = np.zeros(len(places), dtype=np.int64)
        for of_rule in scores[places].T[:-1]:
            tie = _groups_of_equals(tie, of_rule)
        of_torque = _within_groups(tie, scores[places][:, -1])
        rank = self.rank(solutions.points, places)
        kept = []
        for group in range(tie.max() + 1):
            tied = np.flatnonzero(tie == group)
            in_order = tied[np.argsort(rank[tied])]
            first = in_order[of_torque[in_order]][:1]
            kept.append(np.union1d(first, in_order[:MOST_TIED]))
        return places[np.unique(np.concatenate(kept))]

    def _may_be_left(self, scores: Array) -> list[Flags]:
        """Return True where a choice may be left by each rule but the last, (choices,) each.

        A choice is not left by a rule if another, equal by all rules before, is better by it.
        """
        is_left = np.ones(len(scores), dtype=np.bool_)
        group = np.zeros(len(scores), dtype=np.int64)
        stages = []
        for of_rule in scores.T[:-1]:
            places = np.flatnonzero(is_left)
            is_left = np.zeros(len(scores), dtype=np.bool_)
            is_left[places] = _within_groups(group[places], of_rule[places])
            places = np.flatnonzero(is_left)
            group[places] = _groups_of_equals(group[places], of_rule[places])
            stages.append(is_left)
        return stages

    # --- Counting ---------------------------------------------------------------------------------

    def stages(self, solutions: Solutions) -> Stages:
        """Return how many choices of a part each rule but the last may leave, by their scores."""
        scores = self.scores(solutions)
        counted = []
        for place, is_left in enumerate(self._may_be_left(scores)):
            rows = map(tuple, scores[is_left, : place + 1].tolist())
            counted.append(Counter(rows))
        return counted

    def count_left(self, stages: Iterable[Stages]) -> list[int]:
        """Return how many of all choices each rule but the last leaves.

        Args:
            stages: The stages of every part that has a choice with a window.
        """
        merged: Stages = [Counter() for _ in self.rules[:-1]]
        for of_part in stages:
            for counts, more in zip(merged, of_part, strict=True):
                counts.update(more)
        left: set[tuple[float, ...]] = {()}
        numbers = []
        for counts in merged:
            tried = [scores for scores in counts if scores[:-1] in left]
            top = max((scores[-1] for scores in tried), default=-np.inf)
            left = {scores for scores in tried if scores[-1] >= _least_equal(top)}
            numbers.append(sum(counts[scores] for scores in left))
        return numbers


def last_stage(scores: Array) -> Rows:
    """Return the rows of scores, (choices, rules), that tie by all rules, ascending."""
    rows = np.arange(len(scores))
    for of_rule in scores.T:
        rows = rows[of_rule[rows] >= _least_equal(of_rule[rows].max())]
    return rows


def _least_equal(top: float) -> float:
    """Return the smallest value that ties with the largest one."""
    return float(top - EQUAL * abs(top)) if np.isfinite(top) else float(top)


def _groups_of_equals(group: Rows, values: Array) -> Rows:
    """Divide groups into groups of equal values, and number them.

    Args:
        group: Number of the group of each value, (values,).
        values: The values.
    """
    order = np.lexsort((values, group))
    in_order = np.column_stack([group, values])[order]
    begins = (in_order[1:] != in_order[:-1]).any(axis=1)
    numbers = np.zeros(len(values), dtype=np.int64)
    numbers[order[1:]] = np.cumsum(begins)
    return numbers


def _within_groups(group: Rows, values: Array) -> Flags:
    """Return True where a value ties with the largest of its group.

    Args:
        group: Number of the group of each value, (values,).
        values: The values; minus infinity for those that are worst.
    """
    top = np.full(int(group.max(initial=-1)) + 1, -np.inf)
    np.maximum.at(top, group, values)
    with np.errstate(invalid="ignore"):
        least = np.where(np.isfinite(top), top - EQUAL * np.abs(top), top)
    return np.asarray(values >= least[group])
