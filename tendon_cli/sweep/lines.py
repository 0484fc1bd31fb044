"""A look at all states of a tile in NumPy: every result of a state is a straight line in pretension.

With v = max(F - shortfall, lowest), which `statics.respond` derives, tensions, motor torque and stiffness are lines in
v that do not depend on the pretension F. For each F a few passes over these find what is smallest, largest and counted.
`compiled` does the same, operation by operation, where a C compiler was at hand.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.model import actuator, statics
from tendon_cli.model.kinematics import Array
from tendon_cli.model.statics import Response
from tendon_cli.sweep.tile import Flags, Range, Seen, Tile


@dataclass(frozen=True, eq=False)
class Line:
    """floor + gain v, for every state."""

    floor: Array | None
    """None for nothing."""
    gain: Array

    def __call__(self, v: Array, out: Array) -> Array:
        """The values at v, written into `out`."""
        np.multiply(self.gain, v, out=out)
        if self.floor is not None:
            np.add(out, self.floor, out=out)
        return out


@dataclass(frozen=True, eq=False)
class Lines:
    """The states of a tile: one row for each elbow angle, one column for each direction of each design, (K, D B)."""

    shortfall: Array
    lowest: Array
    limit: Array
    """Pretension below which a state counts as slack, N."""
    flexor: Line
    extensor: Line
    motor: Line
    stiffness: Line
    """Elbow stiffness as `statics.elbow_stiffness` has it while both tendons pull, N m/rad."""
    slack_stiffness: Array
    """Elbow stiffness where the state is slack, N m/rad; infinite in the bilateral model, which loses nothing."""
    pretension: Array
    """(P, 1), or (P, D B) where it differs between columns, N."""

    @classmethod
    def of(cls, tile: Tile, response: Response) -> Lines:
        """Lay the lines out for passes over whole arrays."""
        shape, pretension = tile.shape, tile.pretension
        flexor_arm, extensor_arm = actuator.motor_arms(tile.design, tile.flexor, tile.extensor)
        motor_floor = response.flexor_floor * flexor_arm - response.extensor_floor * extensor_arm
        motor_gain = response.flexor_gain * flexor_arm - response.extensor_gain * extensor_arm
        stiffness_floor, stiffness_gain, slack_stiffness = _stiffness(tile, response)
        return cls(
            shortfall=_flat(response.shortfall, shape),
            lowest=_flat(response.lowest, shape),
            limit=_flat(response.limit, shape),
            flexor=_line(response.flexor_floor, response.flexor_gain, shape),
            extensor=_line(response.extensor_floor, response.extensor_gain, shape),
            motor=_line(motor_floor, motor_gain, shape),
            stiffness=_line(stiffness_floor, stiffness_gain, shape),
            slack_stiffness=_flat(slack_stiffness, shape),
            pretension=pretension[:, 0]
            if pretension[0].size == 1
            else _flat(pretension, (len(pretension), *shape[1:])),
        )


def look(tile: Tile) -> Seen:
    """Look at all states of a tile, once for each pretension."""
    response = statics.respond(tile.coupling, unilateral=tile.design.unilateral)
    lines, seen = Lines.of(tile, response), Seen.empty(tile.pretensions, tile.shape)
    slackness = _Slackness.of(lines, tile.elbow_angle)
    taking, values = np.empty_like(lines.limit), np.empty_like(lines.limit)
    for index, pretension in enumerate(lines.pretension):
        np.subtract(pretension, lines.shortfall, out=taking)
        np.maximum(taking, lines.lowest, out=taking)
        _take(seen.flexor, index, lines.flexor(taking, values))
        _take(seen.extensor, index, lines.extensor(taking, values))
        _take(seen.motor, index, lines.motor(taking, values))
        slackness.take(seen, index, pretension, lines.stiffness(taking, values))
    _look_aside(tile, response, seen)
    return seen


def _take(found: Range, index: int, values: Array) -> None:
    np.fmin.reduce(values, axis=0, out=found.lowest[index].reshape(-1))
    np.fmax.reduce(values, axis=0, out=found.highest[index].reshape(-1))


@dataclass(frozen=True, eq=False)
class _Slackness:
    """Which states of a tile are slack or unstable at a pretension."""

    lines: Lines
    highest_limit: Array
    """At or above this pretension no state of a column is slack, N."""
    limit_until: Array
    """At or above this pretension no state of a column is slack at this angle or at a smaller one, N."""
    angles: Array
    """Elbow angles, ascending, and not a number for none at all, rad."""

    @classmethod
    def of(cls, lines: Lines, elbow_angle: Array) -> _Slackness:
        order = np.argsort(elbow_angle, kind="stable")
        until = np.fmax.accumulate(np.fmax(lines.limit[order], -np.inf), axis=0)
        return cls(lines, until[-1], until, np.append(elbow_angle[order], np.nan))

    def take(self, seen: Seen, index: int, pretension: Array, stiffness: Array) -> None:
        """Note what a pretension does, given each state's stiffness as if both tendons pulled."""
        shape = seen.slack[index].shape
        seen.slack[index], seen.first_slack_angle[index] = 0.0, np.nan
        if (pretension < self.highest_limit).any():
            slack = pretension < self.lines.limit
            seen.slack[index] = _count(slack).reshape(shape)
            seen.first_slack_angle[index] = self.angles[_count(pretension >= self.limit_until)].reshape(shape)
            # A state is never stiffer slack than taut. One without equilibrium stays not a number: no fmin here.
            stiffness = np.minimum(stiffness, np.where(slack, self.lines.slack_stiffness, np.inf))
        lowest = np.fmin.reduce(stiffness, axis=0, out=seen.stiffness[index].reshape(-1))
        seen.unstable[index] = _count(stiffness < 0.0).reshape(shape) if np.fmin.reduce(lowest) < 0.0 else 0.0


