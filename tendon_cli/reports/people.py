"""Whom the best choice serves, person by person, over two measures of the body."""

from __future__ import annotations

from typing import Any

import pyarrow as pa

from tendon_cli import say
from tendon_cli.answers.population_text import population_share
from tendon_cli.cube.axes import evenly
from tendon_cli.cube.columns import as_numpy
from tendon_cli.cube.labels import Shown
from tendon_cli.quantities import QUANTITIES
from tendon_cli.reports.data import number_record, packed_classes

MOST_PERSONS = 5000
_USUAL = ("biceps_circumference", "weight")


def people_record(record: dict[str, Any], persons: pa.Table | None) -> dict[str, Any] | None:
    """What the page draws of the persons of an answer, from their table; None if it was not asked of people."""
    population = record["population"]
    if population is None or persons is None or population["pretension"] is None:
        return None
    kept = evenly(persons.num_rows, MOST_PERSONS)
    named = [dimension for reason in population["not_served"] for dimension in reason["bodies"]]
    first, second = list(dict.fromkeys((*named, *_USUAL)))[:2]
    axes = {}
    for name, dimension in (("x", first), ("y", second)):
        shown = Shown.of(dimension, QUANTITIES[dimension])
        axes[name] = number_record(shown, as_numpy(persons.column(dimension))[kept])
    enough = 1.0 if population["kind"] == "persons" else record["serve"]
    served = as_numpy(persons.column("served"))[kept] >= enough - 1e-9
    title = f"{say.number(population['pretension'])} N serves {population_share(population)}"
    return {**axes, "served": {"array": packed_classes(served)}, "title": title}
