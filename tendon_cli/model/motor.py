"""What motor, springs and friction do as the elbow moves through a state.

The spool turns with the elbow by dα/dθ; everything else follows from that. Per radian of the elbow

    τ_m dα/dθ = τ_a + dU/dθ + dW/dθ

with U what tendons and springs store and W what friction takes. Along a sheath the tendon slides by u(s) and friction
takes dF/ds du ds: W comes from friction itself, and the balance above is used nowhere. SI units, angles in radians.

A cycle is both strokes of a design. Its works are integrals over the elbow angle; where a tendon goes slack or the
motor turns from driving to braking they have a kink, which bisection finds. What the turns between the strokes
cost is left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.model.actuator import State, evaluate
from tendon_cli.model.design import Design, changed
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.statics import BOTH_SLACK, EXTENSOR_SLACK, FLEXOR_SLACK
from tendon_cli.model.trajectory import Trajectory

_LONGEST_STEP = float(np.radians(1.0))
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(3)
_HALVINGS = 30


@dataclass(frozen=True, eq=False)
class MotorRates:
    """What goes on in states per radian of the elbow (θ, whichever way it moves); shapes as those of `State`.

    Along a trajectory it is per second: the inertia that asks for more torque has the motor stretch the springs, too.

    Where both tendons are slack the spool is free: its angle and speed are NaN, and nothing is driven, stored or lost.
    """

    spool_angle: Array
    """α + c_f F0/R_f, counted from one unstretched flexor for both directions, rad."""
    spool_speed: Array
    """dα/dθ."""
    power: Array
    """τ_m dα/dθ, N m."""
    stored: Array
    """U, elastic energy of both tendons and springs, J."""
    storing: Array
    """dU/dθ, N m."""
    friction: Array
    """dW/dθ by the work of friction along both sheaths, N m: below 0 in extension, where θ falls."""


def motor_rates(state: State) -> MotorRates:
    """Rates of states by their elbow stiffness k = dα/dθ R_f (J_f/c_f + η J_e/c_e), which leaves slack sides out."""
    design, tied, status = state.design, state.coupling, state.status
    turning = 1.0 if state.speed is None else state.speed
    asked = 0.0 if state.torque_rate is None else state.torque_rate
    limp = np.asarray(design.unilateral)
    flexor_pulls = ~(((status == FLEXOR_SLACK) | (status == BOTH_SLACK)) & limp)
    extensor_pulls = ~(((status == EXTENSOR_SLACK) | (status == BOTH_SLACK)) & limp)
    by_flexor = flexor_pulls * tied.moment_arm / tied.flexor_compliance
    by_extensor = extensor_pulls * tied.ratio * tied.extensor_arm / tied.extensor_compliance
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = state.elbow_stiffness * turning + asked
        winding = np.where(
            flexor_pulls | extensor_pulls, needed / (by_flexor + by_extensor), np.nan
        )
    wound = np.where(np.isnan(winding) & ~np.isnan(tied.moment_arm), 0.0, winding)
    x, y = state.balance.flexor, state.balance.extensor
    shortens, lengthens = tied.moment_arm * turning, np.asarray(tied.extensor_arm) * turning
    x_takes, y_takes = wound - shortens, lengthens - tied.ratio * wound
    if state.resting is not None:  # a bend that follows the joint stretches the tendons, too
        x_takes = x_takes - state.flexor.compliance_rate * x * turning
        y_takes = y_takes - state.extensor.compliance_rate * y * turning
    x_rate = flexor_pulls * x_takes / tied.flexor_compliance
    y_rate = extensor_pulls * y_takes / tied.extensor_compliance
    started = (
        state.flexor if state.resting is None else state.resting[0]
    ).compliance * design.flexor.pretension
    return MotorRates(
        spool_angle=state.spool_angle + started / design.flexor_radius,
        spool_speed=winding / design.flexor_radius,
        power=np.asarray(state.motor_torque * wound / design.flexor_radius),
        stored=0.5 * (state.flexor.gives * x * x + state.extensor.gives * y * y),
        storing=state.flexor.storing(x, x_rate, turning)
        + state.extensor.storing(y, y_rate, turning),
        friction=state.flexor.friction_rate(x, x_rate, shortens, turning)
        + state.extensor.friction_rate(y, y_rate, -lengthens, turning),
    )


def cycle(design: Design, elbow_angle: Array, flexion: Flags, speed: float) -> dict[str, Array]:
    """What both strokes of designs come to at a speed of the elbow (rad/s), by column, from the least angle and back.

    Directions (D, 1) and elbow angles (1, K), in any order, are the last two axes, which results do not have. Peaks,
    travel and differences are those of the states at these angles; NaN where no state tells, differences where there is
    one direction alone, and works and losses where any state has no equilibrium. Units: `quantities.OF_CYCLES`.
    """
    angles = np.unique(elbow_angle)
    state = evaluate(design, angles[np.newaxis], flexion)
    rates = motor_rates(state)
    power = np.where(flexion, speed, -speed) * rates.power
    return _columns(
        state, rates, speed * rates.spool_speed, power, _works(design, angles, flexion), flexion
    )


def along(design: Design, trajectory: Trajectory) -> dict[str, Array]:
    """What designs come to along a trajectory, by column, as by `cycle`; sums over time are those of its samples.

    There is no other direction at the same angle to compare with.
    """
    state = evaluate(design, trajectory.angle[np.newaxis], trajectory.flexion[np.newaxis])
    rates, weights = motor_rates(state), trajectory.weights

    def total(values: Array) -> Array:
        return np.asarray(np.broadcast_to(values, rates.power.shape)[..., 0, :] @ weights)

    works = total(np.maximum(rates.power, 0.0)), total(rates.friction)
    return _columns(state, rates, rates.spool_speed, rates.power, works, np.array([[True]])) | {
        "rms_motor_torque": np.sqrt(total(np.square(state.motor_torque)) / weights.sum()),
        "braking_work": total(np.maximum(-rates.power, 0.0)),
    }


def _columns(
    state: State,
    rates: MotorRates,
    turning: Array,
    power: Array,
    works: tuple[Array, Array],
    flexion: Flags,
) -> dict[str, Array]:
    """What states come to whose spool turns by `turning` (rad/s) with a power (W), and their works in and lost (J)."""
    work, loss = works
    with np.errstate(divide="ignore", invalid="ignore"):
        efficiency = np.asarray(np.where(work > 0.0, 1.0 - loss / work, np.nan))
    return {
        "peak_motor_speed": _over(np.fmax, np.abs(turning)),
        "peak_motor_power": np.maximum(_over(np.fmax, power), 0.0),
        "peak_braking_power": np.maximum(_over(np.fmax, -power), 0.0),
        "motor_work_in": work,
        "friction_loss": loss,
        "efficiency": efficiency,
        "spool_travel": _over(np.fmax, rates.spool_angle) - _over(np.fmin, rates.spool_angle),
        "max_backlash": _largest_gap(rates.spool_angle, flexion),
        "max_torque_band": _largest_gap(state.motor_torque, flexion),
    }


def _works(design: Design, angles: Array, flexion: Flags) -> tuple[Array, Array]:
    """Work of the motor where it drives, and what friction takes, J."""
    edges = _steps(angles)
    low, high = edges[:-1], edges[1:]
    kinds = _kinds(design, edges, flexion)
    kinked = kinds[..., :-1] != kinds[..., 1:]
    smooth = [np.where(kinked, 0.0, each) for each in _integrals(design, low, high, flexion)]
    at = np.nonzero(kinked)
    some, ways = select_points(design, kinked.shape, at), np.broadcast_to(flexion, kinked.shape)[at]
    start, stop = low[at[-1]], high[at[-1]]
    while np.any(start < stop):
        kink = _next_kink(some, start, stop, ways)
        for whole, part in zip(smooth, _integrals(some, start, kink, ways), strict=True):
            np.add.at(whole, at, part)
        start = kink
    work, loss = (each.sum(axis=(-2, -1)) for each in smooth)
    return work, loss


def _steps(angles: Array, longest: float = _LONGEST_STEP) -> Array:
    """The angles, and others between them, so that no step is too long."""
    counts = np.maximum(1, np.ceil(np.diff(angles) / longest - 1e-9)).astype(np.int64)
    steps = zip(angles[:-1], angles[1:], counts, strict=True)
    return np.concatenate(
        [
            *(np.linspace(low, high, count, endpoint=False) for low, high, count in steps),
            angles[-1:],
        ]
    )


def gauss(angles: Array, longest: float = _LONGEST_STEP) -> tuple[Array, Array]:
    """Nodes and weights, one after the other, for integrals over ascending angles of what has no kinks, rad."""
    edges = _steps(angles, longest)
    middle, half = 0.5 * (edges[:-1] + edges[1:]), 0.5 * np.diff(edges)
    return (middle[:, np.newaxis] + half[:, np.newaxis] * _NODES).ravel(), (
        half[:, np.newaxis] * _WEIGHTS
    ).ravel()


def _rates(design: Design, angle: Array, flexion: Flags) -> tuple[State, Array, Array]:
    """States, and in the direction of motion per radian the motor's power and friction's, N m."""
    state = evaluate(design, angle, flexion)
    rates = motor_rates(state)
    forward = np.where(flexion, 1.0, -1.0)
    return state, forward * rates.power, forward * rates.friction


def _integrals(design: Design, low: Array, high: Array, flexion: Flags) -> list[Array]:
    """Work of the motor where it drives and of friction over smooth steps, J, by Gauss's rule."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    total = [np.zeros(()), np.zeros(())]
    for node, weight in zip(_NODES, _WEIGHTS, strict=True):
        _, power, friction = _rates(design, middle + half * node, flexion)
        driven = weight * half * np.maximum(power, 0.0)
        total = [total[0] + driven, total[1] + weight * half * friction]
    return total


