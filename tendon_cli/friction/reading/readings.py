"""Readings of two load cells, from a file or from memory: one row per reading, in one unit."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from tendon_cli import say
from tendon_cli.errors import InputError, UsageError
from tendon_cli.friction.reading.header import (
    Heading,
    check_units,
    find_cells,
    named_column,
    read_header,
)
from tendon_cli.friction.reading.table import MOST_ROWS, Table, read_table
from tendon_cli.units import shorten

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]

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
_ANGLES = {"deg": math.pi / 180.0, "rad": 1.0, "mrad": 1e-3}
"""Units of angle, in rad."""


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
        back = np.flatnonzero(np.diff(time) < 0.0)
        if len(back):
            problem = "time goes backwards in this row, so strokes cannot be found"
            hint = "give one log per file, its rows in order of time"
            raise InputError(problem, where=self.place(int(back[0]) + 1), hint=hint)
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
    cell_1: str | None = None,
    cell_2: str | None = None,
    direction: str | None = None,
    position: str | None = None,
) -> Readings:
    """Read the columns of two load cells, and the other columns that a fit uses.

    Args:
        source: Path of a CSV of settled readings or a raw log, a DataFrame, or a mapping of arrays,
            whose names serve as headers.
        cell_1: Header of the column of the first cell, if it is not one that is known.
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
    names = (cell_1, cell_2) if cell_1 is not None and cell_2 is not None else None
    table = read_table(source, names) if isinstance(source, Path) else _table_of(source, names)
    return _assembled(table, direction, position)


def _table_of(frame: Any, names: tuple[str, str] | None) -> Table:
    """Make a table of columns in memory; rows count from 0, as in pandas."""
    where = "the readings"
    try:
        given = pd.DataFrame({str(name): np.asarray(frame[name]) for name in frame})
    except (TypeError, ValueError, LookupError) as error:
        problem = (
            f"{type(frame).__name__} is not a path, a DataFrame"
            " or a mapping of arrays of equal length"
        )
        raise UsageError(problem, where="fit_friction") from error
    if not 0 < len(given) <= MOST_ROWS:
        raise InputError(f"{len(given):,} readings, expected 1 to {MOST_ROWS:,}", where=where)
    columns = read_header([str(name) for name in given])
    cells = find_cells(columns, names, where)
    if cells is None:
        shown = ", ".join(column.shown for column in columns[:12])
        problem = f"no header names the two load cells; the columns are {shown}"
        raise InputError(problem, where=where, hint="name them with cell_1 and cell_2")
    digest = hashlib.sha256()
    data = [given[name].to_numpy() for name in given]
    for values in data:
        if values.dtype == object:
            digest.update(repr(values.tolist()).encode())
        else:
            digest.update(values.tobytes())
    return Table(
        source=where,
        sha256=digest.hexdigest(),
        columns=columns,
        cells=cells,
        lines=np.arange(len(given)),
        data=data,
    )


def _assembled(table: Table, direction: str | None, position: str | None) -> Readings:
    """Read the needed columns of a table, with both cells in one unit."""
    first, second = table.cells
    factors = check_units(first, second, table.place)
    rows: dict[str, Any] = {
        "line": table.lines,
        "cell_1": table.numbers(first) * factors[0],
        "cell_2": table.numbers(second) * factors[1],
    }
    moved = _stated_column(table, position, "--position")
    if moved:
        rows["position"] = table.numbers(moved)
    directed = _stated_column(table, direction, "--direction")
    readers: dict[str, Callable[[Table, Heading], Any]] = {
        "time": _times,
        "bend_angle": _radians,
        "bend_uncertainty": _radians,
        "direction": Table.names,
        "stroke": Table.names,
    }
    columns = {
        role: directed if directed and role == "direction" else table.find(role) for role in readers
    }
    for role, column in columns.items():
        if column:
            rows[role] = readers[role](table, column)
    table.raise_faults()
    time = columns["time"]
    read = [first, second, moved, *columns.values()]
    notes = table.unread(read)
    unread: tuple[str, ...] = ()
    if notes and not moved and not columns["direction"]:
        unread = _unread_names(table, read)
    if unread:
        shown = f'"{shorten(unread[0], 30)}"'
        notes[0] += f"; if {shown} says the direction, name it direction or give --direction"
    return Readings(
        rows=pd.DataFrame(rows, copy=False),
        source=table.source,
        sha256=table.sha256,
        names=(first.header, second.header),
        position_name=moved.header if moved else "",
        position_is_speed=bool(moved and moved.is_speed),
        unit=first.unit if first.unit == second.unit else "N",
        time_unit=time.unit if time else None,
        motor=_motor_by_headers(first, second),
        files=(table.source,),
        notes=tuple(notes),
        unread_names=unread,
    )


