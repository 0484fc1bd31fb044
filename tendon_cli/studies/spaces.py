"""The space of a study: its axes with their roles, the numbers that all designs share, and what cannot be in it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from tendon_cli.errors import Fault, UsageError
from tendon_cli.model.design import F0, READINGS
from tendon_cli.model.kinematics import Array
from tendon_cli.model.setting import Reading
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
from tendon_cli.space.space import EXCURSION, INERTIA, TRAJECTORY, Space
from tendon_cli.studies.angle_curves import curves_of
from tendon_cli.studies.contents import case_numbers, column_of
from tendon_cli.studies.fields import nearest
from tendon_cli.studies.study import Study
from tendon_cli.studies.values import Grid, drawn
from tendon_cli.units import shorten

_MOST_READINGS, _ROUNDING = 10**6, 1e-6
MAX_FRICTION_EXPONENT = 100.0
"""Largest μφ: a tendon that loses 43 orders of magnitude of its tension is a slip of the pen."""

_MOST_ARMS_TO_CHECK = 100_000

_WORDS = {REFERENCE: "initial", SLACK: "unilateral", SPRING_AT: "motor", AFTER: "flexion"}
_WORDS |= {of_side(SPRING_AT, side): "motor" for side in SIDES}
"""Words that are numbers to the model, each with the one that is 1."""


def space_of(study: Study) -> Space:
    """The product of a study's axes, slowest first."""
    named = {axis.key: axis for axis in named_axes(study)}
    axes = [named.get(key) or axis_of(study, key) for key in study.axes]
    return Space(
        tuple(replace(axis, role=_role(study, axis.key)) for axis in axes), single_numbers(study)
    )


def lengths_of(study: Study) -> tuple[int, ...]:
    """How many values each axis of a study has, without any of them."""
    persons = 0 if study.people is None else study.people.persons
    lengths = {key: len(values) for key, values in (study.numbers | study.words).items()}
    lengths |= {CASE_AXIS: len(study.cases), PERSON_AXIS: persons, DRAW_AXIS: study.draws}
    return tuple(lengths[key] for key in study.axes)


def single_numbers(study: Study) -> dict[str, Any]:
    """What a study gives once for all of its designs, by dotted key, SI."""
    words = {
        key: given == word
        for key, word in _WORDS.items()
        if (given := word_of(study, key)) is not None
    }
    numbers = {key: values.single for key, values in study.numbers.items() if not values.is_axis}
    read = {READ: float(READINGS.index(study.setting.read))}
    inertia = 0.0 if study.motion.inertia is None else study.motion.inertia.single
    in_time = (
        {TRAJECTORY: study.trajectory, INERTIA: inertia} if study.trajectory is not None else {}
    )
    return (
        numbers
        | {key: float(is_so) for key, is_so in words.items()}
        | read
        | curves_of(study)
        | in_time
    )


def word_of(table: object, key: str) -> str | None:
    """The word at a dotted key of a study or a case; None if it says none."""
    for name in key.split("."):
        table = getattr(table, name, None)
    return table if isinstance(table, str) else None


def named_axes(study: Study) -> tuple[Axis, ...]:
    """Cases, persons and draws, as far as a study has them; if each person gets one draw, no axis of draws."""
    asked, axes = (
        study.uncertainty if study.uncertain else None,
        [case_axis(study)] if study.cases else [],
    )
    if study.people is not None:
        once = (
            {}
            if asked is None or study.draws
            else drawn(study.uncertain, study.people.persons, asked.seed)
        )
        axes.append(person_axis(study, once))
    if asked is not None and study.draws:
        names = tuple(f"draw {at + 1}" for at in range(study.draws))
        axes.append(
            Axis(DRAW_AXIS, DRAW_AXIS, drawn(study.uncertain, study.draws, asked.seed), names)
        )
    return tuple(axes)


def case_axis(study: Study) -> Axis:
    """The cases of a study, each of which may set numbers and the choices of the model; NaN where it does not."""
    given: list[dict[str, float]] = []
    for case in study.cases:
        words = {key: word_of(case, key) for key in _WORDS}
        given.append(
            case_numbers(case)
            | {key: float(word == _WORDS[key]) for key, word in words.items() if word}
        )
    named = dict.fromkeys(key for each in given for key in each)
    numbers = {key: np.array([each.get(key, np.nan) for each in given]) for key in named}
    return Axis(
        CASE_AXIS, CASE_AXIS, numbers, tuple(str(getattr(case, "name", "")) for case in study.cases)
    )


def case_place(study: Study, name: str) -> int:
    """The position of a case; raises UsageError if the study has none of this name."""
    names = [str(getattr(case, "name", "")) for case in study.cases]
    if name not in names:
        listed = f"cases: {', '.join(names[:20])}" if names else "the study has no [[cases]]"
        hint = nearest(name, names) or listed
        raise UsageError(f'there is no case "{shorten(name)}"', where="--case", hint=hint)
    return names.index(name)


def person_axis(study: Study, drawn_once: Mapping[str, Array]) -> Axis:
    """The persons of a study; `drawn_once` are uncertain numbers of which each has one value."""
    from tendon_cli.studies.people.population import (
        arms_of,
    )  # a study without people does without it

    if study.people is None:
        raise ValueError("a study without people has no axis of persons")
    people = study.people.population
    sets, scales = arms_of(people, study.of_the_body)
    if (dimension := study.joint.scale_with) is not None:
        mine, theirs = getattr(people.reference, dimension), getattr(people.body, dimension)
        scales[EXCURSION] = np.asarray(theirs) / mine
    numbers = {**drawn_once, **sets, **{scale_of(key): values for key, values in scales.items()}}
    return Axis(PERSON_AXIS, PERSON_AXIS, numbers, people.names, weighting=people.weighting)


