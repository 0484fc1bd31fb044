"""The record of a finished run, `run.json` or `design.json`; it counts only as tendon wrote it."""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from tendon_cli.errors import FolderError
from tendon_cli.files import read_file, write_whole
from tendon_cli.studies.study import Study
from tendon_cli.tables.digest import file_sha256
from tendon_cli.tables.read import RECORDS
from tendon_cli.version import RESULTS_VERSION

TABLES = ("designs", "states", "choices", "conditions", "persons", "draws")
_TABLE_FILE = re.compile(rf"({'|'.join(TABLES)})\.parquet(/part-\d{{5,}}\.parquet)?", re.ASCII)
FIGURE_FILE = re.compile(r"[\w-][\w.-]*\.(png|svg|pdf)")
MOST_BYTES = 2**30

_ALWAYS: dict[str, type] = {
    **dict.fromkeys(("name", "title", "study_hash"), str),
    **dict.fromkeys(("study", "versions"), dict),
    **dict.fromkeys(("files", "figures"), list),
    "results_version": int,
}
"""What every record has had since the first version."""
_COUNTS = {
    "sweep": (
        "designs",
        "states",
        "feasible",
        "slack",
        "no_equilibrium",
        "unstable",
        "parts",
        "resumed_parts",
    ),
    "design": ("choices", "conditions", "feasible"),
}
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


def read_record(folder: Path) -> dict[str, Any] | None:
    """The record of the finished run in a folder, or nothing; raises FolderError for one that tendon did not write.

    Its `verb` is the command that it is of.
    """
    records = {verb: _read_sealed(folder / name, verb) for verb, name in RECORDS.items()}
    standing = [{"verb": verb, **record} for verb, record in records.items() if record is not None]
    if len(standing) > 1:
        raise FolderError("holds the records of two runs", where=str(folder), hint=_ELSEWHERE)
    return standing[0] if standing else None


def write_record(folder: Path, record: dict[str, Any]) -> None:
    """Put a record in place, whole, with its checksum; raises OutputError."""
    record["checksum"] = checksum(record)
    content = json.dumps(record, indent=2, ensure_ascii=False) + "\n"
    write_whole(folder / RECORDS[record["verb"]], content.encode(), of_a_run=True)


def checksum(record: dict[str, Any]) -> str:
    """SHA-256 of a record without its checksum: a record that was changed is no record."""
    content = {key: value for key, value in record.items() if key != "checksum"}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


_ELSEWHERE = "choose another folder with --out, or delete this one yourself"


def _read_sealed(path: Path, verb: str) -> dict[str, Any] | None:
    try:
        record = json.loads(read_file(path, MOST_BYTES))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (ValueError, RecursionError, OSError):
        record = None
    if (
        isinstance(record, dict)
        and record.get("checksum") == checksum(record)
        and _is_sound(record, verb)
    ):
        return record
    raise FolderError(
        f"holds a {path.name} that is not as tendon wrote it",
        where=str(path.parent),
        hint=_ELSEWHERE,
    )


def _is_sound(record: dict[str, Any], verb: str) -> bool:
    """Whether everything is of its kind; anybody can compute a checksum."""
    kinds = {**_ALWAYS, **dict.fromkeys(_COUNTS[verb], int)}
    kinds |= {name: kind for name, kind in _LATER.items() if name in record}
    texts = [text for name in ("axes", "warnings", "notes") for text in record.get(name, ())]
    return (
        all(
            type(record.get(name)) is kind and (kind is not int or record[name] >= 0)
            for name, kind in kinds.items()
        )
        and record.get("verb", verb) == verb
        and type(record.get("seconds")) in (int, float)
        and math.isfinite(record["seconds"])
        and all(isinstance(text, str) for text in texts)
        and all(isinstance(name, str) and FIGURE_FILE.fullmatch(name) for name in record["figures"])
        and all(isinstance(entry, dict) and _is_file(entry) for entry in record["files"])
    )


def _is_file(entry: Mapping[str, Any]) -> bool:
    path, digest = entry.get("path"), entry.get("sha256")
    is_table = isinstance(path, str) and _TABLE_FILE.fullmatch(path) is not None
    return (
        is_table
        and isinstance(digest, str)
        and is_count(entry.get("size"))
        and is_count(entry.get("rows", 0))
    )


def is_count(value: Any) -> bool:
    """Whether a value read from JSON is a count."""
    return type(value) is int and value >= 0


def stands(folder: Path, entry: Mapping[str, Any]) -> bool:
    """Whether a file of a run has the bytes that were recorded."""
    path = folder / entry["path"]
    try:
        return (
            not path.is_symlink()
            and path.stat().st_size == entry["size"]
            and file_sha256(path) == entry["sha256"]
        )
    except OSError:
        return False


def lost(folder: Path, record: Mapping[str, Any]) -> Iterator[str]:
    """Files of a record that do not stand as they were written."""
    return (entry["path"] for entry in record["files"] if not stands(folder, entry))


def difference(standing: Mapping[str, Any], verb: str, study: Study) -> str | None:
    """In what a recorded run differs from one of a study; nothing if it is the same."""
    if (version := standing.get("results_version")) != RESULTS_VERSION:
        return f"results version {version}, this tendon gives {RESULTS_VERSION}"
    if (other := standing.get("verb", "sweep")) != verb:
        return f"it is of `tendon {other}`, not of `tendon {verb}`"
    if standing.get("study_hash") == study.hash:
        return None
    return (
        "; ".join(differences(standing.get("study") or {}, study.document())[:4])
        or "the order of the axes"
    )


def differences(theirs: Any, ours: Any, key: str = "") -> list[str]:
    """Keys in which two resolved studies differ, each with both values."""
    if isinstance(theirs, dict) and isinstance(ours, dict):
        names = dict.fromkeys((*theirs, *ours))
        return [
            line
            for name in names
            for line in differences(
                theirs.get(name), ours.get(name), f"{key}.{name}" if key else name
            )
        ]
    if theirs == ours:
        return []
    was, now = (_in_short(value) for value in (theirs, ours))
    return [f"{key} was {was}, now {now}"]


def _in_short(value: Any) -> str:
    """A value of a study for a message, without the content of files."""
    if value is None:
        return "not stated"
    if isinstance(value, dict):
        return f"{{{', '.join(value)}}}"
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 60 else f"{text[:57]}..."
