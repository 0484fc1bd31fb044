"""What is said at length, as data that JSON can hold, and as a terminal has it; `reports/html.py` has it as a page.

A block is {"heading": text}, {"sentence": text}, {"item": text} of a list, {"note": text}, or {"table": rows of cells},
whose first row is its head. Headings and sentences begin a paragraph.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from tendon_cli.say.words import aligned, filled, of_joint

Block = Mapping[str, Any]


def heading(text: str) -> Block:
    """What the blocks after it are about."""
    return {"heading": text}


def sentence(text: str) -> Block:
    """A paragraph."""
    return {"sentence": text}


def items(texts: Iterable[str]) -> Iterator[Block]:
    """A list."""
    return ({"item": text} for text in texts)


def table(rows: Iterable[Sequence[str]]) -> Block:
    """A small table of text, its head first."""
    return {"table": [[*row] for row in rows]}


def as_text(blocks: Iterable[Block], study: Any) -> str:
    """Blocks in 80 columns, in the words for the study's joint (`of_joint`)."""
    lines: list[str] = []
    for block in blocks:
        ((kind, content),) = block.items()
        if kind == "table":
            lines += aligned([[of_joint(cell, study) for cell in row] for row in content])
            continue
        lines += [""] if lines and kind in ("heading", "sentence") else []
        text = of_joint(content, study)
        lines += filled(f"Note: {text}" if kind == "note" else text, "  " if kind == "item" else "")
    return "\n".join(lines)
