"""People: bodies drawn from a survey or completed by it, with names and weights, and their arms."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tendon_cli.model.body import (
    DIMENSIONS,
    Body,
    anchor_scales,
    forearm_com,
    forearm_mass,
    load_distance,
)
from tendon_cli.model.kinematics import Array
from tendon_cli.studies.magnitude import Slip
from tendon_cli.studies.people.persons_csv import read_persons
from tendon_cli.studies.people.survey import LEAST, SEXES, Survey, scattered
from tendon_cli.studies.values import OF_THE_STUDY, Stream, random_numbers
from tendon_cli.units import counted

Sexes = str | npt.NDArray[np.str_]
"""The sex of each person, or the one that the study gives them all."""
STANDARD_PERSONS = ("mean-man", "mean-woman")
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
    """Names, all different."""
    values: Array
    """Bodies, (n, 8), dimensions in the order of `DIMENSIONS`, SI."""
    weighting: Array
    """Weight of each person in a share, (n,), at least 0 and not all 0."""
    reference: Body
    """Mean man of the survey, for whom anchors that were not measured hold as written."""
    notes: tuple[str, ...] = ()
    """Notes on what was assumed about them."""
    sexes: tuple[str, ...] = ()
    """"male" or "female" for each, if that is known."""
    completions: int = 1
    """Number of successive bodies of one person; they differ in draws of what was not measured."""
    is_drawn: bool = False
    """True if what was not measured of the persons of a file is drawn."""
    slips: tuple[Slip, ...] = ()
    """Values of their file that are far from any person."""

    def __len__(self) -> int:
        return len(self.names)

    @property
    def body(self) -> Body:
        """All bodies, each dimension of shape (n,)."""
        return Body(*self.values.T)

    @property
    def persons(self) -> tuple[str, ...]:
        """Names of the persons themselves."""
        names = self.names[:: self.completions]
        if self.completions == 1:
            return names
        return tuple(name.rpartition(", body ")[0] for name in names)

    def only(self, chosen: slice) -> Population:
        """Select persons by a slice."""
        return replace(
            self,
            names=self.names[chosen],
            values=self.values[chosen],
            weighting=self.weighting[chosen],
            sexes=self.sexes[chosen],
        )


def draw(
    survey: Survey,
    sex: str,
    count: int,
    seed: int,
    women: float | None = None,
    stream: Stream = OF_THE_STUDY,
) -> Population:
    """Draw persons of a survey, men first.

    For each sex, the first persons of a seed are the same whatever the count.

    Args:
        survey: The survey.
        sex: "male", "female" or "both".
        count: Number of persons.
        seed: Seed of the draws.
        women: Share of women among both; by default the survey's.
        stream: Stream of the draws.
    """
    both = survey.share_of_women if women is None else women
    share = {"male": 0.0, "female": 1.0}.get(sex, both)
    females = round(share * count)
    values = []
    names: list[str] = []
    sexes: list[str] = []
    for number, (word, persons) in enumerate((("man", count - females), ("woman", females))):
        kind = SEXES[number]
        statistics = survey.of(kind)
        random = random_numbers(seed, number, stream)
        normal = random.standard_normal((persons, len(DIMENSIONS)))
        mean = np.tile(statistics.mean, (persons, 1))
        bodies = scattered(mean, statistics.factor, normal)
        values.append(np.maximum(bodies, statistics.least))
        names += [f"{word} {row + 1}" for row in range(persons)]
        sexes += [kind] * persons
    note = (
        "bodies are drawn from a correlated normal distribution; real ones have longer tails, "
        f"above all in weight; no dimension is drawn over {LEAST:g} standard deviations below its "
        "mean"
    )
    return Population(
        names=tuple(names),
        values=np.concatenate(values),
        weighting=np.ones(count),
        reference=survey.male.mean_body,
        notes=(note,),
        sexes=tuple(sexes),
    )


def read_population(
    content: bytes,
    where: str,
    survey: Survey,
    sex: str,
    women: float | None = None,
    bodies: int = 0,
    seed: int = 1,
    stream: Stream = OF_THE_STUDY,
    *,
    accepts_slips: bool = True,
) -> Population:
    """Return the persons of a CSV file, completed by a survey.

    Dimensions that the file does not have are drawn from the survey for people of that sex with the
    dimensions given, or are those that it expects of them.

    Args:
        content: The file.
        where: Name of the file in errors.
        survey: The survey.
        sex: "male", "female" or "both", of persons whose sex the file does not say.
        women: Share of women among both; by default the survey's.
        bodies: Number of bodies that the persons have together, at least, if a dimension is
            missing, the same number each; 0 draws nothing.
        seed: Seed of the draws.
        stream: Stream of the draws.
        accepts_slips: As `read_persons` takes it.

    Raises:
        InputError: The file cannot be used.
    """
    rows = read_persons(content, where, accepts_slips=accepts_slips)
    sexes = sex if rows.sexes is None else rows.sexes
    persons = len(rows.names)
    is_drawn = bodies > 0 and bool(np.isnan(rows.values).any())
    completions = math.ceil(bodies / persons) if is_drawn else 1
    notes = []
    if persons == completions == 1:
        notes.append(f"{where} has 1 person: a share of it is all or nothing")
    notes += [*_notes(rows.values, sexes, women, completions if is_drawn else 0), *rows.ignored]
    names = rows.names
    values = np.repeat(rows.values, completions, axis=0)
    weighting = np.repeat(rows.weighting / completions, completions)
    if completions > 1:
        names = tuple(f"{name}, body {body + 1}" for name in names for body in range(completions))
    if not isinstance(sexes, str):
        sexes = np.repeat(sexes, completions)
    normal = None
    if is_drawn:
        normal = random_numbers(seed, len(SEXES), stream).standard_normal(values.shape)
    known_sexes: tuple[str, ...] = ()
    if not isinstance(sexes, str) or sexes in SEXES:
        known_sexes = tuple(np.broadcast_to(sexes, len(names)).tolist())
    return Population(
        names=names,
        values=_completed(values, normal, sexes, survey, women),
        weighting=weighting,
        reference=survey.male.mean_body,
        notes=tuple(notes),
        sexes=known_sexes,
        completions=completions,
        is_drawn=is_drawn,
        slips=rows.slips,
    )


def standard_person(survey: Survey, name: str) -> Population:
    """Return one of the persons that every survey has, by one of `STANDARD_PERSONS`."""
    statistics = (survey.male, survey.female)[STANDARD_PERSONS.index(name)]
    return Population((name,), statistics.mean[np.newaxis], np.ones(1), survey.male.mean_body)


def arms_of(
    people: Population, of_the_body: Iterable[str], measured: Collection[str] = ()
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return the numbers of the persons' arms that come from their bodies.

    Args:
        people: Persons.
        of_the_body: Keys of `OF_THE_BODY` that a study does not state itself.
        measured: Names of the anchors that were measured on the wearer, and have no factor.

    Returns:
        Numbers that the bodies set, and factors by which they scale others, by dotted key, (n,).
    """
    body = people.body
    sets = {key: OF_THE_BODY[key](body) for key in of_the_body}
    scales = {
        f"arm.{name}": scale
        for name, scale in anchor_scales(body, people.reference).items()
        if name not in measured
    }
    return sets, scales


