"""Call the compiled code of `native.c` and `entry.h` with checked arrays.

A call runs without Python's lock. The shape of a call is that of its states: the axes of designs,
direction and elbow angle. Inputs broadcast to it; results have the shape of the designs. ValueError
and KeyError say what does not fit.
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
    """`Walk` of `arrays.h`."""

    _fields_ = (("axes", c_long), ("length", c_long * _MOST_AXES), ("index", c_long * _MOST_AXES))


class _RowsCall(Structure):
    """`RowsCall` of `arrays.h`."""

    _fields_ = (
        ("walk", _Walk),
        ("arrays", c_void_p),
        ("column", c_void_p),
        ("has_nan", c_void_p),
        ("status", c_void_p),
        ("key", c_void_p),
        ("keys", c_long),
        ("first", c_long),
        ("count", c_long),
    )


class _ExtremesCall(Structure):
    """`ExtremesCall` of `arrays.h`."""

    _fields_ = (("walk", _Walk), ("arrays", c_void_p), ("angle", c_void_p))


class _WindowCall(Structure):
    """`WindowCall` of `arrays.h`."""

    _fields_ = (
        ("walk", _Walk),
        ("arrays", c_void_p),
        ("forms", c_long),
        ("first", c_long),
        ("total", c_long),
    )


class Native:
    """Compiled code of a library file.

    Args:
        path: The library.

    Raises:
        OSError: The file is not a library.
        ValueError: The library is not the kernel's, or was compiled for another number of axes.
    """

    def __init__(self, path: str) -> None:
        self._library = CDLL(path)
        self.version = self._number("version")
        self.most_forms = self._number("most_forms")
        if self._number("most_axes") != _MOST_AXES:
            raise ValueError("compiled for another number of axes")
        self.results = self._names("results")
        self._given = self._names("given")
        self._extremes = self._names("extremes")
        self._bounds = self._names("bounds")
        self._form = self._names("form")
        self._window = self._names("window")
        self._library.tendon_kinds.restype = c_char_p
        self.kinds: tuple[str, ...] = tuple(self._library.tendon_kinds().decode().split())
        """Kinds of code that this processor can run, the fastest last."""
        self.kind = self.kinds[-1]
        """The kind that is called."""

    def rows(
        self,
        shape: Shape,
        given: Columns,
        keys: Columns,
        columns: Columns,
        first: int,
        count: int,
    ) -> list[str]:
        """Write some rows of the states table into columns.

        Args:
            shape: Lengths of the designs' axes, directions and angles. In rows the last axis is
                fastest.
            given: Inputs of the states, by the names of GIVEN in `arrays.h`.
            keys: Columns that are copied, by name; they broadcast to the shape.
            columns: Arrays of `count` values to write, by name: results, `status` and keys. Other
                names are left alone.
            first: Number of the first row.
            count: Number of rows.

        Returns:
            Names of the results that have NaN in these rows.
        """
        walk = _walk(shape)
        sources = _input_places(given, self._given, shape)
        sources += [_place(values, name, shape, values.dtype) for name, values in keys.items()]
        if first < 0 or not 0 <= count <= math.prod(shape) - first:
            raise ValueError(f"rows {first} to {first + count} are not among the states")

        types: dict[str, np.dtype[Any]] = dict.fromkeys(self.results, np.dtype(np.float64))
        types["status"] = np.dtype(np.int8)
        types |= {name: values.dtype for name, values in keys.items()}
        targets = {
            name: _place(values, name, (count,), types[name], written=True)[0]
            for name, values in columns.items()
            if name in types
        }
        arrays = _table(sources)
        has_nan = np.zeros(len(self.results), np.int32)
        column = np.array([targets.get(name, 0) for name in self.results])
        key = np.array([(targets[name], values.itemsize) for name, values in keys.items()])
        call = _RowsCall(
            walk=walk,
            arrays=arrays.ctypes.data,
            column=column.ctypes.data,
            has_nan=has_nan.ctypes.data,
            status=targets.get("status", 0),
            key=key.ctypes.data,
            keys=len(keys),
            first=first,
            count=count,
        )
        self._run("rows", call)
        return [name for name, is_null in zip(self.results, has_nan, strict=True) if is_null]

    def extremes(
        self, shape: Shape, given: Columns, angle: npt.NDArray[Any], folded: Columns
    ) -> None:
        """Fold all states into extremes of designs.

        Args:
            shape: Lengths of the designs' axes, directions and angles.
            given: Inputs of the states, by the names of GIVEN in `arrays.h`.
            angle: Elbow angles of the states, rad.
            folded: Extremes over the designs' axes, by the names of EXTREMES; changed in place.
        """
        inputs = _input_places(given, self._given, shape)
        arrays = _table([*inputs, *_result_places(folded, self._extremes, shape)])
        angles = _table([_place(angle, "angle", shape)])
        call = _ExtremesCall(walk=_walk(shape), arrays=arrays.ctypes.data, angle=angles.ctypes.data)
        self._run("extremes", call)

    def window(
        self,
        shape: Shape,
        given: Columns,
        bounds: Columns,
        forms: Sequence[Columns],
        folded: Columns,
        first: int,
        total: int,
    ) -> None:
        """Fold all states into windows of designs.

        Args:
            shape: Lengths of the designs' axes, directions and angles.
            given: Inputs of the states, by the names of GIVEN in `arrays.h`.
            bounds: Bounds on tensions and stiffness, by the names of BOUNDS.
            forms: Forms with their bounds, by the names of FORM, at most `most_forms`.
            folded: Ends over the designs' axes, by the names of WINDOW; changed in place.
            first: Number of the first of these elbow angles in each direction.
            total: Number of all elbow angles in each direction.
        """
        if len(forms) > self.most_forms:
            raise ValueError(f"{len(forms)} forms, expected at most {self.most_forms}")
        places = _input_places(given, self._given, shape)
        places += _input_places(bounds, self._bounds, shape)
        for form in forms:
            places += _input_places(form, self._form, shape)
        places += _result_places(folded, self._window, shape)
        arrays = _table(places)
        call = _WindowCall(
            walk=_walk(shape),
            arrays=arrays.ctypes.data,
            forms=len(forms),
            first=first,
            total=total,
        )
        self._run("window", call)

    def _run(self, name: str, call: Structure) -> None:
        """Call the function of a name that was compiled for this kind of processor."""
        function = self._library[f"tendon_{self.kind}_{name}"]
        function.restype = None
        function(byref(call))

    def _number(self, name: str) -> int:
        """Return a number that the library exports."""
        return c_long.in_dll(self._library, f"tendon_{name}").value

    def _names(self, name: str) -> tuple[str, ...]:
        """Return a list of names that the library exports."""
        text = c_char_p.in_dll(self._library, f"tendon_{name}").value or b""
        return tuple(text.decode().split())


def _walk(shape: Shape) -> _Walk:
    """Return a walk at the first line of a shape."""
    if not 2 <= len(shape) <= _MOST_AXES:
        raise ValueError(f"states have {len(shape)} axes, expected 2 to {_MOST_AXES}")
    if min(shape) < 1:
        raise ValueError("an axis is empty")
    return _Walk(len(shape), (c_long * _MOST_AXES)(*shape))


def _input_places(arrays: Columns, names: Sequence[str], shape: Shape) -> list[list[int]]:
    """Return the places of inputs, which broadcast to the shape of states."""
    return [_place(arrays[name], name, shape) for name in names]


def _result_places(arrays: Columns, names: Sequence[str], shape: Shape) -> list[list[int]]:
    """Return the places of results, which have the shape of designs."""
    return [_place(arrays[name], name, shape[:-2], written=True) for name in names]


def _place(
    values: npt.NDArray[Any],
    name: str,
    shape: Shape,
    dtype: npt.DTypeLike = np.float64,
    *,
    written: bool = False,
) -> list[int]:
    """Return the address of an array and its steps along the axes of a shape.

    Args:
        values: The array. Its last axis is contiguous.
        name: Its name in messages.
        shape: Shape to which it broadcasts, or which it has if it is written.
        dtype: Type that it must have.
        written: True if the compiled code writes it.

    Returns:
        The address, then a step for each axis in bytes, 0 where the array is broadcast.

    Raises:
        ValueError: The array has another type or shape.
    """
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
            own in (1, length) for own, length in zip(values.shape, shape[missing:], strict=True)
        )
    is_contiguous = steps[-1:] in ([], [0], [values.itemsize])
    if not fits or not is_contiguous:
        raise ValueError(
            f"{name} has the shape {values.shape}, expected {shape}, contiguous along the last axis"
        )
    return [values.__array_interface__["data"][0], *[0] * missing, *steps]


def _table(places: Sequence[Sequence[int]]) -> npt.NDArray[np.int64]:
    """Return places of several arrays as `Array` of `arrays.h`, with room for all possible axes."""
    table = np.zeros((len(places), 1 + _MOST_AXES), np.int64)
    for row, place in zip(table, places, strict=True):
        row[: len(place)] = place
    return table
