"""A run as an xarray dataset: the axes of the study are its dimensions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import UsageError
from tendon_cli.study.load import recorded_study
from tendon_cli.sweep.columns import Tables
from tendon_cli.sweep.inputs import Inputs
from tendon_cli.sweep.plan import Plan

if TYPE_CHECKING:
    import pyarrow as pa
    import xarray as xr

Variable = tuple[tuple[str, ...], npt.NDArray[Any], dict[str, str]]
"""Dimensions, values and attributes, as xarray takes them."""


def dataset_of(record: Mapping[str, Any], table_of: Callable[[str], pa.Table]) -> xr.Dataset:
    """Both tables of a run, as far as it has them, from its record and what gives a table by its name.

    Nulls are NaN, or None in text. Raises UsageError without xarray.
    """
    try:
        import xarray as xr  # an optional extra
    except ImportError:
        hint = "pip install 'tendon-cli[xarray]'"
        raise UsageError("to_xarray needs the package xarray, which is not installed", hint=hint) from None
    plan = Plan(recorded_study(record))
    axes = {axis.column: len(axis) for axis in plan.axes}
    motion = {"direction": len(plan.directions), "elbow_angle": len(plan.elbow_angles)}
    keys = {column.name for column in Tables(Inputs(plan)).leading} | set(motion)
    keys.discard("design")
    coordinates: dict[str, Variable] = {}
    variables: dict[str, Variable] = {}
    for table, sizes in (("designs", axes), ("states", axes | motion)):
        if table not in plan.study.output.tables:
            continue
        for name, variable in _variables(table_of(table), sizes).items():
            if name in keys:
                coordinates[name] = _along_own_axes(name, variable)
            else:
                variables.setdefault(name, variable)
    facts = {name: record[name] for name in ("name", "title", "study_hash")}
    return xr.Dataset(variables, coordinates, facts)


def _variables(table: pa.Table, sizes: dict[str, int]) -> dict[str, Variable]:
    """Every column in the shape of the product; the first names stand for the axes, whose rows come in that order."""
    shape, dimensions = tuple(sizes.values()), tuple(sizes)
    if table.num_rows != math.prod(shape):
        raise UsageError(f"the table has {table.num_rows} rows, the study {math.prod(shape)}")
    frame = table.to_pandas()
    found = {}
    for field in table.schema:
        values = frame[field.name]
        array = values.astype(object).to_numpy() if values.dtype == "category" else values.to_numpy()
        meaning = {key.decode(): text.decode() for key, text in (field.metadata or {}).items()}
        attributes = {"units": meaning.get("unit", "1"), "long_name": meaning.get("long_name", field.name)}
        found[field.name] = (dimensions, array.reshape(shape), attributes)
    return found


def _along_own_axes(name: str, variable: Variable) -> Variable:
    """A coordinate along the axes that it varies with: that of an axis along itself, a constant along none."""
    dimensions, values, attributes = variable
    kept = []
    for axis, dimension in enumerate(dimensions):
        first = values.take([0], axis=axis)
        varies = dimension == name or (name not in dimensions and not _same(values, first))
        kept.append(slice(None) if varies else 0)
    own = tuple(dimension for dimension, part in zip(dimensions, kept, strict=True) if part != 0)
    return own, np.asarray(values[tuple(kept)]), attributes


def _same(values: npt.NDArray[Any], first: npt.NDArray[Any]) -> bool:
    equal = (values == first) | ((values != values) & (first != first))  # noqa: PLR0124 - NaN differs from itself
    return bool(np.all(equal))
