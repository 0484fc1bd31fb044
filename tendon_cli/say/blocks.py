"""Blocks of a long text, as data that JSON can hold, and as a terminal shows them.

A block is {"heading": text}, {"sentence": text}, {"item": text} of a list, {"note": text},
{"command": text} to type as it stands, or {"table": rows of cells}, whose first row is its head.
Headings and sentences begin a paragraph.
`reports/html.py` makes a page of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from tendon_cli.say.words import WIDTH, align_cells, name_joint, wrap

Block = Mapping[str, Any]


def heading(text: str) -> Block:
    """Title of the blocks after it."""
    return {"heading": text}


def sentence(text: str) -> Block:
    """Sentence that begins a paragraph."""
    return {"sentence": text}


def items(texts: Iterable[str]) -> Iterator[Block]:
    """Items of a list."""
    return ({"item": text} for text in texts)


def command(text: str) -> Block:
    """Command to type, which no line break interrupts."""
    return {"command": text}


def table(rows: Iterable[Sequence[str]]) -> Block:
    """Small table of text; the first row is its head."""
    return {"table": [[*row] for row in rows]}


def as_text(blocks: Iterable[Block], study: Any, width: int = WIDTH) -> str:
    """Return blocks as text of so many columns that names the study's joint (`name_joint`)."""
    lines: list[str] = []
    for block in blocks:
        ((kind, content),) = block.items()
        if kind == "table":
            cells = [[name_joint(cell, study) for cell in row] for row in content]
            lines += align_cells(cells, width=width)
            continue
        if kind == "command":
            lines.append(f"    {content}")
            continue
        if lines and kind in ("heading", "sentence"):
            lines.append("")
        text = name_joint(content, study)
        if kind == "note":
            text = f"Note: {text}"
        lines += wrap(text, "  " if kind == "item" else "", width)
    return "\n".join(lines)
