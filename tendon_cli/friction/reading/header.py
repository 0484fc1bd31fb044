"""What the columns of a readings file are, from their headers."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction

from tendon_cli.errors import InputError
from tendon_cli.units import UNITS, shorten

STANDARD_GRAVITY = Fraction("9.80665")

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
_FIRST, _SECOND = {"1", "i", "one", "a", "first"}, {"2", "ii", "two", "b", "second"}
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
_STROKE, _DIRECTION = {"stroke", "hub"}, {"direction", "dir", "richtung", "case"}
_ANGLE = {"bend", "wrap", "bending", "wrapping", "contact"}
_SPEED = {"speed", "velocity", "rate", "rpm", "geschwindigkeit", "drehzahl"}
_FILLERS = {"at", "the", "of", "side", "end", "on", "mean", "measured", "value"}
_UNDERSTOOD = _FORCE | _FIRST | _SECOND | _MOTOR | _LOAD | _FILLERS
_WRITTEN_UNITS = {
    **{
        symbol.lower(): symbol
        for symbol in (
            "kg",
            "g",
            "N",
            "kN",
            "kgf",
            "gf",
            "lbf",
            "lb",
            "deg",
            "rad",
            "mrad",
            "s",
            "ms",
            "mm",
            "cm",
            "V",
            "mV/V",
        )
    },
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
    """One column of the file: its place, its header and what the header says."""

    index: int
    header: str
    role: str
    """"cell", "time", "direction", "stroke", "bend_angle", "bend_uncertainty", or "" if it is not read."""
    unit: str | None = None
    cell: int | None = None
    """1 or 2, if the header numbers the load cells."""
    end: str | None = None
    """"motor" or "load", if the header says at which end of the sheath the cell is."""

    @property
    def shown(self) -> str:
        """The header as errors quote it."""
        return f'"{shorten(self.header, 30)}"'

    @property
    def is_speed(self) -> bool:
        """Whether a column of the motor's motion is its speed, and not its position."""
        return bool(_words(self.header) & _SPEED)


def unit_symbol(text: str) -> str | None:
    """The unit that a text such as "(kg)" or "N" stands for, or None."""
    bare = unicodedata.normalize("NFC", text).strip().strip("()[]{} ")
    return bare if bare in {"mN", "mV"} else _WRITTEN_UNITS.get(bare.lower())


def force_factor(symbol: str | None) -> float | None:
    """Newtons per unit of force or of mass (as its weight), None for a unit of something else."""
    if symbol == "gf":
        return float(STANDARD_GRAVITY / 1000)
    unit = UNITS.get(symbol or "")
    if unit is None or unit.dimension not in {"force", "mass"}:
        return None
    return float(unit.factor * (STANDARD_GRAVITY if unit.dimension == "mass" else 1))


def read_header(headers: list[str]) -> list[Heading]:
    """What each header says; one that says nothing known is of a column that is not read."""
    return [_heading(index, header) for index, header in enumerate(headers)]


def _heading(index: int, header: str) -> Heading:
    unit, text = _take_unit(unicodedata.normalize("NFKC", header))
    known = _words(text)
    column = Heading(index, header, "", unit)
    if "angle" in known and known & _ANGLE:
        return replace(column, role="bend_uncertainty" if known & _UNCERTAINTY else "bend_angle")
    if unit is None and len(known) == 1 and known <= _STROKE | _DIRECTION:
        return replace(column, role="stroke" if known <= _STROKE else "direction")
    if known & _TIME and not known & (_FORCE | _MOTOR | _LOAD):
        return replace(column, role="time")
    foreign = unit in UNITS and force_factor(unit) is None  # the mm of a motor's position
    cell = 1 if known & _FIRST else 2 if known & _SECOND else None
    end = "motor" if known & _MOTOR else "load" if known & _LOAD else None
    is_named = end is not None or (cell is not None and bool(known & _FORCE))
    is_cell = is_named and not foreign and known <= _UNDERSTOOD
    return replace(column, role="cell", cell=cell, end=end) if is_cell else column


def _take_unit(text: str) -> tuple[str | None, str]:
    """The unit in brackets or at the end, and what is left of the header."""
    for match in re.finditer(r"[(\[{]([^()\[\]{}]*)[)\]}]", text):
        if unit := unit_symbol(match.group(1)):
            return unit, text[: match.start()] + " " + text[match.end() :]
    last = re.fullmatch(r"(.*[\w)\]][\s_,/]+)([^\s_,/]+)\s*", text)
    unit = unit_symbol(last.group(2)) if last else None
    return (unit, re.sub(r"[\s_]in[\s_]*$", " ", last.group(1))) if last and unit else (None, text)


def _words(text: str) -> set[str]:
    return set(
        re.findall(r"[^\W\d_]+|\d+", re.sub(r"load[\s_-]*cells?", " cell ", text.casefold()))
    )


def find_cells(
    columns: list[Heading], names: tuple[str, str] | None, place: str
) -> tuple[Heading, Heading] | None:
    """The columns of both cells, by name or by their headers; None if this is no header, refused if there are more."""
    if names:
        first, second = (named_column(columns, name) for name in names)
        return (first, second) if first and second else None
    cells = [column for column in columns if column.role == "cell"]
    if len(cells) > 2 and any(column.cell is not None for column in cells):
        cells = [column for column in cells if column.cell is not None]
    firsts = [
        column
        for column in cells
        if column.cell == 1 or (column.cell is None and column.end == "motor")
    ]
    seconds = [column for column in cells if column not in firsts]
    if not firsts or not seconds:
        return None
    if len(cells) > 2:
        problem = f"several columns may be the load cells: {', '.join(column.shown for column in cells[:8])}"
        raise InputError(problem, where=place, hint="name the two with --cell-1 and --cell-2")
    return firsts[0], seconds[0]


def named_column(columns: list[Heading], name: str) -> Heading | None:
    """The one column of this header; None if there is none, or several."""
    exact = [column for column in columns if column.header == name.strip()]
    alike = exact or [
        column for column in columns if column.header.casefold() == name.strip().casefold()
    ]
    return alike[0] if len(alike) == 1 else None


def check_units(
    first: Heading, second: Heading, place: Callable[[Heading], str]
) -> tuple[float, float]:
    """Factors that bring both cells to one unit; only their ratio matters, so equal units need not be known."""
    one, two = first.unit, second.unit
    if one == two and one in _VOLTS:
        hint = "take off each cell's reading without load, multiply by its factor, and save forces in N"
        raise InputError(
            f'the cells are in "{one}", before their calibration', where=place(first), hint=hint
        )
    if one == two:
        return 1.0, 1.0
    if one is None or two is None:
        bare = first if one is None else second
        problem = f'the unit of {bare.shown} is missing, the other cell has "{one or two}"'
        raise InputError(problem, where=place(bare), hint="give both cells a unit, or neither")
    factors = force_factor(one), force_factor(two)
    if factors[0] is None or factors[1] is None:
        raise InputError(
            f'the cells are in "{one}" and "{two}", which do not compare', where=place(first)
        )
    return factors[0], factors[1]
