"""Rates of motor, springs and friction as the elbow moves through a state.

The spool turns with the elbow by dα/dθ; everything else follows from that. Per radian of the elbow

    τ_m dα/dθ = τ_a + dU/dθ + dW/dθ

with U the energy that tendons and springs store and W the energy that friction takes. Along a
sheath the tendon slides by u(s) and friction takes dF/ds du ds: W is computed from friction itself,
and the balance above is used nowhere. SI units, angles in radians.

A cycle is both strokes of a design. Its work and loss are integrals over the elbow angle; where a
tendon goes slack or the motor turns from driving to braking they have a kink, which bisection
finds. The cost of the turns between the strokes is left out.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.model.actuator import State, evaluate
from tendon_cli.model.design import Design, map_arrays, shape_of
from tendon_cli.model.kinematics import Array, Flags, Real
from tendon_cli.model.statics import BOTH_SLACK, EXTENSOR_SLACK, FLEXOR_SLACK
from tendon_cli.quantities import OF_CYCLES

_LONGEST_STEP = float(np.radians(1.0))
"""Longest step of an integral over the elbow angle, rad."""
# Of Gauss's rule in each step
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(3)
_HALVINGS = 30  # of a step, to find a kink


@dataclass(frozen=True, eq=False)
class MotorRates:
    """Rates of states per radian of the elbow (θ, whichever way it moves); shapes as in `State`.

    Along a trajectory they are per second: the motor then also stretches the springs as inertia
    needs more torque.

    Where both tendons are slack the spool is free: its angle and speed are NaN, and nothing is
    driven, stored or lost.
    """

    spool_angle: Array
    """Spool angle α + c_f F0/R_f from the unstretched flexor, a zero for both directions, rad."""
    spool_speed: Array
    """dα/dθ."""
    power: Array
    """τ_m dα/dθ, N m."""
    storage_rate: Array
    """dU/dθ, with U the elastic energy of both tendons and springs, N m."""
    friction: Array
    """dW/dθ by the work of friction along both sheaths, N m: below 0 in extension, where θ
    falls."""


@dataclass(frozen=True, eq=False)
class TendonRates:
    """Rates of both tendons in states, per radian of the elbow; per second along a trajectory."""

    turning: Real
    """Rate of the elbow: 1, or its speed along a trajectory, rad/s."""
    winding: Array
    """Length wound on the flexor's spool, m; NaN where both tendons are slack."""
    wound: Array
    """The same length, m; 0 where the spool is free."""
    flexor_pulls: Flags
    """True where the flexor is under tension."""
    extensor_pulls: Flags
    """True where the extensor is under tension."""
    path_shortening: Array
    """Shortening of the flexor's path, m."""
    path_lengthening: Array
    """Lengthening of the extensor's path, m."""
    flexor: Array
    """Rate of the distal flexor tension, N."""
    extensor: Array
    """Rate of the distal extensor tension, N."""


