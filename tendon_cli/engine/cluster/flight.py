"""A task on a running Dask cluster: parts go out to its workers and come back as they are finished.

The Dask client works in one event loop, which runs in the calling thread: no thread outlives a run.
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
    check_versions,
    halt,
    make_part,
    prepare_worker,
)
from tendon_cli.engine.task import PartFailure, PartMaker, PartOutcomes, PartResult
from tendon_cli.engine.threads import Runner, place
from tendon_cli.errors import (
    OutputError,
    Stopped,
    TendonError,
    UsageError,
    WorkersLostError,
    install_hint,
)
from tendon_cli.files import mark_lock

CONNECT = 6.0
"""Seconds within which the scheduler must answer, and have a worker."""
ANSWER = 60.0
"""Seconds within which every worker must have imported tendon and answered whether it is fit."""
PATIENCE = 30.0
"""Seconds that a run waits for a scheduler that does not answer, or while no worker is left."""
_LOOK = 0.2
"""Seconds that a run waits for parts before it looks at the cluster."""
_COUNT = 2.0
"""Seconds between two counts of the workers' threads."""
_RECALL = 3.0
"""Seconds within which workers must drop parts that are called back."""
_CLOSE = 2.0
"""Seconds within which the library must leave the cluster."""
_ADDRESS = re.compile(r"(?:tcp|tls)://([\w.-]+|\[[0-9A-Fa-f:.]+\]):(\d{1,5})", re.ASCII)
_TALKATIVE = (
    "distributed",
    "distributed.client",
    "distributed.gc",
    "tornado",
    "tornado.application",
    "asyncio",
)
"""Loggers that are silenced."""


@contextlib.contextmanager
def connected(address: str, jobs: int | None) -> Iterator[Runner]:
    """Yield the runner that makes parts on a cluster whose workers all have our versions.

    Args:
        address: Address of the scheduler, such as tcp://10.0.0.1:8786.
        jobs: Parts that are out at once; None for two for each of the workers' threads.

    Raises:
        UsageError: The address is malformed, or the package distributed is not installed.
        WorkersLostError: The cluster cannot be reached within seconds, or a worker is unfit.
    """
    match = _ADDRESS.fullmatch(address)
    if match is None or not 0 < int(match[2]) < 2**16:
        hint = "such as tcp://10.0.0.1:8786, which `dask scheduler` prints when it starts"
        raise UsageError(f'--scheduler "{address[:80]}" is not tcp://HOST:PORT', hint=hint)
    _library()
    with asyncio.Runner() as loop:
        with warnings.catch_warnings():
            # The library warns of other versions of packages that no table depends on.
            warnings.simplefilter("ignore")
            client = loop.run(_connect(address, match[1].strip("[]"), int(match[2])))
        try:
            yield partial(_results, client, loop, jobs)
        finally:
            loop.run(_close(client))


def _library() -> Any:
    """Return the package distributed, its loggers silenced; raises UsageError without it."""
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
    """Return a client of a cluster whose workers all have our versions; raises WorkersLostError."""
    client = None
    try:
        async with asyncio.timeout(CONNECT):
            # Tried first without the library, whose errors do not say what is wrong.
            _, writer = await asyncio.open_connection(host, port)
            writer.close()
            client = _library().Client(
                address, asynchronous=True, set_as_default=False, timeout=CONNECT
            )
            await client
            await client.wait_for_workers(1)
        await _ask_everywhere(client, check_versions, all_versions())
    except Exception as error:  # noqa: BLE001 - whatever answers there may be no scheduler at all
        fault = error if isinstance(error, TendonError) else _unreachable(address, error, client)
        await _close(client)
        raise fault from None
    return client


def _unreachable(address: str, error: Exception, client: Any) -> WorkersLostError:
    """Return the error of a scheduler that does not answer, or has no workers."""
    if isinstance(error, TimeoutError) and getattr(client, "status", None) == "running":
        hint = f"`dask worker {address}` starts one"
        return WorkersLostError("the cluster has no workers", where=address, hint=hint)
    if isinstance(error, TimeoutError):
        why = f" within {CONNECT:.0f} s"
    elif isinstance(error, OSError) and error.errno is not None:
        # Errors of looking up a name have numbers below zero.
        reason = os.strerror(error.errno) if error.errno > 0 else error.strerror
        why = f": {reason}"
    else:
        why = ": something else does, or another version"
    hint = (
        "is it running, and can it be reached from here? "
        "`dask scheduler` prints its address when it starts"
    )
    return WorkersLostError(f"no Dask scheduler answers{why}", where=address, hint=hint)


async def _ask_everywhere(
    client: Any, question: Callable[[Any], Refusal | None], argument: Any
) -> None:
    """Ask every worker a question; a worker that is gone is left to the scheduler.

    Raises:
        WorkersLostError: A worker refuses, or one does not answer.
    """
    try:
        async with asyncio.timeout(ANSWER):
            answers = await client.run(question, argument, on_error="return")
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
    """Leave the cluster, which then forgets our parts."""
    if client is not None:
        with contextlib.suppress(Exception):
            async with asyncio.timeout(_CLOSE):
                await client.close()


def _lost(client: Any, what: str) -> WorkersLostError:
    """Return the error of a scheduler that was lost during the run.

    Args:
        client: Its client.
        what: Verb phrase after "the scheduler".
    """
    where = getattr(client.scheduler, "address", None)
    hint = "the parts that were finished are kept; --resume continues, with or without --scheduler"
    return WorkersLostError(f"the scheduler {what}", where=where, hint=hint)


