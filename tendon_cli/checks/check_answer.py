"""Check of an answer: whether the choice named first still does, or has moved since a baseline."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, TypedDict

from tendon_cli import say
from tendon_cli.answer_record import AnswerRecord, ChoiceRecord, as_answer, named_first, value_of
from tendon_cli.answers import phrases
from tendon_cli.answers.text_first import first_words
from tendon_cli.checks.check_text import NEGATIVE, CheckResult, finite
from tendon_cli.checks.compare import check_studies
from tendon_cli.engine.results import Result
from tendon_cli.quantities import AS_READ, QUANTITIES

_WINDOW = ("pretension_from", "pretension_to")
_WORDS = {
    "pretension": "pretension to set",
    "set_flexor_tension": "to set in the flexor at the joint",
    "set_extensor_tension": "to set in the extensor at the joint",
    "set_flexor_tension_motor": "to set in the flexor at the motor",
    "set_extensor_tension_motor": "to set in the extensor at the motor",
}
"""Columns of what is set, in words."""
_MAY_DIFFER = ("name", "title", "output", "figure", "allow_implausible")
"""Keys that change no number of an answer."""
_SERVED = "served"


class MovedRecord(TypedDict):
    """A number of the choice named first in two answers."""

    quantity: str
    before: float | None
    """Value in the baseline, SI; null if it has none."""
    now: float | None
    share: float | None
    """Difference as a share of the larger of both; null if only one has a value."""


def check_answer(answer: Result, _worst: int) -> CheckResult:
    """Check that the choice named first keeps the limits for as many as the study asks for.

    If a fresh sample judges it, this sample decides.
    """
    record = as_answer(answer.record)
    best = record["best"]
    choices = record["choices"]
    feasible = record["feasible"]
    conflicts = record["conflicts"]
    holds = best is not None and best["feasible"]
    have = "has" if feasible == 1 else "have"
    counted = say.counted(choices, "choice")
    lines = [f"{record['name']}: {feasible:,} of {counted} {have} a window of pretension"]
    if best is not None:
        lines.append(f"  {say.name_joint(first_words(record, best), record['question']['joint'])}")
    else:
        lines += [f"  {_conflict_words(conflict['limits'])}" for conflict in conflicts]
    result = {
        "choices": choices,
        "feasible": feasible,
        "best": best,
        "conflicts": conflicts,
        "holds": holds,
    }
    verdict = "the choice named first holds" if holds else NEGATIVE
    return CheckResult(holds, "\n".join(lines), finite(result), verdict)


def _conflict_words(limits: Sequence[str]) -> str:
    """Name the limits that leave no window: "max_tension conflicts with extensor slack"."""
    if len(limits) == 1:
        return f"{limits[0]} is broken at any pretension"
    return f"{limits[0]} conflicts with {' and '.join(limits[1:])}"


def check_answer_since(
    answer: Result, baseline: Result, tolerance: float, apart: Sequence[str], _worst: int
) -> CheckResult:
    """Find what changed of the choice named first since another answer.

    Its values on the axes, whether it does, its window, the share that it serves, and what to set
    are compared, numbers as shares of the larger of both.

    Args:
        answer: The answer.
        baseline: The other answer.
        tolerance: Share of the larger number by which two may differ.
        apart: Keys in which the studies may differ.

    Raises:
        UsageError: The studies differ in other keys.
    """
    check_studies(answer.study, baseline.study, apart, _MAY_DIFFER)
    now = as_answer(answer.record)
    before = as_answer(baseline.record)
    moved = [*_moved(before, now)]
    beyond = [found for found in moved if found["share"] is None or found["share"] > tolerance]
    within = [found for found in moved if found not in beyond]
    words = [*_changed_words(before, now)]
    holds = not beyond and not words
    record: dict[str, Any] = {
        "choice": {"before": _choice(before), "now": _choice(now)},
        "changes": beyond,
        "within": max(within, key=lambda found: found["share"] or 0.0, default=None),
        "excepted": list(apart),
        "holds": holds,
    }
    head = "nothing changed" if holds else "changed"
    unit = now["question"]["unit"]
    lines = [
        f"{answer.folder or now['name']}: {head} since {baseline.folder or before['name']}",
        "  compared: the choice named first, its window, the share it serves and what to set",
    ]
    if record["within"] is not None:
        largest = _moved_words(record["within"], unit)
        lines.append(f"  within the tolerance, the largest difference: {largest}")
    lines += [f"  {text}" for text in words]
    lines += [f"  {_moved_words(found, unit)}" for found in beyond]
    verdict = "nothing changed" if holds else "changed"
    text = say.name_joint("\n".join(lines), now["question"]["joint"])
    return CheckResult(holds, text, finite(record), verdict)


def _moved(before: AnswerRecord, now: AnswerRecord) -> list[MovedRecord]:
    """List the numbers of the choice named first that differ in two answers."""
    found: list[MovedRecord] = []
    is_judged_anew = all(_is_verified(record) for record in (before, now))
    for name in (*_WINDOW, _SERVED, *_WORDS):
        first, second = (
            _value(record, name, is_judged_anew=is_judged_anew) for record in (before, now)
        )
        if first == second:
            continue
        share = None
        if first is not None and second is not None:
            scale = max(abs(first), abs(second))
            share = abs(second - first) / scale
        found.append({"quantity": name, "before": first, "now": second, "share": share})
    return found


def _is_verified(record: AnswerRecord) -> bool:
    """Return True if a fresh sample judges the choice named first."""
    choice = named_first(record)
    return choice is not None and choice["served_verified"] is not None


def _value(record: AnswerRecord, name: str, *, is_judged_anew: bool) -> float | None:
    """Return a number of the choice named first; None if it has none.

    Args:
        record: Record of the answer.
        name: Column of the choice.
        is_judged_anew: True if the share that it serves is that of the fresh sample.
    """
    choice = named_first(record)
    if choice is None:
        return None
    judged = choice["served_verified"]
    if name == _SERVED and is_judged_anew and judged is not None:
        return judged["value"]
    if name == _SERVED:
        return choice["served_at"]
    window = phrases.window_of(choice)
    has_window = window is not None and window[0] <= window[1]
    if name in _WINDOW and not has_window:
        return None
    value = value_of(choice, name)
    return None if value is None else float(value)


def _choice(record: AnswerRecord) -> dict[str, Any] | None:
    """Return the values of the choice named first on its axes, and whether it does."""
    choice = named_first(record)
    if choice is None:
        return None
    axes = record["question"]["choices"]
    values = {axis["column"]: value_of(choice, axis["column"]) for axis in axes}
    return {**values, "feasible": _does(record, choice)}


def _does(record: AnswerRecord, choice: ChoiceRecord) -> bool:
    """Return True if the choice named first is the best one and serves enough."""
    return record["best"] is not None and choice["feasible"]


def _changed_words(before: AnswerRecord, now: AnswerRecord) -> list[str]:
    """Say which other choice is named first, and whether it does, if this changed."""
    choices = (named_first(before), named_first(now))
    texts = []
    was, is_now = (
        "" if choice is None else phrases.choice_words(record["question"], choice)
        for choice, record in zip(choices, (before, now), strict=True)
    )
    if was != is_now:
        texts.append(f"another choice is named first: {is_now or 'none'}, was {was or 'none'}")
    does = [
        choice is not None and _does(record, choice)
        for choice, record in zip(choices, (before, now), strict=True)
    ]
    if does[0] and not does[1]:
        texts.append("it no longer keeps the limits for as many as the study demands")
        texts += [_conflict_words(conflict["limits"]) for conflict in now["conflicts"]]
    elif does[1] and not does[0]:
        texts.append("it now keeps the limits for as many as the study demands, but did not before")
    return texts


def _moved_words(found: MovedRecord, unit: str) -> str:
    """Say how a number moved: "smallest pretension: 126 N, was 122 N (3.3 %)"."""
    name = found["quantity"]
    now = _shown(name, found["now"], unit)
    before = _shown(name, found["before"], unit)
    by = ""
    if found["share"] is not None and not math.isinf(found["share"]):
        by = f" ({say.number(100.0 * found['share'], 3)} %)"
    return f"{_WORDS.get(name, say.column(name))}: {now}, was {before}{by}"


def _shown(name: str, value: float | None, unit: str) -> str:
    """Return a number of a choice in words."""
    if value is None:
        return "none"
    if name == _SERVED:
        return f"{say.number(100.0 * value)} %"
    if name in AS_READ:
        return f"{say.number(value, 5)} {unit}"
    return say.quantity(QUANTITIES[name], value, 5)
