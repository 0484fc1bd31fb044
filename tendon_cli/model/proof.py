"""Proofs that a window of pretension holds at every elbow angle: interval arithmetic over cells of the angle.

A limit on a form of states (`limits`) is g(θ) >= 0 at a pretension. On a cell of half-width h about m it is at least
the smallest of g(m) + g'(m) t + t²/2 inf g'' over |t| <= h; a cell where that is negative is halved. As g is linear in
pretension and in what the load asks for together, it holds between two of either if it does at both. All is by the
general balance, x = (τ c_e + J_e D)/det, y = (J_f D - η c_f τ)/det, D = H_e - η H_f + (η c_f + c_e)_0 F, so that joints
and bends that follow measured curves are enclosed, too; cells end at their knots. SI units, angles in radians.

Numbers of a design may be any within a box: a cell then has a range of each, as a share p of the way from the box's
middle to its end, and a limit falls from the middle of that by at most the sum of |∂g/∂p| over the cell times half the
range; what contributes most is halved.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import Design, changed
from tendon_cli.model.enclosure import COMPUTED, ORDER, Series
from tendon_cli.model.kinematics import AnyJoint, Array, Excursion, Flags, Spline
from tendon_cli.model.motor import select_points
from tendon_cli.model.sheath import sheaths_of

Rows = npt.NDArray[np.int64]

FIRST_CELLS = 8
MOST_CELLS = 2**20
_AT_ONCE = 2**14
_NARROWEST = 1e-9  # rad, and of the way to the end of a box; what is not decided there is left
_USUAL = 0.1  # rad; half of a cell of the angle that is as wide as a whole box, if nothing else says which to halve


@dataclass(frozen=True, eq=False)
class Cells:
    """Parts of the motion of designs, each at one pretension in one direction; arrays of one length."""

    row: Rows
    """Which design."""
    flexion: Flags
    upper: Flags
    """Whether it is the upper end of the window that is held."""
    low: Array
    high: Array
    """From where to where, (cells, 1 + numbers in a box): of the angle, rad, and of each number from -1 to 1."""

    def __len__(self) -> int:
        return len(self.row)

    @property
    def middle(self) -> Array:
        """Of each."""
        return np.asarray(0.5 * (self.low + self.high))

    def select(self, which: Any) -> Cells:
        """Some of them."""
        return Cells(**{name: values[which] for name, values in vars(self).items()})

    def halved(self, along: Rows) -> Cells:
        """Each in two, along the variable at a place."""
        first, second, each = self.high.copy(), self.low.copy(), np.arange(len(self))
        first[each, along] = second[each, along] = self.middle[each, along]
        return _joined([replace(self, high=first), replace(self, low=second)])


def _joined(parts: list[Cells]) -> Cells:
    return Cells(
        **{name: np.concatenate([getattr(part, name) for part in parts]) for name in vars(parts[0])}
    )


@dataclass(frozen=True, eq=False)
class Proof:
    """What became of the cells."""

    cells: int
    broken: Cells
    """In the middle of which a limit is not kept."""
    left: Cells
    """That are not decided, for they are too many or too narrow."""


def cells_of(
    count: int, angles: tuple[float, float], flexion: Flags, knots: Array, numbers: int = 0
) -> Cells:
    """The first cells of designs from angle to angle, in each direction, at both ends of windows, of whole boxes."""
    low, high = angles
    edges = np.unique(
        [*np.linspace(low, high, FIRST_CELLS + 1), *knots[(knots > low) & (knots < high)]]
    )
    parts = np.arange(max(1, len(edges) - 1))
    row, ways, upper, place = map(
        np.ravel, np.meshgrid(np.arange(count), flexion, [False, True], parts, indexing="ij")
    )
    box = np.ones((len(row), numbers))
    ends = edges[place], edges[np.minimum(place + 1, len(edges) - 1)]
    return Cells(
        row, ways, upper, np.column_stack([ends[0], -box]), np.column_stack([ends[1], box])
    )


def prove(
    design: Design,
    cells: Cells,
    low: Array,
    high: Array,
    bounds: Bounds,
    ends: Sequence[Design] = (),
) -> Proof:
    """Whether designs, (designs, 1, 1), keep all limits on states from `low` to `high` (N) in cells.

    `ends` has, of a box about them, for each number the designs in which this one is at its upper end.
    """
    none, todo, count = cells.select(slice(0)), cells, 0
    broken, left = [none], [none]
    at_once, most = (_AT_ONCE // (1 + len(ends)), MOST_CELLS // (1 + 7 * bool(ends)))
    while len(todo) and count + len(todo) <= most:
        count += len(todo)
        rest = [none]
        for part in (todo.select(slice(at, at + at_once)) for at in range(0, len(todo), at_once)):
            at = (part.row, np.zeros_like(part.row), np.zeros_like(part.row))
            some, *of_ends = (select_points(each, (len(low), 1, 1), at) for each in (design, *ends))
            with np.errstate(all="ignore"):
                pretension = np.where(part.upper, high[part.row], low[part.row])
                kept, fails, along = _kept(some, of_ends, part, pretension, bounds)
            narrow = (part.high - part.low < _NARROWEST).all(axis=1)
            broken.append(part.select(fails))
            left.append(part.select(~kept & ~fails & narrow))
            halve = ~kept & ~fails & ~narrow
            rest.append(part.select(halve).halved(along[halve]))
        todo = _joined(rest)
    return Proof(count, _joined(broken), _joined([*left, todo]))


def _kept(
    design: Design, ends: Sequence[Design], cells: Cells, pretension: Array, bounds: Bounds
) -> tuple[Flags, Flags, Rows]:
    """Whether all limits are kept in all of each cell, whether one is broken in its middle, and what to halve."""
    middle, halves = (
        cells.middle,
        np.maximum(cells.high - cells.middle, cells.middle - cells.low) * (1.0 + 1e-15),
    )
    angle, half, about = middle[:, 0], halves[:, 0], halves[:, 1:]
    at_point, over_box = (
        within(design, ends, middle[:, 1:], size) for size in (0.0 * about, about)
    )
    at_middle = _held(
        enclosed(at_point, angle, np.zeros(()), cells.flexion, pretension, ORDER - 1), bounds
    )
    over_cell = _held(enclosed(over_box, angle, half, cells.flexion, pretension, ORDER), bounds)
    kept, fails = np.ones(len(cells), dtype=np.bool_), np.zeros(len(cells), dtype=np.bool_)
    worst, falls = np.full(len(cells), np.inf), np.zeros(middle.shape)
    for point, whole in zip(at_middle, over_cell, strict=True):
        (value, near), (slope, slope_about) = (term or (0.0, 0.0) for term in point.terms[:2])
        bend, bend_about = whole.terms[2] or (0.0, 0.0)
        least, steep, bend = value - near, abs(slope) + slope_about, bend - bend_about
        vertex = steep / np.asarray(2.0 * bend)
        turn = np.where((bend > 0.0) & (vertex < half), vertex, half)
        moves = np.zeros(middle.shape)
        moves[:, 0] = steep * turn - bend * turn * turn
        for place, partial in whole.partials.items():
            slope, slope_about = partial.value
            moves[:, 1 + place] = (abs(slope) + slope_about) * about[:, place] * (1.0 + 1e-15)
        rounding = 1e-15 * (abs(value) + steep * half + abs(bend) * half * half)
        lowest = np.broadcast_to(least - moves.sum(axis=1) - rounding, kept.shape)
        kept &= lowest >= 0.0
        fails |= value + near < 0.0
        lowest = np.where(np.isnan(lowest), -np.inf, lowest)
        falls[lowest < worst] = moves[lowest < worst]
        worst = np.minimum(worst, lowest)
    sizes = halves / np.append(_USUAL, np.ones(len(ends)))
    falls = np.where(np.isfinite(falls).all(axis=1, keepdims=True), falls, sizes)
    return kept, fails, np.where(cells.high - cells.low > 0.0, falls, -1.0).argmax(axis=1)


def within(design: Design, ends: Sequence[Design], middle: Array, half: Array) -> Design:
    """A design whose numbers in a box are series, within `half` of their middle, (cells, numbers).

    Numbers are straight lines of the share of the way to the end of the box.
    """

    def moving(number: Any, *at_ends: Any) -> Any:
        for place, end in enumerate(at_ends if number.dtype == np.float64 else ()):
            apart = np.where((number == end) | np.isnan(number), 0.0, end - number)
            if np.any(apart):
                size = np.abs(apart) * half[:, place]
                return Series.number(number + apart * middle[:, place], size, apart, place)
        return number

    boxed: Design = changed(design, moving, *ends)
    return boxed


def _held(state: Any, bounds: Bounds) -> Iterator[Series]:
    """What must not be negative: the flexor's arm less a rounded zero, both tensions, and each limit's distance."""
    yield from state.arms
    yield state.x
    yield state.y
    for limit in bounds.asked:
        for form in () if limit.forms is None else limit.forms(state, bounds.speed):
            shares = (
                (form.flexor, state.x),
                (form.extensor, state.y),
                (form.stiffness, state.stiffness),
            )
            value = sum(
                (Series.of(share, COMPUTED) * part for share, part in shares),
                Series.of(form.constant, COMPUTED),
            )
            least, most = limit.range_of(bounds[limit.name])
            if least is not None:
                yield value - least
            if most is not None:
                yield most - value


def enclosed(
    design: Design, middle: Array, half: Array, flexion: Flags, pretension: Array, order: int
) -> SimpleNamespace:
    """States over cells as series, with the names that forms of limits ask a `State` for."""
    angle: Any = Series.variable(middle, half, order)
    path, flexor_travel, extensor_travel = _travels(design.arm.joint, angle)
    arm, extensor_arm, ratio = flexor_travel.slope(), extensor_travel.slope(), design.ratio
    sides = [_in_series(side) for side in (design.flexor, design.extensor)]
    at_angle = before = sheaths_of(sides[0], sides[1], angle, flexion)
    if design.follows:
        before = sheaths_of(sides[0], sides[1], Series.of(design.setting.angle), flexion)  # type: ignore[arg-type]
    (c_f, c_e), resting = (
        [Series.of(side.compliance, COMPUTED) for side in both] for both in (at_angle, before)
    )
    torque = _torque(design, angle)
    apart = extensor_travel - ratio * flexor_travel + (ratio * resting[0] + resting[1]) * pretension
    det = arm * c_e + extensor_arm * (ratio * c_f)
    x, y = (torque * c_e + extensor_arm * apart) / det, (arm * apart - ratio * c_f * torque) / det
    of_flexor, of_extensor = (
        each.slope() - each * c.slope() / c for each, c in ((arm, c_f), (extensor_arm, c_e))
    )
    stiffness = (
        arm * arm / c_f
        + extensor_arm * extensor_arm / c_e
        + torque.slope()
        - of_flexor * x
        + of_extensor * y
    )
    flexor, extensor = at_angle
    return SimpleNamespace(
        arms=(arm, extensor_arm),
        x=x,
        y=y,
        stiffness=stiffness,
        flexor=flexor,
        extensor=extensor,
        design=design,
        motion=SimpleNamespace(flexor_path=path),
        speed=None,
        coupling=SimpleNamespace(
            ratio=ratio,
            extensor_arm=extensor_arm,
            moment_arm=arm,
            flexor_compliance=c_f,
            extensor_compliance=c_e,
        ),
        motor_arms=(
            design.flexor_radius / flexor.capstan,
            ratio * design.flexor_radius / extensor.capstan,
        ),
    )


def _travels(joint: AnyJoint, angle: Any) -> Any:
    """The flexor's path, if the joint tells, and both travels, m."""
    if isinstance(joint, Excursion):
        origin: Any = Series.of(joint.origin)
        return None, *(
            (curve(angle) - curve(origin)) * joint.scale for curve in (joint.flexor, joint.extensor)
        )
    a1, b1, a2, b2 = (Series.of(each) for each in (joint.a1, joint.b1, joint.a2, joint.b2))
    squares, along, across = (
        a1 * a1 + b1 * b1 + a2 * a2 + b2 * b2,
        2.0 * (b1 * b2 - a1 * a2),
        2.0 * (a1 * b2 + a2 * b1),
    )
    path, start = (
        np.sqrt(squares + along * np.cos(angle) - across * np.sin(angle)),
        np.sqrt(squares + along),
    )
    return path, np.where(joint.from_initial, start, b1 + b2) - path, angle * joint.elbow_radius


def _torque(design: Design, angle: Any) -> Any:
    """What weights, joint and task ask for, N m."""
    weights: Any = Series.of(design.gravity_moment, COMPUTED)
    return weights * np.sin(angle + design.arm.upper_arm_angle) + design.other_torque(angle)


def _in_series(side: Any) -> Any:
    """A side with series for all of its numbers if it has any, or bends with the joint, so that nothing is rounded."""
    numbers = {name: value for name, value in vars(side).items() if name != "spring_at_motor"}
    if any(isinstance(value, Series | Spline) for value in numbers.values()):
        numbers = {
            name: value if isinstance(value, Spline) else Series.of(value)
            for name, value in numbers.items()
        }
    return replace(side, **numbers)
