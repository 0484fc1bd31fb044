"""Data of a figure of curves, read from a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tendon_cli.cube.axes import DIRECTION, LOAD, TIME
from tendon_cli.cube.columns import ColumnArray
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import ColumnLabel
from tendon_cli.cube.room import room_to
from tendon_cli.errors import UsageError
from tendon_cli.figures.layout import CurvePlan
from tendon_cli.figures.limit_remarks import crosses_zero, limit_remarks
from tendon_cli.figures.maps import (
    OF_MARGIN,
    STIFFNESS,
    limit_text,
    margin_shown,
    meaning_of_margin,
)
from tendon_cli.figures.scales import Scale, axis_scale, caption, value_texts
from tendon_cli.figures.style import OKABE_ITO, Colour, load_colours, sequence
from tendon_cli.quantities import QUANTITIES
from tendon_cli.space.axis import Axis
from tendon_cli.studies.figures import FigureSpec
from tendon_cli.studies.filters import Condition, Truth
from tendon_cli.units import shorten

Floats = npt.NDArray[np.float64]

_SLACK_STATUSES = {
    "flexor": ("flexor slack", "both slack"),
    "extensor": ("extensor slack", "both slack"),
}
_ANY_SLACK = ("flexor slack", "extensor slack", "both slack")
_STIFFNESS = "elbow_stiffness"
ZEROS_OF_SPOOL = "Each direction counts the spool angle from its own zero, its pretensioned state."
_GEOMETRY = ("flexor_moment_arm", "flexor_travel", "extensor_travel", "radius_ratio")
"""Quantities that no tension changes, so that nothing is marked on them."""
_TENDON_ENDINGS = (
    "_tension_distal",
    "_tension_proximal",
    "_elongation",
    "_extensor_tension",
    "_flexor_tension",
)
"""Endings of tensions and lengths, which fall below zero in a model in which tendons push."""
_ARRAYS = ("values", "slack", "any_slack", "unstable", "others")
"""Fields of CurveData of shape (quantities, panels, colours, dashes, x)."""
_OF_LINES = ("turning", "at_record_end")
"""Fields of shape (panels, colours, dashes, x)."""
_OF_PANELS = (*_ARRAYS, "broken")
"""Fields whose second dimension is the panels."""
_OTHER = "_other"
"""Ending of a column with the values of the other direction of friction."""


@dataclass(frozen=True)
class CurveData:
    """Data of all pages of curves, in arrays of shape (quantities, panels, colours, dashes, x)."""

    title: str
    study: str
    x: Scale | None
    """Scale of x; None if x is not an axis but a column that changes along one."""
    x_label: str
    x_values: Floats
    """Values along x (panels, colours, dashes, x), in the unit shown."""
    quantities: tuple[ColumnLabel, ...]
    values: Floats
    """Values in the unit shown, NaN where there is none."""
    slack: Truth
    """True where the quantity's tendon is slack, or either tendon if it is not of one side."""
    any_slack: Truth
    """True where either tendon is slack; the line has a kink where this changes."""
    unstable: Truth
    """True where the elbow stiffness is below its limit."""
    limits: tuple[str, ...]
    """Limits that some designs on lines of the margin break, such as "max tension ≤ 300 N"."""
    broken: Truth
    """True where each of these limits is broken (limits, panels, colours, dashes, x)."""
    turning: Truth
    """True where the sheath turns in a motion in time (panels, colours, dashes, x)."""
    at_record_end: Truth
    """True for samples at the ends of its record (panels, colours, dashes, x)."""
    others: Floats
    """Values of the other direction of friction while the sheath turns, in the shape of `values`;
    NaN elsewhere, and for quantities of which the table has none."""
    colours: tuple[tuple[str, Colour], ...]
    """Text in the key and colour of the lines, by the index of their colour; at least one."""
    dashes: tuple[str, ...]
    panels: tuple[str, ...]
    has_kinks: bool
    """True if lines have a kink where a tendon goes slack; not if tendons push in the model."""
    is_slack_below_zero: bool
    """True if a negative value of every quantity means slack."""
    is_line: bool
    """True if points are joined by lines; False if they are those of names."""
    notes: tuple[str, ...]


