"""The short answer: at most fourteen lines, from the record alone.

What to set on which suit, why, how to set it, the parts that it needs, and what all this rests on;
without a window the two ends that conflict, and the cheapest fixes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from tendon_cli import say
from tendon_cli.answer_record import (
    AnswerResults,
    ChoiceRecord,
    ConflictRecord,
    SettingRecord,
)
from tendon_cli.answers import phrases
from tendon_cli.answers.phrases import pretension_words
from tendon_cli.answers.text import conflict_words, edges_words, no_window_words, window_words
from tendon_cli.answers.text_bench import (
    drift_words,
    other_end_words,
    shortening_words,
    spread_words,
)
from tendon_cli.answers.text_exact import errors_reach_setting, exact_short
from tendon_cli.answers.text_first import first_words, suit_words
from tendon_cli.answers.text_order import state_words, ties_words, why_first
from tendon_cli.answers.text_parts import short_parts
from tendon_cli.answers.text_people import need_words
from tendon_cli.answers.text_remedies import fix_words, relaxations_words
from tendon_cli.say import Clause, Section

MOST_LINES = 14
"""Most lines of a short answer, blank ones not counted."""
WIDTH = 100
"""Most characters of a line."""
_MOST_REASONS = 2
"""Most reasons why some are not served."""
_MOST_FIXES = 3
"""Most changes that would help."""


def short_text(record: AnswerResults) -> str:
    """Return the short answer."""
    best = record["best"]
    sections = _no_window(record) if best is None else _answer(record, best)
    joint = say.joint_name(record["question"])
    named = [
        section._replace(
            clauses=[
                clause._replace(text=say.name_joint(clause.text, joint))
                for clause in section.clauses
            ]
        )
        for section in sections
    ]
    return say.fit(named, MOST_LINES, WIDTH)


# --- There is a window ----------------------------------------------------------------------------


def _answer(record: AnswerResults, best: ChoiceRecord) -> Iterator[Section]:
    """Yield the sections of an answer in which a choice has a window."""
    first = [Clause(first_words(record, best))]
    decided = say.cutoff_words(record.get("checks"))
    if decided:
        first.append(Clause(decided))
    rule = why_first(record)
    if rule:
        first.append(Clause(rule, 1))
    to_state = state_words(record)
    if to_state:
        first.append(Clause(to_state))
    yield Section("", first, " ")
    yield Section("Why", [*_why(record, best)], "")
    if not best["feasible"]:
        yield Section("Would help", [*_other_pretension(record, best), *_help(record)], "")
    if record["setting"] is not None:
        yield Section("To set it", [*_to_set(record, best, record["setting"])])
    if record["parts_needed"] is not None:
        sums = phrases.sums_words(record["question"], best)
        parts = [Clause(sums, 2)] if sums else []
        parts += [Clause(words, 3) for words in short_parts(record["parts_needed"])]
        yield Section("Parts", parts)
    yield Section("Rests on", [*_rests_on(record, best)])


def _why(record: AnswerResults, best: ChoiceRecord) -> Iterator[Clause]:
    """Yield the limits that bind at both ends, what happens beyond, and who is not served."""
    question = record["question"]
    noun, where = say.setting_words(question["read"])
    gauge = where or f" of {noun}"
    own_sample = ""
    if best["served_verified"] is not None:
        own_sample = f"in {phrases.own_sample(question)}: "
    yield Clause(f"{own_sample}{phrases.lower_words(question, best, gauge)}")
    yield Clause(phrases.upper_words(question, best))
    drift = drift_words(record["drift"])
    if drift:
        yield Clause(drift, 4)
    population = record["population"]
    if population is not None:
        for rank, reason in enumerate(population["not_served"][:_MOST_REASONS]):
            yield Clause(need_words(question, population, reason), 2 + 4 * rank)
    for words in ties_words(record):
        yield Clause(words, 7)
    for words in edges_words(question, best):
        yield Clause(words, 6)


def _to_set(record: AnswerResults, best: ChoiceRecord, setting: SettingRecord) -> Iterator[Clause]:
    """Yield what shorter tendons add, how far they may be off, and the other readings."""
    question = record["question"]
    if question["read"] == "pretension":
        yield Clause(f"a pretension of {pretension_words(question, best)}")
    yield Clause(shortening_words(record, best, setting))
    spread = spread_words(record, setting)
    if spread:
        yield Clause(spread, 1)
    yield Clause(other_end_words(question, best), 6)


def _rests_on(record: AnswerResults, best: ChoiceRecord) -> Iterator[Clause]:
    """Yield what is proved, by whom it is judged, what is taken as exact, and the notes."""
    question = record["question"]
    population = record["population"]
    between = record["between_samples"]
    whom = ""
    if population is not None:
        whom = phrases.everyone(population["counts"], population["count"], population["kind"])
    is_judged_anew = record["verified_by"] is not None
    if between is not None:
        proof = say.proof_sentence(between).rstrip(".")
        of_sample = f" of {phrases.own_sample(question)}" if is_judged_anew else ""
        yield Clause(f"the window{of_sample} is {proof[0].lower()}{proof[1:]}")
    if whom and not is_judged_anew:
        yield Clause(f"the choice is made and judged by the same {whom.removeprefix('this ')}", 2)
    numbers = record["taken_as_exact"]
    exact = exact_short(question, numbers, best)
    if exact:
        yield Clause(exact, 1 if errors_reach_setting(numbers, best) else 3)
    for note in record["notes"]:
        yield Clause(note, 9)


# --- There is no window ---------------------------------------------------------------------------


def _no_window(record: AnswerResults) -> Iterator[Section]:
    """Yield the sections of an answer in which no choice has a window."""
    decided = say.cutoff_words(record.get("checks"))
    first = [Clause(words) for words in (no_window_words(record), decided) if words]
    yield Section("", first, " ")
    conflicts = record["conflicts"]
    if conflicts:
        nearest = min(conflicts, key=_distance)
        yield Section("Why", [*_conflict(record, nearest)], "")
    yield Section("Would help", [*_help(record)], "")
    yield Section("Rests on", [Clause(note, 9) for note in record["notes"]])


def _distance(conflict: ConflictRecord) -> float:
    """Return the distance between the ends of the choice nearest to a window, N."""
    return math.inf if conflict["gap"] is None else conflict["gap"]


def _conflict(record: AnswerResults, conflict: ConflictRecord) -> Iterator[Clause]:
    """Yield the choice that is nearest to a window, and the ends that conflict there."""
    question = record["question"]
    if record["choices"] > 1:
        suit = suit_words(question, conflict["nearest"])
        yield Clause(f"{suit.words} {suit.verb('come', 'comes')} closest to a window:", 3)
    for place, words in enumerate(conflict_words(record, conflict)):
        yield Clause(words, 0 if place < 2 else 5)


def _other_pretension(record: AnswerResults, best: ChoiceRecord) -> Iterator[Clause]:
    """Yield the pretensions that serve enough of the fresh sample, if there are some."""
    question = record["question"]
    judged = best["served_verified"]
    if judged is None or judged["from"] is None or question["pretension"] is not None:
        return
    noun, where = say.setting_words(question["read"])
    yield Clause(window_words(question, judged, record["serve"], where or f" of {noun}"))


def _help(record: AnswerResults) -> Iterator[Clause]:
    """Yield the cheapest fixes, and the demands that would have to be relaxed."""
    possible = [fix for fix in record["fixes"] if fix["after"] is not None]
    fixes = sorted(possible, key=lambda fix: not fix["can_be_built"])
    words = [*dict.fromkeys(fix_words(record["question"], fix) for fix in fixes)][:_MOST_FIXES]
    for place, text in enumerate(words):
        yield Clause(text, min(place, 2))
    changes = [*relaxations_words(record, record["would_take"])]
    for place, text in enumerate(changes):
        yield Clause(text, 3 + place if words else min(place, 3))
    if not words and record["fixes"]:
        yield Clause("changing one number alone gives no window at any plausible value", 1)
