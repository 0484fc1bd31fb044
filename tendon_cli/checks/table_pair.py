"""Two tables of one kind, matched by the values of their axes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.checks.breaches import breaches_in, columns_that_judge
from tendon_cli.checks.compared import Value
from tendon_cli.cube.columns import ColumnArray
from tendon_cli.cube.cube import Cube
from tendon_cli.engine.table_columns import JUDGEMENTS
from tendon_cli.errors import UsageError
from tendon_cli.model.kinematics import Rows
from tendon_cli.quantities import (
    OF_CYCLES,
    OF_DESIGNS,
    OF_MOTION_STATES,
    OF_STATES,
    OF_TRAJECTORIES,
)
from tendon_cli.studies.space.axis import Axis
from tendon_cli.studies.study import Study

FLAGS = ("status", *JUDGEMENTS)
"""Columns of words, and of true or false, which are compared exactly."""
_RESULTS = {*OF_DESIGNS, *OF_CYCLES, *OF_TRAJECTORIES, *OF_STATES, *OF_MOTION_STATES, *FLAGS}
"""Columns that are computed; the others define the design or state of a row."""
_OWNERS = ("the first", "the second")


@dataclass(frozen=True)
class TablePair:
    """Two tables of one kind, and the rows that both have, in the same order from either side."""

    cubes: tuple[Cube, Cube]
    axes: tuple[Axis, ...]
    """Axes that both have, by their columns."""
    places: tuple[Mapping[str, Rows], Mapping[str, Rows]]
    """Common positions on each axis of either table, by its column."""
    left_out: Mapping[str, str]
    """Values and columns that only one of them has, in words, by key or name."""

    @classmethod
    def of(cls, first: Cube, second: Cube) -> TablePair:
        """Match two tables by the values of their axes.

        Raises:
            UsageError: if they have nothing in common.
        """
        ours, theirs = ({axis.key: axis for axis in cube.axes} for cube in (first, second))
        common: list[Axis] = []
        places: tuple[dict[str, Rows], dict[str, Rows]] = ({}, {})
        left_out: dict[str, str] = {}
        for key in sorted({*ours, *theirs}):
            axes = (ours.get(key), theirs.get(key))
            if axes[0] is not None and axes[1] is not None:
                common.append(axes[0])
                found = _common(axes[0], axes[1])
            else:
                # The other table has the axis's only value, if its study says it.
                found = (_single(axes[0], second.study), _single(axes[1], first.study))
            only = []
            for place, (axis, of_both) in enumerate(zip(axes, found, strict=True)):
                if axis is None:
                    continue
                places[place][axis.column] = of_both
                if len(axis) > len(of_both):
                    values = say.counted(len(axis) - len(of_both), "value")
                    only.append(f"{values} in {_OWNERS[place]} only")
            if only:
                left_out[key] = f"{key}: {', '.join(only)}"
        results = (_results(first), _results(second))
        for place, owner in enumerate(_OWNERS):
            for name in results[place]:
                if name not in results[1 - place]:
                    whole = f"{first.kind}.{name}"
                    left_out[whole] = f"{whole}: a column in {owner} only"
        return cls((first, second), tuple(common), places, left_out)

    @property
    def kind(self) -> str:
        """Name of the tables: designs, or states."""
        return self.cubes[0].kind

    @property
    def columns(self) -> list[str]:
        """Results that both tables have."""
        return [name for name in _results(self.cubes[0]) if name in _results(self.cubes[1])]

    @cached_property
    def rows(self) -> tuple[Rows, Rows]:
        """Numbers of the common rows in either table, one dimension for each common axis."""
        order = [axis.column for axis in self.axes]
        first, second = (
            cube.rows(order, of_cube) for cube, of_cube in zip(self.cubes, self.places, strict=True)
        )
        return first, second

    def both(self, name: str) -> tuple[ColumnArray, ColumnArray]:
        """Return a column of both tables, on the rows that both have."""
        first, second = (
            cube.gather(rows, [name])[name].ravel()
            for cube, rows in zip(self.cubes, self.rows, strict=True)
        )
        return first, second

    def where(self, row: int) -> dict[str, Value]:
        """Return the values of a common row on the axes."""
        values: dict[str, Value] = {}
        places = np.unravel_index(row, self.rows[0].shape)
        for axis, place in zip(self.axes, places, strict=True):
            value = axis.values[self.places[0][axis.column][place]]
            values[axis.column] = str(value) if axis.is_text else float(value)
        return values

    def broken(self, place: int, row: int) -> list[str]:
        """Return the limits that a common row breaks in the first table, 0, or the second, 1.

        Slack and no equilibrium count as limits.
        """
        cube = self.cubes[place]
        names = [name for name in columns_that_judge(cube) if name in cube.columns]
        rows = self.rows[place].ravel()[[row]]
        columns: dict[str, Any] = {"design": rows, **cube.gather(rows, names)}
        bounds = {limit: cube.bound(limit, columns) for limit in cube.limits}
        return [*dict.fromkeys(breach["limit"] for breach in breaches_in(columns, bounds))]


def _results(cube: Cube) -> list[str]:
    """Return the columns of a table that are computed."""
    names: list[str] = [] if cube.table is None else cube.table.schema.names
    return [name for name in names if name in _RESULTS]


def _common(first: Axis, second: Axis) -> tuple[Rows, Rows]:
    """Find the positions of the common values on two axes; of numbers in ascending order."""
    _, ours, theirs = np.intersect1d(_tokens(first), _tokens(second), return_indices=True)
    if not len(ours):
        raise UsageError(
            f"the runs have no value of {first.key} in common",
            hint="runs are compared by axis values",
        )
    order = np.argsort(ours if first.is_text else first.values[ours], kind="stable")
    return ours[order], theirs[order]


def _single(axis: Axis | None, other: Study) -> Rows:
    """Find the position on an axis of the single value that the other study has of it."""
    number = None if axis is None else other.numbers.get(axis.key)
    if axis is not None and number is not None and not (number.is_axis or number.is_interval):
        places = np.flatnonzero(_tokens(axis) == _token(number.single))
        if len(places):
            return places[:1].astype(np.int64)
    if axis is None or len(axis) == 1:
        return np.zeros(1, dtype=np.int64)
    raise UsageError(
        f"only one of the runs has the axis {axis.key}, "
        "and it does not contain the other run's value"
    )


def _tokens(axis: Axis) -> npt.NDArray[np.str_]:
    return np.array([_token(value) for value in axis.values])


def _token(value: Any) -> str:
    """Return the text by which values of two axes are matched, to 12 significant digits."""
    return value if isinstance(value, str) else f"{float(value):.12g}"
