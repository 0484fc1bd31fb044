"""From a study to the question that it asks: its choices, its conditions, its limits, and what is left out."""

from __future__ import annotations

import math

import numpy as np

from tendon_cli.answers.factors import PRETENSION, Combinations, Factor, factors_of
from tendon_cli.answers.problem import Problem
from tendon_cli.space.inputs import bounds_of
from tendon_cli.studies.checks import case_numbers
from tendon_cli.studies.study import DRAW_AXIS, PERSON_AXIS, Study, split_side

_SEVERAL = ("peak_motor_power", "max_motor_work_in", "max_friction_loss", "min_efficiency")


def question(study: Study) -> Problem:
    """What a study asks of `tendon design`."""
    factors = factors_of(study)
    conditions = set(study.conditions)
    return Problem(
        study=study,
        choices=Combinations(tuple(factor for factor in factors if factor.key not in conditions)),
        conditions=conditions_of([factor for factor in factors if factor.key in conditions]),
        bounds=bounds_of(study),
        enough=study.serve,
        middle=study.design.pretension == "middle",
        notes=(*study.warnings, *_left_out(study), *_of_people_and_draws(study)),
    )


def conditions_of(factors: list[Factor]) -> Combinations:
    """Conditions in groups by persons, or by draws where there are no persons.

    One of these is served by a pretension that all its other conditions allow, and counts as much as it is weighted.
    """
    whose = next((factor for key in (PERSON_AXIS, DRAW_AXIS) for factor in factors if factor.key == key), None)
    if whose is None:
        return Combinations(tuple(factors))
    others = tuple(factor for factor in factors if factor is not whose)
    each = math.prod(len(factor) for factor in others)
    weighting = np.ones(len(whose)) if whose.weighting is None else whose.weighting
    groups = np.repeat(np.arange(len(whose)), each)
    return Combinations((whose, *others), weighting=np.repeat(weighting, each), groups=groups)


def _left_out(study: Study) -> list[str]:
    """What the study says of pretension, which is solved for."""
    given = [key for key in study.numbers if split_side(key)[0] == PRETENSION]
    notes = []
    if any(split_side(key)[1] for key in given):
        notes.append("the study's pretensions per side are left out: one of both sides is solved for")
    if any(study.numbers[key].is_axis for key in given):
        notes.append("the study's values of pretension are left out: the window is found exactly, without them")
    if any(split_side(key)[0] == PRETENSION for case in study.cases for key in case_numbers(case)):
        notes.append("the pretensions of the study's cases are left out: one of all is solved for")
    several = [name for name in _SEVERAL if name in study.limits]
    if several:
        notes.append(f"{', '.join(several)}: where several intervals of pretension keep to this, the widest is used")
    return notes


def _of_people_and_draws(study: Study) -> list[str]:
    """What was supposed of persons, and where doubt is asked for and none is stated, or stated and not asked for."""
    drawn = study.people is not None and study.people.content is None
    notes = list(study.people.population.notes) if study.people is not None and drawn else []
    if study.uncertain and study.uncertainty is None:
        notes.append("uncertain numbers stand at their middle; [uncertainty] draws them")
    if study.uncertainty is not None and not study.uncertain:
        notes.append("nothing in this study is uncertain, so that [uncertainty] draws nothing")
    return notes
