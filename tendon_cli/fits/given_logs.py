"""Logs that a fit is given."""

from __future__ import annotations

import contextlib
from os import PathLike
from pathlib import Path
from typing import Any

from tendon_cli.errors import UsageError
from tendon_cli.files import path_of
from tendon_cli.tables.digest import file_sha256
from tendon_cli.units import shorten


def given_logs(logs: object) -> list[Any]:
    """Return the logs that a fit is given: paths of files, and tables as they are.

    Args:
        logs: Name of a file or a table, or a list of them.

    Raises:
        UsageError: There is none, or two are the same object or files with the same content, which
            would count as twice the evidence.
    """
    given: list[Any] = list(logs) if isinstance(logs, list | tuple) else [logs]
    sources = [path_of(one) if isinstance(one, str | PathLike) else one for one in given]
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
            raise UsageError(
                f"{name} has the same readings as {seen[identity]}, and would count twice",
                hint="leave one of them out",
            )
        seen[identity] = name
    return sources
