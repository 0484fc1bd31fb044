"""An answer as `design.json` and `--json` have it; texts, figures and pages are made of this and the tables."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.answers import coverage
from tendon_cli.answers.answer import Findings
from tendon_cli.answers.between import curves_of
from tendon_cli.answers.candidates import Candidates
from tendon_cli.answers.conflicts import Conflict
from tendon_cli.answers.fixes import Fix
from tendon_cli.answers.front import losses
from tendon_cli.answers.population import LESS, MORE, NEITHER, AxisSizes, PopulationResult, Reason
from tendon_cli.answers.remarks import bench_record
from tendon_cli.answers.sizes import Sizes
from tendon_cli.answers.tables import as_records, choice_columns, choice_rows
from tendon_cli.answers.uncertainty import Indices
from tendon_cli.studies.values import RIGID

_MOST_OF_CURVE = 1000
_NEEDS = {MORE: "more", LESS: "less", NEITHER: "another suit"}


def as_record(answer: Findings, population: PopulationResult | None) -> dict[str, Any]:
    """The answer. SI values, null for what is not a number; `choice` is a row of choices.parquet."""
    problem = answer.problem
    best = {name: _row(answer, one) for name, one in answer.best.items()}
    single = len(answer.goals) > 0
    return {
        "choices": answer.summary.choices,
        "conditions": len(problem.conditions),
        "feasible": answer.summary.feasible,
        "serve": problem.enough,
        "goals": [asdict(goal) for goal in answer.goals],
        "best": next(iter(best.values()), None),
        "best_by": {} if single else best,
        "given_up": _given_up(answer),
        "window_for_all": _finite_ends(answer.window_for_all),
        "gains": answer.gains,
        "front": [] if answer.front is None else _rows(answer, answer.front),
        **({} if answer.chosen is None else bench_record(problem, answer.chosen)),
        "between_samples": None if answer.chosen is None else {"curves": curves_of(problem, answer.chosen)},
        "fixes": [_fix(fix) for fix in answer.fixes],
        "conflicts": [_conflict(answer, each) for each in answer.conflicts],
        "sensitivities": [{**asdict(each), "per_percent": each.per_percent} for each in answer.sensitivities],
        "population": None if population is None else _population(answer, population),
        "notes": answer.notes,
    }


def named_rows(record: Mapping[str, Any]) -> tuple[list[int], list[dict[str, Any]]]:
    """Of the choices that a record names those on the front, as rows of the table, and those that the grid has not.

    The latter stand in the table after all others, in the order that is given.
    """
    rows = [*([record["best"]] if record["best"] else []), *record["best_by"].values()]
    named = {row["choice"]: row for row in (*rows, *record["front"]) if row["choice"] is not None}
    on_front = sorted(choice for choice, row in named.items() if row["on_front"])
    return on_front, [named[choice] for choice in sorted(named) if choice >= record["choices"]]


def _rows(answer: Findings, candidates: Candidates) -> list[dict[str, Any]]:
    """Choices as rows of the table, each with its number there."""
    refined = candidates.row < 0
    on_front = np.full(len(candidates), answer.front is not None or len(answer.goals) == 1)
    rows = as_records(choice_columns(answer.problem), choice_rows(answer.problem, candidates, refined, on_front))
    numbers = _numbers(answer, candidates).tolist()
    return [{"choice": number if number >= 0 else None, **row} for number, row in zip(numbers, rows, strict=True)]


def _numbers(answer: Findings, candidates: Candidates) -> np.ndarray[Any, np.dtype[np.int64]]:
    """The rows of choices in `choices.parquet`: those between the points of the grid stand after all others."""
    rows = candidates.row.copy()
    if not len(answer.between):
        return rows
    places = np.column_stack([np.asarray(values) for values in answer.between.columns.values()])
    for at in np.flatnonzero(rows < 0):
        place = np.array([values[at] for values in candidates.columns.values()])
        same = np.flatnonzero((places == place).all(axis=1))
        rows[at] = answer.summary.choices + same[0] if len(same) else -1
    return rows


def _row(answer: Findings, one: Candidates) -> dict[str, Any]:
    return _rows(answer, one)[0]


def _given_up(answer: Findings) -> float | None:
    """Of what the goals span on the front, the largest share that the best compromise gives up of any."""
    if answer.front is None or answer.chosen is None:
        return None
    if len(answer.front) < 2:
        return 0.0
    scores = answer.front.scores(answer.goals)
    at = np.flatnonzero((scores == answer.chosen.scores(answer.goals)[0]).all(axis=1))[0]
    return float(losses(scores)[at].max())


def _finite_ends(ends: tuple[float, float] | None) -> list[float | None] | None:
    return None if ends is None else [finite(end) for end in ends]


def _fix(fix: Fix) -> dict[str, Any]:
    record = asdict(fix) | {"pretension": finite(fix.pretension)}
    costs = record.pop("costs") or {}
    return record | {name: finite(value) for name, value in costs.items()}


def _conflict(answer: Findings, each: Conflict) -> dict[str, Any]:
    return {
        "limits": list(each.limits),
        "choices": each.choices,
        "gap": finite(each.gap),
        "nearest": _row(answer, each.nearest),
        "relaxed": each.relaxed,
    }


def finite(value: float) -> float | None:
    """A number, or null if it is none."""
    return value if math.isfinite(value) else None


# --- Persons and draws -----------------------------------------------------------------------------------------------


def _population(answer: Findings, population: PopulationResult) -> dict[str, Any]:
    """What the choice named first is to persons or draws; members are their numbers."""
    weighting, row = population.problem.weighting, _row(answer, population.chosen)
    return {
        "choice": row["choice"],
        "values": {factor.column: row[factor.column] for factor in answer.problem.choices.axes},
        "kind": population.kind,
        "count": len(population.windows.low),
        "effective_count": coverage.effective_count(weighting),
        "counts": population.problem.counts,
        "window": [row["pretension_from"], row["pretension_to"]],
        "pretension": finite(population.pretension),
        "served": population.share,
        "interval_95": _interval(population.share, weighting),
        "largest_share": population.best_share,
        "largest_share_at": finite(population.curve.best) if population.best_share > 0.0 else None,
        "by": _by_sex(population) if answer.problem.study.design.by == "sex" else [],
        "curve": _thinned_curve(population.curve),
        "not_served": [_reason(population, reason) for reason in population.reasons],
        "sizes": {each.column: [_size(each, best) for best in each.best] for each in population.sizes},
        "sobol": [_sobol(each) for each in population.indices],
    }


def _by_sex(population: PopulationResult) -> list[dict[str, Any]]:
    """The share that the pretension serves among men and among women."""
    weighting, shares = population.problem.weighting, []
    if population.people is None:
        return []
    rows = population.problem.person_of(np.arange(len(weighting)))
    sexes, people = np.array(population.people.sexes)[rows], rows // population.people.completions
    served = population.windows.served(population.pretension)
    for sex in dict.fromkeys(sexes.tolist()):
        of_sex = np.flatnonzero(sexes == sex)
        weights = coverage.normalised(weighting[of_sex])
        share = 1.0 if served[of_sex].all() else float(min(weights[served[of_sex]].sum(), 1.0))
        persons = len(np.unique(people[of_sex]))
        effective = coverage.effective_count(weighting[of_sex]) * persons / len(of_sex)
        interval = list(say.interval(share, effective))
        shares.append({"sex": sex, "persons": persons, "served": share, "interval_95": interval})
    return shares


def _thinned_curve(curve: coverage.Curve) -> dict[str, list[float]]:
    """The share served over pretension, at most so many points of it."""
    count = len(curve.pretension)
    kept = np.unique(np.linspace(0, count - 1, min(count, _MOST_OF_CURVE)).round().astype(np.int64))
    return {name: values[kept].tolist() for name, values in vars(curve).items()}


def _interval(share: float, weighting: np.ndarray[Any, Any]) -> list[float]:
    return list(say.interval(share, coverage.effective_count(weighting)))


def _reason(population: PopulationResult, reason: Reason) -> dict[str, Any]:
    people = population.people
    names: list[str] = []
    if people is not None:
        of_persons, rows = people.persons, population.problem.person_of(reason.members)
        names = list(dict.fromkeys(of_persons[at] for at in (rows // people.completions).tolist()))[:100]
    return {
        "needs": _NEEDS[reason.needs],
        "limits": list(reason.limits),
        "conditions": list(reason.conditions),
        "count": len(reason.members),
        "share": reason.share,
        "interval_95": _interval(reason.share, population.problem.weighting),
        "first": names,
        "bodies": {
            each.dimension: {"theirs": each.theirs, "of_all": each.of_all, "deviations": each.deviations}
            for each in reason.differences
        },
    }


def _size(each: AxisSizes, best: Sizes) -> dict[str, Any]:
    return {
        "suits": [
            {"value": RIGID if each.values[choice] == np.inf else each.values[choice], "pretension": at}
            for choice, at in zip(best.choices, best.pretensions, strict=True)
        ],
        "served": best.share,
        "interval_95": list(say.interval(best.share, each.persons)),
        "persons": each.persons,
        "values_tried": len(each.values),
        "all_values": not each.thinned,
    }


def _sobol(each: Indices) -> dict[str, Any]:
    rows = zip(
        each.inputs, each.first.tolist(), each.first_error.tolist(), each.total.tolist(), each.total_error.tolist(),
        strict=True,
    )  # fmt: skip
    names = ("first", "first_standard_error", "total", "total_standard_error")
    inputs = {key: dict(zip(names, numbers, strict=True)) for key, *numbers in rows}
    return {"end": each.end, "standard_deviation": each.deviation, "inputs": inputs}
