"""A guard against what never ends."""

import signal
from contextlib import contextmanager

LONGEST_TIME = 60.0  # seconds; only what hangs needs them


@contextmanager
def at_most(seconds):
    """Interrupts what takes longer."""

    def stop(*_):
        raise TimeoutError(f"longer than {seconds} s")

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
