"""Lines, cells and columns of text from a CSV file.

Cells are separated by comma, semicolon or tab; lines that hold a comment are left out.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any

import numpy as np

from tendon_cli.errors import InputError
from tendon_cli.files import CSV, WORKBOOK, kind_of_file
from tendon_cli.units import shorten

SEPARATORS = {"\t": "tab", ";": "semicolon", ",": "comma"}
"""Separators in the order in which they are tried.

The comma comes last: in a file separated by semicolons or tabs it is the decimal sign.
"""
LONGEST_LINE = 64 * 2**10  # characters
MOST_FAULTS = 10
"""Largest number of faults of a file that are listed."""
_MOST_NAMES = 5
"""Largest number of columns that a note lists."""
_COMMENT = ("#", "%", "//", "*")
_AS_CSV = "save it as CSV in UTF-8 or UTF-16"
_CONTROL = re.compile(rb"[\x01-\x08\x0e-\x1f\x7f-\x9f]")  # no Latin-1 text has these
_LINE = re.compile(r", line ([0-9]+)")
_ESCAPED_SEPARATOR = "\x1f"  # a separator inside a quoted cell, while rows are split


def raise_all(errors: list[InputError], source: str) -> None:
    """Raise the errors of a file as one, if there are any, in the order of its lines.

    The first `MOST_FAULTS` are listed.
    """
    if not errors:
        return
    if len(errors) == 1:
        raise errors[0]
    listed = []
    for error in sorted(errors, key=_line_of)[:MOST_FAULTS]:
        place = (error.where or "").removeprefix(source).removeprefix(", ")
        advice = f" ({error.hint})" if error.hint else ""
        listed.append(f"  {place}{': ' if place else ''}{error.message}{advice}")
    if len(errors) > MOST_FAULTS:
        listed.append(f"  and {len(errors) - MOST_FAULTS:,} more")
    problem = "\n".join([f"the file has {len(errors):,} faults:", *listed])
    raise InputError(problem, where=source)


def _line_of(error: InputError) -> int:
    """Return the line at which an error is; 0 for an error of the whole file."""
    line = _LINE.search(error.where or "")
    return 0 if line is None else int(line[1])


def not_read(names: list[str], source: str) -> list[str]:
    """Return a note that names the columns that are not read; no note if every column is.

    Args:
        names: Headers of the columns that are not read; columns without a header are not named.
        source: Name of the file.
    """
    shown = [shorten(name, 30) for name in names if name]
    if not shown:
        return []
    others = len(shown) - _MOST_NAMES
    more = f" and {others} more" if others > 0 else ""
    return [f"{source}: columns not read: {', '.join(shown[:_MOST_NAMES])}{more}"]


def lines_of(content: bytes, source: str) -> list[str]:
    """Return the lines of a CSV, without their ends.

    The text may be UTF-8, UTF-16 with its byte order mark, or Latin-1.

    Args:
        content: Bytes of the file.
        source: Name of the file for messages.

    Raises:
        InputError: The file is empty, of another kind, no text, or has a line longer than
            `LONGEST_LINE`.
    """
    kind = kind_of_file(PurePath(source))
    if kind not in (None, CSV, WORKBOOK):  # a workbook is known by its content, below
        raise InputError(f"this is {kind}, expected a CSV", where=source)
    if not content.strip(b" \t\r\n\0\xef\xbb\xbf\xff\xfe"):
        raise InputError("the file is empty", where=source)
    if content.startswith((b"\xff\xfe\0\0", b"\0\0\xfe\xff")):
        raise InputError("the file is in UTF-32", where=source, hint=_AS_CSV)
    if content.startswith((b"PK\x03\x04", b"\xd0\xcf\x11\xe0")):
        hint = 'in the spreadsheet: "Save as", then the type "CSV UTF-8"'
        raise InputError("is a spreadsheet workbook, not text", where=source, hint=hint)
    is_utf16 = content.startswith((b"\xff\xfe", b"\xfe\xff"))
    if b"\0" in content and not is_utf16:
        line = content.count(b"\n", 0, content.index(b"\0")) + 1
        place = f"{source}, line {line}"
        raise InputError("contains a zero byte, so it is not text", where=place, hint=_AS_CSV)
    encoding = "utf-16" if is_utf16 else "utf-8-sig"
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError as error:
        if is_utf16 or _CONTROL.search(content):
            line = content[: error.start].decode(encoding, errors="ignore").count("\n") + 1
            problem = f"bytes that are not {'UTF-16' if is_utf16 else 'UTF-8'} text"
            raise InputError(problem, where=f"{source}, line {line}", hint=_AS_CSV) from None
        text = content.decode("latin-1")
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    for number, line_text in enumerate(lines, start=1):
        if len(line_text) > LONGEST_LINE:
            problem = f"a line of more than {LONGEST_LINE} characters"
            raise InputError(problem, where=f"{source}, line {number}")
    return lines


def is_comment(line: str) -> bool:
    """Return True if a line is empty or begins with a comment sign or a footnote's asterisk."""
    text = line.lstrip(' \t"\ufeff')
    return not text.strip(' \t",;') or text.startswith(_COMMENT)


