"""Choices, conditions, shares and ends of windows in words, from the record of an answer."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from tendon_cli import say
from tendon_cli.quantities import bound_name
from tendon_cli.studies import limit_phrases
from tendon_cli.studies.axis_words import numbers_in_words, parameter, row_name, word_of_key
from tendon_cli.studies.space.axis import DRAW_AXIS, PERSON_AXIS, SAMPLE_AXES, limit_of
from tendon_cli.studies.study import keys
from tendon_cli.verbs.answer_record import (
    AxisRecord,
    ChoiceRecord,
    FixRecord,
    FreshRecord,
    PopulationRecord,
    QuestionRecord,
    ReasonRecord,
    Value,
    Values,
    VerifiedRecord,
    value_of,
)

COSTS = {"max_tension": "tension", "max_spring_extension": "spring", "peak_motor_torque": "torque"}
"""Columns of a choice's costs, and their heads in small tables."""
_MOST_SHARE_DIGITS = 7
"""Most significant digits of a share that is printed beside the one asked for."""
_SHARE_ROUNDING = 1e-12
"""Rounding of a share."""
MORE = "more"
"""Needs more pretension to be served."""
LESS = "less"
"""Needs less pretension to be served."""
NEITHER = "another suit"
"""Needs another suit to be served."""
_NEEDS = {MORE: "a higher", LESS: "a lower"}


# --- Values ---------------------------------------------------------------------------------------


def value_words(axis: AxisRecord, value: Value, *, in_brackets: bool = False) -> str:
    """Say the value of a choice or a condition on an axis: "K 3 kN/m", "d88 (b₁ 88 mm)".

    Args:
        axis: The axis.
        value: The number, or the name of the value.
        in_brackets: True for words that stand in brackets: "d88: b₁ 88 mm".
    """
    if axis.sets is not None:
        told = ", ".join((axis.carries or {}).get(str(value), ()))
        if not told:
            told = numbers_in_words(axis.sets.get(str(value), {}), parameter)
        return row_name(axis.key, str(value), told, in_brackets=in_brackets)
    if axis.named:
        return word_of_key(axis.key, str(value))
    return parameter(axis.key, value, axis.read)


def choice_words(question: QuestionRecord, choice: ChoiceRecord | Values) -> str:
    """Say a choice by its value on each axis; empty if there is no axis."""
    return ", ".join(value_words(axis, value_of(choice, axis.column)) for axis in question.choices)


def condition_words(question: QuestionRecord, condition: Values) -> str:
    """Say a condition, within brackets, by its value on each axis; empty if there is no axis."""
    return ", ".join(
        value_words(axis, condition[axis.column], in_brackets=True) for axis in question.conditions
    )


def condition_of_group(question: QuestionRecord, condition: Values) -> str:
    """Say a condition without the person and the draw that it belongs to."""
    axes = [axis for axis in question.conditions if not _is_drawn(axis)]
    return ", ".join(value_words(axis, condition[axis.column], in_brackets=True) for axis in axes)


def _is_drawn(axis: AxisRecord) -> bool:
    """Return True for an axis of persons, of draws, or of rows that are draws."""
    return axis.key in SAMPLE_AXES or axis.drawn


def costs(row: ChoiceRecord | FixRecord) -> list[str]:
    """Say the costs of a choice."""
    values = {name: value_of(row, name) for name in COSTS}
    return [
        "-" if value is None else say.quantity(name, float(value)) for name, value in values.items()
    ]


def everyone(counts: Mapping[str, int], count: int, kind: str) -> str:
    """Say who or what a share is counted in: "1,000 persons", "this person's 256 draws".

    Pairs are "192 pairs of 3 persons and 64 draws".

    Args:
        counts: Numbers of persons and draws.
        count: Number of groups: persons, pairs, draws or conditions.
        kind: Their noun in the plural.
    """
    persons = counts.get("person", 0)
    draws = counts.get("draw", 0)
    if persons == 1 and draws > 1:
        return f"this person's {say.counted(draws, 'draw')}"
    if persons > 1 and draws > 1 and kind == "pairs":
        of_both = f"{say.counted(persons, 'person')} and {say.counted(draws, 'draw')}"
        return f"{count:,} pairs of {of_both}"
    noun = kind.removesuffix("s")
    return f"this {noun}" if count == 1 else say.counted(count, noun)


def own_sample(question: QuestionRecord) -> str:
    """Say of whom or what the study's own sample is: "the study's own 256 draws of this person"."""
    draws = question.counts.get(DRAW_AXIS, 0)
    if question.counts.get(PERSON_AXIS, 0) == 1 and draws > 1:
        return f"the study's own {say.counted(draws, 'draw')} of this person"
    whom = everyone(question.counts, question.groups, question.counted)
    return f"the study's own {whom.removeprefix('this ')}"


