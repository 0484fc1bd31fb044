"""One digest over every byte of a table file, kept inside the file.

A Parquet page carries a checksum, but page headers and the footer do not, and there a flipped bit
may change a name, a unit or a number without anybody noticing. So the footer holds the SHA-256 of
the whole file, taken with zeros instead of the digest itself. So a table can be verified even if it
was moved away from its run folder.
"""

from __future__ import annotations

import hashlib
import os
from io import RawIOBase
from pathlib import Path
from typing import Any, BinaryIO

from tendon_cli.files import open_file

KEY = "tendon.digest"
PLACEHOLDER = "sha256:" + "0" * 64
_ZEROS = b"0" * 64
# The footer (Thrift's compact protocol) holds the key and the value each as a string field with its
# length before it. No text of a study has such control characters, so that nothing else in a footer
# looks like it.
_MARK = b"\x18%c%s\x18%csha256:" % (len(KEY), KEY.encode(), len(PLACEHOLDER))
_STEP = 1 << 20


class StampedSink(RawIOBase):
    """A file that a Parquet writer fills, and that gets its digest into the footer at the end.

    Args:
        file: File that takes the bytes. Closing the sink leaves it open, to be stamped.
    """

    def __init__(self, file: BinaryIO | RawIOBase) -> None:
        self._file = file
        self._written = hashlib.sha256()
        self._before_footer = hashlib.sha256()
        self._footer: list[bytes] | None = None
        self.size = 0
        """Number of bytes written."""
        self.footer = b""
        """Footer with the digest; empty before `stamp`."""
        self.discards = False
        """True if the file was abandoned, so that nothing more is written."""

    def write(self, data: Any) -> int:
        """Pass bytes on to the file."""
        if not self.discards:
            self._written.update(data)
            if self._footer is not None:
                self._footer.append(bytes(data))
            self._file.write(data)
            self.size += len(data)
        return len(data)

    def tell(self) -> int:
        """Return the number of bytes written."""
        return self.size

    def writable(self) -> bool:
        """Return True until the sink is closed."""
        return not self.closed

    def begin_footer(self) -> None:
        """Mark the end of all pages: what follows is the footer."""
        self._before_footer = self._written.copy()
        self._footer = []

    def stamp(self) -> str:
        """Put the digest into the finished file, and return the SHA-256 of the file with it."""
        footer = b"".join(self._footer or [])
        start = digest_place(footer)
        if start is None:
            raise ValueError("the footer has no place for a digest")
        self.footer = footer[:start] + self._written.hexdigest().encode() + footer[start + 64 :]
        self._file.seek(self.size - len(footer))
        self._file.write(self.footer)
        self._before_footer.update(self.footer)
        return self._before_footer.hexdigest()


def digests_of(file: BinaryIO, footer: bytes, start: int) -> tuple[bool, str]:
    """Digest an open table file in a single pass.

    Args:
        file: The file.
        footer: Its footer, which holds a digest.
        start: Number of bytes before the footer.

    Returns:
        True if every byte is as it was written, and the SHA-256 of the file.
    """
    place = digest_place(footer)
    if place is None:
        raise ValueError("the footer has no digest")
    whole = _digest_of(file, start)
    as_written = whole.copy()
    as_written.update(footer[:place] + _ZEROS + footer[place + 64 :])
    whole.update(footer)
    is_intact = as_written.hexdigest().encode() == footer[place : place + 64]
    return is_intact, whole.hexdigest()


def file_sha256(path: Path) -> str:
    """Return the SHA-256 of a file."""
    with open_file(path) as file:
        return _digest_of(file, os.fstat(file.fileno()).st_size).hexdigest()


def _digest_of(file: BinaryIO, count: int) -> hashlib._Hash:
    """Digest the first `count` bytes of a file."""
    digest = hashlib.sha256()
    file.seek(0)
    while count > 0 and (piece := file.read(min(count, _STEP))):
        digest.update(piece)
        count -= len(piece)
    return digest


def digest_place(footer: bytes) -> int | None:
    """Return the offset of the digest's 64 digits in a footer, or None unless there is just one."""
    if footer.count(_MARK) != 1:
        return None
    return footer.index(_MARK) + len(_MARK)
