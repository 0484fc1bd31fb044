"""Comparison of answers: the choice that each names first, or one that is asked for.

All numbers stand in the records and tables of the answers, but for shares of a fresh sample that
both have in common: these are computed again, member by member.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

from tendon_cli.answer_record import (
    AnswerRecord,
    ChoiceRecord,
    as_answer,
    named_first,
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
from tendon_cli.answers.text import no_window_words
from tendon_cli.answers.text_first import bench_words, first_words, suit_words
from tendon_cli.checks.comparison_record import (
    BesideFirst,
    BindRecord,
    ComparedResult,
    ComparisonRecord,
    Judgement,
    MoveRecord,
    QuantityRecord,
    UnservedRecord,
)
from tendon_cli.checks.study_differences import study_differences
from tendon_cli.checks.unserved_member import unserved_afresh, unserved_by_name
from tendon_cli.quantities import AS_READ, QUANTITIES, in_unit_of_reading
from tendon_cli.tables.schema import as_numpy
from tendon_cli.units import shorten

ROUNDING = 1e-9
"""Share of a number by which two numbers may differ by rounding."""
Member: TypeAlias = tuple[Any, ...]
"""A person or a draw of an answer's own sample: its name, then all that is known of it."""
_MOST_NAMES = 5
"""Most persons or draws that are named."""
_MOST_REASONS = 3
"""Most of them for whom it is said why they are not served."""
_LONGEST_CHOICE = 28
"""Most characters of a choice in a table."""
_SERVED = "served"
"""Name of the share served."""


class ComparedColumn(NamedTuple):
    """A column of choices that is compared."""

    name: str
    label: str
    """Meaning in words."""
    better: int
    """1 if more of it is better, -1 if less is, 0 if neither is by itself."""


COLUMNS = (
    ComparedColumn("pretension_from", "window from", 0),
    ComparedColumn("pretension_to", "window to", 0),
    ComparedColumn("tolerance_length", "half of the window", 1),
    ComparedColumn("pretension", "pretension to set", 0),
    ComparedColumn("set_flexor_tension", "to set in the flexor", 0),
    ComparedColumn("set_extensor_tension", "to set in the extensor", 0),
    ComparedColumn("max_tension", "largest tension", -1),
    ComparedColumn("max_contact_pressure", "strap pressure", -1),
    ComparedColumn("max_spring_extension", "spring travel", -1),
    ComparedColumn("peak_motor_torque", "motor torque", -1),
    ComparedColumn("min_elbow_stiffness", "least elbow stiffness", 1),
)
"""Columns that are compared, those of the window first."""


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
        if self.choice is None:
            return False
        window = phrases.window_of(self.choice)
        return window is not None and window[0] <= window[1]

    @property
    def is_named_first(self) -> bool:
        """True if the choice is the one that the answer names first."""
        best = self.record["best"]
        return best is not None and best == self.choice

    def value(self, name: str) -> float | None:
        """Return the value of a column of the choice; None if it has none."""
        if self.choice is None:
            return None
        value = value_of(self.choice, name)
        return None if value is None else float(value)


def compare_answers(
    answers: Sequence[Answer], labels: Sequence[str], choice: int | None
) -> ComparisonRecord:
    """Return the comparison of answers with the first of them.

    Args:
        answers: The answers.
        labels: Name of each for texts.
        choice: Row of a choice of the first one, compared with the same choice of the others;
            None for the choices that the answers name first.

    Raises:
        UsageError: An answer has no such choice.
        InputError: A table is damaged.
    """
    compared = [*_with_choices(answers, choice)]
    first = compared[0]
    notes: list[str] = []
    pairs = [
        _paired(first, other, notes, label)
        for other, label in zip(compared[1:], labels[1:], strict=True)
    ]
    quantities = [_quantity(column, compared) for column in COLUMNS]
    quantities = [quantity for quantity in quantities if any_value(quantity)]
    quantities += _strap(compared)
    quantities += _served(compared, pairs)
    for one, label in zip(compared, labels, strict=True):
        if one.choice is not None and not one.has_window:
            notes.append(
                f"{label} has no window: its numbers are those of the choice that comes closest to "
                "one, at the pretension that serves most."
            )
    if any(one.record["population"] is not None for one in compared):
        notes.append(
            "The values for tension, strap, springs and motor are the largest in each answer's own "
            "sample and have no interval."
        )
    return {
        "results": [_result(one, label) for one, label in zip(compared, labels, strict=True)],
        "differences": study_differences(
            [one.answer.study for one in compared],
            [one.record["versions"].get("tendon", "") for one in compared],
        ),
        "quantities": quantities,
        "binds": [_binds(one) for one in compared],
        "beside": [
            _beside(first, other, pair) for other, pair in zip(compared[1:], pairs, strict=True)
        ],
        "notes": notes,
    }


