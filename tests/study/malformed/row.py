"""What is known of a malformed study: its text, and what its error must say, and soon."""

import signal
from contextlib import contextmanager
from dataclasses import dataclass, field

from tendon_cli.errors import StudyError, TendonError

LONGEST_TIME = 60.0  # seconds; only what hangs needs them


@dataclass(frozen=True)
class Malformed:
    """A study that is refused. `says` are fragments of the message, the key first; `line` that of the first fault."""

    label: str
    text: str | bytes
    says: tuple[str, ...]
    line: int | None = None
    kind: type[TendonError] = StudyError
    suffix: str = ".toml"
    stem: str = "study"
    settings: tuple[str, ...] = ()
    files: dict[str, str | bytes] = field(default_factory=dict)


def toml(label, text, *says, line=None, **more):
    return Malformed(label, text, says, line, **more)


def yaml(label, text, *says, line=None, **more):
    return Malformed(f"yaml {label}", text, says, line, suffix=".yaml", **more)


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
