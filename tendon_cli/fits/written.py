"""Origin of a file of a fit, read before it is replaced."""

from __future__ import annotations

import contextlib
import tomllib
from pathlib import Path

from tendon_cli import say
from tendon_cli.files import read_file, what_is_written

_MOST_BYTES = 1_000_000
"""Largest size of a file that is read to say where it came from."""


def said_of(path: Path, key: str, now: str, held: str) -> str:
    """Return a line that says what a file was or becomes; call it before it is written.

    A file that came from other readings is named with them: it holds other numbers.

    Args:
        path: The file, TOML if a fit wrote it.
        key: Table and key of its sources, such as "fit.logs".
        now: Sources of what will be written.
        held: Noun for what it holds, such as "the numbers".
    """
    before = None
    table, name = key.split(".")
    with contextlib.suppress(OSError, ValueError, LookupError, TypeError):
        stated = tomllib.loads(read_file(path, _MOST_BYTES).decode())[table][name]
        before = stated if isinstance(stated, str) else say.join_words(stated)
    return what_is_written(path, before, now, held)
