"""The unit of work of the engine: a task, cut into parts, each of which becomes files of tables."""

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
from typing import Any, ClassVar, Self, TypeAlias

import pyarrow as pa

from tendon_cli.errors import Stopped
from tendon_cli.files import OF_A_RUN
from tendon_cli.studies.study import Study
from tendon_cli.tables.footer import Origin
from tendon_cli.tables.read import TableFiles
from tendon_cli.tables.schema import Column, TableLayout, schema_of, versions
from tendon_cli.tables.write import (
    Filler,
    RowsInMemory,
    RowTarget,
    TableFile,
    WrittenFile,
    table_file,
)
from tendon_cli.verbs.registry import UNFINISHED, TaskKind
from tendon_cli.version import RESULTS_VERSION

_BYTES_PER_VALUE = 8
"""Size of a value in memory, bytes."""
Note: TypeAlias = dict[str, Any]
"""Counts and other facts of a part besides its rows, as JSON, kept in the footers of its files."""
FinalFile: TypeAlias = tuple[str, TableLayout, Filler]
"""A file that follows from the whole record: its name, its layout, and its filler."""
Compute: TypeAlias = Callable[[Callable[[], Note]], Note]
"""Calls the function that computes a part, here or in another thread, and returns its note."""


class Task(ABC):
    """Work of a command on a study, cut into parts that are computed independently.

    Each part is a function of the study alone, as are the lengths of the parts and the names of all
    files; each file is written once. The table `completed` is written when the whole is known;
    until then its parts stand in the table UNFINISHED. Several threads may work on a task at once.
    `stop` is set when its results are not wanted any more.
    """

    kind: ClassVar[TaskKind]
    """Kind of the task: its verb, its record, its tables, and who reads its results."""
    completed: ClassVar[str] = ""
    """Table to which only the whole adds something; empty if there is none."""
    stop: threading.Event

    @classmethod
    @abstractmethod
    def of(cls, study: Study, stop: threading.Event | None = None) -> Self:
        """Return the task of a study; raises TendonError."""

    @property
    @abstractmethod
    def study(self) -> Study:
        """The study that the task is of."""

    @property
    @abstractmethod
    def tables(self) -> Mapping[str, int]:
        """Tables and the number of files of each."""

    @property
    def last_tables(self) -> tuple[str, ...]:
        """Tables that follow from the whole record, `completed` among them."""
        return ()

    @abstractmethod
    def columns(self, table: str) -> tuple[Column, ...]:
        """Return the columns of a table."""

    @abstractmethod
    def rows(self, table: str, index: int) -> int:
        """Return the number of rows in a part of a table."""

    @abstractmethod
    def fill(self, tables: Mapping[str, RowTarget], index: int) -> Note:
        """Compute a part, write its rows into the given tables, return its note; raises Stopped."""

    @abstractmethod
    def is_note(self, index: int, note: Any) -> bool:
        """Return True if a note that was read has the form of those that `fill` returns."""

    @abstractmethod
    def place(self, index: int) -> str:
        """Describe a part for messages: "designs 0 to 99, from load.mass=3"."""

    @property
    @abstractmethod
    def least_bytes(self) -> int:
        """Least size of the tables on the disk."""

    @property
    def most_bytes(self) -> int:
        """Size of the tables if nothing in them could be compressed."""
        return sum(
            _BYTES_PER_VALUE * len(self.columns(table)) * self.rows(table, index)
            for table, files in self.tables.items()
            for index in range(files)
        )

    @property
    def seconds(self) -> float:
        """Expected time of the processor, s; 0 if nothing in the task takes long for its size."""
        return 0.0

    @abstractmethod
    def results(
        self,
        notes: Sequence[Note],
        finished: Callable[[int], pa.Table],
        proving: Callable[[int, int], None],
    ) -> dict[str, Any]:
        """Return the results for the record; raises Stopped.

        Args:
            notes: Notes of all parts, in their order.
            finished: Reads a part of UNFINISHED.
            proving: Called with the numbers of cells examined and of most cells in a proof.
        """

    def warnings(self, record: Mapping[str, Any]) -> list[str]:  # noqa: ARG002
        """Return the warnings that a reader of the results needs first."""
        return list(self.study.warnings)

    def final_files(
        self,
        record: Mapping[str, Any],  # noqa: ARG002
        finished: Callable[[int], pa.Table],  # noqa: ARG002
    ) -> Iterator[FinalFile]:
        """Yield the files that follow from the whole record, those of `last_tables`.

        Args:
            record: The record.
            finished: Reads a part of UNFINISHED.
        """
        return iter(())

    def check_memory(self) -> None:  # noqa: B027 - a task is of any size, unless it says so
        """Raise SizeError if the task is too large to be run in memory."""

    @property
    def parts(self) -> int:
        """Number of parts that the work is cut into."""
        return max(count for table, count in self.tables.items() if table not in self.last_tables)

    def file(self, table: str, index: int) -> str:
        """Return the name of a table's file in the run folder: one file, or one of several."""
        if self.tables[table] == 1:
            return f"{table}.parquet"
        return f"{table}.parquet/part-{index:05d}.parquet"

    def files(self, index: int) -> dict[str, str]:
        """Return the files of a part in the run folder, by table."""
        return {
            table: self.file(table, index)
            for table, count in self.tables.items()
            if table not in self.last_tables and index < count
        }

    def needed_by(self, index: int) -> set[str]:
        """Return the files of a finished run that cannot be written without a part."""
        files = self.files(index)
        if files.pop(UNFINISHED, None) is not None:
            files[self.completed] = self.file(self.completed, index)
        return set(files.values())

    @cached_property
    def unfinished(self) -> set[str]:
        """Names of the files that are no longer there when the run is finished."""
        return {self.file(UNFINISHED, index) for index in range(self.tables.get(UNFINISHED, 0))}

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of all files of tables in the run folder, those of a table together."""
        return tuple(
            self.file(table, index)
            for table, count in self.tables.items()
            for index in range(count)
        )

    @property
    def run(self) -> tuple[str, str, int]:
        """Facts that its files share with no file of another run, as in `Origin.run`."""
        return self.kind.verb, self.study.hash, RESULTS_VERSION

    def origin(self, table: str, index: int) -> Origin:
        """Return what a file of a table says it is of."""
        return Origin(*self.run, table, index, self.tables[table])

    def layout(self, table: str, index: int, rows: int | None = None) -> TableLayout:
        """Return the layout of a file of a table.

        Args:
            table: The table.
            index: Number of the file, from 0.
            rows: Number of rows, if it is not that of `Task.rows`.
        """
        part = json.dumps({"index": index, "of": self.tables[table]}, sort_keys=True)
        common = self._schemas[table]
        schema = common.with_metadata({**common.metadata, b"tendon.part": part})
        if rows is None:
            rows = self.rows(table, index)
        return TableLayout(self.columns(table), schema, rows)

    @cached_property
    def _schemas(self) -> dict[str, pa.Schema]:
        """Schemas of all tables without the part, from the study and the versions alone."""
        facts = {
            "verb": self.kind.verb,
            "study": self.study.record,
            "study_hash": self.study.hash,
            "results_version": RESULTS_VERSION,
            "versions": versions(),
        }
        return {
            table: schema_of(self.columns(table), {"table": table, **facts})
            for table in self.tables
        }

    def check_stopped(self) -> None:
        """Raise Stopped if the results are not wanted any more."""
        if self.stop.is_set():
            raise Stopped


@dataclass(frozen=True)
class PartResult:
    """A finished part: its note, and its files by their names in the run folder."""

    index: int
    note: Note = field(default_factory=dict)
    files: dict[str, WrittenFile] = field(default_factory=dict)


@dataclass(frozen=True)
class PartFailure:
    """A part that could not be made, and why; the other parts go on."""

    index: int
    error: Exception


PartOutcomes: TypeAlias = Generator[PartResult | PartFailure]
"""Parts in the order in which they are finished, or fail."""


@dataclass(frozen=True)
class PartMaker:
    """Makes parts of a task in a folder; safe to use from several threads."""

    task: Task
    folder: Path

    def open(
        self, name: str, layout: TableLayout
    ) -> AbstractContextManager[TableFile | RowsInMemory]:
        """Open a file of a table, to be filled and flushed; it is put in place at the end."""
        return table_file(self.folder / name, layout)

    def make(self, index: int, compute: Compute = lambda work: work()) -> PartResult:
        """Compute a part, then put its files in place; raises OutputError, Stopped.

        Args:
            index: The part.
            compute: Calls the function that computes the part, by default in this thread.
        """
        names = self.task.files(index)
        files: dict[str, TableFile | RowsInMemory] = {}
        with ExitStack() as stack:

            def work() -> Note:
                for table, name in names.items():
                    layout = self.task.layout(table, index)
                    files[table] = stack.enter_context(self.open(name, layout))
                note = self.task.fill(files, index)
                for file in files.values():
                    file.close(note)
                return note

            note = compute(work)
            for file in files.values():
                file.flush()
            self.check()
            written = {names[table]: file.close() for table, file in files.items()}
            return PartResult(index, note, written)

    def check(self) -> None:
        """Raise an exception if written files may not be put in place; here they always may."""

    def finished(self, index: int) -> pa.Table:
        """Read a finished part that is not complete yet; raises InputError."""
        return TableFiles((self.folder / self.task.file(UNFINISHED, index),)).read()

    def write(self, file: FinalFile) -> WrittenFile:
        """Write a file that follows from the whole record; raises OutputError."""
        name, layout, fill = file
        with self.open(name, layout) as opened:
            opened.fill(layout.rows, fill)
            opened.flush()
            return opened.close()

    def tidy(self) -> None:
        """Remove files that killed processes had begun; only the holder of the folder may."""
        folders = [self.folder]
        folders += [
            self.folder / f"{table}.parquet"
            for table, files in self.task.tables.items()
            if files > 1
        ]
        for folder in folders:
            if not folder.is_dir() or folder.is_symlink():
                continue
            for file in folder.iterdir():
                if OF_A_RUN.fullmatch(file.name):
                    with contextlib.suppress(OSError):
                        file.unlink()


@dataclass(frozen=True)
class InMemory(PartMaker):
    """Makes parts that never reach the disk."""

    kept: dict[str, pa.Table] = field(default_factory=dict, kw_only=True)
    """Parts of tables by the names of their files."""

    @contextlib.contextmanager
    def open(self, name: str, layout: TableLayout) -> Iterator[RowsInMemory]:
        """Open a part of a table, to be filled; it is kept at the end."""
        rows = RowsInMemory(layout)
        yield rows
        self.kept[name] = rows.table()

    def finished(self, index: int) -> pa.Table:
        """Return a finished part."""
        return self.kept[self.task.file(UNFINISHED, index)]

    def tables(self) -> dict[str, pa.Table]:
        """Return the whole tables by name; their parts are not kept any longer."""
        tables = {}
        for table, count in self.task.tables.items():
            if table == UNFINISHED:
                continue
            names = [self.task.file(table, index) for index in range(count)]
            tables[table] = pa.concat_tables(self.kept.pop(name) for name in names)
        return tables
