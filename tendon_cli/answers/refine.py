"""Choices between the points of the grid: a range is searched for what is better than its grid. Windows stay exact."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from tendon_cli.answers.front import Goal
from tendon_cli.answers.question import Columns, Problem
from tendon_cli.answers.solve import WORST, Solutions, of_columns
from tendon_cli.model.kinematics import Array
from tendon_cli.space.axis import Axis

_PENALTY = 1e3
_AT_ONCE_PER_RANGE = 10
_GENERATIONS = 120
_FEWEST_GENERATIONS = 20
_STATES = 4e7
"""Most states of one search."""
_NEAR_AN_EDGE = 1e-4


def refined(problem: Problem, goals: tuple[Goal, ...], start: Solutions) -> Solutions | None:
    """A choice between the points of the grid, better than `start`, one of its choices with a window.

    With one goal it is the best; with several it is as good in all of them, and better in their sum. None if the
    search finds nothing better, or there is no range, or too many conditions to search.
    """
    axes = [axis for axis in problem.choices.axes if axis.is_range]
    at_once = _AT_ONCE_PER_RANGE * len(axes) * len(problem.conditions) * problem.states_per_design
    generations = min(_GENERATIONS, int(_STATES / max(at_once, 1)))
    if not axes or generations < _FEWEST_GENERATIONS:
        return None
    before = start.scores(goals)[0]
    scale = np.maximum(np.abs(before), 1e-300)
    with_worst = any(goal.column in WORST for goal in goals)

    def columns(at: Array) -> Columns:
        """Whole choices at points, (points, ranges), each 0 to 1; all else as the start has it."""
        rest = {name: np.repeat(values[:1], len(at)) for name, values in start.columns.items()}
        return rest | {axis.column: _value(axis, place) for axis, place in zip(axes, at.T, strict=True)}

    def cost(at: Array) -> Array:
        tried = of_columns(problem, columns(at.T), at.shape[1], with_worst=with_worst)
        gain = (tried.scores(goals) - before) / scale
        lost = np.sum(np.maximum(0.0, -gain), axis=1) if len(goals) > 1 else 0.0
        costs = np.where(tried["feasible"], -np.sum(gain, axis=1) + _PENALTY * lost, _infeasible(problem, tried))
        return np.asarray(np.where(np.isfinite(costs), costs, 4.0 * _PENALTY))

    at = np.array([_place(axis, start.one(axis.column)) for axis in axes])
    steps = np.array([1.0 / (len(axis) - 1) for axis in axes])
    best = of_columns(problem, columns(_evolved(cost, at, steps, generations)[np.newaxis]), 1)
    after = best.scores(goals)[0]
    better = np.all(after >= before) and np.any(after > before + 1e-9 * scale)
    return best if better else None


def _value(axis: Axis, place: Array) -> Array:
    """Values of a range at places from 0 to 1 along its grid."""
    first, last = axis.values[0], axis.values[-1]
    inner = first * (last / first) ** place if axis.is_log else first + (last - first) * place
    return np.asarray(np.where(place <= 0.0, first, np.where(place >= 1.0, last, inner)))


def _place(axis: Axis, value: float) -> float:
    ends = np.array([axis.values[0], value, axis.values[-1]])
    first, at, last = np.log(ends) if axis.is_log else ends
    return float(np.clip((at - first) / (last - first), 0.0, 1.0))


def _infeasible(problem: Problem, solutions: Solutions) -> Array:
    """What a choice without a window costs: the less, the nearer it is to one."""
    low, high = solutions["pretension_from"], solutions["pretension_to"]
    with np.errstate(invalid="ignore"):  # nothing bounds the window
        gap = (low - high) / (np.abs(low) + np.abs(high))
    return 2.0 * _PENALTY + (gap if problem.enough >= 1.0 else problem.enough - solutions["served"])


def _evolved(cost: Callable[[Array], Array], start: Array, steps: Array, generations: int) -> Array:
    """The point of least cost, by differential evolution from around a start, then tried at the edges it is near to."""
    from scipy.optimize import Bounds, differential_evolution

    count = _AT_ONCE_PER_RANGE * len(start)
    random = np.random.default_rng(1)
    near = np.clip(start + steps * random.normal(size=(count // 2, len(start))), 0.0, 1.0)
    anywhere = random.random((count - len(near) - 1, len(start)))
    vectorized: Any = cost  # the stubs know of one point at a time only
    box = Bounds(np.zeros(len(start)), np.ones(len(start)))
    best = differential_evolution(
        vectorized, box, init=np.vstack([start, near, anywhere]), maxiter=generations,
        tol=1e-9, atol=0.0, polish=False, updating="deferred", vectorized=True, rng=random,
    ).x  # fmt: skip
    at_edge = np.where(best < _NEAR_AN_EDGE, 0.0, np.where(best > 1.0 - _NEAR_AN_EDGE, 1.0, best))
    tried = np.vstack([best, at_edge])
    return np.asarray(tried[np.argmin(cost(tried.T))])
