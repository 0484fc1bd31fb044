"""What lets a process of tendon start soon and end cleanly; a program that imports the package is left as it is."""

from __future__ import annotations

import atexit
import contextlib
import gc
import os
import signal
import threading
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

Handler = Callable[[int, FrameType | None], None]

_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3  # mallopt(3) of the GNU C library
_MOST_MMAP_THRESHOLD = 32 * 1024 * 1024


_SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)
_received: list[int] = []


def _quit(number: int, _frame: FrameType | None) -> None:
    os._exit(128 + number)


def _interrupt(number: int, _frame: FrameType | None) -> None:
    """End what is being done as Ctrl-C does, so that nothing half-written stays; a second Ctrl-C ends it at once."""
    if _received and number == signal.SIGINT:
        _quit(number, None)
    _received.append(number)
    if len(_received) == 1:
        raise KeyboardInterrupt


def quit_on_signals() -> None:
    """End at once if a signal asks for it while modules are read: nothing has begun that could be left half done."""
    _listen(_quit, {signal.default_int_handler, signal.SIG_DFL})


def end_on_signals() -> None:
    """Have a signal raise KeyboardInterrupt from here on."""
    _received.clear()
    _listen(_interrupt, {_quit})


def _listen(handler: Handler, instead: set[Any]) -> None:
    """Handle every signal that is handled by one of those now; what nohup has the process ignore stays ignored."""
    if threading.current_thread() is threading.main_thread():
        for number in _SIGNALS:
            if signal.getsignal(number) in instead:
                signal.signal(number, handler)


def exit_code(code: int = 128 + signal.SIGINT) -> int:
    """The exit code of a command that a signal has ended, as shells have it, else `code`."""
    return 128 + _received[0] if _received else code


@contextlib.contextmanager
def stopped_by_signals(where: str) -> Iterator[threading.Event]:
    """An event that SIGINT, SIGTERM and SIGHUP set; the work that heeds it ends in InterruptError.

    A second SIGINT ends the process at once.
    """
    from tendon_cli.errors import InterruptError, Stopped

    event, first = threading.Event(), 0

    def ask(number: int, _frame: FrameType | None) -> None:
        nonlocal first
        if first and number == signal.SIGINT:
            os._exit(128 + number)
        first = first or number
        event.set()

    on_main = threading.current_thread() is threading.main_thread()
    heard = [
        number for number in _SIGNALS if on_main and signal.getsignal(number) is not signal.SIG_IGN
    ]
    before = [signal.signal(number, ask) for number in heard]
    try:
        yield event
    except Stopped:
        raise InterruptError(first, where=where) from None
    finally:
        for number, handler in zip(heard, before, strict=True):
            signal.signal(number, handler)


def spare_time() -> None:
    """Leave out what the libraries do at the start and the end of a process that no command needs."""
    os.environ.setdefault(
        "OPENBLAS_NUM_THREADS", "1"
    )  # else numpy starts a thread per core, for matrices nobody has
    gc.set_threshold(
        100_000
    )  # else Python looks for garbage a hundred times while it reads modules, which leave none
    atexit.register(
        gc.freeze
    )  # and once more, at the end, in all that the process is about to give back
    os.environ.setdefault(
        "PYDANTIC_DISABLE_PLUGINS", "__all__"
    )  # else pydantic looks into every installed package
    os.environ.setdefault(
        "ARROW_DEFAULT_MEMORY_POOL", "system"
    )  # as fast as Arrow's, and gives back what it frees


def keep_freed_memory() -> None:
    """Have the C library keep what is freed: a sweep frees and asks for the same arrays again, many times a second.

    Otherwise the system takes each back and clears it anew, which took as long as the arithmetic.
    """
    import ctypes  # not for every command

    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError, TypeError):  # another C library
        return
    mallopt(_MMAP_THRESHOLD, _MOST_MMAP_THRESHOLD)
    mallopt(_TRIM_THRESHOLD, 16 * _MOST_MMAP_THRESHOLD)
