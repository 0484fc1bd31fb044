"""What says which run stands in a folder: `run.json` of a finished one, the journal of one that is not.

Both count only as tendon wrote them. A journal has a line per finished part, each with its own checksum. It may be cut
off anywhere: whole lines count, the rest is dropped, and whoever goes on writing first removes it.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
import re
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from tendon_cli.engine.design_rows import Totals
from tendon_cli.engine.part import PartResult
from tendon_cli.errors import FolderError
from tendon_cli.files import output_errors, read_file, write_locked
from tendon_cli.studies.study import Study
from tendon_cli.tables.digest import file_sha256
from tendon_cli.tables.write import WrittenFile
from tendon_cli.version import RESULTS_VERSION

RECORD, JOURNAL = "run.json", "journal.jsonl"
TABLES = ("designs", "states")
_TABLE_FILE = re.compile(r"(designs|states)\.parquet(/part-\d{5,}\.parquet)?", re.ASCII)
_FIGURE_FILE = re.compile(r"[\w-][\w.-]*\.(png|svg|pdf)")
_MOST_BYTES = 2**30
_MOST_PARTS = 10**8
"""Of half a million states each: no disk holds more."""

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
    return read_sealed(folder / RECORD, _is_sound)


def write_record(folder: Path, record: dict[str, Any]) -> None:
    """Put the record in place, whole; raises OutputError."""
    record["checksum"] = checksum(record)
    write_locked(folder / RECORD, (json.dumps(record, indent=2) + "\n").encode())


def read_sealed(path: Path, is_sound: Callable[[dict[str, Any]], bool] = bool) -> dict[str, Any] | None:
    """A record that holds its own checksum, or nothing; raises FolderError for one that tendon did not write."""
    try:
        record = json.loads(read_file(path, _MOST_BYTES))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (ValueError, RecursionError, OSError):
        record = None
    if isinstance(record, dict) and record.get("checksum") == checksum(record) and is_sound(record):
        return record
    hint = "choose another folder with --out, or delete this one yourself"
    raise FolderError(f"holds a {path.name} that is not as tendon wrote it", where=str(path.parent), hint=hint)


def checksum(record: dict[str, Any]) -> str:
    """SHA-256 of a record without its checksum: a record that was changed is no record."""
    content = {key: value for key, value in record.items() if key != "checksum"}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def stands(folder: Path, entry: Mapping[str, Any]) -> bool:
    """Whether a file of a run has the bytes that were recorded."""
    path = folder / entry["path"]
    try:
        return not path.is_symlink() and path.stat().st_size == entry["size"] and file_sha256(path) == entry["sha256"]
    except OSError:
        return False


def lost(folder: Path, record: Mapping[str, Any]) -> Iterator[str]:
    """Files of a record that do not stand as they were written."""
    return (entry["path"] for entry in record["files"] if not stands(folder, entry))


def _is_sound(record: dict[str, Any]) -> bool:
    """Whether everything is of its kind; anybody can compute a checksum."""
    return (
        all(type(record.get(name)) is kind for name, kind in _KINDS.items())
        and all(_is_count(record.get(name)) for name in _COUNTS)
        and all(_is_count(record[name]) for name in ("taut", "stable", "suits", "feasible_suits") if name in record)
        and type(record.get("seconds")) in (int, float)
        and math.isfinite(record["seconds"])
        and all(isinstance(text, str) for name in ("axes", "warnings") for text in record[name])
        and all(isinstance(name, str) and _FIGURE_FILE.fullmatch(name) for name in record["figures"])
        and all(_is_file(entry) for entry in record["files"])
    )


def _is_file(entry: Any) -> bool:
    return (
        isinstance(entry, dict)
        and isinstance(entry.get("path"), str)
        and _TABLE_FILE.fullmatch(entry["path"]) is not None
        and _is_count(entry.get("size"))
        and _is_count(entry.get("rows"))
        and isinstance(entry.get("sha256"), str)
    )


def _is_count(value: Any) -> bool:
    return type(value) is int and value >= 0


def difference(found: Mapping[str, Any], study: Study) -> str | None:
    """In what a recorded run differs from one of a study; nothing where it is the same."""
    if (version := found.get("results_version")) != RESULTS_VERSION:
        return f"results version {version}, this tendon gives {RESULTS_VERSION}"
    if found.get("study_hash") == study.hash:
        return None
    return "; ".join(differences(found.get("study") or {}, study.document())[:4]) or "the order of the axes"


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


@dataclass
class Journal:
    """What is known of an unfinished run: what it is a run of, and the parts that are done."""

    path: Path
    header: dict[str, Any] = field(default_factory=dict)
    parts: dict[int, PartResult] = field(default_factory=dict)
    figures: tuple[str, ...] = ()
    """Names that are about to appear in the folder."""

    @classmethod
    def read(cls, folder: Path) -> Journal:
        """All whole lines of a folder's journal; a file that is not there is an empty journal. Raises FolderError."""
        journal = cls(folder / JOURNAL)
        for entry in _entries(journal.path):
            if "part" in entry:
                result = _part(entry)
                if result is not None:
                    journal.parts[result.index] = result
            elif isinstance(names := entry.get("figures"), list):
                journal.figures += tuple(name for name in names if _FIGURE_FILE.fullmatch(str(name)))
            elif _is_header(entry):
                journal.header = entry
        return journal

    def is_beginning_of(self, header: dict[str, Any]) -> bool:
        """Whether the file holds nothing but the beginning of the line of this header; raises FolderError."""
        return _line(header).startswith(_content(self.path))

    def start(self, header: dict[str, Any]) -> None:
        """Write the journal anew with its header and the parts that count; raises OutputError."""
        self.header = header
        write_locked(self.path, b"".join([_line(header), *(_line(_entry(part)) for part in self.parts.values())]))

    def add(self, result: PartResult) -> None:
        """Record a finished part, on the disk before this returns; raises OutputError."""
        self.parts[result.index] = result
        self._append(_entry(result))

    def announce(self, figures: list[str]) -> None:
        """Record the names of figures before they appear in the folder; raises OutputError."""
        self.figures += tuple(figures)
        self._append({"figures": figures})

    def _append(self, entry: dict[str, Any]) -> None:
        with output_errors(self.path), self.path.open("ab") as file:
            file.write(_line(entry))
            file.flush()
            os.fsync(file.fileno())


