"""Roles and units of the columns of a readings file, from their headers."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction

from tendon_cli.errors import InputError
from tendon_cli.units import UNITS, shorten

STANDARD_GRAVITY = Fraction("9.80665")
"""Standard acceleration of gravity, m/s²."""

# Words of headers, English and German, by what they say of a column.
_FORCE = {
    "cell",
    "lc",
    "force",
    "forces",
    "tension",
    "f",
    "sensor",
    "reading",
    "weight",
    "kraft",
    "zugkraft",
    "kraftsensor",
    "kraftmessdose",
}
_FIRST = {"1", "i", "one", "a", "first"}
_SECOND = {"2", "ii", "two", "b", "second"}
_MOTOR = {
    "motor",
    "proximal",
    "prox",
    "input",
    "in",
    "drive",
    "actuator",
    "spool",
    "antrieb",
    "motorseite",
    "motorkraft",
    "eingang",
}
_LOAD = {
    "load",
    "distal",
    "dist",
    "output",
    "out",
    "elbow",
    "weight",
    "last",
    "lastseite",
    "lastkraft",
    "abtrieb",
    "ausgang",
}
_TIME = {"time", "t", "timestamp", "date", "datetime", "elapsed", "clock", "zeit", "zeitstempel"}
_UNCERTAINTY = {"uncertainty", "std", "sd", "sigma", "error", "unsicherheit"}
_STROKE = {"stroke", "hub"}
_DIRECTION = {"direction", "dir", "richtung", "case"}
_ANGLE = {"bend", "wrap", "bending", "wrapping", "contact"}
_SPEED = {"speed", "velocity", "rate", "rpm", "geschwindigkeit", "drehzahl"}
_FILLERS = {"at", "the", "of", "side", "end", "on", "mean", "measured", "value"}
_UNDERSTOOD = _FORCE | _FIRST | _SECOND | _MOTOR | _LOAD | _FILLERS
_FORCE_UNITS = ("N", "kN", "kgf", "gf", "lbf", "lb", "kg", "g")
_OTHER_UNITS = ("deg", "rad", "mrad", "s", "ms", "mm", "cm", "V", "mV/V")
_WRITTEN_UNITS = {
    **{symbol.lower(): symbol for symbol in _FORCE_UNITS + _OTHER_UNITS},
    "lbs": "lb",
    "gram": "g",
    "grams": "g",
    "kilogram": "kg",
    "kilograms": "kg",
    "newton": "N",
    "newtons": "N",
    "degree": "deg",
    "degrees": "deg",
    "°": "deg",
    "radian": "rad",
    "radians": "rad",
    "sec": "s",
    "volt": "V",
    "volts": "V",
}
_VOLTS = {"V", "mV", "mV/V"}


@dataclass(frozen=True)
class Heading:
    """Column of a file: its number, its header and what the header says."""

    index: int
    header: str
    role: str
    """Role: "cell", "time", "direction", "stroke", "bend_angle", "bend_uncertainty", or "" if it
    is not read."""
    unit: str | None = None
    cell: int | None = None
    """1 or 2, if the header numbers the load cells."""
    end: str | None = None
    """"motor" or "load", if the header says at which end of the sheath the cell is."""

    @property
    def shown(self) -> str:
        """Header as errors quote it."""
        return f'"{shorten(self.header, 30)}"'

    @property
    def is_speed(self) -> bool:
        """True if a column of the motor's motion holds its speed rather than its position."""
        return bool(words_of(self.header) & _SPEED)


def unit_symbol(text: str) -> str | None:
    """Return the unit that a text such as "(kg)" or "N" stands for, or None."""
    bare = unicodedata.normalize("NFC", text).strip().strip("()[]{} ")
    return bare if bare in {"mN", "mV"} else _WRITTEN_UNITS.get(bare.lower())


def force_factor(symbol: str | None) -> float | None:
    """Return newtons per unit of force, or per unit of mass by its weight; None for others."""
    if symbol == "gf":
        return float(STANDARD_GRAVITY / 1000)
    unit = UNITS.get(symbol or "")
    if unit is None or unit.dimension not in {"force", "mass"}:
        return None
    weight = STANDARD_GRAVITY if unit.dimension == "mass" else 1
    return float(unit.factor * weight)


def read_header(headers: list[str]) -> list[Heading]:
    """Read the headers of all columns; a column whose header has no known word is not read."""
    return [_heading(index, header) for index, header in enumerate(headers)]


