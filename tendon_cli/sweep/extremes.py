"""What each design comes to over all its states: extremes and counts, the results of the `designs` table.

A state's tensions are straight lines in pretension with one kink (`statics.Response`), and all else follows from them:
what does not depend on pretension is computed once for all pretensions of a block, and only a few passes go over all
states. Axis 0 of every array here is the direction, axis 1 the elbow angle, then come the axes of the designs; so
reductions run over whole vectors of designs.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tendon_cli.model import actuator, statics
from tendon_cli.model.actuator import Design, Transmission
from tendon_cli.model.kinematics import Array, Real
from tendon_cli.model.statics import Coupling, Response

Extremes = dict[str, npt.NDArray[np.float64]]
Flags = npt.NDArray[np.bool_]

_LOWEST = ("min_flexor_tension", "min_extensor_tension", "min_elbow_stiffness", "first_slack_angle", "margin",
           "lowest_elbow_torque", "lowest_motor_torque")  # fmt: skip
_HIGHEST = ("max_tension", "max_spring_extension", "max_slack", "required_pretension",
            "highest_elbow_torque", "highest_motor_torque")  # fmt: skip
COUNTS = ("slack", "no_equilibrium", "unstable")

_STATES = (0, 1)


def extremes(design: Design, elbow_angle: Array, flexion: Flags) -> Extremes:
    """Smallest, largest and counted over all states, with the axes of the designs; `finished` makes columns of them."""
    motion, flexor, extensor, tied = actuator.couple(design, elbow_angle, flexion)
    response = statics.respond(tied, unilateral=design.unilateral)
    pretension = statics.common_pretension(tied, design.flexor.pretension, design.extensor.pretension)
    torque, torque_slope = actuator.gravity_torque(design.arm, design.load_mass, elbow_angle)
    torque = np.where(np.isnan(tied.moment_arm), np.nan, torque)
    taking = pretension - response.shortfall
    np.maximum(taking, response.lowest, out=taking)
    slack = pretension < np.fmax(response.flexor_limit, response.extensor_limit)
    x = _line(response.flexor_floor, response.flexor_gain, taking)
    y = _line(response.extensor_floor, response.extensor_gain, taking)
    stiffness = _stiffness(design, tied, response, x, slack, motion.flexor_moment_arm_slope, torque_slope)
    return (
        _tensions(x, y, flexor, extensor)
        | _motor_torques(design, response, flexor, extensor, taking)
        | _slack_lengths(design, tied, response, pretension)
        | _pretensions(design, response, pretension)
        | {
            "lowest_elbow_torque": np.fmin.reduce(torque, axis=_STATES),
            "highest_elbow_torque": np.fmax.reduce(torque, axis=_STATES),
            "min_elbow_stiffness": np.fmin.reduce(stiffness, axis=_STATES),
            "unstable": _count(stiffness < 0.0),
            "slack": _count(slack),
            "no_equilibrium": _count(np.isnan(tied.moment_arm)) * flexion.size,
            "first_slack_angle": _lowest_angle(slack, elbow_angle),
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


def _line(floor: Array, gain: Array, taking: Array) -> Array:
    """A straight line in what the springs take: a tension, or what tensions make."""
    values = gain * taking
    values += floor
    return np.asarray(values)


def _tensions(x: Array, y: Array, flexor: Transmission, extensor: Transmission) -> Extremes:
    """Extremes of all tensions. Along a sheath tension only scales, so the distal extremes of a direction suffice."""
    capstan_x, capstan_y = flexor.capstan[:, 0], extensor.capstan[:, 0]
    low_x, high_x = np.fmin.reduce(x, axis=1), np.fmax.reduce(x, axis=1)
    low_y, high_y = np.fmin.reduce(y, axis=1), np.fmax.reduce(y, axis=1)
    highest = np.maximum(np.maximum(high_x, high_x / capstan_x), np.maximum(high_y, high_y / capstan_y))
    extension = np.maximum(high_x * _without_angles(flexor.spring), high_y * _without_angles(extensor.spring))
    return {
        "min_flexor_tension": np.fmin.reduce(np.minimum(low_x, low_x / capstan_x), axis=0),
        "min_extensor_tension": np.fmin.reduce(np.minimum(low_y, low_y / capstan_y), axis=0),
        "max_tension": np.fmax.reduce(highest, axis=0),
        "max_spring_extension": np.fmax.reduce(extension, axis=0),
    }


def _motor_torques(
    design: Design, response: Response, flexor: Transmission, extensor: Transmission, taking: Array
) -> Extremes:
    """τ_m = (x_prox - η y_prox) R_f (Eq. 17) is a line in what the springs take, too."""
    flexor_arm = design.flexor_radius / flexor.capstan
    extensor_arm = design.ratio * design.flexor_radius / extensor.capstan
    floor = response.flexor_floor * flexor_arm - response.extensor_floor * extensor_arm
    gain = response.flexor_gain * flexor_arm - response.extensor_gain * extensor_arm
    torque = _line(floor, gain, taking)
    return {
        "lowest_motor_torque": np.fmin.reduce(torque, axis=_STATES),
        "highest_motor_torque": np.fmax.reduce(torque, axis=_STATES),
    }


def _stiffness(
    design: Design, tied: Coupling, response: Response, x: Array, slack: Flags, arm_slope: Array, torque_slope: Array
) -> Array:
    """Elbow stiffness as `statics.elbow_stiffness` has it. What a slack state loses by it is known beforehand."""
    flexor = np.square(tied.moment_arm) / tied.flexor_compliance
    extensor = np.square(tied.elbow_radius) / tied.extensor_compliance
    on_flexor, on_extensor = np.isfinite(response.flexor_limit), np.isfinite(response.extensor_limit)
    lost = np.where(design.unilateral, flexor * on_flexor + extensor * on_extensor, 0.0)
    stiffness = x * -arm_slope
    stiffness += flexor + extensor + torque_slope
    stiffness -= lost * slack
    return np.asarray(stiffness)


def _slack_lengths(design: Design, tied: Coupling, response: Response, pretension: Real) -> Extremes:
    """The longest slack of either tendon.

    Below its shortfall a state has η c_f + c_e metres of loose path per newton, which differs between directions only,
    so the state with the largest shortfall on a side has the longest slack. Where both tendons are slack, only their
    sum is determined, and such a state tells no length.
    """
    on_flexor, on_extensor = np.isfinite(response.flexor_limit), np.isfinite(response.extensor_limit)
    alone = on_flexor != on_extensor
    loose = []
    for side, share in ((on_flexor & alone, 1.0 / np.asarray(design.ratio)), (on_extensor & alone, np.asarray(1.0))):
        shortfall = np.fmax.reduce(np.where(side, response.shortfall, -np.inf), axis=1, keepdims=True)
        limit = np.where(side, np.fmax(response.flexor_limit, response.extensor_limit), -np.inf)
        is_slack = pretension < np.fmax.reduce(limit, axis=1, keepdims=True)
        length = np.where(is_slack, tied.common_compliance * share * (shortfall - pretension), 0.0)
        loose.append(np.fmax.reduce(length, axis=_STATES))
    limit = np.where(alone, -np.inf, response.extensor_limit)
    told = np.any(alone | (pretension >= limit), axis=_STATES) & _only_designs(np.asarray(design.unilateral))
    return {"max_slack": np.where(told, np.maximum(*loose), np.nan)}


def _pretensions(design: Design, response: Response, pretension: Real) -> Extremes:
    """What pretension is required, and how much is in hand: both could be lowered together by that much."""
    shortfall = np.fmax.reduce(response.shortfall, axis=1)
    in_hand = np.fmin.reduce(_without_angles(np.asarray(pretension)) - shortfall, axis=0)
    smaller = _only_designs(np.minimum(design.flexor.pretension, design.extensor.pretension))
    return {"required_pretension": np.fmax.reduce(shortfall, axis=0), "margin": np.minimum(in_hand, smaller)}


def _lowest_angle(flags: Flags, elbow_angle: Array) -> Array:
    """The smallest elbow angle at which any direction has its flag set; not a number where none has."""
    either = np.logical_or.reduce(flags, axis=0)
    lowest = np.fmin.reduce(np.where(either, elbow_angle[0], np.inf), axis=0)
    return np.where(np.isinf(lowest), np.nan, lowest)


def _count(flags: Flags) -> Array:
    return np.asarray(np.add.reduce(flags, axis=_STATES, dtype=np.int32), dtype=np.float64)


def _larger(lowest: Array, highest: Array) -> Array:
    """Of two values the one of larger magnitude, with its sign."""
    return np.where(-lowest > highest, lowest, highest)


def _without_angles(values: Array) -> Array:
    """An array that does not depend on the elbow angle, without that axis."""
    return values if values.ndim == 0 else values[:, 0]


def _only_designs(values: Array) -> Array:
    """An array that depends on no state, without the states' axes."""
    return values if values.ndim == 0 else values[0, 0]
