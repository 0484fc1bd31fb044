"""A readings file as columns of text, and columns of text as numbers."""

from __future__ import annotations

import errno
import hashlib
import os
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from tendon_cli.cells import SEPARATORS, cells_of, is_comment, lines_of, texts_of
from tendon_cli.errors import InputError, UsageError
from tendon_cli.files import read_file
from tendon_cli.friction.reading.header import Heading, find_cells, read_header
from tendon_cli.units import shorten

MOST_BYTES, MOST_ROWS = 64_000_000, 1_000_000
_HEADER_WITHIN = 200
_PLAIN_START = frozenset("0123456789+-.abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ")
_NUMBER = r"[+-]?(?:[0-9]{1,40}(?:[.,][0-9]{0,40})?|[.,][0-9]{1,40})(?:[eE][+-]?[0-9]{1,3})?"
_MISSING = ("", "nan", "na", "n/a", "null", "none", "-", "--", "?", "1.#qnan")
_DECIMAL_COMMA = "a decimal comma read as a separator? separate the columns by semicolons"


@dataclass
class Table:
    """Columns of a file or of a frame, row by row.

    `source` is the file's name without its folder, `lines` the line of each row and `header` that of the header, None
    in a frame. `data` has a pyarrow array of strings per column of a file, an array of values per column of a frame.
    `decimal` is the decimal sign, known from the first number that has one.
    """

    source: str
    sha256: str
    columns: list[Heading]
    cells: tuple[Heading, Heading]
    lines: np.ndarray
    data: list[Any]
    header: int | None = None
    separator: str = ""
    decimal: str = ""

    def place(self, column: Heading, row: int | None = None) -> str:
        """Where a header, or a row of its column, stands."""
        if self.header is None:
            return f"column {column.shown}"
        return f"{self.source}, line {self.header if row is None else self.lines[row]}, column {column.index + 1}"

    def find(self, role: str) -> Heading | None:
        """The one column of a role; refused if there are two."""
        alike = [column for column in self.columns if column.role == role]
        if len(alike) > 1:
            where = self.source if self.header is None else f"{self.source}, line {self.header}"
            raise InputError(f"two columns give the {role.replace('_', ' ')}", where=where)
        return alike[0] if alike else None

    def names(self, column: Heading) -> Any:
        """A column of names, as a pandas Categorical."""
        data = self.data[column.index]
        if isinstance(data, np.ndarray):
            return pd.Categorical([str(value) for value in data.tolist()])
        coded = data.dictionary_encode()
        return pd.Categorical.from_codes(
            coded.indices.to_numpy(), categories=coded.dictionary.to_pylist()
        )

    def numbers(self, column: Heading) -> np.ndarray:
        """A column's numbers; NaN for an empty cell or one that says that there is no reading."""
        data = self.data[column.index]
        try:
            values = (
                data.astype(np.float64) if isinstance(data, np.ndarray) else self._parsed(column)
            )
        except (TypeError, ValueError):
            raise InputError("is not a column of numbers", where=self.place(column)) from None
        if np.isinf(values).any():
            row = int(np.argmax(np.isinf(values)))
            shown = shorten(str(data[row]))
            raise InputError(f'"{shown}" is too large for a number', where=self.place(column, row))
        return np.asarray(values, dtype=np.float64)

    def _parsed(self, column: Heading) -> np.ndarray:
        """The numbers of a column of texts."""
        import pyarrow as pa
        import pyarrow.compute as pc

        text = pc.replace_substring(self.data[column.index], "\u2212", "-")
        missing = pc.is_in(pc.utf8_lower(text), value_set=pa.array(_MISSING))
        good = pc.or_(missing, pc.match_substring_regex(text, f"^{_NUMBER}$"))
        if not pc.all(good).as_py():
            row = int(np.argmin(good.to_numpy(zero_copy_only=False)))
            hint = "numbers stand without unit and without a separator of thousands"
            raise InputError(
                f'"{shorten(text[row].as_py())}" is not a number',
                where=self.place(column, row),
                hint=hint,
            )
        self._check_signs(text, column)
        plain = pc.utf8_ltrim(pc.replace_substring(text, ",", "."), "+")
        values = pc.cast(pc.if_else(missing, "nan", plain), pa.float64())
        return np.asarray(values.to_numpy(zero_copy_only=False))

    def _check_signs(self, text: Any, column: Heading) -> None:
        """Refuse a second decimal sign in the file, and one that may separate thousands."""
        import pyarrow.compute as pc

        def first(mask: Any) -> int | None:
            row = pc.index(mask, True).as_py()
            return None if row < 0 else int(row)

        def check(row: int | None, problem: str, hint: str | None = None) -> None:
            if row is not None:
                raise InputError(
                    problem.format(text[row].as_py()), where=self.place(column, row), hint=hint
                )

        signs = {
            sign: row for sign in ",." if (row := first(pc.match_substring(text, sign))) is not None
        }
        if self.separator == ",":
            check(
                first(pc.match_substring_regex(text, r"^[+-]?0[0-9]+$")),
                '"{}" begins with a zero',
                _DECIMAL_COMMA,
            )
            problem = '"{}" has a comma, which may be a decimal sign or separate thousands'
            check(
                signs.get(","), problem, "in a file separated by commas the decimal sign is a point"
            )
        if not signs:
            return
        self.decimal = self.decimal or min(signs, key=signs.__getitem__)
        other = "," if self.decimal == "." else "."
        check(
            signs.get(other),
            f'"{{}}" has the decimal sign "{other}", numbers above have "{self.decimal}"',
        )
        whole = first(pc.match_substring_regex(text, r"^[+-]?[0-9]{3,}$"))
        fraction, three = (
            pc.match_substring_regex(text, sign) for sign in ("[.,]", "[.,][0-9]{3}$")
        )
        if whole is not None and not pc.any(pc.and_(fraction, pc.invert(three))).as_py():
            problem = (
                f'"{self.decimal}" may be a decimal sign or separate thousands: every number that has it has three'
                f" digits after it, and line {self.lines[whole]} has a whole number of 100 or more"
            )
            check(
                min(signs.values()),
                problem,
                "write all numbers of the column with the same number of decimals",
            )


