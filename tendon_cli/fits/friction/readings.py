"""Readings of two load cells, from a file or from memory: one row per reading, in one unit."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from tendon_cli import say
from tendon_cli.errors import InputError, UsageError
from tendon_cli.fits.log_rows import Floats, Integers
from tendon_cli.readers.clock import first_back
from tendon_cli.readers.heading import Heading, column_called
from tendon_cli.readers.table import Table, read_table
from tendon_cli.units import UnitError, find_unit, force_factor, shorten

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
LARGEST_BEND = 100.0
"""Largest bend angle, rad: a sheath on a rig has no fifteen turns, so a larger number is one in
degrees that is read as radians."""
ENOUGH_ROWS = 40
"""Number of rows within which a working cell reads at least two different values."""
_STRONGEST = 1e12
"""Force, in any unit, that no load cell reads."""
_LARGEST_RATIO = 20.0
"""Largest ratio of one cell to the other in whole numbers: a decimal comma that is read as a
separator makes 1 and 236 of "1,236"."""
_ROLES = ("position", "direction", "time", "bend_angle", "bend_uncertainty", "stroke")
"""Roles of columns beside the cells, in the order in which they are read."""
_TURNS = {"deg": 360.0, "°": 360.0, "rad": 2.0 * math.pi, "rev": 1.0, "": 360.0}
"""One turn of the motor's encoder by the unit of its position; without a unit, in degrees."""
_UNCALIBRATED = {"voltage", "counts"}
"""Dimensions of what a cell gives before it is calibrated."""
_COUNTS = (1e3, 2.0**32)
"""Usual size of whole numbers without a unit that are a converter's counts."""
_CALIBRATE = (
    "subtract each cell's reading without load, multiply by its factor, and save forces in N"
)


@dataclass(frozen=True, eq=False)
class Readings:
    """Readings in the order of the file."""

    rows: pd.DataFrame
    """Table with a row per reading.

    It has `line` in the file, `cell_1` and `cell_2` (NaN without a reading) and, as far as the file
    has them, `direction` and `stroke` (categories), `position` of the motor or its speed, in any
    unit, `bend_angle` and `bend_uncertainty` (rad), `time` (in any unit), `file` (its number, if
    there are several).
    """
    source: str
    """Name of the file."""
    sha256: str
    names: tuple[str, str]
    """Headers of the two cells."""
    position_name: str = ""
    position_is_speed: bool = False
    unit: str | None = None
    """Unit of both cells; None if the file does not say."""
    time_unit: str | None = None
    motor: str | None = None
    """"1" or "2" if the headers say which cell is the motor's."""
    files: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    """Note that names the columns that are not read, for each file that has any."""
    unread_names: tuple[str, ...] = ()
    """Header of a column that may say the direction but is not read, and its words; or empty."""

    @property
    def cells(self) -> tuple[Floats, Floats]:
        """Forces of cell 1 and cell 2."""
        return self.rows["cell_1"].to_numpy(), self.rows["cell_2"].to_numpy()

    def column(self, name: str) -> Floats | None:
        """Return the numbers of a column; None if there is none."""
        return self.rows[name].to_numpy() if name in self.rows else None

    @property
    def times(self) -> Floats:
        """Time of each row, or its number if there is no time; refused if it goes backwards."""
        time = self.column("time")
        if time is None:
            return np.arange(len(self.rows), dtype=np.float64)
        back = first_back(time)
        if back is not None:
            raise InputError(
                f"{back[1]}, so strokes cannot be found",
                where=self.place(back[0]),
                hint="give one log per file, its rows in order of time",
            )
        return time

    def place(self, row: int) -> str:
        """Return file and line of a reading, as errors say it."""
        source = self.source
        if len(self.files) > 1:
            source = self.files[self.rows["file"].iloc[row]]
        return f"{source}, line {self.rows['line'].iloc[row]}"

    def codes(self, name: str) -> tuple[list[str], Integers]:
        """Return the different values of a column of names, and the code of each row's value."""
        values = self.rows[name].cat
        return list(values.categories), values.codes.to_numpy().astype(np.int64)


