"""Tables of a run that is kept in memory."""

from __future__ import annotations

import io
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from tendon_cli.engine.task import PartMaker
from tendon_cli.tables.schema import TableLayout
from tendon_cli.tables.write import RowGroups, TableFile, WrittenFile


@dataclass(frozen=True)
class InMemory(PartMaker):
    """Makes parts whose files never reach the disk."""

    kept: dict[str, bytes] = field(default_factory=dict, kw_only=True)
    """Files by their names."""

    def open(self, layout: TableLayout, name: str) -> TableFile:
        """A file that is kept once it is whole."""
        return _MemoryFile(layout, name, self.kept)

    def read(self, name: str) -> pa.Table:
        """The rows of a file that is kept."""
        return _table(self.kept[name])

    def tables(self) -> dict[str, pa.Table]:
        """The tables, each of all its parts; the files are let go of."""
        files = defaultdict(list)
        for name in sorted(self.kept, key=lambda name: (len(name), name)):
            files[name.partition(".")[0]].append(name)
        return {
            table: pa.concat_tables(_table(self.kept.pop(name)) for name in names) for table, names in files.items()
        }


class _MemoryFile(TableFile):
    """A table's file that is kept in memory once it is whole."""

    def __init__(self, layout: TableLayout, name: str, kept: dict[str, bytes]) -> None:
        self.path, self._name, self._kept, self._written = Path(name), name, kept, None
        self._file = self._bytes = io.BytesIO()
        self._groups = RowGroups(self._file, layout)

    def __exit__(self, *_: object) -> None:
        self._groups.abandon()

    def flush(self) -> None:
        """There is no disk."""

    def place(self) -> WrittenFile:
        """Keep the file under its name."""
        written = self.close()
        self._kept[self._name] = self._bytes.getvalue()
        return written


def _table(content: bytes) -> pa.Table:
    """Not by pq.read_table, which imports pandas."""
    return pq.ParquetFile(pa.BufferReader(content)).read()
