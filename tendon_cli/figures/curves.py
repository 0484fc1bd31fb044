"""Curves: quantities of states or designs as lines, on which slack and broken limits are seen."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tendon_cli.cube.axes import DIRECTION, LOAD, TIME
from tendon_cli.cube.columns import ColumnArray
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import ColumnLabel
from tendon_cli.cube.room import room_to
from tendon_cli.errors import UsageError
from tendon_cli.figures.backend import Axes
from tendon_cli.figures.frame import Page, fitted, framed, grid_shape, panels_of
from tendon_cli.figures.layout import CurvePlan
from tendon_cli.figures.limit_remarks import crosses_zero, limit_remarks
from tendon_cli.figures.maps import (
    OF_MARGIN,
    STIFFNESS,
    column_shown,
    limit_colour,
    limit_text,
    meaning_of_margin,
)
from tendon_cli.figures.motion_marks import (
    band_key,
    draw_band,
    ends_key,
    hatch_ends,
    shade_turning,
    stretches,
    turning_key,
)
from tendon_cli.figures.scales import Scale, axis_scale, caption, value_texts
from tendon_cli.figures.style import (
    COLUMN_WIDTH,
    INK,
    MARKERS,
    OKABE_ITO,
    PAGE_HEIGHT,
    WHOLE,
    Colour,
    hatch_key,
    key_line,
    load_colours,
    sequence,
    unknown_hatch,
)
from tendon_cli.model.kinematics import Array
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.figures import FigureSpec
from tendon_cli.studies.filters import Condition, Truth
from tendon_cli.studies.space.axis import Axis
from tendon_cli.units import shorten

ZEROS_OF_SPOOL = "Each direction counts the spool angle from its own zero, its pretensioned state."
_GEOMETRY = ("flexor_moment_arm", "flexor_travel", "extensor_travel", "radius_ratio")
"""Quantities that no tension changes, so that nothing is marked on them."""
_BELOW_ZERO = (
    "_tension_distal",
    "_tension_proximal",
    "_elongation",
    "_extensor_tension",
    "_flexor_tension",
)
"""Endings of tensions and lengths, which fall below zero in a model in which tendons push."""
_OF_MOTION = ("turning", "at_record_end")
_OTHER = "_other"
"""Ending of a column with the values of the other direction of friction."""
_DASHES: tuple[Any, ...] = ("solid", (0, (3.2, 1.4)))
_FEW_POINTS = 12
"""Lines of at most so many points have a marker at each."""
_CROWD = 200
"""From this number on points that no line joins have smaller markers."""
_MOST_CELLS = 12
"""Largest number of panels on a page."""
_MOST_IN_COLUMN = 5
"""Largest number of panels below each other at the width of a column."""
_MOST_IN_ROW = 4
"""Largest number of panels side by side that each have several quantities."""
_MOST_UNLIKE = 5.0
"""Panels whose values differ by more than this factor do not share an axis."""
_BAND: dict[str, Any] = {"alpha": 0.25, "linewidth": 4.2, "solid_capstyle": "butt"}
_DISC: dict[str, Any] = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 8.0,
    "markeredgewidth": 0.0,
    "alpha": 0.3,
    **WHOLE,
}
_DOTTED: dict[str, Any] = {"color": INK, "linewidth": 1.7, "linestyle": (0, (0.6, 0.9))}
_CROSS: dict[str, Any] = {
    "linestyle": "none",
    "marker": "x",
    "markersize": 6.0,
    "markeredgewidth": 1.1,
    "color": INK,
    **WHOLE,
}

_IN_KEY: dict[str, Any] = {"markevery": 1, "markersize": 2.8}

Cell = tuple[int, int]
"""A panel on a page: indices of its quantity and of its value among the data's panels."""


@dataclass(frozen=True)
class Mark:
    """Mark on lines where something holds, with one style on lines and another on points."""

    name: str
    label: str
    holds: Truth
    """(quantities, panels, colours, dashes, x)."""
    on_line: Mapping[str, Any]
    """Style of a stretch of a line, which has the colour of the line if the style has none."""
    on_point: Mapping[str, Any]


