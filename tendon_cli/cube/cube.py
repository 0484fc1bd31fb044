"""A table by the axes of its study, whose product its rows are; only rows asked for are read."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from tendon_cli import say
from tendon_cli.cube.axes import ANGLE, axis_values, columns_of_names
from tendon_cli.cube.columns import ColumnArray, TableColumns
from tendon_cli.cube.labels import ColumnLabel, as_read
from tendon_cli.cube.room import (
    bound_of,
    bounded_column,
    bounded_values,
    has_bounded_column,
    room_to,
)
from tendon_cli.engine.results import Result
from tendon_cli.engine.states import WorkedOut
from tendon_cli.engine.sweep_kind import DEFINING, SWEEP
from tendon_cli.errors import InputError, TendonError, UsageError
from tendon_cli.model.kinematics import Rows
from tendon_cli.quantities import SIDES, Quantity, bound_name
from tendon_cli.studies.answer_draws import READ_WHERE_DRAWN
from tendon_cli.studies.filters import Condition, Filter
from tendon_cli.studies.load import recorded_study
from tendon_cli.studies.space.axis import SLACK, Axis
from tendon_cli.studies.spaces import space_of
from tendon_cli.studies.study import Study
from tendon_cli.tables.read import AnyTable, TableInMemory
from tendon_cli.tables.schema import as_numpy
from tendon_cli.units import shorten
from tendon_cli.verbs.registry import load, table_kinds

_SLACK_LENGTHS = ("flexor_slack", "extensor_slack", "max_slack")
_LARGEST = 1e150
"""Bound above any number of a study, below which all can be drawn."""
_MOST_LISTED = 12
"""Most values of an axis that a hint lists."""
_UNREADABLE = (
    LookupError,
    TypeError,
    ValueError,
    OverflowError,
    AttributeError,
    pa.ArrowException,
    TendonError,
)
"""Errors of metadata that are not as tendon writes them."""


@dataclass(frozen=True)
class Cube:
    """A table of designs, states or choices by the axes of its study, slowest first."""

    kind: str
    """designs, states, or choices."""
    axes: tuple[Axis, ...]
    table_columns: TableColumns
    """Columns of the table, the derived ones included."""
    document: Mapping[str, Any]
    """The resolved study as a document."""
    study: Study
    """The study itself."""
    study_hash: str
    table: AnyTable | None = None
    """Table with the rows; None for columns alone."""

    @property
    def columns(self) -> Mapping[str, Quantity | None]:
        """Quantity of each column, the derived ones included; None for words and truths."""
        return self.table_columns.quantities

    @property
    def title(self) -> str:
        """Title of the study, or its name."""
        return str(self.document.get("title") or self.document.get("name") or "")

    @property
    def source(self) -> str:
        """Name and hash of the study, for a figure's file."""
        return f"tendon study {self.document.get('name', '')} {self.study_hash}"

    @cached_property
    def limits(self) -> dict[str, float | None]:
        """Limits of the study, SI; None for one that differs between designs."""
        of_axes = space_of(self.study).limits
        stated = self.study.limits
        return {name: None if name in of_axes else stated[name] for name in self.study.limit_names}

    def bound(self, limit: str, columns: Mapping[str, ColumnArray]) -> npt.NDArray[np.float64]:
        """Return the bound of a limit at some rows, SI, to broadcast to them; infinite for none.

        Args:
            limit: Name of the limit.
            columns: Columns at these rows; that of the limit is needed if the rows do not share it.
        """
        shared = self.limits[limit]
        values = columns[bound_name(limit)] if shared is None else shared
        return bound_of(limit, np.asarray(values, dtype=np.float64))

    @cached_property
    def _unilateral(self) -> npt.NDArray[np.bool_]:
        """True where tendons cannot push."""
        space = space_of(self.study)
        return np.asarray(space.number(SLACK).within(space.whole)) > 0.0

    @property
    def has_pushing_tendons(self) -> bool:
        """True if tendons push in a model of the study, so that negative tension means slack."""
        return not self._unilateral.all()

    def is_null(self, column: str) -> bool:
        """Return True if a column is null whatever the numbers are.

        Slack lengths have no meaning if tendons push.
        """
        return column in _SLACK_LENGTHS and not self._unilateral.any()

    @cached_property
    def defining(self) -> list[str]:
        """Columns of numbers that say what a design is."""
        of_axes = [axis.column for axis in self.axes if not axis.is_text and axis.column != ANGLE]
        names = []
        for name in dict.fromkeys([*DEFINING, *of_axes]):
            names += self.with_sides(name)
        return names

    def with_sides(self, column: str) -> list[str]:
        """Return a column, or those of both sides if the sides differ."""
        sides = [f"{column}_{side}" for side in SIDES]
        return sides if set(sides) <= set(self.columns) else [column]

    @cached_property
    def strides(self) -> dict[str, int]:
        """Rows from one value of an axis to the next, by the axis's column."""
        return {
            axis.column: math.prod(map(len, self.axes[place + 1 :]))
            for place, axis in enumerate(self.axes)
        }

    @cached_property
    def columns_of_names(self) -> dict[str, tuple[Axis, Axis]]:
        """Columns that follow from one named axis, as `columns_of_names` of `axes.py` has them."""
        return columns_of_names(self.axes, space_of(self.study).single)

    def axis(self, column: str) -> Axis | None:
        """Return the axis of a column; None if it has none."""
        return next((axis for axis in self.axes if axis.column == column), None)

    def shown(self, column: str, units: Mapping[str, str] | None = None) -> ColumnLabel:
        """Return a column as figures show it.

        Args:
            column: Its name.
            units: Units by dimension that overrule the usual ones.
        """
        words = say.spaced(column)
        quantity = self.columns[column] or Quantity(column, words, "number", "1", "1", words)
        return ColumnLabel.of(column, as_read(quantity, self.document), units)

    # --- Rows -------------------------------------------------------------------------------------

    def conditions(self, filters: Iterable[Filter | str]) -> list[Condition]:
        """Return the conditions that filters set on the columns; raises UsageError."""
        return self.table_columns.conditions(filters, axis_values(self.axes, self.study))

    def choose(self, asked: Sequence[Condition]) -> dict[str, Rows]:
        """Return the positions on each axis that conditions leave, by the axis's column.

        A condition on a number that a named axis sets selects among its names.

        Raises:
            UsageError: A condition leaves no rows.
        """
        chosen = {axis.column: np.arange(axis.length, dtype=np.int64) for axis in self.axes}
        for condition in asked:
            axis = self.axis(condition.column)
            values = axis
            if condition.column in self.columns_of_names:
                axis, values = self.columns_of_names[condition.column]
            if axis is None or values is None:
                continue
            positions = chosen[axis.column]
            left = positions[condition.holds(values.values[positions])]
            if not len(left):
                hint = f"values: {', '.join(self._listed(values, positions))}"
                raise UsageError(
                    f'"{shorten(condition.text)}" leaves no rows',
                    where="--where",
                    hint=hint,
                )
            chosen[axis.column] = left
        return chosen

    def _listed(self, axis: Axis, positions: Rows) -> list[str]:
        """Return values of an axis as a filter states them; if they are many, those at the ends."""
        are_few = len(positions) <= _MOST_LISTED
        values = axis.values[positions if are_few else positions[[0, 1, 2, -1]]]
        if axis.is_text:
            texts = [str(value) for value in values]
        else:
            shown = self.shown(axis.column)
            texts = [shown.text(value).replace("−", "-") for value in values]
        return texts if are_few else [*texts[:-1], "…", texts[-1]]

    def rows(self, order: Sequence[str], positions: Mapping[str, Rows]) -> Rows:
        """Return the row numbers of all combinations of positions on some axes.

        Args:
            order: Columns of these axes.
            positions: Positions on each axis of the table; one on every axis not in `order`.

        Returns:
            Row numbers with one dimension for each column in `order`.
        """
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

    def gather(self, rows: Rows, columns: Sequence[str]) -> dict[str, ColumnArray]:
        """Return columns at some rows, read part by part.

        Args:
            rows: Row numbers.
            columns: Names of the columns.

        Returns:
            Values in the shape of `rows`; null becomes NaN or "".
        """
        names = list(dict.fromkeys(columns))
        return self.table_columns.compute(
            names, self._stored(rows, self.table_columns.stored(names))
        )

    def room(self, limit: str, rows: Rows) -> npt.NDArray[np.float64]:
        """Return the room that a limit of the study leaves at some rows.

        It is positive where the limit is kept, negative where it is broken, and NaN where there is
        nothing to compare; SI, in the shape of `rows`.
        """
        column = bounded_column(limit)
        own = self.columns_of_bound(limit)
        is_column = column in self.columns and self.with_sides(column) == [column]
        if is_column and has_bounded_column(limit, self.kind):
            columns = self.gather(rows, [column, *own])
            values = columns[column]
        else:
            values = bounded_values(self.study, self.kind, limit, rows)
            columns = self.gather(rows, own)
        return room_to(limit, values, self.bound(limit, columns))

    def columns_of_bound(self, limit: str) -> list[str]:
        """Return the column that has the limit of each row; none if all rows share it."""
        return [bound_name(limit)] if self.limits[limit] is None else []

    def _stored(self, rows: Rows, names: list[str]) -> dict[str, ColumnArray]:
        """Read columns of the table at some rows, in the shape of `rows`."""
        if self.table is None:
            raise ValueError("this cube has columns but no rows")
        order = np.argsort(rows, axis=None, kind="stable")
        wanted = rows.ravel()[order]
        read = {}
        for name in names:
            is_text = pa.types.is_dictionary(self.table.schema.field(name).type)
            null, dtype = ("", object) if is_text else (np.nan, np.float64)
            read[name] = np.full(rows.size, null, dtype)
        for start, part in self.table.parts(names, wanted):
            low, high = np.searchsorted(wanted, (start, start + part.num_rows))
            if high <= low:
                continue
            for name in names:
                read[name][order[low:high]] = as_numpy(part.column(name))[wanted[low:high] - start]
        for name, values in read.items():
            quantity = self.columns[name]
            may_be_rigid = quantity is not None and quantity.dimension == "stiffness"
            numbers = values[values != np.inf] if may_be_rigid else values
            if values.dtype == np.float64 and (np.abs(numbers) > _LARGEST).any():
                raise foreign(self.table)
        return {name: values.reshape(rows.shape) for name, values in read.items()}


