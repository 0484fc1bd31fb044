"""The journal of an unfinished run: a line per finished part, each with a checksum.

It counts only as tendon wrote it. It may be cut off anywhere: whole lines count, the rest is dropped, and whoever goes
on writing first removes it.
"""

from __future__ import annotations

import contextlib
import json
import os
import zlib
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from tendon_cli.engine.records import FIGURE_FILE, MOST_BYTES, TABLES, is_count
from tendon_cli.engine.task import PartResult
from tendon_cli.errors import FolderError
from tendon_cli.files import output_errors, read_file, write_whole
from tendon_cli.tables.write import WrittenFile

JOURNAL = "journal.jsonl"
_MOST_PARTS = 10**8
"""Of half a million states each: no disk holds more."""


@dataclass
class Journal:
    """What is known of an unfinished run: what it is a run of, and the parts that are done."""

    path: Path
    header: dict[str, Any] = field(default_factory=dict)
    parts: dict[int, PartResult] = field(default_factory=dict)
    last: dict[str, WrittenFile] = field(default_factory=dict)
    """Files that are written last, or once more, by their names: each may stand already."""
    figures: tuple[str, ...] = ()
    """Names that are about to appear in the folder."""
    in_memory: bool = False
    """Of a run without a folder: nothing is written."""

    @classmethod
    def read(cls, folder: Path) -> Journal:
        """All whole lines of a folder's journal; a file that is not there is an empty journal. Raises FolderError."""
        journal = cls(folder / JOURNAL)
        for entry in _entries(journal.path):
            if "part" in entry:
                result = _part(entry)
                if result is not None:
                    journal.parts[result.index] = result
            elif "last" in entry:
                journal.last |= _files(entry["last"]) or {}
            elif isinstance(names := entry.get("figures"), list):
                journal.figures += tuple(name for name in names if FIGURE_FILE.fullmatch(str(name)))
            elif _is_header(entry):
                journal.header = entry
        return journal

    def is_beginning_of(self, header: dict[str, Any]) -> bool:
        """Whether the file holds nothing but the beginning of the line of this header; raises FolderError."""
        return _line(header).startswith(_content(self.path))

    def start(self, header: dict[str, Any]) -> None:
        """Write the journal anew with its header and what counts of an older one; raises OutputError."""
        self.header = header
        entries = [header, *map(_entry, self.parts.values())]
        entries += [{"figures": list(self.figures)}] if self.figures else []
        write_whole(self.path, b"".join(map(_line, entries)), of_a_run=True)

    def add(self, result: PartResult) -> None:
        """Record a finished part, on the disk before this returns; raises OutputError."""
        self.parts[result.index] = result
        self._append(_entry(result))

    def announce_last(self, name: str, file: WrittenFile) -> None:
        """Record a file that is written last before it takes its place; raises OutputError."""
        self.last[name] = file
        self._append({"last": {name: asdict(file)}})

    def announce(self, figures: list[str]) -> None:
        """Record the names of figures before they appear in the folder; raises OutputError."""
        self.figures += tuple(figures)
        self._append({"figures": figures})

    def _append(self, entry: dict[str, Any]) -> None:
        if self.in_memory:
            return
        with output_errors(self.path), self.path.open("ab") as file:
            file.write(_line(entry))
            file.flush()
            os.fsync(file.fileno())


def _line(entry: dict[str, Any]) -> bytes:
    text = json.dumps(entry, sort_keys=True).encode()
    return b"%08x %s\n" % (zlib.crc32(text), text)


def _content(path: Path) -> bytes:
    try:
        return read_file(path, MOST_BYTES)
    except (FileNotFoundError, NotADirectoryError):
        return b""
    except (
        OSError
    ) as error:  # what it lists is not known, so nothing in the folder may be trusted or deleted
        hint = "make it a file that can be read, or choose another folder with --out"
        raise FolderError(
            f"cannot be read: {error.strerror}", where=str(path), hint=hint
        ) from error


def _entries(path: Path) -> list[dict[str, Any]]:
    entries = []
    for line in _content(path).split(b"\n")[:-1]:
        crc, _, text = line.partition(b" ")
        if crc == b"%08x" % zlib.crc32(text):
            with contextlib.suppress(ValueError, RecursionError):
                entries.append(json.loads(text))
    return [entry for entry in entries if isinstance(entry, dict)]


def _is_header(entry: dict[str, Any]) -> bool:
    """Whether an entry says of what run the journal is."""
    tables, parts = entry.get("tables"), entry.get("parts")
    is_known = (
        isinstance(tables, list) and bool(tables) and all(table in TABLES for table in tables)
    )
    return (
        is_known
        and is_count(parts)
        and 0 < entry["parts"] <= _MOST_PARTS
        and type(entry.get("study_hash")) is str
    )


def _entry(result: PartResult) -> dict[str, Any]:
    files = {name: asdict(file) for name, file in result.files.items()}
    return {"part": result.index, "note": result.note, "files": files}


def _part(entry: dict[str, Any]) -> PartResult | None:
    """A finished part, or nothing where the entry is not as it was written; its note is for the task to judge."""
    index, note, files = entry["part"], entry.get("note"), _files(entry.get("files"))
    return (
        PartResult(index, note, files)
        if is_count(index) and isinstance(note, dict) and files is not None
        else None
    )


def _files(entry: Any) -> dict[str, WrittenFile] | None:
    try:
        files = {str(name): WrittenFile(**file) for name, file in entry.items()}
    except (TypeError, AttributeError):
        return None
    return files if all(is_count(file.size) for file in files.values()) else None
