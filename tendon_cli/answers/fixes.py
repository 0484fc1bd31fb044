"""What would give a choice without a window one: for each parameter that a designer can change the least change."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tendon_cli import say
from tendon_cli.answers.candidates import Candidates, numbers_of
from tendon_cli.answers.coverage import ROUNDING
from tendon_cli.answers.problem import Flags, Problem
from tendon_cli.answers.solve import WORST, Solutions, solve
from tendon_cli.model.kinematics import Array
from tendon_cli.space.axis import Numbers, Rows
from tendon_cli.studies.study import keys
from tendon_cli.units import parse_measure

PARAMETERS = {
    "spring.stiffness": (200.0, 5e4),
    "spool.ratio": (0.3, 2.0),
    "spool.flexor_radius": (0.01, 0.08),
    "arm.elbow_radius": (0.02, 0.1),
    "sheath.friction": (0.005, 0.3),
    "sheath.bend_angle": (0.2, 12.0),
    "arm.a1": (0.005, 0.1),
    "arm.b1": (0.05, 0.3),
    "arm.a2": (0.002, 0.08),
    "arm.b2": (0.05, 0.25),
    "tendon.length": (0.2, 5.0),
    "tendon.diameter": (4e-4, 4e-3),
}
"""What a designer can change, and between which values that is plausible, SI."""

_POINTS = 65
_SECTIONS = 16
_ROUNDS = 14
_HALVINGS = 52
_SMALL = 20_000
"""Work of a choice from which on values are tried one by one."""
_MOST = 1_000_000
"""Work of one choice under all conditions for which changes are tried; beyond it, some conditions stand for all."""
_OF_MOTOR = 50
"""States that take as long as one does with limits on the motor."""
_AT_ONCE = 200_000
"""Work of the choices that are tried together if the first that has a window is wanted."""
_FEW = 8
_STAGED = 64
"""Groups of conditions from which on some are tried before the others."""


@dataclass(frozen=True)
class Fix:
    """The least change of one parameter that opens a window."""

    parameter: str
    before: float
    """SI."""
    after: float | None
    """SI; None if no value within the plausible range does."""
    plausible: tuple[float, float]
    pretension: float = np.nan
    """The one that then suits, N."""
    costs: dict[str, float] | None = None
    """The worst of every quantity at it, over all conditions."""
    printed: str = ""
    """A value as a study can have it, rounded so that it opens a window, too."""
    printed_pretension: str = ""
    """One of that window, in N."""

    @property
    def size(self) -> float:
        """How large the change is: the logarithm of the factor."""
        return np.inf if self.after is None else float(abs(np.log(self.after / self.before)))


def fixes(problem: Problem, choice: Candidates) -> list[Fix]:
    """What each parameter alone does for one choice, the least change first."""
    trials = Trials.of(problem, choice)
    before = {key: value for key in PARAMETERS if 0.0 < (value := _now(problem, trials.numbers, key)) < np.inf}
    return sorted((_fix(trials, key, value) for key, value in before.items()), key=lambda fix: fix.size)


def work(problem: Problem) -> int:
    """How long one choice takes under all conditions, in states."""
    return len(problem.conditions) * problem.states_per_design * (_OF_MOTOR if problem.bounds.of_motion else 1)


def sampled(problem: Problem, choice: Candidates) -> Problem:
    """The same question under as many of its persons, draws or conditions as changes can be tried for.

    They are drawn at random, but for those that bind the choice.
    """
    groups = len(problem.weighting)
    most = max(_FEW, groups * _MOST // work(problem))
    return problem if most >= groups else problem.of_groups(np.sort(_order(problem, choice)[:most]))


def _order(problem: Problem, choice: Candidates) -> Rows:
    """All groups of conditions, at random, but first those that bind a choice."""
    solutions = choice.solutions
    ends = np.array([solutions.from_condition[0], solutions.to_condition[0]])
    binding = np.unique(problem.groups[np.minimum(ends, len(problem.groups) - 1)])
    order = np.random.default_rng(1).permutation(len(problem.weighting))
    return np.concatenate([binding, order[~np.isin(order, binding)]])


def _now(problem: Problem, numbers: Numbers, key: str) -> float:
    """A parameter's value in a choice; NaN if it differs between conditions or sides."""
    space = problem.points(numbers, problem.condition_numbers)
    if key in problem.condition_numbers or key in space.of_sides:
        return np.nan
    return float(np.asarray(replace(space.number(key), scales=()).within(space.whole)).item())


def _fix(trials: Trials, key: str, before: float) -> Fix:
    low, high = PARAMETERS[key]
    ends = [end for end in (low, high) if (end - before) * (end - low - (high - end)) > 0.0]
    values = [value for end in ends if (value := _nearest(trials, key, before, end)) is not None]
    if not values:
        return Fix(key, before, None, (low, high))
    after = min(values, key=lambda value: abs(np.log(value / before)))
    solutions = solve(trials.problem, {**trials.numbers, key: np.array([after])}, 1)
    costs = {name: float(solutions.column(name)[0]) for name in WORST}
    printed = _printed(trials, key, before, after)
    return Fix(key, before, after, (low, high), float(solutions.pretension[0]), costs, *printed)


