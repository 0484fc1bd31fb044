"""The figures of persons and draws, into the folder of an answer."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tendon_cli import say
from tendon_cli.answers.population import PopulationResult
from tendon_cli.answers.population_text import input_name, why_not
from tendon_cli.answers.words import Row, row_words
from tendon_cli.figures.population import Bars, Group, draw_for_whom, draw_how_sure
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.quantities import QUANTITIES

FOR_WHOM, HOW_SURE = "for_whom.png", "how_sure.png"
_USUAL = ("weight", "forearm_circumference")


def draw_population(population: PopulationResult, record: Row, folder: Path) -> list[str]:
    """Draw all that there is to be drawn; returns the files' names. Raises OutputError."""
    of_record = record["population"]
    what = row_words(population.problem.choices, of_record["values"])
    share = say.sampled_share(population.share, of_record["count"], of_record["kind"][:-1])
    title = ", ".join(filter(None, (what, f"serves {share}")))
    _for_whom(population, of_record, folder / FOR_WHOM, title)
    _how_sure(population, folder / HOW_SURE, title)
    return [FOR_WHOM, HOW_SURE]


def _for_whom(population: PopulationResult, of_record: Row, path: Path, title: str) -> None:
    windows, solutions = population.windows, population.chosen.solutions
    band = float(solutions.pretension_from[0]), float(solutions.pretension_to[0])
    bodies, labels, groups = None, ("", ""), []
    if population.people is not None:
        names = _most_different(population)
        body = population.people.body
        first, second = (np.asarray(getattr(body, name)) / say.factor_of(QUANTITIES[name]) for name in names)
        person = population.problem.person_of(np.arange(len(windows.low)))
        bodies = first[person], second[person]
        labels = _body_label(names[0]), _body_label(names[1])
        groups = [
            Group(why_not(population.problem, words), reason.members)
            for reason, words in zip(population.reasons[:4], of_record["not_served"], strict=False)
        ]
    draw_for_whom(
        path, title, windows.low, windows.high, windows.served(population.pretension),
        band if band[0] <= band[1] else (np.nan, np.nan), population.pretension,
        bodies, labels, groups, population.kind,
    )  # fmt: skip


def _body_label(name: str) -> str:
    return f"{say.column(name)} ({QUANTITIES[name].shown_in})"


def _most_different(population: PopulationResult) -> tuple[str, str]:
    """The two dimensions in which those left out differ most, whatever the reason."""
    apart = dict.fromkeys(DIMENSIONS, 0.0)
    for reason in population.reasons:
        for each in reason.differences:
            apart[each.dimension] += reason.share * abs(each.deviations)
    if not population.reasons:
        return _USUAL
    first, second = sorted(apart, key=lambda name: -apart[name])[:2]
    return first, second


def _how_sure(population: PopulationResult, path: Path, title: str) -> None:
    curve = population.curve
    bars = [
        Bars(f"{'lower' if each.end == 'pretension_from' else 'upper'} end, ± {say.number(each.deviation, 2)} N",
             each.first, each.first_error, each.total, each.total_error)
        for each in population.indices
    ]  # fmt: skip
    inputs = [input_name(name) for name in population.indices[0].inputs] if population.indices else []
    draw_how_sure(
        path, title, curve.pretension, curve.share, curve.low, curve.high, population.pretension,
        population.problem.enough, inputs, bars,
    )  # fmt: skip
