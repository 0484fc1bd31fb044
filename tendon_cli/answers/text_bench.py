"""The suit on the bench and on the arm in words: posture, tensions to set, and drift."""

from __future__ import annotations

import math
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
from tendon_cli.answers.phrases import ends_of, window_of
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
    return f"To set it{on_whom(question, setting)}: {posture_words(question.joint, setting)}"


def on_whom(question: QuestionRecord, setting: SettingRecord) -> str:
    """Say on whom the recorded tensions are set, if the study is about people."""
    if PERSON_AXIS not in question.counts:
        return ""
    return " on this person" if setting.on_wearer else " on the mean man"


def posture_words(joint: str, setting: SettingRecord) -> str:
    """Say the posture in which a pretension is set."""
    angle = setting.angle
    tilt = setting.upper_arm_angle
    load = setting.load
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
    return f"{limb}, {held}, after {setting.after}"


def to_set(record: AnswerResults, best: ChoiceRecord, setting: SettingRecord) -> Iterator[str]:
    """Say the tensions to set at the joint and at the motor, and the effect of shorter tendons."""
    flexor, extensor = (say.quantity(name, value_of(best, name), 4) for name in SET_AT_JOINT)
    yield f"{flexor} in the flexor and {extensor} in the extensor at the joint"
    flexor, extensor = (say.quantity(name, value_of(best, name), 4) for name in SET_AT_MOTOR)
    yield f"{flexor} and {extensor} at the motor"
    spread = spread_words(record, setting)
    if spread:
        yield spread
    yield shortening_words(record, best, setting)


def spread_words(record: AnswerResults, setting: SettingRecord) -> str:
    """Say the tensions to set over persons or draws: "on nine of ten persons 191 to 200 N ...".

    Empty without them, or if they are the same for all.
    """
    question = record.question
    population = record.population
    if population is None or not population.set:
        return ""
    is_motor = is_read_at_motor(question)
    names = SET_AT_MOTOR if is_motor else SET_AT_JOINT
    flexor, extensor = (_spread(name, population.set[name]) for name in names)
    is_one_body = " to " not in flexor + extensor
    is_known = setting.on_wearer or PERSON_AXIS not in question.counts
    if is_known and is_one_body:
        return ""
    end = "motor" if is_motor else "joint"
    whom = _in_how_many(question)
    return f"{whom} {flexor} in the flexor and {extensor} in the extensor at the {end}"


def other_end_words(question: QuestionRecord, best: ChoiceRecord) -> str:
    """Say the tensions to set at the end at which the pretension is not read."""
    is_motor = is_read_at_motor(question)
    names = SET_AT_JOINT if is_motor else SET_AT_MOTOR
    end = "joint" if is_motor else "motor"
    flexor, extensor = (say.quantity(name, value_of(best, name), 4) for name in names)
    return f"at the {end} {flexor} in the flexor, {extensor} in the extensor"


def is_read_at_motor(question: QuestionRecord) -> bool:
    """Return True if the pretension is read at the motor."""
    return question.read.endswith(("motor", "torque"))


def shortening_words(record: AnswerResults, best: ChoiceRecord, setting: SettingRecord) -> str:
    """Say what 1 mm taken from both tendons adds, and how far they may be too long or too short."""
    question = record.question
    words = f"shortening both tendons by 1 mm adds {_per_mm(question, setting)}"
    window = _serving_window(best)
    pretension = best.pretension
    if window is None or pretension is None:
        return words
    low, high = window
    if not low <= pretension <= high:
        return words
    per_metre = setting.read_per_metre
    too_long = say.length_to_spare((pretension - low) / per_metre)
    works = "works"
    if record.serve < 1.0 and question.groups > 1:
        works = f"serves {say.percent(record.serve)}"
        if best.served_verified is not None:
            works = f"{works} of the new {question.counted}"
    span = f"{say.window_text(low, high, unit=question.unit)} {works}"
    if math.isinf(high):
        return f"{words}; they may be {too_long} too long ({span})"
    too_short = say.length_to_spare((high - pretension) / per_metre)
    return f"{words}; they may be {too_long} too long or {too_short} too short ({span})"


def _serving_window(best: ChoiceRecord) -> tuple[float, float] | None:
    """Return the pretensions that serve enough, N, none below 0; None if none does.

    A fresh sample decides if there is one.
    """
    judged = best.served_verified
    window = window_of(best)
    if judged is not None:
        window = None if judged.from_ is None else ends_of([judged.from_, judged.to])
    if window is None:
        return None
    return max(window[0], 0.0), window[1]


def _per_mm(question: QuestionRecord, setting: SettingRecord) -> str:
    """Say what 1 mm taken from both tendons adds to the reading, and to F0 if this is another."""
    of_f0 = f"{say.number(1e-3 * setting.newtons_per_metre, 2)} N"
    noun, where = say.setting_words(question.read)
    if noun == "pretension":
        return f"{of_f0} of {noun}"
    of_reading = f"{say.number(1e-3 * setting.read_per_metre, 2)} {question.unit}"
    return f"{of_reading} of {noun}{where} ({of_f0} of F0)"


def _in_how_many(question: QuestionRecord) -> str:
    """Say for whom, or in which draws, a range of tensions holds."""
    persons = question.counts.get(PERSON_AXIS, 0)
    is_of_ten = question.groups >= FEW_PERSONS
    if persons == question.groups:
        if is_of_ten:
            return "on nine of ten persons"
        return "on these persons" if persons > 1 else "on this person"
    noun = "draws" if persons == 1 else question.counted
    return f"in nine of ten {noun}" if is_of_ten else f"in these {noun}"


def _spread(name: str, ends: Sequence[float]) -> str:
    """Say a range of a quantity: "120 to 140 N"."""
    low, high = (say.quantity(name, end, 3) for end in ends)
    return low if low == high else f"{low.partition(' ')[0]} to {high}"


def drift_words(drift: DriftRecord | None) -> str:
    """Say where the elbow goes beyond the upper end of its window, if stability ends it."""
    if drift is None:
        return ""
    start = say.quantity("elbow_angle", drift.start)
    end = say.quantity("elbow_angle", drift.end)
    if start == end:
        return f"10 % above this the elbow still stays at {start}"
    torque = f"pushed by at most {say.quantity('elbow_torque', drift.torque, 2)}"
    if drift.balanced:
        return f"10 % above this the elbow settles at {end} instead of {start}, {torque}"
    return f"10 % above this the elbow moves from {start} past {end}, {torque}"
