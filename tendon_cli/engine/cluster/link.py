"""The connection to a running Dask cluster: made, checked and ended within bounds, without a word on stderr."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import re
from collections.abc import Callable
from typing import Any

from tendon_cli.engine.cluster.worker import Refusal, all_versions, unlike
from tendon_cli.errors import TendonError, UsageError, WorkersLostError, install_hint

CONNECT = 6.0
"""Seconds within which the scheduler must answer, and have a worker."""
ANSWER = 60.0
"""Seconds within which every worker must have imported tendon and answered whether it is fit."""
_CLOSE = 2.0

_ADDRESS = re.compile(r"(tcp|tls)://([\w.-]+|\[[0-9A-Fa-f:.]+\]):(\d{1,5})", re.ASCII)
_TALKATIVE = ("distributed", "distributed.client", "distributed.gc", "tornado", "tornado.application", "asyncio")


def check_address(address: str) -> None:
    """Raises UsageError for anything but tcp://HOST:PORT and tls://HOST:PORT."""
    match = _ADDRESS.fullmatch(address)
    if match is None or not 0 < int(match[3]) < 2**16:
        hint = "such as tcp://10.0.0.1:8786, which `dask scheduler` prints when it starts"
        raise UsageError(f'--scheduler "{address[:80]}" is not tcp://HOST:PORT', hint=hint)


def library() -> Any:
    """The package `distributed`, its loggers silenced; raises UsageError where it is not installed."""
    try:
        import distributed  # an optional extra
    except ImportError:
        raise UsageError(
            "--scheduler needs the package distributed, which is not installed", hint=install_hint("distributed")
        ) from None
    for name in _TALKATIVE:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    return distributed


async def connect(address: str) -> Any:
    """A client of the cluster, all of whose workers have our versions; raises WorkersLostError."""
    client = None
    try:
        async with asyncio.timeout(CONNECT):
            await _knock(address)
            client = library().Client(address, asynchronous=True, set_as_default=False, timeout=CONNECT)
            await client
            while not await client.nthreads():
                await asyncio.sleep(0.2)
        await ask_everywhere(client, unlike, all_versions())
    except TendonError:
        await close(client)
        raise
    except Exception as error:  # noqa: BLE001 - whatever answers there may be no scheduler at all
        connected = getattr(client, "status", None) == "running"
        await close(client)
        raise _unreachable(address, error, connected=connected) from None
    return client


async def _knock(address: str) -> None:
    """See that somebody listens; the library would try for as long as it may, and not say what was wrong."""
    host, _, port = address.partition("://")[2].rpartition(":")
    _, writer = await asyncio.open_connection(host.strip("[]"), int(port))
    writer.close()


def _unreachable(address: str, error: Exception, *, connected: bool) -> WorkersLostError:
    if connected and isinstance(error, TimeoutError):
        return WorkersLostError("the cluster has no workers", where=address, hint=f"`dask worker {address}` starts one")
    if isinstance(error, TimeoutError):
        why = f" within {CONNECT:.0f} s"
    elif isinstance(error, OSError) and error.errno is not None:
        why = f": {os.strerror(error.errno) if error.errno > 0 else error.strerror}"  # those of names are below zero
    else:
        why = ": something else does, or another version"
    hint = "is it running, and can it be reached from here? `dask scheduler` prints its address when it starts"
    if address.startswith("tls:"):
        hint = "does Dask's configuration name the certificates, distributed.comm.tls, as the scheduler's does?"
    return WorkersLostError(f"no Dask scheduler answers{why}", where=address, hint=hint)


async def ask_everywhere(client: Any, question: Callable[[Any], Refusal | None], about: Any) -> None:
    """Ask every worker, and raise WorkersLostError for the first that refuses.

    One that cannot be reached any more is left to the scheduler, which replaces it.
    """
    try:
        async with asyncio.timeout(ANSWER):
            answers = await client.run(question, about, on_error="return")
    except TimeoutError:
        raise lost(client, f"has workers that do not answer within {ANSWER:.0f} s") from None
    for worker, answer in answers.items():
        if isinstance(answer, Refusal):
            raise unfit(answer)
        if isinstance(answer, Exception) and not isinstance(answer, OSError):
            reason = f"this worker cannot run tendon: {type(answer).__name__}: {answer}"
            hint = "install the same tendon-cli on every worker"
            raise WorkersLostError(reason.splitlines()[0], where=f"worker {worker}", hint=hint)


async def close(client: Any) -> None:
    """Leave the cluster; what it still has of ours is forgotten there."""
    if client is not None:
        with contextlib.suppress(Exception):
            async with asyncio.timeout(_CLOSE):
                await client.close()


def unfit(refusal: Refusal) -> WorkersLostError:
    """A worker that can take no part in the run."""
    where = f"worker {refusal.host}" + (f": {refusal.where}" if refusal.where else "")
    return WorkersLostError(refusal.reason, where=where, hint=refusal.hint)


def lost(client: Any, what: str) -> WorkersLostError:
    """The scheduler is of no use any more."""
    hint = "the parts that were finished are kept; --resume goes on, with or without --scheduler"
    address = getattr(client.scheduler, "address", None)
    return WorkersLostError(f"the scheduler {what}", where=address, hint=hint)
