"""States of designs along a motion in time, and the columns of designs that follow from them.

At each sample both directions of friction give a state, a candidate; `sliding` tells which one
holds. Where the tendons turn, torque and tensions lie between both, so that peaks and limits count
both there; speed and power are those of the state that holds. Samples at the ends of the record
count nowhere. Arrays of states are (designs..., directions, samples); SI units, angles in radians.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from tendon_cli.model.actuator import State, at_pretension
from tendon_cli.model.design import Design, map_arrays, shape_of
from tendon_cli.model.kinematics import Array, Flags, Real, Rows
from tendon_cli.model.motor import (
    MotorRates,
    TendonRates,
    motor_power,
    motor_rates,
    spool_from_unstretched,
    tendon_rates,
)
from tendon_cli.model.reversal import SideReversal, side_reversal
from tendon_cli.model.sliding import (
    BOTH_DIRECTIONS,
    Sliding,
    Turns,
    against,
    in_play,
    not_past,
    slack_passes,
    spool_turns,
)
from tendon_cli.model.trajectory import Trajectory

_MOST_TURNING = 0.95
"""Largest share of samples at which the tendons turn for which friction's loss is given: a rig of
elastic links lost up to a third less where they never slid as a whole."""


@dataclass(frozen=True, eq=False)
class Moving:
    """Designs along their trajectory: candidates, and the states that hold."""

    candidates: State
    """States in both directions at all samples, (..., 2, K)."""
    trajectory: Trajectory
    """The motion."""

    @classmethod
    def of(cls, design: Design, trajectory: Trajectory) -> Moving:
        """Return designs along a trajectory, the one that they have."""
        return cls(State.of(design, trajectory.angle[np.newaxis], BOTH_DIRECTIONS), trajectory)

    def at_pretension(self, pretension: Real) -> Moving:
        """Return the same designs at a pretension of both sides, (..., 1, 1), N."""
        moved = Moving(at_pretension(self.candidates, pretension), self.trajectory)
        designs = np.broadcast_shapes(self.shape[:-1], np.shape(pretension)[:-2])
        vars(moved).update(
            shape=(*designs, self.shape[-1]),
            _turns_of_sides=self._turns_of_sides,  # pretension does not change them
        )
        return moved

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the axes of the designs, and number of samples."""
        at = self.candidates
        of_states = np.broadcast_shapes(at.response.required.shape, (*shape_of(at.design), 1, 1))
        return (*of_states[:-2], len(self.trajectory.time))

    def _flat(self, values: Any) -> Any:
        """Return values of states in one direction as (designs, samples)."""
        return self.along(values).reshape(math.prod(self.shape[:-1]), self.shape[-1])

    def _of_states(self, values: Any) -> Any:
        """Return values (designs, samples) as those of states in one direction."""
        return values.reshape(*self.shape[:-1], 1, self.shape[-1])

    def _pick(self, values: Array, designs: Rows, directions: Rows | int, samples: Rows) -> Array:
        """Return values of candidates at designs, directions and samples, all of one shape."""
        whole = np.broadcast_to(values, (*self.shape[:-1], 2, self.shape[-1]))
        place = np.unravel_index(designs, self.shape[:-1]) if self.shape[:-1] else ()
        return np.asarray(whole[(*place, directions, samples)])

    def along(self, values: Any) -> Any:
        """Return values of states in one direction at all samples, (..., K)."""
        of_states = np.broadcast_to(values, (*self.shape[:-1], 1, self.shape[-1]))
        return of_states[..., 0, :]

    # --- Which state holds ------------------------------------------------------------------------

    @cached_property
    def _spool_angle(self) -> Array:
        """Spool angle of the candidates from the unstretched flexor, rad."""
        return spool_from_unstretched(self.candidates)

    @cached_property
    def _turns_of_sides(self) -> tuple[SideReversal, SideReversal]:
        """Turn of each tendon per newton at the joint, by the direction that it has before."""
        at = self.candidates
        radius = np.asarray(at.design.flexor_radius)

        def turn(side: Any, spool: Array) -> SideReversal:
            after = map_arrays(side, lambda values: values[..., ::-1, :] if values.ndim else values)
            return side_reversal(side, after, np.ones(()), spool)

        return turn(at.flexor, radius), turn(at.extensor, radius * at.design.ratio)

    @cached_property
    def _sliding(self) -> tuple[Flags, Turns]:
        """Direction in which the tendons slide, (designs, samples), and their turns."""
        angle = self._spool_angle
        mean = self._flat(0.5 * (angle[..., :1, :] + angle[..., 1:, :]))
        return spool_turns(mean, self._play)

    def _play(self, designs: Rows, samples: Rows) -> Array:
        """Return the larger play of both tendons and candidates, rad."""
        at = self.candidates.balance
        largest = np.zeros(samples.shape)
        for tension, side in zip((at.flexor, at.extensor), self._turns_of_sides, strict=True):
            for direction in (0, 1):
                force = self._pick(tension, designs, direction, samples)
                per_newton = self._pick(side.turn, designs, direction, samples)
                largest = np.fmax(largest, force * per_newton)
        return largest

    @property
    def _largest_play(self) -> Array:
        """Largest play of each design at the start of the motion and at its turns, rad."""
        flexion, turns = self._sliding
        designs = np.arange(len(flexion))
        largest = self._play(designs, np.zeros_like(designs))
        np.maximum.at(largest, turns.design, turns.play)
        return largest

    @cached_property
    def flexion(self) -> Flags:
        """True where the tendons slide as in flexion, (..., 1, K)."""
        return np.asarray(self._of_states(self._sliding[0]))

    @cached_property
    def _held(self) -> State:
        """States that hold, (..., 1, K), without their sliding."""
        return _pick_direction(self.candidates, self.flexion)

    @cached_property
    def rates(self) -> TendonRates:
        """Rates of the tendons in the states that hold."""
        return tendon_rates(self._held)

    @cached_property
    def motor_rates(self) -> MotorRates:
        """Rates of motor, springs and friction in the states that hold."""
        return motor_rates(self._held, self.rates)

    @cached_property
    def state(self) -> State:
        """States that hold, (..., 1, K), with their sliding."""
        return replace(self._held, sliding=self.sliding)

    @cached_property
    def turned(self) -> State:
        """States of the other direction where the tendons turn, elsewhere those that hold."""
        return _pick_direction(self.candidates, self.flexion ^ self.sliding.turning)

    @cached_property
    def counted_states(self) -> tuple[State, State]:
        """`state` and `turned` at the samples that count alone."""
        counted = self.trajectory.counted
        count = self.shape[-1]
        return at_samples(self.state, counted, count), at_samples(self.turned, counted, count)

    @cached_property
    def power(self) -> Array:
        """Power of the motor in the states that hold, (..., 1, K), W."""
        return motor_power(self._held, self.rates)

    @cached_property
    def passing(self) -> Flags:
        """True where slack passes from one side to the other, (..., 1, K)."""
        return np.asarray(self._of_states(slack_passes(self._flat(self._held.status))))

    def slack_count(self) -> Array:
        """Return the number of samples that count at which a tendon is, or may be, slack, (...)."""
        is_slack = self._flat(self._held.balance.is_slack | self.turned.balance.is_slack)
        counted = is_slack[:, self.trajectory.counted]
        return np.asarray(counted.sum(axis=1).astype(np.float64).reshape(self.shape[:-1]))

    @cached_property
    def sliding(self) -> Sliding:
        """Way in which the tendons slide."""
        flexion, turns = self._sliding
        before = np.where(turns.to_flexion, 1, 0)  # direction before each turn
        start = self._pick(self._spool_angle, turns.design, before, turns.sample)
        spool_angle = self._flat(_choose(self._spool_angle, self.flexion))
        goes_back = against(self._ends_of_tendons(), flexion)
        turning = self._flat(self.passing) | goes_back | in_play(spool_angle, flexion, turns, start)
        turning |= not_past(spool_angle, flexion, turns, goes_back, self._largest_play)
        return Sliding(
            flexion=self.flexion,
            turning=self._of_states(turning),
            passing=self.passing,
            other_torque=_choose(self.candidates.motor_torque, ~self.flexion),
            turn_loss=self._of_states(self._turn_loss(before)),
        )

    def _ends_of_tendons(self) -> list[tuple[Array, Flags]]:
        """Return the speeds of both ends of each tendon in flexion, m/s, and where it pulls."""
        at = self._held
        rates = self.rates
        of_flexor = at.flexor.sliding_speeds(
            at.balance.flexor, rates.flexor, rates.path_shortening, rates.turning
        )
        of_extensor = at.extensor.sliding_speeds(
            at.balance.extensor, rates.extensor, -rates.path_lengthening, rates.turning
        )
        flexor_pulls = self._flat(rates.flexor_pulls)
        extensor_pulls = self._flat(rates.extensor_pulls)
        return [
            *((self._flat(speed), flexor_pulls) for speed in of_flexor),
            *((self._flat(-speed), extensor_pulls) for speed in of_extensor),
        ]

    def _turn_loss(self, before: Rows) -> Array:
        """Return what friction takes in the turns, at the samples where they begin, J.

        Args:
            before: Directions before the turns, as places among the candidates.
        """
        turns = self._sliding[1]
        at = self.candidates.balance
        loss = np.zeros((math.prod(self.shape[:-1]), self.shape[-1]))
        for side, tension in zip(self._turns_of_sides, (at.flexor, at.extensor), strict=True):
            force = self._pick(tension, turns.design, before, turns.sample)
            per_square = self._pick(side.loss, turns.design, before, turns.sample)
            loss[turns.design, turns.sample] += per_square * np.square(force)
        return loss


