"""The record of an answer: the best choices and their limits, or the conflicts and what helps."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from tendon_cli.answers import candidates
from tendon_cli.answers.between_samples import METHOD, curves_of, scope
from tendon_cli.answers.candidates import LimitPair
from tendon_cli.answers.fixes import fixes, sampled
from tendon_cli.answers.problem import Problem, rows_to_prove
from tendon_cli.answers.proofs import Proofs, ProvedChoice
from tendon_cli.answers.question import Goal, goals_of
from tendon_cli.answers.relax import relaxations
from tendon_cli.answers.sensitivity import sensitivities
from tendon_cli.answers.setup import bench_record
from tendon_cli.answers.solve import Solutions, solve_rows
from tendon_cli.answers.tables import as_records, choice_columns, choice_rows
from tendon_cli.engine.task import Note
from tendon_cli.model.window import Ends
from tendon_cli.space.axis import evenly_spaced
from tendon_cli.tables.schema import finite_or_none

_REFINED_ON_FRONT = 24
"""Most choices of a front that are refined between the points of the grid."""


@dataclass(eq=False)
class NamedChoices:
    """Choices that an answer names, with their windows proved."""

    problem: Problem
    goals: tuple[Goal, ...]
    """Goals of the study; none if it leaves them open."""
    best: dict[str, Solutions] = field(default_factory=dict)
    """Best choice by each goal's column; the best compromise of a front under an empty name."""
    gains: dict[str, float] = field(default_factory=dict)
    """Share of its score by which a refined choice beats the best of the grid, by goal's column."""
    front: Solutions | None = None
    """Choices that no other beats, in the order of the first goal; None without several goals."""
    given_up: float | None = None
    """Largest share of the span of any goal on the front that the best compromise gives up."""
    places: dict[tuple[Any, ...], int] = field(default_factory=dict)
    """Order of choices between the points of the grid in the table, by their values."""

    @classmethod
    def of(cls, problem: Problem, choices: Solutions) -> NamedChoices:
        """Return the best of some choices, refined between the points of the grid if possible."""
        named = cls(problem, goals_of(problem.study))
        feasible = choices.select(choices["feasible"])
        if not len(feasible):
            return named
        for goal in problem.goals:
            scores = feasible.scores((goal,))[:, 0]
            start = feasible.select([candidates.best_of(feasible, scores)])
            best = candidates.refine_choice(problem, (goal,), start) or start
            before = start.scores((goal,)).item()
            after = best.scores((goal,)).item()
            named.best[goal.column] = best
            if after != before and before:
                named.gains[goal.column] = (after - before) / abs(before)
        if len(named.goals) > 1:
            on_front = _front(problem, named.goals, feasible, list(named.best.values()))
            named.front = named.with_rows(on_front)
            scores = named.front.scores(named.goals)
            named.best = {"": named.front.select([candidates.compromise(scores)])}
            named.given_up = float(candidates.losses(scores).max(axis=1).min())
        named.best = {column: named.with_rows(choice) for column, choice in named.best.items()}
        return named

    def with_rows(self, choices: Solutions) -> Solutions:
        """Give choices without a row one after the rows of the grid; equal choices share theirs."""
        rows = choices.row.copy()
        for place in np.flatnonzero(rows < 0):
            values = tuple(column[place].item() for column in choices.columns.values())
            after_grid = self.places.setdefault(values, len(self.places))
            rows[place] = len(self.problem.choices) + after_grid
        return replace(choices, row=rows)

    def prove(self, proofs: Proofs) -> None:
        """Prove the windows of all choices, beginning with the one that is named first."""
        self.best = {column: proofs.prove(choice) for column, choice in self.best.items()}
        if self.front is not None:
            self.front = proofs.prove(self.front)

    def records(self, choices: Solutions) -> list[dict[str, Any]]:
        """Return choices as rows of the table for JSON, each with its row number as `choice`."""
        is_refined = choices.row >= len(self.problem.choices)
        on_front = np.full(len(choices), self.front is not None or len(self.goals) == 1)
        rows = choice_rows(self.problem, choices, is_refined, on_front)
        records = as_records(choice_columns(self.problem), rows)
        return [
            {"choice": number, **record}
            for number, record in zip(choices.row.tolist(), records, strict=True)
        ]


