"""Recognise figures that tendon wrote, by what their metadata say of their source."""

from __future__ import annotations

import re
from typing import BinaryIO

_SOURCE = rb"tendon (?:study [^\n()<]+ ([0-9a-f]{64})|fit-friction |fit-suit )"
"""Name and hash of a study as `frame.py` of the figures has them, or the mark of a friction fit."""
_PNG = b"\x89PNG\r\n\x1a\n"
_IN_PNG = re.compile(rb"Source\0" + _SOURCE)
_IN_SVG = re.compile(rb"<dc:source>\s*" + _SOURCE)
_IN_PDF = re.compile(rb"/Keywords \(" + _SOURCE)
_MOST_BYTES = 64 * 10**6
"""Size up to which a PDF is searched, bytes."""
_HEAD = 10**6
"""Bytes at the beginning of an SVG that hold its metadata."""


def is_figure(file: BinaryIO) -> bool:
    """Return True if a file is a PNG, an SVG or a PDF whose metadata say that tendon drew it."""
    return _source_in(file) is not None


def study_hash_in(file: BinaryIO) -> str | None:
    """Return the hash of the study of which a file is a figure; None if it is of none."""
    source = _source_in(file)
    return source[1].decode() if source is not None and source[1] is not None else None


def _source_in(file: BinaryIO) -> re.Match[bytes] | None:
    """Return what the metadata of a figure say of its source; None if tendon did not draw it."""
    beginning = file.read(len(_PNG))
    if beginning == _PNG:
        return _source_in_png(file)
    if beginning.startswith(b"%PDF-"):
        return _IN_PDF.search(file.read(_MOST_BYTES))
    metadata, end, _ = (beginning + file.read(_HEAD)).partition(b"</metadata>")
    is_svg = b"<svg" in metadata and bool(end)
    return _IN_SVG.search(metadata) if is_svg else None


def _source_in_png(file: BinaryIO) -> re.Match[bytes] | None:
    """Return the source that a text chunk before the pixels names; None if it names none.

    Args:
        file: The file after its signature. A chunk is its length, its type, its data and a sum.
    """
    while len(head := file.read(8)) == 8:
        size = int.from_bytes(head[:4], "big")
        kind = head[4:]
        if kind == b"IDAT":
            return None
        if kind != b"tEXt":
            file.seek(size + 4, 1)
            continue
        source = _IN_PNG.match(file.read(min(size, _HEAD)))
        if source is not None:
            return source
        file.seek(max(0, size - _HEAD) + 4, 1)
    return None
