"""The record of an answer: what is best, what binds it, and if nothing suits, why and what would help."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from tendon_cli.answers import candidates
from tendon_cli.answers.between_samples import METHOD, curves_of, scope
from tendon_cli.answers.candidates import Pair
from tendon_cli.answers.fixes import fixes, sampled
from tendon_cli.answers.problem import Problem, rows_to_prove
from tendon_cli.answers.proofs import Proofs
from tendon_cli.answers.question import Goal, goals_of
from tendon_cli.answers.relax import relaxations
from tendon_cli.answers.sensitivity import sensitivities
from tendon_cli.answers.setup import bench_record
from tendon_cli.answers.solve import Solutions, of_rows
from tendon_cli.answers.tables import as_records, choice_columns, choice_rows
from tendon_cli.engine.task import Note
from tendon_cli.model.window import Ends

_REFINED_ON_FRONT = 24


@dataclass(eq=False)
class Named:
    """The choices that an answer names, with their windows proved."""

    problem: Problem
    goals: tuple[Goal, ...]  # of the study; none if it leaves them open
    best: dict[str, Solutions] = field(default_factory=dict)
    """The best choice by each goal's column; if several goals make a front, its best compromise under an empty name."""
    gains: dict[str, float] = field(default_factory=dict)
    """By what share of its score a refined choice beats the best of the grid, by goal's column."""
    front: Solutions | None = None
    """Choices that no other beats, if there are several goals; in the order of the first goal."""
    given_up: float | None = None
    """Of what the goals span on the front, the largest share that the best compromise gives up of any."""
    places: dict[tuple[Any, ...], int] = field(default_factory=dict)
    """Where those between the points of the grid stand in the table, after all others."""

    @classmethod
    def of(cls, problem: Problem, kept: Solutions) -> Named:
        """The best of some choices, which may be improved between the points of the grid."""
        named = cls(problem, goals_of(problem.study))
        feasible = kept.select(kept["feasible"])
        for goal in problem.goals if len(feasible) else ():
            start = feasible.select([candidates.best_of(feasible, feasible.scores((goal,))[:, 0])])
            named.best[goal.column] = candidates.refined(problem, (goal,), start) or start
            before, after = (one.scores((goal,)).item() for one in (start, named.best[goal.column]))
            if after != before and before:
                named.gains[goal.column] = (after - before) / abs(before)
        if len(named.goals) > 1 and len(feasible):
            named.front = named.numbered(
                _front(problem, named.goals, feasible, [*named.best.values()])
            )
            scores = named.front.scores(named.goals)
            named.best = {"": named.front.select([candidates.compromise(scores)])}
            named.given_up = float(candidates.losses(scores).max(axis=1).min())
        named.best = {column: named.numbered(one) for column, one in named.best.items()}
        return named

    def numbered(self, some: Solutions) -> Solutions:
        """Choices of which those between the points of the grid follow all others in the table, each place once."""
        rows = some.row.copy()
        for at in np.flatnonzero(rows < 0):
            place = tuple(values[at].item() for values in some.columns.values())
            rows[at] = len(self.problem.choices) + self.places.setdefault(place, len(self.places))
        return replace(some, row=rows)

    def prove(self, proofs: Proofs) -> None:
        """Prove the windows of all, those named first at first."""
        self.best = {column: proofs.prove(one) for column, one in self.best.items()}
        self.front = None if self.front is None else proofs.prove(self.front)

    def records(self, choices: Solutions) -> list[dict[str, Any]]:
        """Choices as rows of the table, with their numbers there."""
        is_refined = choices.row >= len(self.problem.choices)
        on_front = np.full(len(choices), self.front is not None or len(self.goals) == 1)
        rows = as_records(
            choice_columns(self.problem), choice_rows(self.problem, choices, is_refined, on_front)
        )
        return [
            {"choice": number, **row}
            for number, row in zip(choices.row.tolist(), rows, strict=True)
        ]


def _front(
    problem: Problem, goals: tuple[Goal, ...], feasible: Solutions, bests: list[Solutions]
) -> Solutions:
    """The front, each of its choices made better between the points of the grid if that is possible."""

    def ordered(some: Solutions) -> Solutions:
        some = some.select(candidates.front(some.scores(goals)))
        return some.select(np.argsort(-some.scores(goals)[:, 0], kind="stable"))

    on_front = ordered(feasible)
    if len(on_front) > _REFINED_ON_FRONT and any(axis.is_range for axis in problem.choices.axes):
        on_front = on_front.select(
            np.linspace(0, len(on_front) - 1, _REFINED_ON_FRONT).round().astype(np.int64)
        )
    ones = [on_front.select([at]) for at in range(len(on_front))]
    return ordered(
        Solutions.concatenate(
            [candidates.refined(problem, goals, one) or one for one in ones] + bests
        )
    )


