"""A table by the axes of its study: its rows are their product, slowest first; those that are asked for are read."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from tendon_cli.cube.axes import ANGLE, LOAD, Ints, axes_of
from tendon_cli.cube.columns import Columns, Values
from tendon_cli.cube.labels import Shown, as_read
from tendon_cli.engine.states import WorkedOut
from tendon_cli.errors import InputError, TendonError, UsageError
from tendon_cli.quantities import Quantity
from tendon_cli.space.axis import SIDES, SLACK, Axis
from tendon_cli.studies.filters import Condition
from tendon_cli.studies.load import recorded_study
from tendon_cli.studies.spaces import space_of
from tendon_cli.studies.study import Study
from tendon_cli.tables.read import AnyTable
from tendon_cli.tables.schema import as_numpy
from tendon_cli.units import shorten

_ALWAYS = ("pretension", "spring_stiffness", "spool_ratio", LOAD, "friction", "bend_angle")
"""Columns that every table has, and that say what a design is."""
_LARGEST = 1e150
"""More than any number of a study comes to, and few enough to be drawn."""
_MOST_LISTED = 12


@dataclass(frozen=True)
class Cube:
    """A table of designs or states by its axes; without `files`, one to come."""

    kind: str
    """designs, states, or choices, of which rows between the points of the grid stand after the product."""
    axes: tuple[Axis, ...]
    of: Columns
    study: Mapping[str, Any]
    """The resolved study as a document."""
    asked: Study
    """The study itself."""
    study_hash: str
    files: AnyTable | None = None

    @property
    def columns(self) -> Mapping[str, Quantity | None]:
        """What each column holds, the derived ones included; words and truths are no quantity."""
        return self.of.held

    @property
    def title(self) -> str:
        """What the study is called: its title, or its name."""
        return str(self.study.get("title") or self.study.get("name") or "")

    @property
    def source(self) -> str:
        """Name and hash of the study, for a figure's file."""
        return f"tendon study {self.study.get('name', '')} {self.study_hash}"

    @cached_property
    def limits(self) -> dict[str, float]:
        """What the study says under [limits], in SI."""
        return dict(self.asked.limits.items())

    def limit(self, key: str) -> float:
        """A limit of the study, in SI; 0 if it says nothing."""
        return self.limits.get(key, 0.0)

    @cached_property
    def _unilateral(self) -> npt.NDArray[np.bool_]:
        space = space_of(self.asked)
        return np.asarray(space.number(SLACK).within(space.whole)) > 0.0

    @property
    def pushes(self) -> bool:
        """Whether tendons push in the model of the study, so that negative tension means slack."""
        return not self._unilateral.all()

    def is_null(self, column: str) -> bool:
        """Whether a column is null whatever the numbers are: slack lengths have no meaning if tendons push."""
        return (
            column in ("flexor_slack", "extensor_slack", "max_slack") and not self._unilateral.any()
        )

    @cached_property
    def defining(self) -> list[str]:
        """Columns of numbers that say what a design is."""
        names = [
            *_ALWAYS,
            *(axis.column for axis in self.axes if not axis.is_text and axis.column != ANGLE),
        ]
        return [each for name in dict.fromkeys(names) for each in self.with_sides(name)]

    def with_sides(self, column: str) -> list[str]:
        """A column, or the two of the sides if they differ."""
        sides = [f"{column}_{side}" for side in SIDES]
        return sides if set(sides) <= set(self.columns) else [column]

    @cached_property
    def strides(self) -> dict[str, int]:
        """Rows from one value of an axis to the next, by its column."""
        return {
            axis.column: math.prod(map(len, self.axes[at + 1 :]))
            for at, axis in enumerate(self.axes)
        }

    def axis(self, column: str) -> Axis | None:
        """The axis of a column."""
        return next((axis for axis in self.axes if axis.column == column), None)

    def shown(self, column: str, units: Mapping[str, str] | None = None) -> Shown:
        """How a column is shown; `units` overrules the usual unit of a dimension."""
        words = column.replace("_", " ")
        quantity = self.columns[column] or Quantity(column, words, "number", "1", "1", words)
        return Shown.of(column, as_read(quantity, self.study), units)

    # --- Rows --------------------------------------------------------------------------------------------------------

    def choose(self, asked: Sequence[Condition]) -> dict[str, Ints]:
        """Positions on each axis that conditions leave; raises UsageError if nothing is left of one."""
        chosen = {axis.column: np.arange(axis.length, dtype=np.int64) for axis in self.axes}
        for condition in asked:
            axis = self.axis(condition.column)
            if axis is None:
                continue
            positions = chosen[axis.column]
            known = [str(value) for value in axis.values] if axis.is_text else []
            wrong = next(
                (str(word) for word in condition.wanted if axis.is_text and word not in known), None
            )
            if wrong is not None:
                hint = f"values: {', '.join(known[:20])}"
                raise UsageError(
                    f'{axis.column} is never "{shorten(wrong)}"', where="--where", hint=hint
                )
            kept = positions[condition.holds(axis.values[positions], of_axis=True)]
            if not len(kept):
                hint = f"values: {', '.join(self._listed(axis, positions))}"
                raise UsageError(
                    f'nothing is left by "{shorten(condition.text)}"', where="--where", hint=hint
                )
            chosen[axis.column] = kept
        return chosen

    def _listed(self, axis: Axis, positions: Ints) -> list[str]:
        """The values of an axis as one writes them in a filter, many of them shortened."""
        ends = positions if len(positions) <= _MOST_LISTED else positions[[0, 1, 2, -1]]
        values = axis.values[ends]
        texts = [
            str(each) if axis.is_text else self.shown(axis.column).text(each).replace("−", "-")
            for each in values
        ]
        return texts if len(ends) == len(positions) else [*texts[:-1], "…", *texts[-1:]]

    def rows(self, order: Sequence[str], positions: Mapping[str, Ints]) -> Ints:
        """Row numbers over the columns in `order`, of shape (len of each); other axes have one position each."""
        total = np.zeros((1,) * len(order), dtype=np.int64)
        for axis in self.axes:
            steps = np.asarray(positions[axis.column], dtype=np.int64) * self.strides[axis.column]
            if axis.column in order:
                shape = [1] * len(order)
                shape[order.index(axis.column)] = len(steps)
                total = total + steps.reshape(shape)
            else:
                total = total + steps.reshape(())
        return total

    def gather(self, rows: Ints, columns: Sequence[str]) -> dict[str, Values]:
        """Columns at some rows, in the shape of `rows`; null becomes NaN or "". Read part by part."""
        names = list(dict.fromkeys(columns))
        return self.of.work_out(names, self._stored(rows, self.of.stored(names)))

    def _stored(self, rows: Ints, names: list[str]) -> dict[str, Values]:
        if self.files is None:
            raise ValueError("a table that is not written has no rows")
        order = np.argsort(rows, axis=None, kind="stable")
        wanted = rows.ravel()[order]
        kinds = {name: self.files.schema.field(name).type for name in names}
        read = {name: np.full(rows.size, *_nothing(kind)) for name, kind in kinds.items()}
        for start, part in self.files.parts(names, wanted):
            low, high = np.searchsorted(wanted, (start, start + part.num_rows))
            for name in names if high > low else ():
                read[name][order[low:high]] = as_numpy(part.column(name))[wanted[low:high] - start]
        for name, values in read.items():
            quantity = self.columns[name]
            may_be_rigid = quantity is not None and quantity.dimension == "stiffness"
            numbers = values[values != np.inf] if may_be_rigid else values
            if values.dtype == np.float64 and (np.abs(numbers) > _LARGEST).any():
                raise foreign(self.files)
        return {name: values.reshape(rows.shape) for name, values in read.items()}


