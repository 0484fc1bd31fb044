"""A block of the product through the model: the only translator between the model's arguments and table columns.

A column is an array that broadcasts to the block's shape; NaN in it stands for null, and only where `State` says so.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.model import actuator
from tendon_cli.model.actuator import Design, State
from tendon_cli.sweep.inputs import Inputs
from tendon_cli.sweep.plan import Block

Columns = dict[str, npt.NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class Evaluated:
    """A block's states, and the designs they belong to."""

    state: State
    design: Design


def evaluate(inputs: Inputs, block: Block) -> Evaluated:
    """Solve all states of a block."""
    design = inputs.design(block)
    angles, flexion = inputs.motion(block)
    return Evaluated(actuator.evaluate(design, angles, flexion), design)


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
