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
    return "".join(
        sign if sign.isprintable() or sign == "\n" else json.dumps(sign)[1:-1] for sign in text
    )


def print_result(result: str | dict[str, Any], *, unless: bool = False) -> None:
    """Write a text, or a record as one JSON object, to stdout, unless it is not wanted; raises OutputError."""
    if unless:
        return
    text = result if isinstance(result, str) else json.dumps(result, indent=2, ensure_ascii=False)
    flush_results(harmless(text) + "\n")


def flush_results(text: str = "") -> None:
    """See a text leave, and what others have written to stdout, such as a help page; raises OutputError."""
    try:
        if text:
            sys.stdout.write(text)
        sys.stdout.flush()
    except (OSError, ValueError) as error:
        give_up_stdout()
        reason = getattr(error, "strerror", None) or error
        raise OutputError(f"standard output cannot be written: {reason}") from error


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
    """Stands for a standard output that cannot be written."""

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
            pass  # nobody reads it there, so it becomes a line
        else:
            return
    place = f"{fault.where}: " if fault.where else ""
    print_note(
        f"tendon: error: {place}{fault.message}" + (f"\n  hint: {fault.hint}" if fault.hint else "")
    )


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
    from rich import progress as rich  # only a terminal pays for its import
    from rich.console import Console

    columns = (
        "{task.description}",
        rich.BarColumn(),
        rich.MofNCompleteColumn(),
        "parts",
        rich.TimeElapsedColumn(),
        "left",
        rich.TimeRemainingColumn(),
    )
    with rich.Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def _plain(title: str) -> Callable[[int, int], None]:
    last = 0

    def update(done: int, total: int) -> None:
        nonlocal last
        if total > 1 and 10 * done // total > last:
            last = 10 * done // total
            print_note(f"{title}: {10 * last} % ({done} of {total} parts)")

    return update


def give_up_stdout() -> None:
    """Try it never again, nor have the interpreter try, and complain, when it ends."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    sys.stdout = _Closed()
