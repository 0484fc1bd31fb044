"""The order of choices: which one an answer names first, by which rule, and what ties with it.

A choice comes before another if it can be built, serves more up to the share that is enough, can
be set at all, keeps the rest of the advice, can be set with room to spare, and needs less tension,
in this order. Stated goals replace the last two rules. Values that are equal to `EQUAL` are a tie,
which the smaller motor torque breaks, then the smaller values of the axes by key. So neither the
order of a list in a study nor the way in which work is cut decides anything.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from tendon_cli.engine.windows.advice import NO_ROOM
from tendon_cli.engine.windows.by_choice import Selection
from tendon_cli.engine.windows.points import Points
from tendon_cli.engine.windows.question import EQUAL, Goal, Question
from tendon_cli.engine.windows.solutions import Solutions
from tendon_cli.model.kinematics import Array, Rows

BUILT = "built"
SERVED_ENOUGH = "served_enough"
CAN_BE_SET = "can_be_set"
ADVISED = "advised"
FIRST_RULES = (BUILT, SERVED_ENOUGH, CAN_BE_SET, ADVISED)
"""Rules that come before all goals."""
SETTABLE = Goal("settable", maximise=True)
"""The largest tolerance of setting as far as it is needed."""
LEAST_TENSION = Goal("max_tension", maximise=False)
LEAST_TORQUE = Goal("peak_motor_torque", maximise=False)
USUAL_ORDER = (SETTABLE, LEAST_TENSION)
"""Rules that stated goals replace."""
MOST_TIED = 8
"""Most choices of a part that are kept because they tie."""


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
        return (*FIRST_RULES, *(goal.column for goal in self.goals), LEAST_TORQUE.column)

    @property
    def is_front(self) -> bool:
        """True if the goals are those of the study, none of which decides before another."""
        return len(self.goals) > 1 and self.goals == self.question.goals

    # --- Scores -----------------------------------------------------------------------------------

    def first_scores(self, solutions: Solutions) -> Array:
        """Return the scores by the rules before all goals, (choices, 4), the larger the better."""
        heeded = solutions.advice if self.question.study.design.advice else 0
        can_be_built = np.bitwise_and(heeded, NO_ROOM) == 0
        keeps_rest = np.bitwise_and(heeded, ~NO_ROOM) == 0
        columns = np.broadcast_arrays(
            can_be_built.astype(np.float64),
            np.minimum(solutions.served_at, self.question.sample.enough),
            solutions.can_be_set.astype(np.float64),
            keeps_rest.astype(np.float64),
        )
        return np.column_stack(columns)

    def scores(self, solutions: Solutions) -> Array:
        """Return the scores by each rule, (choices, rules), the larger the better."""
        by_goals = solutions.scores((*self.goals, LEAST_TORQUE))
        return np.column_stack([self.first_scores(solutions), by_goals])

    @property
    def tie_breakers(self) -> tuple[Goal, ...]:
        """Goals that decide in turn between choices that tie, before the values of their axes."""
        if self.question.sample.tie == EQUAL:
            return (LEAST_TORQUE,)
        return tuple(goal for goal in (LEAST_TENSION, LEAST_TORQUE) if goal not in self.goals)

    def left(self, solutions: Solutions) -> list[Rows]:
        """Return the places of the choices that each rule but the last leaves, ascending."""
        rows = np.arange(len(solutions))
        stages = []
        for place, of_rule in enumerate(self.scores(solutions).T[:-1]):
            tie = EQUAL if place < len(FIRST_RULES) else self.question.sample.tie
            rows = rows[of_rule[rows] >= _least_equal(of_rule[rows].max(), tie)]
            stages.append(rows)
        return stages

    def with_first(self, solutions: Solutions) -> Solutions:
        """Select the choices that are best by the rules before all goals."""
        return solutions.select(last_stage(self.first_scores(solutions)))

    # --- Choosing ---------------------------------------------------------------------------------

    def best(self, solutions: Solutions) -> int:
        """Return the place of the choice that comes first; there is at least one."""
        tied = self.left(solutions)[-1]
        scores = solutions.scores(self.tie_breakers)[tied]
        tied = tied[last_stage(scores, self.question.sample.tie)]
        return int(tied[np.argmin(self.rank(solutions.points, tied))])

    def rank(self, points: Points, rows: Selection) -> Rows:
        """Return the ranks of choices by the values of their axes, the axes in order of their keys.

        The smaller value comes first, and the name that comes first in the alphabet.
        """
        columns = []
        for axis in sorted(self.question.choices.axes, key=lambda axis: axis.key):
            values = points.columns[axis.column][rows]
            if axis.names:
                values = axis.rank[values]
            columns.append(values)
        count = len(points.row[rows])
        ranks = np.zeros(count, dtype=np.int64)
        if columns:
            ranks[np.lexsort(columns[::-1])] = np.arange(count)
        return ranks

    def first_few(self, solutions: Solutions) -> Rows:
        """Return the places of the choice that comes first and of some that tie with it."""
        tied = self.left(solutions)[-1]
        in_order = tied[np.argsort(self.rank(solutions.points, tied))]
        return np.union1d(self.best(solutions), in_order[:MOST_TIED])

    def leading(self, solutions: Solutions, most: int) -> Rows:
        """Return the places of the first few choices, the first of them first."""
        scores = self.scores(solutions)
        rank = self.rank(solutions.points, slice(None))
        return np.lexsort((rank, *(-scores.T[::-1])))[:most]


def last_stage(scores: Array, tie: float = EQUAL) -> Rows:
    """Return the rows of scores, (choices, rules), that tie by all rules, ascending."""
    rows = np.arange(len(scores))
    for of_rule in scores.T:
        rows = rows[of_rule[rows] >= _least_equal(of_rule[rows].max(), tie)]
    return rows


def _least_equal(top: npt.ArrayLike, tie: float = EQUAL) -> Array:
    """Return the smallest values that tie with the largest ones.

    Args:
        top: The largest values.
        tie: Relative difference up to which values are a tie.
    """
    largest = np.asarray(top, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        return np.where(np.isfinite(largest), largest - tie * np.abs(largest), largest)
