"""Comparison of two answers: the choice that each names first, or one that is asked for.

All numbers stand in the records and tables of the answers, but for shares of a fresh sample that
both have in common: these are computed again, member by member.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from tendon_cli.answers import phrases
from tendon_cli.answers.answer import Answer
from tendon_cli.answers.choice_rows import choice_in_row, same_choice
from tendon_cli.answers.paired import (
    PairedShares,
    paired_shares,
    unpaired_interval,
    why_other_draws,
)
from tendon_cli.answers.text import first_words, no_window_words
from tendon_cli.answers.text_bench import bench_words, suit_words
from tendon_cli.checks.compared import (
    MOST_NAMES,
    ROUNDING,
    BindingLimits,
    Compared,
    ComparedResult,
    Judgement,
    Move,
    Number,
    Unserved,
    Value,
    better_of,
    difference,
    judge,
)
from tendon_cli.engine.study_differences import Difference
from tendon_cli.quantities import AS_READ, QUANTITIES, in_unit_of_reading
from tendon_cli.studies.axis_words import parameter
from tendon_cli.studies.contents import keys
from tendon_cli.verbs.answer_record import (
    AnswerRecord,
    ChoiceRecord,
    as_read,
    named_first,
    row_as_read,
)

Members: TypeAlias = dict[tuple[Any, ...], dict[str, Any]]
"""Rows of an answer's own sample, persons or draws: by the name, then all that is known of each."""
_MOST_REASONS = 3
"""Most persons or draws for whom it is said which limit loses them."""
_LARGEST_OF_SAMPLE = (
    "The values for tension, strap, springs and motor are the largest in each answer's own sample "
    "and have no interval."
)
_COLUMNS = {
    "set_flexor_tension": "to set in the flexor",
    "set_extensor_tension": "to set in the extensor",
    "pretension": "pretension to set",
    "pretension_from": "window from",
    "pretension_to": "window to",
    "tolerance_length": "half of the window",
    "max_tension": "largest tension",
    "max_contact_pressure": "strap pressure",
    "max_spring_extension": "spring travel",
    "peak_motor_torque": "motor torque",
    "min_elbow_stiffness": "least elbow stiffness",
}
"""Columns of choices that are compared, with their meaning: those that a gauge shows first."""
_RESULTS_OF_MEMBERS = (
    "pretension_from",
    "pretension_to",
    "from_by",
    "to_by",
    "from_condition",
    "to_condition",
    "served",
)
"""Columns of persons or draws that depend on the suit, besides those that say what to set."""


@dataclass(frozen=True, eq=False)
class ComparedAnswer:
    """An answer with the choice of it that is compared."""

    answer: Answer
    record: AnswerRecord
    """Its record, as the gauge of the answer shows pretensions."""
    choice: ChoiceRecord | None
    """The choice; None if the answer names none."""

    @property
    def has_window(self) -> bool:
        """True if the choice has a window."""
        window = None if self.choice is None else phrases.window_of(self.choice)
        return window is not None and window[0] <= window[1]

    @property
    def is_named_first(self) -> bool:
        """True if the choice is the one that the answer names first."""
        return self.choice is not None and self.choice == self.record.best

    @property
    def axes(self) -> dict[str, Value]:
        """Values of the choice by the columns of its axes."""
        if self.choice is None:
            return {}
        columns = [axis.column for axis in self.record.question.choices]
        return {column: self.choice.columns[column] for column in columns}

    @cached_property
    def numbers(self) -> dict[str, float | None]:
        """Numbers of the choice by their columns; None where it has none."""
        numbers: dict[str, float | None] = dict.fromkeys((*_COLUMNS, "contact_width"))
        if self.choice is None:
            return numbers
        numbers |= {name: getattr(self.choice, name) for name in _COLUMNS}
        if not self.has_window:
            numbers |= {"pretension_from": None, "pretension_to": None}
        parts = self.record.parts_needed
        if self.is_named_first and parts is not None and parts.strap is not None:
            numbers["contact_width"] = parts.strap.least_width
        return numbers

    @cached_property
    def members(self) -> tuple[str, Members]:
        """Return "persons" or "draws", and the rows of the answer's own sample.

        There are none without such a table, or if it is not of the choice that is compared.
        """
        population = self.record.population
        if population is None or self.choice is None or population.choice != self.choice.choice:
            return "", {}
        known = {*self.answer.tables, *self.answer.table_files}
        for kind in ("persons", "draws"):
            if {kind, f"{kind}.parquet"} & known:
                rows = self.answer.table(kind).to_pylist()
                return kind, {_about(row): row for row in rows}
        return "", {}

    def serves(self, row: Mapping[str, Any]) -> bool:
        """Return True if a row is of a member that is served: of several draws in enough."""
        population = self.record.population
        is_of_pairs = population is not None and population.kind == "pairs"
        return bool(row["served"] >= (self.record.serve if is_of_pairs else 1.0) - ROUNDING)


