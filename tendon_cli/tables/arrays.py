"""Arrays as Arrow has them and back, by ways of the library that do not import pandas."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.compute as pc

from tendon_cli.tables.schema import Column


def array_of(column: Column, values: npt.NDArray[Any], *, nulls: bool | None = None) -> pa.Array:
    """Values as Arrow has them, without a copy; NaN becomes null, text positions a dictionary.

    `nulls` says whether any is NaN; None if they are to be searched for it. Built from buffers, because the library's
    conversions import pandas.
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
    numbers = pc.fill_null(column.cast(pa.float64()), _NAN).combine_chunks()
    return np.array(np.from_dlpack(numbers))


_NAN = pa.Array.from_buffers(pa.float64(), 1, [None, pa.py_buffer(np.array([np.nan]))])[0]
_NO_WORDS = np.zeros(0, dtype=object)


def _words(chunk: pa.DictionaryArray) -> npt.NDArray[Any]:
    known = np.array(["", *chunk.dictionary.to_pylist()], dtype=object)
    places = as_numpy(pa.chunked_array([chunk.indices]))
    return np.asarray(known[np.nan_to_num(places + 1.0).astype(np.int64)])
