"""Read tables back: nothing that is damaged, incomplete or foreign is ever taken for a result."""

from __future__ import annotations

import contextlib
import json
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.parquet as pq

from tendon_cli.errors import InputError, is_memory_short
from tendon_cli.files import CSV, TABLE, kind_of_file, open_file, read_file
from tendon_cli.tables.footer import facts_in, read_whole
from tendon_cli.verbs.registry import record_names
from tendon_cli.version import RESULTS_VERSION, reader_of

_LONGEST_RECORD = 2**30
"""Largest size of a record that is read, bytes."""
_PARQUET = b"PAR1"
"""First bytes of a file in Parquet."""


class AnyTable(ABC):
    """Rows in the order of their product: on the disk, in memory, or computed when read."""

    files: tuple[Path, ...] = ()
    """Files that a message names if something is wrong."""
    notes: tuple[str, ...] = ()
    """Notes on the file that it was read from."""

    @property
    @abstractmethod
    def schema(self) -> pa.Schema:
        """Columns with units and meaning."""

    @property
    @abstractmethod
    def rows(self) -> int:
        """Number of rows."""

    @abstractmethod
    def parts(
        self, columns: Sequence[str] | None = None, wanted: npt.NDArray[np.int64] | None = None
    ) -> Iterator[tuple[int, pa.Table]]:
        """Yield each part with the number of its first row.

        Args:
            columns: Names of the columns to read, by default all.
            wanted: Numbers of rows; parts without any of them may be left out.
        """

    def stretches(self, columns: Sequence[str], rows: int = 1 << 14) -> Iterator[pa.Table]:
        """Yield some columns, at most `rows` rows at a time, in constant memory."""
        for _, part in self.parts(columns):
            for batch in part.to_batches(rows):
                yield pa.Table.from_batches([batch])

    @cached_property
    def facts(self) -> dict[str, Any]:
        """Facts in the table's metadata: `table`, `study`, `study_hash`, `versions`, `part`."""
        return facts_in(self.schema.metadata or {})

    def read(self, columns: Sequence[str] | None = None) -> pa.Table:
        """Read the whole table, or some of its columns."""
        return pa.concat_tables(part for _, part in self.parts(columns))


@dataclass(frozen=True)
class TableInMemory(AnyTable):
    """A table in memory, read like one on the disk."""

    whole: pa.Table
    notes: tuple[str, ...] = ()
    """Notes on the file that it was read from."""

    @property
    def schema(self) -> pa.Schema:
        """Columns with units and meaning."""
        return self.whole.schema

    @property
    def rows(self) -> int:
        """Number of rows."""
        return int(self.whole.num_rows)

    def parts(
        self,
        columns: Sequence[str] | None = None,
        wanted: npt.NDArray[np.int64] | None = None,  # noqa: ARG002
    ) -> Iterator[tuple[int, pa.Table]]:
        """Yield the table as a single part."""
        yield 0, self.whole.select(list(columns)) if columns else self.whole


@dataclass(frozen=True)
class TableFiles(AnyTable):
    """A table on the disk: one file, or the parts of a folder in the order of the rows.

    `open_table` verifies them.
    """

    files: tuple[Path, ...]

    @cached_property
    def schema(self) -> pa.Schema:
        """Columns with units and meaning."""
        return pq.read_schema(self.files[0])

    @cached_property
    def rows(self) -> int:
        """Number of rows."""
        return sum(self._lengths)

    @cached_property
    def _lengths(self) -> list[int]:
        """Number of rows in each file."""
        return [pq.read_metadata(file).num_rows for file in self.files]

    def parts(
        self, columns: Sequence[str] | None = None, wanted: npt.NDArray[np.int64] | None = None
    ) -> Iterator[tuple[int, pa.Table]]:
        """Yield the table of each file with the number of its first row."""
        names = list(columns) if columns else None
        first = 0
        for file, length in zip(self.files, self._lengths, strict=True):
            stop = first + length
            if wanted is None or ((first <= wanted) & (wanted < stop)).any():
                yield first, _read_part(file, names)
            first = stop

    def stretches(self, columns: Sequence[str], rows: int = 1 << 14) -> Iterator[pa.Table]:
        """Yield some columns, at most `rows` rows at a time, in constant memory."""
        options = {"page_checksum_verification": True, "buffer_size": 1 << 20, "pre_buffer": False}
        for file in self.files:
            with _damage_in(file), pq.ParquetFile(str(file), **options) as parquet:
                for batch in parquet.iter_batches(rows, columns=list(columns), use_threads=False):
                    yield pa.Table.from_batches([batch])


