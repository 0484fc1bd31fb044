"""Errors that tendon raises on purpose, one class for each exit code.

Anything that a user or the machine got wrong is raised as a `TendonError` and printed once, by
`tendon_cli.commands.cli`. Any other exception that reaches it is a bug in tendon (exit 1).
"""

from __future__ import annotations

import errno
import signal
import sys
from dataclasses import dataclass

EXIT_BUG = 1
EXIT_NEGATIVE = 4
"""Finished, but the result is negative: some states have no equilibrium, a limit is broken."""


class TendonError(Exception):
    """Error with its place and a way out of it.

    Attributes:
        exit: Exit code of the commands.
        kind: Name of the sort of error in JSON.
        message: What is wrong.
        where: File, option or key at which it is wrong, if known.
        hint: What would help, if known.
    """

    exit: int = EXIT_BUG
    kind: str = "bug"

    def __init__(self, message: str, *, where: str | None = None, hint: str | None = None) -> None:
        super().__init__(message)
        self.message = message
        self.where = where
        self.hint = hint

    def __str__(self) -> str:
        """Return place and message, as a traceback and the commands print them."""
        return f"{self.where}: {self.message}" if self.where else self.message


def install_hint(package: str) -> str:
    """Return the command that installs a package where this tendon is installed.

    It names the package itself, not an extra of tendon: tendon's own name on an index may be a
    stranger's.
    """
    import importlib.util  # only who lacks a package pays for its import

    if importlib.util.find_spec("pip") is None:
        return f"uv pip install --python {sys.executable} {package}"
    return f"{sys.executable} -m pip install {package}"


class UsageError(TendonError):
    """The command line asks for something that does not exist or does not fit together."""

    exit = 2
    kind = "usage"


@dataclass(frozen=True)
class Fault:
    """One fault of a study: its key, the problem, a hint, and its line if known."""

    key: str
    problem: str
    hint: str | None = None
    line: int | None = None
    is_implausible: bool = False
    """True if the value is possible, but far from any arm."""
    is_of_file: bool = False
    """True if it stands in a CSV that the study names, and not in the study."""
    file: str | None = None
    """File in which it stands, from the folder of the study; None for the study's own file."""

    @property
    def is_of_whole_file(self) -> bool:
        """True if it stands in no line and at no key, such as a file that does not exist."""
        return not self.key and self.line is None and self.file is None

    def __str__(self) -> str:
        line = None if self.line is None else f"line {self.line}"
        place = ", ".join(part for part in (self.file, line) if part is not None)
        place = f"{place}: " if place else ""
        advice = f" ({self.hint})" if self.hint else ""
        key = f"{self.key}: " if self.key else ""
        return f"{place}{key}{self.problem}{advice}"


class StudyError(TendonError):
    """A study file that cannot be used; carries every fault found in it, not only the first."""

    exit = 2
    kind = "study"

    def __init__(self, faults: list[Fault], *, where: str | None = None) -> None:
        self.faults = faults
        count = "1 fault" if len(faults) == 1 else f"{len(faults)} faults"
        lines = "\n".join(f"  {fault}" for fault in faults)
        hint = (
            "`tendon init --schema` lists every key with its unit; "
            "`tendon init` writes a commented example"
        )
        if any(fault.is_implausible for fault in faults):
            hint = "allow_implausible = true at the top of the study accepts implausible numbers"
        if len(faults) == 1 and faults[0].is_of_whole_file:
            super().__init__(faults[0].problem, where=where, hint=faults[0].hint or hint)
            return
        super().__init__(f"the study has {count}:\n{lines}", where=where, hint=hint)


class SizeError(TendonError):
    """A study too large to run: too many states, too long an axis, or too many bytes."""

    exit = 2
    kind = "size"


class InputError(TendonError):
    """Input data that cannot be trusted: a CSV, a route, a damaged or foreign table."""

    exit = 3
    kind = "input"


class OutputError(TendonError):
    """Something could not be written: full disk, missing permission, closed standard output."""

    exit = 5
    kind = "output"


class WorkersLostError(TendonError):
    """Parts of the sweep failed or their workers died; what was finished is kept."""

    exit = 6
    kind = "workers"


class MemoryShortError(TendonError):
    """There is not enough memory; what was finished is kept."""

    exit = 6
    kind = "memory"


_TEXTS_OF_SHORT_MEMORY = (
    "Cannot allocate memory",
    "failed to map segment",
    "can't start new thread",
    "malloc of size",
    "realloc of size",
)


def is_memory_short(error: BaseException) -> bool:
    """Return True if an error means that there is no memory left."""
    if isinstance(error, MemoryError):
        return True
    if isinstance(error, OSError) and error.errno == errno.ENOMEM:
        return True
    if isinstance(error, (OSError, ImportError, RuntimeError)):
        message = str(error)
        return any(text in message for text in _TEXTS_OF_SHORT_MEMORY)
    # A pool of threads that could not be started fails again while it tidies up.
    if isinstance(error, AttributeError) and error.__context__ is not None:
        return is_memory_short(error.__context__)
    return False


class InterruptError(TendonError):
    """A signal ended the run cleanly; the exit code is the one that shells expect of it."""

    kind = "stopped"

    def __init__(self, number: int, *, where: str, again: str) -> None:
        message = f"stopped by {signal.Signals(number).name}; the parts that were finished are kept"
        super().__init__(message, where=where, hint=f"`{again}` continues where it stopped")
        self.exit = 128 + number


class FolderError(TendonError):
    """The run folder is in use, unfinished, or belongs to something else."""

    exit = 7
    kind = "folder"


class Stopped(Exception):  # noqa: N818 - not a fault: somebody asked for it
    """The work was asked to stop; parts that were being made leave nothing behind."""
