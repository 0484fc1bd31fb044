"""A fresh sample of a study: persons or draws that had no part in a choice, and so may judge it.

Whoever chooses among suits by a sample takes the one that this sample happens to favour, so that
its share among the same persons is too large. Fresh ones of the same law come from other streams of
the same seeds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tendon_cli.model.kinematics import Array, Rows
from tendon_cli.studies.answer_draws import draws_of
from tendon_cli.studies.space.axis import DRAW_AXIS, Axis, Numbers, evenly_spaced
from tendon_cli.studies.spaces import person_axis
from tendon_cli.studies.study import Study
from tendon_cli.studies.values import (
    OF_FRESH_BODIES,
    OF_FRESH_DRAWS,
    OF_SECOND_BODIES,
    OF_SECOND_DRAWS,
)


@dataclass(frozen=True, eq=False)
class FreshSample:
    """Fresh persons with a draw each of the uncertain numbers, or fresh draws."""

    axis: Axis
    """Axis of the members, in place of the study's axes of persons and draws."""
    strata: Rows
    """Stratum of each member, (members,): a sex, or a person of a file, of whom the sample has
    given numbers. Members of a stratum have one weight."""
    sexes: tuple[str, ...] = ()
    """"male" or "female" for each person that is drawn; empty if that is not known."""
    persons: int = 0
    """Number of persons of a file, for all of whom there are draws; 0 if persons, too, are drawn,
    or if there are none."""
    draws_persons: bool = False
    """True if the members are persons that are drawn."""

    def __len__(self) -> int:
        return len(self.strata)

    @property
    def weighting(self) -> Array:
        """Weight of each member, (members,)."""
        return np.ones(len(self)) if self.axis.weighting is None else self.axis.weighting

    def thinned(self, most: int) -> FreshSample:
        """Return a sample of at most so many of these members; all of them for persons of a file.

        Args:
            most: Largest number of members.
        """
        if self.persons or len(self) <= most:
            return self
        rows = evenly_spaced(len(self), most)
        numbers = {key: values[rows] for key, values in self.axis.numbers.items()}
        sexes = tuple(self.sexes[row] for row in rows) if self.sexes else ()
        axis = _axis(numbers, self.weighting[rows])
        return replace(self, axis=axis, strata=self.strata[rows], sexes=sexes)


def fresh_sample(study: Study, *, second: bool = False) -> FreshSample | None:
    """Return a fresh sample of a study, of about as many members as `[design] verify` says.

    There are two, of independent streams: the best choices are set by the second sample, and the
    last one, which had no part in choosing or setting, judges.

    The members of persons of a file are the same persons, each with as many draws of what was not
    measured and of the uncertain numbers.

    Args:
        study: The study.
        second: True for the sample by which choices are set.

    Returns:
        The sample; None if the study wants none, or draws nothing.
    """
    bodies_stream = OF_SECOND_BODIES if second else OF_FRESH_BODIES
    stream = OF_SECOND_DRAWS if second else OF_FRESH_DRAWS
    count = study.design.verify
    people = study.people
    if not count or (people is None and study.drawing is None):
        return None
    if people is None:
        axis = _axis(draws_of(study, count, stream), np.ones(count))
        return FreshSample(axis, np.zeros(count, dtype=np.int64))
    bodies = people.fresh(count, bodies_stream)
    if not people.is_from_file:
        numbers = person_axis(study, draws_of(study, count, stream), bodies).numbers
        return FreshSample(
            _axis(numbers, bodies.weighting),
            np.unique(bodies.sexes, return_inverse=True)[1],
            sexes=bodies.sexes,
            draws_persons=True,
        )
    if study.drawing is None and not bodies.is_drawn:
        return None
    persons = len(bodies.persons)
    repeats = 1 if bodies.is_drawn else max(1, count // persons)
    rows = np.repeat(np.arange(len(bodies)), repeats)
    of_bodies = person_axis(study, {}, bodies).numbers
    numbers = draws_of(study, len(rows), stream)
    numbers |= {key: values[rows] for key, values in of_bodies.items()}
    return FreshSample(
        _axis(numbers, bodies.weighting[rows]),
        np.repeat(np.arange(persons), repeats * bodies.completions),
        persons=persons,
    )


def _axis(numbers: Numbers, weighting: Array) -> Axis:
    """Return the axis of the members of a sample."""
    axis = Axis.of_points(numbers, len(weighting))
    return replace(axis, key=DRAW_AXIS, role="draw", weighting=weighting)
