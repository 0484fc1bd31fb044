"""The one reader of tables: text files and frames as columns of numbers, with all faults at once.

A feature says which columns it needs and judges what their numbers mean; how a file writes them is
known here alone.
"""

from __future__ import annotations

import csv
import errno
import hashlib
import os
import re
from bisect import bisect_right
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NoReturn, TypeAlias

import numpy as np

from tendon_cli.errors import InputError, UsageError
from tendon_cli.files import read_input
from tendon_cli.readers.clock import Floats, counted_on, evenly, stamps, unwrapped
from tendon_cli.readers.file_text import PLAIN_START, is_comment, lines_of, raise_all, unpacked
from tendon_cli.readers.heading import Heading, column_called, columns_named
from tendon_cli.units import (
    UnitError,
    counted,
    factor_of,
    find_unit,
    known_units,
    shorten,
    written_unit,
)

MOST_BYTES = 64_000_000
"""Largest size of a file, packed or not, bytes."""
MOST_ROWS = 1_000_000
"""Largest number of rows."""
_MOST_NAMES = 5
"""Largest number of columns that a note lists."""
_HEADER_WITHIN = 200
"""Number of lines at the beginning in which the header is looked for."""
_LINES_PER_ROW = 4
"""Lines per row, comments and empty ones among them, from which a file is too large to look at."""
_SAMPLE = 20
"""Number of last rows that show how many cells rows have."""
_SEPARATORS = {"\t": "tab", ";": "semicolon", ",": "comma", " ": "spaces"}
"""Separators in the order in which they are tried.

The comma comes after the others: in a file separated by these it is the decimal sign. Spaces
separate if nothing else does.
"""
_NUMBER = r"[+-]?(?:[0-9]{1,40}(?:[.,][0-9]{0,40})?|[.,][0-9]{1,40})(?:[eE][+-]?[0-9]{1,3})?"
_IS_NUMBER = re.compile(_NUMBER)
_DECIMAL = re.compile(r"[+-]?[0-9]+(?:[.,][0-9]+)?(?:[eE][+-]?[0-9]{1,3})?")
_THOUSANDS = "[+-]?[1-9][0-9]{0,2}[.,][0-9]{3}"
"""Number in which a sign may separate thousands."""
_MISSING = ("", "nan", "na", "n/a", "null", "none", "-", "--", "?", "1.#qnan", "<na>", "nat")
"""Cells that say that there is no number, in lower case."""
_LARGEST = 1e9
"""Largest magnitude of a number with a dimension, in the unit of its column."""
_DECIMAL_COMMA = "a decimal comma read as a separator? separate the columns by semicolons"
_ESCAPED_SEPARATOR = "\x1f"  # a separator inside a quoted cell, while rows are split
_IN_DEGREES = re.compile(r"indegrees\s*=\s*(yes|no)", re.IGNORECASE)

Known: TypeAlias = Callable[[Sequence[Heading]], Collection[Heading]]
"""Function that returns the columns that a feature reads of a line; none if it is no header."""


