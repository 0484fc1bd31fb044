"""What the columns of a readings file are, from their headers."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass, replace
from fractions import Fraction

from tendon_cli.errors import InputError
from tendon_cli.friction.reading.text import LogFile
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
_FILLERS = {"at", "the", "of", "side", "end", "on", "mean", "measured", "value"}
_SPOKEN_UNITS = {
    "kg": "kg", "g": "g", "n": "N", "kn": "kN", "kgf": "kgf", "gf": "gf", "lbf": "lbf", "lb": "lb", "lbs": "lb",
    "gram": "g", "grams": "g", "kilogram": "kg", "kilograms": "kg", "newton": "N", "newtons": "N",
    "deg": "deg", "degree": "deg", "degrees": "deg", "rad": "rad", "radian": "rad", "radians": "rad", "°": "deg",
    "s": "s", "sec": "s", "ms": "ms", "mrad": "mrad", "mm": "mm", "cm": "cm", "v": "V",
    "volt": "V", "volts": "V", "mv": "mV", "mv/v": "mV/V",
}  # fmt: skip
_VOLTS = {"V", "mV", "mV/V"}
_LABELS = (
    re.compile(r"\bcase\s*(\w+?)\b\*{0,2}(?=[\s,:*-]|$)", re.IGNORECASE),
    re.compile(r"\b(up|down|raising|lowering|rising|falling|upward|downward)\b", re.IGNORECASE),
)


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
    label: str | None = None
    """The case or direction that the header itself names, where cases stand side by side."""


@dataclass(frozen=True)
class CellPair:
    """The two columns that give one reading, and the case or direction they stand for."""

    first: Heading
    second: Heading
    label: str | None = None


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
    label, text = _take_label(text)
    words = _words(text)
    known = set(words)
    column = Heading(index, header, "", unit, label=label)
    if "angle" in known and known & _ANGLE_KINDS:
        return replace(column, role="bend angle uncertainty" if known & _UNCERTAINTY else "bend angle")
    if unit is None and len(known) == 1 and known <= _STROKE_NAMES | _DIRECTION_NAMES:
        return replace(column, role="stroke" if known <= _STROKE_NAMES else "direction")
    if known == {"x", "value"}:  # LabVIEW's name for time
        return replace(column, role="time")
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
    return Heading(column.index, column.header, "cell", column.unit, cell, end, column.label)


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


def _take_label(text: str) -> tuple[str | None, str]:
    """Take "case 1" or a word of direction out of a header such as "case 1 load cell II"."""
    spaced = text.replace("_", " ")
    for pattern in _LABELS:
        match = pattern.search(spaced)
        if match:
            return match.group(1), spaced.replace(match.group(0), " ")
    return None, text


def _words(text: str) -> list[str]:
    text = re.sub(r"load[\s_-]*cells?", " cell ", text.casefold())
    return [word for word in re.findall(r"[^\W\d_]+|\d+", text) if word]


def pair_cells(columns: list[Heading], labels: list[str], place: str) -> list[CellPair]:
    """The pairs of cell columns: one, or one per case where the cases stand side by side; none if not a header."""
    cells = [column for column in columns if column.role == "cell"]
    if len(cells) > 2 and any(column.cell is not None for column in cells):
        cells = [column for column in cells if column.cell is not None]
    firsts = [column for column in cells if _is_first(column)]
    seconds = [column for column in cells if not _is_first(column)]
    if not firsts or not seconds:
        return []
    if len(firsts) != len(seconds):
        names = ", ".join(f'"{shorten(column.header, 30)}"' for column in cells[:8])
        raise InputError(
            f"several columns may be the load cells: {names}",
            where=place,
            hint="name the two with --cell-1 and --cell-2",
        )
    pairs = []
    for number, (first, second) in enumerate(zip(firsts, seconds, strict=True), start=1):
        label = first.label or second.label
        if label is None and len(firsts) > 1:
            label = _label_above(labels, min(first.index, second.index)) or str(number)
        pairs.append(CellPair(first, second, label))
    return pairs


def _is_first(column: Heading) -> bool:
    return column.cell == 1 if column.cell is not None else column.end == "motor"


def _label_above(labels: list[str], index: int) -> str | None:
    """The label in the row above the header that spans this column: the nearest one at or left of it."""
    for label in reversed(labels[: index + 1]):
        if label.strip():
            return re.sub(r"^case[\s_]*", "", label.strip(" *:"), flags=re.IGNORECASE) or label
    return None


def named_pair(columns: list[Heading], cell_1: str, cell_2: str) -> list[CellPair]:
    """The pair of columns that the options name; empty where this line has not both of them."""
    found = []
    for name in (cell_1, cell_2):
        exact = [column for column in columns if column.header == name.strip()]
        loose = [column for column in columns if column.header.casefold() == name.strip().casefold()]
        same = exact or loose
        if len(same) != 1:
            return []
        found.append(same[0])
    return [CellPair(found[0], found[1])]


def check_units(pair: CellPair, source: LogFile, line: int) -> tuple[float, float]:
    """Factors that bring both cells to one unit; only their ratio matters, so equal units need not be known."""
    one, two = pair.first.unit, pair.second.unit
    if one == two and one in _VOLTS:
        raise InputError(
            f'the cells are in "{one}", before their calibration',
            where=source.place(line, pair.first.index),
            hint="take off each cell's reading without load, multiply by its factor, and save forces in N",
        )
    if one == two:
        return 1.0, 1.0
    if one is None or two is None:
        bare = pair.first if one is None else pair.second
        raise InputError(
            f'the unit of "{shorten(bare.header, 30)}" is missing, the other cell has "{one or two}"',
            where=source.place(line, bare.index),
            hint="give both cells a unit, or neither",
        )
    factors = force_factor(one), force_factor(two)
    if factors[0] is None or factors[1] is None:
        raise InputError(f'the cells are in "{one}" and "{two}", which do not compare', where=source.place(line))
    return factors[0], factors[1]
