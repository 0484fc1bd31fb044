"""Everything that is printed: results on stdout, everything else on stderr."""

from __future__ import annotations

import contextlib
import errno
import io
import json
import os
import sys
from collections.abc import Callable, Iterator
from typing import Any

from tendon_cli.errors import OutputError, TendonError


def harmless(text: str) -> str:
    """Text whose unprintable characters, but ends of lines, are written out as in JSON: none reaches a terminal raw.

    Names of files, keys, cases and values of records are other people's; an escape among them could rewrite a screen.
    """
    if text.replace("\n", "").isprintable():
        return text
    return "".join(sign if sign.isprintable() or sign == "\n" else _written_out(sign) for sign in text)


def _written_out(sign: str) -> str:
    code = ord(sign)
    if code < 0x10000:
        return f"\\u{code:04x}"
    return f"\\u{0xD7C0 + (code >> 10):04x}\\u{0xDC00 + (code & 0x3FF):04x}"


def print_result(result: str | dict[str, Any], *, unless: bool = False) -> None:
    """Write a text, or a record as one JSON object, to stdout, unless it is not wanted; raises OutputError."""
    if unless:
        return
    text = result if isinstance(result, str) else json.dumps(result, indent=2, ensure_ascii=False)
    if _stdout.lost:
        raise OutputError("standard output cannot be written")
    try:
        sys.stdout.write(harmless(text) + "\n")
        sys.stdout.flush()
    except (OSError, ValueError) as error:
        raise _lost(error) from error


def flush_results() -> None:
    """See everything leave that was written to stdout by others, such as a help page; raises OutputError."""
    try:
        sys.stdout.flush()
    except (OSError, ValueError) as error:
        raise _lost(error) from error


def _lost(error: OSError | ValueError) -> OutputError:
    give_up_stdout()
    return OutputError(f"standard output cannot be written: {getattr(error, 'strerror', None) or error}")


def as_output_error(error: OSError) -> OutputError:
    """An OSError that nobody expected: of standard output, where that cannot be flushed, else of the file it names."""
    try:
        flush_results()  # a help page that nobody could take is still in there
    except OutputError as fault:
        return fault
    file = error.filename
    where = os.fsdecode(file) if isinstance(file, str | bytes | os.PathLike) else None
    return OutputError(f"input or output failed: {error.strerror or error}", where=where)


class _Closed(io.TextIOBase):
    """Stands for a standard output that was closed before Python started."""

    def write(self, _text: str) -> int:
        raise OSError(errno.EBADF, "it is closed")


def prepare_streams() -> None:
    """Print what a narrow terminal cannot show as question marks, and notice a closed standard output."""
    if sys.stdout is None:
        sys.stdout = _Closed()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")


def print_note(text: str) -> None:
    """Write a line to stderr; where that is impossible nobody is listening, and nothing is lost."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        sys.stderr.write(harmless(text) + "\n")
        sys.stderr.flush()


def print_error(fault: TendonError, *, as_json: bool) -> None:
    """Tell of an error: one message on stderr, or with `as_json` one object on stdout."""
    if as_json:
        names = ("exit", "kind", "message", "where", "hint")
        try:
            print_result({"error": {name: getattr(fault, name) for name in names}})
        except OutputError:
            pass  # nobody takes it there, so it is told as a line
        else:
            return
    place = f"{fault.where}: " if fault.where else ""
    print_note(f"tendon: error: {place}{fault.message}" + (f"\n  hint: {fault.hint}" if fault.hint else ""))


@contextlib.contextmanager
def progress(title: str, *, quiet: bool) -> Iterator[Callable[[int, int], None]]:
    """A function to call with finished and all parts: a bar on a terminal, else a plain line per 10 %."""
    if quiet:
        yield lambda _done, _total: None
    elif sys.stderr is not None and sys.stderr.isatty() and os.environ.get("TERM") != "dumb":
        with _bar(title) as update:
            yield update
    else:
        yield _plain(title)


@contextlib.contextmanager
def _bar(title: str) -> Iterator[Callable[[int, int], None]]:
    from rich.console import Console  # only a terminal pays for its import
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("parts"),
               TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn())  # fmt: skip
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def _plain(title: str) -> Callable[[int, int], None]:
    said = 0

    def say(done: int, total: int) -> None:
        nonlocal said
        tenth = 10 * done // total
        if total > 1 and tenth > said:
            said = tenth
            print_note(f"{title}: {10 * tenth} % ({done} of {total} parts)")

    return say


class _Stdout:
    """Whether standard output has failed once; it is then not tried again."""

    lost = False


_stdout = _Stdout()


def give_up_stdout() -> None:
    """Keep the interpreter from trying, and complaining, once more when it ends."""
    _stdout.lost = True
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
