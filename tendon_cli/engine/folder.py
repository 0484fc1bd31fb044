"""The folder of a run: check that a task may write there, and put its files in place."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from tendon_cli.engine.journal import JOURNAL, Journal
from tendon_cli.engine.records import difference, is_intact, read_record, write_record
from tendon_cli.engine.task import PartResult, Task
from tendon_cli.errors import FolderError, InputError, OutputError, SizeError, WorkersLostError
from tendon_cli.files import LOCK, OF_A_RUN, output_errors
from tendon_cli.registry import record_names, table_kinds
from tendon_cli.tables.read import study_hash_of
from tendon_cli.tables.write import WrittenFile

_PART = re.compile(r"part-(\d{5,})\.parquet", re.ASCII)
_READ_AS_PART = re.compile(r"part-.*\.parquet")
"""Names of files that readers of a folder of parts take for parts."""
_FIGURES = re.compile(r"\.tendon-figures-[0-9a-f]{12}", re.ASCII)
"""Names of folders in which figures lie until all are drawn."""
_ELSEWHERE = "choose another folder with --out"
_NO_JOURNAL = "holds a journal that is not as tendon wrote it"


@dataclass(frozen=True)
class RunFolder:
    """A run folder, and the task that is to be run into it."""

    path: Path
    task: Task

    def check(self, *, resume: bool, overwrite: bool) -> None:
        """Raise FolderError if the task may not be run into the folder; nothing is changed there.

        Args:
            resume: True if an unfinished run of the same study may be finished.
            overwrite: True if the run in the folder may be replaced.
        """
        if not self.path.exists():
            return
        if not self.path.is_dir():
            raise self._refusal("is a file, expected a folder for the run")
        record = read_record(self.path)
        journal = Journal.read(self.path)
        existing = record or journal.header
        if not existing:
            self._check_not_foreign(journal)
            return
        if overwrite:
            self._check_replaceable(existing)
            return
        differs = difference(existing, self.task.kind.verb, self.task.study)
        if differs is not None:
            hint = "--overwrite replaces it, --out writes elsewhere"
            raise self._refusal(f"holds a run of another study: {differs}", hint)
        if record is not None:
            return
        if not self.header().items() <= existing.items():
            raise self._refusal(_NO_JOURNAL, _ELSEWHERE)
        if not resume:
            done = f"{len(journal.parts)} of {self.task.parts} parts are done"
            hint = "--resume finishes it (in Python resume=True), --overwrite starts over"
            raise self._refusal(f"holds an unfinished run of this study, {done}", hint)

    def _check_not_foreign(self, journal: Journal) -> None:
        """Raise FolderError unless the folder is empty, or can only be the beginning of this run.

        Args:
            journal: The journal of the folder, which has no header.
        """
        foreign = sorted(item.name for item in self.path.iterdir() if not _is_ours(item.name))
        if journal.path.exists():
            if not (journal.parts or journal.is_beginning_of(self.header())):
                raise self._refusal(_NO_JOURNAL, _ELSEWHERE)
            foreign = [name for name in foreign if not self._is_of_this_study(name)]
        if foreign:
            raise self._refusal(f"is not a run folder, it holds {foreign[0]}", _ELSEWHERE)

    def _is_of_this_study(self, name: str) -> bool:
        """Return True if a file, or a folder of parts, is a table of this study, or becomes one."""
        path = self.path / name
        if path.is_symlink() or name not in {f"{table}.parquet" for table in table_kinds()}:
            return False
        files = [path]
        if not path.is_file():
            files = [file for file in path.iterdir() if not OF_A_RUN.fullmatch(file.name)]
        return all(study_hash_of(file) == self.task.study.hash for file in files)

    def _check_replaceable(self, existing: dict[str, Any]) -> None:
        """Raise FolderError if a file that no run wrote is in the way of this run.

        Args:
            existing: Record, or header of the journal, of the run that is to be replaced.
        """
        listed = {entry["path"].partition(".")[0] for entry in existing.get("files", ())}
        listed.update(existing.get("tables", ()))
        for table in table_kinds():
            path = self.path / f"{table}.parquet"
            parts = self.task.tables.get(table)
            is_unlisted = parts is not None and table not in listed
            in_the_way = []
            if path.is_symlink() or (is_unlisted and path.exists()):
                in_the_way.append(path.name)
            if path.is_dir() and table in listed:
                # A folder of parts may keep a stranger's file, unless readers take it for a part.
                stays_folder = parts is not None and parts > 1
                others = [item.name for item in path.iterdir() if not _is_part(item.name)]
                in_the_way += [
                    f"{path.name}/{name}"
                    for name in others
                    if not stays_folder or _READ_AS_PART.fullmatch(name)
                ]
            if in_the_way:
                hint = "move it away, or choose another folder with --out"
                raise self._refusal(f"holds {in_the_way[0]}, which no run wrote", hint)

    def _refusal(self, message: str, hint: str | None = None) -> FolderError:
        return FolderError(message, where=str(self.path), hint=hint)

    def check_space(self) -> None:
        """Raise SizeError for a run that cannot fit on the disk, before any of it is written."""
        if (self.path / JOURNAL).exists():
            return  # the finished parts of an unfinished run are on the disk already
        needed = self.task.least_bytes
        free = free_bytes(self.path)
        if needed > free:
            raise SizeError(
                f"at least {needed / 1e9:.3g} GB would be written, "
                f"the disk has {free / 1e9:.3g} GB free",
                where=str(self.path),
                hint='`[output] tables = ["designs"]` leaves the states out; '
                "--dry-run prints the size beforehand",
            )

    def header(self) -> dict[str, Any]:
        """Return the first entry of this run's journal: which run it is, its tables and parts."""
        return {**self.task.identity, "tables": list(self.task.tables), "parts": self.task.parts}

    def intact(self, journal: Journal) -> dict[int, PartResult]:
        """Return the recorded parts whose files are as they were first or last written."""
        intact = {}
        for index, part in journal.parts.items():
            if index >= self.task.parts or not self.task.is_note(index, part.note):
                continue
            files = {}
            for name, first in part.files.items():
                for written in (first, journal.last.get(name)):
                    if written is not None and self._is_intact(name, written):
                        files[name] = written
                        break
            is_whole = len(files) == len(part.files)
            if is_whole and set(files) == set(self.task.files(index).values()):
                intact[index] = replace(part, files=files)
        return intact

    def _is_intact(self, name: str, file: WrittenFile) -> bool:
        """Return True if a file in the folder has the recorded bytes."""
        return is_intact(self.path, {"path": name, **asdict(file)})

    def prepare(self) -> None:
        """Make the folders of tables that have several parts; raises OutputError."""
        for table, parts in self.task.tables.items():
            folder = self.path / f"{table}.parquet"
            if parts <= 1:
                continue
            try:
                if folder.is_symlink():
                    raise OutputError(
                        "is a symbolic link, which tendon does not write through", where=str(folder)
                    )
                folder.mkdir(exist_ok=True)
            except OSError as error:
                raise OutputError(f"cannot be made: {error.strerror}", where=str(folder)) from error

    def clear(self) -> bool:
        """Delete the files of the run in the folder, finished or not, and nothing else.

        Returns:
            True if there was one.
        """
        record = read_record(self.path)
        journal = Journal.read(self.path)
        if record is not None:
            # Until the new run has its journal, this one says whose files these are.
            tables = sorted({entry["path"].partition(".")[0] for entry in record["files"]})
            identity = {key: record.get(key) for key in self.task.identity}
            journal.figures = (*record["figures"], *journal.figures)
            journal.start({**identity, "parts": record.get("parts", 1), "tables": tables})
        with output_errors(self.path):
            for name in record_names():
                self._delete(name)  # first, so that what is half deleted does not look finished
            for name in journal.figures:
                self._delete(name)
            for table in journal.header.get("tables", ()):
                self._delete_table(f"{table}.parquet")
        return journal.path.exists()

    def _delete_table(self, name: str) -> None:
        """Delete a table of the run, its file or all its parts; other files among parts stay."""
        path = self.path / name
        if path.is_symlink() or not path.is_dir():
            self._delete(name)
            return
        for item in path.iterdir():
            if _is_part(item.name):
                self._delete(f"{name}/{item.name}")
        with contextlib.suppress(OSError):
            path.rmdir()

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

    def place_figures(
        self, drawn: Path, names: list[str], before: list[str], journal: Journal | None
    ) -> list[str]:
        """Replace earlier figures by those that were drawn; raises OutputError.

        Args:
            drawn: The folder in which they were drawn.
            names: Their names; those that cannot be put in place are removed from the list.
            before: Names of the earlier figures.
            journal: Journal in which the names are announced first; None if a record lists them.

        Returns:
            Warnings about figures that are left out.
        """
        faults = []
        for name in list(names):
            if name not in before and os.path.lexists(self.path / name):
                names.remove(name)
                faults.append(
                    f"{name} is not drawn: a file of that name is there, which no run wrote"
                )
        if journal is not None and names:
            journal.announce(names)
        with output_errors(self.path):
            for name in before:
                if name not in names:
                    self._delete(name)
            for name in names:
                (drawn / name).replace(self.path / name)
        return faults

    def finish(self, record: dict[str, Any]) -> None:
        """Declare the run finished: write its record last of all, then delete the journal.

        Parts that the record does not list are deleted: a worker that was lost may have written
        them late.

        Raises:
            WorkersLostError: A file of the run was replaced.
            InputError: A file of the run was damaged.
        """
        sizes = {entry["path"]: entry["size"] for entry in record["files"]}
        for table, parts in self.task.tables.items():
            if parts <= 1:
                continue
            for item in (self.path / f"{table}.parquet").iterdir():
                name = f"{table}.parquet/{item.name}"
                if _is_part(item.name) and name not in sizes:
                    self._delete(name)
        for name, size in sizes.items():
            path = self.path / name
            if path.lstat().st_size != size:
                hint = "--resume computes it again"
                if study_hash_of(path) is None:
                    message = "was damaged during the run"
                    raise InputError(message, where=str(path), hint=hint)
                message = "was replaced during the run"
                raise WorkersLostError(message, where=str(path), hint=hint)
        write_record(self.path, record)
        with contextlib.suppress(OSError):
            self._delete(JOURNAL)


def _is_ours(name: str) -> bool:
    """Return True if a run gives this name to a file in its folder that is no table or figure."""
    is_named = name in (*record_names(), JOURNAL, LOCK)
    return is_named or bool(OF_A_RUN.fullmatch(name) or _FIGURES.fullmatch(name))


def _is_part(name: str) -> bool:
    """Return True if a run gives this name to a file in a folder of parts."""
    return bool(_PART.fullmatch(name) or OF_A_RUN.fullmatch(name))


def free_bytes(folder: Path) -> int:
    """Return the free space on the disk of a folder, which need not exist yet, bytes."""
    path = folder.absolute()
    existing = next(place for place in (path, *path.parents) if place.exists())
    return shutil.disk_usage(existing).free