def curve_data(
    cube: Cube, plan: CurvePlan, conditions: Sequence[Condition], spec: FigureSpec
) -> CurveData:
    """Read the lines of a plan.

    Args:
        cube: The table.
        plan: The part that each axis plays.
        conditions: Conditions that rows must meet. The plan already obeys those on an axis.
        spec: The figure as the user asks for it.

    Raises:
        UsageError: The filters, or nulls, leave nothing to draw.
    """
    masks = [condition for condition in conditions if cube.axis(condition.column) is None]
    read = _read_columns(cube, plan, masks)
    is_kept = np.ones(read[plan.x_column].shape, dtype=np.bool_)
    for condition in masks:
        is_kept &= condition.holds(read[condition.column])
    quantities = []
    for name in plan.quantities:
        is_margin = name == OF_MARGIN
        shown = margin_shown(cube, spec) if is_margin else cube.shown(name, spec.units)
        quantities.append(shown)
    values = np.array(
        [np.where(is_kept, shown.scaled(read[shown.column]), np.nan) for shown in quantities]
    )
    is_known = np.isfinite(values)
    if not is_known.any():
        for condition in masks:
            _check_leaves_rows(cube, condition, read[condition.column], spec)
        _raise_empty(plan, conditions)
    # Of shape (quantities, marks, panels, colours, dashes, x).
    marks = np.array([_marks(cube, read, name) for name in plan.quantities])
    slack, any_slack, unstable = np.moveaxis(marks & is_known[:, np.newaxis], 1, 0)
    others = np.array(
        [
            shown.scaled(read.get(f"{name}{_OTHER}", np.full(is_kept.shape, np.nan)))
            for name, shown in zip(plan.quantities, quantities, strict=True)
        ]
    )
    turning, at_record_end = (
        is_kept & (read[name] > 0.0) if name in read else np.zeros_like(is_kept)
        for name in _OF_LINES
    )
    x, x_label, x_values = _along_x(cube, plan, read, spec)
    panels = _axis_texts(cube, plan, plan.panels, spec)
    colours = _axis_texts(cube, plan, plan.colour, spec)
    varied = [axis.column for axis in plan.parts if axis is not None]
    lines, _ = caption(cube, spec, read, varied=varied)
    limits, broken, remarks = _broken_limits(cube, plan, spec, is_known[0])
    is_line = plan.is_joined and not (x and x.names)
    meaning = []
    if OF_MARGIN in plan.quantities:
        meaning.append(meaning_of_margin(cube, has_lines=is_line))
    has_spool_angle = "spool_angle" in (plan.x_column, *plan.quantities)
    if has_spool_angle and len(plan.positions.get(DIRECTION, ())) > 1:
        meaning.append(ZEROS_OF_SPOOL)
    # Negative means slack for a margin and, if tendons push, for their tensions and lengths.
    endings = (OF_MARGIN, *_TENDON_ENDINGS) if cube.has_pushing_tendons else (OF_MARGIN,)
    data = CurveData(
        title=spec.title or cube.title,
        study=cube.source,
        x=x,
        x_label=x_label,
        x_values=x_values,
        quantities=tuple(quantities),
        values=values,
        slack=slack,
        any_slack=any_slack,
        unstable=unstable,
        limits=limits,
        broken=broken,
        turning=turning,
        at_record_end=at_record_end,
        others=np.where(is_kept, others, np.nan),
        colours=tuple(zip(colours or ("",), _colours(plan, len(colours)), strict=True)),
        dashes=_axis_texts(cube, plan, plan.dash, spec),
        panels=panels,
        has_kinks=not cube.has_pushing_tendons,
        is_slack_below_zero=all(name.endswith(endings) for name in plan.quantities),
        is_line=is_line,
        notes=(*remarks, *meaning, *lines, *plan.notes),
    )
    if spec.overlay:
        data = _overlay(data)
    return _merge_equal_panels(data)


def _read_columns(
    cube: Cube, plan: CurvePlan, masks: Sequence[Condition]
) -> Mapping[str, ColumnArray]:
    """Read the columns that curves, their marks and their caption need."""
    names = [
        *plan.quantities,
        "status",
        _STIFFNESS,
        "taut",
        "stable",
        *_marks_of_motion(plan),
        *(condition.column for condition in masks),
        plan.x_column,
        *cube.defining,
        *_numbers_of_names(cube),
        *cube.columns_of_bound(STIFFNESS),
        *(axis.column for axis in cube.axes if axis.is_text),
    ]
    return cube.gather(plan.rows(cube), [name for name in names if name in cube.columns])


