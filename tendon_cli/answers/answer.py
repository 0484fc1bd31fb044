"""The answer to a design question: what is best, what binds it, and if nothing suits, why and what would help."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace

import numpy as np

from tendon_cli.answers.candidates import (
    Candidates,
    Pair,
    best_of,
    counted,
    leaves_out,
    nearest,
    numbers_of,
    pairs,
    relevant,
)  # fmt: skip
from tendon_cli.answers.conflicts import Conflict, conflict
from tendon_cli.answers.fixes import Fix, fixes, sampled
from tendon_cli.answers.front import SERVED, USUAL, Goal, compromise, front, goals_of
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.refine import refined
from tendon_cli.answers.sensitivity import Sensitivity, sensitivities

_REFINED_ON_FRONT = 24


@dataclass(frozen=True, eq=False)
class Summary:
    """What is known of all choices: counts, and the few that may matter; parts of it can be added up."""

    choices: int
    feasible: int
    conflicts: Counter[Pair]
    relevant: Candidates
    """The best by each goal, those that may be on the front, and the nearest that each pair of limits leaves without
    a window."""

    def __add__(self, other: Summary) -> Summary:
        relevant = Candidates.joined([self.relevant, other.relevant])
        return Summary(
            self.choices + other.choices, self.feasible + other.feasible, self.conflicts + other.conflicts, relevant
        )


@dataclass(frozen=True, eq=False)
class Findings:
    """An answer in the terms of the question, from which `record` is made."""

    problem: Problem
    goals: tuple[Goal, ...]
    """None if the study leaves them open."""
    summary: Summary
    best: dict[str, Candidates]
    """The best choice by each goal's column; if several goals make a front, its best compromise under an empty name."""
    gains: dict[str, float]
    """By what share of its score a refined choice beats the best of the grid, by goal's column."""
    front: Candidates | None
    """Choices that no other beats, if there are several goals; in the order of the first goal."""
    between: Candidates
    """Choices between the points of the grid that are among the best or on the front."""
    conflicts: tuple[Conflict, ...] = ()
    """Most frequent first."""
    fixes: tuple[Fix, ...] = ()
    """Of the choice that is nearest to have a window, if none has."""
    sensitivities: tuple[Sensitivity, ...] = ()
    """Of the window of the best choice."""
    window_for_all: tuple[float, float] | None = None
    """The interval of the best choice in which all are served, N, if the question asks for a share."""
    notes: list[str] = field(default_factory=list)

    @property
    def most_universal(self) -> Candidates:
        """The choice to be named first, or if none has a window the one that serves most."""
        relevant = self.summary.relevant
        return self.chosen or relevant.taken(np.array([np.argmax(relevant.solutions.served)]))

    @property
    def chosen(self) -> Candidates | None:
        """The choice to be named first; None if none has a window."""
        return next(iter(self.best.values()), None)


def summarise(candidates: Candidates, goals: tuple[Goal, ...]) -> Summary:
    """What matters of some choices."""
    solutions = candidates.solutions
    kept = candidates.taken(relevant(candidates, goals))
    return Summary(len(candidates), int(solutions.feasible.sum()), counted(solutions), kept)


def goals_or_usual(problem: Problem) -> tuple[Goal, ...]:
    """The goals of a study, or if it leaves them open those by each of which an answer names the best."""
    usual = USUAL if problem.conditions.groups is None else (SERVED, *USUAL)
    return goals_of(problem.study) or usual


