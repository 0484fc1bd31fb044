"""Running a plan: parts in parallel, here in threads, each recorded when it stands.

In threads some parts compute while others wait for the disk.
"""

from __future__ import annotations

import contextlib
import os
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict
from functools import partial
from itertools import takewhile
from typing import Any, TypeVar

from tendon_cli.engine.ownership import check_folder
from tendon_cli.engine.part import PartFailure, PartMaker, PartResult, Results, Runner, part_index
from tendon_cli.engine.record import JOURNAL, Journal, lost, read_record
from tendon_cli.engine.results import Run, record_of
from tendon_cli.engine.run_folder import RunFolder
from tendon_cli.errors import (
    FolderError,
    MemoryShortError,
    OutputError,
    Stopped,
    TendonError,
    WorkersLostError,
    is_memory_short,
)

Progress = Callable[[int, int], None]
"""Called with the number of finished parts and of all parts."""

Made = TypeVar("Made")


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
) -> Run:
    """Compute a plan into its locked folder, by default in `jobs` threads of this process; not yet recorded there.

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
    return Run(record_of(folder, list(journal.parts.values()), resumed, seconds), folder.path)


def _begun(folder: RunFolder, *, replaces: bool) -> Journal:
    """The journal of the run, on the disk, with what of an unfinished one stands."""
    journal = Journal(folder.path / JOURNAL) if replaces else Journal.read(folder.path)
    journal.parts = folder.intact(journal.parts)
    figures = list(journal.figures)
    journal.start(folder.header())
    if figures:
        journal.announce(figures)
    return journal


def _repaired(folder: RunFolder, record: dict[str, Any], runner: Runner | None, stop: threading.Event) -> Run:
    """A finished run whose damaged parts are computed again, if they may be; the same parts give the same bytes."""
    entries = {entry["path"]: entry for entry in record["files"]}
    damaged = list(lost(folder.path, record))
    if not damaged:
        return Run(record, folder.path, up_to_date=True)
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
    return Run({**record, "repaired": damaged}, folder.path)


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


def in_threads(jobs: int) -> Runner:
    """Makes parts, at most `jobs` at once; a single one in the calling thread."""
    return _one_by_one if jobs == 1 else partial(_at_once, jobs)


def _one_by_one(maker: PartMaker, missing: Iterator[int]) -> Results:
    """Each part when it is asked for."""
    for index in missing:
        yield _attempt(index, partial(maker.make, index))


def _at_once(jobs: int, maker: PartMaker, missing: Iterator[int]) -> Results:
    """Parts as they are finished, and failures among them, since joblib would end all at the first exception.

    However this ends, no thread works on a part any more.
    """
    from concurrent.futures import Future, ThreadPoolExecutor  # a small study does without these imports

    from joblib import Parallel, delayed

    room = threading.Semaphore(2 * jobs)  # parts that nobody has taken yet; a slow disk holds up the computing
    ended = threading.Event()
    at_work = threading.Semaphore(jobs)  # whoever holds all of it is alone

    def compute(index: int) -> PartFailure | Future[PartFailure | PartResult]:
        room.acquire()
        with at_work:
            part = PartFailure(index, Stopped()) if ended.is_set() else _attempt(index, partial(maker.compute, index))
            if isinstance(part, PartFailure):
                return part
            if ended.is_set():
                part.discard()
                return PartFailure(index, Stopped())
            return disk.submit(_attempt, index, part.finish)

    with (
        ThreadPoolExecutor(jobs) as disk,
        Parallel(n_jobs=jobs, backend="threading", return_as="generator_unordered", pre_dispatch="2*n_jobs") as pool,
    ):
        parts = pool(delayed(compute)(index) for index in takewhile(lambda _: not ended.is_set(), missing))
        try:
            for part in parts:
                yield part if isinstance(part, PartFailure) else part.result()
                room.release()
        finally:
            ended.set()
            room.release(maker.plan.parts)  # for whoever waits
            list(parts)  # until those that are at work are done, for which joblib would not wait
            for _ in range(jobs):  # nor does it after KeyboardInterrupt
                at_work.acquire()
            at_work.release(jobs)


def _attempt(index: int, step: Callable[[], Made]) -> Made | PartFailure:
    """A step in the making of a part; its failure is told with the part's coordinates, while the others go on."""
    try:
        return step()
    except Exception as error:  # noqa: BLE001
        return PartFailure(index, error)