def read_readings(
    source: Any,
    *,
    cell_1: str | int | None = None,
    cell_2: str | int | None = None,
    direction: str | None = None,
    position: str | None = None,
) -> Readings:
    """Read the columns of two load cells, and the other columns that a fit uses.

    Args:
        source: Path of a CSV of settled readings or a raw log, a DataFrame, or a mapping of arrays,
            whose names serve as headers.
        cell_1: Header of the first cell's column, or its number from 1, if it is not a known one.
        cell_2: Header of the column of the second cell.
        direction: Header of the column of the motor's direction, if it is not one that is known.
        position: Header of the column of the motor's position or speed.

    Raises:
        InputError: if the readings are wrong, with line and column.
        UsageError: if there is no column of a given name, or only one cell is named.
    """
    if (cell_1 is None) != (cell_2 is None):
        raise UsageError(
            "one load cell is named and the other is not",
            where="--cell-1, --cell-2",
            hint="name both",
        )
    names = None if cell_1 is None else (str(cell_1), str(cell_2))
    are_numbers = names is not None and all(name.strip().isdecimal() for name in names)

    def known(columns: Sequence[Heading]) -> list[Heading]:
        """Return the columns that are read of a line that names both cells."""
        if are_numbers and columns[0].header != "column 1":
            return []  # every line has them; the header is the first line that is as wide as most
        cells = _cells_of(columns, names)
        if not cells:
            return []
        return [column for column in columns if column in cells or _meaning_of(column).role]

    where = "" if isinstance(source, Path) else "the readings"
    table = read_table(source, known, source=where, noun="reading")
    cells = _cells_of(table.columns, names)
    shown = ", ".join(column.shown for column in cells[:8])
    if len(cells) > 2:
        raise InputError(
            f"several columns could be the load cells: {shown}",
            where=table.place(),
            hint="name the two with --cell-1 and --cell-2",
        )
    if not cells and not names:
        for dimension in ("mass", "force"):
            found = [one for one in table.columns if one.dimension == dimension and one.name]
            cells = found if len(found) == 2 else cells
        shown = ", ".join(column.shown for column in cells)
        if cells:
            table.notes.append(f"{table.source}: load cells by their unit alone: {shown}")
    if not cells and names:
        named = [shorten(name) for name in names]
        raise UsageError(
            f'no line of {table.source} has one column "{named[0]}" and one "{named[1]}"',
            where="--cell-1, --cell-2",
            hint=f"the columns are {table.shown}",
        )
    if not cells:
        raise InputError(
            f"no header names the two load cells; the columns are {table.shown}",
            where=table.place(),
            hint='call them "load cell 1" and "load cell 2", or name them with --cell-1 and'
            " --cell-2",
        )
    given = {"direction": direction, "position": position}
    return _assembled(table, cells[0], cells[1], given)


