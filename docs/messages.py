"""Collect all messages of tendon from its code, so that the page of questions lacks none."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

PACKAGE = Path(__file__).parents[1] / "tendon_cli"
KINDS = {
    "UsageError": "usage, exit 2",
    "StudyError": "study, exit 2",
    "Fault": "study, exit 2",
    "fault": "study, exit 2",
    "SizeError": "size, exit 2",
    "InputError": "input, exit 3",
    "table.refuse": "input, exit 3",
    "self.refuse": "input, exit 3",
    "OutputError": "output, exit 5",
    "WorkersLostError": "workers, exit 6",
    "MemoryShortError": "memory, exit 6",
    "FolderError": "folder, exit 7",
    "UnitError": "study, exit 2",
    "InterruptError": "stopped, exit 128 + signal",
}
"""Kind and exit code of each error, by the name that makes it."""
_PLACE_OF_MESSAGE = {"Fault": 1}
"""Place of the message among the arguments; 0 for any other error."""
_PLACE_OF_HINT = {"Fault": 2, "fault": 1, "UnitError": 1, "table.refuse": 1, "self.refuse": 1}
"""Place of the hint among the arguments, unless it is given by keyword."""


def messages() -> list[tuple[str, str, str]]:
    """Return message, hint and kind of all errors, sorted; a value in a message is `...`."""
    hints: dict[tuple[str, str], str] = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        for scope in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            found: Iterator[tuple[str, str, str]] = iter(())
            if isinstance(scope, ast.FunctionDef):
                found = _messages_in(scope)
            elif isinstance(scope, ast.ClassDef) and scope.name in KINDS:
                found = _messages_in(scope, of_class=scope.name)
            for message, hint, kind in found:
                hints[message, kind] = hints.get((message, kind)) or hint
    return sorted((message, hint, kind) for (message, kind), hint in hints.items())


def sections() -> str:
    """Return all messages in Markdown: a heading and a table for each kind of error."""
    by_kind: dict[str, list[tuple[str, str]]] = {kind: [] for kind in KINDS.values()}
    for message, hint, kind in messages():
        by_kind[kind].append((message, hint))
    return "\n\n".join(_section(kind, rows) for kind, rows in by_kind.items() if rows)


def _section(kind: str, rows: list[tuple[str, str]]) -> str:
    """Return the heading and the table of one kind of error, ordered by the first words."""
    lines = [
        f"| {_cell(message)} | {_cell(hint)} |"
        for message, hint in sorted(rows, key=lambda row: _first_words(row[0]))
    ]
    return "\n".join(
        [f"### {kind.capitalize()}", "", "| message | what helps |", "|---|---|", *lines]
    )


def _first_words(message: str) -> str:
    """Return a message from its first letter on, in small letters, for sorting."""
    return re.sub(r"^[^A-Za-z]+", "", message).lower()


def _messages_in(scope: ast.AST, of_class: str = "") -> Iterator[tuple[str, str, str]]:
    """Yield message, hint and kind of each error that a function makes.

    Args:
        scope: The function, or the class of an error that makes its message itself.
        of_class: Name of this class; empty for a function.
    """
    for node in ast.walk(scope):
        if not isinstance(node, ast.Call):
            continue
        is_own = of_class and ast.unparse(node.func) == "super().__init__"
        name = of_class if is_own else ast.unparse(node.func)
        if name not in KINDS:
            continue
        known = _assigned_texts(scope, node)
        place_of_hint = _PLACE_OF_HINT.get(name)
        hints = [keyword.value for keyword in node.keywords if keyword.arg == "hint"]
        if place_of_hint is not None and len(node.args) > place_of_hint:
            hints.append(node.args[place_of_hint])
        hint_texts = [text for hint in hints for text in _texts(hint, known)]
        hint = "; or ".join(dict.fromkeys(hint_texts))
        place = _PLACE_OF_MESSAGE.get(name, 0)
        if len(node.args) > place:
            for message in _texts(node.args[place], known):
                if re.search(r"[A-Za-z]{3}", message):
                    yield message, hint, KINDS[name]


def _assigned_texts(scope: ast.AST, call: ast.Call) -> dict[str, list[str]]:
    """Return the texts that variables may hold at a call, by name.

    What is assigned in a deeper block than that of the call may not happen: its text is one more.
    Any other assignment replaces what the variable held before.
    """
    statements = [
        node
        for node in ast.walk(scope)
        if isinstance(node, ast.stmt) and node.lineno <= call.lineno
    ]
    around = [node for node in statements if (node.end_lineno or 0) >= call.lineno]
    depth = max((node.col_offset for node in around), default=0)
    texts: dict[str, list[str]] = {}
    for node in sorted(statements, key=lambda node: node.lineno):
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            name = node.targets[0].id
            before = texts.get(name, []) if node.col_offset > depth else []
            texts[name] = before + _texts(node.value, {})
    return texts


def _texts(node: ast.AST, known: dict[str, list[str]]) -> list[str]:
    """Return the texts that an expression may have; a value within a text is `...`.

    Args:
        node: The expression.
        known: Texts of variables by name.
    """
    if isinstance(node, ast.Constant):
        return [node.value] if isinstance(node.value, str) else []
    if isinstance(node, ast.JoinedStr):
        parts = [
            str(part.value) if isinstance(part, ast.Constant) else "..." for part in node.values
        ]
        return ["".join(parts)]
    if isinstance(node, ast.IfExp):
        return [*_texts(node.body, known), *_texts(node.orelse, known)]
    if isinstance(node, ast.BoolOp):
        return [text for value in node.values for text in _texts(value, known)]
    if isinstance(node, ast.Name):
        return known.get(node.id, [])
    return []


def _cell(text: str) -> str:
    """Return a text as a cell of a Markdown table; values beside each other become one `...`."""
    text = re.sub(r"\.\.\.(?: ?\.\.\.)+", "...", text)
    return re.sub(r"([|<>*_`\[\]])", r"\\\1", " ".join(text.split()))
