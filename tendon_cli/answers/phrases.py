"""Choices, conditions, persons and draws in words, made of the record of an answer."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.answers.coverage import ROUNDING
from tendon_cli.answers.problem import Problem
from tendon_cli.space.axis import Axis
from tendon_cli.space.space import Space
from tendon_cli.studies.study import keys
from tendon_cli.studies.values import RIGID

Row = Mapping[str, Any]  # a part of the record of an answer, such as a row of `choices.parquet`

_MOST_NAMED = 3
_DIFFERENT = 0.5  # standard deviations from which on those not served differ
MORE, LESS, NEITHER = "more", "less", "another suit"
"""What someone who is not served would need: more pretension, less, or another suit."""
_NEEDS = {
    MORE: "would need more",
    LESS: "would need less",
    NEITHER: "cannot be served by any pretension",
}
_HOW_MANY = ("one suit", "two suits", "three suits")


def parameter(key: str, value: float | str) -> str:
    """A number of a study with its symbol, by its key; as a record has it."""
    return say.parameter(
        keys()[key].number.quantity, math.inf if value == RIGID else float(value), say.side_of(key)
    )


def value_words(axis: Axis, value: float | str) -> str:
    """What a choice or a condition has of an axis."""
    return axis.named(str(value)) if axis.names else parameter(axis.key, value)


def row_words(product: Space, row: Row) -> str:
    """A choice: what it has of each axis; empty if there is none."""
    return ", ".join(value_words(axis, row[axis.column]) for axis in product.axes)


def condition_words(conditions: Space, condition: int, *, but_first: bool = False) -> str:
    """A condition by its row of conditions.parquet; `but_first` leaves out the person or draw that it is of."""
    at = {name: values[0] for name, values in conditions.columns(np.array([condition])).items()}
    axes = conditions.axes[int(but_first) :]
    values = (axis.names[int(at[axis.column])] if axis.names else at[axis.column] for axis in axes)
    return ", ".join(value_words(axis, value) for axis, value in zip(axes, values, strict=True))


COSTS = {"max_tension": "tension", "max_spring_extension": "spring", "peak_motor_torque": "torque"}
"""What a choice costs, and the heads of these columns in small tables."""


def costs(row: Row) -> list[str]:
    """What a choice costs, in words."""
    return ["-" if row[name] is None else say.quantity(name, row[name]) for name in COSTS]


def everyone(counts: Mapping[str, int], count: int, kind: str) -> str:
    """What a share is of: "1,000 persons", "this person's 256 draws", "192 pairs of 3 persons and 64 draws"."""
    persons, draws = (counts.get(key, 0) for key in ("person", "draw"))
    if persons == 1 and draws > 1:
        return f"this person's {say.counted(draws, 'draw')}"
    if persons > 1 and draws > 1 and kind == "pairs":
        return (
            f"{count:,} pairs of {say.counted(persons, 'person')} and {say.counted(draws, 'draw')}"
        )
    return f"this {kind[:-1]}" if count == 1 else say.counted(count, kind[:-1])


def ends_of(row: Row) -> tuple[Any, float]:
    """The ends of a row's window, N, as recorded; the upper one infinite if there is none."""
    return row["pretension_from"], np.inf if row["pretension_to"] is None else row["pretension_to"]


def end_words(problem: Problem, row: Row, end: str) -> str:
    """One end of a window, with what binds there."""
    limit, value = row[f"{end}_by"], row[f"pretension_{end}"]
    if limit is None:
        return "no lower limit: taut without pretension" if end == "from" else "no upper limit"
    word = "below" if end == "from" else "above"
    return f"{word} {say.number(value)} N {broken(problem, limit)}{where(problem, row, end)}"


def broken(problem: Problem, limit: str) -> str:
    """What it means that a limit of the study is not kept."""
    return say.limit_words(limit, problem.study.limits).broken


def where(problem: Problem, row: Row, end: str) -> str:
    """The condition and the state that bind, in brackets."""
    words = [condition_words(problem.conditions, row[f"{end}_condition"])]
    if row[f"{end}_direction"] is not None:
        words += [row[f"{end}_direction"], say.quantity("elbow_angle", row[f"{end}_elbow_angle"])]
    inside = ", ".join(word for word in words if word)
    return f" ({inside})" if inside else ""


def margins(problem: Problem, row: Row) -> str:
    """By what a given pretension lies within, or misses, the window of a choice."""
    (low, high), at = ends_of(row), problem.given
    if at is None or low is None or not low <= high:
        return "there is no window"
    window = say.window(low, high)
    if at < low:
        return f"it is {say.number(low - at, 3)} N less than the window, {window}"
    if at > high:
        return f"it is {say.number(at - high, 3)} N more than the window, {window}"
    upper = "" if np.isinf(high) else f" and {say.number(high - at, 3)} N below the upper end"
    return f"that is {say.number(at - low, 3)} N above the lower end{upper} of the window, {window}"