def _front(
    problem: Problem, goals: tuple[Goal, ...], feasible: Solutions, bests: list[Solutions]
) -> Solutions:
    """Return the front, its choices refined between the points of the grid if possible.

    Args:
        problem: The question.
        goals: Goals of the study, at least two.
        feasible: Choices of the grid with a window.
        bests: The best choice by each goal.
    """

    def front_of(choices: Solutions) -> Solutions:
        """Select the front, in the order of the first goal."""
        unbeaten = choices.select(candidates.front(choices.scores(goals)))
        return unbeaten.select(np.argsort(-unbeaten.scores(goals)[:, 0], kind="stable"))

    on_front = front_of(feasible)
    count = len(on_front)
    if count > _REFINED_ON_FRONT and any(axis.is_range for axis in problem.choices.axes):
        on_front = on_front.select(evenly_spaced(count, _REFINED_ON_FRONT))
    choices = []
    for place in range(len(on_front)):
        choice = on_front.select([place])
        choices.append(candidates.refine_choice(problem, goals, choice) or choice)
    return front_of(Solutions.concatenate(choices + bests))


def make_record(
    problem: Problem, notes: Sequence[Note]
) -> tuple[dict[str, Any], Solutions, dict[str, Any]]:
    """Make the record of an answer.

    Choices that may matter are solved again, since the notes have only their rows. A choice that
    seems to have a window may lose it by the proof: then the best are chosen again without it.

    Args:
        problem: The question.
        notes: Notes of all parts.

    Returns:
        The record; the choice that is named first, or else the one that serves most; its row in
        the table.
    """
    to_prove = rows_to_prove(problem)
    relevant_rows = [row for note in notes for row in note["rows"]]
    relevant = solve_rows(problem, np.unique([*relevant_rows, *to_prove.tolist()]))
    feasible = sum(note["feasible"] for note in notes)
    conflicts = Counter[LimitPair]()
    for note in notes:
        conflicts.update({tuple(names): count for names, count in note["conflicts"]})
    while True:
        named = NamedChoices.of(problem, relevant)
        proofs = Proofs(problem)
        named.prove(proofs)
        proved = None
        if len(to_prove):
            proved = proofs.prove(relevant.select(np.isin(relevant.row, to_prove)))
        lost = _lost_windows(relevant, proofs)
        if not lost:
            break
        is_unchanged = ~np.isin(relevant.row, [choice.row.item() for choice in lost])
        relevant = Solutions.concatenate([relevant.select(is_unchanged), *lost])
        feasible -= len(lost)
    chosen = next(iter(named.best.values()), None)
    between = None
    ends = None
    if chosen is not None:
        of_chosen = next(iter(proofs.done.values()))
        between = _between_samples(problem, chosen, of_chosen, proofs)
        ends = of_chosen.ends
    record = {
        "choices": sum(note["choices"] for note in notes),
        "conditions": len(problem.conditions),
        "feasible": feasible,
        "serve": problem.enough,
        **_best_record(problem, named, chosen, ends),
        "between_samples": between,
        "proved": [] if proved is None else named.records(proved),
        **_conflict_record(problem, named, relevant, conflicts, chosen),
        "population": None,
    }
    if chosen is None:
        chosen = relevant.select([int(np.argmax(relevant["served"]))])
    return record, chosen, named.records(chosen)[0]


def _lost_windows(relevant: Solutions, proofs: Proofs) -> list[Solutions]:
    """Return proved choices that have no window, although they seemed to have one before."""
    seemed_feasible = relevant.row[relevant["feasible"]]
    choices = [proved.choice for proved in proofs.done.values()]
    return [
        choice
        for choice in choices
        if not choice["feasible"].item() and choice.row.item() in seemed_feasible
    ]


