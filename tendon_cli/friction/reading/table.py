"""A readings file as columns of text, and columns of text as numbers: the separator, the decimal sign, comments."""

from __future__ import annotations

import csv
import re
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tendon_cli.errors import InputError, UsageError
from tendon_cli.friction.reading.header import Heading, find_cells, named_column, read_column
from tendon_cli.friction.reading.text import LogFile, lines_of
from tendon_cli.units import shorten

_COMMENT = ("#", "%", "//", "*")
_PLAIN_START = frozenset("0123456789+-.abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ")
_SEPARATORS = {"\t": "tab", ";": "semicolon", ",": "comma"}
"""In this order: a comma is believed last, since in a file separated by semicolons or tabs it is the decimal sign."""
_NUMBER = r"[+-]?(?:[0-9]{1,40}(?:[.,][0-9]{0,40})?|[.,][0-9]{1,40})(?:[eE][+-]?[0-9]{1,3})?"
_MISSING = ("", "nan", "na", "n/a", "null", "none", "-", "--", "?", "1.#qnan")
_DECIMAL_COMMA = "a decimal comma read as a separator? separate the columns by semicolons"
_SNIFFED, _HEADER_WITHIN = 100, 200
MOST_ROWS = 1_000_000


@dataclass
class Table:
    """The rows below the header, column by column."""

    source: LogFile
    header: int
    """Line of the header."""
    columns: list[Heading]
    cells: tuple[Heading, Heading]
    separator: str
    lines: np.ndarray
    """Line of each row."""
    texts: list[Any]
    """A pyarrow array of strings per column."""
    decimal: str | None = field(default=None)
    """The decimal sign, known from the first number that has one."""

    def place(self, column: Heading) -> str:
        """Where a column's header stands."""
        return self.source.place(self.header, column.index)

    def find(self, role: str) -> Heading | None:
        """The one column of a role; refused if there are two."""
        found = [column for column in self.columns if column.role == role]
        if len(found) > 1:
            raise InputError(f"two columns give the {role}", where=self.source.place(self.header))
        return found[0] if found else None

    def names(self, column: Heading) -> tuple[tuple[str, ...], np.ndarray]:
        """The different texts of a column, and which one each row has."""
        import pyarrow.compute as pc

        coded = pc.dictionary_encode(self.texts[column.index])
        return tuple(coded.dictionary.to_pylist()), coded.indices.to_numpy().astype(np.int64)

    def numbers(self, column: Heading) -> np.ndarray:
        """A column's numbers; NaN for an empty cell or one that says that there is no reading."""
        import pyarrow as pa
        import pyarrow.compute as pc

        text = pc.replace_substring(self.texts[column.index], "\u2212", "-")
        missing = pc.is_in(pc.utf8_lower(text), value_set=pa.array(_MISSING))
        good = pc.or_(missing, pc.match_substring_regex(text, f"^{_NUMBER}$"))
        if not pc.all(good).as_py():
            row = int(np.argmin(good.to_numpy(zero_copy_only=False)))
            raise self._no_number(text[row].as_py(), self.source.place(int(self.lines[row]), column.index))
        self._check_signs(text, column)
        plain = pc.utf8_ltrim(pc.replace_substring(text, ",", "."), "+")
        values = pc.cast(pc.if_else(missing, "nan", plain), pa.float64()).to_numpy(zero_copy_only=False)
        if np.isinf(values).any():
            row = int(np.argmax(np.isinf(values)))
            problem = f'"{shorten(text[row].as_py())}" is too large for a number'
            raise InputError(problem, where=self.source.place(int(self.lines[row]), column.index))
        return np.asarray(values, dtype=np.float64)

    def _check_signs(self, text: Any, column: Heading) -> None:
        """One decimal sign in the whole file, and none that may separate thousands."""
        import pyarrow.compute as pc

        def first(mask: Any) -> int | None:
            found = pc.index(mask, True).as_py()
            return None if found < 0 else int(found)

        def refuse(row: int, problem: str, hint: str | None = None) -> InputError:
            where = self.source.place(int(self.lines[row]), column.index)
            return InputError(problem, where=where, hint=hint)

        zero = first(pc.match_substring_regex(text, r"^[+-]?0[0-9]+$")) if self.separator == "," else None
        if zero is not None:
            raise refuse(zero, f'"{text[zero].as_py()}" begins with a zero', _DECIMAL_COMMA)
        signs = {sign: first(pc.match_substring(text, sign)) for sign in ",."}
        if signs[","] is not None and self.separator == ",":
            problem = f'"{text[signs[","]].as_py()}" has a comma, which may be a decimal sign or separate thousands'
            raise refuse(signs[","], problem, "in a file separated by commas the decimal sign is a point")
        known = {sign: row for sign, row in signs.items() if row is not None}
        if known and self.decimal is None:
            self.decimal = min(known, key=known.__getitem__)
        for sign, row in known.items():
            if sign != self.decimal:
                problem = f'"{text[row].as_py()}" has the decimal sign "{sign}", numbers above have "{self.decimal}"'
                raise refuse(row, problem)
        whole = first(pc.match_substring_regex(text, r"^[+-]?[0-9]{3,}$"))
        fraction, three = (pc.match_substring_regex(text, sign) for sign in ("[.,]", "[.,][0-9]{3}$"))
        if known and whole is not None and not pc.any(pc.and_(fraction, pc.invert(three))).as_py():
            raise refuse(
                min(known.values()),
                f'"{self.decimal}" may be a decimal sign or separate thousands: every number that has it has three'
                f" digits after it, and line {self.lines[whole]} has a whole number of 100 or more",
                "write all numbers of the column with the same number of decimals",
            )

    def _no_number(self, text: str, place: str) -> InputError:
        if re.fullmatch(r"[+-]?(?:inf|infinity|1\.#inf|∞)", text, re.IGNORECASE):
            return InputError(f'"{shorten(text)}" is not a finite number', where=place)
        hint = None
        if re.match(r"[+-]?[\d.,]+\s*[^\d\s.,]", text) or (self.lines.size and text[:1] in "([{"):
            hint = "units belong in the header"
        elif re.fullmatch(r"[+-]?\d+[.,][\d.,]+", text):
            hint = "write numbers without a separator of thousands"
        return InputError(f'"{shorten(text)}" is not a number', where=place, hint=hint)