def _assembled(
    table: Table, first: Heading, second: Heading, given: dict[str, str | None]
) -> Readings:
    """Read the needed columns of a table, with both cells in one unit.

    Args:
        table: The table.
        first: Column of cell 1.
        second: Column of cell 2.
        given: Headers of other columns that the user names, by role.
    """
    factors = _check_units(table, first, second)
    forces = (table.numbers(first, may_lack=True), table.numbers(second, may_lack=True))
    _check_calibrated(table, first, forces)
    rows: dict[str, Any] = {
        "line": table.lines,
        "cell_1": forces[0] * factors[0],
        "cell_2": forces[1] * factors[1],
    }
    columns: dict[str, Heading] = {}
    for role in _ROLES:
        name = given.get(role)
        found = [column for column in table.columns if _meaning_of(column).role == role]
        column = table.only(found, say.spaced(role)) if name is None else None
        if name is not None:
            column = table.called(name, f"--{role}")
        if column is not None:
            columns[role] = column
    moved = columns.get("position")
    is_speed = moved is not None and bool(_words_of(moved.header) & _SPEED)
    time_unit = ""
    for role, column in columns.items():
        if role == "time":
            rows[role], time_unit = _times(table, column)
        elif role in ("direction", "stroke"):
            names = table.texts(column)
            is_file = table.header is not None
            categories = [*dict.fromkeys(names)] if is_file else None
            rows[role] = pd.Categorical(names, categories=categories)
        elif role == "position":
            rows[role] = table.numbers(column, may_lack=True)
            if not is_speed and column.unit in _TURNS:
                rows[role] = table.unwrapped(column, rows[role], _TURNS[column.unit])
        else:
            rows[role] = _radians(table, column, role)
    table.raise_faults()
    read = [first, second, *columns.values()]
    notes = [*table.unread(read), *table.notes]
    unread: tuple[str, ...] = ()
    if notes and not moved and "direction" not in columns:
        unread = _unread_names(table, read)
    if unread:
        shown = f'"{shorten(unread[0], 30)}"'
        notes[0] += f"; if {shown} says the direction, name it direction or give --direction"
    ends = (_meaning_of(first).end, _meaning_of(second).end)
    motor = None
    if ends[0] != ends[1]:
        motor = "1" if ends[0] == "motor" or ends[1] == "load" else "2"
    return Readings(
        rows=pd.DataFrame(rows, copy=False),
        source=table.source,
        sha256=table.sha256,
        names=(first.header, second.header),
        position_name=moved.header if moved else "",
        position_is_speed=is_speed,
        unit=(first.unit or None) if first.unit == second.unit else "N",
        time_unit=time_unit or None,
        motor=motor,
        files=(table.source,),
        notes=tuple(notes),
        unread_names=unread,
    )


def _unread_names(table: Table, read: list[Heading]) -> tuple[str, ...]:
    """Return the header and the words of a column that is not read but may say the direction.

    Such a column has two or three different words, and one of them in every row.
    """
    known = {column.index for column in read}
    for column in table.columns:
        if column.index in known or not column.header:
            continue
        data = table.data[column.index]
        values = pd.unique(data) if isinstance(data, np.ndarray) else data.unique().to_pylist()
        if len(values) not in {2, 3}:
            continue
        words = {str(value).strip() for value in values}
        if len(words) > 1 and all(re.search(r"[^\W\d_]{2}", word) for word in words):
            return column.header, *sorted(words)
    return ()


class _Meaning(NamedTuple):
    """Meaning of a column by its header."""

    role: str
    """Role: "cell", "time", "direction", "stroke", "bend_angle", "bend_uncertainty", or "" if the
    column is not read."""
    cell: int | None = None
    """1 or 2, if the header numbers the load cells."""
    end: str | None = None
    """"motor" or "load", if the header says at which end of the sheath the cell is."""


@lru_cache(maxsize=1024)
def _meaning_of(column: Heading) -> _Meaning:
    """Find the role of a column by the words of its header; one without a known word has none."""
    known = _words_of(column.text)
    if "angle" in known and known & _ANGLE:
        return _Meaning("bend_uncertainty" if known & _UNCERTAINTY else "bend_angle")
    if not column.dimension and len(known) == 1 and known <= _STROKE | _DIRECTION:
        return _Meaning("stroke" if known <= _STROKE else "direction")
    if (known & _TIME or column.clock) and not known & (_FORCE | _MOTOR | _LOAD):
        return _Meaning("time")
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
    is_named = end is not None or (cell is not None and bool(known & _FORCE))
    is_foreign = column.dimension not in {"", "force", "mass", *_UNCALIBRATED}
    has_unknown_unit = bool(column.unit) and _words_of(column.name) <= _UNDERSTOOD
    is_understood = known <= _UNDERSTOOD or has_unknown_unit
    if not is_named or is_foreign or not is_understood:
        return _Meaning("")
    if cell is not None and not known & _FORCE:
        end = None  # "Load 1" and "Load 2" number the cells
    return _Meaning("cell", cell, end)