def _read_part(file: Path, columns: list[str] | None) -> pa.Table:
    """Read a file. Raise InputError if it is damaged.

    It starts no thread of Arrow's, under which the process might end; they gained nothing.
    """
    # pq.read_table would import pandas.
    options = {"page_checksum_verification": True, "pre_buffer": False}
    with _damage_in(file), pq.ParquetFile(pa.memory_map(str(file)), **options) as parquet:
        return parquet.read(columns=columns, use_threads=False)


@contextlib.contextmanager
def _damage_in(file: Path) -> Iterator[None]:
    """Raise pyarrow's and the system's errors about a file as InputError."""
    try:
        yield
    except UnicodeDecodeError:
        raise _damaged(file, "a name in it is not text") from None
    except FileNotFoundError:
        raise InputError("no such table", where=str(file)) from None
    except (pa.ArrowException, OSError) as error:
        if is_memory_short(error):
            raise
        if isinstance(error, OSError) and error.strerror:  # of the system, not of Arrow
            raise InputError(f"cannot be read: {error.strerror}", where=str(file)) from None
        raise _damaged(file, str(error).splitlines()[0]) from None


def open_table(path: Path, records: Mapping[str, Any] | None = None) -> TableFiles:
    """Open a table of tendon's with every byte verified.

    Args:
        path: File of the table, or the folder of its parts.
        records: Records in its folder by the names of their files; read by `records_in` if None.

    Raises:
        InputError: The table is damaged or incomplete, is not one of tendon's, or does not belong
            to the run in whose folder it is.
    """
    _check_kind(path)
    files = [path]
    if path.is_dir():
        files = sorted(path.glob("part-*.parquet"), key=_by_number)
    if not files:
        raise InputError("holds no parts of a table", where=str(path))
    table = TableFiles(tuple(files))
    try:
        facts = [_verified_facts(file) for file in files]
        _check_whole(path, files, facts)
        with _damage_in(files[0]):
            of_schema = table.facts
        if any(facts[0].get(name) != value for name, value in of_schema.items()):
            raise _damaged(files[0], "its schema and its footer disagree")
    except (KeyError, TypeError, AttributeError, ValueError):
        raise InputError(
            "does not say what table it is", where=str(path), hint="`tendon sweep` writes it anew"
        ) from None
    _check_run(path, table, records_in(path.parent) if records is None else records)
    return table


def _check_kind(path: Path) -> None:
    """Raise InputError for a file that is no table in Parquet, by its ending or its beginning.

    One that is called a table may be damaged anywhere, and is looked at by who verifies it.
    """
    kind = kind_of_file(path)
    if kind == TABLE or not path.is_file():
        return
    with _damage_in(path), open_file(path) as opened:
        is_parquet = opened.read(len(_PARQUET)) == _PARQUET
    if is_parquet:
        return
    found = "this is not a table in Parquet" if kind is None else f"this is {kind}"
    hint = None
    if kind == CSV:
        hint = "`tendon show` and `tendon export` read a CSV of people"
    elif path.name in record_names():
        hint = f"name its folder: {path.parent}"
    problem = f"{found}, expected a table or the folder of a run"
    raise InputError(problem, where=str(path), hint=hint)


