"""Numbers that an answer takes as exact, in words."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tendon_cli import say
from tendon_cli.answer_record import ChoiceRecord, ExactRecord, QuestionRecord
from tendon_cli.studies.study import keys

_MOST_NAMED = 5
"""Most numbers that are named."""
_MOST_NAMED_IN_SHORT = 3
"""Most numbers that are named where there is little room."""
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
        error = f"{record.deviation_words} in {_symbol(record.key)}"
        moves.append(f"{error} moves the {end} end by {say.number(move, 2)} {question.unit}")
    words = f"Taken as exact: {_symbols(named)}. An error of {', one of '.join(moves)}"
    if len(named) > 1:
        words += f"; usual errors of all of them together move {_together(question, named)}"
    return (
        f"{words}. These errors are standard deviations; to draw them, state the numbers with +/-."
    )


def exact_short(
    question: QuestionRecord, records: Sequence[ExactRecord], best: ChoiceRecord
) -> str:
    """Say which numbers are taken as exact, and how far their errors move the window together.

    "b₁, K and 6 others are taken as exact: their usual errors together move the lower end by 16 N
    (the setting is 5.9 N above it)". Empty if none does.

    Args:
        question: The question.
        records: Numbers, the one that moves an end most first.
        best: The choice that is set.
    """
    named = _that_matter(records)
    if not named:
        return ""
    moved = _together(question, named, best)
    symbols = _symbols(named, _MOST_NAMED_IN_SHORT)
    if len(named) == 1:
        return f"{symbols} is taken as exact: its usual error moves {moved}"
    return f"{symbols} are taken as exact: their usual errors together move {moved}"


def errors_reach_setting(records: Sequence[ExactRecord], best: ChoiceRecord) -> bool:
    """Return True if the usual errors together move an end of the window as far as the setting."""
    moved = _moved_ends(_that_matter(records))
    return any(_distance(best, end) < together for end, together in moved.items())


def _that_matter(records: Sequence[ExactRecord]) -> list[ExactRecord]:
    """Select the numbers whose usual error moves an end so far that it is said."""
    return [record for record in records if _largest(record)[1] >= _LEAST_MOVE]


def _symbols(named: Sequence[ExactRecord], most: int = _MOST_NAMED) -> str:
    """List the first few numbers by their symbols, and count the others."""
    symbols = [_symbol(record.key) for record in named[:most]]
    if len(named) > most:
        symbols.append(say.counted(len(named) - most, "other"))
    return say.join_words(symbols)


def _together(
    question: QuestionRecord, named: Sequence[ExactRecord], best: ChoiceRecord | None = None
) -> str:
    """Say how far all errors together move each end: the root of the sum of squares.

    Args:
        question: The question.
        named: The numbers.
        best: The choice that is set, to say how near the setting is to an end that moves farther.
    """
    ends = []
    for end, together in _moved_ends(named).items():
        if together < _LEAST_MOVE:
            continue
        words = f"the {end} end by {say.number(together, 2)} {question.unit}"
        away = _distance(best, end)
        if away < together:
            side = "above" if end == "lower" else "below"
            words += f" (the setting is {say.number(away, 2)} {question.unit} {side} it)"
        ends.append(words)
    return say.join_words(ends)


def _moved_ends(named: Sequence[ExactRecord]) -> dict[str, float]:
    """Return how far all errors together move each end of the window, N."""
    changes = {
        "lower": [record.moves_from for record in named],
        "upper": [record.moves_to for record in named],
    }
    return {
        end: math.hypot(*(change for change in of_end if change is not None))
        for end, of_end in changes.items()
    }


def _distance(best: ChoiceRecord | None, end: str) -> float:
    """Return how far a setting lies within an end of its window, N; infinite if not known."""
    if best is None or best.pretension is None:
        return math.inf
    limit = best.pretension_from if end == "lower" else best.pretension_to
    if limit is None:
        return math.inf
    return abs(best.pretension - limit)


def _symbol(key: str) -> str:
    """Return the symbol of a number, with its side if it is one side's."""
    symbol = keys()[key].quantity.symbol
    side = say.side_of(key)
    return f"{symbol} of the {side}" if side else symbol


def _largest(record: ExactRecord) -> tuple[str, float]:
    """Return the end of the window that a number moves more, and by how much, N."""
    lower = abs(record.moves_from or 0.0)
    upper = abs(record.moves_to or 0.0)
    return ("lower", lower) if lower > upper else ("upper", upper)