def findings(
    problem: Problem, notes: Sequence[Note]
) -> tuple[dict[str, Any], Solutions, dict[str, Any]]:
    """The record of an answer, from the notes of all parts; the choice named first, or that serves most; its row.

    Choices that may matter are solved again, whoever solved them before. One that seems to have a window may lose it by
    the proof: then all begins anew with what that says.
    """
    asked = rows_to_prove(problem)
    kept = of_rows(
        problem, np.unique([*(row for note in notes for row in note["rows"]), *asked.tolist()])
    )
    counts, feasible = Counter[Pair](), sum(note["feasible"] for note in notes)
    for note in notes:
        counts.update({tuple(names): count for names, count in note["conflicts"]})
    while True:
        named, proofs = Named.of(problem, kept), Proofs(problem)
        named.prove(proofs)
        proved = proofs.prove(kept.select(np.isin(kept.row, asked))) if len(asked) else None
        seemed = kept.row[kept["feasible"]]
        lost = [
            proved_choice.choice
            for proved_choice in proofs.done.values()
            if not proved_choice.choice["feasible"].item()
            and proved_choice.choice.row.item() in seemed
        ]
        if not lost:
            break
        others = ~np.isin(kept.row, [one.row.item() for one in lost])
        kept, feasible = Solutions.concatenate([kept.select(others), *lost]), feasible - len(lost)
    chosen, between, ends = next(iter(named.best.values()), None), None, None
    if chosen is not None:
        first = next(iter(proofs.done.values()))
        certificate, ends = first.certificate, first.ends
        each = [
            {"choice": one.choice.row.item(), **asdict(one.certificate)}
            for one in proofs.done.values()
        ]
        of_all = {
            "method": METHOD,
            "scope": scope(problem),
            "curves": curves_of(problem, chosen, ends),
        }
        between = {**asdict(certificate), "choices": each, **of_all}
    record = {
        "choices": sum(note["choices"] for note in notes),
        "conditions": len(problem.conditions),
        "feasible": feasible,
        "serve": problem.enough,
        **_of_named(problem, named, chosen, ends),
        "between_samples": between,
        "proved": [] if proved is None else named.records(proved),
        **_of_none(problem, named, kept, counts, chosen),
        "population": None,
    }
    chosen = kept.select([int(np.argmax(kept["served"]))]) if chosen is None else chosen
    return record, chosen, named.records(chosen)[0]


# --- The record ------------------------------------------------------------------------------------------------------


def _of_named(
    problem: Problem, named: Named, chosen: Solutions | None, ends: Ends | None
) -> dict[str, Any]:
    """What is best, and what that is on the bench. SI values, null for what is not a number."""
    best = {column: named.records(one)[0] for column, one in named.best.items()}
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
    """The interval in which a choice serves all, N; None if there is none, or if all is what is asked for."""
    if problem.enough >= 1.0:
        return None
    low, high = float(ends.low.max()), float(ends.high.min())
    return [low, high if math.isfinite(high) else None] if low <= high else None


def _of_none(
    problem: Problem, named: Named, kept: Solutions, counts: Counter[Pair], chosen: Solutions | None
) -> dict[str, Any]:
    """What leaves choices without a window, and if it leaves all, what would help; notes."""
    notes = [*problem.notes]
    if candidates.leaves_out(problem):
        notes.append(
            f"all {len(problem.choices):,} choices have their window; the worst values at their pretension are worked"
            " out for those that may matter, and are null in the others"
        )
    record: dict[str, Any] = {"fixes": [], "would_take": [], "notes": notes}
    record["conflicts"] = [*_conflicts(named, kept, counts)]
    if chosen is None:
        some = sampled(problem, closest := candidates.nearest(kept))
        if len(some.weighting) < len(problem.weighting):
            of_all = f"{len(some.weighting):,} of the {len(problem.weighting):,} {problem.counted}"
            notes.append(
                f"what would help is worked out for {of_all}: those that bind, and others at random"
            )
        record["fixes"] = fixes(some, closest)
        record["would_take"] = relaxations(problem, {limit for pair in counts for limit in pair})
    return record


def _conflicts(named: Named, kept: Solutions, counts: Counter[Pair]) -> Iterator[dict[str, Any]]:
    """Pairs of limits that leave choices without a window, the most frequent first, and what relaxing one would take.

    `gap` is by how much the pretensions asked for miss each other, N, in the choice that is nearest to a window.
    """
    of_pairs = candidates.conflicts_of(kept)
    for pair, count in counts.most_common():
        closest = candidates.nearest(kept.select(of_pairs[pair]))
        gap = closest.scalar("pretension_from") - closest.scalar("pretension_to")
        yield {
            "limits": list(pair),
            "choices": count,
            "gap": gap if math.isfinite(gap) else None,
            "nearest": named.records(closest)[0],
        }


def named_rows(record: Mapping[str, Any]) -> tuple[dict[int, dict[str, Any]], list[dict[str, Any]]]:
    """The choices that a record names, by their rows in the table, and those of them that the grid has not.

    The latter stand in the table after all others, in the order that is given.
    """
    rows = [
        *record["proved"],
        *([record["best"]] if record["best"] else []),
        *record["best_by"].values(),
    ]
    named = {row["choice"]: row for row in (*rows, *record["front"])}
    of_grid = {choice: row for choice, row in sorted(named.items()) if choice < record["choices"]}
    return of_grid, [named[choice] for choice in sorted(named) if choice >= record["choices"]]
