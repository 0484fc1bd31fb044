"""Data of a page: axes, quantities, tables and states, packed as numbers that its scripts unpack.

A page is kept small: it has only some values of long axes, and only the first of many columns.
"""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.cube.axes import axis_values, thin_axes
from tendon_cli.cube.columns import ColumnArray
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import ColumnLabel
from tendon_cli.model.actuator import State, evaluate
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Anchors, Array, Rows
from tendon_cli.model.moving import Moving
from tendon_cli.quantities import QUANTITIES, SIDES
from tendon_cli.studies.axis_words import name_words
from tendon_cli.studies.space.axis import Axis, evenly_spaced
from tendon_cli.studies.space.space import Space
from tendon_cli.studies.study import Study, keys
from tendon_cli.units import UNITS

MOST_CELLS = 700_000
"""Largest number of cells of a map."""
MOST_BYTES = 2_300_000
"""Largest size of all maps together, bytes: a page stays under 5 MB with its library and states."""
MOST_BYTES_OF_PAGE = 5_000_000
"""Largest size of a page, bytes, if fewer rows can make it so small."""
_MOST_CODES = 256
"""Most words of a column that is packed."""
MOST_BYTES_OF_GIVEN = 300_000
"""Largest size of the columns together that only filters read, bytes."""


def page_data(**given: Any) -> dict[str, Any]:
    """Return the data of a page with every name that its scripts read.

    A name that is not given is empty, and the page has no such part.
    """
    data: dict[str, Any] = {"axes": [], "quantities": [], "arms": []}
    for name in ("states", "table", "design", "people", "between", "start"):
        data[name] = None
    data["angle"] = "elbow angle"
    data["units"] = {symbol: [unit.dimension, float(unit.factor)] for symbol, unit in UNITS.items()}
    return data | given


@dataclass(frozen=True, eq=False)
class PageAxis:
    """An axis of the maps, with the positions whose values the page has."""

    axis: Axis
    shown: ColumnLabel
    positions: Rows

    def record(self) -> dict[str, Any]:
        """Return the axis as JSON; values that are not all finite numbers are given as texts.

        Filters compare with `words`, or with `numbers`, which are exact; `stated` are values that
        they may mean.
        """
        about = _about(self.shown) | {"key": self.axis.key}
        about |= {"words": None, "numbers": None, "stated": None}
        values = self.axis.values[self.positions]
        if self.axis.is_text:
            about["words"] = values.tolist()
        else:
            about["numbers"] = pack_exact(self.shown.scaled(values))
            about["stated"] = pack_exact(self.shown.scaled(self.stated))
        if self.axis.is_text:
            # The label of the axis says of what they are.
            words = (name_words(self.axis, str(value)) for value in values)
            names = [text.removeprefix(f"{self.axis.key} ") for text in words]
            return {**about, "values": None, "names": names, "is_log": False, "is_list": True}
        if not np.isfinite(values).all():
            names = [self.shown.text(float(value)) for value in values]
            return {**about, "values": None, "names": names, "is_log": False, "is_list": True}
        numbers = [float(f"{value:.10g}") for value in self.shown.scaled(values)]
        kind = {"is_log": self.axis.is_log, "is_list": not self.axis.is_range}
        return {**about, "values": numbers, "names": None, **kind}

    @property
    def stated(self) -> npt.NDArray[np.float64]:
        """Values on the page and their next smaller and larger neighbours, SI, sorted.

        A number means a value on the page by them if it means that value by the whole axis.
        """
        ascending = np.sort(self.axis.values)
        places = np.searchsorted(ascending, self.axis.values[self.positions])
        beside = places[:, np.newaxis] + np.array([-1, 0, 1])
        return np.asarray(ascending[np.unique(beside.clip(0, len(ascending) - 1))])


def page_axes(cube: Cube, most: int, kept: Mapping[str, int] | None = None) -> list[PageAxis]:
    """Return the axes of a table, thinned so that a page can hold their product.

    Args:
        cube: The table.
        most: Most rows of the product, but for what is kept.
        kept: Positions that a page has in any case, by the columns of axes.
    """
    positions = thin_axes([axis.length for axis in cube.axes], most)
    return [
        PageAxis(
            axis,
            cube.shown(axis.column),
            np.union1d(along, [(kept or {}).get(axis.column, along[0])]),
        )
        for axis, along in zip(cube.axes, positions, strict=True)
    ]


