"""Writing a table: rows collected into row groups of fixed length, a file that appears only when it is whole."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from io import RawIOBase
from pathlib import Path
from typing import Any, BinaryIO, TypeAlias

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.parquet as pq

from tendon_cli.files import open_file, output_errors, whole_file
from tendon_cli.tables.digest import KEY, PLACEHOLDER, StampedSink
from tendon_cli.tables.schema import Column, TableLayout, array_of

_ROWS_AT_ONCE = 1 << 17
"""Most rows in a page and most that are encoded at once."""

_BYTES_AT_ONCE = 1 << 16
"""That are passed on to Python, which holds its lock for each write: most are of a few bytes, a header's."""

Filler = Callable[[Mapping[str, npt.NDArray[Any]], range], Collection[str] | None]
"""Writes some rows of a block into arrays of that many rows, by column; NaN stands for null.

It says in which columns it wrote NaN, or None where these are to be searched for it.
"""


@dataclass(frozen=True)
class WrittenFile:
    """A table file as it was put in place."""

    rows: int
    size: int
    sha256: str


class RowsInMemory:
    """Rows of a table that never reaches the disk."""

    def __init__(self, layout: TableLayout) -> None:
        self._layout, self._pieces = layout, list[pa.Table]()

    def fill(self, count: int, write: Filler) -> None:
        """Add rows that `write` puts straight to where they are kept."""
        columns = self._layout.columns
        values = {column.name: np.empty(count, column.dtype) for column in columns}
        write(values, range(count))
        arrays = [array_of(column, values[column.name]) for column in columns]
        self._pieces.append(pa.Table.from_arrays(arrays, schema=self._layout.schema))

    def table(self) -> pa.Table:
        """All rows."""
        return pa.concat_tables(self._pieces) if self._pieces else self._layout.schema.empty_table()

    def close(self) -> WrittenFile:
        """What a file of these rows would be."""
        return WrittenFile(self._layout.rows, 0, "")

    def flush(self) -> None:
        """There is no disk."""


class RowGroups:
    """Gathers rows block by block and writes row groups of exactly `layout.row_group` rows, but the last.

    So the bytes depend on the rows only, not on the blocks they came in. Written are row groups as they are full, or
    as many together as `layout.at_once` rows have.
    """

    def __init__(self, file: BinaryIO | RawIOBase, layout: TableLayout) -> None:
        columns, schema = layout.columns, layout.schema
        self._columns, self._schema, self._row_group = columns, schema, layout.row_group
        self._capacity = max(1, min(layout.at_once, layout.rows))
        self._buffers = {column.name: np.empty(self._capacity, column.dtype) for column in columns}
        self._filled = 0
        self._with_nan: set[str] | None = set()
        self.rows = 0
        self._written: WrittenFile | None = None
        self.sink = StampedSink(file)
        self._stream = pa.BufferedOutputStream(pa.PythonFile(self.sink, mode="w"), _BYTES_AT_ONCE)
        self._writer = pq.ParquetWriter(self._stream, schema, **_encoding(columns))

    def fill(self, count: int, write: Filler) -> None:
        """Add rows that `write` puts straight to where they are collected, as many at a time as still fit."""
        start = 0
        while start < count:
            rows = range(start, min(count, start + self._capacity - self._filled))
            until = self._filled + len(rows)
            here = {name: column[self._filled : until] for name, column in self._buffers.items()}
            with_nan = write(here, rows)
            self._with_nan = (
                None
                if with_nan is None or self._with_nan is None
                else self._with_nan.union(with_nan)
            )
            self._filled, start = until, rows.stop
            if self._filled == self._capacity:
                self._write()

    def abandon(self) -> None:
        """Let go of the writer without another byte; else it would write its footer when it is collected."""
        self.sink.discards = True
        with contextlib.suppress(OSError, ValueError, pa.ArrowException):
            self._writer.close()
            self._stream.close()

    def close(self) -> WrittenFile:
        """Write what is left and the footer with the file's digest, once; the rows and what they took are let go of."""
        if self._written is None:
            if self._filled:
                self._write()
            self._stream.flush()
            self.sink.begin_footer()
            self._writer.add_key_value_metadata({KEY: PLACEHOLDER})
            self._writer.close()
            self._stream.close()
            self._buffers = {}
            if self._writer.writer.metadata.num_rows != self.rows:
                raise OSError("the file does not have the rows that were written")
            self._written = WrittenFile(self.rows, self.sink.size, self.sink.stamp())
        return self._written

    def _write(self) -> None:
        known, arrays = self._with_nan, []
        for column in self._columns:
            values = self._buffers[column.name][: self._filled]
            arrays.append(
                array_of(column, values, nulls=None if known is None else column.name in known)
            )
        self._writer.write_table(
            pa.Table.from_arrays(arrays, schema=self._schema), row_group_size=self._row_group
        )
        self.rows += self._filled
        self._filled, self._with_nan = 0, set()


