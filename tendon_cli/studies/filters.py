"""Filters such as "load_mass = 5 kg": one strict grammar, never evaluated, for files, the command line and Python."""

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

_FILTER = re.compile(r"\s*([A-Za-z_][\w.]*)\s*(<=|>=|!=|==|=|<|>|\bin\b)\s*(.+?)\s*")
_LONGEST = 500
_ORDER: dict[str, Callable[[Any, Any], Any]] = {"<": operator.lt, ">": operator.gt}
_AS_PRINTED = 1e-3
"""A value is met by what a figure prints of it, four digits; the nearest one counts."""
_ROUNDING = 1e-9
_TRUTHS = {"true": 1.0, "yes": 1.0, "1": 1.0, "false": 0.0, "no": 0.0, "0": 0.0}


@dataclass(frozen=True)
class Filter:
    """A filter as it is written: the name of a column, a relation, and one or more values."""

    text: str
    name: str
    relation: str
    """=, !=, <, <=, >, >= or in."""
    values: tuple[str, ...]

    def on(self, column: str, quantity: Quantity | None, *, is_truth: bool = False) -> Condition:
        """What it asks of a column of this quantity, of truths, or of words; raises UsageError for what cannot be."""
        if self.relation[0] in "<>" and (is_truth or quantity is None):
            raise UsageError(
                f"{column} holds words, which have no order", where="--where", hint="=, != or in"
            )
        wanted: list[Any] = [_unquoted(each) for each in self.values]
        if is_truth:
            wanted = [self._truth(column, each) for each in wanted]
        elif quantity is not None:
            wanted = [self._number(each, quantity) for each in self.values]
        return Condition(self.text, column, self.relation, tuple(wanted))

    def _truth(self, column: str, text: str) -> float:
        wanted = _TRUTHS.get(text.lower())
        if wanted is None:
            hint = f"{column} = yes, or {column} = no"
            raise UsageError(
                f'"{shorten(self.text)}": {column} is true or false', where="--where", hint=hint
            )
        return wanted

    def _number(self, text: str, quantity: Quantity) -> float:
        if quantity.dimension == "stiffness" and _unquoted(text) == "rigid":
            return math.inf
        try:
            return parse_measure(text, quantity.dimension).si
        except UnitError as error:
            example = f"such as {EXAMPLES.get(quantity.dimension, quantity.unit)}".replace('"', "")
            hint = error.hint if error.hint and "quotes" not in error.hint else example
            raise UsageError(
                f'"{shorten(self.text)}": {error.problem}', where="--where", hint=hint
            ) from None


@dataclass(frozen=True)
class Condition:
    """What a filter asks of the values of one column; numbers are in SI."""

    text: str
    column: str
    relation: str
    wanted: tuple[float, ...] | tuple[str, ...]

    def holds(self, values: npt.NDArray[Any], *, of_axis: bool = False) -> Truth:
        """Where it holds; never for null. On an axis "=" means the nearest value within the tolerance."""
        if self.relation in ("=", "in", "!="):
            met = np.zeros(values.shape, dtype=np.bool_)
            for wanted in self.wanted:
                met |= _equals(values, wanted, of_axis=of_axis)
            return ~met & _is_known(values) if self.relation == "!=" else met
        bound = float(self.wanted[0])
        near = _ROUNDING * max(abs(bound) if math.isfinite(bound) else 0.0, _largest(values))
        beyond = _ORDER[self.relation[0]](values, bound)
        close = np.abs(values - bound) <= near
        return np.asarray(beyond | close if self.relation.endswith("=") else beyond & ~close)


def read_filter(text: str) -> Filter:
    """Column, relation and values; raises UsageError.

    >>> read_filter("load_mass in 3 kg, 5 kg").values
    ('3 kg', '5 kg')
    """
    match = _FILTER.fullmatch(text) if len(text) <= _LONGEST else None
    if match is None:
        hint = 'such as "load_mass = 5 kg", "elbow_angle <= 60 deg" or "load_mass in 3 kg, 5 kg"'
        raise UsageError(f'"{shorten(text)}" is not a filter', where="--where", hint=hint)
    relation = "=" if match[2] == "==" else match[2]
    values = (
        [each.strip() for each in match[3].strip("[]").split(",")]
        if relation == "in"
        else [match[3]]
    )
    return Filter(text.strip(), match[1], relation, tuple(values))


def _unquoted(word: str) -> str:
    return word[1:-1] if len(word) > 1 and word[0] == word[-1] and word[0] in "\"'" else word


def _equals(values: npt.NDArray[Any], wanted: float | str, *, of_axis: bool) -> Truth:
    if isinstance(wanted, str):
        return np.asarray(values == wanted, dtype=np.bool_)
    if math.isinf(wanted):
        return np.asarray(values == wanted, dtype=np.bool_)
    distance = np.abs(values - wanted)
    close = distance <= _AS_PRINTED * abs(wanted) + _ROUNDING * _largest(values)
    return np.asarray(
        close & (distance == np.nanmin(distance)) if of_axis and close.any() else close
    )


def _largest(values: npt.NDArray[Any]) -> float:
    finite = values[np.isfinite(values)]
    return float(np.abs(finite).max()) if len(finite) else 0.0


def _is_known(values: npt.NDArray[Any]) -> Truth:
    return np.asarray(values != "" if values.dtype == object else ~np.isnan(values), dtype=np.bool_)
