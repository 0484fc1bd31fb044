"""Filters such as "load_mass = 5 kg", of one strict grammar, for files, command line and Python.

A filter is never evaluated as code.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import UsageError
from tendon_cli.quantities import Quantity
from tendon_cli.units import EXAMPLES, UnitError, parse_measure, shorten

Truth = npt.NDArray[np.bool_]
"""Array of truth values."""

_FILTER = re.compile(r"\s*([A-Za-z_][\w.]*)\s*(<=|>=|!=|==|=|<|>|\bin\b)\s*(.+?)\s*")
_LONGEST = 500
"""Length of the longest filter, characters."""
_ORDER: dict[str, Callable[[Any, Any], Any]] = {"<": operator.lt, ">": operator.gt}
_AS_PRINTED = 1e-3
"""Relative tolerance of "=", so that a value with the four digits that a figure prints is found."""
_ROUNDING = 1e-9
"""Tolerance of rounding, relative to the largest value of a column."""
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
        self, column: str, quantity: Quantity | None, *, is_truth: bool = False
    ) -> Condition:
        """Return the condition of the filter on a column.

        Args:
            column: Name of the column.
            quantity: Quantity of the column; None for one of words.
            is_truth: True for a column of truth values.

        Raises:
            UsageError: The column cannot have such values, or has no order.
        """
        if self.relation[0] in "<>" and (is_truth or quantity is None):
            problem = f"{column} holds words, which have no order"
            raise UsageError(problem, where="--where", hint="=, != or in")
        wanted: list[Any]
        if is_truth:
            wanted = [self._truth(column, _unquoted(value)) for value in self.values]
        elif quantity is not None:
            wanted = [self._number(value, quantity) for value in self.values]
        else:
            wanted = [_unquoted(value) for value in self.values]
        return Condition(self.text, column, self.relation, tuple(wanted))

    def _truth(self, column: str, text: str) -> float:
        """Return the number of a truth value, 0 or 1."""
        wanted = _TRUTHS.get(text.lower())
        if wanted is None:
            problem = f'"{shorten(self.text)}": {column} is true or false'
            hint = f"{column} = yes, or {column} = no"
            raise UsageError(problem, where="--where", hint=hint)
        return wanted

    def _number(self, text: str, quantity: Quantity) -> float:
        """Return a number of the filter in SI."""
        if quantity.dimension == "stiffness" and _unquoted(text) == "rigid":
            return math.inf
        try:
            return parse_measure(text, quantity.dimension).si
        except UnitError as error:
            problem = f'"{shorten(self.text)}": {error.problem}'
            hint = error.hint
            if not hint or "quotes" in hint:  # a filter's values have no quotes
                example = EXAMPLES.get(quantity.dimension, quantity.unit)
                hint = f"such as {example}".replace('"', "")
            raise UsageError(problem, where="--where", hint=hint) from None


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

    def holds(self, values: npt.NDArray[Any], *, of_axis: bool = False) -> Truth:
        """Return True where the condition holds; it never holds for null.

        Args:
            values: Values of the column, any shape; numbers in SI.
            of_axis: True for the values of an axis: "=" then selects only the nearest of those
                within the tolerance.
        """
        if self.relation in ("=", "in", "!="):
            met = np.zeros(values.shape, dtype=np.bool_)
            for wanted in self.wanted:
                met |= _equals(values, wanted, of_axis=of_axis)
            return ~met & _is_known(values) if self.relation == "!=" else met
        bound = float(self.wanted[0])
        magnitude = abs(bound) if math.isfinite(bound) else 0.0
        tolerance = _ROUNDING * max(magnitude, _largest(values))
        is_beyond = _ORDER[self.relation[0]](values, bound)
        is_close = np.abs(values - bound) <= tolerance
        if self.relation.endswith("="):
            return np.asarray(is_beyond | is_close)
        return np.asarray(is_beyond & ~is_close)


def read_filter(text: str) -> Filter:
    """Return the column, the relation and the values of a filter.

    Raises:
        UsageError: The text is not a filter.

    >>> read_filter("load_mass in 3 kg, 5 kg").values
    ('3 kg', '5 kg')
    """
    match = _FILTER.fullmatch(text) if len(text) <= _LONGEST else None
    if match is None:
        hint = 'such as "load_mass = 5 kg", "elbow_angle <= 60 deg" or "load_mass in 3 kg, 5 kg"'
        raise UsageError(f'"{shorten(text)}" is not a filter', where="--where", hint=hint)
    relation = "=" if match[2] == "==" else match[2]
    values = [match[3]]
    if relation == "in":
        values = [value.strip() for value in match[3].strip("[]").split(",")]
    return Filter(text.strip(), match[1], relation, tuple(values))


def _unquoted(word: str) -> str:
    """Return a word without quotes around it."""
    is_quoted = len(word) > 1 and word[0] == word[-1] and word[0] in "\"'"
    return word[1:-1] if is_quoted else word


def _equals(values: npt.NDArray[Any], wanted: float | str, *, of_axis: bool) -> Truth:
    """Return True where a value is the wanted one, up to rounding and to printed digits."""
    if isinstance(wanted, str) or math.isinf(wanted):
        return np.asarray(values == wanted, dtype=np.bool_)
    distance = np.abs(values - wanted)
    is_close = distance <= _AS_PRINTED * abs(wanted) + _ROUNDING * _largest(values)
    if of_axis and is_close.any():
        return np.asarray(is_close & (distance == np.nanmin(distance)))
    return np.asarray(is_close)


def _largest(values: npt.NDArray[Any]) -> float:
    """Return the largest magnitude of finite values; 0 if there is none."""
    finite = values[np.isfinite(values)]
    return float(np.abs(finite).max()) if len(finite) else 0.0


def _is_known(values: npt.NDArray[Any]) -> Truth:
    """Return True where a value is not null."""
    known = values != "" if values.dtype == object else ~np.isnan(values)
    return np.asarray(known, dtype=np.bool_)
