"""From the bytes of a study file to a plain dictionary, TOML or YAML 1.2, with the place of every key.

Files are hostile until checked: size, nesting and key length are looked at before anything is parsed, YAML anchors,
aliases and tags are refused, and what a file says is never executed.
"""

from __future__ import annotations

import re
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tendon_cli.files import read_file
from tendon_cli.studies.toml_scan import LONG_INTEGER, MAX_DEPTH, KeyPlaces, refused, scan
from tendon_cli.units import shorten

MAX_BYTES = 256_000
YAML_SUFFIXES = (".yaml", ".yml")
STDIN = Path("-")
"""The name of a study from standard input."""

_OF_THE_PARSER = {
    "Cannot overwrite a value": "a key that stands twice, expected each key once",
    "Expected newline or end of document after a statement": "more follows the value, expected the end of the line",
    "Illegal character '\\n'": "text that is not closed on its line, expected a quote at its end",
    "Invalid value": "no value that TOML knows, expected a number, a list, or text in quotes",
    "Invalid statement": 'neither a key nor a table, expected such as name = "fig07" or [arm]',
    "Expected '=' after a key in a key/value pair": 'a key without a value, expected such as name = "fig07"',
    "Unclosed array": "a list that is not closed, expected ] at its end",
    "Unclosed inline table": "a table that is not closed, expected } at its end",
    "Unterminated string": "text that is not closed, expected a quote at its end",
}
"""What the parser says, in the words of someone who writes a study."""

_TUPLE = re.compile(r"\('(.*?)',?\)")
_KEY_OF_YAML = re.compile(r"(?:---|[\w.-]+\s*:(?:\s|$))")
"""How the first line of a study in YAML begins, and none in TOML."""
_MANY_DIGITS = re.compile(r"[\d_]{4301,}")


@dataclass(frozen=True)
class Document:
    """What a study file says, unchecked, and where it says it."""

    content: dict[str, Any]
    places: KeyPlaces


def read_document(path: Path) -> Document:
    """Read a TOML or YAML file; raises StudyError where it cannot be read or is not of its grammar."""
    text = _text(_bytes(path))
    try:
        return _yaml(text) if _is_yaml(path, text) else read_toml(text)
    except RecursionError:
        raise refused(f"nested deeper than {MAX_DEPTH} levels") from None


def _is_yaml(path: Path, text: str) -> bool:
    """By its ending; of standard input by its first line that says something."""
    if path != STDIN:
        return path.suffix.lower() in YAML_SUFFIXES
    lines = (line.strip() for line in text.splitlines())
    return _KEY_OF_YAML.match(next((line for line in lines if line and line[0] != "#"), "")) is not None


def read_value(text: str) -> Any:
    """A value given on the command line as TOML; raises StudyError."""
    if len(text) > MAX_BYTES:
        raise refused(f"a value of {len(text)} characters, at most {MAX_BYTES} are read")
    content = read_toml(f"value = {text}").content
    if set(content) != {"value"}:
        raise refused("more than one value")
    return content["value"]


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
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise refused("UTF-16 text, expected UTF-8", "save the file as UTF-8")
    if content.startswith((b"PAR1", b"\x89PNG", b"PK\x03\x04")) or b"\0" in content[:4096]:
        raise refused("this is a binary file, expected a study in TOML or YAML")
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise refused("not UTF-8 text, expected UTF-8", "save the file as UTF-8", line) from None


def read_toml(text: str) -> Document:
    """TOML text, looked at before it is parsed; raises StudyError."""
    places = scan(text)
    try:
        return Document(tomllib.loads(text), places)
    except tomllib.TOMLDecodeError as error:
        message, _, place = str(error).partition(" (at ")
        line = int(place.split()[1].strip(",")) if place.startswith("line ") else text.count("\n") + 1
        words = _OF_THE_PARSER.get(message) or shorten(f"{message[:1].lower()}{message[1:]}", 200)
        plain = _TUPLE.sub(lambda match: match.group(1).replace("', '", "."), words)  # a key as Python prints it
        raise refused(f"not TOML: {plain}", _toml_hint(text, line), line) from None
    except ValueError:
        digits = _MANY_DIGITS.search(text)
        raise refused(LONG_INTEGER, None, text[: digits.start()].count("\n") + 1 if digits else None) from None


def _toml_hint(text: str, line: int) -> str | None:
    lines = text.splitlines()
    written = lines[line - 1] if 0 < line <= len(lines) else ""
    _, equals, value = written.partition("=")
    if equals and value.strip()[:1].isdigit() and value.strip()[-1:].isalpha():
        return f'a quantity with a unit stands in quotes: "{shorten(value.strip())}"'
    return f"the line reads: {shorten(written.strip())}" if written.strip() else None


def _yaml(text: str) -> Document:
    from tendon_cli.studies.yaml_reading import read_yaml  # only studies in YAML pay for its import

    content, places = read_yaml(text)
    return Document(content, places)
