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
from tendon_cli.study.toml_scan import MAX_DEPTH, KeyPlaces
from tendon_cli.units import shorten

_PLACEHOLDERS = {
    "'<document start>'": "nothing more",
    "'<scalar>'": "a value",
    "'<block end>'": "the end of the block",
    "'<block mapping start>'": "a block of keys",
    "'<stream end>'": "the end of the file",
}
_PLACEHOLDER = re.compile("|".join(map(re.escape, _PLACEHOLDERS)))


def read_yaml(text: str) -> tuple[dict[str, Any], KeyPlaces]:
    """The content of a YAML document and where its keys stand; raises StudyError."""
    places = KeyPlaces()
    try:
        _check_events(_reader().parse(text))
        _note_places(_reader().compose(text), "", places)
        content = _reader().load(text)
    except MarkedYAMLError as error:
        problem = _PLACEHOLDER.sub(
            lambda match: _PLACEHOLDERS[match.group()], (error.problem or str(error)).split("\n")[0]
        )
        mark = error.problem_mark
        raise _refusal(f"not YAML: {shorten(problem, 120)}", mark.line + 1 if mark else None) from None
    except YAMLError as error:
        raise _refusal(f"not YAML: {shorten(str(error).splitlines()[0], 120)}", None) from None
    except (ValueError, OverflowError):
        raise _refusal("not YAML: an integer of more than 4300 digits, or a date that is none", None) from None
    if content is None:
        return {}, places
    if not isinstance(content, dict):
        raise _refusal("the file holds no keys, expected such as `name: my-study`", 1)
    return content, places


def _reader() -> YAML:
    return YAML(typ="safe", pure=True)


def _refusal(problem: str, line: int | None, hint: str | None = None) -> StudyError:
    return StudyError([Fault("", problem, hint, line)])


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
            raise _refusal(f"the YAML tag {shorten(str(event.tag))} is not read", line, "leave it out")


def _note_places(node: Any, path: str, places: KeyPlaces) -> None:
    """Remember the line of every key, in the order of the document; keys are words and nothing else."""
    if node is None or isinstance(node.value, str):
        return
    for index, item in enumerate(node.value):
        pair = isinstance(item, tuple)
        at, value = item if pair else (item, item)
        line = at.start_mark.line + 1
        if pair and not (isinstance(at.value, str) and str(at.tag).endswith(":str")):
            said = f'"{shorten(at.value)}"' if isinstance(at.value, str) else "a list or table"
            raise _refusal(f"{said} stands as a key, expected a word", line)
        inner = f"{path}.{at.value if pair else index}".removeprefix(".")
        places.lines.setdefault(inner, line)
        _note_places(value, inner, places)
