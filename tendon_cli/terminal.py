"""Output of the commands: results on stdout, everything else on stderr."""

from __future__ import annotations

import contextlib
import errno
import io
import json
import os
import select
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, TypeAlias

from tendon_cli.errors import OutputError, Stopped, TendonError


def harmless(text: str) -> str:
    """Return a text whose unprintable characters, except ends of lines, are escaped as in JSON.

    Names of files, keys, cases and values of records are other people's; an escape sequence among
    them could rewrite a screen.
    """
    if text.replace("\n", "").isprintable():
        return text
    signs = []
    for sign in text:
        is_harmless = sign.isprintable() or sign == "\n"
        signs.append(sign if is_harmless else json.dumps(sign)[1:-1])
    return "".join(signs)


def print_result(result: str | dict[str, Any], *, unless: bool = False) -> None:
    """Write a text, or a record as one JSON object, to stdout.

    Args:
        result: Text or record.
        unless: True to write nothing.

    Raises:
        OutputError: Standard output cannot be written.
    """
    if unless:
        return
    text = result if isinstance(result, str) else json.dumps(result, indent=2, ensure_ascii=False)
    flush_results(harmless(text) + "\n")


def flush_results(text: str = "") -> None:
    """Write a text to stdout and flush it, with what others wrote there, such as a help page.

    Raises:
        OutputError: Standard output cannot be written.
    """
    try:
        if text:
            sys.stdout.write(text)
        sys.stdout.flush()
    except (OSError, ValueError) as error:
        give_up_stdout()
        reason = getattr(error, "strerror", None) or error
        raise OutputError(f"standard output cannot be written: {reason}") from error


def as_output_error(error: OSError) -> OutputError:
    """Return an unexpected OSError as an OutputError.

    It is an error of standard output if that cannot be flushed, else of the file that it names.
    """
    try:
        flush_results()  # a help page that nobody could take may still be in there
    except OutputError as fault:
        return fault
    file = error.filename
    where = os.fsdecode(file) if isinstance(file, str | bytes | os.PathLike) else None
    return OutputError(f"input or output failed: {error.strerror or error}", where=where)


class _Closed(io.TextIOBase):
    """Standard output that cannot be written."""

    def write(self, _text: str) -> int:
        raise OSError(errno.EBADF, "it is closed")


def prepare_streams() -> None:
    """Make the streams print "?" for signs that they cannot encode, and notice a closed stdout."""
    if sys.stdout is None:
        sys.stdout = _Closed()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")


