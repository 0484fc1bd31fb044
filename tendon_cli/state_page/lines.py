"""Lines of a page that works something out for a check by hand, and how they are printed."""

from __future__ import annotations

import unicodedata
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True)
class PageLine:
    """A line of the page: a symbol, how it comes about, its values (one, or flexor and extensor), unit and source."""

    symbol: str
    formula: str
    values: tuple[float, ...]
    unit: str
    source: str = ""

    @property
    def text(self) -> str:
        """The line in a terminal."""
        values = "  ".join(f"{value:>13.7g}" if not np.isnan(value) else f"{'-':>13}" for value in self.values)
        symbol, formula = (_padded(text, width) for text, width in ((self.symbol, 9), (self.formula, 42)))
        return f"  {symbol}{formula}{values:<29}{self.unit:<9}{self.source}".rstrip()


@dataclass(frozen=True)
class PageSection:
    """Lines under a heading."""

    title: str
    lines: tuple[PageLine, ...]


def _padded(text: str, width: int) -> str:
    """Dots above letters take no room of their own."""
    return text.ljust(width + sum(1 for sign in text if unicodedata.combining(sign)))


def one(values: npt.ArrayLike) -> float:
    """The first of some values."""
    return float(np.asarray(values).reshape(-1)[0])


def null_if_nan(value: float) -> float | None:
    """As JSON has it."""
    return None if np.isnan(value) else value
