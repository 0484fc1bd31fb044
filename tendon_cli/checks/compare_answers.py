"""Comparison of two answers: the choice that each names first, or one that is asked for.

All numbers stand in the records and tables of the answers, but for shares of a fresh sample that
both have in common: these are computed again, member by member.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from tendon_cli.answer_record import (
    AnswerRecord,
    ChoiceRecord,
    as_answer,
    as_read,
    named_first,
    row_as_read,
    value_of,
)
from tendon_cli.answers import phrases
from tendon_cli.answers.answer import Answer
from tendon_cli.answers.choice_rows import choice_in_row, same_choice
from tendon_cli.answers.paired import (
    PairedShares,
    UnservedMember,
    paired_shares,
    unpaired_interval,
    why_other_draws,
)
from tendon_cli.answers.text import first_words, no_window_words
from tendon_cli.answers.text_bench import bench_words, suit_words
from tendon_cli.checks.compare_runs import MOST_NAMES, ROUNDING, better_of, judge
from tendon_cli.checks.comparison_record import (
    BindingLimits,
    Compared,
    ComparedResult,
    Judgement,
    Move,
    Number,
    Unserved,
    Value,
)
from tendon_cli.quantities import AS_READ, QUANTITIES, in_unit_of_reading
from tendon_cli.studies.axis_words import parameter
from tendon_cli.studies.contents import keys
from tendon_cli.studies.study_differences import Difference
from tendon_cli.tables.schema import as_numpy

Member: TypeAlias = tuple[Any, ...]
"""A person or a draw of an answer's own sample: its name, then all that is known of it."""
_MOST_REASONS = 3
"""Most persons or draws for whom it is said which limit loses them."""
_LARGEST_OF_SAMPLE = (
    "The values for tension, strap, springs and motor are the largest in each answer's own sample "
    "and have no interval."
)


