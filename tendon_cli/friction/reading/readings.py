"""A file of two load cells' readings, as it comes, made into arrays."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import InputError, UsageError
from tendon_cli.friction.reading.dialect import NumberReader, find_separator, is_comment, ragged, split
from tendon_cli.friction.reading.header import CellPair, Heading, check_units, unit_symbol
from tendon_cli.friction.reading.layout import Layout, find_header
from tendon_cli.friction.reading.text import LogFile, numbered_lines, read_source
from tendon_cli.units import shorten

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

LARGEST = 100.0
"""More than fifteen turns, in rad: no sheath on a rig, but a number in degrees taken for radians."""
MOST_ROWS = 1_000_000
_SNIFFED = 100


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
    """As the file has it, where it has numbers; only for showing."""
    timed: bool = False
    """Whether the file has a column of time, which a logger writes."""
    time_unit: str | None = None
    motor: str | None = None
    """"1" or "2" where the headers say which cell is the motor's."""

    def place(self, row: int) -> str:
        """Where a reading stands, as errors say it."""
        return f"{self.source}, line {self.lines[row]}"


def read_readings(path: Path, *, cell_1: str | None = None, cell_2: str | None = None) -> Readings:
    """Read a CSV of settled readings or a raw log; raises InputError with line and column."""
    if (cell_1 is None) != (cell_2 is None):
        raise UsageError("one load cell is named and the other is not", where="--cell-1, --cell-2", hint="name both")
    source = read_source(path)
    lines = ((number, line) for number, line in numbered_lines(source) if not is_comment(line))
    sniffed = list(itertools.islice(lines, _SNIFFED))
    if not sniffed:
        raise InputError("the file has comments only", where=source.name)
    separator = find_separator([line for _, line in sniffed], source)
    rows = ((number, split(line, separator, source.place(number))) for number, line in itertools.chain(sniffed, lines))
    layout = find_header(rows, source, (cell_1, cell_2) if cell_1 is not None and cell_2 is not None else None)
    table = _Table(source, layout, NumberReader(source, separator))
    for number, cells in rows:
        table.add(number, cells)
    return table.finish()


