"""People: as many bodies as asked for, drawn from a survey, each with a name and a weighting, and their arms."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from tendon_cli.model.body import DIMENSIONS, Body, anchor_scales, forearm_com, forearm_mass, load_distance
from tendon_cli.model.kinematics import Array
from tendon_cli.studies.people.survey import SEXES, Statistics, Survey

NAMED = ("mean-man", "mean-woman")
"""Persons that every survey has."""

OF_THE_BODY = {
    "arm.forearm_mass": forearm_mass,
    "arm.forearm_com": forearm_com,
    "arm.load_distance": load_distance,
}
"""Numbers that come from the body, unless a study states them."""


@dataclass(frozen=True, eq=False)
class Population:
    """Persons, in the order of their numbers."""

    names: tuple[str, ...]
    """Each once."""
    values: Array
    """Their bodies, shape (n, 8), dimensions in the order of `DIMENSIONS`, SI units."""
    weighting: Array
    """How much each counts in a share, shape (n,), at least 0 and not all 0."""
    reference: Body
    """The survey's mean man, on whom the study's anchors stand as written."""
    notes: tuple[str, ...] = ()
    """What was supposed of them."""
    sexes: tuple[str, ...] = ()
    """"male" or "female" for each, if that is known."""

    def __len__(self) -> int:
        return len(self.names)

    @property
    def body(self) -> Body:
        """All bodies, each dimension of shape (n,)."""
        return Body(*self.values.T)

    def only(self, chosen: slice) -> Population:
        """Some of them."""
        return replace(self, names=self.names[chosen], values=self.values[chosen], weighting=self.weighting[chosen],
                       sexes=self.sexes[chosen])  # fmt: skip


def draw(survey: Survey, sex: str, count: int, seed: int, women: float | None = None) -> Population:
    """`count` persons of a survey: "male", "female" or "both", men first, `women` being the share of women among these.

    The first persons of a seed are the same whatever the count, of each sex.
    """
    if sex == "both":
        share = survey.share_of_women if women is None else women
        counts = {"female": round(share * count)}
        counts["male"] = count - counts["female"]
    else:
        counts = {sex: count}
    values, names, sexes = [np.empty((0, len(DIMENSIONS)))], [], []
    for number, (kind, word) in enumerate(zip(SEXES, ("man", "woman"), strict=True)):
        persons = counts.get(kind, 0)
        values.append(_bodies(survey.of(kind), persons, np.random.default_rng([seed, number])))
        names += [f"{word} {at + 1}" for at in range(persons)]
        sexes += [kind] * persons
    note = "bodies are drawn as normal and correlated; real ones have longer tails, of weight above all"
    return Population(
        tuple(names), np.concatenate(values), np.ones(count), survey.male.mean_body, (note,), tuple(sexes)
    )


def named(survey: Survey, name: str) -> Population:
    """One of the persons that every survey has, by one of `NAMED`."""
    body = (survey.male, survey.female)[NAMED.index(name)].mean
    return Population((name,), body[np.newaxis], np.ones(1), survey.male.mean_body)


def arms_of(people: Population, of_the_body: Iterable[str]) -> tuple[dict[str, Array], dict[str, Array]]:
    """The numbers of the persons' arms that their bodies set, and by what they scale others, by dotted key, (n,).

    `of_the_body` are those of `OF_THE_BODY` that a study does not state itself.
    """
    body = people.body
    scales = {f"arm.{name}": scale for name, scale in anchor_scales(body, people.reference).items()}
    return {name: OF_THE_BODY[name](body) for name in of_the_body}, scales


def _bodies(statistics: Statistics, count: int, random: np.random.Generator) -> Array:
    """Correlated normal bodies, shape (count, 8)."""
    normal = random.standard_normal((count, len(DIMENSIONS)))
    bodies = np.tile(statistics.mean, (count, 1))
    for row, factors in enumerate(statistics.factor):  # added up in this order everywhere, unlike a matrix product
        for column in range(row + 1):
            bodies[:, row] += factors[column] * normal[:, column]
    return bodies
