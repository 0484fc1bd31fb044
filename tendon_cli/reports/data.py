"""What a page carries: axes, quantities, tables and states as numbers that its scripts unpack, and what was thinned."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.cube.axes import Ints, evenly, thinned
from tendon_cli.cube.columns import Values
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import Shown
from tendon_cli.model.actuator import State, evaluate
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Anchors, Array
from tendon_cli.quantities import QUANTITIES
from tendon_cli.space.axis import Axis
from tendon_cli.studies.study import Study
from tendon_cli.units import UNITS

MOST_CELLS = 700_000
MOST_BYTES = 2_300_000
"""Of all maps together, so that a page stays under 5 MB with its library and its states."""


def page_data(**given: Any) -> dict[str, Any]:
    """What the scripts of a page are given: every name there is, whether the page has it or not."""
    lists: dict[str, Any] = {name: [] for name in ("axes", "quantities", "arms")}
    nothing = dict.fromkeys(("states", "table", "design", "people", "between", "start")) | {
        "angle": "elbow angle"
    }
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
            names = [
                str(value) if self.axis.is_text else self.shown.text(float(value))
                for value in values
            ]
            return {**about, "values": None, "names": names, "is_log": False}
        numbers = [float(f"{value:.10g}") for value in self.shown.scaled(values)]
        return {**about, "values": numbers, "names": None, "is_log": self.axis.is_log}


def page_axes(cube: Cube) -> list[PageAxis]:
    """The axes of a table, so many values of each that a page can hold them."""
    kept = thinned([axis.length for axis in cube.axes], MOST_CELLS)
    return [
        PageAxis(axis, cube.shown(axis.column), at)
        for axis, at in zip(cube.axes, kept, strict=True)
    ]


def thinning_text(axes: Iterable[PageAxis], left_out: Sequence[str]) -> list[str]:
    """What the page does not hold of the run."""
    kept = [
        f"{len(each.kept)} of {each.axis.length} values of {each.shown.name}"
        for each in axes
        if len(each.kept) < each.axis.length
    ]
    parts = [f"it holds {', '.join(kept)}"] if kept else []
    parts += [f"it leaves out {', '.join(left_out)}"] if left_out else []
    return (
        [f"This page is kept small: {'; '.join(parts)}. The tables have everything."]
        if parts
        else []
    )


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
        {
            "name": name,
            "label": name.replace("_", " "),
            "unit": "",
            "truth": True,
            "hidden": True,
            "array": packed_classes(values),
        }
        for name, values in columns.items()
    ]


def _about(shown: Shown) -> dict[str, Any]:
    """What a column is called, and the unit that its numbers are in."""
    unit = "" if shown.unit == "1" else shown.unit
    dimension = shown.quantity.dimension
    return {
        "name": shown.column,
        "label": shown.name,
        "unit": unit,
        "dimension": dimension,
        "factor": shown.factor,
    }


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


# --- States of some designs as curves over the elbow angle, and their arms, by the model alone -----------------------


MOST_ANGLES = 61
MOST_DESIGNS = 400
"""Whose states the page keeps: about 3 kB each."""

GROUPS = {
    "tension at the elbow": ("flexor_tension_distal", "extensor_tension_distal"),
    "tension at the motor": ("flexor_tension_proximal", "extensor_tension_proximal"),
    "torque": ("elbow_torque", "motor_torque"),
    "elbow stiffness": ("elbow_stiffness",),
    "slack length": ("flexor_slack", "extensor_slack"),
    "spool angle": ("spool_angle",),
    "travel": ("flexor_travel", "extensor_travel"),
}
OF_TAUT = ("tension at the elbow", "torque", "elbow stiffness", "travel")
"""Those that say something of states without slack; the travels are shown of a joint that has no anchors to draw."""
_ANCHORS = ("a1", "b1", "a2", "b2", "elbow_radius")
_ARM = (*_ANCHORS, "load_distance")

Curves = dict[str, Array]
"""Columns of states, (designs, directions, angles), and measures of the arm, (designs,)."""


def angles_of(study: Study) -> Array:
    """The elbow angles that a page keeps, (1, K)."""
    angles = study.angles
    if study.trajectory is not None:  # curves over the angle stand still
        angles = np.linspace(angles.min(), angles.max(), MOST_ANGLES)
    return np.asarray(angles[evenly(len(angles), MOST_ANGLES)]).reshape(1, -1)


def curves(
    study: Study, design: Design, shape: tuple[int, ...], labels: Iterable[str] = GROUPS
) -> Curves:
    """Of designs, whose axes have a shape, the curves of some groups."""
    flexion = np.array([[direction == "flexion"] for direction in study.motion.direction])
    angles = angles_of(study)
    columns = State.columns(evaluate(design, angles, flexion))
    states = (*shape, flexion.size, angles.size)
    is_drawn = isinstance(design.arm.joint, Anchors)
    wanted = [
        column
        for label in labels
        if not (is_drawn and label == "travel")
        for column in GROUPS[label]
    ]
    result = {
        name: np.broadcast_to(columns[name], states).reshape(-1, *states[-2:]) for name in wanted
    }
    joint = design.arm.joint
    measures = {name: getattr(joint, name) for name in _ANCHORS} if is_drawn else {}
    measures["load_distance"] = design.arm.load_distance
    return result | {
        name: np.broadcast_to(value, (*shape, 1, 1)).ravel() for name, value in measures.items()
    }


def rows_with_states(cube: Cube, axes: Sequence[PageAxis], most: int) -> tuple[list[Ints], Ints]:
    """Positions on a page's axes, of `most` rows together, whose states it shows, and these rows."""
    kept = thinned([len(axis.kept) for axis in axes], most)
    places = {each.axis.column: each.kept[at] for each, at in zip(axes, kept, strict=True)}
    return kept, cube.rows(list(places), places).ravel()


