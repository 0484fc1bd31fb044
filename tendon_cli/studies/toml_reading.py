"""Read TOML as a plain dictionary with the line of every key, after a check of its nesting."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from tendon_cli.errors import Fault, StudyError
from tendon_cli.units import shorten

MAX_BYTES = 256_000
"""Largest size of a study file, bytes."""
MAX_DEPTH = 32
"""Largest nesting of tables and lists."""
MAX_KEY_PARTS = 16
"""Largest number of parts of a dotted key."""
LONG_INTEGER = "an integer of more than 4300 digits, no study needs that"
"""Fault of an integer that the grammars allow, but that Python does not convert."""
_LONGEST_PATH = 200
"""Largest number of characters of a path in a fault."""
_TWICE = re.compile(r"Cannot (?:declare|redefine namespace) \((.*)\)")
"""Message of the parser for a table that is written twice."""
_PLAIN_WORDS = {
    "Cannot overwrite a value": "a key that is given twice, expected each key once",
    "Illegal character '\\n'": "text that is not closed on its line, expected a quote at its end",
    "Invalid value": "not a value of TOML, expected a number, a list, or text in quotes",
    "Invalid statement": 'not a key and not a table, expected such as name = "fig07" or [arm]',
}
"""Messages of the parser for which the author of a study needs other words."""

_MARK = re.compile(
    r'"""(?:\\.|[^\\])*?(?:"""|\Z)'  # strings of several lines
    r"|'''.*?(?:'''|\Z)"
    r'|"(?:\\.|[^"\\\n])*(?:"|$)'  # strings of one line
    r"|'[^'\n]*(?:'|$)"
    r"|\#[^\n]*"
    r"|[\[\]{}=.,\n]",
    re.DOTALL | re.MULTILINE,
)
"""Pieces of a text that tell where its keys are: strings, comments and punctuation."""
_KEY_PART = re.compile(r"""\s*("(?:\\.|[^"\\])*"|'[^']*'|[^."'\s]+)\s*(?:\.|$)""")


def refused(
    problem: str, hint: str | None = None, line: int | None = None, key: str = ""
) -> StudyError:
    """Return the error for a file or a value that cannot be read, with its only fault."""
    return StudyError([Fault(key, problem, hint, line)])


def shown(file: Path) -> str:
    """Return a path as a fault shows it."""
    return shorten(str(file), _LONGEST_PATH)


Place = tuple[int | None, Path | None]
"""Line of a key, None if it has none, and its file from the folder of the study; None for the
study's own file."""


@dataclass
class KeyPlaces:
    """Places of the keys of a study in its file, or in one that it extends."""

    places: dict[str, Place] = field(default_factory=dict)
    """Place of each dotted key, in the order of the document."""

    def note(self, path: str, line: int) -> None:
        """Keep the line at which a key stands for the first time."""
        self.places.setdefault(path, (line, None))

    def forget(self, path: str) -> None:
        """Forget the places of a key that the command line sets, and of every key inside it."""
        for key in (path, *self._inside(path)):
            self.places[key] = (None, None)

    def remove(self, path: str) -> None:
        """Remove the places of a key that another file replaces, and of every key inside it."""
        for key in (path, *self._inside(path)):
            self.places.pop(key, None)

    def line_of(self, path: str) -> int | None:
        """Return the line of a key, or the nearest line to it.

        The nearest is that of the first key inside it, or else of the nearest table around it.
        """
        return self._nearest(path)[0]

    def file_of(self, path: str) -> Path | None:
        """Return the file in which the line of a key stands; None for the study's own."""
        return self._nearest(path)[1]

    def folder_of(self, path: str) -> Path:
        """Return the folder of the file that states a key, from the folder of the study."""
        file = self.file_of(path)
        return Path() if file is None else file.parent

    def placed(self, fault: Fault, path: str | None = None) -> Fault:
        """Return a fault with the line and the file of its key, unless it has a line already.

        Args:
            fault: The fault.
            path: Whole dotted key, if that of the fault is shortened.
        """
        if fault.line is not None:
            return fault
        line, file = self._nearest(fault.key if path is None else path)
        return replace(fault, line=line, file=None if file is None else shown(file))

    def _nearest(self, path: str) -> Place:
        """Return the place of a key, or of the key that has one and is nearest to it."""
        while path and path not in self.places:
            inside = self._inside(path)
            if inside and self.places[inside[0]][0] is not None:
                return self.places[inside[0]]
            path = path.rpartition(".")[0]
        return self.places.get(path, (None, None))

    def _inside(self, path: str) -> list[str]:
        """Return the keys with places inside a table or a list, in the order of the document."""
        return [key for key in self.places if key.startswith(f"{path}.")]


@dataclass(frozen=True)
class Document:
    """Content of a study file, unchecked, with the places of its keys."""

    content: dict[str, Any]
    """Tables and keys as the file has them."""
    places: KeyPlaces
    """Places of the keys."""
    sha256: str = ""
    """SHA-256 of the file; empty for text that is no file."""
    file: Path | None = None
    """Path of a file that the study extends, from the folder of the study; None for its own."""


