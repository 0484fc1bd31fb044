"""The first sentences of a short answer: what to set, which suit it is, and whom it serves."""

from __future__ import annotations

import math
from typing import NamedTuple

from tendon_cli import say
from tendon_cli.answer_record import (
    AnswerResults,
    AxisRecord,
    ChoiceRecord,
    QuestionRecord,
    Value,
    value_of,
)
from tendon_cli.answers.phrases import pretension_words, value_words, window_of
from tendon_cli.answers.text_bench import (
    SET_AT_JOINT,
    SET_AT_MOTOR,
    is_read_at_motor,
    on_whom,
    posture_words,
)
from tendon_cli.answers.text_order import unsettable_words
from tendon_cli.answers.text_parts import can_be_built, failure_words
from tendon_cli.answers.text_people import population_share
from tendon_cli.answers.text_verified import judgement_words
from tendon_cli.space.axis import NAMED_AXES, limit_of, split_side
from tendon_cli.studies.study import keys
from tendon_cli.studies.values import RIGID

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


# --- The sentence ---------------------------------------------------------------------------------


def first_words(record: AnswerResults, best: ChoiceRecord) -> str:
    """Say what to set on which suit, and whom it serves; never recommend what something refutes.

    "Set 168 N in the flexor (112 N in the extensor) at the joint, arm hanging straight, hand
    empty: springs of 5 kN/m with a spool ratio of 0.6 work for all 4 loads." If the suit cannot be
    built or set, or a fresh sample refutes it, the sentence does not begin with "Set".
    """
    suit = suit_words(record.question, best)
    serves = _serves(record, best, suit)
    setting = bench_words(record, best)
    failures = failure_words(record)
    unsettable = unsettable_words(record)
    but = f", but {failures}" if failures else ""
    if unsettable:
        at_setting = f"At {setting}, {suit.verb('they', 'it')} {serves}"
        return f"{_capital(suit.words)} {unsettable}. {at_setting}{but}."
    if not can_be_built(record):
        return f"{_capital(suit.words)} would be set to {setting}, but {failures}."
    if best.feasible and suit.is_of_parts:
        return f"{_capital(suit.words)}: set {setting}; this {serves}{but}."
    if best.feasible:
        return f"Set {setting}: {suit.words} {serves}{but}."
    nearest = ""
    if record.choices > 1:
        nearest = f"{suit.verb('come', 'comes')} closest, but "
    refuted = f"{_capital(suit.words)} {nearest}{serves}"
    and_fails = f", and {failures}" if failures else ""
    return f"{refuted}{and_fails}. It is set to {setting}."


def _serves(record: AnswerResults, best: ChoiceRecord, suit: Suit) -> str:
    """Say whom a suit serves: "work for all 4 loads", "serve 96 % of 10,000 new draws"."""
    question = record.question
    judged = best.served_verified
    fresh = record.verified_by
    serve = suit.verb("serve", "serves")
    work = suit.verb("work", "works")
    if judged is not None and fresh is not None:
        return f"{serve} {judgement_words(fresh, judged, record.serve)}"
    population = record.population
    if population is not None:
        if population.count == 1:
            return f"{work} for this {population.kind.removesuffix('s')}"
        return f"{serve} {population_share(population)}"
    if record.conditions == 1:
        return f"{suit.verb('keep', 'keeps')} every limit"
    noun = _noun_of_condition(question)
    if record.conditions == 2:
        return f"{work} for both {noun}s"
    return f"{work} for all {say.counted(record.conditions, noun)}"


def _noun_of_condition(question: QuestionRecord) -> str:
    """Return the noun for what the conditions are: "load" if they are loads alone."""
    axes = question.conditions
    if len(axes) == 1:
        return {"load.mass": "load", "case": "case"}.get(axes[0].key, "condition")
    return "condition"


def _capital(text: str) -> str:
    """Return a text with a capital at its beginning."""
    return text[0].upper() + text[1:]


# --- The suit -------------------------------------------------------------------------------------


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
        return say.limit_of_so_much(limit, float(value), read), False, False
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


# --- What to set ----------------------------------------------------------------------------------


def bench_words(record: AnswerResults, best: ChoiceRecord) -> str:
    """Say what to set, on whom and in which posture: "168 N in the flexor ..., hand empty"."""
    question = record.question
    setting = record.setting
    tensions = _tensions(record, best)
    if setting is None:
        return tensions
    whom = on_whom(question, setting)
    return f"{tensions}{whom}, {posture_words(question.joint, setting)}"


def _tensions(record: AnswerResults, best: ChoiceRecord) -> str:
    """Say the tensions to set where they are read, or the torque with the tensions beside it."""
    question = record.question
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


def _digits(best: ChoiceRecord, tension: float) -> int:
    """Return as many digits as keep the rounding of a tension small beside the window."""
    pretension = best.pretension
    window = window_of(best)
    if pretension is None or window is None or tension == 0.0:
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
