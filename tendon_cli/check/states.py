"""In which state a design breaks a limit worst: its states are worked out once more, by the model."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tendon_cli.model.actuator import State
from tendon_cli.model.kinematics import Array
from tendon_cli.model.response import pretension_shortfall
from tendon_cli.sweep.inputs import Inputs
from tendon_cli.sweep.plan import Plan


def _spring_extension(state: State) -> Array:
    return np.maximum(state.balance.flexor * state.flexor.spring, state.balance.extensor * state.extensor.spring)


BADNESS: dict[str, Callable[[State], Array]] = {
    "no equilibrium": lambda state: np.where(np.isnan(state.elbow_torque), 1.0, 0.0),
    "slack": lambda state: pretension_shortfall(state.coupling),
    "min_flexor_tension": lambda state: -np.minimum(state.balance.flexor, state.flexor_tension_proximal),
    "min_extensor_tension": lambda state: -np.minimum(state.balance.extensor, state.extensor_tension_proximal),
    "max_tension": lambda state: np.maximum.reduce(
        [
            state.balance.flexor,
            state.flexor_tension_proximal,
            state.balance.extensor,
            state.extensor_tension_proximal,
        ]
    ),
    "max_spring_extension": _spring_extension,
    "peak_motor_torque": lambda state: np.abs(state.motor_torque),
    "max_contact_pressure": lambda state: state.balance.extensor,
    "min_elbow_stiffness": lambda state: -state.elbow_stiffness,
}
"""What is largest in the state that breaks a limit worst; limits of a whole motion, or of no state, are not here."""


def worst_state(limit: str, design: int, plan: Plan) -> tuple[str, float] | None:
    """Direction and elbow angle (rad) of the state that breaks a limit worst; None where no single state does."""
    badness = BADNESS.get(limit)
    if badness is None:
        return None
    inputs = Inputs(plan)
    worst, found = -np.inf, None
    for block in plan.blocks(range(design, design + 1)):
        directions, angles = plan.directions[block.directions], plan.elbow_angles[block.angles]
        values = np.broadcast_to(badness(State.of(inputs.situation(block))), block.shape).reshape(len(directions), -1)
        if np.isnan(values).all() or np.nanmax(values) <= worst:
            continue
        worst = float(np.nanmax(values))
        direction, angle = np.unravel_index(int(np.nanargmax(values)), values.shape)
        found = directions[direction], float(angles[angle])
    return found