def any_value(quantity: QuantityRecord) -> bool:
    """Return True if any result has a value of a quantity."""
    return any(value is not None for value in quantity["values"])


def _with_choices(answers: Sequence[Answer], row: int | None) -> list[ComparedAnswer]:
    """Return answers with the choice of each that is compared."""
    records = [as_answer(answer.record) for answer in answers]
    if row is None:
        return [
            ComparedAnswer(answer, record, named_first(record))
            for answer, record in zip(answers, records, strict=True)
        ]
    chosen = choice_in_row(answers[0], row)
    axes = records[0]["question"]["choices"]
    compared = [ComparedAnswer(answers[0], records[0], chosen)]
    for answer, record in zip(answers[1:], records[1:], strict=True):
        compared.append(ComparedAnswer(answer, record, same_choice(answer, chosen, axes)))
    return compared


def _result(one: ComparedAnswer, label: str) -> ComparedResult:
    """Return name, folder and sentence of an answer."""
    record = one.record
    return {
        "label": label,
        "folder": None if one.answer.folder is None else str(one.answer.folder),
        "name": record["name"],
        "title": record["title"],
        "verb": record["verb"],
        "choice": "" if one.choice is None else _choice_words(one),
        "study_hash": record["study_hash"],
        "sentence": _sentence(one),
        "unit": record["question"]["unit"],
    }


def _choice_words(one: ComparedAnswer) -> str:
    """Say the choice that is compared by its values; empty if the question has no axes."""
    axes = one.record["question"]["choices"]
    if one.choice is None or not axes:
        return ""
    return shorten(phrases.choice_words(one.record["question"], one.choice), _LONGEST_CHOICE)


def _sentence(one: ComparedAnswer) -> str:
    """Say what an answer says of the choice that is compared."""
    record = one.record
    best = record["best"]
    if best is not None and one.is_named_first:
        return first_words(record, best)
    if one.choice is None or best is None:
        return no_window_words(record)
    suit = suit_words(record["question"], one.choice)
    return f"Choice {one.choice['choice']}: {suit.words}, set to {bench_words(record, one.choice)}."


# --- Quantities -----------------------------------------------------------------------------------


def _quantity(column: ComparedColumn, compared: Sequence[ComparedAnswer]) -> QuantityRecord:
    """Return a column of the choices of all answers, with a judgement on each."""
    first = compared[0]
    units = {_unit(column.name, one) for one in compared}
    is_comparable = len(units) == 1
    verdicts: list[Judgement | None] = [None]
    for other in compared[1:]:
        judged = _judge(column, first, other) if is_comparable else None
        verdicts.append(judged)
    read = first.record["question"]["read"]
    label = column.label
    if column.name == "pretension" and read != "pretension":
        label = f"to set: {read}"
    return {
        "name": column.name,
        "label": label,
        "unit": " or ".join(sorted(units)),
        "values": [one.value(column.name) for one in compared],
        "spans": [None] * len(compared),
        "verdicts": verdicts,
        "intervals": [None] * len(compared),
    }


def _unit(name: str, one: ComparedAnswer) -> str:
    """Return the SI unit of a column of an answer; pretensions are in the unit that is read."""
    quantity = QUANTITIES[name]
    if name in AS_READ:
        quantity = in_unit_of_reading(quantity, one.record["question"]["read"])
    return quantity.unit


