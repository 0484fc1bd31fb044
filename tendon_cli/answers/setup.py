"""The suit on the bench and on the arm: tensions to set, and reasons not to build or wear it.

No gauge reads the pretension F0 of the model: in the posture in which the suit is set, the arm's
weight and the moment arms turn it into other tensions (`model/setting.py`). Quantities that the
study does not limit are compared with published values.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tendon_cli.answer_record import DriftRecord, RemarkRecord, SettingRecord
from tendon_cli.answers.text_bench import (
    SET_AT_JOINT,
    SET_AT_MOTOR,
    rope_remark,
    spring_remark,
    strap_remark,
)
from tendon_cli.model.actuator import evaluate
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMIT_NAMES
from tendon_cli.model.reversal import Drift, drift
from tendon_cli.model.setting import all_readings, pretension_per_length
from tendon_cli.quantities import SIDES
from tendon_cli.studies.spaces import wearer_axis
from tendon_cli.tables.schema import finite_or_none
from tendon_cli.windows.question import Question
from tendon_cli.windows.solutions import Solutions
from tendon_cli.windows.solver import Solver
from tendon_cli.windows.study_arm import of_designs, study_arm, tension_per_length

SETTING_COLUMNS = (*SET_AT_JOINT, *SET_AT_MOTOR)
"""Columns of the tensions to set, at the joint and at the motor, N."""

_STRAP_WIDTH = 0.04
"""Width of a strap if the study gives none, m."""
_DISCOMFORT = 30.4e3
"""Pressure under a cuff at the knee that is uncomfortable for a while, Pa."""
_PAIN = 52.9e3
"""Pressure under a cuff at the knee that hurts, Pa."""
_ROPE_DIAMETER = 1.5875e-3
"""Diameter of a stainless rope of 1/16 inch, 7x7, m."""
_ROPE_STRENGTH = 2.1e3
"""Tension at which this rope breaks, N."""
_ROPE_SAFETY = 10.0
"""Customary ratio of the breaking tension to the largest tension."""
_SPRING_STIFFNESSES = (3e3, 5e3)
"""Stiffness of springs that are made for 300 N, N/m."""
_SPRING_LENGTHS = (0.084, 0.073)
"""Unloaded length of these springs, m."""
_BEYOND = 1.1
"""Factor on the upper end of a window at which the drift is worked out."""


# --- What to set ----------------------------------------------------------------------------------


def settings(design: Design, count: int) -> dict[str, Array]:
    """Return the tensions to set for `count` designs: the columns `SETTING_COLUMNS`, N."""
    readings = all_readings(design, design.flexor.pretension)
    values = [readings[f"{side} at {end}"] for end in ("joint", "motor") for side in SIDES]
    columns = zip(SETTING_COLUMNS, values, strict=True)
    return {name: of_designs(value, count) for name, value in columns}


# --- The record -----------------------------------------------------------------------------------


def setting_record(question: Question, choice: Solutions) -> SettingRecord:
    """Return the posture in which a choice is set, and the pretension that shorter tendons add."""
    design = study_arm(question, choice.points.at_pretension(choice.pretension))
    posture = question.study.setting
    per_length = float(tension_per_length(question, choice.points)[0])
    reserve = float(choice.reserve[0])
    pretension = float(choice.pretension[0])
    too_long = (pretension - float(choice.pretension_from[0])) / per_length
    too_short = (float(choice.pretension_to[0]) - pretension) / per_length
    is_within = too_long >= 0.0 and too_short >= 0.0
    return {
        "angle": float(posture.angle.array[0]),
        "upper_arm_angle": float(posture.upper_arm_angle.array[0]),
        "load": float(posture.load.array[0]),
        "after": posture.after,
        "read": posture.read,
        "on_wearer": wearer_axis(question.study) is not None,
        "newtons_per_metre": float(of_designs(pretension_per_length(design), 1)[0]),
        "read_per_metre": per_length,
        "accuracy": reserve / per_length,
        "reserve": reserve,
        "too_long": too_long if is_within else None,
        "too_short": finite_or_none(too_short) if is_within else None,
    }


def drift_record(question: Question, choice: Solutions) -> DriftRecord | None:
    """Return the drift of a choice beyond its window; None if stability does not end it."""
    beyond = drift_of(question, choice)
    if beyond is None:
        return None
    pretension, drifted = beyond
    return {
        "pretension": pretension,
        "start": drifted.start,
        "end": drifted.end,
        "torque": drifted.torque,
        "balanced": drifted.balanced,
    }


def remarks(solver: Solver, choice: Solutions) -> Iterator[RemarkRecord]:
    """Yield remarks, with their sources, on a suit at its pretension.

    They name loads that no limit of the study forbids, but nobody would want.
    """
    pretension = choice.pretension
    if np.isnan(pretension[0]) or not choice.served_at[0] > 0.0:
        return
    question = solver.question
    points = choice.points
    count = len(question.conditions)
    everyone = np.ones((1, count), dtype=np.bool_)
    if "max_contact_pressure" not in question.bounds:
        pressure = float(choice.worst.max_contact_pressure[0])
        width = None
        if np.isnan(pressure):
            strapped = question.with_numbers({"arm.contact_width": np.full(count, _STRAP_WIDTH)})
            of_strap = solver.for_question(strapped).worst(points, pretension, everyone)
            pressure = float(of_strap.max_contact_pressure[0])
            width = _STRAP_WIDTH
        if pressure > _PAIN:
            yield strap_remark(pressure, _PAIN, pains=True, width=width)
        elif pressure > _DISCOMFORT:
            yield strap_remark(pressure, _DISCOMFORT, pains=False, width=width)
    if "max_tension" not in question.bounds:
        design = question.designs(points)
        diameter = float(min(np.min(design.flexor.diameter), np.min(design.extensor.diameter)))
        breaking = _ROPE_STRENGTH * (diameter / _ROPE_DIAMETER) ** 2
        tension = float(choice.worst.max_tension[0])
        if tension > breaking / _ROPE_SAFETY:
            yield rope_remark(diameter, breaking, tension, _ROPE_SAFETY)
    if not {"max_spring_extension", "min_spring_room"} & set(question.bounds):
        severest = solver.severest_conditions(points, pretension, everyone, 1)
        few = question.for_conditions(severest)
        yield from _remarks_on_spring(few, few.designs(points.at_pretension(pretension)))


def _remarks_on_spring(question: Question, design: Design) -> Iterator[RemarkRecord]:
    """Yield a remark if the flexor's stretched spring hardly fits between its anchors."""
    state = evaluate(design, question.angles, question.flexion)
    extension: Array = np.asarray(state.balance.flexor / design.flexor.spring_stiffness)
    path = state.motion.flexor_path
    if path is None:
        return
    # A spring at the motor lies before the sheath, and not between the anchors.
    room = np.where(design.flexor.spring_at_motor, np.nan, path - extension)
    if not np.isfinite(room).any():
        return
    tightest = np.unravel_index(int(np.nanargmin(room)), room.shape)
    stiffness = np.min(design.flexor.spring_stiffness)
    if room[tightest] < np.interp(stiffness, _SPRING_STIFFNESSES, _SPRING_LENGTHS):
        yield spring_remark(float(extension[tightest]), float(room[tightest]))


def drift_of(question: Question, choice: Solutions) -> tuple[float, Drift] | None:
    """Return the pretension 10 % beyond the upper end, N, and the arm's drift there.

    The drift is under the condition that binds. Return None if the upper end is not set by
    stability, or if the motion has a single angle.
    """
    high = float(choice.pretension_to[0])
    state = int(choice.to_binding.state[0])
    is_stability = state >= 0 and LIMIT_NAMES[choice.to_binding.by[0]] == "min_elbow_stiffness"
    if not (is_stability and np.isfinite(high) and question.bounds["min_elbow_stiffness"] == 0.0):
        return None
    alone = question.for_conditions(choice.to_binding.condition[:1])
    pretension = _BEYOND * high
    design = alone.designs(choice.points.at_pretension(np.array([pretension])))
    start = float(question.angles[0, state % question.angles.size])
    ends = (float(question.angles.min()), float(question.angles.max()))
    drifts = [drift(design, start, end) for end in ends if end != start]
    if not drifts:
        return None
    return pretension, max(drifts, key=lambda drifted: abs(drifted.end - drifted.start))
