"""Space of a study: its axes with their roles, the numbers that all designs share, and faults."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tendon_cli.errors import Fault, StudyError, UsageError
from tendon_cli.model.body import stiffness_scale
from tendon_cli.model.design import F0, MOTOR_TORQUE, READINGS, Design
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.setting import Reading
from tendon_cli.quantities import SIDES, unit_of_reading
from tendon_cli.say import join_words
from tendon_cli.studies.answer_draws import draws_of
from tendon_cli.studies.contents import column_of
from tendon_cli.studies.fields import hint_at_nearest
from tendon_cli.studies.model_words import number_of_word, numbers_of_words
from tendon_cli.studies.space.axis import (
    CASE_AXIS,
    DRAW_AXIS,
    PERSON_AXIS,
    PRETENSION,
    READ,
    Axis,
    NamedAxis,
    Role,
    scale_of,
    split_side,
)
from tendon_cli.studies.space.space import EXCURSION, INERTIA, TRAJECTORY, Space
from tendon_cli.studies.study import Study
from tendon_cli.studies.study_curves import curves_of
from tendon_cli.studies.values import Grid, StudyNumber
from tendon_cli.units import shorten

if TYPE_CHECKING:
    from tendon_cli.studies.people.population import Population

MAX_FRICTION_EXPONENT = 100.0
"""Largest μφ: a tendon that loses 43 orders of magnitude of its tension is a slip of the pen."""
_MOST_READINGS = 10**6
"""Largest number of designs whose setting is checked before the study runs."""
_MOST_ARMS = 100_000
"""Largest number of arms whose anchors are checked before the study runs."""
_MOST_LISTED = 20
"""Largest number of rows of a table that a hint lists."""
_MOST_COMPARED = 10_000
"""Largest number of rows among which a hint seeks the nearest name."""
_NO_TENSION = 1e-6
"""Rounding of a pretension, N."""


def space_of(study: Study) -> Space:
    """Return the product of a study's axes, slowest first, with the numbers that all share."""
    named = {axis.key: axis for axis in named_axes(study)}
    axes = [named[key] if key in named else axis_of(study, key) for key in study.axes]
    return Space(tuple(axes), single_numbers(study))


def lengths_of(study: Study) -> tuple[int, ...]:
    """Return the number of values of each axis of a study, without building the axes."""
    lengths = {key: len(values) for key, values in (study.numbers | study.words).items()}
    lengths |= study.named_lengths
    return tuple(lengths[key] for key in study.axes)


def single_numbers(study: Study) -> dict[str, Any]:
    """Return what a study gives once for all of its designs, by dotted key, SI.

    Words are given as the numbers that they are to the model. Curves and a motion in time are
    given as the objects that the model takes.
    """
    numbers: dict[str, Any] = {
        key: values.single for key, values in study.numbers.items() if not values.is_axis
    }
    numbers |= numbers_of_words(study)
    numbers[READ] = float(READINGS.index(study.setting.read))
    numbers |= curves_of(study)
    if study.trajectory is not None:
        inertia = study.motion.inertia
        numbers[TRAJECTORY] = study.trajectory
        numbers[INERTIA] = 0.0 if inertia is None else inertia.single
    return numbers


# --- Axes ----------------------------------------------------------------------------------------


def named_axes(study: Study) -> tuple[NamedAxis, ...]:
    """Return the axes of cases, tables, persons and draws, as far as a study has them.

    If each person gets one draw of the uncertain numbers, the draws are values of the persons and
    no axis.
    """
    axes: list[NamedAxis] = [*row_axes(study)]
    if study.people is not None:
        drawn_once = {} if study.draws else draws_of(study, study.people.persons)
        axes.append(person_axis(study, drawn_once))
    if study.draws:
        names = tuple(f"draw {at + 1}" for at in range(study.draws))
        axes.append(NamedAxis.of(DRAW_AXIS, names, draws_of(study, study.draws), "draw"))
    return tuple(axes)


def row_axes(study: Study) -> tuple[NamedAxis, ...]:
    """Return the axes of a study's cases and tables, slowest first.

    The rows of a sample all count the same.
    """
    return tuple(replace(table, role=_role(study, table.key)) for table in study.row_tables)


