"""Whom the best choice serves, person by person, over two measures of the body."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyarrow as pa

from tendon_cli import say
from tendon_cli.answers.candidates import numbers_of
from tendon_cli.answers.population import windows_of
from tendon_cli.answers.question import question
from tendon_cli.cube.axes import evenly
from tendon_cli.cube.labels import Shown
from tendon_cli.model.body import DIMENSIONS
from tendon_cli.quantities import QUANTITIES
from tendon_cli.reports.data import number_record, packed_classes
from tendon_cli.studies.load import recorded_study
from tendon_cli.tables.read import TableFiles

MOST_PERSONS = 5000
_USUAL = ("biceps_circumference", "weight")


def people_record(table: TableFiles, crowd: dict[str, Any] | None) -> dict[str, Any] | None:
    """What the page draws of the persons of an answer; None where it was not asked of people."""
    if crowd is None or crowd["kind"] != "persons" or crowd["pretension"] is None:
        return None
    problem, choices = question(recorded_study(table.facts["study"])), table.read()
    people = problem.study.people
    if people is None:
        return None
    population = people.population
    row = choices.slice(_row(choices, crowd), 1)
    columns = {each.column: _value(each.names, row.column(each.column)[0].as_py()) for each in problem.choices.axes}
    served = windows_of(problem, numbers_of(problem, columns)).served(crowd["pretension"])
    kept = evenly(len(population), MOST_PERSONS)
    told = [dimension for reason in crowd["not_served"] for dimension in reason["bodies"]]
    first, second = list(dict.fromkeys((*told, *_USUAL)))[:2]
    found = {}
    for name, dimension in (("x", first), ("y", second)):
        shown = Shown.of(dimension, QUANTITIES[dimension])
        found[name] = number_record(shown, population.values[kept, DIMENSIONS.index(dimension)])
    share = say.sampled_share(crowd["served"], crowd["count"], "person", crowd["effective_count"])
    share = f"{say.number(crowd['pretension'])} N serves {share}"
    return {**found, "served": {"array": packed_classes(served[kept])}, "title": share}


def _row(choices: pa.Table, crowd: dict[str, Any]) -> int:
    """The row of the choice that was told of: one between the points of the grid is known by its pretension."""
    if crowd["choice"] is not None:
        return int(crowd["choice"])
    return int(np.nanargmin(np.abs(choices.column("pretension").to_numpy() - crowd["pretension"])))


def _value(names: tuple[str, ...], value: Any) -> np.ndarray[Any, Any]:
    return np.array([names.index(value)] if names else [value])