def findings(problem: Problem, summary: Summary) -> Findings:
    """The answer, from the summary of all choices."""
    goals, kept, notes = goals_of(problem.study), summary.relevant, [*problem.notes]
    if leaves_out(problem):
        notes.append(
            f"all {summary.choices:,} choices have their window; the worst values at their pretension are worked out"
            " for those that may matter, and are null in the others"
        )
    feasible = kept.taken(kept.solutions.feasible)
    none = kept.taken(np.zeros(len(kept), dtype=np.bool_))
    if not len(feasible):
        return _explained(Findings(problem, goals, summary, {}, {}, None, none, notes=notes))
    single = {goal.column: _best(problem, goal, feasible) for goal in goals_or_usual(problem)}
    gains = {column: gain for column, (_, gain) in single.items() if gain}
    bests, on_front = {column: one for column, (one, _) in single.items()}, None
    if len(goals) > 1:
        on_front = _front(problem, goals, feasible, list(bests.values()))
        bests = {"": on_front.taken(np.array([compromise(on_front.scores(goals))]))}
    named = [*bests.values()] if on_front is None else [on_front]
    between = _distinct(Candidates.joined([one.taken(one.row < 0) for one in named]))
    return _explained(Findings(problem, goals, summary, bests, gains, on_front, between, notes=notes))


def _best(problem: Problem, goal: Goal, feasible: Candidates) -> tuple[Candidates, float]:
    """The best by one goal, between the points of the grid, too, and by what share it beats the grid's."""
    start = feasible.taken(np.array([best_of(feasible, feasible.scores((goal,))[:, 0])]))
    better = refined(problem, (goal,), start)
    if better is None:
        return start, 0.0
    before, after = start.scores((goal,)).item(), better.scores((goal,)).item()
    return better, (after - before) / abs(before) if before else 0.0


def _front(problem: Problem, goals: tuple[Goal, ...], feasible: Candidates, bests: list[Candidates]) -> Candidates:
    """The front, each of its choices made better between the points of the grid if that is possible."""
    on_front = feasible.taken(front(feasible.scores(goals)))
    on_front = on_front.taken(np.argsort(-on_front.scores(goals)[:, 0], kind="stable"))
    if len(on_front) > _REFINED_ON_FRONT and any(factor.is_range for factor in problem.choices.axes):
        on_front = on_front.taken(np.linspace(0, len(on_front) - 1, _REFINED_ON_FRONT).round().astype(np.int64))
    ones = [on_front.taken(np.array([at])) for at in range(len(on_front))]
    whole = Candidates.joined([refined(problem, goals, one) or one for one in ones] + bests)
    whole = whole.taken(front(whole.scores(goals)))
    return whole.taken(np.argsort(-whole.scores(goals)[:, 0], kind="stable"))


def _distinct(candidates: Candidates) -> Candidates:
    """Each place once."""
    if not candidates.columns or not len(candidates):
        return candidates
    places = np.column_stack([np.asarray(values, dtype=np.float64) for values in candidates.columns.values()])
    _, first = np.unique(places, axis=0, return_index=True)
    return candidates.taken(np.sort(first))


def _window_for_all(problem: Problem, choice: Candidates) -> tuple[float, float] | None:
    """The interval in which a choice serves all; None if there is none, or if all is what is asked for."""
    ends = problem.ends(numbers_of(problem, choice.columns), 1)
    low, high = float(ends.low.max()), float(ends.high.min())
    return (low, high) if problem.enough < 1.0 and low <= high else None


def _explained(answer: Findings) -> Findings:
    """With conflicts, and with sensitivities of the best or, if there is none, with fixes."""
    problem, kept = answer.problem, answer.summary.relevant
    infeasible = kept.taken(~kept.solutions.feasible)
    conflicts = []
    named = pairs(infeasible.solutions)
    for pair, count in answer.summary.conflicts.most_common():
        rows = np.array([at for at, other in enumerate(named) if other == pair])
        conflicts.append(conflict(problem, pair, count, nearest(infeasible.taken(rows))))
    answer = replace(answer, conflicts=tuple(conflicts))
    if answer.chosen is not None:
        moves = tuple(sensitivities(problem, answer.chosen))
        return replace(answer, sensitivities=moves, window_for_all=_window_for_all(problem, answer.chosen))
    closest = nearest(infeasible)
    some = sampled(problem, closest)
    if len(some.weighting) < len(problem.weighting):
        of_all = f"{len(some.weighting):,} of the {len(problem.weighting):,} {problem.counted}"
        answer.notes.append(f"what would help is worked out for {of_all}: those that bind, and others at random")
    return replace(answer, fixes=tuple(fixes(some, closest)))