def read_table(source: LogFile, names: tuple[str, str] | None) -> Table:
    """The columns of a file; raises InputError with line and column."""
    lines = lines_of(source)
    kept = [at for at, line in enumerate(lines) if (line[:1] in _PLAIN_START and line) or not _is_comment(line)]
    if not kept:
        raise InputError("the file has comments only", where=source.name)
    separator = _separator([lines[at] for at in kept[:_SNIFFED]], source)
    at, columns, cells = _find_header(lines, kept[:_HEADER_WITHIN], separator, source, names)
    kept = kept[kept.index(at) + 1 :]
    if len(kept) > MOST_ROWS:
        where = source.place(kept[MOST_ROWS] + 1)
        raise InputError(f"more than {MOST_ROWS:,} readings", where=where, hint="thin the log")
    texts, kept = _texts(lines, kept, columns, separator, source)
    if not kept:
        raise InputError("there are no readings below the header", where=source.place(at + 1))
    return Table(source, at + 1, columns, cells, separator, np.array(kept, dtype=np.int64) + 1, texts)


def _is_comment(line: str) -> bool:
    """Whether a line is empty or begins with a comment sign (a footnote's asterisk included)."""
    text = line.lstrip(' \t"\ufeff')
    return not text.strip(' \t",;') or text.startswith(_COMMENT)


def _separator(lines: list[str], source: LogFile) -> str:
    """The separator that divides most of the lines into equally many columns."""
    best, best_share = "", 0.0
    for separator in _SEPARATORS:
        counts = Counter(line.count(separator) for line in lines)
        counts.pop(0, None)
        share = max(counts.values(), default=0) / len(lines)
        if share >= 0.5:
            return separator
        if share > best_share:
            best, best_share = separator, share
    if not best:
        hint = "columns are separated by comma, semicolon or tab"
        raise InputError("no line has more than one column", where=source.name, hint=hint)
    return best


