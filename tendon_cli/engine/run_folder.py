"""The folder of a run: who may write to it, what it holds, and what of that may be replaced."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import re
import shutil
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tendon_cli.engine.part import PartResult, file_name
from tendon_cli.engine.plan import Plan
from tendon_cli.engine.record import JOURNAL, RECORD, Journal, read_record, stands, write_record
from tendon_cli.engine.suits import is_note
from tendon_cli.errors import FolderError, InputError, OutputError, SizeError, WorkersLostError
from tendon_cli.files import output_errors
from tendon_cli.tables.read import study_hash_of
from tendon_cli.version import RESULTS_VERSION

LOCK = ".lock"
FIGURES = ".tendon-figures"
"""Where figures lie until all are drawn."""
OURS = (RECORD, JOURNAL, LOCK, FIGURES, f".{RECORD}.tmp", f".{JOURNAL}.tmp")
_PART = re.compile(r"part-(\d{5,})\.parquet", re.ASCII)
TEMPORARY = re.compile(r"\.(part-\d{5,}|designs|states)\.parquet(\.[0-9a-f]+\.own)?(\.tmp)?", re.ASCII)
_LEAST_BYTES_PER_STATE = 20
_LEAST_BYTES_PER_DESIGN = 10


@dataclass(frozen=True)
class RunFolder:
    """A run folder and the plan that is to stand in it."""

    path: Path
    plan: Plan

    def check_space(self) -> None:
        """Refuse a run that cannot fit, before anything is made of it; raises SizeError."""
        if (self.path / JOURNAL).exists():
            return  # what is done of an unfinished run is on the disk already
        tables = self.plan.study.output.tables
        needed = self.plan.designs * _LEAST_BYTES_PER_DESIGN if "designs" in tables else 0
        needed += self.plan.states * _LEAST_BYTES_PER_STATE if "states" in tables else 0
        if needed > (free := free_bytes(self.path)):
            raise SizeError(
                f"at least {needed / 1e9:.3g} GB would be written, the disk has {free / 1e9:.3g} GB free",
                where=str(self.path),
                hint='`[output] tables = ["designs"]` leaves the states out; --dry-run tells the size beforehand',
            )

    @contextlib.contextmanager
    def locked(self, *, use_lock: bool = True) -> Iterator[None]:
        """Make the folder and hold it; raises FolderError where another run does, OutputError where it cannot be made.

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
        """Raises FolderError where another run writes here just now; leaves no trace."""
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

    def identity(self) -> dict[str, Any]:
        """What makes two runs the same."""
        study = self.plan.study
        return {"study_hash": study.hash, "results_version": RESULTS_VERSION, **study.record}

    def header(self) -> dict[str, Any]:
        """What the journal of this run begins with."""
        return {**self.identity(), "tables": list(self.plan.study.output.tables), "parts": self.plan.parts}

    def intact(self, parts: dict[int, PartResult]) -> dict[int, PartResult]:
        """Of recorded parts those whose files stand as they were written."""
        tables, count = self.plan.study.output.tables, self.plan.parts
        return {
            index: result
            for index, result in parts.items()
            if index < count
            and is_note(self.plan, self.plan.part(index), result.suits)
            and set(result.files) == {file_name(table, index, count) for table in tables}
            and all(stands(self.path, {"path": name, **asdict(file)}) for name, file in result.files.items())
        }

    def prepare(self, table: str) -> None:
        """Make the folder of a table's parts, where it has several; raises OutputError."""
        folder = self.path / f"{table}.parquet"
        if self.plan.parts > 1:
            try:
                if folder.is_symlink():
                    raise OutputError("is a symbolic link, which tendon does not write through", where=str(folder))
                folder.mkdir(exist_ok=True)
            except OSError as error:
                raise OutputError(f"cannot be made: {error.strerror}", where=str(folder)) from error

    def clear(self) -> bool:
        """Delete the files of the run that stands here, finished or not, and nothing else; whether there was one."""
        record, journal = read_record(self.path), Journal.read(self.path)
        figures = [*(record["figures"] if record else ()), *journal.figures]
        if record is not None:  # until the new run has its journal, this one says whose files these are
            tables = sorted({entry["path"].partition(".")[0] for entry in record["files"]})
            kept = ("study_hash", "results_version", "study", "axes", "parts")
            journal.start({**{key: record[key] for key in kept}, "tables": tables})
            if figures:
                journal.announce(figures)
        with output_errors(self.path):
            self._delete(RECORD)  # first: what is half deleted must not look finished
            for name in figures:
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
        for item in self.path.glob(f".{name}*"):
            if TEMPORARY.fullmatch(item.name):
                self._delete(item.name)

    def _delete(self, name: str) -> None:
        (self.path / name).unlink(missing_ok=True)

    def place_figures(self, names: list[str], before: list[str], journal: Journal | None) -> list[str]:
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
                (self.path / FIGURES / name).replace(self.path / name)
        return faults

    def finish(self, record: dict[str, Any]) -> None:
        """Declare the run finished: `run.json` last of all, then the journal goes.

        A lost worker of an older run may have written late: parts that this run has not are deleted; raises
        WorkersLostError where one of its own was replaced, InputError where it is no whole table any more.
        """
        sizes = {entry["path"]: entry["size"] for entry in record["files"]}
        for table in self.plan.study.output.tables if self.plan.parts > 1 else ():
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


def is_part(name: str) -> bool:
    """Whether a run gives such names to files in a folder of parts."""
    return bool(_PART.fullmatch(name) or TEMPORARY.fullmatch(name))


def free_bytes(folder: Path) -> int:
    """What is free on the disk that holds a folder, or would hold it."""
    path = folder.absolute()
    return shutil.disk_usage(next(place for place in (path, *path.parents) if place.exists())).free
