"""Persons of whom everything was measured, so that no body is drawn of them."""

from tendon_cli.model.body import DIMENSIONS
from tendon_cli.studies.people.population import read_population
from tendon_cli.studies.people.survey import ansur2


def in_full(text):
    """Return the text of a file of persons with what it lacks at its expected value."""
    people = read_population(text.encode(), "people.csv", ansur2(), "both")
    header = ["name", *(f"{name} ({'kg' if name == 'weight' else 'm'})" for name in DIMENSIONS)]
    lines = [",".join([*header, "weighting"])]
    for name, body, weighting in zip(people.names, people.values, people.weighting, strict=True):
        lines.append(",".join([name, *map(repr, body.tolist()), repr(float(weighting))]))
    return "\n".join(lines) + "\n"