def bounds(question: QuestionRecord, *values: Mapping[str, Any]) -> dict[str, float | None]:
    """Return the limits that hold for a choice under a condition, SI, by name.

    A limit that differs between designs is None as far as the values do not tell it.

    Args:
        question: The question.
        values: Values by column: the row of a choice, and those of a condition on its axes.
    """
    known: dict[str, float | None] = {**question.limits}
    on_axes = {column: value for of_axes in values for column, value in of_axes.items()}
    for limit in question.own_limits:
        known[limit] = on_axes.get(bound_name(limit))
    for axis in question.conditions:
        limit_of_axis = limit_of(axis.key)
        of_rows = axis.limits
        value = on_axes.get(axis.column)
        if limit_of_axis is not None:
            known[limit_of_axis] = None if value is None else float(value)
        elif value is None:
            known |= dict.fromkeys(name for row in of_rows.values() for name in row)
        else:
            known |= of_rows.get(str(value), {})
    return known


def broken(question: QuestionRecord, limit: str, *values: Mapping[str, Any]) -> str:
    """Say what happens if a limit is not kept, with its bound for the values of `bounds`."""
    return limit_phrases.limit_words(limit, bounds(question, *values), question.read).broken


def sums_words(question: QuestionRecord, row: ChoiceRecord) -> str:
    """Say what a choice adds up of its parts: "price 141 EUR in all with 2 springs"; or nothing."""
    texts = []
    several: dict[str, int] = {}
    for column, carried in question.carried.items():
        value = carried_words(question, value_of(row, column), column)
        if (len(carried.tables) > 1 or carried.pieces) and value != "-":
            texts.append(f"{say.spaced(column)} {value}")
            several |= carried.pieces
    counted = "".join(f" with {number} {table}s" for table, number in several.items())
    return f"{', '.join(texts)} in all{counted}" if texts else ""


def carried_words(question: QuestionRecord, value: Any, column: str) -> str:
    """Say a number that the parts of a choice carry along: "141 EUR"; "-" if it is not known."""
    if value is None:
        return "-"
    unit = question.carried[column].unit
    return f"{float(value):,.12g} {unit}".rstrip()


class WindowEnd(NamedTuple):
    """One end of a choice's window, with what binds there."""

    pretension: float | None
    """The end, N; null if nothing bounds the window, or if no pretension could do."""
    limit: str | None
    under: Values
    """Values of the condition."""
    direction: str | None
    """Direction of the state; None if the limit belongs to no state."""
    elbow_angle: float | None
    """Elbow angle of the state, rad."""
    time: float | None
    """Moment of the state along a trajectory, s; None without one."""


def lower_end(row: ChoiceRecord) -> WindowEnd:
    """Return the lower end of a choice's window."""
    return WindowEnd(
        row.pretension_from,
        row.from_by,
        row.from_under,
        row.from_direction,
        row.from_elbow_angle,
        row.columns.get("from_time"),
    )


def upper_end(row: ChoiceRecord) -> WindowEnd:
    """Return the upper end of a choice's window."""
    return WindowEnd(
        row.pretension_to,
        row.to_by,
        row.to_under,
        row.to_direction,
        row.to_elbow_angle,
        row.columns.get("to_time"),
    )


def window_of(row: ChoiceRecord) -> tuple[float, float] | None:
    """Return the ends of a choice's window, N, the upper one infinite if nothing bounds it.

    The window is empty if they are in the wrong order. Return None if no pretension could do.
    """
    if row.pretension_from is None:
        return None
    return ends_of([row.pretension_from, row.pretension_to])


def ends_of(window: Sequence[float | None]) -> tuple[float, float]:
    """Return the ends of a recorded window, N, infinite for an end that it does not have."""
    low, high = window
    return -np.inf if low is None else low, np.inf if high is None else high


def pretension_words(question: QuestionRecord, best: ChoiceRecord) -> str:
    """Say the pretension of a choice as it is read, rounded so that it stays in its window."""
    pretension = best.pretension
    window = window_of(best)
    if pretension is None or window is None:
        return "-"
    return f"{say.number_within(pretension, *window, question.setting_digits)} {question.unit}"


def lower_words(question: QuestionRecord, row: ChoiceRecord, gauge: str = "") -> str:
    """Say the lower end of a window, with the limit, the condition and the state that bind.

    Args:
        question: The question.
        row: The choice.
        gauge: Words for what is read, behind the value: " of pretension".
    """
    end = lower_end(row)
    if end.limit is None or end.pretension is None:
        return "no lower limit: both tendons are taut without pretension"
    if end.pretension < 0.0:
        return "no lower limit: no pretension is needed"
    return f"below {_end_words(question, row, end, end.pretension, end.limit, gauge)}"


