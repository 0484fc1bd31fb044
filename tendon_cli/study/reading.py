"""From the bytes of a study file to a plain dictionary, TOML or YAML 1.2, with the place of every key.

Files are hostile until checked: size, nesting and key length are looked at before anything is parsed, YAML anchors,
aliases and tags are refused, and what a file says is never executed.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tendon_cli.errors import Fault, StudyError
from tendon_cli.study.toml_scan import MAX_DEPTH, KeyPlaces, scan
from tendon_cli.units import shorten

MAX_BYTES = 256_000
YAML_SUFFIXES = (".yaml", ".yml")


@dataclass(frozen=True)
class Document:
    """What a study file says, unchecked, and where it says it."""

    content: dict[str, Any]
    places: KeyPlaces


def read_document(path: Path) -> Document:
    """Read a TOML or YAML file; raises StudyError where it cannot be read or is not of its grammar."""
    text = _text(_bytes(path))
    try:
        return _yaml(text) if path.suffix.lower() in YAML_SUFFIXES else _toml(text)
    except RecursionError:
        raise StudyError([Fault("", f"nested deeper than {MAX_DEPTH} levels")]) from None


def read_value(text: str) -> Any:
    """A value given on the command line as TOML; raises StudyError."""
    if len(text) > MAX_BYTES:
        raise StudyError([Fault("", f"a value of {len(text)} characters, at most {MAX_BYTES} are read")])
    return _toml(f"value = {text}").content["value"]


def _bytes(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        near = [other.name for other in path.parent.glob("*.toml")][:3] if path.parent.is_dir() else []
        hint = f"files there: {', '.join(sorted(near))}" if near else "`tendon init` writes a study to start from"
        raise StudyError([Fault("", "no such file", hint)]) from None
    except IsADirectoryError:
        raise StudyError([Fault("", "this is a folder, expected a study file")]) from None
    except (OSError, ValueError) as error:
        raise StudyError([Fault("", f"cannot be read: {getattr(error, 'strerror', None) or error}")]) from None
    if len(content) > MAX_BYTES:
        raise StudyError([Fault("", f"the file is larger than {MAX_BYTES // 1000} kB, no study needs that")])
    return content


def _text(content: bytes) -> str:
    if content.startswith((b"PAR1", b"\x89PNG", b"PK\x03\x04")) or b"\0" in content[:4096]:
        raise StudyError([Fault("", "this is a binary file, expected a study in TOML or YAML")])
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise StudyError([Fault("", "not UTF-8 text", "save the file as UTF-8", line)]) from None


def _toml(text: str) -> Document:
    places = scan(text)
    try:
        return Document(tomllib.loads(text), places)
    except tomllib.TOMLDecodeError as error:
        message, _, place = str(error).partition(" (at ")
        line = int(place.split()[1].strip(",")) if place.startswith("line ") else text.count("\n") + 1
        raise StudyError(
            [Fault("", f"not TOML: {message[:1].lower()}{message[1:]}", _toml_hint(text, line), line)]
        ) from None
    except ValueError as error:  # an integer of more digits than Python converts
        raise StudyError([Fault("", f"not TOML: {shorten(str(error))}")]) from None


def _toml_hint(text: str, line: int) -> str | None:
    lines = text.splitlines()
    written = lines[line - 1] if 0 < line <= len(lines) else ""
    _, equals, value = written.partition("=")
    if equals and value.strip()[:1].isdigit() and value.strip()[-1:].isalpha():
        return f'a quantity with a unit stands in quotes: "{shorten(value.strip())}"'
    return f"the line reads: {shorten(written.strip())}" if written.strip() else None


def _yaml(text: str) -> Document:
    from ruamel.yaml import YAML  # only studies in YAML pay for its import
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    reader = YAML(typ="safe", pure=True)
    try:
        _check_yaml_events(reader.parse(text))
        places = KeyPlaces()
        node = YAML(typ="safe", pure=True).compose(text)
        _note_yaml_places(node, "", places)
        content = YAML(typ="safe", pure=True).load(text)
    except MarkedYAMLError as error:
        mark = error.problem_mark
        problem = (error.problem or str(error)).split("\n")[0]
        raise StudyError(
            [Fault("", f"not YAML: {shorten(problem, 120)}", None, mark.line + 1 if mark else None)]
        ) from None
    except (YAMLError, ValueError, OverflowError) as error:
        raise StudyError([Fault("", f"not YAML: {shorten(str(error).splitlines()[0], 120)}")]) from None
    if content is None:
        content = {}
    if not isinstance(content, dict):
        raise StudyError([Fault("", "the file holds no keys, expected such as `name: my-study`", None, 1)])
    return Document(content, places)


def _check_yaml_events(events: Any) -> None:
    """Refuse deep nesting, anchors, aliases and tags, while nothing has been built yet."""
    depth = 0
    for event in events:
        kind = type(event).__name__
        line = event.start_mark.line + 1
        depth += kind.endswith(("MappingStartEvent", "SequenceStartEvent"))
        depth -= kind.endswith(("MappingEndEvent", "SequenceEndEvent"))
        if depth > MAX_DEPTH:
            raise StudyError([Fault("", f"nested deeper than {MAX_DEPTH} levels", None, line)])
        if getattr(event, "anchor", None) is not None:
            raise StudyError([Fault("", "YAML anchors and aliases are not read", "write the value out", line)])
        if getattr(event, "tag", None) is not None:
            raise StudyError([Fault("", f"the YAML tag {shorten(str(event.tag))} is not read", "leave it out", line)])


def _note_yaml_places(node: Any, path: str, places: KeyPlaces) -> None:
    """Remember the line of every key, in the order of the document."""
    if node is None or isinstance(node.value, str):
        return
    for index, item in enumerate(node.value):
        pair = isinstance(item, tuple)
        key, value = (str(item[0].value), item[1]) if pair else (str(index), item)
        inner = f"{path}.{key}" if path else key
        places.lines.setdefault(inner, (item[0] if pair else item).start_mark.line + 1)
        _note_yaml_places(value, inner, places)
