"""Some choices of a question with what they come to, and which of them may matter to an answer."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.answers.front import SERVED, USUAL, Goal, best, front, goals_of
from tendon_cli.answers.problem import Flags, Problem
from tendon_cli.answers.solve import WORST, Solutions, severest, solve, without_worst, worst
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMIT_NAMES, NOTHING
from tendon_cli.space.axis import Axis, Numbers, Rows

Columns = dict[str, npt.NDArray[Any]]
Pair = tuple[str, ...]
"""The limit that asks for more pretension and the one that asks for less; one alone that no pretension can keep."""

STATES_FOR_ALL = 2**30
"""States of all choices under persons or draws, beyond which the worst is worked out for the relevant ones alone."""

_AMONG_EQUALS = (Goal("tolerance", maximise=True),)
"""What decides between choices that are as good by a goal, such as all that serve everyone."""

_SEVEREST = 8
_UNKNOWN = dict(zip(WORST, (-np.inf, -np.inf, 0.0, np.inf, -np.inf), strict=True))
"""Better than any worst there is."""


@dataclass(frozen=True, eq=False)
class Candidates:
    """Choices, those of the grid and others between its points."""

    row: Rows
    """Their rows in `choices.parquet`; -1 for one between the points of the grid that has none yet."""
    columns: Columns
    """Their values of each axis: SI, or of named values the position among their names."""
    solutions: Solutions

    def __len__(self) -> int:
        return len(self.row)

    def column(self, name: str) -> Array:
        """An axis or a result by its column's name."""
        if name in self.columns:
            return np.asarray(self.columns[name], dtype=np.float64)
        return self.solutions.column(name)

    def scores(self, goals: tuple[Goal, ...]) -> Array:
        """The score of each by each goal, (choices, goals); one without a window has the least."""
        scores = np.column_stack([goal.score(self.column(goal.column)) for goal in goals])
        return np.where(self.solutions.feasible[:, np.newaxis], scores, -np.inf)

    def taken(self, rows: Rows | Flags) -> Candidates:
        """Some of them."""
        columns = {name: values[rows] for name, values in self.columns.items()}
        return Candidates(self.row[rows], columns, self.solutions.taken(rows))

    @classmethod
    def joined(cls, parts: list[Candidates]) -> Candidates:
        """Those of several, one after the other."""
        columns = {name: np.concatenate([part.columns[name] for part in parts]) for name in parts[0].columns}
        solutions = Solutions.joined([part.solutions for part in parts])
        return cls(np.concatenate([part.row for part in parts]), columns, solutions)


def of_rows(problem: Problem, rows: Rows) -> Candidates:
    """The choices of some rows, solved."""
    solutions = solve(problem, problem.choices.numbers(rows), len(rows))
    return Candidates(rows, problem.choices.columns(rows), solutions)


def of_columns(problem: Problem, columns: Columns, count: int) -> Candidates:
    """Choices anywhere, solved."""
    solutions = solve(problem, numbers_of(problem, columns), count)
    return Candidates(np.full(count, -1), columns, solutions)


def numbers_of(problem: Problem, columns: Columns) -> Numbers:
    """What choices, given by their columns, say of the study's numbers."""
    numbers: dict[str, Array] = {}
    for factor in problem.choices.axes:
        numbers |= _numbers_of(factor, columns[factor.column])
    return numbers


def _numbers_of(factor: Axis, values: npt.NDArray[Any]) -> Numbers:
    if factor.names:
        return {key: numbers[values] for key, numbers in factor.numbers.items()}
    return {factor.key: values}


# --- Those without a window ------------------------------------------------------------------------------------------


def pairs(solutions: Solutions) -> list[Pair]:
    """What leaves each choice without a window; empty for one that has one."""
    none: Pair = ()
    named = []
    # A given pretension may miss a window at one of its ends.
    below = solutions.has_window & (solutions.pretension < solutions.pretension_from)
    above = solutions.has_window & (solutions.pretension > solutions.pretension_to)
    alone = np.isnan(solutions.pretension_from) | below
    for feasible, at_low, at_high, low, high in zip(
        solutions.feasible, alone, above, solutions.from_by, solutions.to_by, strict=True
    ):
        codes = (low,) if at_low else (high,) if at_high else (low, high)
        names = [LIMIT_NAMES[code] for code in codes if code != NOTHING]
        named.append(none if feasible else tuple(dict.fromkeys(names)))
    return named


