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

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.model.actuator import STANDARD_GRAVITY
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import Design, Side
from tendon_cli.model.enclosure import ORDER, Series
from tendon_cli.model.kinematics import Anchors, Array, Excursion, Flags, Spline
from tendon_cli.model.motor import taken
from tendon_cli.model.sheath import TOWARD_ELBOW, TOWARD_MOTOR, sheath_of

Rows = npt.NDArray[np.int64]

FIRST_CELLS = 8
MOST_CELLS = 2**20
_AT_ONCE = 2**14
_NARROWEST = 1e-9
"""rad, and of the way to the end of a box; what is not decided there is left."""
_USUAL = 0.1
"""rad; half of a cell of the angle that is as wide as a whole box, if nothing else says which to halve."""


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

    def taken(self, which: Any) -> Cells:
        """Some of them."""
        return Cells(**{name: values[which] for name, values in vars(self).items()})

    def halved(self, along: Rows) -> Cells:
        """Each in two, along the variable at a place."""
        first, second, each = self.high.copy(), self.low.copy(), np.arange(len(self))
        first[each, along] = second[each, along] = self.middle[each, along]
        return joined([replace(self, high=first), replace(self, low=second)])


@dataclass(frozen=True, eq=False)
class Proof:
    """What became of the cells."""

    cells: int
    broken: Cells
    """In the middle of which a limit is not kept."""
    left: Cells
    """That are not decided, for they are too many or too narrow."""


def cells_of(count: int, angles: tuple[float, float], flexion: Flags, knots: Array, numbers: int = 0) -> Cells:
    """The first cells of designs from angle to angle, in each direction, at both ends of windows, of whole boxes."""
    low, high = angles
    inner = knots[(knots > low) & (knots < high)]
    edges = np.unique(np.concatenate([np.linspace(low, high, FIRST_CELLS + 1), inner]))
    last = len(edges) - 1 if high > low else 1
    grids = np.meshgrid(np.arange(count), flexion.ravel(), [False, True], np.arange(last), indexing="ij")
    row, ways, upper, place = (grid.ravel() for grid in grids)
    box = np.ones((len(row), numbers))
    return Cells(
        row, ways, upper, np.column_stack([edges[place], -box]),
        np.column_stack([edges[np.minimum(place + 1, len(edges) - 1)], box]),
    )  # fmt: skip


def knots_of(design: Design) -> Array:
    """Where curves of a design have kinks in a derivative, rad."""
    joint = design.arm.joint
    curves = [design.arm.torque, design.load_torque, *(side.bend_angle for side in (design.flexor, design.extensor))]
    curves += [getattr(joint, "flexor", None), getattr(joint, "extensor", None)]
    return np.unique(np.concatenate([np.zeros(0), *(each.knots for each in curves if isinstance(each, Spline))]))


def prove(design: Design, cells: Cells, low: Array, high: Array, bounds: Bounds, ends: Sequence[Design] = ()) -> Proof:
    """Whether designs, (designs, 1, 1), keep all limits on states from `low` to `high` (N) in cells.

    `ends` has, of a box about them, for each number the designs in which this one is at its upper end.
    """
    begun, count = len(low), 0
    none = cells.taken(slice(0))
    broken, left, todo = [none], [none], cells
    at_once, most = (_AT_ONCE // (1 + len(ends)), MOST_CELLS // (1 + 7 * bool(ends)))
    with np.errstate(all="ignore"):
        while len(todo):
            if count + len(todo) > most:
                left.append(todo)
                break
            count += len(todo)
            rest = [none]
            for part in (todo.taken(slice(at, at + at_once)) for at in range(0, len(todo), at_once)):
                some, *of_ends = (
                    taken(each, (begun, 1, 1), (part.row, 0, 0))  # type: ignore[arg-type]
                    for each in (design, *ends)
                )
                pretension = np.where(part.upper, high[part.row], low[part.row])
                kept, fails, along = _kept(some, of_ends, part, pretension, bounds)
                broken.append(part.taken(fails))
                open_ = ~kept & ~fails
                narrow = (part.high - part.low < _NARROWEST).all(axis=1)
                left.append(part.taken(open_ & narrow))
                rest.append(part.taken(open_ & ~narrow).halved(along[open_ & ~narrow]))
            todo = joined(rest)
    return Proof(count, joined(broken), joined(left))


def joined(parts: list[Cells]) -> Cells:
    """Cells of several, one after the other."""
    return Cells(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in vars(parts[0])})


