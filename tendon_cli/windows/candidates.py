"""Candidates for an answer: the best choices of the grid, and better ones between its points."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from tendon_cli.engine.task import Note
from tendon_cli.model.kinematics import Array, Rows
from tendon_cli.model.limits import LIMIT_NAMES, NOTHING
from tendon_cli.space.axis import Axis
from tendon_cli.windows.by_choice import ColumnArrays
from tendon_cli.windows.points import Points
from tendon_cli.windows.question import SERVED, USUAL, Goal, Question
from tendon_cli.windows.solutions import Solutions, solve, solve_windows
from tendon_cli.windows.solver import Solver
from tendon_cli.windows.worst import WORST, Worst

LimitPair = tuple[str, ...]
"""The limit that asks for more pretension and the one that asks for less, by name.

A single name is that of a limit that no pretension can keep.
"""

STATES_FOR_ALL = 2**30
"""Most states, under persons or draws, for which all choices have worst values."""

_PENALTY = 1e3
"""Cost of a share of a goal that is lost; choices without a window cost twice this, and more."""
_AT_ONCE_PER_RANGE = 10
"""Points of a generation, for each range that is searched."""
_GENERATIONS = 120
"""Most generations of a search."""
_FEWEST_GENERATIONS = 20
"""Generations below which a search is not worth while."""
_STATES = 4e7
"""Most states of one search."""
_NEAR_AN_EDGE = 1e-4
"""Distance from the end of a range within which the end itself is tried, as a share of it."""
_SEVEREST = 8
"""Number of conditions for each quantity, over which its worst bounds that over all conditions."""
_BEST_BOUNDS = {
    "max_tension": -np.inf,
    "max_spring_extension": -np.inf,
    "peak_motor_torque": 0.0,
    "min_elbow_stiffness": np.inf,
    "max_contact_pressure": -np.inf,
}
"""Bounds that no worst value can beat, by column."""


def conflicts_of(solutions: Solutions) -> dict[LimitPair, Rows]:
    """Return the limits that leave choices without a window, and the places of these choices."""
    low = solutions.pretension_from
    high = solutions.pretension_to
    pretension = solutions.pretension
    # A given pretension may miss a window at one of its ends.
    is_below = solutions.has_window & (pretension < low)
    is_above = solutions.has_window & (pretension > high)
    first = np.where(is_above, solutions.to_binding.by, solutions.from_binding.by)
    is_alone = np.isnan(low) | is_below | is_above
    second = np.where(is_alone, NOTHING, solutions.to_binding.by)
    rows = np.flatnonzero(~solutions.feasible)
    codes, kind = np.unique(np.column_stack([first, second])[rows], axis=0, return_inverse=True)
    conflicts: dict[LimitPair, Rows] = {}
    for place, pair_codes in enumerate(codes.tolist()):
        names = [LIMIT_NAMES[code] for code in pair_codes if code != NOTHING]
        pair = tuple(dict.fromkeys(names))
        of_codes = rows[kind.ravel() == place]
        conflicts[pair] = np.union1d(conflicts.get(pair, rows[:0]), of_codes)
    return conflicts


def nearest(solutions: Solutions) -> Solutions:
    """Return the choice nearest to a window: it serves most, and of these misses by least."""
    gap = _relative_gap(solutions)
    order = np.lexsort((solutions.row, np.where(np.isnan(gap), np.inf, gap), -solutions.served))
    return solutions.select(order[:1])


def _relative_gap(solutions: Solutions) -> Array:
    """Return the relative gap (from - to)/(|from| + |to|); NaN if an end is infinite."""
    low = solutions.pretension_from
    high = solutions.pretension_to
    with np.errstate(invalid="ignore"):
        return np.asarray((low - high) / (np.abs(low) + np.abs(high)))


def best_of(solutions: Solutions, scores: Array) -> int:
    """Return the place of the choice with the highest of the scores, (choices,).

    The tolerance decides among equal scores, such as those of all choices that serve everyone.
    """
    tolerance = solutions.scores((Goal("tolerance", maximise=True),))[:, 0]
    return int(np.lexsort((-tolerance, -scores))[0])


def relevant(solutions: Solutions, goals: tuple[Goal, ...]) -> Rows:
    """Return the places of choices that an answer may name, ascending.

    They are the best by each goal, the front, the one that serves most, and for each conflict the
    one that is nearest to a window.
    """
    places = [np.array([np.argmax(solutions.served)])]
    if solutions.feasible.any():
        feasible = np.flatnonzero(solutions.feasible)
        selected = solutions.select(feasible)
        scores = selected.scores(goals or (SERVED, *USUAL))
        places += [feasible[[best_of(selected, of_goal)]] for of_goal in scores.T]
        if len(goals) > 1:
            places.append(feasible[front(scores)])
    for rows in conflicts_of(solutions).values():
        is_nearest = solutions.row[rows] == nearest(solutions.select(rows)).row
        places.append(rows[is_nearest])
    return np.unique(np.concatenate(places))


def leaves_out(question: Question) -> bool:
    """Return True if choices that are not relevant are left without worst values to save time."""
    goals = {goal.column: goal.maximise for goal in question.goals}
    has_bounds = all(
        goals[name] == (name == "min_elbow_stiffness") for name in WORST if name in goals
    )
    has_groups = question.conditions.groups is not None
    return has_groups and has_bounds and question.states > STATES_FOR_ALL


def solve_part(solver: Solver, rows: Rows) -> Solutions:
    """Solve choices by their rows, with the worst values at the pretension of each.

    If `leaves_out`, only relevant choices have worst values. The worst over a few conditions bounds
    the worst over all. Relevant choices are selected by such bounds, worked out, and selected
    again, until the worst values of all of them are known: no other choice is better than its
    bound, so the selection is right.
    """
    question = solver.question
    points = question.points(rows)
    if not leaves_out(question):
        return solve(solver, points)
    solved, served = solve_windows(solver, points)

    def worst_of(places: Rows) -> Worst:
        """Return the worst values of some choices over all conditions that they serve."""
        return solver.worst(points.select(places), solved.pretension[places], served[places])

    first = np.array([np.argmax(solved.served)])
    severest = solver.severest_conditions(
        points.select(first), solved.pretension[first], served[first], _SEVEREST
    )
    of_severest = solver.for_question(question.for_conditions(severest))
    bounds = of_severest.worst(points, solved.pretension, served[:, severest])
    known = worst_of(first)
    solved = solved.with_worst(slice(None), _as_bounds(bounds, known), has_worst=False)
    solved = solved.with_worst(first, known)
    while True:
        places = relevant(solved, question.goals)
        missing = places[~solved.has_worst[places]]
        if not len(missing):
            break
        solved = solved.with_worst(missing, worst_of(missing))
    left = np.flatnonzero(~solved.has_worst)
    return solved.with_worst(left, Worst.unknown(len(left)), has_worst=False)


def _as_bounds(bounds: Worst, known: Worst) -> Worst:
    """Return bounds with those that no value can beat where a choice serves none of the conditions.

    Args:
        bounds: Worst values over a few conditions.
        known: Worst values of one choice over all conditions.
    """
    columns = {}
    for name, best_bound in _BEST_BOUNDS.items():
        values = getattr(bounds, name)
        # A quantity that has no value, such as pressure without a strap, has no bound.
        if not np.isnan(getattr(known, name)[0]):
            values = np.where(np.isnan(values), best_bound, values)
        columns[name] = values
    return Worst(**columns)


def summarise(choices: Solutions, goals: tuple[Goal, ...]) -> Note:
    """Return the note of a part for JSON: counts, conflicts, and the rows that may be named."""
    conflicts = conflicts_of(choices)
    return {
        "choices": len(choices),
        "feasible": int(choices.feasible.sum()),
        "conflicts": [[list(pair), len(rows)] for pair, rows in conflicts.items()],
        "rows": choices.row[relevant(choices, goals)].tolist(),
    }


# --- Comparing ------------------------------------------------------------------------------------


def front(scores: Array) -> Rows:
    """Return the rows of scores, (rows, goals), that no other row beats, ascending.

    A row beats another if it is as good in every goal and better in one. If rows are equal in
    every goal, only the first is returned.
    """
    _, first = np.unique(scores, axis=0, return_index=True)
    # In this order no row is beaten by one that comes after it.
    rest = first[np.lexsort(scores[first].T)[::-1]]
    unbeaten = []
    while len(rest):
        best = rest[0]
        unbeaten.append(best)
        is_beaten = np.all(scores[best] >= scores[rest], axis=1)
        rest = rest[~is_beaten]
    return np.sort(np.array(unbeaten, dtype=np.int64))


def losses(scores: Array) -> Array:
    """Return the share of each goal's span that rows of a front lose, (rows, goals): 0 is best.

    A score may be infinite, as that of an endless window: a row loses all of the span if it is
    infinitely worse than the best.
    """
    best = scores.max(axis=0)
    lag = np.subtract(best, scores, out=np.zeros_like(scores), where=scores != best)
    is_finite = np.isfinite(lag)
    span = np.max(lag, axis=0, initial=0.0, where=is_finite)
    return np.where(is_finite, lag / np.where(span > 0.0, span, 1.0), 1.0)


def compromise(scores: Array) -> int:
    """Return the row of a front, (rows, goals), whose largest loss in any goal is the smallest."""
    lost = losses(scores)
    return int(np.lexsort((lost.sum(axis=1), lost.max(axis=1)))[0])


# --- Between the points of the grid ---------------------------------------------------------------


def may_refine(question: Question) -> bool:
    """Return True if a search between the points of the grid is possible, and not too long."""
    return bool(_ranges(question)) and _generations(question) >= _FEWEST_GENERATIONS


def _ranges(question: Question) -> list[Axis]:
    """Return the axes between whose points a choice can lie."""
    return [axis for axis in question.choices.axes if axis.is_range]


def _generations(question: Question) -> int:
    """Return the number of generations of a search."""
    points = _AT_ONCE_PER_RANGE * len(_ranges(question))
    at_once = points * len(question.conditions) * question.states_per_design
    return min(_GENERATIONS, int(_STATES / max(at_once, 1)))


def refine_choice(solver: Solver, goals: tuple[Goal, ...], start: Solutions) -> Solutions | None:
    """Search for a better choice between the points of the grid.

    With one goal it is the best; with several it is as good in all of them, and better in their
    sum.

    Args:
        solver: Solver of the question.
        goals: Goals by which it is better.
        start: A choice of the grid with a window.

    Returns:
        The choice; None if the search finds nothing better, if there is no range to search, or if
        there are too many conditions.
    """
    question = solver.question
    if not may_refine(question):
        return None
    axes = _ranges(question)
    generations = _generations(question)
    before = start.scores(goals)[0]
    scale = np.maximum(np.abs(before), 1e-300)
    with_worst = any(goal.column in WORST for goal in goals)

    def choices_at(places: Array) -> Points:
        """Return choices at places, (choices, ranges), 0 to 1; the rest is as in `start`."""
        columns: ColumnArrays = {
            name: np.repeat(values, len(places)) for name, values in start.points.columns.items()
        }
        for axis, along in zip(axes, places.T, strict=True):
            columns[axis.column] = _value(axis, along)
        return Points.of_columns(question.choices, columns, len(places))

    def cost(places: Array) -> Array:
        """Return the cost of choices at places, (ranges, choices), the less the better."""
        tried = solve(solver, choices_at(places.T), with_worst=with_worst)
        gain = (tried.scores(goals) - before) / scale  # (choices, goals)
        lost = np.sum(np.maximum(0.0, -gain), axis=1) if len(goals) > 1 else 0.0
        of_feasible = -np.sum(gain, axis=1) + _PENALTY * lost
        costs = np.where(tried.feasible, of_feasible, _cost_without_window(question, tried))
        return np.asarray(np.where(np.isfinite(costs), costs, 4.0 * _PENALTY))

    place = np.array([_place(axis, float(start.points.columns[axis.column][0])) for axis in axes])
    steps = np.array([1.0 / (len(axis) - 1) for axis in axes])
    point = _evolve(cost, place, steps, generations)
    best = solve(solver, choices_at(point[np.newaxis]))
    after = best.scores(goals)[0]
    is_better = np.all(after >= before) and np.any(after > before + 1e-9 * scale)
    return best if is_better else None


def _value(axis: Axis, place: Array) -> Array:
    """Return values of a range at places from 0 to 1 along its grid."""
    first = axis.values[0]
    last = axis.values[-1]
    values = first * (last / first) ** place if axis.is_log else first + (last - first) * place
    values = np.where(place >= 1.0, last, values)
    return np.asarray(np.where(place <= 0.0, first, values))


def _place(axis: Axis, value: float) -> float:
    """Return the place of a value, 0 to 1, along the grid of a range."""
    points = np.array([axis.values[0], value, axis.values[-1]])
    first, middle, last = np.log(points) if axis.is_log else points
    return float(np.clip((middle - first) / (last - first), 0.0, 1.0))


def _cost_without_window(question: Question, solutions: Solutions) -> Array:
    """Return the cost of choices without a window: the less, the nearer they are to one."""
    if question.serve >= 1.0:
        return 2.0 * _PENALTY + _relative_gap(solutions)
    return np.asarray(2.0 * _PENALTY + (question.serve - solutions.served))


def _evolve(cost: Callable[[Array], Array], start: Array, steps: Array, generations: int) -> Array:
    """Return the point of least cost, (ranges,), by differential evolution.

    Half of the first points lie near the start, the others anywhere. If the best point lies near
    the ends of some ranges, the point at these ends is tried, too.

    Args:
        cost: Function from points, (ranges, points), to costs, (points,).
        start: First point, (ranges,), each 0 to 1.
        steps: Steps of the grid, (ranges,).
        generations: Most generations.
    """
    from scipy.optimize import Bounds, differential_evolution

    count = _AT_ONCE_PER_RANGE * len(start)
    random = np.random.default_rng(1)
    near = np.clip(start + steps * random.normal(size=(count // 2, len(start))), 0.0, 1.0)
    anywhere = random.random((count - len(near) - 1, len(start)))
    vectorized: Any = cost  # the stubs know of one point at a time only
    best = differential_evolution(
        vectorized,
        Bounds(np.zeros(len(start)), np.ones(len(start))),
        init=np.vstack([start, near, anywhere]),
        maxiter=generations,
        tol=1e-9,
        atol=0.0,
        polish=False,
        updating="deferred",
        vectorized=True,
        rng=random,
    ).x
    at_edge = np.where(best > 1.0 - _NEAR_AN_EDGE, 1.0, best)
    at_edge = np.where(best < _NEAR_AN_EDGE, 0.0, at_edge)
    tried = np.vstack([best, at_edge])
    return np.asarray(tried[np.argmin(cost(tried.T))])
