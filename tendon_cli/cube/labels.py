"""Labels for axes, titles and legends of figures: names, symbols and units of columns."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.quantities import (
    AS_READ,
    QUANTITIES,
    SIDES,
    Quantity,
    in_unit_of_reading,
    unit_of_reading,
)
from tendon_cli.studies.axis_words import told_words
from tendon_cli.studies.contents import column_of, keys
from tendon_cli.studies.space.axis import Axis, NamedAxis
from tendon_cli.units import factor_of

INPUT = r"\mathit{I}"
"""The capital I of the input side, whose serifs tell it from a stroke."""
_LONGEST_NAME = 40
"""Most characters of a name that a title or a key shows."""
_SYMBOL = re.compile(r"([^_^]+)(?:_([^_^]+))?(?:\^([^_^]+))?")
_FORMULA = re.compile(r"(?<!\\)\$([^$]*)\$")


@dataclass(frozen=True)
class ColumnLabel:
    """A column as a figure shows it: its name, its symbol and its unit."""

    column: str
    quantity: Quantity
    unit: str
    factor: float
    """The unit in SI, by which SI values are divided."""

    @classmethod
    def of(
        cls, column: str, quantity: Quantity, units: Mapping[str, str] | None = None
    ) -> ColumnLabel:
        """Return the label of a column that holds a quantity.

        Args:
            column: Its name.
            quantity: Its quantity.
            units: Units by dimension that overrule the usual ones.
        """
        unit = (units or {}).get(quantity.dimension, quantity.shown_in)
        factor = 1.0 if quantity.has_own_unit else factor_of(unit)
        return cls(column, quantity, unit, factor)

    @property
    def name(self) -> str:
        """Name in words, with the side of a column that only one side has."""
        words = say.column(self.quantity.name)
        return f"{words}, {self.side}" if self.side else words

    @property
    def side(self) -> str:
        """Side of a column that only one side has; empty if the quantity's name says it."""
        for side in SIDES:
            if self.column.endswith(f"_{side}") and side not in self.quantity.name:
                return side
        return ""

    @property
    def symbol(self) -> str:
        """Symbol, ready to be drawn, as a formula or as text."""
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
        """Kind and unit, for the axis of a panel whose title has the name."""
        return f"{self._kind}{self._in_brackets}"

    @property
    def kind_shown(self) -> tuple[str, str]:
        """Kind and unit, both of which are the same for quantities that share an axis."""
        return self._kind, self.unit

    def scaled(self, values: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Return SI values in the unit shown."""
        with np.errstate(over="ignore"):  # an infinite value is drawn nowhere
            return np.asarray(values, dtype=np.float64) / self.factor

    def text(self, value: float) -> str:
        """Return an SI value with its unit: "5 kg"."""
        if np.isposinf(value) and self.quantity.dimension == "stiffness":
            return "rigid"
        unit = "" if self.unit == "1" else f" {plain(self.unit)}"
        return f"{number(value / self.factor)}{unit}"

    def equation(self, value: float) -> str:
        """Return an SI value with its symbol: "K = 3 kN/m", "max F ≤ 300 N"; a "5 kg load"."""
        if self.quantity.name == "load_mass":
            return f"{self.text(value)} load"
        side = f" ({self.side})" if self.side else ""
        is_bound = self.quantity.symbol.endswith(("≤", "≥"))
        sign = "" if is_bound else " ="
        return f"{self.symbol}{sign} {self.text(value)}{side}"

    @property
    def _kind(self) -> str:
        """Dimension, such as "force"; for a pure number its name, for all numbers are alike."""
        is_pure_number = self.quantity.dimension == "number"
        return self.name if is_pure_number else self.quantity.dimension

    @property
    def _in_brackets(self) -> str:
        """Unit in brackets after a space; empty if there is none."""
        return "" if self.unit == "1" else f" ({plain(self.unit)})"


def drawn_name(axis: Axis, name: str, units: Mapping[str, str] | None = None) -> str:
    """Return a name on an axis, ready to be drawn, and what it sets: "d88 (b₁ = 88 mm)".

    Args:
        axis: An axis whose values have names.
        name: The name.
        units: Units by dimension that overrule the usual ones.
    """

    def equation(key: str, value: float) -> str:
        return ColumnLabel.of(column_of(key), keys()[key].quantity, units).equation(value)

    told = told_words(axis, name, equation)
    is_number = isinstance(axis, NamedAxis) and name.isdigit()
    shown = f"{axis.column} {name}" if is_number else name
    text = plain(shown, width=_LONGEST_NAME, lines=1)
    return f"{text} ({told})" if told else text


def reading(document: Mapping[str, Any]) -> str:
    """Return words for what somebody sets in the study: a pretension or a tension.

    They are "pretension", or for example "tension in the flexor at the joint".
    """
    return "".join(say.setting_words(document.get("setting", {}).get("read", "pretension")))


def reading_unit(document: Mapping[str, Any]) -> str:
    """Return the unit of what somebody sets in the study: "N" or "N m"."""
    return unit_of_reading(document.get("setting", {}).get("read", "pretension"))


def as_read(quantity: Quantity, document: Mapping[str, Any]) -> Quantity:
    """Return a quantity of pretension renamed to what the study sets; any other as it is."""
    words = reading(document)
    if quantity.name not in AS_READ or words == "pretension":
        return quantity
    quantity = in_unit_of_reading(quantity, document["setting"]["read"])
    name = say.column(quantity.name).replace("pretension", words)
    symbol_set = quantity.symbol.replace("F₀*", "F_set^*").replace("F₀", "F_set")
    return replace(quantity, name=name, symbol=symbol_set)


def number(value: float) -> str:
    """Return a number as texts have it, with a minus sign and no hyphen."""
    return say.number(value).replace("-", "−")


def symbol(text: str) -> str:
    """Return a symbol such as F_o^f set as a formula, word by word."""
    return " ".join(_set(word) for word in text.split(" "))


def with_symbols(text: str, *, width: int | None = None, lines: int = 3) -> str:
    """Return a sentence of an answer ready to be drawn, its symbols such as R_f set as formulas.

    Args:
        text: The sentence, with symbols as a terminal shows them.
        width: Most characters in a line; None for a single line.
        lines: Most lines, after which the text is cut off.
    """
    drawn = plain(text, width=width, lines=lines)
    return _symbols_with_index().sub(lambda match: symbol(match[0]), drawn)


@cache
def _symbols_with_index() -> re.Pattern[str]:
    """Return a pattern of the symbols of all quantities that have an index, as whole words."""
    words = {word for quantity in QUANTITIES.values() for word in quantity.symbol.split(" ")}
    with_index = sorted(word for word in words if "_" in word or "^" in word)
    longest_first = sorted(with_index, key=len, reverse=True)
    return re.compile(rf"(?<!\w)({'|'.join(map(re.escape, longest_first))})(?![\w^])")


def without_formulas(text: str) -> str:
    """Return drawn text for a file's metadata, its formulas as plain symbols such as F_o^f."""
    unset = _FORMULA.sub(lambda match: match[1].replace("{", "").replace("}", ""), text)
    return unset.replace(r"\$", "$")


def _set(word: str) -> str:
    """Return one word of a symbol, set as a formula if it has an index."""
    match = _SYMBOL.fullmatch(word)
    if match is None or (match[2] is None and match[3] is None):
        return plain(word)
    # Subscripts are words of the field (I, o, elb).
    subscript = f"_{{{match[2].replace('I', INPUT)}}}" if match[2] else ""
    superscript = f"^{{{match[3]}}}" if match[3] else ""
    return f"${match[1]}{subscript}{superscript}$"


def plain(text: str, *, width: int | None = None, lines: int = 3) -> str:
    """Return a user's text so that matplotlib draws it literally.

    A dollar sign makes no formula, and a control character breaks no line.

    Args:
        text: The text.
        width: Most characters in a line; None for a single line.
        lines: Most lines, after which the text is cut off.
    """
    printable = "".join(sign if sign.isprintable() else " " for sign in text)
    clean = " ".join(printable.split())
    if width is not None:
        clean = "\n".join(
            textwrap.wrap(clean, width, max_lines=lines, placeholder=" …", break_long_words=True)
        )
    return clean.replace("$", r"\$")
