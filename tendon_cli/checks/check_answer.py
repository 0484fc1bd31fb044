"""Check of an answer: True if the choice named first keeps the limits for enough."""

from __future__ import annotations

from collections.abc import Sequence

from tendon_cli import say
from tendon_cli.answer_record import as_answer
from tendon_cli.answers.text_first import first_words
from tendon_cli.checks.check_text import NEGATIVE, CheckResult, finite
from tendon_cli.engine.results import Result


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
        lines.append(
            f"  {say.name_joint(first_words(record, best), say.joint_name(record['question']))}"
        )
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
