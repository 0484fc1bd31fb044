"""The space of a study: its axes with their roles, and the numbers that all of its designs share."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from tendon_cli.model.design import READINGS
from tendon_cli.model.kinematics import Array
from tendon_cli.space.axis import (
    AFTER,
    CASE_AXIS,
    DRAW_AXIS,
    PERSON_AXIS,
    PRETENSION,
    READ,
    REFERENCE,
    SIDES,
    SLACK,
    SPRING_AT,
    Axis,
    Role,
    of_side,
    scale_of,
    split_side,
)
from tendon_cli.space.space import EXCURSION, Space
from tendon_cli.studies.contents import case_numbers
from tendon_cli.studies.curves import curves_of
from tendon_cli.studies.study import Study, keys
from tendon_cli.studies.values import Grid, drawn

_WORDS = {REFERENCE: "initial", SLACK: "unilateral", SPRING_AT: "motor", AFTER: "flexion"}
_WORDS |= {of_side(SPRING_AT, side): "motor" for side in SIDES}
"""Words that are numbers to the model, each with the one that is 1."""


def space_of(study: Study) -> Space:
    """The product of a study's axes, slowest first."""
    named = {axis.key: axis for axis in named_axes(study)}
    axes = [named.get(key) or number_axis(study, key) for key in study.axes]
    return Space(tuple(replace(axis, role=_role(study, axis.key)) for axis in axes), single_numbers(study))


def lengths_of(study: Study) -> tuple[int, ...]:
    """How many values each axis of a study has, without any of them."""
    persons = 0 if study.people is None else study.people.persons
    named = {CASE_AXIS: len(study.cases), PERSON_AXIS: persons, DRAW_AXIS: study.draws}
    return tuple(named[key] if key in named else len(study.numbers[key]) for key in study.axes)


def single_numbers(study: Study) -> dict[str, Any]:
    """What a study gives once for all of its designs, by dotted key, SI."""
    words = {key: given == word for key, word in _WORDS.items() if (given := _word(study, key)) is not None}
    numbers = {key: values.single for key, values in study.numbers.items() if not values.is_axis}
    read = {READ: float(READINGS.index(study.setting.read))}
    return numbers | {key: float(is_so) for key, is_so in words.items()} | read | curves_of(study)


def _word(table: object, key: str) -> str | None:
    """The word at a dotted key of a study or a case; None if it says none."""
    for name in key.split("."):
        table = getattr(table, name, None)
    return table if isinstance(table, str) else None


def named_axes(study: Study) -> tuple[Axis, ...]:
    """Cases, persons and draws, as far as a study has them; if each person gets one draw, no axis of draws."""
    asked, axes = study.uncertainty if study.uncertain else None, [case_axis(study)] if study.cases else []
    if study.people is not None:
        drawn_once = {}
        if asked is not None and not study.draws:
            drawn_once = drawn(study.uncertain, len(study.people.population), asked.seed)
        axes.append(person_axis(study, drawn_once))
    if asked is not None and study.draws:
        names = tuple(f"draw {at + 1}" for at in range(study.draws))
        axes.append(Axis(DRAW_AXIS, DRAW_AXIS, drawn(study.uncertain, study.draws, asked.seed), names))
    return tuple(axes)


def case_axis(study: Study) -> Axis:
    """The cases of a study, each of which may set numbers and the choices of the model; NaN where it does not."""
    given = [case_numbers(case) for case in study.cases]
    named = dict.fromkeys(key for each in given for key in each)
    numbers = {key: _stacked(each.get(key) for each in given) for key in named}
    for key, word in _WORDS.items():
        words = [_word(case, key) for case in study.cases]
        if any(words):
            numbers[key] = _stacked(None if each is None else each == word for each in words)
    return Axis(CASE_AXIS, CASE_AXIS, numbers, tuple(str(getattr(case, "name", "")) for case in study.cases))


def person_axis(study: Study, drawn_once: Mapping[str, Array]) -> Axis:
    """The persons of a study; `drawn_once` are uncertain numbers of which each has one value."""
    from tendon_cli.studies.people.population import arms_of  # a study without people does without it

    if study.people is None:
        raise ValueError("a study without people has no axis of persons")
    people = study.people.population
    sets, scales = arms_of(people, study.of_the_body)
    if (dimension := study.joint.scale_with) is not None:
        mine, theirs = getattr(people.reference, dimension), getattr(people.body, dimension)
        scales[EXCURSION] = np.asarray(theirs) / mine
    numbers = {**drawn_once, **sets, **{scale_of(key): values for key, values in scales.items()}}
    return Axis(PERSON_AXIS, PERSON_AXIS, numbers, people.names, weighting=people.weighting)


def number_axis(study: Study, key: str) -> Axis:
    """A number that varies: a grid with several values is a range, a list a catalogue."""
    values = study.numbers[key]
    grid = values.source if isinstance(values.source, Grid) and values.source.num > 1 else None
    is_range, is_log = grid is not None and not values.is_interval, grid is not None and grid.log
    return Axis(
        key, keys()[key].column, {key: values.array}, is_range=is_range, is_log=is_log, is_interval=values.is_interval
    )


def _role(study: Study, key: str) -> Role:
    if split_side(key)[0] == PRETENSION:
        return "pretension"
    return "condition" if key in study.conditions else "choice"


def _stacked(values: Iterable[float | None]) -> Array:
    return np.array([np.nan if value is None else float(value) for value in values])
