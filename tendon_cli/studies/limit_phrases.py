"""Phrases for limits, for two that leave no pretension, and for the proof of a window."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from tendon_cli.model.forms import LimitWords
from tendon_cli.model.limits import ALWAYS, LIMITS
from tendon_cli.quantities import QUANTITIES, in_unit_of_reading
from tendon_cli.say.words import number, quantity

if TYPE_CHECKING:
    from tendon_cli.verbs.answer_record import BetweenSamples

LimitValues = Mapping[str, float | None]
"""Limits by name, SI; None for one that differs between designs."""

_STABLE = LimitWords(
    "elbow unstable",
    "stability",
    "the elbow becomes unstable",
)


def limit_words(limit: str, bounds: LimitValues, read: str = "pretension") -> LimitWords:
    """Return the phrases for a limit, with its bound in them.

    Args:
        limit: Name of the limit; `min_elbow_stiffness` means stability if its bound is 0 or absent.
        bounds: Limits of the study by name, SI.
        read: Gauge by which a pretension is read.
    """
    if limit == "min_elbow_stiffness" and bounds.get(limit, 0.0) == 0.0:
        return _STABLE
    words = ALWAYS[limit] if limit in ALWAYS else LIMITS[limit].words
    bound = "its limit"
    value = bounds.get(limit)
    if value is not None:
        bound = quantity(in_unit_of_reading(QUANTITIES[limit], read), value)
    return LimitWords(**{name: text.format(bound) for name, text in vars(words).items()})


def limit_on(limit: str) -> str:
    """Return the name of a limit in a sentence: "limit on tension"."""
    return f"limit on {LIMITS[limit].words.topic}"


def limit_of_so_much(limit: str, bound: float, read: str = "pretension") -> str:
    """Say a limit with its bound as a noun: "a limit of 400 N on tension"."""
    value = quantity(in_unit_of_reading(QUANTITIES[limit], read), bound)
    return f"a limit of {value} on {LIMITS[limit].words.topic}"


def conflict_label(limits: Sequence[str], bounds: LimitValues) -> str:
    """Explain a conflict in few words for a legend: "slack and stability conflict"."""
    words = [limit_words(limit, bounds) for limit in limits]
    if len(words) == 1:
        return words[0].label
    return f"{words[0].topic} and {words[1].topic} conflict"


# --- Proof ---------------------------------------------------------------------------------------

SAMPLED = "sampled"
PROVEN = "proven"
OPEN = "open"
STATUSES = (SAMPLED, PROVEN, OPEN)
"""Status of a window between the samples of the study, as in tables and records."""
_PROVED = {SAMPLED: "sampled", PROVEN: "proved", OPEN: "not proved"}


def proved_word(status: str) -> str:
    """Return the word for a status in a sentence: "proved" for PROVEN."""
    return _PROVED[status]


def proof_sentence(between: BetweenSamples) -> str:
    """Say what holds between the samples of a window: "Proved for every angle".

    `between` is `between_samples` in the record of an answer.
    """
    status = between.status
    error = between.estimate
    text = f"{proved_word(status).capitalize()} for {between.scope}"
    if status == OPEN:
        text += f": {between.cells:,} cells were not enough"
        if error is not None:
            text += f"; an end is off by at most {number(error, 2)} N"
    elif status == SAMPLED and error is not None:
        text += f": between the samples an end may be off by {number(error, 2)} N"
    return f"{text}."
