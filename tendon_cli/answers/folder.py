"""The folder of an answer: made beside its place and put there whole, or not at all."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tendon_cli.answers.problem import Problem
from tendon_cli.engine.record import checksum, difference, lost, read_sealed
from tendon_cli.errors import FolderError, InputError
from tendon_cli.files import open_file, output_errors, sync_folder, write_whole

RECORD = "design.json"
_MARK = ".tendon-making"
"""In a folder that is being made: says whose it is, and is locked as long as its maker lives, however he dies."""
_OURS = re.compile(r"(choices|conditions)\.parquet(/part-\d+\.parquet)?|[\w-]+\.png")
_IN_THE_MAKING = re.compile(rf"({_OURS.pattern}|choices\.parquet|{re.escape(RECORD)}|(choices\.parquet/)?\.[\w.-]+)")


def standing(folder: Path, problem: Problem, *, overwrite: bool) -> dict[str, Any] | None:
    """The record of this very answer where it stands, every file as it was written; nothing where the place is free.

    Raises FolderError where something else is there, unless an answer is there that is to be replaced.
    """
    record = read_sealed(folder / RECORD)
    if record is None:
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            hint = "choose another folder with --out"
            raise FolderError("is not the folder of an answer", where=str(folder), hint=hint)
        return None
    if overwrite:
        return None
    hint = "--overwrite replaces it, --out writes elsewhere"
    if (differs := difference(record, problem.study)) is not None:
        raise FolderError(f"holds the answer to another study: {differs}", where=str(folder), hint=hint)
    for name in lost(folder, record):
        raise FolderError(f"{name} is missing or damaged", where=str(folder), hint=hint)
    return record


def open_answer(folder: Path) -> dict[str, Any] | None:
    """The record of the answer in a folder, every file as it was written; nothing where no answer is.

    Raises FolderError for a record that tendon did not write, InputError for a file that is missing or changed.
    """
    record = read_sealed(folder / RECORD)
    for name in lost(folder, record) if record is not None else ():
        hint = "`tendon design --overwrite` writes it anew"
        raise InputError("is missing, or not as it was written", where=str(folder / name), hint=hint)
    return record


@contextlib.contextmanager
def made_whole(folder: Path) -> Iterator[Path]:
    """A folder to write into, which becomes `folder` when all is well, and leaves nothing behind else.

    What an earlier one left that was killed goes first. Raises OutputError.
    """
    with output_errors(folder):
        folder.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.suppress(OSError):  # a parent that may be written to and not be read
            _remove_left(folder)
        making = folder.with_name(f".{folder.name}.{os.urandom(6).hex()}.tmp")  # nobody else's
        making.mkdir()
    try:
        with _marked(making):
            yield making
            _put_in_place(making, folder)
    finally:
        shutil.rmtree(making, ignore_errors=True)


@contextlib.contextmanager
def _marked(making: Path) -> Iterator[None]:
    """Mark a folder as being made, until this ends."""
    with output_errors(making):
        mark = (making / _MARK).open("xb")
    with mark:
        with contextlib.suppress(OSError):  # a file system that cannot lock: what is left there stays
            fcntl.flock(mark, fcntl.LOCK_EX)
        yield


def _remove_left(folder: Path) -> None:
    """Remove folders that were being made into this one, marked as such, when whoever made them was killed."""
    name = re.compile(rf"\.{re.escape(folder.name)}\.[0-9a-f]{{12}}\.tmp")
    for left in folder.parent.iterdir():
        if not name.fullmatch(left.name) or left.is_symlink() or not left.is_dir():
            continue
        with contextlib.suppress(OSError), open_file(left / _MARK) as mark:
            fcntl.flock(mark, fcntl.LOCK_EX | fcntl.LOCK_NB)
            inside = [str(path.relative_to(left)) for path in left.rglob("*")]
            if all(_IN_THE_MAKING.fullmatch(each) for each in inside):
                shutil.rmtree(left)


def write_record(making: Path, record: dict[str, Any]) -> None:
    """Write the record of an answer, last of its files."""
    record["checksum"] = checksum(record)
    write_whole(making / RECORD, (json.dumps(record, indent=2, ensure_ascii=False) + "\n").encode())


def _put_in_place(making: Path, folder: Path) -> None:
    """By its name where that is free; else the files of the answer that stands there go first, and nothing else."""
    old = read_sealed(folder / RECORD)
    with output_errors(folder):
        if old is None:
            making.replace(folder)  # also over an empty folder, never over another
            (folder / _MARK).unlink()
        else:
            (folder / RECORD).unlink()  # first: what is half deleted must not seem finished
            for name in (*(entry["path"] for entry in old["files"]), *old["figures"]):
                path = folder / name
                if _OURS.fullmatch(name) and not path.parent.is_symlink():
                    path.unlink(missing_ok=True)
            with contextlib.suppress(OSError):
                (folder / "choices.parquet").rmdir()
            (making / _MARK).unlink()
            for item in sorted(making.iterdir(), key=lambda item: item.name == RECORD):
                item.replace(folder / item.name)
        sync_folder(folder.parent)
