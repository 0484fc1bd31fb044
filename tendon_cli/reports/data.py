"""What a page carries: axes, quantities and tables as numbers that its scripts unpack, and what was thinned."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.cube.axes import Ints, thinned
from tendon_cli.cube.columns import Values
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import Shown
from tendon_cli.space.axis import Axis
from tendon_cli.units import UNITS

MOST_CELLS = 700_000
MOST_BYTES = 2_300_000
"""Of all maps together, so that a page stays under 5 MB with its library and its states."""


def page_data(**given: Any) -> dict[str, Any]:
    """What the scripts of a page are given: every name there is, whether the page has it or not."""
    lists: dict[str, Any] = {name: [] for name in ("axes", "quantities", "arms")}
    nothing = dict.fromkeys(("states", "table", "design", "people", "between", "start")) | {"angle": "elbow angle"}
    units = {symbol: [unit.dimension, float(unit.factor)] for symbol, unit in UNITS.items()}
    return {**lists, **nothing, "units": units, **given}


@dataclass(frozen=True, eq=False)
class PageAxis:
    """An axis of the maps, and which of its positions the page keeps."""

    axis: Axis
    shown: Shown
    kept: Ints

    def record(self) -> dict[str, Any]:
        """As the page has it."""
        values = self.axis.values[self.kept]
        about = _about(self.shown) | {"key": self.axis.key}
        if self.axis.is_text or not np.isfinite(values).all():
            names = [str(value) if self.axis.is_text else self.shown.text(float(value)) for value in values]
            return {**about, "values": None, "names": names, "is_log": False}
        numbers = [float(f"{value:.10g}") for value in self.shown.scaled(values)]
        return {**about, "values": numbers, "names": None, "is_log": self.axis.is_log}


def page_axes(cube: Cube) -> list[PageAxis]:
    """The axes of a table, so many values of each that a page can hold them."""
    kept = thinned([axis.length for axis in cube.axes], MOST_CELLS)
    return [PageAxis(axis, cube.shown(axis.column), at) for axis, at in zip(cube.axes, kept, strict=True)]


def thinning_text(axes: Iterable[PageAxis], left_out: Sequence[str]) -> list[str]:
    """What the page does not hold of the run."""
    kept = [
        f"{len(each.kept)} of {each.axis.length} values of {each.shown.name}"
        for each in axes
        if len(each.kept) < each.axis.length
    ]
    parts = [f"it holds {', '.join(kept)}"] if kept else []
    parts += [f"it leaves out {', '.join(left_out)}"] if left_out else []
    return [f"This page is kept small: {'; '.join(parts)}. The tables have everything."] if parts else []


def within_size(records: Iterable[dict[str, Any]]) -> tuple[list[dict[str, Any]], list[str]]:
    """Columns in the order of their use, as many as MOST_BYTES hold; and what the others are called."""
    kept, left_out, budget = [], [], MOST_BYTES
    for record in records:
        size = len(record["array"]["data"])
        if size > budget:
            left_out.append(record["label"])
            continue
        budget -= size
        kept.append(record)
    return kept, left_out


def number_record(shown: Shown, values: Values) -> dict[str, Any]:
    """A column of numbers as the page has it, in the unit shown."""
    scaled = shown.scaled(values)
    finite = scaled[np.isfinite(scaled)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    return {**_about(shown), "classes": None, "low": low, "high": high, "array": packed(scaled)}


def truths_record(columns: Mapping[str, Values]) -> list[dict[str, Any]]:
    """Columns that are true or false, to be filtered by."""
    return [
        {"name": name, "label": name.replace("_", " "), "unit": "", "truth": True, "hidden": True,
         "array": packed_classes(values)}
        for name, values in columns.items()
    ]  # fmt: skip


def _about(shown: Shown) -> dict[str, Any]:
    """What a column is called, and the unit that its numbers are in."""
    unit = "" if shown.unit == "1" else shown.unit
    dimension = shown.quantity.dimension
    return {"name": shown.column, "label": shown.name, "unit": unit, "dimension": dimension, "factor": shown.factor}


# --- Packing ---------------------------------------------------------------------------------------------------------


FEW = 50_000
"""Up to so many numbers keep seven digits."""
_NONE = 65535


def packed(values: npt.ArrayLike) -> dict[str, Any]:
    """A text that the page unpacks to the same numbers, flat; null where not finite."""
    array = np.asarray(values, dtype=np.float64).ravel()
    finite = np.isfinite(array)
    if array.size <= FEW or not finite.any():
        return {"type": "f4", "data": _text(np.where(finite, array, np.nan).astype("<f4"))}
    low, high = float(array[finite].min()), float(array[finite].max())
    step = (high - low) / (_NONE - 1) or 1.0
    steps = np.where(finite, np.rint((np.where(finite, array, low) - low) / step), _NONE)
    return {"type": "u2", "low": low, "step": step, "data": _text(steps.astype("<u2"))}


def packed_classes(values: npt.ArrayLike) -> dict[str, Any]:
    """Small whole numbers."""
    return {"type": "u1", "data": _text(np.asarray(values, dtype=np.uint8).ravel())}


def _text(array: npt.NDArray[Any]) -> str:
    return base64.b64encode(zlib.compress(array.tobytes(), 6)).decode("ascii")