@dataclass
class Table:
    """Columns of a file or of a frame, row by row."""

    source: str
    """Name of the file without its folder."""
    sha256: str
    columns: list[Heading]
    lines: np.ndarray
    """Line of each row; its number from 0 in a frame."""
    data: list[Any]
    """Cells of each column: Arrow arrays of text of a file, arrays of values of a frame."""
    has_header: bool = True
    """False if no line is the header of what the feature reads."""
    header: int | None = None
    """Line of the header; None without one."""
    separator: str = ""
    decimal: str = ""
    """Decimal sign, known from the first number that has one."""
    comments: list[str] = field(default_factory=list)
    """Comments above the header."""
    notes: list[str] = field(default_factory=list)
    """Notes on what was understood: counters that rolled over, headers that are repeated."""
    faults: list[InputError] = field(default_factory=list)
    """Faults found so far; `raise_faults` raises them as one error."""

    def __len__(self) -> int:
        return len(self.lines)

    # --- Places and faults -----------------------------------------------------------------------

    def place(self, column: Heading | None = None, row: int | None = None) -> str:
        """Return file, line and column of a header, or of a row of its column."""
        line = self.header if row is None else self.lines[row]
        words = [self.source]
        if line is not None:
            words.append(f"line {line}" if self.separator else f"row {line}")
        if column is not None:
            is_frame = not self.separator
            words.append(f"column {column.shown if is_frame else column.index + 1}")
        return ", ".join(words)

    def refuse(
        self, problem: str, hint: str | None = None, *, column: Any = None, row: int | None = None
    ) -> None:
        """Add a fault of a column, or of a row."""
        self.faults.append(InputError(problem, where=self.place(column, row), hint=hint))

    @contextmanager
    def collected(self) -> Iterator[None]:
        """Keep an InputError for `raise_faults`, so that others of the file are found, too."""
        try:
            yield
        except InputError as error:
            self.faults.append(error)

    def raise_faults(self) -> None:
        """Raise all faults found so far as one InputError, if there are any."""
        raise_all(self.faults, self.source)

    # --- Columns ---------------------------------------------------------------------------------

    @property
    def shown(self) -> str:
        """Headers as messages list them."""
        return ", ".join(column.shown for column in self.columns[:12])

    def only(self, columns: Collection[Heading], what: str) -> Heading | None:
        """Return the one column of several that may be; None if there is none. Refuse two."""
        if len(columns) < 2:
            return next(iter(columns), None)
        listed = " and ".join(f"{one.shown} (column {one.index + 1})" for one in columns)
        raise InputError(
            f"two columns give the {what}: {listed}",
            where=self.place(),
            hint="leave one of them out, or give it another name",
        )

    def named(self, *names: str) -> list[Heading]:
        """Return the columns of some names."""
        return columns_named(self.columns, names)

    def need(self, *names: str, hint: str) -> Heading | None:
        """Return the column of one of some names, the first its own; none or two are a fault."""
        try:
            column = self.only(self.named(*names), names[0])
        except InputError as error:
            self.faults.append(error)
            return None
        if column is None:
            found = shorten(", ".join(column.header for column in self.columns))
            self.refuse(f"no column {names[0]}, the header reads: {found}", hint)
        return column

    def called(self, given: str, option: str) -> Heading:
        """Return the column that a user names by its header or its number from 1.

        Raises:
            UsageError: There is none; it names the option.
        """
        column = column_called(self.columns, given)
        if column is None:
            problem = f'there is no column "{shorten(given)}" in {self.source}'
            raise UsageError(problem, where=option, hint=f"the columns are {self.shown}")
        return column

    def unread(self, read: Iterable[Heading | None]) -> list[str]:
        """Return a note that names the columns that are not among these, if there are any."""
        known = {column.index for column in read if column}
        names = [shorten(one.header, 30) for one in self.columns if one.index not in known]
        names = list(filter(None, names))
        if not names:
            return []
        others = len(names) - _MOST_NAMES
        more = f" and {others} more" if others > 0 else ""
        return [f"{self.source}: columns not read: {', '.join(names[:_MOST_NAMES])}{more}"]

    # --- Cells -----------------------------------------------------------------------------------

    def texts(self, column: Heading) -> list[str]:
        """Return the cells of a column as texts."""
        cells = self.data[column.index]
        return list(map(str, cells.tolist())) if _is_frame(cells) else list(cells.to_pylist())

    def measures(self, column: Heading) -> list[str]:
        """Return cells as texts; numbers, with or without a unit, have decimal points.

        A sign that may separate thousands is a fault.
        """
        import pyarrow.compute as pc

        if self.separator in ("", ","):
            return self.texts(column)
        text = self._arrow(column)
        is_measure = pc.match_substring_regex(text, rf"^{_NUMBER}(\s.*)?$")
        with self.collected():
            numbers = pc.replace_substring_regex(text, r"\s.*$", "")
            self.check_signs(column, pc.if_else(is_measure, numbers, ""))
        with_points = pc.replace_substring_regex(text, r"^([^\s,]*),", r"\1.")
        return list(pc.if_else(is_measure, with_points, self.data[column.index]).to_pylist())

    def is_missing(self, column: Heading) -> np.ndarray:
        """Return a mask of the cells that say that there is no number, (rows,)."""
        import pyarrow as pa
        import pyarrow.compute as pc

        missing = pc.is_in(pc.utf8_lower(self._arrow(column)), value_set=pa.array(_MISSING))
        return np.asarray(missing.to_numpy(zero_copy_only=False))

    def numbers(self, column: Heading, *, may_lack: bool = False) -> Floats:
        """Return the numbers of a column as written.

        A cell without a number is NaN, and a fault unless cells may lack one.
        """
        cells = self.data[column.index]
        if _is_frame(cells) and cells.dtype.kind in "biuf":
            values = cells.astype(np.float64)
            is_missing = np.isnan(values)
            is_wrong = np.isinf(values)
        else:
            values, is_number, is_missing = self._converted(column)
            is_wrong = ~is_number & ~is_missing
        for row in np.flatnonzero(is_wrong | (is_missing & (not may_lack))).tolist():
            found = str(cells[row]).strip()
            shown = f'"{shorten(found)}"' if found else "empty"
            hint = "units belong in the header, and numbers have no sign between thousands"
            problem = f"{column.name} is {shown}, expected a number"
            self.refuse(problem, hint if found else None, column=column, row=row)
        for row in np.flatnonzero(np.isinf(values) & ~is_wrong).tolist():
            problem = f'{column.name} is "{shorten(str(cells[row]))}", too large for a number'
            self.refuse(problem, column=column, row=row)
        return np.where(np.isinf(values), np.nan, values)

    def quantity(
        self, column: Heading, dimension: str, *, unit: str = "", may_lack: bool = False
    ) -> tuple[Floats, str]:
        """Return the numbers of a column in SI, and the symbol of the unit in which they stand.

        Args:
            column: The column.
            dimension: Dimension of the numbers.
            unit: Unit if the header says none.
            may_lack: True if a cell may be empty or say that there is no number.
        """
        values = self.numbers(column, may_lack=may_lack)
        for row in np.flatnonzero(np.abs(values) > _LARGEST).tolist():
            problem = f"{column.name} is {values[row]:g}, expected {_LARGEST:g} at most"
            self.refuse(problem, column=column, row=row)
        symbol = self.unit_of(column, dimension, unit)
        return values * (factor_of(symbol) if symbol else np.nan), symbol

    def unit_of(self, column: Heading, dimension: str, unit: str = "") -> str:
        """Return the symbol of a column's unit; empty, and a fault, if it is none of a dimension.

        Args:
            column: The column.
            dimension: Dimension of its numbers.
            unit: Unit if the header says none.
        """
        written = column.unit or unit
        meant = written_unit(written, dimension)
        if meant is not None:
            return meant.symbol
        known = known_units(dimension)
        hint = f"such as {column.name} ({known[0]}); units of {dimension}: {', '.join(known)}"
        problem = f"the column {column.name} has no unit"
        if written:
            try:
                find_unit(written, dimension)
            except UnitError as error:
                problem = f"{column.name}: {error.problem}"
                hint = error.hint or hint
        self.refuse(problem, hint, column=column)
        return ""

    def times(self, column: Heading, *, may_lack: bool = False) -> tuple[Floats, str]:
        """Return times, and the symbol of their unit: seconds for stamps, empty if none is said.

        Counters that roll over go on, and rows that share their times lie at equal steps; notes say
        so.
        """
        cells = self.data[column.index]
        unit = column.unit if column.dimension == "time" else column.clock
        is_dated = _is_frame(cells) and np.issubdtype(cells.dtype, np.datetime64)
        times: Floats | None = None
        if is_dated or re.search(r"\d[:-]\d", str(cells[0])):
            times = stamps(cells if is_dated else self.texts(column))
        if times is not None:
            unit = "s"
        else:
            times = self.numbers(column, may_lack=may_lack)
        times, rolls = counted_on(times)
        self.notes += [
            f"{self.place(row=int(row))}: {column.shown} rolls over at 2^32, and is counted on"
            for row in rolls[:_MOST_NAMES]
        ]
        spread = evenly(times)
        if spread is not None:
            times, shared = spread
            self.notes.append(
                f"{self.source}: {shared:g} rows share each time in {column.shown}, so the rows are"
                " taken at equal steps"
            )
        return times, unit

    def unwrapped(self, column: Heading, angles: Floats, turn: float) -> Floats:
        """Return angles of an encoder that go on where it starts again, with a note if it does."""
        angles, rows = unwrapped(angles, turn)
        if len(rows):
            times = counted(len(rows), "time")
            self.notes.append(
                f"{self.place(row=int(rows[0]))}: {column.shown} starts again after one turn"
                f" ({times} in all), and is counted on"
            )
        return angles

    def _arrow(self, column: Heading) -> Any:
        """Return the cells of a column as an Arrow array of text, with plain signs of minus."""
        import pyarrow as pa
        import pyarrow.compute as pc

        cells = self.data[column.index]
        if _is_frame(cells):
            cells = pa.array(["" if cell is None else str(cell) for cell in cells.tolist()])
        return pc.replace_substring(cells, "\u2212", "-")

    def _converted(self, column: Heading) -> tuple[Floats, np.ndarray, np.ndarray]:
        """Return the numbers of texts, and masks of those that are numbers and that are missing."""
        import pyarrow as pa
        import pyarrow.compute as pc

        text = self._arrow(column)
        missing = pc.is_in(pc.utf8_lower(text), value_set=pa.array(_MISSING))
        is_number = pc.match_substring_regex(text, f"^{_NUMBER}$")
        with self.collected():
            self.check_signs(column, pc.if_else(is_number, text, ""))
        plain = pc.utf8_ltrim(pc.replace_substring(text, ",", "."), "+")
        numbers = pc.if_else(is_number, plain, "nan")
        try:
            values = pc.cast(numbers, pa.float64()).to_numpy(zero_copy_only=False)
        except pa.ArrowInvalid:  # how some versions of Arrow take a number above 1e308
            values = np.array([float(number) for number in numbers.to_pylist()])
        masks = [mask.to_numpy(zero_copy_only=False) for mask in (is_number, missing)]
        return np.asarray(values), masks[0], masks[1]

    def check_signs(self, column: Heading, text: Any) -> None:
        """Refuse a second decimal sign in the file, and one that may separate thousands.

        Args:
            column: The column.
            text: Its numbers as an Arrow array of text, empty where a cell is none.
        """
        import pyarrow.compute as pc

        def first(mask: Any) -> int | None:
            """Return the first row of a mask, None if there is none."""
            row = pc.index(mask, True).as_py()
            return None if row < 0 else int(row)

        def refuse(row: int, problem: str, hint: str | None = None) -> NoReturn:
            """Raise for a row; `problem` has a place for its text."""
            shown = problem.format(text[row].as_py())
            raise InputError(shown, where=self.place(column, row), hint=hint)

        def proof(sign: str) -> int | None:
            """Return the first row in which a sign does not separate thousands."""
            has_sign = pc.match_substring(text, sign)
            may_separate = pc.match_substring_regex(text, f"^{_THOUSANDS}$")
            return first(pc.and_(has_sign, pc.invert(may_separate)))

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
        if not self.decimal:
            proven = [sign for sign in signs if len(signs) > 1 and proof(sign) is not None]
            self.decimal = min(proven or signs, key=signs.__getitem__)
        other = "," if self.decimal == "." else "."
        if other in signs:
            found = text[signs[other]].as_py()
            problem = f'"{{}}" has the decimal sign "{other}", other numbers have "{self.decimal}"'
            is_thousands = re.fullmatch(_THOUSANDS, found) is not None
            advice = f'if "{other}" separates thousands, leave it out' if is_thousands else None
            refuse(signs[other], problem, advice)
        whole = first(pc.match_substring_regex(text, r"^[+-]?[0-9]{3,}$"))
        if whole is not None and proof(self.decimal) is None:
            problem = (
                f'"{self.decimal}" may be a decimal sign or separate thousands: every number that'
                f" has it has three digits after it, and line {self.lines[whole]} has a whole"
                " number of 100 or more"
            )
            hint = "write all numbers of the column with the same number of decimals"
            refuse(min(signs.values()), problem, hint)


