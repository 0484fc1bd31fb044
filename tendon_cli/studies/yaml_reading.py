"""YAML 1.2 text to a plain dictionary, with the place of every key.

Looked at event by event before anything is built: nesting is bounded, and anchors, aliases, tags and merge keys, which
YAML can make bombs of, are refused. A study needs none of them.
"""

from __future__ import annotations

import re
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError

from tendon_cli.errors import StudyError
from tendon_cli.studies.toml_reading import LONG_INTEGER, MAX_DEPTH, Document, KeyPlaces, refused
from tendon_cli.units import shorten

_MARK = re.compile(r"'?<([a-z ]+)>'?")
_MARKS = {
    "document start": "nothing more",
    "scalar": "a value",
    "block end": "the end of the table",
    "block mapping start": "a key",
    "block sequence start": "a list",
    "stream end": "the end of the file",
}
_TUPLE = re.compile(r"\((.*?),?\)$")
_TOML = "a study in TOML is a file that ends in .toml"
_OF_THE_PARSER = {
    "found unexpected end of stream": ("text that is not closed, expected a quote at its end", None),
    "cannot start any token": ("a sign that cannot start a value", "indent with spaces, not with tabs"),
    "mapping values are not allowed here": ("a second colon, expected one value", 'text with ": " in it needs quotes'),
    "found another document": ("a second document, expected one", None),
    "expected <block end>": (None, "keys of one table are indented alike"),
    "'<document start>'": ("neither a key nor a value, expected such as `name: fig07`", _TOML),
}
"""What the parser says, in the words of someone who writes a study, and what helps."""


def read_yaml(text: str) -> Document:
    """The content of a YAML document and where its keys stand; raises StudyError."""
    yaml, places = YAML(typ="safe", pure=True), KeyPlaces()
    try:
        _check_events(YAML(typ="safe", pure=True).parse(text))
        node = yaml.compose(text)
        content = {} if node is None else _value(yaml, node, "", places)
    except MarkedYAMLError as error:
        raise _not_yaml(error.problem or str(error), error.problem_mark) from None
    except YAMLError as error:
        at = getattr(error, "position", None)
        line = text[:at].count("\n") + 1 if isinstance(at, int) else None
        raise refused(f"not YAML: {shorten(str(error).splitlines()[0], 120)}", line=line) from None
    if not isinstance(content, dict | None):
        raise refused("the file holds no keys, expected such as `name: my-study`", line=1)
    return Document(content or {}, places)


def _not_yaml(message: str, mark: Any) -> StudyError:
    """What the parser found, in our words where there are better ones than its own."""
    message = message.partition("\n")[0]
    problem, hint = next((words for sign, words in _OF_THE_PARSER.items() if sign in message), (None, None))
    plain = _MARK.sub(lambda match: _MARKS.get(match.group(1), match.group(1)), _TUPLE.sub(r"\1", message))
    return refused(f"not YAML: {shorten(problem or plain, 120)}", hint, mark.line + 1 if mark else None)


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
            tag = str(event.tag).replace("tag:yaml.org,2002:", "!!")
            raise refused(f"the YAML tag {shorten(tag)} is not read", "leave it out", line)


def _value(yaml: YAML, node: Any, path: str, places: KeyPlaces) -> Any:
    """What a node says, the lines of its keys noted; raises StudyError."""
    if isinstance(node.value, str):
        return _scalar(yaml, node, path)
    is_list = str(node.tag).endswith(":seq")
    content: dict[str, Any] = {}
    entries: Any = enumerate(node.value) if is_list else node.value
    for key, item in entries:
        name, line = (str(key), item.start_mark.line + 1) if is_list else (_key(key, path), key.start_mark.line + 1)
        if name in content:
            raise refused(f'not YAML: duplicate key "{shorten(name)}", expected each key once', line=line)
        inner = f"{path}.{name}".removeprefix(".")
        places.lines.setdefault(inner, line)
        content[name] = _value(yaml, item, inner, places)
    return list(content.values()) if is_list else content


def _key(node: Any, table: str) -> str:
    """A word; raises StudyError for numbers, dates, truth values, lists, tables and merge keys."""
    line = node.start_mark.line + 1
    if not isinstance(node.value, str):
        raise refused("a list or table stands as a key, expected a word", None, line, shorten(table, 120))
    key = shorten(f"{table}.{shorten(node.value)}".removeprefix("."), 120)
    if node.value == "<<":
        raise refused("YAML merge keys are not read", "write the keys out", line, key)
    if not str(node.tag).endswith(":str"):
        given = f'"{shorten(node.value)}"' if node.value else "nothing"
        raise refused(f"{given} stands as a key, expected a word", "text in quotes is a word", line, key)
    return str(node.value)


def _scalar(yaml: YAML, node: Any, path: str) -> Any:
    try:
        return yaml.constructor.construct_object(node)
    except (ValueError, OverflowError):
        is_date = str(node.tag).endswith(":timestamp")
        date = f'"{shorten(node.value)}" is not a date of the calendar, expected text in quotes'
        problem = date if is_date else LONG_INTEGER
        raise refused(problem, None, node.start_mark.line + 1, shorten(path, 120)) from None
