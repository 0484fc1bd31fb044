"""Proofs that a window of pretension holds at every elbow angle: interval arithmetic over cells.

A limit on a form of states (`limits`) is g(θ) >= 0 at a pretension. On a cell of half-width h about
m it is at least the smallest of g(m) + g'(m) t + t²/2 inf g'' over |t| <= h; a cell where that is
negative is halved. As g is linear in pretension and load together, a limit that is kept at two
values of either is kept between them. Cells end at the knots of measured curves. SI units, angles
in radians.

Numbers of a design may be any within a box. A cell then has a range of each, as a share p of the
way from the box's middle to its end, and a limit falls from the middle of that by at most the sum
of |∂g/∂p| over the cell times half the range; the variable that contributes most is halved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags, Rows
from tendon_cli.model.motor import select_points
from tendon_cli.proof.enclosed_states import box_design, enclose_states, limit_values
from tendon_cli.proof.series import ORDER, Series

FIRST_CELLS = 8
"""Cells of the angle that a proof begins with, besides those that end at knots."""
MOST_CELLS = 2**20
"""Cells after which a proof is given up."""
_BOX_COST = 8  # one cell of a box takes as long as so many of angles alone
_AT_ONCE = 2**14  # cells
_NARROWEST = 1e-9  # rad, or share of the box: narrower cells are left undecided
_TYPICAL_HALF_WIDTH = 0.1  # rad; counts as much as a whole box if nothing says what to halve
_OUT = 1.0 + 1e-15  # a width is rounded
_ROUNDING = 1e-15  # relative error of a lower bound


@dataclass(frozen=True, eq=False)
class Cells:
    """Parts of the motion of designs, each at one end of a window, in one direction.

    All arrays have one entry per cell.
    """

    row: Rows
    """Row of the design."""
    flexion: Flags
    """True in flexion, else extension."""
    upper: Flags
    """True for the upper end of the window, else the lower."""
    low: Array
    """Lower ends of the angle (rad) and of each number of a box (-1 to 1), (cells, 1 + numbers)."""
    high: Array
    """Upper ends, likewise."""

    def __len__(self) -> int:
        return len(self.row)

    @property
    def middle(self) -> Array:
        """Middle of each cell, (cells, 1 + numbers)."""
        return np.asarray(0.5 * (self.low + self.high))

    def select(self, which: Any) -> Cells:
        """Select cells by index, slice or mask."""
        return Cells(**{name: values[which] for name, values in vars(self).items()})

    def halved(self, along: Rows) -> Cells:
        """Halve each cell along one of its variables, (cells,): 0 is the angle."""
        rows = np.arange(len(self))
        middle = self.middle[rows, along]
        high = self.high.copy()
        low = self.low.copy()
        high[rows, along] = middle
        low[rows, along] = middle
        return _concatenate([replace(self, high=high), replace(self, low=low)])


def _concatenate(parts: list[Cells]) -> Cells:
    """Concatenate cells of several parts."""
    names = vars(parts[0])
    return Cells(
        **{name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    )


@dataclass(frozen=True, eq=False)
class Proof:
    """Outcome of a proof; it succeeded if no cell is broken or left."""

    cells: int
    """Number of cells that were examined."""
    broken: Cells
    """Cells in the middle of which a limit is broken."""
    left: Cells
    """Cells that are left undecided, because they were too many or too narrow."""


def first_cells(
    count: int, angles: tuple[float, float], flexion: Flags, knots: Array, numbers: int = 0
) -> Cells:
    """Return the first cells of designs, in each direction, at both ends of windows.

    Args:
        count: Number of designs.
        angles: First and last elbow angle, rad.
        flexion: Directions of motion.
        knots: Angles at which cells must end, rad: those of kinks, and those where a limit begins.
        numbers: Count of numbers of a design that lie in a box; each cell spans the whole box.
    """
    low, high = angles
    inner_knots = knots[(knots > low) & (knots < high)]
    edges = np.unique([*np.linspace(low, high, FIRST_CELLS + 1), *inner_knots])
    places = np.arange(max(1, len(edges) - 1))
    axes = np.meshgrid(np.arange(count), flexion, [False, True], places, indexing="ij")
    row, direction, upper, place = (axis.ravel() for axis in axes)
    box = np.ones((len(row), numbers))
    next_place = np.minimum(place + 1, len(edges) - 1)
    return Cells(
        row,
        direction,
        upper,
        low=np.column_stack([edges[place], -box]),
        high=np.column_stack([edges[next_place], box]),
    )


def prove(
    design: Design,
    cells: Cells,
    low: Array,
    high: Array,
    bounds: Bounds,
    ends: Sequence[Design] = (),
) -> Proof:
    """Try to prove that designs keep all limits on states at both ends of their windows, in cells.

    Args:
        design: Designs, (designs, 1, 1); with a box, the designs in its middle.
        cells: Cells to begin with.
        low: Lower ends of the windows, (designs,), N.
        high: Upper ends of the windows, (designs,), N.
        bounds: Limits of the designs.
        ends: For each number of a box the designs in which this number is at its upper end.
    """
    none = cells.select(slice(0))
    todo = cells
    examined = 0
    broken = [none]
    undecided = [none]
    at_once = _AT_ONCE // (1 + len(ends))
    most_cells = MOST_CELLS // _BOX_COST if ends else MOST_CELLS
    while len(todo) and examined + len(todo) <= most_cells:
        examined += len(todo)
        halves = [none]
        for start in range(0, len(todo), at_once):
            part = todo.select(slice(start, start + at_once))
            points = part.row, np.zeros_like(part.row), np.zeros_like(part.row)
            middle, *at_ends = (
                select_points(designs, (len(low), 1, 1), points) for designs in (design, *ends)
            )
            pretension = np.where(part.upper, high[part.row], low[part.row])
            with np.errstate(all="ignore"):
                verdict = _judge(middle, at_ends, part, pretension, bounds)
            is_open = ~verdict.is_kept & ~verdict.is_broken
            is_narrow = (part.high - part.low < _NARROWEST).all(axis=1)
            broken.append(part.select(verdict.is_broken))
            undecided.append(part.select(is_open & is_narrow))
            is_halved = is_open & ~is_narrow
            halves.append(part.select(is_halved).halved(verdict.along[is_halved]))
        todo = _concatenate(halves)
    return Proof(examined, _concatenate(broken), _concatenate([*undecided, todo]))


class _Verdict(NamedTuple):
    """Decision on each cell, (cells,)."""

    is_kept: Flags
    """True where all limits are kept in all of the cell."""
    is_broken: Flags
    """True where a limit is broken in the middle of the cell."""
    along: Rows
    """Variable along which to halve the cell."""


def _judge(
    design: Design, ends: Sequence[Design], cells: Cells, pretension: Array, bounds: Bounds
) -> _Verdict:
    """Decide where limits are kept or broken, from enclosures in the middle of cells and over them.

    Args:
        design: Designs in the middle of the box, (cells,).
        ends: For each number of the box the designs at its upper end.
        cells: Cells.
        pretension: Pretension in each cell, N.
        bounds: Limits of the designs.
    """
    middle = cells.middle
    halves = np.maximum(cells.high - middle, middle - cells.low) * _OUT
    angle = middle[:, 0]
    box_halves = halves[:, 1:]
    at_point = box_design(design, ends, middle[:, 1:], 0.0 * box_halves)
    over_box = box_design(design, ends, middle[:, 1:], box_halves)
    state_in_middle = enclose_states(
        at_point, angle, np.zeros(()), cells.flexion, pretension, ORDER - 1
    )
    state_over_cell = enclose_states(
        over_box, angle, halves[:, 0], cells.flexion, pretension, ORDER
    )

    is_kept = np.ones(len(cells), dtype=np.bool_)
    is_broken = np.zeros(len(cells), dtype=np.bool_)
    worst = np.full(len(cells), np.inf)
    worst_falls = np.zeros(middle.shape)  # (cells, 1 + numbers)
    values_in_middle = limit_values(state_in_middle, bounds)
    values_over_cell = limit_values(state_over_cell, bounds)
    for in_middle, over_cell in zip(values_in_middle, values_over_cell, strict=True):
        value, radius = in_middle.value
        lowest, falls = _lower_bound(in_middle, over_cell, halves)
        is_kept &= lowest >= 0.0
        is_broken |= value + radius < 0.0
        lowest = np.where(np.isnan(lowest), -np.inf, lowest)
        is_worse = lowest < worst
        worst_falls[is_worse] = falls[is_worse]
        worst = np.minimum(worst, lowest)

    # Halve the variable that lets the worst limit fall most, or the widest if that is unbounded.
    sizes = halves / np.append(_TYPICAL_HALF_WIDTH, np.ones(len(ends)))
    is_bounded = np.isfinite(worst_falls).all(axis=1, keepdims=True)
    worst_falls = np.where(is_bounded, worst_falls, sizes)
    has_width = cells.high - cells.low > 0.0
    return _Verdict(is_kept, is_broken, np.where(has_width, worst_falls, -1.0).argmax(axis=1))


def _lower_bound(in_middle: Series, over_cell: Series, halves: Array) -> tuple[Array, Array]:
    """Return a lower bound of a limit's value over cells, and how far each variable lets it fall.

    Args:
        in_middle: The value and its slope in the middle of the cells.
        over_cell: Its second derivative and its partial derivatives over the cells.
        halves: Half-widths of the cells, (cells, 1 + numbers).

    Returns:
        Lower bounds, (cells,), and falls, (cells, 1 + numbers).
    """
    half = halves[:, 0]
    value, value_radius = in_middle.value
    slope, slope_radius = in_middle.terms[1] or (0.0, 0.0)
    bend, bend_radius = over_cell.terms[2] or (0.0, 0.0)
    steepness = abs(slope) + slope_radius
    lowest_bend = bend - bend_radius  # inf g''/2

    # The parabola falls to its vertex, or to the end of the cell if that is nearer.
    vertex = steepness / np.asarray(2.0 * lowest_bend)
    has_vertex = (lowest_bend > 0.0) & (vertex < half)
    distance = np.where(has_vertex, vertex, half)
    falls = np.zeros(halves.shape)
    falls[:, 0] = steepness * distance - lowest_bend * distance * distance
    for place, derivative in over_cell.partials.items():
        change, change_radius = derivative.value
        falls[:, 1 + place] = (abs(change) + change_radius) * halves[:, 1 + place] * _OUT
    rounding = _ROUNDING * (abs(value) + steepness * half + abs(lowest_bend) * half * half)
    lowest = value - value_radius - falls.sum(axis=1) - rounding
    return np.broadcast_to(lowest, half.shape), falls