def upper_words(question: QuestionRecord, row: ChoiceRecord) -> str:
    """Say the upper end of a window, with the limit, the condition and the state that bind."""
    end = upper_end(row)
    if end.limit is None or end.pretension is None:
        return "no upper limit"
    if end.pretension < 0.0:
        noun, _ = say.setting_words(question.read)
        is_broken = broken(question, end.limit, row.columns, end.under)
        return f"at any {noun}, even 0 {question.unit}, {is_broken}{where(question, end)}"
    return f"above {_end_words(question, row, end, end.pretension, end.limit)}"


def _end_words(
    question: QuestionRecord,
    row: ChoiceRecord,
    end: WindowEnd,
    pretension: float,
    limit: str,
    gauge: str = "",
) -> str:
    """Say an end of a window, and what binds there: of a sample, what too few would do."""
    happens = f"{broken(question, limit, row.columns, end.under)}{where(question, end)}"
    if not question.set_by_sample:
        return f"{say.number(pretension)} {question.unit}{gauge} {happens}"
    value = f"{say.number(pretension, 3)} {question.unit}{gauge}"
    return f"{value} too few are served: {happens}"


def gap_words(question: QuestionRecord, row: ChoiceRecord, gap: float | None) -> Iterator[str]:
    """Say both ends of an empty window, and the distance between them.

    An upper end below zero is broken by any pretension, so that no distance would help.

    Args:
        question: The question.
        row: A choice whose upper end lies below its lower one.
        gap: Distance between the ends, N.
    """
    lower = lower_end(row)
    upper = upper_end(row)
    if upper.pretension is None or upper.limit is None or upper.pretension >= 0.0:
        yield f"{lower_words(question, row)},"
        apart = "" if gap is None else f": {say.number(gap, 3)} {question.unit} apart"
        yield f"{upper_words(question, row)}{apart}"
        return
    if lower.limit != upper.limit:
        yield lower_words(question, row)
    yield upper_words(question, row)


def where(question: QuestionRecord, end: WindowEnd) -> str:
    """Say the condition and the state that bind, in brackets."""
    if question.set_by_sample:
        words = [condition_of_group(question, end.under)]
    else:
        words = [condition_words(question, end.under)]
    if end.direction is not None and end.elbow_angle is not None:
        words.append(end.direction)
        words.append(say.quantity("elbow_angle", end.elbow_angle))
    if end.time is not None:
        words.append(f"at {say.quantity('time', end.time)}")
    inside = ", ".join(word for word in words if word)
    return f" ({inside})" if inside else ""


def margins(question: QuestionRecord, row: ChoiceRecord) -> str:
    """Say by how much a given pretension lies within the window of a choice, or misses it."""
    pretension = question.pretension
    window = window_of(row)
    if pretension is None or window is None or window[0] > window[1]:
        return "there is no window"
    low, high = window
    unit = question.unit
    span = say.window_text(low, high, unit=unit)
    given = f"{say.number(pretension)} {unit}"
    if pretension < low:
        return f"{given} is {say.number(low - pretension, 3)} {unit} below the window, {span}"
    if pretension > high:
        return f"{given} is {say.number(pretension - high, 3)} {unit} above the window, {span}"
    lower = f"{say.number(pretension - low, 3)} {unit} above the lower end"
    upper = ""
    if not np.isinf(high):
        upper = f" and {say.number(high - pretension, 3)} {unit} below the upper end"
    return f"that is {lower}{upper} of the window, {span}"


# --- Shares ---------------------------------------------------------------------------------------


def members(fresh: FreshRecord) -> str:
    """Say who or what judges: "10,000 newly drawn persons", "9,999 new draws for 3 persons"."""
    count = f"{fresh.count:,}"
    several = "" if fresh.count == 1 else "s"
    if fresh.kind == "persons":
        return f"{count} newly drawn person{several}"
    whom = ""
    if fresh.persons == 1:
        whom = " for this person"
    elif fresh.persons:
        whom = f" for these {fresh.persons:,} persons"
    return f"{count} new draw{several}{whom}"


def judgement_words(fresh: FreshRecord, judged: VerifiedRecord, serve: float) -> str:
    """Say whom a choice serves: "only 93 % of 10,000 new draws (...), not the 95 % asked for"."""
    is_short = not is_enough(judged, serve) and not is_undecided(judged, serve)
    only = "only " if is_short else ""
    return f"{only}{share_words(fresh, judged, serve)}{verdict(fresh, judged, serve)}"


