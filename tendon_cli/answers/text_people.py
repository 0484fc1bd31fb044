"""An answer for persons or draws in words: whom it serves, why not others, sizes, Sobol indices."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from tendon_cli import say
from tendon_cli.answer_record import (
    AnswerResults,
    AxisRecord,
    FreshRecord,
    PopulationRecord,
    QuestionRecord,
    ReasonRecord,
    SexRecord,
    SizeRecord,
    SobolRecord,
    Values,
)
from tendon_cli.answers.phrases import (
    broken,
    choice_words,
    condition_of_group,
    everyone,
    value_words,
)
from tendon_cli.answers.text_verified import share_words
from tendon_cli.studies.study import keys

MORE = "more"
"""Needs more pretension to be served."""
LESS = "less"
"""Needs less pretension to be served."""
NEITHER = "another suit"
"""Needs another suit to be served."""
_NEEDS = {MORE: "a higher", LESS: "a lower"}
_SUITS = ("one suit", "two suits", "three suits")
_MOST_NAMED = 3
"""Most persons who are named."""
_DIFFERENT = 0.5
"""Standard deviations by which those who are not served must differ from everyone to say so."""
_LEAST_GAIN = 1e-12
"""Share by which another pretension must serve more to be named."""
_LEAST_INDEX = 1e-4
"""Share of the variance below which an index is not printed."""


# --- Words that the record holds ------------------------------------------------------------------


def population_title(
    question: QuestionRecord,
    population: PopulationRecord,
    fresh: FreshRecord | None,
    serve: float,
) -> str:
    """Say the choice, its pretension and the share that it serves, for figures and pages.

    Args:
        question: The question.
        population: The choice for persons or draws.
        fresh: Fresh sample that judges it; None without one.
        serve: Share that is enough.
    """
    judged = population.served_verified
    share = f"serves {population_share(population)}"
    if fresh is not None and judged is not None:
        share = f"serves {share_words(fresh, judged, serve)}"
    if population.pretension is not None:
        share = f"{say.number(population.pretension)} {question.unit} {share}"
    choice = choice_words(question, population.values)
    return f"{choice}, {share}" if choice else share


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


# --- For whom -------------------------------------------------------------------------------------


def population_blocks(record: AnswerResults, population: PopulationRecord) -> Iterator[say.Block]:
    """Yield the blocks of an answer about persons or draws."""
    question = record.question
    counts = population.counts
    choice = choice_words(question, population.values)
    served = _served(population, question.unit)
    by_sex = "; ".join(_of_sex(share) for share in population.by)
    fresh = record.verified_by
    judged = population.served_verified
    items = [f"{choice}: {served}" if choice else served]
    if judged is not None and fresh is not None and population.pretension is not None:
        pretension = say.number(population.pretension)
        items = [
            f"{pretension} {question.unit} serves {share_words(fresh, judged, record.serve)}",
            by_sex,
        ]
        items.append(f"in the study's own sample {served}")
    else:
        items.append(by_sex)
    items = [item for item in items if item]
    items += [_not_served(question, population, reason) for reason in population.not_served]
    yield say.heading("For whom" if "person" in counts else "How sure")
    yield from say.items(items)
    persons = counts.get("person", 0)
    if persons > 1:
        of_draws = ""
        if question.counted == "pairs":
            of_draws = f" with at least {say.percent(record.serve)} of their draws"
        for axis in question.choices:
            sizes = population.sizes.get(axis.column)
            if sizes:
                yield from _sizes(axis, sizes, persons, of_draws, question.unit)
    yield from _sobol(population.sobol, question.unit)


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


def _served(population: PopulationRecord, unit: str) -> str:
    """Say the share that the pretension serves, and the pretension that would serve most."""
    most = population.largest_share
    is_single = population.count == 1
    pretension = population.pretension
    best = population.largest_share_at
    if pretension is None or best is None:
        whom = everyone(population.counts, population.count, population.kind)
        return f"no pretension serves {'' if is_single else 'any of '}{whom}"
    verb = "works for" if is_single else "serves"
    words = f"{say.number(pretension)} {unit} {verb} {population_share(population)}"
    if most - population.served < _LEAST_GAIN:
        return words
    return f"{words}; {say.number(best)} {unit} would serve {say.percent(most)}"


def _of_sex(share: SexRecord) -> str:
    """Say the share of men, or of women."""
    one, several = {"male": ("man", "men"), "female": ("woman", "women")}[share.sex]
    whom = f"{share.persons:,} {one if share.persons == 1 else several}"
    low, high = (say.percent(end) for end in share.interval_95)
    if share.served >= 1.0:
        return f"all of {whom} (at least {low})"
    return f"{say.percent(share.served)} of {whom} ({low} to {high})"


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


def _not_served(
    question: QuestionRecord, population: PopulationRecord, reason: ReasonRecord
) -> str:
    """Say who is not served for a reason, how they differ, and some of their names."""
    words = need_words(question, population, reason)
    if population.counts.get("person", 1) == 1:
        return words
    bodies = []
    for name, body in reason.bodies.items():
        if abs(body.deviations) >= _DIFFERENT:
            of_members = say.quantity(name, body.theirs)
            of_all = say.quantity(name, body.of_all)
            bodies.append(f"{say.column(name)} {of_members} against {of_all}")
    parts = [words]
    if bodies:
        parts.append(f"mean {' and '.join(bodies[:2])} for all")
    names = say.join_words(reason.first[:_MOST_NAMED])
    parts.append(f"for example {names}" if reason.count > _MOST_NAMED else names)
    return "; ".join(parts)


# --- Sizes ----------------------------------------------------------------------------------------


def _sizes(
    axis: AxisRecord, sizes: Sequence[SizeRecord], of_all: int, of_draws: str, unit: str
) -> Iterator[say.Block]:
    """Yield the best few suits along an axis.

    Args:
        axis: The axis.
        sizes: The best suit, the best two, the best three.
        of_all: Number of all persons.
        of_draws: Words for the share of the draws that must be served; empty without draws.
        unit: Unit of the pretension.
    """
    first = sizes[0]
    persons = ""
    if first.persons < of_all:
        persons = f", for the first {first.persons:,} persons"
    values = ""
    if not first.all_values:
        values = f", from {first.values_tried} of its values"
    yield say.heading(f"Sizes of {axis.key}{persons}{values}")
    served_before = None
    for suits_in_words, size in zip(_SUITS, sizes, strict=False):
        if size.served == served_before:
            yield from say.items(["more sizes serve nobody else"])
            break
        served_before = size.served
        share = say.sampled_share(size.served, size.persons, "person") + of_draws
        suits = [
            f"{value_words(axis, suit.value)} at {say.number(suit.pretension)} {unit}"
            for suit in size.choices
        ]
        verb = "serves" if len(suits) == 1 else "serve"
        chosen = say.join_words(suits) or "none"
        yield from say.items([f"{suits_in_words} {verb} {share}: {chosen}"])


# --- Sobol indices --------------------------------------------------------------------------------


def _sobol(ends: Sequence[SobolRecord], unit: str) -> Iterator[say.Block]:
    """Yield a table of the Sobol indices of each end of a window, the largest first."""
    if not ends:
        return
    yield say.heading("Where the uncertainty of the window comes from (Sobol indices)")
    for record in ends:
        end = "lower" if record.end == "pretension_from" else "upper"
        deviation = say.number(record.standard_deviation, 2)
        rows = [[f"{end} end, standard deviation {deviation} {unit}", "first order", "total"]]
        for index in sorted(record.inputs.values(), key=lambda index: -index.total):
            first = _index(index.first, index.first_standard_error)
            total = _index(index.total, index.total_standard_error)
            rows.append([f"  {index.name}", first, total])
        yield say.table(rows)
    if "body" in ends[0].inputs:
        yield from say.items(["the dimensions of a body are correlated and count as one input"])


def _index(index: float, error: float) -> str:
    """Say an index with its standard error, in percent."""
    if max(index, error) < _LEAST_INDEX:
        return "below 0.01 %"
    share = say.number(100.0 * index, 2) if index >= _LEAST_INDEX else "0"
    if error < _LEAST_INDEX:
        return f"{share} %"
    return f"{share} ± {say.number(100.0 * error, 1)} %"