def middle_of(axes: Sequence[PageAxis], is_good: npt.NDArray[np.bool_]) -> list[int]:
    """Return the page's position at which its map opens: the good row nearest the middle.

    If no row is good, it is the middle.

    Args:
        axes: The axes of the page.
        is_good: True for good rows, in the product of the axes.
    """
    if not axes:
        return []
    lengths = np.array([len(axis.positions) for axis in axes])
    middle = (lengths - 1) // 2
    places = np.argwhere(is_good.reshape(lengths))  # (good rows, axes)
    if not len(places):
        return [int(place) for place in middle]
    distance = np.abs((places - middle) / lengths).sum(axis=1)
    return [int(place) for place in places[np.argmin(distance)]]


def thinning_text(axes: Iterable[PageAxis], left_out: Sequence[str]) -> list[str]:
    """Return a sentence on what the page leaves out of the results; empty if it has all of them.

    Args:
        axes: The axes of the page.
        left_out: Names of the columns that found no room.
    """
    thinned_axes = [
        f"{len(axis.positions)} of {axis.axis.length} values of {axis.shown.name}"
        for axis in axes
        if len(axis.positions) < axis.axis.length
    ]
    parts = []
    if thinned_axes:
        parts.append(f"it holds {', '.join(thinned_axes)}")
    if left_out:
        parts.append(f"it leaves out {', '.join(left_out)}")
    if not parts:
        return []
    return [f"To keep this page small, {'; '.join(parts)}. The tables have everything."]


def within_size(records: Iterable[dict[str, Any]]) -> tuple[list[dict[str, Any]], list[str]]:
    """Select the first columns that fit into MOST_BYTES together.

    Args:
        records: Columns as `number_record` returns them, the most useful first.

    Returns:
        The columns that fit, and the labels of the others.
    """
    selected = []
    left_out = []
    budget = MOST_BYTES
    for record in records:
        size = len(record["array"]["data"])
        if size > budget:
            left_out.append(record["label"])
            continue
        budget -= size
        selected.append(record)
    return selected, left_out


def number_record(
    shown: ColumnLabel, values: ColumnArray, none: str = "no value"
) -> dict[str, Any]:
    """Return a column of numbers as JSON, in the unit shown, with its range.

    Args:
        shown: Name and unit of the column.
        values: Its numbers, SI.
        none: Words for a row without a value.
    """
    scaled = shown.scaled(values)
    finite = scaled[np.isfinite(scaled)]
    low = None
    high = None
    if finite.size:
        low = float(finite.min())
        high = float(finite.max())
    return {
        **_about(shown),
        "classes": None,
        "none": none,
        "low": low,
        "high": high,
        "array": pack_numbers(scaled),
    }


def exact_record(shown: ColumnLabel, values: ColumnArray, stated: ColumnArray) -> dict[str, Any]:
    """Return the numbers of a column that axes set as JSON, in the unit shown.

    Args:
        shown: The column.
        values: Its values, SI.
        stated: Values that a number of a filter may mean, SI.
    """
    return {
        **_about(shown),
        "exact": pack_exact(shown.scaled(values)),
        "stated": pack_exact(shown.scaled(stated)),
    }


def given_records(
    cube: Cube, axes: Sequence[PageAxis], columns: Mapping[str, ColumnArray]
) -> list[dict[str, Any]]:
    """Return columns that say what a row is as JSON; the table hides them, and filters read them.

    Columns that find no room are left out.

    Args:
        cube: The table.
        axes: The axes of the page, whose columns are left out.
        columns: Values by the names of the columns, numbers in SI.
    """
    stated = axis_values(cube.axes, cube.study)
    for name in _carried_columns(cube):
        values = columns[name].ravel()
        stated[name] = values if values.dtype == object else values[~np.isnan(values)]
    records = []
    budget = MOST_BYTES_OF_GIVEN
    for name in sorted(columns.keys() - {axis.axis.column for axis in axes}):
        record = _given_record(cube.shown(name), columns[name], stated.get(name))
        size = len(json.dumps(record))
        if size <= budget:
            budget -= size
            records.append({**record, "hidden": True})
    return records


