"""Values of axes, and the numbers that a named row sets, in words."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from tendon_cli import say
from tendon_cli.quantities import in_unit_of_reading
from tendon_cli.studies.contents import keys
from tendon_cli.studies.model_words import WORDS_OF
from tendon_cli.studies.space.axis import NAMED_AXES, Axis, NamedAxis, split_side
from tendon_cli.studies.values import RIGID


def axis_meaning(axis: Axis) -> str:
    """Return the meaning of a column that holds the names of an axis's values."""
    if isinstance(axis, NamedAxis):
        return f"name of the {axis.key}"
    return say.spaced(axis.column)


def parameter(key: str, value: float | str, read: str | None = None) -> str:
    """Say a recorded number of a study with its symbol and unit.

    Args:
        key: Dotted key of the number.
        value: The number, SI, or the word for infinity.
        read: Gauge by which a pretension is read; None for F0.
    """
    number = math.inf if value == RIGID else float(value)
    quantity = keys()[key].quantity
    if read is not None:
        quantity = in_unit_of_reading(quantity, read)
    return say.parameter(quantity, number, say.side_of(key))


def name_words(axis: Axis, name: str, *, in_brackets: bool = False) -> str:
    """Say a name on an axis, with what it sets if that is short: "d88 (b₁ 88 mm)".

    Args:
        axis: An axis whose values have names.
        name: The name.
        in_brackets: True for words that stand in brackets: "d88: b₁ 88 mm".
    """
    is_named = isinstance(axis, NamedAxis)
    told = told_words(axis, name, parameter)
    return row_name(axis.key if is_named else "", name, told, in_brackets=in_brackets)


def row_name(key: str, name: str, told: str, *, in_brackets: bool = False) -> str:
    """Say the name of a row with what tells it from others: "d88 (b₁ 88 mm)", "spring A2".

    Args:
        key: Key of a named axis; empty for another axis.
        name: The name.
        told: What tells the row from the others, in words; may be empty.
        in_brackets: True for words that stand in brackets: "d88: b₁ 88 mm".
    """
    shown = f"{key} {name}" if key and key not in NAMED_AXES else name
    if not told:
        return shown
    return f"{shown}: {told}" if in_brackets else f"{shown} ({told})"


def told_words(axis: Axis, name: str, number: Callable[[str, float], str]) -> str:
    """List what tells a named row from the others; empty if that is nothing, or much.

    Args:
        axis: The axis; the values of one that is not named are told by their names alone.
        name: Name of the row.
        number: Returns the words for a number, of its key and its value in SI.
    """
    if not isinstance(axis, NamedAxis):
        return ""
    row = axis.place(name)
    carried = axis.carried_by(row)
    return ", ".join(carried) if carried else numbers_in_words(axis.told_by(row), number)


def numbers_in_words(told: Mapping[str, float], number: Callable[[str, float], str]) -> str:
    """List the numbers that tell a row from others; words of a study are told as words."""
    words = []
    for key, value in told.items():
        options = WORDS_OF.get(split_side(key)[0])
        words.append(
            number(key, value) if options is None else word_of_key(key, options[int(value)])
        )
    return ", ".join(words)


def word_of_key(key: str, word: str) -> str:
    """Say a word of a study: "the extensor's spring at the motor", "after flexion"."""
    common, side = split_side(key)
    table, _, name = common.partition(".")
    if name != "at":
        return f"{name} {word}"
    whose = f"the {side}'s " if side else ""
    return f"{whose}{table} at the {word}"
