"""Layout of a figure of a table.

A plan says which axes run along x and y, by colour, dashes and panels, and which values are left
out.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from tendon_cli import say
from tendon_cli.cube.axes import ANGLE, DIRECTION, LOAD, TIME
from tendon_cli.cube.columns import DERIVED
from tendon_cli.cube.cube import Cube
from tendon_cli.errors import UsageError
from tendon_cli.model.kinematics import Rows
from tendon_cli.studies.figures import MOST_QUANTITIES, OF_STATES, FigureSpec
from tendon_cli.studies.space.axis import (
    CASE_AXIS,
    NAMED_AXES,
    Axis,
    NamedAxis,
    evenly_spaced,
    limit_of,
)
from tendon_cli.studies.study import keys

MOST_COLOURS = 12
MOST_PANELS = 48
"""Largest number of panels of curves, on several pages."""
POINTS = 1000
"""Largest number of points of a line."""
MARKS = 10_000
"""Largest number of points that no line joins: of cases, persons or draws."""

STATE_PAIRS = (
    "flexor_tension_distal",
    "extensor_tension_distal",
    "flexor_tension_proximal",
    "extensor_tension_proximal",
    "elbow_torque",
    "motor_torque",
    "flexor_spring_stretch",
    "extensor_spring_stretch",
)
"""Columns of `states` that are drawn if nothing else is asked for, two in a row."""


STATES_OF_ROWS = ("flexor_tension_distal", "extensor_tension_distal", "motor_torque")
"""Columns of `states` that are drawn of each row of a table, below each other."""
MOST_NAMES = 40
"""Largest number of rows that stand by name along an axis; more are points over their numbers."""
MOST_NUMBERS = 6
"""Largest number of numbers over which rows are drawn as points."""


def is_of_rows(axis: Axis) -> bool:
    """Return True for an axis of the rows of a table of a study."""
    return isinstance(axis, NamedAxis) and axis.key not in NAMED_AXES


def has_many_rows(axes: Iterable[Axis]) -> bool:
    """Return True if the names of an axis are too many to stand along it."""
    return any(is_of_rows(axis) and len(axis) > MOST_NAMES for axis in axes)


def numbers_that_vary(cube: Cube) -> list[str]:
    """Return the columns of numbers that differ between rows: of axes, set and carried."""
    of_axes = [axis.column for axis in cube.axes if len(axis) > 1 and not axis.is_text]
    of_names = [column for column, (_, axis) in cube.columns_of_names.items() if not axis.is_text]
    carried = [
        column.name
        for axis in cube.axes
        if isinstance(axis, NamedAxis)
        for column in axis.carried
        if not column.words
    ]
    names = dict.fromkeys([*of_axes, *of_names, *carried])
    return [name for name in names if cube.columns.get(name) is not None]


def numbers_of_many_rows(cube: Cube) -> list[str]:
    """Return the numbers of rows that are too many to stand by name: those set, then carried."""
    numbers = []
    for name in numbers_that_vary(cube):
        axis = _axis_behind(cube, name)
        if axis is not None and has_many_rows([axis]):
            numbers.append(name)
    return numbers


def _axis_behind(cube: Cube, column: str) -> Axis | None:
    """Return the named axis whose rows set or carry a number; None if there is none."""
    if column in cube.columns_of_names:
        return cube.columns_of_names[column][0]
    for axis in cube.axes:
        if isinstance(axis, NamedAxis):
            names = [column.name for column in axis.carried]
            if column in (*names, *(f"{axis.key}_{name}" for name in names)):
                return axis
    return None


@dataclass(frozen=True)
class CurvePlan:
    """Layout of curves: the part that each axis plays, and the positions drawn."""

    quantities: tuple[str, ...]
    x_column: str
    """Column along x: that of the axis `x`, or another that changes along it."""
    x: Axis
    colour: Axis | None
    dash: Axis | None
    """The direction of motion, unless it plays another part."""
    panels: tuple[Axis, ...]
    """Axes whose values have a panel for each combination."""
    positions: Mapping[str, Rows]
    """Positions drawn of each axis, by its column."""
    notes: tuple[str, ...]

    @property
    def axes(self) -> list[Axis]:
        """Axes that have a part."""
        return [axis for axis in (*self.panels, self.colour, self.dash, self.x) if axis is not None]

    def rows(self, cube: Cube) -> Rows:
        """Return the rows of all lines (panels, colours, dashes, x)."""
        ends = (self.colour, self.dash, self.x)
        shape = [1 if axis is None else len(self.positions[axis.column]) for axis in ends]
        order = [axis.column for axis in self.axes]
        return cube.rows(order, self.positions).reshape(-1, *shape)


def plan_curves(cube: Cube, chosen: Mapping[str, Rows], spec: FigureSpec) -> CurvePlan:
    """Give each axis its part in a figure of curves.

    A figure of one quantity has panels for all axes without another part; of several quantities
    only one axis, or the rows of a table, has panels.

    Args:
        cube: The table.
        chosen: Positions to choose from, by the column of the axis.
        spec: The figure as the user asks for it.

    Raises:
        UsageError: The figure does not fit the table.
    """
    quantities = _quantities(cube, spec)
    long = [axis for axis in cube.axes if len(chosen[axis.column]) > 1]
    colour = _named_axis(cube, spec.colour, "--colour")
    named = _named_axis(cube, spec.panels, "--panels")
    x_column, x = _along_x(cube, spec, [axis for axis in long if axis not in (colour, named)])
    free = [axis for axis in long if axis is not x]
    if not spec.overlay:
        colour = colour or _usual_colour(free, named)
    elif named is None:
        named = _usual_colour([axis for axis in free if axis.column != ANGLE], None)
    parts = [axis for axis in (x, colour, named) if axis is not None]
    if len(set(parts)) < len(parts):
        raise UsageError(
            "one axis cannot have two roles", hint="x, colour and panels name different axes"
        )
    dash = next((axis for axis in free if axis.column == DIRECTION and axis not in parts), None)
    others = [axis for axis in free if axis not in (*parts, dash)]
    rows = [axis for axis in others if is_of_rows(axis) and len(chosen[axis.column]) <= MOST_NAMES]
    panels = [axis for axis in (named,) if axis is not None]
    if len(quantities) == 1 or spec.overlay:
        panels += [axis for axis in others if axis.column not in (ANGLE, TIME)]
    elif rows and named is None:
        panels = rows[:1]
        quantities = _quantities(cube, spec, is_by_row=True)
    counts = [len(chosen[axis.column]) for axis in panels]
    most = {x: MARKS if x.is_text else POINTS, colour: MOST_COLOURS, dash: 2}
    most |= dict(zip(panels, fewer(counts, MOST_PANELS), strict=True))
    positions, notes = thin_out(cube, chosen, most)
    return CurvePlan(quantities, x_column, x, colour, dash, tuple(panels), positions, notes)


def fewer(counts: list[int], most: int) -> list[int]:
    """Lower the largest of some counts until their product is at most `most`."""
    left = list(counts)
    while math.prod(left) > most:
        left[left.index(max(left))] -= 1
    return left


def _quantities(cube: Cube, spec: FigureSpec, *, is_by_row: bool = False) -> tuple[str, ...]:
    """Return the columns to draw: those asked for, or the usual ones of the table.

    There are fewer usual ones if each row of a table has its own panels.
    """
    if spec.quantity:
        names = [cube.table_columns.find_numbers(name, "--quantity") for name in spec.quantity]
        return tuple(dict.fromkeys(names))
    if cube.kind == "designs":
        return (cube.table_columns.find_numbers("margin", "--quantity"),)
    results = [name for name in OF_STATES if name in cube.columns and name not in DERIVED]
    if not results:
        raise UsageError(
            "the table keeps no results",
            where="--quantity",
            hint="[output] states names those it keeps",
        )
    usual = STATES_OF_ROWS if is_by_row else STATE_PAIRS
    pairs = tuple(name for name in usual if name in results)
    return pairs or tuple(results[:MOST_QUANTITIES])


def _along_x(cube: Cube, spec: FigureSpec, long: list[Axis]) -> tuple[str, Axis]:
    """Return the column along x, and the axis that runs along it."""
    usual = [axis for axis in long if axis.column not in (LOAD, DIRECTION)] or list(long)
    usual.sort(key=lambda axis: (_is_limit(axis), axis.is_text))
    angle = next((axis for axis in cube.axes if axis.column in (ANGLE, TIME)), None)
    runs = angle if angle in long or not usual else usual[0]
    if spec.x is not None:
        column = cube.table_columns.find(spec.x, "--x")
        axis = cube.axis(column)
        if axis is not None:
            return column, axis
        runs = _axis_behind(cube, column) or angle or runs
        if runs is not None:
            return cube.table_columns.find_numbers(column, "--x"), runs
    if runs is None:
        raise UsageError(
            "no axis with several values is left to run along x",
            where="--x",
            hint="`tendon state` prints a single design; "
            "colour and panels already use the other axes",
        )
    return runs.column, runs


def _named_axis(cube: Cube, name: str | None, where: str) -> Axis | None:
    """Return the axis of a column or key; None if the study has one value of it."""
    if name is None:
        return None
    axis = next((axis for axis in cube.axes if name in (axis.column, axis.key)), None)
    is_key = any(name in (key.path, key.column) for key in keys().values())
    if axis is None and not is_key and name != CASE_AXIS:
        column = cube.table_columns.find(name, where)
        names = ", ".join(axis.column for axis in cube.axes)
        raise UsageError(
            f"{column} is not an axis of the study", where=where, hint=f"axes: {names}"
        )
    return axis


def _usual_colour(free: list[Axis], panels: Axis | None) -> Axis | None:
    """Select the axis of the colours: the load, or else the first that has no part yet."""
    open_axes = [axis for axis in free if axis.column != DIRECTION and axis != panels]
    open_axes.sort(key=_is_limit)
    first = open_axes[0] if open_axes else None
    return next((axis for axis in open_axes if axis.column == LOAD), first)


def thin_out(
    cube: Cube, chosen: Mapping[str, Rows], most: Mapping[Any, int]
) -> tuple[dict[str, Rows], tuple[str, ...]]:
    """Select the positions drawn of each axis, evenly if there are more than `most`.

    An axis without an entry in `most` has no part in the figure and keeps one position.

    Returns:
        The positions by column, and a note if values are left out.
    """
    positions = {}
    fewer = []
    for axis in cube.axes:
        all_positions = chosen[axis.column]
        drawn = all_positions[evenly_spaced(len(all_positions), most.get(axis, 1))]
        positions[axis.column] = drawn
        if len(drawn) < len(all_positions):
            shown = cube.shown(axis.column)
            which = ""
            if len(drawn) == 1 and not axis.is_text:
                which = f" ({shown.equation(float(axis.values[int(drawn[0])]))})"
            fewer.append(f"{len(drawn):,} of {len(all_positions):,} values of {shown.name}{which}")
    if not fewer:
        return positions, ()
    return positions, (f"Shown: {say.join_words(fewer)}, evenly spaced.",)


def long_axes(cube: Cube, chosen: Mapping[str, Rows]) -> list[Axis]:
    """Return the axes other than the load with more than one chosen value, those of limits last."""
    long = [axis for axis in cube.axes if axis.column != LOAD and len(chosen[axis.column]) > 1]
    return sorted(long, key=_is_limit)


def is_table_of_loads(cube: Cube, chosen: Mapping[str, Rows]) -> bool:
    """Return True if rows of a table, few enough to stand by name, differ under several loads."""
    load = cube.axis(LOAD)
    axes = long_axes(cube, chosen)
    return (
        load is not None
        and len(chosen[LOAD]) > 1
        and len(axes) == 1
        and is_of_rows(axes[0])
        and len(chosen[axes[0].column]) <= MOST_NAMES
    )


def weight(axis: Axis, count: int) -> float:
    """Return how much an axis of so many values asks to be one of the map's two.

    A load counts half, because it is rather compared panel by panel, and a limit hardly, because no
    state changes along it.
    """
    if _is_limit(axis):
        return 0.0
    return count / 2.0 if axis.column == LOAD else float(count)


def map_axes(
    cube: Cube, chosen: Mapping[str, Rows], x: Axis | None = None, y: Axis | None = None
) -> tuple[Axis, Axis] | None:
    """Select the axes of a map: those asked for, or else the two of the most values.

    Of equally long ones those next to each other in the study belong together. Names stand up,
    where they are read without turning.

    Args:
        cube: The table.
        chosen: Positions to choose from, by the column of the axis.
        x: Axis across, if it is asked for.
        y: Axis up, if it is asked for.

    Returns:
        The axes across and up; None if fewer than two have several values.
    """
    long = [axis for axis in cube.axes if len(chosen[axis.column]) > 1 or axis in (x, y)]
    is_asked = x is not None
    weights = {axis: weight(axis, len(chosen[axis.column])) for axis in long}
    places = {axis: place for place, axis in enumerate(long)}
    if x is None:
        others = [axis for axis in long if axis is not y]
        x = max(others, key=lambda axis: weights[axis], default=None)
    others = [axis for axis in long if axis is not x]
    if y is None and x is not None and others:
        here = places[x]
        y = max(others, key=lambda axis: (weights[axis], -abs(places[axis] - here)))
        if x.is_text and not (y.is_text or is_asked):
            x, y = y, x
    return None if x is None or y is None or x is y else (x, y)


def _is_limit(axis: Axis) -> bool:
    """Return True for an axis of a limit, along which no state and so no margin changes."""
    return limit_of(axis.key) is not None
