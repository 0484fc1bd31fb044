"""A block of the product through the model: the only translator between the model's arguments and table columns.

A column is an array that broadcasts to the block's shape; NaN in it stands for null, and only where `State` says so.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.model import actuator, statics
from tendon_cli.model.actuator import Design, State
from tendon_cli.model.kinematics import Array, Real
from tendon_cli.sweep.inputs import Inputs
from tendon_cli.sweep.plan import Block

Columns = dict[str, npt.NDArray[np.float64]]

_LOWEST = ("min_flexor_tension", "min_extensor_tension", "min_elbow_stiffness", "first_slack_angle", "margin",
           "lowest_elbow_torque", "lowest_motor_torque")  # fmt: skip
_HIGHEST = ("max_tension", "max_spring_extension", "max_slack", "required_pretension",
            "highest_elbow_torque", "highest_motor_torque")  # fmt: skip
_COUNTS = ("slack", "no_equilibrium", "unstable")


@dataclass(frozen=True)
class Evaluated:
    """A block's states, and what each of its designs comes to over these states."""

    state: State
    design: Design
    angles: Real
    flexion: npt.NDArray[np.bool_]


def evaluate(inputs: Inputs, block: Block) -> Evaluated:
    """Solve all states of a block."""
    design = inputs.design(block)
    angles, flexion = inputs.motion(block)
    return Evaluated(actuator.evaluate(design, angles, flexion), design, angles, flexion)


def state_columns(evaluated: Evaluated) -> Columns:
    """The result columns of `states`, but `status`."""
    state, balance, design = evaluated.state, evaluated.state.balance, evaluated.design
    flexor_change = balance.flexor - design.flexor.pretension
    extensor_change = balance.extensor - design.extensor.pretension
    return {
        "flexor_tension_proximal": state.flexor_tension_proximal,
        "flexor_tension_distal": balance.flexor,
        "extensor_tension_proximal": state.extensor_tension_proximal,
        "extensor_tension_distal": balance.extensor,
        "flexor_tendon_stretch": state.flexor.tendon * flexor_change,
        "extensor_tendon_stretch": state.extensor.tendon * extensor_change,
        "flexor_spring_stretch": state.flexor.spring * flexor_change,
        "extensor_spring_stretch": state.extensor.spring * extensor_change,
        "flexor_slack": state.flexor_slack,
        "extensor_slack": state.extensor_slack,
        "elbow_torque": state.elbow_torque,
        "motor_torque": state.motor_torque,
        "spool_angle": state.spool_angle,
        "elbow_stiffness": state.elbow_stiffness,
        "flexor_moment_arm": state.motion.flexor_moment_arm,
        "flexor_travel": state.motion.flexor_travel,
        "extensor_travel": state.motion.extensor_travel,
    }


def extremes(evaluated: Evaluated) -> Columns:
    """Smallest, largest and counted over the states of a block, per design; `design_columns` finishes them."""
    state, balance = evaluated.state, evaluated.state.balance
    flexor, extensor = evaluated.design.flexor, evaluated.design.extensor
    shortfall = statics.pretension_shortfall(state.coupling)
    in_hand = statics.pretension_in_hand(state.coupling, flexor.pretension, extensor.pretension, shortfall)
    is_slack = (state.status > statics.TAUT) & (state.status < statics.NO_EQUILIBRIUM)
    tensions = (balance.flexor, state.flexor_tension_proximal, balance.extensor, state.extensor_tension_proximal)
    return {
        "min_flexor_tension": np.minimum(_lowest(tensions[0]), _lowest(tensions[1])),
        "min_extensor_tension": np.minimum(_lowest(tensions[2]), _lowest(tensions[3])),
        "max_tension": np.maximum.reduce(np.broadcast_arrays(*map(_highest, tensions))),
        "max_spring_extension": np.maximum(
            _highest(balance.flexor * state.flexor.spring), _highest(balance.extensor * state.extensor.spring)
        ),
        "lowest_elbow_torque": _lowest(state.elbow_torque),
        "highest_elbow_torque": _highest(state.elbow_torque),
        "lowest_motor_torque": _lowest(state.motor_torque),
        "highest_motor_torque": _highest(state.motor_torque),
        "min_elbow_stiffness": _lowest(state.elbow_stiffness),
        "max_slack": np.fmax(_highest(state.flexor_slack), _highest(state.extensor_slack)),
        "first_slack_angle": _lowest(np.where(is_slack, evaluated.angles, np.nan)),
        "required_pretension": _highest(shortfall),
        "margin": _lowest(in_hand),
        "slack": _count(is_slack),
        "no_equilibrium": _count(state.status == statics.NO_EQUILIBRIUM),
        "unstable": _count(state.elbow_stiffness < 0.0),
    }


def merge(first: Columns, second: Columns) -> Columns:
    """The extremes of the same designs over two sets of states."""
    merged = {name: np.fmin(first[name], second[name]) for name in _LOWEST}
    merged |= {name: np.fmax(first[name], second[name]) for name in _HIGHEST}
    return merged | {name: first[name] + second[name] for name in _COUNTS}


def design_columns(found: Columns, states: int, pretension: Real | None) -> Columns:
    """The result columns of `designs`, from the extremes over all `states` of each design.

    `pretension` is None where the two sides differ in it; the margin is then the amount by which both could be lowered.
    """
    unanswerable = found["no_equilibrium"] > 0
    required = np.where(unanswerable, np.nan, np.maximum(0.0, found["required_pretension"]))
    margin = found["margin"] if pretension is None else pretension - required
    return {
        "min_flexor_tension": found["min_flexor_tension"],
        "min_extensor_tension": found["min_extensor_tension"],
        "max_tension": found["max_tension"],
        "max_spring_extension": found["max_spring_extension"],
        "peak_elbow_torque": _larger(found["lowest_elbow_torque"], found["highest_elbow_torque"]),
        "peak_motor_torque": _larger(found["lowest_motor_torque"], found["highest_motor_torque"]),
        "min_elbow_stiffness": found["min_elbow_stiffness"],
        "max_slack": found["max_slack"],
        "slack_fraction": (found["slack"] + found["no_equilibrium"]) / states,
        "unstable_fraction": found["unstable"] / states,
        "first_slack_angle": found["first_slack_angle"],
        "required_pretension": required,
        "margin": np.where(unanswerable, np.nan, margin),
        "feasible": (found["slack"] + found["no_equilibrium"]) == 0,
    }


def _lowest(values: npt.ArrayLike) -> Array:
    return np.asarray(np.fmin.reduce(np.asarray(values, dtype=np.float64), axis=(-2, -1), keepdims=True))


def _highest(values: npt.ArrayLike) -> Array:
    return np.asarray(np.fmax.reduce(np.asarray(values, dtype=np.float64), axis=(-2, -1), keepdims=True))


def _count(flags: npt.NDArray[np.bool_]) -> Array:
    return np.asarray(np.count_nonzero(flags, axis=(-2, -1), keepdims=True), dtype=np.float64)


def _larger(lowest: Array, highest: Array) -> Array:
    """Of two values the one of larger magnitude, with its sign."""
    return np.where(-lowest > highest, lowest, highest)
