"""Filters on a table: columns found by their names, and the positions on each axis that are left."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence

import numpy as np

from tendon_cli.errors import UsageError
from tendon_cli.figures.axes import Ints, RowAxis
from tendon_cli.figures.product import Product
from tendon_cli.studies.filters import Condition, Filter
from tendon_cli.units import shorten

_MOST_LISTED = 12
_TRUTHS = ("taut", "stable", "feasible")
_SAID = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}


def find_column(product: Product, name: str, where: str) -> str:
    """A column by its name or by the dotted key of its axis; raises UsageError with the nearest name."""
    by_key = {axis.key: axis.column for axis in product.axes}
    if name in product.columns:
        return name
    if name in by_key:
        return by_key[name]
    near = difflib.get_close_matches(name, [*product.columns, *by_key], n=1, cutoff=0.5)
    hint = f'did you mean "{near[0]}"?' if near else f"columns: {', '.join(product.columns)}"
    raise UsageError(f'the table has no column "{shorten(name)}"', where=where, hint=hint)


def find_numbers(product: Product, name: str, where: str) -> str:
    """A column of numbers by its name; raises UsageError."""
    column = find_column(product, name, where)
    if product.columns[column] is None:
        raise UsageError(f"{column} holds words, expected a column of numbers", where=where)
    return column


def conditions(product: Product, filters: Iterable[Filter]) -> list[Condition]:
    """What filters ask of a table's columns; raises UsageError."""
    return [_condition(product, each) for each in filters]


def choose(product: Product, asked: Sequence[Condition]) -> dict[str, Ints]:
    """Positions on each axis that conditions leave; raises UsageError where nothing is left of one."""
    chosen = {axis.column: np.arange(axis.length, dtype=np.int64) for axis in product.axes}
    for condition in asked:
        axis = product.axis(condition.column)
        if axis is None:
            continue
        positions = chosen[axis.column]
        kept = positions[condition.holds(axis.values[positions], of_axis=True)]
        if not len(kept):
            hint = f"values: {', '.join(_listed(product, axis, positions))}"
            raise UsageError(f'nothing is left by "{shorten(condition.text)}"', where="--where", hint=hint)
        chosen[axis.column] = kept
    return chosen


def _condition(product: Product, asked: Filter) -> Condition:
    column = find_column(product, asked.name, "--where")
    if column in _TRUTHS:
        return _of_truth(asked, column)
    condition = asked.on(column, product.columns[column])
    axis = product.axis(column)
    if axis is not None and axis.is_text:
        known = [str(value) for value in axis.values]
        wrong = next((str(word) for word in condition.wanted if word not in known), None)
        if wrong is not None:
            hint = f"values: {', '.join(known[:20])}"
            raise UsageError(f'{column} is never "{shorten(wrong)}"', where="--where", hint=hint)
    return condition


def _of_truth(asked: Filter, column: str) -> Condition:
    wanted = [_SAID.get(value.lower()) for value in asked.values]
    if None in wanted or asked.relation not in ("=", "!=", "in"):
        problem = f'"{shorten(asked.text)}": {column} is true or false'
        raise UsageError(problem, where="--where", hint=f"{column} = true")
    return Condition(asked.text, column, asked.relation, tuple(float(each) for each in wanted if each is not None))


def _listed(product: Product, axis: RowAxis, positions: Ints) -> list[str]:
    """The values of an axis as one writes them in a filter, many of them shortened."""
    ends = positions if len(positions) <= _MOST_LISTED else positions[[0, 1, 2, -1]]
    values = axis.values[ends]
    texts = [str(each) if axis.is_text else product.shown(axis.column).text(each).replace("−", "-") for each in values]
    return texts if len(ends) == len(positions) else [*texts[:-1], "…", *texts[-1:]]
