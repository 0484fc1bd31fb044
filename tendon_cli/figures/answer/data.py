"""What the figures of an answer show, read from the table of choices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.compute as pc

from tendon_cli.cube.columns import quantity_in
from tendon_cli.cube.labels import Shown
from tendon_cli.figures.scales import Scale, scale_of
from tendon_cli.tables.read import TableFiles

Floats = npt.NDArray[np.float64]

READ = ("pretension_from", "pretension_to", "tolerance", "from_by", "to_by", "feasible", "refined", "on_front")


@dataclass(frozen=True)
class Slice:
    """Choices of the grid along one or two of its axes, all else as in one choice; arrays of shape (y, x) or (x,)."""

    scales: tuple[Scale, ...]
    """Of x, and of y."""
    low: Floats
    """N; not a number where no pretension could do."""
    high: Floats
    """N; infinite where nothing bounds it."""
    tolerance: Floats
    low_by: npt.NDArray[Any]
    high_by: npt.NDArray[Any]
    title: str

    @property
    def pairs(self) -> npt.NDArray[Any]:
        """What leaves each choice without a window, in words; empty where one has one."""
        both = np.char.add(np.char.add(self.low_by, " against "), self.high_by)
        one = np.isnan(self.low) | (self.low_by == "") | (self.high_by == "")
        single = np.where(self.low_by == "", self.high_by, self.low_by)
        return np.where(self.low <= self.high, "", np.where(one, single, both))


@dataclass(frozen=True)
class ChoiceTable:
    """The table of choices of an answer."""

    table: TableFiles

    @property
    def axes(self) -> list[str]:
        """Columns of the choices' axes, slowest first."""
        names: list[str] = self.table.schema.names
        return names[: names.index("refined")]

    def values(self, axis: str) -> list[Any]:
        """The values of an axis on the grid, each once, in the order of the grid."""
        found: dict[Any, None] = {}
        for _, part in self.table.parts([axis, "refined"]):
            unique = pc.unique(part.filter(pc.invert(part["refined"]))[axis])
            found |= dict.fromkeys(unique.to_pylist())
        return list(found)

    def shown(self, column: str) -> Shown | None:
        """How a column is shown; None for names."""
        field = self.table.schema.field(column)
        return None if pa.types.is_dictionary(field.type) else Shown.of(column, quantity_in(field))

    def near(self, choice: dict[str, Any], axes: Sequence[str]) -> dict[str, Any]:
        """The values of other axes, of the grid and nearest to those of a choice."""
        return {axis: self._nearest(axis, choice[axis]) for axis in self.axes if axis not in axes}

    def _nearest(self, axis: str, value: Any) -> Any:
        return value if isinstance(value, str) else min(self.values(axis), key=lambda each: abs(each - value))

    def slice(self, axes: Sequence[str], choice: dict[str, Any]) -> Slice:
        """The choices along one axis or two, x first, through a choice."""
        fixed = self.near(choice, axes)
        parts = []
        for _, part in self.table.parts([*self.axes, *READ]):
            keep = pc.invert(part["refined"])
            for axis, value in fixed.items():
                keep = pc.and_(
                    keep, pc.equal(pc.cast(part[axis], pa.string()) if isinstance(value, str) else part[axis], value)
                )
            parts.append(part.filter(keep))
        rows = pa.concat_tables(parts, promote_options="default").to_pandas()
        scales, places = [], []
        for axis in axes:
            values = self.values(axis)
            scale = scale_of(np.array(values), self.shown(axis), is_log=False)
            scales.append(scale)
            position = {values[at]: rank for rank, at in enumerate(scale.order)}
            places.append(rows[axis].map(position).to_numpy(dtype=np.int64))
        shape = tuple(len(scale.places) for scale in reversed(scales))
        at = tuple(reversed(places))

        def laid(name: str, empty: Any) -> npt.NDArray[Any]:
            out = np.full(shape, empty)
            out[at] = rows[name].to_numpy()
            return out

        high = laid("pretension_to", np.nan)
        low = laid("pretension_from", np.nan)
        return Slice(
            scales=tuple(scales),
            low=low,
            high=np.where(np.isnan(high) & ~np.isnan(low), np.inf, high),
            tolerance=laid("tolerance", np.nan),
            low_by=laid("from_by", " " * 40).astype(str),
            high_by=laid("to_by", " " * 40).astype(str),
            title=", ".join(self.said(axis, value) for axis, value in fixed.items()),
        )

    def said(self, axis: str, value: Any) -> str:
        """One value of an axis, as titles say it."""
        how = self.shown(axis)
        return str(value) if how is None else how.equation(float(value))
