"""What the engine carries out: a task, cut into parts, each of which becomes a file of every table."""

from __future__ import annotations

import contextlib
import json
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Self

import pyarrow as pa

from tendon_cli.errors import Stopped
from tendon_cli.files import OF_A_RUN
from tendon_cli.studies.study import Study
from tendon_cli.tables.read import TableFiles
from tendon_cli.tables.schema import Column, TableLayout, schema_of, versions
from tendon_cli.tables.write import Filler, Rows, RowsInMemory, TableFile, WrittenFile, table_file
from tendon_cli.version import RESULTS_VERSION

Note = dict[str, Any]
"""What a part gives besides its tables: counts and the like, as JSON has them."""
LastFile = tuple[str, TableLayout, Filler]
"""A file that follows from the whole record: its name, its layout, and what fills it."""


class Task(ABC):
    """Points of a study's space and a fold over each, in parts whose length follows from the study alone.

    Safe to be worked on from several threads; `stop` is set when whoever asked wants nothing of it any more.
    """

    verb: ClassVar[str]
    """The command that carries it out."""
    stop: threading.Event

    @classmethod
    @abstractmethod
    def of(cls, study: Study, stop: threading.Event | None = None) -> Self:
        """That of a study; raises TendonError."""

    @property
    @abstractmethod
    def study(self) -> Study:
        """What is asked."""

    @property
    @abstractmethod
    def tables(self) -> Mapping[str, int]:
        """Its tables, and of how many parts each is; of none if it is written last, of what all parts gave."""

    @abstractmethod
    def columns(self, table: str) -> tuple[Column, ...]:
        """Columns of a table."""

    @abstractmethod
    def rows(self, table: str, index: int) -> int:
        """Rows of a part of a table."""

    @abstractmethod
    def fill(self, tables: Mapping[str, Rows], index: int) -> Note:
        """Work a part out into those of its tables that are given; raises Stopped."""

    @abstractmethod
    def is_note(self, index: int, note: Any) -> bool:
        """Whether the note of a part is as `fill` gives it."""

    @abstractmethod
    def place(self, index: int) -> str:
        """What a part is of, for whoever reads a message."""

    @property
    @abstractmethod
    def least_bytes(self) -> int:
        """That its tables take on a disk at the very least."""

    @abstractmethod
    def results(self, notes: Sequence[Note]) -> dict[str, Any]:
        """What its record says of the parts, from the notes of all in their order; raises Stopped."""

    def warnings(self, record: Mapping[str, Any]) -> list[str]:  # noqa: ARG002
        """What a reader has to know first."""
        return list(self.study.warnings)

    def last(
        self,
        record: Mapping[str, Any],  # noqa: ARG002
        read: Callable[[str], pa.Table],  # noqa: ARG002
    ) -> Iterator[LastFile]:
        """Files that follow from the whole record; `read` gives parts.

        A part that is written once more is the same however often it is, from its first form or from its last.
        """
        return iter(())

    def check_memory(self) -> None:  # noqa: B027 - a task is of any size, unless it says so
        """Raises SizeError for a task that is too large to be carried out in memory."""

    @property
    def parts(self) -> int:
        """How many parts the work is cut into."""
        return max(self.tables.values())

    @property
    def identity(self) -> dict[str, Any]:
        """What makes two runs the same."""
        study = self.study
        return {
            "verb": self.verb,
            "study_hash": study.hash,
            "results_version": RESULTS_VERSION,
            **study.record,
        }

    def files(self, index: int) -> dict[str, str]:
        """The files of a part in the run folder, by table."""
        return {
            table: file_name(table, index, parts)
            for table, parts in self.tables.items()
            if index < parts
        }

    def layout(self, table: str, index: int, rows: int | None = None) -> TableLayout:
        """The layout of a part of a table; `rows` if it has not the usual number."""
        part = json.dumps({"index": index, "of": max(1, self.tables[table])}, sort_keys=True)
        first = self._schemas[table]
        schema = first.with_metadata({**first.metadata, b"tendon.part": part})
        return TableLayout(
            self.columns(table), schema, self.rows(table, index) if rows is None else rows
        )

    @cached_property
    def _schemas(self) -> dict[str, pa.Schema]:
        """Those of all tables, but for the part; what they say follows from the study and the versions alone."""
        facts = {
            "study": self.study.record,
            "study_hash": self.study.hash,
            "results_version": RESULTS_VERSION,
        }
        facts |= {"versions": versions()}
        return {
            table: schema_of(self.columns(table), {"table": table, **facts})
            for table in self.tables
        }

    def go_on(self) -> None:
        """Raises Stopped if the work shall stop."""
        if self.stop.is_set():
            raise Stopped


