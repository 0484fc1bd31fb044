"""Space of a study: its axes with their roles, the numbers that all designs share, and faults."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from tendon_cli.errors import Fault, StudyError, UsageError
from tendon_cli.model.body import stiffness_scale
from tendon_cli.model.design import F0, MOTOR_TORQUE, READINGS, Design
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.setting import Reading
from tendon_cli.quantities import SIDES, unit_of_reading
from tendon_cli.space.axis import (
    AFTER,
    CASE_AXIS,
    DRAW_AXIS,
    PERSON_AXIS,
    PRETENSION,
    READ,
    REFERENCE,
    SLACK,
    SPRING_AT,
    Axis,
    NamedAxis,
    Role,
    of_side,
    scale_of,
    split_side,
)
from tendon_cli.space.space import EXCURSION, INERTIA, TRAJECTORY, Space
from tendon_cli.studies.angle_curves import curves_of
from tendon_cli.studies.contents import case_numbers, column_of
from tendon_cli.studies.fields import hint_at_nearest
from tendon_cli.studies.study import Study
from tendon_cli.studies.values import Grid, StudyNumber, draw_numbers
from tendon_cli.units import shorten

if TYPE_CHECKING:
    from tendon_cli.studies.people.population import Population

MAX_FRICTION_EXPONENT = 100.0
"""Largest μφ: a tendon that loses 43 orders of magnitude of its tension is a slip of the pen."""
_MOST_READINGS = 10**6
"""Largest number of designs whose setting is checked before the study runs."""
_MOST_ARMS = 100_000
"""Largest number of arms whose anchors are checked before the study runs."""
_NO_TENSION = 1e-6
"""Rounding of a pretension, N."""

WORDS_OF = {
    REFERENCE: ("published", "initial"),
    SLACK: ("bilateral", "unilateral"),
    SPRING_AT: ("joint", "motor"),
    AFTER: ("extension", "flexion"),
}
"""Common keys whose words are numbers to the model, each with its words for 0 and for 1."""
KEYS_OF_WORDS = (*WORDS_OF, *(of_side(SPRING_AT, side) for side in SIDES))
"""Keys of these words, those of one side included."""


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
    numbers |= _numbers_of_words(study)
    numbers[READ] = float(READINGS.index(study.setting.read))
    numbers |= curves_of(study)
    if study.trajectory is not None:
        inertia = study.motion.inertia
        numbers[TRAJECTORY] = study.trajectory
        numbers[INERTIA] = 0.0 if inertia is None else inertia.single
    return numbers


def word_of(table: object, key: str) -> str | None:
    """Return the word at a dotted key of a study or a case; None if it has no single word."""
    for name in key.split("."):
        table = getattr(table, name, None)
    return table if isinstance(table, str) else None


def _numbers_of_words(table: object) -> dict[str, float]:
    """Return the words that a study or a case gives, as the numbers that they are to the model."""
    words = {key: word_of(table, key) for key in KEYS_OF_WORDS}
    return {key: _number_of_word(key, word) for key, word in words.items() if word is not None}


def _number_of_word(key: str, word: str) -> float:
    """Return the number that a word is to the model: 0 or 1."""
    return float(WORDS_OF[split_side(key)[0]].index(word))


# --- Axes ----------------------------------------------------------------------------------------


def named_axes(study: Study) -> tuple[NamedAxis, ...]:
    """Return the axes of cases, persons and draws, as far as a study has them.

    If each person gets one draw of the uncertain numbers, the draws are values of the persons and
    no axis.
    """
    axes: list[NamedAxis] = []
    if study.cases:
        axes.append(case_axis(study))
    drawing = study.drawing
    if study.people is not None:
        drawn_once: Mapping[str, Array] = {}
        if drawing is not None and not study.draws:
            drawn_once = draw_numbers(
                study.uncertain, study.people.persons, drawing.seed, study.correlation
            )
        axes.append(person_axis(study, drawn_once))
    if drawing is not None and study.draws:
        numbers = draw_numbers(study.uncertain, study.draws, drawing.seed, study.correlation)
        names = tuple(f"draw {at + 1}" for at in range(study.draws))
        axes.append(NamedAxis.of(DRAW_AXIS, names, numbers, "draw"))
    return tuple(axes)


def case_axis(study: Study) -> NamedAxis:
    """Return the axis of a study's cases.

    A case may set numbers and words of the model; a number is NaN in a case that does not set it.
    """
    cases = [case_numbers(case) | _numbers_of_words(case) for case in study.cases]
    keys_set = dict.fromkeys(key for given in cases for key in given)
    numbers = {key: np.array([given.get(key, np.nan) for given in cases]) for key in keys_set}
    return NamedAxis.of(CASE_AXIS, _case_names(study), numbers, _role(study, CASE_AXIS))


def _case_names(study: Study) -> tuple[str, ...]:
    """Return the names of a study's cases."""
    return tuple(str(getattr(case, "name", "")) for case in study.cases)


