"""Limits in words: what it means that one is not kept, why two leave no pretension, and what of it is proved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from tendon_cli.model.forms import LimitWords
from tendon_cli.model.limits import ALWAYS, LIMITS
from tendon_cli.say.words import number, quantity

_STABLE = LimitWords(
    "elbow unstable",
    "stability",
    "the elbow becomes unstable",
    "keeps the elbow stable",
    "makes the elbow unstable",
)


def limit_words(limit: str, bounds: Mapping[str, float]) -> LimitWords:
    """A limit in words; `bounds` has the limits of the study by name, SI. Without a bound stability is meant."""
    if limit == "min_elbow_stiffness" and bounds.get(limit, 0.0) == 0.0:
        return _STABLE
    words = ALWAYS[limit] if limit in ALWAYS else LIMITS[limit].words
    bound = quantity(limit, bounds[limit]) if limit in bounds else "its limit"
    return LimitWords(**{name: text.format(bound) for name, text in vars(words).items()})


def conflict(limits: Sequence[str], bounds: Mapping[str, float]) -> str:
    """Why no pretension is left, as a sentence: "the pretension that prevents slack already makes the elbow unstable".

    The first limit asks for more pretension, the second for less; one alone is broken at any pretension.
    """
    words = [limit_words(each, bounds) for each in limits]
    if len(words) == 1:
        return f"{words[0].broken} at any pretension"
    return f"the pretension that {words[0].keeps} already {words[1].breaks}"


def conflict_label(limits: Sequence[str], bounds: Mapping[str, float]) -> str:
    """The same in few words, for a legend or a table: "slack and stability exclude each other"."""
    words = [limit_words(each, bounds) for each in limits]
    return (
        words[0].label
        if len(words) == 1
        else f"{words[0].topic} and {words[1].topic} exclude each other"
    )


# --- Proof -----------------------------------------------------------------------------------------------------------

SAMPLED, PROVEN, OPEN = STATUSES = ("sampled", "proven", "open")
"""What is known of a window between the samples, as tables and records have it."""
_PROVED = {SAMPLED: "sampled", PROVEN: "proved", OPEN: "not proved"}


def proved(status: str) -> str:
    """The same in words."""
    return _PROVED[status]


def proof(between: Mapping[str, Any]) -> str:
    """What holds between the samples of a window, of the record of an answer: "Proved for every angle"."""
    status, off = between["status"], between["estimate"]
    text = f"{proved(status).capitalize()} for {between['scope']}"
    if status == OPEN:
        text += f": {between['cells']:,} cells were not enough"
    elif status == SAMPLED and off is not None:
        text += f": an end may be off by {number(off, 2)} N between them"
    return f"{text}."
