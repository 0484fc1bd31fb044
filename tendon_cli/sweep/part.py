"""One part of a sweep: a range of designs through the model and into its files."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import numpy.typing as npt
import pyarrow as pa

from tendon_cli.errors import Stopped
from tendon_cli.sweep.columns import Tables, state_keys
from tendon_cli.sweep.design_rows import DesignRows, Totals
from tendon_cli.sweep.inputs import Inputs
from tendon_cli.sweep.plan import ROW_GROUP, Block, Plan
from tendon_cli.sweep.rows import blocks_of_rows, state_rows
from tendon_cli.tables.schema import Column
from tendon_cli.tables.write import Filler, TableFile, WrittenFile


class Rows(Protocol):
    """Where the rows of a table go."""

    def fill(self, count: int, write: Filler) -> None:
        """Add rows that are written straight to where they are gathered."""


@dataclass(frozen=True)
class PartResult:
    """A finished part: what was counted, and its files by their names in the run folder."""

    index: int
    totals: Totals
    files: dict[str, WrittenFile] = field(default_factory=dict)


@dataclass(frozen=True)
class PartFailure:
    """A part that could not be made, and why; the others go on."""

    index: int
    error: Exception


def file_name(table: str, index: int, parts: int) -> str:
    """Where a part of a table stands in the run folder: a file of its own, or one in a folder of parts."""
    return f"{table}.parquet" if parts == 1 else f"{table}.parquet/part-{index:05d}.parquet"


def part_index(name: str) -> int:
    """The part that a file of a run folder belongs to."""
    _, found, number = name.rpartition("/part-")
    return int(number.removesuffix(".parquet")) if found else 0


def comes_at_once(table: str) -> bool:
    """Whether the rows of a part must all be held before any is written: designs come tile by tile."""
    return table == "designs"


@dataclass(frozen=True)
class WrittenPart:
    """A part whose files are written, but not yet in place: from here on nothing but the disk is waited for."""

    index: int
    totals: Totals
    files: dict[str, TableFile]
    """By their names in the run folder."""
    stack: ExitStack
    """Leaves nothing behind of a file that is not put in place."""

    def finish(self) -> PartResult:
        """Put the files in place; raises OutputError."""
        with self.stack:
            return PartResult(self.index, self.totals, {name: file.finish() for name, file in self.files.items()})

    def discard(self) -> None:
        """Leave nothing behind."""
        self.stack.close()


@dataclass(frozen=True)
class PartMaker:
    """Computes parts of one plan into a folder; safe to use from several threads."""

    plan: Plan
    folder: Path
    stop: threading.Event = field(default_factory=threading.Event)
    inputs: Inputs = field(init=False)
    tables: Tables = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "inputs", Inputs(self.plan))
        object.__setattr__(self, "tables", Tables(self.inputs))

    def make(self, index: int) -> PartResult:
        """Compute a part and put its files in place; raises OutputError, or Stopped."""
        return self.compute(index).finish()

    def compute(self, index: int) -> WrittenPart:
        """Compute a part into files under temporary names; raises OutputError, or Stopped."""
        designs = self.plan.part(index)
        names = {str(table): file_name(table, index, self.plan.parts) for table in self.plan.study.output.tables}
        with ExitStack() as stack:
            files = {table: stack.enter_context(self._file(table, index, name)) for table, name in names.items()}
            totals = self.fill(files, designs)
            for file in files.values():
                file.close()
            return WrittenPart(index, totals, {names[table]: file for table, file in files.items()}, stack.pop_all())

    def layout(self, table: str, index: int) -> tuple[tuple[Column, ...], pa.Schema]:
        """Columns and schema of a part of a table."""
        return self.tables.designs if table == "designs" else self.tables.states, self.tables.schema(table, index)

    def _file(self, table: str, index: int, name: str) -> TableFile:
        columns, schema = self.layout(table, index)
        rows, at_once = self.plan.rows(table, self.plan.part(index)), comes_at_once(table)
        return TableFile(self.folder / name, columns, schema, row_group=ROW_GROUP, rows=rows, at_once=at_once)

    def fill(self, tables: Mapping[str, Rows], designs: range) -> Totals:
        """Evaluate a range of designs into the tables asked for; raises Stopped."""
        if "states" in tables:
            for block in self.plan.blocks(designs, blocks_of_rows()):
                self._go_on()
                keys = self._leading(block) | state_keys(block, self.plan.elbow_angles)
                tables["states"].fill(math.prod(block.shape), state_rows(self.inputs, block, keys))
        totals = Totals()
        for rectangle in self.plan.rectangles(designs):
            rows = DesignRows(self.inputs, rectangle, self._leading(rectangle), self._go_on)
            if "designs" in tables:
                tables["designs"].fill(rectangle.design_count, rows.write)
            else:
                rows.write({}, range(rectangle.design_count))
            totals += rows.totals
        return totals

    def _leading(self, block: Block) -> dict[str, npt.ArrayLike]:
        return {column.name: values(block) for column, values in self.tables.leading.items()}

    def _go_on(self) -> None:
        if self.stop.is_set():
            raise Stopped


Results = Generator[PartResult | PartFailure]
Runner = Callable[[PartMaker, Iterator[int]], Results]
"""Makes parts, and gives them in whatever order they are finished."""
