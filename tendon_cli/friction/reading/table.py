"""Tables of readings: a file as columns of text, and columns of text as numbers."""

from __future__ import annotations

import errno
import hashlib
import os
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn, TypeAlias

import numpy as np
import pandas as pd

from tendon_cli import say
from tendon_cli.cells import (
    SEPARATORS,
    cells_of,
    is_comment,
    lines_of,
    not_read,
    raise_all,
    split_rows,
)
from tendon_cli.errors import InputError, TendonError, UsageError
from tendon_cli.files import read_file
from tendon_cli.friction.reading.header import Heading, find_cells, read_header
from tendon_cli.units import shorten

MOST_BYTES = 64_000_000
"""Largest size of a file, bytes."""
MOST_ROWS = 1_000_000
"""Largest number of readings."""
_HEADER_WITHIN = 200
"""Number of lines at the beginning in which the header is looked for."""
_PLAIN_START = frozenset("0123456789+-.abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ")
"""First characters of lines that are no comment, so that most lines need no further test."""
_NUMBER = r"[+-]?(?:[0-9]{1,40}(?:[.,][0-9]{0,40})?|[.,][0-9]{1,40})(?:[eE][+-]?[0-9]{1,3})?"
_MISSING = ("", "nan", "na", "n/a", "null", "none", "-", "--", "?", "1.#qnan")
_DECIMAL_COMMA = "a decimal comma read as a separator? separate the columns by semicolons"


@dataclass
class Table:
    """Columns of a file or of a frame, row by row."""

    source: str
    """Name of the file without its folder."""
    sha256: str
    columns: list[Heading]
    cells: tuple[Heading, ...]
    """Columns by which the header was found: of readings of friction the two cells."""
    lines: np.ndarray
    """Line of each row."""
    data: list[Any]
    """Columns: pyarrow arrays of strings of a file, arrays of values of a frame."""
    header: int | None = None
    """Line of the header; None in a frame."""
    separator: str = ""
    decimal: str = ""
    """Decimal sign, known from the first number that has one."""
    comments: list[str] = field(default_factory=list)
    """Comments above the header."""
    faults: list[InputError] = field(default_factory=list)
    """Faults found so far; `raise_faults` raises them as one error."""

    def place(self, column: Heading, row: int | None = None) -> str:
        """Return line and column of a header, or of a row of its column."""
        if self.header is None:
            return f"column {column.shown}"
        line = self.header if row is None else self.lines[row]
        return f"{self.source}, line {line}, column {column.index + 1}"

    def find(self, role: str) -> Heading | None:
        """Return the one column of a role; None if there is none. Refuse two."""
        matches = [column for column in self.columns if column.role == role]
        if len(matches) > 1:
            where = self.source if self.header is None else f"{self.source}, line {self.header}"
            raise InputError(f"two columns give the {say.spaced(role)}", where=where)
        return matches[0] if matches else None

    def names(self, column: Heading) -> Any:
        """Return a column of names, as a pandas Categorical."""
        data = self.data[column.index]
        if isinstance(data, np.ndarray):
            return pd.Categorical([str(value) for value in data.tolist()])
        coded = data.dictionary_encode()
        return pd.Categorical.from_codes(
            coded.indices.to_numpy(), categories=coded.dictionary.to_pylist()
        )

    def raise_faults(self) -> None:
        """Raise all faults found so far as one InputError, if there are any."""
        raise_all(self.faults, self.source)

    def unread(self, columns: Iterable[Heading | None]) -> list[str]:
        """Return a note that names the columns that are not among these."""
        read = {column.index for column in columns if column}
        names = [column.header for column in self.columns if column.index not in read]
        return not_read(names, self.source)

    def numbers(self, column: Heading) -> np.ndarray:
        """Return a column's numbers; NaN for a cell that is empty or says there is no reading.

        A cell that is anything else is a fault, and NaN.
        """
        values, faults = self.parsed(column)
        self.faults += faults
        return values

    def parsed(self, column: Heading) -> tuple[np.ndarray, list[InputError]]:
        """Return a column's numbers, NaN without one, and the faults of its cells."""
        data = self.data[column.index]
        faults: list[InputError] = []
        if isinstance(data, np.ndarray):
            try:
                values = np.asarray(data.astype(np.float64))
            except (TypeError, ValueError):
                fault = InputError("is not a column of numbers", where=self.place(column))
                return np.full(len(data), np.nan), [fault]
        else:
            values = self._parsed_texts(column, faults)
        for row in np.flatnonzero(np.isinf(values)).tolist():
            problem = f'"{shorten(str(data[row]))}" is too large for a number'
            faults.append(InputError(problem, where=self.place(column, row)))
        return np.where(np.isinf(values), np.nan, values), faults

    def _parsed_texts(self, column: Heading, faults: list[InputError]) -> np.ndarray:
        """Parse a column of texts, and add the faults of its cells to `faults`."""
        import pyarrow as pa
        import pyarrow.compute as pc

        text = pc.replace_substring(self.data[column.index], "\u2212", "-")
        missing = pc.is_in(pc.utf8_lower(text), value_set=pa.array(_MISSING))
        is_number = pc.match_substring_regex(text, f"^{_NUMBER}$")
        good = pc.or_(missing, is_number)
        for row in np.flatnonzero(~good.to_numpy(zero_copy_only=False)).tolist():
            problem = f'"{shorten(text[row].as_py())}" is not a number'
            hint = "write numbers without units and without thousands separators"
            faults.append(InputError(problem, where=self.place(column, row), hint=hint))
        try:
            self._check_signs(pc.if_else(is_number, text, ""), column)
        except InputError as error:
            faults.append(error)
        plain = pc.utf8_ltrim(pc.replace_substring(text, ",", "."), "+")
        numbers = pc.if_else(is_number, plain, "nan")
        try:
            values = pc.cast(numbers, pa.float64())
        except pa.ArrowInvalid:  # how some versions of Arrow take a number above 1e308
            return np.array([float(text) for text in numbers.to_pylist()])
        return np.asarray(values.to_numpy(zero_copy_only=False))

    def _check_signs(self, text: Any, column: Heading) -> None:
        """Refuse a second decimal sign in the file, and one that may separate thousands."""
        import pyarrow.compute as pc

        def first(mask: Any) -> int | None:
            """Return the first row of a mask, None if there is none."""
            row = pc.index(mask, True).as_py()
            return None if row < 0 else int(row)

        def refuse(row: int, problem: str, hint: str | None = None) -> NoReturn:
            """Raise for a row; `problem` has a place for its text."""
            shown = problem.format(text[row].as_py())
            raise InputError(shown, where=self.place(column, row), hint=hint)

        signs = {}  # first row that has each decimal sign
        for sign in ",.":
            row = first(pc.match_substring(text, sign))
            if row is not None:
                signs[sign] = row
        if self.separator == ",":
            row = first(pc.match_substring_regex(text, r"^[+-]?0[0-9]+$"))
            if row is not None:
                refuse(row, '"{}" begins with a zero', _DECIMAL_COMMA)
            if "," in signs:
                problem = '"{}" has a comma, which may be a decimal sign or separate thousands'
                hint = "in a file separated by commas the decimal sign is a point"
                refuse(signs[","], problem, hint)
        if not signs:
            return
        self.decimal = self.decimal or min(signs, key=signs.__getitem__)
        other = "," if self.decimal == "." else "."
        if other in signs:
            problem = f'"{{}}" has the decimal sign "{other}", numbers above have "{self.decimal}"'
            refuse(signs[other], problem)
        whole = first(pc.match_substring_regex(text, r"^[+-]?[0-9]{3,}$"))
        if whole is None:
            return
        has_sign = pc.match_substring_regex(text, "[.,]")
        has_three = pc.match_substring_regex(text, "[.,][0-9]{3}$")
        if not pc.any(pc.and_(has_sign, pc.invert(has_three))).as_py():
            problem = (
                f'"{self.decimal}" may be a decimal sign or separate thousands: every number that'
                f" has it has three digits after it, and line {self.lines[whole]} has a whole"
                " number of 100 or more"
            )
            hint = "write all numbers of the column with the same number of decimals"
            refuse(min(signs.values()), problem, hint)


