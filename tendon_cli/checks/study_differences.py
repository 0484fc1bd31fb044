"""Keys in which studies differ, with the value of each and its unit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypedDict

from tendon_cli.engine.records import differing_keys
from tendon_cli.studies.contents import keys
from tendon_cli.studies.study import EXTENDS, Study
from tendon_cli.studies.value_words import number_words, other_words, quantity_of, si_value
from tendon_cli.units import shorten

OF_THE_FILE = ("study", EXTENDS)
"""Sources that are files of a study itself: their content is compared key by key."""
_NOT_COMPARED = ("name", "title", "allow_implausible", "output")
"""Keys that change no number."""
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
    files = _files(studies)
    told = {*_NOT_COMPARED, *(file["key"] for file in files)}
    compared = [key for key in found if told.isdisjoint((key, key.partition(".")[0]))]
    records = [
        _difference(key, [_value_at(document, key) for document in documents]) for key in compared
    ]
    records += files
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
    quantity = quantity_of(key)
    if quantity is None:
        return {
            "key": key,
            "unit": None,
            "values": [_without_content(value) for value in values],
            "shown": [other_words(value) for value in values],
        }
    return {
        "key": key,
        "unit": quantity.unit,
        "values": [si_value(value, quantity) for value in values],
        "shown": [number_words(value, quantity) for value in values],
    }


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
