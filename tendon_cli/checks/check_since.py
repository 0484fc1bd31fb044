"""Verdict on a comparison: nothing changed since a baseline, or what did."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import asdict
from typing import Any

from tendon_cli import say
from tendon_cli.checks.check_text import CheckResult, finite, shown
from tendon_cli.checks.compare import VERSION, compared
from tendon_cli.checks.compare_text import digits_of, move_words, value_words
from tendon_cli.checks.compared import Compared, Number
from tendon_cli.engine.results import Result
from tendon_cli.engine.study_differences import Difference
from tendon_cli.errors import InputError, UsageError
from tendon_cli.studies.fields import hint_at_nearest
from tendon_cli.studies.json_schema import key_words
from tendon_cli.studies.study import Study
from tendon_cli.units import shorten

TOLERANCE = 1e-9
"""Share of a column's scale by which numbers may differ."""
_OF_ROWS = ("motion.elbow_angle", "motion.direction")
"""Keys of runs that only say which rows a study has."""
_OF_ANSWER = (
    "choice",
    "feasible",
    "pretension_from",
    "pretension_to",
    "served",
    "pretension",
    "set_flexor_tension",
    "set_extensor_tension",
)
"""Quantities of an answer that may not move."""


def check_since(
    baseline: Result, result: Result, tolerance: float, apart: Sequence[str], worst: int
) -> CheckResult:
    """Find what changed since a baseline of the same kind, the study included.

    Args:
        baseline: The baseline.
        result: The result.
        tolerance: Share of a column's scale by which numbers may differ.
        apart: Keys in which the studies may differ.
        worst: Number of persons, draws or designs that are listed.

    Raises:
        InputError: The baseline is of another kind.
        UsageError: A key is of no study, or the runs have nothing in common.
    """
    if baseline.kind.verb != result.kind.verb:
        problem = f"holds {baseline.kind.noun}, expected {result.kind.noun} as baseline"
        raise InputError(problem, where=str(baseline.folder))
    found = compared(baseline, result, ("the baseline", "this result"))
    edits = _edits(found, baseline.study, result.study, apart)
    if not found.quantities:
        raise UsageError(found.notes[0])
    is_of_answer = found.quantities[0].table == "choices"
    gated = [
        number
        for number in found.quantities
        if number.change and (not is_of_answer or number.name in _OF_ANSWER)
    ]
    gated.sort(key=lambda number: -number.change)
    beyond = [number for number in gated if number.change > tolerance]
    within = next((number for number in gated if number.change <= tolerance), None)
    missing = [text for key, text in found.left_out.items() if not _is_within(key, apart)]
    excepted = [text for key, text in found.left_out.items() if _is_within(key, apart)]
    holds = not (beyond or missing or edits)
    record: dict[str, Any] = {
        "edits": [edit.key for edit in edits],
        "compared": found.compared,
        "missing": missing,
        "excepted": excepted,
        "within": None if within is None else asdict(within),
        "changes": [asdict(number) for number in beyond],
        "gained": None if found.gained is None else asdict(found.gained),
        "lost": None if found.lost is None else asdict(found.lost),
        "holds": holds,
    }
    verdict = "nothing changed" if holds else "changed"
    lines = [f"{found.b.place}: {verdict} since {found.a.place}"]
    for edit in edits[:worst]:
        was, is_now = edit.shown
        lines.append(f"  {edit.key} was {was}, now {is_now} (--except {edit.key} accepts it)")
    if len(edits) > worst:
        lines.append(f"  and {say.counted(len(edits) - worst, 'more key')} of the study")
    lines.append(f"  compared: {found.compared}")
    if within is not None:
        lines.append(f"  within the tolerance, the largest difference: {_change_words(within)}")
    lines += [f"  not compared, because it may differ: {text}" for text in excepted]
    lines += [f"  not compared: {text}" for text in missing]
    lines += [f"  {_change_words(number)}" for number in beyond]
    if any(move.count for move in found.moves):
        lines += [f"  {words}" for words in [*move_words(found)][: worst + 1]]
    text = say.name_joint("\n".join(lines), say.joint_name(result.record))
    return CheckResult(holds, text, finite(record), verdict)


def _edits(
    found: Compared, baseline: Study, study: Study, apart: Sequence[str]
) -> list[Difference]:
    """Return the differences of studies in other keys than `apart` and those of rows.

    Raises:
        UsageError: A key of `apart` is of no study.
    """
    known: set[str] = set()  # keys, and the tables that they are in
    for key in (*key_words(), *(difference.key for difference in found.differences)):
        parts = key.split(".")
        known.update(".".join(parts[: depth + 1]) for depth in range(len(parts)))
    unknown = [key for key in apart if key not in known.union(Study.model_fields)]
    if unknown:
        hint = hint_at_nearest(unknown[0], known) or "`tendon init --schema` lists every key"
        raise UsageError(f'a study has no key "{shorten(unknown[0])}"', where="--except", hint=hint)
    varied = {*apart, VERSION}
    if found.b.verb == "sweep":
        varied |= {*_OF_ROWS, *baseline.axes, *study.axes}
    return [edit for edit in found.differences if not _is_within(edit.key, varied)]


def _is_within(key: str, keys: Collection[str]) -> bool:
    """Return True if a key is one of `keys`, or in a table that is."""
    return any(f"{key}.".startswith(f"{table}.") for table in keys)


def _change_words(number: Number) -> str:
    """Say by how much a column differs, and where most; of an answer from what to what."""
    if number.table == "choices":
        digits = digits_of(number)
        now, before = (value_words(number, value, digits) for value in (number.b, number.a))
        by = "" if math.isinf(number.change) else f" ({say.number(100.0 * number.change, 3)} %)"
        return f"{number.label}: {now}, was {before}{by}"
    head = f"{number.table}.{number.name}: {say.counted(number.rows, 'row')}"
    if number.most is None:
        return f"{head}, first at {number.at}"
    if math.isinf(number.most):
        return f"{head}, null in one run only, first at {number.at}"
    share = ""
    if math.isfinite(number.change):
        share = f" ({say.number(100.0 * number.change, 3)} % of its scale)"
    return f"{head}, most by {shown(number.name, number.most)}{share} at {number.at}"