def name_of(path: Path) -> str:
    """Return the file's name without its folder, as errors and provenance give it.

    Bytes that are not UTF-8 become a replacement character.
    """
    if "\0" in str(path):
        return "the file"
    return os.fsencode(path.name or str(path)).decode("utf-8", "replace")


def content_of(path: Path, most: int, hint: str | None = None) -> bytes:
    """Return the bytes of a file.

    Args:
        path: Path of the file.
        most: Largest number of bytes.
        hint: Hint for a file that cannot be read, unless it is too large.

    Raises:
        InputError: if it cannot be read, or is larger.
    """
    try:
        return read_file(path, most)
    except (OSError, ValueError) as error:
        if getattr(error, "errno", 0) == errno.EFBIG:
            hint = "cut the log down to the strokes of one rig"
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot be read: {reason}", where=name_of(path), hint=hint) from None


HeaderSearch: TypeAlias = Callable[
    [list[str], str], tuple[list[Heading], tuple[Heading, ...]] | None
]
"""Function that returns the columns of a line, and those that make it the header.

It takes the cells of the line and its place for messages, and returns None for any other line.
"""
HeaderRefusal: TypeAlias = Callable[[str, str, int], TendonError]
"""Function that returns the error of a file without a header.

It takes the cells of the line that looks most like one, as errors show them, the name of the file
and the number of that line.
"""