@dataclass(frozen=True)
class CurveData:
    """Data of all pages of curves, in arrays of shape (quantities, panels, colours, dashes, x)."""

    title: str
    study: str
    x: Scale | None
    """Scale of x; None if x is not an axis but a column that changes along one."""
    x_label: str
    x_values: Array
    """Values along x (panels, colours, dashes, x), in the unit shown."""
    quantities: tuple[ColumnLabel, ...]
    values: Array
    """Values in the unit shown, NaN where there is none."""
    marks: tuple[Mark, ...]
    turning: Truth
    """True where the sheath turns in a motion in time (panels, colours, dashes, x)."""
    at_record_end: Truth
    """True for samples at the ends of its record (panels, colours, dashes, x)."""
    others: Array
    """Values of the other direction of friction while the sheath turns; NaN elsewhere."""
    colours: tuple[tuple[str, Colour], ...]
    """Text in the key and colour of the lines, by the index of their colour; at least one."""
    dashes: tuple[str, ...]
    panels: tuple[str, ...]
    is_slack_below_zero: bool
    """True if a negative value of every quantity means slack."""
    is_line: bool
    """True if points are joined by lines; False if they are those of names."""
    notes: tuple[str, ...]

    @property
    def has_stretches(self) -> bool:
        """True if points are so near each other that it is known what holds between them."""
        return self.is_line and int(self.x_values.shape[-1]) > _FEW_POINTS


# --- Data -----------------------------------------------------------------------------------------


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
    quantities = [column_shown(cube, spec, name) for name in plan.quantities]
    values = np.array(
        [np.where(is_kept, shown.scaled(read[shown.column]), np.nan) for shown in quantities]
    )
    if not np.isfinite(values).any():
        for condition in masks:
            _check_leaves_rows(cube, condition, read[condition.column], spec)
        _raise_empty(plan, conditions)
    nowhere = np.full(is_kept.shape, np.nan)
    others = [shown.scaled(read.get(f"{shown.column}{_OTHER}", nowhere)) for shown in quantities]
    turning, at_record_end = (
        is_kept & (read[name] > 0.0) if name in read else np.zeros_like(is_kept)
        for name in _OF_MOTION
    )
    x, x_label, x_values = _along_x(cube, plan, read, spec)
    texts = [_axis_texts(cube, plan, axis, spec) for axis in plan.panels]
    panels = tuple(", ".join(words) for words in itertools.product(*texts)) if texts else ()
    colours = _axis_texts(cube, plan, plan.colour, spec)
    lines, _ = caption(cube, spec, read, varied=[axis.column for axis in plan.axes])
    marks = _marks(cube, plan, read, np.isfinite(values))
    limits, remarks = _limits(cube, plan, spec, np.isfinite(values[0]))
    is_line = not plan.x.is_text and not (x and x.names)
    meaning = []
    if OF_MARGIN in plan.quantities:
        meaning.append(meaning_of_margin(cube, has_lines=is_line))
    has_spool_angle = "spool_angle" in (plan.x_column, *plan.quantities)
    if has_spool_angle and len(plan.positions.get(DIRECTION, ())) > 1:
        meaning.append(ZEROS_OF_SPOOL)
    # Negative means slack for a margin and, if tendons push, for their tensions and lengths.
    endings = (OF_MARGIN, *_BELOW_ZERO) if cube.has_pushing_tendons else (OF_MARGIN,)
    data = CurveData(
        title=spec.title or cube.title,
        study=cube.source,
        x=x,
        x_label=x_label,
        x_values=x_values,
        quantities=tuple(quantities),
        values=values,
        marks=(*marks, *limits),
        turning=turning,
        at_record_end=at_record_end,
        others=np.where(is_kept, np.array(others), np.nan),
        colours=tuple(zip(colours or ("",), _colours(plan, len(colours)), strict=True)),
        dashes=_axis_texts(cube, plan, plan.dash, spec),
        panels=panels,
        is_slack_below_zero=all(name.endswith(endings) for name in plan.quantities),
        is_line=is_line,
        notes=(*remarks, *meaning, *lines, *plan.notes),
    )
    return _overlay(data) if spec.overlay else data


