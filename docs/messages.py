"""Every message of tendon, from the code itself, for the page of questions: none can be missing or out of date."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

PACKAGE = Path(__file__).parents[1] / "tendon_cli"
KINDS = {
    "UsageError": "usage, exit 2",
    "Fault": "study, exit 2",
    "fault": "study, exit 2",
    "SizeError": "size, exit 2",
    "InputError": "input, exit 3",
    "OutputError": "output, exit 5",
    "WorkersLostError": "workers, exit 6",
    "MemoryShortError": "memory, exit 6",
    "FolderError": "folder, exit 7",
    "UnitError": "study, exit 2",
}
_PLACE_OF_MESSAGE = {"Fault": 1}
_PLACE_OF_HINT = {"Fault": 2, "fault": 1, "UnitError": 1}


def messages() -> list[tuple[str, str, str]]:
    """Message, what helps and kind of every error, by the message; a value that it holds is `...`."""
    found: dict[tuple[str, str], str] = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        for function in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(function, ast.FunctionDef):
                for message, hint, kind in _of(function):
                    found[message, kind] = found.get((message, kind)) or hint
    return sorted((message, hint, kind) for (message, kind), hint in found.items())


def table() -> str:
    """All messages as a Markdown table."""
    rows = [f"| {_cell(message)} | {_cell(hint)} | {kind} |" for message, hint, kind in messages()]
    return "\n".join(["| message | what helps | kind |", "|---|---|---|", *rows])


def _of(function: ast.AST) -> Iterator[tuple[str, str, str]]:
    """Those of the errors that one function makes."""
    assigned = [node for node in ast.walk(function) if isinstance(node, ast.Assign)]
    for node in ast.walk(function):
        name = (
            node.func.id if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else ""
        )
        if not isinstance(node, ast.Call) or name not in KINDS:
            continue
        texts = {
            each.targets[0].id: _texts(each.value, {})
            for each in assigned
            if each.lineno <= node.lineno and isinstance(each.targets[0], ast.Name)
        }
        place = _PLACE_OF_MESSAGE.get(name, 0)
        hints = [each.value for each in node.keywords if each.arg == "hint"]
        if name in _PLACE_OF_HINT and len(node.args) > _PLACE_OF_HINT[name]:
            hints.append(node.args[_PLACE_OF_HINT[name]])
        hint = "; or ".join(dict.fromkeys(text for each in hints for text in _texts(each, texts)))
        for message in _texts(node.args[place], texts) if len(node.args) > place else ():
            if re.search(r"[A-Za-z]{3}", message):
                yield message, hint, KINDS[name]


def _texts(node: ast.AST, known: dict[str, list[str]]) -> list[str]:
    """What a piece of code may say; what it works out is `...`."""
    if isinstance(node, ast.Constant):
        return [node.value] if isinstance(node.value, str) else []
    if isinstance(node, ast.JoinedStr):
        return [
            "".join(
                str(part.value) if isinstance(part, ast.Constant) else "..." for part in node.values
            )
        ]
    if isinstance(node, ast.IfExp):
        return [*_texts(node.body, known), *_texts(node.orelse, known)]
    if isinstance(node, ast.BoolOp):
        return [text for value in node.values for text in _texts(value, known)]
    return known.get(node.id, []) if isinstance(node, ast.Name) else []


def _cell(text: str) -> str:
    return re.sub(r"([|<>*_`\[\]])", r"\\\1", " ".join(text.split()))
