"""The rows of a table as the product of its axes, as a study lays them out; those that a figure needs are read."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from tendon_cli.errors import InputError
from tendon_cli.figures.axes import ANGLE, LOAD, Ints, RowAxis, axes_of
from tendon_cli.figures.labels import Shown, quantity_in
from tendon_cli.quantities import OF_CYCLES, QUANTITIES, Quantity
from tendon_cli.studies.derived import DERIVED
from tendon_cli.studies.figures import OF_DESIGNS, OF_STATES
from tendon_cli.studies.study import SIDES, Study, keys
from tendon_cli.tables.read import TableFiles
from tendon_cli.units import parse_measure

Columns = dict[str, npt.NDArray[Any]]

_ALWAYS = ("pretension", "spring_stiffness", "spool_ratio", LOAD, "friction", "bend_angle")
"""Columns that every table has, and that say what a design is."""
_MOST = 1e150
"""More than any number of a study comes to, and few enough to be drawn."""


@dataclass(frozen=True)
class Product:
    """The rows of a table as the product of its axes, slowest first; without `files`, of a table to come."""

    kind: str
    """designs or states."""
    axes: tuple[RowAxis, ...]
    columns: Mapping[str, Quantity | None]
    """What each column holds, the derived ones included; words and truths are no quantity."""
    study: Mapping[str, Any]
    """The resolved study as a document."""
    study_hash: str
    files: TableFiles | None = None

    @property
    def title(self) -> str:
        """What the study is called: its title, or its name."""
        return str(self.study.get("title") or self.study.get("name") or "")

    @property
    def source(self) -> str:
        """Name and hash of the study, for a figure's file."""
        return f"tendon study {self.study.get('name', '')} {self.study_hash}"

    def limit(self, key: str) -> float:
        """What the study says under [limits], in SI; 0 where it says nothing."""
        said = self.study.get("limits", {}).get(key, 0.0)
        return float(said) if isinstance(said, (int, float)) else parse_measure(said, QUANTITIES[key].dimension).si

    @property
    def pushes(self) -> bool:
        """Whether tendons push in the model of the study, so that negative tension means slack."""
        return any(model.get("slack") == "bilateral" for model in _models(self.study))

    def is_null(self, column: str) -> bool:
        """Whether a column is null whatever the numbers are: slack lengths have no meaning where tendons push."""
        always = self.pushes and all(model.get("slack", "bilateral") == "bilateral" for model in _models(self.study))
        return always and column in ("flexor_slack", "extensor_slack", "max_slack")

    @property
    def defining(self) -> list[str]:
        """Columns of numbers that say what a design is."""
        names = [*_ALWAYS, *(axis.column for axis in self.axes if not axis.is_text and axis.column != ANGLE)]
        return [each for name in dict.fromkeys(names) for each in self.with_sides(name)]

    def with_sides(self, column: str) -> list[str]:
        """A column, or the two of the sides where they differ."""
        sides = [f"{column}_{side}" for side in SIDES]
        return sides if set(sides) <= set(self.columns) else [column]

    def axis(self, column: str) -> RowAxis | None:
        """The axis of a column."""
        return next((axis for axis in self.axes if axis.column == column), None)

    def shown(self, column: str, units: Mapping[str, str] | None = None) -> Shown:
        """How a column of numbers is shown; `units` overrules the usual unit of a dimension."""
        quantity = self.columns[column]
        words = column.replace("_", " ")
        return Shown.of(column, quantity or Quantity(column, words, "number", "1", "1", words), units)

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

    def gather(self, rows: Ints, columns: Sequence[str]) -> Columns:
        """Columns at some rows, in the shape of `rows`; null becomes NaN or "". Read part by part."""
        names = list(dict.fromkeys(columns))
        stored = dict.fromkeys(need for name in names for need in (_needs(name, self.columns) or [name]))
        read = self._stored(rows, list(stored))
        for name in names:
            if name in DERIVED:
                needed = (read[need] for need in _needs(name, self.columns))
                read[name] = np.asarray(DERIVED[name].of(*needed), dtype=np.float64)
        return {name: read[name] for name in names}

    def _stored(self, rows: Ints, names: list[str]) -> Columns:
        if self.files is None:
            raise ValueError("a table that is not written has no rows")
        order = np.argsort(rows, axis=None, kind="stable")
        wanted = rows.ravel()[order]
        found = {name: _empty(self.files.schema.field(name).type, rows.size) for name in names}
        for start, part in self.files.parts(names):
            low, high = np.searchsorted(wanted, (start, start + part.num_rows))
            if high > low:
                for name in names:
                    found[name][order[low:high]] = as_numpy(part.column(name))[wanted[low:high] - start]
        if any((np.abs(values) > _MOST).any() for values in found.values() if values.dtype == np.float64):
            raise _foreign(self.files)
        return {name: values.reshape(rows.shape) for name, values in found.items()}