def cube_of(
    table: AnyTable, study: Study | None = None, kinds: Sequence[str] = SWEEP.table_names
) -> Cube:
    """Return a table by the axes of its study.

    Args:
        table: The table.
        study: Its study, if the caller has it already; else that of the table's metadata.
        kinds: Names of the tables that are accepted.

    Raises:
        InputError: It is a table of another kind, or not as tendon writes it.
    """
    try:
        kind = table_kinds()[table.facts["table"]]
        if study is None:
            study = study_of(table)
        axes: tuple[Axis, ...] = load(kind.axes)(study)
        needed = {*kind.always, *(axis.column for axis in axes)}
        is_whole = needed <= {*table.schema.names} and table.rows == math.prod(map(len, axes))
        if kind.name not in kinds or not _is_ours(table.schema) or not is_whole:
            raise foreign(table)
        return Cube(
            kind=kind.name,
            axes=axes,
            table_columns=TableColumns.of(table.schema),
            document=table.facts["study"]["study"],
            study=study,
            study_hash=str(table.facts["study_hash"]),
            table=table,
        )
    except _UNREADABLE:
        raise foreign(table) from None


def cube_to_come(study: Study, kind: str) -> Cube:
    """Return the table of designs or states that a study will give.

    With it figures are planned before anything is computed.

    Raises:
        StudyError: The study cannot be swept.
    """
    table = WorkedOut(study, kind=kind)
    return Cube(
        kind=kind,
        axes=load(table_kinds()[kind].axes)(study),
        table_columns=TableColumns.of(table.schema),
        document=study.document(),
        study=study,
        study_hash=study.hash,
        table=table,
    )


