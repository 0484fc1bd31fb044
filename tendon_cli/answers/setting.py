"""What to set on the bench for a pretension: both tensions in the posture in which it is set, and length for force.

The pretension F0 is a tension of the model that no gauge reads: where the suit is set, the arm's weight and the moment
arms make other tensions of it. The posture is the straight arm that hangs down, the hand empty, after extension.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_cli.answers.problem import Problem
from tendon_cli.model.actuator import evaluate
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array
from tendon_cli.space.axis import DRAW_AXIS, PERSON_AXIS, PRETENSION, Numbers

COLUMNS = (
    "set_flexor_tension", "set_extensor_tension", "set_flexor_tension_motor", "set_extensor_tension_motor",
    "tolerance_length",
)  # fmt: skip
"""Columns of choices.parquet."""

ANGLE = 0.0
"""Elbow angle at which the pretension is set, rad."""
POSTURE = {"load.mass": 0.0, "arm.upper_arm_angle": 0.0}
"""What the numbers of a study are while it is set: the empty hand, the upper arm hanging, SI."""


@dataclass(frozen=True, eq=False)
class Settings:
    """What to set for each choice, (choices,)."""

    flexor: Array
    """Tension at the joint, N."""
    extensor: Array
    flexor_motor: Array
    """Tension at the motor, N."""
    extensor_motor: Array
    per_length: Array
    """Pretension that a length taken from both tendons adds, N/m."""


def settings(problem: Problem, numbers: Numbers, pretension: Array) -> Settings:
    """What to set for choices at their pretensions, (choices,), on the study's arm.

    That has no person's body and no draw's numbers, and the first of every other condition.
    """
    others = (axis for axis in problem.conditions.axes if axis.key not in (PERSON_AXIS, DRAW_AXIS))
    under = {key: values[:1] for axis in others for key, values in axis.numbers.items()}
    under |= {key: np.array([value]) for key, value in POSTURE.items()}
    return settings_of(problem.points({**numbers, PRETENSION: pretension}, under).design(), len(pretension))


def settings_of(design: Design, count: int) -> Settings:
    """The same of `count` designs that are in the posture in which they are set."""
    state = evaluate(design, np.array([[ANGLE]]), np.array([[False]]))
    tied = state.coupling
    per_length = (1.0 + np.asarray(design.ratio)) / tied.common_compliance
    values = (
        state.balance.flexor, state.balance.extensor, state.flexor_tension_proximal, state.extensor_tension_proximal,
        per_length,
    )  # fmt: skip
    return Settings(*(np.broadcast_to(np.asarray(each).reshape(-1), (count,)).copy() for each in values))


def setting_columns(problem: Problem, numbers: Numbers, low: Array, high: Array, pretension: Array) -> dict[str, Array]:
    """The columns of what to set; null for a choice without a pretension, or whose window is empty or has no end."""
    values = settings(problem, numbers, pretension)
    with np.errstate(invalid="ignore"):
        length = np.where((low <= high) & np.isfinite(high), 0.5 * (high - low) / values.per_length, np.nan)
    return dict(
        zip(COLUMNS, (values.flexor, values.extensor, values.flexor_motor, values.extensor_motor, length), strict=True)
    )
