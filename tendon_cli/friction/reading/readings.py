"""A file of two load cells' readings, as it comes, made into arrays."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import InputError, UsageError
from tendon_cli.friction.reading.header import (
    Heading,
    check_units,
    find_cells,
    is_speed,
    moves,
    named_column,
    read_column,
)  # fmt: skip
from tendon_cli.friction.reading.table import MOST_ROWS, Table, read_table
from tendon_cli.friction.reading.text import read_source
from tendon_cli.units import shorten

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
_ANGLES = {"deg": math.pi / 180.0, "rad": 1.0, "mrad": 1e-3}

LARGEST = 100.0
"""More than fifteen turns, in rad: no sheath on a rig, but a number in degrees taken for radians."""


@dataclass(frozen=True, eq=False)
class Labels:
    """A column of names: each different one once, and which one each row has."""

    names: tuple[str, ...]
    code: Integers

    @classmethod
    def of(cls, values: Sequence[str]) -> Labels:
        """From the names row by row."""
        names = tuple(dict.fromkeys(values))
        index = {name: number for number, name in enumerate(names)}
        return cls(names, np.fromiter((index[value] for value in values), dtype=np.int64, count=len(values)))


@dataclass(frozen=True, eq=False)
class Readings:
    """One row per reading, in the order of the file; both cells in the same unit."""

    source: str
    """Name of the file."""
    sha256: str
    lines: Integers
    """Line of the file that each reading stands in."""
    cell_1: Floats
    """NaN where the file has no reading."""
    cell_2: Floats
    names: tuple[str, str]
    """Headers of the two cells."""
    directions: Labels | None = None
    """Case or direction of each reading as the file names it."""
    strokes: Labels | None = None
    position: Floats | None = None
    """Of the motor, in any unit; or its speed."""
    position_name: str = ""
    position_is_speed: bool = False
    bend_angle: Floats | None = None
    """rad; None where the file has no such column."""
    bend_uncertainty: Floats | None = None
    """Standard uncertainty of each bend angle, rad; None where the file has no such column."""
    unit: str | None = None
    """Of both cells; None where the file does not say."""
    time: Floats | None = None
    """As the file has it, if it has numbers."""
    time_unit: str | None = None
    motor: str | None = None
    """"1" or "2" where the headers say which cell is the motor's."""

    file: Integers | None = None
    """Which file each reading is of, if there are several."""
    files: tuple[str, ...] = ()

    def place(self, row: int) -> str:
        """Where a reading stands, as errors say it."""
        source = self.source if self.file is None else self.files[int(self.file[row])]
        return f"{source}, line {self.lines[row]}"


def read_readings(
    path: Path, *, cell_1: str | None = None, cell_2: str | None = None, position: str | None = None
) -> Readings:
    """Read a CSV of settled readings or a raw log; raises InputError with line and column."""
    names = _both(cell_1, cell_2)
    source = read_source(path)
    table = read_table(source, names)
    return _assembled(table, source.name, source.sha256, position)


def frame_readings(
    frame: Any, *, cell_1: str | None = None, cell_2: str | None = None, position: str | None = None
) -> Readings:
    """Readings of a DataFrame, or of a mapping of names to arrays, whose names are what headers are in a file."""
    names = _both(cell_1, cell_2)
    if not isinstance(frame, Mapping) and not hasattr(frame, "columns"):
        problem = f"readings are a path, a DataFrame or a mapping of arrays, not {type(frame).__name__}"
        raise UsageError(problem, where="fit_friction")
    headers = [str(name) for name in (frame.columns if hasattr(frame, "columns") else frame)]
    values = [np.asarray(frame[name]) for name in (frame.columns if hasattr(frame, "columns") else frame)]
    if len({value.shape for value in values}) != 1 or values[0].ndim != 1 or not 0 < len(values[0]) <= MOST_ROWS:
        raise InputError(f"the columns are not of one length from 1 to {MOST_ROWS:,}", where="the readings")
    columns = [read_column(index, header) for index, header in enumerate(headers)]
    found = (
        (named_column(columns, names[0]), named_column(columns, names[1]))
        if names
        else find_cells(columns, "the readings")
    )
    if found is None or found[0] is None or found[1] is None:
        shown = ", ".join(f'"{shorten(header, 30)}"' for header in headers[:12])
        problem = f"no column is named as the two load cells are: {shown}"
        raise InputError(problem, where="the readings", hint="name them with cell_1 and cell_2")
    digest = hashlib.sha256()
    for value in values:
        digest.update(value.tobytes() if value.dtype != object else repr(value.tolist()).encode())
    table = _Frame(columns, (found[0], found[1]), values)
    return _assembled(table, "the readings", digest.hexdigest(), position)