def _heading(index: int, header: str) -> Heading:
    """Find the role and unit of a column by the words of its header."""
    unit, text = split_unit(unicodedata.normalize("NFKC", header))
    known = words_of(text)
    column = Heading(index, header, "", unit)
    if "angle" in known and known & _ANGLE:
        return replace(column, role="bend_uncertainty" if known & _UNCERTAINTY else "bend_angle")
    if unit is None and len(known) == 1 and known <= _STROKE | _DIRECTION:
        return replace(column, role="stroke" if known <= _STROKE else "direction")
    if known & _TIME and not known & (_FORCE | _MOTOR | _LOAD):
        return replace(column, role="time")
    cell = None
    if known & _FIRST:
        cell = 1
    elif known & _SECOND:
        cell = 2
    end = None
    if known & _MOTOR:
        end = "motor"
    elif known & _LOAD:
        end = "load"
    is_foreign = unit in UNITS and force_factor(unit) is None  # mm of a motor's position
    is_named = end is not None or (cell is not None and bool(known & _FORCE))
    is_cell = is_named and not is_foreign and known <= _UNDERSTOOD
    return replace(column, role="cell", cell=cell, end=end) if is_cell else column


def split_unit(text: str) -> tuple[str | None, str]:
    """Split off the unit in brackets or at the end; return it, and the rest of the header."""
    for match in re.finditer(r"[(\[{]([^()\[\]{}]*)[)\]}]", text):
        if unit := unit_symbol(match.group(1)):
            return unit, text[: match.start()] + " " + text[match.end() :]
    last = re.fullmatch(r"(.*[\w)\]][\s_,/]+)([^\s_,/]+)\s*", text)
    unit = unit_symbol(last.group(2)) if last else None
    if last is None or unit is None:
        return None, text
    return unit, re.sub(r"[\s_]in[\s_]*$", " ", last.group(1))


def words_of(text: str) -> set[str]:
    """Words and numbers of a header, without case; "load cell" counts as "cell"."""
    text = re.sub(r"load[\s_-]*cells?", " cell ", text.casefold())
    return set(re.findall(r"[^\W\d_]+|\d+", text))


def find_cells(
    columns: list[Heading], names: tuple[str, str] | None, place: str
) -> tuple[Heading, Heading] | None:
    """Find the columns of both cells, by the given names or by their headers.

    Args:
        columns: Columns of a line that may be the header.
        names: Headers that the user gives; None if they are not given.
        place: Place of the line, for messages.

    Returns:
        Both columns; None if the line is no header.

    Raises:
        InputError: if more than two columns may be the cells.
    """
    if names:
        first = named_column(columns, names[0])
        second = named_column(columns, names[1])
        return (first, second) if first and second else None
    cells = [column for column in columns if column.role == "cell"]
    numbered = [column for column in cells if column.cell is not None]
    if len(cells) > 2 and numbered:
        cells = numbered
    firsts = [column for column in cells if _is_first(column)]
    seconds = [column for column in cells if not _is_first(column)]
    if not firsts or not seconds:
        return None
    if len(cells) > 2:
        shown = ", ".join(column.shown for column in cells[:8])
        problem = f"several columns could be the load cells: {shown}"
        raise InputError(problem, where=place, hint="name the two with --cell-1 and --cell-2")
    return firsts[0], seconds[0]


def _is_first(column: Heading) -> bool:
    """True for cell 1, and for the motor's cell if its header has no number."""
    return column.cell == 1 or (column.cell is None and column.end == "motor")


def named_column(columns: list[Heading], name: str) -> Heading | None:
    """Return the only column with this header; None if there is none or several."""
    name = name.strip()
    matches = [column for column in columns if column.header == name]
    if not matches:
        matches = [column for column in columns if column.header.casefold() == name.casefold()]
    return matches[0] if len(matches) == 1 else None


def check_units(
    first: Heading, second: Heading, place: Callable[[Heading], str]
) -> tuple[float, float]:
    """Return the factors that bring both cells to one unit.

    Only the ratio of the forces matters, so equal units need not be known.

    Args:
        first: Column of cell 1.
        second: Column of cell 2.
        place: Function that returns the place of a column, for messages.

    Raises:
        InputError: if the units cannot be compared.
    """
    first_unit = first.unit
    second_unit = second.unit
    if first_unit == second_unit and first_unit in _VOLTS:
        problem = f'the cells are in "{first_unit}", not yet calibrated'
        hint = (
            "subtract each cell's reading without load, multiply by its factor,"
            " and save forces in N"
        )
        raise InputError(problem, where=place(first), hint=hint)
    if first_unit == second_unit:
        return 1.0, 1.0
    if first_unit is None or second_unit is None:
        bare = first if first_unit is None else second
        known_unit = first_unit or second_unit
        problem = f'the unit of {bare.shown} is missing, but the other cell has "{known_unit}"'
        raise InputError(problem, where=place(bare), hint="give both cells a unit, or neither")
    factor_one = force_factor(first_unit)
    factor_two = force_factor(second_unit)
    if factor_one is None or factor_two is None:
        problem = f'the cells are in "{first_unit}" and "{second_unit}", which cannot be compared'
        raise InputError(problem, where=place(first))
    return factor_one, factor_two
