"""From the bytes of a study file to a plain dictionary, TOML or YAML 1.2, with the line of every key.

Files are hostile until checked: size, nesting and key length are looked at before anything is parsed, YAML anchors,
aliases and tags are refused, and what a file says is never executed.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

from tendon_cli.files import read_file
from tendon_cli.studies.toml_reading import (
    LONG_INTEGER,
    MAX_BYTES,
    MAX_DEPTH,
    Document,
    KeyPlaces,
    read_toml,
    refused,
)
from tendon_cli.units import shorten

YAML_SUFFIXES = (".yaml", ".yml")
STDIN = Path("-")
"""The name of a study from standard input."""
_KEY_OF_YAML = re.compile(r"(?:---|[\w.-]+\s*:(?:\s|$))")
"""How the first line of a study in YAML begins, and none in TOML."""
_HINTS = {
    "mapping values are not allowed": 'a second colon: text with ": " in it needs quotes',
    "cannot start any token": "indent with spaces, not with tabs",
    "<block end>": "keys of one table are indented alike",
    "<document start>": "a study in TOML is a file that ends in .toml",
}
"""What helps, by what the parser says."""


def read_document(path: Path) -> Document:
    """Read a TOML or YAML file; raises StudyError where it cannot be read or is not of its grammar."""
    content = _bytes(path)
    try:
        text = content.decode("utf-8-sig").replace("\r\n", "\n")
        return read_yaml(text) if _is_yaml(path, text) else read_toml(text)
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise refused(
            "not UTF-8 text, expected a study in TOML or YAML", "save the file as UTF-8", line
        ) from None
    except RecursionError:
        raise refused(f"nested deeper than {MAX_DEPTH} levels") from None


def _is_yaml(path: Path, text: str) -> bool:
    """By its ending; of standard input by its first line that says something."""
    if path != STDIN:
        return path.suffix.lower() in YAML_SUFFIXES
    lines = (line.strip() for line in text.splitlines())
    return (
        _KEY_OF_YAML.match(next((line for line in lines if line and line[0] != "#"), ""))
        is not None
    )


def _bytes(path: Path) -> bytes:
    try:
        if path != STDIN:
            return read_file(path, MAX_BYTES)
        content = sys.stdin.buffer.read(MAX_BYTES + 1) if sys.stdin is not None else b""
    except FileNotFoundError:
        near = (
            sorted(other.name for other in path.parent.glob("*.toml"))[:3]
            if path.parent.is_dir()
            else []
        )
        hint = (
            f"files there: {', '.join(map(shorten, near))}"
            if near
            else "`tendon init` writes a study to start from"
        )
        raise refused("no such file", hint) from None
    except IsADirectoryError:
        raise refused("this is a folder, expected a study file") from None
    except (OSError, ValueError) as error:
        raise refused(f"cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if len(content) > MAX_BYTES:
        raise refused(f"cannot be read: it is larger than {MAX_BYTES // 1000} kB")
    if not content.strip():
        raise refused(
            "nothing came in, expected a study in TOML or YAML",
            "such as: tendon sweep - < study.toml",
        )
    return content


def read_yaml(text: str) -> Document:
    """The content of a YAML document and where its keys stand; raises StudyError.

    It is looked at event by event before anything is built: nesting is bounded, and anchors, aliases, tags and merge
    keys, which YAML can make bombs of, are refused. A study needs none of them.
    """
    from ruamel.yaml import YAML  # only studies in YAML pay for its import
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    yaml, places = YAML(typ="safe", pure=True), KeyPlaces()
    try:
        _check_events(YAML(typ="safe", pure=True).parse(text))
        node = yaml.compose(text)
        content = {} if node is None else _value(yaml, node, "", places)
    except MarkedYAMLError as error:
        problem, mark = (error.problem or str(error)).partition("\n")[0], error.problem_mark
        problem = problem.replace("('", "'").replace("',)", "'")  # a token as Python prints it
        hint = next((hint for sign, hint in _HINTS.items() if sign in problem), None)
        raise refused(
            f"not YAML: {shorten(problem, 120)}", hint, mark.line + 1 if mark else None
        ) from None
    except YAMLError as error:
        at = getattr(error, "position", None)
        line = text[:at].count("\n") + 1 if isinstance(at, int) else None
        raise refused(f"not YAML: {shorten(str(error).splitlines()[0], 120)}", line=line) from None
    if not isinstance(content, dict | None):
        raise refused("the file holds no keys, expected such as `name: my-study`", line=1)
    return Document(content or {}, places)


def _check_events(events: Any) -> None:
    """Refuse deep nesting, anchors, aliases and tags, while nothing has been built yet."""
    depth = 0
    for event in events:
        kind, line = type(event).__name__, event.start_mark.line + 1
        depth += kind.endswith(("MappingStartEvent", "SequenceStartEvent"))
        depth -= kind.endswith(("MappingEndEvent", "SequenceEndEvent"))
        if depth > MAX_DEPTH:
            raise refused(f"nested deeper than {MAX_DEPTH} levels", line=line)
        if getattr(event, "anchor", None) is not None:
            raise refused("YAML anchors and aliases are not read", "write the value out", line)
        if getattr(event, "tag", None) is not None:
            raise refused(
                f"the YAML tag {shorten(str(event.tag))} is not read", "leave it out", line
            )


def _value(yaml: Any, node: Any, path: str, places: KeyPlaces) -> Any:
    """What a node says, the lines of its keys noted; raises StudyError."""
    if isinstance(node.value, str):
        return _scalar(yaml, node, path)
    is_list = str(node.tag).endswith(":seq")
    content: dict[str, Any] = {}
    entries: Any = enumerate(node.value) if is_list else node.value
    for key, item in entries:
        name, line = (
            (str(key), item.start_mark.line + 1)
            if is_list
            else (_key(key, path), key.start_mark.line + 1)
        )
        if name in content:
            raise refused(
                f'not YAML: duplicate key "{shorten(name)}", expected each key once', line=line
            )
        inner = f"{path}.{name}".removeprefix(".")
        places.lines.setdefault(inner, line)
        content[name] = _value(yaml, item, inner, places)
    return list(content.values()) if is_list else content


def _key(node: Any, table: str) -> str:
    """A word; raises StudyError for numbers, dates, truth values, lists, tables and merge keys."""
    line = node.start_mark.line + 1
    if not isinstance(node.value, str):
        raise refused(
            "a list or table stands as a key, expected a word", None, line, shorten(table, 120)
        )
    key = shorten(f"{table}.{shorten(node.value)}".removeprefix("."), 120)
    if node.value == "<<":
        raise refused("YAML merge keys are not read", "write the keys out", line, key)
    if not str(node.tag).endswith(":str"):
        given = f'"{shorten(node.value)}"' if node.value else "nothing"
        raise refused(
            f"{given} stands as a key, expected a word", "text in quotes is a word", line, key
        )
    return str(node.value)


def _scalar(yaml: Any, node: Any, path: str) -> Any:
    try:
        return yaml.constructor.construct_object(node)
    except (ValueError, OverflowError):
        date = f'"{shorten(node.value)}" is not a date of the calendar, expected text in quotes'
        problem = date if str(node.tag).endswith(":timestamp") else LONG_INTEGER
        raise refused(problem, None, node.start_mark.line + 1, shorten(path, 120)) from None
