"""One person of a study: the same study on that arm alone, and how the arm comes from the body."""

from __future__ import annotations

from dataclasses import dataclass

from tendon_cli.errors import UsageError
from tendon_cli.model.body import (
    ANCHOR_ALONG,
    DIMENSIONS,
    FOREARM_COM_SHARE,
    FOREARM_MASS_SHARE,
    stiffness_scale,
)
from tendon_cli.model.kinematics import Real
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.fields import hint_at_nearest
from tendon_cli.studies.people.population import (
    OF_THE_BODY,
    STANDARD_PERSONS,
    Population,
    arms_of,
    standard_person,
)
from tendon_cli.studies.people.survey import ansur2
from tendon_cli.studies.study import Study
from tendon_cli.studies.values import StudyNumber
from tendon_cli.units import shorten

_NAMES_SHOWN = 5  # in a message
_NAMES_SEARCHED = 10_000  # for one that is nearly the one asked for
_FORMULAS = {
    "forearm_mass": (FOREARM_MASS_SHARE, "weight", "Winter"),
    "forearm_com": (FOREARM_COM_SHARE, "radiale_stylion_length", "Winter"),
    "load_distance": (1.0, "forearm_grip_length", ""),
}
"""Numbers of the arm that are a share of a dimension of the body: share, dimension and source."""


@dataclass(frozen=True)
class Step:
    """A dimension of the body, or a number of the arm and how it comes from the body; SI."""

    quantity: str
    """Name in `QUANTITIES`."""
    formula: str
    """Formula, or the long name of a dimension."""
    value: float
    source: str = ""
    """Author of the formula."""


@dataclass(frozen=True, eq=False)
class PersonStudy:
    """A study on the arm of one person."""

    name: str
    study: Study
    """Study without people, its arm that of the person."""
    body: tuple[Step, ...]
    """Dimensions of the person."""
    arm: tuple[Step, ...]
    """Numbers of the arm."""


def person_study(study: Study, name: str) -> PersonStudy:
    """Return a study on the arm of one person, and how this arm comes from the body.

    Args:
        study: A study, with people or without.
        name: One of its persons, or one of `STANDARD_PERSONS`.

    Raises:
        UsageError: There is no such person, or the study's anchors were measured on another one.
    """
    measured = study.measured_anchors
    if measured and name in STANDARD_PERSONS:
        problem = f"the anchors of this study were measured on its wearer, not on the {name}"
        hint = 'arm.anchors = "mean man" scales them, if they are the mean man\'s'
        raise UsageError(problem, hint=hint)
    person = _person(study, name)
    dimensions = dict(zip(DIMENSIONS, map(float, person.values[0]), strict=True))
    stated = {f"arm.{key}" for key in study.arm.model_fields_set}
    sets, scales = arms_of(person, [key for key in OF_THE_BODY if key not in stated], measured)
    steps: list[Step] = []
    numbers: dict[str, StudyNumber] = {}
    for anchor, dimension in ANCHOR_ALONG.items():
        given = study.numbers[f"arm.{anchor}"]
        if anchor in measured:
            steps.append(Step(anchor, "as measured on this person", given.array[0]))
            continue
        numbers[anchor] = _scaled(given, scales[f"arm.{anchor}"])
        symbol = QUANTITIES[dimension].symbol
        of_mean_man = getattr(person.reference, dimension)
        formula = f"{given.array[0]:.6g} x {symbol} / {of_mean_man:.6g} of the mean man"
        steps.append(Step(anchor, formula, numbers[anchor].array[0]))
    for number, (share, dimension, source) in _FORMULAS.items():
        key = f"arm.{number}"
        if key not in sets:
            value = float(study.numbers[key].array[0])
            steps.append(Step(number, "as the study states it", value))
            continue
        numbers[number] = StudyNumber.of(float(sets[key][0]))
        symbol = QUANTITIES[dimension].symbol
        formula = symbol if share == 1.0 else f"{share:g} x {symbol}"
        steps.append(Step(number, formula, numbers[number].single, source))
    arm = study.arm.model_copy(update=numbers)
    joint = study.joint
    if joint.stiffness_with is not None:
        given = study.numbers["joint.stiffness"]
        stiffness = _scaled(given, stiffness_scale(person.body, person.reference))
        joint = joint.model_copy(update={"stiffness": stiffness})
        formula = f"{given.array[0]:.6g} x arm volume / that of the mean man"
        steps.append(Step("joint_stiffness", formula, stiffness.array[0]))
    return PersonStudy(
        name=person.names[0],
        study=study.replaced({"arm": arm, "joint": joint, "people": None}),
        body=tuple(
            Step(dimension, QUANTITIES[dimension].long_name, value)
            for dimension, value in dimensions.items()
        ),
        arm=tuple(steps),
    )


def _scaled(given: StudyNumber, factor: Real) -> StudyNumber:
    values = tuple((given.array * factor).tolist())
    return StudyNumber(values, is_axis=given.is_axis, is_interval=given.is_interval)


def _person(study: Study, name: str) -> Population:
    """Return one person of a study, or one of `STANDARD_PERSONS`.

    Raises:
        UsageError: The study has no such person.
    """
    if name in STANDARD_PERSONS:
        survey = study.people.survey if study.people is not None else ansur2()
        return standard_person(survey, name)
    people = study.people.nominal if study.people is not None else None
    names = people.names if people is not None else ()
    if people is not None and name in names:
        row = names.index(name)
        return people.only(slice(row, row + 1))
    hint = hint_at_nearest(name, (*STANDARD_PERSONS, *names[:_NAMES_SEARCHED]))
    if not hint:
        known = [*STANDARD_PERSONS, *names[:_NAMES_SHOWN]]
        if len(names) > _NAMES_SHOWN:
            known.append("...")
        hint = f"persons: {', '.join(map(shorten, known))}"
    raise UsageError(f'there is no person "{shorten(name)}"', hint=hint)
