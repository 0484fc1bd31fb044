"""Choices by the numbers that they set: rows of the grid, or others that vary one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from tendon_cli.engine.windows.by_choice import ByChoice, ColumnArrays
from tendon_cli.model.kinematics import Array, Rows
from tendon_cli.studies.contents import column_of
from tendon_cli.studies.space.axis import PRETENSION, Numbers, split_side
from tendon_cli.studies.space.space import Space


@dataclass(frozen=True, eq=False)
class Points(ByChoice):
    """Choices by the numbers that they set, with their places in the grid of choices.

    A point with other or further numbers than its axes set keeps row and columns of the choice that
    it varies.
    """

    numbers: Numbers
    """Numbers that the choices set, (choices,) each, by dotted key, SI."""
    columns: ColumnArrays
    """Values of each axis, SI, or the positions of named values among their names; and what rows of
    tables set and carry."""
    row: Rows
    """Rows of the grid, which are those of `choices.parquet`; -1 for a choice that has no row."""

    def __len__(self) -> int:
        return len(self.row)

    @classmethod
    def of(cls, numbers: Numbers, count: int) -> Self:
        """Return `count` choices that set some numbers, without rows and columns."""
        return cls(numbers, {}, np.full(count, -1))

    @classmethod
    def of_rows(cls, choices: Space, rows: Rows) -> Self:
        """Return the choices in some rows of the grid."""
        numbers = choices.numbers(rows)
        columns = {**choices.columns(rows), **set_by_names(choices, choices.at(numbers))}
        return cls(numbers, columns, rows)

    def with_numbers(self, numbers: Numbers) -> Self:
        """Return the choices with other or further numbers, (choices,) each."""
        return replace(self, numbers={**self.numbers, **numbers})

    def at_pretension(self, pretension: Array) -> Self:
        """Return the choices at their pretensions, (choices,), N."""
        return self.with_numbers({PRETENSION: pretension})


def set_by_names(space: Space, rows: Space) -> ColumnArrays:
    """Return the columns of the numbers that vary over named axes, (rows,) each.

    Args:
        space: All choices, or all conditions.
        rows: The space itself, or a list of points of it.
    """
    columns: ColumnArrays = {}
    for key in space.set_by_names:
        values = rows.number(*split_side(key)).within(rows.whole)
        columns[column_of(key)] = np.broadcast_to(values, (*rows.shape, 1, 1)).ravel()
    return columns