def _results(
    client: Any, loop: asyncio.Runner, jobs: int | None, maker: PartMaker, missing: Iterator[int]
) -> PartOutcomes:
    """Yield parts as they are finished; raises WorkersLostError if the cluster is lost or unfit."""
    flight = _Flight(client, maker, jobs)
    try:
        loop.run(flight.prepare())
        while loop.run(flight.fill(missing)):
            yield from loop.run(flight.landed())
            if maker.task.stop.is_set() and flight.parts:
                first_part = next(iter(flight.parts.values()))
                yield PartFailure(first_part, Stopped())
                return
    finally:
        loop.run(flight.recall())
        with contextlib.suppress(OutputError):
            mark_lock(maker.folder, "")
        maker.tidy()


@dataclass
class _Flight:
    """Parts of a run that are out on the cluster."""

    client: Any
    maker: PartMaker
    jobs: int | None
    parts: dict[asyncio.Task[PartResult | PartFailure | None], int] = field(default_factory=dict)
    """Parts that are out, by the tasks that wait for them."""
    suspects: list[int] = field(default_factory=list)
    """Parts whose workers died.

    Each goes out again, alone, since another part may have been the cause.
    """
    alone: bool = False
    """True once suspects go out, one at a time."""
    at_once: int = 1
    """Parts that may be out at once."""
    asked: float = field(default_factory=time.monotonic)
    """Time at which the numbers of threads were last asked for, s, by the monotonic clock."""
    manned: float = field(default_factory=time.monotonic)
    """Time at which the cluster last had a worker, s, by the monotonic clock."""

    async def prepare(self) -> None:
        """Make every worker ready for this run; raises WorkersLostError if one is unfit."""
        self.assignment = Assignment.of(self.maker)
        mark_lock(self.maker.folder, self.assignment.run)
        await _ask_everywhere(self.client, prepare_worker, self.assignment)
        self.count = asyncio.create_task(self.client.nthreads())
        self._counted(await self.count)

    async def fill(self, missing: Iterator[int]) -> bool:
        """Send out as many parts as there is room for; return True if any are out."""
        while not self.alone and len(self.parts) < self.at_once:
            index = next(missing, None)
            if index is None:
                break
            self._send(index)
        if not self.parts and self.suspects:
            self.alone = True
            self._send(self.suspects.pop())
        return bool(self.parts)

    def _send(self, index: int) -> None:
        """Send a part out without waiting for it."""
        self.parts[asyncio.create_task(self._outcome(index))] = index

    async def landed(self) -> list[PartResult | PartFailure]:
        """Return the parts that came back, after a moment at most; raises WorkersLostError."""
        done, _ = await asyncio.wait(self.parts, timeout=_LOOK, return_when=asyncio.FIRST_COMPLETED)
        for waiting in done:
            del self.parts[waiting]
        self._watch()
        return [outcome for waiting in done if (outcome := waiting.result()) is not None]

    async def recall(self) -> None:
        """Call back the parts that are out; workers end them at once and leave nothing behind."""
        for waiting in self.parts:
            waiting.cancel()
        if self.parts and self.client.status == "running":
            with contextlib.suppress(Exception):
                async with asyncio.timeout(_RECALL):
                    await asyncio.gather(*self.parts, return_exceptions=True)
                    await self.client.run(halt, self.assignment.run, on_error="ignore")

    async def _outcome(self, index: int) -> PartResult | PartFailure | None:
        """Send a part out and return its result or failure; None if it is to be sent again.

        If a worker dies before it hands its part over, the scheduler has another one make it.
        """
        suffix = "-alone" if self.alone else ""
        key = (f"tendon-part-{self.assignment.run}{suffix}", index)
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
            died = error.allowed_failures + 1
            last = error.last_worker.address
            message = f"{died} workers died of it one after another, the last {last}"
            return PartFailure(index, OnWorkerError(message))
        except Exception as error:  # noqa: BLE001 - its worker could not even answer for it
            if isinstance(error, CancelledError) or self.client.status != "running":
                raise _lost(self.client, "went away, or gave up our parts") from None
            return PartFailure(index, OnWorkerError(f"{type(error).__name__}: {error}"))
        if not isinstance(result, Refusal):
            return result
        if result.kind == "unfit":
            raise result.error()
        return PartFailure(index, result.error())

    def _watch(self) -> None:
        """Ask for the workers' threads now and then, which also shows that the scheduler is alive.

        Raises:
            WorkersLostError: The scheduler does not answer, or no worker is left.
        """
        waited = time.monotonic() - self.asked
        is_answered = self.count.done()
        if self.client.status != "running":
            raise _lost(self.client, "went away")
        if is_answered and self.count.exception() is not None:
            raise _lost(self.client, "went away")
        if is_answered and waited > _COUNT:
            self._counted(self.count.result())
            self.count = asyncio.create_task(self.client.nthreads())
            self.asked = time.monotonic()
        elif not is_answered and waited > PATIENCE:
            raise _lost(self.client, f"has not answered for {PATIENCE:.0f} s")

    def _counted(self, threads: dict[str, int]) -> None:
        """Set the number of parts that may be out; raises WorkersLostError if no worker is left.

        Args:
            threads: Number of threads of each worker.
        """
        now = time.monotonic()
        self.at_once = self.jobs or max(1, 2 * sum(threads.values()))
        if threads:
            self.manned = now
        elif now - self.manned > PATIENCE:
            places = "; ".join(
                place(self.maker, index) for index in sorted(self.parts.values())[:4]
            )
            message = f"no worker is left; {len(self.parts)} parts were being computed: {places}"
            hint = "workers with a nanny are replaced when they die; --resume continues"
            raise WorkersLostError(message, where=str(self.maker.folder), hint=hint)
