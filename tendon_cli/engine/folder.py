"""The folder of a run: check that a task may write there, and put its files in place.

What a folder holds is said by the files themselves: a record says that a run is finished, and each
file of a table says in its footer which run and part it is of, a figure which study. So a run needs
no list of its files to be resumed, and nothing else is ever replaced or deleted.
"""

from __future__ import annotations

import contextlib
import os
import re
import shutil
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from tendon_cli.engine.records import (
    FIGURE_FILE,
    difference,
    is_table_file,
    read_record,
    write_record,
)
from tendon_cli.engine.task import PartResult, Task
from tendon_cli.errors import FolderError, OutputError, SizeError, WorkersLostError
from tendon_cli.files import LOCK, OF_A_RUN, open_file, output_errors, study_hash_in
from tendon_cli.tables.footer import Origin, read_footer, read_whole
from tendon_cli.tables.write import WrittenFile
from tendon_cli.verbs.registry import UNFINISHED, record_names, tables_in_folders
from tendon_cli.version import reader_of

_OLD_JOURNAL = "journal.jsonl"
"""File of an unfinished run of tendon 0.3.0 and before, which listed its parts."""
_READ_AS_PART = re.compile(r"part-.*\.parquet")
"""Names of files that readers of a folder of parts take for parts."""
_FIGURES = re.compile(r"\.tendon-figures-[0-9a-f]{12}", re.ASCII)
"""Names of folders in which figures lie until all are drawn."""
_ELSEWHERE = "choose another folder with --out"
_MOVE_AWAY = "move it away, or choose another folder with --out"


@dataclass(frozen=True)
class FolderContents:
    """Contents of a run folder at one look."""

    record: dict[str, Any] | None
    """Record of the finished run; None if there is none."""
    has_lock: bool
    """True if a run has ever been there."""
    origins: Mapping[str, Origin]
    """Files of tables that a run wrote, by name, and what their footers say they are of."""
    others: tuple[str, ...]
    """Other files by name, among them tables that no run wrote; in folders of tables, too."""

    @cached_property
    def listed(self) -> set[str]:
        """Names of the tables' files that the record lists."""
        return set() if self.record is None else {item["path"] for item in self.record["files"]}

    @cached_property
    def run(self) -> tuple[str, str, int] | None:
        """The run that stands in the folder, finished or not; None if there is none.

        It is as in `Origin.run`.
        """
        if self.record is not None:
            record = self.record
            return record["verb"], record["study_hash"], record["results_version"]
        return next((origin.run for origin in self.origins.values()), None)

    @cached_property
    def of_run(self) -> set[str]:
        """Names of the tables' files that belong to the run in the folder."""
        by_footer = {name for name, origin in self.origins.items() if origin.run == self.run}
        return self.listed | by_footer