def _is_frame(cells: Any) -> bool:
    return isinstance(cells, np.ndarray)


# --- Reading --------------------------------------------------------------------------------------


def read_table(
    given: Any,
    known: Known,
    *,
    source: str = "",
    noun: str = "row",
    most_bytes: int = MOST_BYTES,
    most_rows: int = MOST_ROWS,
    hint: str | None = None,
) -> Table:
    """Return the columns of a file or of a frame.

    Args:
        given: Path of a file, its bytes, a frame of pandas or Arrow, or a mapping of arrays.
        known: Function that returns the columns that the feature reads of a line. The first line of
            which it returns any is the header.
        source: Name of the table for messages; by default that of the file.
        noun: Noun for what a row describes, such as "person".
        most_bytes: Largest size of the file.
        most_rows: Largest number of rows.
        hint: Hint for a file that cannot be opened.

    Raises:
        InputError: It is no table; with line and column.
        UsageError: It is no file and no frame.
    """
    if isinstance(given, Path):
        source = source or name_of(given)
        given = content_of(given, most_bytes, hint)
    if isinstance(given, bytes):
        table = _Text(given, source, noun, most_bytes, most_rows).table(known)
    else:
        table = _table_of_frame(given, known, source, noun, most_rows)
    _check_headers(table, known)
    return table