def _kinds(design: Design, angle: Array, flexion: Flags) -> Array:
    """What differs across a kink: the status, and whether the motor drives or brakes."""
    state, power, _ = _rates(design, angle, flexion)
    return np.asarray(4.0 * state.balance.status + np.sign(np.nan_to_num(power)))


def _next_kink(design: Design, start: Array, stop: Array, flexion: Flags) -> Array:
    """Just past the first kink after `start`, by bisection; `stop` where there is none."""
    kind, low, high = _kinds(design, start, flexion), start, stop
    alike = _kinds(design, stop, flexion) == kind
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        same = _kinds(design, middle, flexion) == kind
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.where(alike, stop, high)


def select_points(
    design: Design, shape: tuple[int, ...], at: tuple[npt.NDArray[np.int64], ...]
) -> Design:
    """Some states' designs of all, one after the other."""
    some: Design = changed(
        design, lambda values: np.broadcast_to(values, shape)[at] if values.ndim else values
    )
    return some


def _over(extreme: np.ufunc, values: Array) -> Array:
    """The extreme over directions and angles of what is a number."""
    spread = np.broadcast_to(values, np.broadcast_shapes(values.shape, (1, 1)))
    return np.asarray(extreme.reduce(spread, axis=(-2, -1)))


def _largest_gap(values: Array, flexion: Flags) -> Array:
    """The largest difference between the directions at one elbow angle."""
    ways = np.ravel(flexion)
    if ways.all() or not ways.any():
        return np.full(values.shape[:-2], np.nan)
    there, back = (np.compress(ways == way, values, axis=-2)[..., :1, :] for way in (True, False))
    return _over(np.fmax, np.abs(there - back))