def _given_record(
    shown: ColumnLabel, values: ColumnArray, stated: ColumnArray | None
) -> dict[str, Any]:
    """Return a column that says what a row is as JSON.

    Args:
        shown: The column.
        values: Its values.
        stated: Values that axes give it; None if all rows share a number.
    """
    if stated is None:
        singles = shown.scaled(values).ravel().astype("<f4")
        return {**_about(shown), "array": {"type": "f4", "data": _encoded_steps(singles)}}
    if stated.dtype != object:
        return exact_record(shown, values, np.unique(stated))
    words = list(dict.fromkeys(stated.tolist()))
    if len(words) > _MOST_CODES:
        return {**_about(shown), "texts": values.ravel().tolist(), "stated": words}
    codes = pack_classes([words.index(word) for word in values.ravel().tolist()])
    return {**_about(shown), "words": words, "codes": codes}


def given_columns(cube: Cube) -> list[str]:
    """Return the columns that follow from the axes of a table, the axes included."""
    known = (*axis_values(cube.axes, cube.study), *_carried_columns(cube))
    return [name for name in known if name in cube.columns]


def _carried_columns(cube: Cube) -> list[str]:
    """Return the columns of a table that rows of its axes carry along, such as a price."""
    carried = Space(cube.axes).carried
    return [column.column for column in carried if column.column in cube.columns]


def truths_record(columns: Mapping[str, ColumnArray]) -> list[dict[str, Any]]:
    """Return columns of true and false as JSON; the table hides them, and its filters read them."""
    return [
        {
            "name": name,
            "label": say.spaced(name),
            "unit": "",
            "truth": True,
            "hidden": True,
            "array": pack_classes(values),
        }
        for name, values in columns.items()
    ]


def _about(shown: ColumnLabel) -> dict[str, Any]:
    """Return the names of a column, and the unit, dimension and factor of its numbers."""
    return {
        "name": shown.column,
        "key": _keys_by_column().get(shown.column),
        "label": shown.name,
        "unit": _unit(shown),
        "dimension": shown.quantity.dimension,
        "factor": shown.factor,
    }


@cache
def _keys_by_column() -> dict[str, str]:
    """Return the dotted key of each number that may be an axis, by its column."""
    return {field.column: key for key, field in keys().items()}


def _unit(shown: ColumnLabel) -> str:
    """Return the symbol of the unit shown; empty for a number without one."""
    return "" if shown.unit == "1" else shown.unit


# --- Packing --------------------------------------------------------------------------------------


def pack_numbers(values: npt.ArrayLike) -> dict[str, Any]:
    """Pack numbers, flat, in single precision into a text that the page unpacks.

    Infinite numbers become no value.
    """
    with np.errstate(over="ignore", under="ignore"):
        array = np.asarray(values, dtype=np.float64).ravel().astype("<f4")
    return {"type": "f4", "data": _encoded_steps(np.where(np.isfinite(array), array, np.nan))}


def pack_exact(values: npt.ArrayLike) -> dict[str, Any]:
    """Pack numbers, flat, in double precision; infinite ones stay infinite."""
    return {"type": "f8", "data": _encoded_steps(np.asarray(values, dtype="<f8").ravel())}


def _encoded_steps(array: npt.NDArray[np.floating[Any]]) -> str:
    """Encode numbers without loss as `unpack` of `page/base.js` reads them.

    Their bits are read as whole numbers, of which the differences between neighbours are stored,
    all first bytes before all second ones: results that change smoothly are small then.
    """
    size = array.dtype.itemsize
    bits = array.view(f"<u{size}")
    steps = np.diff(bits, prepend=bits.dtype.type(0))
    return _encoded(np.ascontiguousarray(steps.view(np.uint8).reshape(-1, size).T))


def pack_classes(values: npt.ArrayLike) -> dict[str, Any]:
    """Pack whole numbers from 0 to 255, flat."""
    return {"type": "u1", "data": _encoded(np.asarray(values, dtype=np.uint8).ravel())}