@dataclass(frozen=True)
class RunFolder:
    """A run folder, and the task that is to be run into it."""

    path: Path
    task: Task

    def check(self, contents: FolderContents, *, resume: bool, overwrite: bool) -> None:
        """Raise FolderError if the task may not be run into the folder; nothing is changed there.

        Args:
            contents: Contents of the folder.
            resume: True if an unfinished run of the same study may be finished.
            overwrite: True if the run in the folder may be replaced.
        """
        record = contents.record
        if record is None and _OLD_JOURNAL in contents.others:
            raise self._refusal(
                f"holds a {_OLD_JOURNAL}, which this tendon does not write",
                f"{reader_of(0)} to {reader_of(6)} finish a run that has one; {_ELSEWHERE}",
            )
        ours = self.task.run
        is_ours = contents.run == ours
        if record is None and not (is_ours or (contents.run and contents.has_lock)):
            # No run was ever here, or none that came to its first part.
            foreign = [*contents.origins, *map(self._at_the_top, contents.others)]
            foreign = [name for name in foreign if not self._is_figure_of(name, ours)]
            if foreign:
                raise self._refusal(f"is not a run folder, it holds {min(foreign)}", _ELSEWHERE)
            return
        another = [name for name in contents.origins if name not in contents.of_run]
        if record is None and another:
            raise self._refusal(f"holds files of two runs, among them {another[0]}", _MOVE_AWAY)
        if overwrite:
            self._check_nothing_in_the_way(contents, contents.of_run)
            return
        if not is_ours:
            differs = self._difference(contents)
            hint = "--overwrite replaces it, --out writes elsewhere"
            raise self._refusal(f"holds a run of another study: {differs}", hint)
        if record is not None:
            return
        if not resume:
            parts = range(self.task.parts)
            done = sum(set(self.task.files(part).values()) <= contents.of_run for part in parts)
            raise self._refusal(
                f"holds an unfinished run of this study, {done} of {len(parts)} parts are done",
                "--resume finishes it (in Python resume=True), --overwrite starts over",
            )
        self._check_nothing_in_the_way(contents, contents.of_run.intersection(self.task.names))

    def _difference(self, contents: FolderContents) -> str:
        """Say how the run in the folder differs from the one that is to be run."""
        existing: dict[str, Any] | None = contents.record
        if existing is None:
            footer = read_footer(self.path / next(iter(contents.origins)))
            facts = {} if footer is None else footer.facts
            existing = {**facts, **(facts.get("study") or {})}
        return difference(existing, self.task.kind.verb, self.task.study) or "other parts"

    def _check_nothing_in_the_way(self, contents: FolderContents, replaced: set[str]) -> None:
        """Raise FolderError if a file is in the way of this run.

        Args:
            contents: Contents of the folder.
            replaced: Names of the files that the run may replace or delete.
        """
        for name in (*contents.others, *contents.origins):
            top, _, inner = name.partition("/")
            table = top.removesuffix(".parquet")
            if name in replaced or top == table or table not in self.task.tables:
                continue
            # A folder of parts may keep a stranger's file, unless readers take it for a part.
            stays_folder = inner and self.task.tables[table] > 1
            if not stays_folder or _READ_AS_PART.fullmatch(inner):
                raise self._refusal(f"holds {name}, which no run wrote, or is damaged", _MOVE_AWAY)

    @staticmethod
    def _at_the_top(name: str) -> str:
        """Return the file or folder at the top of the run folder that a name is in."""
        return name.partition("/")[0]

    def _is_figure_of(self, name: str, run: tuple[str, str, int]) -> bool:
        """Return True if a file is a figure of a run's study."""
        _, study_hash, _ = run
        if not FIGURE_FILE.fullmatch(name):
            return False
        try:
            with open_file(self.path / name) as file:
                return study_hash_in(file) == study_hash
        except OSError:
            return False

    def _refusal(self, message: str, hint: str | None = None) -> FolderError:
        return FolderError(message, where=str(self.path), hint=hint)

    def check_space(self, contents: FolderContents) -> None:
        """Raise SizeError for a run that cannot fit on the disk, before any of it is written."""
        if contents.record is None and contents.origins:
            return  # the finished parts of an unfinished run are on the disk already
        needed = self.task.least_bytes
        free = free_bytes(self.path)
        if needed > free:
            raise SizeError(
                f"at least {needed / 1e9:.3g} GB would be written, "
                f"but the disk has {free / 1e9:.3g} GB free",
                where=str(self.path),
                hint='`[output] tables = ["designs"]` leaves the states out; '
                "--dry-run prints the size beforehand",
            )

    def standing(self, contents: FolderContents) -> dict[int, PartResult]:
        """Return the parts of this run whose files are whole, by their indices.

        Each file is read once.
        """
        standing = {}
        for index in range(self.task.parts):
            part = self._standing_part(contents, index)
            if part is not None:
                standing[index] = part
        return standing

    def _standing_part(self, contents: FolderContents, index: int) -> PartResult | None:
        """Return a part whose files are all there, as they were written; else None."""
        files = {}
        note: Any = None
        for table, name in self.task.files(index).items():
            if contents.origins.get(name) != self.task.origin(table, index):
                return None
            path = self.path / name
            try:
                whole = None if path.is_symlink() else read_whole(path)
                if whole is None:
                    return None
                footer, sha256 = whole
                note = footer.fact("note")
            except (OSError, ValueError, RecursionError):
                return None
            files[name] = WrittenFile(footer.metadata.num_rows, footer.size, sha256)
        if not self.task.is_note(index, note):
            return None
        return PartResult(index, note, files)

    def prepare(self) -> None:
        """Make the folders of tables that have several parts; raises OutputError.

        A table of one part stands where an interrupted run may have left an empty folder.
        """
        for table, files in self.task.tables.items():
            folder = self.path / f"{table}.parquet"
            if files <= 1:
                with contextlib.suppress(OSError):
                    folder.rmdir()
                continue
            try:
                if folder.is_symlink():
                    raise OutputError(
                        "is a symbolic link, which tendon does not write through", where=str(folder)
                    )
                folder.mkdir(exist_ok=True)
            except OSError as error:
                raise OutputError(f"cannot be made: {error.strerror}", where=str(folder)) from error

    def clear(self, contents: FolderContents) -> None:
        """Delete the files of the run in the folder, finished or not, and nothing else.

        Tables go last: they say themselves whose they are, so that the next run knows the rest,
        whenever the process ends.
        """
        run = contents.run
        if run is None:
            return
        figures = contents.others if contents.record is None else contents.record["figures"]
        with output_errors(self.path):
            for name in figures:
                if self._is_figure_of(name, run):
                    self._delete(name)
            for name in record_names():
                self._delete(name)
            for name in contents.of_run:
                self._delete(name)
            for name in _table_files():
                with contextlib.suppress(OSError):
                    (self.path / name).rmdir()

    def _delete(self, name: str) -> None:
        (self.path / name).unlink(missing_ok=True)

    @contextlib.contextmanager
    def figures(self) -> Iterator[Path]:
        """Yield a folder for figures until all are drawn; raises OSError.

        Folders that killed processes left are removed.
        """
        for item in self.path.iterdir():
            if _FIGURES.fullmatch(item.name) and not item.is_symlink():
                shutil.rmtree(item, ignore_errors=True)
        drawn = self.path / f".tendon-figures-{os.urandom(6).hex()}"
        try:
            drawn.mkdir()
            yield drawn
        finally:
            shutil.rmtree(drawn, ignore_errors=True)

    def place_figures(self, drawn: Path, names: list[str], before: list[str]) -> list[str]:
        """Replace earlier figures by those that were drawn; raises OutputError.

        Args:
            drawn: The folder in which they were drawn.
            names: Their names; those that cannot be put in place are removed from the list.
            before: Names of the earlier figures.

        Returns:
            Warnings about figures that are left out.
        """
        run = self.task.run
        faults = []
        for name in list(names):
            if os.path.lexists(self.path / name) and not self._is_figure_of(name, run):
                names.remove(name)
                faults.append(
                    f"{name} is not drawn: a file of that name is there, which no run wrote"
                )
        with output_errors(self.path):
            for name in before:
                if name not in names and self._is_figure_of(name, run):
                    self._delete(name)
            for name in names:
                (drawn / name).replace(self.path / name)
        return faults

    def finish(self, record: dict[str, Any]) -> None:
        """Declare the run finished: write its record last of all.

        Raises:
            WorkersLostError: A file of the run was replaced or damaged meanwhile.
            FolderError: A file among the parts is not of the run.
        """
        sizes = {entry["path"]: entry["size"] for entry in record["files"]}
        for name, size in sizes.items():
            path = self.path / name
            if not path.exists() or path.lstat().st_size != size:
                hint = "--resume computes it again"
                message = "was replaced or damaged during the run"
                raise WorkersLostError(message, where=str(path), hint=hint)
        for table, files in self.task.tables.items():
            if files <= 1 or table == UNFINISHED:
                continue
            for item in (self.path / f"{table}.parquet").iterdir():
                name = f"{table}.parquet/{item.name}"
                if _READ_AS_PART.fullmatch(item.name) and name not in sizes:
                    hint = "move it away, then --resume"
                    raise self._refusal(f"holds {name}, which is not of this run", hint)
        write_record(self.path, record)
        self.drop_unfinished()

    def drop_unfinished(self) -> None:
        """Delete the parts that a finished run has completed, which nobody needs any more."""
        if UNFINISHED not in self.task.tables:
            return
        with contextlib.suppress(OSError):
            for name in self.task.unfinished:
                self._delete(name)
            (self.path / f"{UNFINISHED}.parquet").rmdir()


