"""Files that appear whole or not at all: written under a temporary name, flushed to the disk, renamed."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from tendon_cli.errors import OutputError


def write_whole(path: Path, content: bytes) -> None:
    """Write a small file whole or not at all; what stood there before stays until then. Raises OutputError."""
    temporary = temporary_of(path)
    with output_errors(path):
        temporary.unlink(missing_ok=True)
        try:
            # Exclusive, so that nothing that stands in the way is followed or written through.
            with temporary.open("xb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            temporary.replace(path)
        except OSError:
            temporary.unlink(missing_ok=True)
            raise
        sync_folder(path.parent)


def temporary_of(path: Path) -> Path:
    """The name a file bears until it is whole; hidden, beside it, so that the rename stays within one file system."""
    return path.with_name(f".{path.name}.tmp")


def sync_folder(folder: Path) -> None:
    """Make a rename in a folder last through a power cut, where the system can."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


@contextlib.contextmanager
def output_errors(path: Path) -> Iterator[None]:
    """An OSError while writing a file, as an OutputError that names it."""
    try:
        yield
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        hint = "free some space, then start again" if "space" in reason else None
        raise OutputError(f"cannot be written: {reason}", where=str(path), hint=hint) from error
