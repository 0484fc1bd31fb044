"""Choices solved on a running Dask cluster: workers send them back, and the answer is written here."""

from __future__ import annotations

import asyncio
import contextlib
import json
import platform
import threading
import time
from collections import deque
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

from tendon_cli.answers.candidates import Candidates
from tendon_cli.answers.parts import Choices
from tendon_cli.answers.question import question
from tendon_cli.engine.cluster.flight import PATIENCE, Cluster
from tendon_cli.engine.cluster.link import lost
from tendon_cli.errors import Stopped, WorkersLostError
from tendon_cli.studies.load import recorded_study

_LOOK = 0.2
_AHEAD = 2
"""Parts that are out for each of the workers' threads."""


def solved(cluster: Cluster, choices: Choices, stop: threading.Event) -> Iterator[Candidates]:
    """Parts as workers solve them, in their order; raises Stopped where `stop` is set."""
    study = choices.problem.study
    record = json.dumps(study.record)
    waiting: deque[Any] = deque()
    missing = iter(range(choices.parts))
    at_once = cluster.jobs or _AHEAD * max(1, sum(cluster.loop.run(_threads(cluster.client)).values()))
    try:
        while True:
            while len(waiting) < at_once and (index := next(missing, None)) is not None:
                waiting.append(cluster.client.submit(solve_part, record, study.hash, index, pure=False))
            if not waiting:
                return
            yield cluster.loop.run(_result(cluster.client, waiting.popleft(), stop))
    finally:
        with contextlib.suppress(Exception):  # the cluster may be gone: nothing of ours is left there either way
            cluster.loop.run(_recalled(cluster.client, list(waiting)))


async def _threads(client: Any) -> dict[str, int]:
    found: dict[str, int] = await client.nthreads()
    return found


async def _recalled(client: Any, futures: list[Any]) -> None:
    async with asyncio.timeout(_LOOK * 5):
        await client.cancel(futures, force=True)


async def _result(client: Any, future: Any, stop: threading.Event) -> Candidates:
    """What a worker found; every wait has its bound."""
    answer = asyncio.ensure_future(future.result())
    manned = time.monotonic()
    try:
        while not answer.done():
            await asyncio.wait({answer}, timeout=_LOOK)
            if stop.is_set():
                raise Stopped
            if client.status != "running":
                raise lost(client, "went away")
            if not answer.done() and await _has_workers(client):
                manned = time.monotonic()
            elif time.monotonic() - manned > PATIENCE:
                raise WorkersLostError("no worker is left", hint="start workers, and ask again")
        return _taken(answer)
    finally:
        answer.cancel()


async def _has_workers(client: Any) -> bool:
    try:
        async with asyncio.timeout(PATIENCE):
            return bool(await client.nthreads())
    except (OSError, TimeoutError):
        raise lost(client, "went away") from None


def _taken(answer: asyncio.Future[Any]) -> Candidates:
    error = answer.exception() if not answer.cancelled() else asyncio.CancelledError()
    if error is not None:
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        raise WorkersLostError(f"a part of the choices could not be solved: {reason}") from None
    found: Candidates = answer.result()
    return found


# --- On a worker -----------------------------------------------------------------------------------------------------


def solve_part(record: str, study_hash: str, index: int) -> Candidates:
    """A part of the choices of a recorded study."""
    return _choices(record, study_hash).part(index)


@lru_cache(maxsize=4)
def _choices(record: str, study_hash: str) -> Choices:
    study = recorded_study(json.loads(record))
    if study.hash != study_hash:
        raise WorkersLostError(f"the tendon on {platform.node()} understands the study otherwise")
    return Choices(question(study))
