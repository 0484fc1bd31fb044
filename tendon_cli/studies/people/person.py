"""One person of a study: the same study on that arm alone, and how the arm comes from the body."""

from __future__ import annotations

from dataclasses import dataclass

from tendon_cli.errors import UsageError
from tendon_cli.model.body import ANCHOR_ALONG, DIMENSIONS, FOREARM_COM_SHARE, FOREARM_MASS_SHARE
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.fields import nearest
from tendon_cli.studies.people.population import NAMED, OF_THE_BODY, Population, arms_of, named
from tendon_cli.studies.people.survey import ansur2
from tendon_cli.studies.study import Study
from tendon_cli.studies.values import Values
from tendon_cli.units import shorten

_MANY = 5
_FORMULAS = {
    "forearm_mass": (FOREARM_MASS_SHARE, "weight", "Winter"),
    "forearm_com": (FOREARM_COM_SHARE, "radiale_stylion_length", "Winter"),
    "load_distance": (1.0, "forearm_grip_length", ""),
}
"""How the page says what comes from the body: a share of a dimension, and its source."""


@dataclass(frozen=True)
class Step:
    """A dimension of the body, or a number of the arm and how it comes from the body; SI."""

    quantity: str
    """By its name in `QUANTITIES`."""
    formula: str
    value: float
    source: str = ""


@dataclass(frozen=True, eq=False)
class Worn:
    """A study on the arm of one person."""

    name: str
    study: Study
    """Without people, its arm that of the person."""
    body: tuple[Step, ...]
    arm: tuple[Step, ...]


def worn_by(study: Study, name: str) -> Worn:
    """A study as one person wears it: one of its persons, or one of `NAMED`; raises UsageError for anyone else."""
    person = _person(study, name)
    body, reference = person.values[0], person.reference
    value = {name: float(body[at]) for at, name in enumerate(DIMENSIONS)}
    stated = {f"arm.{name}" for name in study.arm.model_fields_set}
    sets, scales = arms_of(person, [key for key in OF_THE_BODY if key not in stated])
    steps, numbers = [], {}
    for anchor, dimension in ANCHOR_ALONG.items():
        given = study.numbers[f"arm.{anchor}"]
        scaled = tuple((given.array * scales[f"arm.{anchor}"]).tolist())
        numbers[anchor] = Values(scaled, is_axis=given.is_axis, is_interval=given.is_interval)
        of_all: float = getattr(reference, dimension)
        formula = (
            f"{given.array[0]:.6g} x {QUANTITIES[dimension].symbol} / {of_all:.6g} of the mean man"
        )
        steps.append(Step(anchor, formula, numbers[anchor].array[0]))
    for key, (share, dimension, source) in _FORMULAS.items():
        if f"arm.{key}" not in sets:
            steps.append(
                Step(key, "as the study states it", float(study.numbers[f"arm.{key}"].array[0]))
            )
            continue
        numbers[key] = Values.of(float(sets[f"arm.{key}"][0]))
        symbol = QUANTITIES[dimension].symbol
        steps.append(
            Step(
                key,
                f"{share:g} x {symbol}" if share != 1.0 else symbol,
                numbers[key].single,
                source,
            )
        )
    arm = study.arm.model_copy(update=numbers)
    measures = tuple(Step(name, QUANTITIES[name].long_name, value[name]) for name in DIMENSIONS)
    return Worn(
        person.names[0], study.replaced({"arm": arm, "people": None}), measures, tuple(steps)
    )


def _person(study: Study, name: str) -> Population:
    if name in NAMED:
        return named(study.people.survey if study.people is not None else ansur2(), name)
    people = study.people.nominal if study.people is not None else None
    names = people.names if people is not None else ()
    if people is not None and name in names:
        return people.only(slice(names.index(name), names.index(name) + 1))
    known = [*NAMED, *names[:_MANY]] + (["..."] if len(names) > _MANY else [])
    hint = nearest(name, (*NAMED, *names[:10_000])) or f"persons: {', '.join(map(shorten, known))}"
    raise UsageError(f'there is no person "{shorten(name)}"', hint=hint)
