"""Numbers, quantities, shares, limits and columns in words: once, for every text, figure and page."""

from tendon_cli.model.forms import LimitWords
from tendon_cli.say.limits import conflict, conflict_label, limit_words
from tendon_cli.say.words import (
    WIDTH,
    aligned,
    column,
    duration,
    factor_of,
    filled,
    interval,
    joint_word,
    listed,
    number,
    of_joint,
    parameter,
    percent,
    quantity,
    sampled_share,
    share,
    side_of,
    size,
    window,
    within,
)  # fmt: skip
from tendon_cli.units import counted

__all__ = [
    "WIDTH", "LimitWords", "aligned", "column", "conflict", "conflict_label", "counted", "duration", "factor_of",
    "filled", "interval", "joint_word", "limit_words", "listed", "number", "of_joint", "parameter", "percent",
    "quantity", "sampled_share", "share", "side_of", "size", "window", "within",
]  # fmt: skip
