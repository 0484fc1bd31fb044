"""For whom, and how sure: what the text of an answer says of persons or draws, made of its record."""

from __future__ import annotations

import math
from collections.abc import Iterator

from tendon_cli import say
from tendon_cli.answers.coverage import ROUNDING
from tendon_cli.answers.problem import Problem
from tendon_cli.answers.uncertainty import BODY
from tendon_cli.answers.words import Row, condition_words, everyone, parameter, row_words
from tendon_cli.space.axis import Axis
from tendon_cli.studies.study import keys
from tendon_cli.studies.values import RIGID

_MOST_NAMED = 3
_DIFFERENT = 0.5
"""Standard deviations from which on those not served are said to differ."""
_NEEDS = {"more": "would need more", "less": "would need less", "another suit": "cannot be served by any pretension"}
_HOW_MANY = ("one suit", "two suits", "three suits")


def population_lines(problem: Problem, record: Row) -> Iterator[tuple[str, str]]:
    """Paragraphs with the indent of each."""
    population = record["population"]
    what = row_words(problem.choices, population["values"])
    yield "", ""
    yield "For whom" if "person" in population["counts"] else "How sure", ""
    yield f"{what}: {_served(population)}" if what else _served(population), "  "
    if population["by"]:
        yield "; ".join(map(_of_sex, population["by"])), "  "
    for reason in population["not_served"]:
        yield _not_served(problem, population, reason), "  "
    if population["counts"].get("person", 0) > 1:
        yield from _sizes(problem, population)
    yield from _sobol(population)


def _served(population: Row) -> str:
    """The share that the pretension serves, with what the sample says of everyone."""
    served, most = population["served"], population["largest_share"]
    whom = everyone(population["counts"], population["count"], population["kind"])
    if not most > 0.0:
        return f"no pretension serves {'' if population['count'] == 1 else 'any of '}{whom}"
    verb = "works for" if population["count"] == 1 else "serves"
    words = f"{say.number(population['pretension'])} N {verb} {population_share(population)}"
    if most - served < ROUNDING:
        return words
    return f"{words}; {say.number(population['largest_share_at'])} N would serve {say.percent(most)}"


def _of_sex(share: Row) -> str:
    """The share of men, or of women."""
    nouns = {"male": ("man", "men"), "female": ("woman", "women")}[share["sex"]]
    whom = f"{share['persons']:,} {nouns[share['persons'] != 1]}"
    low, high = (say.percent(end) for end in share["interval_95"])
    if share["served"] >= 1.0:
        return f"all of {whom} (at least {low})"
    return f"{say.percent(share['served'])} of {whom} ({low} to {high})"


def population_share(population: Row) -> str:
    """The share that the pretension serves, of whom, and what that says of everyone.

    "all 1,000 persons (at least 99.6 %)", "96.9 % of this person's 256 draws (94 to 98.5 %)", "90 % of 192 pairs of
    3 persons and 64 draws". Pairs of several persons are no sample of independent ones, so that they have no interval.
    """
    count, served, noun = population["count"], population["served"], population["kind"][:-1]
    persons, draws = (population["counts"].get(key, 0) for key in ("person", "draw"))
    whom = everyone(population["counts"], count, population["kind"])
    if persons > 1 and draws > 1:
        return f"all {whom}" if served >= 1.0 else f"{say.percent(served)} of {whom}"
    if persons == 1 and draws > 1:
        share = say.sampled_share(served, count, "draw")
        return share.replace(f"{count:,} draws", f"{'of ' if share.startswith('all') else ''}{whom}")
    return say.sampled_share(served, count, noun, population["effective_count"])


def _not_served(problem: Problem, population: Row, reason: Row) -> str:
    share = f"{say.percent(reason['share'])} " if population["count"] > 1 else ""
    words = f"{share}{_NEEDS[reason['needs']]}: {why_not(problem, reason)}"
    if population["counts"].get("person", 1) == 1:
        return words
    bodies = [
        f"{say.column(name)} {say.quantity(name, each['theirs'])} against {say.quantity(name, each['of_all'])}"
        for name, each in reason["bodies"].items()
        if abs(each["deviations"]) >= _DIFFERENT
    ]
    names = ", ".join(reason["first"][:_MOST_NAMED]) + (", ..." if reason["count"] > _MOST_NAMED else "")
    return "; ".join([words, *bodies[:2], names])


def why_not(problem: Problem, reason: Row) -> str:
    """What happens to those not served, under which condition."""
    words = []
    for limit, condition in zip(reason["limits"], reason["conditions"], strict=False):
        under = condition_words(problem.conditions, condition, but_first=True)
        words.append(say.limit_words(limit, problem.study.limits).broken + (f" ({under})" if under else ""))
    return " and ".join(words)


def _sizes(problem: Problem, population: Row) -> Iterator[tuple[str, str]]:
    for column, sizes in population["sizes"].items():
        factor = next(factor for factor in problem.choices.axes if factor.column == column)
        of_all = population["counts"]["person"]
        few = f", by the first {sizes[0]['persons']:,} persons" if sizes[0]["persons"] < of_all else ""
        thin = "" if sizes[0]["all_values"] else f", among {sizes[0]['values_tried']} of its values"
        yield "", ""
        yield f"Sizes of {factor.key}{few}{thin}", ""
        for count, each in enumerate(sizes):
            if count and each["served"] == sizes[count - 1]["served"]:
                yield "further sizes serve nobody else", "  "
                break
            share = say.sampled_share(each["served"], each["persons"], "person")
            share += (
                f" with at least {say.percent(problem.enough)} of their draws" if problem.counted == "pairs" else ""
            )
            suits = ", ".join(f"{_value(factor, suit['value'])} at {say.number(suit['pretension'])} N"
                              for suit in each["suits"])  # fmt: skip
            yield f"{_HOW_MANY[count]:<11} {share}: {suits or 'none'}", "  "


def _value(factor: Axis, value: float | str) -> str:
    if value == RIGID and not factor.names:
        return parameter(factor.key, math.inf)
    return value if isinstance(value, str) else parameter(factor.key, value)


def _sobol(population: Row) -> Iterator[tuple[str, str]]:
    ends = population["sobol"]
    if not ends:
        return
    yield "", ""
    yield "Where the uncertainty of the window comes from (Sobol index: first order, total)", ""
    for each in ends:
        end = "lower" if each["end"] == "pretension_from" else "upper"
        inputs = [
            f"{input_name(key)} {_index(index, 'first')}, {_index(index, 'total')}"
            for key, index in sorted(each["inputs"].items(), key=lambda item: -item[1]["total"])
        ]
        deviation = say.number(each["standard_deviation"], 2)
        yield f"{end} end, standard deviation {deviation} N: {'; '.join(inputs)}", "  "
    if BODY in ends[0]["inputs"]:
        yield "the dimensions of a body are correlated and count as one input", "  "


def _index(index: Row, order: str) -> str:
    share, error = 100.0 * max(index[order], 0.0), 100.0 * index[f"{order}_standard_error"]
    return f"{say.number(share, 2)} ± {say.number(error, 1)} %"


def input_name(key: str) -> str:
    """An input of the indices in words."""
    if key not in keys():
        return key
    side = say.side_of(key)
    return say.column(keys()[key].number.quantity.name) + (f" of the {side}" if side else "")
