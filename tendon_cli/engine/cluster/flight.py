"""A task on a running Dask cluster: parts go out to its workers and come back as they are finished.

All that the library does happens in one event loop, which turns in the calling thread: no thread outlives a run.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import re
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from tendon_cli.engine.cluster.worker import (
    Assignment,
    OnWorkerError,
    Refusal,
    all_versions,
    halt,
    make_part,
    ready,
    unlike,
)
from tendon_cli.engine.task import PartFailure, PartMaker, PartResult, PartOutcomes
from tendon_cli.engine.threads import Runner, place
from tendon_cli.errors import Stopped, TendonError, UsageError, WorkersLostError, install_hint

CONNECT = 6.0
"""Seconds within which the scheduler must answer, and have a worker."""
ANSWER = 60.0
"""Seconds within which every worker must have imported tendon and answered whether it is fit."""
PATIENCE = 30.0
"""Seconds that a run waits for a scheduler that does not answer, or for the first worker after the last one died."""
_LOOK, _COUNT, _RECALL, _CLOSE = 0.2, 2.0, 3.0, 2.0
_ADDRESS = re.compile(r"(?:tcp|tls)://([\w.-]+|\[[0-9A-Fa-f:.]+\]):(\d{1,5})", re.ASCII)
_TALKATIVE = (
    "distributed",
    "distributed.client",
    "distributed.gc",
    "tornado",
    "tornado.application",
    "asyncio",
)


@contextlib.contextmanager
def connected(address: str, jobs: int | None) -> Iterator[Runner]:
    """A cluster whose workers all have our versions; raises UsageError, or WorkersLostError within seconds.

    `jobs` parts are out at once, by default two for each of the workers' threads.
    """
    match = _ADDRESS.fullmatch(address)
    if match is None or not 0 < int(match[2]) < 2**16:
        hint = "such as tcp://10.0.0.1:8786, which `dask scheduler` prints when it starts"
        raise UsageError(f'--scheduler "{address[:80]}" is not tcp://HOST:PORT', hint=hint)
    _library()
    with asyncio.Runner() as loop:
        with warnings.catch_warnings():
            warnings.simplefilter(
                "ignore"
            )  # the library's, on other versions of what no table depends on
            client = loop.run(_connect(address, match[1].strip("[]"), int(match[2])))
        try:
            yield partial(_results, client, loop, jobs)
        finally:
            loop.run(_close(client))


def _library() -> Any:
    """The package `distributed`, its loggers silenced; raises UsageError where it is not installed."""
    try:
        import distributed  # an optional extra
    except ImportError:
        hint = install_hint("distributed")
        raise UsageError(
            "--scheduler needs the package distributed, which is not installed", hint=hint
        ) from None
    for name in _TALKATIVE:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    return distributed


async def _connect(address: str, host: str, port: int) -> Any:
    """A client of the cluster, all of whose workers have our versions; raises WorkersLostError."""
    client = None
    try:
        async with asyncio.timeout(CONNECT):
            _, writer = await asyncio.open_connection(
                host, port
            )  # the library would not say what is wrong
            writer.close()
            client = _library().Client(
                address, asynchronous=True, set_as_default=False, timeout=CONNECT
            )
            await client
            await client.wait_for_workers(1)
        await _ask_everywhere(client, unlike, all_versions())
    except Exception as error:  # noqa: BLE001 - whatever answers there may be no scheduler at all
        fault = error if isinstance(error, TendonError) else _unreachable(address, error, client)
        await _close(client)
        raise fault from None
    return client


def _unreachable(address: str, error: Exception, client: Any) -> WorkersLostError:
    if isinstance(error, TimeoutError) and getattr(client, "status", None) == "running":
        return WorkersLostError(
            "the cluster has no workers", where=address, hint=f"`dask worker {address}` starts one"
        )
    if isinstance(error, TimeoutError):
        why = f" within {CONNECT:.0f} s"
    elif isinstance(error, OSError) and error.errno is not None:
        why = f": {os.strerror(error.errno) if error.errno > 0 else error.strerror}"  # those of names are below zero
    else:
        why = ": something else does, or another version"
    hint = "is it running, and can it be reached from here? `dask scheduler` prints its address when it starts"
    return WorkersLostError(f"no Dask scheduler answers{why}", where=address, hint=hint)


async def _ask_everywhere(
    client: Any, question: Callable[[Any], Refusal | None], about: Any
) -> None:
    """Raises WorkersLostError for the first worker that refuses; one that is gone is left to the scheduler."""
    try:
        async with asyncio.timeout(ANSWER):
            answers = await client.run(question, about, on_error="return")
    except TimeoutError:
        raise _lost(client, f"has workers that do not answer within {ANSWER:.0f} s") from None
    for worker, answer in answers.items():
        if isinstance(answer, Refusal):
            raise answer.error()
        if isinstance(answer, Exception) and not isinstance(answer, OSError):
            reason = f"this worker cannot run tendon: {type(answer).__name__}: {answer}"
            hint = "install the same tendon-cli on every worker"
            raise WorkersLostError(reason.splitlines()[0], where=f"worker {worker}", hint=hint)


async def _close(client: Any) -> None:
    """Leave the cluster; what it still has of ours is forgotten there."""
    if client is not None:
        with contextlib.suppress(Exception):
            async with asyncio.timeout(_CLOSE):
                await client.close()


def _lost(client: Any, what: str) -> WorkersLostError:
    hint = "the parts that were finished are kept; --resume goes on, with or without --scheduler"
    return WorkersLostError(
        f"the scheduler {what}", where=getattr(client.scheduler, "address", None), hint=hint
    )


def _results(
    client: Any, loop: asyncio.Runner, jobs: int | None, maker: PartMaker, missing: Iterator[int]
) -> PartOutcomes:
    """Parts as they are finished; raises WorkersLostError where the cluster is lost or unfit."""
    flight = _Flight(client, maker, jobs)
    try:
        loop.run(flight.prepare())
        while loop.run(flight.fill(missing)):
            yield from loop.run(flight.landed())
            if maker.task.stop.is_set() and flight.parts:
                yield PartFailure(next(iter(flight.parts.values())), Stopped())
                return
    finally:
        loop.run(flight.recall())
        maker.tidy()


@dataclass
class _Flight:
    """The parts of a run that are out on the cluster."""

    client: Any
    maker: PartMaker
    jobs: int | None
    parts: dict[asyncio.Task[PartResult | PartFailure | None], int] = field(default_factory=dict)
    """Parts that are out, by what waits for them."""
    suspects: list[int] = field(default_factory=list)
    """Parts whose workers died. Each goes out once more, alone, since another part may have been the cause."""
    alone: bool = False
    at_once: int = 1
    asked: float = field(default_factory=time.monotonic)
    manned: float = field(default_factory=time.monotonic)

    async def prepare(self) -> None:
        """See that every worker is fit for this run."""
        self.assignment = Assignment.of(self.maker)
        await _ask_everywhere(self.client, ready, self.assignment)
        self.count = asyncio.create_task(self.client.nthreads())
        self._counted(await self.count)

    async def fill(self, missing: Iterator[int]) -> bool:
        """Send parts out as far as there is room; whether any are out."""
        while (
            not self.alone
            and len(self.parts) < self.at_once
            and (index := next(missing, None)) is not None
        ):
            self.parts[asyncio.create_task(self._made(index))] = index
        if not self.parts and self.suspects:
            self.alone, index = True, self.suspects.pop()
            self.parts[asyncio.create_task(self._made(index))] = index
        return bool(self.parts)

    async def landed(self) -> list[PartResult | PartFailure]:
        """What came back, waiting for a moment at most; raises WorkersLostError."""
        done, _ = await asyncio.wait(self.parts, timeout=_LOOK, return_when=asyncio.FIRST_COMPLETED)
        for waited in done:
            del self.parts[waited]
        self._watch()
        return [outcome for waited in done if (outcome := waited.result()) is not None]

    async def recall(self) -> None:
        """Call back what is still out; workers end it at once and leave nothing behind."""
        for waiting in self.parts:
            waiting.cancel()
        if self.parts and self.client.status == "running":
            with contextlib.suppress(Exception):
                async with asyncio.timeout(_RECALL):
                    await asyncio.gather(*self.parts, return_exceptions=True)
                    await self.client.run(halt, self.assignment.run, on_error="ignore")

    async def _made(self, index: int) -> PartResult | PartFailure | None:
        """What comes of a part that is sent out; nothing if it is to be sent once more.

        A worker that dies before it hands over what it made is no loss: the scheduler has the part made again.
        """
        key = (f"tendon-part-{self.assignment.run}{'-alone' if self.alone else ''}", index)
        future = self.client.submit(make_part, self.assignment, index, key=key, pure=False)
        try:
            result: PartResult | Refusal = await future
        except asyncio.CancelledError:
            await self.client.cancel([future], force=True)
            raise
        except _library().KilledWorker as error:
            if not self.alone:
                self.suspects.append(index)
                return None
            died, last = error.allowed_failures + 1, error.last_worker.address
            return PartFailure(
                index,
                OnWorkerError(f"{died} workers died of it one after another, the last {last}"),
            )
        except Exception as error:  # noqa: BLE001 - its worker could not even answer for it
            if isinstance(error, CancelledError) or self.client.status != "running":
                raise _lost(self.client, "went away, or gave up our parts") from None
            return PartFailure(index, OnWorkerError(f"{type(error).__name__}: {error}"))
        if isinstance(result, Refusal) and result.kind == "unfit":
            raise result.error()
        return PartFailure(index, result.error()) if isinstance(result, Refusal) else result

    def _watch(self) -> None:
        """Count the workers' threads now and then, and see by it that the scheduler lives."""
        waited = time.monotonic() - self.asked
        if self.client.status != "running" or (
            self.count.done() and self.count.exception() is not None
        ):
            raise _lost(self.client, "went away")
        if self.count.done() and waited > _COUNT:
            self._counted(self.count.result())
            self.count, self.asked = asyncio.create_task(self.client.nthreads()), time.monotonic()
        elif not self.count.done() and waited > PATIENCE:
            raise _lost(self.client, f"does not answer for {PATIENCE:.0f} s")

    def _counted(self, threads: dict[str, int]) -> None:
        now = time.monotonic()
        self.at_once = self.jobs or max(1, 2 * sum(threads.values()))
        if threads:
            self.manned = now
        elif now - self.manned > PATIENCE:
            out = "; ".join(place(self.maker, index) for index in sorted(self.parts.values())[:4])
            message = f"no worker is left; {len(self.parts)} parts were being computed: {out}"
            hint = "workers under a nanny are replaced when they die; --resume goes on"
            raise WorkersLostError(message, where=str(self.maker.folder), hint=hint)
