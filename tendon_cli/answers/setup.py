"""The suit on the bench and on the arm: tensions to set, and reasons not to build or wear it.

No gauge reads the pretension F0 of the model: in the posture in which the suit is set, the arm's
weight and the moment arms turn it into other tensions (`model/setting.py`). Quantities that the
study does not limit are compared with published values.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tendon_cli.answer_record import DriftRecord, RemarkRecord, SettingRecord
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.solve import Solutions, severest_conditions, worst
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
from tendon_cli.space.axis import DRAW_AXIS, PERSON_AXIS, PRETENSION, SIDES, Axis, Numbers

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


def study_arm(
    problem: Problem, numbers: Numbers, pretension: Array, whom: Axis | None = None
) -> Design:
    """Return choices on the study's own arm, or on the bodies of all persons.

    The numbers of a draw are left out, and every other condition has its first value.

    Args:
        problem: The question.
        numbers: Numbers of the choices.
        pretension: Pretensions of the choices, (choices,), N.
        whom: Axis of the persons or draws; None for the study's own arm.
    """
    count = 1 if whom is None else len(whom)
    under: dict[str, Array] = {}
    for axis in problem.conditions.axes:
        if axis.key not in (PERSON_AXIS, DRAW_AXIS):
            for key, values in axis.numbers.items():
                under[key] = np.repeat(values[:1], count)
    if whom is not None:
        under |= whom.numbers
    return problem.choices.at({**numbers, PRETENSION: pretension}, under).design()


def settings(design: Design, count: int) -> dict[str, Array]:
    """Return the tensions to set for `count` designs: the columns `SETTING_COLUMNS`, N."""
    readings = all_readings(design, design.flexor.pretension)
    values = [readings[f"{side} at {end}"] for end in ("joint", "motor") for side in SIDES]
    columns = zip(SETTING_COLUMNS, values, strict=True)
    return {name: _of_designs(value, count) for name, value in columns}


def _of_designs(values: Array, count: int) -> Array:
    """Return values that broadcast to `count` designs as one for each, (count,)."""
    return np.broadcast_to(np.asarray(values).reshape(-1), (count,)).copy()


def setting_columns(
    problem: Problem, numbers: Numbers, low: Array, high: Array, pretension: Array
) -> dict[str, Array]:
    """Return the tensions to set for choices, N, and half the window as a length of both tendons.

    Args:
        problem: The question.
        numbers: Numbers of the choices.
        low: Lower ends of their windows, (choices,), N.
        high: Upper ends.
        pretension: Pretensions of the choices, (choices,), N.

    Returns:
        The columns `SETTING_COLUMNS` and `tolerance_length`, m, NaN for an empty or endless window.
    """
    count = len(low)
    design = study_arm(problem, numbers, pretension)
    with np.errstate(invalid="ignore"):
        at_low = study_arm(problem, numbers, low).flexor.pretension
        at_high = study_arm(problem, numbers, high).flexor.pretension
        width = _of_designs(np.asarray(at_high), count) - _of_designs(np.asarray(at_low), count)
        length = 0.5 * width / _of_designs(pretension_per_length(design), count)
    is_closed = (low <= high) & np.isfinite(high)
    return {**settings(design, count), "tolerance_length": np.where(is_closed, length, np.nan)}


# --- The record -----------------------------------------------------------------------------------


def setting_record(problem: Problem, choice: Solutions) -> SettingRecord:
    """Return the posture in which a choice is set, and the pretension that shorter tendons add."""
    design = study_arm(problem, problem.numbers_of(choice.columns), choice["pretension"])
    posture = problem.study.setting
    return {
        "angle": float(posture.angle.array[0]),
        "upper_arm_angle": float(posture.upper_arm_angle.array[0]),
        "load": float(posture.load.array[0]),
        "after": posture.after,
        "read": posture.read,
        "newtons_per_metre": float(_of_designs(pretension_per_length(design), 1)[0]),
    }


def drift_record(problem: Problem, choice: Solutions) -> DriftRecord | None:
    """Return the drift of a choice beyond its window; None if stability does not end it."""
    beyond = drift_of(problem, choice)
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


def remarks(problem: Problem, choice: Solutions) -> Iterator[RemarkRecord]:
    """Yield remarks, with their sources, on a suit at its pretension.

    They name loads that no limit of the study forbids, but nobody would want.
    """
    pretension = choice["pretension"]
    if np.isnan(pretension[0]) or not choice["served_at"][0] > 0.0:
        return
    numbers = problem.numbers_of(choice.columns)
    count = len(problem.conditions)
    everyone = np.ones((1, count), dtype=np.bool_)
    if "max_contact_pressure" not in problem.bounds:
        pressure = choice.scalar("max_contact_pressure")
        width = None
        if np.isnan(pressure):
            strapped = problem.saying({"arm.contact_width": np.full(count, _STRAP_WIDTH)})
            of_strap = worst(strapped, numbers, pretension, everyone)["max_contact_pressure"]
            pressure = float(of_strap[0])
            width = _STRAP_WIDTH
        if pressure > _PAIN:
            yield strap_remark(pressure, _PAIN, pains=True, width=width)
        elif pressure > _DISCOMFORT:
            yield strap_remark(pressure, _DISCOMFORT, pains=False, width=width)
    if "max_tension" not in problem.bounds:
        design = problem.design(numbers)
        diameter = float(min(np.min(design.flexor.diameter), np.min(design.extensor.diameter)))
        breaking = _ROPE_STRENGTH * (diameter / _ROPE_DIAMETER) ** 2
        tension = choice.scalar("max_tension")
        if tension > breaking / _ROPE_SAFETY:
            yield rope_remark(diameter, breaking, tension, _ROPE_SAFETY)
    if not {"max_spring_extension", "min_spring_room"} & set(problem.bounds):
        few = problem.under(severest_conditions(problem, numbers, pretension, everyone, 1))
        yield from _remarks_on_spring(few, few.design(numbers, pretension=pretension))


def _remarks_on_spring(problem: Problem, design: Design) -> Iterator[RemarkRecord]:
    """Yield a remark if the flexor's stretched spring hardly fits between its anchors."""
    state = evaluate(design, problem.angles, problem.flexion)
    extension: Array = np.asarray(state.balance.flexor / design.flexor.spring_stiffness)
    path = state.motion.flexor_path
    if path is None:
        return
    room = np.broadcast_to(path, extension.shape) - extension
    if not np.isfinite(room).any():
        return
    tightest = np.unravel_index(int(np.nanargmin(room)), room.shape)
    stiffness = np.min(design.flexor.spring_stiffness)
    if room[tightest] < np.interp(stiffness, _SPRING_STIFFNESSES, _SPRING_LENGTHS):
        yield spring_remark(float(extension[tightest]), float(room[tightest]))


def drift_of(problem: Problem, choice: Solutions) -> tuple[float, Drift] | None:
    """Return the pretension 10 % beyond the upper end, N, and the arm's drift there.

    The drift is under the condition that binds. Return None if the upper end is not set by
    stability.
    """
    high = choice.scalar("pretension_to")
    state = int(choice["to_state"][0])
    is_stability = state >= 0 and LIMIT_NAMES[choice["to_by"][0]] == "min_elbow_stiffness"
    if not (is_stability and np.isfinite(high) and problem.bounds["min_elbow_stiffness"] == 0.0):
        return None
    alone = problem.under(choice["to_condition"][:1])
    pretension = _BEYOND * high
    design = alone.design(problem.numbers_of(choice.columns), pretension=np.array([pretension]))
    start = float(problem.angles[0, state % problem.angles.size])
    ends = (float(problem.angles.min()), float(problem.angles.max()))
    drifts = [drift(design, start, end) for end in ends if end != start]
    return pretension, max(drifts, key=lambda drifted: abs(drifted.end - drifted.start))
