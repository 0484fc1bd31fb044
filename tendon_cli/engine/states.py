"""The table of states of a study whose run did not keep it: worked out when it is read, only what is read of it."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from tendon_cli import kernel
from tendon_cli.engine.blocks import Block
from tendon_cli.engine.columns import Tables
from tendon_cli.engine.plan import Plan
from tendon_cli.studies.load import recorded_study
from tendon_cli.tables.schema import Column, schema_of
from tendon_cli.tables.write import array_of


@dataclass(frozen=True, eq=False)
class StatesOf:
    """All states of a recorded study with all their columns, read as those of a table on the disk are."""

    record: Mapping[str, Any]
    """Of the study, as a run or a table keeps it."""
    study_hash: str
    files: tuple[Path, ...]
    """What is named if something is wrong: the run's folder."""

    @cached_property
    def tables(self) -> Tables:
        """The columns, whatever the study keeps of them."""
        output = {"tables": ["designs", "states"]}
        whole = {**self.record, "study": {**self.record["study"], "output": output}}
        return Tables(Plan(recorded_study(whole)))

    @property
    def plan(self) -> Plan:
        """The study as a product."""
        return self.tables.plan

    @cached_property
    def schema(self) -> pa.Schema:
        """Columns with units and meaning."""
        return schema_of(self.tables.states, self.facts)

    @property
    def facts(self) -> dict[str, Any]:
        """What a table knows of itself."""
        return {"table": "states", "study": self.record, "study_hash": self.study_hash}

    @property
    def rows(self) -> int:
        """Number of states."""
        return self.plan.states

    def read(self, columns: Sequence[str] | None = None) -> pa.Table:
        """The whole table, or some of its columns."""
        return pa.concat_tables(part for _, part in self.parts(columns))

    def stretches(self, columns: Sequence[str], rows: int = 1 << 16) -> Iterator[pa.Table]:
        """Some columns, at most so many rows at a time, in the order of the rows and in constant memory."""
        for block in self.plan.blocks(range(self.plan.designs), rows):
            yield self._rows(block, columns)

    def parts(
        self, columns: Sequence[str] | None = None, wanted: npt.NDArray[np.int64] | None = None
    ) -> Iterator[tuple[int, pa.Table]]:
        """Block by block, each with the number of its first row; with `wanted` only the designs that have such rows."""
        each, names = self.plan.states_per_design, columns or self.schema.names
        for designs in _runs(range(self.plan.designs) if wanted is None else np.unique(wanted // each).tolist()):
            start = designs.start * each
            for block in self.plan.blocks(designs, self.plan.block_states):
                part = self._rows(block, names)
                yield start, part
                start += part.num_rows

    def _rows(self, block: Block, names: Sequence[str]) -> pa.Table:
        columns = {column.name: column for column in self.tables.states}
        keys = {
            column.name: (column, values) for column, values in (self.tables.leading | self.tables.of_states).items()
        }
        given = {name: np.asarray(values(block), dtype=column.dtype) for name, (column, values) in keys.items()}
        write = kernel.row_writer(self.tables.plan.situation(block), block.shape, given)
        count = int(np.prod(block.shape))
        values_of = {name: np.empty(count, columns[name].dtype) for name in names}
        write(values_of, range(count))
        fields = [self.schema.field(name) for name in names]
        arrays = [_array(columns[name], values) for name, values in values_of.items()]
        return pa.Table.from_arrays(arrays, schema=pa.schema(fields, self.schema.metadata))


def _array(column: Column, values: npt.NDArray[Any]) -> pa.Array:
    return array_of(column, values, nulls=column.kind == "number" and bool(np.isnan(values).any()))


def _runs(designs: Iterable[int]) -> Iterator[range]:
    """Designs in ascending order as ranges of consecutive ones."""
    if isinstance(designs, range):
        yield designs
        return
    for _, run in itertools.groupby(enumerate(designs), key=lambda each: each[1] - each[0]):
        members = [design for _, design in run]
        yield range(members[0], members[-1] + 1)