def _encoded(array: npt.NDArray[Any]) -> str:
    """Encode the bytes of an array: base64 of deflated data."""
    return base64.b64encode(zlib.compress(array.tobytes(), 6)).decode("ascii")


# --- States of some designs as curves over the motion, and their arms, by the model alone ---------


MOST_ANGLES = 61
"""Largest number of elbow angles of a curve."""
MOST_SAMPLES = 401
"""Largest number of samples of a curve over a motion in time."""
_MOST_STATES = 250_000
"""Largest number of states along a motion in time that are worked out at once for the page."""
TURNING = "turning"
OTHER_TORQUE = "motor_torque_other"
MOST_DESIGNS = 400
"""Largest number of designs whose states the page has: about 3 kB each."""

GROUPS = {
    "tension at the elbow": ("flexor_tension_distal", "extensor_tension_distal"),
    "tension at the motor": ("flexor_tension_proximal", "extensor_tension_proximal"),
    "torque": ("elbow_torque", "motor_torque"),
    "elbow stiffness": ("elbow_stiffness",),
    "slack length": ("flexor_slack", "extensor_slack"),
    "spool angle": ("spool_angle",),
    "travel": ("flexor_travel", "extensor_travel"),
}
"""Columns of states that share a figure, by its title."""
OF_TAUT = ("tension at the elbow", "torque", "elbow stiffness", "travel")
"""Groups that are shown for taut tendons; travels are drawn for a joint without anchors only."""
_ANCHORS = ("a1", "b1", "a2", "b2", "elbow_radius")
_ARM = (*_ANCHORS, "load_distance")

Curves = dict[str, Array]
"""Columns of states, (designs, directions, angles), and measures of an arm, (designs,), by name."""


def places_of(study: Study) -> Rows:
    """Return the positions of the curves' places among the study's angles or samples."""
    most = MOST_ANGLES if study.trajectory is None else MOST_SAMPLES
    return evenly_spaced(len(study.angles), most)