def _words_of(text: str) -> set[str]:
    """Words and numbers of a header, without case; "load cell" counts as "cell"."""
    text = re.sub(r"load[\s_-]*cells?", " cell ", text.casefold())
    return set(re.findall(r"[^\W\d_]+|\d+", text))


def _cells_of(columns: Sequence[Heading], names: tuple[str, str] | None) -> list[Heading]:
    """Return the columns of both cells, by the given names or by their headers.

    None are returned unless there are both; more than two if more may be the cells.
    """
    if names:
        called = [column_called(columns, name) for name in names]
        return [] if None in called else [column for column in called if column]
    cells = [column for column in columns if _meaning_of(column).role == "cell"]
    if len(cells) > 2:
        cells = [column for column in cells if column.dimension or not column.unit] or cells
    numbered = [column for column in cells if _meaning_of(column).cell is not None]
    if len(cells) > 2 and numbered:
        cells = numbered
    # Cell 1 is first, or the motor's cell if its header has no number.
    ranks = {column: (_meaning_of(column).cell or 0, _meaning_of(column).end) for column in cells}
    firsts = [column for column, rank in ranks.items() if rank[0] == 1 or rank == (0, "motor")]
    seconds = [column for column in cells if column not in firsts]
    return [*firsts, *seconds] if firsts and seconds else []


def _check_units(table: Table, first: Heading, second: Heading) -> tuple[float, float]:
    """Return the factors that bring both cells to one unit.

    Only the ratio of the forces matters, so equal units need not be known.

    Raises:
        InputError: if the units cannot be compared.
    """
    for cell in (first, second):
        if cell.unit and not cell.dimension:
            try:
                find_unit(cell.unit, "force")
            except UnitError as error:
                raise InputError(error.problem, where=table.place(cell), hint=error.hint) from None
    if first.unit == second.unit:
        if first.dimension in _UNCALIBRATED:
            raise InputError(
                f'the cells are in "{first.unit}", not yet calibrated',
                where=table.place(first),
                hint=_CALIBRATE,
            )
        return 1.0, 1.0
    if not first.unit or not second.unit:
        bare = second if first.unit else first
        known_unit = first.unit or second.unit
        raise InputError(
            f'the unit of {bare.shown} is missing, but the other cell has "{known_unit}"',
            where=table.place(bare),
            hint="give both cells a unit, or neither",
        )
    factors = (force_factor(first.unit), force_factor(second.unit))
    if factors[0] is None or factors[1] is None:
        raise InputError(
            f'the cells are in "{first.unit}" and "{second.unit}", which cannot be compared',
            where=table.place(first),
        )
    return factors[0], factors[1]


def _check_calibrated(table: Table, first: Heading, cells: tuple[Floats, Floats]) -> None:
    """Refuse counts of a converter: large whole numbers of which nothing says the unit."""
    if first.unit:
        return
    for cell in cells:
        known = cell[np.isfinite(cell)]
        if not len(known) or np.any(known != np.round(known)):
            return
        if not _COUNTS[0] <= np.median(np.abs(known)) <= _COUNTS[1]:
            return
    raise InputError(
        "the cells read whole numbers of thousands and have no unit, as the counts of a converter:"
        " not yet calibrated",
        where=table.place(first),
        hint=f"{_CALIBRATE}; if they are forces, write their unit into the headers",
    )


def _times(table: Table, column: Heading) -> tuple[Floats, str]:
    """Return the times with their unit, or the numbers of the rows if they are no times."""
    before = len(table.faults)
    times, unit = table.times(column, may_lack=True)
    if len(table.faults) == before and np.all(np.isfinite(times)):
        return times, unit
    del table.faults[before:]
    return np.arange(len(table), dtype=np.float64), unit


