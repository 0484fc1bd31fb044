"""Cells of the angle and of a box of numbers, and what interval arithmetic decides on each.

A limit on a form of states (`limits`) is g(θ) >= 0 at a pretension. On a cell of half-width h about
m it is at least the smallest of g(m) + g'(m) t + t²/2 inf g'' over |t| <= h; a cell where that is
negative is halved. As g is linear in pretension and load together, a limit that is kept at two
values of either is kept between them. Cells end at the knots of measured curves. SI units, angles
in radians.

Numbers of a design may be any within a box. A cell then has a range of each, as a share p of the
way from the box's middle to its end, and a limit falls from the middle of that by at most the sum
of |∂g/∂p| over the cell times half the range; the variable that contributes most is halved.

The upper arm may lean at any angle within an arc. As g is linear in sine and cosine of that, one
point just beyond the arc stands for all of it (`ConditionArcs`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags, Rows
from tendon_cli.proof.enclosed_states import box_design, enclose_states, limit_values
from tendon_cli.proof.series import ORDER, Series

MOST_CELLS = 2**20
"""Cells after which the proof of a choice is given up."""
_BOX_COST = 8  # one cell of a box takes as long as so many of angles alone
_AT_ONCE = 2**14  # cells
_NARROWEST = 1e-9  # rad, or share of the box: cells narrower in all variables are not halved
_TYPICAL_HALF_WIDTH = 0.1  # rad; counts as much as a whole box if nothing says what to halve
_OUT = 1.0 + 1e-15  # a width is rounded
_ROUNDING = 1e-15  # relative error of a lower bound


def most_cells(numbers: int) -> int:
    """Return the number of cells after which the proof of a choice is given up.

    Args:
        numbers: Count of numbers of its designs that lie in a box.
    """
    return MOST_CELLS // _BOX_COST if numbers else MOST_CELLS


def cells_at_once(numbers: int) -> int:
    """Return the number of cells that fit into memory together.

    Args:
        numbers: Count of numbers of a design that lie in a box.
    """
    return _AT_ONCE // (1 + numbers)


@dataclass(frozen=True, eq=False)
class Cells:
    """Parts of the motion of designs, each at one end of a window, in one direction.

    All arrays have one entry per cell.
    """

    row: Rows
    """Row of the design's condition."""
    flexion: Flags
    """True in flexion, else extension."""
    upper: Flags
    """True for the upper end of the window, else the lower."""
    low: Array
    """Lower ends, (cells, 2 + numbers): of the angle, rad, of each number of a box, -1 to 1, and of
    the arc of postures, rad. The latter is NaN where the posture is that of the condition."""
    high: Array
    """Upper ends, likewise."""

    def __len__(self) -> int:
        return len(self.row)

    @property
    def middle(self) -> Array:
        """Middle of each cell, (cells, 2 + numbers)."""
        return np.asarray(0.5 * (self.low + self.high))

    @property
    def is_narrow(self) -> Flags:
        """True for each cell that is too narrow to be halved."""
        return np.asarray(~(self.high - self.low >= _NARROWEST).any(axis=1))

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
        return concatenate([replace(self, high=high), replace(self, low=low)])


def concatenate(parts: Sequence[Cells]) -> Cells:
    """Concatenate cells of several parts."""
    names = vars(parts[0])
    return Cells(
        **{name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    )


class Setup(NamedTuple):
    """Designs of cells, (cells,), at their pretensions."""

    design: Design
    """Designs in the middle of the box."""
    ends: Sequence[Design]
    """For each number of the box the designs at its upper end."""
    pretension: Array
    """Pretensions as F0, N."""


class Verdict(NamedTuple):
    """Decision on each cell, (cells,)."""

    is_kept: Flags
    """True where all limits are kept in all of the cell."""
    is_broken: Flags
    """True where a limit is broken in the middle of the cell."""
    along: Rows
    """Variable along which to halve the cell."""


def judge(cells: Cells, beyond: Setup, within: Setup, bounds: Bounds) -> Verdict:
    """Decide where limits are kept or broken, from enclosures in the middle of cells and over them.

    Args:
        cells: Cells.
        beyond: Designs at the points that stand for arcs of postures.
        within: Designs in the middle of these arcs; the same object if each is a single posture.
        bounds: Limits of the designs.
    """
    middle = cells.middle
    widths = cells.high - cells.low
    halves = (np.maximum(cells.high - middle, middle - cells.low) * _OUT)[:, :-1]
    over_box = box_design(beyond.design, beyond.ends, middle[:, 1:-1], halves[:, 1:])
    state_over_cell = enclose_states(
        over_box, middle[:, 0], halves[:, 0], cells.flexion, beyond.pretension, ORDER
    )
    values_over_cell = limit_values(state_over_cell, bounds)
    values_beyond = _values_in_middle(cells, beyond, bounds)
    values_within = values_beyond
    if within is not beyond:
        values_within = _values_in_middle(cells, within, bounds)

    is_kept = np.ones(len(cells), dtype=np.bool_)
    is_broken = np.zeros(len(cells), dtype=np.bool_)
    worst = np.full(len(cells), np.inf)
    worst_falls = np.zeros(middle.shape)  # (cells, 2 + numbers)
    series = zip(values_beyond, values_within, values_over_cell, strict=True)
    for in_middle, in_posture, over_cell in series:
        lowest, falls = _lower_bound(in_middle, over_cell, halves)
        value, radius = in_posture.value
        is_kept &= lowest >= 0.0
        is_broken |= value + radius < 0.0
        fall_of_posture = np.broadcast_to(value - in_middle.value[0], lowest.shape)
        falls = np.column_stack([falls, fall_of_posture])
        lowest = np.where(np.isnan(lowest), -np.inf, lowest)
        is_worse = lowest < worst
        worst_falls[is_worse] = falls[is_worse]
        worst = np.minimum(worst, lowest)

    # Halve the variable that lets the worst limit fall most, or the widest if that is unbounded.
    typical = np.ones(widths.shape[1])
    typical[[0, -1]] = _TYPICAL_HALF_WIDTH
    is_bounded = np.isfinite(worst_falls).all(axis=1, keepdims=True)
    worst_falls = np.where(is_bounded, worst_falls, 0.5 * widths / typical)
    along = np.where(widths > 0.0, worst_falls, -np.inf).argmax(axis=1)
    return Verdict(is_kept, is_broken, along)


def _values_in_middle(cells: Cells, setup: Setup, bounds: Bounds) -> list[Series]:
    """Return series of the values that must not be negative, in the middle of cells."""
    middle = cells.middle
    at_point = box_design(setup.design, setup.ends, middle[:, 1:-1], None)
    state = enclose_states(
        at_point, middle[:, 0], np.zeros(()), cells.flexion, setup.pretension, ORDER - 1
    )
    return list(limit_values(state, bounds))


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
