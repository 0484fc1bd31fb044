"""Files: read only if they are regular, and written so that they appear whole or not at all."""

from __future__ import annotations

import contextlib
import csv
import errno
import fcntl
import os
import re
import stat
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path, PurePath
from typing import BinaryIO, TextIO, TypeAlias

from tendon_cli.errors import FolderError, OutputError, UsageError
from tendon_cli.units import described, shorten

CSV = "a CSV"
TABLE = "a table in Parquet"
WORKBOOK = "a workbook of a spreadsheet"
STUDIES = ("a study or a friction fragment in TOML", "a study in YAML")
_BY_ENDING = {
    ".csv": CSV,
    ".tsv": CSV,
    ".parquet": TABLE,
    ".toml": STUDIES[0],
    ".yaml": STUDIES[1],
    ".yml": STUDIES[1],
    ".json": "JSON",
    ".html": "a page",
    ".xml": "XML",
    ".png": "a figure",
    ".svg": "a figure",
    ".pdf": "a figure",
    ".xlsx": WORKBOOK,
    ".py": "a program in Python",
}
"""Kinds of files by their endings, in words."""
_KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}
_MAX_NAME = 255  # bytes in the name of a file, on every usual file system
_MAX_PATH = 4095  # bytes in a path, on Linux


def path_of(given: object, *, in_utf8: bool = False) -> Path:
    """Return a user's name of a file or folder as a path, once it is checked.

    Args:
        given: Name of a file or folder.
        in_utf8: True if the name must be UTF-8, as those of tables and their folders must.

    Raises:
        UsageError: This cannot be a path.
    """
    text = os.fspath(given) if isinstance(given, (str, os.PathLike)) else None
    if not isinstance(text, str):
        raise UsageError(f"{described(given)} is not a path, expected the name of a file or folder")
    if not text.strip():
        problem = "the name is empty, expected the name of a file or folder"
        raise UsageError(problem, hint=". is the current folder")
    where = shorten(text)
    try:
        longest = max(len(os.fsencode(part)) for part in text.split("/"))
        if in_utf8:
            str(Path(text).absolute()).encode()
    except FileNotFoundError:
        hint = "change to one that exists, or name files by their whole path"
        raise UsageError("the working directory no longer exists", hint=hint) from None
    except UnicodeEncodeError:
        raise UsageError("the name is not UTF-8, which tables cannot have", where=where) from None
    if longest > _MAX_NAME or len(os.fsencode(text)) > _MAX_PATH:
        problem = f"the name is too long, expected {_MAX_NAME} bytes at most"
        raise UsageError(problem, where=where)
    if "\0" in text:
        raise UsageError("the name holds a NUL, which no file can have", where=where)
    return Path(text)


def result_path(given: object) -> Path:
    """Return a user's name of a file or folder of results as a path, which must be UTF-8."""
    return path_of(given, in_utf8=True)


def kind_of_file(path: PurePath) -> str | None:
    """Return the kind of a file in words, such as "a figure", by its ending; None if unknown."""
    return _BY_ENDING.get(path.suffix.lower())


def open_file(path: Path) -> BinaryIO:
    """Open a regular file for reading.

    Its kind is checked before it is opened, since opening a device may do something, and again
    afterwards.

    Raises:
        OSError: It is a pipe, a device or anything else but a regular file; it does not wait.
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
    """Return the bytes of a regular file.

    Raises:
        OSError: It cannot be read. With EFBIG, before it is read, if it has more than `most` bytes.
    """
    with open_file(path) as file:
        is_small = os.fstat(file.fileno()).st_size <= most
        content = file.read(most + 1) if is_small else b""
    if not is_small or len(content) > most:  # it may have grown since
        size = f"{most // 10**6} MB" if most >= 10**6 else f"{most // 1000} kB"
        raise OSError(errno.EFBIG, f"it is larger than {size}", str(path))
    return content


FORMULA = r"^([=+\-@\t\r])"
"""Pattern of text that a spreadsheet would run as a formula; it is written with a ' before it."""


