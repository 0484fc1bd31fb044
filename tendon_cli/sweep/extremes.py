"""What each design comes to over all its states: extremes and counts, the results of the `designs` table."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tendon_cli.model.actuator import Design
from tendon_cli.model.kinematics import Array
from tendon_cli.sweep import native
from tendon_cli.sweep.tile import Flags, Seen, Tile, only_designs

Extremes = dict[str, npt.NDArray[np.float64]]

_LOWEST = ("min_flexor_tension", "min_extensor_tension", "min_elbow_stiffness", "first_slack_angle", "margin",
           "lowest_elbow_torque", "lowest_motor_torque")  # fmt: skip
_HIGHEST = ("max_tension", "max_spring_extension", "max_slack", "required_pretension",
            "highest_elbow_torque", "highest_motor_torque")  # fmt: skip
COUNTS = ("slack", "no_equilibrium", "unstable")


def blocks_at_once() -> int:
    """How many blocks of a plan make the tile that is looked at fastest; the results do not depend on it."""
    return 16 if native.library() else 1


def extremes(design: Design, elbow_angle: Array, flexion: Flags) -> Extremes:
    """Smallest, largest and counted over all states of a tile; `finished` makes columns of them.

    The arguments are those of `Tile.of`; the results broadcast to (P, B).
    """
    tile = Tile.of(design, elbow_angle, flexion)
    seen = _look(tile)
    return (
        _tensions(tile, seen)
        | _pretensions(tile, seen)
        | {
            "max_slack": _longest_slack(tile, seen),
            "lowest_motor_torque": np.fmin.reduce(seen.motor.lowest, axis=1),
            "highest_motor_torque": np.fmax.reduce(seen.motor.highest, axis=1),
            "lowest_elbow_torque": np.fmin.reduce(seen.elbow_torque.lowest, axis=0)[np.newaxis],
            "highest_elbow_torque": np.fmax.reduce(seen.elbow_torque.highest, axis=0)[np.newaxis],
            "min_elbow_stiffness": np.fmin.reduce(seen.stiffness, axis=1),
            "unstable": np.add.reduce(seen.unstable, axis=1),
            "slack": np.add.reduce(seen.slack, axis=1),
            "no_equilibrium": np.add.reduce(seen.no_equilibrium, axis=0)[np.newaxis],
            "first_slack_angle": np.fmin.reduce(seen.first_slack_angle, axis=1),
        }
    )


def _look(tile: Tile) -> Seen:
    """By what is at hand; the other is not even imported."""
    if code := native.library():
        from tendon_cli.sweep import compiled

        return compiled.look(tile, code)
    from tendon_cli.sweep import lines

    return lines.look(tile)


def merge(first: Extremes, second: Extremes) -> Extremes:
    """The extremes of the same designs over two sets of states."""
    merged = {name: np.fmin(first[name], second[name]) for name in _LOWEST}
    merged |= {name: np.fmax(first[name], second[name]) for name in _HIGHEST}
    return merged | {name: first[name] + second[name] for name in COUNTS}


def finished(found: Extremes, states: int, least_stiffness: float = 0.0) -> Extremes:
    """The result columns of `designs`, from the extremes over all `states` of each design.

    A design is stable where no state has less elbow stiffness than `least_stiffness`, N m/rad.
    """
    unanswerable = found["no_equilibrium"] > 0
    failing = found["slack"] + found["no_equilibrium"]
    columns = {name: found[name] for name in (*_LOWEST, *_HIGHEST) if not name.endswith("_torque")}
    columns |= {
        "peak_elbow_torque": _larger(found["lowest_elbow_torque"], found["highest_elbow_torque"]),
        "peak_motor_torque": _larger(found["lowest_motor_torque"], found["highest_motor_torque"]),
        "slack_fraction": failing / states,
        "unstable_fraction": found["unstable"] / states,
        "required_pretension": np.where(unanswerable, np.nan, np.maximum(0.0, found["required_pretension"])),
        "margin": np.where(unanswerable, np.nan, found["margin"]),
    }
    # Minus nought becomes nought: which of the two is the smallest depends on the order in which states are looked at.
    taut, stable = failing == 0, ~(columns["min_elbow_stiffness"] < least_stiffness)
    judged = {"taut": taut, "stable": stable, "feasible": taut & stable}
    return {name: values + 0.0 for name, values in columns.items()} | judged


def _tensions(tile: Tile, seen: Seen) -> Extremes:
    """Extremes of all tensions. Along a sheath tension only scales, so the distal extremes of a direction suffice."""
    low_x, high_x = seen.flexor.lowest, seen.flexor.highest
    low_y, high_y = seen.extensor.lowest, seen.extensor.highest
    capstan_x, capstan_y = tile.flexor.capstan[0], tile.extensor.capstan[0]
    highest = np.maximum(np.maximum(high_x, high_x / capstan_x), np.maximum(high_y, high_y / capstan_y))
    spring_x, spring_y = only_designs(tile.flexor.spring), only_designs(tile.extensor.spring)
    extension = np.maximum(high_x * spring_x, high_y * spring_y)
    return {
        "min_flexor_tension": np.fmin.reduce(np.minimum(low_x, low_x / capstan_x), axis=1),
        "min_extensor_tension": np.fmin.reduce(np.minimum(low_y, low_y / capstan_y), axis=1),
        "max_tension": np.fmax.reduce(highest, axis=1),
        "max_spring_extension": np.fmax.reduce(extension, axis=1),
    }


def _longest_slack(tile: Tile, seen: Seen) -> Array:
    """The longest slack of either tendon.

    Below its shortfall a state has η c_f + c_e metres of loose path per newton, which differs between directions only,
    so the state with the largest shortfall on a side has the longest slack. Where both tendons are slack, only their
    sum is determined, and such a state tells no length.
    """
    pretension, looseness = tile.pretension, tile.looseness
    longest = np.zeros(1)
    per_ratio = 1.0 / only_designs(tile.design.ratio)
    for side, share in zip(seen.sides, (per_ratio, np.ones(())), strict=True):
        length = looseness * share * (side.shortfall - pretension)
        longest = np.maximum(longest, np.where(pretension < side.limit, length, 0.0))
    told = seen.one_sided | (pretension >= seen.both_limit)
    told = np.logical_or.reduce(told, axis=1) & only_designs(tile.design.unilateral)
    return np.where(told, np.fmax.reduce(longest, axis=1), np.nan)


def _pretensions(tile: Tile, seen: Seen) -> Extremes:
    """What pretension is required, and how much is in hand: both could be lowered together by that much."""
    in_hand = np.fmin.reduce(tile.pretension - seen.shortfall, axis=1)
    smaller = np.minimum(tile.design.flexor.pretension, tile.design.extensor.pretension)
    smaller = smaller.reshape(-1, smaller.shape[-1]) if smaller.ndim else smaller
    return {
        "required_pretension": np.fmax.reduce(seen.shortfall, axis=0)[np.newaxis],
        "margin": np.minimum(in_hand, smaller),
    }


def _larger(lowest: Array, highest: Array) -> Array:
    """Of two values the one of larger magnitude, with its sign."""
    return np.where(-lowest > highest, lowest, highest)