def _printed(trials: Trials, key: str, before: float, after: float) -> tuple[str, str]:
    """The shortest text of a value beyond `after` that opens a window when it is typed in, and a pretension in it."""
    of, toward = keys()[key].number.quantity, np.inf if after > before else -np.inf
    for digits in range(3, 16):
        text = say.quantity(of, after, digits, toward=toward)
        value = parse_measure(text.replace(",", ""), of.dimension).si
        solutions = solve(trials.problem, {**trials.numbers, key: np.array([value])}, 1, with_worst=False)
        if solutions.feasible[0]:
            low, high = float(solutions.pretension_from[0]), float(solutions.pretension_to[0])
            return text, say.within(float(solutions.pretension[0]), low, high, digits=3)
    return repr(after), ""


def _nearest(trials: Trials, key: str, before: float, end: float) -> float | None:
    """The value nearest to `before`, on the way to `end`, that opens a window."""
    values = np.geomspace(before, end, _POINTS)
    first, nearest = trials.first(key, values)
    for _ in range(4):  # between three values, where a narrow window may hide: around the nearest to have one
        if first is not None:
            break
        values = np.geomspace(values[max(nearest - 1, 0)], values[min(nearest + 1, len(values) - 1)], _SECTIONS)
        first, nearest = trials.first(key, values)
    if first is None:
        return None
    return float(values[0]) if first == 0 else _edge(trials, key, values[first - 1], values[first])


def _edge(trials: Trials, key: str, empty: float, open_: float) -> float:
    """Where a window opens between two values; the last that has one."""
    # Many small questions are faster asked together, large ones one by one.
    sections, rounds = (_SECTIONS, _ROUNDS) if work(trials.problem) <= _SMALL else (3, _HALVINGS)
    for _ in range(rounds):
        values = np.linspace(empty, open_, sections)
        values[-1] = open_
        first, _ = trials.first(key, values[1:-1])
        first = sections - 1 if first is None else first + 1
        if (empty, open_) == (values[first - 1], values[first]):
            break
        empty, open_ = float(values[first - 1]), float(values[first])
    return open_


@dataclass(frozen=True, eq=False)
class Trials:
    """Tries other values of a parameter on one choice: under few conditions first, under all if these allow it."""

    problem: Problem
    numbers: Numbers
    """Of the choice, (1,) each."""
    stages: tuple[tuple[Problem, float], ...]
    """The question for some persons, and their share of the weighting; last for all."""

    @classmethod
    def of(cls, problem: Problem, choice: Candidates) -> Trials:
        """Of a choice, whose binding conditions come first if all must be served."""
        order, groups = _order(problem, choice), len(problem.weighting)
        sizes = [groups // 8, groups // 2] if groups >= _STAGED else []
        if problem.enough >= 1.0 and groups > _FEW:
            sizes = [2, *sizes[:1]]
        total, stages = problem.weighting.sum(), []
        for size in sizes:
            some = np.sort(order[:size])
            stages.append((problem.of_groups(some), float(problem.weighting[some].sum() / total)))
        return cls(problem, numbers_of(problem, choice.columns), (*stages, (problem, 1.0)))

    def first(self, key: str, values: Array) -> tuple[int | None, int]:
        """The first of some values that gives a window, and if there is none, the one that is nearest to do so."""
        is_open, nearness = self.tried(key, values, at_once=max(1, _AT_ONCE // work(self.problem)))
        return int(np.argmax(is_open)) if is_open.any() else None, int(np.argmax(nearness))

    def tried(self, key: str, values: Array, at_once: int) -> tuple[Flags, Rows]:
        """Whether values give a window, in their order until `at_once` have one among them; and their ranks."""
        reached, width = np.zeros(len(values), dtype=np.int64), np.full(len(values), -np.inf)
        left, is_open = np.arange(len(values)), np.zeros(len(values), dtype=np.bool_)
        for stage, (problem, share) in enumerate(self.stages):
            is_last = stage == len(self.stages) - 1
            step = at_once if is_last else len(left)
            hopeful = left[:0]
            for at in range(0, len(left), max(1, step)):
                some = left[at : at + step]
                solutions = self._solved(problem, key, values[some])
                reached[some], width[some] = stage, _width(problem, solutions)
                # Whoever is not among those tried here may be served; if even that is not enough, all is known.
                at_most = np.where(solutions.feasible, 1.0, solutions.served * share + 1.0 - share)
                passed = solutions.feasible if is_last else at_most >= self.problem.enough - ROUNDING
                hopeful = np.concatenate([hopeful, some[passed]])
                if is_last and len(hopeful):
                    break
            left = hopeful
        is_open[left] = True
        order = np.lexsort((width, reached))
        return is_open, np.argsort(order)

    def _solved(self, problem: Problem, key: str, values: Array) -> Solutions:
        changed = {name: np.repeat(value, len(values)) for name, value in self.numbers.items()}
        return solve(problem, changed | {key: values}, len(values), with_worst=False)


def _width(problem: Problem, solutions: Solutions) -> Array:
    """How far a window is open, N; if a share is asked for, by how much more than enough is served."""
    if problem.enough < 1.0:
        return solutions.served - problem.enough
    with np.errstate(invalid="ignore"):
        width = solutions.pretension_to - solutions.pretension_from
    return np.where(np.isnan(width), -np.inf, width)
