"""The suit on the bench and on the arm: what to set for a pretension, and what speaks against building or wearing it.

No gauge reads the pretension F0 of the model: where the suit is set, the arm's weight and the moment arms make other
tensions of it (`model/setting.py`). Limits that the study does not set are compared with what is known.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.answers.phrases import Row
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.solve import Solutions, severest_conditions, worst
from tendon_cli.model.actuator import evaluate
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMIT_NAMES
from tendon_cli.model.reversal import Drift, drift
from tendon_cli.model.setting import all_readings, per_length
from tendon_cli.space.axis import DRAW_AXIS, PERSON_AXIS, PRETENSION, SIDES, Axis, Numbers

SET = tuple(f"set_{side}_tension{end}" for end in ("", "_motor") for side in SIDES)
"""Columns of what to set: the tensions at the joint, and at the motor, N."""

FEW = 20  # persons of whom no share says more than all of them
STRAP = 0.04  # width of a strap if the study gives none, m
DISCOMFORT, PAIN = 30.4e3, 52.9e3
"""Pressure under a cuff at the knee that is uncomfortable for a while, and that hurts, Pa."""
OF_CUFFS = "cuffs at the knee, Ergonomics 63(5):618, 2020; nothing is known of elbows"
BREAKING, ROPE, SAFETY = 2.1e3, 1.5875e-3, 10.0
"""A stainless rope of 1/16 inch, 7x7, breaks at so many N; the customary factor."""
OF_ROPES = "makers' tables for stainless 7x7 rope"
SPRINGS = (
    (3e3, 5e3),
    (0.084, 0.073),
)  # stiffness, N/m, and unloaded length of springs that are made for 300 N, m
OF_SPRINGS = "extension springs made for 300 N: 73 mm at 5 kN/m, 84 mm at 3 kN/m"

BEYOND = 1.1  # times the upper end of a window, where the drift is worked out


# --- What to set -----------------------------------------------------------------------------------------------------


def study_arm(
    problem: Problem, numbers: Numbers, pretension: Array, whom: Axis | None = None
) -> Design:
    """Choices at their pretensions, (choices,), on the study's own arm, or on the bodies of all persons.

    That has no draw's numbers, and the first of every other condition.
    """
    count = 1 if whom is None else len(whom)
    others = (axis for axis in problem.conditions.axes if axis.key not in (PERSON_AXIS, DRAW_AXIS))
    under = {
        key: np.repeat(values[:1], count) for axis in others for key, values in axis.numbers.items()
    }
    under |= {} if whom is None else dict(whom.numbers)
    return problem.choices.at({**numbers, PRETENSION: pretension}, under).design()


def settings(design: Design, count: int) -> dict[str, Array]:
    """What to set for `count` designs: the columns of `SET`."""
    shown = all_readings(design, design.flexor.pretension)
    values = [shown[f"{side} at {end}"] for end in ("joint", "motor") for side in SIDES]
    return {name: _each(value, count) for name, value in zip(SET, values, strict=True)}


def _each(values: Array, count: int) -> Array:
    return np.broadcast_to(np.asarray(values).reshape(-1), (count,)).copy()


def setting_columns(
    problem: Problem, numbers: Numbers, low: Array, high: Array, pretension: Array
) -> dict[str, Array]:
    """What to set for choices, and half the window as a length of both tendons, m; null for one without an end."""
    design = study_arm(problem, numbers, pretension)
    with np.errstate(invalid="ignore"):
        ends = (study_arm(problem, numbers, end).flexor.pretension for end in (low, high))
        first, last = (_each(np.asarray(end), len(low)) for end in ends)
        length = 0.5 * (last - first) / _each(per_length(design), len(low))
    is_closed = (low <= high) & np.isfinite(high)
    return {**settings(design, len(low)), "tolerance_length": np.where(is_closed, length, np.nan)}


# --- What an answer says of it ---------------------------------------------------------------------------------------


def bench_record(problem: Problem, choice: Solutions) -> dict[str, Any]:
    """What to set for a choice, the drift beyond its window, and remarks, as the record of an answer has them."""
    design = study_arm(problem, problem.numbers_of(choice.columns), choice["pretension"])
    beyond, posture = drift_of(problem, choice), problem.study.setting
    angles = {
        name: float(getattr(posture, name).array[0])
        for name in ("angle", "upper_arm_angle", "load")
    }
    added = {"newtons_per_metre": float(_each(per_length(design), 1)[0])}
    return {
        "setting": {**angles, "after": posture.after, "read": posture.read, **added},
        "drift": None if beyond is None else {"pretension": beyond[0], **asdict(beyond[1])},
        "remarks": [*remarks(problem, choice)],
    }


def remarks(problem: Problem, choice: Solutions) -> Iterator[Row]:
    """What a suit would do that no limit forbids and nobody would want, at its pretension, with the sources."""
    if np.isnan(choice["pretension"][0]) or not choice["served_at"][0] > 0.0:
        return
    numbers = problem.numbers_of(choice.columns)
    everyone = np.ones((1, len(problem.conditions)), dtype=np.bool_)
    if "max_contact_pressure" not in problem.bounds:
        pressure, width = choice.scalar("max_contact_pressure"), ""
        if np.isnan(pressure):
            strapped = problem.saying(
                {"arm.contact_width": np.full(len(problem.conditions), STRAP)}
            )
            pressure = float(
                worst(strapped, numbers, choice["pretension"], everyone)["max_contact_pressure"][0]
            )
            width = f" if it is {1e3 * STRAP:.0f} mm wide"
        yield from _of_strap(pressure, width)
    if "max_tension" not in problem.bounds:
        design = problem.design(numbers)
        diameter = float(min(np.min(design.flexor.diameter), np.min(design.extensor.diameter)))
        yield from _of_rope(choice.scalar("max_tension"), diameter)
    if not {"max_spring_extension", "min_spring_room"} & set(problem.bounds):
        few = problem.under(
            severest_conditions(problem, numbers, choice["pretension"], everyone, 1)
        )
        yield from _of_spring(few, few.design(numbers, pretension=choice["pretension"]))


def _of_strap(pressure: float, width: str) -> Iterator[Row]:
    begins, limit = ("pain begins", PAIN) if pressure > PAIN else ("discomfort begins", DISCOMFORT)
    if pressure > limit:
        text = f"the strap presses the elbow with up to {say.quantity('max_contact_pressure', pressure)}{width}"
        yield {
            "about": "strap",
            "text": f"{text}; {begins} at {1e-3 * limit:.1f} kPa",
            "source": OF_CUFFS,
        }


def _of_rope(tension: float, diameter: float) -> Iterator[Row]:
    breaking = BREAKING * (diameter / ROPE) ** 2
    if tension > breaking / SAFETY:
        rope = f"a rope of {say.number(1e3 * diameter, 3)} mm breaks at about {say.number(breaking, 2)} N"
        factor = f"{say.number(breaking / tension, 2)} times the largest tension, where {SAFETY:.0f} is customary"
        yield {"about": "rope", "text": f"{rope}, {factor}", "source": OF_ROPES}


def _of_spring(problem: Problem, design: Design) -> Iterator[Row]:
    """By how much the flexor's spring is stretched, against the room between its anchors."""
    state = evaluate(design, problem.angles, problem.flexion)
    extension: Array = np.asarray(state.balance.flexor / design.flexor.spring_stiffness)
    path = state.motion.flexor_path
    if (
        path is None
        or not np.isfinite(room := np.broadcast_to(path, extension.shape) - extension).any()
    ):
        return
    at = np.unravel_index(int(np.nanargmin(room)), room.shape)
    if room[at] < np.interp(np.min(design.flexor.spring_stiffness), *SPRINGS):
        values = (float(each) for each in (room[at], extension[at], room[at] + extension[at]))
        left, stretched, apart = (say.quantity("max_spring_extension", each) for each in values)
        text = f"the flexor's spring is stretched by {stretched} between anchors {apart} apart"
        text += f": {left} are left for the spring itself" if room[at] > 0.0 else ""
        yield {"about": "spring", "text": text, "source": OF_SPRINGS}