def case_place(study: Study, name: str) -> int:
    """Return the position of a case in the study, counted from 0.

    Raises:
        UsageError: The study has no case of this name.
    """
    names = _case_names(study)
    if name not in names:
        listed = f"cases: {', '.join(names[:20])}" if names else "the study has no [[cases]]"
        hint = hint_at_nearest(name, names) or listed
        raise UsageError(f'there is no case "{shorten(name)}"', where="--case", hint=hint)
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
    people = study.people.changed(completions=None)
    return person_axis(study.replaced({"people": people}), {})


def axis_of(study: Study, key: str) -> Axis:
    """Return the axis of a number that varies, or of a word.

    A grid with several values is a range, between whose values others are possible; a list is a
    catalogue.
    """
    words = study.words.get(key)
    if words:
        flags = np.array([_number_of_word(key, word) for word in words])
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
    """Yield a fault if anchors are measured on the wearer, but the study has not just one."""
    if study.arm.anchors != "measured" or study.people is None:
        return
    key = "arm.anchors"
    scaled = 'anchors = "mean man" scales those of the mean man to each person'
    if not study.people.is_from_file:
        problem = '"measured" is about the one person of a file, but a survey draws the persons'
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
        f"does not tell the pretension{where}: friction and the moment arms let the torque of the"
        " motor fall, or stay, as both tendons tighten"
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
    if any(PRETENSION in case_numbers(case) for case in study.cases):
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
    axes = (case_axis(study),) if study.cases else ()
    space = Space(axes, largest)
    for side in SIDES:
        friction = space.number("sheath.friction", side).within(space.whole)
        bend_angle = space.number("sheath.bend_angle", side).within(space.whole)
        exponents = np.ravel(friction * bend_angle)  # (cases,), μφ
        row = int(np.argmax(exponents > MAX_FRICTION_EXPONENT))
        if exponents[row] > MAX_FRICTION_EXPONENT:
            place = f"on the {side}'s side{_in_case(space, row)}"
            problem = f"friction x bend_angle reaches {exponents[row]:.4g} {place}"
            yield Fault("sheath.friction", f"{problem}, expected {MAX_FRICTION_EXPONENT:g} at most")
            return


def _in_case(space: Space, row: int) -> str:
    """Return the phrase by which an error names the case of a design; empty without cases."""
    if not space.axes or space.axes[0].key != CASE_AXIS:
        return ""
    case = np.unravel_index(row, space.shape)[0]
    return f' in the case "{shorten(space.axes[0].names[case])}"'


def _anchor_faults(study: Study) -> Iterator[Fault]:
    """Yield a fault if the flexor's two anchors coincide at an elbow angle of the study.

    The path between them then has no direction: both anchors are equally far from the elbow, and
    the angle between them is zero.
    """
    anchors = [f"arm.{name}" for name in ("a1", "b1", "a2", "b2")]
    axes: list[Axis] = [case_axis(study)] if study.cases else []
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
            place = f"{angle}{_in_case(space, int(row))}"
            hint = "make a1, b1 and a2, b2 differ, or leave this angle out"
            yield Fault("arm", f"the flexor's anchors coincide (L_c = 0) at {place}", hint)
            return