def write_csv_rows(file: TextIO, rows: Iterable[Sequence[str | int]]) -> None:
    """Write rows as CSV; texts that a spreadsheet would run have a ' before them."""
    writer = csv.writer(file, lineterminator="\n")
    for row in rows:
        writer.writerow([_as_text(cell) for cell in row])


def _as_text(cell: str | int) -> str | int:
    """Return a cell that no spreadsheet runs; numbers below zero stay as they are."""
    if not isinstance(cell, str) or re.fullmatch(r"-[0-9.]+(e[+-]?[0-9]+)?", cell):
        return cell
    return re.sub(FORMULA, r"'\1", cell)


_inputs: set[tuple[int, int]] | None = None
"""Device and number of each file that the user's study names, once a command guards them."""


def guard_inputs() -> None:
    """Let no output replace a file that `read_input` reads from now on, in a command."""
    global _inputs  # noqa: PLW0603 - a process of its own for each command
    _inputs = set()


def read_input(path: Path, most: int) -> bytes:
    """Return the bytes of a file of the user, as `read_file` does, and guard it."""
    content = read_file(path, most)
    if _inputs is not None:
        status = path.stat()
        _inputs.add((status.st_dev, status.st_ino))
    return content


def _check_regular(status: os.stat_result, path: Path) -> None:
    """Raise OSError unless this is the status of a regular file."""
    if not stat.S_ISREG(status.st_mode):
        kind = _KINDS.get(stat.S_IFMT(status.st_mode), "no file")
        number = errno.EISDIR if stat.S_ISDIR(status.st_mode) else errno.EINVAL
        raise OSError(number, f"it is {kind}, expected a file", str(path))


@contextlib.contextmanager
def whole_file(path: Path, *, of_a_run: bool = False) -> Iterator[Path]:
    """Yield a temporary name to write a file under, which then appears whole or not at all.

    The file of that name stays until then, and if the work is stopped nothing new is left. If
    several processes write at once, the last one wins.

    Args:
        path: Final name of the file.
        of_a_run: True to give a temporary name that the holder of a run's lock may remove.

    Raises:
        OutputError: The file cannot be renamed.
    """
    temporary = temporary_of(path, of_a_run=of_a_run)
    try:
        yield temporary
        with output_errors(path):
            temporary.replace(path)
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
    sync_folder(path.parent)


def write_whole(path: Path, content: bytes, *, of_a_run: bool = False) -> None:
    """Write a small file as `whole_file` does."""
    with whole_file(path, of_a_run=of_a_run) as temporary, output_errors(path):
        _write(temporary, content)


Recogniser: TypeAlias = Callable[[BinaryIO], bool]
"""Function that returns True if tendon wrote the open file."""


def begins_with(mark: str) -> Recogniser:
    """Return a function that recognises files of tendon by the text at their beginning."""
    beginning = mark.encode()
    return lambda file: file.read(len(beginning)) == beginning


def check_output(path: Path, is_ours: Recogniser, *, overwrite: bool = False) -> None:
    """Refuse to replace a file that a user names and that tendon did not write.

    Every file whose name the user chooses is written by way of `output_file`, which calls this.
    Commands call it themselves before they begin a long computation.

    Args:
        path: File to be written.
        is_ours: Function that recognises a file of this kind that tendon wrote.
        overwrite: True to replace whatever file stands there.

    Raises:
        UsageError: The file exists and tendon did not write it, or the command reads it.
        OutputError: It cannot be read, or is a folder, a pipe or a device.
    """
    if not os.path.lexists(path):
        return
    with output_errors(path):
        leads_nowhere = not path.exists()  # a link whose target is gone
        if not leads_nowhere:
            status = path.stat()
            _check_regular(status, path)
            if (status.st_dev, status.st_ino) in (_inputs or ()):
                raise UsageError(
                    "is an input and would be overwritten",
                    where=shorten(str(path), 1000),
                    hint="choose another name",
                )
        may_replace = overwrite or (not leads_nowhere and _is_recognised(path, is_ours))
    if not may_replace:
        raise not_replaced(path, "tendon did not write it")


