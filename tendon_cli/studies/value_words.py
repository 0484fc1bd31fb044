"""Values of a resolved study in words: numbers with their units, lists, grids and tables."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from tendon_cli import say
from tendon_cli.model.limits import LIMITS
from tendon_cli.quantities import QUANTITIES, Quantity
from tendon_cli.studies.contents import keys
from tendon_cli.units import UnitError, parse_measure, shorten

_MOST_VALUES = 4
"""Most values of a list that are shown one by one."""
_LONGEST = 28
"""Most characters of a value in a table."""


def quantity_of(key: str) -> Quantity | None:
    """Return the quantity of a key of numbers; None for words."""
    if key in keys():
        return keys()[key].number.quantity
    table, _, name = key.partition(".")
    if table == "limits" and name in LIMITS:
        return QUANTITIES[LIMITS[name].column]
    return None


def si_value(value: Any, quantity: Quantity) -> Any:
    """Return a value of a resolved study with numbers in SI, where it has text with a unit."""
    if isinstance(value, list):
        return [si_value(item, quantity) for item in value]
    if isinstance(value, Mapping):
        return {name: si_value(inner, quantity) for name, inner in value.items()}
    if not isinstance(value, str):
        return value
    try:
        return parse_measure(value, quantity.dimension).si
    except UnitError:
        return value  # a word, such as "rigid", or a tolerance that is a share


def number_words(value: Any, quantity: Quantity, digits: int = 3) -> str:
    """Return the number of a study in words: one value, a list, a grid or a distribution.

    Args:
        value: The number as a record has it.
        quantity: Its quantity.
        digits: Number of significant digits.
    """
    number = si_value(value, quantity)
    if isinstance(number, float):
        return say.quantity(quantity, number, digits)
    if isinstance(number, list) and number:
        return shorten(_shown_list(number, quantity, digits), _LONGEST)
    if isinstance(number, Mapping):
        return shorten(_shown_table(number, quantity, digits), _LONGEST)
    return other_words(value)


def _shown_list(numbers: Sequence[Any], quantity: Quantity, digits: int) -> str:
    """Return the values of a list in words; of a long one both ends."""
    if len(numbers) <= _MOST_VALUES:
        return ", ".join(number_words(item, quantity, digits) for item in numbers)
    first = number_words(numbers[0], quantity, digits)
    last = number_words(numbers[-1], quantity, digits)
    return f"{first} to {last}, {len(numbers):,} values"


def _shown_table(number: Mapping[str, Any], quantity: Quantity, digits: int) -> str:
    """Return a grid, an interval, a distribution or a curve in words."""
    texts = {
        name: say.quantity(quantity, inner, digits) if isinstance(inner, float) else str(inner)
        for name, inner in number.items()
    }
    middle = texts.get("mean", texts.get("value"))
    spread = texts.get("std", texts.get("tolerance"))
    if middle is not None:
        return f"{middle} ± {spread}"
    if {"from", "to"} <= texts.keys():
        count = f", {texts['num']} values" if "num" in texts else ""
        return f"{texts['from']} to {texts['to']}{count}"
    return value_in_short(dict(number))


def other_words(value: Any) -> str:
    """Return a value that is no number in words."""
    if isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
        names = [str(item.get("name", "")) for item in value]
        return shorten(f"{len(value)}: {', '.join(filter(None, names))}", _LONGEST)
    if isinstance(value, Mapping):
        return shorten(", ".join(f"{name} {inner}" for name, inner in value.items()), _LONGEST)
    if isinstance(value, str):
        return shorten(value, _LONGEST)
    return shorten(value_in_short(value), _LONGEST)


def value_in_short(value: Any) -> str:
    """Return a value of a study for a message, without the content of files."""
    if value is None:
        return "not stated"
    if isinstance(value, dict):
        return f"{{{', '.join(value)}}}"
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 60 else f"{text[:57]}..."
