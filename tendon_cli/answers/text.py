"""An answer in words: at most fourteen lines, or all of it as tables, from the record alone."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tendon_cli import say
from tendon_cli.answers import phrases
from tendon_cli.answers.phrases import (
    ends_of,
    judgement_words,
    need_words,
    population_share,
    pretension_words,
    share_words,
    suits_words,
    window_of,
)
from tendon_cli.answers.record_tables import record_blocks
from tendon_cli.answers.text_assumed import (
    cuffs_words,
    deviations_words,
    errors_reach_setting,
    listed_words,
    paper_words,
    posture_words,
)
from tendon_cli.answers.text_bench import (
    Suit,
    bench_words,
    drift_words,
    other_end_words,
    shortening_words,
    spread_words,
    suit_words,
)
from tendon_cli.answers.text_order import (
    axis_words,
    state_words,
    ties_words,
    unsettable_words,
    why_first,
)
from tendon_cli.answers.text_parts import (
    can_be_built,
    failure_words,
    fix_words,
    relaxations_words,
    short_parts,
)
from tendon_cli.say import Clause, Section
from tendon_cli.studies import limit_phrases
from tendon_cli.studies.axis_words import parameter
from tendon_cli.studies.space.axis import PERSON_AXIS
from tendon_cli.verbs.answer_record import (
    AnswerResults,
    ChoiceRecord,
    ConflictRecord,
    QuestionRecord,
    SettingRecord,
    VerifiedRecord,
    as_read,
    value_of,
)

_ALL_LINES = 1000
"""Lines that no answer needs."""
MOST_LINES = 14
"""Most lines of a short answer, blank ones not counted."""
WIDTH = 100
"""Most characters of a line."""
_MOST_REASONS = 2
"""Most reasons why some are not served."""
_MOST_FIXES = 3
"""Most changes that would help."""
_MOST_FAILING = 3
_FAR_APART = 0.1
"""Share by which neighbouring points of a grid differ from which on a finer one is suggested."""


# --- All of it ------------------------------------------------------------------------------------


def short_text(record: AnswerResults, most_lines: int = MOST_LINES) -> str:
    """Return the short answer; with more lines, more of what may be left out stands in it."""
    joint = say.JointName.of(record.question.joint, record.question.own_words)
    named = [
        section._replace(
            clauses=[
                clause._replace(text=say.name_joint(clause.text, joint))
                for clause in section.clauses
            ]
        )
        for section in _sections(record)
    ]
    return say.fit(named, most_lines, WIDTH)


def answer_text(record: AnswerResults) -> str:
    """Return the whole answer: all of the short one, then the sections of the record as tables."""
    tables = say.as_text(
        _tables(record), say.JointName.of(record.question.joint, record.question.own_words), WIDTH
    )
    return f"{short_text(record, _ALL_LINES)}\n\n{tables}"


def answer_blocks(record: AnswerResults) -> Iterator[say.Block]:
    """Yield the blocks of the whole answer: every clause of the short one, then the tables."""
    for section in _sections(record):
        texts = [clause.text for clause in section.clauses]
        if section.label and texts:
            yield say.heading(section.label)
            yield from say.items(texts)
        elif texts:
            yield say.sentence(" ".join(texts))
    yield from _tables(record)


def _tables(record: AnswerResults) -> Iterator[say.Block]:
    yield from record_blocks(as_read(record))
    yield from ({"note": note} for note in record.notes)


def _sections(record: AnswerResults) -> list[Section]:
    """Return the sections of the short answer, with all that may stand in them."""
    record = as_read(record)
    best = record.best
    return [*(_no_window(record) if best is None else _with_window(record, best))]


# --- There is a window ----------------------------------------------------------------------------


def _with_window(record: AnswerResults, best: ChoiceRecord) -> Iterator[Section]:
    """Yield the sections of an answer in which a choice has a window."""
    first = [Clause(first_words(record, best))]
    decided = say.cutoff_words(record.checks)
    if decided:
        first.append(Clause(decided))
    rule = why_first(record)
    if rule:
        first.append(Clause(rule, 1))
    to_state = state_words(record)
    if to_state:
        first.append(Clause(to_state))
    cuffs = cuffs_words(record)
    if cuffs:
        first.append(Clause(cuffs))
    yield Section("", first, " ")
    yield Section("Why", [*_why(record, best)], "")
    if not best.feasible:
        yield Section("Would help", [*_other_pretension(record, best), *_help(record)], "")
    if record.setting is not None:
        yield Section("To set it", [*_to_set(record, best, record.setting)])
    if record.parts_needed is not None:
        sums = phrases.sums_words(record.question, best)
        parts = [Clause(sums, 2)] if sums else []
        rank = 1 if record.question.set_by_sample else 3
        parts += [Clause(words, rank) for _, words in short_parts(record.parts_needed)]
        yield Section("Parts", parts)
    yield Section("Rests on", [*_rests_on(record, best)])


def _why(record: AnswerResults, best: ChoiceRecord) -> Iterator[Clause]:
    """Yield the limits that bind at both ends, what happens beyond, and who is not served."""
    question = record.question
    noun, where = say.setting_words(question.read)
    gauge = where or f" of {noun}"
    own_sample = ""
    if best.served_verified is not None and not question.set_by_sample:
        own_sample = f"in {phrases.own_sample(question)}: "
    yield Clause(f"{own_sample}{phrases.lower_words(question, best, gauge)}")
    yield Clause(phrases.upper_words(question, best))
    drift = drift_words(record.drift)
    if drift:
        yield Clause(drift, 4)
    population = record.population
    if population is not None and not question.set_by_sample:
        for rank, reason in enumerate(population.not_served[:_MOST_REASONS]):
            yield Clause(need_words(question, population, reason), 2 + 4 * rank)
    for words in ties_words(record):
        yield Clause(words, 7)
    for words in edges_words(question, best):
        yield Clause(words, 6)


def _to_set(record: AnswerResults, best: ChoiceRecord, setting: SettingRecord) -> Iterator[Clause]:
    """Yield what shorter tendons add, how far they may be off, and the other readings."""
    question = record.question
    if question.read == "pretension":
        yield Clause(f"a pretension of {pretension_words(question, best)}")
    yield Clause(shortening_words(record, best, setting))
    spread = spread_words(record, setting)
    if spread:
        yield Clause(spread, 4)
    yield Clause(other_end_words(question, best), 6)


def _rests_on(record: AnswerResults, best: ChoiceRecord) -> Iterator[Clause]:
    """Yield what is proved, by whom it is judged, what is taken as exact, and the notes."""
    question = record.question
    population = record.population
    between = record.between_samples
    whom = ""
    if population is not None:
        whom = phrases.everyone(population.counts, population.count, population.kind)
    is_judged_anew = record.verified_by is not None
    if between is not None:
        proof = limit_phrases.proof_sentence(between).rstrip(".")
        of_sample = ""
        if is_judged_anew:
            of_sample = f" of {phrases.own_sample(question)}"
        rank = 5 if question.set_by_sample else 0
        yield Clause(f"the window{of_sample} is {proof[0].lower()}{proof[1:]}", rank)
    if best.served_verified is not None and record.verified_by is not None:
        share = share_words(record.verified_by, best.served_verified, record.serve)
        chose = "that had no part in choosing or setting"
        yield Clause(f"it serves {share}, {chose}")
    if whom and not is_judged_anew:
        yield Clause(f"the choice is made and judged by the same {whom.removeprefix('this ')}", 2)
    deviations = deviations_words(record, best)
    if deviations:
        is_first = record.question.set_by_sample or errors_reach_setting(record, best)
        yield Clause(deviations, 1 if is_first else 3)
    posture = posture_words(record)
    if posture:
        yield Clause(posture)
    for words in (listed_words(record), paper_words(record)):
        if words:
            yield Clause(words, 4)
    for note in record.notes:
        yield Clause(note, 9)


def _no_window(record: AnswerResults) -> Iterator[Section]:
    """Yield the sections of an answer in which no choice has a window."""
    decided = say.cutoff_words(record.checks)
    first = [Clause(words) for words in (no_window_words(record), decided) if words]
    yield Section("", first, " ")
    conflicts = record.conflicts
    if conflicts:
        nearest = min(conflicts, key=_distance)
        if record.question.set_by_sample:
            nearest = max(conflicts, key=lambda conflict: conflict.nearest.served or 0.0)
        yield Section("Why", [*_conflict(record, nearest)], "")
    yield Section("Would help", [*_help(record)], "")
    yield Section("Rests on", [Clause(note, 9) for note in record.notes])


def _distance(conflict: ConflictRecord) -> float:
    """Return the distance between the ends of the choice nearest to a window, N."""
    return math.inf if conflict.gap is None else conflict.gap


def _conflict(record: AnswerResults, conflict: ConflictRecord) -> Iterator[Clause]:
    """Yield the choice that is nearest to a window, and the ends that conflict there."""
    question = record.question
    if record.choices > 1:
        suit = suit_words(question, conflict.nearest)
        yield Clause(f"{suit.words} {suit.verb('come', 'comes')} closest to a window:", 3)
    for place, words in enumerate(conflict_words(record, conflict)):
        yield Clause(words, 0 if place < 2 else 5)


def _other_pretension(record: AnswerResults, best: ChoiceRecord) -> Iterator[Clause]:
    """Yield the pretensions that serve enough of the fresh sample, if there are some."""
    question = record.question
    judged = best.served_verified
    if judged is None or judged.from_ is None or question.pretension is not None:
        return
    noun, where = say.setting_words(question.read)
    yield Clause(window_words(question, judged, record.serve, where or f" of {noun}"))


def _help(record: AnswerResults) -> Iterator[Clause]:
    """Yield the cheapest fixes, and the demands that would have to be relaxed."""
    possible = [fix for fix in record.fixes if fix.after is not None]
    words = [*dict.fromkeys(fix_words(record.question, fix) for fix in possible)][:_MOST_FIXES]
    for place, text in enumerate(words):
        yield Clause(text, min(place, 2))
    changes = [*relaxations_words(record, record.would_take)]
    for place, text in enumerate(changes):
        yield Clause(text, 3 + place if words else min(place, 3))
    if not words and record.fixes:
        yield Clause("changing one number alone gives no window at any plausible value", 1)


# --- The first sentence ---------------------------------------------------------------------------


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
        if question.set_by_sample and PERSON_AXIS not in question.counts:
            return f"{work} in {suits_words(fresh, judged, record.serve)}"
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


# --- Both -----------------------------------------------------------------------------------------


def window_words(
    question: QuestionRecord, judged: VerifiedRecord, serve: float, gauge: str = ""
) -> str:
    """Say what serves enough of a fresh sample: "anything from 74 to 277 N serves all of them".

    Args:
        question: The question.
        judged: Judgement of the sample, which has such a window.
        serve: Share that is enough.
        gauge: Words for what is read, behind the window: " of pretension".
    """
    low, high = ends_of([judged.from_, judged.to])
    span = f"{_span(low, high, question.unit)}{gauge}"
    return f"anything {span} serves {_enough(serve)} of them"


def _enough(serve: float) -> str:
    """Say the share that is enough: "all", "at least 95 %"."""
    return "all" if serve >= 1.0 else f"at least {say.percent(serve)}"


def _span(low: float, high: float, unit: str) -> str:
    """Say a window: "from 100 to 120 N"."""
    if np.isfinite(high):
        return f"from {say.number(low)} to {say.number(high)} {unit}"
    return f"from {say.number(low)} {unit} up"


def _everyone(question: QuestionRecord) -> str:
    """Say who or what a share is counted in: "1,000 persons"."""
    return phrases.everyone(question.counts, question.groups, question.counted)


def _all_of(question: QuestionRecord) -> str:
    """Say whom or what a pretension must suit: "all 1,000 persons", "the design"."""
    whom = _everyone(question)
    is_single = question.groups == 1
    if _are_countless(question):
        return "all conditions"
    if question.counted == "conditions" and is_single:
        return "the design"
    return whom if whom.startswith("this") and is_single else say.all_of(whom)


def _are_countless(question: QuestionRecord) -> bool:
    """Return True if conditions are counted, but all values of an interval are among them."""
    return question.counted == "conditions" and bool(question.intervals)


def edges_words(question: QuestionRecord, best: ChoiceRecord) -> Iterator[str]:
    """Say which ranges have the best choice at their end, or between points that are far apart."""
    between = []
    for axis in question.choices:
        if axis.range is None or axis.step is None:
            continue
        symbol = axis_words(axis.key)
        value = float(value_of(best, axis.column))
        is_inside = True
        for edge, word in zip(axis.range, ("lower", "upper"), strict=True):
            if abs(value - edge) <= 1e-9 * abs(edge):
                is_inside = False
                at_edge = parameter(axis.key, value)
                yield f"{symbol} is at the {word} end of its range, {at_edge}: widen the range"
        if is_inside and axis.step > _FAR_APART:
            between.append(f"{symbol} (now up to {say.percent(axis.step)} apart)")
    if between:
        yield f"a finer grid of {say.join_words(between)} may hold a better choice"


def no_window_words(record: AnswerResults) -> str:
    """Say that no choice has a window, or that the given pretension suits none."""
    question = record.question
    choices = record.choices
    noun, where = say.setting_words(question.read)
    any_of = "either" if choices == 2 else "any"
    with_any = "" if choices == 1 else f" with {any_of} of the {choices:,} choices"
    whom = _all_of(question)
    if record.serve < 1.0:
        whom = f"{say.percent(record.serve)} of {_everyone(question)}"
    start = f"No {noun}{where} works for"
    if question.pretension is not None:
        given = f"{say.number(question.pretension)} {question.unit}"
        start = f"A {noun} of {given}{where} does not work for"
    best = ""
    if question.set_by_sample and record.conflicts:
        nearest = max((conflict.nearest for conflict in record.conflicts), key=_served_at_best)
        suit = suit_words(question, nearest)
        serve = suit.verb("serve", "serves")
        if nearest.pretension is not None:
            share = say.percent(_served_at_best(nearest))
            shown = f"{say.number(nearest.pretension, 3)} {question.unit}"
            best = f" At best {suit.words} {serve} {share}, at {shown}."
    return f"{start} {whom}{with_any}.{best}"


def _served_at_best(row: ChoiceRecord) -> float:
    return row.served or 0.0


def conflict_words(record: AnswerResults, conflict: ConflictRecord) -> Iterator[str]:
    """Say the ends that leave the choice nearest to a window none, and how far they are apart."""
    question = record.question
    row = conflict.nearest
    given = question.pretension
    window = window_of(row)
    if window is None:
        end = phrases.lower_end(row)
        limit = end.limit or conflict.limits[0]
        broken = phrases.broken(question, limit, row.columns, end.under)
        yield f"at any pretension {broken}{phrases.where(question, end)}"
        return
    low, high = window
    if given is not None and low <= high:
        lower_is_missed = given < low
        missed = phrases.upper_words(question, row)
        if lower_is_missed:
            missed = phrases.lower_words(question, row)
        yield f"{missed}; {phrases.margins(question, row)}"
        return
    yield from phrases.gap_words(question, row, conflict.gap)
    if row.pretension is None:
        return
    pretension = f"{say.number(row.pretension, 3)} {question.unit}"
    fails = conflict.fails
    if row.served and record.serve >= 1.0 and record.conditions > 1:
        yield f"{pretension} works for {say.percent(row.served)} of the {question.counted}"
    elif 0 < len(fails) < record.conditions and not _are_countless(question):
        words = [phrases.condition_words(question, values) for values in fails[:_MOST_FAILING]]
        more = [f"{len(fails) - len(words)} more"] if len(fails) > len(words) else []
        of_all = f"{len(fails)} of {record.conditions} conditions"
        yield f"{pretension} does not work in {of_all}: {'; '.join([*words, *more])}"
