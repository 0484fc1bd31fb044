"""A task on a running Dask cluster."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tendon_cli.engine.cluster.flight import Cluster


def cluster_at(address: str | None, jobs: int | None) -> AbstractContextManager[Cluster | None]:
    """The workers of a cluster, ready, or None where no address is given; raises UsageError, WorkersLostError."""
    if address is None:
        return nullcontext()
    from tendon_cli.engine.cluster.flight import connected  # only who has a cluster pays for its import

    return connected(address, jobs)