def suits_words(fresh: FreshRecord, judged: VerifiedRecord, serve: float) -> str:
    """Say in how many of 100 suits a choice works: "98 of 100 suits so built"."""
    suits = "suits so built"
    if judged.value >= 1.0:
        return f"all of {fresh.count:,} {suits}"
    of_hundred = round(100.0 * judged.value)
    asked = round(100.0 * serve)
    is_short = not is_enough(judged, serve)
    if is_short and of_hundred >= asked:
        of_hundred = asked - 1
    count = str(min(of_hundred, 99)) if of_hundred else "fewer than 1"
    words = f"{count} of 100 {suits}"
    if is_undecided(judged, serve):
        return f"{words}, too close to {asked} to tell from {fresh.count:,}"
    return f"only {words}, not in the {asked} asked for" if is_short else words


def share_words(fresh: FreshRecord, judged: VerifiedRecord, serve: float) -> str:
    """Say a share with its interval: "94.7 % of 10,000 newly drawn persons (94.2 to 95.2 %)".

    Args:
        fresh: The sample.
        judged: Its judgement.
        serve: Share that is enough: one that is less is never rounded to it.
    """
    value = judged.value
    low, high = judged.interval_95
    return say.share_of(members(fresh), value, low, high, _share(value, serve))


def is_enough(judged: VerifiedRecord, serve: float) -> bool:
    """Return True if the share is at least `serve`, apart from rounding."""
    return judged.value >= serve - _SHARE_ROUNDING


def is_undecided(judged: VerifiedRecord, serve: float) -> bool:
    """Return True if the interval of the share holds the one asked for."""
    low, high = judged.interval_95
    return low <= serve <= high


def verdict(fresh: FreshRecord, judged: VerifiedRecord, serve: float) -> str:
    """Say what the share means for the one asked for, after `share_words`; empty if it is more."""
    enough = say.percent(serve)
    if is_undecided(judged, serve):
        return f", too close to {enough} to tell from {fresh.count:,}"
    return "" if is_enough(judged, serve) else f", not the {enough} asked for"


def _share(value: float, serve: float) -> str:
    """Say a share with as many digits as tell it from the one asked for."""
    text = say.percent(value)
    for digits in range(4, _MOST_SHARE_DIGITS + 1):
        if text != say.percent(serve) or abs(value - serve) < _SHARE_ROUNDING:
            break
        text = f"{say.number(100.0 * value, digits)} %"
    return text


# --- Persons and draws ----------------------------------------------------------------------------


def reason_words(
    question: QuestionRecord, choice: Mapping[str, Any], limits: list[str], under: list[Values]
) -> str:
    """Say what happens to those who are not served, by limit, and under which condition.

    Args:
        question: The question.
        choice: Row of the choice in the table.
        limits: Limits that are broken.
        under: For each limit the values of the condition.
    """
    words = []
    for limit, condition in zip(limits, under, strict=True):
        inside = condition_of_group(question, condition)
        is_broken = broken(question, limit, choice, condition)
        words.append(f"{is_broken} ({inside})" if inside else is_broken)
    return " and ".join(words)


def input_words(key: str) -> str:
    """Say the name of an input that a Sobol index is of."""
    if key not in keys():
        return key
    name = say.column(keys()[key].quantity.name)
    side = say.side_of(key)
    return f"{name} of the {side}" if side else name


def population_share(population: PopulationRecord) -> str:
    """Say the share that the pretension serves, of whom, and its interval for everyone.

    "all 1,000 persons (at least 99.6 %)", "96.9 % of this person's 256 draws (94 to 98.5 %)",
    "90 % of 192 pairs of 3 persons and 64 draws". Pairs of several persons are not
    independent samples, so that their share has no interval.
    """
    count = population.count
    served = population.served
    kind = population.kind
    persons = population.counts.get("person", 0)
    draws = population.counts.get("draw", 0)
    whom = everyone(population.counts, count, kind)
    if persons > 1 and draws > 1:
        return f"all {whom}" if served >= 1.0 else f"{say.percent(served)} of {whom}"
    if persons == 1 and draws > 1:
        share = say.sampled_share(served, count, "draw")
        of_whom = f"of {whom}" if share.startswith("all") else whom
        return share.replace(f"{count:,} draws", of_whom)
    return say.sampled_share(served, count, kind.removesuffix("s"), population.effective_count)


def need_words(question: QuestionRecord, population: PopulationRecord, reason: ReasonRecord) -> str:
    """Say what those need who are not served, and why.

    "0.6 % of the draws need a lower pretension, because the elbow becomes unstable".
    """
    kind = population.kind
    is_one = population.count == 1
    whom = f"{say.percent(reason.share)} of the {kind}"
    if is_one:
        whom = f"this {kind.removesuffix('s')}"
    noun, _ = say.setting_words(question.read)
    if reason.needs == NEITHER:
        return f"no {noun} serves {whom}: {reason.text}"
    verb = "needs" if is_one else "need"
    return f"{whom} {verb} {_NEEDS[reason.needs]} {noun}, because {reason.text}"
