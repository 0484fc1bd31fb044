"""The bytes of a readings file as lines of text."""

from __future__ import annotations

import errno
import os
import re
from collections import Counter
from pathlib import Path

from tendon_cli.errors import InputError
from tendon_cli.files import read_file

SEPARATORS = {"\t": "tab", ";": "semicolon", ",": "comma"}
"""In this order: a comma is believed last, since in a file separated by semicolons or tabs it is the decimal sign."""
LONGEST_LINE = 64 * 2**10
_COMMENT = ("#", "%", "//", "*")
_AS_CSV = "save it as CSV in UTF-8 or UTF-16"
_CONTROL = re.compile(rb"[\x01-\x08\x0e-\x1f\x7f-\x9f]")
"""Signs that no Latin-1 text has."""


def name_of(path: Path) -> str:
    """The file's name without its folder, as errors and provenance give it; a sign for what is no UTF-8."""
    return "the file" if "\0" in str(path) else os.fsencode(path.name or str(path)).decode("utf-8", "replace")


def content_of(path: Path, most: int, hint: str | None = None) -> bytes:
    """The bytes of a file; raises InputError."""
    try:
        return read_file(path, most)
    except (OSError, ValueError) as error:
        hint = "cut the log to the strokes of one rig" if getattr(error, "errno", 0) == errno.EFBIG else hint
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot be read: {reason}", where=name_of(path), hint=hint) from None


def lines_of(content: bytes, source: str) -> list[str]:
    """The lines of the text, the first of which is line 1, without line ends."""
    if not content.strip(b" \t\r\n\0\xef\xbb\xbf\xff\xfe"):
        raise InputError("the file is empty", where=source)
    if content.startswith((b"\xff\xfe\0\0", b"\0\0\xfe\xff")):
        raise InputError("the file is in UTF-32", where=source, hint=_AS_CSV)
    if content.startswith((b"PK\x03\x04", b"\xd0\xcf\x11\xe0")):
        hint = 'in the spreadsheet: "Save as", then the type "CSV UTF-8"'
        raise InputError("is a workbook of a spreadsheet, not text", where=source, hint=hint)
    wide = content.startswith((b"\xff\xfe", b"\xfe\xff"))
    if b"\0" in content and not wide:
        line = content.count(b"\n", 0, content.index(b"\0")) + 1
        raise InputError("a zero byte: this is not text", where=f"{source}, line {line}", hint=_AS_CSV)
    encoding = "utf-16" if wide else "utf-8-sig"
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError as error:
        if wide or _CONTROL.search(content):
            line = content[: error.start].decode(encoding, errors="ignore").count("\n") + 1
            problem = f"bytes that are not {'UTF-16' if wide else 'UTF-8'} text"
            raise InputError(problem, where=f"{source}, line {line}", hint=_AS_CSV) from None
        text = content.decode("latin-1")
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    if max(map(len, lines)) > LONGEST_LINE:
        long = next(number for number, line in enumerate(lines, start=1) if len(line) > LONGEST_LINE)
        problem = f"a line of more than {LONGEST_LINE} characters is no row of readings"
        raise InputError(problem, where=f"{source}, line {long}")
    return lines


def is_comment(line: str) -> bool:
    """Whether a line is empty or begins with a comment sign (a footnote's asterisk included)."""
    text = line.lstrip(' \t"\ufeff')
    return not text.strip(' \t",;') or text.startswith(_COMMENT)


def separator_of(lines: list[str], source: str) -> str:
    """The separator that divides most of the lines into equally many columns."""
    shares = {}
    for separator in SEPARATORS:
        counts = Counter(line.count(separator) for line in lines)
        counts.pop(0, None)
        shares[separator] = max(counts.values(), default=0) / len(lines)
    best = next((separator for separator in shares if shares[separator] >= 0.5), max(shares, key=shares.__getitem__))
    if not shares[best]:
        hint = "columns are separated by comma, semicolon or tab"
        raise InputError("no line has more than one column", where=source, hint=hint)
    return best
