"""The suit and its setting in words: the choice, tensions, posture and drift."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from tendon_cli import say
from tendon_cli.answers.phrases import (
    choice_words,
    ends_of,
    population_share,
    pretension_words,
    share_words,
    value_words,
    window_of,
)
from tendon_cli.studies import limit_phrases
from tendon_cli.studies.space.axis import NAMED_AXES, PERSON_AXIS, limit_of, split_side
from tendon_cli.studies.study import keys
from tendon_cli.studies.values import RIGID
from tendon_cli.verbs.answer_record import (
    AnswerResults,
    AxisRecord,
    ChoiceRecord,
    DriftRecord,
    FreshRecord,
    PopulationRecord,
    QuestionRecord,
    SettingRecord,
    Value,
    value_of,
)

_MOST_AXES = 5
"""Most values by which a choice is named."""
_LEAST_DIGITS = 3
"""Fewest significant digits of a tension to set."""
_MOST_DIGITS = 4
"""Most significant digits of such a tension."""
_ROUNDING = 0.05
"""Share of the distance to an end of the window by which rounding may move what is set."""
_NOUNS = {
    "spool.ratio": "a spool ratio of {}",
    "arm.contact_width": "a strap of {}",
    "tendon.diameter": "a rope of {}",
}
"""Words for the value of a choice, by the key of its axis; others are said by their symbols."""
SET_AT_JOINT = ("set_flexor_tension", "set_extensor_tension")
"""Columns of the tensions to set at the joint, N."""
SET_AT_MOTOR = ("set_flexor_tension_motor", "set_extensor_tension_motor")
"""Columns of the tensions to set at the motor, N."""
FEW_PERSONS = 20
"""Number of persons below which a range holds all of them, not nine in ten."""


# --- The suit -------------------------------------------------------------------------------------


class Suit(NamedTuple):
    """A choice in words."""

    words: str
    """Noun phrase: "springs of 5 kN/m with a spool ratio of 0.6"; "this suit" without axes."""
    is_plural: bool
    """True if its verb is a plural."""
    is_of_parts: bool = False
    """True if it begins with a row of a table, such as a part that one can buy."""

    def verb(self, several: str, one: str) -> str:
        """Return the form of a verb that agrees with it."""
        return several if self.is_plural else one


def suit_words(question: QuestionRecord, row: ChoiceRecord) -> Suit:
    """Say a choice by its values: rows of tables first, then springs."""
    rows: list[str] = []
    springs: list[str] = []
    others: list[str] = []
    is_plural = False
    for axis in question.choices:
        value = value_of(row, axis.column)
        if _is_table(axis):
            rows.append(value_words(axis, value))
            continue
        words, is_spring, is_several = _part_words(axis, value)
        (springs if is_spring else others).append(words)
        is_plural = is_plural or is_several
    if rows:
        others = [*rows[1:], *springs, *others]
        springs = rows[:1]
    left = len(springs) + len(others) - _MOST_AXES
    if left > 0:
        counted = say.counted(left + 1, "other number")
        others = [*others[: -left - 1], f"{counted} (--why)"]
    if not springs and not others:
        return Suit("this suit", is_plural=False)
    if rows:
        with_others = f" with {say.join_words(others)}" if others else ""
        return Suit(f"{rows[0]}{with_others}", is_plural=False, is_of_parts=True)
    if not springs:
        return Suit(say.join_words(others), is_plural=len(others) > 1)
    whole = say.join_words(springs)
    rest = say.join_words(others)
    suit = f"{whole} with {rest}" if rest else whole
    return Suit(suit, is_plural or len(springs) > 1)


def _is_table(axis: AxisRecord) -> bool:
    """Return True for the axis of a table of the study, whose rows are parts or samples."""
    return axis.sets is not None and axis.key not in NAMED_AXES


def _part_words(axis: AxisRecord, value: Value) -> tuple[str, bool, bool]:
    """Say the value of a choice on an axis; return True if it is a spring, and if it is several."""
    common, side = split_side(axis.key)
    limit = limit_of(common)
    if axis.named or axis.sets is not None:
        return value_words(axis, value), False, False
    if limit is not None:
        read = axis.read or "pretension"
        return limit_phrases.limit_of_so_much(limit, float(value), read), False, False
    if common == "spring.stiffness":
        is_rigid = value == RIGID or math.isinf(float(value))
        number = "" if is_rigid else f" of {say.quantity('spring_stiffness', float(value))}"
        rigid = "rigid " if is_rigid else ""
        if side:
            return f"a {rigid}spring{number} in the {side}", True, False
        return f"{rigid}springs{number}", True, True
    if common in _NOUNS and not side:
        number = say.quantity(keys()[common].quantity, float(value))
        return _NOUNS[common].format(number), False, False
    return value_words(axis, value), False, False


def bench_words(record: AnswerResults, best: ChoiceRecord) -> str:
    """Say what to set, on whom and in which posture: "168 N in the flexor ..., hand empty"."""
    question = record.question
    setting = record.setting
    tensions = to_set_words(question, best)
    if setting is None:
        return tensions
    whom = on_whom(question, setting)
    return f"{tensions}{whom}, {posture_words(question.joint, setting)}"


def to_set_words(question: QuestionRecord, best: ChoiceRecord) -> str:
    """Say the tensions to set where they are read, or the torque with the tensions beside it."""
    read = question.read
    is_motor = is_read_at_motor(question)
    columns = SET_AT_MOTOR if is_motor else SET_AT_JOINT
    end = "motor" if is_motor else "joint"
    values = [value_of(best, column) for column in columns]
    if any(value is None for value in values):
        return f"{pretension_words(question, best)} of {read}"
    flexor, extensor = (
        say.quantity(column, value, _digits(best, value))
        for column, value in zip(columns, values, strict=True)
    )
    if read == "motor torque":
        both = f"{flexor} in the flexor, {extensor} in the extensor"
        return f"a motor torque of {pretension_words(question, best)} ({both}, at the motor)"
    if read == f"flexor at {end}":
        flexor = pretension_words(question, best)
    if read == f"extensor at {end}":
        extensor = pretension_words(question, best)
        return f"{extensor} in the extensor ({flexor} in the flexor) at the {end}"
    return f"{flexor} in the flexor ({extensor} in the extensor) at the {end}"


def population_title(
    question: QuestionRecord,
    population: PopulationRecord,
    row: ChoiceRecord,
    fresh: FreshRecord | None,
    serve: float,
) -> str:
    """Say a choice, what to set and the share that this serves, for figures and pages.

    Args:
        question: The question.
        population: The choice for persons or draws.
        row: The choice.
        fresh: Fresh sample that judges it; None without one.
        serve: Share that is enough.
    """
    judged = population.served_verified
    share = f"serves {population_share(population)}"
    if fresh is not None and judged is not None:
        share = f"serves {share_words(fresh, judged, serve)}"
    if population.pretension is not None:
        share = f"{to_set_words(question, row)} {share}"
    choice = choice_words(question, population.values)
    return f"{choice}: {share}" if choice else share


def _digits(best: ChoiceRecord, tension: float) -> int:
    """Return as many digits as keep the rounding of a tension small beside the window."""
    pretension = best.pretension
    window = window_of(best)
    is_of_sample = best.served_verified is not None  # whose seed decides on the fourth digit
    if pretension is None or window is None or tension == 0.0 or is_of_sample:
        return _LEAST_DIGITS
    room = min(pretension - window[0], window[1] - pretension)
    share = max(room, 0.0) / max(abs(pretension), 1e-12)
    digits = _LEAST_DIGITS
    place = math.floor(math.log10(abs(tension))) + 1
    while digits < _MOST_DIGITS:
        rounding = 0.5 * 10.0 ** (place - digits)
        if rounding <= _ROUNDING * share * abs(tension):
            break
        digits += 1
    return digits


# --- On the bench ---------------------------------------------------------------------------------


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
    if question.read == f"flexor at {end}":
        return f"{whom} the extensor then shows {extensor}"
    return f"{whom} {flexor} in the flexor and {extensor} in the extensor at the {end}"


def other_end_words(question: QuestionRecord, best: ChoiceRecord) -> str:
    """Say the tensions to set at the end at which the pretension is not read."""
    is_motor = is_read_at_motor(question)
    names = SET_AT_JOINT if is_motor else SET_AT_MOTOR
    end = "joint" if is_motor else "motor"
    flexor, extensor = (
        say.quantity(name, value_of(best, name), question.setting_digits) for name in names
    )
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
    if question.set_by_sample:
        low_text = say.number(low, 3)
        high_text = "more" if math.isinf(high) else f"{say.number(high, 3)} {question.unit}"
        span = f"{low_text} to {high_text} {works}"
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
    if question.set_by_sample:
        return f"{of_reading} to the {noun}"
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
