"""Windows of pretension narrowed by a limit on the power of the motor.

In a taut state motor torque and dα/dθ are straight lines in pretension F, so their product is a
parabola, and a limit on power may allow several intervals of pretension. The widest is used; its
ends are found by bisection between samples. Arguments broadcast as in `window`; SI units, angles in
radians.
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
from tendon_cli.model.limits import LIMIT_NAMES, POWER
from tendon_cli.model.motor import motor_power, select_points, spool_speed, tendon_rates
from tendon_cli.model.window import Window

_STEP = 100.0  # N; first step of the search for an upper end, where a window has none
_DOUBLINGS = 16  # of that step, until the limit is broken
_SAMPLES = 65  # pretensions of a window between which ends are sought
_HALVINGS = 45  # of the distance between two samples
_UNIT = 100.0  # N; lines go through values at this pretension and without any

AtPretension = Callable[[Array], Array]
"""Function of one pretension of each design, (designs,), N."""


def within_power(
    windows: Window,
    design: Design,
    elbow_angle: Array,
    flexion: Flags,
    bounds: Bounds,
    loads: tuple[float, float] | None = None,
) -> Window:
    """Narrow windows to the widest interval that keeps the limit on power, too.

    Empty windows stay as they are.

    Args:
        windows: Windows within the other limits.
        design: Designs.
        elbow_angle: Angles, (1, K), rad.
        flexion: Directions of motion, (D, 1).
        bounds: Limits of the designs.
        loads: Least and largest load, kg; the motor's power is then the largest between.
    """
    if not windows.is_open.any() or not bounds.asks_power:
        return windows
    # What changes no single state, such as the strap's width, may be an axis of the designs, too.
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
    bound = np.reshape(bounds.of(open_designs)[LIMIT_NAMES[POWER]], -1)  # (1,), or (designs,)
    _cut_to_widest(cut, lambda at: motor.peak_power(at) - bound)
    for name, values in columns.items():
        values[open_places] = getattr(cut, name)
    return Window(**{name: values.reshape(designs) for name, values in columns.items()})


def power_excess(
    design: Design, elbow_angle: Array, flexion: Flags, bounds: Bounds, pretension: complex
) -> complex:
    """Return the excess of one design over the limit on power at a pretension, W.

    Numbers may be complex, for derivatives.

    Args:
        design: One design, with two axes of length 1.
        elbow_angle: Angles, (1, K), rad.
        flexion: Directions of motion, (D, 1), or (1, K) along a trajectory.
        bounds: Limits of the design.
        pretension: Pretension, N.
    """
    taut = replace(design.with_pretension(np.array(pretension)), unilateral=False)
    trajectory = design.trajectory
    if trajectory is None:
        state = evaluate(taut, elbow_angle, flexion)
        turning = np.where(flexion, bounds.speed, -np.asarray(bounds.speed))
    else:
        counted = trajectory.counted
        state = evaluate(taut, elbow_angle[:, counted], flexion[:, counted])
        turning = np.ones(())
    power = turning * motor_power(state, tendon_rates(state))
    bound = np.asarray(bounds.of(design)[LIMIT_NAMES[POWER]]).item()
    return complex(np.max(power) - bound)


@dataclass(frozen=True, eq=False)
class Motor:
    """Power of the motor in all states of designs while all are taut."""

    design: Design
    angles: Array
    """Elbow angles, (1, K), rad."""
    flexion: Flags
    """Directions of motion, (D, 1)."""
    shape: tuple[int, ...]
    """Shape of the designs."""
    speed: Real
    """Speed of the elbow, rad/s."""
    loads: tuple[float, float] | None = None
    """Least and largest load, kg; power is then the largest for any load between."""

    @cached_property
    def spool_speed(self) -> AtPretension:
        """Rotation of the spool per radian of the elbow."""
        return self._lines(spool_speed)

    @cached_property
    def torque(self) -> AtPretension:
        """Motor torque, N m."""
        return self._lines(lambda state: state.motor_torque)

    @cached_property
    def _states(self) -> list[State]:
        """States as if they were taut, without pretension and at `_UNIT`."""
        taut = replace(self.design, unilateral=False)
        state = evaluate(taut, self.angles, self.flexion)
        return [at_pretension(state, pretension) for pretension in (0.0, _UNIT)]

    def _lines(self, quantity: Callable[[State], Array]) -> AtPretension:
        """Return a quantity of states as straight lines over pretension, (designs, states)."""
        base, above = (self._flat(quantity(state)) for state in self._states)
        gain = (above - base) / _UNIT
        return lambda at: np.asarray(base + gain * at[:, np.newaxis])

    def _flat(self, values: Array) -> Array:
        """Return values of states as (designs, states)."""
        shape = (*self.shape, len(self.flexion), self.angles.size)
        flat = (math.prod(self.shape), math.prod(shape[-2:]))
        return np.broadcast_to(values, shape).reshape(flat)

    def peak_power(self, at: Array) -> Array:
        """Return the largest power over all states at one pretension of each design, W.

        Args:
            at: Pretensions, (designs,), N.

        Returns:
            Power, (designs,); with `loads` the largest for any load between.
        """
        velocity = self._flat(np.where(self.flexion, self.speed, -np.asarray(self.speed)))
        power = np.asarray(velocity * self.torque(at) * self.spool_speed(at))
        if self.loads is None:
            return np.asarray(np.max(power, axis=1))
        least, largest = self._motors_at_loads
        torque = least.torque(at)
        turning = least.spool_speed(at)
        # Torque and speed are lines in the load, so power is a parabola; `top` is its vertex.
        with np.errstate(divide="ignore", invalid="ignore"):
            torque_rise = largest.torque(at) - torque
            turning_rise = largest.spool_speed(at) - turning
            top = -0.5 * (torque / torque_rise + turning / turning_rise)
            at_top = velocity * (torque + top * torque_rise) * (turning + top * turning_rise)
        power = np.where((top > 0.0) & (top < 1.0), np.fmax(power, at_top), power)
        return np.asarray(np.max(power, axis=1))

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


def _cut_to_widest(windows: Window, excess: AtPretension) -> None:
    """Cut open windows to the widest interval without an excess over the limit, in place."""
    start = windows.low
    is_endless = np.isinf(windows.high)
    stop = np.where(is_endless, start + _STEP, windows.high)
    for _ in range(_DOUBLINGS):  # beyond where the limit is kept
        is_kept = is_endless & ~(excess(stop) > 0.0)
        if not is_kept.any():
            break
        stop = np.where(is_kept, start + 2.0 * (stop - start), stop)

    samples = start + np.linspace(0.0, 1.0, _SAMPLES)[:, np.newaxis] * (stop - start)
    is_broken = np.array([excess(pretension) > 0.0 for pretension in samples])
    first, last = widest(~is_broken.T)
    rows = np.arange(len(start))
    for name, inner, outer in (("low", first, first - 1), ("high", last, last + 1)):
        is_cut = (first >= 0) & (outer >= 0) & (outer < _SAMPLES)
        if not is_cut.any():
            continue
        outside = samples[np.clip(outer, 0, _SAMPLES - 1), rows]
        end = _edge(samples[inner, rows], outside, excess)
        _set_end(windows, name, is_cut, end)
        getattr(windows, f"{name}_state")[is_cut] = -1
        getattr(windows, f"{name}_angle")[is_cut] = np.nan
    is_closed = first < 0
    for name in ("low", "high"):
        _set_end(windows, name, is_closed, np.full(len(rows), np.nan))


def _set_end(windows: Window, name: str, where: Flags, ends: Array) -> None:
    """Give some of the windows another lower or upper end, which power sets, in place."""
    getattr(windows, name)[where] = ends[where]
    getattr(windows, f"{name}_by")[where] = POWER


def widest(kept: Flags) -> tuple[Rows, Rows]:
    """Return the first and last of the most samples in a row that are kept, (N,); -1 if none is.

    Args:
        kept: True for samples that are kept, (N, samples).
    """
    places = np.arange(kept.shape[1])
    length = places - np.maximum.accumulate(np.where(kept, -1, places), axis=1)
    last = length.argmax(axis=1)
    most = length.max(axis=1)
    is_kept = kept.any(axis=1)
    return np.where(is_kept, last - most + 1, -1), np.where(is_kept, last, -1)


def _edge(inside: Array, outside: Array, excess: AtPretension) -> Array:
    """Bisect between two pretensions for the one at which the limit is just kept, N."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (inside + outside)
        is_broken = excess(middle) > 0.0
        inside = np.where(is_broken, inside, middle)
        outside = np.where(is_broken, middle, outside)
    return inside
