"""Choices, conditions, persons and draws in words, from the record of an answer."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.space.axis import Axis
from tendon_cli.space.space import Space
from tendon_cli.studies.study import keys
from tendon_cli.studies.values import RIGID
from tendon_cli.windows.coverage import ROUNDING
from tendon_cli.windows.question import Question

Row = Mapping[str, Any]
"""A part of the record of an answer, such as a row of `choices.parquet`."""

COSTS = {"max_tension": "tension", "max_spring_extension": "spring", "peak_motor_torque": "torque"}
"""Columns of a choice's costs, and their heads in small tables."""

MORE = "more"
"""Needs more pretension to be served."""
LESS = "less"
"""Needs less pretension to be served."""
NEITHER = "another suit"
"""Needs another suit to be served."""
_NEEDS = {
    MORE: "would need more",
    LESS: "would need less",
    NEITHER: "cannot be served by any pretension",
}
_SUITS = ("one suit", "two suits", "three suits")
_MOST_NAMED = 3
"""Most persons who are named."""
_DIFFERENT = 0.5
"""Standard deviations by which those who are not served must differ from everyone to say so."""


def parameter(key: str, value: float | str) -> str:
    """Say a recorded number of a study with its symbol and unit."""
    number = math.inf if value == RIGID else float(value)
    return say.parameter(keys()[key].number.quantity, number, say.side_of(key))


def value_words(axis: Axis, value: float | str) -> str:
    """Say the value of a choice or a condition on an axis."""
    return axis.in_words(str(value)) if axis.names else parameter(axis.key, value)


def row_words(product: Space, row: Row) -> str:
    """Say a choice by its value on each axis; empty if there is no axis."""
    return ", ".join(value_words(axis, row[axis.column]) for axis in product.axes)


def condition_words(conditions: Space, condition: int, *, but_first: bool = False) -> str:
    """Say a condition by its row of conditions.parquet.

    Args:
        conditions: All conditions.
        condition: The row.
        but_first: True to leave out the first axis, of the person or draw that it belongs to.
    """
    columns = conditions.columns(np.array([condition]))
    words = []
    for axis in conditions.axes[int(but_first) :]:
        value = columns[axis.column][0]
        words.append(value_words(axis, axis.names[int(value)] if axis.names else value))
    return ", ".join(words)


def costs(row: Row) -> list[str]:
    """Say the costs of a choice."""
    return ["-" if row[name] is None else say.quantity(name, row[name]) for name in COSTS]


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


def ends_of(row: Row) -> tuple[Any, float]:
    """Return the ends of a row's window, N, as recorded; the upper one infinite if it has none."""
    high = row["pretension_to"]
    return row["pretension_from"], np.inf if high is None else high


def end_words(problem: Question, row: Row, end: str) -> str:
    """Say one end of a window, "from" or "to", with the limit, condition and state that bind."""
    limit = row[f"{end}_by"]
    if limit is None:
        return "no lower limit: taut without pretension" if end == "from" else "no upper limit"
    side = "below" if end == "from" else "above"
    value = say.number(row[f"pretension_{end}"])
    return f"{side} {value} N {broken(problem, limit)}{where(problem, row, end)}"


def broken(problem: Question, limit: str) -> str:
    """Say what happens if a limit of the study is not kept."""
    return say.limit_words(limit, problem.study.limits).broken


def where(problem: Question, row: Row, end: str) -> str:
    """Say the condition and the state that bind, in brackets."""
    words = [condition_words(problem.conditions, row[f"{end}_condition"])]
    if row[f"{end}_direction"] is not None:
        words.append(row[f"{end}_direction"])
        words.append(say.quantity("elbow_angle", row[f"{end}_elbow_angle"]))
    inside = ", ".join(word for word in words if word)
    return f" ({inside})" if inside else ""


def margins(problem: Question, row: Row) -> str:
    """Say by how much a given pretension lies within the window of a choice, or misses it."""
    pretension = problem.placement.given
    low, high = ends_of(row)
    if pretension is None or low is None or not low <= high:
        return "there is no window"
    window = say.window_text(low, high)
    if pretension < low:
        return f"it is {say.number(low - pretension, 3)} N less than the window, {window}"
    if pretension > high:
        return f"it is {say.number(pretension - high, 3)} N more than the window, {window}"
    lower = f"{say.number(pretension - low, 3)} N above the lower end"
    upper = ""
    if not np.isinf(high):
        upper = f" and {say.number(high - pretension, 3)} N below the upper end"
    return f"that is {lower}{upper} of the window, {window}"


# --- Persons and draws ----------------------------------------------------------------------------


def why_not(problem: Question, limits: list[str], conditions: list[int]) -> str:
    """Say what happens to those who are not served, by limit, and under which condition."""
    words = []
    for limit, condition in zip(limits, conditions, strict=False):
        under = condition_words(problem.conditions, condition, but_first=True)
        words.append(broken(problem, limit) + (f" ({under})" if under else ""))
    return " and ".join(words)


def population_share(population: Row) -> str:
    """Say the share that the pretension serves, of whom, and its interval for everyone.

    "all 1,000 persons (at least 99.6 %)", "96.9 % of this person's 256 draws (94 to 98.5 %)",
    "90 % of 192 pairs of 3 persons and 64 draws". Pairs of several persons are not
    independent samples, so that their share has no interval.
    """
    count = population["count"]
    served = population["served"]
    kind = population["kind"]
    persons = population["counts"].get("person", 0)
    draws = population["counts"].get("draw", 0)
    whom = everyone(population["counts"], count, kind)
    if persons > 1 and draws > 1:
        return f"all {whom}" if served >= 1.0 else f"{say.percent(served)} of {whom}"
    if persons == 1 and draws > 1:
        share = say.sampled_share(served, count, "draw")
        of_whom = f"of {whom}" if share.startswith("all") else whom
        return share.replace(f"{count:,} draws", of_whom)
    return say.sampled_share(served, count, kind.removesuffix("s"), population["effective_count"])


