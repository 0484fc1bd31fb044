"""Which limits leave no window: in how many choices each pair does, by how much, and what relaxing one would take."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from tendon_cli.answers.candidates import Candidates, numbers_of
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.solve import Solutions, solve
from tendon_cli.model.limits import LIMIT_NAMES, NOTHING

Pair = tuple[str, ...]
"""The limit that asks for more pretension and the one that asks for less; one alone that no pretension can keep."""

_STEPS = 200


@dataclass(frozen=True, eq=False)
class Conflict:
    """A pair of limits that leaves choices without a window."""

    limits: Pair
    choices: int
    """How many it does so."""
    nearest: Candidates
    """The one of these that is nearest to a window."""
    relaxed: dict[str, float | None]
    """To what value each limit of the pair must be relaxed, all else equal, for this one to have a window, SI; None
    where that does not help. Slack is no limit that could be relaxed."""

    @property
    def gap(self) -> float:
        """By how much the pretensions asked for miss each other, N."""
        return float((self.nearest.solutions.pretension_from - self.nearest.solutions.pretension_to)[0])


def pairs(solutions: Solutions) -> list[Pair]:
    """What leaves each choice without a window; empty for one that has one."""
    nothing: Pair = ()
    found = []
    shut = np.isnan(solutions.pretension_from)
    for is_open, is_shut, low, high in zip(
        solutions.feasible, shut, solutions.from_by, solutions.to_by, strict=True
    ):  # fmt: skip
        names = [LIMIT_NAMES[code] for code in ((low,) if is_shut else (low, high)) if code != NOTHING]
        found.append(nothing if is_open else tuple(dict.fromkeys(names)))
    return found


def counted(solutions: Solutions) -> Counter[Pair]:
    """How many choices each pair leaves without a window."""
    codes = np.column_stack([solutions.from_by, solutions.to_by, np.isnan(solutions.pretension_from)])
    kinds, first, counts = np.unique(
        codes[~solutions.feasible], axis=0, return_index=True, return_counts=True
    )  # fmt: skip
    shut = solutions.taken(np.flatnonzero(~solutions.feasible)[first]) if len(kinds) else solutions.taken(slice(0, 0))
    found: Counter[Pair] = Counter()
    for pair, count in zip(pairs(shut), counts.tolist(), strict=True):
        found[pair] += count
    return found


def nearest(candidates: Candidates) -> Candidates:
    """Of choices without a window the one nearest to have one: that serves most, and misses by the least share."""
    found = candidates.solutions
    low, high = found.pretension_from, found.pretension_to
    with np.errstate(invalid="ignore"):
        gap = (low - high) / (np.abs(low) + np.abs(high))
    order = np.lexsort((candidates.row, np.where(np.isnan(gap), np.inf, gap), -found.served))
    return candidates.taken(order[:1])


def conflict(problem: Problem, limits: Pair, choices: int, nearest: Candidates) -> Conflict:
    """A conflict with the least relaxation of each of its limits."""
    relaxed = {limit: relaxation(problem, nearest, limit) for limit in limits if limit in problem.bounds}
    return Conflict(limits, choices, nearest, relaxed)


def relaxation(problem: Problem, choice: Candidates, limit: str) -> float | None:
    """The value nearest to a limit's own at which a choice has a window, all else equal; None where none does."""
    numbers, own = numbers_of(problem, choice.columns), problem.limit(limit)
    outward = -1.0 if limit.startswith("min_") else 1.0

    def has_window(value: float) -> bool:
        return bool(solve(problem.relaxed(limit, value), numbers, 1, with_worst=False).feasible[0])

    if not has_window(outward * np.inf):
        return None
    shut, step = own, max(abs(own), 1e-3)
    while not has_window(own + outward * step):
        shut, step = own + outward * step, 2.0 * step
    opened = own + outward * step
    for _ in range(_STEPS):
        middle = 0.5 * (shut + opened)
        if middle in (shut, opened):
            break
        shut, opened = (shut, middle) if has_window(middle) else (middle, opened)
    return opened
