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

_FORCE_WORDS = {"cell", "lc", "force", "forces", "tension", "f", "sensor", "reading", "weight",
                "kraft", "zugkraft", "kraftsensor", "kraftmessdose"}  # fmt: skip
_FIRST = {"1", "i", "one", "a", "first"}
_SECOND = {"2", "ii", "two", "b", "second"}
_MOTOR_WORDS = {"motor", "proximal", "prox", "input", "in", "drive", "actuator", "spool",
                "antrieb", "motorseite", "motorkraft", "eingang"}  # fmt: skip
_LOAD_WORDS = {"load", "distal", "dist", "output", "out", "elbow", "weight",
               "last", "lastseite", "lastkraft", "abtrieb", "ausgang"}  # fmt: skip
_TIME_WORDS = {"time", "t", "timestamp", "date", "datetime", "elapsed", "clock", "zeit",
               "zeitstempel"}  # fmt: skip
_UNCERTAINTY = {"uncertainty", "std", "sd", "sigma", "error", "unsicherheit"}
_STROKE_NAMES, _DIRECTION_NAMES = {"stroke", "hub"}, {"direction", "dir", "richtung"}
_ANGLE_KINDS = {"bend", "wrap", "bending", "wrapping", "contact"}
_NOT_A_FORCE = {
    "position", "pos", "speed", "velocity", "current", "angle", "torque", "temperature", "temp", "voltage", "status",
    "displacement", "setpoint", "command", "target", "rpm", "encoder", "count", "counts", "error", "raw", "rate",
    "stretch", "offset", "x", "y", "z", "id", "number", "no", "note", "comment", "direction", "stroke", "std", "sd",
}  # fmt: skip
_MOTION = {"position", "pos", "travel", "encoder", "counts", "speed", "velocity", "displacement", "weg"}
_FILLERS = {"at", "the", "of", "side", "end", "on", "mean", "measured", "value"}
_SPOKEN_UNITS = {
    "kg": "kg", "g": "g", "n": "N", "kn": "kN", "kgf": "kgf", "gf": "gf", "lbf": "lbf", "lb": "lb", "lbs": "lb",
    "gram": "g", "grams": "g", "kilogram": "kg", "kilograms": "kg", "newton": "N", "newtons": "N",
    "deg": "deg", "degree": "deg", "degrees": "deg", "rad": "rad", "radian": "rad", "radians": "rad", "°": "deg",
    "s": "s", "sec": "s", "ms": "ms", "mrad": "mrad", "mm": "mm", "cm": "cm", "v": "V",
    "volt": "V", "volts": "V", "mv": "mV", "mv/v": "mV/V",
}  # fmt: skip
_VOLTS = {"V", "mV", "mV/V"}


@dataclass(frozen=True)
class Heading:
    """One column of the file: its place, its header and what the header says."""

    index: int
    header: str
    role: str
    """"cell", "time", "direction", "case", "stroke", "bend angle" or "" for one that is not read."""
    unit: str | None = None
    cell: int | None = None
    """1 or 2, where the header numbers the load cells."""
    end: str | None = None
    """"motor" or "load", where the header says at which end of the sheath the cell is."""


def unit_symbol(text: str) -> str | None:
    """The unit that a text such as "(kg)" or "N" stands for, or None."""
    bare = unicodedata.normalize("NFC", text).strip().strip("()[]{} ")
    return bare if bare in {"mN", "mV"} else _SPOKEN_UNITS.get(bare.lower())


def force_factor(symbol: str) -> float | None:
    """Newtons per unit of force or of mass (as its weight), None for a unit of something else."""
    if symbol == "gf":
        return float(STANDARD_GRAVITY / 1000)
    unit = UNITS.get(symbol)
    if unit is None or unit.dimension not in {"force", "mass"}:
        return None
    return float(unit.factor * (STANDARD_GRAVITY if unit.dimension == "mass" else 1))


def read_column(index: int, header: str) -> Heading:
    """What one header says; a header that says nothing known is a column that is not read."""
    text = unicodedata.normalize("NFKC", header)
    if text.casefold().strip(" *:") == "case":
        return Heading(index, header, "case")
    unit, text = _take_unit(text)
    known = set(_words(text))
    column = Heading(index, header, "", unit)
    if "angle" in known and known & _ANGLE_KINDS:
        return replace(column, role="bend angle uncertainty" if known & _UNCERTAINTY else "bend angle")
    if unit is None and len(known) == 1 and known <= _STROKE_NAMES | _DIRECTION_NAMES:
        return replace(column, role="stroke" if known <= _STROKE_NAMES else "direction")
    if known & _TIME_WORDS and not known & (_FORCE_WORDS | _MOTOR_WORDS | _LOAD_WORDS):
        return replace(column, role="time")
    return _as_cell(column, known)


