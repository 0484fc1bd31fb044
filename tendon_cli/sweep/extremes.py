"""What each design comes to over all its states: extremes and counts, the results of the `designs` table.

A tile's states are straight lines in pretension (`lines`). For each pretension a few passes over these find what is
smallest, largest and counted at all elbow angles, for every design and direction at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.model.actuator import Design
from tendon_cli.model.kinematics import Array
from tendon_cli.sweep.lines import Lines, Tile, only_designs, tile

Extremes = dict[str, npt.NDArray[np.float64]]
Flags = npt.NDArray[np.bool_]

_LOWEST = ("min_flexor_tension", "min_extensor_tension", "min_elbow_stiffness", "first_slack_angle", "margin",
           "lowest_elbow_torque", "lowest_motor_torque")  # fmt: skip
_HIGHEST = ("max_tension", "max_spring_extension", "max_slack", "required_pretension",
            "highest_elbow_torque", "highest_motor_torque")  # fmt: skip
COUNTS = ("slack", "no_equilibrium", "unstable")

_STATES = (0, 1)


def extremes(design: Design, elbow_angle: Array, flexion: Flags) -> Extremes:
    """Smallest, largest and counted over all states of a tile; `finished` makes columns of them.

    The arguments are those of `lines.tile`; the results broadcast to (P, B).
    """
    of = tile(design, elbow_angle, flexion)
    seen = _look(of, elbow_angle.reshape(-1))
    return (
        _tensions(of, seen)
        | _slack_lengths(of)
        | _pretensions(of)
        | {
            "lowest_motor_torque": np.fmin.reduce(seen.motor.lowest, axis=1),
            "highest_motor_torque": np.fmax.reduce(seen.motor.highest, axis=1),
            "lowest_elbow_torque": np.fmin.reduce(of.elbow_torque, axis=_STATES)[np.newaxis],
            "highest_elbow_torque": np.fmax.reduce(of.elbow_torque, axis=_STATES)[np.newaxis],
            "min_elbow_stiffness": np.fmin.reduce(seen.stiffness, axis=1),
            "unstable": np.add.reduce(seen.unstable, axis=1),
            "slack": np.add.reduce(seen.slack, axis=1),
            "no_equilibrium": np.add.reduce(np.isnan(of.lines.limit).reshape(of.shape), axis=_STATES, dtype=np.float64)[
                np.newaxis
            ],
            "first_slack_angle": np.fmin.reduce(seen.first_slack_angle, axis=1),
        }
    )


def merge(first: Extremes, second: Extremes) -> Extremes:
    """The extremes of the same designs over two sets of states."""
    merged = {name: np.fmin(first[name], second[name]) for name in _LOWEST}
    merged |= {name: np.fmax(first[name], second[name]) for name in _HIGHEST}
    return merged | {name: first[name] + second[name] for name in COUNTS}


def finished(found: Extremes, states: int) -> Extremes:
    """The result columns of `designs`, from the extremes over all `states` of each design."""
    unanswerable = found["no_equilibrium"] > 0
    failing = found["slack"] + found["no_equilibrium"]
    columns = {name: found[name] for name in (*_LOWEST, *_HIGHEST) if "_elbow_torque" not in name}
    return columns | {
        "peak_elbow_torque": _larger(found["lowest_elbow_torque"], found["highest_elbow_torque"]),
        "peak_motor_torque": _larger(found["lowest_motor_torque"], found["highest_motor_torque"]),
        "slack_fraction": failing / states,
        "unstable_fraction": found["unstable"] / states,
        "required_pretension": np.where(unanswerable, np.nan, np.maximum(0.0, found["required_pretension"])),
        "margin": np.where(unanswerable, np.nan, found["margin"]),
        "feasible": failing == 0,
    }


@dataclass(frozen=True)
class _Range:
    """Smallest and largest value over the elbow angles, (P, D, B)."""

    lowest: Array
    highest: Array

    @classmethod
    def empty(cls, shape: tuple[int, ...]) -> _Range:
        return cls(np.empty(shape), np.empty(shape))

    def take(self, index: int, values: Array) -> None:
        np.fmin.reduce(values, axis=0, out=self.lowest[index].reshape(-1))
        np.fmax.reduce(values, axis=0, out=self.highest[index].reshape(-1))


@dataclass(frozen=True)
class _Seen:
    """What the passes over a tile's states found, (P, D, B)."""

    flexor: _Range
    extensor: _Range
    motor: _Range
    stiffness: Array
    unstable: Array
    slack: Array
    first_slack_angle: Array


def _look(of: Tile, elbow_angle: Array) -> _Seen:
    """Go over all states once for each pretension."""
    lines, shape = of.lines, (len(of.pretension), *of.shape[1:])
    ranges = (_Range.empty(shape), _Range.empty(shape), _Range.empty(shape))
    seen = _Seen(*ranges, *(np.empty(shape) for _ in range(4)))
    slackness = _Slackness.of(lines, elbow_angle)
    taking, values = np.empty_like(lines.limit), np.empty_like(lines.limit)
    for index, pretension in enumerate(lines.pretension):
        np.subtract(pretension, lines.shortfall, out=taking)
        np.maximum(taking, lines.lowest, out=taking)
        seen.flexor.take(index, lines.flexor(taking, values))
        seen.extensor.take(index, lines.extensor(taking, values))
        seen.motor.take(index, lines.motor(taking, values))
        slackness.take(seen, index, pretension, lines.stiffness(taking, values))
    return seen


