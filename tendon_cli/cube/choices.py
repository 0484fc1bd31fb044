"""The choices of an answer by the axes of their grid."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from tendon_cli import say
from tendon_cli.cube.axes import Ints
from tendon_cli.cube.columns import Columns, Values
from tendon_cli.cube.cube import Cube, foreign
from tendon_cli.space.axis import Axis
from tendon_cli.studies.study import keys
from tendon_cli.tables.read import TableFiles, as_numpy


def choices_of(table: TableFiles) -> Cube:
    """The choices of an answer by the axes of their grid; raises InputError for another table."""
    try:
        held, record = Columns.of(table.schema), table.facts["study"]
        names = list(held.held)[: list(held.held).index("refined")]
        grid = table.read([*names, "refined"])
        grid = grid.filter(pc.invert(grid["refined"]))
        axes: list[Axis] = []
        for name in names:
            values = list(dict.fromkeys(as_numpy(grid[name]).tolist()))
            key = next((key.path for key in keys().values() if key.column == name), name)
            is_text = held.held[name] is None
            axes.append(Axis(key, name, {} if is_text else {key: np.array(values)}, tuple(values) if is_text else ()))
        if math.prod(axis.length for axis in axes) != grid.num_rows:
            raise foreign(table)
        return Cube("choices", tuple(axes), held, record["study"], str(table.facts["study_hash"]), table)
    except (LookupError, TypeError, ValueError, AttributeError, pa.ArrowException):
        raise foreign(table) from None


def position(axis: Axis, value: Any) -> Ints:
    """The position of a value on an axis, or of the nearest, as an array of one."""
    same = np.array(axis.values == value)
    apart = ~same if axis.is_text else np.where(same, 0.0, np.abs(axis.values - (0.0 if same.any() else value)))
    apart = np.where(same, -1.0, apart)
    return np.array([int(np.argmin(apart))], dtype=np.int64)


def value_text(cube: Cube, axis: Axis, value: Any) -> str:
    """One value of an axis, as titles have it."""
    return str(value) if axis.is_text else cube.shown(axis.column).equation(float(value))


def bounds_of(cube: Cube) -> dict[str, float]:
    """The limits of the study of a table, SI."""
    return {key: cube.limit(key) for key in cube.study.get("limits", {})}


def conflicts_of(read: Mapping[str, Values], bounds: Mapping[str, float]) -> Values:
    """Why each of some choices has no window, in words; empty if it has one. `read` has both ends and what they are of.

    An end that nothing bounds is not a number, as in the table.
    """
    low, high = read["pretension_from"], read["pretension_to"]
    texts = np.full(low.shape, "", dtype=object)
    has_window = (low <= high) | (np.isnan(high) & ~np.isnan(low))
    for at in np.argwhere(~has_window):
        place = tuple(at)
        limits = list(dict.fromkeys(str(read[name][place]) for name in ("from_by", "to_by") if read[name][place]))
        limits = limits if np.isfinite(low[place]) else limits[:1]
        texts[place] = say.conflict_label(limits, bounds) if limits else "no window"
    return texts


def lines_texts(between: Mapping[str, Any], pretension: float) -> tuple[str, str]:
    """What the lines over the angle stand for, that each limit of the choice named first has, and what is proved."""
    proof = ": ".join(str(between[name]) for name in ("status", "scope") if between.get(name))
    stand = "Each line is the worst of all conditions and both directions."
    if not between["curves"]["all_conditions"]:
        served = f"that {say.quantity('pretension', pretension)} serves"
        stand = f"Each line is the worst of the conditions {served}; at the ends of the window others are served."
    return stand, f"{proof}." if proof else ""
