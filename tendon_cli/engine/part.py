"""One part of a sweep: a range of designs through the model and into its files."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from io import BytesIO, RawIOBase
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from tendon_cli import kernel
from tendon_cli.engine.columns import Tables
from tendon_cli.engine.design_rows import DesignRows, Totals
from tendon_cli.engine.plan import DESIGNS_AT_ONCE, ROW_GROUP, Block, Plan
from tendon_cli.engine.suits import noted
from tendon_cli.engine.windows import PlanWindows
from tendon_cli.errors import Stopped
from tendon_cli.tables.schema import Column
from tendon_cli.tables.write import Filler, RowGroups, TableFile, WrittenFile

_BLOCKS_AT_ONCE = 8
"""Blocks of a plan that compiled code best takes at once, together a part; the rows do not depend on it."""


class RowSink(Protocol):
    """Where the rows of a table go."""

    def fill(self, count: int, write: Filler) -> None:
        """Add rows that are written straight to where they are gathered."""


@dataclass(frozen=True)
class PartResult:
    """A finished part: what was counted, and its files by their names in the run folder."""

    index: int
    totals: Totals
    files: dict[str, WrittenFile] = field(default_factory=dict)
    suits: str = ""
    """Which suits have only feasible designs in it, as `suits.noted` says."""


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


def state_rows(plan: Plan, block: Block, keys: Mapping[str, npt.NDArray[Any]]) -> Filler:
    """What writes the rows of a block's states; `keys` are the columns that say which design and state a row is."""
    return kernel.row_writer(plan.situation(block), block.shape, keys)


@dataclass(frozen=True)
class WrittenPart:
    """A part whose files are written, but not yet in place: from here on nothing but the disk is waited for."""

    index: int
    totals: Totals
    suits: str
    files: dict[str, TableFile]
    """By their names in the run folder."""
    stack: ExitStack
    """Leaves nothing behind of a file that is not put in place."""

    def finish(self) -> PartResult:
        """Put the files in place; raises OutputError."""
        with self.stack:
            files = {name: file.finish() for name, file in self.files.items()}
            return PartResult(self.index, self.totals, files, self.suits)

    def discard(self) -> None:
        """Leave nothing behind."""
        self.stack.close()


@dataclass(frozen=True)
class PartMaker:
    """Computes parts of one plan into a folder; safe to use from several threads."""

    plan: Plan
    folder: Path
    stop: threading.Event = field(default_factory=threading.Event)
    tables: Tables = field(init=False)
    windows: PlanWindows = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "tables", Tables(self.plan))
        object.__setattr__(self, "windows", PlanWindows(self.plan))

    def make(self, index: int) -> PartResult:
        """Compute a part and put its files in place; raises OutputError, or Stopped."""
        return self.compute(index).finish()

    def compute(self, index: int) -> WrittenPart:
        """Compute a part into files under temporary names; raises OutputError, or Stopped."""
        designs = self.plan.part(index)
        names = {str(table): file_name(table, index, self.plan.parts) for table in self.plan.study.output.tables}
        with ExitStack() as stack:
            files = {table: stack.enter_context(self._file(table, index, name)) for table, name in names.items()}
            totals, note = self.fill(files, designs)
            for file in files.values():
                file.close()
            return WrittenPart(
                index, totals, note, {names[table]: file for table, file in files.items()}, stack.pop_all()
            )

    def layout(self, table: str, index: int) -> tuple[tuple[Column, ...], pa.Schema]:
        """Columns and schema of a part of a table."""
        return self.tables.designs if table == "designs" else self.tables.states, self.tables.schema(table, index)

    def groups(self, table: str, index: int, file: BytesIO | RawIOBase, designs: int) -> RowGroups:
        """What gathers the rows of so many designs of a table, and writes them into a file."""
        columns, schema = self.layout(table, index)
        return RowGroups(file, columns, schema, **self._lengths(table, designs))

    def _file(self, table: str, index: int, name: str) -> TableFile:
        columns, schema = self.layout(table, index)
        return TableFile(self.folder / name, columns, schema, **self._lengths(table, len(self.plan.part(index))))

    def _lengths(self, table: str, designs: int) -> dict[str, int]:
        """How many rows there are of so many designs, and how many are gathered before they are written."""
        at_once = DESIGNS_AT_ONCE if table == "designs" else ROW_GROUP
        return {"row_group": ROW_GROUP, "rows": self.plan.rows(table, range(designs)), "at_once": at_once}

    def fill(self, tables: Mapping[str, RowSink], designs: range) -> tuple[Totals, str]:
        """Evaluate a range of designs into the tables asked for; returns the note of its suits, too. Raises Stopped."""
        states = self.plan.block_states * (_BLOCKS_AT_ONCE if kernel.kind() else 1)
        for block in self.plan.blocks(designs, states) if "states" in tables else ():
            self._go_on()
            tables["states"].fill(math.prod(block.shape), state_rows(self.plan, block, self._keys("states", block)))
        totals, judged = Totals(), []
        for block in self.plan.blocks_of_designs(designs):
            rows = DesignRows(self.windows, block, self._keys("designs", block), self._go_on)
            if "designs" in tables:
                tables["designs"].fill(block.design_count, rows.write)
            else:
                rows.write({}, range(block.design_count))
            totals += rows.totals
            judged.append((block, rows.feasible))
        return totals, noted(self.plan, judged)

    def _keys(self, table: str, block: Block) -> dict[str, npt.NDArray[Any]]:
        """The columns that say which design, or which state, a row of a block is."""
        keys = self.tables.leading | (self.tables.of_states if table == "states" else {})
        return {column.name: np.asarray(values(block), dtype=column.dtype) for column, values in keys.items()}

    def _go_on(self) -> None:
        if self.stop.is_set():
            raise Stopped


Results = Generator[PartResult | PartFailure]
Runner = Callable[[PartMaker, Iterator[int]], Results]
"""Makes parts, and gives them in whatever order they are finished."""
