"""Keys in which two studies differ in value, however each spells it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic_core import PydanticCustomError

from tendon_cli.quantities import Quantity
from tendon_cli.studies.contents import keys
from tendon_cli.studies.row_reading import flat_keys
from tendon_cli.studies.value_words import number_words, other_words, quantity_of, si_value
from tendon_cli.units import shorten

_OF_THE_FILE = ("study", "extends", "table")
"""Sources that are compared by what they give, not by their files."""
CHANGES_NOTHING = ("name", "title", "allow_implausible", "output", "figure")
"""Keys that change no number."""
_ROUNDING = 1e-12
"""Share of a value by which two spellings of it may differ."""
_DIGITS = range(3, 18)
"""Significant digits of numbers, of which as many are shown as tell two values apart."""
_HASH = 8
"""Digits of a SHA-256 that are shown."""
_MOST_CHARACTERS = 200
"""Most characters of a word or of the content of a file that a record has."""


@dataclass(frozen=True)
class Difference:
    """A key in which two studies differ, or a file that they name."""

    key: str
    """Dotted key; of rows `table.NAME.KEY` and `cases.KEY`."""
    unit: str | None
    """Unit of the numbers, SI; None for words and files."""
    a: Any
    """Value of the first study, as its record has it; None where it does not state the key."""
    b: Any
    """Value of the second."""
    shown: tuple[str, str]
    """Both in words."""


def study_differences(first: Mapping[str, Any], second: Mapping[str, Any]) -> list[Difference]:
    """List the keys in which two studies differ.

    Args:
        first: Record with the first `study`, resolved, and the `sources` of its numbers.
        second: The same of the second.
    """
    sources = (first.get("sources") or {}, second.get("sources") or {})
    files = {}
    for key in sorted({*sources[0], *sources[1]}):
        if key.partition(".")[0] in _OF_THE_FILE:
            continue
        a, b = (_file_words(source.get(key)) for source in sources)
        if a != b:
            files[key] = Difference(key, None, a, b, (a, b))
    documents = [_with_columns(record.get("study") or {}) for record in (first, second)]
    differing = _differing_keys(documents[0], documents[1])
    found = [
        _difference(key, *(_value_at(document, key) for document in documents))
        for key in dict.fromkeys(map(_whole_key, differing))
        if files.keys().isdisjoint((key, key.partition(".")[0]))
    ]
    return [*filter(None, found), *files.values()]


def _file_words(source: Mapping[str, Any] | None) -> str:
    """Return the name of a file with the beginning of its hash."""
    if source is None:
        return "no file"
    return f"{shorten(source['file'], 15)} ({source['sha256'][:_HASH]})"


# --- Which keys differ ----------------------------------------------------------------------------


def _with_columns(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return a document with cases and rows of tables as columns, by the key of each."""
    changed = dict(document)
    tables = {}
    for table in document.get("table", ()):
        columns = {header: cells for header, *cells in table["rows"]}
        tables[table["name"]] = {"role": table.get("role"), **columns}
    cases = [dict(flat_keys(case)) for case in document.get("cases", ())]
    set_by_cases = dict.fromkeys(key for case in cases for key in case)
    changed["table"] = tables
    changed["cases"] = {key: [case.get(key) for case in cases] for key in set_by_cases}
    return changed


def _differing_keys(first: Any, second: Any, key: str = "") -> Iterator[str]:
    """Yield the dotted keys in which two documents differ."""
    if isinstance(first, Mapping) and isinstance(second, Mapping):
        for name in sorted({*first, *second}):
            inner = f"{key}.{name}" if key else name
            yield from _differing_keys(first.get(name), second.get(name), inner)
    elif first != second:
        yield key


def _whole_key(key: str) -> str:
    """Return the key of the number in which a key stands, or the key itself."""
    parts = key.split(".")
    for depth in range(1, len(parts)):
        outer = ".".join(parts[:depth])
        if outer in keys():
            return outer
    return key


def _value_at(document: Mapping[str, Any], key: str) -> Any:
    """Return the value at a dotted key; None if it is not stated."""
    value: Any = document
    left = key
    while left:
        if not isinstance(value, Mapping):
            return None
        if left in value:  # a header of a table has dots of its own
            return value[left]
        name, _, left = left.partition(".")
        value = value.get(name)
    return value


# --- How they differ ------------------------------------------------------------------------------


def _difference(key: str, a: Any, b: Any) -> Difference | None:
    """Return the difference in a key; None if both values are the same, spelled differently."""
    quantity = _quantity(key)
    if quantity is None:
        words = (other_words(a), other_words(b))
        if words[0] == words[1]:
            words = (f"{words[0]} (one)", f"{words[1]} (another)")
        return Difference(key, None, _short(a), _short(b), words)
    if _is_same(key, a, b):
        return None
    words = (number_words(a, quantity), number_words(b, quantity))
    kinds = (_kind(a), _kind(b))
    if words[0] == words[1] and kinds[0] != kinds[1]:
        words = (f"{words[0]} ({kinds[0]})", f"{words[1]} ({kinds[1]})")
    for digits in _DIGITS:
        if words[0] != words[1]:
            break
        words = (number_words(a, quantity, digits), number_words(b, quantity, digits))
    if words[0] == words[1]:
        words = _first_that_differ(a, b, quantity)
    return Difference(key, quantity.unit, si_value(a, quantity), si_value(b, quantity), words)


def _kind(value: Any) -> str:
    """Return what several values of a number mean."""
    if not isinstance(value, Mapping):
        return "drawn evenly" if isinstance(value, str) else "stated"
    if "num" in value or "step" in value:
        return "a grid"
    if "std" in value:
        return "drawn from a normal distribution"
    return "drawn evenly" if "tolerance" in value else "every value"


def _quantity(key: str) -> Quantity | None:
    """Return the quantity of a key of numbers, or of a column of rows; None for words."""
    table, _, of_rows = key.partition(".")
    if table == "table":
        _, _, header = of_rows.partition(".")
        of_rows = header.partition(" (")[0]
    return quantity_of(of_rows if table in ("table", "cases") else key)


def _is_same(key: str, a: Any, b: Any) -> bool:
    """Return True if two values of a study are the same numbers, spelled differently."""
    if key not in keys() or a is None or b is None:
        return False
    try:
        first, second = (keys()[key].number.read(value) for value in (a, b))
    except PydanticCustomError:
        return False
    if first is None or second is None or first.uncertain or second.uncertain:
        return False
    if first.is_interval != second.is_interval or len(first) != len(second):
        return False
    return bool(np.allclose(first.array, second.array, rtol=_ROUNDING, atol=0.0))


def _first_that_differ(a: Any, b: Any, quantity: Quantity) -> tuple[str, str]:
    """Return the first values of two lists that differ, in words: "value 3: 4 kN/m"."""
    if isinstance(a, list) and isinstance(b, list):
        for place, pair in enumerate(zip(a, b, strict=False), 1):
            if pair[0] != pair[1]:
                first, second = (number_words(value, quantity, max(_DIGITS)) for value in pair)
                return f"value {place}: {first}", f"value {place}: {second}"
    return str(a), str(b)


def _short(value: Any) -> Any:
    """Return words for a record, without the packed content of files."""
    return shorten(value, _MOST_CHARACTERS) if isinstance(value, str) else value
