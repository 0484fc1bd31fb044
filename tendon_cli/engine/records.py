"""The record of a finished run, `run.json` or `design.json`; one that was changed is refused."""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from tendon_cli.engine.study_differences import study_differences
from tendon_cli.errors import FolderError
from tendon_cli.files import read_file, write_whole
from tendon_cli.studies.study import Study
from tendon_cli.tables.digest import file_sha256
from tendon_cli.verbs.registry import TaskKind, kind_of, kinds, load, tables_in_folders
from tendon_cli.version import RESULTS_VERSION, reader_of

FIGURE_FILE = re.compile(r"[\w-][\w.-]*\.(png|svg|pdf)")
"""Names of figures."""
MOST_BYTES = 2**30
"""Largest record that is read."""

_TABLE_FILE = re.compile(r"(\w+)\.parquet(/part-\d{5,}\.parquet)?", re.ASCII)
_ELSEWHERE = "choose another folder with --out, or delete this one yourself"

_ALWAYS: dict[str, type] = {
    **dict.fromkeys(("name", "title", "study_hash"), str),
    **dict.fromkeys(("study", "versions"), dict),
    **dict.fromkeys(("files", "figures"), list),
    "results_version": int,
}
"""Types of the entries that every record has had since the first version."""
_LATER: dict[str, type] = {
    "sources": dict,
    "axes": list,
    "warnings": list,
    "notes": list,
    "text": str,
    **dict.fromkeys(
        ("taut", "stable", "choices", "feasible_choices", "parts", "resumed_parts"), int
    ),
}
"""Types of the entries that only later versions write."""


def read_record(folder: Path) -> dict[str, Any] | None:
    """Return the record of the finished run in a folder; None if there is none.

    Its `verb` is the command that wrote it.

    Raises:
        FolderError: A record is not as tendon wrote it, or there are two.
    """
    found = []
    for kind in kinds().values():
        record = _read_sealed(folder / kind.record, kind)
        if record is not None:
            found.append({"verb": kind.verb, **record})
    if len(found) > 1:
        raise FolderError("contains the records of two runs", where=str(folder), hint=_ELSEWHERE)
    return found[0] if found else None


_MOST_INDENTED = 2**20
"""Characters of the longest record that is laid out for people; a longer one holds many rows."""


def write_record(folder: Path, record: dict[str, Any]) -> None:
    """Write a record with its checksum, whole or not at all; raises OutputError."""
    record["checksum"] = checksum(record)
    content = json.dumps(record, ensure_ascii=False)
    if len(content) <= _MOST_INDENTED:
        content = json.dumps(record, indent=2, ensure_ascii=False)
    content += "\n"
    write_whole(folder / kind_of(record).record, content.encode(), of_a_run=True)


def checksum(record: dict[str, Any]) -> str:
    """Return the SHA-256 of a record without its checksum, by which a change is noticed."""
    content = {key: value for key, value in record.items() if key != "checksum"}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _read_sealed(path: Path, kind: TaskKind) -> dict[str, Any] | None:
    """Return a record as tendon wrote it, None if there is no file; raises FolderError."""
    try:
        record = json.loads(read_file(path, MOST_BYTES))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (ValueError, RecursionError, OSError):
        record = None
    if isinstance(record, dict):
        is_as_written = record.get("checksum") == checksum(record)
        if is_as_written and _is_sound(record, kind):
            return record
    raise FolderError(
        f"holds a {path.name} that is not as tendon wrote it",
        where=str(path.parent),
        hint=_ELSEWHERE,
    )


def _is_sound(record: dict[str, Any], kind: TaskKind) -> bool:
    """Return True if every entry has its type, which a right checksum does not prove."""
    expected = {**_ALWAYS, **dict.fromkeys(kind.counts, int)}
    expected |= {name: later for name, later in _LATER.items() if name in record}
    for name, expected_type in expected.items():
        value = record.get(name)
        if type(value) is not expected_type:
            return False
        if expected_type is int and not is_count(value):
            return False
    if record.get("verb", kind.verb) != kind.verb:
        return False
    if type(record.get("seconds")) not in (int, float) or not math.isfinite(record["seconds"]):
        return False
    if kind.reads and record["results_version"] == RESULTS_VERSION:
        try:
            load(kind.reads)(record)
        except ValueError:
            return False
    texts = [text for name in ("axes", "warnings", "notes") for text in record.get(name, ())]
    return (
        all(isinstance(text, str) for text in texts)
        and all(isinstance(name, str) and FIGURE_FILE.fullmatch(name) for name in record["figures"])
        and all(isinstance(entry, dict) and _is_file(entry) for entry in record["files"])
    )


def _is_file(entry: Mapping[str, Any]) -> bool:
    """Return True if an entry of a record describes a file of a table."""
    path = entry.get("path")
    return (
        isinstance(path, str)
        and is_table_file(path)
        and isinstance(entry.get("sha256"), str)
        and is_count(entry.get("size"))
        and is_count(entry.get("rows", 0))
    )


def is_table_file(name: str) -> bool:
    """Return True if a run gives this name to a file of a table in its folder."""
    named = _TABLE_FILE.fullmatch(name)
    return named is not None and named[1] in tables_in_folders()


def is_count(value: Any) -> bool:
    """Return True if a value read from JSON is a count."""
    return type(value) is int and value >= 0


def is_intact(folder: Path, entry: Mapping[str, Any]) -> bool:
    """Return True if a file of a run has the bytes that were recorded."""
    path = folder / entry["path"]
    try:
        return (
            not path.is_symlink()
            and path.stat().st_size == entry["size"]
            and file_sha256(path) == entry["sha256"]
        )
    except OSError:
        return False


def damaged_files(folder: Path, record: Mapping[str, Any]) -> Iterator[str]:
    """Yield the paths of the files of a run that are missing or not as they were written."""
    return (entry["path"] for entry in record["files"] if not is_intact(folder, entry))


def difference(recorded: Mapping[str, Any], verb: str, study: Study) -> str | None:
    """Say how a recorded run differs from one of a study; None if it does not.

    Args:
        recorded: A record, or what the tables of an unfinished run say.
        verb: The command that is to be run.
        study: Its study.
    """
    version = recorded.get("results_version")
    if version != RESULTS_VERSION:
        return (
            f"results version {version}, which {reader_of(version)} reads; "
            f"this tendon gives {RESULTS_VERSION}"
        )
    other = recorded.get("verb", "sweep")
    if other != verb:
        return f"`tendon {other}` wrote it, not `tendon {verb}`"
    if recorded.get("study_hash") == study.hash:
        return None
    ours = {"study": study.document(), "sources": study.sources}
    lines = [
        f"{found.key} was {found.shown[0]}, now {found.shown[1]}"
        for found in study_differences(recorded, ours)
    ]
    return "; ".join(lines[:4]) or "the order of the axes, or how they are spelled"
