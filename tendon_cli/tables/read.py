"""Reading tables back: nothing that is damaged, incomplete or foreign is ever taken for a result."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.parquet as pq

from tendon_cli.errors import InputError, is_memory_short
from tendon_cli.files import read_file
from tendon_cli.tables.digest import is_intact
from tendon_cli.tables.schema import Column

RECORDS = {"sweep": "run.json", "design": "design.json"}
"""By the command that a run is of, the name of its record in the run's folder."""
_LONGEST_RECORD = 2**30


@dataclass(frozen=True)
class TableFiles:
    """A table on the disk: one file, or the parts of a folder, in the order of the rows. All verified."""

    files: tuple[Path, ...]

    @cached_property
    def schema(self) -> pa.Schema:
        """Columns with units and meaning."""
        return pq.read_schema(self.files[0])

    @cached_property
    def facts(self) -> dict[str, Any]:
        """What the table knows of itself: `table`, `study`, `study_hash`, `versions`, `part`."""
        return _facts(self.schema)

    @cached_property
    def rows(self) -> int:
        """Number of rows of all parts."""
        return sum(pq.read_metadata(file).num_rows for file in self.files)

    def read(self, columns: Sequence[str] | None = None) -> pa.Table:
        """The whole table, or some of its columns."""
        return pa.concat_tables(part for _, part in self.parts(columns))

    def parts(self, columns: Sequence[str] | None = None) -> Iterator[tuple[int, pa.Table]]:
        """Part by part, each with the number of its first row."""
        first = 0
        for file in self.files:
            try:
                # Not pq.read_table, which imports pandas.
                with pq.ParquetFile(pa.memory_map(str(file)), page_checksum_verification=True) as whole:
                    part = whole.read(columns=list(columns) if columns else None)
            except (pa.ArrowException, OSError) as error:
                if is_memory_short(error):
                    raise
                raise _damaged(file, str(error).splitlines()[0]) from None
            yield first, part
            first += part.num_rows

    def stretches(self, columns: Sequence[str], rows: int = 1 << 14) -> Iterator[pa.Table]:
        """Some columns, so many rows at a time, in the order of the rows and in constant memory."""
        for file in self.files:
            try:
                how = {"page_checksum_verification": True, "buffer_size": 1 << 20, "pre_buffer": False}
                with pq.ParquetFile(str(file), **how) as whole:
                    for batch in whole.iter_batches(rows, columns=list(columns), use_threads=False):
                        yield pa.Table.from_batches([batch])
            except (pa.ArrowException, OSError) as error:
                if is_memory_short(error):
                    raise
                raise _damaged(file, str(error).splitlines()[0]) from None


def open_table(path: Path) -> TableFiles:
    """A table of ours, from its file or the folder of its parts, every byte verified; raises InputError."""
    files = tuple(sorted(path.glob("part-*.parquet"), key=_by_number)) if path.is_dir() else (path,)
    if not files:
        raise InputError("holds no parts of a table", where=str(path))
    for file in files:
        _verify(file)
    table = TableFiles(files)
    try:
        _check_whole(path, files, [_facts(pq.read_schema(file)) for file in files])
    except (KeyError, TypeError, AttributeError, ValueError):
        raise InputError(
            "does not say what table it is", where=str(path), hint="`tendon sweep` writes it anew"
        ) from None
    _check_place(path, table)
    return table


def _check_place(path: Path, table: TableFiles) -> None:
    """A table that stands in a run's folder is one of that run; raises InputError."""
    for name in RECORDS.values():
        try:
            record = json.loads(read_file(path.parent / name, _LONGEST_RECORD))
            here = (record["study_hash"], record["results_version"])
            sizes = {str(entry["path"]): entry["size"] for entry in record["files"]}
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            continue  # no record, or none as tendon writes it: whoever needs the run complains of that
        standing = {str(file.relative_to(path.parent)): file.stat().st_size for file in table.files}
        listed = {file: size for file, size in sizes.items() if file.partition("/")[0] == path.name}
        of_another = (table.facts["study_hash"], table.facts.get("results_version")) != here
        if of_another or (listed and listed != standing):
            hint = "it was copied here, or left by another run; name it where it belongs, or move it elsewhere"
            raise InputError(f"is not of the run in its folder, which {name} tells of", where=str(path), hint=hint)


def study_hash_of(file: Path) -> str | None:
    """The study that a file is a table of; None where it is no table of ours, or damaged."""
    try:
        return _facts(pq.read_schema(file)).get("study_hash")
    except (pa.ArrowException, OSError, ValueError):
        return None