def read_table(path: Path, names: tuple[str, str] | None) -> Table:
    """Return the columns of a file of readings of two load cells.

    Args:
        path: Path of the file.
        names: Headers of the two cells; None if they are not given.

    Raises:
        InputError: if the file is no table of readings, with line and column.
    """

    def find(texts: list[str], where: str) -> tuple[list[Heading], tuple[Heading, ...]] | None:
        """Return the columns of a line that names both cells."""
        columns = read_header(texts)
        cells = find_cells(columns, names, where)
        return None if cells is None else (columns, cells)

    def refusal(shown: str, source: str, line: int) -> TendonError:
        """Return the error of a file that names no cells."""
        if names:
            first, second = (shorten(name) for name in names)
            problem = f'no line of {source} has one column "{first}" and one "{second}"'
            hint = f"line {line} has {shown}"
            return UsageError(problem, where="--cell-1, --cell-2", hint=hint)
        return InputError(
            f"no header names the two load cells; this line has {shown}",
            where=f"{source}, line {line}",
            hint='call them "load cell 1" and "load cell 2", or name them with --cell-1 and '
            "--cell-2",
        )

    return read_columns(path, find, refusal)


def read_columns(path: Path, find: HeaderSearch, refusal: HeaderRefusal) -> Table:
    """Return the columns of a file whose header is found by a function.

    Args:
        path: Path of the file.
        find: Function that knows the header.
        refusal: Function that makes the error of a file without one.

    Raises:
        TendonError: if the file is no such table, with line and column.
    """
    source = name_of(path)
    content = content_of(path, MOST_BYTES)
    lines = lines_of(content, source)
    numbers = [
        number
        for number, line in enumerate(lines)
        if line[:1] in _PLAIN_START or not is_comment(line)
    ]
    if not numbers:
        raise InputError("the file has comments only", where=source)
    separator = separator_of([lines[number] for number in numbers[:100]], source)
    candidates = numbers[:_HEADER_WITHIN]
    header, columns, cells = _find_header(lines, candidates, separator, source, find, refusal)
    numbers = numbers[numbers.index(header) + 1 :]
    if not numbers:
        where = f"{source}, line {header + 1}"
        raise InputError("there are no readings below the header", where=where)
    if len(numbers) > MOST_ROWS:
        where = f"{source}, line {numbers[MOST_ROWS] + 1}"
        hint = "keep fewer rows, such as every tenth"
        raise InputError(f"more than {MOST_ROWS:,} readings", where=where, hint=hint)
    is_read = [column for column in columns if column.role or column in cells]
    needed = 1 + max(column.index for column in (*cells, *is_read))
    split = split_rows(lines, numbers, separator, source, len(columns), needed)
    if not split.rows:
        raise_all(split.faults, source)
    return Table(
        source=source,
        sha256=hashlib.sha256(content).hexdigest(),
        columns=columns,
        cells=cells,
        lines=np.array(split.places, dtype=np.int64) + 1,
        data=split.arrays(),
        header=header + 1,
        separator=separator,
        comments=[line for line in lines[:header] if is_comment(line)],
        faults=split.faults,
    )


def _find_header(
    lines: list[str],
    numbers: list[int],
    separator: str,
    source: str,
    find: HeaderSearch,
    refusal: HeaderRefusal,
) -> tuple[int, list[Heading], tuple[Heading, ...]]:
    """Find the first line that is the header.

    Args:
        lines: All lines of the file.
        numbers: Numbers of the lines that may be the header.
        separator: Separator of columns.
        source: Name of the file.
        find: Function that knows the header.
        refusal: Function that makes the error of a file without one.

    Returns:
        Number of the line, its columns, and those that make it the header.
    """
    widest = 0
    widest_texts: Sequence[str] = []
    for number in numbers:
        where = f"{source}, line {number + 1}"
        texts = cells_of(lines[number], separator, where)
        found = find(texts, where)
        if found is not None:
            columns, cells = found
            return number, columns, cells
        if _count_filled(texts) > _count_filled(widest_texts):
            widest = number
            widest_texts = texts
    shown = ", ".join(f'"{shorten(text, 30)}"' for text in widest_texts[:12])
    raise refusal(shown, source, widest + 1)


def _count_filled(texts: Sequence[str]) -> int:
    """Number of cells of a line that are not empty."""
    return sum(map(bool, texts))


def separator_of(lines: list[str], source: str) -> str:
    """Return the separator that divides most of the lines into equally many columns."""
    shares = {}
    for separator in SEPARATORS:
        counts = Counter(line.count(separator) for line in lines)
        counts.pop(0, None)
        shares[separator] = max(counts.values(), default=0) / len(lines)
    common = [separator for separator, share in shares.items() if share >= 0.5]
    best = common[0] if common else max(shares, key=shares.__getitem__)
    if not shares[best]:
        hint = "columns are separated by comma, semicolon or tab"
        raise InputError("no line has more than one column", where=source, hint=hint)
    return best
