"""The axes of a table, and the rows that a figure needs, read part by part so that memory stays flat."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.parquet as pq

from tendon_cli.errors import InputError
from tendon_cli.study.study import keys
from tendon_cli.tables.read import TableFiles

Ints = npt.NDArray[np.int64]
Columns = dict[str, npt.NDArray[Any]]

CASE = "case"
_SIDES = ("flexor", "extensor")
_MOST = 1e150
"""More than any number of a study comes to, and few enough to be drawn."""


@dataclass(frozen=True)
class Axis:
    """One axis of a table's rows, whose values are those of a column."""

    key: str
    column: str
    length: int
    stride: int
    """Rows from one value to the next."""
    is_log: bool
    is_text: bool


@dataclass(frozen=True)
class Product:
    """The rows of a table as the product of its axes, slowest first."""

    table: TableFiles
    axes: tuple[Axis, ...]

    def axis(self, column: str) -> Axis | None:
        """The axis of a column."""
        return next((axis for axis in self.axes if axis.column == column), None)

    def positions(self) -> dict[str, Ints]:
        """All positions on each axis."""
        return {axis.column: np.arange(axis.length, dtype=np.int64) for axis in self.axes}

    def is_text(self, column: str) -> bool:
        """Whether a column holds words."""
        return bool(pa.types.is_dictionary(self.table.schema.field(column).type))

    def rows(self, order: Sequence[str], positions: Mapping[str, Ints]) -> Ints:
        """Row numbers over the columns in `order`, of shape (len of each); other axes have one position each."""
        total = np.zeros((1,) * len(order), dtype=np.int64)
        for axis in self.axes:
            steps = np.asarray(positions[axis.column], dtype=np.int64) * axis.stride
            if axis.column in order:
                shape = [1] * len(order)
                shape[order.index(axis.column)] = len(steps)
                total = total + steps.reshape(shape)
            else:
                total = total + steps.reshape(())
        return total

    def values(self, axis: Axis, positions: Ints | None = None) -> npt.NDArray[Any]:
        """Values of an axis at its positions, all by default."""
        at = np.arange(axis.length, dtype=np.int64) if positions is None else positions
        found = self.gather(at * axis.stride, (axis.column,))[axis.column]
        if not axis.is_text and np.isnan(found).any():
            # A case that sets this number for one side makes the plain column null; the study still has the axis.
            try:
                found = _in_study(self.table.facts["study"]["study"], axis.key)[at]
            except (KeyError, TypeError, ValueError, IndexError):
                raise _foreign(self.table) from None
        return found

    def gather(self, rows: Ints, columns: Sequence[str]) -> Columns:
        """Columns at some rows, in the shape of `rows`; null becomes NaN or ""."""
        order = np.argsort(rows, axis=None, kind="stable")
        wanted = rows.ravel()[order]
        names = list(dict.fromkeys(columns))
        found = {name: _empty(self.table.schema.field(name).type, rows.size) for name in names}
        start = 0
        for file in self.table.files:
            count = pq.read_metadata(file).num_rows
            low, high = np.searchsorted(wanted, (start, start + count))
            if high > low:
                part = TableFiles((file,)).read(names).take(pa.array(wanted[low:high] - start))
                for name in names:
                    found[name][order[low:high]] = _numpy(part.column(name))
            start += count
        if any((np.abs(values) > _MOST).any() for values in found.values() if values.dtype == np.float64):
            raise _foreign(self.table)
        return {name: values.reshape(rows.shape) for name, values in found.items()}


def product_of(table: TableFiles) -> Product:
    """The axes of a table from what it knows of its study; raises InputError for a table of another kind."""
    try:
        lengths = _lengths(table)
        strides = np.cumprod([1, *(length for _, length, _ in reversed(lengths))][:-1], dtype=object)[::-1]
        axes = tuple(
            _axis(table.schema, key, length, int(stride), is_log)
            for (key, length, is_log), stride in zip(lengths, strides, strict=True)
        )
        is_one = table.facts["table"] in {"designs", "states"} and _is_ours(table.schema)
        if not is_one or table.rows != math.prod(axis.length for axis in axes):
            raise _foreign(table)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError, pa.ArrowException):
        raise _foreign(table) from None
    return Product(table, axes)