def _stated_column(table: Table, name: str | None, option: str) -> Heading | None:
    """Return the column that an option names, None without a name; refuse one that is not there."""
    column = None if name is None else named_column(table.columns, name)
    if name is not None and column is None:
        hint = f"the columns are {', '.join(column.shown for column in table.columns[:12])}"
        raise UsageError(f'there is no column "{shorten(name)}"', where=option, hint=hint)
    return column


def _unread_names(table: Table, read: list[Heading | None]) -> tuple[str, ...]:
    """Return the header and the words of a column that is not read but may say the direction.

    Such a column has two or three different words, and one of them in every row.
    """
    known = {column.index for column in read if column}
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


def _motor_by_headers(first: Heading, second: Heading) -> str | None:
    """Return "1" or "2", the cell that the headers say is the motor's; None if they do not."""
    if first.end:
        return "1" if first.end == "motor" else "2"
    if second.end:
        return "2" if second.end == "motor" else "1"
    return None


def _times(table: Table, column: Heading) -> Floats:
    """Return the times, or the numbers of the rows if they are no numbers but times of day."""
    order = np.arange(len(table.lines), dtype=np.float64)
    times, faults = table.parsed(column)
    is_time = not faults and bool(np.all(np.isfinite(times)))
    return times if is_time else order


def _radians(table: Table, column: Heading) -> Floats:
    """Return a column of angles, rad."""
    if column.unit not in _ANGLES:
        problem = f"{column.shown} has no unit of angle"
        hint = "call the column bend_angle_deg or bend_angle_rad"
        raise InputError(problem, where=table.place(column), hint=hint)
    values, faults = table.parsed(column)
    angles = values * _ANGLES[column.unit]
    if not faults:
        for row in np.flatnonzero(~(angles >= 0.0)).tolist():
            problem = "the bend angle is missing or negative"
            faults.append(InputError(problem, where=table.place(column, row)))
    if not faults and column.role == "bend_angle" and not 0.0 < angles.max() <= LARGEST_BEND:
        problem = f"bend angles reach {angles.max():.4g} rad, expected above 0 and at most 100"
        faults.append(InputError(problem, where=table.place(column)))
    table.faults += faults
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
        problem = f'{part.source} is in "{part.unit}", {first.source} in "{first.unit}"'
        raise InputError(problem, where=part.source, hint="save them in one unit")
    differing = set(part.rows) ^ set(first.rows)
    if not differing and part.motor != first.motor:
        differing = {"motor"}
    if differing:
        name = say.spaced(min(map(str, differing)))
        problem = f"only one of {first.source} and {part.source} gives the {name}"
        raise InputError(problem, where=part.source, hint="fit files of one kind together")


def check_forces(readings: Readings) -> None:
    """Refuse forces that no two working cells give."""
    one, two = readings.cells
    source = readings.source
    largest = max(float(np.nanmax(np.abs(cell), initial=0.0)) for cell in (one, two))
    if largest >= _STRONGEST:
        problem = f"forces reach {largest:.3g}, more than any load cell measures"
        raise InputError(problem, where=source, hint="is the unit right?")
    is_fixed = all(
        np.nanmin(cell, initial=np.inf) == np.nanmax(cell, initial=-np.inf) for cell in (one, two)
    )
    directions = len(readings.codes("direction")[0]) if "direction" in readings.rows else 0
    if is_fixed and (len(readings.rows) >= ENOUGH_ROWS or directions > 1):
        hint = "are these the right columns, and are both cells connected?"
        raise InputError("both cells read the same in every row", where=source, hint=hint)
    is_loaded = (one > 0.0) & (two > 0.0)
    if not is_loaded.any():
        return
    one = one[is_loaded]
    two = two[is_loaded]
    if np.all(one == np.round(one)) and np.all(two == np.round(two)):
        ratio = float(np.exp(np.median(np.abs(np.log(one / two)))))
        if ratio > _LARGEST_RATIO:
            problem = f"one cell reads {ratio:.0f} times the other, in whole numbers"
            hint = "a decimal comma read as a separator? separate the columns by semicolons"
            raise InputError(problem, where=source, hint=hint)
