"""People: as many bodies as asked for, drawn from a survey, each with a name and a weighting, and their arms."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import InputError
from tendon_cli.model.body import (
    DIMENSIONS,
    Body,
    anchor_scales,
    forearm_com,
    forearm_mass,
    load_distance,
)
from tendon_cli.model.kinematics import Array
from tendon_cli.studies.people.persons_csv import read_listed
from tendon_cli.studies.people.survey import LEAST, SEXES, Survey, scattered

MOST_BODIES = 10**6
Sexes = str | npt.NDArray[np.str_]
"""The sex of each person, or the one that the study gives them all."""
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
    completions: int = 1
    """So many of these, one after the other, are the same person, with other draws of what was not measured."""

    def __len__(self) -> int:
        return len(self.names)

    @property
    def body(self) -> Body:
        """All bodies, each dimension of shape (n,)."""
        return Body(*self.values.T)

    @property
    def persons(self) -> tuple[str, ...]:
        """The names of the persons themselves."""
        each = self.names[:: self.completions]
        return (
            tuple(name.rpartition(", body ")[0] for name in each) if self.completions > 1 else each
        )

    def only(self, chosen: slice) -> Population:
        """Some of them."""
        return replace(
            self,
            names=self.names[chosen],
            values=self.values[chosen],
            weighting=self.weighting[chosen],
            sexes=self.sexes[chosen],
        )


def draw(survey: Survey, sex: str, count: int, seed: int, women: float | None = None) -> Population:
    """`count` persons of a survey: "male", "female" or "both", men first, `women` being the share of women among these.

    The first persons of a seed are the same whatever the count, of each sex.
    """
    share = {"male": 0.0, "female": 1.0}.get(sex, survey.share_of_women if women is None else women)
    females = round(share * count)
    values, names, sexes = [], list[str](), list[str]()
    for number, (word, persons) in enumerate((("man", count - females), ("woman", females))):
        kind, random = SEXES[number], np.random.default_rng([seed, number])
        statistics = survey.of(kind)
        normal, mean = (
            random.standard_normal((persons, len(DIMENSIONS))),
            np.tile(statistics.mean, (persons, 1)),
        )
        values.append(np.maximum(scattered(mean, statistics.factor, normal), statistics.least))
        names += [f"{word} {at + 1}" for at in range(persons)]
        sexes += [kind] * persons
    note = "bodies are drawn as normal and correlated; real ones have longer tails, of weight above all; "
    note += f"no dimension is drawn below the mean less {LEAST:g} standard deviations"
    bodies = np.concatenate(values)
    return Population(
        tuple(names), bodies, np.ones(count), survey.male.mean_body, (note,), tuple(sexes)
    )


def read_population(
    content: bytes,
    where: str,
    survey: Survey,
    sex: str,
    women: float | None = None,
    completions: int | None = None,
    seed: int = 1,
) -> Population:
    """Persons of a CSV file, what it does not say of their bodies as a survey leads to expect of people of that sex.

    With `completions` each is so many bodies, what was not measured drawn by the survey given what was. Raises
    InputError.
    """
    rows = read_listed(content, where)
    sexes = sex if rows.sexes is None else rows.sexes
    one = (
        [f"{where} has 1 person: a share of it is all or nothing"]
        if len(rows.names) == 1 and not completions
        else []
    )
    notes = [*one, *_notes(rows.values, sexes, women, completions), *rows.ignored]
    names, values, weighting, normal = rows.names, rows.values, rows.weighting, None
    each = completions or 1
    if completions:
        if len(names) * each > MOST_BODIES:
            problem = f"{len(names):,} persons of {each:,} bodies are {len(names) * each:,}"
            raise InputError(f"{problem}, expected {MOST_BODIES:,} at most", where=where)
        names = tuple(f"{name}, body {at + 1}" for name in names for at in range(each))
        values, weighting = np.repeat(values, each, axis=0), np.repeat(weighting / each, each)
        sexes = sexes if isinstance(sexes, str) else np.repeat(sexes, each)
        normal = np.random.default_rng([seed, len(SEXES)]).standard_normal(values.shape)
    completed = _completed(values, normal, sexes, survey, women)
    known = (
        ()
        if isinstance(sexes, str) and sexes not in SEXES
        else np.broadcast_to(sexes, len(names)).tolist()
    )
    return Population(
        names, completed, weighting, survey.male.mean_body, tuple(notes), tuple(known), each
    )


def named(survey: Survey, name: str) -> Population:
    """One of the persons that every survey has, by one of `NAMED`."""
    body = (survey.male, survey.female)[NAMED.index(name)].mean
    return Population((name,), body[np.newaxis], np.ones(1), survey.male.mean_body)


def arms_of(
    people: Population, of_the_body: Iterable[str]
) -> tuple[dict[str, Array], dict[str, Array]]:
    """The numbers of the persons' arms that their bodies set, and by what they scale others, by dotted key, (n,).

    `of_the_body` are those of `OF_THE_BODY` that a study does not state itself.
    """
    body = people.body
    scales = {f"arm.{name}": scale for name, scale in anchor_scales(body, people.reference).items()}
    return {name: OF_THE_BODY[name](body) for name in of_the_body}, scales


def _completed(
    values: Array, normal: Array | None, sexes: Sexes, survey: Survey, women: float | None
) -> Array:
    if isinstance(sexes, str):
        return (survey.both(women) if sexes == "both" else survey.of(sexes)).completed(
            values, normal
        )
    completed = values.copy()
    for sex in SEXES:
        some = sexes == sex
        completed[some] = survey.of(sex).completed(
            values[some], None if normal is None else normal[some]
        )
    return completed


def _notes(values: Array, sexes: Sexes, women: float | None, completions: int | None) -> list[str]:
    """What is not from the file but expected of such bodies."""
    missing = np.isnan(values)
    lacking = [
        f"{name} of {count}"
        for name, count in zip(DIMENSIONS, missing.sum(axis=0), strict=True)
        if count
    ]
    if not lacking:
        return []
    kind = "their sex"
    if isinstance(sexes, str):
        kind = {"both": "men and women mixed", "male": "men", "female": "women"}[sexes]
        kind += f", {women:.0%} women," if sexes == "both" and women is not None else ""
    lacking_text = f"not in the file: {', '.join(lacking)}; "
    if completions:
        drawn = f"{completions} bodies of each person are drawn from {kind} in the survey with the dimensions given"
        return [
            f"{lacking_text}{drawn}, no dimension below the mean less {LEAST:g} standard deviations"
        ]
    expected = f"taken as expected of {kind} in the survey with the dimensions given"
    return [
        f"{lacking_text}{expected}, without the scatter of real bodies (people.completions draws it)"
    ]
