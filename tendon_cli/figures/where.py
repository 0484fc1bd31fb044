"""Filters such as "load_mass = 5 kg": read by a strict grammar, never evaluated."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import UsageError
from tendon_cli.figures.labels import Shown, shown
from tendon_cli.figures.product import Axis, Ints, Product
from tendon_cli.figures.request import find_column
from tendon_cli.units import EXAMPLES, UnitError, parse_measure, shorten

Truth = npt.NDArray[np.bool_]

_FILTER = re.compile(r"\s*([A-Za-z_][\w.]*)\s*(<=|>=|!=|==|=|<|>|\bin\b)\s*(.+?)\s*")
_ORDER: dict[str, Callable[[Any, Any], Any]] = {"<": operator.lt, ">": operator.gt}
_AS_PRINTED = 1e-3
"""A value is met by what a figure prints of it, four digits; the nearest one counts."""
_ROUNDING = 1e-9
_MOST_LISTED = 12


@dataclass(frozen=True)
class Filter:
    """A condition on one column; numbers are in SI."""

    text: str
    column: str
    relation: str
    wanted: tuple[float, ...] | tuple[str, ...]

    def holds(self, values: npt.NDArray[Any], *, of_axis: bool = False) -> Truth:
        """Where it holds; never for null. On an axis "=" means the nearest value within the tolerance."""
        if self.relation in ("=", "in", "!="):
            found = np.zeros(values.shape, dtype=np.bool_)
            for wanted in self.wanted:
                found |= self._equals(values, wanted, of_axis=of_axis)
            return ~found & _is_known(values) if self.relation == "!=" else found
        bound = float(self.wanted[0])
        near = _ROUNDING * max(abs(bound), _largest(values))
        beyond = _ORDER[self.relation[0]](values, bound)
        close = np.abs(values - bound) <= near
        return np.asarray(beyond | close if self.relation.endswith("=") else beyond & ~close)

    @staticmethod
    def _equals(values: npt.NDArray[Any], wanted: float | str, *, of_axis: bool) -> Truth:
        if isinstance(wanted, str):
            return np.asarray(values == wanted, dtype=np.bool_)
        distance = np.abs(values - wanted)
        close = distance <= _AS_PRINTED * abs(wanted) + _ROUNDING * _largest(values)
        return np.asarray(close & (distance == np.nanmin(distance)) if of_axis and close.any() else close)


def read_filter(text: str, product: Product) -> Filter:
    """Column, relation and values with units; raises UsageError."""
    match = _FILTER.fullmatch(text) if len(text) <= 500 else None
    if match is None:
        hint = 'such as "load_mass = 5 kg", "elbow_angle <= 60 deg" or "load_mass in 3 kg, 5 kg"'
        raise UsageError(f'"{shorten(text)}" is not a filter', where="--where", hint=hint)
    column = find_column(product, match[1], "--where")
    relation = "=" if match[2] == "==" else match[2]
    texts = [piece.strip() for piece in match[3].strip("[]").split(",")] if relation == "in" else [match[3]]
    axis = product.axis(column)
    if product.is_text(column):
        if relation[0] in "<>":
            raise UsageError(f"{column} holds words, which have no order", where="--where", hint="=, != or in")
        return Filter(text, column, relation, tuple(_word(piece, column, axis, product) for piece in texts))
    quantity = shown(product.table.schema, column)
    return Filter(text, column, relation, tuple(_number(piece, quantity, text) for piece in texts))


def choose(product: Product, filters: list[Filter]) -> dict[str, Ints]:
    """Positions on each axis that the filters leave; raises UsageError where nothing is left of one."""
    chosen = product.positions()
    for found in filters:
        axis = product.axis(found.column)
        if axis is None:
            continue
        positions = chosen[axis.column]
        kept = positions[found.holds(product.values(axis, positions), of_axis=True)]
        if not len(kept):
            values = ", ".join(listed(product, axis, positions))
            raise UsageError(f'nothing is left by "{shorten(found.text)}"', where="--where", hint=f"values: {values}")
        chosen[axis.column] = kept
    return chosen


def listed(product: Product, axis: Axis, positions: Ints) -> list[str]:
    """The values of an axis as one writes them in a filter, many of them shortened."""
    ends = positions if len(positions) <= _MOST_LISTED else positions[[0, 1, 2, -1]]
    values = product.values(axis, ends)
    known = [value for value in values if value == value and value != ""]  # noqa: PLR0124 - NaN differs from itself
    quantity = None if axis.is_text else shown(product.table.schema, axis.column)
    texts = [str(value) if quantity is None else quantity.text(value).replace("−", "-") for value in known]
    return texts if len(ends) == len(positions) else [*texts[:-1], "…", *texts[-1:]]


def _word(text: str, column: str, axis: Axis | None, product: Product) -> str:
    word = text[1:-1] if len(text) > 1 and text[0] == text[-1] and text[0] in "\"'" else text
    known = [str(value) for value in product.values(axis)] if axis else []
    if known and word not in known:
        raise UsageError(
            f'{column} is never "{shorten(word)}"', where="--where", hint=f"values: {', '.join(known[:20])}"
        )
    return word


def _number(text: str, quantity: Shown, whole: str) -> float:
    try:
        return parse_measure(text, quantity.quantity.dimension).si
    except UnitError as error:
        example = f"such as {EXAMPLES[quantity.quantity.dimension]}".replace('"', "")
        hint = error.hint if error.hint and "quotes" not in error.hint else example
        raise UsageError(f'"{shorten(whole)}": {error.problem}', where="--where", hint=hint) from None


def _largest(values: npt.NDArray[Any]) -> float:
    finite = values[np.isfinite(values)]
    return float(np.abs(finite).max()) if len(finite) else 0.0


def _is_known(values: npt.NDArray[Any]) -> Truth:
    return np.asarray(values != "" if values.dtype == object else np.isfinite(values), dtype=np.bool_)