def product_of(table: TableFiles) -> Product:
    """A table by what it knows of its study; raises InputError for a table of another kind."""
    try:
        kind, record = table.facts["table"], table.facts["study"]
        numbers = (pa.float64(), pa.int64())
        held = {each.name: quantity_in(each) if each.type in numbers else None for each in table.schema}
        columns = _with_derived(held)
        axes = axes_of(record, kind, columns, lambda key: _names_in(table, key))
        is_one = kind in {"designs", "states"} and _is_ours(table.schema)
        if not is_one or table.rows != math.prod(axis.length for axis in axes):
            raise _foreign(table)
        if not _is_study(record["study"]):
            raise _foreign(table)
        return Product(kind, axes, columns, record["study"], str(table.facts["study_hash"]), table)
    except (LookupError, TypeError, ValueError, OverflowError, AttributeError, StopIteration, pa.ArrowException):
        raise _foreign(table) from None


def product_to_come(study: Study, kind: str) -> Product:
    """The table of designs or states that a study will give, to plan its figures before anything is computed."""
    known = [keys()[path] for path in study.numbers]
    # What the sides or the cases say of their own has columns, too; which, only the run itself knows.
    numbers = {
        key.column: key.number.quantity
        for key in known
        if study.cases or key.column in _ALWAYS or key.path in study.axes or key.column.endswith(SIDES)
    }
    numbers |= {ANGLE: QUANTITIES[ANGLE]} if kind == "states" else {}
    results = OF_STATES if kind == "states" else OF_DESIGNS
    words = ("case", "direction", "status") if kind == "states" else ("case", "taut", "stable", "feasible")
    columns: dict[str, Quantity | None] = {**numbers, **dict.fromkeys(words)}
    kept = study.output.states or results if kind == "states" else results
    unmoved = OF_CYCLES if study.motion.speed is None else ()
    columns |= {name: QUANTITIES[name] for name in results if name in kept and name not in (*DERIVED, *unmoved)}
    linked = {axis.key: axis.names for axis in study.linked}
    record = study.record()
    axes = axes_of(record, kind, {**columns, **dict.fromkeys(linked)}, linked.__getitem__)
    return Product(kind, axes, _with_derived(columns), record["study"], study.hash)


def _needs(name: str, columns: Mapping[str, object]) -> list[str]:
    """The columns that a derived quantity follows from, those of its side where the sides differ; else none."""
    derived = DERIVED.get(name)
    needs = derived.needs if derived else ()
    return [side if derived and (side := f"{need}_{derived.side}") in columns else need for need in needs]


def _with_derived(columns: Mapping[str, Quantity | None]) -> dict[str, Quantity | None]:
    offered = {name: each.quantity for name, each in DERIVED.items() if set(_needs(name, columns)) <= set(columns)}
    return {**columns, **offered}


def _is_study(document: Any) -> bool:
    """Whether a document that a file holds has the sections of which figures read, as they must be."""
    limits = [value for part in _parts(document) for value in part.get("limits", {}).values()]
    models = all(isinstance(model, dict) for model in _models(document))
    return models and all(isinstance(value, (int, float, str)) for value in limits)


def _models(document: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    return [part.get("model", {}) for part in _parts(document)]


def _parts(document: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """What a study says for all cases, then what each case says."""
    return [document, *document.get("cases", ())]


def _names_in(table: TableFiles, key: str) -> list[str]:
    """The names along an axis, from the table's column."""
    return list(dict.fromkeys(table.read([key]).column(key).cast(pa.string()).to_pylist()))


def _is_ours(schema: pa.Schema) -> bool:
    """Whether columns have names of their own, and types that we write."""
    return len(set(schema.names)) == len(schema.names) and all(_kinds(schema))


def _kinds(schema: pa.Schema) -> Iterator[bool]:
    for each in schema:
        is_words = pa.types.is_dictionary(each.type) and each.type.value_type == pa.string()
        yield is_words or each.type in (pa.float64(), pa.int64(), pa.bool_())


def _foreign(table: TableFiles) -> InputError:
    hint = "figures are drawn from designs.parquet and states.parquet of a run"
    return InputError("is not a table of designs or states", where=str(table.files[0]), hint=hint)


def _empty(kind: pa.DataType, size: int) -> npt.NDArray[Any]:
    return np.full(size, "", dtype=object) if pa.types.is_dictionary(kind) else np.full(size, np.nan)


def as_numpy(column: pa.ChunkedArray) -> npt.NDArray[Any]:
    """A column with NaN or "" for null. Not by pyarrow's own ways, which import pandas or its functions."""
    return np.concatenate(
        [_words(each) if pa.types.is_dictionary(column.type) else _floats(each) for each in column.chunks]
    )


def _words(chunk: pa.DictionaryArray) -> npt.NDArray[Any]:
    known = np.array([*chunk.dictionary.to_pylist(), ""], dtype=object)
    return known[np.nan_to_num(_floats(chunk.indices), nan=-1.0).astype(np.int64)]


def _floats(chunk: pa.Array) -> npt.NDArray[np.float64]:
    valid, data = chunk.buffers()
    here = slice(chunk.offset, chunk.offset + len(chunk))
    stored = _bits(data) if chunk.type == pa.bool_() else np.frombuffer(data, chunk.type.to_pandas_dtype())
    numbers = stored[here].astype(np.float64)
    if valid is not None:
        numbers[_bits(valid)[here] == 0] = np.nan
    return numbers


def _bits(buffer: pa.Buffer) -> npt.NDArray[np.uint8]:
    """Arrow's bits, the lowest first."""
    return np.unpackbits(np.frombuffer(buffer, np.uint8), bitorder="little")
