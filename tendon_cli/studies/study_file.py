"""Read a study file, TOML or YAML 1.2, as a plain dictionary with the line of every key.

Files are hostile until checked: size, nesting and key length are checked before anything is parsed,
YAML anchors, aliases and tags are refused, and nothing that a file says is executed.
"""

from __future__ import annotations

import hashlib
import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

from tendon_cli.files import CSV, STUDIES, TABLE, kind_of_file, read_input
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
"""Endings of a study in YAML."""
STDIN = Path("-")
"""Name of a study from standard input."""
_KEY_OF_YAML = re.compile(r"(?:---|[\w.-]+\s*:(?:\s|$))")
"""Beginning of the first line of a study in YAML, and of none in TOML."""
_HINTS = {
    "mapping values are not allowed": 'a second colon: text with ": " in it needs quotes',
    "cannot start any token": "indent with spaces, not with tabs",
    "<block end>": "keys of one table are indented alike",
    "<document start>": "a study in TOML is a file that ends in .toml",
}
"""Hints by pieces of the YAML parser's messages."""


_USED_BY = {
    CSV: "`tendon fit-friction` reads load-cell readings; a study names its other CSVs by key",
    TABLE: "`tendon show` and `tendon export` read tables",
}
"""Hints at what a file of another kind is for."""


def read_document(path: Path) -> Document:
    """Return the content of a TOML or YAML file.

    Args:
        path: The file; `STDIN` for standard input.

    Raises:
        StudyError: The file cannot be read, is of another kind, or is not of its grammar.
    """
    kind = kind_of_file(path)
    if kind is not None and kind not in STUDIES and path.is_file():
        raise refused(f"this is {kind}, expected a study in TOML or YAML", _USED_BY.get(kind))
    content = _bytes(path)
    try:
        text = content.decode("utf-8-sig").replace("\r\n", "\n")
        document = read_yaml(text) if _is_yaml(path, text) else read_toml(text)
        return replace(document, sha256=hashlib.sha256(content).hexdigest())
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        problem = "not UTF-8 text, expected a study in TOML or YAML"
        raise refused(problem, "save the file as UTF-8", line) from None
    except RecursionError:
        raise refused(f"nested deeper than {MAX_DEPTH} levels") from None


def _is_yaml(path: Path, text: str) -> bool:
    """Return True for YAML: by the ending of a file, by the first line of standard input."""
    if path != STDIN:
        return path.suffix.lower() in YAML_SUFFIXES
    for line in text.splitlines():
        statement = line.strip()
        if statement and not statement.startswith("#"):
            return _KEY_OF_YAML.match(statement) is not None
    return False


