"""Files: opened only where they are files, and written so that they appear whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from tendon_cli.errors import OutputError, UsageError

_KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}


def open_file(path: Path) -> BinaryIO:
    """A regular file, open for reading; raises OSError, at once, for a pipe, a device or whatever else is none.

    What bears the name is asked before it is opened, since opening a device may do something, and again afterwards.
    """
    _check_regular(path.stat(), path)
    handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    try:
        _check_regular(os.fstat(handle), path)
        return os.fdopen(handle, "rb")
    except OSError:
        os.close(handle)
        raise


def read_file(path: Path, most: int) -> bytes:
    """The bytes of a regular file; raises OSError, with EFBIG before it is read for one of more than `most`."""
    with open_file(path) as file:
        is_small = os.fstat(file.fileno()).st_size <= most
        content = file.read(most + 1) if is_small else b""
    if not is_small or len(content) > most:  # it may have grown since
        size = f"{most // 10**6} MB" if most >= 10**6 else f"{most // 1000} kB"
        raise OSError(errno.EFBIG, f"it is larger than {size}", str(path))
    return content


def _check_regular(status: os.stat_result, path: Path) -> None:
    if not stat.S_ISREG(status.st_mode):
        kind = _KINDS.get(stat.S_IFMT(status.st_mode), "no file")
        number = errno.EISDIR if stat.S_ISDIR(status.st_mode) else errno.EINVAL
        raise OSError(number, f"it is {kind}, expected a file", str(path))


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


def check_ours(path: Path, mark: str, option: str) -> None:
    """Refuse to write over a file that does not hold the mark that tendon writes into its own; raises UsageError."""
    if not os.path.lexists(path):
        return
    try:
        ours = mark.encode() in read_file(path, 64 * 10**6)
    except OSError:
        ours = False
    if not ours:
        raise UsageError(
            f"{path.name!r} stands there, and tendon did not write it",
            where=option,
            hint="choose another name, or move it away",
        )


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
