"""A malformed study: its text, what its error must say, and how soon."""

import signal
from contextlib import contextmanager
from dataclasses import dataclass, field

from tendon_cli.errors import StudyError, TendonError

LONGEST_TIME = 60.0  # seconds; only what hangs needs them


@dataclass(frozen=True)
class Malformed:
    """A study that is refused.

    Attributes:
        label: Name of the test.
        text: Text of the study.
        says: Fragments of the message, the key first.
        line: Line of the first fault.
        kind: Class of the error.
        suffix: Suffix of the study's file name.
        stem: Stem of the study's file name.
        settings: Settings of the command line.
        files: Content of the files beside the study, by name.
    """

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
    """Return a malformed study in TOML."""
    return Malformed(label, text, says, line, **more)


def yaml(label, text, *says, line=None, **more):
    """Return a malformed study in YAML."""
    return Malformed(f"yaml {label}", text, says, line, suffix=".yaml", **more)


@contextmanager
def at_most(seconds):
    """Raise TimeoutError in a block that takes longer."""

    def stop(*_):
        raise TimeoutError(f"longer than {seconds} s")

    previous = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, previous)
