"""The answer to a design question: what is best, what binds it, and if nothing suits, why and what would help.

It is a record as `design.json` and `--json` have it; texts, figures and pages are made of that and the tables.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from tendon_cli.answers.bench import bench_record
from tendon_cli.answers.between import Proofs, between_record, rows_to_prove
from tendon_cli.answers.candidates import (
    Pair,
    best_of,
    conflicts_of,
    leaves_out,
    nearest,
    numbers_of,
    of_rows,
    relevant,
)
from tendon_cli.answers.fixes import fixes, relaxation, sampled
from tendon_cli.answers.front import Goal, compromise, front, goals_of, losses
from tendon_cli.answers.proofs import Certificate
from tendon_cli.answers.question import Problem
from tendon_cli.answers.refine import refined
from tendon_cli.answers.relax import relaxations
from tendon_cli.answers.sensitivity import sensitivities
from tendon_cli.answers.solve import Solutions
from tendon_cli.answers.tables import as_records, choice_columns, choice_rows
from tendon_cli.engine.task import Note

_REFINED_ON_FRONT = 24


@dataclass(frozen=True, eq=False)
class Findings:
    """An answer in the terms of the question, from which its record is made."""

    problem: Problem
    goals: tuple[Goal, ...]
    """None if the study leaves them open."""
    choices: int
    feasible: int
    conflicts: Counter[Pair]
    """In how many choices each pair of limits leaves no window."""
    relevant: Solutions
    """The best by each goal, those that may be on the front, and the nearest to a window of each conflict."""
    best: dict[str, Solutions]
    """The best choice by each goal's column; if several goals make a front, its best compromise under an empty name."""
    gains: dict[str, float] = field(default_factory=dict)
    """By what share of its score a refined choice beats the best of the grid, by goal's column."""
    front: Solutions | None = None
    """Choices that no other beats, if there are several goals; in the order of the first goal."""
    proved: Solutions | None = None
    """Choices that the question wants proved besides."""
    certificates: Sequence[tuple[Solutions, Certificate]] = ()
    """Choices that are named, each with what holds of its window between the samples; the first is named first."""

    @property
    def chosen(self) -> Solutions | None:
        """The choice to be named first; None if none has a window."""
        return next(iter(self.best.values()), None)

    @property
    def most_universal(self) -> Solutions:
        """The choice to be named first, or if none has a window the one that serves most."""
        return self.chosen or self.relevant.taken([int(np.argmax(self.relevant["served"]))])

    @property
    def between(self) -> Solutions | None:
        """Choices between the points of the grid that are among the best or on the front, each place once."""
        named = [*self.best.values()] if self.front is None else [self.front]
        some = [one.taken(one.row < 0) for one in named if (one.row < 0).any()]
        if not some:
            return None
        _, first = np.unique(_places(whole := Solutions.joined(some)), axis=0, return_index=True)
        return whole.taken(np.sort(first))


def _places(choices: Solutions) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.column_stack([np.asarray(values, dtype=np.float64) for values in choices.columns.values()])


def summarised(choices: Solutions, goals: tuple[Goal, ...]) -> Note:
    """What matters of some choices, as JSON has it: counts, conflicts, and the rows that may be named."""
    return {
        "choices": len(choices),
        "feasible": int(choices["feasible"].sum()),
        "conflicts": [[list(pair), len(rows)] for pair, rows in conflicts_of(choices).items()],
        "rows": choices.row[relevant(choices, goals)].tolist(),
    }


