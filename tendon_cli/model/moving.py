"""States of designs along a motion in time, and the columns of designs that follow from them.

At each sample both directions of friction give a state, a candidate; `sliding` tells which one
holds. Where the tendons turn, torque and tensions lie between both, so that peaks and limits count
both there; speed and power are those of the state that holds. Samples at the ends of the record
count nowhere. Arrays of states are (designs..., directions, samples); SI units, angles in radians.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design, map_arrays, shape_of
from tendon_cli.model.kinematics import Array, Flags, Real, Rows
from tendon_cli.model.motor import MotorRates, TendonRates, motor_power, motor_rates, tendon_rates
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
from tendon_cli.quantities import OF_CYCLES, OF_TRAJECTORIES, SIDES

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
        moved = Moving(_at_pretension(self.candidates, pretension), self.trajectory)
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
        of_states = np.broadcast_to(values, (*self.shape[:-1], 1, self.shape[-1]))
        return of_states.reshape(math.prod(self.shape[:-1]), self.shape[-1])

    def _of_states(self, values: Any) -> Any:
        """Return values (designs, samples) as those of states in one direction."""
        return values.reshape(*self.shape[:-1], 1, self.shape[-1])

    def _pick(self, values: Array, designs: Rows, directions: Rows | int, samples: Rows) -> Array:
        """Return values of candidates at designs, directions and samples, all of one shape."""
        whole = np.broadcast_to(values, (*self.shape[:-1], 2, self.shape[-1]))
        place = np.unravel_index(designs, self.shape[:-1]) if self.shape[:-1] else ()
        return np.asarray(whole[(*place, directions, samples)])

    # --- Which state holds ------------------------------------------------------------------------

    @cached_property
    def _spool_angle(self) -> Array:
        """Spool angle of the candidates from the unstretched flexor, rad."""
        return _from_unstretched_flexor(self.candidates)

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
        return _with(self._held, sliding=self.sliding)

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


@dataclass(frozen=True, eq=False)
class MotionTotals:
    """Columns of designs along a trajectory, each worked out when it is asked for.

    Integrals over time are sums over its samples; friction's loss has that of the turns, too, and
    is NaN if the tendons turn all the time. Differences are NaN, because there is no other
    direction at the same angle to compare with. Values are over the designs' axes, with units as in
    `quantities.OF_CYCLES` and `quantities.OF_TRAJECTORIES`.
    """

    moving: Moving

    @property
    def peak_motor_speed(self) -> Array:
        """Largest speed of the motor, rad/s."""
        speed = self._samples(self.moving.motor_rates.spool_speed)
        return self._largest(np.where(self._passing, np.nan, np.abs(speed)))

    @property
    def peak_motor_power(self) -> Array:
        """Largest power that the motor gives, W."""
        return np.maximum(self._largest(self._known_power), 0.0)

    @property
    def peak_braking_power(self) -> Array:
        """Largest power that the motor takes, W."""
        return np.maximum(self._largest(-self._known_power), 0.0)

    @cached_property
    def motor_work_in(self) -> Array:
        """Work that the motor gives, J."""
        return self._total(np.maximum(self._power, 0.0))

    @property
    def braking_work(self) -> Array:
        """Work that the motor takes, J."""
        return self._total(np.maximum(-self._power, 0.0))

    @cached_property
    def friction_loss(self) -> Array:
        """Work that friction takes, J."""
        counted = self.moving.trajectory.counted
        friction = self._samples(self.moving.motor_rates.friction)
        # Where an end of a tendon goes back while it turns, friction acts the other way.
        taken = np.where(self._turning, np.abs(friction), friction)
        turn_loss = self._samples(self.moving.sliding.turn_loss)
        of_turns = turn_loss[..., counted].sum(axis=-1)
        slides_somewhere = self.turning_fraction <= _MOST_TURNING
        return np.where(slides_somewhere, self._total(taken) + of_turns, np.nan)

    @property
    def efficiency(self) -> Array:
        """1 less the loss over the work that the motor gives."""
        work = self.motor_work_in
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.where(work > 0.0, 1.0 - self.friction_loss / work, np.nan))

    @property
    def spool_travel(self) -> Array:
        """Rotation of the spool between its ends, rad."""
        spool_angle = self._samples(self.moving.motor_rates.spool_angle)
        return self._largest(spool_angle) + self._largest(-spool_angle)

    @property
    def max_backlash(self) -> Array:
        """Largest difference of the spool angle between the directions: unknown, NaN."""
        return np.full(self.moving.shape[:-1], np.nan)

    @property
    def max_torque_band(self) -> Array:
        """Largest difference of the motor torque between the directions: unknown, NaN."""
        return np.full(self.moving.shape[:-1], np.nan)

    @property
    def rms_motor_torque(self) -> Array:
        """Root of the mean square of the motor torque, N m."""
        weights = self.moving.trajectory.weights
        squares = self._samples(np.square(self.moving.state.motor_torque))
        return np.asarray(np.sqrt(squares @ weights / weights.sum()))

    @property
    def turning_fraction(self) -> Array:
        """Share of the samples at which the tendons turn."""
        counted = self.moving.trajectory.counted
        return np.asarray(self._turning[..., counted].mean(axis=-1))

    @property
    def opposite_fraction(self) -> Array:
        """Share of the samples at which the spool turns against the joint."""
        trajectory = self.moving.trajectory
        differs = self._samples(self.moving.flexion) != trajectory.is_flexing
        is_opposite = differs & (trajectory.speed != 0.0)
        return np.asarray(is_opposite[..., trajectory.counted].mean(axis=-1))

    @property
    def _passing(self) -> Flags:
        """True where slack passes from one side to the other, (..., K)."""
        return np.asarray(self._samples(self.moving.passing))

    @property
    def _turning(self) -> Flags:
        """True where the tendons turn, (..., K)."""
        return np.asarray(self._samples(self.moving.sliding.turning))

    @property
    def _power(self) -> Array:
        """Power of the motor, (..., K), W."""
        return np.asarray(self._samples(self.moving.power))

    @property
    def _known_power(self) -> Array:
        """Power of the motor, (..., K), W; NaN where slack passes from one side to the other."""
        return np.where(self._passing, np.nan, self._power)

    def _samples(self, values: Any) -> Any:
        """Return values of states in one direction at all samples, (..., K)."""
        shape = self.moving.shape
        of_states = np.broadcast_to(values, (*shape[:-1], 1, shape[-1]))
        return of_states[..., 0, :]

    def _total(self, values: Array) -> Array:
        """Return the integral of values, (..., K), over time."""
        known = np.where(self._passing, 0.0, values)
        return np.asarray(known @ self.moving.trajectory.weights)

    def _largest(self, values: Array) -> Array:
        """Return the largest of values, (..., K), that count; NaN if none is known."""
        counted = self.moving.trajectory.counted
        return np.asarray(np.fmax.reduce(values[..., counted], axis=-1))


_MOTION_COLUMNS = (*OF_CYCLES, *OF_TRAJECTORIES)


def motion_columns(moving: Moving, names: Iterable[str] = _MOTION_COLUMNS) -> dict[str, Array]:
    """Return columns of designs along a trajectory by name, by default all (`MotionTotals`)."""
    totals = MotionTotals(moving)
    return {name: getattr(totals, name) for name in names}


def motion_demand(moving: Moving) -> tuple[float, float]:
    """Return the largest speed (rad/s) and power (W) that designs ask of their motors.

    They are NaN if no sample that counts has a value.
    """
    totals = MotionTotals(moving)
    speed = np.fmax.reduce(totals.peak_motor_speed, axis=None)
    return float(speed), float(np.fmax.reduce(totals.peak_motor_power, axis=None))


def _from_unstretched_flexor(at: State) -> Array:
    """Return the spool angle from the unstretched flexor, a zero for both directions, rad."""
    resting = at.flexor if at.resting is None else at.resting[0]
    stretch = resting.compliance * at.design.flexor.pretension
    return np.asarray(at.spool_angle + stretch / at.design.flexor_radius)


def _at_pretension(at: State, pretension: Real) -> State:
    """Return states at a pretension of both sides, N, with what it does not change."""
    sides = {name: replace(getattr(at.design, name), pretension=pretension) for name in SIDES}
    changed = replace(at, design=replace(at.design, **sides))
    known = ("coupling", "arm_slopes", "response", "held_stiffness", "motor_arms")
    vars(changed).update({name: vars(at)[name] for name in known if name in vars(at)})
    return changed


def _choose(values: Array, flexion: Flags) -> Array:
    """Return the values of candidates in the directions given, (..., 1, K)."""
    if values.ndim < 2 or values.shape[-2] == 1:
        return values
    return np.where(flexion, values[..., :1, :], values[..., 1:, :])


def _pick_direction(candidates: State, flexion: Flags) -> State:
    """Return the candidates in the directions given, (..., 1, K), with what is known of them."""

    def choose(values: Array) -> Array:
        return _choose(values, flexion)

    resting = candidates.resting
    if resting is not None:
        resting = (resting[0].chosen(choose), resting[1].chosen(choose))
    picked = replace(
        candidates,
        flexor=candidates.flexor.chosen(choose),
        extensor=candidates.extensor.chosen(choose),
        resting=resting,
    )
    vars(picked)["response"] = map_arrays(candidates.response, choose)
    return picked


def _with(at: State, **changes: Any) -> State:
    """Return states with other fields, and all that is known of them."""
    changed = replace(at, **changes)
    names = {entry.name for entry in fields(at)}
    vars(changed).update({name: value for name, value in vars(at).items() if name not in names})
    return changed