def drift_of(problem: Problem, choice: Solutions) -> tuple[float, Drift] | None:
    """The pretension 10 % beyond the upper end, N, and the arm's drift there under the condition that binds.

    None if it is not stability that bounds the window above.
    """
    high, state = choice.scalar("pretension_to"), int(choice["to_state"][0])
    is_stability = state >= 0 and LIMIT_NAMES[choice["to_by"][0]] == "min_elbow_stiffness"
    if not (is_stability and np.isfinite(high) and problem.bounds["min_elbow_stiffness"] == 0.0):
        return None
    alone = problem.under(choice["to_condition"][:1])
    design = alone.design(problem.numbers_of(choice.columns), pretension=np.array([BEYOND * high]))
    start = float(problem.angles[0, state % problem.angles.size])
    first, last = float(problem.angles.min()), float(problem.angles.max())
    ways = [drift(design, start, end) for end in (first, last) if end != start]
    return BEYOND * high, max(ways, key=lambda way: abs(way.end - way.start))


# --- In words --------------------------------------------------------------------------------------------------------


def on_whom(problem: Problem) -> str:
    """Whose tensions the record has: the study's own arm is that of the mean man, if it is about people."""
    return " on the mean man" if PERSON_AXIS in problem.counts else ""


def posture(problem: Problem, setting: Row) -> str:
    """The posture in which a pretension is set."""
    joint, angle, tilt, load = (
        say.joint_word(problem.study),
        setting["angle"],
        setting["upper_arm_angle"],
        setting["load"],
    )
    if joint != "elbow":
        limb, hand = f"{joint} at {say.quantity('elbow_angle', angle)}", "without a load"
    else:
        tilted = f", upper arm at {say.quantity('upper_arm_angle', tilt)}" if tilt else ""
        limb = (
            f"elbow at {say.quantity('elbow_angle', angle)}{tilted}"
            if angle or tilt
            else "arm hanging straight"
        )
        hand = "hand empty"
    held = hand if load == 0.0 else f"a load of {say.quantity('load_mass', load)}"
    return f"{limb}, {held}, after {setting['after']}"


