"""A task on a running Dask cluster: parts go out to its workers and come back as they are finished.

All that the cluster's library does happens in one event loop, which turns in the calling thread while this waits: no
thread outlives a run, and every wait has its bound.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import time
import warnings
from collections.abc import Iterator
from concurrent.futures import CancelledError
from dataclasses import dataclass, field
from typing import Any

from tendon_cli.engine.cluster.link import ask_everywhere, check_address, close, connect, library, lost, unfit
from tendon_cli.engine.cluster.worker import Assignment, Refusal, halt, make_part, ready
from tendon_cli.engine.task import PartFailure, PartMaker, PartResult, Results
from tendon_cli.engine.threads import place
from tendon_cli.errors import OutputError, Stopped, WorkersLostError

PATIENCE = 30.0
"""Seconds that a run waits for a scheduler that does not answer, or for the first worker after the last one died."""

_LOOK = 0.2
_COUNT = 2.0
_RECALL = 3.0


@contextlib.contextmanager
def connected(address: str, jobs: int | None) -> Iterator[Cluster]:
    """A cluster whose workers all have our versions; raises UsageError, or WorkersLostError within seconds.

    `jobs` parts are out at once, by default two for each of the workers' threads.
    """
    check_address(address)
    library()
    with asyncio.Runner() as loop:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the library's, on other versions of what no table depends on
            client = loop.run(connect(address))
        try:
            yield Cluster(client, loop, jobs)
        finally:
            loop.run(close(client))


@dataclass(frozen=True)
class Cluster:
    """Workers that stand ready for a run."""

    client: Any
    loop: asyncio.Runner
    jobs: int | None

    def results(self, maker: PartMaker, missing: Iterator[int]) -> Results:
        """Parts as they are finished; raises WorkersLostError where the cluster is lost or unfit."""
        first = next(missing, None)
        if first is None:
            return
        waiting = itertools.chain([first], missing)
        flight = _Flight(self.client, maker, self.jobs)
        try:
            self.loop.run(flight.prepare())
            while self.loop.run(flight.fill(waiting)):
                yield from self.loop.run(flight.landed())
                if maker.task.stop.is_set() and flight.parts:
                    yield PartFailure(next(iter(flight.parts.values())), Stopped())
                    return
        finally:
            self.loop.run(flight.recall())
            maker.tidy()


class OnWorkerError(Exception):
    """What went wrong with a part on a worker, in that worker's words."""


