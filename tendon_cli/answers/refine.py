"""Choices between the points of the grid: a range is searched for what is better than its grid. Windows stay exact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tendon_cli.answers.candidates import Candidates, Columns, numbers_of, of_columns
from tendon_cli.answers.front import Goal
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.solve import WORST, Solutions, solve
from tendon_cli.model.kinematics import Array
from tendon_cli.space.axis import Axis

_PENALTY = 1e3
_AT_ONCE_PER_RANGE = 10
_GENERATIONS = 120
_FEWEST_GENERATIONS = 20
_STATES = 4e7
"""Most states of one search."""
_NEAR_AN_EDGE = 1e-4


@dataclass(frozen=True, eq=False)
class Ranges:
    """The ranges among the choices, each as 0 to 1 along its grid."""

    problem: Problem
    axes: tuple[Axis, ...]

    @classmethod
    def of(cls, problem: Problem) -> Ranges:
        """Those of a question."""
        return cls(problem, tuple(factor for factor in problem.choices.axes if factor.is_range))

    def values(self, at: Array) -> Columns:
        """The values of points, (points, ranges)."""
        columns: Columns = {}
        for place, factor in zip(at.T, self.axes, strict=True):
            first, last = factor.values[0], factor.values[-1]
            inner = first * (last / first) ** place if factor.is_log else first + (last - first) * place
            columns[factor.column] = np.where(place <= 0.0, first, np.where(place >= 1.0, last, inner))
        return columns

    def places(self, candidates: Candidates) -> Array:
        """Where candidates lie, (points, ranges)."""
        places = []
        for factor in self.axes:
            first, last, values = factor.values[0], factor.values[-1], candidates.column(factor.column)
            place = (
                np.log(values / first) / np.log(last / first) if factor.is_log else (values - first) / (last - first)
            )
            places.append(np.clip(place, 0.0, 1.0))
        return np.column_stack(places)

    def columns(self, at: Array, start: Candidates) -> Columns:
        """Whole choices at points, all else as one candidate has it."""
        rest = {name: np.repeat(values[:1], len(at)) for name, values in start.columns.items()}
        return rest | self.values(at)

    @property
    def generations(self) -> int:
        """How many rounds of a search are affordable; 0 if they are too few to help."""
        at_once = _AT_ONCE_PER_RANGE * len(self.axes) * len(self.problem.conditions) * self.problem.states_per_design
        most = int(_STATES / max(at_once, 1))
        return 0 if not self.axes or most < _FEWEST_GENERATIONS else min(_GENERATIONS, most)


def refined(problem: Problem, goals: tuple[Goal, ...], start: Candidates) -> Candidates | None:
    """A choice between the points of the grid, better than `start`, one of its choices with a window.

    With one goal it is the best; with several it is as good in all of them, and better in their sum. None if the
    search finds nothing better, or there is no range, or too many conditions to search.
    """
    ranges = Ranges.of(problem)
    if not ranges.generations:
        return None
    before = start.scores(goals)[0]
    scale = np.maximum(np.abs(before), 1e-300)
    with_worst = any(goal.column in WORST for goal in goals)

    def cost(at: Array) -> Array:
        columns = ranges.columns(at.T, start)
        solutions = solve(problem, numbers_of(problem, columns), at.shape[1], with_worst=with_worst)
        gain = (Candidates(np.full(at.shape[1], -1), columns, solutions).scores(goals) - before) / scale
        lost = np.sum(np.maximum(0.0, -gain), axis=1) if len(goals) > 1 else 0.0
        costs = np.where(solutions.feasible, -np.sum(gain, axis=1) + _PENALTY * lost, _infeasible(problem, solutions))
        return np.where(np.isfinite(costs), costs, 4.0 * _PENALTY)

    place = _evolved(cost, ranges, ranges.places(start)[0])
    best = of_columns(problem, ranges.columns(place[np.newaxis], start), 1)
    after = best.scores(goals)[0]
    better = np.all(after >= before) and np.any(after > before + 1e-9 * scale)
    return best if better else None


def _infeasible(problem: Problem, solutions: Solutions) -> Array:
    """What a choice without a window costs: the less, the nearer it is to one."""
    low, high = solutions.pretension_from, solutions.pretension_to
    with np.errstate(invalid="ignore"):  # nothing bounds the window
        gap = (low - high) / (np.abs(low) + np.abs(high))
    return 2.0 * _PENALTY + (gap if problem.enough >= 1.0 else problem.enough - solutions.served)


def _evolved(cost: Callable[[Array], Array], ranges: Ranges, start: Array) -> Array:
    """The point of least cost, by differential evolution from around a start, then tried at the edges it is near to."""
    from scipy.optimize import Bounds, differential_evolution

    count = _AT_ONCE_PER_RANGE * len(start)
    random = np.random.default_rng(1)
    steps = np.array([1.0 / (len(factor) - 1) for factor in ranges.axes])
    near = np.clip(start + steps * random.normal(size=(count // 2, len(start))), 0.0, 1.0)
    anywhere = random.random((count - len(near) - 1, len(start)))
    vectorized: Any = cost  # the stubs know of one point at a time only
    box = Bounds(np.zeros(len(start)), np.ones(len(start)))
    best = differential_evolution(
        vectorized, box, init=np.vstack([start, near, anywhere]), maxiter=ranges.generations,
        tol=1e-9, atol=0.0, polish=False, updating="deferred", vectorized=True, rng=random,
    ).x  # fmt: skip
    at_edge = np.where(best < _NEAR_AN_EDGE, 0.0, np.where(best > 1.0 - _NEAR_AN_EDGE, 1.0, best))
    tried = np.vstack([best, at_edge])
    return np.asarray(tried[np.argmin(cost(tried.T))])