def axis_of(study: Study, key: str) -> Axis:
    """A number that varies, or a word: a grid with several values is a range, a list a catalogue."""
    if words := study.words.get(key):
        return Axis(
            key,
            column_of(key),
            {key: np.array([float(word == _WORDS[key]) for word in words])},
            words,
        )
    values = study.numbers[key]
    grid = values.source if isinstance(values.source, Grid) and values.source.num > 1 else None
    axis = Axis(key, column_of(key), {key: values.array}, is_log=grid is not None and grid.log)
    return replace(
        axis, is_range=grid is not None and not values.is_interval, is_interval=values.is_interval
    )


def _role(study: Study, key: str) -> Role:
    if split_side(key)[0] == PRETENSION:
        return "pretension"
    return "condition" if key in study.conditions else "choice"


# --- What cannot be --------------------------------------------------------------------------------------------------


def impossibilities(study: Study) -> list[Fault]:
    """Combinations of numbers, those of its files included, that cannot be."""
    return [
        *_friction_faults(study),
        *_anchor_faults(study),
        *_faults_of_by(study),
        *_reading_faults(study),
    ]


def _faults_of_by(study: Study) -> Iterator[Fault]:
    """Shares by a column that the people do not have."""
    if study.design.by is None:
        return
    if study.people is None:
        yield Fault(
            "design.by",
            "gives shares of people, and this study has none",
            'add [people] source = "ansur2"',
        )
    elif not study.people.population.sexes:
        hint = 'a column "sex" with male or female, or people.sex if all are alike'
        yield Fault("design.by", "gives shares by sex, which the file of people does not say", hint)


def _reading_faults(study: Study) -> Iterator[Fault]:
    """A pretension that no gauge can show, as even without pretension it shows more."""
    if study.setting.read == F0 or len(space := space_of(study)) > _MOST_READINGS:
        return
    design = space.design()
    least = float(np.nanmax(Reading.of(design).shown(0.0)))
    if np.nanmin(design.flexor.pretension) < -_ROUNDING:
        problem = f"cannot be read as {design.read}, which shows {least:.4g} N or more in the setting of every design"
        yield Fault(PRETENSION, problem, f"such as {1.5 * least:.0f} N, or another [setting]")


def _friction_faults(study: Study) -> Iterator[Fault]:
    """A product of friction and bend angle, on one side, beyond any sheath."""
    sheath = {key: values for key, values in study.numbers.items() if key.startswith("sheath.")}
    largest = {
        key: (each.uncertain.reach if each.uncertain else each.extremes)[1]
        for key, each in sheath.items()
    }
    space = Space((case_axis(study),) if study.cases else (), largest)
    for side in SIDES:
        friction, bend_angle = (
            space.number(f"sheath.{name}", side).within(space.whole)
            for name in ("friction", "bend_angle")
        )
        reached = np.ravel(friction * bend_angle)
        at = int(np.argmax(reached > MAX_FRICTION_EXPONENT))
        if reached[at] > MAX_FRICTION_EXPONENT:
            problem = f"friction x bend_angle reaches {reached[at]:.4g} on the {side}'s side{_in_case(space, at)}"
            yield Fault("sheath.friction", f"{problem}, expected {MAX_FRICTION_EXPONENT:g} at most")
            return


def _in_case(space: Space, row: int) -> str:
    """How an error names the case of a design; nothing in a study without cases."""
    cases = space.axes[0] if space.axes and space.axes[0].key == CASE_AXIS else None
    return (
        ""
        if cases is None
        else f' in the case "{shorten(cases.names[np.unravel_index(row, space.shape)[0]])}"'
    )


def _anchor_faults(study: Study) -> Iterator[Fault]:
    """An elbow angle asked for at which the flexor's two anchors coincide: its path has no direction there."""
    anchors = {name: f"arm.{name}" for name in ("a1", "b1", "a2", "b2")}
    axes = [case_axis(study)] if study.cases else []
    axes += [axis_of(study, key) for key in study.axes if key in anchors.values()]
    space = Space(tuple(axes), single_numbers(study))
    if len(space) > _MOST_ARMS_TO_CHECK:
        return  # such states are found one by one when the study runs, as states without equilibrium
    given = (space.number(key).within(space.whole) for key in anchors.values())
    a1, b1, a2, b2 = (np.broadcast_to(each, (*space.shape, 1, 1)).ravel() for each in given)
    meeting = np.pi - np.arctan2(a1, b1) - np.arctan2(a2, b2)
    alike = np.abs(np.hypot(a1, b1) - np.hypot(a2, b2)) <= 1e-12 * b1
    for row in np.flatnonzero(
        alike & (study.angles.min() <= meeting) & (meeting <= study.angles.max())
    ):
        if np.min(np.abs(study.angles - meeting[row])) < 1e-9:
            at = f"the elbow angle {np.degrees(meeting[row]):.6g} deg{_in_case(space, int(row))}"
            hint = "make a1, b1 and a2, b2 differ, or leave this angle out"
            yield Fault("arm", f"the flexor's anchors coincide (L_c = 0) at {at}", hint)
            return
