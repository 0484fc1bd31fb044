"""The suit on the bench and on the arm: tensions to set, and reasons not to build or wear it.

No gauge reads the pretension F0 of the model: in the posture in which the suit is set, the arm's
weight and the moment arms turn it into other tensions (`model/setting.py`). Quantities that the
study does not limit are compared with published values.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.answers.phrases import Row
from tendon_cli.model.actuator import evaluate
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMIT_NAMES
from tendon_cli.model.reversal import Drift, drift
from tendon_cli.model.setting import all_readings, pretension_per_length
from tendon_cli.space.axis import DRAW_AXIS, PERSON_AXIS, SIDES, Axis
from tendon_cli.windows.points import Points
from tendon_cli.windows.question import Question
from tendon_cli.windows.solutions import Solutions
from tendon_cli.windows.solver import Solver

SETTING_COLUMNS = tuple(f"set_{side}_tension{end}" for end in ("", "_motor") for side in SIDES)
"""Columns of the tensions to set, at the joint and at the motor, N."""

FEW_PERSONS = 20
"""Number of persons below which a range holds all of them, not nine in ten."""
_STRAP_WIDTH = 0.04
"""Width of a strap if the study gives none, m."""
_DISCOMFORT = 30.4e3
"""Pressure under a cuff at the knee that is uncomfortable for a while, Pa."""
_PAIN = 52.9e3
"""Pressure under a cuff at the knee that hurts, Pa."""
_SOURCE_OF_CUFFS = "cuffs at the knee, Ergonomics 63(5):618, 2020; nothing is known of elbows"
_ROPE_DIAMETER = 1.5875e-3
"""Diameter of a stainless rope of 1/16 inch, 7x7, m."""
_ROPE_STRENGTH = 2.1e3
"""Tension at which this rope breaks, N."""
_ROPE_SAFETY = 10.0
"""Customary ratio of the breaking tension to the largest tension."""
_SOURCE_OF_ROPES = "makers' tables for stainless 7x7 rope"
_SPRING_STIFFNESSES = (3e3, 5e3)
"""Stiffness of springs that are made for 300 N, N/m."""
_SPRING_LENGTHS = (0.084, 0.073)
"""Unloaded length of these springs, m."""
_SOURCE_OF_SPRINGS = "extension springs made for 300 N: 73 mm at 5 kN/m, 84 mm at 3 kN/m"
_BEYOND = 1.1
"""Factor on the upper end of a window at which the drift is worked out."""


# --- What to set ----------------------------------------------------------------------------------


def study_arm(question: Question, points: Points, whom: Axis | None = None) -> Design:
    """Return choices on the study's own arm, or on the bodies of all persons.

    The numbers of a draw are left out, and every other condition has its first value.

    Args:
        question: The question.
        points: The choices at their pretensions.
        whom: Axis of the persons or draws; None for the study's own arm.
    """
    count = 1 if whom is None else len(whom)
    under: dict[str, Array] = {}
    for axis in question.conditions.axes:
        if axis.key not in (PERSON_AXIS, DRAW_AXIS):
            for key, values in axis.numbers.items():
                under[key] = np.repeat(values[:1], count)
    if whom is not None:
        under |= whom.numbers
    return question.designs(points, under)


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
    question: Question, points: Points, low: Array, high: Array, pretension: Array
) -> dict[str, Array]:
    """Return the tensions to set for choices, N, and half the window as a length of both tendons.

    Args:
        question: The question.
        points: The choices.
        low: Lower ends of their windows, (choices,), N.
        high: Upper ends.
        pretension: Pretensions of the choices, (choices,), N.

    Returns:
        The columns `SETTING_COLUMNS` and `tolerance_length`, m, NaN for an empty or endless window.
    """
    count = len(low)
    design = study_arm(question, points.at_pretension(pretension))
    with np.errstate(invalid="ignore"):
        at_low = study_arm(question, points.at_pretension(low)).flexor.pretension
        at_high = study_arm(question, points.at_pretension(high)).flexor.pretension
        width = _of_designs(np.asarray(at_high), count) - _of_designs(np.asarray(at_low), count)
        length = 0.5 * width / _of_designs(pretension_per_length(design), count)
    is_closed = (low <= high) & np.isfinite(high)
    return {**settings(design, count), "tolerance_length": np.where(is_closed, length, np.nan)}


# --- The record -----------------------------------------------------------------------------------


def bench_record(solver: Solver, choice: Solutions) -> dict[str, Any]:
    """Return the tensions to set for a choice, the drift beyond its window, and remarks."""
    question = solver.question
    design = study_arm(question, choice.points.at_pretension(choice.pretension))
    beyond = drift_of(question, choice)
    posture = question.study.setting
    angles = {
        name: float(getattr(posture, name).array[0])
        for name in ("angle", "upper_arm_angle", "load")
    }
    return {
        "setting": {
            **angles,
            "after": posture.after,
            "read": posture.read,
            "newtons_per_metre": float(_of_designs(pretension_per_length(design), 1)[0]),
        },
        "drift": None if beyond is None else {"pretension": beyond[0], **asdict(beyond[1])},
        "remarks": [*remarks(solver, choice)],
    }


def remarks(solver: Solver, choice: Solutions) -> Iterator[Row]:
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
        width = ""
        if np.isnan(pressure):
            strapped = question.with_numbers({"arm.contact_width": np.full(count, _STRAP_WIDTH)})
            of_strap = solver.for_question(strapped).worst(points, pretension, everyone)
            pressure = float(of_strap.max_contact_pressure[0])
            width = f" if it is {1e3 * _STRAP_WIDTH:.0f} mm wide"
        yield from _remarks_on_strap(pressure, width)
    if "max_tension" not in question.bounds:
        design = question.designs(points)
        diameter = float(min(np.min(design.flexor.diameter), np.min(design.extensor.diameter)))
        yield from _remarks_on_rope(float(choice.worst.max_tension[0]), diameter)
    if not {"max_spring_extension", "min_spring_room"} & set(question.bounds):
        severest = solver.severest_conditions(points, pretension, everyone, 1)
        few = question.for_conditions(severest)
        yield from _remarks_on_spring(few, few.designs(points.at_pretension(pretension)))


def _remarks_on_strap(pressure: float, width: str) -> Iterator[Row]:
    """Yield a remark if the strap's pressure, Pa, is uncomfortable or hurts."""
    begins = "pain begins" if pressure > _PAIN else "discomfort begins"
    limit = _PAIN if pressure > _PAIN else _DISCOMFORT
    if pressure > limit:
        most = say.quantity("max_contact_pressure", pressure)
        yield {
            "about": "strap",
            "text": (
                f"the strap presses the elbow with up to {most}{width};"
                f" {begins} at {1e-3 * limit:.1f} kPa"
            ),
            "source": _SOURCE_OF_CUFFS,
        }


