"""The suit on the bench and on the arm: tensions to set, and the drift beyond the window.

No gauge reads the pretension F0 of the model: in the posture in which the suit is set, the arm's
weight and the moment arms turn it into other tensions (`model/setting.py`).
"""

from __future__ import annotations

import numpy as np

from tendon_cli.answers.text_bench import SET_AT_JOINT, SET_AT_MOTOR
from tendon_cli.engine.windows.question import Question
from tendon_cli.engine.windows.solutions import Solutions
from tendon_cli.engine.windows.study_arm import of_designs, study_arm, tension_per_length
from tendon_cli.engine.windows.verification import Verified
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMIT_NAMES
from tendon_cli.model.reversal import drift
from tendon_cli.model.setting import all_readings, pretension_per_length
from tendon_cli.quantities import SIDES
from tendon_cli.studies.spaces import wearer_axis
from tendon_cli.tables.schema import finite_or_none
from tendon_cli.verbs.answer_record import DriftRecord, SettingRecord

SETTING_COLUMNS = (*SET_AT_JOINT, *SET_AT_MOTOR)
"""Columns of the tensions to set, at the joint and at the motor, N."""

_BEYOND = 1.1
"""Factor on the upper end of a window at which the drift is worked out."""


# --- What to set ----------------------------------------------------------------------------------


def settings(design: Design, pretension: Array, count: int) -> dict[str, Array]:
    """Return the tensions to set for `count` designs: the columns `SETTING_COLUMNS`, N.

    Args:
        design: Designs at their pretensions.
        pretension: These pretensions as they are read; NaN for a design that has none, which has
            no tensions to set, either. A design cannot tell, since its number is silent where NaN.
        count: Number of designs.
    """
    readings = all_readings(design, design.flexor.pretension)
    values = [readings[f"{side} at {end}"] for end in ("joint", "motor") for side in SIDES]
    columns = zip(SETTING_COLUMNS, values, strict=True)
    has_none = np.isnan(pretension)
    return {name: np.where(has_none, np.nan, of_designs(value, count)) for name, value in columns}


# --- The record -----------------------------------------------------------------------------------


def setting_record(
    question: Question, choice: Solutions, judged: Verified | None = None
) -> SettingRecord:
    """Return the posture in which a choice is set, and the pretension that shorter tendons add.

    Args:
        question: The question.
        choice: The choice.
        judged: Judgement of a fresh sample, whose window then says how far the setting may be off.
    """
    design = study_arm(question, choice.points.at_pretension(choice.pretension))
    posture = question.study.setting
    per_length = float(tension_per_length(question, choice.points)[0])
    reserve = float(choice.reserve[0])
    pretension = float(choice.pretension[0])
    low = float(choice.pretension_from[0])
    high = float(choice.pretension_to[0])
    if judged is not None:
        low = judged.low
        high = judged.high
    too_long = (pretension - max(low, 0.0)) / per_length
    too_short = (high - pretension) / per_length
    is_within = too_long >= 0.0 and too_short >= 0.0
    return SettingRecord(
        angle=float(posture.angle.array[0]),
        upper_arm_angle=float(posture.upper_arm_angle.array[0]),
        load=float(posture.load.array[0]),
        after=posture.after,
        read=posture.read,
        on_wearer=wearer_axis(question.study) is not None,
        newtons_per_metre=float(of_designs(pretension_per_length(design), 1)[0]),
        read_per_metre=per_length,
        accuracy=reserve / per_length,
        reserve=reserve,
        too_long=too_long if is_within else None,
        too_short=finite_or_none(too_short) if is_within else None,
    )


def drift_record(question: Question, choice: Solutions) -> DriftRecord | None:
    """Return the drift of a choice 10 % beyond its window, under the condition that binds.

    Return None if the upper end is not set by stability, or if the motion has a single angle.
    """
    high = float(choice.pretension_to[0])
    state = int(choice.to_binding.state[0])
    is_stability = state >= 0 and LIMIT_NAMES[choice.to_binding.by[0]] == "min_elbow_stiffness"
    if not (is_stability and np.isfinite(high)):
        return None
    alone = question.for_conditions(choice.to_binding.condition[:1])
    bounds = alone.bounds.of(alone.designs(choice.points))
    if np.any(bounds["min_elbow_stiffness"]):
        return None
    pretension = _BEYOND * high
    design = alone.designs(choice.points.at_pretension(np.array([pretension])))
    start = float(question.angles[0, state % question.angles.size])
    ends = (float(question.angles.min()), float(question.angles.max()))
    drifts = [drift(design, start, end) for end in ends if end != start]
    if not drifts:
        return None
    farthest = max(drifts, key=lambda drifted: abs(drifted.end - drifted.start))
    return DriftRecord(pretension=pretension, **vars(farthest))
