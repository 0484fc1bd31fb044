"""What the motor of each design does over both strokes: the columns of designs that a speed of the elbow adds."""

from __future__ import annotations

import numpy as np

from tendon_cli.model.kinematics import Array
from tendon_cli.quantities import OF_CYCLES
from tendon_cli.sweep.inputs import Inputs
from tendon_cli.sweep.plan import Block

_LIMITS = ("max_spool_travel", "max_motor_work_in", "max_friction_loss", "min_efficiency")
"""Limits that do not have the name of their column."""
_STATES = 2**18
"""States that are worked out at once; between two elbow angles there are some more."""


def cycle_columns(inputs: Inputs, block: Block) -> dict[str, Array]:
    """The columns for the designs of a block, in its shape, also by the names of their limits; none without a speed."""
    speed = inputs.plan.study.motion.speed
    if speed is None:
        return {}
    from tendon_cli.model.cycle import cycle  # only a study of motion pays for its import

    shape = block.shape[:-2]
    long = max(range(len(shape)), key=lambda axis: shape[axis], default=None)
    if long is not None and shape[long] > 1 and block.design_count * inputs.plan.states_per_design > _STATES:
        halves = [cycle_columns(inputs, half) for half in block.halves(long)]
        return {name: np.concatenate([half[name] for half in halves], axis=long) for name in halves[0]}
    found = cycle(inputs.design(block), *inputs.motion(block), speed.single)
    columns = {name: np.broadcast_to(getattr(found, name), shape) for name in OF_CYCLES}
    return columns | {limit: columns[limit.partition("_")[2]] for limit in _LIMITS}
