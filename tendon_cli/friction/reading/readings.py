"""Readings of two load cells, from a file or from memory: one row per reading, in one unit."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

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
"""More than fifteen turns, in rad: no sheath on a rig, but a number in degrees taken for radians."""
_MANY = 40
"""Rows in which a cell that works reads two values at least."""
_STRONGEST = 1e12
_LARGEST_RATIO = 20.0
"""Of one cell over the other: what a decimal comma leaves of "1,236" is a thousand."""
_ANGLES = {"deg": math.pi / 180.0, "rad": 1.0, "mrad": 1e-3}


@dataclass(frozen=True, eq=False)
class Readings:
    """Readings in the order of the file.

    `rows` has a row per reading: `line` in the file, `cell_1` and `cell_2` (NaN without a reading) and, as far as the
    file has them, `direction` and `stroke` (categories), `position` of the motor or its speed, in any unit,
    `bend_angle` and `bend_uncertainty` (rad), `time` (in any unit), `file` (its number, if there are several).
    """

    rows: pd.DataFrame
    source: str
    """Name of the file."""
    sha256: str
    names: tuple[str, str]
    """Headers of the two cells."""
    position_name: str = ""
    position_is_speed: bool = False
    unit: str | None = None
    """Of both cells; None if the file does not say."""
    time_unit: str | None = None
    motor: str | None = None
    """"1" or "2" if the headers say which cell is the motor's."""
    files: tuple[str, ...] = ()

    @property
    def cells(self) -> tuple[Floats, Floats]:
        """Both forces."""
        return self.rows["cell_1"].to_numpy(), self.rows["cell_2"].to_numpy()

    def column(self, name: str) -> Floats | None:
        """Numbers of a column; None if there is none."""
        return self.rows[name].to_numpy() if name in self.rows else None

    @property
    def times(self) -> Floats:
        """The time of each row, or its number; refused if it goes back."""
        time = self.column("time")
        if time is None:
            return np.arange(len(self.rows), dtype=np.float64)
        back = np.flatnonzero(np.diff(time) < 0.0)
        if len(back):
            problem = "time goes back in this row, so strokes are not known"
            hint = "give one log per file, its rows in order of time"
            raise InputError(problem, where=self.place(int(back[0]) + 1), hint=hint)
        return time

    def place(self, row: int) -> str:
        """Where a reading stands, as errors say it."""
        source = self.files[self.rows["file"].iloc[row]] if len(self.files) > 1 else self.source
        return f"{source}, line {self.rows['line'].iloc[row]}"

    def codes(self, name: str) -> tuple[list[str], Integers]:
        """The different values of a column of names, and which one each row has."""
        values = self.rows[name].cat
        return list(values.categories), values.codes.to_numpy().astype(np.int64)


def read_readings(
    source: Any,
    *,
    cell_1: str | None = None,
    cell_2: str | None = None,
    position: str | None = None,
) -> Readings:
    """A CSV of settled readings or a raw log, a DataFrame or a mapping of arrays, whose names are what headers are.

    Raises InputError with line and column, UsageError for names of columns that there are not.
    """
    if (cell_1 is None) != (cell_2 is None):
        raise UsageError(
            "one load cell is named and the other is not",
            where="--cell-1, --cell-2",
            hint="name both",
        )
    names = (cell_1, cell_2) if cell_1 is not None and cell_2 is not None else None
    table = read_table(source, names) if isinstance(source, Path) else _of_frame(source, names)
    return _assembled(table, position)


def _of_frame(frame: Any, names: tuple[str, str] | None) -> Table:
    """Columns in memory; rows count from 0, as pandas counts them."""
    where = "the readings"
    try:
        given = pd.DataFrame({str(name): np.asarray(frame[name]) for name in frame})
    except (TypeError, ValueError, LookupError) as error:
        problem = f"{type(frame).__name__} is not a path, a DataFrame or a mapping of arrays of one length"
        raise UsageError(problem, where="fit_friction") from error
    if not 0 < len(given) <= MOST_ROWS:
        raise InputError(f"{len(given):,} readings, expected 1 to {MOST_ROWS:,}", where=where)
    columns = read_header([str(name) for name in given])
    cells = find_cells(columns, names, where)
    if cells is None:
        shown = ", ".join(column.shown for column in columns[:12])
        problem = f"no column is named as the two load cells are: {shown}"
        raise InputError(problem, where=where, hint="name them with cell_1 and cell_2")
    digest, values = hashlib.sha256(), [given[name].to_numpy() for name in given]
    for value in values:
        digest.update(value.tobytes() if value.dtype != object else repr(value.tolist()).encode())
    return Table(where, digest.hexdigest(), columns, cells, np.arange(len(given)), values)


