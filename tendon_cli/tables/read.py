"""Reading tables back: nothing that is damaged, incomplete or foreign is ever taken for a result."""

from __future__ import annotations

import contextlib
import json
from abc import ABC, abstractmethod
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

RECORDS = {"sweep": "run.json", "design": "design.json"}
"""By the command that a run is of, the name of its record in the run's folder."""
_LONGEST_RECORD = 2**30


class AnyTable(ABC):
    """Rows in the order of their product: on the disk, in memory, or worked out when they are read."""

    files: tuple[Path, ...] = ()
    """What is named if something is wrong."""

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
        """Part by part, each with the number of its first row; with `wanted` only those that have such rows."""

    def stretches(self, columns: Sequence[str], rows: int = 1 << 14) -> Iterator[pa.Table]:
        """Some columns, at most so many rows at a time, in constant memory."""
        for _, part in self.parts(columns):
            for batch in part.to_batches(rows):
                yield pa.Table.from_batches([batch])

    @cached_property
    def facts(self) -> dict[str, Any]:
        """What the table knows of itself: `table`, `study`, `study_hash`, `versions`, `part`."""
        return _facts(self.schema)

    def read(self, columns: Sequence[str] | None = None) -> pa.Table:
        """The whole table, or some of its columns."""
        return pa.concat_tables(part for _, part in self.parts(columns))


@dataclass(frozen=True)
class TableInMemory(AnyTable):
    """A table in memory, read as those on the disk are."""

    whole: pa.Table

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
        """As of any table."""
        yield 0, self.whole.select(list(columns)) if columns else self.whole


@dataclass(frozen=True)
class TableFiles(AnyTable):
    """A table on the disk: one file, or the parts of a folder, in the order of the rows. All verified."""

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
        return [pq.read_metadata(file).num_rows for file in self.files]

    def parts(
        self, columns: Sequence[str] | None = None, wanted: npt.NDArray[np.int64] | None = None
    ) -> Iterator[tuple[int, pa.Table]]:
        """As of any table."""
        first = 0
        for file, length in zip(self.files, self._lengths, strict=True):
            if wanted is None or ((first <= wanted) & (wanted < first + length)).any():
                # Not pq.read_table, which imports pandas.
                with (
                    _damage_in(file),
                    pq.ParquetFile(
                        pa.memory_map(str(file)), page_checksum_verification=True
                    ) as all_,
                ):
                    part = all_.read(columns=list(columns) if columns else None)
                yield first, part
            first += length

    def stretches(self, columns: Sequence[str], rows: int = 1 << 14) -> Iterator[pa.Table]:
        """As of any table."""
        how = {"page_checksum_verification": True, "buffer_size": 1 << 20, "pre_buffer": False}
        for file in self.files:
            with _damage_in(file), pq.ParquetFile(str(file), **how) as whole:
                for batch in whole.iter_batches(rows, columns=list(columns), use_threads=False):
                    yield pa.Table.from_batches([batch])


@contextlib.contextmanager
def _damage_in(file: Path) -> Iterator[None]:
    """What the library says of a damaged file as an InputError."""
    try:
        yield
    except UnicodeDecodeError:
        raise _damaged(file, "a name in it is no text") from None
    except FileNotFoundError:
        raise InputError("no such table", where=str(file)) from None
    except (pa.ArrowException, OSError) as error:
        if is_memory_short(error):
            raise
        if isinstance(error, OSError) and error.strerror:  # of the system, not of Arrow
            raise InputError(f"cannot be read: {error.strerror}", where=str(file)) from None
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
            raise InputError(
                f"does not belong to the run that {name} in its folder describes",
                where=str(path),
                hint=hint,
            )


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
        raise InputError(
            f"{len(missing)} of {of} parts are missing, the first is part {missing[0]}",
            where=str(path),
        )
    if indices != list(range(of)):
        raise InputError("parts stand twice or under each other's names", where=str(path))


_OF_ONE_TABLE = ("table", "study_hash", "results_version")


def _by_number(part: Path) -> tuple[int, str]:
    """Parts in the order of their numbers, whatever their digits."""
    return len(part.name), part.name


def _verify(file: Path) -> None:
    with _damage_in(file):
        intact = is_intact(file)
        metadata = (pq.read_schema(file).metadata or {}) if intact is not False else {}
        if intact is None and not any(key.startswith(b"tendon.") for key in metadata):
            raise InputError(
                "is not a table written by tendon", where=str(file), hint="run `tendon sweep` first"
            )
        if not intact:
            raise _damaged(file, "its bytes are not those that were written")


def _facts(schema: pa.Schema) -> dict[str, Any]:
    metadata = schema.metadata or {}
    prefix = b"tendon."
    return {
        key[len(prefix) :].decode(): json.loads(value)
        for key, value in metadata.items()
        if key.startswith(prefix) and key != b"tendon.digest"
    }


def _damaged(file: Path, reason: str) -> InputError:
    return InputError(
        f"the table is damaged: {reason}", where=str(file), hint="`tendon sweep` writes it anew"
    )