def states_record(
    study: Study, kept: Sequence[npt.NDArray[np.int64]], of_conditions: Sequence[tuple[str, Curves]]
) -> tuple[dict[str, Any], list[dict[str, list[float]]]]:
    """Curves and arms as the page has them, of each condition by what it is called; `kept` on the page's axes."""
    record = {
        "kept": [[int(index) for index in each] for each in kept],
        "angles": [round(float(angle), 6) for angle in np.rad2deg(angles_of(study).ravel())],
        "directions": list(study.motion.direction),
        "groups": [group for at, each in enumerate(of_conditions) for group in _groups(at, *each)],
    }
    arms = [
        {name: _short(result[name]) for name in _ARM if name in result}
        for _, result in of_conditions
    ]
    return record, arms


def _groups(arm: int, condition: str, result: Curves) -> Iterable[dict[str, Any]]:
    for label, columns in GROUPS.items():
        lines: list[dict[str, Any]] = []
        for column in columns if columns[0] in result else ():
            shown = Shown.of(column, QUANTITIES[column])
            colour = next((side for side in ("flexor", "extensor") if side in column), "motor")
            lines.append(
                {
                    "label": shown.name,
                    "colour": colour,
                    "array": packed(shown.scaled(result[column])),
                }
            )
        if not lines:
            continue
        lines[0]["colour"] = "joint" if label == "torque" else lines[0]["colour"]
        unit = Shown.of(columns[0], QUANTITIES[columns[0]]).unit
        text = f"{label}, {condition}" if condition else label
        yield {
            "label": text,
            "condition": condition,
            "arm": arm,
            "unit": "" if unit == "1" else unit,
            "lines": lines,
        }


def _short(values: Array) -> list[float]:
    """A measure of each design, or once where it is the same for all."""
    rounded = [float(f"{value:.6g}") for value in values.tolist()]
    return rounded[:1] if len(set(rounded)) == 1 else rounded