def not_replaced(path: Path, reason: str) -> UsageError:
    """Return the error for a file of the user that is replaced only if the user insists."""
    return UsageError(
        f"exists already, and {reason}",
        where=shorten(str(path), 1000),
        hint="choose another name; --overwrite (in Python overwrite=True) replaces it",
    )


def _is_recognised(path: Path, is_ours: Recogniser) -> bool:
    """Return True if a function recognises a file."""
    with open_file(path) as file:
        return is_ours(file)


@contextlib.contextmanager
def output_file(path: Path, is_ours: Recogniser, *, overwrite: bool = False) -> Iterator[Path]:
    """Yield a temporary name as `whole_file` does, for a file whose name the user chose.

    Takes and raises what `check_output` does.
    """
    check_output(path, is_ours, overwrite=overwrite)
    with whole_file(path) as temporary:
        yield temporary


def write_output(
    path: Path, content: bytes, is_ours: Recogniser, *, overwrite: bool = False
) -> None:
    """Write a small file whose name the user chose, as `output_file` does."""
    with output_file(path, is_ours, overwrite=overwrite) as temporary, output_errors(path):
        _write(temporary, content)


def what_is_written(path: Path, before: str | None, now: str, held: str) -> str:
    """Return a line that says that a file is written or replaced; call it before it is written.

    Args:
        path: The file.
        before: Source of what stands there, such as the name of a log; None if it does not say.
        now: Source of what will be written.
        held: Noun for what comes from a source, such as "the coefficient".
    """
    if not os.path.lexists(path):
        return f"{path} written"
    if before is None or before == now:
        return f"{path} replaced"
    return f"{path} replaced; before, it held {held} of {shorten(before)}"


def write_new(path: Path, content: bytes) -> bool:
    """Write a small file whole or not at all, unless its name is taken.

    Returns:
        True if the name was free and the file is written.

    Raises:
        OutputError: The file cannot be written.
    """
    if os.path.lexists(path):
        return False
    with output_errors(path):
        temporary = temporary_of(path)
        try:
            _write(temporary, content)
            was_free = _name(temporary, path)
        finally:
            with contextlib.suppress(OSError):
                temporary.unlink(missing_ok=True)
        sync_folder(path.parent)
    return was_free


