"""The answer to a design question: what is best, what binds it, and where nothing suits, why and what would help."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from tendon_cli.answers.candidates import Candidates
from tendon_cli.answers.conflicts import Conflict, Pair, conflict, counted, nearest, pairs
from tendon_cli.answers.fixes import WORK_FOR_PAIRS, Fix, fixes
from tendon_cli.answers.opening import sampled, work
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.promising import best_of, leaves_out, promising
from tendon_cli.answers.rank import SERVED, USUAL, Goal, front, goals_of, knee
from tendon_cli.answers.search import refined
from tendon_cli.answers.sensitivity import Sensitivity, sensitivities

_REFINED_ON_FRONT = 24


@dataclass(frozen=True, eq=False)
class Gathered:
    """What is known of all choices: counts, and the few that may matter; parts of it can be added up."""

    choices: int
    feasible: int
    conflicts: Counter[Pair]
    promising: Candidates
    """The best by each goal, those that may be on the front, and the nearest that each pair of limits leaves without
    a window."""

    def __add__(self, other: Gathered) -> Gathered:
        promising = Candidates.joined([self.promising, other.promising])
        return Gathered(
            self.choices + other.choices, self.feasible + other.feasible, self.conflicts + other.conflicts, promising
        )


@dataclass(frozen=True, eq=False)
class Findings:
    """An answer in the terms of the question; `record` and `text` tell it."""

    problem: Problem
    goals: tuple[Goal, ...]
    """None where the study leaves them open."""
    gathered: Gathered
    best: dict[str, Candidates]
    """The best choice by each goal's column; where several goals make a front, its knee under an empty name."""
    gains: dict[str, float]
    """By what share of its worth a refined choice beats the best of the grid, by goal's column."""
    front: Candidates | None
    """Choices that no other beats, where there are several goals; in the order of the first goal."""
    beside: Candidates
    """Choices between the points of the grid that are among the best or on the front."""
    conflicts: tuple[Conflict, ...] = ()
    """Most frequent first."""
    fixes: tuple[Fix, ...] = ()
    """Of the choice that is nearest to have a window, where none has."""
    sensitivities: tuple[Sensitivity, ...] = ()
    """Of the window of the best choice."""
    notes: list[str] = field(default_factory=list)

    @property
    def most_universal(self) -> Candidates:
        """The choice to be named first, or where none has a window the one that serves most."""
        served = self.gathered.promising.solutions.served
        return self.chosen or self.gathered.promising.taken(np.array([np.argmax(served)]))

    @property
    def chosen(self) -> Candidates | None:
        """The choice to be named first; None where none has a window."""
        return next(iter(self.best.values()), None)


def gather(candidates: Candidates, goals: tuple[Goal, ...]) -> Gathered:
    """What matters of some choices."""
    solutions = candidates.solutions
    kept = candidates.taken(promising(candidates, goals))
    return Gathered(len(candidates), int(solutions.feasible.sum()), counted(solutions), kept)


def sought(problem: Problem) -> tuple[Goal, ...]:
    """The goals by each of which the best is told."""
    usual = USUAL if problem.conditions.groups is None else (SERVED, *USUAL)
    return goals_of(problem.study) or usual


def findings(problem: Problem, gathered: Gathered) -> Findings:
    """The answer, from what was gathered of all choices."""
    goals, kept, notes = goals_of(problem.study), gathered.promising, [*problem.notes]
    if leaves_out(problem):
        said = "the worst at its pretension is worked out of the choices that are told here, and of a few more"
        notes.append(f"of {gathered.choices:,} choices all have their window; {said}")
    able = kept.taken(kept.solutions.feasible)
    nobody = kept.taken(np.zeros(len(kept), dtype=np.bool_))
    if not len(able):
        return _explained(Findings(problem, goals, gathered, {}, {}, None, nobody, notes=notes))
    single = {goal.column: _best(problem, goal, able) for goal in sought(problem)}
    gains = {column: gain for column, (_, gain) in single.items() if gain}
    bests, on_front = {column: one for column, (one, _) in single.items()}, None
    if len(goals) > 1:
        on_front = _front(problem, goals, able, list(bests.values()))
        bests = {"": on_front.taken(np.array([knee(on_front.worth(goals))]))}
    named = [*bests.values()] if on_front is None else [on_front]
    beside = _distinct(Candidates.joined([one.taken(one.row < 0) for one in named]))
    return _explained(Findings(problem, goals, gathered, bests, gains, on_front, beside, notes=notes))


def _best(problem: Problem, goal: Goal, able: Candidates) -> tuple[Candidates, float]:
    """The best by one goal, between the points of the grid, too, and by what share it beats the grid's."""
    start = able.taken(np.array([best_of(able, able.worth((goal,))[:, 0])]))
    better = refined(problem, (goal,), start)
    if better is None:
        return start, 0.0
    before, after = start.worth((goal,)).item(), better.worth((goal,)).item()
    return better, (after - before) / abs(before) if before else 0.0


def _front(problem: Problem, goals: tuple[Goal, ...], able: Candidates, bests: list[Candidates]) -> Candidates:
    """The front, each of its choices made better between the points of the grid where that is possible."""
    found = able.taken(front(able.worth(goals)))
    found = found.taken(np.argsort(-found.worth(goals)[:, 0], kind="stable"))
    if len(found) > _REFINED_ON_FRONT and any(factor.is_range for factor in problem.choices.factors):
        found = found.taken(np.linspace(0, len(found) - 1, _REFINED_ON_FRONT).round().astype(np.int64))
    ones = [found.taken(np.array([at])) for at in range(len(found))]
    whole = Candidates.joined([refined(problem, goals, one) or one for one in ones] + bests)
    whole = whole.taken(front(whole.worth(goals)))
    return whole.taken(np.argsort(-whole.worth(goals)[:, 0], kind="stable"))


def _distinct(candidates: Candidates) -> Candidates:
    """Each place once."""
    if not candidates.columns or not len(candidates):
        return candidates
    places = np.column_stack([np.asarray(values, dtype=np.float64) for values in candidates.columns.values()])
    _, first = np.unique(places, axis=0, return_index=True)
    return candidates.taken(np.sort(first))


def _explained(found: Findings) -> Findings:
    """With conflicts, and with sensitivities of the best or with fixes where there is none."""
    problem, kept = found.problem, found.gathered.promising
    shut = kept.taken(~kept.solutions.feasible)
    conflicts = []
    named = pairs(shut.solutions)
    for pair, count in found.gathered.conflicts.most_common():
        rows = np.array([at for at, other in enumerate(named) if other == pair])
        conflicts.append(conflict(problem, pair, count, nearest(shut.taken(rows))))
    if found.chosen is None:
        closest = nearest(shut)
        some = sampled(problem, closest)
        if some is not problem:
            of_all = f"{len(some.weighting):,} of the {len(problem.weighting):,} {problem.counted}"
            found.notes.append(f"what would fix it is worked out for {of_all}, those that bind and others at random")
        if work(some) > WORK_FOR_PAIRS:
            found.notes.append("changes of two numbers at once are not tried for so many conditions")
        return Findings(**{**vars(found), "conflicts": tuple(conflicts), "fixes": tuple(fixes(some, closest))})
    moves = tuple(sensitivities(problem, found.chosen))
    return Findings(**{**vars(found), "conflicts": tuple(conflicts), "sensitivities": moves})