def _kept(
    design: Design, ends: Sequence[Design], cells: Cells, pretension: Array, bounds: Bounds
) -> tuple[Flags, Flags, Rows]:
    """Whether all limits are kept in all of each cell, whether one is broken in its middle, and what to halve."""
    middle, halves = cells.middle, np.maximum(cells.high - cells.middle, cells.middle - cells.low) * (1.0 + 1e-15)
    angle, half, about = middle[:, 0], halves[:, 0], halves[:, 1:]
    at_point, over_box = (within(design, ends, middle[:, 1:], size) for size in (0.0 * about, about))
    at_middle = _held(enclosed(at_point, angle, np.zeros(()), cells.flexion, pretension, ORDER - 1), bounds)
    over_cell = _held(enclosed(over_box, angle, half, cells.flexion, pretension, ORDER), bounds)
    kept, fails = np.ones(len(cells), dtype=np.bool_), np.zeros(len(cells), dtype=np.bool_)
    worst, falls = np.full(len(cells), np.inf), np.zeros(middle.shape)
    for point, whole in zip(at_middle, over_cell, strict=True):
        (value, near), (slope, slope_about) = (term or (0.0, 0.0) for term in point.terms[:2])
        bend, bend_about = whole.terms[2] or (0.0, 0.0)
        least, steep, bend = value - near, abs(slope) + slope_about, bend - bend_about
        vertex = steep / np.asarray(2.0 * bend)
        at_vertex, at_edge = steep * vertex - bend * vertex * vertex, steep * half - bend * half * half
        fall = np.broadcast_to(np.where((bend > 0.0) & (vertex < half), at_vertex, at_edge), kept.shape)
        moves = [fall, *np.zeros((len(ends), len(cells)))]
        for place, partial in whole.partials.items():
            slope, slope_about = partial.terms[0] or (0.0, 0.0)
            moves[1 + place] = (abs(slope) + slope_about) * about[:, place] * (1.0 + 1e-15)
        rounding = 1e-15 * (abs(value) + steep * half + abs(bend) * half * half)
        lowest = np.broadcast_to(least - sum(moves) - rounding, kept.shape)
        kept &= lowest >= 0.0
        fails |= value + near < 0.0
        lowest = np.where(np.isnan(lowest), -np.inf, lowest)
        falls[lowest < worst] = np.transpose(moves)[lowest < worst]
        worst = np.minimum(worst, lowest)
    sizes = halves / np.append(_USUAL, np.ones(len(ends)))
    falls = np.where(np.isfinite(falls).all(axis=1, keepdims=True), falls, sizes)
    return kept, fails, np.where(cells.high - cells.low > 0.0, falls, -1.0).argmax(axis=1)


def within(design: Any, ends: Sequence[Any], middle: Array, half: Array) -> Any:
    """A design, or part of one, whose numbers in a box are series, within `half` of their middle, (cells, numbers).

    Numbers are straight lines of the share of the way to the end of the box.
    """
    if isinstance(design, np.ndarray):
        for place, end in enumerate(ends):
            if design.dtype == np.float64 and np.any(apart := _apart(design, end)):
                size = np.abs(apart) * half[:, place]
                return Series.number(design + apart * middle[:, place], size, apart, place)
        return design
    if isinstance(design, Mapping):
        return {key: within(each, [end[key] for end in ends], middle, half) for key, each in design.items()}
    if not ends or not is_dataclass(design) or isinstance(design, type):
        return design
    names = [each.name for each in fields(design)]
    changes = {
        name: within(getattr(design, name), [getattr(end, name) for end in ends], middle, half) for name in names
    }
    return replace(design, **changes)


def _apart(design: Array, end: Array) -> Array:
    return np.where((design == end) | np.isnan(design), 0.0, end - design)


def _held(state: Any, bounds: Bounds) -> Iterator[Series]:
    """What must not be negative: the flexor's arm less a rounded zero, both tensions, and each limit's distance."""
    yield from state.arms
    yield state.x
    yield state.y
    for limit in bounds.asked:
        for form in () if limit.forms is None else limit.forms(state, bounds.speed):
            shares = ((form.flexor, state.x), (form.extensor, state.y), (form.stiffness, state.stiffness))
            value = sum((Series.near(share) * part for share, part in shares), Series.near(form.constant))
            least, most = limit.range_of(bounds[limit.name])
            if least is not None:
                yield value - least
            if most is not None:
                yield most - value