@dataclass(frozen=True)
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

    def take(self, seen: _Seen, index: int, pretension: Array, stiffness: Array) -> None:
        """Note what a pretension does, given each state's stiffness as if both tendons pulled."""
        shape = seen.slack[index].shape
        seen.slack[index], seen.first_slack_angle[index] = 0.0, np.nan
        if (pretension < self.highest_limit).any():
            slack = pretension < self.lines.limit
            seen.slack[index] = _count(slack).reshape(shape)
            seen.first_slack_angle[index] = self.angles[_count(pretension >= self.limit_until)].reshape(shape)
            # A state is never stiffer slack than taut.
            stiffness = np.fmin(stiffness, np.where(slack, self.lines.slack_stiffness, np.inf))
        lowest = np.fmin.reduce(stiffness, axis=0, out=seen.stiffness[index].reshape(-1))
        seen.unstable[index] = _count(stiffness < 0.0).reshape(shape) if np.fmin.reduce(lowest) < 0.0 else 0.0


def _count(flags: Flags) -> npt.NDArray[np.intp]:
    """How many rows have their flag set, by column. Bytes add up fastest; they hold up to 255."""
    narrow = np.uint8 if len(flags) < 256 else np.int64
    counts = np.add.reduce(flags.view(np.uint8), axis=0, dtype=narrow)
    return np.asarray(counts, dtype=np.intp)


def _tensions(of: Tile, seen: _Seen) -> Extremes:
    """Extremes of all tensions. Along a sheath tension only scales, so the distal extremes of a direction suffice."""
    low_x, high_x = seen.flexor.lowest, seen.flexor.highest
    low_y, high_y = seen.extensor.lowest, seen.extensor.highest
    capstan_x, capstan_y = of.flexor.capstan[0], of.extensor.capstan[0]
    highest = np.maximum(np.maximum(high_x, high_x / capstan_x), np.maximum(high_y, high_y / capstan_y))
    spring_x, spring_y = only_designs(of.flexor.spring), only_designs(of.extensor.spring)
    extension = np.maximum(high_x * spring_x, high_y * spring_y)
    return {
        "min_flexor_tension": np.fmin.reduce(np.minimum(low_x, low_x / capstan_x), axis=1),
        "min_extensor_tension": np.fmin.reduce(np.minimum(low_y, low_y / capstan_y), axis=1),
        "max_tension": np.fmax.reduce(highest, axis=1),
        "max_spring_extension": np.fmax.reduce(extension, axis=1),
    }


def _slack_lengths(of: Tile) -> Extremes:
    """The longest slack of either tendon.

    Below its shortfall a state has η c_f + c_e metres of loose path per newton, which differs between directions only,
    so the state with the largest shortfall on a side has the longest slack. Where both tendons are slack, only their
    sum is determined, and such a state tells no length.
    """
    response, pretension = of.response, of.pretension
    balanced, idle, backward = ~np.isnan(response.limit), response.idle, of.coupling.elbow_torque < 0.0
    looseness = of.coupling.common_compliance[0]
    longest = np.zeros((1, 1, 1))
    for side, share in ((backward, 1.0 / only_designs(of.design.ratio)), (~backward, np.ones(()))):
        if side.any():
            alone = side & ~idle
            shortfall = np.fmax.reduce(np.where(alone, response.shortfall, -np.inf), axis=0)
            limit = np.fmax.reduce(np.where(alone, response.limit, -np.inf), axis=0)
            length = np.where(pretension < limit, looseness * share * (shortfall - pretension), 0.0)
            longest = np.maximum(longest, length)
    told = np.logical_or.reduce(balanced & ~idle, axis=0)[np.newaxis]
    if not told.all():
        told = told | (pretension >= np.fmin.reduce(np.where(idle, response.limit, np.inf), axis=0))
    told = np.logical_or.reduce(told, axis=1) & only_designs(of.design.unilateral)
    return {"max_slack": np.where(told, np.fmax.reduce(longest, axis=1), np.nan)}


def _pretensions(of: Tile) -> Extremes:
    """What pretension is required, and how much is in hand: both could be lowered together by that much."""
    shortfall = np.fmax.reduce(of.response.shortfall, axis=0)
    in_hand = np.fmin.reduce(of.pretension - shortfall, axis=1)
    smaller = np.minimum(of.design.flexor.pretension, of.design.extensor.pretension)
    smaller = smaller.reshape(-1, smaller.shape[-1]) if smaller.ndim else smaller
    return {
        "required_pretension": np.fmax.reduce(shortfall, axis=0)[np.newaxis],
        "margin": np.minimum(in_hand, smaller),
    }


def _larger(lowest: Array, highest: Array) -> Array:
    """Of two values the one of larger magnitude, with its sign."""
    return np.where(-lowest > highest, lowest, highest)