def name_of(path: Path) -> str:
    """The file's name without its folder, as errors and provenance give it; a sign for what is no UTF-8."""
    return (
        "the file"
        if "\0" in str(path)
        else os.fsencode(path.name or str(path)).decode("utf-8", "replace")
    )


def content_of(path: Path, most: int, hint: str | None = None) -> bytes:
    """The bytes of a file; raises InputError."""
    try:
        return read_file(path, most)
    except (OSError, ValueError) as error:
        hint = (
            "cut the log to the strokes of one rig"
            if getattr(error, "errno", 0) == errno.EFBIG
            else hint
        )
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot be read: {reason}", where=name_of(path), hint=hint) from None


def read_table(path: Path, names: tuple[str, str] | None) -> Table:
    """The columns of a file; raises InputError with line and column."""
    source, content = name_of(path), content_of(path, MOST_BYTES)
    lines = lines_of(content, source)
    kept = [
        at
        for at, line in enumerate(lines)
        if (line[:1] in _PLAIN_START and line) or not is_comment(line)
    ]
    if not kept:
        raise InputError("the file has comments only", where=source)
    separator = separator_of([lines[at] for at in kept[:100]], source)
    at, columns, cells = _find_header(lines, kept[:_HEADER_WITHIN], separator, source, names)
    kept = kept[kept.index(at) + 1 :]
    if not kept:
        raise InputError("there are no readings below the header", where=f"{source}, line {at + 1}")
    if len(kept) > MOST_ROWS:
        where = f"{source}, line {kept[MOST_ROWS] + 1}"
        raise InputError(f"more than {MOST_ROWS:,} readings", where=where, hint="thin the log")
    needed = 1 + max(
        column.index for column in (*cells, *columns) if column.role or column in cells
    )
    data = texts_of(lines, kept, separator, source, len(columns), needed)
    numbered = np.array(kept, dtype=np.int64) + 1
    digest = hashlib.sha256(content).hexdigest()
    return Table(source, digest, columns, cells, numbered, data, at + 1, separator)


def _find_header(
    lines: list[str], kept: list[int], separator: str, source: str, names: tuple[str, str] | None
) -> tuple[int, list[Heading], tuple[Heading, Heading]]:
    """The first of the lines that names both cells, by the options' names or by the obvious ones."""
    widest: tuple[int, list[str]] = (0, [])
    for at in kept:
        texts = cells_of(lines[at], separator, f"{source}, line {at + 1}")
        columns = read_header(texts)
        if cells := find_cells(columns, names, f"{source}, line {at + 1}"):
            return at, columns, cells
        widest = max(widest, (at, texts), key=lambda each: sum(map(bool, each[1])))
    shown = ", ".join(f'"{shorten(text, 30)}"' for text in widest[1][:12])
    if names:
        problem = f'no line of {source} has one column "{shorten(names[0])}" and one "{shorten(names[1])}"'
        raise UsageError(
            problem, where="--cell-1, --cell-2", hint=f"line {widest[0] + 1} has {shown}"
        )
    raise InputError(
        f"no header names the two load cells; this line has {shown}",
        where=f"{source}, line {widest[0] + 1}",
        hint='call them "load cell 1" and "load cell 2", or name them with --cell-1 and --cell-2',
    )


def separator_of(lines: list[str], source: str) -> str:
    """The separator that divides most of the lines into equally many columns."""
    shares = {}
    for separator in SEPARATORS:
        counts = Counter(line.count(separator) for line in lines)
        counts.pop(0, None)
        shares[separator] = max(counts.values(), default=0) / len(lines)
    best = next(
        (separator for separator in shares if shares[separator] >= 0.5),
        max(shares, key=shares.__getitem__),
    )
    if not shares[best]:
        hint = "columns are separated by comma, semicolon or tab"
        raise InputError("no line has more than one column", where=source, hint=hint)
    return best
