"""Remedies in words: fixes of a number, and relaxations of a demand."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from tendon_cli import say
from tendon_cli.answer_record import (
    AnswerResults,
    FixRecord,
    QuestionRecord,
    RelaxationRecord,
)
from tendon_cli.answers.phrases import COSTS, costs, value_words
from tendon_cli.answers.text_verified import share_words
from tendon_cli.quantities import QUANTITIES, Quantity
from tendon_cli.space.axis import limit_of
from tendon_cli.studies.axis_words import parameter
from tendon_cli.studies.study import keys

_DEMANDS = {
    "load.mass": "loads of at most {} instead of {}",
    "arm.upper_arm_angle": "an upper arm tilted by at most {} instead of {}",
    "arm.contact_width": "a strap of {} instead of {}",
    "anchor.stiffness": "tissue and cuffs of {} per tendon instead of {}",
}


def fixes_table(question: QuestionRecord, fixes: Sequence[FixRecord]) -> Iterator[say.Block]:
    """Yield the table of the value that each parameter alone would have to take."""
    is_judged = any(fix.served_verified is not None for fix in fixes)
    lines = [["", question.unit, *(["served"] if is_judged else []), *COSTS.values()]]
    idle = []
    for fix in fixes:
        if fix.after is None:
            idle.append(keys()[fix.parameter].quantity.symbol)
            continue
        changed = f"{_change_words(fix)}{_nearest_words(fix)}"
        judged = fix.served_verified
        share = [] if judged is None else [say.percent(judged.value)]
        lines.append([changed, fix.printed_pretension, *share, *costs(fix)])
    yield say.heading("What changing one number would give, all else equal")
    if len(lines) > 1:
        yield say.table(lines)
    if idle:
        yield from say.items([f"no plausible value of these helps: {', '.join(idle)}"])


def fix_words(question: QuestionRecord, fix: FixRecord) -> str:
    """Say a fix in a line: "K from 3 kN/m to 3.4 kN/m, set to 120 N: tension 377 N".

    If no change of the number can be seen in print, it is the pretension that matters.
    """
    before = parameter(fix.parameter, fix.before)
    words = f"set to {fix.printed_pretension} {question.unit}"
    if not before.endswith(f" {fix.printed}"):
        words = f"{_change_words(fix)}{_nearest_words(fix)}, {words}"
    judged = fix.served_verified
    gains = [] if judged is None else [f"{say.percent(judged.value)} served"]
    of_costs = zip(COSTS.values(), costs(fix), strict=True)
    gains += [f"{head} {cost}" for head, cost in of_costs if cost != "-"]
    return f"{words}: {', '.join(gains)}" if gains else words


def _change_words(fix: FixRecord) -> str:
    """Say the change of a fix: "K from 3 kN/m to 3.4 kN/m"."""
    key = fix.parameter
    value = say.quantity(keys()[key].quantity, fix.before)
    name = parameter(key, fix.before).removesuffix(value).rstrip()
    return f"{name} from {value} to {fix.printed}"


def _nearest_words(fix: FixRecord) -> str:
    """Name the row of a table that is nearest to the value of a fix, in brackets; or nothing."""
    nearest = fix.nearest
    if nearest is None:
        return ""
    value = parameter(fix.parameter, nearest.value)
    return f" (nearest in the catalogue: {nearest.table} {nearest.name}, {value})"


def quantity_of_demand(key: str) -> Quantity:
    """Return the quantity of a number, or of a limit, by its key."""
    limit = limit_of(key)
    return keys()[key].quantity if limit is None else QUANTITIES[limit]


def relaxations_words(
    answer: AnswerResults, relaxations: Sequence[RelaxationRecord]
) -> Iterator[str]:
    """Say the value that each demand would have to take, and the suit that then serves."""
    question = answer.question
    fresh = answer.verified_by
    not_enough = []
    for record in relaxations:
        key = record.key
        quantity = quantity_of_demand(key)
        text = _DEMANDS.get(key, f"{key.removeprefix('limits.')} = {{}} instead of {{}}")
        if record.after is None or record.pretension is None:
            farthest = say.quantity(quantity, record.farthest)
            not_enough.append(text.partition(" instead of")[0].format(farthest))
            continue
        changed = text.format(record.printed, say.quantity(quantity, record.before))
        others = [axis for axis in question.choices if axis.key != key]
        values = [value_words(axis, record.values[axis.column]) for axis in others]
        pretension = f"{record.printed_pretension} {question.unit}"
        suit = f"{', '.join(values)} at {pretension}" if values else pretension
        share = record.served
        some = "all" if share is None or share >= 1.0 else f"{say.percent(share)} of the"
        whom = f"{some} {question.counted}"
        judged = record.served_verified
        if judged is not None and fresh is not None:
            judges = replace(fresh, count=judged.of)
            whom = share_words(judges, judged, answer.serve)
        yield f"{changed}: {suit} serves {whom}"
    if not_enough:
        own = "its" if len(not_enough) == 1 else "their"
        yield f"not enough on {own} own: {', '.join(not_enough)}"
