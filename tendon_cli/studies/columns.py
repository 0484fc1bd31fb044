"""Columns of numbers from a CSV beside a study: by name, with units in the header, whatever separates them."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Mapping

import numpy as np

from tendon_cli.errors import InputError
from tendon_cli.model.kinematics import Array
from tendon_cli.units import UNITS, factor_of, known_units, shorten


def read_columns(
    content: bytes, where: str, columns: Mapping[str, str], of: str, unit: str = ""
) -> tuple[Array, list[int]]:
    """Columns of SI numbers, shape (columns, rows), and the line of each row; `columns` has the dimension of each.

    A header is a name with its unit, such as `angle (deg)` or `torque_Nm`; `unit` is that of one without. Comma,
    semicolon or tab stands between cells, and with the latter two a comma may be the decimal sign. Lines that start
    with # are comments, and `of` is what a row is of. Raises InputError with the line at fault.
    """
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError("not UTF-8 text", where=where, hint="save it as CSV in UTF-8") from None
    lines = [(at, line) for at, line in enumerate(text.splitlines(), 1) if line.strip() and line.lstrip()[0] != "#"]
    if not lines:
        problem = f"holds no {of}s, expected a header {', '.join(columns)} and a line for each {of}"
        raise InputError(problem, where=where)
    separator = next((sign for sign in ";\t" if sign in lines[0][1]), ",")
    header = _cells(lines[0][1], separator)
    places = [_place(header, *each, unit, f"{where}, line {lines[0][0]}") for each in columns.items()]
    rows = [[_number(_cells(line, separator), line, place, separator, f"{where}, line {at}") for place in places]
            for at, line in lines[1:]]  # fmt: skip
    return np.array(rows).reshape(-1, len(columns)).T, [at for at, _ in lines[1:]]


def _cells(line: str, separator: str) -> list[str]:
    try:
        return next(csv.reader([line], delimiter=separator))
    except csv.Error as error:
        return [str(error)]


def _place(header: list[str], name: str, dimension: str, unit: str, where: str) -> tuple[int, str, float]:
    """Where a column is, its name, and SI values per value in it."""
    pattern = re.compile(rf"\s*{name}(?:\s*[\[(_ ]\s*(?P<unit>.*?)\s*[\])]?)?\s*", re.IGNORECASE)
    cells = [(at, match["unit"] or unit) for at, cell in enumerate(header) if (match := pattern.fullmatch(cell))]
    expected = f"such as {name} ({unit or known_units(dimension)[0]})"
    if not cells:
        problem = f"no column {name}, the header reads: {shorten(', '.join(header))}"
        raise InputError(problem, where=where, hint=expected)
    at, written = cells[0]
    if not written:
        raise InputError(f"the column {name} has no unit", where=where, hint=expected)
    plain = {_plain(symbol): symbol for symbol in reversed(known_units(dimension))}
    symbol = written if written in UNITS else plain.get(_plain(written), "")
    if symbol not in UNITS or UNITS[symbol].dimension != dimension:
        hint = f"units of {dimension}: {', '.join(known_units(dimension))}"
        raise InputError(f'the column {name} has the unit "{shorten(written)}"', where=where, hint=hint)
    return at, name, factor_of(symbol)


def _plain(symbol: str) -> str:
    return re.sub(r"[\s_·*.]", "", symbol).lower()


def _number(cells: list[str], line: str, place: tuple[int, str, float], separator: str, where: str) -> float:
    at, name, factor = place
    cell = cells[at].strip() if at < len(cells) else ""
    hint = f"the line reads: {shorten(line.strip())}"
    try:
        number = float(cell.replace(",", ".") if separator != "," else cell)
    except ValueError:
        raise InputError(f'{name} is "{shorten(cell)}", expected a number', where=where, hint=hint) from None
    if not math.isfinite(number) or abs(number) > 1e9:
        raise InputError(f"{name} is {number}, expected a finite number", where=where, hint=hint)
    return number * factor