def _both(cell_1: str | None, cell_2: str | None) -> tuple[str, str] | None:
    if (cell_1 is None) != (cell_2 is None):
        raise UsageError("one load cell is named and the other is not", where="--cell-1, --cell-2", hint="name both")
    return (cell_1, cell_2) if cell_1 is not None and cell_2 is not None else None


@dataclass
class _Frame:
    """Columns in memory, as a table of a file gives them."""

    columns: list[Heading]
    cells: tuple[Heading, Heading]
    values: list[npt.NDArray[Any]]

    @property
    def lines(self) -> Integers:
        """Rows from 0, as pandas counts them."""
        return np.arange(len(self.values[0]))

    def place(self, column: Heading) -> str:
        """A column."""
        return f'column "{shorten(column.header, 30)}"'

    def find(self, role: str) -> Heading | None:
        """The first column of a role."""
        return next((column for column in self.columns if column.role == role), None)

    def names(self, column: Heading) -> tuple[tuple[str, ...], Integers]:
        """The different values as texts, and which one each row has."""
        texts = [str(value) for value in self.values[column.index].tolist()]
        labels = Labels.of(texts)
        return labels.names, labels.code

    def numbers(self, column: Heading) -> Floats:
        """The numbers of a column."""
        try:
            values = np.asarray(self.values[column.index], dtype=np.float64)
        except (TypeError, ValueError):
            raise InputError("is not a column of numbers", where=self.place(column)) from None
        if np.isinf(values).any():
            raise InputError("has an infinite number", where=self.place(column))
        return values


def _assembled(table: Table | _Frame, name: str, sha256: str, position: str | None) -> Readings:
    """The arrays, in one unit."""
    first, second = table.cells
    factors = check_units(first, second, table.place)
    label, stroke = table.find("direction") or table.find("case"), table.find("stroke")
    moved = _motion(table, position)
    angles = _radians(table, "bend angle")
    if angles is not None and not 0.0 < angles.max() <= LARGEST:
        angle = table.find("bend angle")
        place = table.place(angle) if angle else name
        raise InputError(f"bend angles reach {angles.max():.4g} rad, expected above 0 and at most 100", where=place)
    time = table.find("time")
    return Readings(
        source=name,
        sha256=sha256,
        lines=table.lines,
        cell_1=table.numbers(first) * factors[0],
        cell_2=table.numbers(second) * factors[1],
        names=(first.header, second.header),
        directions=Labels(*table.names(label)) if label else None,
        strokes=Labels(*table.names(stroke)) if stroke else None,
        position=table.numbers(moved) if moved else None,
        position_name=moved.header if moved else next((c.header for c in table.columns if moves(c)), ""),
        position_is_speed=bool(moved and is_speed(moved)),
        bend_angle=angles,
        bend_uncertainty=_radians(table, "bend angle uncertainty") if angles is not None else None,
        unit=first.unit if first.unit == second.unit else "N",
        time=_times(table, time),
        time_unit=time.unit if time else None,
        motor="1"
        if first.end == "motor" or second.end == "load"
        else "2"
        if second.end == "motor" or first.end == "load"
        else None,
    )