Pair: TypeAlias = tuple[ComparedAnswer, ComparedAnswer]


def compare_answers(
    answers: tuple[Answer, Answer],
    labels: tuple[str, str],
    differences: list[Difference],
    choice: int | None,
) -> Compared:
    """Compare an answer with the first one.

    Args:
        answers: The answers.
        labels: Name of each for texts.
        differences: Keys in which their studies differ.
        choice: Row of a choice of the first one, compared with the same choice of the second;
            None for the choices that the answers name first.

    Raises:
        UsageError: An answer has no such choice.
        InputError: A table is damaged.
    """
    pair = _with_choices(answers, choice)
    notes: list[str] = []
    paired = _paired(pair)
    if isinstance(paired, str):
        notes.append(f"{labels[1]}: the shares cannot be compared one by one, because {paired}.")
        paired = None
    elif paired is not None:
        of_fresh = "newly drawn persons" if paired.kind == "persons" else "new draws"
        notes.append(
            f"{labels[1]}: the same {paired.members:,} {of_fresh} judge both suits, computed again "
            "for this comparison; all else comes from the records."
        )
    for one, label in zip(pair, labels, strict=True):
        if one.choice is not None and not one.has_window:
            notes.append(
                f"{label} has no window: its numbers are those of the choice that comes closest to "
                "one, at the pretension that serves most."
            )
    if any(one.record.population is not None for one in pair):
        notes.append(_LARGEST_OF_SAMPLE)
    first, second = (
        ComparedResult.of(one.answer, label, _sentence(one), one.record.question.unit)
        for one, label in zip(pair, labels, strict=True)
    )
    gained, lost = _moves(pair, paired, differences)
    return Compared(
        first,
        second,
        differences,
        [*_numbers(pair, paired)],
        binds=(_binding(pair[0]), _binding(pair[1])),
        gained=gained,
        lost=lost,
        paired=paired is not None,
        compared="the choice named first, its window, the share it serves and what to set",
        notes=notes,
    )


def _with_choices(answers: tuple[Answer, Answer], row: int | None) -> Pair:
    """Return answers with the choice of each that is compared."""
    choices = [named_first(answer.answer) for answer in answers]
    if row is not None:
        chosen = choice_in_row(answers[0], row)
        axes = answers[0].answer.question.choices
        choices = [chosen, same_choice(answers[1], chosen, axes)]
    compared = []
    for answer, choice in zip(answers, choices, strict=True):
        record = answer.answer
        if choice is not None and record.question.shows_own_f0:
            choice = row_as_read(choice)  # noqa: PLW2901 - the same choice
        compared.append(ComparedAnswer(answer, as_read(record), choice))
    return compared[0], compared[1]


def _sentence(one: ComparedAnswer) -> str:
    """Say what an answer says of the choice that is compared."""
    record = one.record
    if record.best is not None and one.is_named_first:
        return first_words(record, record.best)
    if one.choice is None or record.best is None:
        return no_window_words(record)
    suit = suit_words(record.question, one.choice)
    return f"Choice {one.choice.choice}: {suit.words}, set to {bench_words(record, one.choice)}."


def _binding(one: ComparedAnswer) -> BindingLimits | None:
    """Return the limits at both ends of the window, or of what comes nearest to one."""
    choice = one.choice
    if choice is None:
        return None
    question = one.record.question
    judged = choice.served_verified
    return BindingLimits(
        lower=choice.from_by,
        upper=choice.to_by,
        words=[phrases.lower_words(question, choice), phrases.upper_words(question, choice)],
        fresh=None if judged is None else (judged.from_, judged.to),
    )


# --- Quantities -----------------------------------------------------------------------------------


