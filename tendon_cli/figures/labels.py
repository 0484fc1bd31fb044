"""What the axes, titles and legends of figures say: columns named, with symbol and unit as people read them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from tendon_cli.figures.style import plain
from tendon_cli.quantities import QUANTITIES, Quantity
from tendon_cli.units import UNITS

_BY_MEANING = {quantity.long_name: quantity for quantity in QUANTITIES.values()}
_SYMBOL = re.compile(r"([^_^]+)(?:_([^_^]+))?(?:\^([^_^]+))?")
_WORDS = {"_proximal": " at the motor", "_distal": " at the elbow", "_": " "}
_ANCHORS = ("a1", "b1", "a2", "b2")


@dataclass(frozen=True)
class Shown:
    """A column as a figure shows it: its name and symbol, and the unit that its SI values are divided into."""

    column: str
    quantity: Quantity
    unit: str
    factor: float

    @property
    def name(self) -> str:
        """In words, the side included."""
        name = self.quantity.name
        words = f"anchor distance {name}" if name in _ANCHORS else name
        for mark, word in _WORDS.items():
            words = words.replace(mark, word)
        side = next((f", {side}" for side in ("flexor", "extensor") if self._is_of(side)), "")
        return f"{words}{side}"

    @property
    def symbol(self) -> str:
        """The symbol, ready to be drawn; its word where it has none, in either text or formula."""
        return symbol(self.quantity.symbol)

    @property
    def titled(self) -> str:
        """Name and symbol, for a title."""
        if self.quantity.name in _ANCHORS:
            return f"anchor distance {self.symbol}"
        # A symbol such as "max F" says nothing that the name does not.
        says_more = " − " in self.symbol or (" " not in self.symbol and self.symbol not in self.name)
        return f"{self.name} {self.symbol}" if says_more else self.name

    @property
    def label(self) -> str:
        """Name, symbol and unit, for an axis."""
        return f"{self.titled}{self._in_brackets}"

    @property
    def short_label(self) -> str:
        """Dimension and unit, for the axis of a panel whose title has the name."""
        return f"{self.quantity.dimension}{self._in_brackets}"

    @property
    def dimension_shown(self) -> tuple[str, str]:
        """What must be equal for two quantities to share an axis."""
        return self.quantity.dimension, self.unit

    def scaled(self, values: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """SI values in the unit shown."""
        with np.errstate(over="ignore"):  # what is too large in the unit shown is drawn nowhere
            return np.asarray(values, dtype=np.float64) / self.factor

    def text(self, value: float) -> str:
        """One SI value with its unit: "5 kg"."""
        unit = "" if self.unit == "1" else f" {plain(self.unit)}"
        return f"{number(value / self.factor)}{unit}"

    def equation(self, value: float) -> str:
        """One SI value with its symbol: "K = 3 kN/m"."""
        return f"{self.symbol} = {self.text(value)}"

    @property
    def _in_brackets(self) -> str:
        return "" if self.unit == "1" else f" ({plain(self.unit)})"

    def _is_of(self, side: str) -> bool:
        return self.column.endswith(f"_{side}") and side not in self.quantity.name


def shown(schema: pa.Schema, column: str, units: Mapping[str, str] | None = None) -> Shown:
    """How a column of numbers is shown; `units` overrules the usual unit of a dimension."""
    metadata = schema.field(column).metadata or {}
    meaning = metadata.get(b"long_name", b"").decode()
    unit = metadata.get(b"unit", b"1").decode()
    quantity = _BY_MEANING.get(meaning) or Quantity(column, column.replace("_", " "), "number", unit, unit, meaning)
    chosen = (units or {}).get(quantity.dimension, quantity.shown_in)
    known = UNITS.get(chosen)
    return Shown(column, quantity, chosen, float(known.factor) if known else 1.0)


def number(value: float) -> str:
    """A number as people write it: four digits at most, no exponent where it is avoidable."""
    rounded = float(f"{value:.4g}")
    text = f"{rounded:.10f}".rstrip("0").rstrip(".") if 1e-4 <= abs(rounded) < 1e6 else f"{rounded:g}"
    return text.replace("-", "−")


def symbol(text: str) -> str:
    """A symbol such as F_o^f set as a formula, word by word."""
    return " ".join(_set(word) for word in text.split(" "))


def _set(word: str) -> str:
    match = _SYMBOL.fullmatch(word)
    if match is None or (match[2] is None and match[3] is None):
        return plain(word)
    low = f"_{{{match[2]}}}" if match[2] else ""
    high = f"^{{{match[3]}}}" if match[3] else ""
    return f"${match[1]}{low}{high}$"