def counted(solutions: Solutions) -> Counter[Pair]:
    """How many choices each pair leaves without a window."""
    low, at = solutions.pretension_from, solutions.pretension
    codes = np.column_stack(
        [solutions.from_by, solutions.to_by, np.isnan(low), solutions.has_window & (at < low), solutions.has_window]
    )
    infeasible = np.flatnonzero(~solutions.feasible)
    _, first, counts = np.unique(codes[infeasible], axis=0, return_index=True, return_counts=True)
    of_pairs: Counter[Pair] = Counter()
    for pair, count in zip(pairs(solutions.taken(infeasible[first])), counts.tolist(), strict=True):
        of_pairs[pair] += count
    return of_pairs


def nearest(candidates: Candidates) -> Candidates:
    """The one of some choices without a window that is nearest to have one.

    It serves most, and misses by the least share.
    """
    solutions = candidates.solutions
    low, high = solutions.pretension_from, solutions.pretension_to
    with np.errstate(invalid="ignore"):
        gap = (low - high) / (np.abs(low) + np.abs(high))
    order = np.lexsort((candidates.row, np.where(np.isnan(gap), np.inf, gap), -solutions.served))
    return candidates.taken(order[:1])


# --- Those that may matter -------------------------------------------------------------------------------------------


def relevant(candidates: Candidates, goals: tuple[Goal, ...]) -> Rows:
    """The best by each goal, the front, the one that serves most, and for each conflict the nearest to a window."""
    solutions = candidates.solutions
    keep = [np.array([np.argmax(solutions.served)])]
    if solutions.feasible.any():
        feasible = np.flatnonzero(solutions.feasible)
        some = candidates.taken(feasible)
        scores = some.scores(goals or (SERVED, *USUAL))
        keep += [feasible[[best_of(some, column)]] for column in scores.T]
        keep += [feasible[front(scores)]] if len(goals) > 1 else []
    infeasible = np.flatnonzero(~solutions.feasible)
    named = np.array([" ".join(pair) for pair in pairs(solutions.taken(infeasible))])
    for name in np.unique(named):
        of_pair = infeasible[named == name]
        closest = nearest(candidates.taken(of_pair))
        keep.append(of_pair[candidates.row[of_pair] == closest.row])
    return np.unique(np.concatenate(keep))


def best_of(candidates: Candidates, scores: Array) -> int:
    """The place of the highest score; of equals that of the largest tolerance."""
    return best(scores, candidates.scores(_AMONG_EQUALS)[:, 0])


def leaves_out(problem: Problem) -> bool:
    """Whether the worst at its pretension is left out of choices that do not matter."""
    goals = {goal.column: goal.maximise for goal in goals_of(problem.study)}
    bounded = all(goals[name] == (name == "min_elbow_stiffness") for name in WORST if name in goals)
    states = len(problem.choices) * len(problem.conditions) * problem.states_per_design
    return problem.conditions.groups is not None and bounded and states > STATES_FOR_ALL


def part_of(problem: Problem, rows: Rows) -> Candidates:
    """Choices by their rows, solved, with the worst at the pretension of each or, if possible, of the relevant.

    The worst over a few conditions bounds the worst over all. With such bounds the relevant ones are chosen, worked
    out, and chosen again, until all of them are: no other is better than its bound, so these are the right ones.
    """
    if not leaves_out(problem):
        return of_rows(problem, rows)
    numbers, columns, goals = problem.choices.numbers(rows), problem.choices.columns(rows), goals_of(problem.study)
    solutions, served = without_worst(problem, numbers, len(rows))

    def of(chosen: Rows) -> dict[str, Array]:
        some = {key: values[chosen] for key, values in numbers.items()}
        return worst(problem, some, solutions.pretension[chosen], served[chosen])

    first = np.array([np.argmax(solutions.served)])
    reference = {key: values[first] for key, values in numbers.items()}
    few = severest(problem, reference, solutions.pretension[first], served[first], _SEVEREST)
    bounds = worst(problem.under(few), numbers, solutions.pretension, served[:, few])
    known = of(first)
    for name, values in bounds.items():
        if not np.isnan(known[name][0]):  # what is not asked for, as pressure without a strap, has no bound
            bounds[name] = np.where(np.isnan(values), _UNKNOWN[name], values)
    bounded = solutions.with_worst(slice(None), bounds, has_worst=False).with_worst(first, known)
    while len(rest := _missing(Candidates(rows, columns, bounded), goals)):
        bounded = bounded.with_worst(rest, of(rest))
    left, null = np.flatnonzero(~bounded.has_worst), np.asarray(np.nan)
    return Candidates(rows, columns, bounded.with_worst(left, dict.fromkeys(WORST, null), has_worst=False))


def _missing(candidates: Candidates, goals: tuple[Goal, ...]) -> Rows:
    """The relevant ones whose worst is not worked out."""
    rows = relevant(candidates, goals)
    return rows[~candidates.solutions.has_worst[rows]]