def _split(line: str, separator: str, place: str) -> list[str]:
    """The cells of one line, quotes removed; a quoted cell may not run over the end of the line."""
    try:
        cells = next(csv.reader([line], delimiter=separator, skipinitialspace=separator != "\t", strict=True))
    except csv.Error as error:
        raise InputError(f"not a row of CSV: {error}", where=place, hint="check the quotes in this line") from error
    return [cell.strip() for cell in cells]


def _find_header(
    lines: list[str], kept: list[int], separator: str, source: LogFile, names: tuple[str, str] | None
) -> tuple[int, list[Heading], tuple[Heading, Heading]]:
    """The first of the lines that names both cells, by the options' names or by the obvious ones."""
    widest: tuple[int, list[str]] = (0, [])
    for at in kept:
        texts = _split(lines[at], separator, source.place(at + 1))
        columns = [read_column(index, text) for index, text in enumerate(texts)]
        if names:
            found = named_column(columns, names[0]), named_column(columns, names[1])
            pair = (found[0], found[1]) if found[0] and found[1] else None
        else:
            pair = find_cells(columns, source.place(at + 1))
        if pair:
            return at, columns, pair
        if sum(map(bool, texts)) > sum(map(bool, widest[1])):
            widest = at, texts
    shown = ", ".join(f'"{shorten(text, 30)}"' for text in widest[1][:12])
    if names:
        raise UsageError(
            f'no line of {source.name} has one column "{shorten(names[0])}" and one "{shorten(names[1])}"',
            where="--cell-1, --cell-2",
            hint=f"line {widest[0] + 1} has {shown}",
        )
    raise InputError(
        f"no header names the two load cells; this line has {shown}",
        where=source.place(widest[0] + 1),
        hint='call them "load cell 1" and "load cell 2", or name them with --cell-1 and --cell-2',
    )


def _texts(
    lines: list[str], kept: list[int], columns: list[Heading], separator: str, source: LogFile
) -> tuple[list[Any], list[int]]:
    """The texts of each column, and the lines of the rows."""
    import pyarrow as pa
    import pyarrow.compute as pc
    from pyarrow import csv as table

    width = len(columns)
    body = [lines[at] for at in kept]
    odd = [row for row, line in enumerate(body) if '"' in line or line.count(separator) != width - 1]
    for row in odd:  # the others need no look
        place = source.place(kept[row] + 1)
        cells = _fitted(_split(body[row], separator, place), columns, separator, place)
        body[row] = separator.join(cell.replace(separator, "\x1f") for cell in cells)
    if not body:
        return [], []
    read = table.read_csv(
        pa.py_buffer("\n".join(body).encode()),
        read_options=table.ReadOptions(column_names=[str(index) for index in range(width)], block_size=1 << 26),
        parse_options=table.ParseOptions(delimiter=separator, quote_char=False, ignore_empty_lines=False),
        convert_options=table.ConvertOptions(
            column_types={str(index): pa.string() for index in range(width)}, strings_can_be_null=False
        ),
    ).combine_chunks()
    texts = [pc.utf8_trim_whitespace(column.combine_chunks() if hasattr(column, "combine_chunks") else column)
             for column in read.columns]  # fmt: skip
    return [pc.replace_substring(text, "\x1f", separator) for text in texts] if odd else texts, kept


def _fitted(cells: list[str], columns: list[Heading], separator: str, place: str) -> list[str]:
    """The cells as many as columns: empty ones beyond them, and comments that are often missing, do not count."""
    while len(cells) > len(columns) and not cells[-1]:
        cells.pop()
    if len(cells) < len(columns) and all(not column.role for column in columns[len(cells) :]):
        cells = cells + [""] * (len(columns) - len(cells))
    if len(cells) != len(columns):
        hint = _DECIMAL_COMMA if separator == "," and len(cells) > len(columns) else None
        count = "1 cell" if len(cells) == 1 else f"{len(cells)} cells"
        problem = f"{count} where the header has {len(columns)} (separator: {_SEPARATORS[separator]})"
        raise InputError(problem, where=place, hint=hint)
    return cells