def _completed(
    values: Array, normal: Array | None, sexes: Sexes, survey: Survey, women: float | None
) -> Array:
    """Complete bodies, (n, 8), by the statistics of their sex; with normal numbers they scatter."""
    if isinstance(sexes, str):
        statistics = survey.both(women) if sexes == "both" else survey.of(sexes)
        return statistics.completed(values, normal)
    completed = values.copy()
    for sex in SEXES:
        is_sex = sexes == sex
        of_sex = None if normal is None else normal[is_sex]
        completed[is_sex] = survey.of(sex).completed(values[is_sex], of_sex)
    return completed


def _notes(values: Array, sexes: Sexes, women: float | None, completions: int) -> list[str]:
    """Return a note on the dimensions that the file lacks, and where they come from, if any."""
    missing = np.isnan(values).sum(axis=0)
    lacking = []
    for count in sorted({int(count) for count in missing if count}, reverse=True):
        names = [name for name, lost in zip(DIMENSIONS, missing, strict=True) if lost == count]
        lacking.append(f"{', '.join(names)} of {counted(count, 'person')}")
    if not lacking:
        return []
    kind = "their sex"
    if isinstance(sexes, str):
        kind = {"both": "men and women mixed", "male": "men", "female": "women"}[sexes]
        if sexes == "both" and women is not None:
            kind += f", {women:.0%} women,"
    note = f"missing from the file: {', and '.join(lacking)}; "
    if completions:
        bodies = "1 body" if completions == 1 else f"{completions} bodies"
        note += (
            f"each person has {bodies}, drawn from {kind} in the survey, given the known "
            f"dimensions, no dimension over {LEAST:g} standard deviations below its mean"
        )
    else:
        note += f"each is the survey's expected value for {kind}, given the known dimensions"
    return [note]
