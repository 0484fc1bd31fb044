"""What a table's columns are: names, types, units and meaning, as Arrow and pandas have them; and their values."""

from __future__ import annotations

import json
import math
import platform
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from tendon_cli.quantities import Quantity
from tendon_cli.version import __version__

Kind = Literal["number", "text", "count", "truth"]

ROW_GROUP = 2**17
"""Rows in a row group of every table."""


@dataclass(frozen=True)
class Column:
    """A column of a table. A text column holds positions in `choices`; `is_axis` marks what few values repeat in.

    A column of numbers that cannot be null in its table is not `nullable`: it is smaller, and sooner written.

    `quantity` is the name of what it holds in `quantities`; what is none goes by the column's name.
    """

    name: str
    kind: Kind
    unit: str
    long_name: str
    is_axis: bool = False
    choices: tuple[str, ...] = ()
    quantity: str = ""
    nullable: bool = True

    @classmethod
    def of(
        cls,
        quantity: Quantity,
        name: str | None = None,
        *,
        is_axis: bool = False,
        nullable: bool = True,
    ) -> Column:
        """A column of numbers of a quantity, under its name or another."""
        named = name or quantity.name
        meaning = quantity.unit, quantity.long_name
        return cls(
            named, "number", *meaning, is_axis=is_axis, quantity=quantity.name, nullable=nullable
        )

    @cached_property
    def type(self) -> pa.DataType:
        """The Arrow type; text is a dictionary, which pandas reads as a categorical."""
        if self.kind == "text":
            return pa.dictionary(pa.int8() if self.dtype == np.int8 else pa.int32(), pa.string())
        return {"number": pa.float64(), "count": pa.int64(), "truth": pa.bool_()}[self.kind]

    @cached_property
    def dtype(self) -> np.dtype[Any]:
        """What its values are collected as; text by its place in `choices`."""
        place = np.int8 if len(self.choices) < 128 else np.int32
        return np.dtype(
            {"number": np.float64, "text": place, "count": np.int64, "truth": np.bool_}[self.kind]
        )

    @cached_property
    def words(self) -> pa.StringArray:
        """Its choices as Arrow has them; built from buffers, because the library's conversions import pandas."""
        encoded = [word.encode() for word in self.choices]
        ends = np.cumsum([0, *map(len, encoded)], dtype=np.int32)
        return pa.StringArray.from_buffers(
            len(encoded), pa.py_buffer(ends), pa.py_buffer(b"".join(encoded))
        )

    @property
    def field(self) -> pa.Field:
        """The Arrow field with its unit and meaning as metadata."""
        meaning = {
            "unit": self.unit,
            "long_name": self.long_name,
            "quantity": self.quantity or self.name,
        }
        return pa.field(
            self.name, self.type, nullable=self.nullable and self.kind == "number", metadata=meaning
        )


@dataclass(frozen=True)
class TableLayout:
    """The layout of a file of a table: its columns, its schema with what it says of itself, and how many rows."""

    columns: tuple[Column, ...]
    schema: pa.Schema
    rows: int
    at_once: int = ROW_GROUP
    """How many rows are collected before they are written: a multiple of `row_group`."""
    row_group: int = ROW_GROUP


def schema_of(columns: Sequence[Column], facts: Mapping[str, Any]) -> pa.Schema:
    """The Arrow schema of a table; each fact becomes a JSON text under `tendon.<name>` in the file's metadata.

    The key that pandas keeps its attributes under is set too, so that `DataFrame.attrs["units"]` has the units.
    """
    attributes = {
        "units": {column.name: column.unit for column in columns},
        "long_names": {column.name: column.long_name for column in columns},
        "study_hash": facts.get("study_hash"),
    }
    metadata = {f"tendon.{name}": json.dumps(fact, sort_keys=True) for name, fact in facts.items()}
    metadata["PANDAS_ATTRS"] = json.dumps(attributes, sort_keys=True)
    return pa.schema([column.field for column in columns], metadata=metadata)


def versions() -> dict[str, str]:
    """The versions that the bytes of a table may depend on."""
    return {
        "tendon": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "pyarrow": pa.__version__,
    }


# --- Values ----------------------------------------------------------------------------------------------------------


def array_of(column: Column, values: npt.NDArray[Any], *, nulls: bool | None = None) -> pa.Array:
    """Values as Arrow has them, without a copy; NaN becomes null, text positions a dictionary.

    `nulls` says whether any is NaN; None if they are to be searched for it. The library's conversions import pandas.
    """
    if column.kind == "text":
        positions = _from_buffers(column.type.index_type, values)
        return pa.DictionaryArray.from_arrays(positions, column.words, safe=False)
    nulls = _has_nan(values) if nulls is None else nulls
    if nulls and not column.nullable:
        raise RuntimeError(f"{column.name} has a value that is not a number, and cannot be null")
    return _from_buffers(column.type, values, nulls=nulls)


def _from_buffers(kind: pa.DataType, values: npt.NDArray[Any], *, nulls: bool = False) -> pa.Array:
    valid = pa.py_buffer(np.packbits(~np.isnan(values), bitorder="little")) if nulls else None
    data = np.packbits(values, bitorder="little") if kind == pa.bool_() else values
    return pa.Array.from_buffers(kind, len(values), [valid, pa.py_buffer(data)])


def _has_nan(values: npt.NDArray[Any]) -> bool:
    """Whether any is NaN: then the smallest is, which one thread finds soonest.

    A sum of squares by BLAS starts threads, whose waiting took half of a sweep's processor time.
    """
    return values.dtype.kind == "f" and math.isnan(values.min(initial=math.inf))


def arrays_of(columns: Sequence[Column], table: pa.Table) -> dict[str, npt.NDArray[Any]]:
    """Columns as they are written from: NaN for null, text by its place among the column's choices."""
    arrays = {}
    for column in columns:
        values = as_numpy(table[column.name])
        if column.kind == "text":
            places = {word: place for place, word in enumerate(column.choices)}
            values = np.array([places[word] for word in values])
        arrays[column.name] = values.astype(column.dtype)
    return arrays


def as_numpy(column: pa.ChunkedArray) -> npt.NDArray[Any]:
    """Numbers and truths with NaN for null, words with ""; by ways of pyarrow that do not import pandas."""
    if pa.types.is_string(column.type):
        return np.array([word or "" for word in column.to_pylist()], dtype=object)
    if pa.types.is_dictionary(column.type):
        return np.concatenate([_NO_WORDS, *map(_words, column.chunks)])
    numbers = (
        column if column.type == pa.float64() else column.cast(pa.float64())
    )  # which imports a library, 50 ms
    return np.array(
        np.from_dlpack((numbers.fill_null(_NAN) if column.null_count else numbers).combine_chunks())
    )


_NAN = pa.Array.from_buffers(pa.float64(), 1, [None, pa.py_buffer(np.array([np.nan]))])[0]
_NO_WORDS = np.zeros(0, dtype=object)


def _words(chunk: pa.DictionaryArray) -> npt.NDArray[Any]:
    known = np.array(["", *chunk.dictionary.to_pylist()], dtype=object)
    places = as_numpy(pa.chunked_array([chunk.indices]))
    return np.asarray(known[np.nan_to_num(places + 1.0).astype(np.int64)])