def _nothing(kind: pa.DataType) -> tuple[Any, Any]:
    """What stands where there is no value, and the type of an array of such values."""
    return ("", object) if pa.types.is_dictionary(kind) else (np.nan, np.float64)


def cube_of(table: AnyTable, kinds: Sequence[str] = ("designs", "states")) -> Cube:
    """A table by what it knows of its study; raises InputError for one of another kind."""
    try:
        kind, record = table.facts["table"], table.facts["study"]
        asked = recorded_study(record)
        axes, rows = axes_of(asked, kind), table.rows
        if kind == "choices":
            rows -= int(as_numpy(table.read(["refined"])["refined"]).sum())
        needed = {axis.column for axis in axes} | (set() if kind == "choices" else {*_ALWAYS})
        is_whole = needed <= {*table.schema.names} and rows == math.prod(map(len, axes))
        if kind not in kinds or not _is_ours(table.schema) or not is_whole:
            raise foreign(table)
        return Cube(
            kind,
            axes,
            Columns.of(table.schema),
            record["study"],
            asked,
            str(table.facts["study_hash"]),
            table,
        )
    except (
        LookupError,
        TypeError,
        ValueError,
        OverflowError,
        AttributeError,
        pa.ArrowException,
        TendonError,
    ):
        raise foreign(table) from None


def cube_to_come(study: Study, kind: str) -> Cube:
    """The table of designs or states that a study will give, to plan its figures before anything is computed."""
    return cube_of(WorkedOut(study.record, study.hash, kind=kind))


def choices_of(table: AnyTable) -> Cube:
    """The choices of an answer by the axes of their grid; raises InputError for another table."""
    return cube_of(table, ("choices",))


def _is_ours(schema: pa.Schema) -> bool:
    """Whether columns have different names, and types that we write."""
    kinds = [each.type for each in schema]
    numbers = [kind for kind in kinds if kind in (pa.float64(), pa.int64(), pa.bool_())]
    words = [
        kind for kind in kinds if pa.types.is_dictionary(kind) and kind.value_type == pa.string()
    ]
    return len(set(schema.names)) == len(schema.names) == len(numbers) + len(words)


def foreign(table: AnyTable) -> InputError:
    """The fault of a table of another kind."""
    hint = "figures are drawn from designs.parquet and states.parquet of a run"
    return InputError(
        "is not a table of designs or states",
        where=str(table.files[0] if table.files else "in memory"),
        hint=hint,
    )
