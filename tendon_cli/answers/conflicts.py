"""Which limits leave no window: in how many choices each pair does, by how much, and what relaxing one would take."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_cli.answers.candidates import Candidates, Pair, numbers_of
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.solve import solve

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


def conflict(problem: Problem, limits: Pair, choices: int, nearest: Candidates) -> Conflict:
    """A conflict with the least relaxation of each of its limits."""
    relaxed = {limit: relaxation(problem, nearest, limit) for limit in limits if limit in problem.bounds}
    return Conflict(limits, choices, nearest, relaxed)


def relaxation(problem: Problem, choice: Candidates, limit: str) -> float | None:
    """The value of a limit nearest to the one asked for at which a choice has a window, all else equal, or None."""
    numbers, start = numbers_of(problem, choice.columns), problem.limit(limit)
    outward = -1.0 if limit.startswith("min_") else 1.0

    def has_window(value: float) -> bool:
        return bool(solve(problem.relaxed(limit, value), numbers, 1, with_worst=False).feasible[0])

    if not has_window(outward * np.inf):
        return None
    empty, step = start, max(abs(start), 1e-3)
    while not has_window(start + outward * step):
        empty, step = start + outward * step, 2.0 * step
    opened = start + outward * step
    for _ in range(_STEPS):
        middle = 0.5 * (empty + opened)
        if middle in (empty, opened):
            break
        empty, opened = (empty, middle) if has_window(middle) else (middle, opened)
    return opened
