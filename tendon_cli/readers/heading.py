"""Headings of tables: the name and the unit of a column that its header says."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

from tendon_cli.units import SENSOR_UNITS, UNITS, shorten, written_unit

_BRACKETS = re.compile(r"[(\[{]([^()\[\]{}]*)[)\]}]")
_LAST_BRACKETS = re.compile(r"(.*?)\s*[(\[{](.*)[)\]}]", re.DOTALL)
_NEVER_LAST = ("1", "%", "in", "t")
"""Units that end a header without brackets for other reasons: "force in", "F_t"."""
_ONLY_WITH = {"A": "current|strom|amp", "min": "time|zeit|duration"}
"""Words without which a header means something else: "cell A", "force_min"."""
_CLOCKS = {"millis": "ms", "micros": "us", "nanos": "ns"}
"""Units of clocks that are called by them."""
_LONGEST_UNIT = 8
"""Most letters of an unknown unit that ends a header without brackets."""


@dataclass(frozen=True)
class Heading:
    """Column of a table: its place from 0, its header as written, and what the header says."""

    index: int
    header: str
    name: str
    """Header without its unit."""
    unit: str
    """Symbol of the unit; text in brackets if it is no unit that is known; empty if none is."""

    @classmethod
    def of(cls, index: int, header: str) -> Heading:
        """Read a header: units may be in brackets, behind a slash or an underscore, or spoken."""
        return cls(index, header, *_name_and_unit(header))

    @property
    def shown(self) -> str:
        """Header as messages quote it."""
        return f'"{shorten(self.header, 30)}"'

    @property
    def dimension(self) -> str:
        """Dimension of the unit; empty if there is none, or none that is known."""
        unit = UNITS.get(self.unit) or SENSOR_UNITS.get(self.unit)
        return "" if unit is None else unit.dimension

    @property
    def clock(self) -> str:
        """Unit of time that the name itself is, such as "millis"; empty if it is none."""
        return next((unit for word, unit in _CLOCKS.items() if word in self.words), "")

    @property
    def column(self) -> str:
        """Name as that of a column of ours: letters, digits and `_`."""
        return re.sub(r"\W+", "_", self.name).strip("_")

    @property
    def text(self) -> str:
        """Header without a unit that is known."""
        return self.name if self.dimension or not self.unit else f"{self.name} {self.unit}"

    @cached_property
    def words(self) -> set[str]:
        """Words and numbers of the header without case."""
        return set(re.findall(r"[^\W\d_]+|\d+", self.text.casefold()))


def _name_and_unit(header: str) -> tuple[str, str]:
    """Split a header into its name and its unit, empty if it says none."""
    text = unicodedata.normalize("NFKC", header).strip()
    for match in _BRACKETS.finditer(text):
        unit = _unit_in(match[1], text)
        if unit not in ("", "1"):
            return f"{text[: match.start()]} {text[match.end() :]}".strip(), unit
    for match in re.finditer(r"[\s_,/]+", text):
        name = text[: match.start()]
        unit = _unit_in(text[match.end() :], text)
        if unit and unit not in _NEVER_LAST and re.search(r"\w", name):
            return re.sub(r"[\s_]in$", "", name), unit
    last = _LAST_BRACKETS.fullmatch(text)
    return (text, "") if last is None else (last[1], last[2].strip())


def _unit_in(text: str, header: str) -> str:
    """Return the symbol of the unit that a part of a header is; empty if it is none."""
    unit = written_unit(text)
    if unit is None:
        return ""
    needs = _ONLY_WITH.get(unit.symbol)
    return unit.symbol if needs is None or re.search(needs, header, re.IGNORECASE) else ""


def columns_named(columns: Iterable[Heading], names: Iterable[str]) -> list[Heading]:
    """Return the columns of some names, whatever their case and the signs between their words.

    If none is, a name that is followed by a short word has that word as its unit: "torque_foo".
    """
    columns = list(columns)
    plain = {_plain(name) for name in names}
    found = [column for column in columns if _plain(column.name) in plain]
    if found:
        return found
    for column in columns:
        name, _, unit = re.sub(r"[\s_]+", " ", column.name).rpartition(" ")
        if not column.unit and _plain(name) in plain and len(unit) <= _LONGEST_UNIT:
            found.append(replace(column, name=name, unit=unit))
    return found


def column_called(columns: Iterable[Heading], given: str) -> Heading | None:
    """Return the only column with a header, with or without its unit, or of a number from 1.

    Return None if there is none, or several have the header.
    """
    columns = list(columns)
    given = given.strip()
    found = [column for column in columns if column.header == given]
    if not found:
        found = [column for column in columns if column.header.casefold() == given.casefold()]
    if not found:
        found = [column for column in columns if column.name.casefold() == given.casefold()]
    if not found and given.isdecimal():
        found = [column for column in columns if column.index + 1 == int(given)]
    return found[0] if len(found) == 1 else None


def _plain(name: str) -> str:
    return re.sub(r"[\W_]+", "", name.casefold())