def _remarks_on_rope(tension: float, diameter: float) -> Iterator[Row]:
    """Yield a remark if a rope of a diameter, m, is less safe at a tension, N, than customary."""
    breaking = _ROPE_STRENGTH * (diameter / _ROPE_DIAMETER) ** 2
    if tension > breaking / _ROPE_SAFETY:
        yield {
            "about": "rope",
            "text": (
                f"a rope of {say.number(1e3 * diameter, 3)} mm breaks at about"
                f" {say.number(breaking, 2)} N, {say.number(breaking / tension, 2)} times the"
                f" largest tension, where {_ROPE_SAFETY:.0f} is customary"
            ),
            "source": _SOURCE_OF_ROPES,
        }


def _remarks_on_spring(question: Question, design: Design) -> Iterator[Row]:
    """Yield a remark if the flexor's stretched spring hardly fits between its anchors."""
    state = evaluate(design, question.angles, question.flexion)
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
        left = float(room[tightest])
        stretch = float(extension[tightest])
        distance = say.quantity("max_spring_extension", float(room[tightest] + extension[tightest]))
        text = (
            f"the flexor's spring is stretched by {say.quantity('max_spring_extension', stretch)}"
            f" between anchors {distance} apart"
        )
        if left > 0.0:
            text += f": {say.quantity('max_spring_extension', left)} are left for the spring itself"
        yield {"about": "spring", "text": text, "source": _SOURCE_OF_SPRINGS}