def population_blocks(problem: Question, population: Row) -> Iterator[say.Block]:
    """Yield the blocks of an answer about persons or draws."""
    counts = population["counts"]
    choice = row_words(problem.choices, population["values"])
    served = _served(population)
    items = [f"{choice}: {served}" if choice else served]
    if population["by"]:
        items.append("; ".join(_of_sex(share) for share in population["by"]))
    items += [_not_served(population, reason) for reason in population["not_served"]]
    yield say.heading("For whom" if "person" in counts else "How sure")
    yield from say.items(items)
    persons = counts.get("person", 0)
    if persons > 1:
        for axis in problem.choices.axes:
            yield from _sizes(problem, axis, population["sizes"].get(axis.column), persons)
    yield from _sobol(population["sobol"])


def _served(population: Row) -> str:
    """Say the share that the pretension serves, and the pretension that would serve most."""
    most = population["largest_share"]
    is_single = population["count"] == 1
    if not most > 0.0:
        whom = everyone(population["counts"], population["count"], population["kind"])
        return f"no pretension serves {'' if is_single else 'any of '}{whom}"
    verb = "works for" if is_single else "serves"
    words = f"{say.number(population['pretension'])} N {verb} {population_share(population)}"
    if most - population["served"] < ROUNDING:
        return words
    better = say.number(population["largest_share_at"])
    return f"{words}; {better} N would serve {say.percent(most)}"


def _of_sex(share: Row) -> str:
    """Say the share of men, or of women."""
    one, several = {"male": ("man", "men"), "female": ("woman", "women")}[share["sex"]]
    whom = f"{share['persons']:,} {one if share['persons'] == 1 else several}"
    low, high = (say.percent(end) for end in share["interval_95"])
    if share["served"] >= 1.0:
        return f"all of {whom} (at least {low})"
    return f"{say.percent(share['served'])} of {whom} ({low} to {high})"


def _not_served(population: Row, reason: Row) -> str:
    """Say who is not served for a reason, how they differ, and some of their names."""
    share = f"{say.percent(reason['share'])} " if population["count"] > 1 else ""
    words = f"{share}{_NEEDS[reason['needs']]}: {reason['text']}"
    if population["counts"].get("person", 1) == 1:
        return words
    bodies = []
    for name, body in reason["bodies"].items():
        if abs(body["deviations"]) >= _DIFFERENT:
            of_members = say.quantity(name, body["theirs"])
            of_all = say.quantity(name, body["of_all"])
            bodies.append(f"{say.column(name)} {of_members} against {of_all}")
    names = ", ".join(reason["first"][:_MOST_NAMED])
    if reason["count"] > _MOST_NAMED:
        names += ", ..."
    return "; ".join([words, *bodies[:2], names])


def _sizes(
    problem: Question, axis: Axis, sizes: list[Row] | None, of_all: int
) -> Iterator[say.Block]:
    """Yield the best few suits along an axis, of `of_all` persons."""
    if not sizes:
        return
    first = sizes[0]
    persons = ""
    if first["persons"] < of_all:
        persons = f", by the first {first['persons']:,} persons"
    values = ""
    if not first["all_values"]:
        values = f", among {first['values_tried']} of its values"
    of_draws = ""
    if problem.groups.noun == "pairs":
        of_draws = f" with at least {say.percent(problem.serve)} of their draws"
    yield say.heading(f"Sizes of {axis.key}{persons}{values}")
    served_before = None
    for suits_in_words, size in zip(_SUITS, sizes, strict=False):
        if size["served"] == served_before:
            yield from say.items(["further sizes serve nobody else"])
            break
        served_before = size["served"]
        share = say.sampled_share(size["served"], size["persons"], "person") + of_draws
        suits = [
            f"{value_words(axis, suit['value'])} at {say.number(suit['pretension'])} N"
            for suit in size["choices"]
        ]
        yield from say.items([f"{suits_in_words}: {share}, {' and '.join(suits) or 'none'}"])


def _sobol(ends: list[Row]) -> Iterator[say.Block]:
    """Yield the Sobol indices of both ends of a window."""
    if not ends:
        return
    yield say.heading(
        "Where the uncertainty of the window comes from (Sobol index: first order, total)"
    )
    for record in ends:
        end = "lower" if record["end"] == "pretension_from" else "upper"
        inputs = [
            f"{index['name']} {_index(index, 'first')}, {_index(index, 'total')}"
            for index in sorted(record["inputs"].values(), key=lambda index: -index["total"])
        ]
        deviation = say.number(record["standard_deviation"], 2)
        yield from say.items([f"{end} end, standard deviation {deviation} N: {'; '.join(inputs)}"])
    if "body" in ends[0]["inputs"]:
        yield from say.items(["the dimensions of a body are correlated and count as one input"])


def _index(index: Row, order: str) -> str:
    """Say an index with its standard error, in percent."""
    share = 100.0 * max(index[order], 0.0)
    error = 100.0 * index[f"{order}_standard_error"]
    return f"{say.number(share, 2)} ± {say.number(error, 1)} %"
