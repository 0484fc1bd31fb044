"""Candidates for an answer: the best choices of the grid, and better ones between its points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from tendon_cli.engine.plan import columns_of_motion
from tendon_cli.engine.task import Note
from tendon_cli.model.kinematics import Array, Rows
from tendon_cli.model.limits import LIMIT_NAMES, NOTHING
from tendon_cli.space.axis import Axis, limit_of
from tendon_cli.windows.by_choice import ColumnArrays
from tendon_cli.windows.dependence import digests_of_windows
from tendon_cli.windows.order import EQUAL, LEAST_TORQUE, Order, last_stage
from tendon_cli.windows.points import Points
from tendon_cli.windows.question import Question
from tendon_cli.windows.solutions import Solutions, solve, solve_windows
from tendon_cli.windows.solver import Solver
from tendon_cli.windows.worst import WORST, Worst

MOST_LIMITS = 100
"""Most values of a limit for each of which an answer names the best choice."""
LimitPair = tuple[str, ...]
"""The limit that asks for more pretension and the one that asks for less, by name.

A single name is that of a limit that no pretension can keep.
"""

STATES_FOR_ALL = 2**30
"""Most states, under persons or draws, for which all choices have worst values."""

_PENALTY = 1e3
"""Cost of a share of a goal that is lost on the way to a better front."""
_WEIGHT = 1e6
"""Weight of a goal over the next one, whose gains do not count before its own."""
_BREAKS_RULE = 1e15
"""Cost of a rule before all goals that the start keeps and a choice does not."""
_NO_WINDOW = 1e18
"""Cost of a choice without a window."""
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
    "spring_room": np.inf,
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
    # Where no pretension at all keeps the upper limit, the lower one does not matter.
    is_never = ~solutions.has_window & (high < 0.0)
    first = np.where(is_above | is_never, solutions.to_binding.by, solutions.from_binding.by)
    is_alone = np.isnan(low) | is_below | is_above | is_never
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


def nearest(question: Question, solutions: Solutions) -> Solutions:
    """Return the choice nearest to a window: it serves most, and of these misses by least."""
    gap = _relative_gap(solutions)
    scores = np.column_stack([solutions.served, np.where(np.isnan(gap), -np.inf, -gap)])
    tied = last_stage(scores)
    rank = Order.of(question).rank(solutions.points, tied)
    return solutions.select(tied[[np.argmin(rank)]])


def _relative_gap(solutions: Solutions) -> Array:
    """Return the relative gap (from - to)/(|from| + |to|); NaN if an end is infinite."""
    low = solutions.pretension_from
    high = solutions.pretension_to
    with np.errstate(invalid="ignore"):
        return np.asarray((low - high) / (np.abs(low) + np.abs(high)))


def orders_of(question: Question) -> dict[str, Order]:
    """Return the orders by which an answer names a best choice, by name, the main one first.

    With several goals it names a front, and the best by each. Without goals the best in the usual
    order has an empty name, and the best by each usual goal follows.
    """
    by_goal = {goal.column: Order(question, (goal,)) for goal in question.ranking}
    return by_goal if question.goals else {"": Order.of(question), **by_goal}


def first_order(question: Question) -> Order:
    """Return the order of the choice that is named first; with several goals that of the first."""
    return next(iter(orders_of(question).values()))


def named_first(question: Question, choices: Solutions) -> Solutions:
    """Return the choice of the grid that an answer with only these choices would name first.

    With several goals it is the best compromise on the front of these choices.

    Args:
        question: The question.
        choices: Choices with a window; at least one.
    """
    if len(question.goals) > 1:
        return compromise(question, front_of(question, choices))
    return choices.select([first_order(question).best(choices)])


def relevant(solutions: Solutions, question: Question) -> Rows:
    """Return the places of choices that an answer may name, ascending.

    They are those that may be the best by each order, or tie with it; the front; the one that
    serves most; for each conflict the one that is nearest to a window; and those that may be the
    best with each value of a limit on which the choices differ, with several goals by the front of
    the choices with that value.
    """
    places = [_places_of(solutions, nearest(question, solutions))]
    if solutions.feasible.any():
        feasible = np.flatnonzero(solutions.feasible)
        selected = solutions.select(feasible)
        places += [feasible[order.may_be_first(selected)] for order in orders_of(question).values()]
        if len(question.goals) > 1:
            places.append(_places_of(solutions, front_of(question, selected)))
        order = first_order(question)
        for of_values in by_limits(question, selected).values():
            for rows in filter(len, of_values):
                with_value = selected.select(rows)
                places.append(feasible[rows[order.may_be_first(with_value)]])
                if len(question.goals) > 1:
                    places.append(_places_of(solutions, front_of(question, with_value)))
    for rows in conflicts_of(solutions).values():
        places.append(_places_of(solutions, nearest(question, solutions.select(rows))))
    return np.unique(np.concatenate(places))


def by_limits(question: Question, choices: Solutions) -> dict[str, list[Rows]]:
    """Return the places of choices of the grid with each value of an axis that sets limits.

    Args:
        question: The question.
        choices: Some of its choices, all of them rows of the grid.

    Returns:
        For the key of each such axis the places of the choices with each of its values, in their
        order. Longer axes than MOST_LIMITS are left out.
    """
    on_axes = question.choices.places(choices.row)
    return {
        axis.key: [np.flatnonzero(on_axes[axis.key] == value) for value in range(len(axis))]
        for axis in question.choices.axes
        if 1 < len(axis) <= MOST_LIMITS and any(limit_of(key) for key in axis.keys)
    }


def _places_of(solutions: Solutions, selected: Solutions) -> Rows:
    """Return the places of selected choices of the grid, ascending."""
    return np.flatnonzero(np.isin(solutions.row, selected.row))


def leaves_out(question: Question) -> bool:
    """Return True if choices that are not relevant are left without worst values to save time."""
    goals = {goal.column: goal.maximise for goal in question.goals}
    has_bounds = goals.keys().isdisjoint(columns_of_motion(question.study)) and all(
        goals[name] == (name == "min_elbow_stiffness") for name in WORST if name in goals
    )
    has_groups = question.conditions.groups is not None
    return has_groups and has_bounds and question.states > STATES_FOR_ALL


def solve_part(solver: Solver, rows: Rows) -> Solutions:
    """Solve choices by their rows, with the worst values at the pretension of each.

    If `leaves_out`, only relevant choices have worst values. The worst over a few conditions bounds
    the worst over all, and so the advice that a choice fails. Relevant choices are selected by such
    bounds, worked out, and selected again, until the worst values of all of them are known: no
    other choice is better than its bound, so the selection is right. So are choices that tell which
    rule decides.
    """
    question = solver.question
    points = question.points(rows)
    if not leaves_out(question):
        return solve(solver, points)
    solved, served = solve_windows(solver, points)

    def worst_of(places: Rows) -> Worst:
        """Return the worst values of some choices over all conditions that they serve."""
        return solver.worst(points.select(places), solved.pretension[places], served[places])

    # A choice that serves nobody at its pretension has no worst values.
    first = np.array([np.argmax(solved.served_at)])
    severest = solver.severest_conditions(
        points.select(first), solved.pretension[first], served[first], _SEVEREST
    )
    of_severest = solver.for_question(question.for_conditions(severest))
    bounds = of_severest.worst(points, solved.pretension, served[:, severest])
    known = worst_of(first)
    solved = solved.with_worst(question, slice(None), _as_bounds(bounds, known), has_worst=False)
    solved = solved.with_worst(question, first, known)
    while True:
        places = relevant(solved, question)
        feasible = np.flatnonzero(solved.feasible)
        if len(feasible):
            undecided = Order.of(question).undecided(solved.select(feasible))
            places = np.union1d(places, feasible[undecided])
        missing = places[~solved.has_worst[places]]
        if not len(missing):
            break
        solved = solved.with_worst(question, missing, worst_of(missing))
    left = np.flatnonzero(~solved.has_worst)
    # What the bounds say of advice stays: a choice that fails it by a bound surely fails it.
    return replace(solved, worst=solved.worst.with_values(left, Worst.unknown(len(left))))


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


def summarise(choices: Solutions, question: Question) -> Note:
    """Return the note of a part for JSON: counts, conflicts, and the rows that may be named.

    `left` has, for each rule of the order, the numbers of choices that it leaves and that it may
    leave, by their scores as text; `windows` tells for each axis whether the windows depend on it.
    """
    conflicts = conflicts_of(choices)
    left = []
    if choices.feasible.any():
        stages = Order.of(question).stages(choices.select(choices.feasible))
        left = [
            [[[*map(repr, scores)], *count] for scores, count in counts.items()]
            for counts in stages
        ]
    return {
        "choices": len(choices),
        "feasible": int(choices.feasible.sum()),
        "conflicts": [[list(pair), len(rows)] for pair, rows in conflicts.items()],
        "rows": choices.row[relevant(choices, question)].tolist(),
        "left": left,
        "windows": digests_of_windows(question, choices),
    }


# --- Comparing ------------------------------------------------------------------------------------


def front_of(question: Question, solutions: Solutions) -> Solutions:
    """Select the choices that no other beats, in the order of the first goal.

    They are the best by the rules that come before all goals. Of choices that are equal in every
    goal, the one that breaks the tie is selected.
    """
    order = Order.of(question)
    best = order.with_first(solutions)
    torque = best.scores((LEAST_TORQUE,))[:, 0]
    best = best.select(np.lexsort((order.rank(best.points, slice(None)), -torque)))
    scores = best.scores(question.goals)
    unbeaten = front(scores)
    return best.select(unbeaten[np.argsort(-scores[unbeaten, 0], kind="stable")])


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


def least_losses(scores: Array, *then: Array) -> Rows:
    """Return the rows of a front whose largest loss in any goal is the smallest, ascending.

    Args:
        scores: Scores of the front, (rows, goals).
        then: Further scores, (rows,) each, that decide in turn where largest losses and sums of
            losses are equal.
    """
    lost = losses(scores)
    return last_stage(np.column_stack([-lost.max(axis=1), -lost.sum(axis=1), *then]))


def compromise(question: Question, choices: Solutions) -> Solutions:
    """Return the choice of a front whose largest loss in any goal is the smallest."""
    torque = choices.scores((LEAST_TORQUE,))[:, 0]
    tied = least_losses(choices.scores(question.goals), torque)
    rank = Order.of(question).rank(choices.points, tied)
    return choices.select(tied[[np.argmin(rank)]])


# --- Between the points of the grid ---------------------------------------------------------------


def may_refine(question: Question) -> bool:
    """Return True if a search between the points of the grid is possible, and not too long."""
    return bool(_ranges(question)) and _generations(question) >= _FEWEST_GENERATIONS


def _ranges(question: Question) -> list[Axis]:
    """Return the axes between whose points a choice can lie, in the order of their keys."""
    ranges = [axis for axis in question.choices.axes if axis.is_range]
    return sorted(ranges, key=lambda axis: axis.key)


def _generations(question: Question) -> int:
    """Return the number of generations of a search."""
    points = _AT_ONCE_PER_RANGE * len(_ranges(question))
    at_once = points * len(question.conditions) * question.states_per_design
    return min(_GENERATIONS, int(_STATES / max(at_once, 1)))


def refine_choice(solver: Solver, order: Order, start: Solutions) -> Solutions | None:
    """Search for a better choice between the points of the grid.

    It comes before `start` in the order. For a front it is as good in all goals, and better in
    their sum.

    Args:
        solver: Solver of the question.
        order: Order by which it is better.
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
    goals = order.goals
    before = start.scores(goals)[0]
    first_before = order.first_scores(start)[0]
    scale = np.maximum(np.abs(before), 1e-300)
    weights = _WEIGHT ** np.arange(len(goals) - 1, -1, -1.0)
    if order.is_front:
        weights = np.ones(len(goals))
    of_worst = {*WORST, *columns_of_motion(question.study)}
    with_worst = question.study.design.advice or any(goal.column in of_worst for goal in goals)

    lean = replace(solver, with_motion=False)

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
        tried = solve(lean, choices_at(places.T), with_worst=with_worst)
        with np.errstate(invalid="ignore"):
            gain = (tried.scores(goals) - before) / scale  # (choices, goals)
        of_feasible = -gain @ weights
        if order.is_front:
            of_feasible += _PENALTY * np.sum(np.maximum(0.0, -gain), axis=1)
        breaks_rule = (order.first_scores(tried) < first_before - EQUAL).any(axis=1)
        of_feasible = of_feasible + np.where(breaks_rule, _BREAKS_RULE, 0.0)
        costs = np.where(tried.feasible, of_feasible, _cost_without_window(question, tried))
        return np.asarray(np.where(np.isfinite(costs), costs, 2.0 * _NO_WINDOW))

    place = np.array([_place(axis, float(start.points.columns[axis.column][0])) for axis in axes])
    steps = np.array([1.0 / (len(axis) - 1) for axis in axes])
    point = _evolve(cost, place, steps, generations)
    best = solve(solver, choices_at(point[np.newaxis]))
    is_better = order.precedes(best, start)
    if order.is_front:
        after = best.scores(goals)[0]
        keeps_rules = np.all(order.first_scores(best)[0] >= first_before - EQUAL)
        gains = np.all(after >= before) and np.any(after > before + EQUAL * scale)
        is_better = bool(gains and keeps_rules)
    return best if best.feasible.item() and is_better else None


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
        return _NO_WINDOW * (1.0 + 0.1 * _relative_gap(solutions))
    return np.asarray(_NO_WINDOW * (1.0 + 0.1 * (question.serve - solutions.served)))


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
