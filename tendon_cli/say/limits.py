"""Limits in words: what it means that one is not kept, and why two leave no pretension."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tendon_cli.model.forms import LimitWords
from tendon_cli.model.limits import ALWAYS, LIMITS
from tendon_cli.say.words import quantity

_STABLE = LimitWords(
    "elbow unstable", "stability", "the elbow becomes unstable", "keeps the elbow stable", "makes the elbow unstable"
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
    return words[0].label if len(words) == 1 else f"{words[0].topic} and {words[1].topic} exclude each other"
