"""Which choices may matter to an answer; of very many only of these the worst at their pretension is worked out."""

from __future__ import annotations

import numpy as np

from tendon_cli.answers.candidates import Candidates, of_rows
from tendon_cli.answers.conflicts import nearest, pairs
from tendon_cli.answers.problem import Problem, Rows
from tendon_cli.answers.rank import SERVED, USUAL, Goal, best, front, goals_of
from tendon_cli.answers.solve import without_worst
from tendon_cli.answers.worst import WORST, severest, worst
from tendon_cli.model.kinematics import Array

STATES_FOR_ALL = 2**30
"""Of all choices under persons or draws; of more, the worst is worked out for the promising ones alone."""

_AMONG_EQUALS = (Goal("tolerance", maximise=True),)
"""What decides between choices that are as good by a goal, such as all that serve everyone."""

_SEVEREST = 8
_UNKNOWN = dict(zip(WORST, (-np.inf, -np.inf, 0.0, np.inf, -np.inf), strict=True))
"""Better than any worst there is."""


def promising(candidates: Candidates, goals: tuple[Goal, ...]) -> Rows:
    """The best by each goal, the front, that which serves most, and of each conflict the nearest to a window."""
    solutions = candidates.solutions
    keep = [np.array([np.argmax(solutions.served)])]
    if solutions.feasible.any():
        able = np.flatnonzero(solutions.feasible)
        some = candidates.taken(able)
        worth = some.worth(goals or (SERVED, *USUAL))
        keep += [able[[best_of(some, column)]] for column in worth.T]
        keep += [able[front(worth)]] if len(goals) > 1 else []
    shut = np.flatnonzero(~solutions.feasible)
    named = np.array([" ".join(pair) for pair in pairs(solutions.taken(shut))])
    for name in np.unique(named):
        of_pair = shut[named == name]
        closest = nearest(candidates.taken(of_pair))
        keep.append(of_pair[candidates.row[of_pair] == closest.row])
    return np.unique(np.concatenate(keep))


def best_of(candidates: Candidates, worth: Array) -> int:
    """The place of the largest worth; of equals that of the largest tolerance."""
    return best(worth, candidates.worth(_AMONG_EQUALS)[:, 0])


def leaves_out(problem: Problem) -> bool:
    """Whether the worst at its pretension is left out of choices that do not matter."""
    goals = {goal.column: goal.maximise for goal in goals_of(problem.study)}
    bounded = all(goals[name] == (name == "min_elbow_stiffness") for name in WORST if name in goals)
    states = len(problem.choices) * len(problem.conditions) * problem.states_per_design
    return problem.conditions.groups is not None and bounded and states > STATES_FOR_ALL


def part_of(problem: Problem, rows: Rows) -> Candidates:
    """Choices by their rows, solved: of each the worst at its pretension, or of the promising ones where that suffices.

    The worst over a few conditions bounds the worst over all. With such bounds the promising ones are found, worked
    out, and found again, until all of them are: no other is better than its bound, so these are the right ones.
    """
    if not leaves_out(problem):
        return of_rows(problem, rows)
    numbers, columns, goals = problem.choices.numbers(rows), problem.choices.columns(rows), goals_of(problem.study)
    solutions, held = without_worst(problem, numbers, len(rows))

    def of(chosen: Rows) -> dict[str, Array]:
        some = {key: values[chosen] for key, values in numbers.items()}
        return worst(problem, some, solutions.pretension[chosen], held[chosen])

    first = np.array([np.argmax(solutions.served)])
    reference = {key: values[first] for key, values in numbers.items()}
    few = severest(problem, reference, solutions.pretension[first], held[first], _SEVEREST)
    bounds = worst(problem.under(few), numbers, solutions.pretension, held[:, few])
    known = of(first)
    for name, values in bounds.items():
        if not np.isnan(known[name][0]):  # of what is not asked for, as pressure without a strap, there is no bound
            bounds[name] = np.where(np.isnan(values), _UNKNOWN[name], values)
    found = solutions.with_worst(slice(None), bounds, worked_out=False).with_worst(first, known)
    while len(rest := _not_yet(Candidates(rows, columns, found), goals)):
        found = found.with_worst(rest, of(rest))
    left, nothing = np.flatnonzero(~found.worked_out), np.asarray(np.nan)
    return Candidates(rows, columns, found.with_worst(left, dict.fromkeys(WORST, nothing), worked_out=False))


def _not_yet(candidates: Candidates, goals: tuple[Goal, ...]) -> Rows:
    """The promising ones whose worst is not worked out."""
    rows = promising(candidates, goals)
    return rows[~candidates.solutions.worked_out[rows]]