def print_note(text: str) -> None:
    """Write a line to stderr; if that is impossible nobody is listening, and nothing is lost."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        sys.stderr.write(harmless(text) + "\n")
        sys.stderr.flush()


def print_error(fault: TendonError, *, as_json: bool) -> None:
    """Print an error: one message on stderr, or with `as_json` one object on stdout."""
    if as_json:
        names = ("exit", "kind", "message", "where", "hint")
        try:
            print_result({"error": {name: getattr(fault, name) for name in names}})
        except OutputError:
            pass  # nobody reads it there, so it becomes a line
        else:
            return
    hint = f"\n  hint: {fault.hint}" if fault.hint else ""
    print_note(f"tendon: error: {fault}{hint}")


def can_ask() -> bool:
    """Return True if somebody at a terminal can read a question and answer it."""
    streams = (sys.stdin, sys.stderr)
    return all(stream is not None and stream.isatty() for stream in streams)


def is_confirmed(question: str, stop: threading.Event) -> bool:
    """Ask a question on the terminal; return True if the answer is yes.

    Args:
        question: The question.
        stop: Event that a signal sets.

    Raises:
        Stopped: A signal came before the answer.
    """
    sys.stderr.write(f"{harmless(question)} [y/N] ")
    sys.stderr.flush()
    while not select.select([sys.stdin], [], [], 0.1)[0]:
        if stop.is_set():
            raise Stopped
    return sys.stdin.readline().strip().lower() in ("y", "yes")


Update: TypeAlias = Callable[[int, int], None]
"""Called with a number that grows, and with the largest that it may reach."""


@dataclass(frozen=True)
class Shown:
    """Functions that show how far a command is."""

    parts: Update
    """Called with the numbers of finished and of all parts."""
    cells: Update
    """Called with the numbers of cells examined and of most cells in a proof."""


_LONGEST_SILENCE = 10.0
"""Time after which a line is written although no tenth is finished, s."""
_SILENCE_IN_LONG_RUNS = 0.1
"""The same time as a share of the time since the start, if that is longer."""


@contextlib.contextmanager
def progress(title: str, *, quiet: bool) -> Iterator[Shown]:
    """Yield functions that show a bar on a terminal, else a line for every 10 % or 10 s."""
    if quiet:
        yield Shown(lambda _done, _total: None, lambda _cells, _most: None)
    elif sys.stderr is not None and sys.stderr.isatty() and os.environ.get("TERM") != "dumb":
        with _bar(title) as shown:
            yield shown
    else:
        yield Shown(
            parts=_plain(title, "({done:,} of {total:,} parts)", "{done:,} of {total:,} parts"),
            cells=_plain(
                f"{title}: proof",
                "of at most {total:,} cells",
                "{done:,} of at most {total:,} cells",
            ),
        )


@contextlib.contextmanager
def _bar(title: str) -> Iterator[Shown]:
    """Yield functions that move a bar on the terminal: one of parts, later one of a proof.

    The bar appears when one of them is called first. Until then a question may be asked below.
    """
    from rich import progress as rich  # only a terminal pays for its import
    from rich.console import Console
    from rich.text import Text

    class TimeLeft(rich.TimeRemainingColumn):
        """Time that is left; nothing if it is not known."""

        def render(self, task: rich.Task) -> Text:
            is_known = task.time_remaining is not None and not task.finished
            return Text.assemble(super().render(task), " left") if is_known else Text("")

    columns = (
        "{task.description}",
        rich.BarColumn(),
        "{task.fields[count]}",
        rich.TimeElapsedColumn(),
        TimeLeft(),
    )
    bar = rich.Progress(*columns, console=Console(stderr=True), transient=True)
    parts = bar.add_task(title, total=None, count="", visible=False)
    # A proof may end long before the most cells that it may take, so its bar has no end.
    proof = bar.add_task(f"{title}: proof", total=None, count="", start=False, visible=False)

    def show_parts(done: int, total: int) -> None:
        count = f"{done:,}/{total:,} parts"
        bar.update(parts, completed=done, total=total, count=count, visible=True)
        bar.start()

    def show_cells(cells: int, most: int) -> None:
        count = f"{cells:,} of at most {most:,} cells"
        bar.start_task(proof)
        bar.update(parts, visible=False)
        bar.update(proof, count=count, visible=True)
        bar.start()

    try:
        yield Shown(show_parts, show_cells)
    finally:
        if bar.live.is_started:
            bar.stop()


def _plain(title: str, of_tenth: str, between: str) -> Update:
    """Return a function that writes a line for every tenth, anew if the number falls.

    If a tenth takes long, it writes a line in between every 10 s. In a long run these lines get
    rarer, so that they do not fill a log.

    Args:
        title: Beginning of each line.
        of_tenth: End of a line for a tenth, after its per cent; a form with `done` and `total`.
        between: End of a line in between, a form with both, too.
    """
    last_tenth = 0
    started = time.monotonic()
    last_line = started

    def update(done: int, total: int) -> None:
        nonlocal last_tenth, last_line
        tenth = 10 * done // total
        is_new_tenth = tenth > last_tenth
        now = time.monotonic()
        longest_silence = max(_LONGEST_SILENCE, _SILENCE_IN_LONG_RUNS * (now - started))
        is_overdue = now - last_line >= longest_silence
        if total > 1 and (is_new_tenth or is_overdue):
            form = f"{10 * tenth} % {of_tenth}" if is_new_tenth else between
            print_note(f"{title}: {form.format(done=done, total=total)}")
            last_line = now
        last_tenth = tenth

    return update


def give_up_stdout() -> None:
    """Never write to stdout again, so that the interpreter does not complain when it ends."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    sys.stdout = _Closed()
