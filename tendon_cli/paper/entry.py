"""A line of the ledger, and how its numbers are written."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Entry:
    """A finding of the paper, or a slip of it, with the verdict and what it rests on."""

    id: str
    finding: str
    holds: bool
    """Of a finding: whether the tables show it. Of a slip: whether the evidence shows that the letter fails."""
    value: str
    """The numbers behind the verdict, with units."""
    figure: str | None
    """Name of the file that shows it."""


@dataclass(frozen=True)
class Verdict:
    """What a check found."""

    holds: bool
    value: str


def number(value: float, digits: int = 1) -> str:
    """A number with a proper minus sign; a dash where there is none."""
    if math.isnan(value):
        return "–"
    text = f"{value:.{digits}f}"
    return (text.lstrip("-") if float(text) == 0.0 else text).replace("-", "−")


def listed(values: Iterable[float], digits: int = 1) -> str:
    """Numbers, separated by commas."""
    return ", ".join(number(value, digits) for value in values)
