"""What to set on the bench for a pretension: both tensions in the posture in which it is set, and length for force.

The pretension F0 is a tension of the model that no gauge reads: where the suit is set, the arm's weight and the moment
arms make other tensions of it (`model/setting.py`), by default of the straight arm that hangs down, the hand empty.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_cli.answers.problem import Problem
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array
from tendon_cli.model.setting import all_readings, per_length
from tendon_cli.space.axis import DRAW_AXIS, PERSON_AXIS, PRETENSION, SIDES, Numbers

COLUMNS = (
    "set_flexor_tension", "set_extensor_tension", "set_flexor_tension_motor", "set_extensor_tension_motor",
    "tolerance_length",
)  # fmt: skip
"""Columns of choices.parquet."""


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
    return settings_of(_on_the_study_arm(problem, numbers, pretension), len(pretension))


def _on_the_study_arm(problem: Problem, numbers: Numbers, pretension: Array) -> Design:
    others = (axis for axis in problem.conditions.axes if axis.key not in (PERSON_AXIS, DRAW_AXIS))
    under = {key: values[:1] for axis in others for key, values in axis.numbers.items()}
    return problem.points({**numbers, PRETENSION: pretension}, under).design()


def _model_pretension(problem: Problem, numbers: Numbers, read: Array) -> Array:
    """The F0 of pretensions as the study reads them, (choices,)."""
    found = _on_the_study_arm(problem, numbers, read).flexor.pretension
    return np.broadcast_to(np.asarray(found).reshape(-1), read.shape)


def settings_of(design: Design, count: int) -> Settings:
    """The same of `count` designs."""
    shown = all_readings(design, design.flexor.pretension)
    values = (*(shown[f"{side} at {end}"] for end in ("joint", "motor") for side in SIDES), per_length(design))
    return Settings(*(np.broadcast_to(np.asarray(each).reshape(-1), (count,)).copy() for each in values))


def setting_columns(problem: Problem, numbers: Numbers, low: Array, high: Array, pretension: Array) -> dict[str, Array]:
    """The columns of what to set; null for a choice without a pretension, or whose window is empty or has no end."""
    values = settings(problem, numbers, pretension)
    with np.errstate(invalid="ignore"):
        width = _model_pretension(problem, numbers, high) - _model_pretension(problem, numbers, low)
        length = np.where((low <= high) & np.isfinite(high), 0.5 * width / values.per_length, np.nan)
    return dict(
        zip(COLUMNS, (values.flexor, values.extensor, values.flexor_motor, values.extensor_motor, length), strict=True)
    )