def _assembled(table: Table, position: str | None) -> Readings:
    """The columns that are read, in one unit."""
    first, second = table.cells
    factors = check_units(first, second, table.place)
    rows = {"line": table.lines, "cell_1": table.numbers(first) * factors[0]}
    rows["cell_2"] = table.numbers(second) * factors[1]
    moved = None if position is None else named_column(table.columns, position)
    if moved:
        rows["position"] = table.numbers(moved)
    elif position is not None:
        hint = f"the columns are {', '.join(column.shown for column in table.columns[:12])}"
        raise UsageError(f'there is no column "{shorten(position)}"', where="--position", hint=hint)
    reads = {"time": _times, "bend_angle": _radians, "bend_uncertainty": _radians}
    columns = {role: table.find(role) for role in (*reads, "direction", "stroke")}
    rows |= {
        role: reads.get(role, Table.names)(table, column)
        for role, column in columns.items()
        if column
    }
    ends = [(first.end, "1", "2"), (second.end, "2", "1")]
    return Readings(
        rows=pd.DataFrame(rows, copy=False),
        source=table.source,
        sha256=table.sha256,
        names=(first.header, second.header),
        position_name=moved.header if moved else "",
        position_is_speed=bool(moved and moved.is_speed),
        unit=first.unit if first.unit == second.unit else "N",
        time_unit=columns["time"].unit if columns["time"] else None,
        motor=next((this if end == "motor" else other for end, this, other in ends if end), None),
        files=(table.source,),
    )


def _times(table: Table, column: Heading) -> Floats:
    """Numbers of time, or the order of the rows if they are times of day."""
    order = np.arange(len(table.lines), dtype=np.float64)
    try:
        times = table.numbers(column)
    except InputError:
        return order
    return times if np.all(np.isfinite(times)) else order


def _radians(table: Table, column: Heading) -> Floats:
    """A column of angles."""
    if column.unit not in _ANGLES:
        hint = "call the column bend_angle_deg or bend_angle_rad"
        raise InputError(
            f"{column.shown} has no unit of angle", where=table.place(column), hint=hint
        )
    values = table.numbers(column) * _ANGLES[column.unit]
    bad = np.flatnonzero(~(values >= 0.0))
    if len(bad):
        raise InputError(
            "the bend angle is missing or negative", where=table.place(column, int(bad[0]))
        )
    if column.role == "bend_angle" and not 0.0 < values.max() <= LARGEST_BEND:
        problem = f"bend angles reach {values.max():.4g} rad, expected above 0 and at most 100"
        raise InputError(problem, where=table.place(column))
    return values


def concatenate(parts: list[Readings]) -> Readings:
    """Several files as one, in this order; strokes of different files are different, time goes on after the last."""
    if len(parts) == 1:
        return parts[0]
    first, frames, end = parts[0], [], 0.0
    names = [name for name in ("direction", "stroke") if name in first.rows]
    for number, part in enumerate(parts):
        if part.unit != first.unit:
            problem = f'{part.source} is in "{part.unit}", {first.source} in "{first.unit}"'
            raise InputError(problem, where=part.source, hint="save them in one unit")
        only = set(part.rows) ^ set(first.rows) or (
            {"motor"} if part.motor != first.motor else set()
        )
        if only:
            problem = f"only one of {first.source} and {part.source} says the {min(map(str, only)).replace('_', ' ')}"
            raise InputError(problem, where=part.source, hint="fit files of one kind together")
        frame = part.rows.assign(file=number)
        for name in names:
            frame[name] = (f"{number}:" if name == "stroke" else "") + frame[name].astype(str)
        if "time" in frame:
            time = frame["time"].to_numpy()
            frame["time"] = time - time[0] + end
            end = float(
                frame["time"].iloc[-1] + (np.median(np.diff(time)) if len(time) > 1 else 1.0)
            )
        frames.append(frame)
    return replace(
        first,
        rows=pd.concat(frames, ignore_index=True).astype(dict.fromkeys(names, "category")),
        source=", ".join(part.source for part in parts),
        sha256=hashlib.sha256("".join(part.sha256 for part in parts).encode()).hexdigest(),
        files=tuple(part.source for part in parts),
    )


def check_forces(readings: Readings) -> None:
    """Refuse forces that no two working cells give."""
    cells, source = readings.cells, readings.source
    largest = max(float(np.nanmax(np.abs(cell), initial=0.0)) for cell in cells)
    if largest >= _STRONGEST:
        problem = f"forces reach {largest:.3g}, which no load cell reads"
        raise InputError(problem, where=source, hint="is the unit right?")
    fixed = all(
        np.nanmin(cell, initial=np.inf) == np.nanmax(cell, initial=-np.inf) for cell in cells
    )
    named = len(readings.codes("direction")[0]) if "direction" in readings.rows else 0
    if fixed and (len(readings.rows) >= _MANY or named > 1):
        hint = "are the right columns read, the cells alive?"
        raise InputError("both cells read the same in every row", where=source, hint=hint)
    known = (cells[0] > 0.0) & (cells[1] > 0.0)
    one, two = cells[0][known], cells[1][known]
    if known.any() and np.all(one == np.round(one)) and np.all(two == np.round(two)):
        ratio = float(np.exp(np.median(np.abs(np.log(one / two)))))
        if ratio > _LARGEST_RATIO:
            hint = "a decimal comma read as a separator? separate the columns by semicolons"
            raise InputError(
                f"one cell reads {ratio:.0f} times the other, in whole numbers",
                where=source,
                hint=hint,
            )
