"""Text of files that users bring: their bytes as lines, and all their faults as one error."""

from __future__ import annotations

import re
import zlib
from collections.abc import Sequence
from pathlib import PurePath

from tendon_cli.errors import InputError
from tendon_cli.files import CSV, WORKBOOK, kind_of_file

LONGEST_LINE = 64 * 2**10  # characters
MOST_FAULTS = 10
"""Largest number of faults of a file that are listed."""
_COMMENT = ("#", "%", "//", "*")
PLAIN_START = frozenset("0123456789+-.abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ")
"""First characters of lines that are no comment, so that most lines need no further test."""
_AS_CSV = "save it as CSV in UTF-8 or UTF-16"
_CONTROL = re.compile(rb"[\x01-\x08\x0e-\x1f\x7f]")  # no text has these
_LINE = re.compile(r", line ([0-9]+)")


def unpacked(content: bytes, source: str, most: int) -> bytes:
    """Return the content of a file that gzip may have packed; never more than so many bytes."""
    if not content.startswith(b"\x1f\x8b"):
        return content
    try:
        content = zlib.decompressobj(wbits=31).decompress(content, most + 1)
    except zlib.error:
        raise InputError("cannot be unpacked as gzip", where=source) from None
    if len(content) > most:
        raise InputError(f"is larger than {most / 1e6:g} MB when unpacked", where=source)
    return content


def lines_of(content: bytes, source: str) -> list[str]:
    """Return the lines of a text, without their ends.

    The text may be UTF-8, UTF-16 with its byte order mark, Windows-1252 or Latin-1.

    Args:
        content: Bytes of the file.
        source: Name of the file for messages.

    Raises:
        InputError: The file is empty, of another kind, no text, or has a line longer than
            `LONGEST_LINE`.
    """
    kind = kind_of_file(PurePath(source))
    if kind not in (None, CSV, WORKBOOK):  # a workbook is known by its content, below
        raise InputError(f"this is {kind}, expected a CSV", where=source)
    if not content.strip(b" \t\r\n\0\xef\xbb\xbf\xff\xfe"):
        raise InputError("the file is empty", where=source)
    if content.startswith((b"\xff\xfe\0\0", b"\0\0\xfe\xff")):
        raise InputError("the file is in UTF-32", where=source, hint=_AS_CSV)
    if content.startswith((b"PK\x03\x04", b"\xd0\xcf\x11\xe0")):
        hint = 'in the spreadsheet: "Save as", then the type "CSV UTF-8"'
        raise InputError("is a spreadsheet workbook, not text", where=source, hint=hint)
    is_utf16 = content.startswith((b"\xff\xfe", b"\xfe\xff"))
    if b"\0" in content and not is_utf16:
        raise _zero_bytes(content, source)
    encoding = "utf-16" if is_utf16 else "utf-8-sig"
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError as error:
        text = "" if is_utf16 or _CONTROL.search(content) else _decoded(content)
        if not text:
            line = content[: error.start].decode(encoding, errors="ignore").count("\n") + 1
            problem = f"bytes that are not {'UTF-16' if is_utf16 else 'UTF-8'} text"
            raise InputError(problem, where=f"{source}, line {line}", hint=_AS_CSV) from None
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    for number, line_text in enumerate(lines, start=1):
        if len(line_text) > LONGEST_LINE:
            problem = f"a line of more than {LONGEST_LINE} characters"
            raise InputError(problem, where=f"{source}, line {number}")
    return lines


def _decoded(content: bytes) -> str:
    """Return a text in Windows-1252, a larger Latin-1; empty if it is none."""
    try:
        return content.decode("cp1252")
    except UnicodeDecodeError:
        return ""


def _zero_bytes(content: bytes, source: str) -> InputError:
    """Return the error of a file with zero bytes: at its end they come of a power cut."""
    before = content.rstrip(b"\0\r\n")
    line = content.count(b"\n", 0, content.index(b"\0")) + 1
    if b"\0" in before:
        place = f"{source}, line {line}"
        return InputError("contains a zero byte, so it is not text", where=place, hint=_AS_CSV)
    last = before.count(b"\n") + 1
    good = last if content[len(before) :].startswith((b"\n", b"\r")) else last - 1
    return InputError(
        f"ends in zero bytes, as after a power cut: line {good} is the last whole one",
        where=f"{source}, line {line}",
        hint=f"delete what follows line {good}",
    )


def is_comment(line: str) -> bool:
    """Return True if a line is empty or begins with a comment sign or a footnote's asterisk."""
    text = line.lstrip(' \t"\ufeff')
    return not text.strip(' \t",;') or text.startswith(_COMMENT)


def raise_all(errors: Sequence[InputError], source: str) -> None:
    """Raise the errors of a file as one, if there are any, in the order of its lines.

    The first `MOST_FAULTS` are listed.
    """
    if not errors:
        return
    if len(errors) == 1:
        raise errors[0]
    listed = []
    for error in sorted(errors, key=_line_of)[:MOST_FAULTS]:
        place = (error.where or "").removeprefix(source).removeprefix(", ")
        advice = f" ({error.hint})" if error.hint else ""
        listed.append(f"  {place}{': ' if place else ''}{error.message}{advice}")
    if len(errors) > MOST_FAULTS:
        listed.append(f"  and {len(errors) - MOST_FAULTS:,} more")
    problem = "\n".join([f"the file has {len(errors):,} faults:", *listed])
    raise InputError(problem, where=source)


def _line_of(error: InputError) -> int:
    """Return the line at which an error is; 0 for an error of the whole file."""
    line = _LINE.search(error.where or "")
    return 0 if line is None else int(line[1])