def tendon_rates(state: State) -> TendonRates:
    """Return the rates of the tendons in states.

    They follow from the elbow stiffness k = dα/dθ R_f (J_f/c_f + η J_e/c_e), which leaves slack
    sides out; along a trajectory k θ̇ and the rate of inertia and task take its place.
    """
    design = state.design
    coupling = state.coupling
    status = state.status
    turning: Real = 1.0
    torque_rate: Real = 0.0
    if state.rates is not None:
        turning = state.rates.speed
        torque_rate = state.rates.torque

    unilateral = np.asarray(design.unilateral)
    is_flexor_slack = (status == FLEXOR_SLACK) | (status == BOTH_SLACK)
    is_extensor_slack = (status == EXTENSOR_SLACK) | (status == BOTH_SLACK)
    flexor_pulls = ~(is_flexor_slack & unilateral)
    extensor_pulls = ~(is_extensor_slack & unilateral)

    # Elbow torque that each side adds per length wound on the flexor's spool, N.
    by_flexor = flexor_pulls * coupling.moment_arm / coupling.flexor_compliance
    by_extensor = (
        extensor_pulls * coupling.ratio * coupling.extensor_arm / coupling.extensor_compliance
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = state.elbow_stiffness * turning + torque_rate
        winding = needed / (by_flexor + by_extensor)
        winding = np.where(flexor_pulls | extensor_pulls, winding, np.nan)
    is_free = np.isnan(winding) & ~np.isnan(coupling.moment_arm)
    wound = np.where(is_free, 0.0, winding)

    # Rates of both distal tensions, by the lengths that each side takes up.
    path_shortening = coupling.moment_arm * turning
    path_lengthening = np.asarray(coupling.extensor_arm) * turning
    flexor_stretching = wound - path_shortening
    extensor_stretching = path_lengthening - coupling.ratio * wound
    if not (state.flexor.is_still and state.extensor.is_still):
        # A bend that follows the joint stretches the tendons, too.
        x = state.balance.flexor
        y = state.balance.extensor
        flexor_stretching = flexor_stretching - state.flexor.compliance_rate * x * turning
        extensor_stretching = extensor_stretching - state.extensor.compliance_rate * y * turning
    return TendonRates(
        turning=turning,
        winding=winding,
        wound=wound,
        flexor_pulls=flexor_pulls,
        extensor_pulls=extensor_pulls,
        path_shortening=path_shortening,
        path_lengthening=path_lengthening,
        flexor=flexor_pulls * flexor_stretching / coupling.flexor_compliance,
        extensor=extensor_pulls * extensor_stretching / coupling.extensor_compliance,
    )


def motor_power(state: State, rates: TendonRates) -> Array:
    """Return the power of the motor in states, τ_m dα/dθ in N m; in W along a trajectory."""
    return np.asarray(state.motor_torque * rates.wound / state.design.flexor_radius)


def spool_speed(state: State) -> Array:
    """Return the rotation of the spool per radian of the elbow, as in `MotorRates`."""
    return np.asarray(tendon_rates(state).winding / state.design.flexor_radius)


def spool_from_unstretched(state: State) -> Array:
    """Return the spool angle from the unstretched flexor, a zero for both directions, rad."""
    resting = state.flexor if state.resting is None else state.resting[0]
    stretch = resting.compliance * state.design.flexor.pretension
    return np.asarray(state.spool_angle + stretch / state.design.flexor_radius)


def motor_rates(state: State, rates: TendonRates | None = None) -> MotorRates:
    """Return the rates of motor, springs and friction in states.

    Args:
        state: The states.
        rates: Result of `tendon_rates` for them, if it is known already.
    """
    rates = tendon_rates(state) if rates is None else rates
    turning = rates.turning
    x = state.balance.flexor
    y = state.balance.extensor
    flexor_storing = state.flexor.storage_rate(x, rates.flexor, turning)
    extensor_storing = state.extensor.storage_rate(y, rates.extensor, turning)
    flexor_friction = state.flexor.friction_rate(x, rates.flexor, rates.path_shortening, turning)
    extensor_friction = state.extensor.friction_rate(
        y, rates.extensor, -rates.path_lengthening, turning
    )
    return MotorRates(
        spool_angle=spool_from_unstretched(state),
        spool_speed=rates.winding / state.design.flexor_radius,
        power=motor_power(state, rates),
        storage_rate=flexor_storing + extensor_storing,
        friction=flexor_friction + extensor_friction,
    )


def cycle_columns(
    design: Design,
    elbow_angle: Array,
    flexion: Flags,
    speed: float,
    names: Collection[str] = OF_CYCLES,
) -> dict[str, Array]:
    """Return columns of both strokes of designs, from the least angle to the largest and back.

    Peaks, travel and differences are those of the states at these angles. They are NaN if no state
    has a value, differences also if there is a single direction. Work and loss are NaN if any state
    has no equilibrium; they take most of the time.

    Args:
        design: Designs, over axes before the last two.
        elbow_angle: Elbow angles (1, K) in any order, rad.
        flexion: Directions (D, 1), True for flexion.
        speed: Speed of the elbow, rad/s.
        names: Names of the columns.

    Returns:
        Values by column over the designs' axes; units as in `quantities.OF_CYCLES`.
    """
    angles = np.unique(elbow_angle)
    state = evaluate(design, angles[np.newaxis], flexion)
    rates = motor_rates(state)
    spool_speed = speed * rates.spool_speed
    power = np.where(flexion, speed, -speed) * rates.power
    columns = {
        "peak_motor_speed": _extreme_of_states(np.fmax, np.abs(spool_speed)),
        "peak_motor_power": np.maximum(_extreme_of_states(np.fmax, power), 0.0),
        "peak_braking_power": np.maximum(_extreme_of_states(np.fmax, -power), 0.0),
        "spool_travel": _extreme_of_states(np.fmax, rates.spool_angle)
        - _extreme_of_states(np.fmin, rates.spool_angle),
        "max_backlash": _largest_gap(rates.spool_angle, flexion),
        "max_torque_band": _largest_gap(state.motor_torque, flexion),
    }
    if not columns.keys() >= {*names}:
        work, loss = _work_and_loss(design, angles, flexion)
        with np.errstate(divide="ignore", invalid="ignore"):
            efficiency = np.asarray(np.where(work > 0.0, 1.0 - loss / work, np.nan))
        columns |= {"motor_work_in": work, "friction_loss": loss, "efficiency": efficiency}
    return {name: columns[name] for name in names}


def _work_and_loss(design: Design, angles: Array, flexion: Flags) -> tuple[Array, Array]:
    """Return the work of the motor where it drives, and the work that friction takes, J."""
    edges = _steps(angles)
    low = edges[:-1]
    high = edges[1:]
    kinds = _kinds(design, edges, flexion)
    is_kinked = kinds[..., :-1] != kinds[..., 1:]
    # What changes no state, such as the width of the strap, may be an axis of the designs, too.
    shape = np.broadcast_shapes(is_kinked.shape, (*shape_of(design), 1, 1))
    is_kinked = np.broadcast_to(is_kinked, shape)
    smooth_work, smooth_loss = _integrals(design, low, high, flexion)
    work = np.where(is_kinked, 0.0, smooth_work)  # (designs, directions, steps), J
    loss = np.where(is_kinked, 0.0, smooth_loss)

    # Steps with kinks are integrated from kink to kink, all together.
    steps = np.nonzero(is_kinked)
    designs = select_points(design, is_kinked.shape, steps)
    directions = np.broadcast_to(flexion, is_kinked.shape)[steps]
    start = low[steps[-1]]
    stop = high[steps[-1]]
    while np.any(start < stop):
        kink = _next_kink(designs, start, stop, directions)
        part_work, part_loss = _integrals(designs, start, kink, directions)
        np.add.at(work, steps, part_work)
        np.add.at(loss, steps, part_loss)
        start = kink
    return work.sum(axis=(-2, -1)), loss.sum(axis=(-2, -1))


def _steps(angles: Array) -> Array:
    """Insert angles between ascending ones, so that no step is longer than `_LONGEST_STEP`."""
    counts = np.maximum(1, np.ceil(np.diff(angles) / _LONGEST_STEP - 1e-9)).astype(np.int64)
    steps = [
        np.linspace(low, high, count, endpoint=False)
        for low, high, count in zip(angles[:-1], angles[1:], counts, strict=True)
    ]
    return np.concatenate([*steps, angles[-1:]])


def _rates(design: Design, angle: Array, flexion: Flags) -> tuple[State, Array, Array]:
    """Return states with the powers of motor and friction per radian of the motion, N m."""
    state = evaluate(design, angle, flexion)
    rates = motor_rates(state)
    forward = np.where(flexion, 1.0, -1.0)
    return state, forward * rates.power, forward * rates.friction


def _integrals(design: Design, low: Array, high: Array, flexion: Flags) -> tuple[Array, Array]:
    """Integrate the work of the driving motor and of friction over smooth steps, J."""
    middle = 0.5 * (low + high)
    half = 0.5 * (high - low)
    work = np.zeros(())
    loss = np.zeros(())
    for node, weight in zip(_NODES, _WEIGHTS, strict=True):
        _, power, friction = _rates(design, middle + half * node, flexion)
        work = work + weight * half * np.maximum(power, 0.0)
        loss = loss + weight * half * friction
    return work, loss


def _kinds(design: Design, angle: Array, flexion: Flags) -> Array:
    """Return numbers that differ across a kink, from the status and the sign of the power."""
    state, power, _ = _rates(design, angle, flexion)
    return np.asarray(4.0 * state.balance.status + np.sign(np.nan_to_num(power)))


def _next_kink(design: Design, start: Array, stop: Array, flexion: Flags) -> Array:
    """Bisect for a point just past the first kink after `start`; `stop` if there is none."""
    kind = _kinds(design, start, flexion)
    has_no_kink = _kinds(design, stop, flexion) == kind
    low = start
    high = stop
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        is_before = _kinds(design, middle, flexion) == kind
        low = np.where(is_before, middle, low)
        high = np.where(is_before, high, middle)
    return np.where(has_no_kink, stop, high)


def select_points(
    design: Design, shape: tuple[int, ...], at: tuple[npt.NDArray[np.int64], ...]
) -> Design:
    """Select the designs at some points of a shape, along a single axis.

    Args:
        design: Designs whose arrays broadcast to a shape.
        shape: The shape.
        at: Indices of the points along each axis of the shape.
    """

    def select(values: Array) -> Array:
        return np.broadcast_to(values, shape)[at] if values.ndim else values

    selected: Design = map_arrays(design, select)
    return selected


def _extreme_of_states(extreme: np.ufunc, values: Array) -> Array:
    """Return the extreme over directions and angles, without regard to NaN."""
    spread = np.broadcast_to(values, np.broadcast_shapes(values.shape, (1, 1)))
    return np.asarray(extreme.reduce(spread, axis=(-2, -1)))


def _largest_gap(values: Array, flexion: Flags) -> Array:
    """Return the largest difference between the directions at any elbow angle."""
    directions = np.ravel(flexion)
    if directions.all() or not directions.any():
        return np.full(values.shape[:-2], np.nan)
    in_flexion = np.compress(directions, values, axis=-2)[..., :1, :]
    in_extension = np.compress(~directions, values, axis=-2)[..., :1, :]
    return _extreme_of_states(np.fmax, np.abs(in_flexion - in_extension))