def _numbers(pair: Pair, paired: PairedShares | None) -> Iterator[Number]:
    """Yield the quantities of both choices."""
    words: list[Value] = [
        None if one.choice is None else phrases.choice_words(one.record.question, one.choice)
        for one in pair
    ]
    if any(words):
        yield _number("choice", "choice", None, words)
    does: list[Value] = [one.choice is not None and one.choice.feasible for one in pair]
    yield _number("feasible", "keeps the limits for as many as asked", None, does)
    where = pair[0].axes if pair[0].axes == pair[1].axes else {}
    reads = sorted({one.record.question.read for one in pair})
    labels = {**_COLUMNS, "contact_width": "strap width, at least"}
    if reads != ["pretension"]:
        labels["pretension"] = f"to set: {' or '.join(reads)}"
    for name, label in labels.items():
        values: list[Value] = [one.numbers[name] for one in pair]
        has_neither = values == [None, None]
        if has_neither or (name == "contact_width" and None in values):
            continue
        units = sorted({_unit(name, one.record.question.read) for one in pair})
        is_of_gauge = name.startswith("pretension")
        is_comparable = len(units) == 1 and (len(reads) == 1 or not is_of_gauge)
        changes: dict[str, Any] = {} if is_comparable else {"change": math.inf}
        verdict = _judge(name, pair) if is_comparable else None
        unit = " or ".join(units)
        place = {} if name == "contact_width" else where
        yield _number(name, label, unit, values, verdict=verdict, where=place, **changes)
    if any(one.record.population is not None for one in pair):
        yield _served(pair, paired)


def _number(
    name: str, label: str, unit: str | None, values: Sequence[Value], **more: Any
) -> Number:
    """Return a quantity of both choices with its change; words and truths have no unit."""
    is_flag = unit is None
    first, second = (np.array([value], object if is_flag else np.float64) for value in values)
    size = difference(first, second, is_flag=is_flag)
    changes = Number.changes(size, first, second, is_flag=is_flag)
    return Number(name, label, unit, values[0], values[1], **(changes | more))


def _unit(name: str, read: str) -> str:
    """Return the SI unit of a column of an answer; pretensions are in the unit that is read."""
    quantity = QUANTITIES[name]
    return (in_unit_of_reading(quantity, read) if name in AS_READ else quantity).unit


def _judge(name: str, pair: Pair) -> Judgement | None:
    """Judge a column of the second answer beside that of the first; None if neither is better."""
    if name == "tolerance_length":
        return _judge_tolerance(pair)
    if not all(one.has_window for one in pair):
        return None  # at the pretension of a choice without a window nothing is worth comparing
    better = better_of(name)
    before, now = (one.numbers[name] for one in pair)
    if better < 0 and before is not None and now is not None:
        before = abs(before)
        now = abs(now)
    return judge(better, before, now)


def _judge_tolerance(pair: Pair) -> Judgement | None:
    """Judge how far the setting of the second answer may be off beside that of the first.

    Where both answers have a window of a fresh sample, too, a difference counts if both samples
    show it.
    """
    (before, fresh_before), (now, fresh_now) = (_lengths(one) for one in pair)
    own = judge(1, before, now)
    if fresh_before is None or fresh_now is None or own == "no difference":
        return own
    return own if judge(1, fresh_before, fresh_now) == own else "no difference"


def _lengths(one: ComparedAnswer) -> tuple[float, float | None]:
    """Return half the window as a length of both tendons, m, of the own and of the fresh sample."""
    choice = one.choice
    if choice is None or not one.has_window:
        return 0.0, None
    own = math.inf if choice.tolerance_length is None else choice.tolerance_length
    low = choice.pretension_from
    high = choice.pretension_to
    judged = choice.served_verified
    if judged is None or judged.from_ is None or judged.to is None:
        return own, None
    if low is None or high is None or high == low:
        return own, None
    return own, own * (judged.to - judged.from_) / (high - low)


# --- Whom they serve ------------------------------------------------------------------------------


def _paired(pair: Pair) -> PairedShares | str | None:
    """Return the shares of two answers among the same fresh members, or why there are none.

    Answers without persons and draws have nothing to pair, and need no reason.
    """
    first, second = pair
    if any(one.record.population is None for one in pair):
        return None
    if first.choice is None or second.choice is None:
        return None
    return paired_shares((first.answer.study, second.answer.study), (first.choice, second.choice))