def _read_columns(
    cube: Cube, plan: CurvePlan, masks: Sequence[Condition]
) -> Mapping[str, ColumnArray]:
    """Read the columns that curves, their marks and their caption need."""
    of_motion: list[str] = []
    if plan.x_column == TIME:
        of_motion = [*_OF_MOTION, *(f"{name}{_OTHER}" for name in plan.quantities)]
    names = [
        *plan.quantities,
        "status",
        "elbow_stiffness",
        "taut",
        "stable",
        *of_motion,
        *(condition.column for condition in masks),
        plan.x_column,
        *cube.defining,
        *(name for name, (_, axis) in cube.columns_of_names.items() if not axis.is_text),
        *cube.columns_of_bound(STIFFNESS),
        *(axis.column for axis in cube.axes if axis.is_text),
    ]
    return cube.gather(plan.rows(cube), [name for name in names if name in cube.columns])


def _axis_texts(
    cube: Cube, plan: CurvePlan, axis: Axis | None, spec: FigureSpec
) -> tuple[str, ...]:
    """Return the values drawn of an axis as texts; empty without an axis."""
    if axis is None:
        return ()
    return tuple(value_texts(cube, axis, plan.positions[axis.column], spec.units))


def _marks(
    cube: Cube, plan: CurvePlan, read: Mapping[str, ColumnArray], is_known: Truth
) -> list[Mark]:
    """Find where the tendon of each quantity, or either, is slack, and where the elbow is unstable.

    Tables of states have the status and the stiffness, tables of designs `taut` and `stable`.
    """
    slack = np.zeros(is_known.shape, dtype=np.bool_)
    unstable = np.zeros(is_known.shape, dtype=np.bool_)
    for place, name in enumerate(plan.quantities):
        if name in _GEOMETRY:
            continue
        if "status" in read:
            side = next((side for side in ("flexor", "extensor") if name.startswith(side)), "")
            sides = (side,) if side else ("flexor", "extensor")
            statuses = [*(f"{one} slack" for one in sides), "both slack"]
            slack[place] = np.isin(read["status"], statuses)
        elif "taut" in read and name != OF_MARGIN:
            slack[place] = read["taut"] == 0.0
        if "elbow_stiffness" in read:
            room = room_to(STIFFNESS, read["elbow_stiffness"], cube.bound(STIFFNESS, read))
            unstable[place] = room < 0.0
        elif "stable" in read:
            unstable[place] = read["stable"] == 0.0
    return [
        Mark("slack", "a tendon is slack", slack & is_known, _BAND, _DISC),
        Mark("unstable", "unstable elbow", unstable & is_known, _DOTTED, _CROSS),
    ]


def _limits(
    cube: Cube, plan: CurvePlan, spec: FigureSpec, is_known: Truth
) -> tuple[list[Mark], list[str]]:
    """Find where lines of the margin break limits other than the one on stiffness.

    On a line the marks of several limits take turns; on points they are rings around each other.

    Returns:
        A mark of each limit that some designs break, and sentences on limits that all designs keep,
        or that none keeps. Nothing if other quantities than the margin are drawn.
    """
    if plan.quantities != (OF_MARGIN,) or spec.overlay:
        return [], []
    rows = plan.rows(cube)
    rooms = {
        name: np.where(is_known, cube.room(name, rows), np.nan)
        for name in cube.limits
        if name != STIFFNESS
    }
    texts = {name: limit_text(cube, spec, name) for name in rooms}
    broken = [name for name, room in rooms.items() if crosses_zero(room)]
    marks = []
    for place, name in enumerate(broken):
        colour = limit_colour(place + 1)  # the first is on stiffness
        dashes = (-1.6 * place, (1.0, 1.6 * len(broken) - 0.6))
        on_line = {"color": colour, "linewidth": 2.6, "linestyle": dashes}
        ring = {"marker": "o", "markersize": 7.5 + 2.0 * place, "markerfacecolor": "none"}
        on_point = {"color": colour, "linestyle": "none", "markeredgewidth": 0.8, **ring}
        holds = (rooms[name] < 0.0)[np.newaxis]
        marks.append(Mark(texts[name], f"breaks {texts[name]}", holds, on_line, on_point))
    remarks = limit_remarks(texts, {name: [room] for name, room in rooms.items()}, [""])
    return marks, remarks


