"""Whose a folder is: what may be written there, gone on with or replaced, decided without leaving a trace in it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tendon_cli.engine.folder import RunFolder, is_ours, is_part
from tendon_cli.engine.journal import JOURNAL, Journal
from tendon_cli.engine.records import TABLES, difference, read_record
from tendon_cli.errors import FolderError, UsageError
from tendon_cli.files import OF_A_RUN
from tendon_cli.tables.read import study_hash_of

_ELSEWHERE = "choose another folder with --out"


def check_folder(folder: RunFolder, *, resume: bool, overwrite: bool) -> None:
    """Refuse, without a trace in the folder, what may not be written here; raises FolderError."""
    _check_place(folder.path)
    if not folder.path.exists():
        return
    if not folder.path.is_dir():
        raise FolderError("is a file, expected a folder for the run", where=str(folder.path))
    record, journal = read_record(folder.path), Journal.read(folder.path)
    if record is None and not journal.header:
        _check_not_foreign(folder, journal)
    elif overwrite:
        _check_replaceable(folder, record or journal.header)
    elif record is not None:
        _check_same(folder, record)
    else:
        _check_same(folder, journal.header)
        if any(journal.header.get(name) != value for name, value in folder.header().items()):
            raise FolderError("holds a journal that is not as tendon wrote it", where=str(folder.path), hint=_ELSEWHERE)
        if not resume:
            done = f"{len(journal.parts)} of {folder.task.parts} parts are done"
            hint = "--resume finishes it (in Python resume=True), --overwrite starts anew"
            raise FolderError(f"holds an unfinished run of this study, {done}", where=str(folder.path), hint=hint)


def _check_same(folder: RunFolder, standing: dict[str, Any]) -> None:
    """Raises FolderError, naming what differs, where the folder holds another study or other results."""
    if (differs := difference(standing, folder.task.verb, folder.task.study)) is not None:
        hint = "--overwrite replaces it, --out writes elsewhere"
        raise FolderError(f"holds a run of another study: {differs}", where=str(folder.path), hint=hint)


def _check_not_foreign(folder: RunFolder, journal: Journal) -> None:
    """Raises FolderError unless the folder is empty, or holds what can only be the beginning of this very run."""
    foreign = sorted(item.name for item in folder.path.iterdir() if not is_ours(item.name))
    if journal.path.exists():
        if not (journal.parts or journal.is_beginning_of(folder.header())):
            foreign = [JOURNAL]
        else:
            foreign = [name for name in foreign if not _is_of_this_study(folder, name)]
    if foreign:
        message = f"is not a run folder, it holds {foreign[0]}"
        if foreign == [JOURNAL]:
            message = "holds a journal that is not as tendon wrote it"
        raise FolderError(message, where=str(folder.path), hint=_ELSEWHERE)


def _is_of_this_study(folder: RunFolder, name: str) -> bool:
    """Whether a file, or a folder of parts, is a table that this study gives, or was about to become one."""
    path = folder.path / name
    if path.is_symlink() or name not in {f"{table}.parquet" for table in TABLES}:
        return False
    files = [path] if path.is_file() else [file for file in path.iterdir() if not OF_A_RUN.fullmatch(file.name)]
    return all(study_hash_of(file) == folder.task.study.hash for file in files)


def _check_replaceable(folder: RunFolder, standing: dict[str, Any]) -> None:
    """Raises FolderError if another's file is in the way of the run that is to replace the one standing there."""
    listed = {path.partition(".")[0] for path in (entry["path"] for entry in standing.get("files", ()))}
    listed |= set(standing.get("tables", ()))
    for table in TABLES:
        path, wanted = folder.path / f"{table}.parquet", table in folder.task.tables
        if path.is_symlink() or (wanted and path.exists() and table not in listed):
            raise FolderError(f"holds {path.name}, which no run wrote", where=str(folder.path), hint=_ELSEWHERE)
        if not path.is_dir() or table not in listed:
            continue
        others = [item.name for item in path.iterdir() if not is_part(item.name)]
        if not (wanted and folder.task.tables[table] > 1):
            in_the_way = others
        else:
            in_the_way = [name for name in others if name.startswith("part-") and name.endswith(".parquet")]
        if in_the_way:
            hint = "move it away, or choose another folder with --out"
            raise FolderError(
                f"holds {path.name}/{in_the_way[0]}, which no run wrote", where=str(folder.path), hint=hint
            )


def _check_place(folder: Path) -> None:
    """Raises UsageError for a folder that no table could be written to, whatever it holds."""
    try:
        str(folder.absolute()).encode()
    except FileNotFoundError:
        hint = "change to one that exists, or name a folder by its whole path"
        raise UsageError("the working directory does not exist any more", hint=hint) from None
    except UnicodeEncodeError:
        raise UsageError("the folder's name is not UTF-8, which tables cannot have", where=str(folder)) from None
