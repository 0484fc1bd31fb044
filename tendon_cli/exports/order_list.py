"""An order list of a choice: the parts of catalogues, springs, rope, strap and motor."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator
from typing import NamedTuple

from tendon_cli import say
from tendon_cli.answers.text_parts import short_parts
from tendon_cli.errors import UsageError
from tendon_cli.exports.chosen import ChosenSuit, scalar
from tendon_cli.files import write_csv_rows
from tendon_cli.studies.space.axis import NamedAxis
from tendon_cli.verbs.answer_record import PartsRecord, value_of

ORDER_MARK = "part,quantity,supplier,number,price,currency,remark"
"""First line of an order list."""
_SUPPLIERS = ("supplier", "maker", "manufacturer")
_NUMBERS = ("number", "article", "part_number", "order_number")
_PRICE = "price"
_MOTOR = "limits.peak_motor_torque"
"""Key that rows of a table of motors set."""


class OrderLine(NamedTuple):
    """A line of an order list."""

    part: str
    quantity: str = "1"
    supplier: str = ""
    number: str = ""
    price: str = ""
    """Price of one piece."""
    currency: str = ""
    remark: str = ""


def order_csv(suit: ChosenSuit) -> str:
    """Return the parts of a choice, one a line, and what else the suit needs."""
    if not suit.choice.feasible:
        problem = f"{suit.record.name}: this choice has no window, so there is nothing to order"
        raise UsageError(problem, where="--choice", hint="`tendon show` lists the choices")
    file = io.StringIO()
    write_csv_rows(file, [OrderLine._fields, *_lines(suit)])
    return file.getvalue()


def _lines(suit: ChosenSuit) -> Iterator[OrderLine]:
    listed: set[str] = set()
    for axis in suit.question.choices.axes:
        if not isinstance(axis, NamedAxis):
            continue
        listed |= set(axis.keys)
        name = str(value_of(suit.choice, axis.column))
        yield _of_row(axis, name)
    if not any(key.startswith("spring.") for key in listed):
        yield from _springs(suit)
    parts = suit.record.parts_needed
    is_first = suit.record.best is not None and suit.choice.choice == suit.record.best.choice
    if parts is None or not is_first:
        return  # the answer works out what the choice named first needs
    has_motor = _MOTOR in listed
    yield from (line for line in _needed(suit, parts) if not (has_motor and line.part == "motor"))


def _springs(suit: ChosenSuit) -> Iterator[OrderLine]:
    """Yield the springs of both sides; rigid ones are none."""
    design = suit.design()
    stiffnesses = [scalar(side.spring_stiffness) for side in (design.flexor, design.extensor)]
    for stiffness in dict.fromkeys(stiffnesses):
        if math.isfinite(stiffness):
            part = f"spring of {say.quantity('spring_stiffness', stiffness)}"
            yield OrderLine(part, quantity=str(stiffnesses.count(stiffness)))


def _of_row(axis: NamedAxis, name: str) -> OrderLine:
    """Return the line of a row of a table, with what it carries."""
    row = axis.place(name)
    carried = {column.name: column for column in axis.carried}

    def text(names: tuple[str, ...]) -> str:
        return next((carried[one].text(row) for one in names if one in carried), "")

    price = carried.get(_PRICE)
    amount = "" if price is None or price.words else f"{float(price.values[row]):.12g}"
    return OrderLine(
        part=f"{axis.key} {name}",
        quantity=str(axis.pieces),
        supplier=text(_SUPPLIERS),
        number=text(_NUMBERS),
        price="" if amount == "nan" else amount,
        currency="" if price is None else price.unit,
    )


def _needed(suit: ChosenSuit, parts: PartsRecord) -> Iterator[OrderLine]:
    """Yield what the suit needs beside the parts of its catalogues, as the answer says it."""
    length = suit.question.study.numbers["tendon.length"].array[0]
    for kind, words in short_parts(parts):
        if kind == "spring":
            continue
        quantity = "2" if kind == "rope" else "1"
        remark = words
        if kind == "rope":
            remark = f"{words}; {say.quantity('tendon_length', float(length))} each"
        yield OrderLine(part=kind, quantity=quantity, remark=remark)