def _along_x(
    cube: Cube, plan: CurvePlan, read: Mapping[str, ColumnArray], spec: FigureSpec
) -> tuple[Scale | None, str, Array]:
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
    count = len(names)
    return replace(
        data,
        quantities=(ColumnLabel(common.name, common, first.unit, first.factor),),
        x_values=np.repeat(data.x_values, count, axis=1),
        values=np.swapaxes(data.values, 0, 2),
        others=np.swapaxes(data.others, 0, 2),
        marks=tuple(replace(mark, holds=np.swapaxes(mark.holds, 0, 2)) for mark in data.marks),
        colours=tuple(zip(names, _qualitative_colours(count), strict=True)),
        turning=np.repeat(data.turning, count, axis=1),
        at_record_end=np.repeat(data.at_record_end, count, axis=1),
    )


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


# --- Pages ----------------------------------------------------------------------------------------


def draw_curves(data: CurveData, width: float, height: float | None) -> list[Page]:
    """Draw curves, a panel for each quantity and value of the axes of panels, page by page.

    Args:
        data: The lines.
        width: Width of the page, mm.
        height: Height of the page, mm; None if the panels may have their usual height.
    """
    quantities, panels = data.values.shape[:2]
    in_row = panels
    if quantities > 1 and panels > 1:  # as many panels side by side as fit, quantities below
        in_row = max(1, min(_MOST_IN_ROW, _MOST_CELLS // quantities))
    elif quantities == 1:
        in_row = _MOST_IN_COLUMN if width <= COLUMN_WIDTH else _MOST_CELLS
    pages = []
    for start in range(0, panels, in_row):
        seen = range(start, min(panels, start + in_row))
        cells = [(quantity, panel) for quantity in range(quantities) for panel in seen]
        columns = grid_shape(len(cells), most=3)[1] if quantities == 1 else 2
        if quantities > 1 and panels > 1:
            columns = len(seen)
        pages.append(_page(data, cells, 1 if width <= COLUMN_WIDTH else columns, width, height))
    return pages


def _page(
    data: CurveData, cells: Sequence[Cell], columns: int, width: float, height: float | None
) -> Page:
    """Draw a page of panels in so many columns."""
    rows = -(-len(cells) // columns)
    panel_width = (width - 6.0) / columns - 10.0
    below = 0.0 if data.x is None else data.x.height_of_names(panel_width)
    usual = min(PAGE_HEIGHT, rows * min(0.62 * panel_width + 14.0, 70.0) + 8.0 + below)
    page = framed(
        data.title,
        usual,
        _key(data, cells),
        data.notes,
        width=width,
        height=height,
        study=data.study,
    )
    panels = panels_of(page, rows, columns, len(cells), sharex=True)
    panel_height = max((page.inner - below) / rows - 12.0, 15.0)
    for place, (cell, axes) in enumerate(zip(cells, panels, strict=True)):
        _draw_lines(axes, data, cell, panel_width)
        shown = data.quantities[cell[0]]
        texts = [shown.titled] if len(data.quantities) > 1 else []
        texts += [data.panels[cell[1]]] if data.panels else []
        axes.set_title(fitted(", ".join(texts), panel_width), y=1.0)
        if axes.xaxis.get_visible():
            axes.set_xlabel(fitted(data.x_label, panel_width))
        axes.margins(y=0.05)
        if not _share_y(data, panels, cells, place, columns):
            label = shown.short_label if len(data.quantities) > 1 else shown.label
            axes.set_ylabel(fitted(label, panel_height))
    for axes in panels:
        low, high = axes.get_ylim()
        if data.is_slack_below_zero and low < -0.01 * high:
            _shade_slack(axes, low)
        if low < 0.0 < high:
            axes.axhline(0.0, color=INK, linewidth=0.5, zorder=1.2)
        axes.set_ylim(low, high)
    return page


def _share_y(
    data: CurveData, panels: Sequence[Axes], cells: Sequence[Cell], place: int, columns: int
) -> bool:
    """Let a panel share y with the first of its row, or with all panels of one quantity.

    In a row quantities of one unit and of similar sizes share it, too.

    Returns:
        True if the axis is that of the left neighbour, which then labels both.
    """
    is_one = len(data.quantities) == 1
    row_start = place - place % columns
    first = 0 if is_one else row_start
    sizes = [float(np.nanmax(np.abs(data.values[cells[at]]), initial=0.0)) for at in (first, place)]
    kinds = [data.quantities[cells[at][0]].kind_shown for at in (first, place)]
    is_same = is_one or (kinds[0] == kinds[1] and max(sizes) <= _MOST_UNLIKE * min(sizes))
    if is_same and place != first:
        panels[place].sharey(panels[first])
    is_labelled = not is_same or place == row_start
    panels[place].tick_params(labelleft=is_labelled)
    return not is_labelled


def _draw_lines(axes: Axes, data: CurveData, cell: Cell, width: float) -> None:
    """Draw all lines of one panel, and hatch where none of them has a value."""
    values = data.values[cell]  # (colours, dashes, x)
    for colour, dash in np.ndindex(*values.shape[:2]):
        _draw_line(axes, data, cell, colour, dash)
    if data.x is None:
        return
    if not data.x.names:
        _mark_motion(axes, data, data.x, cell)
    data.x.apply(axes, "x", width)
    is_unknown = np.asarray(~np.isfinite(values).any(axis=(0, 1)))
    for first, last in stretches(is_unknown[data.x.order], data.x.edges):
        axes.axvspan(first, last, zorder=0.6, **unknown_hatch())


def _draw_line(axes: Axes, data: CurveData, cell: Cell, colour: int, dash: int) -> None:
    """Draw one line with what is marked on it."""
    place = (*cell, colour, dash)
    x = data.x_values[cell[1], colour, dash]
    order = np.argsort(x, kind="stable") if data.x else np.arange(len(x))
    x = x[order]
    y = data.values[place][order]
    style = _line_style(data, colour, dash, len(x))
    names = (data.colours[colour][0], data.dashes[dash] if data.dashes else "")
    label = ", ".join(name for name in names if name) or "_line"
    is_crowd = not data.is_line and len(x) >= _CROWD
    axes.plot(x, y, **style, gid="curve", label=label, rasterized=is_crowd)
    for mark in data.marks:
        holds = mark.holds[place][order]
        if not holds.any():
            continue
        if data.has_stretches:
            marked = {"color": style["color"], **mark.on_line}
            axes.plot(*_stretches(x, y, holds), gid=mark.name, zorder=1.9, **marked)
        else:
            marked = {"color": style["color"], **mark.on_point}
            axes.plot(x[holds], y[holds], gid=mark.name, **marked)


def _line_style(data: CurveData, colour: int, dash: int, points: int) -> dict[str, Any]:
    """Return the style of a line; `colour` and `dash` are its indices, `points` its length.

    Points that no line joins have a marker each. Lines differ by colour, and in grey print by
    markers and lightness. No two lines have their markers at the same points, so that two lines
    that coincide are recognised.
    """
    lines = len(data.colours)
    step = max(2, points // 6)
    start = round(step * ((colour + 0.5) / lines + 0.5 * dash)) % step
    has_all_markers = points <= _FEW_POINTS or not data.is_line
    line_colour = data.colours[colour][1]
    return {
        "color": line_colour,
        "linestyle": _DASHES[dash] if data.is_line else "none",
        "marker": MARKERS[colour % len(MARKERS)] if lines > 1 or has_all_markers else "none",
        "markersize": 2.8 if data.is_line or points < _CROWD else 1.6,
        "markevery": 1 if has_all_markers else (start, step),
        "markerfacecolor": line_colour if dash == 0 else "white",
        "markeredgewidth": 0.8,
        **WHOLE,
    }


def _stretches(x: Array, y: Array, holds: Truth) -> tuple[Array, Array]:
    """Return the parts of a line where something holds, with NaN between them.

    Each part reaches half way to the next point where it does not hold, so that a single point has
    a length, too.
    """
    count = 2 * len(x) - 1
    places = np.empty(count)
    values = np.empty(count)
    is_kept = np.empty(count, dtype=np.bool_)
    places[::2] = x
    places[1::2] = (x[:-1] + x[1:]) / 2.0
    values[::2] = y
    values[1::2] = (y[:-1] + y[1:]) / 2.0
    is_kept[::2] = holds
    is_kept[1::2] = holds[:-1] | holds[1:]
    return places, np.where(is_kept, values, np.nan)


def _mark_motion(axes: Axes, data: CurveData, x: Scale, cell: Cell) -> None:
    """Mark turns, the range of the torque there, and the ends of the record along a motion."""
    panel = cell[1]
    values = data.values[cell]  # (colours, dashes, x)
    at_ends = data.at_record_end[panel].any(axis=(0, 1))
    hatch_ends(axes, at_ends[x.order], x.edges)
    lines = int(np.prod(values.shape[:2]))
    for colour, dash in np.ndindex(*values.shape[:2]):
        turning = data.turning[panel, colour, dash] & ~at_ends
        shade_turning(axes, turning[x.order], x.edges, lines)
        times = data.x_values[panel, colour, dash][x.order]
        torque = values[colour, dash][x.order]
        other = np.where(at_ends, np.nan, data.others[cell][colour, dash])[x.order]
        draw_band(axes, times, torque, other, data.colours[colour][1])


def _shade_slack(axes: Axes, low: float) -> None:
    """Shade and name the area below zero in a panel in which negative means slack."""
    axes.axhspan(low, 0.0, facecolor="#fbeae0", linewidth=0.0, zorder=0.3, gid="slack area")
    axes.text(
        0.02,
        0.03,
        "slack",
        transform=axes.transAxes,
        color="#8a3b12",
        style="italic",
        gid="slack word",
    )


def _key(data: CurveData, cells: Sequence[Cell]) -> list[Any]:
    """Return the key: colours, dashes (filled and open markers), marks, stretches of a motion."""
    points = data.x_values.shape[-1]
    key: list[Any] = []
    for place, (text, _) in enumerate(data.colours):
        if text:
            key.append(key_line(**{**_line_style(data, place, 0, points), **_IN_KEY}, label=text))
    for place, text in enumerate(data.dashes):
        style = {**_line_style(data, 0, place, points), **_IN_KEY, "color": INK}
        style["markerfacecolor"] = ("black", "white")[place]
        shape = "" if style["marker"] == "none" else (", filled", ", open")[place]
        key.append(key_line(**style, label=f"{text}{shape}"))
    for mark in data.marks:
        if any(mark.holds[cell].any() for cell in cells):
            style = dict(mark.on_line if data.has_stretches else mark.on_point)
            key.append(key_line(label=mark.label, **{"color": INK, **style}))
    panels = sorted({panel for _, panel in cells})
    is_known = [np.isfinite(data.values[cell]).any(axis=(0, 1)).all() for cell in cells]
    for holds, entry in (
        (data.turning[panels].any(), turning_key()),
        (any(np.isfinite(data.others[cell]).any() for cell in cells), band_key()),
        (data.at_record_end[panels].any(), ends_key()),
        (data.x is not None and not all(is_known), hatch_key("no value")),
    ):
        if holds:
            key.append(entry)
    return key