def _write(temporary: Path, content: bytes) -> None:
    """Write and flush a new file."""
    # Exclusive, so that no file or link of this name is followed or overwritten.
    with temporary.open("xb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def _name(temporary: Path, path: Path) -> bool:
    """Give a finished file its name. Return False if the name is taken, even by a new file."""
    try:
        path.hardlink_to(temporary)
    except FileExistsError:
        return False
    except OSError:
        # Perhaps a file system without links: claim the name first, then replace only the claim.
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


OF_A_RUN = re.compile(r"\.tendon-run-[0-9a-f]{12}\.tmp", re.ASCII)
"""Temporary names in a run folder; the holder of its lock removes those that a kill left."""


def temporary_of(path: Path, *, of_a_run: bool = False) -> Path:
    """Return a name that nobody else has, in the same folder and so the same file system."""
    prefix = ".tendon-run-" if of_a_run else ".tendon-"
    return path.with_name(f"{prefix}{os.urandom(6).hex()}.tmp")


def sync_folder(folder: Path) -> None:
    """Make a rename in a folder last through a power cut, if the system can."""
    with contextlib.suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


@contextlib.contextmanager
def output_errors(path: Path) -> Iterator[None]:
    """Turn an OSError while a file is written into an OutputError that names the file."""
    try:
        yield
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        hint = "free some space, then start again" if "space" in reason else None
        raise OutputError(f"cannot be written: {reason}", where=str(path), hint=hint) from error


# --- Figures that tendon wrote --------------------------------------------------------------------

_SOURCE = rb"tendon (?:study [^\n()<]+ ([0-9a-f]{64})|fit-friction |fit-suit )"
"""Name and hash of a study as `frame.py` of the figures has them, or the mark of a friction fit."""
_PNG = b"\x89PNG\r\n\x1a\n"
_IN_PNG = re.compile(rb"Source\0" + _SOURCE)
_IN_SVG = re.compile(rb"<dc:source>\s*" + _SOURCE)
_IN_PDF = re.compile(rb"/Keywords \(" + _SOURCE)
_MOST_OF_A_PDF = 64 * 10**6
"""Size up to which a PDF is searched, bytes."""
_HEAD_OF_AN_SVG = 10**6
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
        return _IN_PDF.search(file.read(_MOST_OF_A_PDF))
    metadata, end, _ = (beginning + file.read(_HEAD_OF_AN_SVG)).partition(b"</metadata>")
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
        source = _IN_PNG.match(file.read(min(size, _HEAD_OF_AN_SVG)))
        if source is not None:
            return source
        file.seek(max(0, size - _HEAD_OF_AN_SVG) + 4, 1)
    return None


# --- Locks ----------------------------------------------------------------------------------------

LOCK = ".lock"
"""File in the folder of a run that the process which writes there locks."""
_HAS_NO_LOCKS = (errno.ENOLCK, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS)
"""Errors of a file system without locks."""
_LONGEST_MARK = 1000  # bytes


def mark_lock(folder: Path, text: str) -> None:
    """Write into a lock which run holds it, so that workers elsewhere see it; raises OutputError.

    Only the holder of the lock may. An empty text says that no workers are wanted.
    """
    with output_errors(folder / LOCK):
        (folder / LOCK).write_text(text, "utf-8")


def lock_mark(folder: Path) -> str:
    """Return the run that a lock says holds it; empty if it says none, or cannot be read."""
    try:
        return read_file(folder / LOCK, _LONGEST_MARK).decode()
    except (OSError, ValueError):
        return ""


@contextlib.contextmanager
def locked(folder: Path) -> Iterator[bool]:
    """Make the folder of a run, hold its lock, and yield True; False if its file system has none.

    The system releases the lock when its holder dies, however it dies.

    Raises:
        FolderError: Another run holds the lock.
        OutputError: The folder cannot be made.
    """
    flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(folder / LOCK, flags, 0o666)
    except FileExistsError:
        raise FolderError("is a file, expected a folder for the run", where=str(folder)) from None
    except OSError as error:
        raise OutputError(f"cannot be made: {error.strerror}", where=str(folder)) from error
    try:
        yield _lock(handle, folder)
    finally:
        os.close(handle)


def check_unlocked(folder: Path) -> None:
    """Raise FolderError if another run is writing there; leave no trace."""
    with contextlib.suppress(OSError):  # a folder in which no run ever was has no lock
        handle = os.open(folder / LOCK, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
        try:
            _lock(handle, folder, fcntl.LOCK_SH)
        finally:
            os.close(handle)


def _lock(handle: int, folder: Path, kind: int = fcntl.LOCK_EX) -> bool:
    """Lock an open file without waiting, and return True; False if its file system has no locks.

    Raises:
        FolderError: Another run holds the lock, or the file cannot be locked.
    """
    try:
        fcntl.flock(handle, kind | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in _HAS_NO_LOCKS:
            return False
        if error.errno in (errno.EWOULDBLOCK, errno.EACCES):
            hint = "wait for it, or choose another folder with --out"
            raise FolderError("another run is writing here", where=str(folder), hint=hint) from None
        raise FolderError(f"cannot be locked: {error.strerror}", where=str(folder)) from None
    return True
