"""The compiled code of `native.c` and `entry.h`: its structures, filled with checked arrays, and its calls.

A call goes on without Python's lock. Its shape is that of states: the designs' axes, direction and elbow angle; inputs
broadcast to it, results have that of designs. ValueError and KeyError say what does not fit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from ctypes import CDLL, Structure, byref, c_char_p, c_long, c_void_p
from typing import Any

import numpy as np
import numpy.typing as npt

Columns = Mapping[str, npt.NDArray[Any]]
Shape = tuple[int, ...]

_MOST_AXES = 64


class _Walk(Structure):
    _fields_ = (("axes", c_long), ("length", c_long * _MOST_AXES), ("index", c_long * _MOST_AXES))


class _Rows(Structure):
    _fields_ = (
        ("walk", _Walk),
        ("arrays", c_void_p),
        ("column", c_void_p),
        ("no_number", c_void_p),
        ("status", c_void_p),
        ("key", c_void_p),
        ("keys", c_long),
        ("first", c_long),
        ("count", c_long),
    )


class _Extremes(Structure):
    _fields_ = (("walk", _Walk), ("arrays", c_void_p), ("angle", c_void_p))


class _Window(Structure):
    _fields_ = (
        ("walk", _Walk),
        ("arrays", c_void_p),
        ("forms", c_long),
        ("first", c_long),
        ("total", c_long),
    )


class Native:
    """The compiled code in a file; raises OSError or ValueError if that is none of ours."""

    def __init__(self, path: str) -> None:
        self._library = CDLL(path)
        self.version, self.most_forms = self._number("version"), self._number("most_forms")
        if self._number("most_axes") != _MOST_AXES:
            raise ValueError("compiled for another number of axes")
        self.results = self._names("results")
        self._given, self._extremes, self._bounds, self._form, self._window = (
            self._names(name) for name in ("given", "extremes", "bounds", "form", "window")
        )
        self._library.tendon_kinds.restype = c_char_p
        self.kinds: tuple[str, ...] = tuple(self._library.tendon_kinds().decode().split())
        """The kinds of code that this processor can run, the fastest last."""

    def rows(
        self,
        kind: str,
        shape: Shape,
        given: Columns,
        keys: Columns,
        columns: Columns,
        first: int,
        count: int,
    ) -> list[str]:
        """Write some rows into columns of that many; returns the names of results that are not everywhere a number."""
        walk, inputs = _walk(shape), _inputs(given, self._given, shape)
        inputs += [_place(values, name, shape, values.dtype) for name, values in keys.items()]
        if first < 0 or not 0 <= count <= math.prod(shape) - first:
            raise ValueError("there are no such rows")
        types = dict.fromkeys(self.results, np.dtype(np.float64)) | {"status": np.dtype(np.int8)}
        types |= {name: values.dtype for name, values in keys.items()}
        known = {name: values for name, values in columns.items() if name in types}
        to = {
            name: _place(each, name, (count,), types[name], written=True)[0]
            for name, each in known.items()
        }
        arrays, no_number = _table(inputs), np.zeros(len(self.results), np.int32)
        column = np.array([to.get(name, 0) for name in self.results])
        key = np.array([(to[name], values.itemsize) for name, values in keys.items()])
        what = _Rows(
            walk,
            arrays.ctypes.data,
            column.ctypes.data,
            no_number.ctypes.data,
            to.get("status", 0),
            key.ctypes.data,
            len(keys),
            first,
            count,
        )
        self._call(kind, "rows", what)
        return [name for name, is_so in zip(self.results, no_number, strict=True) if is_so]

    def extremes(
        self, kind: str, shape: Shape, given: Columns, angle: npt.NDArray[Any], found: Columns
    ) -> None:
        """Fold all states into the arrays of `found`."""
        arrays = _table(
            [*_inputs(given, self._given, shape), *_results(found, self._extremes, shape)]
        )
        angles = _table([_place(angle, "angle", shape)])
        self._call(
            kind, "extremes", _Extremes(_walk(shape), arrays.ctypes.data, angles.ctypes.data)
        )

    def window(
        self,
        kind: str,
        shape: Shape,
        given: Columns,
        bounds: Columns,
        forms: Sequence[Columns],
        found: Columns,
        first: int,
        total: int,
    ) -> None:
        """Fold all states into the arrays of `found`; the angles are those from `first` on of `total`."""
        if len(forms) > self.most_forms:
            raise ValueError("more forms than there is room for")
        inputs = [*_inputs(given, self._given, shape), *_inputs(bounds, self._bounds, shape)]
        inputs += [place for form in forms for place in _inputs(form, self._form, shape)]
        arrays = _table([*inputs, *_results(found, self._window, shape)])
        self._call(
            kind, "window", _Window(_walk(shape), arrays.ctypes.data, len(forms), first, total)
        )

    def _call(self, kind: str, name: str, what: Structure) -> None:
        if kind not in self.kinds:
            raise ValueError(f"this processor has no code named {kind}")
        function = self._library[f"tendon_{kind}_{name}"]
        function.restype = None
        function(byref(what))

    def _number(self, name: str) -> int:
        return c_long.in_dll(self._library, f"tendon_{name}").value

    def _names(self, name: str) -> tuple[str, ...]:
        return tuple(
            (c_char_p.in_dll(self._library, f"tendon_{name}").value or b"").decode().split()
        )


def _walk(shape: Shape) -> _Walk:
    if not 2 <= len(shape) <= _MOST_AXES:
        raise ValueError(f"states have {len(shape)} axes, expected 2 to {_MOST_AXES}")
    if min(shape) < 1:
        raise ValueError("an axis is empty")
    return _Walk(len(shape), (c_long * _MOST_AXES)(*shape))


def _inputs(arrays: Columns, names: Sequence[str], shape: Shape) -> list[list[int]]:
    return [_place(arrays[name], name, shape) for name in names]


def _results(arrays: Columns, names: Sequence[str], shape: Shape) -> list[list[int]]:
    return [_place(arrays[name], name, shape[:-2], written=True) for name in names]


def _place(
    values: npt.NDArray[Any],
    name: str,
    shape: Shape,
    dtype: npt.DTypeLike = np.float64,
    *,
    written: bool = False,
) -> list[int]:
    """Where an array begins, and its steps in bytes along the axes of a shape: none where it is broadcast."""
    if values.dtype != dtype:
        raise ValueError(f"{name} has values of {values.dtype}, expected {np.dtype(dtype)}")
    missing = len(shape) - values.ndim
    steps = [
        step if length > 1 else 0 for step, length in zip(values.strides, values.shape, strict=True)
    ]
    if written:
        fits = values.shape == shape and values.flags.writeable
    else:
        fits = missing >= 0 and all(
            each in (1, length) for each, length in zip(values.shape, shape[missing:], strict=True)
        )
    if not fits or steps[-1:] not in ([], [0], [values.itemsize]):
        raise ValueError(
            f"{name} has the shape {values.shape}, expected {shape}, the last axis side by side"
        )
    return [values.__array_interface__["data"][0], *[0] * missing, *steps]


def _table(places: Sequence[Sequence[int]]) -> npt.NDArray[np.int64]:
    """The same for several arrays, with room for all axes that there may be."""
    table = np.zeros((len(places), 1 + _MOST_AXES), np.int64)
    for row, place in zip(table, places, strict=True):
        row[: len(place)] = place
    return table
