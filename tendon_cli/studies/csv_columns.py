"""Columns of numbers from a CSV beside a study: by name, with units in the header."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tendon_cli.cells import SEPARATORS, cells_of, is_comment, lines_of, texts_of
from tendon_cli.errors import InputError
from tendon_cli.model.kinematics import Array
from tendon_cli.units import UNITS, factor_of, known_units, shorten

_NUMBER = r"^[+-]?([0-9]{1,40}\.?[0-9]{0,40}|\.[0-9]{1,40})([eE][+-]?[0-9]{1,3})?$"
_LARGEST = 1e9


@dataclass(frozen=True, eq=False)
class Sheet:
    """The columns of a file whose first line that is no comment is its header."""

    where: str
    header: list[str]
    header_line: int
    lines: list[str]
    """Of the whole file, the first of which is line 1."""
    kept: list[int]
    """The places of the rows among the lines."""
    separator: str
    columns: list[Any]

    @classmethod
    def of(cls, content: bytes, where: str, row: str) -> Sheet:
        """Comma, semicolon or tab stands between cells; `row` is what one is of. Raises InputError."""
        lines = lines_of(content, where)
        kept = [at for at, line in enumerate(lines) if not is_comment(line)]
        separator = next((sign for sign in SEPARATORS if kept and sign in lines[kept[0]]), ",")
        header = cells_of(lines[kept[0]], separator, f"{where}, line {kept[0] + 1}") if kept else []
        if len(kept) < 2:
            raise InputError(
                f"holds no {row}s, expected a header and a line for each {row}", where=where
            )
        columns = texts_of(lines, kept[1:], separator, where, len(header), len(header))
        return cls(where, header, kept[0] + 1, lines, kept[1:], separator, columns)

    def place(self, row: int) -> str:
        """Where a row stands, as errors say it."""
        return f"{self.where}, line {self.kept[row] + 1}"

    def numbers(self, at: int, name: str, missing: tuple[str, ...] = ()) -> Array:
        """A column's numbers, NaN where a cell says that there is none; beside other separators a comma is decimal."""
        import pyarrow as pa
        import pyarrow.compute as pc

        texts = (
            self.columns[at]
            if self.separator == ","
            else pc.replace_substring(self.columns[at], ",", ".")
        )
        is_missing = pc.is_in(pc.utf8_lower(texts), value_set=pa.array(missing, pa.string()))
        is_number = pc.or_(is_missing, pc.match_substring_regex(texts, _NUMBER))
        if (row := pc.index(is_number, False).as_py()) >= 0:
            problem = f'{name} is "{shorten(self.columns[at][row].as_py())}", expected a number'
            hint = f"units belong in the header; the line reads: {shorten(self.lines[self.kept[row]].strip())}"
            raise InputError(problem, where=self.place(row), hint=hint)
        plain = pc.utf8_ltrim(pc.if_else(is_missing, "nan", texts), "+")
        return np.asarray(pc.cast(plain, pa.float64()).to_numpy(zero_copy_only=False))


def name_and_unit(header: str, names: tuple[str, ...]) -> tuple[str, str] | None:
    """The name that a header begins with, and the unit that follows it; None for none of the names."""
    for name in names:
        spelled = name.replace("_", r"[\W_]*")
        if match := re.fullmatch(
            rf"\s*{spelled}(?:[\s_]*[\[(_ ]\s*(.*?)\s*[\])]?)?\s*", header, re.IGNORECASE
        ):
            return name, match[1] or ""
    return None


def unit_factor(name: str, unit: str, dimension: str, where: str) -> float:
    """SI values per value in a column; raises InputError for one without unit, or of another dimension."""
    plain = {_plain(symbol): symbol for symbol in reversed(known_units(dimension))}
    symbol = unit if unit in UNITS else plain.get(_plain(unit), "")
    if unit and symbol in UNITS and UNITS[symbol].dimension == dimension:
        return factor_of(symbol)
    problem = (
        f'the column {name} has the unit "{shorten(unit)}"'
        if unit
        else f"the column {name} has no unit"
    )
    units = ", ".join(known_units(dimension))
    hint = f"such as {name} ({known_units(dimension)[0]}); units of {dimension}: {units}"
    raise InputError(problem, where=where, hint=hint)


def _plain(symbol: str) -> str:
    return re.sub(r"[\s_·*.]", "", symbol).lower()


def read_columns(
    content: bytes, where: str, columns: Mapping[str, str], of: str, unit: str = ""
) -> tuple[Array, list[int]]:
    """Columns of SI numbers, shape (columns, rows), and the line of each row; `columns` has the dimension of each.

    A header is a name with its unit, such as `angle (deg)` or `torque_Nm`; `unit` is that of one without. `of` is what
    a row is of. Raises InputError with the line at fault.
    """
    sheet = Sheet.of(content, where, of)
    place, numbers = f"{where}, line {sheet.header_line}", []
    for name, dimension in columns.items():
        named = [
            (at, each[1])
            for at, text in enumerate(sheet.header)
            if (each := name_and_unit(text, (name,)))
        ]
        if not named:
            problem = f"no column {name}, the header reads: {shorten(', '.join(sheet.header))}"
            raise InputError(
                problem, where=place, hint=f"such as {name} ({unit or known_units(dimension)[0]})"
            )
        factor = unit_factor(name, named[0][1] or unit, dimension, place)
        values = sheet.numbers(named[0][0], name)
        if (beyond := np.flatnonzero(np.abs(values) > _LARGEST)).size:
            problem = f"{name} is {values[beyond[0]]:g}, expected {_LARGEST:g} at most"
            raise InputError(problem, where=sheet.place(int(beyond[0])))
        numbers.append(values * factor)
    return np.array(numbers), [at + 1 for at in sheet.kept]