def evenly(count: int, most: int) -> Ints:
    """At most `most` of `count` positions, evenly chosen, both ends among them; of one, the middle."""
    if count <= most:
        return np.arange(count, dtype=np.int64)
    if most == 1:
        return np.array([count // 2], dtype=np.int64)
    return np.unique(np.round(np.linspace(0, count - 1, most)).astype(np.int64))


def _lengths(table: TableFiles) -> list[tuple[str, int, bool]]:
    """Key, length and spacing of each axis, slowest first."""
    record = table.facts["study"]
    study = record["study"]
    found = [(CASE, len(study["cases"]), False) if key == CASE else (key, *_grid(study, key)) for key in record["axes"]]
    if table.facts["table"] == "states":
        found.append(("direction", len(study["motion"]["direction"]), False))
        found.append(("motion.elbow_angle", *_grid(study, "motion.elbow_angle")))
    return found


def _said(study: Mapping[str, Any], key: str) -> Any:
    """What a study says under a dotted key."""
    said: Any = study
    for name in key.split("."):
        said = said[name]
    return said


def _grid(study: Mapping[str, Any], key: str) -> tuple[int, bool]:
    value = _said(study, key)
    if isinstance(value, Mapping):
        return int(value["num"]), value.get("spacing") == "log"
    return (len(value), False) if isinstance(value, list) else (1, False)


def _in_study(study: Mapping[str, Any], key: str) -> npt.NDArray[np.float64]:
    """The values of an axis in SI, from the study that the table knows."""
    values = keys()[key].number.read(_said(study, key))
    return values.array if values is not None else np.full(1, np.nan)


def _axis(schema: pa.Schema, key: str, length: int, stride: int, is_log: bool) -> Axis:
    """An axis with its column, which is named by its key, or for the commonest by the key's last word."""
    parts = key.split(".")
    side = [parts.pop(1)] if len(parts) == 3 and parts[1] in _SIDES else []
    names = ("_".join((*parts, *side)), "_".join((parts[-1], *side)))
    column = next(name for name in (*names, "") if name in schema.names or not name)
    return Axis(key, column, length, stride, is_log, pa.types.is_dictionary(schema.field(column).type))


def _is_ours(schema: pa.Schema) -> bool:
    """Whether columns have names of their own, types that we write, and units and meanings that are text."""
    for field in schema:
        b"".join((field.metadata or {}).values()).decode()  # raises ValueError
    words = [field.type.value_type for field in schema if pa.types.is_dictionary(field.type)]
    plain = [field.type for field in schema if not pa.types.is_dictionary(field.type)]
    is_known = all(kind in (pa.float64(), pa.int64(), pa.bool_()) for kind in plain)
    return is_known and all(kind == pa.string() for kind in words) and len(set(schema.names)) == len(schema.names)


def _foreign(table: TableFiles) -> InputError:
    hint = "figures are drawn from designs.parquet and states.parquet of a run"
    return InputError("is not a table of designs or states", where=str(table.files[0]), hint=hint)


def _empty(kind: pa.DataType, size: int) -> npt.NDArray[Any]:
    return np.full(size, "", dtype=object) if pa.types.is_dictionary(kind) else np.full(size, np.nan)


def _numpy(column: pa.ChunkedArray) -> npt.NDArray[Any]:
    if pa.types.is_dictionary(column.type):
        return np.asarray(column.cast(pa.string()).fill_null("").to_numpy(zero_copy_only=False))
    return np.asarray(column.cast(pa.float64()).to_numpy(zero_copy_only=False))
