"""A look at TOML text before it is parsed: its nesting, the length of its keys, and the line each key stands on.

The parser of the standard library needs gigabytes for one long dotted key, and forgets line numbers and the order of
tables that are opened again. This scan finds all three in one pass over the text; it does not judge the grammar.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from tendon_cli.errors import Fault, StudyError

MAX_DEPTH = 32
MAX_KEY_PARTS = 16
LONG_INTEGER = "an integer of more than 4300 digits, no study needs that"
"""The one thing that the parsers refuse beyond their grammars: Python converts no longer one."""

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


def refused(problem: str, hint: str | None = None, line: int | None = None, key: str = "") -> StudyError:
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
        while True:
            if path in self.lines:
                return self.lines[path]
            inside = next((line for key, line in self.lines.items() if key.startswith(f"{path}.")), None)
            if inside is not None or "." not in path:
                return inside
            path = path.rpartition(".")[0]


def scan(text: str) -> KeyPlaces:
    """Refuse what is nested or dotted too deeply, and note where the keys stand; raises StudyError."""
    scanner = _Scanner(text)
    for match in _MARK.finditer(text):
        scanner.take(match.group(), match.start())
    return scanner.places


class _Scanner:
    """What is known while walking through the marks of a document."""

    def __init__(self, text: str) -> None:
        self.text, self.places = text, KeyPlaces()
        self.line, self.depth, self.dots = 1, 0, 0
        self.statement = 0  # offset at which the current statement starts
        self.in_key = True  # before the equals sign of the current statement
        self.table: list[str] = []
        self.counts: dict[str, int] = {}

    def take(self, mark: str, start: int) -> None:
        if mark[0] not in "\"'#":
            self.dots = self.dots + 1 if mark == "." else 0
            self.depth += (mark in "[{") - (mark in "]}")
        if self.dots >= MAX_KEY_PARTS or self.depth > MAX_DEPTH:
            deep = (
                f"a key of more than {MAX_KEY_PARTS} parts" if self.dots else f"nested deeper than {MAX_DEPTH} levels"
            )
            raise refused(deep, "a study needs no more than four", self.line)
        if self.depth == 0 and self.in_key and mark in "=\n":
            statement = self.text[self.statement : start]
            if mark == "=":
                self._note([*self.table, *_key_parts(statement)])
            elif statement.strip().startswith("["):
                self._header(statement.strip())
        if self.depth == 0 and mark == "=":
            self.in_key = False
        if self.depth == 0 and mark == "\n":
            self.statement, self.in_key = start + 1, True
        self.line += mark.count("\n")

    def _header(self, text: str) -> None:
        self.table = _key_parts(text.partition("#")[0].strip().strip("[]"))
        path = ".".join(self.table)
        if text.startswith("[["):
            self.counts[path] = self.counts.get(path, -1) + 1
            self.table = [*self.table, str(self.counts[path])]
        elif self.table and self.table[0] in self.counts:  # a table inside the latest entry, such as [cases.arm]
            self.table.insert(1, str(self.counts[self.table[0]]))
        self._note(self.table)

    def _note(self, parts: list[str]) -> None:
        self.places.lines.setdefault(".".join(parts), self.line)


def _key_parts(text: str) -> list[str]:
    """The parts of a dotted key, unquoted."""
    parts: list[str] = []
    at = 0
    while match := _KEY_PART.match(text, at):
        parts.append(match.group(1).strip("\"'"))
        at = match.end()
    return parts
