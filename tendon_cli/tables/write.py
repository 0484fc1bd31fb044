"""Write tables: rows collected into row groups of fixed length, in files that appear only whole."""

from __future__ import annotations

import contextlib
import json
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
"""Largest number of rows in a page, and of rows that are encoded at once."""

_BYTES_AT_ONCE = 1 << 16
"""Bytes that are collected before they are passed on to Python, which holds its lock during each
write: most writes are headers of a few bytes."""

Filler = Callable[[Mapping[str, npt.NDArray[Any]], range], Collection[str] | None]
"""Writes some rows of a block into arrays of that many rows, by column; NaN stands for null.

It returns the names of the columns in which it wrote NaN, or None if it does not know them.
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
        self._layout = layout
        self._pieces: list[pa.Table] = []

    def fill(self, count: int, write: Filler) -> None:
        """Add `count` rows that a function writes."""
        columns = self._layout.columns
        values = {column.name: np.empty(count, column.dtype) for column in columns}
        write(values, range(count))
        arrays = [array_of(column, values[column.name]) for column in columns]
        self._pieces.append(pa.Table.from_arrays(arrays, schema=self._layout.schema))

    def table(self) -> pa.Table:
        """Return all rows."""
        return pa.concat_tables(self._pieces) if self._pieces else self._layout.schema.empty_table()

    def close(self, note: Mapping[str, Any] | None = None) -> WrittenFile:  # noqa: ARG002
        """Return the record of a file with these rows, but without size or digest.

        The note is not kept.
        """
        return WrittenFile(self._layout.rows, 0, "")

    def flush(self) -> None:
        """Do nothing: there is no disk."""


class RowGroups:
    """Gathers rows block by block and writes row groups of exactly `layout.row_group` rows.

    Only the last row group may have fewer. So the bytes depend on the rows only, not on the blocks
    they came in. Row groups are written as soon as they are full, or as many together as
    `layout.at_once` rows have.

    Args:
        file: File that takes the bytes.
        layout: Layout of the table.
    """

    def __init__(self, file: BinaryIO | RawIOBase, layout: TableLayout) -> None:
        columns = layout.columns
        self._columns = columns
        self._schema = layout.schema
        self._row_group = layout.row_group
        self._capacity = max(1, min(layout.at_once, layout.rows))
        self._buffers = {column.name: np.empty(self._capacity, column.dtype) for column in columns}
        self._filled = 0
        self._with_nan: set[str] | None = set()
        self.rows = 0
        """Number of rows written."""
        self._written: WrittenFile | None = None
        self.sink = StampedSink(file)
        self._stream = pa.BufferedOutputStream(pa.PythonFile(self.sink, mode="w"), _BYTES_AT_ONCE)
        self._writer = pq.ParquetWriter(self._stream, layout.schema, **_encoding(columns))

    def fill(self, count: int, write: Filler) -> None:
        """Add `count` rows that a function writes, as many at a time as still fit."""
        start = 0
        while start < count:
            rows = range(start, min(count, start + self._capacity - self._filled))
            stop = self._filled + len(rows)
            targets = {name: buffer[self._filled : stop] for name, buffer in self._buffers.items()}
            with_nan = write(targets, rows)
            if with_nan is None or self._with_nan is None:
                self._with_nan = None
            else:
                self._with_nan = self._with_nan.union(with_nan)
            self._filled = stop
            start = rows.stop
            if self._filled == self._capacity:
                self._write()

    def abandon(self) -> None:
        """Close the writer without another byte; else it would write its footer when collected."""
        self.sink.discards = True
        with contextlib.suppress(OSError, ValueError, pa.ArrowException):
            self._writer.close()
            self._stream.close()

    def close(self, note: Mapping[str, Any] | None = None) -> WrittenFile:
        """Write the remaining rows and the footer with the file's digest, once, and free memory.

        Args:
            note: Facts of the part for its footer, which are known when all rows are.
        """
        if self._written is None:
            if self._filled:
                self._write()
            self._stream.flush()
            self.sink.begin_footer()
            self._writer.add_key_value_metadata(_last_facts(note))
            self._writer.close()
            self._stream.close()
            self._buffers = {}
            if self._writer.writer.metadata.num_rows != self.rows:
                raise OSError("the file does not have the rows that were written")
            self._written = WrittenFile(self.rows, self.sink.size, self.sink.stamp())
        return self._written

    def _write(self) -> None:
        """Write the rows that are gathered."""
        arrays = []
        for column in self._columns:
            values = self._buffers[column.name][: self._filled]
            nulls = None if self._with_nan is None else column.name in self._with_nan
            arrays.append(array_of(column, values, nulls=nulls))
        table = pa.Table.from_arrays(arrays, schema=self._schema)
        self._writer.write_table(table, row_group_size=self._row_group)
        self.rows += self._filled
        self._filled = 0
        self._with_nan = set()


class TableFile(RowGroups):
    """A table's file under a temporary name. Raises OutputError if it cannot be written."""

    def __init__(self, path: Path, temporary: Path, file: BinaryIO, layout: TableLayout) -> None:
        super().__init__(file, layout)
        self._path = path
        self._temporary = temporary
        self._file = file

    def fill(self, count: int, write: Filler) -> None:
        """Add `count` rows that a function writes."""
        with output_errors(self._path):
            super().fill(count, write)

    def close(self, note: Mapping[str, Any] | None = None) -> WrittenFile:
        """Write the remaining rows and the footer with the part's note and the digest, once."""
        with output_errors(self._path):
            return super().close(note)

    def flush(self) -> None:
        """Flush the file to the disk and check that its length and footer there are as written."""
        written = self.close()
        footer = self.sink.footer
        with output_errors(self._path):
            self._file.flush()
            os.fsync(self._file.fileno())
            with open_file(self._temporary) as file:
                has_length = file.seek(0, os.SEEK_END) == written.size
                file.seek(written.size - len(footer))
                if not has_length or file.read() != footer:
                    raise OSError("the file on the disk is not what was written")


