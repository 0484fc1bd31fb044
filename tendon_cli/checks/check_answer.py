"""Check of an answer: True if the choice named first keeps the limits for enough."""

from __future__ import annotations

from collections.abc import Sequence

from tendon_cli import say
from tendon_cli.answers.text import first_words
from tendon_cli.checks.check_text import NEGATIVE, CheckResult, finite
from tendon_cli.engine.results import Result
from tendon_cli.verbs.answer_record import as_answer, as_read, holds
from tendon_cli.verbs.typed_record import to_json


def check_answer(answer: Result, _worst: int) -> CheckResult:
    """Check that the choice named first keeps the limits for as many as the study asks for.

    If a fresh sample judges it, this sample decides. A suit that cannot be set does not hold.
    """
    record = as_answer(answer.record)
    best = record.best
    choices = record.choices
    feasible = record.feasible
    conflicts = record.conflicts
    is_held = holds(record)
    have = "has" if feasible == 1 else "have"
    counted = say.counted(choices, "choice")
    lines = [f"{record.name}: {feasible:,} of {counted} {have} a window of pretension"]
    read = as_read(record)
    if read.best is not None:
        joint = say.JointName.of(read.question.joint, read.question.own_words)
        lines.append(f"  {say.name_joint(first_words(read, read.best), joint)}")
    else:
        lines += [f"  {_conflict_words(conflict.limits)}" for conflict in conflicts]
    result = {
        "choices": choices,
        "feasible": feasible,
        "best": to_json(best),
        "conflicts": to_json(conflicts),
        "holds": is_held,
    }
    verdict = "the choice named first holds" if is_held else NEGATIVE
    return CheckResult(is_held, "\n".join(lines), finite(result), verdict)


def _conflict_words(limits: Sequence[str]) -> str:
    """Name the limits that leave no window: "max_tension conflicts with extensor slack"."""
    if len(limits) == 1:
        return f"{limits[0]} is broken at any pretension"
    return f"{limits[0]} conflicts with {' and '.join(limits[1:])}"