def to_set(problem: Problem, record: Row) -> Iterator[str]:
    """What gauges show at the joint and at the motor, and what a length of the tendons does."""
    row = record["best"]
    joint, joint_extensor, motor, motor_extensor = (
        say.quantity(name, row[name], 4) for name in SET
    )
    yield f"{joint} in the flexor and {joint_extensor} in the extensor at the joint"
    yield f"{motor} and {motor_extensor} at the motor"
    if on_whom(problem):
        flexor, extensor = (_spread(name, record["population"]["set"][name]) for name in SET[:2])
        persons = problem.counts[PERSON_AXIS]
        whom = (
            "nine persons of ten"
            if persons >= FEW
            else "these persons"
            if persons > 1
            else "this person"
        )
        yield f"on {whom} {flexor} in the flexor and {extensor} in the extensor at the joint"
    length, per_mm = (
        row["tolerance_length"],
        say.number(1e-3 * record["setting"]["newtons_per_metre"], 2),
    )
    window = (
        ""
        if length is None
        else f", so the window is ± {say.quantity('tolerance_length', length, 2)}"
    )
    yield f"1 mm taken from both tendons adds {per_mm} N{window}"


def _spread(name: str, ends: Sequence[float]) -> str:
    low, high = (say.quantity(name, end, 3) for end in ends)
    return low if low == high else f"{low.partition(' ')[0]} to {high}"


def drift_in_words(drift: Row | None) -> str:
    """How far the elbow goes beyond the upper end of its window, if it is stability that ends it."""
    if drift is None:
        return ""
    start, end = (say.quantity("elbow_angle", drift[name]) for name in ("start", "end"))
    if start == end:
        return ": at 10 % more it still stays"
    far = (
        f"drifts from {start} to {end}"
        if drift["balanced"]
        else f"goes on from {start} beyond {end}"
    )
    return f": at 10 % more it {far}, driven by at most {say.quantity('elbow_torque', drift['torque'], 2)}"