def _numbers_of_names(cube: Cube) -> list[str]:
    """Return the columns of numbers that rows of tables and cases set."""
    return [name for name, (_, axis) in cube.columns_of_names.items() if not axis.is_text]


def _marks_of_motion(plan: CurvePlan) -> list[str]:
    """Return the columns that mark lines over time; empty over anything else."""
    if plan.x_column != TIME:
        return []
    return [*_OF_LINES, *(f"{name}{_OTHER}" for name in plan.quantities)]


def _axis_texts(
    cube: Cube, plan: CurvePlan, axis: Axis | None, spec: FigureSpec
) -> tuple[str, ...]:
    """Return the values drawn of an axis as texts; empty without an axis."""
    if axis is None:
        return ()
    return tuple(value_texts(cube, axis, plan.positions[axis.column], spec.units))


def _marks(cube: Cube, read: Mapping[str, ColumnArray], name: str) -> tuple[Truth, Truth, Truth]:
    """Find where a column's tendon is slack, where either is, and where the elbow is unstable.

    Tables of states have the status and the stiffness, tables of designs `taut` and `stable`.
    """
    nowhere = np.zeros(read[name].shape, dtype=np.bool_)
    if name in _GEOMETRY:
        return nowhere, nowhere, nowhere
    slack = nowhere
    any_slack = nowhere
    unstable = nowhere
    if "status" in read:
        side = next((side for side in _SLACK_STATUSES if name.startswith(side)), "")
        slack = np.isin(read["status"], _SLACK_STATUSES.get(side, _ANY_SLACK))
        any_slack = np.isin(read["status"], _ANY_SLACK)
    elif "taut" in read and name != OF_MARGIN:
        slack = read["taut"] == 0.0
        any_slack = slack
    if _STIFFNESS in read:
        unstable = room_to(STIFFNESS, read[_STIFFNESS], cube.bound(STIFFNESS, read)) < 0.0
    elif "stable" in read:
        unstable = read["stable"] == 0.0
    return slack, any_slack, unstable


def _broken_limits(
    cube: Cube, plan: CurvePlan, spec: FigureSpec, is_known: Truth
) -> tuple[tuple[str, ...], Truth, list[str]]:
    """Find where lines of the margin break limits other than the one on stiffness.

    Args:
        cube: The table.
        plan: The part that each axis plays.
        spec: The figure as the user asks for it.
        is_known: True where a line has a value (panels, colours, dashes, x).

    Returns:
        The limits that some designs break, where they do (limits, panels, colours, dashes, x), and
        sentences on limits that all designs keep, or that none keeps. Nothing if other quantities
        than the margin are drawn.
    """
    rows = plan.rows(cube)
    if plan.quantities != (OF_MARGIN,) or spec.overlay:
        return (), np.zeros((0, *rows.shape), dtype=np.bool_), []
    rooms = {}
    for name in cube.limits:
        if name != STIFFNESS:
            rooms[name] = np.where(is_known, cube.room(name, rows), np.nan)
    texts = {name: limit_text(cube, spec, name) for name in rooms}
    broken = {texts[name]: room < 0.0 for name, room in rooms.items() if crosses_zero(room)}
    remarks = limit_remarks(texts, {name: [room] for name, room in rooms.items()}, [""])
    marks = np.array([*broken.values()], dtype=np.bool_).reshape(-1, *rows.shape)
    return tuple(broken), marks, remarks


def _along_x(
    cube: Cube, plan: CurvePlan, read: Mapping[str, ColumnArray], spec: FigureSpec
) -> tuple[Scale | None, str, Floats]:
    """Return the scale of x, its label, and its values (panels, colours, dashes, x)."""
    if plan.x_column != plan.x.column and cube.columns[plan.x_column] is not None:
        quantity = cube.shown(plan.x_column, spec.units)
        return None, quantity.label, quantity.scaled(read[plan.x_column])
    scale = axis_scale(cube, plan.x, plan.positions[plan.x.column], spec.units)
    places = np.empty(len(scale.places))
    places[scale.order] = scale.places
    label = plan.x.column if plan.x.is_text else scale.label
    return scale, label, np.broadcast_to(places, read[plan.x_column].shape)


