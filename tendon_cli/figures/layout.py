"""What a figure shows of a table: which axes run along x and y, by colour, dashes and panels, and what is left out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from tendon_cli.cube.axes import ANGLE, DIRECTION, LOAD, TIME, Ints, evenly
from tendon_cli.cube.columns import DERIVED
from tendon_cli.cube.cube import Cube
from tendon_cli.errors import UsageError
from tendon_cli.space.axis import CASE_AXIS, Axis
from tendon_cli.studies.figures import MOST_QUANTITIES, OF_STATES, FigureSpec
from tendon_cli.studies.study import keys

MOST_COLOURS = 6
MOST_PANELS, PANELS_PER_PAGE = 24, 12
MOST_PANELS_UNASKED = 4
POINTS = 1000
CELLS_PER_AXIS = 400

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
"""Drawn of `states` when nothing else is asked for, two in a row."""


@dataclass(frozen=True)
class CurvePlan:
    """The part that each axis plays, and the positions drawn."""

    quantities: tuple[str, ...]
    x_column: str
    """What stands along x: the column of `x`, or another that changes along it."""
    x: Axis
    colour: Axis | None
    dash: Axis | None
    """The direction of motion, unless it plays another part."""
    panels: Axis | None
    positions: Mapping[str, Ints]
    notes: tuple[str, ...]

    @property
    def parts(self) -> tuple[Axis | None, ...]:
        """Panels, colour, dashes, x: the order of the values' dimensions."""
        return self.panels, self.colour, self.dash, self.x

    def rows(self, cube: Cube) -> Ints:
        """Rows of all lines, of shape (panels, colours, dashes, x)."""
        order = [axis.column for axis in self.parts if axis is not None]
        shape = [1 if axis is None else len(self.positions[axis.column]) for axis in self.parts]
        return cube.rows(order, self.positions).reshape(shape)


def plan_curves(cube: Cube, chosen: Mapping[str, Ints], spec: FigureSpec) -> CurvePlan:
    """Give each axis its part; raises UsageError where the figure does not fit the table."""
    quantities = _quantities(cube, spec)
    long = [axis for axis in cube.axes if len(chosen[axis.column]) > 1]
    named = _named(cube, spec.colour, "--colour"), _named(cube, spec.panels, "--panels")
    x_column, x = _along_x(cube, spec, [axis for axis in long if axis not in named])
    free = [axis for axis in long if axis is not x]
    panels = named[1] or (_usual_panels(free) if spec.overlay else None)
    colour = None if spec.overlay else named[0] or _usual_colour(free, panels)
    dash = next(
        (axis for axis in free if axis.column == DIRECTION and axis not in (colour, panels)), None
    )
    if panels is None and len(quantities) == 1:
        panels = next((axis for axis in free if axis not in (colour, dash)), None)
    parts = [axis for axis in (x, colour, dash, panels) if axis is not None]
    if len(set(parts)) < len(parts):
        raise UsageError(
            "one axis cannot play two parts", hint="x, colour and panels name different axes"
        )
    most_panels = MOST_PANELS if len(quantities) == 1 and spec.panels else MOST_PANELS_UNASKED
    most = {x: POINTS, colour: MOST_COLOURS, dash: 2, panels: most_panels}
    return CurvePlan(quantities, x_column, x, colour, dash, panels, *_thinned(cube, chosen, most))


def _quantities(cube: Cube, spec: FigureSpec) -> tuple[str, ...]:
    if spec.quantity:
        names = [cube.of.find_numbers(name, "--quantity") for name in spec.quantity]
        return tuple(dict.fromkeys(names))
    if cube.kind == "designs":
        return (cube.of.find_numbers("margin", "--quantity"),)
    kept = [name for name in OF_STATES if name in cube.columns and name not in DERIVED]
    if not kept:
        raise UsageError(
            "the table keeps no results",
            where="--quantity",
            hint="[output] states names those it keeps",
        )
    return tuple(name for name in STATE_PAIRS if name in kept) or tuple(kept[:MOST_QUANTITIES])


def _along_x(cube: Cube, spec: FigureSpec, long: list[Axis]) -> tuple[str, Axis]:
    """The column along x, and the axis that runs along it."""
    usual = [axis for axis in long if axis.column not in (LOAD, DIRECTION)] or long
    usual.sort(key=lambda axis: axis.is_text)
    angle = next((axis for axis in cube.axes if axis.column in (ANGLE, TIME)), None)
    runs = angle if angle in long or not usual else usual[0]
    if spec.x is not None:
        column = cube.of.find(spec.x, "--x")
        if (axis := cube.axis(column)) is not None:
            return column, axis
        runs = angle or runs
        if runs is not None:
            return cube.of.find_numbers(column, "--x"), runs
    if runs is None:
        hint = "`tendon state` prints a single design; colour and panels take axes away"
        raise UsageError(
            "no axis with several values is left to run along x", where="--x", hint=hint
        )
    return runs.column, runs


