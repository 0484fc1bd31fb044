"""Settings that let a process of tendon start soon and end cleanly.

Only the command line calls them: a program that imports the package is left as it is.
"""

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

_TRIM_THRESHOLD = -1  # names of parameters in mallopt(3) of the GNU C library
_MMAP_THRESHOLD = -3
_MAX_MMAP_THRESHOLD = 32 * 1024 * 1024  # bytes, the largest value that mallopt takes

_SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)
_received: list[int] = []


def _quit(number: int, _frame: FrameType | None) -> None:
    """End the process at once with the exit code of a signal."""
    os._exit(128 + number)


def _interrupt(number: int, _frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt, so that nothing half-written stays; a second Ctrl-C ends at once."""
    if _received and number == signal.SIGINT:
        _quit(number, None)
    _received.append(number)
    if len(_received) == 1:
        raise KeyboardInterrupt


def quit_on_signals() -> None:
    """End at once if a signal arrives while modules are imported.

    Nothing has begun by then that could be left half done.
    """
    _listen(_quit, {signal.default_int_handler, signal.SIG_DFL})


def end_on_signals() -> None:
    """Make a signal raise KeyboardInterrupt from here on."""
    _received.clear()
    _listen(_interrupt, {_quit})


def _listen(handler: Handler, replaced: set[Any]) -> None:
    """Replace handlers of signals; a signal that nohup has the process ignore stays ignored."""
    if threading.current_thread() is not threading.main_thread():
        return
    for number in _SIGNALS:
        if signal.getsignal(number) in replaced:
            signal.signal(number, handler)


def exit_code(code: int = 128 + signal.SIGINT) -> int:
    """Return the exit code that shells expect of a signal if one has arrived, else `code`."""
    if _received:
        return 128 + _received[0]
    return code


@contextlib.contextmanager
def stopped_by_signals(where: str, again: str) -> Iterator[threading.Event]:
    """Yield an event that SIGINT, SIGTERM and SIGHUP set.

    Work that sees the event set raises `Stopped`, which ends in InterruptError here. A second
    SIGINT ends the process at once.

    Args:
        where: Folder that the error names.
        again: Command that finishes the work.

    Raises:
        InterruptError: A signal arrived and the work stopped.
    """
    from tendon_cli.errors import InterruptError, Stopped

    event = threading.Event()
    first_signal = 0

    def stop(number: int, _frame: FrameType | None) -> None:
        nonlocal first_signal
        if first_signal and number == signal.SIGINT:
            os._exit(128 + number)
        first_signal = first_signal or number
        event.set()

    previous_handlers: dict[int, Any] = {}
    if threading.current_thread() is threading.main_thread():
        for number in _SIGNALS:
            if signal.getsignal(number) is not signal.SIG_IGN:
                previous_handlers[number] = signal.signal(number, stop)
    try:
        yield event
    except Stopped:
        raise InterruptError(first_signal, where=where, again=again) from None
    finally:
        for number, handler in previous_handlers.items():
            signal.signal(number, handler)


def spare_time() -> None:
    """Skip work of libraries, at the start and the end of a process, that no command needs."""
    # NumPy would start a thread per core for large matrices, and tendon has none.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Python would look for garbage a hundred times while it imports modules, which leave none,
    gc.set_threshold(100_000)
    # and once more at the end, in all that the process is about to give back.
    atexit.register(gc.freeze)
    # Pydantic would look into every installed package.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # The system's memory is as fast as Arrow's own pool, and gives back what is freed.
    os.environ.setdefault("ARROW_DEFAULT_MEMORY_POOL", "system")


def keep_freed_memory() -> None:
    """Make the C library keep freed memory for the next array.

    A sweep frees and asks for the same arrays many times a second. Otherwise the system takes each
    back and clears it again, which took as long as the arithmetic.
    """
    import ctypes  # not for every command

    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError, TypeError):  # another C library
        return
    mallopt(_MMAP_THRESHOLD, _MAX_MMAP_THRESHOLD)
    mallopt(_TRIM_THRESHOLD, 16 * _MAX_MMAP_THRESHOLD)