@contextlib.contextmanager
def table_file(path: Path, layout: TableLayout) -> Iterator[TableFile]:
    """Open a table's file, which is put in place at the end; an error leaves nothing behind.

    The caller flushes it before the end.
    """
    with whole_file(path, of_a_run=True) as temporary, ExitStack() as stack:
        with output_errors(path):
            # Exclusive, so that a link or a file of that name is neither followed nor overwritten.
            file = stack.enter_context(temporary.open("xb"))
            rows = TableFile(path, temporary, file, layout)
        try:
            yield rows
        except BaseException:
            rows.abandon()
            with contextlib.suppress(OSError):  # closing writes what is left, and may fail again
                file.close()
            raise


RowTarget: TypeAlias = RowsInMemory | RowGroups
"""Target of a table's rows."""


def _last_facts(note: Mapping[str, Any] | None) -> dict[str, str]:
    """Return what a footer gets when all rows are written: the note and room for the digest."""
    digest = {KEY: PLACEHOLDER}
    return digest if note is None else {"tendon.note": json.dumps(note, sort_keys=True), **digest}


def _encoding(columns: Sequence[Column]) -> dict[str, object]:
    """Return the encoding of pages, as arguments of `pyarrow.parquet.ParquetWriter`.

    Words are written as a dictionary, results split into byte streams, counts by their differences.
    Measured on states tables: twice to three times as fast as the library's defaults, and a sixth
    smaller; pages as long as a row group take another fifth off. Numbers that repeat are as small
    by Zstandard as in a dictionary, which looks up each value and takes three times as long. It has
    trouble with the numbers of designs, whose differences take half the time and a twentieth of the
    room.
    """
    axes = [column.name for column in columns if column.is_axis]
    words = [column.name for column in columns if column.kind == "text"]
    counts = [column.name for column in columns if column.kind == "count"]
    numbers = [column for column in columns if column.kind == "number"]
    results = [column.name for column in numbers if not column.is_axis]
    repeats = counts + [column.name for column in numbers if column.is_axis]
    return {
        "version": "2.6",
        "compression": {
            column.name: "zstd" if column.name in repeats else "snappy" for column in columns
        },
        "compression_level": dict.fromkeys(repeats, 1),
        "use_dictionary": words,
        "column_encoding": dict.fromkeys(results, "BYTE_STREAM_SPLIT")
        | dict.fromkeys(counts, "DELTA_BINARY_PACKED"),
        "write_statistics": axes,
        "write_page_checksum": True,
        "max_rows_per_page": _ROWS_AT_ONCE,
        "write_batch_size": _ROWS_AT_ONCE,
    }
