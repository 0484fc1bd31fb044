"""The folder of a run: who may write to it, what it holds, and what of that may be replaced."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import re
import shutil
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from tendon_cli.engine.journal import JOURNAL, Journal
from tendon_cli.engine.records import read_record, stands, write_record
from tendon_cli.engine.task import PartResult, Task
from tendon_cli.errors import FolderError, InputError, OutputError, SizeError, WorkersLostError
from tendon_cli.files import OF_A_RUN, output_errors
from tendon_cli.tables.read import RECORDS, study_hash_of

LOCK = ".lock"
OURS = (*RECORDS.values(), JOURNAL, LOCK)
_PART = re.compile(r"part-(\d{5,})\.parquet", re.ASCII)
_FIGURES = re.compile(r"\.tendon-figures-[0-9a-f]{12}", re.ASCII)
"""Where figures lie until all are drawn."""


@dataclass(frozen=True)
class RunFolder:
    """A run folder and the task that is to stand in it."""

    path: Path
    task: Task

    def check_space(self) -> None:
        """Refuse a run that cannot fit, before anything is made of it; raises SizeError."""
        if (self.path / JOURNAL).exists():
            return  # what is done of an unfinished run is on the disk already
        needed = self.task.least_bytes
        if needed > (free := free_bytes(self.path)):
            raise SizeError(
                f"at least {needed / 1e9:.3g} GB would be written, the disk has {free / 1e9:.3g} GB free",
                where=str(self.path),
                hint='`[output] tables = ["designs"]` leaves the states out; --dry-run tells the size beforehand',
            )

    @contextlib.contextmanager
    def locked(self, *, use_lock: bool = True) -> Iterator[None]:
        """Make the folder and hold it; raises FolderError if another run does, OutputError if it cannot be made.

        The system gives the lock up when its holder dies, however it dies.
        """
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            handle = os.open(self.path / LOCK, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK, 0o666)
        except FileExistsError:
            raise FolderError("is a file, expected a folder for the run", where=str(self.path)) from None
        except OSError as error:
            raise OutputError(f"cannot be made: {error.strerror}", where=str(self.path)) from error
        try:
            if use_lock:
                self._lock(handle)
            yield
        finally:
            os.close(handle)

    def check_free(self) -> None:
        """Raises FolderError if another run writes here just now; leaves no trace."""
        try:
            handle = os.open(self.path / LOCK, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
        except OSError:  # no run was ever here
            return
        try:
            self._lock(handle, fcntl.LOCK_SH)
        finally:
            os.close(handle)

    def _lock(self, handle: int, kind: int = fcntl.LOCK_EX) -> None:
        try:
            fcntl.flock(handle, kind | fcntl.LOCK_NB)
        except OSError as error:
            if error.errno in (errno.EWOULDBLOCK, errno.EACCES):
                hint = "wait for it, or choose another folder with --out"
                raise FolderError("another run is writing here", where=str(self.path), hint=hint) from None
            hint = "--no-lock runs without; make sure yourself that no other run writes here"
            raise FolderError(
                f"the file system cannot lock: {error.strerror}", where=str(self.path), hint=hint
            ) from None

    def header(self) -> dict[str, Any]:
        """What the journal of this run begins with."""
        return {**self.task.identity, "tables": list(self.task.tables), "parts": self.task.parts}

    def intact(self, journal: Journal) -> dict[int, PartResult]:
        """Of recorded parts those whose files stand as they were written, at first or at last."""
        kept = {}
        for index, part in journal.parts.items():
            if not (index < self.task.parts and self.task.is_note(index, part.note)):
                continue
            files = {
                name: next((each for each in (file, journal.last.get(name)) if each and self._stands(name, each)), None)
                for name, file in part.files.items()
            }
            if set(files) == set(self.task.files(index).values()) and None not in files.values():
                kept[index] = replace(part, files={name: file for name, file in files.items() if file})
        return kept

    def _stands(self, name: str, file: Any) -> bool:
        return stands(self.path, {"path": name, **asdict(file)})

    def prepare(self) -> None:
        """Make the folders of tables' parts, if there are several; raises OutputError."""
        for table, parts in self.task.tables.items():
            folder = self.path / f"{table}.parquet"
            if parts <= 1:
                continue
            try:
                if folder.is_symlink():
                    raise OutputError("is a symbolic link, which tendon does not write through", where=str(folder))
                folder.mkdir(exist_ok=True)
            except OSError as error:
                raise OutputError(f"cannot be made: {error.strerror}", where=str(folder)) from error

    def clear(self) -> bool:
        """Delete the files of the run that stands here, finished or not, and nothing else; whether there was one."""
        record, journal = read_record(self.path), Journal.read(self.path)
        if record is not None:  # until the new run has its journal, this one says whose files these are
            tables = sorted({entry["path"].partition(".")[0] for entry in record["files"]})
            kept = {key: record.get(key) for key in self.task.identity}
            journal.figures = (*record["figures"], *journal.figures)
            journal.start({**kept, "parts": record.get("parts", 1), "tables": tables})
        with output_errors(self.path):
            for name in RECORDS.values():
                self._delete(name)  # first: what is half deleted must not look finished
            for name in journal.figures:
                self._delete(name)
            for table in journal.header.get("tables", ()):
                self._delete_table(f"{table}.parquet")
        return journal.path.exists()

    def _delete_table(self, name: str) -> None:
        """Delete a table of the run: its file, or all parts; what others put among these stays."""
        path = self.path / name
        if path.is_dir() and not path.is_symlink():
            for item in path.iterdir():
                if is_part(item.name):
                    self._delete(f"{name}/{item.name}")
            with contextlib.suppress(OSError):
                path.rmdir()
        else:
            self._delete(name)

    def _delete(self, name: str) -> None:
        (self.path / name).unlink(missing_ok=True)

    @contextlib.contextmanager
    def figures(self) -> Iterator[Path]:
        """A folder for figures until all are drawn; those that a kill left go. Raises OSError."""
        for left in self.path.iterdir():
            if _FIGURES.fullmatch(left.name) and not left.is_symlink():
                shutil.rmtree(left, ignore_errors=True)
        place = self.path / f".tendon-figures-{os.urandom(6).hex()}"
        try:
            place.mkdir()
            yield place
        finally:
            shutil.rmtree(place, ignore_errors=True)

    def place_figures(self, place: Path, names: list[str], before: list[str], journal: Journal | None) -> list[str]:
        """Put drawn figures in place of those `before`; returns what is wrong with those that are left out."""
        faults = []
        for name in list(names):
            if name not in before and os.path.lexists(self.path / name):
                names.remove(name)
                faults.append(f"{name} is not drawn: a file of that name stands there, which no run wrote")
        if journal is not None and names:
            journal.announce(names)
        with output_errors(self.path):
            for name in before:
                if name not in names:
                    self._delete(name)
            for name in names:
                (place / name).replace(self.path / name)
        return faults

    def finish(self, record: dict[str, Any]) -> None:
        """Declare the run finished: its record last of all, then the journal goes.

        A lost worker of an older run may have written late: parts that this run has not are deleted; raises
        WorkersLostError if one of its files was replaced, InputError if it is no whole table any more.
        """
        sizes = {entry["path"]: entry["size"] for entry in record["files"]}
        for table in (table for table, parts in self.task.tables.items() if parts > 1):
            for item in (self.path / f"{table}.parquet").iterdir():
                if is_part(item.name) and f"{table}.parquet/{item.name}" not in sizes:
                    self._delete(f"{table}.parquet/{item.name}")
        for name, size in sizes.items():
            if (self.path / name).lstat().st_size != size:
                place, hint = str(self.path / name), "--resume computes it anew"
                if study_hash_of(self.path / name) is None:
                    raise InputError("was damaged while the run went on", where=place, hint=hint)
                raise WorkersLostError("was replaced while the run went on", where=place, hint=hint)
        write_record(self.path, record)
        with contextlib.suppress(OSError):
            self._delete(JOURNAL)


def is_ours(name: str) -> bool:
    """Whether a run gives such names to files in its folder besides tables and figures."""
    return name in OURS or bool(OF_A_RUN.fullmatch(name) or _FIGURES.fullmatch(name))


def is_part(name: str) -> bool:
    """Whether a run gives such names to files in a folder of parts."""
    return bool(_PART.fullmatch(name) or OF_A_RUN.fullmatch(name))


def free_bytes(folder: Path) -> int:
    """What is free on the disk that holds a folder, or would hold it."""
    path = folder.absolute()
    return shutil.disk_usage(next(place for place in (path, *path.parents) if place.exists())).free
