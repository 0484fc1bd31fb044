"""Numbers that an answer takes as exact, in words."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tendon_cli import say
from tendon_cli.answer_record import ExactRecord, QuestionRecord
from tendon_cli.studies.study import keys

_MOST_NAMED = 5
"""Most numbers that are named."""
_MOST_MOVES = 2
"""Most numbers of which the effect is said."""
_LEAST_MOVE = 0.05
"""Change of an end below which it is not said, N."""


def exact_words(question: QuestionRecord, records: Sequence[ExactRecord]) -> str:
    """Say which numbers are taken as exact, and how far usual errors of them move the window.

    "Taken as exact: b₁, K, a₁, R_elb, μ and 6 others. An error of 5 mm in b₁ moves the upper end
    by 37 N", and the sum of squares over all of them. Empty if none moves it.

    Args:
        question: The question.
        records: Numbers, the one that moves an end most first.
    """
    named = _that_matter(records)
    if not named:
        return ""
    moves = []
    for record in named[:_MOST_MOVES]:
        end, move = _largest(record)
        error = f"{record['deviation_words']} in {_symbol(record['key'])}"
        moves.append(f"{error} moves the {end} end by {say.number(move, 2)} {question['unit']}")
    words = f"Taken as exact: {_symbols(named)}. An error of {', one of '.join(moves)}"
    if len(named) > 1:
        words += f"; usual errors of all of them together move {_together(question, named)}"
    return (
        f"{words}. These errors are standard deviations; to draw them, state the numbers with +/-."
    )


def exact_short(question: QuestionRecord, records: Sequence[ExactRecord]) -> str:
    """Say which numbers are taken as exact, and how far their errors move the window together.

    "b₁, K and 6 others are taken as exact: their usual errors together move the lower end by 16 N".
    Empty if none does.
    """
    named = _that_matter(records)
    if not named:
        return ""
    moved = _together(question, named)
    if len(named) == 1:
        return f"{_symbols(named)} is taken as exact: its usual error moves {moved}"
    return f"{_symbols(named)} are taken as exact: their usual errors together move {moved}"


def _that_matter(records: Sequence[ExactRecord]) -> list[ExactRecord]:
    """Select the numbers whose usual error moves an end so far that it is said."""
    return [record for record in records if _largest(record)[1] >= _LEAST_MOVE]


def _symbols(named: Sequence[ExactRecord]) -> str:
    """List the first few numbers by their symbols, and count the others."""
    symbols = [_symbol(record["key"]) for record in named[:_MOST_NAMED]]
    if len(named) > _MOST_NAMED:
        symbols.append(say.counted(len(named) - _MOST_NAMED, "other"))
    return say.join_words(symbols)


def _together(question: QuestionRecord, named: Sequence[ExactRecord]) -> str:
    """Say how far all errors together move each end: the root of the sum of squares."""
    ends = []
    for end, changes in (
        ("lower", [record["moves_from"] for record in named]),
        ("upper", [record["moves_to"] for record in named]),
    ):
        together = math.hypot(*(change for change in changes if change is not None))
        if together >= _LEAST_MOVE:
            ends.append(f"the {end} end by {say.number(together, 2)} {question['unit']}")
    return say.join_words(ends)


def _symbol(key: str) -> str:
    """Return the symbol of a number, with its side if it is one side's."""
    symbol = keys()[key].quantity.symbol
    side = say.side_of(key)
    return f"{symbol} of the {side}" if side else symbol


def _largest(record: ExactRecord) -> tuple[str, float]:
    """Return the end of the window that a number moves more, and by how much, N."""
    lower = abs(record["moves_from"] or 0.0)
    upper = abs(record["moves_to"] or 0.0)
    return ("lower", lower) if lower > upper else ("upper", upper)