def at_samples(at: State, samples: slice, count: int) -> State:
    """Return states along a trajectory of `count` samples at some of these alone."""

    def select(values: Array) -> Array:
        return values[..., samples] if values.ndim and values.shape[-1] == count else values

    selected: State = map_arrays(at, select)
    return selected


def motion_columns(moving: Moving) -> dict[str, Array]:
    """Return columns of designs along a trajectory by name, over the designs' axes.

    Integrals over time are sums over its samples; friction's loss has that of the turns, too, and
    is NaN if the tendons turn all the time. Differences are NaN, because there is no other
    direction at the same angle to compare with. Units are those of `quantities.OF_CYCLES` and
    `quantities.OF_TRAJECTORIES`.
    """
    trajectory = moving.trajectory
    counted = trajectory.counted
    rates = moving.motor_rates
    spool_angle = moving.along(rates.spool_angle)
    torque_squared = moving.along(np.square(moving.state.motor_torque))
    turning = moving.along(moving.sliding.turning)
    differs = moving.along(moving.flexion) != trajectory.is_flexing
    is_opposite = differs & (trajectory.speed != 0.0)
    turning_fraction = np.asarray(turning[..., counted].mean(axis=-1))

    # Where an end of a tendon goes back while it turns, friction acts the other way.
    friction = moving.along(rates.friction)
    taken = np.where(turning, np.abs(friction), friction)
    of_turns = moving.along(moving.sliding.turn_loss)[..., counted].sum(axis=-1)
    slides_somewhere = turning_fraction <= _MOST_TURNING
    loss = np.where(slides_somewhere, _total(moving, taken) + of_turns, np.nan)

    power = moving.along(moving.power)
    work = _total(moving, np.maximum(power, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        efficiency = np.asarray(np.where(work > 0.0, 1.0 - loss / work, np.nan))
    unknown = np.full(moving.shape[:-1], np.nan)
    return {
        "peak_motor_speed": _peak_speed(moving),
        "peak_motor_power": peak_power(moving),
        "peak_braking_power": np.maximum(_largest_known(moving, -power), 0.0),
        "motor_work_in": work,
        "friction_loss": loss,
        "efficiency": efficiency,
        "spool_travel": _largest(moving, spool_angle) + _largest(moving, -spool_angle),
        "max_backlash": unknown,
        "max_torque_band": unknown,
        "rms_motor_torque": np.sqrt(torque_squared @ trajectory.weights / trajectory.weights.sum()),
        "braking_work": _total(moving, np.maximum(-power, 0.0)),
        "turning_fraction": turning_fraction,
        "opposite_fraction": np.asarray(is_opposite[..., counted].mean(axis=-1)),
    }


def peak_power(moving: Moving) -> Array:
    """Return the largest power that the motor gives, W."""
    return np.maximum(_largest_known(moving, moving.along(moving.power)), 0.0)


def motion_demand(moving: Moving) -> tuple[float, float]:
    """Return the largest speed (rad/s) and power (W) that designs ask of their motors.

    They are NaN if no sample that counts has a value.
    """
    speed = np.fmax.reduce(_peak_speed(moving), axis=None)
    return float(speed), float(np.fmax.reduce(peak_power(moving), axis=None))


def _peak_speed(moving: Moving) -> Array:
    """Return the largest speed of the motor, rad/s."""
    return _largest_known(moving, np.abs(moving.along(moving.motor_rates.spool_speed)))


def _total(moving: Moving, values: Array) -> Array:
    """Return the integral of values, (..., K), over time."""
    known = np.where(moving.along(moving.passing), 0.0, values)
    return np.asarray(known @ moving.trajectory.weights)


def _largest(moving: Moving, values: Array) -> Array:
    """Return the largest of values, (..., K), that count; NaN if none is known."""
    return np.asarray(np.fmax.reduce(values[..., moving.trajectory.counted], axis=-1))


def _largest_known(moving: Moving, values: Array) -> Array:
    """Return the largest of values that count, but where slack passes from side to side."""
    return _largest(moving, np.where(moving.along(moving.passing), np.nan, values))


def _choose(values: Array, flexion: Flags) -> Array:
    """Return the values of candidates in the directions given, (..., 1, K)."""
    if values.ndim < 2 or values.shape[-2] == 1:
        return values
    return np.where(flexion, values[..., :1, :], values[..., 1:, :])


def _pick_direction(candidates: State, flexion: Flags) -> State:
    """Return the candidates in the directions given, (..., 1, K)."""

    def choose(values: Array) -> Array:
        return _choose(values, flexion)

    picked = replace(
        candidates,
        flexor=map_arrays(candidates.flexor, choose),
        extensor=map_arrays(candidates.extensor, choose),
    )
    vars(picked)["response"] = map_arrays(candidates.response, choose)
    return picked