_ON_GAUGE = {
    "pretension": "set_flexor_tension",
    "pretension_from": "set_flexor_tension_from",
    "pretension_to": "set_flexor_tension_to",
}
"""Columns of what a gauge in the flexor shows, by those of the pretension."""


@dataclass(frozen=True)
class CubeAsRead(Cube):
    """Choices whose columns of pretension are what a gauge in the flexor at the joint shows."""

    @classmethod
    def of(cls, cube: Cube) -> CubeAsRead:
        """Return the same choices as the gauge shows them."""
        known = {field.name: getattr(cube, field.name) for field in fields(cube)}
        setting = {**cube.document.get("setting", {}), "read": READ_WHERE_DRAWN}
        return cls(**{**known, "document": {**cube.document, "setting": setting}})

    def gather(self, rows: Rows, columns: Sequence[str]) -> dict[str, ColumnArray]:
        """Return columns at some rows, as `Cube.gather` does."""
        names = {column: _ON_GAUGE.get(column, column) for column in columns}
        read = super().gather(rows, list(names.values()))
        return {column: read[name] for column, name in names.items()}


def cube_in(result: Result, table: str) -> Cube:
    """Return a table of a result, in its folder or in memory; raises as `cube_of` does."""
    in_memory = result.folder is None
    opened = TableInMemory(result.table(table)) if in_memory else result.kept(table)
    return cube_of(opened, result.study, (table,))


def study_of(table: AnyTable) -> Study:
    """Return the study of a table: the one of which it is worked out, or that of its metadata.

    Raises:
        InputError: The metadata hold no study.
    """
    if isinstance(table, WorkedOut):
        return table.study
    try:
        return recorded_study(table.facts["study"], table.facts["results_version"])
    except _UNREADABLE:
        raise foreign(table) from None


def axis_values_of(table: AnyTable) -> dict[str, npt.NDArray[Any]]:
    """Return the values that axes give the columns of a table, by column, in SI or as words.

    A table that holds no study, such as a CSV of people, has none.
    """
    try:
        study = study_of(table)
        kind = table_kinds()[table.facts["table"]]
    except (InputError, LookupError):
        return {}
    if kind.axes:
        return axis_values(load(kind.axes)(study), study)
    # Rows of other tables of an answer lie on axes of its choices and conditions.
    return axis_values(space_of(study).without_pretension().axes, study)


def _is_ours(schema: pa.Schema) -> bool:
    """Return True if all columns have different names, and types that tendon writes."""
    names = schema.names
    kinds = [field.type for field in schema]
    return len(set(names)) == len(names) and all(map(_is_written, kinds))


def _is_written(kind: pa.DataType) -> bool:
    """Return True if tendon writes columns of a type."""
    if pa.types.is_dictionary(kind):
        return bool(kind.value_type == pa.string())
    return kind in (pa.float64(), pa.int64(), pa.bool_())


def foreign(table: AnyTable) -> InputError:
    """Return the error of a table of another kind."""
    hint = "figures are drawn from designs.parquet and states.parquet of a run"
    return InputError(
        "is not a table of designs or states",
        where=str(table.files[0] if table.files else "in memory"),
        hint=hint,
    )
