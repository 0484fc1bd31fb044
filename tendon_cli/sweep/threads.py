"""Parts in threads of this process: some compute, others wait for the disk."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from functools import partial
from itertools import takewhile
from typing import TypeVar

from tendon_cli.errors import Stopped
from tendon_cli.sweep.part import PartFailure, PartMaker, PartResult, Results, Runner

Made = TypeVar("Made")


def in_threads(jobs: int) -> Runner:
    """Makes parts, at most `jobs` at once; a single one in the calling thread."""
    return _one_by_one if jobs == 1 else partial(_at_once, jobs)


def _one_by_one(maker: PartMaker, missing: Iterator[int]) -> Results:
    """Each part when it is asked for."""
    for index in missing:
        yield _attempt(index, partial(maker.make, index))


def _at_once(jobs: int, maker: PartMaker, missing: Iterator[int]) -> Results:
    """Parts as they are finished. While one waits for the disk, the next is computed.

    A task gives its failure back, since joblib would end all at the first exception. However this ends, no thread
    works on a part any more.
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
            for _ in parts:  # until those that are at work are done, for which joblib would not wait
                pass
            for _ in range(jobs):  # nor does it after KeyboardInterrupt
                at_work.acquire()
            at_work.release(jobs)


def _attempt(index: int, step: Callable[[], Made]) -> Made | PartFailure:
    """A step in the making of a part; its failure is told with the part's coordinates, while the others go on."""
    try:
        return step()
    except Exception as error:  # noqa: BLE001
        return PartFailure(index, error)
