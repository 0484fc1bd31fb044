"""What the axes, titles and legends of figures say: columns named, with symbol and unit as people read them."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.quantities import AS_READ, Quantity
from tendon_cli.units import factor_of

_SYMBOL = re.compile(r"([^_^]+)(?:_([^_^]+))?(?:\^([^_^]+))?")
_FORMULA = re.compile(r"(?<!\\)\$([^$]*)\$")


@dataclass(frozen=True)
class Shown:
    """A column as a figure shows it: its name and symbol, and the unit that its SI values are divided into."""

    column: str
    quantity: Quantity
    unit: str
    factor: float

    @classmethod
    def of(cls, column: str, quantity: Quantity, units: Mapping[str, str] | None = None) -> Shown:
        """A column of a quantity; `units` overrules the usual unit of a dimension."""
        unit = (units or {}).get(quantity.dimension, quantity.shown_in)
        return cls(column, quantity, unit, factor_of(unit))

    @property
    def name(self) -> str:
        """In words, the side included."""
        words = say.column(self.quantity.name)
        return f"{words}, {self.side}" if self.side else words

    @property
    def side(self) -> str:
        """The side of a column that only one side has, where the quantity's name does not say it."""
        sides = ("flexor", "extensor")
        return next(
            (
                one
                for one in sides
                if self.column.endswith(f"_{one}") and one not in self.quantity.name
            ),
            "",
        )

    @property
    def symbol(self) -> str:
        """The symbol, ready to be drawn; its word where it has none, in either text or formula."""
        return symbol(self.quantity.symbol)

    @property
    def titled(self) -> str:
        """Name and symbol, for a title."""
        # A symbol such as "max F" says nothing that the name does not.
        text = self.quantity.symbol
        says_more = " − " in text or " / " in text or (" " not in text and text not in self.name)
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
        if np.isposinf(value) and self.quantity.dimension == "stiffness":
            return "rigid"
        unit = "" if self.unit == "1" else f" {plain(self.unit)}"
        return f"{number(value / self.factor)}{unit}"

    def equation(self, value: float) -> str:
        """One SI value with its symbol: "K = 3 kN/m", of a load "5 kg load"."""
        if self.quantity.name == "load_mass":
            return f"{self.text(value)} load"
        return f"{self.symbol} = {self.text(value)}{f' ({self.side})' if self.side else ''}"

    @property
    def _in_brackets(self) -> str:
        return "" if self.unit == "1" else f" ({plain(self.unit)})"


def reading(document: Mapping[str, Any]) -> str:
    """What is set, by the resolved study: "pretension", or "tension in the flexor at the joint"."""
    return "".join(say.reading(document.get("setting", {}).get("read", "pretension")))


def as_read(quantity: Quantity, document: Mapping[str, Any]) -> Quantity:
    """A quantity of pretension by what the resolved study reads in its place; any other as it is."""
    words = reading(document)
    if quantity.name not in AS_READ or words == "pretension":
        return quantity
    name = say.column(quantity.name).replace("pretension", words)
    return replace(
        quantity, name=name, symbol=quantity.symbol.replace("F₀*", "F_set^*").replace("F₀", "F_set")
    )


def number(value: float) -> str:
    """A number as texts have it, with a minus sign that is none of a keyboard."""
    return say.number(value).replace("-", "−")


def symbol(text: str) -> str:
    """A symbol such as F_o^f set as a formula, word by word."""
    return " ".join(_set(word) for word in text.split(" "))


def without_formulas(text: str) -> str:
    """Drawn text as it can stand in a file's metadata: formulas as they are written, F_o^f."""
    return _FORMULA.sub(lambda match: match[1].replace("{", "").replace("}", ""), text).replace(
        r"\$", "$"
    )


def _set(word: str) -> str:
    match = _SYMBOL.fullmatch(word)
    if match is None or (match[2] is None and match[3] is None):
        return plain(word)
    # Subscripts are words of the field (I, o, elb): the capital I needs its serifs to differ from a stroke.
    low = f"_{{{match[2].replace('I', INPUT)}}}" if match[2] else ""
    high = f"^{{{match[3]}}}" if match[3] else ""
    return f"${match[1]}{low}{high}$"


INPUT = r"\mathit{I}"


def plain(text: str, *, width: int | None = None, lines: int = 3) -> str:
    """Text of a user as it stands: no formula is made of a dollar sign, no line is broken by a control character."""
    clean = " ".join("".join(sign if sign.isprintable() else " " for sign in text).split())
    if width is not None:
        clean = "\n".join(
            textwrap.wrap(clean, width, max_lines=lines, placeholder=" …", break_long_words=True)
        )
    return clean.replace("$", r"\$")