def cells_of(line: str, separator: str, place: str) -> list[str]:
    """Return the cells of one line without quotes; a quoted cell must end on its line.

    Raises:
        InputError: The quotes of the line do not match; it names `place`.
    """
    skips_spaces = separator != "\t"
    reader = csv.reader([line], delimiter=separator, skipinitialspace=skips_spaces, strict=True)
    try:
        cells = next(reader)
    except csv.Error as error:
        problem = f"not a row of CSV: {error}"
        raise InputError(problem, where=place, hint="check the quotes in this line") from error
    return [cell.strip() for cell in cells]


@dataclass(frozen=True)
class SplitRows:
    """Rows of a CSV with as many cells as there are columns, and the faults of all others."""

    rows: list[str]
    """Text of each row that has its cells, none of them in quotes."""
    places: list[int]
    """Places of these rows among the lines of the file, counted from 0."""
    faults: list[InputError]
    """Fault of each row that has too few or too many cells, or quotes that do not match."""
    separator: str
    """Sign between cells."""
    width: int
    """Number of columns."""
    has_escapes: bool
    """True if separators that belong to a cell are escaped."""

    def arrays(self) -> list[Any]:
        """Return the cells of each column without surrounding spaces, as Arrow arrays of text."""
        import pyarrow as pa  # only files of rows pay for its import
        import pyarrow.compute as pc

        # Not by Arrow's reader of CSV: its threads may hold on to the text until the process ends,
        # and end it by a crash.
        split = pc.split_pattern(pa.array(self.rows, pa.string()), self.separator)
        cells_of_rows = split.flatten()
        first_cells = np.arange(len(self.rows)) * self.width
        texts = [
            pc.utf8_trim_whitespace(cells_of_rows.take(pa.array(first_cells + column)))
            for column in range(self.width)
        ]
        if not self.has_escapes:
            return texts
        return [pc.replace_substring(text, _ESCAPED_SEPARATOR, self.separator) for text in texts]

    def lists(self) -> list[list[str]]:
        """Return the cells of each column without surrounding spaces, as plain lists.

        For tables whose cells are read one by one.
        """
        columns: list[list[str]] = []
        for cells in zip(*(row.split(self.separator) for row in self.rows), strict=True):
            texts = [cell.strip() for cell in cells]
            if self.has_escapes:
                texts = [text.replace(_ESCAPED_SEPARATOR, self.separator) for text in texts]
            columns.append(texts)
        return columns


def split_rows(
    lines: list[str], row_lines: list[int], separator: str, source: str, width: int, needed: int
) -> SplitRows:
    """Split the rows of a CSV; those without as many cells as there are columns are faults.

    Args:
        lines: Lines of the file.
        row_lines: Places in `lines` of those that are rows, the header left out.
        separator: Sign between cells.
        source: Name of the file for messages.
        width: Number of columns.
        needed: Number of first columns that a row must fill; it may leave out those behind them.
            Empty cells beyond the last column do not count.
    """
    rows = [lines[place] for place in row_lines]
    commas = width - 1  # separators in a row without quotes that has every cell
    unusual = [i for i, row in enumerate(rows) if '"' in row or row.count(separator) != commas]
    faults = []
    refused = set()
    for index in unusual:
        where = f"{source}, line {row_lines[index] + 1}"
        try:
            found = cells_of(rows[index], separator, where)
            cells = _fit_to_columns(found, separator, where, width, needed)
        except InputError as error:
            faults.append(error)
            refused.add(index)
            continue
        rows[index] = separator.join(cell.replace(separator, _ESCAPED_SEPARATOR) for cell in cells)
    places = row_lines
    if refused:
        kept = [index for index in range(len(rows)) if index not in refused]
        rows = [rows[index] for index in kept]
        places = [row_lines[index] for index in kept]
    return SplitRows(rows, places, faults, separator, width, has_escapes=bool(unusual))


def _fit_to_columns(
    cells: list[str], separator: str, place: str, width: int, needed: int
) -> list[str]:
    """Return the cells of a row, filled up to `width`."""
    while len(cells) > width and not cells[-1]:
        cells.pop()
    if needed <= len(cells) <= width:
        return cells + [""] * (width - len(cells))
    hint = None
    if separator == "," and len(cells) > width:
        hint = "a decimal comma read as a separator? separate the columns by semicolons"
    count = "1 cell" if len(cells) == 1 else f"{len(cells)} cells"
    problem = f"{count} where the header has {width} (separator: {SEPARATORS[separator]})"
    raise InputError(problem, where=place, hint=hint)
