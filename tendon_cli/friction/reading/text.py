"""The bytes of a readings file as numbered lines of text, within bounds that no file can exceed."""

from __future__ import annotations

import hashlib
import os
import re
from dataclasses import dataclass
from pathlib import Path

from tendon_cli.errors import InputError
from tendon_cli.files import open_file

LARGEST_FILE = 64 * 2**20
LONGEST_LINE = 64 * 2**10
_CONTROL = re.compile(rb"[\x00-\x08\x0e-\x1f\x7f-\x9f]")
"""Signs that no Latin-1 text has."""
_AS_CSV_THERE = 'in the spreadsheet: "Save as", then the type "CSV UTF-8"'
_AS_CSV = "save it as CSV in UTF-8 or UTF-16"


@dataclass(frozen=True)
class LogFile:
    """A readings file held as bytes, so that what is fitted is what was hashed."""

    name: str
    """The file's name without its folder, as errors and provenance give it."""
    data: bytes
    encoding: str

    @property
    def sha256(self) -> str:
        """Hash of the bytes as they are on disk."""
        return hashlib.sha256(self.data).hexdigest()

    def place(self, line: int, column: int | None = None) -> str:
        """Where something stands, as errors say it; `column` counts from 0 here and from 1 for people."""
        place = f"{self.name}, line {line}"
        return place if column is None else f"{place}, column {column + 1}"


def read_source(path: Path) -> LogFile:
    """Read a regular file of at most 64 MB and find its encoding; raises InputError."""
    # A name that is no UTF-8 is shown with a sign for what cannot be.
    name = os.fsencode(path.name or str(path)).decode("utf-8", "replace") if "\0" not in str(path) else "the file"
    try:
        with open_file(path) as file:
            size = os.fstat(file.fileno()).st_size
            data = file.read(LARGEST_FILE + 1) if size <= LARGEST_FILE else b""
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot be read: {reason}", where=name) from error
    if max(size, len(data)) > LARGEST_FILE:  # it may have grown since
        raise _too_large(name, max(size, len(data)))
    if not data.strip(b" \t\r\n\0\xef\xbb\xbf\xff\xfe"):
        raise InputError("the file is empty", where=name)
    return LogFile(name, data, _encoding(name, data))


def lines_of(source: LogFile) -> list[str]:
    """The lines, the first of which is line 1, without line ends."""
    try:
        text = source.data.decode(source.encoding)
    except UnicodeError:
        raise _not_decodable(source) from None
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    for number, line in enumerate(lines, start=1):
        if len(line) > LONGEST_LINE:
            problem = f"a line of more than {LONGEST_LINE} characters is no row of readings"
            raise InputError(problem, where=source.place(number))
    return lines


def _too_large(name: str, size: int) -> InputError:
    return InputError(
        f"the file has {size / 2**20:.0f} MB, more than the {LARGEST_FILE // 2**20} MB that are read",
        where=name,
        hint="cut the log to the strokes of one rig, or log at a lower rate",
    )


def _is_utf_8(data: bytes) -> bool:
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return False
    return True


def _encoding(name: str, data: bytes) -> str:
    if data.startswith((b"\xff\xfe\0\0", b"\0\0\xfe\xff")):
        raise InputError("the file is in UTF-32", where=name, hint=_AS_CSV)
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    if data.startswith((b"PK\x03\x04", b"\xd0\xcf\x11\xe0")):
        raise InputError("is a workbook of a spreadsheet, not text", where=name, hint=_AS_CSV_THERE)
    zero = data.find(b"\0")
    if zero < 0:
        return "utf-8-sig" if _is_utf_8(data) or _CONTROL.search(data) else "latin-1"
    # UTF-16 without a mark: in European text every second byte is zero, and no other.
    sample = data[: min(len(data), 4096) // 2 * 2]
    low, high = sample[0::2].count(0), sample[1::2].count(0)
    if min(low, high) == 0 and max(low, high) > 0.9 * len(sample) / 2:
        return "utf-16-le" if high else "utf-16-be"
    line = data.count(b"\n", 0, zero) + 1
    raise InputError("a zero byte: this is not text", where=f"{name}, line {line}", hint=_AS_CSV)


def _not_decodable(source: LogFile) -> InputError:
    try:
        source.data.decode(source.encoding)
        start = 0
    except UnicodeDecodeError as error:
        start = error.start
    line = source.data[:start].decode(source.encoding, errors="ignore").count("\n") + 1
    kind = "UTF-16" if source.encoding.startswith("utf-16") else "UTF-8"
    return InputError(f"bytes that are not {kind} text", where=source.place(line), hint=_AS_CSV)
