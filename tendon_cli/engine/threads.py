"""Parts made in threads of this process: some compute while others wait for the disk. And what ends them."""

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

from tendon_cli.engine.task import Note, PartFailure, PartMaker, PartResult, Results
from tendon_cli.errors import (
    MemoryShortError,
    OutputError,
    Stopped,
    TendonError,
    WorkersLostError,
    is_memory_short,
)

Runner = Callable[[PartMaker, Iterator[int]], Results]
"""Makes parts, and gives them in whatever order they are finished."""

_ADDRESSES_PER_JOB = 300 * 10**6
"""Three stacks, an arena of the C library (64 MB) for each, and the arrays of a part."""


def available_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def make_parts(
    maker: PartMaker, runner: Runner, parts: Iterable[int], take: Callable[[PartResult], None]
) -> None:
    """Make parts and hand each over as it is finished; raises for those that failed when the others are done."""
    failures: list[PartFailure] = []
    with contextlib.closing(
        runner(maker, iter(parts))
    ) as results:  # nothing is out when the folder is let go
        try:
            for result in results:
                failure = _taken(result, take)
                failures += [failure] if failure else []
                if failure and isinstance(failure.error, OutputError):
                    maker.task.stop.set()  # the next part would not fit either
        except (
            BaseException
        ) as error:  # such as KeyboardInterrupt: the parts that are being made end at once
            maker.task.stop.set()
            if is_memory_short(error):
                raise _memory_short(maker, "threads") from error
            raise
    for failure in failures:  # what stopped the writing first, then anything else, then a stop
        if isinstance(failure.error, TendonError) and not isinstance(failure.error, Stopped):
            raise failure.error
    faults = [failure for failure in failures if not isinstance(failure.error, Stopped)]
    if faults:
        raise _lost(maker, faults) from faults[0].error
    if failures:
        raise failures[0].error


def _taken(
    result: PartResult | PartFailure, take: Callable[[PartResult], None]
) -> PartFailure | None:
    """Hand a finished part over; what fails at that is a failure of the part, so that the others come to their end."""
    if isinstance(result, PartFailure):
        return result
    try:
        take(result)
    except OutputError as error:
        return PartFailure(result.index, error)
    return None


def _lost(maker: PartMaker, faults: list[PartFailure]) -> TendonError:
    first, where = faults[0], place(maker, faults[0].index)
    if is_memory_short(first.error):
        return _memory_short(maker, where)
    return WorkersLostError(
        f"{len(faults)} of {maker.task.parts} parts failed, the others are kept; first "
        f"{where}: {type(first.error).__name__}: {first.error}",
        where=str(maker.folder),
        hint="--resume tries the failed parts again",
    )


def _memory_short(maker: PartMaker, what: str) -> MemoryShortError:
    hint = "fewer --jobs need less; --resume goes on"
    return MemoryShortError(
        f"there is not enough memory for {what}", where=str(maker.folder), hint=hint
    )


def place(maker: PartMaker, index: int) -> str:
    """A part, and what it is of."""
    return f"part {index} ({maker.task.place(index)})"


def in_threads(jobs: int) -> Runner:
    """Makes parts, at most `jobs` at once, or as many as addresses allow; a single one in the calling thread."""
    jobs = _affordable(jobs)
    return _one_by_one if jobs == 1 else partial(_at_once, jobs)


def _affordable(jobs: int) -> int:
    """At most as many jobs as there are addresses for: a thread without them aborts the process, uncaught."""
    try:
        import resource  # not on every system

        limit, _ = resource.getrlimit(resource.RLIMIT_AS)
        if limit == resource.RLIM_INFINITY:
            return jobs
        used = int(Path("/proc/self/statm").read_text("ascii").split()[0]) * resource.getpagesize()
    except (ImportError, OSError, ValueError):
        return jobs
    return max(1, min(jobs, (limit - used) // _ADDRESSES_PER_JOB))


def _one_by_one(maker: PartMaker, missing: Iterator[int]) -> Results:
    """Each part when it is asked for."""
    return (_attempt(maker, index) for index in missing)


def _at_once(jobs: int, maker: PartMaker, missing: Iterator[int]) -> Results:
    """Parts as they are finished, and failures among them, since joblib would end all at the first exception.

    As many threads as there are jobs compute, so that no others have the C library keep memory for them; twice as many
    parts are begun, for some wait for the disk. However this ends, no thread works on a part any more.
    """
    from concurrent.futures import ThreadPoolExecutor

    from joblib import Parallel, delayed  # a small study does without this import

    ended = threading.Event()
    begun = threading.Semaphore(2 * jobs)

    def make(index: int) -> PartResult | PartFailure:
        with begun:
            return (
                PartFailure(index, Stopped())
                if ended.is_set()
                else _attempt(maker, index, computed)
            )

    def computed(work: Callable[[], Note]) -> Note:
        return computing.submit(work).result()

    with (
        ThreadPoolExecutor(jobs) as computing,
        Parallel(
            2 * jobs, backend="threading", return_as="generator_unordered", pre_dispatch="n_jobs"
        ) as pool,
    ):
        parts = pool(
            delayed(make)(index) for index in takewhile(lambda _: not ended.is_set(), missing)
        )
        try:
            for part in parts:  # noqa: UP028 - `yield from` would close joblib's generator, which then cancels
                yield part
        except BaseException:
            maker.task.stop.set()
            raise
        finally:
            ended.set()
            list(parts)  # until those that are at work are done, for which joblib would not wait
            for _ in range(2 * jobs):  # nor does it after KeyboardInterrupt
                begun.acquire()


def _attempt(
    maker: PartMaker, index: int, *working: Callable[[Callable[[], Note]], Note]
) -> PartResult | PartFailure:
    """A part; its failure is reported with the part's coordinates, while the others go on."""
    try:
        return maker.make(index, *working)
    except Exception as error:  # noqa: BLE001
        return PartFailure(index, error)


@contextlib.contextmanager
def ended_by_keyboard(stop: threading.Event | None) -> Iterator[threading.Event]:
    """The event that ends a run: the caller's, or one that Ctrl-C sets; a second Ctrl-C does not wait."""
    is_main = threading.current_thread() is threading.main_thread()
    if (
        stop is not None
        or not is_main
        or signal.getsignal(signal.SIGINT) is not signal.default_int_handler
    ):
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