def _table_files() -> list[str]:
    """Return the names of the files of tables, or of the folders of their parts."""
    return [f"{table}.parquet" for table in tables_in_folders()]


def look(folder: Path) -> FolderContents:
    """Look at what a folder holds. Of files that no record lists, footers are read.

    Raises:
        FolderError: It is no folder, or a record in it is not as tendon wrote it.
    """
    if not folder.is_dir():
        if folder.exists():
            raise FolderError("is a file, expected a folder for the run", where=str(folder))
        return FolderContents(None, has_lock=False, origins={}, others=())
    record = read_record(folder)
    listed = set() if record is None else {entry["path"] for entry in record["files"]}
    origins = {}
    others = []
    for name in _names_in(folder):
        if name in listed:
            continue
        origin = _origin_of(folder / name) if is_table_file(name) else None
        if origin is not None:
            origins[name] = origin
        else:
            others.append(name)
    has_lock = (folder / LOCK).exists()
    return FolderContents(record, has_lock=has_lock, origins=origins, others=tuple(others))


def _names_in(folder: Path) -> Iterator[str]:
    """Yield the names of all that a folder holds but records, locks and files that are begun.

    Folders of tables are looked into, others are one name; an empty folder of a table is none.
    """
    of_every_run = (*record_names(), LOCK)
    table_files = _table_files()
    for item in sorted(folder.iterdir()):
        name = item.name
        if name in of_every_run or OF_A_RUN.fullmatch(name):
            continue
        if _FIGURES.fullmatch(name):
            continue
        is_table = name in table_files and item.is_dir() and not item.is_symlink()
        if not is_table:
            yield name
            continue
        for part in sorted(item.iterdir()):
            if not OF_A_RUN.fullmatch(part.name):
                yield f"{name}/{part.name}"


def _origin_of(path: Path) -> Origin | None:
    """Return what the file of a table says it is of; None if it is no file that a run wrote."""
    try:
        footer = read_footer(path)
    except OSError:
        return None
    return None if footer is None else footer.origin


def free_bytes(folder: Path) -> int:
    """Return the free space on the disk of a folder, which need not exist yet, bytes."""
    path = folder.absolute()
    existing = next(place for place in (path, *path.parents) if place.exists())
    return shutil.disk_usage(existing).free