def _judge(
    column: ComparedColumn, first: ComparedAnswer, other: ComparedAnswer
) -> Judgement | None:
    """Judge a column of another answer beside that of the first; None if neither is better."""
    if not column.better:
        return None
    if column.name == "tolerance_length":
        return _judge_tolerance(first, other)
    before = first.value(column.name)
    now = other.value(column.name)
    if before is None or now is None or not (first.has_window and other.has_window):
        return None  # at the pretension of a choice without a window nothing is worth comparing
    if column.better < 0:
        before = abs(before)
        now = abs(now)
    return judge(column.better, before, now)


def judge(better: int, before: float, now: float) -> Judgement:
    """Judge a number beside another one, apart from rounding.

    Args:
        better: 1 if more is better, -1 if less is.
        before: Number of the first result.
        now: Number of the later one.
    """
    if before == now or math.isclose(before, now, rel_tol=ROUNDING):
        return "no difference"
    return "better" if (now > before) == (better > 0) else "worse"


def _judge_tolerance(first: ComparedAnswer, other: ComparedAnswer) -> Judgement:
    """Judge how far the setting of another answer may be off beside that of the first.

    Where both answers have a window of a fresh sample, too, a difference counts if both samples
    show it.
    """
    own = judge(1, _length(first), _length(other))
    ratios = [_fresh_ratio(one) for one in (first, other)]
    before, now = ratios
    if before is None or now is None or own == "no difference":
        return own
    fresh = judge(1, _length(first) * before, _length(other) * now)
    return own if fresh == own else "no difference"


def _length(one: ComparedAnswer) -> float:
    """Return half the window as a length of both tendons, m; 0 without a window."""
    if not one.has_window or one.choice is None:
        return 0.0
    length = one.choice["tolerance_length"]
    return math.inf if length is None else length


def _fresh_ratio(one: ComparedAnswer) -> float | None:
    """Return the width of the fresh sample's window over that of the own; None without either."""
    if not one.has_window or one.choice is None:
        return None
    judged = one.choice["served_verified"]
    low = one.choice["pretension_from"]
    high = one.choice["pretension_to"]
    if judged is None or low is None or high is None or high == low:
        return None
    if judged["from"] is None or judged["to"] is None:
        return None
    return (judged["to"] - judged["from"]) / (high - low)


def _strap(compared: Sequence[ComparedAnswer]) -> list[QuantityRecord]:
    """Return the least width of the strap, if every answer names its choice first and has one."""
    widths = []
    for one in compared:
        parts = one.record["parts_needed"]
        if not one.is_named_first or parts is None or parts["strap"] is None:
            return []
        widths.append(parts["strap"]["least_width"])
    verdicts: list[Judgement | None] = [None]
    verdicts += [judge(-1, widths[0], width) for width in widths[1:]]
    return [
        {
            "name": "contact_width",
            "label": "strap width, at least",
            "unit": "m",
            "values": [*widths],
            "spans": [None] * len(widths),
            "verdicts": verdicts,
            "intervals": [None] * len(widths),
        }
    ]


# --- Whom they serve ------------------------------------------------------------------------------


def _paired(
    first: ComparedAnswer, other: ComparedAnswer, notes: list[str], label: str
) -> PairedShares | None:
    """Return the shares of two answers among the same fresh members; None, and a note, if not.

    Answers without persons and draws have nothing to pair, and need no note.
    """
    if first.record["population"] is None or other.record["population"] is None:
        return None
    if first.choice is None or other.choice is None:
        return None
    paired = paired_shares((first.answer.study, other.answer.study), (first.choice, other.choice))
    if isinstance(paired, str):
        notes.append(f"{label}: the shares cannot be compared one by one, because {paired}.")
        return None
    notes.append(
        f"{label}: the same {paired.members:,} {_of_fresh(paired)} judge both suits, computed "
        "again for this comparison; all else comes from the records."
    )
    return paired


