"""Signals that end a long command cleanly."""

import contextlib
import os
import signal
import threading
from collections.abc import Iterator
from types import FrameType

from tendon_cli.errors import InterruptError, Stopped


@contextlib.contextmanager
def stopped_by_signals(where: str, *, keeps_parts: bool = True) -> Iterator[threading.Event]:
    """An event that SIGINT, SIGTERM and SIGHUP set; the work that heeds it ends in InterruptError.

    `keeps_parts` says whether what was finished of the work stays.

    A second SIGINT ends the process at once.
    """
    event, first = threading.Event(), 0

    def ask(number: int, _frame: FrameType | None) -> None:
        nonlocal first
        if first and number == signal.SIGINT:
            os._exit(128 + number)
        first = first or number
        event.set()

    on_main = threading.current_thread() is threading.main_thread()
    signals = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP) if on_main else ()
    heard = [number for number in signals if signal.getsignal(number) is not signal.SIG_IGN]  # nohup stays nohup
    before = [signal.signal(number, ask) for number in heard]
    try:
        yield event
    except Stopped:
        raise InterruptError(first, where=where, keeps_parts=keeps_parts) from None
    finally:
        for number, handler in zip(heard, before, strict=True):
            signal.signal(number, handler)
