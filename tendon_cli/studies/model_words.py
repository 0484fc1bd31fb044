"""Words of a study that are numbers to the model, such as the place of a spring."""

from __future__ import annotations

from tendon_cli.quantities import SIDES
from tendon_cli.studies.space.axis import AFTER, REFERENCE, SLACK, SPRING_AT, of_side, split_side

WORDS_OF = {
    REFERENCE: ("published", "initial"),
    SLACK: ("bilateral", "unilateral"),
    SPRING_AT: ("joint", "motor"),
    AFTER: ("extension", "flexion"),
}
"""Common keys whose words are numbers to the model, each with its words for 0 and for 1."""
KEYS_OF_WORDS = (*WORDS_OF, *(of_side(SPRING_AT, side) for side in SIDES))
"""Keys of these words, those of one side included."""


def numbers_of_words(study: object) -> dict[str, float]:
    """Return the single words that a study gives, as the numbers that they are to the model."""
    words = {}
    for key in KEYS_OF_WORDS:
        word = study
        for name in key.split("."):
            word = getattr(word, name, None)
        if isinstance(word, str):
            words[key] = number_of_word(key, word)
    return words


def number_of_word(key: str, word: str) -> float:
    """Return the number that a word is to the model: 0 or 1."""
    return float(WORDS_OF[split_side(key)[0]].index(word))