LABELS = {
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


@dataclass(frozen=True, eq=False)
class ComparedAnswer:
    """An answer with the choice of it that is compared."""

    answer: Answer
    record: AnswerRecord
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
        best = self.record.best
        return best is not None and best == self.choice

    @property
    def axes(self) -> dict[str, Value]:
        """Values of the choice by the columns of its axes."""
        if self.choice is None:
            return {}
        columns = [axis.column for axis in self.record.question.choices]
        return {column: value_of(self.choice, column) for column in columns}

    def value(self, name: str) -> float | None:
        """Return the value of a column of the choice; None if it has none."""
        value = None if self.choice is None else value_of(self.choice, name)
        return None if value is None else float(value)


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
    paired = _paired(pair, notes, labels[1])
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


def _as_shown(record: AnswerRecord, choice: ChoiceRecord | None) -> ChoiceRecord | None:
    """Return a choice with pretensions as the gauge of its answer shows them."""
    is_own_f0 = record.question.shows_own_f0
    return row_as_read(choice) if choice is not None and is_own_f0 else choice


def _with_choices(answers: tuple[Answer, Answer], row: int | None) -> Pair:
    """Return answers with the choice of each that is compared."""
    records = [as_answer(answer.record) for answer in answers]
    first, second = (as_read(record) for record in records)
    if row is None:
        choices = (named_first(first), named_first(second))
    else:
        chosen = choice_in_row(answers[0], row)
        other = same_choice(answers[1], chosen, first.question.choices)
        choices = (_as_shown(records[0], chosen), _as_shown(records[1], other))
    return (
        ComparedAnswer(answers[0], first, choices[0]),
        ComparedAnswer(answers[1], second, choices[1]),
    )


def _sentence(one: ComparedAnswer) -> str:
    """Say what an answer says of the choice that is compared."""
    record = one.record
    best = record.best
    if best is not None and one.is_named_first:
        return first_words(record, best)
    if one.choice is None or best is None:
        return no_window_words(record)
    suit = suit_words(record.question, one.choice)
    return f"Choice {one.choice.choice}: {suit.words}, set to {bench_words(record, one.choice)}."


def _binding(one: ComparedAnswer) -> BindingLimits | None:
    """Return the limits at both ends of the window, or of what comes nearest to one."""
    if one.choice is None:
        return None
    question = one.record.question
    judged = one.choice.served_verified
    return BindingLimits(
        lower=one.choice.from_by,
        upper=one.choice.to_by,
        words=[
            phrases.lower_words(question, one.choice),
            phrases.upper_words(question, one.choice),
        ],
        fresh=None if judged is None else (judged.from_, judged.to),
    )


# --- Quantities -----------------------------------------------------------------------------------


def _numbers(pair: Pair, paired: PairedShares | None) -> Iterator[Number]:
    """Yield the quantities of both choices."""
    first, second = pair
    choices = [
        None if one.choice is None else phrases.choice_words(one.record.question, one.choice)
        for one in pair
    ]
    if any(choices):
        yield _number("choice", "choice", None, choices[0], choices[1])
    does = [one.choice is not None and one.choice.feasible for one in pair]
    yield _number("feasible", "keeps the limits for as many as asked", None, does[0], does[1])
    where = first.axes if first.axes == second.axes else {}
    reads = sorted({one.record.question.read for one in pair})
    labels = dict(LABELS)
    if reads != ["pretension"]:
        labels["pretension"] = f"to set: {' or '.join(reads)}"
    for name, label in labels.items():
        a, b = (_value(name, one) for one in pair)
        if a is None and b is None:
            continue
        units = sorted({_unit(name, one) for one in pair})
        is_of_gauge = name.startswith("pretension")
        is_comparable = len(units) == 1 and (len(reads) == 1 or not is_of_gauge)
        yield _number(
            name,
            label,
            " or ".join(units),
            a,
            b,
            _judge(name, pair) if is_comparable else None,
            is_comparable=is_comparable,
            where=where,
        )
    strap = _strap(pair)
    if strap is not None:
        yield strap
    if any(one.record.population is not None for one in pair):
        yield _served(pair, paired)


def _number(
    name: str,
    label: str,
    unit: str | None,
    a: Any,
    b: Any,
    verdict: Judgement | None = None,
    *,
    is_comparable: bool = True,
    **more: Any,
) -> Number:
    """Return a quantity of both choices with its change; words and truths have no unit."""
    change = 0.0 if a == b else math.inf
    most = None
    if unit is not None and a is not None and b is not None:
        most = abs(b - a)
        if a != b:
            change = most / max(abs(a), abs(b))
    if not is_comparable:
        change = math.inf
    rows = int(a != b)
    return Number(name, label, unit, a, b, verdict, change=change, most=most, rows=rows, **more)


def _value(name: str, one: ComparedAnswer) -> float | None:
    """Return a number of the choice; None if it has none, such as an end of an empty window."""
    if name in ("pretension_from", "pretension_to") and not one.has_window:
        return None
    return one.value(name)


def _unit(name: str, one: ComparedAnswer) -> str:
    """Return the SI unit of a column of an answer; pretensions are in the unit that is read."""
    quantity = QUANTITIES[name]
    if name in AS_READ:
        quantity = in_unit_of_reading(quantity, one.record.question.read)
    return quantity.unit


def _judge(name: str, pair: Pair) -> Judgement | None:
    """Judge a column of the second answer beside that of the first; None if neither is better."""
    first, second = pair
    better = better_of(name)
    if not better:
        return None
    if name == "tolerance_length":
        return _judge_tolerance(first, second)
    before = first.value(name)
    now = second.value(name)
    if before is None or now is None or not (first.has_window and second.has_window):
        return None  # at the pretension of a choice without a window nothing is worth comparing
    if better < 0:
        before = abs(before)
        now = abs(now)
    return judge(better, before, now)


def _judge_tolerance(first: ComparedAnswer, second: ComparedAnswer) -> Judgement:
    """Judge how far the setting of the second answer may be off beside that of the first.

    Where both answers have a window of a fresh sample, too, a difference counts if both samples
    show it.
    """
    own = judge(1, _length(first), _length(second))
    before = _fresh_ratio(first)
    now = _fresh_ratio(second)
    if before is None or now is None or own == "no difference":
        return own
    fresh = judge(1, _length(first) * before, _length(second) * now)
    return own if fresh == own else "no difference"


def _length(one: ComparedAnswer) -> float:
    """Return half the window as a length of both tendons, m; 0 without a window."""
    if not one.has_window or one.choice is None:
        return 0.0
    length = one.choice.tolerance_length
    return math.inf if length is None else length


def _fresh_ratio(one: ComparedAnswer) -> float | None:
    """Return the width of the fresh sample's window over that of the own; None without either."""
    if not one.has_window or one.choice is None:
        return None
    judged = one.choice.served_verified
    low = one.choice.pretension_from
    high = one.choice.pretension_to
    if judged is None or low is None or high is None or high == low:
        return None
    if judged.from_ is None or judged.to is None:
        return None
    return (judged.to - judged.from_) / (high - low)


def _strap(pair: Pair) -> Number | None:
    """Return the least width of the strap, if both answers name their choice first and have one."""
    widths = []
    for one in pair:
        parts = one.record.parts_needed
        if not one.is_named_first or parts is None or parts.strap is None:
            return None
        widths.append(parts.strap.least_width)
    a, b = widths
    return _number("contact_width", "strap width, at least", "m", a, b, judge(-1, a, b))


# --- Whom they serve ------------------------------------------------------------------------------


def _paired(pair: Pair, notes: list[str], label: str) -> PairedShares | None:
    """Return the shares of two answers among the same fresh members; None, and a note, if not.

    Answers without persons and draws have nothing to pair, and need no note.
    """
    first, second = pair
    if first.record.population is None or second.record.population is None:
        return None
    if first.choice is None or second.choice is None:
        return None
    studies = (first.answer.study, second.answer.study)
    paired = paired_shares(studies, (first.choice, second.choice))
    if isinstance(paired, str):
        notes.append(f"{label}: the shares cannot be compared one by one, because {paired}.")
        return None
    of_fresh = "newly drawn persons" if paired.kind == "persons" else "new draws"
    notes.append(
        f"{label}: the same {paired.members:,} {of_fresh} judge both suits, computed again for "
        "this comparison; all else comes from the records."
    )
    return paired


def _served(pair: Pair, paired: PairedShares | None) -> Number:
    """Return the share that each answer serves, with the interval of the difference."""
    first, second = pair
    a = _share(first)
    b = _share(second)
    spans = (_span(first), _span(second))
    interval = None
    if paired is not None:
        a = paired.first
        b = paired.second
        spans = (paired.of_first, paired.of_second)
        interval = paired.interval
    is_comparable = _counted(first) == _counted(second)  # a share of draws is none of persons
    has_both = a is not None and b is not None and None not in spans
    if paired is None and is_comparable and has_both:
        interval = unpaired_interval(a or 0.0, spans[0] or (), b or 0.0, spans[1] or ())
    verdict: Judgement | None = None
    if interval is not None:
        low, high = interval
        verdict = "no difference"
        if low > 0.0 or high < 0.0:
            verdict = "better" if low > 0.0 else "worse"
    elif is_comparable and a is not None and b is not None:
        verdict = judge(1, a, b)
    return _number(
        "served",
        "share served",
        "1",
        a,
        b,
        verdict,
        is_comparable=is_comparable,
        interval=interval,
        spans=spans,
    )


def _counted(one: ComparedAnswer) -> str:
    """Return the noun for what an answer counts: "persons", "draws", "conditions"."""
    fresh = one.record.verified_by
    return one.record.question.counted if fresh is None else fresh.kind


def _share(one: ComparedAnswer) -> float | None:
    """Return the share that a choice serves: of the fresh sample if there is one."""
    if one.choice is None:
        return None
    judged = one.choice.served_verified
    return one.choice.served_at if judged is None else judged.value


def _span(one: ComparedAnswer) -> Sequence[float] | None:
    """Return the 95 % interval of the share that a choice serves; None without one."""
    if one.choice is None:
        return None
    judged = one.choice.served_verified
    if judged is not None:
        return judged.interval_95
    population = one.record.population
    is_of_choice = population is not None and population.choice == one.choice.choice
    return population.interval_95 if population is not None and is_of_choice else None


def _moves(
    pair: Pair, paired: PairedShares | None, differences: Sequence[Difference]
) -> tuple[Move | None, Move | None]:
    """Return whom the second answer serves and the first does not, and the other way round."""
    before, now = (_served_by_name(one) for one in pair)
    if before is None or now is None or not _are_the_same(before, now, pair, differences):
        before = {}
        now = {}
    if not before and paired is None:
        return None, None
    gained = [member for member in before if now[member] and not before[member]]
    lost = [member for member in before if before[member] and not now[member]]
    moves = []
    for one, members, is_gain in ((pair[0], gained, True), (pair[1], lost, False)):
        names = [str(member[0]) for member in members]
        kind = _members(one)
        move = Move(
            kind=kind,
            count=len(names),
            of=len(before),
            share=len(names) / (len(before) or 1),
            names=names[:MOST_NAMES],
            named=len(names),
            named_kind=kind,
            named_of=len(before),
        )
        of_fresh = None
        if paired is not None:
            of_fresh = paired.gained_one if is_gain else paired.lost_one
            move = replace(
                move,
                kind=paired.kind,
                count=paired.gained_members if is_gain else paired.lost_members,
                of=paired.members,
                share=paired.gained if is_gain else paired.lost,
                named_kind=kind if before else paired.kind,
            )
        moves.append(replace(move, why=[*_why_unserved(one, names, of_fresh)]))
    return moves[0], moves[1]


def _are_the_same(
    before: Mapping[Member, bool],
    now: Mapping[Member, bool],
    pair: Pair,
    differences: Sequence[Difference],
) -> bool:
    """Return True if members of the same name are the same persons or draws in both answers."""
    question = pair[0].record.question
    if before.keys() != now.keys():
        return False
    if "draw" in question.counts and why_other_draws(*(one.answer.study for one in pair)):
        return False
    drawn = tuple(f"table.{axis.column}." for axis in question.conditions if axis.drawn)
    return not any(difference.key.startswith(drawn) for difference in differences)


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


def _members(one: ComparedAnswer) -> str:
    """Return "persons" or "draws", the table of an answer's own sample.

    It is empty if there is no such table, or if it is not of the choice that is compared.
    """
    population = one.record.population
    if population is None or one.choice is None or population.choice != one.choice.choice:
        return ""
    known = (*one.answer.tables, *one.answer.table_files)
    return next((name for name in ("persons", "draws") if {name, f"{name}.parquet"} & {*known}), "")


def _served_by_name(one: ComparedAnswer) -> dict[Member, bool] | None:
    """Return for each person or draw of an answer's own sample whether it is served.

    A person of several draws is served if enough of them are. None without a table.
    """
    table = _members(one)
    population = one.record.population
    if not table or population is None:
        return None
    rows = one.answer.table(table)
    enough = one.record.serve if population.kind == "pairs" else 1.0
    served = as_numpy(rows.column("served")) >= enough - ROUNDING
    about = [
        rows.column(name).to_pylist()
        for name in rows.column_names
        if name not in _RESULTS_OF_MEMBERS and not name.startswith("set_")
    ]
    return dict(zip(zip(*about, strict=True), served.tolist(), strict=True))


def _why_unserved(
    one: ComparedAnswer, names: Sequence[str], of_fresh: UnservedMember | None
) -> Iterator[Unserved]:
    """Yield the limits by which an answer loses persons or draws that the other one serves.

    Args:
        one: The answer that does not serve them.
        names: Names of such members of its own sample.
        of_fresh: Such a member of the fresh sample of both answers, if none has a name.
    """
    if names:
        table = one.answer.table(_members(one))
        places = {str(name): row for row, name in enumerate(table.column(0).to_pylist())}
        set_to = one.value("pretension") or 0.0
        for name in names[:_MOST_REASONS]:
            (row,) = table.slice(places[name], 1).to_pylist()
            is_low = row["pretension_from"] is None or set_to < row["pretension_from"]
            yield Unserved(name, row["from_by" if is_low else "to_by"] or "")
    elif of_fresh is not None:
        # Scales of a person's anchors have no key, and are not among the numbers of a study.
        stated = {key: value for key, value in of_fresh.numbers.items() if key in keys()}
        numbers = ", ".join(parameter(key, value) for key, value in stated.items())
        yield Unserved(numbers, of_fresh.limit)
