"""Columns of numbers from a CSV beside a study: by name, with units in the header."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from tendon_cli.cells import (
    SEPARATORS,
    cells_of,
    is_comment,
    lines_of,
    not_read,
    raise_all,
    split_rows,
)
from tendon_cli.errors import InputError
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.studies.magnitude import Slip, hint_at_units
from tendon_cli.units import UNITS, factor_of, known_units, shorten

_NUMBER = r"^[+-]?([0-9]{1,40}\.?[0-9]{0,40}|\.[0-9]{1,40})([eE][+-]?[0-9]{1,3})?$"
"""Pattern of a number."""
_LARGEST = 1e9
"""Largest magnitude of a number, in the unit of its column."""


@dataclass(frozen=True, eq=False)
class Sheet:
    """Columns of a CSV; its header is the first line that is not a comment."""

    where: str
    """Name of the file in errors."""
    header: list[str]
    """Cells of the header."""
    header_line: int
    """Line of the header, counted from 1."""
    lines: list[str]
    """All lines of the file."""
    kept: list[int]
    """Places of the rows that have all their cells among the lines, counted from 0."""
    separator: str
    """Comma, semicolon or tab."""
    columns: list[Any]
    """Texts of each column, as arrays of Arrow or as plain lists."""
    faults: list[InputError] = field(default_factory=list)
    """Faults found so far, first those of rows that are left out as they lack cells.

    `raise_faults` raises them as one error.
    """

    @classmethod
    def of(cls, content: bytes, where: str, row: str, *, as_lists: bool = False) -> Sheet:
        """Return the sheet of a file, with a comma, semicolon or tab between cells.

        Rows with too few or too many cells are left out, and are faults of the sheet.

        Args:
            content: The file.
            where: Name of the file in errors.
            row: Noun for what a row describes, such as "person".
            as_lists: True for columns of plain lists, for cells that are read one by one.

        Raises:
            InputError: The file is not such a table, or none of its rows has all cells.
        """
        lines = lines_of(content, where)
        kept = [place for place, line in enumerate(lines) if not is_comment(line)]
        separator = ","
        header = []
        if kept:
            first = lines[kept[0]]
            separator = next((sign for sign in SEPARATORS if sign in first), ",")
            header = cells_of(first, separator, f"{where}, line {kept[0] + 1}")
        if len(kept) < 2:
            problem = f"holds no {row}s, expected a header and a line for each {row}"
            raise InputError(problem, where=where)
        split = split_rows(lines, kept[1:], separator, where, len(header), len(header))
        if not split.rows:
            raise_all(split.faults, where)
        return cls(
            where=where,
            header=header,
            header_line=kept[0] + 1,
            lines=lines,
            kept=split.places,
            separator=separator,
            columns=split.lists() if as_lists else split.arrays(),
            faults=split.faults,
        )

    def place(self, row: int) -> str:
        """Return file and line of a row, for errors."""
        return f"{self.where}, line {self.kept[row] + 1}"

    @property
    def header_place(self) -> str:
        """File and line of the header, for errors."""
        return f"{self.where}, line {self.header_line}"

    def find(self, name: str) -> tuple[int, str] | None:
        """Return place and unit of the first column of a name; None if there is none."""
        for at, text in enumerate(self.header):
            known = name_and_unit(text, (name,))
            if known is not None:
                return at, known[1]
        return None

    def lacks(self, name: str, hint: str) -> InputError:
        """Return the error that there is no column of a name."""
        problem = f"no column {name}, the header reads: {shorten(', '.join(self.header))}"
        return InputError(problem, where=self.header_place, hint=hint)

    def ignored(self, places: set[int]) -> list[str]:
        """Return a note that names the columns that are not at these places; empty if none is."""
        names = [text for place, text in enumerate(self.header) if place not in places]
        return not_read(names, self.where)

    def refuse(self, row: int, problem: str, hint: str | None = None) -> None:
        """Add a fault of a row."""
        self.faults.append(InputError(problem, where=self.place(row), hint=hint))

    @contextmanager
    def collected(self) -> Iterator[None]:
        """Keep an InputError for `raise_faults`, so that others of the file are found, too."""
        try:
            yield
        except InputError as error:
            self.faults.append(error)

    def raise_faults(self, slips: Sequence[Slip] = ()) -> None:
        """Raise all faults found so far as one InputError, if there are any.

        Args:
            slips: Values far from any arm, which are told beside the faults. They are no faults by
                themselves: a study may accept them.
        """
        if not self.faults:
            return
        implausible = [
            InputError(
                replace(slip, place="").problem,
                where=slip.place,
                hint=hint_at_units(slip.suggestions),
            )
            for slip in slips
        ]
        raise_all([*self.faults, *implausible], self.where)

    def numbers(self, at: int, name: str, missing: tuple[str, ...] = ()) -> Array:
        """Return the numbers of a column.

        Commas are decimal unless they separate cells. A cell that is neither a number nor missing
        is a fault, and NaN.

        Args:
            at: Place of the column.
            name: Name of the column in errors.
            missing: Texts of cells without a number, which become NaN.
        """
        import pyarrow as pa
        import pyarrow.compute as pc

        texts = self.columns[at]
        if self.separator != ",":
            texts = pc.replace_substring(texts, ",", ".")
        is_number = pc.match_substring_regex(texts, _NUMBER)
        is_good = is_number.to_numpy(zero_copy_only=False) | self.is_missing(at, missing)
        for row in np.flatnonzero(~is_good).tolist():
            found = shorten(self.columns[at][row].as_py())
            line = shorten(self.lines[self.kept[row]].strip())
            hint = f"units belong in the header; the line reads: {line}"
            problem = f'{name} is "{found}", expected a number'
            self.refuse(row, problem, hint)
        plain = pc.utf8_ltrim(pc.if_else(is_number, texts, "nan"), "+")
        return np.asarray(pc.cast(plain, pa.float64()).to_numpy(zero_copy_only=False))

    def is_missing(self, at: int, missing: tuple[str, ...]) -> Flags:
        """Return a mask of the cells of a column that say that there is no number, (rows,).

        Args:
            at: Place of the column.
            missing: Texts of such cells in lower case.
        """
        import pyarrow as pa
        import pyarrow.compute as pc

        words = pa.array(missing, pa.string())
        found = pc.is_in(pc.utf8_lower(self.columns[at]), value_set=words)
        return np.asarray(found.to_numpy(zero_copy_only=False))


def name_and_unit(header: str, names: tuple[str, ...]) -> tuple[str, str] | None:
    """Return the name that a header begins with, and its unit; None if it has none of the names.

    The unit is empty if the header does not say it.
    """
    for name in names:
        spelled = name.replace("_", r"[\W_]*")
        unit = r"(?:[\s_]*[\[(_ ]\s*(.*?)\s*[\])]?)?"
        match = re.fullmatch(rf"\s*{spelled}{unit}\s*", header, re.IGNORECASE)
        if match:
            return name, match[1] or ""
    return None


def unit_symbol(name: str, unit: str, dimension: str, where: str) -> str:
    """Return the symbol of the unit of a column.

    Args:
        name: Name of the column.
        unit: Unit as its header has it, empty if there is none.
        dimension: Dimension of its quantity.
        where: Place of the header in errors.

    Raises:
        InputError: There is no unit, or one of another dimension.
    """
    known = known_units(dimension)
    plain = {_plain(symbol): symbol for symbol in reversed(known)}
    symbol = unit if unit in UNITS else plain.get(_plain(unit), "")
    if unit and symbol in UNITS and UNITS[symbol].dimension == dimension:
        return symbol
    problem = f"the column {name} has no unit"
    if unit:
        problem = f'the column {name} has the unit "{shorten(unit)}"'
    hint = f"such as {name} ({known[0]}); units of {dimension}: {', '.join(known)}"
    raise InputError(problem, where=where, hint=hint)


def _plain(symbol: str) -> str:
    """Return a unit without signs between its parts, in lower case."""
    return re.sub(r"[\s_·*.]", "", symbol).lower()


@dataclass(frozen=True)
class ReadColumns:
    """Columns of numbers that were read from a CSV."""

    values: Array
    """Numbers, (columns, rows), SI."""
    lines: list[int]
    """Line of each row, counted from 1."""
    notes: list[str]
    """Note that names the columns that are not read, if there are any."""
    units: list[str]
    """Symbol of the unit of each column as the file has it; empty for a faulty header."""


def read_columns(
    content: bytes, where: str, columns: Mapping[str, str], row: str, unit: str = ""
) -> ReadColumns:
    """Return columns of numbers, as `collect_columns` reads them.

    Args:
        content: The file.
        where: Name of the file in errors.
        columns: Dimension of each column by its name.
        row: Noun for what a row describes, such as "way-point".
        unit: Unit of a column whose header has none.

    Raises:
        InputError: Columns are missing, have no unit, or hold no numbers; the error names the lines
            of all faults.
    """
    sheet = Sheet.of(content, where, row)
    read = collect_columns(sheet, columns, unit)
    sheet.raise_faults()
    return read


def collect_columns(
    sheet: Sheet, columns: Mapping[str, str], unit: str = "", meaning: str = ""
) -> ReadColumns:
    """Return columns of numbers; what cannot be read is a fault of the sheet, and NaN.

    A header is a name with its unit, such as `angle (deg)` or `torque_Nm`.

    Args:
        sheet: The file as texts.
        columns: Dimension of each column by its name.
        unit: Unit of a column whose header has none.
        meaning: What the numbers mean, such as their sign, for errors on a missing column.
    """
    numbers = np.full((len(columns), len(sheet.kept)), np.nan)
    units = [""] * len(columns)
    places = set()
    for number, (name, dimension) in enumerate(columns.items()):
        with sheet.collected():
            column = sheet.find(name)
            if column is None:
                example = f"such as {name} ({unit or known_units(dimension)[0]})"
                raise sheet.lacks(name, "; ".join(filter(None, (example, meaning))))
            at, own_unit = column
            places.add(at)
            values = sheet.numbers(at, name)
            for place in np.flatnonzero(np.abs(values) > _LARGEST).tolist():
                sheet.refuse(place, f"{name} is {values[place]:g}, expected {_LARGEST:g} at most")
            symbol = unit_symbol(name, own_unit or unit, dimension, sheet.header_place)
            numbers[number] = values * factor_of(symbol)
            units[number] = symbol
    lines = [place + 1 for place in sheet.kept]
    return ReadColumns(numbers, lines, sheet.ignored(places), units)