def _named(cube: Cube, name: str | None, where: str) -> Axis | None:
    """The axis of a column or key; none where the study has one value of it."""
    if name is None:
        return None
    axis = next((axis for axis in cube.axes if name in (axis.column, axis.key)), None)
    if (
        axis is None
        and not any(name in (key.path, key.column) for key in keys().values())
        and name != CASE_AXIS
    ):
        column = cube.of.find(name, where)
        names = ", ".join(axis.column for axis in cube.axes)
        raise UsageError(
            f"{column} is not an axis of the study", where=where, hint=f"axes: {names}"
        )
    return axis


def _usual_colour(free: list[Axis], panels: Axis | None) -> Axis | None:
    """The load, or else the first axis that nothing was asked of."""
    open_axes = [axis for axis in free if axis.column != DIRECTION and axis != panels]
    return next(
        (axis for axis in open_axes if axis.column == LOAD), open_axes[0] if open_axes else None
    )


def _usual_panels(free: list[Axis]) -> Axis | None:
    """The same of the axes that do not run along x or by dashes."""
    return _usual_colour([axis for axis in free if axis.column != ANGLE], None)


def _thinned(
    cube: Cube, chosen: Mapping[str, Ints], most: Mapping[Axis | None, int]
) -> tuple[dict[str, Ints], tuple[str, ...]]:
    """Positions drawn on each axis, evenly chosen where there are more than `most`, and a note of what is left out."""
    positions, fewer = {}, []
    for axis in cube.axes:
        at = chosen[axis.column]
        kept = positions[axis.column] = at[evenly(len(at), most.get(axis, 1))]
        if len(kept) < len(at):
            fewer.append(f"{len(kept)} of {len(at)} values of {cube.shown(axis.column).name}")
    return positions, (f"{', '.join(fewer)} drawn, evenly chosen.",) if fewer else ()


@dataclass(frozen=True)
class MapPlan:
    """Axes and positions of all panels."""

    x: Axis
    y: Axis
    titled: tuple[Axis, ...]
    """Axes that differ between the panels, the load first."""
    positions: Mapping[str, Ints]
    notes: tuple[str, ...]

    def rows(self, cube: Cube) -> Ints:
        """Rows of all panels, of shape (panels, y, x); the load varies fastest, so that it is seen side by side."""
        order = [axis.column for axis in (*reversed(self.titled), self.y, self.x)]
        rows = cube.rows(order, self.positions)
        return rows.reshape(-1, *rows.shape[-2:])


def long_axes(cube: Cube, chosen: Mapping[str, Ints]) -> list[Axis]:
    """Axes other than the load of which more than one value is chosen."""
    return [axis for axis in cube.axes if axis.column != LOAD and len(chosen[axis.column]) > 1]


def plan_maps(cube: Cube, chosen: Mapping[str, Ints]) -> MapPlan:
    """Lay the designs out over panels; `chosen` are the positions to choose from, of two long axes at least."""
    x, y = long_axes(cube, chosen)[:2]
    others = [axis for axis in cube.axes if axis not in (x, y) and len(chosen[axis.column]) > 1]
    others.sort(key=lambda axis: axis.column != LOAD)
    lengths = [len(chosen[axis.column]) for axis in others]
    counts = lengths if math.prod(lengths) <= MOST_PANELS else _counts(lengths, PANELS_PER_PAGE)
    most: dict[Axis | None, int] = {
        x: CELLS_PER_AXIS,
        y: CELLS_PER_AXIS,
        **dict(zip(others, counts, strict=True)),
    }
    positions, notes = _thinned(cube, chosen, most)
    return MapPlan(
        x, y, tuple(axis for axis in others if len(positions[axis.column]) > 1), positions, notes
    )


def _counts(lengths: list[int], most: int) -> list[int]:
    """How many values of each axis, so that their product is at most `most`: the first axis, the load, gets most."""
    counts = [1] * len(lengths)
    for at, length in enumerate(lengths):
        counts[at] = max(
            1, min(length, most // math.prod(counts), 4 if at == 0 and len(lengths) > 1 else length)
        )
    return counts
