"""How a readings file writes its rows and numbers: the separator, the decimal sign, comments."""

from __future__ import annotations

import csv
import math
import re
from collections import Counter
from dataclasses import dataclass, field

from tendon_cli.errors import InputError
from tendon_cli.friction.reading.text import LogFile
from tendon_cli.units import shorten

_COMMENT = ("#", "%", "//", "*")
_SEPARATORS = ("\t", ";", ",")
_SEPARATOR_NAMES = {"\t": "tab", ";": "semicolon", ",": "comma"}
_NUMBER = re.compile(r"[+-]?(?:\d{1,40}(?:[.,]\d{0,40})?|[.,]\d{1,40})(?:[eE][+-]?\d{1,3})?", re.ASCII)
_INFINITE = re.compile(r"[+-]?(?:inf|infinity|1\.#inf|∞)", re.IGNORECASE)
_LEADING_ZERO = re.compile(r"[+-]?0\d+", re.ASCII)
_MISSING = {"", "nan", "na", "n/a", "null", "none", "-", "--", "?", "1.#qnan"}
_DECIMAL_COMMA = "a decimal comma read as a separator? separate the columns by semicolons"


def is_comment(line: str) -> bool:
    """Whether a line is empty or begins with a comment sign (a footnote's asterisk included)."""
    text = line.lstrip(' \t"\ufeff')
    return not text.strip(' \t"') or text.startswith(_COMMENT)


def find_separator(lines: list[str], source: LogFile) -> str:
    """The separator that divides most of the lines into equally many columns.

    A comma is believed last, since in a file separated by semicolons or tabs it is the decimal sign.
    """
    best, best_share = "", 0.0
    for separator in _SEPARATORS:
        counts = Counter(line.count(separator) for line in lines)
        counts.pop(0, None)
        share = max(counts.values(), default=0) / max(len(lines), 1)
        if share >= 0.5:
            return separator
        if share > best_share:
            best, best_share = separator, share
    if not best:
        raise InputError(
            "no line has more than one column",
            where=source.name,
            hint="columns are separated by comma, semicolon or tab",
        )
    return best


def split(line: str, separator: str, place: str) -> list[str]:
    """The cells of one line, quotes removed; a quoted cell may not run over the end of the line."""
    try:
        cells = next(csv.reader([line], delimiter=separator, skipinitialspace=separator != "\t", strict=True))
    except csv.Error as error:
        raise InputError(f"not a row of CSV: {error}", where=place, hint="check the quotes in this line") from error
    return [cell.strip() for cell in cells]


@dataclass
class NumberReader:
    """Reads numbers one way through a whole file: what is a decimal sign in one row is one in every row."""

    source: LogFile
    separator: str
    decimal: str | None = None
    """The decimal sign, known from the first number that has one."""
    _plain: dict[int, int] = field(default_factory=dict)
    """Per column, the line of the first whole number of 100 or more."""
    _other_than_thousands: set[int] = field(default_factory=set)
    """Columns with a fraction that is not three digits long, so that its sign is no separator of thousands."""
    _with_fraction: dict[int, int] = field(default_factory=dict)
    """Per column, the line of the first number with a decimal sign."""

    def read(self, text: str, line: int, column: int) -> float:
        """One number; NaN where the cell is empty or says that there is no reading."""
        text = text.replace("\u2212", "-")
        if text.lower() in _MISSING:
            return math.nan
        place = self.source.place(line, column)
        if _INFINITE.fullmatch(text):
            raise InputError(f'"{shorten(text)}" is not a finite number', where=place)
        if not _NUMBER.fullmatch(text):
            raise InputError(f'"{shorten(text)}" is not a number', where=place, hint=self._hint(text))
        if _LEADING_ZERO.fullmatch(text) and self.separator == ",":
            raise InputError(f'"{text}" begins with a zero', where=place, hint=_DECIMAL_COMMA)
        self._learn(text, line, column, place)
        number = float(text.replace(",", "."))
        if not math.isfinite(number):
            raise InputError(f'"{shorten(text)}" is too large for a number', where=place)
        return number

    def check_thousands(self) -> None:
        """Refuse a column such as "1,236" beside "858", where the sign may separate thousands."""
        for column, line in self._with_fraction.items():
            if column in self._plain and column not in self._other_than_thousands:
                raise InputError(
                    f'"{self.decimal}" may be a decimal sign or separate thousands: every number that has it has'
                    f" three digits after it, and line {self._plain[column]} has a whole number of 100 or more",
                    where=self.source.place(line, column),
                    hint="write all numbers of the column with the same number of decimals",
                )

    def _learn(self, text: str, line: int, column: int, place: str) -> None:
        sign = "," if "," in text else "." if "." in text else None
        if sign is None:
            if len(text.lstrip("+-")) >= 3:
                self._plain.setdefault(column, line)
            return
        if sign == "," and self.separator == ",":
            raise InputError(
                f'"{text}" has a comma, which may be a decimal sign or separate thousands',
                where=place,
                hint="in a file separated by commas the decimal sign is a point",
            )
        if self.decimal not in {None, sign}:
            raise InputError(
                f'"{text}" has the decimal sign "{sign}", numbers above have "{self.decimal}"', where=place
            )
        self.decimal = sign
        self._with_fraction.setdefault(column, line)
        if not re.search(r"[.,]\d{3}$", text):
            self._other_than_thousands.add(column)

    def _hint(self, text: str) -> str | None:
        if re.match(r"[+-]?[\d.,]+\s*[^\d\s.,]", text):
            return "units belong in the header or in a row below it"
        if re.fullmatch(r"[+-]?\d+[.,][\d.,]+", text):
            return "write numbers without a separator of thousands"
        return None


def ragged(source: LogFile, line: int, found: int, expected: int, separator: str) -> InputError:
    """The error of a row with another number of cells than the header."""
    hint = _DECIMAL_COMMA if separator == "," and found > expected else None
    cells = "cell" if found == 1 else "cells"
    return InputError(
        f"{found} {cells} where the header has {expected} (separator: {_SEPARATOR_NAMES[separator]})",
        where=source.place(line),
        hint=hint,
    )
