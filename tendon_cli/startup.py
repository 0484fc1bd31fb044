"""What lets a process of tendon start and end soon; a program that imports the package is left as it is."""

from __future__ import annotations

import atexit
import gc
import os
import signal
from types import FrameType

_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3  # mallopt(3) of the GNU C library
_MOST_MMAP_THRESHOLD = 32 * 1024 * 1024


def _quit(number: int, _frame: FrameType | None) -> None:
    os._exit(128 + number)


def quit_on_interrupts() -> None:
    """End at once on Ctrl-C while modules are read, where nothing is begun that could be left half done."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _quit)


def hear_interrupts() -> None:
    """Have Ctrl-C raise KeyboardInterrupt again."""
    if signal.getsignal(signal.SIGINT) is _quit:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def spare_time() -> None:
    """Leave out what the libraries do at the start and the end of a process that no command needs."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # else numpy starts a thread per core, for matrices nobody has
    gc.set_threshold(100_000)  # else Python looks for garbage a hundred times while it reads modules, which leave none
    atexit.register(gc.freeze)  # and once more, at the end, in all that the process is about to give back
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # else pydantic looks into every installed package
    os.environ.setdefault("ARROW_DEFAULT_MEMORY_POOL", "system")  # as fast as its own, and gives back what it frees


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