def _colours(plan: CurvePlan, count: int) -> Sequence[Colour]:
    """Select a colour for each value of the axis of colours."""
    if plan.colour is None:
        return sequence(1)
    if plan.colour.is_text:
        return _qualitative_colours(count)
    values = plan.colour.values[plan.positions[plan.colour.column]]
    return load_colours(values) if plan.colour.column == LOAD else sequence(count)


def _qualitative_colours(count: int) -> list[Colour]:
    """Select colours for so many values without an order."""
    return [OKABE_ITO[place % len(OKABE_ITO)] for place in range(count)]


def _overlay(data: CurveData) -> CurveData:
    """Draw all quantities in the same panel, each in its own colour."""
    first = data.quantities[0]
    common = replace(first.quantity, name=first.quantity.dimension, symbol="", shown_in=first.unit)
    names = [quantity.titled for quantity in data.quantities]
    swapped = {part: np.swapaxes(getattr(data, part), 0, 2) for part in _ARRAYS}
    count = len(names)
    return replace(
        data,
        quantities=(ColumnLabel(common.name, common, first.unit, first.factor),),
        x_values=np.repeat(data.x_values, count, axis=1),
        colours=tuple(zip(names, _qualitative_colours(len(names)), strict=True)),
        turning=np.repeat(data.turning, count, axis=1),
        at_record_end=np.repeat(data.at_record_end, count, axis=1),
        **swapped,
    )


def _merge_equal_panels(data: CurveData) -> CurveData:
    """Keep one panel if all show the same picture, and say so in a note."""
    if len(data.panels) < 2:
        return data
    first = {part: getattr(data, part)[:, :1] for part in _OF_PANELS}
    first_x = data.x_values[:1]
    turning = data.turning[:1]
    is_same = (
        _all_equal(data.x_values, first_x)
        and _all_equal(data.turning, turning)
        and all(_all_equal(getattr(data, part), values) for part, values in first.items())
    )
    if not is_same:
        return data
    note = f"The same picture for {', '.join(data.panels)}."
    return replace(
        data,
        **first,
        turning=turning,
        at_record_end=data.at_record_end[:1],
        x_values=first_x,
        panels=(),
        notes=(*data.notes, note),
    )


def _all_equal(values: npt.NDArray[np.generic], first: npt.NDArray[np.generic]) -> bool:
    """Return True if all panels of an array are equal to the first."""
    return np.array_equal(values, np.broadcast_to(first, values.shape), equal_nan=True)


def _check_leaves_rows(
    cube: Cube, condition: Condition, values: ColumnArray, spec: FigureSpec
) -> None:
    """Raise UsageError if no value of a column meets a condition, with the values that it has."""
    if condition.holds(values).any():
        return
    name = condition.column
    if np.issubdtype(values.dtype, np.number):
        known = values[~np.isnan(values)]
        shown = cube.shown(name, spec.units)
        both = (known.min(), known.max()) if known.size else ()
        ends = [shown.text(value).replace("−", "-") for value in both]
        hint = f"values: {' to '.join(dict.fromkeys(ends)) or 'none'}"
    else:
        hint = f"values: {', '.join(str(value) for value in np.unique(values) if value != '')}"
    problem = f'"{shorten(condition.text)}" leaves no rows'
    raise UsageError(problem, where="--where", hint=hint)


def _raise_empty(plan: CurvePlan, conditions: Sequence[Condition]) -> None:
    """Raise UsageError because every value to draw is null."""
    if plan.quantities == (OF_MARGIN,) and not conditions:
        raise UsageError("no design has a margin, each has elbow angles without equilibrium")
    names = ", ".join(plan.quantities)
    if conditions:
        problem = f"no selected row has a value of {names}"
        raise UsageError(problem, where="--where", hint="fewer or wider filters")
    hint = None
    if any(name in QUANTITIES and QUANTITIES[name].null != "often" for name in plan.quantities):
        hint = "a row without equilibrium has none"
    raise UsageError(f"no row of the table has a value of {names}", hint=hint)
