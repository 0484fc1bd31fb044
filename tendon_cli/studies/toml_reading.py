"""TOML text to a plain dictionary, with the line of every key; nesting and key length are looked at before."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass, field
from typing import Any

from tendon_cli.errors import Fault, StudyError
from tendon_cli.units import shorten

MAX_BYTES = 256_000
MAX_DEPTH = 32
MAX_KEY_PARTS = 16
LONG_INTEGER = "an integer of more than 4300 digits, no study needs that"
"""The one thing that the parsers refuse beyond their grammars: Python converts no longer one."""
_OF_THE_PARSER = {
    "Cannot overwrite a value": "a key that stands twice, expected each key once",
    "Illegal character '\\n'": "text that is not closed on its line, expected a quote at its end",
    "Invalid value": "no value that TOML knows, expected a number, a list, or text in quotes",
    "Invalid statement": 'neither a key nor a table, expected such as name = "fig07" or [arm]',
}
"""What the parser says, where a study's author needs other words."""

_MARK = re.compile(
    r'"""(?:\\.|[^\\])*?(?:"""|\Z)'  # strings of several lines
    r"|'''.*?(?:'''|\Z)"
    r'|"(?:\\.|[^"\\\n])*(?:"|$)'  # strings of one line
    r"|'[^'\n]*(?:'|$)"
    r"|\#[^\n]*"
    r"|[\[\]{}=.,\n]",
    re.DOTALL | re.MULTILINE,
)
_KEY_PART = re.compile(r"""\s*("(?:\\.|[^"\\])*"|'[^']*'|[^."'\s]+)\s*(?:\.|$)""")


def refused(
    problem: str, hint: str | None = None, line: int | None = None, key: str = ""
) -> StudyError:
    """A file that cannot be read as a study, for one reason."""
    return StudyError([Fault(key, problem, hint, line)])


@dataclass
class KeyPlaces:
    """Where keys stand: `lines[path]` is the line of a dotted key, in the order of the document."""

    lines: dict[str, int | None] = field(default_factory=dict)

    def forget(self, path: str) -> None:
        """A key that the command line sets has no line, and no key inside it."""
        inside = (key for key in self.lines if key.startswith(f"{path}."))
        self.lines |= dict.fromkeys((path, *inside))

    def line_of(self, path: str) -> int | None:
        """The line of a key, else of the first key inside it, else of the nearest table around it."""
        while path and path not in self.lines:
            inside = next(
                (line for key, line in self.lines.items() if key.startswith(f"{path}.")), None
            )
            if inside is not None:
                return inside
            path = path.rpartition(".")[0]
        return self.lines.get(path)


@dataclass(frozen=True)
class Document:
    """What a study file says, unchecked, and where it says it."""

    content: dict[str, Any]
    places: KeyPlaces


def read_value(text: str) -> Any:
    """A value given on the command line as TOML; raises StudyError."""
    if len(text) > MAX_BYTES:
        raise refused(f"a value of {len(text)} characters, at most {MAX_BYTES} are read")
    content = read_toml(f"value = {text}").content
    if set(content) != {"value"}:
        raise refused("more than one value")
    return content["value"]


def read_toml(text: str) -> Document:
    """TOML text, looked at before it is parsed; raises StudyError."""
    places = _scanned(text)
    try:
        return Document(tomllib.loads(text), places)
    except tomllib.TOMLDecodeError as error:
        message, _, place = str(error).partition(" (at ")
        line = (
            int(place.split()[1].strip(",")) if place.startswith("line ") else text.count("\n") + 1
        )
        plain = re.sub(
            r"['(),]", "", f"{message[:1].lower()}{message[1:]}"
        )  # a key as Python prints it
        problem = f"not TOML: {_OF_THE_PARSER.get(message) or shorten(plain, 200)}"
        raise refused(problem, _toml_hint(text, line), line) from None
    except ValueError:
        raise refused(LONG_INTEGER) from None


def _toml_hint(text: str, line: int) -> str | None:
    written = [*text.splitlines(), "", ""][line - 1].strip()
    value = written.partition("=")[2].strip()
    if value[:1].isdigit() and value[-1:].isalpha():
        return f'a quantity with a unit stands in quotes: "{shorten(value)}"'
    return f"the line reads: {shorten(written)}" if written else None


def _scanned(text: str) -> KeyPlaces:
    """The line of every key; raises StudyError for what is nested or dotted too deeply.

    The parser of the standard library needs gigabytes for one long dotted key, and forgets line numbers and the order
    of tables that are opened again. This does not judge the grammar.
    """
    places, table, counts = KeyPlaces(), list[str](), dict[str, int]()
    line, depth, dots, start, in_key = 1, 0, 0, 0, True
    for match in _MARK.finditer(text):
        mark = match.group()
        if mark[0] not in "\"'#":
            dots = dots + 1 if mark == "." else 0
            depth += (mark in "[{") - (mark in "]}")
        if dots >= MAX_KEY_PARTS or depth > MAX_DEPTH:
            dotted, nested = (
                f"a key of more than {MAX_KEY_PARTS} parts",
                f"nested deeper than {MAX_DEPTH} levels",
            )
            raise refused(dotted if dots else nested, "a study needs no more than four", line)
        if depth == 0 and mark in "=\n":
            statement = text[start : match.start()].strip()
            if in_key and mark == "=":
                places.lines.setdefault(".".join([*table, *_key_parts(statement)]), line)
            elif in_key and statement.startswith("["):
                table = _table_of(statement, counts)
                places.lines.setdefault(".".join(table), line)
            in_key = mark == "\n"
            start = match.end() if in_key else start
        line += mark.count("\n")
    return places


def _table_of(header: str, counts: dict[str, int]) -> list[str]:
    """The parts of the path that a header opens; `counts` has the last entry of each list of tables."""
    table = _key_parts(header.partition("#")[0].strip().strip("[]"))
    path = ".".join(table)
    if header.startswith("[["):
        counts[path] = counts.get(path, -1) + 1
        return [*table, str(counts[path])]
    if table and table[0] in counts:  # a table inside the latest entry, such as [cases.arm]
        table.insert(1, str(counts[table[0]]))
    return table


def _key_parts(text: str) -> list[str]:
    """The parts of a dotted key, unquoted."""
    parts: list[str] = []
    at = 0
    while match := _KEY_PART.match(text, at):
        parts.append(match.group(1).strip("\"'"))
        at = match.end()
    return parts