def _of_fresh(paired: PairedShares) -> str:
    """Return the noun for the members of a fresh sample."""
    return "newly drawn persons" if paired.kind == "persons" else "new draws"


def _served(
    compared: Sequence[ComparedAnswer], pairs: Sequence[PairedShares | None]
) -> list[QuantityRecord]:
    """Return the share that each answer serves, with the interval of each difference."""
    if all(one.record["population"] is None for one in compared):
        return []
    values = [_share(one) for one in compared]
    spans = [_interval(one) for one in compared]
    verdicts: list[Judgement | None] = [None]
    intervals: list[list[float] | None] = [None]
    for place, (other, pair) in enumerate(zip(compared[1:], pairs, strict=True), 1):
        if _counted(compared[0]) != _counted(other):
            intervals.append(None)
            verdicts.append(None)  # a share of draws is none of persons
            continue
        interval = _share_interval(compared[0], other, pair)
        if pair is not None:
            values[0] = pair.first
            values[place] = pair.second
            spans[0] = pair.of_first
            spans[place] = pair.of_second
        intervals.append(None if interval is None else [*interval])
        verdicts.append(_judge_share(values[0], values[place], interval))
    return [
        {
            "name": _SERVED,
            "label": "share served",
            "unit": "1",
            "values": values,
            "spans": [None if span is None else [*span] for span in spans],
            "verdicts": verdicts,
            "intervals": intervals,
        }
    ]


def _counted(one: ComparedAnswer) -> str:
    """Return the noun for what an answer counts: "persons", "draws", "conditions"."""
    fresh = one.record["verified_by"]
    return one.record["question"]["counted"] if fresh is None else fresh["kind"]


def _share(one: ComparedAnswer) -> float | None:
    """Return the share that a choice serves: of the fresh sample if there is one."""
    if one.choice is None:
        return None
    judged = one.choice["served_verified"]
    return one.choice["served_at"] if judged is None else judged["value"]


def _share_interval(
    first: ComparedAnswer, other: ComparedAnswer, pair: PairedShares | None
) -> tuple[float, float] | None:
    """Return the 95 % interval of the difference of two shares; None if there is none."""
    if pair is not None:
        return pair.interval
    shares = (_share(first), _share(other))
    intervals = (_interval(first), _interval(other))
    if None in shares or None in intervals:
        return None
    return unpaired_interval(
        shares[0] or 0.0, intervals[0] or (), shares[1] or 0.0, intervals[1] or ()
    )


def _interval(one: ComparedAnswer) -> Sequence[float] | None:
    """Return the 95 % interval of the share that a choice serves; None without one."""
    if one.choice is None:
        return None
    judged = one.choice["served_verified"]
    if judged is not None:
        return judged["interval_95"]
    population = one.record["population"]
    is_of_population = population is not None and population["choice"] == one.choice["choice"]
    return population["interval_95"] if population is not None and is_of_population else None


def _judge_share(
    before: float | None, now: float | None, interval: tuple[float, float] | None
) -> Judgement | None:
    """Judge a share beside the first: there is no difference if the interval holds zero."""
    if before is None or now is None:
        return None
    if interval is None:
        return judge(1, before, now)
    low, high = interval
    if low <= 0.0 <= high:
        return "no difference"
    return "better" if low > 0.0 else "worse"


