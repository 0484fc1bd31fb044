"""Plain values of JSON and TOML that fits write, and the origin of a file that is replaced."""

from __future__ import annotations

import contextlib
import json
import math
import tomllib
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

from tendon_cli import say
from tendon_cli.files import read_file, what_is_written

_MOST_BYTES = 1_000_000
"""Largest size of a file that is read to say where it came from."""


def plain(value: Any) -> Any:
    """Convert to plain JSON values; a number that is none or infinite becomes null."""
    if is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, dict):
        return {name: plain(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [plain(part) for part in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def toml_text(value: Any) -> str:
    """Write a number, a text or a list of them in TOML.

    A basic string has the escapes of JSON, and one for DEL, which JSON leaves as it is.
    """
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml_text, value))}]"
    if not isinstance(value, str):
        return repr(value)
    text = value.encode("utf-8", "replace").decode()
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


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