def read_value(text: str) -> Any:
    """Return a value that the command line gives as TOML.

    Raises:
        StudyError: The text is not one value.
    """
    if len(text) > MAX_BYTES:
        raise refused(f"a value of {len(text)} characters, at most {MAX_BYTES} are read")
    content = read_toml(f"value = {text}").content
    if set(content) != {"value"}:
        raise refused("more than one value")
    return content["value"]


def read_toml(text: str) -> Document:
    """Return the content of TOML text; its nesting is checked before it is parsed.

    Raises:
        StudyError: The text is not TOML, or nested or dotted too deeply.
    """
    places = _key_places(text)
    try:
        return Document(tomllib.loads(text), places)
    except tomllib.TOMLDecodeError as error:
        message, _, place = str(error).partition(" (at ")
        line = text.count("\n") + 1
        if place.startswith("line "):
            line = int(place.split()[1].strip(","))
        problem, hint = _plain_words(text, message, line, places)
        raise refused(f"not TOML: {problem}", hint, line) from None
    except ValueError:
        raise refused(LONG_INTEGER) from None


def _plain_words(text: str, message: str, line: int, places: KeyPlaces) -> tuple[str, str | None]:
    """Return the problem with a line, and a hint, for the author of a study."""
    lines = [*text.splitlines(), "", ""]
    written = lines[line - 1].strip()
    value = written.partition("=")[2].strip()
    twice = _TWICE.match(message)
    if twice is not None:
        # The parser prints a key as Python does.
        return _given_twice(".".join(re.findall(r"'([^']*)'", twice[1])), lines, places)
    if "\\" in value and value.startswith('"'):
        path = shorten(value.strip('"'))
        problem = "a backslash in double quotes begins an escape"
        return problem, f"write a path in single quotes, '{path}', or with /"
    problem = _PLAIN_WORDS.get(message) or f"{message[:1].lower()}{message[1:]}"
    if value[:1].isdigit() and value[-1:].isalpha():
        return problem, f'a quantity with a unit needs quotes: "{shorten(value)}"'
    return shorten(problem, 200), f"the line reads: {shorten(written)}" if written else None


def _given_twice(path: str, lines: list[str], places: KeyPlaces) -> tuple[str, str]:
    """Return the problem with a table that is written twice, with both lines, and a hint."""
    first = min(
        line
        for key, (line, _) in places.places.items()
        if line and f"{key}.".startswith(f"{path}.")
    )
    written = lines[first - 1].strip()
    dotted, _, rest = written.partition("=")
    name = f"{path.rpartition('.')[2]}."
    if name not in dotted:
        return f"[{path}] is written twice, first in line {first}", "write all its keys there"
    key = shorten(f"{dotted.partition(name)[2]}={rest}")
    problem = f"{path} is a table here, and line {first} has a key of it with a dot"
    return problem, f"write line {first} below [{path}], as: {key}"


def _key_places(text: str) -> KeyPlaces:
    """Return the line of every key.

    The parser of the standard library needs gigabytes for one long dotted key, and forgets line
    numbers and the order of tables that are opened again. This scan does not check the grammar.

    Raises:
        StudyError: The text is nested or dotted too deeply.
    """
    places = KeyPlaces()
    table: list[str] = []
    last_entries: dict[str, int] = {}
    line = 1
    depth = 0
    dots = 0  # since the last mark that is not a dot
    start = 0  # of the statement in the text
    in_key = True
    for match in _MARK.finditer(text):
        mark = match.group()
        if mark[0] not in "\"'#":
            dots = dots + 1 if mark == "." else 0
            if mark in "[{":
                depth += 1
            elif mark in "]}":
                depth -= 1
        if dots >= MAX_KEY_PARTS or depth > MAX_DEPTH:
            dotted = f"a key of more than {MAX_KEY_PARTS} parts"
            nested = f"nested deeper than {MAX_DEPTH} levels"
            raise refused(dotted if dots else nested, "a study needs no more than four", line)
        if depth == 0 and mark in "=\n":
            statement = text[start : match.start()].strip()
            if in_key and mark == "=":
                places.note(".".join([*table, *_key_parts(statement)]), line)
            elif in_key and statement.startswith("["):
                table = _table_of(statement, last_entries)
                places.note(".".join(table), line)
            in_key = mark == "\n"
            if in_key:
                start = match.end()
        line += mark.count("\n")
    return places


def _table_of(header: str, last_entries: dict[str, int]) -> list[str]:
    """Return the parts of the path that a header opens.

    Args:
        header: The statement, such as `[arm]` or `[[cases]]`.
        last_entries: Number of the last entry of each list of tables, by its path; updated.
    """
    table = _key_parts(header.partition("#")[0].strip().strip("[]"))
    path = ".".join(table)
    if header.startswith("[["):
        last_entries[path] = last_entries.get(path, -1) + 1
        return [*table, str(last_entries[path])]
    if table and table[0] in last_entries:
        # A table inside the last entry, such as [cases.arm].
        table.insert(1, str(last_entries[table[0]]))
    return table


def _key_parts(text: str) -> list[str]:
    """Return the parts of a dotted key, unquoted."""
    parts: list[str] = []
    position = 0
    while match := _KEY_PART.match(text, position):
        parts.append(match.group(1).strip("\"'"))
        position = match.end()
    return parts