def _as_cell(column: Heading, known: set[str]) -> Heading:
    foreign = unit_is_foreign(column.unit)
    if not known or known & _NOT_A_FORCE or foreign:
        return column
    cell = 1 if known & _FIRST else 2 if known & _SECOND else None
    end = "motor" if known & _MOTOR_WORDS else "load" if known & _LOAD_WORDS else None
    understood = known <= _FORCE_WORDS | _FIRST | _SECOND | _MOTOR_WORDS | _LOAD_WORDS | _FILLERS
    if not understood or (end is None and (cell is None or not known & _FORCE_WORDS)):
        return column
    return Heading(column.index, column.header, "cell", column.unit, cell, end)


def unit_is_foreign(unit: str | None) -> bool:
    """Whether a unit is known and measures neither force nor mass, as the mm of a motor's position."""
    return unit is not None and unit in UNITS and force_factor(unit) is None


def _take_unit(text: str) -> tuple[str | None, str]:
    for match in re.finditer(r"[(\[{]([^()\[\]{}]*)[)\]}]", text):
        unit = unit_symbol(match.group(1))
        if unit:
            return unit, text[: match.start()] + " " + text[match.end() :]
    last = re.fullmatch(r"(.*[\w)\]][\s_,/]+)([^\s_,/]+)\s*", text)
    unit = unit_symbol(last.group(2)) if last else None
    return (unit, re.sub(r"[\s_]in[\s_]*$", " ", last.group(1))) if last and unit else (None, text)


def _words(text: str) -> list[str]:
    text = re.sub(r"load[\s_-]*cells?", " cell ", text.casefold())
    return [word for word in re.findall(r"[^\W\d_]+|\d+", text) if word]


def find_cells(columns: list[Heading], place: str) -> tuple[Heading, Heading] | None:
    """The columns of the first and the second cell; None if this line is no header; refused if there are several."""
    cells = [column for column in columns if column.role == "cell"]
    if len(cells) > 2 and any(column.cell is not None for column in cells):
        cells = [column for column in cells if column.cell is not None]
    firsts = [column for column in cells if (column.cell == 1 if column.cell is not None else column.end == "motor")]
    seconds = [column for column in cells if column not in firsts]
    if not firsts or not seconds:
        return None
    if len(cells) > 2:
        names = ", ".join(f'"{shorten(column.header, 30)}"' for column in cells[:8])
        hint = "name the two with --cell-1 and --cell-2"
        raise InputError(f"several columns may be the load cells: {names}", where=place, hint=hint)
    return firsts[0], seconds[0]


def named_column(columns: list[Heading], name: str) -> Heading | None:
    """The one column of this header; None if there is none, or several."""
    exact = [column for column in columns if column.header == name.strip()]
    found = exact or [column for column in columns if column.header.casefold() == name.strip().casefold()]
    return found[0] if len(found) == 1 else None


def is_speed(column: Heading) -> bool:
    """Whether a column of the motor's motion is its speed, and not its position."""
    words = set(_words(column.header))
    return bool(words & {"speed", "velocity", "rate", "rpm", "geschwindigkeit", "drehzahl"})


def moves(column: Heading) -> bool:
    """Whether a column that is not read may be the motor's motion."""
    return not column.role and bool(set(_words(column.header)) & _MOTION)


def check_units(first: Heading, second: Heading, place: Callable[[Heading], str]) -> tuple[float, float]:
    """Factors that bring both cells to one unit; only their ratio matters, so equal units need not be known."""
    one, two = first.unit, second.unit
    if one == two and one in _VOLTS:
        raise InputError(
            f'the cells are in "{one}", before their calibration',
            where=place(first),
            hint="take off each cell's reading without load, multiply by its factor, and save forces in N",
        )
    if one == two:
        return 1.0, 1.0
    if one is None or two is None:
        bare = first if one is None else second
        raise InputError(
            f'the unit of "{shorten(bare.header, 30)}" is missing, the other cell has "{one or two}"',
            where=place(bare),
            hint="give both cells a unit, or neither",
        )
    factors = force_factor(one), force_factor(two)
    if factors[0] is None or factors[1] is None:
        raise InputError(f'the cells are in "{one}" and "{two}", which do not compare', where=place(first))
    return factors[0], factors[1]