def records_in(folder: Path) -> dict[str, Any]:
    """Read the records of runs in a folder as they are, by the names of their files."""
    records = {}
    for name in record_names():
        with contextlib.suppress(OSError, ValueError, RecursionError):
            records[name] = json.loads(read_file(folder / name, _LONGEST_RECORD))
    return records


def _check_run(path: Path, table: TableFiles, records: Mapping[str, Any]) -> None:
    """Raise InputError if a table in a run's folder is not one of that run."""
    folder = path.parent
    for name, record in records.items():
        try:
            run_version = (record["study_hash"], record["results_version"])
            all_recorded = {str(entry["path"]): entry["size"] for entry in record["files"]}
        except (KeyError, TypeError):
            continue  # not as tendon writes it: readers of the run report that
        check_version(folder, record)
        version = (table.facts["study_hash"], table.facts["results_version"])
        sizes = {str(file.relative_to(folder)): file.stat().st_size for file in table.files}
        recorded = {
            file: size for file, size in all_recorded.items() if file.partition("/")[0] == path.name
        }
        if version != run_version or (recorded and recorded != sizes):
            raise InputError(
                f"does not belong to the run that {name} in its folder describes",
                where=str(path),
                hint="it was copied here, or left by another run; name it where it belongs, "
                "or move it elsewhere",
            )


def check_version(folder: Path, record: Mapping[str, Any]) -> None:
    """Raise InputError if a record is one of another results version.

    Args:
        folder: Folder of the record.
        record: The record.
    """
    version = record.get("results_version")
    if version != RESULTS_VERSION:
        verb = record.get("verb", "sweep")
        reader = reader_of(version)
        raise InputError(
            f"holds results of version {version}, which {reader} reads; this tendon reads "
            f"version {RESULTS_VERSION}",
            where=str(folder),
            hint=f"`tendon {verb} --overwrite` runs the study again",
        )


_OF_ONE_TABLE = ("table", "study_hash", "results_version")
"""Facts that all parts of a table share."""


def _check_whole(path: Path, files: Sequence[Path], facts: list[dict[str, Any]]) -> None:
    """Raise InputError unless all parts of one table of one study are there, in their order."""
    first = facts[0]
    total = first["part"]["of"]
    for file, own in zip(files, facts, strict=True):
        is_other_table = any(own[name] != first[name] for name in _OF_ONE_TABLE)
        if is_other_table or own["part"]["of"] != total:
            raise InputError("belongs to another table than the parts beside it", where=str(file))
    indices = [own["part"]["index"] for own in facts]
    if not path.is_dir() and total > 1:
        raise InputError(
            f"is part {indices[0]} of {total} of a table",
            where=str(path),
            hint="name the folder that holds all parts",
        )
    missing = sorted(set(range(total)) - set(indices))
    if missing:
        raise InputError(
            f"{len(missing)} of {total} parts are missing, the first is part {missing[0]}",
            where=str(path),
        )
    if indices != list(range(total)):
        raise InputError("some parts are there twice or have swapped names", where=str(path))


def _by_number(part: Path) -> tuple[int, str]:
    """Sort key that puts parts in the order of their numbers, whatever their digits."""
    return len(part.name), part.name


def _verified_facts(file: Path) -> dict[str, Any]:
    """Return the facts of a file. Raise InputError unless every byte is as tendon wrote it."""
    with _damage_in(file):
        whole = read_whole(file)
        if whole is not None:
            footer, _sha256 = whole
            return footer.facts
        if not any(key.startswith(b"tendon.") for key in pq.read_schema(file).metadata or {}):
            raise InputError(
                "is not a table written by tendon", where=str(file), hint="run `tendon sweep` first"
            )
    raise _damaged(file, "its bytes are not those that were written")


def _damaged(file: Path, reason: str) -> InputError:
    """Return the error for a damaged table."""
    return InputError(
        f"the table is damaged: {reason}", where=str(file), hint="`tendon sweep` writes it anew"
    )
