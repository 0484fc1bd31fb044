"""The figures of persons and draws, from the record of an answer and their table."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.answers.question import Problem
from tendon_cli.answers.tables import members, person_columns
from tendon_cli.answers.words import Row, input_name, population_share, row_words, why_not
from tendon_cli.figures.population import Bars, Group, draw_for_whom, draw_how_sure
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.quantities import QUANTITIES
from tendon_cli.tables.read import arrays_of, open_table
from tendon_cli.units import factor_of

FOR_WHOM, HOW_SURE = "for_whom.png", "how_sure.png"
_USUAL = ("weight", "forearm_circumference")

Arrays = Mapping[str, np.ndarray[Any, Any]]
"""The table of persons or draws, by column."""


def draw_population(problem: Problem, record: Row, folder: Path, place: Path) -> list[str]:
    """Draw what there is of persons or draws, from the tables of a folder into a place; returns the files' names.

    Raises InputError, OutputError.
    """
    population, axis = record["population"], problem.one_by_one
    if axis is None:
        return []
    rows = arrays_of(person_columns(problem, axis), open_table(folder / f"{axis.key}s.parquet").read())
    what = row_words(problem.choices, population["values"])
    title = ", ".join(filter(None, (what, f"serves {population_share(population)}")))
    _for_whom(problem, record, rows, place / FOR_WHOM, title)
    _how_sure(problem, population, place / HOW_SURE, title)
    return [FOR_WHOM, HOW_SURE]


def _number(value: float | None) -> float:
    return np.nan if value is None else float(value)


def _for_whom(problem: Problem, record: Row, rows: Arrays, path: Path, title: str) -> None:
    population = record["population"]
    pretension = _number(population["pretension"])
    band = _number(population["window"][0]), _number(population["window"][1])
    bodies, labels, groups = None, ("", ""), []
    if "weight" in rows:
        names = _most_different(population)
        first, second = (rows[name] / factor_of(QUANTITIES[name].shown_in) for name in names)
        bodies = first, second
        labels = _body_label(names[0]), _body_label(names[1])
        reasons = population["not_served"][:4]
        groups = [Group(why_not(problem, each), members(rows, each, pretension)) for each in reasons]
    high = np.where(np.isnan(rows["pretension_to"]) & ~np.isnan(rows["pretension_from"]), np.inf, rows["pretension_to"])
    kind = "draws" if population["kind"] == "draws" else "persons"
    draw_for_whom(
        path, title, rows["pretension_from"], high, rows["served"] >= min(1.0, problem.enough) - 1e-9, band, pretension,
        bodies, labels, groups, kind,
    )  # fmt: skip


def _body_label(name: str) -> str:
    return f"{say.column(name)} ({QUANTITIES[name].shown_in})"


def _most_different(population: Row) -> tuple[str, str]:
    """The two dimensions in which those not served differ most, whatever the reason."""
    apart = dict.fromkeys(DIMENSIONS, 0.0)
    for reason in population["not_served"]:
        for name, each in reason["bodies"].items():
            apart[name] += reason["share"] * abs(each["deviations"])
    if not population["not_served"]:
        return _USUAL
    first, second = sorted(apart, key=lambda name: -apart[name])[:2]
    return first, second


def _how_sure(problem: Problem, population: Row, path: Path, title: str) -> None:
    curve = {name: np.array(values) for name, values in population["curve"].items()}
    bars = []
    for end in population["sobol"]:
        which = "lower" if end["end"] == "pretension_from" else "upper"
        label = f"{which} end, ± {say.number(end['standard_deviation'], 2)} N"
        columns = ("first", "first_standard_error", "total", "total_standard_error")
        bars.append(Bars(label, *(np.array([each[name] for each in end["inputs"].values()]) for name in columns)))
    inputs = [input_name(name) for name in population["sobol"][0]["inputs"]] if population["sobol"] else []
    draw_how_sure(
        path, title, curve["pretension"], curve["share"], curve["low"], curve["high"],
        _number(population["pretension"]), problem.enough, inputs, bars,
    )  # fmt: skip
