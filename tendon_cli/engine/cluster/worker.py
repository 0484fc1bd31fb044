"""A worker's side of a run: rebuild the task, make parts, put their files into the run folder.

Nothing here knows the cluster's library. A worker answers with what it made or why it did not; it
never raises. The cluster may give a part to a second worker while a first one, thought dead, still
writes. So each worker writes under names that nobody else has, and renames at the very end, if the
folder still holds the run.
"""

from __future__ import annotations

import contextlib
import json
import platform
import threading
import time
import uuid
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from tendon_cli.engine.journal import JOURNAL
from tendon_cli.engine.task import PartMaker, PartResult, Task
from tendon_cli.errors import OutputError, Stopped, TendonError, WorkersLostError
from tendon_cli.registry import record_names
from tendon_cli.studies.load import recorded_study
from tendon_cli.tables.schema import versions
from tendon_cli.version import RESULTS_VERSION

_MOST_RUNS = 4
"""Most runs whose makers are kept in a process."""
_HEAD = 2**14
"""Bytes at the beginning of a record that hold the hash of its study."""
_PATIENCE = 5.0
"""Seconds after which a network file system should show what was written elsewhere."""

_MAKERS: dict[str, _RemoteMaker] = {}
"""Makers of this process, by the names of their runs."""
_LOCK = threading.Lock()


@dataclass(frozen=True)
class Assignment:
    """Facts of a run that a worker needs; small, since they go with every part."""

    run: str
    """A name that no other run has."""
    folder: str
    """The run folder, absolute."""
    study_hash: str
    record: str
    """The resolved study, the order of its axes and what its files gave, as JSON."""
    kind: type[Task]
    parts: int
    """Number of parts of the run."""
    versions: dict[str, str]
    """Versions that a worker must have."""

    @classmethod
    def of(cls, maker: PartMaker) -> Assignment:
        """Return the assignment that lets any worker make the same parts."""
        task = maker.task
        return cls(
            run=uuid.uuid4().hex,
            folder=str(maker.folder.absolute()),
            study_hash=task.study.hash,
            record=json.dumps(task.study.record),
            kind=type(task),
            parts=task.parts,
            versions=all_versions(),
        )

    def task(self) -> Task:
        """Return the task, its study rebuilt without its files."""
        return self.kind.of(recorded_study(json.loads(self.record)))

    def is_in_folder(self) -> bool:
        """Return True if the run folder is seen from here and holds this study.

        The journal of an unfinished run names the study, or the record of one that is repaired.
        """
        mark = f'"study_hash": "{self.study_hash}"'.encode()
        for name in (JOURNAL, *record_names()):
            with contextlib.suppress(OSError), (Path(self.folder) / name).open("rb") as file:
                beginning = file.readline() if name == JOURNAL else file.read(_HEAD)
                if mark in beginning:
                    return True
        return False


@dataclass(frozen=True)
class Refusal:
    """Reason why a worker did not make a part; "unfit" if it can make no part of this run."""

    kind: Literal["unfit", "output", "stopped", "failed"]
    reason: str
    where: str | None = None
    hint: str | None = None
    host: str = field(default_factory=platform.node)

    def error(self) -> Exception:
        """Return the exception that the run raises for this refusal."""
        if self.kind == "unfit":
            where = f"worker {self.host}"
            if self.where:
                where += f": {self.where}"
            return WorkersLostError(self.reason, where=where, hint=self.hint)
        reason = f"{self.reason}, on worker {self.host}"
        if self.kind == "output":
            return OutputError(reason, where=self.where, hint=self.hint)
        return Stopped() if self.kind == "stopped" else OnWorkerError(reason)


class OnWorkerError(Exception):
    """Failure of a part on a worker, in that worker's words."""


class Unfit(Exception):  # noqa: N818 - a state of this worker
    """This worker cannot take part in a run."""


def all_versions() -> dict[str, str]:
    """Return all versions on which the bytes of a table depend."""
    return {**versions(), "results": str(RESULTS_VERSION)}


def check_versions(expected: dict[str, str]) -> Refusal | None:
    """Return a refusal if this worker's versions would give other bytes, else None."""
    installed = all_versions()
    wrong = [
        f"{name} {installed[name]} instead of {version}"
        for name, version in expected.items()
        if installed[name] != version
    ]
    if not wrong:
        return None
    hint = "tables have the same bytes only from the same versions; install these on every worker"
    return Refusal("unfit", f"this worker has {', '.join(wrong)}", hint=hint)


def prepare_worker(assignment: Assignment) -> Refusal | None:
    """Prepare this worker for a run; return a refusal if it cannot take part, else None."""
    try:
        _maker(assignment)
    except Unfit as error:
        hint = (
            "workers write into the run folder themselves: "
            "it must be shared, and have the same path everywhere"
        )
        return Refusal("unfit", str(error), where=assignment.folder, hint=hint)
    return None


def make_part(assignment: Assignment, index: int) -> PartResult | Refusal:
    """Make a part and put its files in place, or return a refusal with the reason."""
    refusal = check_versions(assignment.versions) or prepare_worker(assignment)
    if refusal is not None:
        return refusal
    try:
        return _maker(assignment).make(index)
    except Stopped:
        return Refusal("stopped", "stopped")
    except Unfit as error:
        return Refusal("unfit", str(error), where=assignment.folder)
    except OutputError as error:
        return Refusal("output", error.message, error.where, error.hint)
    except Exception as error:  # noqa: BLE001 - it goes back with the part's coordinates
        return Refusal("failed", f"{type(error).__name__}: {error}")


def halt(run: str) -> None:
    """End the parts of a run that are being made here; they leave nothing behind."""
    maker = _MAKERS.get(run)
    if maker is not None:
        maker.task.stop.set()


@dataclass(frozen=True)
class _RemoteMaker(PartMaker):
    """Makes parts for a run elsewhere, and puts them in place only while that run goes on."""

    assignment: Assignment = field(kw_only=True)

    def check(self) -> None:
        """Raise Unfit if the folder does not hold this run any more."""
        if not self.assignment.is_in_folder():
            raise Unfit("the run folder is gone, or holds another run by now")


def _maker(assignment: Assignment) -> _RemoteMaker:
    """Return the maker of a run, built once in this process; raises Unfit."""
    with _LOCK:
        if assignment.run not in _MAKERS:
            maker = _new_maker(assignment)
            while len(_MAKERS) >= _MOST_RUNS:
                oldest = next(iter(_MAKERS))
                del _MAKERS[oldest]
            _MAKERS[assignment.run] = maker
        return _MAKERS[assignment.run]


def _new_maker(assignment: Assignment) -> _RemoteMaker:
    """Build the maker of a run as soon as its folder is seen from here; raises Unfit."""
    deadline = time.monotonic() + _PATIENCE
    while not assignment.is_in_folder():
        if time.monotonic() > deadline:
            raise Unfit("this worker does not see the run folder")
        time.sleep(0.2)
    try:
        task = assignment.task()
    except TendonError as error:
        raise Unfit(f"this worker cannot read the study: {error.message}") from None
    if (task.study.hash, task.parts) != (assignment.study_hash, assignment.parts):
        raise Unfit("this worker reads the study differently: its tendon is another version")
    return _RemoteMaker(task, Path(assignment.folder), assignment=assignment)
