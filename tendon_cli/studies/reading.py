"""From the bytes of a study file to a plain dictionary, TOML or YAML 1.2, with the line of every key.

Files are hostile until checked: size, nesting and key length are looked at before anything is parsed, YAML anchors,
aliases and tags are refused, and what a file says is never executed.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from tendon_cli.files import read_file
from tendon_cli.studies.toml_reading import MAX_BYTES, MAX_DEPTH, Document, read_toml, refused
from tendon_cli.units import shorten

YAML_SUFFIXES = (".yaml", ".yml")
STDIN = Path("-")
"""The name of a study from standard input."""
_KEY_OF_YAML = re.compile(r"(?:---|[\w.-]+\s*:(?:\s|$))")
"""How the first line of a study in YAML begins, and none in TOML."""


def read_document(path: Path) -> Document:
    """Read a TOML or YAML file; raises StudyError where it cannot be read or is not of its grammar."""
    text = _text(_bytes(path))
    try:
        if not _is_yaml(path, text):
            return read_toml(text)
        from tendon_cli.studies.yaml_reading import read_yaml  # only studies in YAML pay for its import

        return read_yaml(text)
    except RecursionError:
        raise refused(f"nested deeper than {MAX_DEPTH} levels") from None


def _is_yaml(path: Path, text: str) -> bool:
    """By its ending; of standard input by its first line that says something."""
    if path != STDIN:
        return path.suffix.lower() in YAML_SUFFIXES
    lines = (line.strip() for line in text.splitlines())
    return _KEY_OF_YAML.match(next((line for line in lines if line and line[0] != "#"), "")) is not None


def _bytes(path: Path) -> bytes:
    try:
        if path != STDIN:
            return read_file(path, MAX_BYTES)
        content = sys.stdin.buffer.read(MAX_BYTES + 1) if sys.stdin is not None else b""
    except FileNotFoundError:
        near = sorted(other.name for other in path.parent.glob("*.toml"))[:3] if path.parent.is_dir() else []
        hint = f"files there: {', '.join(map(shorten, near))}" if near else "`tendon init` writes a study to start from"
        raise refused("no such file", hint) from None
    except IsADirectoryError:
        raise refused("this is a folder, expected a study file") from None
    except (OSError, ValueError) as error:
        raise refused(f"cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if len(content) > MAX_BYTES:
        raise refused(f"cannot be read: it is larger than {MAX_BYTES // 1000} kB")
    if not content.strip():
        raise refused("nothing came in, expected a study in TOML or YAML", "such as: tendon sweep - < study.toml")
    return content


def _text(content: bytes) -> str:
    if content.startswith((b"PAR1", b"\x89PNG", b"PK\x03\x04")) or b"\0" in content[:4096]:
        is_wide = content.startswith((b"\xff\xfe", b"\xfe\xff"))
        what = "UTF-16 text, expected UTF-8" if is_wide else "this is a binary file, expected a study in TOML or YAML"
        raise refused(what, "save the file as UTF-8" if is_wide else None)
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise refused("not UTF-8 text, expected UTF-8", "save the file as UTF-8", line) from None
