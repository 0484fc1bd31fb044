"""Which choices are best, which may matter to an answer, and better ones between the points of the grid."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from tendon_cli.answers.problem import Problem
from tendon_cli.answers.question import SERVED, USUAL, ColumnArrays, Goal, goals_of, select_numbers
from tendon_cli.answers.solve import (
    WORST,
    Solutions,
    of_columns,
    of_rows,
    severest_conditions,
    solve_windows,
    worst,
)
from tendon_cli.engine.task import Note
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMIT_NAMES, NOTHING
from tendon_cli.space.axis import Axis, Numbers, Rows

Pair = tuple[str, ...]
"""The limit that asks for more pretension and the one that asks for less; one alone that no pretension can keep."""

STATES_FOR_ALL = 2**30
"""States of all choices under persons or draws, beyond which the worst is worked out for the relevant ones alone."""

_PENALTY = 1e3
_AT_ONCE_PER_RANGE = 10
_GENERATIONS = 120
_FEWEST_GENERATIONS = 20
_STATES = 4e7  # most states of one search
_NEAR_AN_EDGE = 1e-4
_SEVEREST = 8
_UNKNOWN = dict(
    zip(WORST, (-np.inf, -np.inf, 0.0, np.inf, -np.inf), strict=True)
)  # better than any worst there is


def conflicts_of(solutions: Solutions) -> dict[Pair, Rows]:
    """What leaves choices without a window, and the places of those choices."""
    low, high, at = (solutions[name] for name in ("pretension_from", "pretension_to", "pretension"))
    # A given pretension may miss a window at one of its ends.
    below, above = solutions.has_window & (at < low), solutions.has_window & (at > high)
    first = np.where(above, solutions["to_by"], solutions["from_by"])
    second = np.where(np.isnan(low) | below | above, NOTHING, solutions["to_by"])
    rows = np.flatnonzero(~solutions["feasible"])
    codes, kind = np.unique(np.column_stack([first, second])[rows], axis=0, return_inverse=True)
    pairs: dict[Pair, Rows] = {}
    for place, each in enumerate(codes.tolist()):
        pair = tuple(dict.fromkeys(LIMIT_NAMES[code] for code in each if code != NOTHING))
        pairs[pair] = np.union1d(pairs.get(pair, rows[:0]), rows[kind.ravel() == place])
    return pairs


def nearest(solutions: Solutions) -> Solutions:
    """The one of some choices without a window that is nearest to have one: it serves most, and misses by least."""
    low, high = solutions["pretension_from"], solutions["pretension_to"]
    with np.errstate(invalid="ignore"):
        gap = (low - high) / (np.abs(low) + np.abs(high))
    order = np.lexsort((solutions.row, np.where(np.isnan(gap), np.inf, gap), -solutions["served"]))
    return solutions.select(order[:1])


def best_of(solutions: Solutions, scores: Array) -> int:
    """The place of the highest score; of equals, such as all that serve everyone, that of the largest tolerance."""
    return int(
        np.lexsort((-solutions.scores((Goal("tolerance", maximise=True),))[:, 0], -scores))[0]
    )


def relevant(solutions: Solutions, goals: tuple[Goal, ...]) -> Rows:
    """The best by each goal, the front, the one that serves most, and for each conflict the nearest to a window."""
    keep = [np.array([np.argmax(solutions["served"])])]
    if solutions["feasible"].any():
        feasible = np.flatnonzero(solutions["feasible"])
        some = solutions.select(feasible)
        scores = some.scores(goals or (SERVED, *USUAL))
        keep += [feasible[[best_of(some, column)]] for column in scores.T]
        keep += [feasible[front(scores)]] if len(goals) > 1 else []
    for rows in conflicts_of(solutions).values():
        keep.append(rows[solutions.row[rows] == nearest(solutions.select(rows)).row])
    return np.unique(np.concatenate(keep))


def leaves_out(problem: Problem) -> bool:
    """Whether the worst at its pretension is left out of choices that do not matter."""
    goals = {goal.column: goal.maximise for goal in goals_of(problem.study)}
    bounded = all(goals[name] == (name == "min_elbow_stiffness") for name in WORST if name in goals)
    states = len(problem.choices) * len(problem.conditions) * problem.states_per_design
    return problem.conditions.groups is not None and bounded and states > STATES_FOR_ALL


def solved_part(problem: Problem, rows: Rows) -> Solutions:
    """Choices by their rows, solved, with the worst at the pretension of each or, if possible, of the relevant.

    The worst over a few conditions bounds the worst over all. With such bounds the relevant ones are chosen, worked
    out, and chosen again, until all of them are: no other is better than its bound, so these are the right ones.
    """
    if not leaves_out(problem):
        return of_rows(problem, rows)
    numbers, goals = problem.choices.numbers(rows), goals_of(problem.study)
    solved, served = solve_windows(problem, numbers, len(rows))
    solved = Solutions(solved.results, rows, problem.choices.columns(rows))

    def given(chosen: Rows) -> tuple[Numbers, Array]:
        return select_numbers(numbers, chosen), solved["pretension"][chosen]

    first = np.array([np.argmax(solved["served"])])
    few = severest_conditions(problem, *given(first), served[first], _SEVEREST)
    bounds = worst(problem.under(few), *given(np.arange(len(rows))), served[:, few])
    known = worst(problem, *given(first), served[first])
    for name, values in bounds.items():
        if not np.isnan(
            known[name][0]
        ):  # what is not asked for, as pressure without a strap, has no bound
            bounds[name] = np.where(np.isnan(values), _UNKNOWN[name], values)
    solved = solved.with_worst(slice(None), bounds, has_worst=False).with_worst(first, known)
    while rest := [row for row in relevant(solved, goals) if not solved["has_worst"][row]]:
        missing = np.array(rest)
        solved = solved.with_worst(missing, worst(problem, *given(missing), served[missing]))
    left = np.flatnonzero(~solved["has_worst"])
    return solved.with_worst(left, dict.fromkeys(WORST, np.asarray(np.nan)), has_worst=False)


def summarised(choices: Solutions, goals: tuple[Goal, ...]) -> Note:
    """What matters of some choices, as JSON has it: counts, conflicts, and the rows that may be named."""
    return {
        "choices": len(choices),
        "feasible": int(choices["feasible"].sum()),
        "conflicts": [[list(pair), len(rows)] for pair, rows in conflicts_of(choices).items()],
        "rows": choices.row[relevant(choices, goals)].tolist(),
    }


# --- Comparing -------------------------------------------------------------------------------------------------------


def front(scores: Array) -> Rows:
    """Rows, ascending, that no other row beats: is as good in every goal and better in one. `scores` is (rows, goals).

    Of rows that are equal in every goal the first stands for all.
    """
    _, first = np.unique(scores, axis=0, return_index=True)
    rest, kept = (
        first[np.lexsort(scores[first].T)[::-1]],
        [],
    )  # no row is beaten by one that comes after it
    while len(rest):
        kept.append(rest[0])
        rest = rest[~np.all(scores[rest[0]] >= scores[rest], axis=1)]
    return np.sort(np.array(kept, dtype=np.int64))


def losses(scores: Array) -> Array:
    """What each row of a front gives up of each goal, as a share of what the front spans: 0 is best, 1 worst."""
    span = np.ptp(scores, axis=0)
    return np.asarray((scores.max(axis=0) - scores) / np.where(span > 0.0, span, 1.0))


def compromise(scores: Array) -> int:
    """The row of a front, (rows, goals), that gives up the least of the goal of which it gives up most."""
    given_up = losses(scores)
    return int(np.lexsort((given_up.sum(axis=1), given_up.max(axis=1)))[0])


# --- Between the points of the grid ----------------------------------------------------------------------------------


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

    def columns(at: Array) -> ColumnArrays:
        """Whole choices at points, (points, ranges), each 0 to 1; all else as the start has it."""
        rest = {name: np.repeat(values[:1], len(at)) for name, values in start.columns.items()}
        return rest | {
            axis.column: _value(axis, place) for axis, place in zip(axes, at.T, strict=True)
        }

    def cost(at: Array) -> Array:
        tried = of_columns(problem, columns(at.T), at.shape[1], with_worst=with_worst)
        gain = (tried.scores(goals) - before) / scale
        lost = np.sum(np.maximum(0.0, -gain), axis=1) if len(goals) > 1 else 0.0
        costs = np.where(
            tried["feasible"], -np.sum(gain, axis=1) + _PENALTY * lost, _infeasible(problem, tried)
        )
        return np.asarray(np.where(np.isfinite(costs), costs, 4.0 * _PENALTY))

    at = np.array([_place(axis, start.scalar(axis.column)) for axis in axes])
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
        vectorized,
        box,
        init=np.vstack([start, near, anywhere]),
        maxiter=generations,
        tol=1e-9,
        atol=0.0,
        polish=False,
        updating="deferred",
        vectorized=True,
        rng=random,
    ).x
    at_edge = np.where(best < _NEAR_AN_EDGE, 0.0, np.where(best > 1.0 - _NEAR_AN_EDGE, 1.0, best))
    tried = np.vstack([best, at_edge])
    return np.asarray(tried[np.argmin(cost(tried.T))])