def drift_of(question: Question, choice: Solutions) -> tuple[float, Drift] | None:
    """Return the pretension 10 % beyond the upper end, N, and the arm's drift there.

    The drift is under the condition that binds. Return None if the upper end is not set by
    stability.
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
    return pretension, max(drifts, key=lambda drifted: abs(drifted.end - drifted.start))


# --- In words -------------------------------------------------------------------------------------


def on_whom(question: Question) -> str:
    """Say whose tensions are recorded: a study about people has the mean man's arm as its own."""
    return " on the mean man" if PERSON_AXIS in question.groups.counts else ""


def posture(question: Question, setting: Row) -> str:
    """Say the posture in which a pretension is set."""
    joint = say.joint_name(question.study)
    angle = setting["angle"]
    tilt = setting["upper_arm_angle"]
    load = setting["load"]
    if joint != "elbow":
        limb = f"{joint} at {say.quantity('elbow_angle', angle)}"
        hand = "without a load"
    elif angle or tilt:
        tilted = f", upper arm at {say.quantity('upper_arm_angle', tilt)}" if tilt else ""
        limb = f"elbow at {say.quantity('elbow_angle', angle)}{tilted}"
        hand = "hand empty"
    else:
        limb = "arm hanging straight"
        hand = "hand empty"
    held = hand if load == 0.0 else f"a load of {say.quantity('load_mass', load)}"
    return f"{limb}, {held}, after {setting['after']}"


def to_set(question: Question, record: Row) -> Iterator[str]:
    """Say the tensions to set at the joint and at the motor, and the effect of shorter tendons."""
    row = record["best"]
    joint_flexor, joint_extensor, motor_flexor, motor_extensor = (
        say.quantity(name, row[name], 4) for name in SETTING_COLUMNS
    )
    yield f"{joint_flexor} in the flexor and {joint_extensor} in the extensor at the joint"
    yield f"{motor_flexor} and {motor_extensor} at the motor"
    if on_whom(question):
        spreads = record["population"]["set"]
        flexor, extensor = (_spread(name, spreads[name]) for name in SETTING_COLUMNS[:2])
        whom = _persons(question.groups.counts[PERSON_AXIS])
        yield f"on {whom} {flexor} in the flexor and {extensor} in the extensor at the joint"
    length = row["tolerance_length"]
    window = ""
    if length is not None:
        window = f", so the window is ± {say.quantity('tolerance_length', length, 2)}"
    per_mm = say.number(1e-3 * record["setting"]["newtons_per_metre"], 2)
    yield f"1 mm taken from both tendons adds {per_mm} N{window}"


def _persons(count: int) -> str:
    """Say for whom a range of tensions holds."""
    if count >= FEW_PERSONS:
        return "nine persons of ten"
    return "these persons" if count > 1 else "this person"


def _spread(name: str, ends: Sequence[float]) -> str:
    """Say a range of a quantity: "120 to 140 N"."""
    low, high = (say.quantity(name, end, 3) for end in ends)
    return low if low == high else f"{low.partition(' ')[0]} to {high}"


def drift_in_words(drift: Row | None) -> str:
    """Say how far the elbow drifts beyond the upper end of its window, if stability ends it."""
    if drift is None:
        return ""
    start = say.quantity("elbow_angle", drift["start"])
    end = say.quantity("elbow_angle", drift["end"])
    if start == end:
        return ": at 10 % more it still stays in place"
    path = f"goes on from {start} beyond {end}"
    if drift["balanced"]:
        path = f"drifts from {start} to {end}"
    torque = say.quantity("elbow_torque", drift["torque"], 2)
    return f": at 10 % more it {path}, driven by at most {torque}"