def most_designs(study: Study) -> int:
    """Return the largest number of designs whose states the page has.

    Along a motion in time there are fewer: each has more places, and is worked out at all samples.
    """
    if study.trajectory is None:
        return MOST_DESIGNS
    most = MOST_DESIGNS * 2 * MOST_ANGLES // MOST_SAMPLES
    return max(1, min(most, _MOST_STATES // len(study.angles)))


def samples_text(study: Study) -> list[str]:
    """Return a remark on how many samples of a motion in time the page has; none if all."""
    shown = len(places_of(study))
    if study.trajectory is None or shown == len(study.angles):
        return []
    return [f"States over time are those of {shown:,} of {len(study.angles):,} samples."]


def curves(
    study: Study, design: Design, shape: tuple[int, ...], labels: Iterable[str] = GROUPS
) -> Curves:
    """Evaluate designs as curves over the motion, with the measures of their arms.

    Args:
        study: Directions and elbow angles, or the motion in time.
        design: Designs whose numbers broadcast over `shape`, directions and angles.
        shape: Lengths of the axes of the designs.
        labels: Names of the groups in GROUPS whose columns are wanted. The travels are left out
            for an arm with anchors, which the page draws.

    Returns:
        Columns (designs, directions, places) and measures (designs,). A motion in time has one
        direction, and its columns are joined by TURNING and OTHER_TORQUE.
    """
    places = places_of(study)
    directions = 1
    if study.trajectory is None:
        directions = len(study.motion.direction)
        is_flexion = np.array([[direction == "flexion"] for direction in study.motion.direction])
        state = evaluate(design, study.angles[np.newaxis, places], is_flexion)
        places = np.arange(len(places))
    else:
        state = Moving.of(design, study.trajectory).state
    columns = State.columns(state)
    joint = design.arm.joint
    has_anchors = isinstance(joint, Anchors)
    wanted = [name for label in labels for name in GROUPS[label]]
    if has_anchors:
        wanted = [name for name in wanted if name not in GROUPS["travel"]]
    wanted += [name for name in (TURNING, OTHER_TORQUE) if name in columns]
    result: Curves = {}
    for name in wanted:
        values = np.asarray(columns[name])
        along = values[..., places] if values.ndim and values.shape[-1] > 1 else values
        states = np.broadcast_to(along, (*shape, directions, len(places)))
        result[name] = states.reshape(-1, directions, len(places))
    measures: dict[str, Any] = {}
    if has_anchors:
        measures = {name: getattr(joint, name) for name in _ANCHORS}
    measures["load_distance"] = design.arm.load_distance
    for name, value in measures.items():
        result[name] = np.broadcast_to(value, (*shape, 1, 1)).ravel()
    return result


def rows_with_states(cube: Cube, axes: Sequence[PageAxis], most: int) -> tuple[list[Rows], Rows]:
    """Select rows whose states the page shows, evenly along its axes.

    Args:
        cube: The table.
        axes: The axes of the page.
        most: Largest number of rows.

    Returns:
        Positions along each of the page's axes, and the rows of their product.
    """
    selected = thin_axes([len(axis.positions) for axis in axes], most)
    positions = {
        axis.axis.column: axis.positions[along] for axis, along in zip(axes, selected, strict=True)
    }
    return selected, cube.rows(list(positions), positions).ravel()


def states_record(
    study: Study, positions: Sequence[Rows], named_curves: Sequence[tuple[str, Curves]]
) -> tuple[dict[str, Any], list[dict[str, list[float]]]]:
    """Return curves and arms as JSON.

    Args:
        study: Directions and elbow angles, or the motion in time.
        positions: Positions along the page's axes whose product the designs are.
        named_curves: Name of each condition, which may be empty, and the curves under it.

    Returns:
        The curves of all conditions, and the measures of the arms under each.
    """
    groups: list[dict[str, Any]] = []
    for number, (condition, result) in enumerate(named_curves):
        groups += _groups(number, condition, result)
    places = places_of(study)
    record: dict[str, Any] = {
        "kept": [[int(index) for index in along] for along in positions],
        "angles": [round(float(angle), 6) for angle in np.rad2deg(study.angles[places])],
        "directions": list(study.motion.direction),
        "groups": groups,
        "times": None,
        "ends": None,
        "turning": None,
    }
    if study.trajectory is not None:
        record["times"] = study.trajectory.time[places].round(6).tolist()
        record["ends"] = study.trajectory.is_at_end[places].astype(int).tolist()
        record["directions"] = [""]
        record["turning"] = [pack_classes(result[TURNING]) for _, result in named_curves]
    arms = [
        {name: _short(result[name]) for name in _ARM if name in result}
        for _, result in named_curves
    ]
    return record, arms


def _groups(arm: int, condition: str, result: Curves) -> Iterable[dict[str, Any]]:
    """Yield the figures of a condition as JSON; `arm` is its index among the arms."""
    for label, columns in GROUPS.items():
        if columns[0] not in result:
            continue
        lines = [_line(column, result[column]) for column in columns]
        if label == "torque":
            lines[0]["colour"] = "joint"
            if OTHER_TORQUE in result:
                shown = ColumnLabel.of(OTHER_TORQUE, QUANTITIES[OTHER_TORQUE])
                lines[1]["other"] = pack_numbers(shown.scaled(result[OTHER_TORQUE]))
        yield {
            "label": f"{label}, {condition}" if condition else label,
            "condition": condition,
            "arm": arm,
            "unit": _unit(ColumnLabel.of(columns[0], QUANTITIES[columns[0]])),
            "lines": lines,
        }


def _line(column: str, values: Array) -> dict[str, Any]:
    """Return the curves of one column, in the colour of its side or else of the motor."""
    shown = ColumnLabel.of(column, QUANTITIES[column])
    colour = next((side for side in SIDES if side in column), "motor")
    return {"label": shown.name, "colour": colour, "array": pack_numbers(shown.scaled(values))}


def _short(values: Array) -> list[float]:
    """Return a measure of each design with six digits; only one value if all are equal."""
    rounded = [float(f"{value:.6g}") for value in values.tolist()]
    return rounded[:1] if len(set(rounded)) == 1 else rounded
