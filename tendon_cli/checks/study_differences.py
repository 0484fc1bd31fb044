"""Keys in which studies differ, with the value of each and its unit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypedDict

from tendon_cli import say
from tendon_cli.engine.records import differing_keys, value_in_short
from tendon_cli.model.limits import LIMITS
from tendon_cli.quantities import QUANTITIES, Quantity
from tendon_cli.studies.contents import keys
from tendon_cli.studies.study import EXTENDS, Study
from tendon_cli.units import UnitError, parse_measure, shorten

OF_THE_FILE = ("study", EXTENDS)
"""Sources that are files of a study itself: their content is compared key by key."""
_NOT_COMPARED = ("name", "title", "allow_implausible", "output")
"""Keys that change no number."""
_MOST_VALUES = 4
"""Most values of a list that are shown one by one."""
_LONGEST = 28
"""Most characters of a value in a table."""
_HASH = 8
"""Digits of a SHA-256 that are shown."""


class DifferenceRecord(TypedDict):
    """A key in which studies differ, or a file that they name, or the version of tendon."""

    key: str
    """Dotted key; "version" for that of tendon."""
    unit: str | None
    """Unit of the numbers, SI; null for words and files."""
    values: list[Any]
    """Value of each study, as its record has it; null where it does not state the key."""
    shown: list[str]
    """The same in words."""


def study_differences(studies: Sequence[Study], versions: Sequence[str]) -> list[DifferenceRecord]:
    """List the keys in which any of several studies differs from the first.

    Args:
        studies: The studies.
        versions: Version of tendon that wrote the result of each.
    """
    documents = [study.document() for study in studies]
    found: dict[str, None] = {}
    for document in documents[1:]:
        for difference in differing_keys(documents[0], document):
            found.setdefault(_whole_key(difference.key))
    compared = [key for key in found if key.partition(".")[0] not in _NOT_COMPARED]
    records = [
        _difference(key, [_value_at(document, key) for document in documents]) for key in compared
    ]
    records += _files(studies)
    if len(set(versions)) > 1:
        records.append(_words("version", [f"tendon {version}" for version in versions]))
    return records


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
    for part in key.split("."):
        if not isinstance(value, Mapping):
            return None
        value = value.get(part)
    return value


def _difference(key: str, values: list[Any]) -> DifferenceRecord:
    """Return the record of a key in which studies differ."""
    quantity = _quantity_of(key)
    if quantity is None:
        return {
            "key": key,
            "unit": None,
            "values": [_without_content(value) for value in values],
            "shown": [_shown_words(value) for value in values],
        }
    return {
        "key": key,
        "unit": quantity.unit,
        "values": [_si(value, quantity) for value in values],
        "shown": [_shown_number(value, quantity) for value in values],
    }


def _quantity_of(key: str) -> Quantity | None:
    """Return the quantity of a key of numbers; None for words."""
    if key in keys():
        return keys()[key].number.quantity
    table, _, name = key.partition(".")
    if table == "limits" and name in LIMITS:
        return QUANTITIES[LIMITS[name].column]
    return None


def _si(value: Any, quantity: Quantity) -> Any:
    """Return a value of a resolved study with numbers in SI, where it has text with a unit."""
    if isinstance(value, list):
        return [_si(item, quantity) for item in value]
    if isinstance(value, Mapping):
        return {name: _si(inner, quantity) for name, inner in value.items()}
    if not isinstance(value, str):
        return value
    try:
        return parse_measure(value, quantity.dimension).si
    except UnitError:
        return value  # a word, such as "rigid", or a tolerance that is a share


def _shown_number(value: Any, quantity: Quantity) -> str:
    """Return the number of a study in words: one value, a list, a grid or a distribution."""
    number = _si(value, quantity)
    if isinstance(number, float):
        return say.quantity(quantity, number)
    if isinstance(number, list) and number:
        return shorten(_shown_list(number, quantity), _LONGEST)
    if isinstance(number, Mapping):
        return shorten(_shown_table(number, quantity), _LONGEST)
    return _shown_words(value)


def _shown_list(numbers: Sequence[Any], quantity: Quantity) -> str:
    """Return the values of a list in words; of a long one both ends."""
    if len(numbers) <= _MOST_VALUES:
        return ", ".join(_shown_number(item, quantity) for item in numbers)
    first = _shown_number(numbers[0], quantity)
    last = _shown_number(numbers[-1], quantity)
    return f"{first} to {last}, {len(numbers):,} values"


def _shown_table(number: Mapping[str, Any], quantity: Quantity) -> str:
    """Return a grid, an interval, a distribution or a curve in words."""
    texts = {
        name: say.quantity(quantity, inner) if isinstance(inner, float) else str(inner)
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


def _shown_words(value: Any) -> str:
    """Return a value that is no number in words."""
    if isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
        names = [str(item.get("name", "")) for item in value]
        return shorten(f"{len(value)}: {', '.join(filter(None, names))}", _LONGEST)
    if isinstance(value, Mapping):
        return shorten(", ".join(f"{name} {inner}" for name, inner in value.items()), _LONGEST)
    if isinstance(value, str):
        return shorten(value, _LONGEST)
    return shorten(value_in_short(value), _LONGEST)


def _without_content(value: Any) -> Any:
    """Return a value that is no number for JSON, without the packed content of files."""
    return shorten(value, 200) if isinstance(value, str) else value


def _words(key: str, values: list[str]) -> DifferenceRecord:
    """Return the record of words that differ."""
    return {"key": key, "unit": None, "values": values, "shown": values}


def _files(studies: Sequence[Study]) -> list[DifferenceRecord]:
    """List the files that studies name and whose contents differ, by the key that names each."""
    named = dict.fromkeys(key for study in studies for key in study.sources)
    records = []
    for key in named:
        if key.partition(".")[0] in OF_THE_FILE:
            continue
        sources = [study.sources.get(key) for study in studies]
        sums = {None if source is None else source["sha256"] for source in sources}
        if len(sums) > 1:
            records.append(_words(key, [_file_words(source) for source in sources]))
    return records


def _file_words(source: Mapping[str, Any] | None) -> str:
    """Return the name of a file with the beginning of its hash."""
    if source is None:
        return "no file"
    return f"{shorten(source['file'], 15)} ({source['sha256'][:_HASH]})"