def _served(pair: Pair, paired: PairedShares | None) -> Number:
    """Return the share that each answer serves, with the interval of the difference."""
    (a, of_a), (b, of_b) = (_share(one) for one in pair)
    interval = None
    if paired is not None:
        a = paired.first
        b = paired.second
        of_a = paired.of_first
        of_b = paired.of_second
        interval = paired.interval
    fresh = [one.record.verified_by for one in pair]
    counted = {
        one.record.question.counted if judged is None else judged.kind
        for one, judged in zip(pair, fresh, strict=True)
    }
    is_comparable = len(counted) == 1  # a share of draws is none of persons
    has_both = a is not None and b is not None
    if interval is None and is_comparable and has_both and of_a is not None and of_b is not None:
        interval = unpaired_interval(a or 0.0, of_a, b or 0.0, of_b)
    verdict: Judgement | None = None
    if interval is not None:
        low, high = interval
        verdict = "no difference"
        if low > 0.0 or high < 0.0:
            verdict = "better" if low > 0.0 else "worse"
    elif is_comparable:
        verdict = judge(1, a, b)
    changes: dict[str, Any] = {} if is_comparable else {"change": math.inf}
    return _number(
        "served",
        "share served",
        "1",
        (a, b),
        verdict=verdict,
        interval=interval,
        spans=(of_a, of_b),
        **changes,
    )


def _share(one: ComparedAnswer) -> tuple[float | None, Sequence[float] | None]:
    """Return the share that a choice serves, of a fresh sample if there is one, and its interval.

    The interval is of 95 %; None without one.
    """
    choice = one.choice
    if choice is None:
        return None, None
    if choice.served_verified is not None:
        return choice.served_verified.value, choice.served_verified.interval_95
    population = one.record.population
    is_of_choice = population is not None and population.choice == choice.choice
    span = population.interval_95 if population is not None and is_of_choice else None
    return choice.served_at, span


def _moves(
    pair: Pair, paired: PairedShares | None, differences: Sequence[Difference]
) -> tuple[Move | None, Move | None]:
    """Return whom the second answer serves and the first does not, and the other way round."""
    is_same = _are_the_same(pair, differences)
    if not is_same and paired is None:
        return None, None
    moves = []
    for place in (0, 1):
        loser = pair[place]
        other = pair[1 - place]
        kind, rows = loser.members if is_same else ("", {})
        missed = [
            row
            for member, row in rows.items()
            if other.serves(other.members[1][member]) and not loser.serves(row)
        ]
        why = [Unserved(str(_about(row)[0]), _why(loser, row)) for row in missed[:MOST_NAMES]]
        move = Move.named_ones(kind, len(missed), len(rows), why)
        move = replace(move, why=why[:_MOST_REASONS])
        if paired is not None:
            fresh = paired.moved[place]
            move = replace(
                move,
                kind=paired.kind,
                count=fresh.members,
                of=paired.members,
                share=fresh.share,
                named_kind=kind or paired.kind,
            )
            if not why and fresh.farthest is not None:
                # Scales of a person's anchors have no key, and are not among a study's numbers.
                stated = [one for one in fresh.farthest.numbers.items() if one[0] in keys()]
                numbers = ", ".join(parameter(key, value) for key, value in stated)
                move = replace(move, why=[Unserved(numbers, fresh.farthest.limit)])
        moves.append(move)
    return moves[0], moves[1]


def _about(row: Mapping[str, Any]) -> tuple[Any, ...]:
    """Return the name of a person or draw, and all that is known of it, whatever the suit is."""
    return tuple(
        value
        for name, value in row.items()
        if name not in _RESULTS_OF_MEMBERS and not name.startswith("set_")
    )


def _why(one: ComparedAnswer, row: Mapping[str, Any]) -> str:
    """Return the limit by which an answer does not serve a member of its own sample."""
    low = row["pretension_from"]
    is_low = low is None or (one.numbers["pretension"] or 0.0) < low
    return row["from_by" if is_low else "to_by"] or ""


def _are_the_same(pair: Pair, differences: Sequence[Difference]) -> bool:
    """Return True if members of the same name are the same persons or draws in both answers."""
    (_, before), (_, now) = (one.members for one in pair)
    question = pair[0].record.question
    if not before or before.keys() != now.keys():
        return False
    if "draw" in question.counts and why_other_draws(*(one.answer.study for one in pair)):
        return False
    drawn = tuple(f"table.{axis.column}." for axis in question.conditions if axis.drawn)
    return not any(found.key.startswith(drawn) for found in differences)