def row_place(study: Study, table: str, name: str, option: str = "--row") -> int:
    """Return the position of a row of a table, counted from 0.

    Args:
        study: The study.
        table: Name of the table; "case" for the cases.
        name: Name of the row.
        option: The option that names it, for messages.

    Raises:
        UsageError: The study has no such table, or the table no row of this name.
    """
    tables = {of_study.key: of_study for of_study in study.row_tables}
    if table not in tables:
        known = [key for key in tables if key != CASE_AXIS] if table != CASE_AXIS else []
        listed = f"tables: {', '.join(known)}" if known else "the study has no [[table]]"
        problem = f'there is no table "{shorten(table)}"'
        if table == CASE_AXIS:
            problem = f'there is no case "{shorten(name)}"'
            listed = "the study has no [[cases]]"
        hint = hint_at_nearest(table, known) or listed
        raise UsageError(problem, where=option, hint=hint)
    names = tables[table].names
    if name not in names:
        noun = "case" if table == CASE_AXIS else f"{table}"
        more = ", ..." if len(names) > _MOST_LISTED else ""
        listed = f"{'cases' if table == CASE_AXIS else 'rows'}: {', '.join(names[:_MOST_LISTED])}"
        hint = hint_at_nearest(name, names[:_MOST_COMPARED]) or f"{listed}{more}"
        raise UsageError(f'there is no {noun} "{shorten(name)}"', where=option, hint=hint)
    return names.index(name)


def person_axis(
    study: Study, drawn_once: Mapping[str, Array], population: Population | None = None
) -> NamedAxis:
    """Return the axis of a study's persons.

    Args:
        study: A study with people.
        drawn_once: Uncertain numbers of which each person has one value, by dotted key, SI.
        population: Other persons in place of the study's own.

    Raises:
        ValueError: The study has no people.
    """
    # A study without people does without the import.
    from tendon_cli.studies.people.population import arms_of

    if study.people is None:
        raise ValueError("a study without people has no axis of persons")
    people = study.people.population if population is None else population
    sets, scales = arms_of(people, study.body_numbers, study.measured_anchors)
    dimension = study.joint.scale_with
    if dimension is not None:
        measured_on = getattr(people.reference, dimension)
        of_persons = np.asarray(getattr(people.body, dimension))
        scales[EXCURSION] = of_persons / measured_on
    if study.joint.stiffness_with is not None:
        scales["joint.stiffness"] = stiffness_scale(people.body, people.reference)
    scaling = {scale_of(key): values for key, values in scales.items()}
    numbers = {**drawn_once, **sets, **scaling}
    return NamedAxis.of(PERSON_AXIS, people.names, numbers, "draw", people.weighting)


def wearer_axis(study: Study) -> NamedAxis | None:
    """Return the axis of the one person on whom the study's anchors were measured; None for others.

    What was not measured on this person has its expected value, and uncertain numbers their middle.
    """
    if study.people is None or not study.measured_anchors:
        return None
    return person_axis(study, {}, study.people.nominal)


def axis_of(study: Study, key: str) -> Axis:
    """Return the axis of a number that varies, or of a word.

    A grid with several values is a range, between whose values others are possible; a list is a
    catalogue.
    """
    words = study.words.get(key)
    if words:
        flags = np.array([number_of_word(key, word) for word in words])
        return Axis(key, column_of(key), {key: flags}, words, _role(study, key))
    values = study.numbers[key]
    grid = values.source if isinstance(values.source, Grid) and values.source.num > 1 else None
    return Axis(
        key,
        column_of(key),
        {key: values.array},
        role=_role(study, key),
        is_range=grid is not None and not values.is_interval,
        is_log=grid is not None and grid.log,
        is_interval=values.is_interval,
    )


def _role(study: Study, key: str) -> Role:
    """Return the role of an axis other than persons and draws in the design of a suit."""
    if split_side(key)[0] == PRETENSION:
        return "pretension"
    if key in study.drawn_tables:
        return "draw"
    return "condition" if key in study.conditions else "choice"


# --- Impossible combinations ---------------------------------------------------------------------


def impossibilities(study: Study) -> list[Fault]:
    """Return the faults of combinations of numbers that are not possible.

    The numbers of the study's files are among them, so the files must have been read.
    """
    return [
        *_friction_faults(study),
        *_anchor_faults(study),
        *_measured_anchor_faults(study),
        *_grouping_faults(study),
        *_reading_faults(study),
    ]


