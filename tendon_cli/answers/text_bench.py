"""The suit on the bench and on the arm in words: posture, tensions to set, and drift."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tendon_cli import say
from tendon_cli.answer_record import (
    AnswerResults,
    ChoiceRecord,
    DriftRecord,
    QuestionRecord,
    SettingRecord,
    value_of,
)
from tendon_cli.space.axis import PERSON_AXIS

SET_AT_JOINT = ("set_flexor_tension", "set_extensor_tension")
"""Columns of the tensions to set at the joint, N."""
SET_AT_MOTOR = ("set_flexor_tension_motor", "set_extensor_tension_motor")
"""Columns of the tensions to set at the motor, N."""

FEW_PERSONS = 20
"""Number of persons below which a range holds all of them, not nine in ten."""


# --- What to set ----------------------------------------------------------------------------------


def bench_heading(question: QuestionRecord, setting: SettingRecord) -> str:
    """Say on whom, and in which posture, the recorded tensions are set.

    A study about people has the mean man's arm as its own, unless anchors were measured on one.
    """
    whom = ""
    if PERSON_AXIS in question["counts"]:
        whom = " on this person" if setting["on_wearer"] else " on the mean man"
    return f"To set it{whom}: {_posture(question['joint'], setting)}"


def _posture(joint: str, setting: SettingRecord) -> str:
    """Say the posture in which a pretension is set."""
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


def to_set(record: AnswerResults, best: ChoiceRecord, setting: SettingRecord) -> Iterator[str]:
    """Say the tensions to set at the joint and at the motor, and the effect of shorter tendons."""
    question = record["question"]
    flexor, extensor = (say.quantity(name, value_of(best, name), 4) for name in SET_AT_JOINT)
    yield f"{flexor} in the flexor and {extensor} in the extensor at the joint"
    flexor, extensor = (say.quantity(name, value_of(best, name), 4) for name in SET_AT_MOTOR)
    yield f"{flexor} and {extensor} at the motor"
    population = record["population"]
    if population is not None:
        is_motor = question["read"].endswith("motor")
        names = SET_AT_MOTOR if is_motor else SET_AT_JOINT
        spreads = {name: population["set"][name] for name in names}
        flexor, extensor = (_spread(name, ends) for name, ends in spreads.items())
        is_one_body = " to " not in flexor + extensor
        is_known = setting["on_wearer"] or PERSON_AXIS not in question["counts"]
        if not (is_known and is_one_body):
            whom = _in_how_many(question)
            end = "motor" if is_motor else "joint"
            yield f"{whom} {flexor} in the flexor and {extensor} in the extensor at the {end}"
    length = best["tolerance_length"]
    window = ""
    if length is not None:
        window = f", so the window is ± {say.quantity('tolerance_length', length, 2)}"
    yield f"1 mm taken from both tendons adds {_per_mm(question, setting)}{window}"


def _per_mm(question: QuestionRecord, setting: SettingRecord) -> str:
    """Say what 1 mm taken from both tendons adds to the reading, and to F0 if this is another."""
    of_f0 = f"{say.number(1e-3 * setting['newtons_per_metre'], 2)} N"
    noun, where = say.setting_words(question["read"])
    if noun == "pretension":
        return f"{of_f0} of {noun}"
    of_reading = f"{say.number(1e-3 * setting['read_per_metre'], 2)} {question['unit']}"
    return f"{of_reading} of {noun}{where} ({of_f0} of F0)"


def _in_how_many(question: QuestionRecord) -> str:
    """Say for whom, or in which draws, a range of tensions holds."""
    persons = question["counts"].get(PERSON_AXIS, 0)
    is_of_ten = question["groups"] >= FEW_PERSONS
    if persons == question["groups"]:
        if is_of_ten:
            return "on nine persons of ten"
        return "on these persons" if persons > 1 else "on this person"
    return (
        f"in nine {question['counted']} of ten" if is_of_ten else f"in these {question['counted']}"
    )


def _spread(name: str, ends: Sequence[float]) -> str:
    """Say a range of a quantity: "120 to 140 N"."""
    low, high = (say.quantity(name, end, 3) for end in ends)
    return low if low == high else f"{low.partition(' ')[0]} to {high}"


def drift_words(drift: DriftRecord | None) -> str:
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
