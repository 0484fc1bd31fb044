"""An answer as `design.json` and `--json` have it."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import numpy as np

from tendon_cli.answers.answer import Findings
from tendon_cli.answers.candidates import Candidates
from tendon_cli.answers.conflicts import Conflict
from tendon_cli.answers.fixes import Fix
from tendon_cli.answers.sensitivity import Sensitivity
from tendon_cli.answers.tables import as_records, choice_columns, choice_rows, condition_columns, condition_rows
from tendon_cli.engine.columns import versions
from tendon_cli.version import RESULTS_VERSION


def record_of(found: Findings) -> dict[str, Any]:
    """The answer, but for its files. SI values, null for what is not a number; `choice` is a row of choices.parquet."""
    problem, study = found.problem, found.problem.study
    best = {name: _row(found, one) for name, one in found.best.items()}
    only = len(found.goals) > 0
    return {
        "name": study.name,
        "title": study.title,
        "study_hash": study.hash,
        "results_version": RESULTS_VERSION,
        "choices": found.gathered.choices,
        "conditions": len(problem.conditions),
        "feasible": found.gathered.feasible,
        "serve": problem.enough,
        "goals": [asdict(goal) for goal in found.goals],
        "best": next(iter(best.values()), None) if only or not best else best,
        "gains": found.gains,
        "front": [] if found.front is None else _rows(found, found.front),
        "fixes": [_fix(fix) for fix in found.fixes],
        "conflicts": [_conflict(found, each) for each in found.conflicts],
        "sensitivities": [_sensitivity(each) for each in found.sensitivities],
        "notes": found.notes,
        "versions": versions(),
        "study": study.document(),
    }


def rows_beside(found: Findings, candidates: Candidates) -> np.ndarray[Any, np.dtype[np.int64]]:
    """The rows of choices in `choices.parquet`: those between the points of the grid stand after all others."""
    rows = candidates.row.copy()
    if not len(found.beside):
        return rows
    places = np.column_stack([np.asarray(values) for values in found.beside.columns.values()])
    for at in np.flatnonzero(rows < 0):
        place = np.array([values[at] for values in candidates.columns.values()])
        same = np.flatnonzero((places == place).all(axis=1))
        rows[at] = found.gathered.choices + same[0] if len(same) else -1
    return rows


def _rows(found: Findings, candidates: Candidates) -> list[dict[str, Any]]:
    """Choices as rows of the table, each with its number there."""
    refined = candidates.row < 0
    on_front = np.full(len(candidates), found.front is not None)
    rows = as_records(choice_columns(found.problem), choice_rows(found.problem, candidates, refined, on_front))
    numbers = rows_beside(found, candidates).tolist()
    return [{"choice": number if number >= 0 else None, **row} for number, row in zip(numbers, rows, strict=True)]


def _row(found: Findings, one: Candidates) -> dict[str, Any]:
    return _rows(found, one)[0]


def _fix(fix: Fix) -> dict[str, Any]:
    costs = {name: finite(value) for name, value in (fix.costs or {}).items()}
    return {
        "knobs": list(fix.knobs),
        "before": list(fix.before),
        "after": None if fix.after is None else list(fix.after),
        "plausible": [list(span) for span in fix.plausible],
        "pretension": finite(fix.pretension),
        **costs,
    }


def _conflict(found: Findings, each: Conflict) -> dict[str, Any]:
    return {
        "limits": list(each.limits),
        "choices": each.choices,
        "gap": finite(each.gap),
        "nearest": _row(found, each.nearest),
        "relaxed": each.relaxed,
    }


def _sensitivity(each: Sensitivity) -> dict[str, Any]:
    return {**asdict(each), "per_percent": each.per_percent}


def finite(value: float) -> float | None:
    """A number, or null where it is none."""
    return value if math.isfinite(value) else None


def conditions_of(found: Findings) -> list[dict[str, Any]]:
    """The conditions as rows of their table."""
    return as_records(condition_columns(found.problem), condition_rows(found.problem))
