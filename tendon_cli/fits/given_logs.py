"""Logs that a fit is given."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from pathlib import Path

from tendon_cli.errors import UsageError
from tendon_cli.tables.digest import file_sha256
from tendon_cli.units import shorten


def check_logs(sources: Sequence[object]) -> None:
    """Refuse no logs at all, and the same one twice, which would count as twice the evidence.

    Args:
        sources: Paths of files, or tables.

    Raises:
        UsageError: There is none, or two are the same object or files with the same content.
    """
    if not sources:
        raise UsageError("there is no log, expected one or more")
    seen: dict[object, str] = {}
    for number, source in enumerate(sources, start=1):
        identity: object = id(source)
        name = f"log {number}"
        if isinstance(source, Path):
            name = shorten(str(source))
            # A file that cannot be read is refused by whoever reads it.
            with contextlib.suppress(OSError, ValueError):
                if source.is_file():
                    identity = file_sha256(source)
        if identity in seen:
            problem = f"{name} has the same readings as {seen[identity]}, and would count twice"
            raise UsageError(problem, hint="leave one of them out")
        seen[identity] = name