class TableFile(RowGroups):
    """A table's file under a temporary name; raises OutputError where it cannot be written."""

    def __init__(self, path: Path, temporary: Path, file: BinaryIO, layout: TableLayout) -> None:
        super().__init__(file, layout)
        self._path, self._temporary, self._file = path, temporary, file

    def fill(self, count: int, write: Filler) -> None:
        """As any rows."""
        with output_errors(self._path):
            super().fill(count, write)

    def close(self) -> WrittenFile:
        """As any rows."""
        with output_errors(self._path):
            return super().close()

    def flush(self) -> None:
        """Flush what was written to the disk, and check that it has the length that was written and the very footer."""
        written, footer = self.close(), self.sink.footer
        with output_errors(self._path):
            self._file.flush()
            os.fsync(self._file.fileno())
            with open_file(self._temporary) as file:
                is_whole = file.seek(0, os.SEEK_END) == written.size
                file.seek(written.size - len(footer))
                if not is_whole or file.read() != footer:
                    raise OSError("the file on the disk is not what was written")


@contextlib.contextmanager
def table_file(path: Path, layout: TableLayout) -> Iterator[TableFile]:
    """A table's file, put in place at the end, before which it is to be flushed; whatever stops it, nothing is left."""
    with whole_file(path, of_a_run=True) as temporary, ExitStack() as stack:
        with output_errors(path):
            # Exclusive, so that nothing that stands in the way is followed or written through.
            file = stack.enter_context(temporary.open("xb"))
            rows = TableFile(path, temporary, file, layout)
        try:
            yield rows
        except BaseException:
            rows.abandon()
            with contextlib.suppress(OSError):  # again, of what is not written yet
                file.close()
            raise


Rows: TypeAlias = RowsInMemory | RowGroups
"""Where the rows of a table go."""


def _encoding(columns: Sequence[Column]) -> dict[str, object]:
    """How pages are encoded: words as a dictionary, results split into byte streams, counts by their differences.

    Measured on states tables: twice to three times as fast as the library's defaults, and a sixth smaller; pages as
    long as a row group take another fifth off. Numbers that repeat are as small by Zstandard as in a dictionary, which
    looks up each value and takes three times as long. It has trouble with the numbers of designs, whose differences
    take half the time and a twentieth of the room.
    """
    results = [column.name for column in columns if column.kind == "number" and not column.is_axis]
    counts = [column.name for column in columns if column.kind == "count"]
    repeats = counts + [
        column.name for column in columns if column.kind == "number" and column.is_axis
    ]
    return {
        "version": "2.6",
        "compression": {
            column.name: "zstd" if column.name in repeats else "snappy" for column in columns
        },
        "compression_level": dict.fromkeys(repeats, 1),
        "use_dictionary": [column.name for column in columns if column.kind == "text"],
        "column_encoding": dict.fromkeys(results, "BYTE_STREAM_SPLIT")
        | dict.fromkeys(counts, "DELTA_BINARY_PACKED"),
        "write_statistics": [column.name for column in columns if column.is_axis],
        "write_page_checksum": True,
        "max_rows_per_page": _ROWS_AT_ONCE,
        "write_batch_size": _ROWS_AT_ONCE,
    }