def enclosed(
    design: Design, middle: Array, half: Array, flexion: Flags, pretension: Array, order: int
) -> SimpleNamespace:
    """States over cells as series, with the names that forms of limits ask a `State` for."""
    angle = Series.variable(middle, half, order)
    path, flexor_travel, extensor_travel = _travels(design, angle)
    arm, extensor_arm = flexor_travel.slope(), extensor_travel.slope()
    flexor, extensor = _side(design.flexor, angle, flexion), _side(design.extensor, angle, ~flexion)
    resting = angle if not design.follows else Series.of(design.setting.angle)
    before = [
        _side(side, resting, way).compliance for side, way in ((design.flexor, flexion), (design.extensor, ~flexion))
    ]
    pulled, given = Series.near(design.ratio * flexor.compliance), extensor.compliance
    torque = _torque(design, angle)
    apart = extensor_travel - design.ratio * flexor_travel + (design.ratio * before[0] + before[1]) * pretension
    det = arm * given + extensor_arm * pulled
    x, y = (torque * given + extensor_arm * apart) / det, (arm * apart - pulled * torque) / det
    of_flexor, of_extensor = (
        each.slope() - each * side.compliance.slope() / side.compliance
        for each, side in ((arm, flexor), (extensor_arm, extensor))
    )
    stiffness = (
        arm * arm / flexor.compliance + extensor_arm * extensor_arm / given + torque.slope()
        - of_flexor * x + of_extensor * y
    )  # fmt: skip
    return SimpleNamespace(
        arms=(arm - 0.0, extensor_arm),
        x=x,
        y=y,
        stiffness=stiffness,
        flexor=flexor,
        extensor=extensor,
        design=design,
        motion=SimpleNamespace(flexor_path=path),
        speed=None,
        coupling=SimpleNamespace(
            ratio=design.ratio, extensor_arm=extensor_arm, moment_arm=arm,
            flexor_compliance=flexor.compliance, extensor_compliance=given,
        ),
        motor_arms=(design.flexor_radius / flexor.capstan, design.ratio * design.flexor_radius / extensor.capstan),
    )  # fmt: skip


def _travels(design: Design, angle: Series) -> tuple[Series | None, Series, Series]:
    """The flexor's path, if the joint tells, and both travels, m."""
    joint = design.arm.joint
    if isinstance(joint, Excursion):
        origin = Series.of(joint.origin)
        flexor, extensor = (
            (_curve(curve, angle) - _curve(curve, origin)) * joint.scale for curve in (joint.flexor, joint.extensor)
        )
        return None, flexor, extensor
    if not isinstance(joint, Anchors):
        raise TypeError(f"{type(joint).__name__} has no enclosure")
    squares = sum((Series.of(each) * each for each in (joint.a1, joint.b1, joint.a2, joint.b2)), Series.of(0.0))
    along = 2.0 * (Series.of(joint.b1) * joint.b2 - Series.of(joint.a1) * joint.a2)
    across = 2.0 * (Series.of(joint.a1) * joint.b2 + Series.of(joint.a2) * joint.b1)
    sine, cosine = angle.circular()
    path, start = (squares + along * cosine - across * sine).root(), (squares + along).root()
    reference, straight = np.where(joint.from_initial, 1.0, 0.0), Series.of(joint.b1) + joint.b2
    return path, reference * start + (1.0 - reference) * straight - path, angle * joint.elbow_radius


def _curve(curve: Spline, angle: Series) -> Series:
    """A curve over cells, each between two of its knots."""
    middle, _ = angle.terms[0] or (np.zeros(()), 0.0)
    piece = np.clip(np.searchsorted(curve.knots, middle, side="right") - 1, 0, len(curve.knots) - 2)
    from_knot, total = angle - curve.knots[piece], Series.of(0.0)
    for coefficient in curve.coefficients:
        total = total * from_knot + coefficient[piece]
    return total


def _torque(design: Design, angle: Series) -> Series:
    """What weights, joint and task ask for, N m."""
    arm, load = design.arm, Series.of(design.load_mass) * design.arm.load_distance
    weights = STANDARD_GRAVITY * (Series.of(arm.forearm_mass) * arm.forearm_com + load)
    passive = _curve(arm.torque, angle) if arm.torque is not None else (angle - arm.rest_angle) * arm.stiffness
    total = weights * (angle + arm.upper_arm_angle).circular()[0] + passive
    return total if design.load_torque is None else total + design.load_scale * _curve(design.load_torque, angle)


def _side(side: Side, angle: Series, pulled: Flags) -> SimpleNamespace:
    """A sheathed tendon that is pulled toward the motor, or else dragged to the joint: what forms ask of it."""
    toward = np.where(pulled, TOWARD_MOTOR, TOWARD_ELBOW)
    if not any(isinstance(value, (Series, Spline)) for value in vars(side).values()):
        plain = sheath_of(side, toward, 0.0)
        return SimpleNamespace(capstan=plain.capstan, spring=plain.spring, compliance=Series.near(plain.compliance))
    bend = _curve(side.bend_angle, angle) if isinstance(side.bend_angle, Spline) else Series.of(side.bend_angle)
    exponent = -toward * (Series.of(side.friction) * bend)
    area = Series.near(np.pi / 4.0) * side.diameter * side.diameter
    tendon = Series.of(side.length) / (area * side.youngs_modulus) * exponent.elongation()
    spring = 1.0 / Series.of(side.spring_stiffness) * (np.where(side.spring_at_motor, 1.0, 0.0) * exponent).exp()
    compliance = tendon + spring + 1.0 / Series.of(side.anchor_stiffness)
    return SimpleNamespace(capstan=(-exponent).exp(), spring=spring, compliance=compliance)