def _motor(first: Heading, second: Heading) -> str | None:
    """Cell "1" or "2" if the headers say which cell is the motor's."""
    if first.end == "motor" or second.end == "load":
        return "1"
    return "2" if second.end == "motor" or first.end == "load" else None


def _motion(table: Table | _Frame, position: str | None) -> Heading | None:
    """The column that the option names."""
    if position is None:
        return None
    found = named_column(table.columns, position)
    if found is None:
        shown = ", ".join(f'"{shorten(column.header, 30)}"' for column in table.columns[:12])
        raise UsageError(
            f'there is no column "{shorten(position)}"', where="--position", hint=f"the columns are {shown}"
        )
    return found


def _times(table: Table | _Frame, column: Heading | None) -> Floats | None:
    """Numbers of time, or their order if they are no numbers."""
    if column is None:
        return None
    try:
        times = table.numbers(column)
    except InputError:  # times of day: rows are in order
        return np.arange(len(table.lines), dtype=np.float64)
    return times if np.all(np.isfinite(times)) else np.arange(len(table.lines), dtype=np.float64)


def _radians(table: Table | _Frame, role: str) -> Floats | None:
    column = table.find(role)
    if column is None:
        return None
    if column.unit not in _ANGLES:
        raise InputError(
            f'"{shorten(column.header)}" has no unit of angle',
            where=table.place(column),
            hint="call the column bend_angle_deg or bend_angle_rad",
        )
    values = table.numbers(column)
    bad = np.flatnonzero(~(values >= 0.0))
    if len(bad):
        where = table.place(column)
        if isinstance(table, Table):
            where = table.source.place(int(table.lines[bad[0]]), column.index)
        raise InputError("the bend angle is missing or negative", where=where)
    return values * _ANGLES[column.unit]


def joined(parts: list[Readings]) -> Readings:
    """Several files as one, in this order; each file's strokes are its own."""
    if len(parts) == 1:
        return parts[0]
    first = parts[0]
    for other in parts[1:]:
        if other.unit != first.unit:
            problem = f'{other.source} is in "{other.unit}", {first.source} in "{first.unit}"'
            raise InputError(problem, where=other.source, hint="save them in one unit")
        for what in ("directions", "strokes", "position", "bend_angle", "bend_uncertainty", "time", "motor"):
            if (getattr(other, what) is None) != (getattr(first, what) is None):
                problem = f"only one of {first.source} and {other.source} says the {what.replace('_', ' ')}"
                raise InputError(problem, where=other.source, hint="fit files of one kind together")

    def column(name: str) -> Any:
        return None if getattr(first, name) is None else np.concatenate([getattr(part, name) for part in parts])

    def labels(name: str, *, apart: bool = False) -> Labels | None:
        if getattr(first, name) is None:
            return None
        given = [(number if apart else 0, getattr(part, name)) for number, part in enumerate(parts)]
        return Labels.of([f"{number}:{each.names[code]}" if apart else each.names[code]
                          for number, each in given for code in each.code])  # fmt: skip

    times, shift = [], 0.0
    for part in parts if first.time is not None else ():
        time = part.time if part.time is not None else np.zeros(0)
        times.append(time - time[0] + shift)
        shift = float(times[-1][-1] + (np.median(np.diff(time)) if len(time) > 1 else 1.0))
    return replace(
        first,
        source=", ".join(part.source for part in parts),
        sha256=hashlib.sha256("".join(part.sha256 for part in parts).encode()).hexdigest(),
        lines=column("lines"), cell_1=column("cell_1"), cell_2=column("cell_2"), directions=labels("directions"),
        strokes=labels("strokes", apart=True), position=column("position"), bend_angle=column("bend_angle"),
        bend_uncertainty=column("bend_uncertainty"), time=np.concatenate(times) if times else None,
        file=np.repeat(np.arange(len(parts)), [len(part.lines) for part in parts]),
        files=tuple(part.source for part in parts),
    )  # fmt: skip
