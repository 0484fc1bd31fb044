"""Columns of tables and their values: names, types, units and meaning for Arrow and pandas."""

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
    """A column of a table."""

    name: str
    kind: Kind
    unit: str
    long_name: str
    is_axis: bool = False
    """True if the column repeats a few values."""
    choices: tuple[str, ...] = ()
    """Words of a text column, which holds positions in them."""
    quantity: str = ""
    """Name in `quantities`, by default that of the column."""
    nullable: bool = True
    """False if a column of numbers is never null: its table is smaller and faster to write."""

    @classmethod
    def of(
        cls,
        quantity: Quantity,
        name: str | None = None,
        *,
        is_axis: bool = False,
        nullable: bool = True,
    ) -> Column:
        """Return a column of numbers of a quantity, under its name or another."""
        return cls(
            name=name or quantity.name,
            kind="number",
            unit=quantity.unit,
            long_name=quantity.long_name,
            is_axis=is_axis,
            quantity=quantity.name,
            nullable=nullable,
        )

    @cached_property
    def type(self) -> pa.DataType:
        """Arrow type; text is a dictionary, which pandas reads as a categorical."""
        if self.kind == "text":
            index = pa.int8() if self.dtype == np.int8 else pa.int32()
            return pa.dictionary(index, pa.string())
        return {"number": pa.float64(), "count": pa.int64(), "truth": pa.bool_()}[self.kind]

    @cached_property
    def dtype(self) -> np.dtype[Any]:
        """NumPy type in which its values are collected; text by its position in `choices`."""
        position = np.int8 if len(self.choices) < 128 else np.int32
        types = {"number": np.float64, "text": position, "count": np.int64, "truth": np.bool_}
        return np.dtype(types[self.kind])

    @cached_property
    def words(self) -> pa.StringArray:
        """Arrow array of its choices."""
        # Built from buffers, because the library's conversions import pandas.
        encoded = [word.encode() for word in self.choices]
        ends = np.cumsum([0, *map(len, encoded)], dtype=np.int32)
        return pa.StringArray.from_buffers(
            len(encoded), pa.py_buffer(ends), pa.py_buffer(b"".join(encoded))
        )

    @property
    def field(self) -> pa.Field:
        """Arrow field with its unit and meaning as metadata."""
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
    """Layout of a table file."""

    columns: tuple[Column, ...]
    schema: pa.Schema
    """Arrow schema with the facts of the table."""
    rows: int
    at_once: int = ROW_GROUP
    """Number of rows that are collected before they are written: a multiple of `row_group`."""
    row_group: int = ROW_GROUP
    """Number of rows in a row group."""


def schema_of(columns: Sequence[Column], facts: Mapping[str, Any]) -> pa.Schema:
    """Return the Arrow schema of a table.

    The key that pandas keeps its attributes under is set too, so that `DataFrame.attrs["units"]`
    has the units.

    Args:
        columns: Columns of the table.
        facts: Values that JSON can hold; each becomes a text under `tendon.<name>` in the metadata
            of the file.
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
    """Return the versions on which the bytes of a table may depend."""
    return {
        "tendon": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "pyarrow": pa.__version__,
    }


# --- Values ---------------------------------------------------------------------------------------


def array_of(column: Column, values: npt.NDArray[Any], *, nulls: bool | None = None) -> pa.Array:
    """Return values as an Arrow array, without a copy; the library's conversions import pandas.

    Args:
        column: Column of the values.
        values: Numbers, in which NaN stands for null, or positions of text.
        nulls: True if any value is NaN, False if none is; None to look for NaN here.

    Raises:
        RuntimeError: A value is NaN in a column that cannot be null.
    """
    if column.kind == "text":
        positions = _from_buffers(column.type.index_type, values)
        return pa.DictionaryArray.from_arrays(positions, column.words, safe=False)
    nulls = _has_nan(values) if nulls is None else nulls
    if nulls and not column.nullable:
        raise RuntimeError(f"{column.name} has a value that is not a number, and cannot be null")
    return _from_buffers(column.type, values, nulls=nulls)


def _from_buffers(kind: pa.DataType, values: npt.NDArray[Any], *, nulls: bool = False) -> pa.Array:
    """Return an Arrow array of a type over the memory of values."""
    valid = pa.py_buffer(np.packbits(~np.isnan(values), bitorder="little")) if nulls else None
    data = np.packbits(values, bitorder="little") if kind == pa.bool_() else values
    return pa.Array.from_buffers(kind, len(values), [valid, pa.py_buffer(data)])


def finite_or_none(value: float) -> float | None:
    """Return a number as a record in JSON has it: None if it is infinite or not a number."""
    return float(value) if math.isfinite(value) else None


def _has_nan(values: npt.NDArray[Any]) -> bool:
    """Return True if any value is NaN.

    The smallest value is then NaN, too, and finding it takes one thread. A sum of squares by BLAS
    starts threads, whose waiting took half of a sweep's processor time.
    """
    return values.dtype.kind == "f" and math.isnan(values.min(initial=math.inf))


def as_numpy(column: pa.ChunkedArray) -> npt.NDArray[Any]:
    """Return a column as a NumPy array: numbers and truths with NaN for null, words with "".

    It avoids the functions of pyarrow that import pandas.
    """
    if pa.types.is_string(column.type):
        return np.array([word or "" for word in column.to_pylist()], dtype=object)
    if pa.types.is_dictionary(column.type):
        return np.concatenate([_NO_WORDS, *map(_words, column.chunks)])
    numbers = column
    if column.type != pa.float64():  # a cast imports a library, 50 ms
        numbers = column.cast(pa.float64())
    if column.null_count:
        numbers = numbers.fill_null(_NAN)
    return np.array(np.from_dlpack(numbers.combine_chunks()))


def stored_values(column: Column, stored: pa.ChunkedArray) -> npt.NDArray[Any]:
    """Return a column as `array_of` takes it: text by its position in the column's `choices`."""
    if column.kind != "text":
        return as_numpy(stored).astype(column.dtype)
    positions = {word: place for place, word in enumerate(column.choices)}
    pieces = [np.empty(0, column.dtype)]
    for chunk in stored.chunks:
        words = chunk.dictionary.to_pylist()
        of_words = np.array([positions[word] for word in words], column.dtype)
        pieces.append(of_words[as_numpy(pa.chunked_array([chunk.indices])).astype(np.int64)])
    return np.concatenate(pieces)


_NAN = pa.Array.from_buffers(pa.float64(), 1, [None, pa.py_buffer(np.array([np.nan]))])[0]
_NO_WORDS = np.zeros(0, dtype=object)


def _words(chunk: pa.DictionaryArray) -> npt.NDArray[Any]:
    """Return the words of a dictionary array, "" for null."""
    words = np.array(["", *chunk.dictionary.to_pylist()], dtype=object)
    positions = as_numpy(pa.chunked_array([chunk.indices]))
    return np.asarray(words[np.nan_to_num(positions + 1.0).astype(np.int64)])
