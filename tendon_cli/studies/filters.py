"""Filters such as "load_mass = 5 kg", of one strict grammar, for files, command line and Python.

A filter is never evaluated as code. Whether a row meets one follows from the row and from the axes
of its study, never from the other rows that are read. Commands, figures and Python compare with
`Condition`, and the page of a result by the same rule in `reports/page/table.js`:

- A number typed for an axis means the value of the axis that a study would read from this text, to
  nine digits, or else the only value of the axis that rounds to it, in four digits or in as many as
  are typed: 33.33 N is 33.333... N. Every other number stands for itself. Comparisons are exact.
- A result is compared in single precision, in the unit in which people read it.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import UsageError
from tendon_cli.quantities import Quantity
from tendon_cli.studies.fields import BARE_NUMBER, hint_to_write
from tendon_cli.units import EXAMPLES, UnitError, factor_of, parse_measure, shorten, usual_units

Truth = npt.NDArray[np.bool_]
"""Array of truth values."""

_FILTER = re.compile(r"\s*([A-Za-z_][\w.]*)\s*(<=|>=|!=|==|=|<|>|\bin\b)\s*(.+?)\s*")
_LISTED = re.compile(r"""\s*("[^"]*"|'[^']*'|[^,]*?)\s*(?:,|$)""")
"""Pattern of one value of a list, which has commas within quotes alone."""
_LONGEST = 500
"""Length of the longest filter, characters."""
_RELATIONS: dict[str, Callable[[Any, Any], Any]] = {
    "=": operator.eq,
    "in": operator.eq,
    "!=": operator.eq,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
"""Comparison of each relation with one value; "!=" holds where it does not."""
_PRINTED_DIGITS = 4
"""Fewest significant digits to which a value is rounded to be recognised: those of figures."""
_ROUNDING = 1e-9
"""Relative difference of a value of an axis and of a text that states it."""
_TRUTHS = {"true": 1.0, "yes": 1.0, "1": 1.0, "false": 0.0, "no": 0.0, "0": 0.0}


@dataclass(frozen=True)
class Filter:
    """Filter as it is written: the name of a column, a relation, and one or more values."""

    text: str
    """The whole filter."""
    name: str
    """Column, or key of its number."""
    relation: str
    """=, !=, <, <=, >, >= or in."""
    values: tuple[str, ...]
    """Values with their units, as they are written."""

    def condition_on(
        self,
        column: str,
        quantity: Quantity | None,
        axis_values: npt.NDArray[Any] | None = None,
        *,
        is_truth: bool = False,
    ) -> Condition:
        """Return the condition of the filter on a column.

        Args:
            column: Name of the column.
            quantity: Quantity of the column; None for one of words.
            axis_values: Values that the axes of the study give the column, in SI or as words; None
                if it is a result.
            is_truth: True for a column of truth values.

        Raises:
            UsageError: The column cannot have such values, or has no order.
        """
        if self.relation[0] in "<>" and (is_truth or quantity is None):
            problem = f"{column} holds words, which have no order"
            raise UsageError(problem, where="--where", hint="=, != or in")
        if is_truth:
            truths = tuple(self._truth(column, _unquoted(value)) for value in self.values)
            return Condition(self.text, column, self.relation, truths)
        if quantity is None:
            words = tuple(_unquoted(value) for value in self.values)
            if axis_values is not None:
                _check_words(column, words, axis_values)
            return Condition(self.text, column, self.relation, words)
        if axis_values is None:
            numbers = tuple(self._number(value, quantity)[0] for value in self.values)
            unit = 1.0 if quantity.has_own_unit else factor_of(quantity.shown_in)
            return Condition(self.text, column, self.relation, numbers, unit)
        meant = tuple(
            _value_meant(*self._number(value, quantity), axis_values) for value in self.values
        )
        return Condition(self.text, column, self.relation, meant)

    def _truth(self, column: str, text: str) -> float:
        """Return the number of a truth value, 0 or 1."""
        wanted = _TRUTHS.get(text.lower())
        if wanted is None:
            problem = f'"{shorten(self.text)}": {column} is true or false'
            hint = f"{column} = yes, or {column} = no"
            raise UsageError(problem, where="--where", hint=hint)
        return wanted

    def _number(self, text: str, quantity: Quantity) -> tuple[float, float]:
        """Return a number of the filter, and by how much a value that rounds to it differs, SI."""
        if quantity.dimension == "stiffness" and _unquoted(text) == "rigid":
            return math.inf, 0.0
        if quantity.has_own_unit:
            text = text.removesuffix(quantity.unit).rstrip()
        try:
            measure = parse_measure(text, quantity.dimension)
        except UnitError as error:
            if quantity.has_own_unit:
                problem = f'"{shorten(self.text)}": expected a number in {quantity.unit}'
                unit_hint = f"such as 100 {quantity.unit}, or the number alone"
                raise UsageError(problem, where="--where", hint=unit_hint) from None
            problem = f'"{shorten(self.text)}": {error.problem}'
            hint = error.hint
            if BARE_NUMBER.fullmatch(text):
                is_angle = quantity.dimension in ("angle", "angular speed")
                units = usual_units(quantity.dimension) if is_angle else (quantity.shown_in,)
                hint = hint_to_write([f"{text} {symbol}" for symbol in units])
            if not hint or "quotes" in hint:  # a filter's values have no quotes
                example = EXAMPLES.get(quantity.dimension, quantity.unit)
                hint = f"such as {example}".replace('"', "")
            raise UsageError(problem, where="--where", hint=hint) from None
        return measure.si, _half_digit(measure.text) * float(measure.unit.factor)


@dataclass(frozen=True)
class Condition:
    """Condition of a filter on the values of one column."""

    text: str
    """The filter as it is written."""
    column: str
    """Name of the column."""
    relation: str
    """=, !=, <, <=, >, >= or in."""
    wanted: tuple[float, ...] | tuple[str, ...]
    """Values to compare with; numbers are in SI."""
    unit: float | None = None
    """Unit, SI, in which results are compared in single precision.

    None for values that are compared exactly: those of axes, words and truths.
    """

    def holds(self, values: npt.NDArray[Any]) -> Truth:
        """Return True where the condition holds; it never holds for null.

        Args:
            values: Values of the column, any shape; numbers in SI.
        """
        compare = _RELATIONS[self.relation]
        compared = self._compared(values)
        is_met = np.zeros(values.shape, dtype=np.bool_)
        for wanted in self._compared(np.array(self.wanted, dtype=values.dtype)):
            is_met |= np.asarray(compare(compared, wanted), dtype=np.bool_)
        if self.relation != "!=":
            return is_met
        is_null = values == "" if values.dtype == object else np.isnan(values)
        return np.asarray(~is_met & ~is_null, dtype=np.bool_)

    def _compared(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return values as they are compared."""
        if self.unit is None:
            return values
        with np.errstate(over="ignore", under="ignore"):
            return np.asarray(values / self.unit, dtype=np.float32)


def read_filter(text: str) -> Filter:
    """Return the column, the relation and the values of a filter.

    Raises:
        UsageError: The text is not a filter.

    >>> read_filter("load_mass in 3 kg, 5 kg").values
    ('3 kg', '5 kg')
    """
    match = _FILTER.fullmatch(text) if len(text) <= _LONGEST else None
    relation = ""
    values: list[str] = []
    if match is not None:
        relation = "=" if match[2] == "==" else match[2]
        values = [match[3]]
        if relation == "in":
            values = [value for value in _LISTED.findall(match[3].strip("[]")) if value]
    if match is None or not values:
        hint = 'such as "load_mass = 5 kg", "elbow_angle <= 60 deg" or "load_mass in 3 kg, 5 kg"'
        raise UsageError(f'"{shorten(text)}" is not a filter', where="--where", hint=hint)
    return Filter(text.strip(), match[1], relation, tuple(values))


def _unquoted(word: str) -> str:
    """Return a word without quotes around it."""
    is_quoted = len(word) > 1 and word[0] == word[-1] and word[0] in "\"'"
    return word[1:-1] if is_quoted else word


def _check_words(column: str, words: Sequence[str], axis_values: npt.NDArray[Any]) -> None:
    """Raise UsageError if a word is not on the axis of its column."""
    known = list(dict.fromkeys(str(value) for value in axis_values))
    for word in words:
        if word not in known:
            hint = f"values: {', '.join(known[:20])}"
            raise UsageError(f'{column} is never "{shorten(word)}"', where="--where", hint=hint)


def _half_digit(number: str) -> float:
    """Return half of the last significant digit of a number as it is written, 0.005 of "33.33".

    It is that of the fourth digit if fewer are written, and 0 of zero.
    """
    _, digits, exponent = Decimal(number).as_tuple()
    if not any(digits) or not isinstance(exponent, int):
        return 0.0
    leading = exponent + len(digits)
    last = min(exponent, leading - _PRINTED_DIGITS)
    return float(Fraction(1, 2) * Fraction(10) ** last)


def _value_meant(number: float, rounding: float, axis_values: npt.NDArray[Any]) -> float:
    """Return the value of an axis that a number means, or the number if it means none.

    Args:
        number: Number of a filter.
        rounding: Largest difference of a value that rounds to the number as it is typed.
        axis_values: Values of the axis.
    """
    finite = axis_values[np.isfinite(axis_values)]
    if not (math.isfinite(number) and finite.size):
        return number
    distance = np.abs(finite - number)
    nearest = int(np.argmin(distance))
    if distance[nearest] <= _ROUNDING * abs(number):
        return float(finite[nearest])
    rounded = np.unique(finite[distance <= rounding])
    return float(rounded[0]) if len(rounded) == 1 else number
