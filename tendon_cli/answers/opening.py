"""Whether one choice has a window with other numbers: under few conditions first, under all where these allow it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_cli.answers.candidates import Candidates, numbers_of
from tendon_cli.answers.coverage import ROUNDING
from tendon_cli.answers.factors import Numbers
from tendon_cli.answers.problem import Flags, Problem, Rows
from tendon_cli.answers.solve import Solutions, solve
from tendon_cli.model.kinematics import Array

_MOST = 1_000_000
"""Work of one choice under all conditions for which changes are tried; of more, some conditions stand for all."""
_OF_MOTOR = 50
"""States that take as long as one does with limits on the motor."""
_AT_ONCE = 200_000
"""Work of the choices that are tried together, where the first that has a window is wanted."""
_FEW = 8
_STAGED = 64
"""Groups of conditions from which on some are tried before the others."""


def work(problem: Problem) -> int:
    """How long one choice takes under all conditions, in states."""
    return len(problem.conditions) * problem.states_per_design * (_OF_MOTOR if problem.bounds.of_motion else 1)


def sampled(problem: Problem, choice: Candidates) -> Problem:
    """The same question under as many of its persons, draws or conditions as changes can be tried for.

    They are drawn at random, but for those that bind the choice.
    """
    groups = len(problem.weighting)
    most = max(_FEW, groups * _MOST // work(problem))
    if most >= groups:
        return problem
    order = _order(problem, choice)
    return problem.of_groups(np.sort(order[:most]))


def _order(problem: Problem, choice: Candidates) -> Rows:
    """All groups of conditions, at random, but first those that bind a choice."""
    solutions = choice.solutions
    ends = np.array([solutions.from_condition[0], solutions.to_condition[0]])
    binding = np.unique(problem.groups[np.minimum(ends, len(problem.groups) - 1)])
    order = np.random.default_rng(1).permutation(len(problem.weighting))
    return np.concatenate([binding, order[~np.isin(order, binding)]])


@dataclass(frozen=True, eq=False)
class Opening:
    """Tries other numbers on one choice of a question."""

    problem: Problem
    numbers: Numbers
    """Of the choice, (1,) each."""
    stages: tuple[tuple[Problem, float], ...]
    """The question for some persons, and their share of the weighting; last for all."""

    @classmethod
    def of(cls, problem: Problem, choice: Candidates) -> Opening:
        """Of a choice, whose binding conditions come first where all must be served."""
        order, groups = _order(problem, choice), len(problem.weighting)
        sizes = [groups // 8, groups // 2] if groups >= _STAGED else []
        if problem.enough >= 1.0 and groups > _FEW:
            sizes = [2, *sizes[:1]]
        total, stages = problem.weighting.sum(), []
        for size in sizes:
            some = np.sort(order[:size])
            stages.append((problem.of_groups(some), float(problem.weighting[some].sum() / total)))
        return cls(problem, numbers_of(problem, choice.columns), (*stages, (problem, 1.0)))

    def tried(self, keys: tuple[str, ...], values: Array) -> Flags:
        """Which values of some numbers, (points, keys), all else as it is, give a window."""
        is_open, _ = self._staged(keys, values, at_once=len(values))
        return is_open

    def first(self, keys: tuple[str, ...], values: Array) -> tuple[int | None, int]:
        """The first of some values that gives a window, and where there is none, the one that is nearest to do so."""
        is_open, nearness = self._staged(keys, values, at_once=max(1, _AT_ONCE // work(self.problem)))
        return int(np.argmax(is_open)) if is_open.any() else None, int(np.argmax(nearness))

    def _staged(self, keys: tuple[str, ...], values: Array, at_once: int) -> tuple[Flags, Rows]:
        """Whether points give a window, in their order until `at_once` points have one among them; and their ranks."""
        reached, width = np.zeros(len(values), dtype=np.int64), np.full(len(values), -np.inf)
        left, is_open = np.arange(len(values)), np.zeros(len(values), dtype=np.bool_)
        for stage, (problem, share) in enumerate(self.stages):
            is_last = problem is self.problem
            step = at_once if is_last else len(left)
            hopeful = left[:0]
            for at in range(0, len(left), max(1, step)):
                some = left[at : at + step]
                found = self._solved(problem, keys, values[some])
                reached[some], width[some] = stage, _width(problem, found)
                # Whoever is not among those tried here may be served; were even that not enough, all is known.
                at_most = np.where(found.feasible, 1.0, found.served * share + 1.0 - share)
                hopeful = np.concatenate([hopeful, some[found.feasible if is_last else at_most >= self._enough]])
                if is_last and len(hopeful):
                    break
            left = hopeful
        is_open[left] = True
        order = np.lexsort((width, reached))
        return is_open, np.argsort(order)

    @property
    def _enough(self) -> float:
        return self.problem.enough - ROUNDING

    def _solved(self, problem: Problem, keys: tuple[str, ...], values: Array) -> Solutions:
        changed = {key: np.repeat(value, len(values)) for key, value in self.numbers.items()}
        changed |= dict(zip(keys, values.T, strict=True))
        return solve(problem, changed, len(values), with_worst=False)


def _width(problem: Problem, found: Solutions) -> Array:
    """How far a window is open, N, or where a share is asked for, by how much more than enough is served."""
    if problem.enough < 1.0:
        return found.served - problem.enough
    with np.errstate(invalid="ignore"):
        width = found.pretension_to - found.pretension_from
    return np.where(np.isnan(width), -np.inf, width)
