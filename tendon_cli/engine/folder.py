"""The folder of a run: whose it is, who may write to it, what it holds, and what of that may be replaced."""

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
from tendon_cli.engine.records import TABLES, difference, read_record, stands, write_record
from tendon_cli.engine.task import PartResult, Task
from tendon_cli.errors import FolderError, InputError, OutputError, SizeError, WorkersLostError
from tendon_cli.files import LOCK, OF_A_RUN, output_errors
from tendon_cli.tables.read import RECORDS, study_hash_of

OURS = (*RECORDS.values(), JOURNAL, LOCK)
_PART = re.compile(r"part-(\d{5,})\.parquet", re.ASCII)
_READ_AS_PART = re.compile(r"part-.*\.parquet")
_FIGURES = re.compile(r"\.tendon-figures-[0-9a-f]{12}", re.ASCII)
"""Where figures lie until all are drawn."""
_ELSEWHERE = "choose another folder with --out"
_NO_JOURNAL = "holds a journal that is not as tendon wrote it"


@dataclass(frozen=True)
class RunFolder:
    """A run folder and the task that is to stand in it."""

    path: Path
    task: Task

    def check(self, *, resume: bool, overwrite: bool) -> None:
        """Refuse, without a trace, what may not be written here, replaced or gone on with; raises FolderError."""
        if not self.path.exists():
            return
        if not self.path.is_dir():
            raise self._refusal("is a file, expected a folder for the run")
        record, journal = read_record(self.path), Journal.read(self.path)
        standing = record or journal.header
        if not standing:
            self._check_not_foreign(journal)
        elif overwrite:
            self._check_replaceable(standing)
        elif (differs := difference(standing, self.task.verb, self.task.study)) is not None:
            hint = "--overwrite replaces it, --out writes elsewhere"
            raise self._refusal(f"holds a run of another study: {differs}", hint)
        elif record is None and not self.header().items() <= standing.items():
            raise self._refusal(_NO_JOURNAL, _ELSEWHERE)
        elif record is None and not resume:
            done = f"{len(journal.parts)} of {self.task.parts} parts are done"
            hint = "--resume finishes it (in Python resume=True), --overwrite starts anew"
            raise self._refusal(f"holds an unfinished run of this study, {done}", hint)

    def _check_not_foreign(self, journal: Journal) -> None:
        """Raises FolderError unless the folder is empty, or holds what can only be the beginning of this very run."""
        foreign = sorted(item.name for item in self.path.iterdir() if not _is_ours(item.name))
        if journal.path.exists():
            if not (journal.parts or journal.is_beginning_of(self.header())):
                raise self._refusal(_NO_JOURNAL, _ELSEWHERE)
            foreign = [name for name in foreign if not self._is_of_this_study(name)]
        if foreign:
            raise self._refusal(f"is not a run folder, it holds {foreign[0]}", _ELSEWHERE)

    def _is_of_this_study(self, name: str) -> bool:
        """Whether a file, or a folder of parts, is a table that this study gives, or was about to become one."""
        path = self.path / name
        if path.is_symlink() or name not in {f"{table}.parquet" for table in TABLES}:
            return False
        files = (
            [path]
            if path.is_file()
            else [file for file in path.iterdir() if not OF_A_RUN.fullmatch(file.name)]
        )
        return all(study_hash_of(file) == self.task.study.hash for file in files)

    def _check_replaceable(self, standing: dict[str, Any]) -> None:
        """Raises FolderError if another's file is in the way of the run that is to replace the one standing there."""
        listed = {entry["path"].partition(".")[0] for entry in standing.get("files", ())} | {
            *standing.get("tables", ())
        }
        for table in TABLES:
            path, parts = self.path / f"{table}.parquet", self.task.tables.get(table)
            is_strangers = path.is_symlink() or (
                parts is not None and path.exists() and table not in listed
            )
            in_the_way = [path.name] if is_strangers else []
            if path.is_dir() and table in listed:
                others = [item.name for item in path.iterdir() if not _is_part(item.name)]
                may_stay = parts is not None and parts > 1  # but for what readers take for a part
                in_the_way += [
                    f"{path.name}/{name}"
                    for name in others
                    if not may_stay or _READ_AS_PART.fullmatch(name)
                ]
            if in_the_way:
                hint = "move it away, or choose another folder with --out"
                raise self._refusal(f"holds {in_the_way[0]}, which no run wrote", hint)

    def _refusal(self, message: str, hint: str | None = None) -> FolderError:
        return FolderError(message, where=str(self.path), hint=hint)

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
                name: next(
                    (
                        each
                        for each in (file, journal.last.get(name))
                        if each and self._stands(name, each)
                    ),
                    None,
                )
                for name, file in part.files.items()
            }
            if set(files) == set(self.task.files(index).values()) and None not in files.values():
                kept[index] = replace(
                    part, files={name: file for name, file in files.items() if file}
                )
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
                    raise OutputError(
                        "is a symbolic link, which tendon does not write through", where=str(folder)
                    )
                folder.mkdir(exist_ok=True)
            except OSError as error:
                raise OutputError(f"cannot be made: {error.strerror}", where=str(folder)) from error

    def clear(self) -> bool:
        """Delete the files of the run that stands here, finished or not, and nothing else; whether there was one."""
        record, journal = read_record(self.path), Journal.read(self.path)
        if (
            record is not None
        ):  # until the new run has its journal, this one says whose files these are
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
                if _is_part(item.name):
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

    def place_figures(
        self, place: Path, names: list[str], before: list[str], journal: Journal | None
    ) -> list[str]:
        """Put drawn figures in place of those `before`; returns what is wrong with those that are left out."""
        faults = []
        for name in list(names):
            if name not in before and os.path.lexists(self.path / name):
                names.remove(name)
                faults.append(
                    f"{name} is not drawn: a file of that name stands there, which no run wrote"
                )
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
                if _is_part(item.name) and f"{table}.parquet/{item.name}" not in sizes:
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


def _is_ours(name: str) -> bool:
    """Whether a run gives such names to files in its folder besides tables and figures."""
    return name in OURS or bool(OF_A_RUN.fullmatch(name) or _FIGURES.fullmatch(name))


def _is_part(name: str) -> bool:
    """Whether a run gives such names to files in a folder of parts."""
    return bool(_PART.fullmatch(name) or OF_A_RUN.fullmatch(name))


def free_bytes(folder: Path) -> int:
    """What is free on the disk that holds a folder, or would hold it."""
    path = folder.absolute()
    return shutil.disk_usage(next(place for place in (path, *path.parents) if place.exists())).free
