"""The journal of an unfinished run: a line for each finished part, each line with a checksum.

A journal counts only as tendon wrote it. It may be cut off anywhere: whole lines count, the rest is
dropped, and is removed before anything else is written.
"""

from __future__ import annotations

import contextlib
import json
import os
import zlib
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from tendon_cli.engine.records import FIGURE_FILE, MOST_BYTES, is_count
from tendon_cli.engine.task import PartResult
from tendon_cli.errors import FolderError
from tendon_cli.files import output_errors, read_file, write_whole
from tendon_cli.registry import table_kinds
from tendon_cli.tables.write import WrittenFile

JOURNAL = "journal.jsonl"
_MOST_PARTS = 10**8
"""Most parts of half a million states each: no disk holds more."""


@dataclass
class Journal:
    """State of an unfinished run: which run it is, and the parts that are done."""

    path: Path
    header: dict[str, Any] = field(default_factory=dict)
    """Identity of the run, its tables and number of parts; empty if there is none."""
    parts: dict[int, PartResult] = field(default_factory=dict)
    """Finished parts by their indices."""
    last: dict[str, WrittenFile] = field(default_factory=dict)
    """Files that follow from the whole record, by their names; each may be in place already."""
    figures: tuple[str, ...] = ()
    """Names of figures that are in the folder or about to appear there."""
    in_memory: bool = False
    """True for a run without a folder: nothing is written."""

    @classmethod
    def read(cls, folder: Path) -> Journal:
        """Read all whole lines of a folder's journal; an empty journal if there is no file.

        Raises:
            FolderError: The file cannot be read.
        """
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
        """Return True if the file holds nothing but the beginning of the line of this header.

        Raises:
            FolderError: The file cannot be read.
        """
        return _line(header).startswith(_content(self.path))

    def start(self, header: dict[str, Any]) -> None:
        """Write a new journal: a header, then the parts and figures so far; raises OutputError."""
        self.header = header
        entries = [header, *map(_entry, self.parts.values())]
        if self.figures:
            entries.append({"figures": list(self.figures)})
        write_whole(self.path, b"".join(map(_line, entries)), of_a_run=True)

    def add(self, result: PartResult) -> None:
        """Record a finished part, on the disk before this returns; raises OutputError."""
        self.parts[result.index] = result
        self._append(_entry(result))

    def announce_last(self, name: str, file: WrittenFile) -> None:
        """Record a file that is written last, before it is put in place; raises OutputError."""
        self.last[name] = file
        self._append({"last": {name: asdict(file)}})

    def announce(self, figures: list[str]) -> None:
        """Record the names of figures before they appear in the folder; raises OutputError."""
        self.figures += tuple(figures)
        self._append({"figures": figures})

    def _append(self, entry: dict[str, Any]) -> None:
        """Add a line, on the disk before this returns; raises OutputError."""
        if self.in_memory:
            return
        with output_errors(self.path), self.path.open("ab") as file:
            file.write(_line(entry))
            file.flush()
            os.fsync(file.fileno())


def _line(entry: dict[str, Any]) -> bytes:
    """Return an entry as a line: CRC-32 in hexadecimal digits, a space, JSON."""
    text = json.dumps(entry, sort_keys=True).encode()
    return b"%08x %s\n" % (zlib.crc32(text), text)


def _content(path: Path) -> bytes:
    """Return the bytes of a journal, none if there is no file; raises FolderError."""
    try:
        return read_file(path, MOST_BYTES)
    except (FileNotFoundError, NotADirectoryError):
        return b""
    except OSError as error:
        # Nothing in the folder may be trusted or deleted if it is not known what the journal lists.
        hint = "make it a file that can be read, or choose another folder with --out"
        raise FolderError(
            f"cannot be read: {error.strerror}", where=str(path), hint=hint
        ) from error


def _entries(path: Path) -> list[dict[str, Any]]:
    """Return the entries of all whole lines whose checksums are right."""
    entries = []
    for line in _content(path).split(b"\n")[:-1]:
        crc, _, text = line.partition(b" ")
        if crc == b"%08x" % zlib.crc32(text):
            with contextlib.suppress(ValueError, RecursionError):
                entries.append(json.loads(text))
    return [entry for entry in entries if isinstance(entry, dict)]


def _is_header(entry: dict[str, Any]) -> bool:
    """Return True if an entry is a header, which says which run the journal is of."""
    tables = entry.get("tables")
    if not isinstance(tables, list) or not tables:
        return False
    return (
        all(table in table_kinds() for table in tables)
        and is_count(entry.get("parts"))
        and 0 < entry["parts"] <= _MOST_PARTS
        and type(entry.get("study_hash")) is str
    )


def _entry(result: PartResult) -> dict[str, Any]:
    """Return the entry of a finished part."""
    files = {name: asdict(file) for name, file in result.files.items()}
    return {"part": result.index, "note": result.note, "files": files}


def _part(entry: dict[str, Any]) -> PartResult | None:
    """Return a finished part, its note unchecked; None if the entry is not as it was written."""
    index = entry["part"]
    note = entry.get("note")
    files = _files(entry.get("files"))
    if not is_count(index) or not isinstance(note, dict) or files is None:
        return None
    return PartResult(index, note, files)


def _files(entry: Any) -> dict[str, WrittenFile] | None:
    """Return the files of an entry by their names; None if it is not as it was written."""
    try:
        files = {str(name): WrittenFile(**file) for name, file in entry.items()}
    except (TypeError, AttributeError):
        return None
    return files if all(is_count(file.size) for file in files.values()) else None