def _bytes(path: Path) -> bytes:
    """Return the content of a file or of standard input.

    Raises:
        StudyError: It cannot be read, or is too large or empty.
    """
    try:
        if path != STDIN:
            return read_input(path, MAX_BYTES)
        content = sys.stdin.buffer.read(MAX_BYTES + 1) if sys.stdin is not None else b""
    except FileNotFoundError:
        raise refused("no such file", _hint_at_files(path)) from None
    except IsADirectoryError:
        raise refused("this is a folder, expected a study file") from None
    except (OSError, ValueError) as error:
        raise refused(f"cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if len(content) > MAX_BYTES:
        raise refused(f"cannot be read: it is larger than {MAX_BYTES // 1000} kB")
    if not content.strip():
        problem = "standard input is empty, expected a study in TOML or YAML"
        raise refused(problem, "such as: tendon sweep - < study.toml")
    return content


def _hint_at_files(path: Path) -> str:
    """Return a hint at the file that a path may mean, at those beside it, or at a first one."""
    files = study_files(path.parent)
    meant = [file.name for file in files if file.stem == path.stem]
    if meant:
        return f"did you mean {' or '.join(map(shorten, meant))}?"
    if files:
        return f"files there: {', '.join(shorten(file.name) for file in files[:3])}"
    return "`tendon init` writes a study to start from"


def study_files(folder: Path) -> list[Path]:
    """Return the files of a folder that may be studies by their endings."""
    endings = (".toml", *YAML_SUFFIXES)
    if not folder.is_dir():
        return []
    return sorted(file for file in folder.iterdir() if file.suffix.lower() in endings)


# --- YAML ----------------------------------------------------------------------------------------


def read_yaml(text: str) -> Document:
    """Return the content of a YAML document.

    Its events are checked before anything is built: nesting is bounded, and anchors, aliases, tags
    and merge keys, of which YAML can make bombs, are refused. A study needs none of them.

    Raises:
        StudyError: The text is not YAML, or uses what is refused.
    """
    from ruamel.yaml import YAML  # only studies in YAML pay for its import
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    yaml = YAML(typ="safe", pure=True)
    places = KeyPlaces()
    try:
        _check_events(YAML(typ="safe", pure=True).parse(text))
        node = yaml.compose(text)
        content = {} if node is None else _value(yaml, node, "", places)
    except MarkedYAMLError as error:
        problem = (error.problem or str(error)).partition("\n")[0]
        problem = problem.replace("('", "'").replace("',)", "'")  # a token as Python prints it
        hint = next((hint for sign, hint in _HINTS.items() if sign in problem), None)
        mark = error.problem_mark
        line = mark.line + 1 if mark else None
        raise refused(f"not YAML: {shorten(problem, 120)}", hint, line) from None
    except YAMLError as error:
        position = getattr(error, "position", None)
        line = text[:position].count("\n") + 1 if isinstance(position, int) else None
        problem = shorten(str(error).splitlines()[0], 120)
        raise refused(f"not YAML: {problem}", line=line) from None
    if not isinstance(content, dict | None):
        raise refused("the file holds no keys, expected a line such as `name: my-study`", line=1)
    return Document(content or {}, places)


def _check_events(events: Any) -> None:
    """Refuse deep nesting, anchors, aliases and tags, before anything is built from the events."""
    depth = 0
    for event in events:
        kind = type(event).__name__
        line = event.start_mark.line + 1
        if kind.endswith(("MappingStartEvent", "SequenceStartEvent")):
            depth += 1
        elif kind.endswith(("MappingEndEvent", "SequenceEndEvent")):
            depth -= 1
        if depth > MAX_DEPTH:
            raise refused(f"nested deeper than {MAX_DEPTH} levels", line=line)
        if getattr(event, "anchor", None) is not None:
            raise refused("YAML anchors and aliases are not read", "write the value out", line)
        tag = getattr(event, "tag", None)
        if tag is not None:
            raise refused(f"the YAML tag {shorten(str(tag))} is not read", "leave it out", line)


def _value(yaml: Any, node: Any, path: str, places: KeyPlaces) -> Any:
    """Return the value of a node, and add the lines of its keys to `places`.

    Args:
        yaml: The parser, which converts scalars.
        node: A scalar, a list or a table.
        path: Dotted key of the node.
        places: Lines of the keys so far.

    Raises:
        StudyError: A key or a scalar cannot be read.
    """
    if isinstance(node.value, str):
        return _scalar(yaml, node, path)
    is_list = str(node.tag).endswith(":seq")
    content: dict[str, Any] = {}
    entries: Any = enumerate(node.value) if is_list else node.value
    for key, item in entries:
        if is_list:
            name = str(key)
            line = item.start_mark.line + 1
        else:
            name = _key(key, path)
            line = key.start_mark.line + 1
        if name in content:
            problem = f'not YAML: duplicate key "{shorten(name)}", expected each key once'
            raise refused(problem, line=line)
        inner = f"{path}.{name}".removeprefix(".")
        places.note(inner, line)
        content[name] = _value(yaml, item, inner, places)
    return list(content.values()) if is_list else content


def _key(node: Any, table: str) -> str:
    """Return the word of a key.

    Args:
        node: The key.
        table: Dotted key of its table.

    Raises:
        StudyError: The key is a number, a date, a truth value, a list, a table or a merge key.
    """
    line = node.start_mark.line + 1
    if not isinstance(node.value, str):
        problem = "a list or table is used as a key, expected a word"
        raise refused(problem, None, line, shorten(table, 120))
    key = shorten(f"{table}.{shorten(node.value)}".removeprefix("."), 120)
    if node.value == "<<":
        raise refused("YAML merge keys are not read", "write the keys out", line, key)
    if not str(node.tag).endswith(":str"):
        given = f'"{shorten(node.value)}"' if node.value else "nothing"
        problem = f"{given} is used as a key, expected a word"
        raise refused(problem, "text in quotes is a word", line, key)
    return str(node.value)


def _scalar(yaml: Any, node: Any, path: str) -> Any:
    """Return the text, number, date or truth value of a node."""
    try:
        return yaml.constructor.construct_object(node)
    except (ValueError, OverflowError):
        problem = LONG_INTEGER
        if str(node.tag).endswith(":timestamp"):
            given = f'"{shorten(node.value)}"'
            problem = f"{given} is not a date of the calendar, expected text in quotes"
        raise refused(problem, None, node.start_mark.line + 1, shorten(path, 120)) from None