# --- Persons and draws -----------------------------------------------------------------------------------------------


def why_not(problem: Problem, limits: list[str], conditions: list[int]) -> str:
    """What happens to those not served, under which condition."""
    words = []
    for limit, condition in zip(limits, conditions, strict=False):
        under = condition_words(problem.conditions, condition, but_first=True)
        words.append(broken(problem, limit) + (f" ({under})" if under else ""))
    return " and ".join(words)


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
        return share.replace(
            f"{count:,} draws", f"{'of ' if share.startswith('all') else ''}{whom}"
        )
    return say.sampled_share(served, count, noun, population["effective_count"])


def population_blocks(problem: Problem, population: Row) -> Iterator[say.Block]:
    """What an answer says of persons or draws."""
    what = row_words(problem.choices, population["values"])
    yield say.heading("For whom" if "person" in population["counts"] else "How sure")
    yield from say.items(
        [
            f"{what}: {_served(population)}" if what else _served(population),
            *(["; ".join(map(_of_sex, population["by"]))] if population["by"] else []),
            *(_not_served(population, reason) for reason in population["not_served"]),
        ]
    )
    if population["counts"].get("person", 0) > 1:
        for axis in problem.choices.axes:
            yield from _sizes(
                problem, axis, population["sizes"].get(axis.column), population["counts"]["person"]
            )
    yield from _sobol(population["sobol"])


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
    return (
        f"{words}; {say.number(population['largest_share_at'])} N would serve {say.percent(most)}"
    )


def _of_sex(share: Row) -> str:
    """The share of men, or of women."""
    nouns = {"male": ("man", "men"), "female": ("woman", "women")}[share["sex"]]
    whom = f"{share['persons']:,} {nouns[share['persons'] != 1]}"
    low, high = (say.percent(end) for end in share["interval_95"])
    if share["served"] >= 1.0:
        return f"all of {whom} (at least {low})"
    return f"{say.percent(share['served'])} of {whom} ({low} to {high})"


def _not_served(population: Row, reason: Row) -> str:
    share = f"{say.percent(reason['share'])} " if population["count"] > 1 else ""
    words = f"{share}{_NEEDS[reason['needs']]}: {reason['text']}"
    if population["counts"].get("person", 1) == 1:
        return words
    bodies = [
        f"{say.column(name)} {say.quantity(name, each['theirs'])} against {say.quantity(name, each['of_all'])}"
        for name, each in reason["bodies"].items()
        if abs(each["deviations"]) >= _DIFFERENT
    ]
    names = ", ".join(reason["first"][:_MOST_NAMED]) + (
        ", ..." if reason["count"] > _MOST_NAMED else ""
    )
    return "; ".join([words, *bodies[:2], names])


def _sizes(
    problem: Problem, axis: Axis, sizes: list[Row] | None, of_all: int
) -> Iterator[say.Block]:
    if not sizes:
        return
    few = f", by the first {sizes[0]['persons']:,} persons" if sizes[0]["persons"] < of_all else ""
    thin = "" if sizes[0]["all_values"] else f", among {sizes[0]['values_tried']} of its values"
    of_draws = (
        f" with at least {say.percent(problem.enough)} of their draws"
        if problem.counted == "pairs"
        else ""
    )
    yield say.heading(f"Sizes of {axis.key}{few}{thin}")
    for count, each in enumerate(sizes):
        if count and each["served"] == sizes[count - 1]["served"]:
            yield from say.items(["further sizes serve nobody else"])
            break
        share = say.sampled_share(each["served"], each["persons"], "person") + of_draws
        suits = [
            f"{value_words(axis, one['value'])} at {say.number(one['pretension'])} N"
            for one in each["choices"]
        ]
        yield from say.items([f"{_HOW_MANY[count]}: {share}, {' and '.join(suits) or 'none'}"])


def _sobol(ends: list[Row]) -> Iterator[say.Block]:
    if not ends:
        return
    yield say.heading(
        "Where the uncertainty of the window comes from (Sobol index: first order, total)"
    )
    for each in ends:
        end = "lower" if each["end"] == "pretension_from" else "upper"
        inputs = [
            f"{index['name']} {_index(index, 'first')}, {_index(index, 'total')}"
            for index in sorted(each["inputs"].values(), key=lambda index: -index["total"])
        ]
        deviation = say.number(each["standard_deviation"], 2)
        yield from say.items([f"{end} end, standard deviation {deviation} N: {'; '.join(inputs)}"])
    if "body" in ends[0]["inputs"]:
        yield from say.items(["the dimensions of a body are correlated and count as one input"])


def _index(index: Row, order: str) -> str:
    share, error = 100.0 * max(index[order], 0.0), 100.0 * index[f"{order}_standard_error"]
    return f"{say.number(share, 2)} ± {say.number(error, 1)} %"
