"""Parts that are kept in memory, with the same bytes as those on the disk."""

from __future__ import annotations

import io
from dataclasses import dataclass, field
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from tendon_cli.sweep.part import PartMaker, rows_at_once
from tendon_cli.sweep.plan import ROW_GROUP
from tendon_cli.tables.write import RowGroups, TableFile, WrittenFile


class _MemoryFile(TableFile):
    """A table's file that is written into memory."""

    def __init__(self, name: str, groups: RowGroups, file: io.BytesIO, kept: dict[str, bytes]) -> None:
        self.path = Path(name)
        self._groups, self._memory, self._kept, self._name = groups, file, kept, name
        self._file, self._in_place, self._written = file, False, None

    def finish(self) -> WrittenFile:
        written = self.close()
        self._kept[self._name] = self._memory.getvalue()
        self._in_place = True
        return written

    def _give_up(self) -> None:
        self._memory.close()


@dataclass(frozen=True)
class MemoryMaker(PartMaker):
    """Makes parts whose files never reach the disk."""

    files: dict[str, bytes] = field(default_factory=dict, kw_only=True)
    """By their names in a run folder."""

    def tables_read(self) -> dict[str, pa.Table]:
        """The tables, each of all its parts; the files are let go of."""
        tables = {}
        for table in self.plan.study.output.tables:
            names = sorted(name for name in self.files if name.startswith(table))
            tables[str(table)] = pa.concat_tables(
                [pq.read_table(pa.BufferReader(self.files.pop(name))) for name in names]
            )
        return tables

    def _file(self, table: str, index: int, name: str) -> TableFile:
        columns, schema = self.layout(table, index)
        rows, file = self.plan.rows(table, self.plan.part(index)), io.BytesIO()
        groups = RowGroups(file, columns, schema, row_group=ROW_GROUP, rows=rows, at_once=rows_at_once(table))
        return _MemoryFile(name, groups, file, self.files)
