"""One part of a sweep: a range of designs through the model and into its files."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from tendon_cli.sweep.columns import Tables, state_keys
from tendon_cli.sweep.evaluate import Columns, Evaluated, design_columns, evaluate, extremes, merge, state_columns
from tendon_cli.sweep.inputs import Inputs
from tendon_cli.sweep.plan import ROW_GROUP, Block, Plan
from tendon_cli.tables.schema import Column
from tendon_cli.tables.write import TableFile, WrittenFile


class Rows(Protocol):
    """Where the rows of a table go."""

    def append(self, columns: Mapping[str, npt.ArrayLike], shape: tuple[int, ...]) -> None:
        """Add the rows of a block."""


class Stopped(Exception):  # noqa: N818 - not a fault: somebody asked for it
    """The sweep was asked to stop while a part was being computed; the part leaves nothing behind."""


@dataclass(frozen=True)
class Totals:
    """What the designs of a part, or of a whole run, come to."""

    feasible: int = 0
    """Designs whose every state is taut."""
    slack: int = 0
    """States with a slack tendon."""
    no_equilibrium: int = 0
    """States in which the flexor cannot balance anything."""
    unstable: int = 0
    """States with negative elbow stiffness."""

    def __add__(self, other: Totals) -> Totals:
        return Totals(
            self.feasible + other.feasible,
            self.slack + other.slack,
            self.no_equilibrium + other.no_equilibrium,
            self.unstable + other.unstable,
        )


@dataclass(frozen=True)
class PartResult:
    """A finished part: what was counted, and its files by their names in the run folder."""

    index: int
    totals: Totals
    files: dict[str, WrittenFile] = field(default_factory=dict)


def file_name(table: str, index: int, parts: int) -> str:
    """Where a part of a table stands in the run folder: a file of its own, or one in a folder of parts."""
    return f"{table}.parquet" if parts == 1 else f"{table}.parquet/part-{index:05d}.parquet"


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
        designs = self.plan.part(index)
        names = {str(table): file_name(table, index, self.plan.parts) for table in self.plan.study.output.tables}
        with ExitStack() as stack:
            files = {table: stack.enter_context(self._file(table, index, name)) for table, name in names.items()}
            totals = self.fill(files, designs)
            return PartResult(index, totals, {names[table]: file.finish() for table, file in files.items()})

    def layout(self, table: str, index: int) -> tuple[tuple[Column, ...], pa.Schema]:
        """Columns and schema of a part of a table."""
        return self.tables.designs if table == "designs" else self.tables.states, self.tables.schema(table, index)

    def _file(self, table: str, index: int, name: str) -> TableFile:
        columns, schema = self.layout(table, index)
        rows = self.plan.rows(table, self.plan.part(index))
        return TableFile(self.folder / name, columns, schema, row_group=ROW_GROUP, rows=rows)

    def fill(self, tables: Mapping[str, Rows], designs: range) -> Totals:
        """Evaluate a range of designs block by block into the tables asked for; raises Stopped."""
        totals, found = Totals(), None
        for block in self.plan.blocks(designs):
            if self.stop.is_set():
                raise Stopped
            evaluated = evaluate(self.inputs, block)
            if "states" in tables:
                tables["states"].append(self._state_rows(block, evaluated), block.shape)
            here = extremes(evaluated)
            found = here if found is None else merge(found, here)
            if self.plan.completes_designs(block):
                rows, found = self._design_rows(block, found), None
                totals += _totals(rows, block.shape[:-2])
                if "designs" in tables:
                    tables["designs"].append(rows, (*block.shape[:-2], 1, 1))
        return totals

    def _leading(self, block: Block) -> dict[str, npt.ArrayLike]:
        return {column.name: values(block) for column, values in self.tables.leading.items()}

    def _state_rows(self, block: Block, evaluated: Evaluated) -> dict[str, npt.ArrayLike]:
        keys = state_keys(block, self.plan.elbow_angles)
        return self._leading(block) | keys | {"status": evaluated.state.status} | state_columns(evaluated)

    def _design_rows(self, block: Block, found: Columns) -> dict[str, npt.ArrayLike]:
        differs = "tendon.pretension" in self.inputs.overridden
        pretension = None if differs else self.inputs.source("tendon.pretension").within(block)
        counts = {name: found[name] for name in ("slack", "no_equilibrium", "unstable")}
        return self._leading(block) | counts | design_columns(found, self.plan.states_per_design, pretension)


def _totals(rows: dict[str, npt.ArrayLike], shape: tuple[int, ...]) -> Totals:
    """Counts over designs of the given shape, from columns that broadcast to it."""

    def total(name: str) -> int:
        return int(np.broadcast_to(rows[name], (*shape, 1, 1)).sum())

    return Totals(total("feasible"), total("slack"), total("no_equilibrium"), total("unstable"))
