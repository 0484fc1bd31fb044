"""Which lines a figure of curves shows: what runs along x, what is told by colour, by dashes and by panels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from tendon_cli.errors import UsageError
from tendon_cli.figures.map_plan import LOAD, words
from tendon_cli.figures.product import Axis, Ints, Product, evenly
from tendon_cli.figures.request import PlotRequest, find_column, find_numbers

DIRECTION, ANGLE = "direction", "elbow_angle"
MOST_COLOURS = 6
MOST_PANELS = 12
MOST_PANELS_UNASKED = 4
MOST_QUANTITIES = 8
POINTS = 1000

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
    fixed: tuple[Axis, ...]
    """Axes of which one of several values was taken."""
    notes: tuple[str, ...]

    @property
    def parts(self) -> tuple[Axis | None, ...]:
        """Panels, colour, dashes, x: the order of the values' dimensions."""
        return self.panels, self.colour, self.dash, self.x

    def rows(self, product: Product) -> Ints:
        """Rows of all lines, of shape (panels, colours, dashes, x)."""
        order = [axis.column for axis in self.parts if axis is not None]
        shape = [1 if axis is None else len(self.positions[axis.column]) for axis in self.parts]
        return product.rows(order, self.positions).reshape(shape)


def plan_curves(product: Product, chosen: Mapping[str, Ints], request: PlotRequest) -> CurvePlan:
    """Give each axis its part; raises UsageError where the request does not fit the table."""
    quantities = _quantities(product, request)
    long = [axis for axis in product.axes if len(chosen[axis.column]) > 1]
    named = _named(product, request.colour, "--colour"), _named(product, request.panels, "--panels")
    x_column, x = _along_x(product, request, [axis for axis in long if axis not in named])
    free = [axis for axis in long if axis is not x]
    colour, panels = named[0] or _usual_colour(free, request), named[1]
    dash = next((axis for axis in free if axis.column == DIRECTION and axis not in (colour, panels)), None)
    if panels is None and len(quantities) == 1:
        panels = next((axis for axis in free if axis not in (colour, dash)), None)
    parts = [axis for axis in (x, colour, dash, panels) if axis is not None]
    if len(set(parts)) < len(parts):
        raise UsageError("one axis cannot play two parts", hint="x, colour and panels name different axes")
    positions, notes = _thinned(
        product, chosen, {x: POINTS, colour: MOST_COLOURS, panels: _most_panels(quantities, request)}
    )
    fixed = tuple(axis for axis in long if axis not in parts)
    for axis in product.axes:
        if axis not in parts:
            at = chosen[axis.column]
            positions[axis.column] = at[evenly(len(at), 1)]
    return CurvePlan(quantities, x_column, x, colour, dash, panels, positions, fixed, tuple(notes))


def _quantities(product: Product, request: PlotRequest) -> tuple[str, ...]:
    if len(request.quantities) > MOST_QUANTITIES:
        raise UsageError(f"{len(request.quantities)} quantities, at most {MOST_QUANTITIES} fit on a page")
    if request.quantities:
        found = [find_numbers(product, name, "--quantity") for name in request.quantities]
        return tuple(dict.fromkeys(found))
    if product.table.facts["table"] == "designs":
        return (find_numbers(product, "margin", "--quantity"),)
    return tuple(find_numbers(product, name, "--quantity") for name in STATE_PAIRS)


def _along_x(product: Product, request: PlotRequest, long: list[Axis]) -> tuple[str, Axis]:
    """The column along x, and the axis that runs along it."""
    usual = [axis for axis in long if axis.column not in (LOAD, DIRECTION)] or long
    angle = next((axis for axis in product.axes if axis.column == ANGLE), None)
    runs = angle if angle in long or not usual else usual[0]
    if request.x is not None:
        column = find_column(product, request.x, "--x")
        axis = product.axis(column)
        if axis is not None:
            return column, axis
        runs = angle or runs
        if runs is not None:
            return find_numbers(product, column, "--x"), runs
    if runs is None and product.table.rows > 1:
        raise UsageError("no axis is left to run along x", where="--x", hint="colour and panels take other axes")
    if runs is None:
        hint = "`tendon state` prints a single design"
        raise UsageError("the table holds one design, there is nothing to draw it against", hint=hint)
    return runs.column, runs


def _named(product: Product, name: str | None, where: str) -> Axis | None:
    if name is None:
        return None
    column = find_column(product, name, where)
    axis = product.axis(column)
    if axis is None:
        names = ", ".join(axis.column for axis in product.axes)
        raise UsageError(f"{column} is not an axis of the study", where=where, hint=f"axes: {names}")
    return axis


def _usual_colour(free: list[Axis], request: PlotRequest) -> Axis | None:
    """The load, or else the first axis that nothing was asked of."""
    open_axes = [axis for axis in free if axis.column != DIRECTION and request.panels not in (axis.column, axis.key)]
    return next((axis for axis in open_axes if axis.column == LOAD), open_axes[0] if open_axes else None)


def _most_panels(quantities: tuple[str, ...], request: PlotRequest) -> int:
    return MOST_PANELS if len(quantities) == 1 and request.panels else MOST_PANELS_UNASKED


def _thinned(
    product: Product, chosen: Mapping[str, Ints], most: Mapping[Axis | None, int]
) -> tuple[dict[str, Ints], list[str]]:
    """Positions drawn on the axes that play a part, and what was left out of them."""
    positions: dict[str, Ints] = {}
    notes: list[str] = []
    for axis in product.axes:
        at = chosen[axis.column]
        kept = evenly(len(at), most.get(axis, len(at)))
        positions[axis.column] = at[kept]
        if len(kept) < len(at):
            notes.append(f"{len(kept)} of {len(at)} values of {words(axis)} drawn, evenly chosen.")
    return positions, notes
