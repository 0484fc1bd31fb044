"""Windows of pretension narrowed by limits on the whole motion, which no single state decides.

Where all states are taut, spool angle, motor torque and dα/dθ are straight lines in pretension F.
So limits on backlash and torque band are half-lines, as those of `window`; spool travel is the
largest of lines less the smallest, which is convex. Power is a product of two lines, and friction's
loss a sum of such products, so limits on them may allow several intervals of pretension. The widest
is used; its ends are found by bisection between samples. Arguments broadcast as in
`window`; SI units, angles in radians.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tendon_cli.model.actuator import State, at_pretension, evaluate
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import Design, shape_of
from tendon_cli.model.kinematics import Array, Flags, Real, Rows
from tendon_cli.model.limits import LIMIT_NAMES, LIMITS
from tendon_cli.model.motor import gauss_rule, motor_rates, select_points, spool_angle, spool_speed
from tendon_cli.model.statics import SLACK_TOLERANCE
from tendon_cli.model.window import Window

_STEP = 100.0  # N; first step of the search for an upper end, where a window has none
_DOUBLINGS = 16  # of that step, until some limit is broken
_SAMPLES = 65  # pretensions of a window between which ends are sought
_HALVINGS = 45  # of the distance between two samples
_UNIT = 100.0  # N; lines and parabolas go through values at multiples of it
_LOSS_STEP = float(np.radians(7.5))  # rad; longest step of Gauss's rule for smooth functions

Measure = Callable[[Array], Array]
"""Excess over a limit at one pretension of each design, (designs,): above 0 the limit is broken."""


@dataclass(frozen=True, eq=False)
class Lines:
    """Straight lines base + gain F of states, (designs, states)."""

    base: Array
    """Values without pretension."""
    gain: Array
    """Slopes over pretension, per newton."""

    def at(self, pretension: Array) -> Array:
        """Return values at one pretension of each design, (designs,)."""
        return np.asarray(self.base + self.gain * pretension[:, np.newaxis])


def narrow(
    windows: Window,
    design: Design,
    elbow_angle: Array,
    flexion: Flags,
    bounds: Bounds,
    loads: tuple[float, float] | None = None,
) -> Window:
    """Narrow windows to the widest interval that keeps the limits on the whole motion, too.

    Empty windows stay as they are.

    Args:
        windows: Windows within the limits on states.
        design: Designs.
        elbow_angle: Angles, (1, K), rad.
        flexion: Directions of motion, (D, 1), or (1, K) along a trajectory.
        bounds: Limits of the designs.
        loads: Least and largest load, kg; the motor's power is then the largest between.
    """
    if not windows.is_open.any() or not bounds.of_motion:
        return windows
    # What changes no single state, such as the spool's radius, may change the motion of the spool.
    designs = np.broadcast_shapes(windows.low.shape, shape_of(design))
    shape = designs or (1,)
    columns = {
        name: np.array(np.broadcast_to(values, shape)) for name, values in vars(windows).items()
    }
    open_places = np.nonzero(columns["low"] <= columns["high"])
    cut = Window(**{name: values[open_places] for name, values in columns.items()})
    open_designs = select_points(design, (*shape, 1, 1), open_places)
    motor = Motor(
        open_designs, np.asarray(elbow_angle), flexion, cut.low.shape, bounds.speed, loads
    )
    measures: dict[int, Measure] = {}
    of_open = bounds.of(open_designs)
    for limit in of_open.of_motion:
        code = LIMIT_NAMES.index(limit.name)
        bound = np.reshape(of_open[limit.name], -1)  # (1,), or (designs,)
        if limit.excess is not None:
            measures[code] = limit.excess(motor, bound)
        elif limit.lines is not None and (lines := limit.lines(motor)) is not None:
            for sign in (1.0, -1.0):
                _cut_by_lines(cut, code, Lines(sign * lines.base, sign * lines.gain), bound)
    if measures:
        _cut_to_widest(cut, measures)
    for name, values in columns.items():
        values[open_places] = getattr(cut, name)
    return Window(**{name: values.reshape(designs) for name, values in columns.items()})


def motion_excess(
    name: str,
    design: Design,
    elbow_angle: Array,
    flexion: Flags,
    bounds: Bounds,
    pretension: complex,
    state: int,
) -> complex:
    """Return the excess of one design over a limit on the whole motion, at a pretension.

    Numbers may be complex, for derivatives.

    Args:
        name: Name of the limit.
        design: One design, with two axes of length 1.
        elbow_angle: Angles, (1, K), rad.
        flexion: Directions of motion, (D, 1).
        bounds: Limits of the design.
        pretension: Pretension, N.
        state: Index of the binding state, as in `Window`, if the limit compares single angles.

    Raises:
        ValueError: If the limit is not on the whole motion.
    """
    motor = Motor(design, elbow_angle, flexion, (1, 1), bounds.speed)
    pretensions = np.array([pretension])
    limit = LIMITS[name]
    bound = np.asarray(bounds.of(design)[name]).item()
    if limit.lines is not None and (lines := limit.lines(motor)) is not None:
        value = complex(lines.at(pretensions)[0, state])
        magnitude = value if value.real > 0.0 else -value
        return magnitude - complex(bound)
    if limit.excess is None:
        raise ValueError(f"{name} is not a limit on the whole motion")
    return complex(limit.excess(motor, bound)(pretensions)[0])


@dataclass(eq=False)
class Motor:
    """Quantities of the motor in all states of designs, as lines in pretension while all are taut.

    Attributes:
        signs: 1 for states in flexion, -1 in extension, (directions, angles).
        trajectory: Motion in time, along which rates are per second; or None.
        velocity: Speed of the elbow in each state with its sign, rad/s; 1 along a trajectory.
    """

    design: Design
    angles: Array
    """Elbow angles, (1, K), rad."""
    flexion: Flags
    """Directions of motion, (D, 1), or (1, K) along a trajectory."""
    shape: tuple[int, ...]
    """Shape of the designs."""
    speed: Real
    """Speed of the elbow, rad/s."""
    loads: tuple[float, float] | None = None
    """Least and largest load, kg; power is then the largest for any load between."""

    def __post_init__(self) -> None:
        self.trajectory = self.design.trajectory
        if self.trajectory is not None and self.angles.size == len(self.trajectory.time):
            counted = self.trajectory.counted
            self.angles = self.angles[:, counted]
            self.flexion = self.flexion[:, counted]
        states = len(self.flexion), self.angles.size
        self.signs = np.broadcast_to(np.where(self.flexion, 1.0, -1.0), states)
        self.velocity = self.signs * self.speed if self.trajectory is None else np.ones(states)

    @cached_property
    def spool_angle(self) -> Lines:
        """Spool angle, rad."""
        return self._lines(spool_angle, self._states)

    @cached_property
    def spool_speed(self) -> Lines:
        """Rotation of the spool per radian of the elbow; along a trajectory rad/s."""
        return self._lines(spool_speed, self._states)

    @cached_property
    def torque(self) -> Lines:
        """Motor torque, N m."""
        return self._lines(lambda state: state.motor_torque, self._states)

    @cached_property
    def _states(self) -> list[State]:
        """States at the angles of the motion without pretension and at `_UNIT`."""
        return self._taut((0.0, _UNIT), self.angles)

    def _lines(self, quantity: Callable[[State], Array], states: list[State]) -> Lines:
        """Return a quantity as lines through its values without pretension and at `_UNIT`."""
        base, above = (self._flat(quantity(state)) for state in states)
        return Lines(base, (above - base) / _UNIT)

    def _taut(self, pretensions: tuple[float, ...], angles: Array) -> list[State]:
        """Return states at each pretension as if they were taut."""
        taut = replace(self.design, unilateral=False)
        state = evaluate(taut, angles, self.flexion)
        return [at_pretension(state, pretension) for pretension in pretensions]

    def _flat(self, values: Array) -> Array:
        """Return values of states as (designs, states)."""
        shape = (*self.shape, len(self.flexion), values.shape[-1])
        flat = (math.prod(self.shape), math.prod(shape[-2:]))  # there may be no angles
        return np.broadcast_to(values, shape).reshape(flat)

    def between(self, lines: Lines) -> Lines | None:
        """Return flexion less extension at each angle; None if there is a single direction."""
        flexion = np.ravel(self.flexion)
        if flexion.all() or not flexion.any():
            return None
        flexing = int(np.argmax(flexion))
        extending = int(np.argmin(flexion))

        def difference(values: Array) -> Array:
            by_direction = values.reshape(len(values), len(flexion), -1)
            return np.asarray(by_direction[:, flexing] - by_direction[:, extending])

        return Lines(difference(lines.base), difference(lines.gain))

    def power(self, at: Array) -> Array:
        """Return the motor's power in each state at one pretension of each design.

        Args:
            at: Pretensions, (designs,), N.

        Returns:
            Power, (designs, states), W; with `loads` the largest for any load between.
        """
        velocity = self._flat(self.velocity)
        power = np.asarray(velocity * self.torque.at(at) * self.spool_speed.at(at))
        if self.loads is None:
            return power
        least, largest = self._motors_at_loads
        torque = least.torque.at(at)
        turning = least.spool_speed.at(at)
        # Torque and speed are lines in the load, so power is a parabola; `top` is its vertex.
        with np.errstate(divide="ignore", invalid="ignore"):
            torque_rise = largest.torque.at(at) - torque
            turning_rise = largest.spool_speed.at(at) - turning
            top = -0.5 * (torque / torque_rise + turning / turning_rise)
            at_top = velocity * (torque + top * torque_rise) * (turning + top * turning_rise)
        return np.where((top > 0.0) & (top < 1.0), np.fmax(power, at_top), power)

    @cached_property
    def _motors_at_loads(self) -> list[Motor]:
        """Motors with the least and with the largest load; empty without `loads`."""
        return [
            Motor(
                replace(self.design, load_mass=load),
                self.angles,
                self.flexion,
                self.shape,
                self.speed,
            )
            for load in self.loads or ()
        ]

    @cached_property
    def work(self) -> Measure:
        """Function of pretension: work of the motor where it drives, J.

        It is summed in fine steps, because power has kinks where the motor begins to brake.
        """
        if self.trajectory is not None:
            seconds = self.trajectory.weights[self.trajectory.counted]
            return lambda at: np.asarray(np.maximum(self.power(at), 0.0) @ seconds)
        nodes, weights = gauss_rule(np.unique(self.angles))
        states = self._taut((0.0, _UNIT), nodes[np.newaxis])
        turning = self._lines(spool_speed, states)
        torque = self._lines(lambda state: state.motor_torque, states)
        signs = np.repeat(self.signs[:, 0], len(nodes))
        forward = Lines(signs * torque.base, signs * torque.gain)
        weight = np.tile(weights, np.size(self.flexion))

        def work(at: Array) -> Array:
            driven = np.maximum(forward.at(at) * turning.at(at), 0.0)
            return np.asarray(driven @ weight)

        return work

    @cached_property
    def loss(self) -> Measure:
        """Function of pretension: work that friction takes, J: a parabola, smooth in the angle."""
        if self.trajectory is not None:
            nodes = self.angles[0]
            weight = self.trajectory.weights[self.trajectory.counted]
        else:
            ends = np.array([self.angles.min(), self.angles.max()])
            nodes, weights = gauss_rule(ends, _LOSS_STEP)
            weight = np.outer(self.signs[:, 0], weights).ravel()
        first, second, third = (
            self._flat(motor_rates(state).friction) @ weight
            for state in self._taut((0.0, _UNIT, 2.0 * _UNIT), nodes[np.newaxis])
        )
        slope = (4.0 * second - 3.0 * first - third) / 2.0
        bend = (third - 2.0 * second + first) / 2.0
        return lambda at: np.asarray(first + at / _UNIT * (slope + at / _UNIT * bend))


def _cut_by_lines(windows: Window, code: int, lines: Lines, bound: Array) -> None:
    """Cut windows to where lines of all states are at most a bound, in place.

    Args:
        windows: Windows.
        code: Limit, index into LIMIT_NAMES.
        lines: Lines, (windows, states).
        bound: Bound, (1,) or (windows,).
    """
    most = bound[:, np.newaxis]
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = (most - lines.base) / lines.gain  # (windows, states), N
    for name, sign in (("low", 1.0), ("high", -1.0)):
        asked = np.where(sign * lines.gain < 0.0, sign * ends, -np.inf)
        tightest = asked.max(axis=1)
        is_tighter = tightest > sign * getattr(windows, name)
        _set_end(windows, name, is_tighter, sign * tightest, code, asked.argmax(axis=1))
    is_hopeless = (lines.gain == 0.0) & (lines.base > most * (1.0 + SLACK_TOLERANCE))
    _close(windows, code, is_hopeless.any(axis=1))


def _set_end(
    windows: Window,
    name: str,
    where: Flags,
    end: Array,
    code: int | Rows,
    state: int | Rows,
) -> None:
    """Give some of the windows another lower or upper end, in place.

    Args:
        windows: Windows.
        name: "low" or "high".
        where: True for the windows that are changed.
        end: Ends, N.
        code: Limits that set them, indices into LIMIT_NAMES.
        state: States that bind, -1 for none.
    """
    for field, changed in (
        (name, end),
        (f"{name}_by", code),
        (f"{name}_state", state),
        (f"{name}_angle", np.nan),
    ):
        values = getattr(windows, field)
        values[where] = np.broadcast_to(changed, values.shape)[where]


def _cut_to_widest(windows: Window, measures: dict[int, Measure]) -> None:
    """Cut open windows to the widest interval within other limits, in place."""
    start = np.where(windows.is_open, windows.low, 0.0)
    stop = np.where(np.isfinite(windows.high) & windows.is_open, windows.high, start + _STEP)
    endless = windows.is_open & np.isinf(windows.high)
    if endless.any():
        for _ in range(_DOUBLINGS):  # beyond where any limit is kept
            is_kept = endless & ~_is_broken(stop, measures)
            if not is_kept.any():
                break
            further = start + 2.0 * (stop - start)
            stop = np.where(is_kept, further, stop)

    samples = start + np.linspace(0.0, 1.0, _SAMPLES)[:, np.newaxis] * (stop - start)
    broken = {  # (samples, windows) each
        code: np.array([measure(pretension) > 0.0 for pretension in samples])
        for code, measure in measures.items()
    }
    kept = ~np.any(list(broken.values()), axis=0)
    has_kept = windows.is_open & kept.any(axis=0)

    # The widest interval ends where most samples have been kept since the last broken one.
    rows = np.arange(len(start))
    places = np.arange(_SAMPLES)[:, np.newaxis]
    length = places - np.maximum.accumulate(np.where(kept, -1, places))
    last = length.argmax(axis=0)
    first = last - length[last, rows] + 1
    for name, inner, outer in (("low", first, first - 1), ("high", last, last + 1)):
        is_cut = has_kept & (outer >= 0) & (outer < _SAMPLES)
        if not is_cut.any():
            continue
        inside = samples[inner, rows]
        outside = samples[np.clip(outer, 0, _SAMPLES - 1), rows]
        end, code = _edge(inside, outside, measures)
        _set_end(windows, name, is_cut, end, code, -1)
    codes = np.array(list(broken))
    most_broken = np.array([flags.sum(axis=0) for flags in broken.values()]).argmax(axis=0)
    _close(windows, codes[most_broken], windows.is_open & ~has_kept)


def _is_broken(pretension: Array, measures: dict[int, Measure]) -> Flags:
    """Return where any limit is broken at one pretension of each design."""
    return np.asarray(np.any([measure(pretension) > 0.0 for measure in measures.values()], axis=0))


def _edge(inside: Array, outside: Array, measures: dict[int, Measure]) -> tuple[Array, Rows]:
    """Bisect between two pretensions for the one at which the limits are just kept.

    Returns:
        That pretension, N, and the code of the limit that is broken most beyond it.
    """
    for _ in range(_HALVINGS):
        middle = 0.5 * (inside + outside)
        is_broken = _is_broken(middle, measures)
        inside = np.where(is_broken, inside, middle)
        outside = np.where(is_broken, middle, outside)
    codes = np.array(list(measures))
    beyond = np.array([measure(outside) for measure in measures.values()])
    return inside, codes[beyond.argmax(axis=0)]


def _close(windows: Window, code: int | Rows, where: Flags) -> None:
    """Empty some windows because of the limit `code`, in place."""
    where = where & ~np.isnan(windows.low)
    for ends, by in ((windows.low, windows.low_by), (windows.high, windows.high_by)):
        ends[where] = np.nan
        by[where] = np.broadcast_to(code, where.shape)[where]