def _between_samples(
    problem: Problem, chosen: Solutions, of_chosen: ProvedChoice, proofs: Proofs
) -> dict[str, Any]:
    """Return the record of all proofs, with the scope and curves of the choice named first."""
    of_each = [
        {"choice": proved.choice.row.item(), **asdict(proved.certificate)}
        for proved in proofs.done.values()
    ]
    return {
        **asdict(of_chosen.certificate),
        "choices": of_each,
        "method": METHOD,
        "scope": scope(problem),
        "curves": curves_of(problem, chosen, of_chosen.ends),
    }


# --- The record -----------------------------------------------------------------------------------


def _best_record(
    problem: Problem, named: NamedChoices, chosen: Solutions | None, ends: Ends | None
) -> dict[str, Any]:
    """Return the record of the best choices, and of the first of them on the bench, in SI."""
    best = {column: named.records(choice)[0] for column, choice in named.best.items()}
    return {
        "goals": [asdict(goal) for goal in named.goals],
        "best": next(iter(best.values()), None),
        "best_by": {} if named.goals else best,
        "given_up": named.given_up,
        "window_for_all": None if ends is None else _window_for_all(problem, ends),
        "gains": named.gains,
        "front": [] if named.front is None else named.records(named.front),
        **({} if chosen is None else bench_record(problem, chosen)),
        "sensitivities": [] if chosen is None else sensitivities(problem, chosen),
    }


def _window_for_all(problem: Problem, ends: Ends) -> list[float | None] | None:
    """Return the window that serves all, N; None if there is none, or if all must be served."""
    if problem.enough >= 1.0:
        return None
    low = float(ends.low.max())
    high = float(ends.high.min())
    if not low <= high:
        return None
    return [low, finite_or_none(high)]


def _conflict_record(
    problem: Problem,
    named: NamedChoices,
    relevant: Solutions,
    conflicts: Counter[LimitPair],
    chosen: Solutions | None,
) -> dict[str, Any]:
    """Return the record of conflicts, of fixes if no choice has a window, and of notes."""
    notes = [*problem.notes]
    if candidates.leaves_out(problem):
        notes.append(
            f"windows are worked out for all {len(problem.choices):,} choices, the worst values at"
            " their pretension only for those that may matter; they are null in the others"
        )
    record: dict[str, Any] = {"fixes": [], "would_take": [], "notes": notes}
    record["conflicts"] = [*_conflicts(named, relevant, conflicts)]
    if chosen is None:
        closest = candidates.nearest(relevant)
        tried = sampled(problem, closest)
        if len(tried.weighting) < len(problem.weighting):
            share = f"{len(tried.weighting):,} of the {len(problem.weighting):,} {problem.counted}"
            notes.append(
                f"what would help is worked out for {share}: those that bind, and others at random"
            )
        limits = {limit for pair in conflicts for limit in pair}
        record["fixes"] = fixes(tried, closest)
        record["would_take"] = relaxations(problem, limits)
    return record


def _conflicts(
    named: NamedChoices, relevant: Solutions, conflicts: Counter[LimitPair]
) -> Iterator[dict[str, Any]]:
    """Yield the limits that leave choices without a window, the most frequent conflict first.

    `gap` is the distance between the pretensions asked for, N, in the choice that is nearest to a
    window; null if there is no such distance.
    """
    rows_of_pairs = candidates.conflicts_of(relevant)
    for pair, count in conflicts.most_common():
        closest = candidates.nearest(relevant.select(rows_of_pairs[pair]))
        gap = closest.scalar("pretension_from") - closest.scalar("pretension_to")
        yield {
            "limits": list(pair),
            "choices": count,
            "gap": finite_or_none(gap),
            "nearest": named.records(closest)[0],
        }


def named_rows(record: Mapping[str, Any]) -> tuple[dict[int, dict[str, Any]], list[dict[str, Any]]]:
    """Return the choices that a record names.

    Returns:
        Those of the grid by their rows in the table, ascending, and those between its points,
        which follow all others in the table, in this order.
    """
    rows = [*record["proved"]]
    if record["best"]:
        rows.append(record["best"])
    rows += [*record["best_by"].values(), *record["front"]]
    named = {row["choice"]: row for row in rows}
    of_grid = {choice: named[choice] for choice in sorted(named) if choice < record["choices"]}
    refined = [named[choice] for choice in sorted(named) if choice >= record["choices"]]
    return of_grid, refined