def _check_headers(table: Table, known: Known) -> None:
    """Refuse two columns with one header, of those that are read, or of all if none is known."""
    first: dict[str, Heading] = {}
    for column in known(table.columns) or table.columns:
        other = first.setdefault(column.header, column)
        if column.header and other.index != column.index:
            places = f"in columns {other.index + 1} and {column.index + 1}"
            problem = f"the header {column.shown} stands twice, {places}, expected it once"
            raise InputError(problem, where=table.place(), hint="rename or delete one of them")


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
        InputError: It cannot be read, or is larger.
    """
    try:
        return read_input(path, most)
    except (OSError, ValueError) as error:
        if getattr(error, "errno", 0) == errno.EFBIG:
            hint = "cut the log down to the strokes of one rig"
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot be read: {reason}", where=name_of(path), hint=hint) from None


def _table_of_frame(frame: Any, known: Known, source: str, noun: str, most_rows: int) -> Table:
    """Return the columns of a frame or a mapping of arrays; rows count from 0, as in pandas."""
    import pandas as pd

    where = source or "the table"
    kind = type(frame).__name__
    problem = f"{kind} is not a path, a DataFrame or a mapping of arrays of equal length"
    try:
        if hasattr(frame, "column_names"):  # of Arrow
            pairs = list(zip(frame.column_names, frame.columns, strict=True))
        elif isinstance(frame, pd.DataFrame):
            pairs = [(name, frame.iloc[:, at]) for at, name in enumerate(frame.columns)]
        else:
            pairs = [(name, frame[name]) for name in frame]
        data = [np.atleast_1d(np.asarray(values)) for _, values in pairs]
    except (TypeError, ValueError, LookupError) as error:
        raise UsageError(problem, where=where) from error
    if len({values.shape for values in data}) > 1 or any(values.ndim > 1 for values in data):
        raise UsageError(problem, where=where)
    rows = len(data[0]) if data else 0
    if not 0 < rows <= most_rows:
        raise InputError(f"{counted(rows, noun)}, expected 1 to {most_rows:,}", where=where)
    units = getattr(frame, "attrs", {}).get("units", {})  # of tendon's own tables
    columns = [Heading.of(index, str(name)) for index, (name, _) in enumerate(pairs)]
    columns = [
        replace(column, unit=column.unit or units.get(column.header, "").replace("1", ""))
        for column in columns
    ]
    digest = hashlib.sha256()
    for values in data:
        is_object = values.dtype == object
        digest.update(repr(values.tolist()).encode() if is_object else values.tobytes())
    has_header = bool(known(columns))
    lines = np.arange(rows)
    return Table(where, digest.hexdigest(), columns, lines, data, has_header)


@dataclass
class _Text:
    """Reader of one file of text."""

    content: bytes
    source: str
    noun: str
    most_bytes: int
    most_rows: int
    separator: str = ""

    def table(self, known: Known) -> Table:
        """Return the table; `known` is as `read_table` takes it."""
        sha256 = hashlib.sha256(self.content).hexdigest()
        content = unpacked(self.content, self.source, self.most_bytes)
        if content.count(b"\n") > _LINES_PER_ROW * self.most_rows + _HEADER_WITHIN:
            raise self._too_many(self.source)
        lines = lines_of(content, self.source.removesuffix(".gz"))
        start, in_degrees = self._preamble(lines)
        plain = [
            number
            for number, line in enumerate(lines[start:], start)
            if line[:1] in PLAIN_START or not is_comment(line)
        ]
        if not plain:
            raise InputError("the file has comments only", where=self.source)
        self.separator = self.separator or self._separator([lines[at] for at in plain[:100]])
        header, columns = self._header(lines, plain, known)
        numbers = plain[bisect_right(plain, header) :]
        where = f"{self.source}, line {header + 1}"
        if not numbers:
            raise InputError(f"there are no {self.noun}s below the header", where=where)
        numbers, columns, notes = self._below(lines, header, numbers, columns)
        if not numbers:
            raise InputError(f"there are no {self.noun}s below the header", where=where)
        if len(numbers) > self.most_rows:
            raise self._too_many(f"{self.source}, line {numbers[self.most_rows] + 1}")
        columns = [_in_degrees(column, in_degrees) for column in columns]
        read = known(columns)
        needed = 1 + max((column.index for column in read), default=len(columns) - 1)
        data, places, faults = self._split(lines, numbers, len(columns), needed)
        return Table(
            source=self.source,
            sha256=sha256,
            columns=columns,
            lines=np.array(places, dtype=np.int64) + 1,
            data=data,
            has_header=bool(read),
            header=header + 1 if header >= 0 else None,
            separator=self.separator,
            comments=[line for line in lines[: max(header, 0)] if is_comment(line)],
            notes=notes,
            faults=faults,
        )

    def _too_many(self, where: str) -> InputError:
        """Return the error of a file with more rows than are read."""
        hint = "keep fewer rows, such as every tenth"
        return InputError(f"more than {self.most_rows:,} {self.noun}s", where=where, hint=hint)

    def _preamble(self, lines: list[str]) -> tuple[int, bool | None]:
        """Return the first line after those that say how a file is written, and its angles' unit.

        The unit is that of OpenSim's files: True for degrees, False for radians, None in others.
        """
        stated = re.fullmatch(r"\W?sep=(.)", lines[0].strip(), re.IGNORECASE)
        if stated is not None and stated[1] in _SEPARATORS:
            self.separator = stated[1]
            return 1, None
        if lines[0].lower().startswith("sep=\t"):
            self.separator = "\t"
            return 1, None
        in_degrees = None
        for number, line in enumerate(lines[:_HEADER_WITHIN]):
            stated = _IN_DEGREES.search(line)
            if stated is not None:
                in_degrees = stated[1].lower() == "yes"
            if line.strip().lower() == "endheader":
                return number + 1, in_degrees
        return 0, None

    def _separator(self, lines: list[str]) -> str:
        """Return the separator that divides most of the lines into equally many columns.

        Spaces divide lines only if the last has two numbers, or columns that stand apart.
        """
        last = lines[-1].split()
        if len(last) > 1 and "\t" not in lines[-1] and all(map(_DECIMAL.fullmatch, last)):
            return " "  # commas, if there are any, are decimal
        shares = {}
        for separator in ("\t", ";", ","):
            counts = Counter(line.count(separator) for line in lines)
            counts.pop(0, None)
            shares[separator] = max(counts.values(), default=0) / len(lines)
        common = [separator for separator, share in shares.items() if share >= 0.5]
        if common:
            return common[0]
        has_numbers = sum(map(bool, map(_DECIMAL.fullmatch, last))) > 1
        if has_numbers or re.search(r"\S {2,}\S", lines[-1]):
            return " "
        return max(shares, key=shares.__getitem__) if any(shares.values()) else ","

    def _cells(self, line: str, place: int, width: int = 0) -> list[str]:
        """Return the cells of one line without quotes; a quoted cell must end on its line.

        Args:
            line: The line.
            place: Its place in the file, from 0.
            width: Number of cells that the rows have, if known: names may hold a single space.
        """
        if self.separator == " " and '"' not in line:
            cells = line.split()
            apart = re.split(r"\s{2,}|\t", line.strip())
            return apart if width and len(cells) != width == len(apart) else cells
        skips = self.separator != "\t"
        reader = csv.reader([line], delimiter=self.separator, skipinitialspace=skips, strict=True)
        try:
            cells = next(reader)
        except csv.Error as error:
            problem = f"not a row of CSV: {error}"
            where = f"{self.source}, line {place + 1}"
            hint = "check the quotes in this line"
            raise InputError(problem, where=where, hint=hint) from error
        return [cell.strip() for cell in cells]

    # --- The header ------------------------------------------------------------------------------

    def _header(
        self, lines: list[str], plain: list[int], known: Known
    ) -> tuple[int, list[Heading]]:
        """Return the place of the header, and its columns.

        The header is the first line of which any column is read. Else it is the last comment that
        has as many cells as the rows and of which any is; else the first line that has as many
        cells as most, of which none is read. It is at -1 if that line has numbers alone.
        """
        width = self._usual_width([lines[at] for at in plain[-_SAMPLE:]])
        candidates = plain[:_HEADER_WITHIN]
        usual: tuple[int, list[Heading]] | None = None
        wrong: list[InputError] = []
        most = 0  # cells that are filled in it, if it is as wide as the rows
        for at in candidates:
            try:
                columns = _columns_of(self._cells(lines[at], at, width))
            except InputError as error:
                wrong.append(error)
                continue
            if known(columns):
                return at, columns
            filled = sum(bool(column.header) for column in columns)
            has_numbers = any(_IS_NUMBER.fullmatch(column.header) for column in columns)
            if usual is None or (len(columns) == width and filled > most and not has_numbers):
                usual = at, columns
                most = filled if len(columns) == width else 0
        for at in range(candidates[0] - 1, -1, -1):
            if not is_comment(lines[at]) or '"' in lines[at]:
                continue
            columns = _columns_of(self._cells(lines[at].lstrip(" \t#%/*"), at, width))
            if len(columns) == width and known(columns):
                return at, columns
        if usual is None:
            raise wrong[0]
        first = lines[candidates[0]]
        for separator, word in _SEPARATORS.items():
            if separator != self.separator and known(_columns_of(first.split(separator))):
                problem = f"the header is separated by {word}, and the rows are by"
                where = f"{self.source}, line {candidates[0] + 1}"
                raise InputError(f"{problem} {_SEPARATORS[self.separator]}", where=where)
        if all(_IS_NUMBER.fullmatch(column.header) for column in usual[1]):
            numbered = _columns_of([f"column {at + 1}" for at in range(width)])
            if known(numbered):
                return -1, numbered
        return usual

    def _usual_width(self, lines: list[str]) -> int:
        """Return the number of cells that most of some lines have."""
        widths: Counter[int] = Counter()
        for line in lines:
            with suppress(InputError):
                widths[len(self._cells(line, 0))] += 1
        return widths.most_common(1)[0][0] if widths else 0

    def _below(
        self, lines: list[str], header: int, numbers: list[int], columns: list[Heading]
    ) -> tuple[list[int], list[Heading], list[str]]:
        """Take what is no row from the lines below the header: units, and the header once more.

        Returns:
            Lines of rows, columns with the units of a row of their own, and notes.
        """
        notes: list[str] = []
        if header < 0:
            return numbers, columns, notes
        above = [lines[header]]
        units = self._units(lines, numbers, columns)
        if units:
            above.append(lines[numbers[0]])
            # In a logger's file the next row says how each cell was sampled.
            is_toa5 = lines[0].lstrip('"').startswith("TOA5")
            numbers = numbers[2:] if is_toa5 else numbers[1:]
            columns = [
                replace(column, unit=column.unit or unit)
                for column, unit in zip(columns, units, strict=True)
            ]
        again: list[int] = []
        if any(lines.count(line) > 1 for line in above):
            again = [at for at in numbers if lines[at] in above]
        if again:
            where = f"{self.source}, line {again[0] + 1}"
            notes.append(f"{where}: the header again, which is not read as a row")
            numbers = [at for at in numbers if lines[at] not in above]
        return numbers, columns, notes

    def _units(self, lines: list[str], numbers: list[int], columns: list[Heading]) -> list[str]:
        """Return the unit of each column if the first line below the header gives units.

        Such a line has no numbers, and a unit above a number at least.
        """
        rows = []
        for at in numbers[:4]:
            with suppress(InputError):
                cells = self._cells(lines[at], at, len(columns))
                rows.append([*cells, *[""] * (len(columns) - len(cells))][: len(columns)])
        if not rows or any(map(_IS_NUMBER.fullmatch, rows[0])):
            return []
        units = [written_unit(cell) for cell in rows[0]]
        is_above = any(
            unit is not None and _IS_NUMBER.fullmatch(row[at]) is not None
            for row in rows[1:]
            for at, unit in enumerate(units)
        )
        if not is_above:
            return []
        return [
            unit.symbol if unit is not None else cell.strip("()[]")
            for unit, cell in zip(units, rows[0], strict=True)
        ]

    # --- Rows ------------------------------------------------------------------------------------

    def _split(
        self, lines: list[str], places: list[int], width: int, needed: int
    ) -> tuple[list[Any], list[int], list[InputError]]:
        """Split rows; those without as many cells as there are columns are faults.

        Args:
            lines: Lines of the file.
            places: Places of the rows among them.
            width: Number of columns.
            needed: Number of first columns that a row must fill; it may leave out those behind
                them. Empty cells beyond the last column do not count.

        Returns:
            Cells of each column as Arrow arrays of text, the places of the rows that have their
            cells, and the faults of the others.
        """
        rows = [lines[place] for place in places]
        if self.separator == " ":
            rows = [row if '"' in row else " ".join(row.split()) for row in rows]
        commas = width - 1  # separators in a row without quotes that has every cell
        if rows[0].endswith(self.separator) and rows[0].count(self.separator) == width:
            rows = [row[:-1] if row.count(self.separator) == width else row for row in rows]
        unusual = [
            index
            for index, row in enumerate(rows)
            if '"' in row or row.count(self.separator) != commas
        ]
        faults = []
        refused = set()
        for index in unusual:
            try:
                cells = self._fitted(rows[index], places[index], width, needed)
            except InputError as error:
                faults.append(error)
                refused.add(index)
                continue
            rows[index] = self.separator.join(
                cell.replace(self.separator, _ESCAPED_SEPARATOR) for cell in cells
            )
        if refused:
            kept = [index for index in range(len(rows)) if index not in refused]
            rows = [rows[index] for index in kept]
            places = [places[index] for index in kept]
        if not rows:
            raise_all(faults, self.source)
        return _arrays(rows, self.separator, width, has_escapes=bool(unusual)), places, faults

    def _fitted(self, row: str, place: int, width: int, needed: int) -> list[str]:
        """Return the cells of a row, filled up to `width`."""
        cells = self._cells(row, place)
        while len(cells) > width and not cells[-1]:
            cells.pop()
        if needed <= len(cells) <= width:
            return cells + [""] * (width - len(cells))
        is_comma = self.separator == "," and len(cells) > width
        separator = _SEPARATORS[self.separator]
        found = counted(len(cells), "cell")
        problem = f"{found} where the header has {width} (separator: {separator})"
        where = f"{self.source}, line {place + 1}"
        raise InputError(problem, where=where, hint=_DECIMAL_COMMA if is_comma else None)


def _arrays(rows: list[str], separator: str, width: int, *, has_escapes: bool) -> list[Any]:
    """Return the cells of each column without surrounding spaces, as Arrow arrays of text."""
    import pyarrow as pa  # only files of rows pay for its import
    import pyarrow.compute as pc

    # Not by Arrow's reader of CSV: its threads may hold on to the text until the process ends,
    # and end it by a crash.
    cells = pc.split_pattern(pa.array(rows, pa.string()), separator).flatten()
    first_cells = np.arange(len(rows)) * width
    texts = [
        pc.utf8_trim_whitespace(cells.take(pa.array(first_cells + column)))
        for column in range(width)
    ]
    if not has_escapes:
        return texts
    return [pc.replace_substring(text, _ESCAPED_SEPARATOR, separator) for text in texts]


def _columns_of(cells: Sequence[str]) -> list[Heading]:
    return [Heading.of(index, cell) for index, cell in enumerate(cells)]


def _in_degrees(column: Heading, in_degrees: bool | None) -> Heading:
    """Return a column of OpenSim's with the unit that its file states; time is in seconds."""
    if in_degrees is None or column.unit or column.words & {"force", "torque", "moment"}:
        return column
    if "time" in column.words:
        return replace(column, unit="s")
    return replace(column, unit="deg" if in_degrees else "rad")
