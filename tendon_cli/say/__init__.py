"""Numbers, quantities, shares, limits and columns in words: once, for every text, figure and page."""

from tendon_cli.model.forms import LimitWords
from tendon_cli.say.blocks import Block, as_text, heading, items, sentence, table
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
    proof,
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
    "WIDTH", "Block", "LimitWords", "aligned", "as_text", "column", "conflict", "conflict_label", "counted", "duration",
    "factor_of", "filled", "heading", "interval", "items", "joint_word", "limit_words", "listed", "number", "of_joint",
    "parameter", "percent", "proof", "quantity", "reading", "sampled_share", "sentence", "share", "side_of", "size",
    "table", "window", "within",
]  # fmt: skip