def _beside(first: ComparedAnswer, other: ComparedAnswer, pair: PairedShares | None) -> BesideFirst:
    """Return whom another answer serves and the first does not, and the other way round."""
    tables = (_table_of_members(first), _table_of_members(other))
    before = _served_by_name(first, tables[0])
    now = _served_by_name(other, tables[1])
    gained: list[str] = []
    lost: list[str] = []
    has_same_names = before is not None and now is not None and before.keys() == now.keys()
    if has_same_names and "draws" in tables:
        has_same_names = why_other_draws(first.answer.study, other.answer.study) is None
    if before is not None and now is not None and has_same_names:
        gained = [str(member[0]) for member in now if now[member] and not before[member]]
        lost = [str(member[0]) for member in now if before[member] and not now[member]]
    moves: list[MoveRecord | None] = [None, None]
    own = len(now) if now is not None and has_same_names else 0
    if pair is not None:
        moves = [
            _move(pair.kind, pair.gained_members, pair.members, pair.gained),
            _move(pair.kind, pair.lost_members, pair.members, pair.lost),
        ]
    elif now is not None and has_same_names:
        kind = tables[1] or ""
        moves = [
            _move(kind, len(names), len(now), len(names) / len(now)) for names in (gained, lost)
        ]
    for move, names in zip(moves, (gained, lost), strict=True):
        if move is not None and own:
            move |= {
                "names": names[:_MOST_NAMES],
                "named": len(names),
                "named_kind": tables[1] or "",
                "named_of": own,
            }
    return {
        "gained": moves[0],
        "lost": moves[1],
        "why_gained": _why_unserved(
            first, tables[0], gained, None if pair is None else pair.gained_one
        ),
        "why_lost": _why_unserved(other, tables[1], lost, None if pair is None else pair.lost_one),
        "paired": pair is not None,
        "margins": None,
        "broken": [],
    }


def _why_unserved(
    one: ComparedAnswer, table: str | None, names: list[str], of_fresh: UnservedMember | None
) -> list[UnservedRecord]:
    """Say why an answer does not serve some persons or draws that the other one serves.

    Those of the answer's own sample have a name; one of a fresh sample has its numbers.

    Args:
        one: The answer that does not serve them.
        table: Its table of persons or of draws.
        names: Names of such members of its own sample.
        of_fresh: Such a member of the fresh sample of both answers.
    """
    if one.choice is None:
        return []
    if names and table is not None:
        return [
            unserved_by_name(one.answer, one.choice, table, name) for name in names[:_MOST_REASONS]
        ]
    return [] if of_fresh is None else [unserved_afresh(one.answer, one.choice, of_fresh)]


def _move(kind: str, count: int, of: int, share: float) -> MoveRecord:
    """Return the record of those that one of two answers alone serves, none of them by name."""
    return {
        "kind": kind,
        "count": count,
        "of": of,
        "share": share,
        "names": [],
        "named": 0,
        "named_kind": kind,
        "named_of": 0,
    }


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


def _table_of_members(one: ComparedAnswer) -> str | None:
    """Return "persons" or "draws", the table of an answer's own sample.

    None if there is no such table, or if it is not of the choice that is compared.
    """
    population = one.record["population"]
    if population is None or one.choice is None or population["choice"] != one.choice["choice"]:
        return None
    for table in ("persons", "draws"):
        if table in one.answer.tables or f"{table}.parquet" in one.answer.table_files:
            return table
    return None


def _served_by_name(one: ComparedAnswer, table: str | None) -> dict[Member, bool] | None:
    """Return for each person or draw of an answer's own sample whether it is served.

    A person of several draws is served if enough of them are. None without a table.

    Args:
        one: The answer.
        table: Its table of persons or of draws.
    """
    population = one.record["population"]
    if table is None or population is None:
        return None
    rows = one.answer.table(table)
    enough = 1.0 if population["kind"] == table else one.record["serve"]
    served = as_numpy(rows.column("served")) >= enough - ROUNDING
    about = [
        rows.column(name).to_pylist()
        for name in rows.column_names
        if name not in _RESULTS_OF_MEMBERS and not name.startswith("set_")
    ]
    return dict(zip(zip(*about, strict=True), served.tolist(), strict=True))


# --- What binds -----------------------------------------------------------------------------------


def _binds(one: ComparedAnswer) -> BindRecord | None:
    """Return the limits at both ends of the window, or of what comes nearest to one."""
    if one.choice is None:
        return None
    question = one.record["question"]
    judged = one.choice["served_verified"]
    return {
        "lower": one.choice["from_by"],
        "upper": one.choice["to_by"],
        "words": [
            phrases.lower_words(question, one.choice),
            phrases.upper_words(question, one.choice),
        ],
        "fresh": None if judged is None else [judged["from"], judged["to"]],
    }