def _grouping_faults(study: Study) -> Iterator[Fault]:
    """Yield a fault if shares are to be given by a column that the people do not have."""
    if study.design.by is None:
        return
    if study.people is None:
        problem = "gives shares of people, but this study has none"
        yield Fault("design.by", problem, 'add [people] source = "ansur2"')
    elif not study.people.population.sexes:
        hint = 'a column "sex" with male or female, or people.sex if all are alike'
        yield Fault("design.by", "gives shares by sex, but the file of people has none", hint)


def _measured_anchor_faults(study: Study) -> Iterator[Fault]:
    """Yield faults of anchors that are said to be measured on one wearer, of whom there is none."""
    if study.people is None or study.arm.anchors != "measured":
        return
    key = "arm.anchors"
    scaled = 'anchors = "mean man" scales those of the mean man to each person'
    if not study.people.is_from_file:
        problem = '"measured" is for the one person of a file, but a survey draws its persons'
        yield Fault(key, problem, f'[people] file = "me.csv" with that person; {scaled}')
        return
    persons = len(study.people.population.persons)
    if persons > 1:
        problem = f'"measured" is about one person, but the file has {persons:,}'
        yield Fault(key, problem, f"a study for each person; {scaled}")


def check_reading(study: Study) -> None:
    """Check that the gauge of a study tells the pretension, in every draw too.

    Raises:
        StudyError: It does not.
    """
    if study.setting.read != MOTOR_TORQUE:
        return  # a tension grows with the pretension
    space = space_of(study)
    if len(space) > _MOST_READINGS:
        return
    falling = _does_not_tell(space.design())
    if falling.any():
        raise StudyError([_undetermined_fault(space, falling)])


def _does_not_tell(design: Design) -> Flags:
    """Return True for designs whose reading does not grow with the pretension."""
    return np.asarray(np.asarray(Reading.of(design).gain) <= 0.0)


def _reading_faults(study: Study) -> Iterator[Fault]:
    """Yield a fault if a gauge does not tell the pretension, or cannot show the stated one.

    A gauge shows what it shows at F0 = 0, or more.
    """
    if study.setting.read == F0:
        return
    space = space_of(study)
    if len(space) > _MOST_READINGS:
        return
    design = space.design()
    falling = _does_not_tell(design)
    if falling.any():
        yield _undetermined_fault(space, falling)
        return
    if study.setting.read == MOTOR_TORQUE and "pretension" not in study.tendon.model_fields_set:
        return  # the default is a tension
    if _is_below_readings(design):
        least = float(np.nanmax(Reading.of(design).shown(0.0)))
        unit = unit_of_reading(design.read)
        shown = f"which shows {least:.4g} {unit} or more in the setting of every design"
        problem = f"cannot be read as {design.read}, {shown}"
        yield Fault(PRETENSION, problem, f"such as {1.5 * least:.2g} {unit}, or another [setting]")


def _is_below_readings(design: Design) -> bool:
    """Return True if a gauge shows more than the pretension of some design, even at F0 = 0."""
    return bool(np.any(np.asarray(design.flexor.pretension) < -_NO_TENSION))


def _undetermined_fault(space: Space, falling: Flags) -> Fault:
    """Return the fault of a gauge that shows no more when the pretension grows.

    Args:
        space: Space of the study.
        falling: True for designs in which it shows no more.
    """
    designs = np.broadcast_to(falling, (*space.shape, 1, 1)).reshape(space.shape)
    where = ""
    if len(space) > 1:
        first = np.unravel_index(int(np.argmax(designs)), space.shape)
        values = [
            f"{axis.key} = {axis.names[place] if axis.names else format(axis.values[place], '.6g')}"
            for axis, place in zip(space.axes, first, strict=True)
        ]
        count = f"{np.count_nonzero(designs):,} of {len(space):,} designs"
        where = f" in {count}, first with {', '.join(values)}"
    problem = (
        f"does not determine the pretension{where}: friction and the moment arms let the motor's"
        " torque fall, or stay, as both tendons tighten"
    )
    hint = 'another gauge, such as read = "flexor at motor", or leave these values out'
    return Fault("setting.read", problem, hint)