def _look_aside(tile: Tile, response: Response, seen: Seen) -> None:
    """What no pretension changes: how far a tile's states are from slack, and on which side."""
    torque = np.where(np.isnan(tile.coupling.moment_arm), np.nan, tile.coupling.elbow_torque)
    seen.elbow_torque.lowest[...] = np.fmin.reduce(torque, axis=0)
    seen.elbow_torque.highest[...] = np.fmax.reduce(torque, axis=0)
    seen.shortfall[...] = np.fmax.reduce(response.shortfall, axis=0)
    backward, nowhere = tile.coupling.elbow_torque < 0.0, np.isnan(response.limit)
    one_sided = ~nowhere & ~response.idle
    for side, chosen in zip(seen.sides, (backward, ~backward), strict=True):
        alone = chosen & one_sided
        side.shortfall[...] = np.fmax.reduce(np.where(alone, response.shortfall, -np.inf), axis=0)
        side.limit[...] = np.fmax.reduce(np.where(alone, response.limit, -np.inf), axis=0)
    seen.one_sided[...] = np.logical_or.reduce(one_sided, axis=0)
    seen.both_limit[...] = np.fmin.reduce(np.where(response.idle, response.limit, np.inf), axis=0)
    seen.no_equilibrium[...] = np.add.reduce(nowhere, axis=0)


def _stiffness(tile: Tile, response: Response) -> tuple[Array, Array, Array]:
    """Elbow stiffness while taut, floor and gain of a line in v, and what is left of it where the state is slack."""
    tied, unilateral = tile.coupling, tile.design.unilateral
    flexor = np.square(tied.moment_arm) * (1.0 / tied.flexor_compliance)
    extensor = np.square(tied.elbow_radius) / tied.extensor_compliance
    torque_slope, arm_slope = tile.moment * np.cos(tile.inclination), tile.motion.flexor_moment_arm_slope
    floor = flexor + extensor + (torque_slope - arm_slope * response.flexor_floor)
    backward = tied.elbow_torque < 0.0
    lost = statics.by_side(backward, flexor, extensor) + response.idle * statics.by_side(backward, extensor, flexor)
    left = floor - lost
    if not np.all(unilateral):
        left = np.where(unilateral, left, np.inf)
    return floor, -arm_slope * response.flexor_gain, left


def _count(flags: Flags) -> npt.NDArray[np.intp]:
    """How many rows have their flag set, by column. Bytes add up fastest; they hold up to 255."""
    narrow = np.uint8 if len(flags) < 256 else np.int64
    counts = np.add.reduce(flags.view(np.uint8), axis=0, dtype=narrow)
    return np.asarray(counts, dtype=np.intp)


def _flat(values: Array, shape: tuple[int, ...]) -> Array:
    return np.ascontiguousarray(np.broadcast_to(values, shape)).reshape(shape[0], -1)


def _line(floor: Array, gain: Array, shape: tuple[int, ...]) -> Line:
    return Line(_flat(floor, shape) if floor.any() else None, _flat(gain, shape))
