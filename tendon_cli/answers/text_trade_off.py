"""Trade-off in words: what a looser limit buys, from the record of an answer."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

import numpy as np

from tendon_cli import say
from tendon_cli.answer_record import (
    AnswerResults,
    AxisRecord,
    ChoiceRecord,
    QuestionRecord,
    TradeOffRecord,
    Value,
    value_of,
)
from tendon_cli.answers.phrases import value_words, window_of
from tendon_cli.answers.text_order import tolerance_millimetres
from tendon_cli.space.axis import limit_of
from tendon_cli.studies.study import keys

_MOST_LINES = 12
"""Most lines of a table; of more, evenly spaced ones are shown."""


def trade_off_blocks(record: AnswerResults) -> Iterator[say.Block]:
    """Yield for each limit with several values the best choice with each of them, as a table."""
    question = record.question
    unit = question.unit
    for trade_off in record.trade_offs:
        if not any(trade_off.best):
            continue
        (axis,) = (axis for axis in question.choices if axis.key == trade_off.key)
        limit = limit_of(axis.key)
        name = axis.key if limit is None else say.limit_on(limit)
        yield say.heading(f"What the {name} buys")
        lines = _lines(question, axis, trade_off)
        step = -(-len(lines) // _MOST_LINES)
        head = ["", f"window {unit}", "±mm", unit, "tension", ""]
        yield say.table([head, *lines[::step]])
        yield from say.items(_own_limits(axis, trade_off))


def _own_limits(axis: AxisRecord, trade_off: TradeOffRecord) -> Iterator[str]:
    """Say with which parts a limit of the part itself, such as a motor's speed, ends the window."""
    own = {limit_of(key) for sets in (axis.sets or {}).values() for key in sets}
    for value, choice in zip(trade_off.values, trade_off.best, strict=True):
        if choice is None:
            continue
        for limit, end in ((choice.from_by, "lower"), (choice.to_by, "upper")):
            if limit is not None and limit in own:
                yield f"with {value} its own {say.limit_on(limit)} sets the {end} end"


def _lines(
    question: QuestionRecord, axis: AxisRecord, trade_off: TradeOffRecord
) -> list[list[str]]:
    """Return the cells of each line; neighbouring values with the same outcome share one."""
    outcomes = [_outcome(question, axis, choice) for choice in trade_off.best]
    of_values = zip(trade_off.values, outcomes, strict=True)
    lines = []
    for outcome, group in groupby(of_values, key=lambda pair: pair[1]):
        values = [value for value, _ in group]
        lines.append([_values_words(axis, values), *outcome])
    return lines


def _outcome(question: QuestionRecord, axis: AxisRecord, choice: ChoiceRecord | None) -> list[str]:
    """Say window, tolerance, pretension, tension and the other axes of the best choice."""
    if choice is None:
        return ["no window", "", "", "", ""]
    low, high = window_of(choice) or (np.nan, np.nan)
    upper = "on" if np.isinf(high) else f"to {say.number(high, 3)}"
    pretension = choice.pretension
    others = [
        value_words(other, value_of(choice, other.column))
        for other in question.choices
        if other.key != axis.key
    ]
    return [
        f"{say.number(low, 3)} {upper}",
        tolerance_millimetres(choice),
        "-" if pretension is None else say.number(pretension, 3),
        say.quantity("max_tension", value_of(choice, "max_tension")),
        ", ".join(others),
    ]


def _values_words(axis: AxisRecord, values: list[Value]) -> str:
    """Say one value of a limit, or neighbouring ones: "12 to 16 N m", "M12 and M16"."""
    if axis.named:
        names = [str(value) for value in values]
        return say.join_words(names) if len(names) < 3 else f"{names[0]} to {names[-1]}"
    quantity = keys()[axis.key].quantity
    first, last = (say.quantity(quantity, float(value)) for value in (values[0], values[-1]))
    if len(values) == 1:
        return first
    return f"{first.partition(' ')[0]} to {last}"