def with_readable_default(study: Study) -> Study:
    """Return a study whose pretension, if it states none, is one that its gauge can show.

    The default is a reading, as a stated pretension is. Where a gauge shows more than that with
    slack tendons, the default is F0 of the model instead: the reading, in whole newtons, at which
    no design has less. A torque has no default, which is a tension.
    """
    if study.setting.read in (F0, MOTOR_TORQUE) or "pretension" in study.tendon.model_fields_set:
        return study
    if any(PRETENSION in table.numbers for table in study.row_tables):
        return study
    space = space_of(study)
    if len(space) > _MOST_READINGS:
        return study
    design = space.design()
    if not _is_below_readings(design):
        return study
    default = study.numbers[PRETENSION].single
    reading = float(np.ceil(np.nanmax(Reading.of(design).shown(default))))
    tendon = study.tendon.model_copy(update={"pretension": StudyNumber.of(reading)})
    tendon.model_fields_set.discard("pretension")
    return study.replaced({"tendon": tendon})


def _friction_faults(study: Study) -> Iterator[Fault]:
    """Yield a fault if friction times bend angle, on one side, exceeds that of any sheath."""
    largest: dict[str, float] = {}
    for key, values in study.numbers.items():
        if key.startswith("sheath."):
            ends = values.uncertain.reach if values.uncertain else values.extremes
            largest[key] = ends[1]
    space = Space(row_axes(study), largest)
    if len(space) > _MOST_ARMS:
        return
    for side in SIDES:
        friction = space.number("sheath.friction", side).within(space.whole)
        bend_angle = space.number("sheath.bend_angle", side).within(space.whole)
        exponents = np.ravel(np.broadcast_to(friction * bend_angle, (*space.shape, 1, 1)))
        row = int(np.argmax(exponents > MAX_FRICTION_EXPONENT))  # of (rows,), μφ
        if exponents[row] > MAX_FRICTION_EXPONENT:
            place = f"on the {side}'s side{_in_row(space, row)}"
            problem = f"friction x bend_angle reaches {exponents[row]:.4g} {place}"
            yield Fault("sheath.friction", f"{problem}, expected {MAX_FRICTION_EXPONENT:g} at most")
            return


def _in_row(space: Space, row: int) -> str:
    """Return the phrase by which an error names the case or the rows of a design.

    It is empty without cases and tables.
    """
    places = space.places(np.array([row]))
    names = []
    for axis in space.axes:
        if isinstance(axis, NamedAxis):
            name = shorten(axis.names[int(places[axis.key][0])])
            names.append(f'the {axis.key} "{name}"')
    return f" in {join_words(names)}" if names else ""


def _anchor_faults(study: Study) -> Iterator[Fault]:
    """Yield a fault if the flexor's two anchors coincide at an elbow angle of the study.

    The path between them then has no direction: both anchors are equally far from the elbow, and
    the angle between them is zero.
    """
    anchors = [f"arm.{name}" for name in ("a1", "b1", "a2", "b2")]
    axes: list[Axis] = [*row_axes(study)]
    axes += [axis_of(study, key) for key in study.axes if key in anchors]
    space = Space(tuple(axes), single_numbers(study))
    if len(space) > _MOST_ARMS:
        return  # the run finds such states one by one, and reports no equilibrium
    given = (space.number(key).within(space.whole) for key in anchors)
    a1, b1, a2, b2 = (np.broadcast_to(values, (*space.shape, 1, 1)).ravel() for values in given)
    meeting = np.pi - np.arctan2(a1, b1) - np.arctan2(a2, b2)  # (arms,), rad
    is_as_far = np.abs(np.hypot(a1, b1) - np.hypot(a2, b2)) <= 1e-12 * b1
    is_reached = (study.angles.min() <= meeting) & (meeting <= study.angles.max())
    for row in np.flatnonzero(is_as_far & is_reached):
        if np.min(np.abs(study.angles - meeting[row])) < 1e-9:
            angle = f"the elbow angle {np.degrees(meeting[row]):.6g} deg"
            place = f"{angle}{_in_row(space, int(row))}"
            hint = "make a1, b1 and a2, b2 differ, or leave this angle out"
            yield Fault("arm", f"the flexor's anchors coincide (L_c = 0) at {place}", hint)
            return
