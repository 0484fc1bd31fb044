"""Texts in Markdown, in which nothing of a study is read as Markdown or HTML."""

from __future__ import annotations

_ESCAPES = {"&": "&amp;", "<": "&lt;", ">": "&gt;", "|": "\\|", "`": "\\`", "[": "\\["}


def escaped(text: str) -> str:
    """Escape names from studies, so that nothing in them is read as Markdown or HTML."""
    for sign, escape in _ESCAPES.items():
        text = text.replace(sign, escape)
    return text