def _radians(table: Table, column: Heading, role: str) -> Floats:
    """Return a column of angles, rad."""
    before = len(table.faults)
    angles, _ = table.quantity(column, "angle", may_lack=True)
    if len(table.faults) > before:
        return angles
    for row in np.flatnonzero(~(angles >= 0.0)).tolist():
        table.refuse("the bend angle is missing or negative", column=column, row=row)
    is_read = len(table.faults) == before
    if is_read and role == "bend_angle" and not 0.0 < angles.max() <= LARGEST_BEND:
        problem = f"bend angles reach {angles.max():.4g} rad, expected above 0 and at most 100"
        table.refuse(problem, column=column)
    return angles


def concatenate(parts: list[Readings]) -> Readings:
    """Concatenate the readings of several files, in this order.

    Strokes of different files stay apart, and the time of a file follows that of the file before.

    Raises:
        InputError: if the files are not of one kind.
    """
    if len(parts) == 1:
        return parts[0]
    first = parts[0]
    names = [name for name in ("direction", "stroke") if name in first.rows]
    frames = []
    end = 0.0
    for number, part in enumerate(parts):
        _check_kind(first, part)
        frame = part.rows.assign(file=number)
        if "direction" in names:
            frame["direction"] = frame["direction"].astype(str)
        if "stroke" in names:
            frame["stroke"] = f"{number}:" + frame["stroke"].astype(str)
        if "time" in frame:
            time = frame["time"].to_numpy()
            frame["time"] = time - time[0] + end
            step = np.median(np.diff(time)) if len(time) > 1 else 1.0
            end = float(frame["time"].iloc[-1] + step)
        frames.append(frame)
    return replace(
        first,
        rows=pd.concat(frames, ignore_index=True).astype(dict.fromkeys(names, "category")),
        source=", ".join(part.source for part in parts),
        sha256=hashlib.sha256("".join(part.sha256 for part in parts).encode()).hexdigest(),
        files=tuple(part.source for part in parts),
        notes=tuple(note for part in parts for note in part.notes),
    )


def _check_kind(first: Readings, part: Readings) -> None:
    """Refuse a file that has other units or columns than the first."""
    if part.unit != first.unit:
        raise InputError(
            f'{part.source} is in "{part.unit}", {first.source} in "{first.unit}"',
            where=part.source,
            hint="save them in one unit",
        )
    differing = set(part.rows) ^ set(first.rows)
    if not differing and part.motor != first.motor:
        differing = {"motor"}
    if differing:
        name = say.spaced(min(map(str, differing)))
        raise InputError(
            f"only one of {first.source} and {part.source} gives the {name}",
            where=part.source,
            hint="fit files of one kind together",
        )


def check_forces(readings: Readings) -> None:
    """Refuse forces that no two working cells give."""
    one, two = readings.cells
    source = readings.source
    largest = max(float(np.nanmax(np.abs(cell), initial=0.0)) for cell in (one, two))
    if largest >= _STRONGEST:
        raise InputError(
            f"forces reach {largest:.3g}, more than any load cell measures",
            where=source,
            hint="is the unit right?",
        )
    is_fixed = all(
        np.nanmin(cell, initial=np.inf) == np.nanmax(cell, initial=-np.inf) for cell in (one, two)
    )
    directions = len(readings.codes("direction")[0]) if "direction" in readings.rows else 0
    if is_fixed and (len(readings.rows) >= ENOUGH_ROWS or directions > 1):
        raise InputError(
            "both cells read the same in every row",
            where=source,
            hint="are these the right columns, and are both cells connected?",
        )
    is_loaded = (one > 0.0) & (two > 0.0)
    if not is_loaded.any():
        return
    one = one[is_loaded]
    two = two[is_loaded]
    if np.all(one == np.round(one)) and np.all(two == np.round(two)):
        ratio = float(np.exp(np.median(np.abs(np.log(one / two)))))
        if ratio > _LARGEST_RATIO:
            raise InputError(
                f"one cell reads {ratio:.0f} times the other, in whole numbers",
                where=source,
                hint="a decimal comma read as a separator? separate the columns by semicolons",
            )
