"""The footer of a table file: the run, the table and the part that it is of, and its digest.

A file says itself what it is, so that no list beside it has to: a part of a run stands if its
footer names the run and the part, and every byte is as it was written.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, BinaryIO

import pyarrow as pa
import pyarrow.parquet as pq

from tendon_cli.files import open_file
from tendon_cli.tables.digest import KEY, digest_place, digests_of

_LONGEST = 256 * 1024 * 1024
_MAGIC = b"PAR1"
_PREFIX = b"tendon."


@dataclass(frozen=True)
class Origin:
    """Run, table and part that the file of a table says it is of."""

    verb: str
    study_hash: str
    results_version: int
    table: str
    index: int
    of: int
    """Number of files of the table."""

    @property
    def run(self) -> tuple[str, str, int]:
        """Facts that files share if and only if they are of the same run."""
        return self.verb, self.study_hash, self.results_version


@dataclass(frozen=True)
class Footer:
    """Footer of a table file, read without its rows."""

    content: bytes
    """Bytes from the metadata to the end of the file."""
    start: int
    """Number of bytes before it."""

    @property
    def size(self) -> int:
        """Size of the file, bytes."""
        return self.start + len(self.content)

    @cached_property
    def metadata(self) -> pq.FileMetaData:
        """Metadata of the file as Parquet has them; raises pyarrow's errors."""
        return pq.read_metadata(pa.BufferReader(_MAGIC + self.content))

    @cached_property
    def texts(self) -> Mapping[bytes, bytes]:
        """Texts of the file's metadata by their keys, among them its facts as JSON."""
        return self.metadata.metadata or {}

    @cached_property
    def facts(self) -> dict[str, Any]:
        """Facts of the file by name, without its digest; raises ValueError."""
        return facts_in(self.texts)

    def fact(self, name: str) -> Any:
        """Return a fact of the file, None if there is none; raises ValueError."""
        text = self.texts.get(_PREFIX + name.encode())
        return None if text is None else json.loads(text)

    @cached_property
    def origin(self) -> Origin | None:
        """Run, table and part of the file; None if the file does not say them."""
        try:
            part = self.fact("part")
            origin = Origin(
                verb=self.fact("verb") or "",
                study_hash=self.fact("study_hash"),
                results_version=self.fact("results_version"),
                table=self.fact("table"),
                index=part["index"],
                of=part["of"],
            )
        except (pa.ArrowException, OSError, ValueError, TypeError, LookupError, RecursionError):
            return None
        texts = (origin.verb, origin.study_hash, origin.table)
        counts = (origin.results_version, origin.index, origin.of)
        is_sound = all(type(text) is str for text in texts)
        return origin if is_sound and all(type(count) is int for count in counts) else None


def facts_in(metadata: Mapping[bytes, bytes]) -> dict[str, Any]:
    """Return the facts in the metadata of a file or a schema by name, without a digest.

    Raises:
        ValueError: A fact is no JSON, or no text.
    """
    return {
        key[len(_PREFIX) :].decode(): json.loads(text)
        for key, text in metadata.items()
        if key.startswith(_PREFIX) and key != KEY.encode()
    }


def read_footer(path: Path) -> Footer | None:
    """Return the footer of a table file; None if the file has no footer with a digest of tendon's.

    Raises:
        OSError: The file cannot be read.
    """
    with open_file(path) as file:
        return _footer_in(file)


def read_whole(path: Path) -> tuple[Footer, str] | None:
    """Read a table file once, from its first byte to its last.

    Returns:
        Its footer and the SHA-256 of the file; None if the file has no footer with a digest of
        tendon's, or a byte of it is not as it was written.

    Raises:
        OSError: The file cannot be read.
    """
    with open_file(path) as file:
        footer = _footer_in(file)
        if footer is None:
            return None
        is_intact, sha256 = digests_of(file, footer.content, footer.start)
    return (footer, sha256) if is_intact else None


def _footer_in(file: BinaryIO) -> Footer | None:
    """Return the footer of an open table file; None if it has none with a digest."""
    end = file.seek(0, os.SEEK_END)
    file.seek(max(0, end - 8))
    tail = file.read(8)
    length = int.from_bytes(tail[:4], "little") + 8
    if tail[4:] != _MAGIC or length > min(end, _LONGEST):
        return None
    file.seek(end - length)
    content = file.read(length)
    if len(content) < length or digest_place(content) is None:
        return None
    return Footer(content, end - length)
