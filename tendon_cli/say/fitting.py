"""Fit labelled sections into a few lines: what matters least is left out first."""

from __future__ import annotations

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from typing import NamedTuple

from tendon_cli.say.words import wrap

LABEL_WIDTH = 10
"""Columns of the labels beside the sections."""
_CUT = " ..."
"""End of a paragraph of which some is cut off."""


class Clause(NamedTuple):
    """A few words that may be left out."""

    text: str
    rank: int = 0
    """Importance: the lower the sooner they stand in the text, those of rank 0 always."""


class Section(NamedTuple):
    """Clauses under a label, or those that begin the text."""

    label: str
    """Label beside the first line; empty for the beginning of the text."""
    clauses: Sequence[Clause]
    separator: str = "; "
    """Text between two clauses; empty if each begins a line."""


def fit(sections: Sequence[Section], most_lines: int, width: int) -> str:
    """Return sections as a text of few lines; a blank line does not count.

    Clauses of rank 0 stand in it. Others join them by their ranks, those of one rank in their
    order, each if it leaves the text short enough. If rank 0 alone is too long, the longest
    paragraph is cut line by line.

    Args:
        sections: Sections; one without clauses has no line.
        most_lines: Most lines, at least one for each clause of rank 0.
        width: Most characters of a line.
    """
    places = [
        (clause.rank, place, index)
        for place, section in enumerate(sections)
        for index, clause in enumerate(section.clauses)
    ]
    kept = {(place, index) for rank, place, index in places if rank == 0}
    for rank, place, index in sorted(places):
        if rank > 0:
            more = kept | {(place, index)}
            if _count(_laid_out(sections, more, width)) <= most_lines:
                kept = more
    head, body = _laid_out(sections, kept, width)
    while _count((head, body)) > most_lines:
        longest = max([*head, *body], key=len)
        if len(longest) < 2:
            break
        longest.pop()
        longest[-1] = longest[-1][: width - len(_CUT)].rstrip() + _CUT
    between = [[""]] if head and body else []
    return "\n".join(line for paragraph in [*head, *between, *body] for line in paragraph)


def _count(parts: tuple[list[list[str]], list[list[str]]]) -> int:
    """Count the lines of all paragraphs."""
    return sum(len(paragraph) for part in parts for paragraph in part)


def _laid_out(
    sections: Sequence[Section], kept: AbstractSet[tuple[int, int]], width: int
) -> tuple[list[list[str]], list[list[str]]]:
    """Return the paragraphs of the beginning and those with labels, each a list of lines.

    Args:
        sections: Sections.
        kept: Places of the clauses that stand in the text: section, clause.
        width: Most characters of a line.
    """
    head = []
    body = []
    later = " " * (LABEL_WIDTH + 3)
    for place, section in enumerate(sections):
        texts = [
            clause.text for index, clause in enumerate(section.clauses) if (place, index) in kept
        ]
        if texts and section.separator:
            texts = [section.separator.join(texts)]
        if not section.label:
            head += [wrap(text, "", width, "  ") for text in texts]
            continue
        label = section.label
        for text in texts:
            body.append(wrap(text, f"  {label:<{LABEL_WIDTH}} ", width, later))
            label = ""
    return head, body
