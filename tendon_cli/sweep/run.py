"""Running a sweep: parts in parallel, each recorded when it stands, the run declared finished at the very end."""

from __future__ import annotations

import contextlib
import os
import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from typing import Any

from tendon_cli.errors import (
    FolderError,
    MemoryShortError,
    OutputError,
    Stopped,
    TendonError,
    WorkersLostError,
    is_memory_short,
)
from tendon_cli.sweep.journal import NAME as JOURNAL
from tendon_cli.sweep.journal import Journal
from tendon_cli.sweep.ownership import check_folder
from tendon_cli.sweep.part import PartFailure, PartMaker, PartResult, Runner, part_index
from tendon_cli.sweep.record import read_record, stands
from tendon_cli.sweep.results import record_of
from tendon_cli.sweep.run_folder import RunFolder
from tendon_cli.sweep.threads import in_threads

Progress = Callable[[int, int], None]
"""Called with the number of finished parts and of all parts."""


@dataclass(frozen=True)
class Outcome:
    """A run that stands in its folder: its record, and whether it had stood there before."""

    record: dict[str, Any]
    up_to_date: bool


def available_cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def run(
    folder: RunFolder,
    *,
    jobs: int,
    stop: threading.Event,
    progress: Progress,
    resume: bool = False,
    overwrite: bool = False,
    runner: Runner | None = None,
) -> Outcome:
    """Compute a plan into its locked folder, by default in `jobs` threads of this process.

    Raises FolderError where something else stands there, SizeError, OutputError, WorkersLostError for parts that
    failed, Stopped where `stop` was set; whatever was finished until then is kept and can be resumed.
    """
    check_folder(folder, resume=resume, overwrite=overwrite)
    replaces = overwrite and folder.clear()
    started, plan = time.monotonic(), folder.plan
    runner = runner or in_threads(min(jobs, plan.parts))
    record = read_record(folder.path)
    if record is not None:
        return _repaired(folder, record, runner if resume else None, stop)
    journal = _begun(folder, replaces=replaces)
    resumed = len(journal.parts)

    def take(result: PartResult) -> None:
        journal.add(result)
        progress(len(journal.parts), plan.parts)

    progress(resumed, plan.parts)
    missing = (index for index in range(plan.parts) if index not in journal.parts)
    compute(_maker(folder, stop), runner, missing, take)
    seconds = time.monotonic() - started
    return Outcome(record_of(folder, list(journal.parts.values()), resumed, seconds), up_to_date=False)


def _begun(folder: RunFolder, *, replaces: bool) -> Journal:
    """The journal of the run, on the disk, with what of an unfinished one stands."""
    path = folder.path / JOURNAL
    journal = Journal(path) if replaces else Journal.read(path)
    journal.parts = folder.intact(journal.parts)
    figures = list(journal.figures)
    journal.start(folder.header())
    if figures:
        journal.announce(figures)
    return journal


def _repaired(folder: RunFolder, record: dict[str, Any], runner: Runner | None, stop: threading.Event) -> Outcome:
    """A finished run whose damaged parts are computed again, if they may be; the same parts give the same bytes."""
    entries = {entry["path"]: entry for entry in record["files"]}
    damaged = [path for path, entry in entries.items() if not stands(folder.path, entry)]
    if not damaged:
        return Outcome(record, up_to_date=True)
    if runner is None:
        raise FolderError(
            f"{len(damaged)} of {len(entries)} files are missing or damaged, the first is {damaged[0]}",
            where=str(folder.path),
            hint="--resume computes just these anew",
        )

    def take(result: PartResult) -> None:
        for name, file in result.files.items():
            entries[name].update(asdict(file))

    compute(_maker(folder, stop), runner, sorted({part_index(path) for path in damaged}), take)
    return Outcome({**record, "repaired": damaged}, up_to_date=False)


def _maker(folder: RunFolder, stop: threading.Event) -> PartMaker:
    for table in folder.plan.study.output.tables:
        folder.prepare(table)
    return PartMaker(folder.plan, folder.path, stop)


def compute(maker: PartMaker, runner: Runner, parts: Iterable[int], take: Callable[[PartResult], None]) -> None:
    """Make parts and hand each over as it is finished; raises for those that failed when the others are done."""
    failures: list[PartFailure] = []
    with contextlib.closing(runner(maker, iter(parts))) as results:  # nothing is out when the folder is let go
        try:
            for result in results:
                failure = _taken(result, take)
                if failure is None:
                    continue
                failures.append(failure)
                if isinstance(failure.error, OutputError):
                    maker.stop.set()  # the next part would not fit either
        except BaseException:  # such as KeyboardInterrupt: the parts that are being made end at once
            maker.stop.set()
            raise
    _raise_for(failures, maker)


def _taken(result: PartResult | PartFailure, take: Callable[[PartResult], None]) -> PartFailure | None:
    """Hand a finished part over; what fails at that is a failure of the part, so that the others come to their end."""
    if isinstance(result, PartFailure):
        return result
    try:
        take(result)
    except OutputError as error:
        return PartFailure(result.index, error)
    return None


def _raise_for(failures: list[PartFailure], maker: PartMaker) -> None:
    """Raise for the parts that failed: what stopped the writing first, then a stop, then anything else."""
    faults = [failure for failure in failures if not isinstance(failure.error, Stopped)]
    for failure in faults:
        if isinstance(failure.error, TendonError):
            raise failure.error
    if faults:
        first = faults[0]
        if is_memory_short(first.error):
            where, hint = str(maker.folder), "fewer --jobs need less; --resume goes on"
            raise MemoryShortError(
                f"there is not enough memory for {place(maker, first.index)}", where=where, hint=hint
            ) from first.error
        raise WorkersLostError(
            f"{len(faults)} of {maker.plan.parts} parts failed, the others are kept; first "
            f"{place(maker, first.index)}: {type(first.error).__name__}: {first.error}",
            where=str(maker.folder),
            hint="--resume tries the failed parts again",
        ) from first.error
    if failures:
        raise failures[0].error


def place(maker: PartMaker, index: int) -> str:
    """A part by its designs and where on the axes it starts."""
    plan, designs = maker.plan, maker.plan.part(index)
    at = [
        f"{axis.key}={axis.names[position] if axis.values is None else format(axis.values[position], '.6g')}"
        for axis, position in zip(plan.axes, plan.coordinates(designs.start), strict=True)
    ]
    return f"part {index} (designs {designs.start} to {designs.stop - 1}, from {', '.join(at) or 'the only design'})"