def _check_whole(path: Path, files: tuple[Path, ...], facts: list[dict[str, Any]]) -> None:
    """All parts are there, in their order, of one table of one study; raises InputError."""
    first = facts[0]
    for file, each in zip(files, facts, strict=True):
        if (
            any(each.get(name) != first.get(name) for name in _OF_ONE_TABLE)
            or each["part"]["of"] != first["part"]["of"]
        ):
            raise InputError("belongs to another table than its neighbours", where=str(file))
    of, indices = first["part"]["of"], [each["part"]["index"] for each in facts]
    if not path.is_dir() and of > 1:
        hint = "name the folder that holds all parts"
        raise InputError(f"is part {indices[0]} of {of} of a table", where=str(path), hint=hint)
    missing = sorted(set(range(of)) - set(indices))
    if missing:
        raise InputError(f"{len(missing)} of {of} parts are missing, the first is part {missing[0]}", where=str(path))
    if indices != list(range(of)):
        raise InputError("parts stand twice or under each other's names", where=str(path))


_OF_ONE_TABLE = ("table", "study_hash", "results_version")


def _by_number(part: Path) -> tuple[int, str]:
    """Parts in the order of their numbers, whatever their digits."""
    return len(part.name), part.name


def _verify(file: Path) -> None:
    try:
        intact = is_intact(file)
        if intact is None:
            metadata = pq.read_schema(file).metadata or {}
            known = any(key.startswith(b"tendon.") for key in metadata)
            if not known:
                raise InputError("is not a table written by tendon", where=str(file), hint="run `tendon sweep` first")
        if not intact:
            raise _damaged(file, "its bytes are not those that were written")
        pq.read_schema(file)
    except FileNotFoundError:
        raise InputError("no such table", where=str(file)) from None
    except UnicodeDecodeError:
        raise _damaged(file, "a name in it is no text") from None
    except (pa.ArrowException, OSError) as error:
        if isinstance(error, OSError) and error.strerror:  # of the system, not of Arrow
            raise InputError(f"cannot be read: {error.strerror}", where=str(file)) from None
        raise _damaged(file, str(error).splitlines()[0]) from None


def _facts(schema: pa.Schema) -> dict[str, Any]:
    metadata = schema.metadata or {}
    prefix = b"tendon."
    return {
        key[len(prefix) :].decode(): json.loads(value)
        for key, value in metadata.items()
        if key.startswith(prefix) and key != b"tendon.digest"
    }


def _damaged(file: Path, reason: str) -> InputError:
    return InputError(f"the table is damaged: {reason}", where=str(file), hint="`tendon sweep` writes it anew")


def arrays_of(columns: Sequence[Column], table: pa.Table) -> dict[str, npt.NDArray[Any]]:
    """Columns as they are written from: NaN for null, text by its place among the column's choices.

    From buffers, because the library's conversions import pandas.
    """
    return {
        column.name: np.concatenate(
            [np.empty(0, column.dtype), *(_array(column, chunk) for chunk in table[column.name].chunks)],
            dtype=column.dtype, casting="unsafe",
        )
        for column in columns
    }  # fmt: skip


def _array(column: Column, chunk: pa.Array) -> npt.NDArray[Any]:
    if column.kind == "text":
        places = np.array([column.choices.index(word) for word in chunk.dictionary.to_pylist()], dtype=np.int64)
        indices: npt.NDArray[Any] = _numbers(chunk.indices, chunk.indices.type.to_pandas_dtype())
        return np.asarray(places[indices])
    if column.kind == "truth":
        _, data = chunk.buffers()
        bits = np.unpackbits(np.frombuffer(data, np.uint8), bitorder="little")
        return np.asarray(bits[chunk.offset : chunk.offset + len(chunk)])
    return _numbers(chunk, np.float64 if column.kind == "number" else np.int64)


def _numbers(chunk: pa.Array, dtype: type[np.generic]) -> npt.NDArray[Any]:
    valid, data = chunk.buffers()
    rows = slice(chunk.offset, chunk.offset + len(chunk))
    values = np.frombuffer(data, dtype)[rows]
    if valid is None or not chunk.null_count:
        return values
    is_valid = np.unpackbits(np.frombuffer(valid, np.uint8), bitorder="little")[rows].astype(np.bool_)
    return np.where(is_valid, values, np.nan)