@dataclass
class _Flight:
    """The parts of a run that are out on the cluster."""

    client: Any
    maker: PartMaker
    jobs: int | None
    parts: dict[asyncio.Task[PartResult | PartFailure | None], int] = field(default_factory=dict)
    """Parts that are out, by what waits for them."""
    sent: dict[int, Any] = field(default_factory=dict)
    """The cluster's futures of parts that are out."""
    suspects: list[int] = field(default_factory=list)
    """Parts whose workers died. Each goes out once more, alone, since another part may have been the cause."""
    alone: bool = False
    at_once: int = 1
    count: asyncio.Future[dict[str, int]] | None = None
    """The answer to how many threads there are, while it is awaited."""
    asked: float = field(default_factory=time.monotonic)
    manned: float = field(default_factory=time.monotonic)
    """When there was a worker last."""

    async def prepare(self) -> None:
        """See that every worker is fit for this run."""
        self.assignment = Assignment.of(self.maker)
        await ask_everywhere(self.client, ready, self.assignment)
        self._counted(await self.client.nthreads())

    async def fill(self, missing: Iterator[int]) -> bool:
        """Send parts out as far as there is room; whether any are out."""
        while not self.alone and len(self.parts) < self.at_once and (index := next(missing, None)) is not None:
            self.parts[asyncio.create_task(self._made(index))] = index
        if not self.parts and self.suspects:
            self.alone, index = True, self.suspects.pop()
            self.parts[asyncio.create_task(self._made(index))] = index
        return bool(self.parts)

    async def landed(self) -> list[PartResult | PartFailure]:
        """What came back, waiting for a moment at most; raises WorkersLostError."""
        done, _ = await asyncio.wait(self.parts, timeout=_LOOK, return_when=asyncio.FIRST_COMPLETED)
        outcomes = []
        for waited in done:
            self.sent.pop(self.parts.pop(waited))
            outcomes.append(waited.result())
        self._watch()
        return [outcome for outcome in outcomes if outcome is not None]

    async def _made(self, index: int) -> PartResult | PartFailure | None:
        """What comes of a part that is sent out; nothing if it is to be sent once more.

        A worker that dies before it hands over what it made is no loss: the scheduler has the part made again.
        """
        key = (f"tendon-part-{self.assignment.run}{'-alone' if self.alone else ''}", index)
        self.sent[index] = self.client.submit(make_part, self.assignment, index, key=key, pure=False)
        try:
            result: PartResult | Refusal = await self.sent[index]
        except library().KilledWorker as error:
            if not self.alone:
                self.suspects.append(index)
                return None
            died, last = error.allowed_failures + 1, error.last_worker.address
            return PartFailure(index, OnWorkerError(f"{died} workers died of it one after another, the last {last}"))
        except Exception as error:  # noqa: BLE001 - its worker could not even answer for it
            if isinstance(error, CancelledError) or self.client.status != "running":
                raise lost(self.client, "went away, or gave up our parts") from None
            return PartFailure(index, OnWorkerError(f"{type(error).__name__}: {error}"))
        return _failure(index, result) if isinstance(result, Refusal) else result

    async def recall(self) -> None:
        """Call back what is still out; workers end it at once and leave nothing behind."""
        if self.count is not None:
            self.count.cancel()
        for waiting in self.parts:
            waiting.cancel()
        if self.parts and self.client.status == "running":
            with contextlib.suppress(Exception):
                async with asyncio.timeout(_RECALL):
                    await self.client.cancel(list(self.sent.values()), force=True)
                    await self.client.run(halt, self.assignment.run, on_error="ignore")
        self.parts.clear()

    def _watch(self) -> None:
        """Count the workers' threads now and then, and see by it that the scheduler lives."""
        now = time.monotonic()
        if self.client.status != "running":
            raise lost(self.client, "went away")
        if self.count is None:
            if now - self.asked > _COUNT:
                self.count, self.asked = asyncio.ensure_future(self.client.nthreads()), now
        elif self.count.done():
            if self.count.exception() is not None:
                raise lost(self.client, "went away")
            self._counted(self.count.result())
            self.count = None
        elif now - self.asked > PATIENCE:
            raise lost(self.client, f"does not answer for {PATIENCE:.0f} s")

    def _counted(self, threads: dict[str, int]) -> None:
        now = time.monotonic()
        self.at_once = self.jobs or max(1, 2 * sum(threads.values()))
        if threads:
            self.manned = now
        elif now - self.manned > PATIENCE:
            out = "; ".join(place(self.maker, index) for index in sorted(self.parts.values())[:4])
            raise WorkersLostError(
                f"no worker is left; {len(self.parts)} parts were being computed: {out}",
                where=str(self.maker.folder),
                hint="workers under a nanny are replaced when they die; --resume goes on",
            )


def _failure(index: int, refusal: Refusal) -> PartFailure:
    """A worker's refusal as the failure of its part; raises WorkersLostError where it would refuse any part."""
    reason = f"{refusal.reason}, on worker {refusal.host}"
    if refusal.kind == "unfit":
        raise unfit(refusal)
    if refusal.kind == "stopped":
        return PartFailure(index, Stopped())
    if refusal.kind == "output":
        return PartFailure(index, OutputError(reason, where=refusal.where, hint=refusal.hint))
    return PartFailure(index, OnWorkerError(reason))
