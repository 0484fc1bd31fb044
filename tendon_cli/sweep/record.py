"""The record of a finished run, `run.json`: read only as tendon wrote it."""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tendon_cli.errors import FolderError
from tendon_cli.files import read_file, write_whole
from tendon_cli.tables.digest import file_sha256

RECORD = "run.json"
TABLE_FILE = re.compile(r"(designs|states)\.parquet(/part-\d{5,}\.parquet)?", re.ASCII)
FIGURE_FILE = re.compile(r"[\w-][\w.-]*\.(png|svg|pdf)")
_MOST_BYTES = 2**29

_COUNTS = ("designs", "states", "feasible", "slack", "no_equilibrium", "unstable", "parts", "resumed_parts")
_KINDS: dict[str, type] = {
    **dict.fromkeys(("name", "title", "study_hash"), str),
    **dict.fromkeys(("study", "sources", "versions"), dict),
    **dict.fromkeys(("axes", "files", "figures", "warnings"), list),
    "results_version": int,
}
"""What every record has had since the first version."""


def read_record(folder: Path) -> dict[str, Any] | None:
    """The record of the finished run in a folder, or nothing; raises FolderError for one that tendon did not write."""
    try:
        record = json.loads(read_file(folder / RECORD, _MOST_BYTES))
    except FileNotFoundError:
        return None
    except (ValueError, RecursionError, OSError):
        record = None
    if isinstance(record, dict) and record.get("checksum") == checksum(record) and _is_sound(record):
        return record
    hint = "choose another folder with --out, or delete this one yourself"
    raise FolderError("holds a run.json that is not as tendon wrote it", where=str(folder), hint=hint)


def write_record(folder: Path, record: dict[str, Any]) -> None:
    """Put the record in place, whole; raises OutputError."""
    record["checksum"] = checksum(record)
    write_whole(folder / RECORD, (json.dumps(record, indent=2) + "\n").encode())


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


def _is_sound(record: dict[str, Any]) -> bool:
    """Whether everything is of its kind; anybody can compute a checksum."""
    return (
        all(type(record.get(name)) is kind for name, kind in _KINDS.items())
        and all(is_count(record.get(name)) for name in _COUNTS)
        and all(is_count(record[name]) for name in ("taut", "stable", "suits", "feasible_suits") if name in record)
        and type(record.get("seconds")) in (int, float)
        and math.isfinite(record["seconds"])
        and all(isinstance(text, str) for name in ("axes", "warnings") for text in record[name])
        and all(isinstance(name, str) and FIGURE_FILE.fullmatch(name) for name in record["figures"])
        and all(_is_file(entry) for entry in record["files"])
    )


def _is_file(entry: Any) -> bool:
    return (
        isinstance(entry, dict)
        and isinstance(entry.get("path"), str)
        and TABLE_FILE.fullmatch(entry["path"]) is not None
        and is_count(entry.get("size"))
        and is_count(entry.get("rows"))
        and isinstance(entry.get("sha256"), str)
    )


def is_count(value: Any) -> bool:
    """Whether a value is a number of things."""
    return type(value) is int and value >= 0


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
