"""The folder of a run: who may write to it, what it holds, and what of that can be trusted."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import hashlib
import json
import os
import re
import shutil
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tendon_cli.errors import FolderError, OutputError, SizeError
from tendon_cli.files import output_errors, temporary_of, write_whole
from tendon_cli.sweep.journal import NAME as JOURNAL
from tendon_cli.sweep.journal import Journal
from tendon_cli.sweep.part import PartResult, file_name
from tendon_cli.sweep.plan import Plan
from tendon_cli.tables.digest import file_sha256
from tendon_cli.version import RESULTS_VERSION

RECORD = "run.json"
LOCK = ".lock"
_OURS = (RECORD, JOURNAL, LOCK, f".{RECORD}.tmp", f".{JOURNAL}.tmp")
_LEAST_BYTES_PER_STATE = 20
_LEAST_BYTES_PER_DESIGN = 10
_RUN_FILE = re.compile(r"(designs|states)\.parquet(/part-\d+\.parquet)?|[\w.-]+\.(png|svg|pdf)")


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
            handle = os.open(self.path / LOCK, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
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

    def _lock(self, handle: int) -> None:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
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
        return {"study_hash": study.hash, "results_version": RESULTS_VERSION, **study.record()}

    def finished(self) -> dict[str, Any] | None:
        """The record of a finished run, or nothing; raises FolderError for one that is not as tendon wrote it."""
        return read_record(self.path)

    def check_same(self, found: dict[str, Any]) -> None:
        """Raises FolderError, naming what differs, where the folder holds another study or other results."""
        ours = self.identity()
        if found.get("results_version") != ours["results_version"]:
            differs = f"results version {found.get('results_version')}, this tendon gives {ours['results_version']}"
        elif found.get("study_hash") != ours["study_hash"]:
            differs = "; ".join(differences(found.get("study") or {}, ours["study"])[:4]) or "the order of the axes"
        else:
            return
        hint = "--overwrite replaces it, --out writes elsewhere"
        raise FolderError(f"holds a run of another study: {differs}", where=str(self.path), hint=hint)

    def check_empty(self) -> None:
        """Raises FolderError where the folder holds anything that is not a run's."""
        foreign = sorted(item.name for item in self.path.iterdir() if item.name not in _OURS)
        if foreign:
            hint = "choose another folder with --out"
            raise FolderError(f"is not a run folder, it holds {foreign[0]}", where=str(self.path), hint=hint)

    def intact(self, parts: dict[int, PartResult]) -> dict[int, PartResult]:
        """Of recorded parts those whose files stand as they were written."""
        tables, count = self.plan.study.output.tables, self.plan.parts
        return {
            index: result
            for index, result in parts.items()
            if index < count
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
        record, journal = self.finished(), Journal.read(self.path / JOURNAL)
        if record is not None:  # until the new run has its journal, this one says whose files these are
            tables = sorted({entry["path"].partition(".")[0] for entry in record["files"]})
            kept = ("study_hash", "results_version", "study", "axes", "parts")
            journal.start({**{key: record[key] for key in kept}, "tables": tables})
        names = [*(entry["path"] for entry in record["files"]), *record["figures"]] if record else []
        for table in journal.header.get("tables", ()):
            parts = journal.header["parts"]
            names += [file_name(table, index, parts) for index in range(parts)]
        with output_errors(self.path):
            (self.path / RECORD).unlink(missing_ok=True)  # first: what is half deleted must not look finished
            for name in dict.fromkeys(names):
                self._delete(name)
            for table in ("designs", "states"):
                with contextlib.suppress(OSError):
                    (self.path / f"{table}.parquet").rmdir()
        return journal.path.exists()

    def _delete(self, name: str) -> None:
        """Delete a file that a run writes, and its temporary twin; names that no run of ours has are left alone."""
        path = self.path / name
        if _RUN_FILE.fullmatch(name) and not path.parent.is_symlink():
            path.unlink(missing_ok=True)
            temporary_of(path).unlink(missing_ok=True)

    def write_record(self, record: dict[str, Any]) -> None:
        """Declare the run finished: `run.json` last of all, then the journal goes."""
        record["checksum"] = checksum(record)
        write_whole(self.path / RECORD, (json.dumps(record, indent=2) + "\n").encode())
        with contextlib.suppress(OSError):
            (self.path / JOURNAL).unlink(missing_ok=True)


def free_bytes(folder: Path) -> int:
    """What is free on the disk that holds a folder, or would hold it."""
    path = folder.absolute()
    return shutil.disk_usage(next(place for place in (path, *path.parents) if place.exists())).free


def read_record(folder: Path) -> dict[str, Any] | None:
    """The record of the finished run in a folder, or nothing; raises FolderError for one that tendon did not write."""
    try:
        record = json.loads((folder / RECORD).read_bytes())
    except FileNotFoundError:
        return None
    except (ValueError, RecursionError, OSError):
        record = None
    if isinstance(record, dict) and record.get("checksum") == checksum(record):
        return record
    hint = "choose another folder with --out, or delete this one yourself"
    raise FolderError("holds a run.json that is not as tendon wrote it", where=str(folder), hint=hint)


def is_begun(folder: Path) -> bool:
    """Whether an unfinished run stands in a folder."""
    return (folder / JOURNAL).is_file()


def stands(folder: Path, entry: Mapping[str, Any]) -> bool:
    """Whether a file of a run has the bytes that were recorded."""
    path = folder / entry["path"]
    try:
        return not path.is_symlink() and path.stat().st_size == entry["size"] and file_sha256(path) == entry["sha256"]
    except OSError:
        return False


def checksum(record: dict[str, Any]) -> str:
    """SHA-256 of a record without its checksum: a record that was changed is no record."""
    content = {key: value for key, value in record.items() if key != "checksum"}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def differences(theirs: Any, ours: Any, key: str = "") -> list[str]:
    """Keys in which two resolved studies differ, each with both values."""
    if isinstance(theirs, dict) and isinstance(ours, dict):
        names = dict.fromkeys((*theirs, *ours))
        return [
            line
            for name in names
            for line in differences(theirs.get(name), ours.get(name), f"{key}.{name}" if key else name)
        ]
    if theirs == ours:
        return []
    shown = [json.dumps(value)[:60] for value in (theirs, ours)]
    return [f"{key} was {shown[0]}, now {shown[1]}"]