def findings(problem: Problem, notes: Sequence[Note], lost: Sequence[Solutions] = ()) -> Findings:
    """The answer, from the notes of all parts; choices that may matter are solved again, whoever solved them before.

    Those that are `lost` seemed to have a window, and a proof found that they have none.
    """
    goals, conflicts = goals_of(problem.study), Counter[Pair]()
    for note in notes:
        conflicts.update({tuple(names): count for names, count in note["conflicts"]})
    asked, seemed = rows_to_prove(problem), [one.row.item() for one in lost]
    rows = np.unique(np.array([*(row for note in notes for row in note["rows"]), *asked], dtype=np.int64))
    kept = of_rows(problem, rows[~np.isin(rows, seemed)]) if len(rows) > len(seemed) else lost[0]
    kept = Solutions.joined([kept, *lost]) if len(rows) > len(seemed) else Solutions.joined([*lost])
    choices, have = (sum(note[name] for note in notes) for name in ("choices", "feasible"))
    feasible, gains, on_front = kept.taken(kept["feasible"]), dict[str, float](), None
    bests: dict[str, Solutions] = {}
    for goal in problem.goals if len(feasible) else ():
        start = feasible.taken([best_of(feasible, feasible.scores((goal,))[:, 0])])
        bests[goal.column] = refined(problem, (goal,), start) or start
        before, after = (one.scores((goal,)).item() for one in (start, bests[goal.column]))
        if after != before and before:
            gains[goal.column] = (after - before) / abs(before)
    if len(goals) > 1 and len(feasible):
        on_front = _front(problem, goals, feasible, list(bests.values()))
        bests = {"": on_front.taken([compromise(on_front.scores(goals))])}
    proofs = Proofs(problem)
    bests = {column: proofs.of(one) for column, one in bests.items()}
    on_front = None if on_front is None else proofs.of(on_front)
    named = kept.taken(np.isin(kept.row, asked))
    proved = proofs.of(named) if len(named) else None
    none = [one for one, _ in proofs.done if not one["feasible"].item() and one.row.item() in feasible.row]
    if none:
        return findings(problem, notes, [*lost, *none])
    have -= len(lost)
    return Findings(
        problem, goals, choices, have, conflicts, kept, bests, gains, on_front, proved, proofs.done
    )  # fmt: skip


def _front(problem: Problem, goals: tuple[Goal, ...], feasible: Solutions, bests: list[Solutions]) -> Solutions:
    """The front, each of its choices made better between the points of the grid if that is possible."""

    def ordered(some: Solutions) -> Solutions:
        some = some.taken(front(some.scores(goals)))
        return some.taken(np.argsort(-some.scores(goals)[:, 0], kind="stable"))

    on_front = ordered(feasible)
    if len(on_front) > _REFINED_ON_FRONT and any(axis.is_range for axis in problem.choices.axes):
        on_front = on_front.taken(np.linspace(0, len(on_front) - 1, _REFINED_ON_FRONT).round().astype(np.int64))
    ones = [on_front.taken([at]) for at in range(len(on_front))]
    return ordered(Solutions.joined([refined(problem, goals, one) or one for one in ones] + bests))


# --- The record ------------------------------------------------------------------------------------------------------


def as_record(answer: Findings) -> dict[str, Any]:
    """The answer. SI values, null for what is not a number; `choice` is a row of choices.parquet."""
    problem, chosen, notes = answer.problem, answer.chosen, [*answer.problem.notes]
    if leaves_out(problem):
        notes.append(
            f"all {answer.choices:,} choices have their window; the worst values at their pretension are worked out"
            " for those that may matter, and are null in the others"
        )
    best = {name: row_of(answer, one) for name, one in answer.best.items()}
    return {
        "choices": answer.choices,
        "conditions": len(problem.conditions),
        "feasible": answer.feasible,
        "serve": problem.enough,
        "goals": [asdict(goal) for goal in answer.goals],
        "best": next(iter(best.values()), None),
        "best_by": {} if answer.goals else best,
        "given_up": _given_up(answer),
        "window_for_all": None if chosen is None else _window_for_all(problem, chosen),
        "gains": answer.gains,
        "front": [] if answer.front is None else _rows(answer, answer.front),
        **({} if chosen is None else bench_record(problem, chosen)),
        "between_samples": None if chosen is None else _between(answer, chosen),
        "proved": [] if answer.proved is None else _rows(answer, answer.proved),
        "fixes": [] if chosen is not None else _fixes(answer, notes),
        "would_take": [] if chosen is not None or problem.given is not None else _would_take(answer),
        "conflicts": _conflicts(answer),
        "sensitivities": [] if chosen is None else sensitivities(problem, chosen),
        "population": None,
        "notes": notes,
    }


