"""Two tables of one kind, matched by the values of their axes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.checks.breaches import breaches_in, columns_that_judge
from tendon_cli.checks.comparison_record import Value
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
from tendon_cli.space.axis import Axis
from tendon_cli.studies.study import Study

FLAGS = ("status", *JUDGEMENTS)
"""Columns of words, and of true or false, which are compared exactly."""
_RESULTS = {*OF_DESIGNS, *OF_CYCLES, *OF_TRAJECTORIES, *OF_STATES, *OF_MOTION_STATES, *FLAGS}
"""Columns that are computed; the others define the design or state of a row."""

Breaking = dict[str, set[int]]
"""Rows that break each limit, by its name; slack and no equilibrium count as limits."""


@dataclass(frozen=True)
class TablePair:
    """Two tables of one kind, and the rows that both have, in the same order from either side."""

    first: Cube
    second: Cube
    axes: tuple[Axis, ...]
    """Axes that both have, by their columns."""
    places: tuple[Mapping[str, Rows], Mapping[str, Rows]]
    """Common positions on each axis of either table, by its column."""
    left_out: Mapping[str, str] = field(default_factory=dict)
    """Values that only one of them has, in words, by the key of the axis."""

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
                found = (
                    np.zeros(1, np.int64) if axes[0] is None else _single(axes[0], second.study),
                    np.zeros(1, np.int64) if axes[1] is None else _single(axes[1], first.study),
                )
            only = []
            for place, (axis, of_both) in enumerate(zip(axes, found, strict=True)):
                if axis is None:
                    continue
                places[place][axis.column] = of_both
                if len(axis) > len(of_both):
                    values = say.counted(len(axis) - len(of_both), "value")
                    only.append(f"{values} in {('the first', 'the second')[place]} only")
            if only:
                left_out[key] = f"{key}: {', '.join(only)}"
        return cls(first, second, tuple(common), places, left_out)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of common values on each axis."""
        return tuple(len(self.places[0][axis.column]) for axis in self.axes)

    @property
    def rows(self) -> int:
        """Number of common rows."""
        return int(np.prod(self.shape))

    @property
    def columns(self) -> list[str]:
        """Results that both tables have."""
        return [name for name in _results(self.first) if name in _results(self.second)]

    @property
    def columns_of_one(self) -> Iterator[tuple[str, str]]:
        """Results that only one of the tables has, each with words for it."""
        common = self.columns
        for cube, owner in ((self.first, "the first"), (self.second, "the second")):
            for name in _results(cube):
                if name not in common:
                    whole = f"{cube.kind}.{name}"
                    yield whole, f"{whole}: a column in {owner} only"

    def both(self, name: str) -> tuple[ColumnArray, ColumnArray]:
        """Return a column of both tables, on the rows that both have."""
        return self._column(0, name), self._column(1, name)

    def _column(self, place: int, name: str) -> ColumnArray:
        """Return a column of the first table, 0, or the second, 1, on the rows that both have."""
        cube = (self.first, self.second)[place]
        order = [axis.column for axis in self.axes]
        return cube.gather(cube.rows(order, self.places[place]), [name])[name].ravel()

    def where(self, row: int) -> dict[str, Value]:
        """Return the values of a common row on the axes."""
        values: dict[str, Value] = {}
        for axis, place in zip(self.axes, np.unravel_index(row, self.shape), strict=True):
            value = axis.values[self.places[0][axis.column][place]]
            values[axis.column] = str(value) if axis.is_text else float(value)
        return values

    def breaking(self, place: int) -> Breaking:
        """Return the common rows that break each limit in the first table, 0, or the second, 1."""
        cube = (self.first, self.second)[place]
        names = [name for name in columns_that_judge(cube) if name in cube.columns]
        columns: dict[str, Any] = {name: self._column(place, name) for name in names}
        columns["design"] = np.arange(self.rows)
        found: Breaking = defaultdict(set)
        bounds = {limit: cube.bound(limit, columns) for limit in cube.limits}
        for breach in breaches_in(columns, bounds):
            found[breach["limit"]].add(breach["design"])
        return found


def _results(cube: Cube) -> list[str]:
    """Return the columns of a table that are computed."""
    if cube.table is None:
        return []
    return [name for name in cube.table.schema.names if name in _RESULTS]


def difference(
    first: ColumnArray, second: ColumnArray, *, is_flag: bool
) -> npt.NDArray[np.float64]:
    """Return the difference in each row: for flags 0 or 1; infinite if only one value is null."""
    if is_flag:
        return np.asarray(first != second, dtype=np.float64)
    one_is_null = np.isnan(first) != np.isnan(second)
    with np.errstate(invalid="ignore"):  # two infinite values do not differ
        return np.where(one_is_null, np.inf, np.abs(np.nan_to_num(first - second)))


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


def _single(axis: Axis, other: Study) -> Rows:
    """Find the position on an axis of the single value that the other study has of it."""
    number = other.numbers.get(axis.key)
    if number is not None and not (number.is_axis or number.is_interval):
        places = np.flatnonzero(_tokens(axis) == _token(number.single))
        if len(places):
            return places[:1].astype(np.int64)
    if len(axis) == 1:
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