def file_name(table: str, index: int, parts: int) -> str:
    """Where a part of a table stands in the run folder: a file, or one in a folder of parts."""
    return f"{table}.parquet" if parts <= 1 else f"{table}.parquet/part-{index:05d}.parquet"


@dataclass(frozen=True)
class PartResult:
    """A finished part: what it notes, and its files by their names in the run folder."""

    index: int
    note: Note = field(default_factory=dict)
    files: dict[str, WrittenFile] = field(default_factory=dict)


@dataclass(frozen=True)
class PartFailure:
    """A part that could not be made, and why; the others go on."""

    index: int
    error: Exception


Results = Generator[PartResult | PartFailure]


@dataclass(frozen=True)
class PartMaker:
    """Makes parts of a task in a folder; safe to use from several threads."""

    task: Task
    folder: Path

    def open(
        self, name: str, layout: TableLayout
    ) -> AbstractContextManager[TableFile | RowsInMemory]:
        """A file of a table, to be filled and flushed; it is put in place at the end."""
        return table_file(self.folder / name, layout)

    def make(
        self, index: int, working: Callable[[Callable[[], Note]], Note] = lambda work: work()
    ) -> PartResult:
        """Work a part out, `working`, then put its files in place; raises OutputError, or Stopped."""
        names, files = self.task.files(index), dict[str, TableFile | RowsInMemory]()
        with ExitStack() as stack:

            def work() -> Note:
                for table, name in names.items():
                    files[table] = stack.enter_context(
                        self.open(name, self.task.layout(table, index))
                    )
                note = self.task.fill(files, index)
                for file in files.values():
                    file.close()
                return note

            note = working(work)
            for file in files.values():
                file.flush()
            self.check()
            return PartResult(
                index, note, {names[table]: file.close() for table, file in files.items()}
            )

    def check(self) -> None:
        """Raises where written files may not be put in place."""

    def write(self, file: LastFile, announce: Callable[[str, WrittenFile], None]) -> WrittenFile:
        """Write a file that follows from the whole record; it is announced before it stands; raises OutputError."""
        name, layout, write = file
        with self.open(name, layout) as opened:
            opened.fill(layout.rows, write)
            announce(name, opened.close())
            opened.flush()
            return opened.close()

    def read(self, name: str) -> pa.Table:
        """The rows of a file that stands in the run folder; raises InputError."""
        return TableFiles((self.folder / name,)).read()

    def tidy(self) -> None:
        """Remove what was begun by whoever was killed; only for who holds the folder."""
        tables = [
            self.folder / f"{table}.parquet"
            for table, parts in self.task.tables.items()
            if parts > 1
        ]
        for home in (self.folder, *tables):
            for left in home.iterdir() if home.is_dir() and not home.is_symlink() else ():
                if OF_A_RUN.fullmatch(left.name):
                    with contextlib.suppress(OSError):
                        left.unlink()


@dataclass(frozen=True)
class InMemory(PartMaker):
    """Makes parts that never reach the disk."""

    kept: dict[str, pa.Table] = field(default_factory=dict, kw_only=True)
    """Parts of tables by the names of their files."""

    @contextlib.contextmanager
    def open(self, name: str, layout: TableLayout) -> Iterator[RowsInMemory]:
        """A part of a table, to be filled and kept."""
        rows = RowsInMemory(layout)
        yield rows
        self.kept[name] = rows.table()

    def read(self, name: str) -> pa.Table:
        """The rows of a part that is kept."""
        return self.kept[name]

    def tables(self) -> dict[str, pa.Table]:
        """The tables, each of all its parts."""
        every = {table: max(1, parts) for table, parts in self.task.tables.items()}
        names = {
            table: [file_name(table, index, parts) for index in range(parts)]
            for table, parts in every.items()
        }
        return {
            table: pa.concat_tables(self.kept.pop(name) for name in each)
            for table, each in names.items()
        }
