"""Parts made in threads of this process, where some compute while others wait for the disk."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import takewhile
from pathlib import Path
from types import FrameType
from typing import TypeAlias

from tendon_cli.engine.task import Compute, Note, PartFailure, PartMaker, PartOutcomes, PartResult
from tendon_cli.errors import (
    MemoryShortError,
    OutputError,
    Stopped,
    TendonError,
    WorkersLostError,
    is_memory_short,
)

Runner: TypeAlias = Callable[[PartMaker, Iterator[int]], PartOutcomes]
"""Makes parts, and yields them in the order in which they are finished."""

_ADDRESSES_PER_JOB = 300 * 10**6
"""Address space for a job, bytes.

That is three stacks, an arena of the C library (64 MB) for each, and the arrays of a part.
"""


def available_cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def make_parts(
    maker: PartMaker, runner: Runner, parts: Iterable[int], take: Callable[[PartResult], None]
) -> None:
    """Make parts, and hand each over as it is finished.

    If parts fail, the others are finished first, unless nothing more can be written. Then one error
    is raised: a TendonError before any other, and Stopped only if there is nothing else.

    Args:
        maker: Makes a part.
        runner: Has the maker make all parts.
        parts: Indices of the parts.
        take: Called with each finished part.
    """
    failures: list[PartFailure] = []
    # Closing the results ends all work on parts before the folder is unlocked.
    with contextlib.closing(runner(maker, iter(parts))) as results:
        try:
            for result in results:
                failure = _hand_over(result, take)
                if failure is None:
                    continue
                failures.append(failure)
                if isinstance(failure.error, OutputError):
                    maker.task.stop.set()  # the next part would not fit either
        except BaseException as error:
            maker.task.stop.set()  # ends the parts that are being made, at Ctrl-C for example
            if is_memory_short(error):
                raise _memory_short(maker, "threads") from error
            raise
    for failure in failures:
        if isinstance(failure.error, TendonError) and not isinstance(failure.error, Stopped):
            raise failure.error
    faults = [failure for failure in failures if not isinstance(failure.error, Stopped)]
    if faults:
        raise _parts_failed(maker, faults) from faults[0].error
    if failures:
        raise failures[0].error


def _hand_over(
    result: PartResult | PartFailure, take: Callable[[PartResult], None]
) -> PartFailure | None:
    """Hand a finished part over; return a failure if it was not made or cannot be handed over.

    If handing over fails, that is a failure of the part, so that the others are still finished.
    """
    if isinstance(result, PartFailure):
        return result
    try:
        take(result)
    except OutputError as error:
        return PartFailure(result.index, error)
    return None


def _parts_failed(maker: PartMaker, faults: list[PartFailure]) -> TendonError:
    """Return the error of parts that failed, with the first of their failures."""
    first = faults[0]
    where = place(maker, first.index)
    if is_memory_short(first.error):
        return _memory_short(maker, where)
    return WorkersLostError(
        f"{len(faults)} of {maker.task.parts} parts failed, the others are kept; the first is "
        f"{where}: {type(first.error).__name__}: {first.error}",
        where=str(maker.folder),
        hint="--resume tries the failed parts again",
    )


def _memory_short(maker: PartMaker, what: str) -> MemoryShortError:
    """Return the error of too little memory for threads, or for a part."""
    hint = "fewer --jobs need less; --resume continues"
    return MemoryShortError(
        f"there is not enough memory for {what}", where=str(maker.folder), hint=hint
    )


def place(maker: PartMaker, index: int) -> str:
    """Describe a part for messages by its number and the task's words."""
    return f"part {index} ({maker.task.place(index)})"


def in_threads(jobs: int) -> Runner:
    """Return the runner that makes parts in threads of this process.

    Args:
        jobs: Most parts computed at once; fewer if there is not enough address space. A single
            one is made in the calling thread.
    """
    jobs = _affordable(jobs)
    return _one_by_one if jobs == 1 else partial(_at_once, jobs)


def _affordable(jobs: int) -> int:
    """Return the number of jobs that there is address space for, from 1 to `jobs`.

    A thread that gets no address space would abort the process, and nothing could catch it.
    """
    try:
        import resource  # not on every system

        limit, _ = resource.getrlimit(resource.RLIMIT_AS)
        if limit == resource.RLIM_INFINITY:
            return jobs
        used = int(Path("/proc/self/statm").read_text("ascii").split()[0]) * resource.getpagesize()
    except (ImportError, OSError, ValueError):
        return jobs
    return max(1, min(jobs, (limit - used) // _ADDRESSES_PER_JOB))


def _one_by_one(maker: PartMaker, missing: Iterator[int]) -> PartOutcomes:
    """Make each part when it is asked for."""
    return (_attempt(maker, index) for index in missing)


def _at_once(jobs: int, maker: PartMaker, missing: Iterator[int]) -> PartOutcomes:
    """Yield parts as they are finished, and failures among them.

    A failure is a result, since joblib would end all parts at the first exception. Only as
    many threads compute as there are jobs, since the C library keeps memory for each. Twice as many
    parts are begun, since some wait for the disk. However this ends, no part is being made then.
    """
    from concurrent.futures import ThreadPoolExecutor

    from joblib import Parallel, delayed  # a small study does without this import

    ended = threading.Event()
    begun = threading.Semaphore(2 * jobs)

    def make(index: int) -> PartResult | PartFailure:
        with begun:
            if ended.is_set():
                return PartFailure(index, Stopped())
            return _attempt(maker, index, compute)

    def compute(work: Callable[[], Note]) -> Note:
        return computing.submit(work).result()

    with (
        ThreadPoolExecutor(jobs) as computing,
        Parallel(
            2 * jobs, backend="threading", return_as="generator_unordered", pre_dispatch="n_jobs"
        ) as pool,
    ):
        to_begin = takewhile(lambda _: not ended.is_set(), missing)
        parts = pool(delayed(make)(index) for index in to_begin)
        try:
            # `yield from` would close joblib's generator, which then cancels.
            for part in parts:  # noqa: UP028
                yield part
        except BaseException:
            maker.task.stop.set()
            raise
        finally:
            ended.set()
            list(parts)  # waits for the parts that are being made, as joblib would not
            for _ in range(2 * jobs):  # after KeyboardInterrupt the list does not wait, either
                begun.acquire()


def _attempt(maker: PartMaker, index: int, *compute: Compute) -> PartResult | PartFailure:
    """Make a part; return an exception as its failure, so that the other parts go on."""
    try:
        return maker.make(index, *compute)
    except Exception as error:  # noqa: BLE001
        return PartFailure(index, error)


@contextlib.contextmanager
def ended_by_keyboard(stop: threading.Event | None) -> Iterator[threading.Event]:
    """Yield the event that ends a run: the caller's, or one that Ctrl-C sets.

    A second Ctrl-C does not wait for the run to end. Stopped becomes KeyboardInterrupt.
    """
    is_main = threading.current_thread() is threading.main_thread()
    is_default = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if stop is not None or not is_main or not is_default:
        yield stop or threading.Event()
        return
    ended = threading.Event()

    def ask(_number: int, _frame: FrameType | None) -> None:
        if ended.is_set():
            raise KeyboardInterrupt
        ended.set()

    before = signal.signal(signal.SIGINT, ask)
    try:
        yield ended
    except Stopped:
        raise KeyboardInterrupt from None
    finally:
        signal.signal(signal.SIGINT, before)
