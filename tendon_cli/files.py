"""Files that appear whole or not at all: written under a temporary name, flushed to the disk, put in their place."""

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
            _write(temporary, content)
            temporary.replace(path)
        except OSError:
            temporary.unlink(missing_ok=True)
            raise
        sync_folder(path.parent)


def write_shared(path: Path, content: bytes) -> None:
    """Write a small file whole or not at all under a name that no lock guards: of several writers the last one wins."""
    temporary = path.with_name(f".tendon-{os.urandom(6).hex()}.tmp")
    with output_errors(path):
        try:
            _write(temporary, content)
            temporary.replace(path)
        finally:
            with contextlib.suppress(OSError):
                temporary.unlink(missing_ok=True)
        sync_folder(path.parent)


def write_new(path: Path, content: bytes) -> bool:
    """Write a small file whole or not at all, and over nothing; whether its name was free. Raises OutputError."""
    if os.path.lexists(path):
        return False
    temporary = path.with_name(f".tendon-{os.urandom(6).hex()}.tmp")  # nobody else's: no lock is held here
    with output_errors(path):
        try:
            _write(temporary, content)
            was_free = _name(temporary, path)
        finally:
            with contextlib.suppress(OSError):
                temporary.unlink(missing_ok=True)
        sync_folder(path.parent)
    return was_free


def _write(temporary: Path, content: bytes) -> None:
    # Exclusive, so that nothing that stands in the way is followed or written through.
    with temporary.open("xb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def _name(temporary: Path, path: Path) -> bool:
    """Give a finished file its name, unless something bears it, even since a moment ago."""
    try:
        path.hardlink_to(temporary)
    except FileExistsError:
        return False
    except OSError:  # perhaps a file system without links: the name is claimed first, then only the claim is replaced
        try:
            path.open("xb").close()
        except FileExistsError:
            return False
        try:
            temporary.replace(path)
        except OSError:
            path.unlink(missing_ok=True)
            raise
    return True


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
