"""Numbers, quantities, shares, limits and columns in words: once, for every text, figure and page."""

from tendon_cli.model.forms import LimitWords
from tendon_cli.say.blocks import Block, as_text, heading, items, sentence, table
from tendon_cli.say.limits import (
    OPEN,
    PROVEN,
    SAMPLED,
    STATUSES,
    conflict,
    conflict_label,
    limit_words,
    proof,
    proved,
)  # fmt: skip
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
    reading,
    sampled_share,
    share,
    side_of,
    size,
    window,
    within,
)  # fmt: skip
from tendon_cli.units import counted

__all__ = [
    "OPEN", "PROVEN", "SAMPLED", "STATUSES", "WIDTH", "Block", "LimitWords", "aligned", "as_text", "column", "conflict",
    "conflict_label", "counted", "duration", "factor_of", "filled", "heading", "interval", "items", "joint_word",
    "limit_words", "listed", "number", "of_joint", "parameter", "percent", "proof", "proved", "quantity", "reading",
    "sampled_share", "sentence", "share", "side_of", "size", "table", "window", "within",
]  # fmt: skip