@dataclass
class _Table:
    """The rows below the header, as they are read."""

    source: LogFile
    layout: Layout
    numbers: NumberReader
    lines: list[int] = field(default_factory=list)
    forces: list[tuple[float, float]] = field(default_factory=list)
    labels: list[str] = field(default_factory=list)
    strokes: list[str] = field(default_factory=list)
    angles: list[float] = field(default_factory=list)
    doubts: list[float] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    units: dict[int, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        place = self.source.place(self.layout.line)
        self.time = self.layout.find("time", place)
        self.stroke = self.layout.find("stroke", place)
        self.angle = self.layout.find("bend angle", place)
        self.doubt = self.layout.find("bend angle uncertainty", place)
        self.label = self.layout.find("direction", place) or self.layout.find("case", place)

    def add(self, line: int, cells: list[str]) -> None:
        """Take one line: readings, or the row of units right below the header."""
        if not any(cells):
            return
        while len(cells) > self.layout.width and not cells[-1]:
            cells.pop()
        if len(cells) < self.layout.width and all(not column.role for column in self.layout.columns[len(cells) :]):
            cells += [""] * (self.layout.width - len(cells))  # a column of comments that is often empty
        if len(cells) != self.layout.width:
            raise ragged(self.source, line, len(cells), self.layout.width, self.numbers.separator)
        if not self.lines and not self.units and self._take_units(cells):
            return
        if len(self.lines) >= MOST_ROWS:
            raise InputError(f"more than {MOST_ROWS:,} readings", where=self.source.place(line), hint="thin the log")
        for pair in self.layout.pairs:
            texts = cells[pair.first.index], cells[pair.second.index]
            if len(self.layout.pairs) == 1 or any(texts):
                self._add_reading(line, cells, pair)

    def _add_reading(self, line: int, cells: list[str], pair: CellPair) -> None:
        self.lines.append(line)
        columns = pair.first.index, pair.second.index
        self.forces.append((self._number(cells, line, columns[0]), self._number(cells, line, columns[1])))
        if pair.label is not None:
            self.labels.append(pair.label)
        elif self.label is not None:
            self.labels.append(cells[self.label.index])
        if self.stroke is not None:
            self.strokes.append(cells[self.stroke.index])
        if self.angle is not None:
            self.angles.append(self._angle(cells, line, self.angle.index))
        if self.doubt is not None:
            self.doubts.append(self._angle(cells, line, self.doubt.index))
        if self.time is not None:
            self.times.append(_plain_number(cells[self.time.index]))

    def _number(self, cells: list[str], line: int, column: int) -> float:
        return self.numbers.read(cells[column], line, column)

    def _angle(self, cells: list[str], line: int, column: int) -> float:
        angle = self._number(cells, line, column)
        if not 0.0 <= angle < math.inf:
            raise InputError("the bend angle is missing or negative", where=self.source.place(line, column))
        return angle

    def _take_units(self, cells: list[str]) -> bool:
        """Read the row of units below the header, if this is one."""
        pair_columns = [column for pair in self.layout.pairs for column in (pair.first, pair.second)]
        found = {column.index: unit_symbol(cells[column.index]) for column in pair_columns}
        if not all(found.values()):
            return False
        self.units = {index: unit or "" for index, cell in enumerate(cells) if (unit := unit_symbol(cell))}
        return True

    def _unit(self, column: Heading) -> Heading:
        """The column with the unit that the row of units gives it."""
        below = self.units.get(column.index)
        if below is not None and column.unit not in {None, below}:
            raise InputError(
                f'the header gives "{column.unit}" and the row of units "{below}"',
                where=self.source.place(self.layout.line, column.index),
            )
        return Heading(column.index, column.header, column.role, below or column.unit, column.cell, column.end)

    def finish(self) -> Readings:
        """The arrays, in one unit."""
        if not self.lines:
            raise InputError("there are no readings below the header", where=self.source.place(self.layout.line))
        self.numbers.check_thousands()
        forces = np.array(self.forces, dtype=np.float64)
        pairs = [CellPair(self._unit(pair.first), self._unit(pair.second)) for pair in self.layout.pairs]
        factors = {check_units(pair, self.source, self.layout.line) for pair in pairs}
        if len(factors) > 1 or len({pair.first.unit for pair in pairs}) > 1:
            raise InputError("the cases are in different units", where=self.source.place(self.layout.line))
        forces = forces * np.array(factors.pop())
        first = pairs[0]
        times = np.array(self.times, dtype=np.float64)
        angles = self._radians(self.angle, self.angles)
        if angles is not None and not 0.0 < angles.max() <= LARGEST:
            place = self.source.place(self.layout.line, self.angle.index if self.angle else None)
            raise InputError(f"bend angles reach {angles.max():.4g} rad, expected above 0 and at most 100", where=place)
        return Readings(
            source=self.source.name,
            sha256=self.source.sha256,
            lines=np.array(self.lines, dtype=np.int64),
            cell_1=forces[:, 0],
            cell_2=forces[:, 1],
            names=(first.first.header, first.second.header),
            directions=Labels.of(self.labels) if self.labels else None,
            strokes=Labels.of(self.strokes) if self.strokes else None,
            bend_angle=angles,
            bend_uncertainty=self._radians(self.doubt, self.doubts) if angles is not None else None,
            time=times if len(times) and bool(np.all(np.isfinite(times))) else None,
            timed=self.time is not None,
            unit=first.first.unit if first.first.unit == first.second.unit else "N",
            motor=_motor_of(first),
        )

    def _radians(self, column: Heading | None, values: list[float]) -> Floats | None:
        if column is None:
            return None
        place = self.source.place(self.layout.line, column.index)
        unit = self._unit(column).unit
        if unit not in {"deg", "rad", "mrad"}:
            raise InputError(
                f'"{shorten(column.header)}" has no unit of angle',
                where=place,
                hint="call the column bend_angle_deg or bend_angle_rad",
            )
        return np.array(values) * {"deg": math.pi / 180.0, "rad": 1.0, "mrad": 1e-3}[unit]


def _plain_number(text: str) -> float:
    try:
        return float(text.replace(",", "."))
    except ValueError:
        return math.nan


def _motor_of(pair: CellPair) -> str | None:
    if pair.first.end == "motor" or pair.second.end == "load":
        return "1"
    return "2" if pair.second.end == "motor" or pair.first.end == "load" else None