def named_rows(record: Mapping[str, Any]) -> tuple[dict[int, dict[str, Any]], list[dict[str, Any]]]:
    """The choices that a record names, by their rows in the table, and those of them that the grid has not.

    The latter stand in the table after all others, in the order that is given.
    """
    rows = [*record["proved"], *([record["best"]] if record["best"] else []), *record["best_by"].values()]
    named = {row["choice"]: row for row in (*rows, *record["front"]) if row["choice"] is not None}
    of_grid = {choice: row for choice, row in sorted(named.items()) if choice < record["choices"]}
    return of_grid, [named[choice] for choice in sorted(named) if choice >= record["choices"]]


def _between(answer: Findings, chosen: Solutions) -> dict[str, Any]:
    """What holds between the samples of the choice named first; `choices` has the same of all that are named."""
    each = [
        {"choice": row_of(answer, one)["choice"], **asdict(certificate)} for one, certificate in answer.certificates
    ]
    return {**asdict(answer.certificates[0][1]), "choices": each, **between_record(answer.problem, chosen)}


def row_of(answer: Findings, one: Solutions) -> dict[str, Any]:
    """A choice as a row of the table, with its number there."""
    return _rows(answer, one)[0]


def _rows(answer: Findings, choices: Solutions) -> list[dict[str, Any]]:
    on_front = np.full(len(choices), answer.front is not None or len(answer.goals) == 1)
    rows = choice_rows(answer.problem, choices, choices.row < 0, on_front)
    records = as_records(choice_columns(answer.problem), rows)
    numbers, between = choices.row.tolist(), answer.between
    for at in np.flatnonzero(choices.row < 0):
        here = _places(choices)[at]
        same = [] if between is None else np.flatnonzero((_places(between) == here).all(axis=1)).tolist()
        numbers[at] = answer.choices + same[0] if same else -1
    return [{"choice": number if number >= 0 else None, **row} for number, row in zip(numbers, records, strict=True)]


def _given_up(answer: Findings) -> float | None:
    """Of what the goals span on the front, the largest share that the best compromise gives up of any."""
    if answer.front is None or answer.chosen is None:
        return None
    scores = answer.front.scores(answer.goals)
    at = np.flatnonzero((scores == answer.chosen.scores(answer.goals)[0]).all(axis=1))[0]
    return float(losses(scores)[at].max())


def _window_for_all(problem: Problem, choice: Solutions) -> list[float | None] | None:
    """The interval in which a choice serves all, N; None if there is none, or if all is what is asked for."""
    ends = problem.ends(numbers_of(problem, choice.columns), 1)
    low, high = float(ends.low.max()), float(ends.high.min())
    return [low, high if math.isfinite(high) else None] if problem.enough < 1.0 and low <= high else None


def _conflicts(answer: Findings) -> list[dict[str, Any]]:
    """Pairs of limits that leave choices without a window, the most frequent first, and what relaxing one would take.

    `gap` is by how much the pretensions asked for miss each other, N, in the choice that is nearest to a window;
    `relaxed` to what each limit must be relaxed for that one to have a window, null where that does not help.
    """
    records, of_pairs = [], conflicts_of(answer.relevant)
    for pair, count in answer.conflicts.most_common():
        closest = nearest(answer.relevant.taken(of_pairs[pair]))
        gap = closest.one("pretension_from") - closest.one("pretension_to")
        limits = [limit for limit in pair if limit in answer.problem.bounds]
        records.append({
            "limits": list(pair), "choices": count, "gap": gap if math.isfinite(gap) else None,
            "nearest": row_of(answer, closest),
            "relaxed": {limit: relaxation(answer.problem, closest, limit) for limit in limits},
        })  # fmt: skip
    return records


def _would_take(answer: Findings) -> list[dict[str, Any]]:
    """What it would take that some choice has a window; of a single one, conflicts say it of limits."""
    limits = {limit for pair in answer.conflicts for limit in pair}
    return relaxations(answer.problem, limits, of_limits=answer.choices > 1)


def _fixes(answer: Findings, notes: list[str]) -> list[dict[str, Any]]:
    """What would give the choice that is nearest to a window one."""
    problem, closest = answer.problem, nearest(answer.relevant)
    some = sampled(problem, closest)
    if len(some.weighting) < len(problem.weighting):
        of_all = f"{len(some.weighting):,} of the {len(problem.weighting):,} {problem.counted}"
        notes.append(f"what would help is worked out for {of_all}: those that bind, and others at random")
    return fixes(some, closest)