def _line(entry: dict[str, Any]) -> bytes:
    text = json.dumps(entry, sort_keys=True).encode()
    return b"%08x %s\n" % (zlib.crc32(text), text)


def _content(path: Path) -> bytes:
    try:
        return read_file(path, _MOST_BYTES)
    except (FileNotFoundError, NotADirectoryError):
        return b""
    except OSError as error:  # what it lists is not known, so nothing in the folder may be trusted or deleted
        hint = "make it a file that can be read, or choose another folder with --out"
        raise FolderError(f"cannot be read: {error.strerror}", where=str(path), hint=hint) from error


def _entries(path: Path) -> list[dict[str, Any]]:
    found = []
    for line in _content(path).split(b"\n")[:-1]:
        crc, _, text = line.partition(b" ")
        if crc == b"%08x" % zlib.crc32(text):
            with contextlib.suppress(ValueError, RecursionError):
                found.append(json.loads(text))
    return [entry for entry in found if isinstance(entry, dict)]


def _is_header(entry: dict[str, Any]) -> bool:
    """Whether an entry says of what run the journal is."""
    tables, parts = entry.get("tables"), entry.get("parts")
    return (
        isinstance(tables, list)
        and bool(tables)
        and all(table in TABLES for table in tables)
        and _is_count(parts)
        and 0 < entry["parts"] <= _MOST_PARTS
        and isinstance(entry.get("study_hash"), str)
    )


def _entry(result: PartResult) -> dict[str, Any]:
    files = {name: asdict(file) for name, file in result.files.items()}
    return {"part": result.index, "totals": asdict(result.totals), "files": files, "suits": result.suits}


def _part(entry: dict[str, Any]) -> PartResult | None:
    """A finished part, or nothing where the entry is not as it was written."""
    try:
        files = {str(name): WrittenFile(**file) for name, file in entry["files"].items()}
        totals, suits = Totals(**entry["totals"]), entry["suits"]
    except (KeyError, TypeError, AttributeError):
        return None
    counts = [entry["part"], *asdict(totals).values(), *(file.size for file in files.values())]
    sound = all(map(_is_count, counts)) and isinstance(suits, str)
    return PartResult(entry["part"], totals, files, suits) if sound else None
