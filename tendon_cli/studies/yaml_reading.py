"""YAML 1.2 text to a plain dictionary, with the place of every key.

Looked at event by event before anything is built: nesting is bounded, and anchors, aliases, tags and merge keys, which
YAML can make bombs of, are refused. A study needs none of them.
"""

from __future__ import annotations

import re
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError

from tendon_cli.errors import Fault, StudyError
from tendon_cli.studies.toml_scan import LONG_INTEGER, MAX_DEPTH, KeyPlaces
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
_MOST_DIGITS = 4300
_DUPLICATE = re.compile(r'found (duplicate key ".*?") with value .*')
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


def read_yaml(text: str) -> tuple[dict[str, Any], KeyPlaces]:
    """The content of a YAML document and where its keys stand; raises StudyError."""
    places = KeyPlaces()
    try:
        _check_events(_reader().parse(text))
        _note_places(_reader().compose(text), "", places)
        content = _reader().load(text)
    except MarkedYAMLError as error:
        raise _not_yaml(error.problem or str(error), error.problem_mark) from None
    except YAMLError as error:
        at = getattr(error, "position", None)
        line = text[:at].count("\n") + 1 if isinstance(at, int) else None
        raise _refusal(f"not YAML: {shorten(str(error).splitlines()[0], 120)}", line) from None
    if content is None:
        return {}, places
    if not isinstance(content, dict):
        raise _refusal("the file holds no keys, expected such as `name: my-study`", 1)
    return content, places


def _not_yaml(message: str, mark: Any) -> StudyError:
    """What the parser found, in our words where there are better ones than its own."""
    message = _DUPLICATE.sub(r"\1, expected each key once", message.partition("\n")[0])
    said, hint = next((words for sign, words in _OF_THE_PARSER.items() if sign in message), (None, None))
    plain = _MARK.sub(lambda match: _MARKS.get(match.group(1), match.group(1)), _TUPLE.sub(r"\1", message))
    return _refusal(f"not YAML: {shorten(said or plain, 120)}", mark.line + 1 if mark else None, hint)


def _reader() -> YAML:
    return YAML(typ="safe", pure=True)


def _refusal(problem: str, line: int | None, hint: str | None = None, key: str = "") -> StudyError:
    return StudyError([Fault(shorten(key, 120), problem, hint, line)])


def _check_events(events: Any) -> None:
    """Refuse deep nesting, anchors, aliases and tags, while nothing has been built yet."""
    depth = 0
    for event in events:
        kind = type(event).__name__
        line = event.start_mark.line + 1
        depth += kind.endswith(("MappingStartEvent", "SequenceStartEvent"))
        depth -= kind.endswith(("MappingEndEvent", "SequenceEndEvent"))
        if depth > MAX_DEPTH:
            raise _refusal(f"nested deeper than {MAX_DEPTH} levels", line)
        if getattr(event, "anchor", None) is not None:
            raise _refusal("YAML anchors and aliases are not read", line, "write the value out")
        if getattr(event, "tag", None) is not None:
            tag = str(event.tag).replace("tag:yaml.org,2002:", "!!")
            raise _refusal(f"the YAML tag {shorten(tag)} is not read", line, "leave it out")


def _note_places(node: Any, path: str, places: KeyPlaces) -> None:
    """Remember the line of every key, in the order of the document; keys are words and nothing else."""
    if node is None:
        return
    if isinstance(node.value, str):
        _check_scalar(node, path)
        return
    for index, item in enumerate(node.value):
        pair = isinstance(item, tuple)
        at, value = item if pair else (item, item)
        line = at.start_mark.line + 1
        if pair:
            _check_key(at, path)
        inner = f"{path}.{at.value if pair else index}".removeprefix(".")
        places.lines.setdefault(inner, line)
        _note_places(value, inner, places)


def _check_key(node: Any, table: str) -> None:
    """Refuse keys that are no words: numbers, dates, truth values, lists, tables and merge keys."""
    line = node.start_mark.line + 1
    if not isinstance(node.value, str):
        raise _refusal("a list or table stands as a key, expected a word", line, None, table)
    key = f"{table}.{shorten(node.value)}".removeprefix(".")
    if node.value == "<<":
        raise _refusal("YAML merge keys are not read", line, "write the keys out", key)
    if not str(node.tag).endswith(":str"):
        said = f'"{shorten(node.value)}"' if node.value else "nothing"
        raise _refusal(f"{said} stands as a key, expected a word", line, "text in quotes is a word", key)


def _check_scalar(node: Any, key: str) -> None:
    """Refuse the numbers and dates that end in an exception when they are built."""
    line = node.start_mark.line + 1
    if len(node.value) > _MOST_DIGITS and str(node.tag).endswith(":int") and "x" not in node.value[:3]:
        raise _refusal(LONG_INTEGER, line, None, key)
    if str(node.tag).endswith(":timestamp"):
        try:
            _reader().constructor.construct_object(node)
        except (ValueError, OverflowError):
            raise _refusal(
                f'"{shorten(node.value)}" is not a date of the calendar, expected text in quotes', line, None, key
            ) from None
