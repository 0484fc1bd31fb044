"""Candidates for an answer: the choices that may be the best, and those that the front has."""

from __future__ import annotations

import numpy as np

from tendon_cli.engine.windows.order import LEAST_TORQUE, Order, last_stage
from tendon_cli.engine.windows.question import EQUAL, Question
from tendon_cli.engine.windows.solutions import Solutions
from tendon_cli.model.kinematics import Array, Rows
from tendon_cli.model.limits import LIMIT_NAMES, NOTHING
from tendon_cli.studies.space.axis import limit_of

MOST_LIMITS = 100
"""Most values of a limit for each of which an answer names the best choice."""
_SMALLEST = 1e-6
"""End of a window below which others are compared as if it were as large, N."""
FINALISTS = 20
"""Number of choices that are solved again by the sample that sets them."""
LimitPair = tuple[str, ...]
"""The limit that asks for more pretension and the one that asks for less, by name.

A single name is that of a limit that no pretension can keep.
"""


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

    They are the best by each order, and some that tie with it; the front; the one that serves most;
    for each conflict the one that is nearest to a window; and the best with each value of a limit
    on which the choices differ, with several goals by the front of the choices with that value.
    """
    places = [_places_of(solutions, nearest(question, solutions))]
    if question.sample.sets_by_sample:
        places.append(Order.of(question).leading(solutions, FINALISTS))
    if solutions.feasible.any():
        feasible = np.flatnonzero(solutions.feasible)
        selected = solutions.select(feasible)
        places += [feasible[order.first_few(selected)] for order in orders_of(question).values()]
        if len(question.goals) > 1:
            places.append(_places_of(solutions, front_of(question, selected)))
        order = first_order(question)
        for of_values in by_limits(question, selected).values():
            for rows in filter(len, of_values):
                with_value = selected.select(rows)
                places.append(feasible[rows[order.first_few(with_value)]])
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


def without_effect(question: Question, solutions: Solutions) -> list[str]:
    """Return the keys on which no window of all choices depends, sorted."""
    ends = np.stack([solutions.pretension_from, solutions.pretension_to])
    windows = ends.reshape(2, *question.choices.shape)
    keys = []
    for place, axis in enumerate(question.choices.axes, start=1):
        first = windows.take([0], axis=place)
        is_same = np.isclose(windows, first, rtol=EQUAL, atol=EQUAL * _SMALLEST, equal_nan=True)
        if len(axis) > 1 and is_same.all():
            keys.append(axis.key)
    return sorted(keys)


def _places_of(solutions: Solutions, selected: Solutions) -> Rows:
    """Return the places of selected choices of the grid, ascending."""
    return np.flatnonzero(np.isin(solutions.row, selected.row))


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
