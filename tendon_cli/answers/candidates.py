"""Some choices of a question, and which of them may matter to an answer."""

from __future__ import annotations

import numpy as np

from tendon_cli.answers.front import SERVED, USUAL, Goal, best, front, goals_of
from tendon_cli.answers.question import Problem
from tendon_cli.answers.solve import WORST, Solutions, of_rows, severest, without_worst, worst
from tendon_cli.engine.task import Note
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMIT_NAMES, NOTHING
from tendon_cli.space.axis import Numbers, Rows

Pair = tuple[str, ...]
"""The limit that asks for more pretension and the one that asks for less; one alone that no pretension can keep."""

STATES_FOR_ALL = 2**30
"""States of all choices under persons or draws, beyond which the worst is worked out for the relevant ones alone."""

_SEVEREST = 8
_UNKNOWN = dict(zip(WORST, (-np.inf, -np.inf, 0.0, np.inf, -np.inf), strict=True))
"""Better than any worst there is."""


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
    return solutions.taken(order[:1])


def best_of(solutions: Solutions, scores: Array) -> int:
    """The place of the highest score; of equals, such as all that serve everyone, that of the largest tolerance."""
    return best(scores, solutions.scores((Goal("tolerance", maximise=True),))[:, 0])


def relevant(solutions: Solutions, goals: tuple[Goal, ...]) -> Rows:
    """The best by each goal, the front, the one that serves most, and for each conflict the nearest to a window."""
    keep = [np.array([np.argmax(solutions["served"])])]
    if solutions["feasible"].any():
        feasible = np.flatnonzero(solutions["feasible"])
        some = solutions.taken(feasible)
        scores = some.scores(goals or (SERVED, *USUAL))
        keep += [feasible[[best_of(some, column)]] for column in scores.T]
        keep += [feasible[front(scores)]] if len(goals) > 1 else []
    for rows in conflicts_of(solutions).values():
        keep.append(rows[solutions.row[rows] == nearest(solutions.taken(rows)).row])
    return np.unique(np.concatenate(keep))


def leaves_out(problem: Problem) -> bool:
    """Whether the worst at its pretension is left out of choices that do not matter."""
    goals = {goal.column: goal.maximise for goal in goals_of(problem.study)}
    bounded = all(goals[name] == (name == "min_elbow_stiffness") for name in WORST if name in goals)
    states = len(problem.choices) * len(problem.conditions) * problem.states_per_design
    return problem.conditions.groups is not None and bounded and states > STATES_FOR_ALL


def part_of(problem: Problem, rows: Rows) -> Solutions:
    """Choices by their rows, solved, with the worst at the pretension of each or, if possible, of the relevant.

    The worst over a few conditions bounds the worst over all. With such bounds the relevant ones are chosen, worked
    out, and chosen again, until all of them are: no other is better than its bound, so these are the right ones.
    """
    if not leaves_out(problem):
        return of_rows(problem, rows)
    numbers, goals = problem.choices.numbers(rows), goals_of(problem.study)
    solved, served = without_worst(problem, numbers, len(rows))
    solved = Solutions(solved.results, rows, problem.choices.columns(rows))

    def given(chosen: Rows) -> tuple[Numbers, Array]:
        return {key: values[chosen] for key, values in numbers.items()}, solved["pretension"][chosen]

    first = np.array([np.argmax(solved["served"])])
    few = severest(problem, *given(first), served[first], _SEVEREST)
    bounds = worst(problem.under(few), *given(np.arange(len(rows))), served[:, few])
    known = worst(problem, *given(first), served[first])
    for name, values in bounds.items():
        if not np.isnan(known[name][0]):  # what is not asked for, as pressure without a strap, has no bound
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
