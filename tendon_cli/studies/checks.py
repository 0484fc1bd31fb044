"""Faults between keys of a study: keys that contradict each other, or lack another key."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from typing import Any

import numpy as np

from tendon_cli.errors import Fault, StudyError
from tendon_cli.model.design import F0
from tendon_cli.model.limits import LIMITS, SPEED
from tendon_cli.quantities import OF_CYCLES, OF_TRAJECTORIES, SIDES, dimension_of_reading
from tendon_cli.studies.angle_curves import SIGN_OF_TASK, CurveTable
from tendon_cli.studies.design_section import CHOICE_RESULTS
from tendon_cli.studies.fields import hint_at_nearest
from tendon_cli.studies.figures import figure_faults
from tendon_cli.studies.fit_section import BACKLASH
from tendon_cli.studies.magnitude import slip_faults
from tendon_cli.studies.measured_motion import short_record, trajectory_fault
from tendon_cli.studies.parts import FILES_OF_SHEATH, with_sides
from tendon_cli.studies.row_table import RowTable
from tendon_cli.studies.space.axis import (
    NAMED_AXES,
    PRETENSION,
    READING_ERROR,
    SAMPLE_AXES,
    SPRING_AT,
    of_side,
    split_side,
)
from tendon_cli.studies.space.space import ANCHORS
from tendon_cli.studies.study import Study, keys
from tendon_cli.studies.study_curves import curves_in, hint_to_cover, not_covered
from tendon_cli.studies.toml_reading import KeyPlaces
from tendon_cli.studies.values import Grid
from tendon_cli.units import shorten, wanted

_LARGEST_PRETENSION = "limits.max_pretension"
_LEAVE_ONE_OUT = "leave one of them out"
_GIVEN_BY: tuple[tuple[str, tuple[str, ...], str], ...] = (
    ("joint", ("torque",), "joint.stiffness"),
    ("arm", ANCHORS, "joint.excursion"),
    ("motion", ("elbow_angle", "direction", "speed"), "motion.trajectory"),
)
"""Tables and their keys that cannot be given with another key, which also gives them."""
_PART_OF = (
    ("joint", ("smoothing", "scale_with"), "excursion", "measured travels"),
    ("joint", ("stiffness_with",), "stiffness", "the joint's own stiffness"),
    ("motion", ("cutoff",), "trajectory", "a trajectory"),
)
"""Tables and their keys that need another key of the table, with a phrase for the whole."""
_OF_BOTH_DIRECTIONS = ("max_backlash", "max_torque_band")
"""Columns of the difference between flexion and extension at an elbow angle."""
_ANCHOR_KEYS = tuple(f"arm.{name}" for name in ANCHORS)
WHOSE_ANCHORS = (
    'anchors = "measured": measured on the one person of the file, for whom they hold as stated; '
    'anchors = "mean man": those of the survey\'s mean man, scaled to each person'
)
"""The two answers to the question whose the stated anchors are."""


def contradictions(study: Study, at_fault: set[str]) -> list[Fault]:
    """Return every fault between keys of a study.

    Args:
        study: The study, without the keys that are at fault by themselves.
        at_fault: Dotted keys that were left out of it; what they give is not reported as missing.
    """
    faults = [
        *_duplicate_faults(study),
        *_dependence_faults(study),
        *(
            fault
            for table, sheath in with_sides(study.sheath, "sheath").items()
            for fault in sheath_faults(table, sheath, at_fault)
        ),
        *_output_faults(study, at_fault),
        *_rest_angle_faults(study, at_fault),
        *_reading_faults(study),
        *_reading_unit_faults(study),
        *_limit_faults(study, at_fault),
        *curve_faults(study, at_fault),
    ]
    faults += motion_faults(study)
    faults += _condition_faults(study)
    faults += _exact_faults(study)
    faults += _goal_faults(study, at_fault)
    if study.people is not None:
        faults += study.people.contradictions()
    quantities = {name: key.quantity for path, key in keys().items() for name in (path, key.column)}
    faults += figure_faults(study.figure, quantities, [*_own_columns(study)], at_fault)
    return faults


def motion_faults(study: Study) -> list[Fault]:
    """Return the faults of a motion in time that cannot be smoothed."""
    faults = (trajectory_fault(study.motion), short_record(study.motion))
    return [fault for fault in faults if fault is not None]


def without_intervals(study: Study) -> Study:
    """Return the study if it can be swept.

    Raises:
        StudyError: It has intervals, which hold no single values to sweep over, or no pretension in
            the unit of its gauge.
    """
    faults = []
    is_default = "pretension" not in study.tendon.model_fields_set
    if is_default and dimension_of_reading(study.setting.read) == "torque":
        problem = f'is needed with setting.read = "{study.setting.read}"'
        faults.append(Fault(PRETENSION, problem, 'such as "1.2 N m"'))
    for key, values in study.numbers.items():
        if values.is_interval and isinstance(values.source, Grid):
            ends = f"from = {values.source.start.quoted}, to = {values.source.stop.quoted}"
            problem = (
                "is an interval, a condition of `tendon design`; `tendon sweep` needs single values"
            )
            faults.append(Fault(key, problem, f"give it a num, as in {{ {ends}, num = 5 }}"))
    if faults:
        raise StudyError(faults)
    return study


def check_shares_are_counted(study: Study) -> None:
    """Check that a share is asked for only where there are persons or draws to count.

    Raises:
        StudyError: `serve` is below 1, or a goal is a share, and the study has neither.
    """
    if not {*SAMPLE_AXES, *study.drawn_tables}.isdisjoint(study.axes):
        return
    problem = (
        "{} persons or draws, and the study has neither: a load, a case or a posture is always kept"
    )
    hint = 'leave it out, or state people, uncertain numbers, or a [[table]] with role = "draw"'
    faults = []
    if study.serve < 1.0:
        faults.append(Fault("design.serve", problem.format("counts"), hint))
    for key in ("minimise", "maximise"):
        shares = [goal for goal in getattr(study.design, key) if goal in ("served", "served_at")]
        about = [problem.format(f'"{goal}" counts') for goal in shares]
        faults += [Fault(f"design.{key}", words, hint) for words in about]
    if faults:
        raise StudyError(faults)


def implausible_faults(study: Study, files: Collection[str] = ()) -> Iterator[Fault]:
    """Yield a fault for each value that is far from any arm, unless the study accepts them.

    Args:
        study: The study.
        files: Keys that name files from which numbers of the study were read.
    """
    if study.allow_implausible:
        return
    for key, slips in study.slips.items():
        yield from slip_faults(_key_of_file(key, files), slips)


def _key_of_file(key: str, files: Collection[str]) -> str:
    """Return the key that names the file from which a number was read, if there is one."""
    table, _, name = key.rpartition(".")
    for number, file in FILES_OF_SHEATH.items():
        if name == number and f"{table}.{file}" in files:
            return f"{table}.{file}"
    return key


def check_set_once(study: Study) -> None:
    """Check that no row of a study sets a number that is drawn.

    Raises:
        StudyError: A row does.
    """
    faults = [*set_twice(study, KeyPlaces())]
    if faults:
        raise StudyError(faults)


# --- Keys that exclude or need each other --------------------------------------------------------


def _also_given(study: Study) -> dict[str, str]:
    """Return the keys of a study that another key of it also gives, each with the other one."""
    return {
        f"{table}.{name}": other
        for table, names, other in _GIVEN_BY
        if _value_at(study, other) is not None
        for name in sorted(names)
    }


def _value_at(study: Study, key: str) -> Any:
    """Return what a study has at a dotted key of one of its tables."""
    table, _, name = key.partition(".")
    return getattr(getattr(study, table), name)


def _duplicate_faults(study: Study) -> Iterator[Fault]:
    """Yield a fault for each key that another key also gives."""
    for key, other in _also_given(study).items():
        table, _, name = key.partition(".")
        if name in getattr(study, table).model_fields_set:
            yield Fault(key, f"cannot be given with {other}, which also gives it", _LEAVE_ONE_OUT)


def _dependence_faults(study: Study) -> Iterator[Fault]:
    """Yield a fault for each key that needs another key of its table, which is not given."""
    for table, names, needed, whole in _PART_OF:
        part = getattr(study, table)
        if getattr(part, needed) is not None:
            continue
        for name in names:
            if getattr(part, name) is not None:
                problem = f"belongs to {whole}, but the study has none"
                yield Fault(f"{table}.{name}", problem, f"add {table}.{needed}")


def sheath_faults(table: str, sheath: Any, at_fault: Collection[str] = ()) -> Iterator[Fault]:
    """Yield faults of numbers that a file of the sheath also gives, and of smoothing no route.

    Args:
        table: Dotted key of the table.
        sheath: The table, of both sides or of one.
        at_fault: Dotted keys that were left out of it.
    """
    for number, file in FILES_OF_SHEATH.items():
        if number in sheath.model_fields_set and getattr(sheath, file) is not None:
            problem = f"cannot be given with {file}, which also gives it"
            yield Fault(f"{table}.{number}", problem, _LEAVE_ONE_OUT)
    has_route = sheath.path is not None or f"{table}.path" in at_fault
    if sheath.path_smoothing is not None and not has_route:
        problem = "smooths a route, but this table names none"
        hint = 'add path = "route.csv", or leave it out'
        yield Fault(f"{table}.path_smoothing", problem, hint)


def _output_faults(study: Study, at_fault: set[str]) -> Iterator[Fault]:
    """Yield a fault if columns of states are chosen, but the states are not written."""
    is_written = "states" in study.output.tables or "output.tables" in at_fault
    if study.output.states and not is_written:
        hint = 'leave it out, or add "states" to tables'
        yield Fault("output.states", "names columns of a table that is not written", hint)


def anchor_faults(study: Study, at_fault: set[str]) -> Iterator[Fault]:
    """Yield faults of anchors that meet a file of persons, unless the study says whose they are.

    Those of a fitted suit are among them once its file has been read.
    """
    key = "arm.anchors"
    if study.people is None or not study.people.is_from_file or key in at_fault:
        return
    stated = [f"arm.{name}" for name in study.stated_anchors]
    of_rows = [
        (place, path)
        for table in study.row_tables
        for path, place in table.places.items()
        if path in _ANCHOR_KEYS
    ]
    keys_given = [*stated, *(place for place, _ in of_rows)]
    is_measured = study.arm.anchors == "measured"
    if study.arm.anchors is None and keys_given:
        names = ", ".join(keys_given)
        problem = f"is needed because this study states {names} and has a file of persons"
        yield Fault(key, problem, WHOSE_ANCHORS)
    elif is_measured and not keys_given:
        is_known = study.fitted_from is None  # else the file of a fitted suit could not be read
        if is_known and not any(name in at_fault for name in _ANCHOR_KEYS):
            problem = '"measured" is about stated anchors, but this study states none'
            yield Fault(key, problem, 'such as b1 = "110 mm" in [arm], or leave it out')
    elif is_measured:
        for place, path in of_rows:
            if path not in stated:
                problem = "is measured in this case, and scaled from the mean man elsewhere"
                if any(_say_in_all_rows(table, {path}) for table in study.row_tables):
                    problem = '"measured" is about anchors of [arm], which does not state this one'
                hint = f"give {path} in the study, too: each value here replaces it"
                yield Fault(place, problem, hint)


def _rest_angle_faults(study: Study, at_fault: set[str]) -> Iterator[Fault]:
    """Yield a fault if the joint has a stiffness, but no angle at which it rests."""
    if is_stated(study, "joint.stiffness") and _is_lacking(study, "joint.rest_angle", at_fault):
        problem = "needs the angle at which the joint itself exerts no torque"
        yield Fault("joint.stiffness", problem, 'such as joint.rest_angle = "73 deg"')


def _reading_faults(study: Study) -> Iterator[Fault]:
    """Yield a fault for each pretension of a single side, if one gauge is read for both."""
    if study.setting.read == F0:
        return
    given = {*study.numbers}
    for table in study.row_tables:
        given.update(table.keys)
    reading = f'setting.read = "{study.setting.read}"'
    problem = f"cannot be given with {reading}, which is a single reading for both sides"
    for key in sorted({of_side(PRETENSION, side) for side in SIDES} & given):
        yield Fault(key, problem, "leave it out")


def _reading_unit_faults(study: Study) -> Iterator[Fault]:
    """Yield a fault for each reading that is stated in another unit than its gauge shows."""
    read = study.setting.read
    wanted_dimension = dimension_of_reading(read)
    stated = {"design.pretension": getattr(study.design.pretension, "dimension", None)}
    for key in (_LARGEST_PRETENSION, READING_ERROR, PRETENSION):
        is_default = key == PRETENSION and "pretension" not in study.tendon.model_fields_set
        if key in study.numbers and not is_default:
            stated[key] = study.numbers[key].dimension
    for rows in study.row_tables:
        for key, place in rows.places.items():
            stated[place] = rows.readings.get(key)
    accuracy = study.setting.accuracy
    if accuracy.tension is not None:
        stated["setting.accuracy"] = accuracy.dimension
    for key, dimension in stated.items():
        if dimension is not None and dimension != wanted_dimension:
            kind = {"force": "tension", "torque": "torque"}[dimension]
            problem = (
                f'is a {kind}, but setting.read = "{read}", expected {wanted(wanted_dimension)}'
            )
            yield Fault(key, problem)


# --- Curves and limits ---------------------------------------------------------------------------


def curve_faults(study: Study, at_fault: Collection[str] = ()) -> Iterator[Fault]:
    """Yield a fault for each curve that does not reach as far as the motion.

    A torque over time needs a motion in time. Curves from files are checked only once the files
    have been read.

    Args:
        study: The study, without the keys that are at fault by themselves.
        at_fault: Dotted keys that were left out of it.
    """
    for key, curve in curves_in(study).items():
        beyond = not_covered(study, curve, is_travel=key == "joint.excursion")
        if beyond:
            yield Fault(key, beyond, hint_to_cover(curve))
    task = study.load.torque
    is_in_time = isinstance(task, CurveTable) and task.is_in_time
    if is_in_time and study.motion.trajectory is None and "motion.trajectory" not in at_fault:
        problem = "is a torque over time, but the study has no motion in time"
        hint = (
            "add motion.trajectory on the same clock, or give the torque over the angle; "
            f"{SIGN_OF_TASK}"
        )
        yield Fault("load.torque", problem, hint)


def _limit_faults(study: Study, at_fault: set[str]) -> Iterator[Fault]:
    """Yield a fault for each limit whose quantity cannot be computed without another key."""
    for name in study.limit_names:
        for need in LIMITS[name].needs:
            if _is_lacking(study, need.key, at_fault):
                hint = f'such as {need.key} = "{need.example}"'
                yield Fault(f"limits.{name}", f"needs {need.phrase}", hint)
    if "min_spring_room" in study.limit_names:
        problem = _lack_of_room(study)
        if problem is not None:
            yield Fault("limits.min_spring_room", problem, "leave it out")
    has_radius = study.joint.excursion is None or study.arm.contact_radius is not None
    if "max_contact_pressure" in study.limit_names and not has_radius:
        problem = "needs the radius of the strap, which does not follow from measured travels"
        yield Fault("limits.max_contact_pressure", problem, 'such as arm.contact_radius = "45 mm"')


def _lack_of_room(study: Study) -> str | None:
    """Return the reason why the flexor has no spring with room between the anchors.

    None if it has one, in the study and in each row of its tables.
    """
    if study.joint.excursion is not None:
        return "needs the anchors, which do not follow from measured travels"
    flexor = study.spring.flexor
    place = getattr(flexor, "at", None) or study.spring.at or ""
    stiffness = getattr(flexor, "stiffness", None) or study.spring.stiffness
    is_at_motor = "motor" in place
    is_rigid = stiffness is not None and math.isinf(stiffness.extremes[1])
    for table in study.row_tables:
        for common in (SPRING_AT, "spring.stiffness"):
            for key in (common, of_side(common, SIDES[0])):
                values = table.numbers.get(key, np.empty(0))
                is_at_motor |= common == SPRING_AT and bool((values == 1.0).any())
                is_rigid |= common != SPRING_AT and bool(np.isinf(values).any())
    if is_at_motor:
        return "needs a spring at the joint, but the flexor's sits at the motor"
    return "needs a spring, but the flexor has none" if is_rigid else None


def is_stated(study: Study, key: str) -> bool:
    """Return True if a study, or each row of one of its tables, says what a limit needs."""
    if key == SPEED.key:
        return study.motion.speed is not None or study.motion.trajectory is not None
    either_key = {key, of_side(key, SIDES[0])}
    if either_key & study.numbers.keys():
        return True
    return any(_say_in_all_rows(table, either_key) for table in study.row_tables)


def _say_in_all_rows(table: RowTable, either_key: set[str]) -> bool:
    """Return True if each row of a table sets one of some numbers."""
    given = [~np.isnan(table.numbers[key]) for key in either_key & table.numbers.keys()]
    return bool(given) and bool(np.logical_or.reduce(given).all())


def _is_lacking(study: Study, needed: str, at_fault: set[str]) -> bool:
    """Return True for a key that a study does not state, and that is not at fault either."""
    return not is_stated(study, needed) and not any(key.endswith(needed) for key in at_fault)


# --- Goals of a design ---------------------------------------------------------------------------


def _condition_faults(study: Study) -> Iterator[Fault]:
    """Yield a fault for each condition that is no axis of any study, or cannot be one."""
    paths = {key.column: path for path, key in keys().items()}
    known = (*keys(), *NAMED_AXES, *(table.key for table in study.row_tables))
    for name in study.design.conditions or ():
        if split_side(name)[0] == PRETENSION:
            problem = f'"{name}" cannot be a condition: tendon design solves for it'
            yield Fault("design.conditions", problem, "leave it out")
        elif name not in known and name not in study.words:
            problem = f'"{shorten(name)}" is not an axis that a study can have'
            yield Fault("design.conditions", problem, hint_at_nearest(paths.get(name, name), known))


def _exact_faults(study: Study) -> Iterator[Fault]:
    """Yield a fault for each name of an exact number that is no key, no table, and no sensor's."""
    names = study.uncertainty.exact if study.uncertainty is not None else ()
    tables = {key[:end] for key in keys() for end in range(len(key)) if key[end] == "."}
    known = (*keys(), *sorted(tables), BACKLASH)
    for name in names:
        if name not in known and " " not in name:  # other errors of sensors are of several words
            problem = f'"{shorten(name)}" is neither a number of a study nor a table of them'
            yield Fault("uncertainty.exact", problem, hint_at_nearest(name, known))


def _goal_faults(study: Study, at_fault: set[str]) -> Iterator[Fault]:
    """Yield faults of goals that are no column, lack a key, or contradict each other."""
    known = (*CHOICE_RESULTS, *_choice_columns(study, at_fault))
    may_be_of_a_table = any(key.startswith("table.") for key in at_fault)
    for table, names in (("minimise", study.design.minimise), ("maximise", study.design.maximise)):
        for name in names:
            lacking = _lacking(study, name, at_fault)
            never = _null_in_all(study, name, at_fault)
            if name not in known:
                if may_be_of_a_table:
                    continue  # of a catalogue that could not be read
                problem = f'there is no column "{shorten(name)}" in the choices of this study'
                hint = hint_at_nearest(name, known) or f"its columns: {', '.join(known)}"
                yield Fault(f"design.{table}", problem, hint)
            elif lacking is not None:
                problem = f"no choice has a {name} without {lacking}"
                yield Fault(f"design.{table}", problem, f"state {lacking}")
            elif never is not None:
                yield Fault(f"design.{table}", f"{name} {never}", "leave it out")
            elif table == "maximise" and name in study.design.minimise:
                problem = f'"{name}" is both minimised and maximised, expected only one'
                yield Fault("design.maximise", problem)


def _own_columns(study: Study) -> Iterator[str]:
    """Yield the columns that name the rows of a study's tables, or that these carry along."""
    for table in study.row_tables:
        yield table.key
        for column in table.carried:
            yield from (f"{table.key}_{column.name}", column.name)


def _choice_columns(study: Study, at_fault: set[str]) -> Iterator[str]:
    """Yield the columns of the axes that are choices, or would be if they were not at fault."""
    for key in (*study.axes, *sorted(at_fault)):
        is_choice = split_side(key)[0] != PRETENSION and key not in study.conditions
        if key in keys() and is_choice:
            yield keys()[key].column
    choices = [table for table in study.row_tables if table.key not in study.conditions]
    for table in choices:
        yield from (keys()[key].column for key in table.keys if key in keys())
        for column in table.carried:
            if not column.words:
                yield f"{table.key}_{column.name}"
            if column.addends is not None:
                yield column.name


def _lacking(study: Study, column: str, at_fault: set[str]) -> str | None:
    """Return the key that a column of the choices needs and the study does not state."""
    needs = LIMITS[column].needs if column in LIMITS else ()
    if column in OF_CYCLES:
        needs = (SPEED,)
    for need in needs:
        if _is_lacking(study, need.key, at_fault):
            return need.key
    is_along = study.motion.trajectory is not None or "motion.trajectory" in at_fault
    return "motion.trajectory" if column in OF_TRAJECTORIES and not is_along else None


def _null_in_all(study: Study, column: str, at_fault: set[str]) -> str | None:
    """Return the reason why a column of the motion is null in all choices; None if it is not."""
    is_along = study.motion.trajectory is not None
    directions = study.motion.direction
    if column in _OF_BOTH_DIRECTIONS:
        compares = "compares flexion and extension at one angle"
        if is_along:
            return f"{compares}, which a trajectory does not have"
        if "motion.direction" not in at_fault and len(set(directions)) == 1:
            return f"{compares}, but the study moves in {directions[0]} alone"
    if column == "efficiency" and not is_along and "motion.elbow_angle" not in at_fault:
        least, largest = study.motion.elbow_angle.extremes
        if least == largest:
            return "needs work over a motion, but the study has a single elbow angle"
    return None


# --- Tables of rows ------------------------------------------------------------------------------


def set_twice(study: Study, places: KeyPlaces, settings: Collection[str] = ()) -> Iterator[Fault]:
    """Yield a fault for each number that rows set, and that something else gives, too.

    Args:
        study: The study, with the rows of its cases and tables.
        places: Lines of the keys in the file of the study.
        settings: Keys that the command line sets.
    """
    setters: dict[str, str] = {}
    for table in study.row_tables:
        whose = "a case" if table.is_of_cases else f'the table "{table.key}"'
        does = "do the cases" if table.is_of_cases else f"does the table {table.key}"
        for key, place in table.places.items():
            where = place if table.is_of_cases else table.where
            other = _other_setter(study, table, key, settings)
            line, _ = places.places.get(key, (None, None))
            if key in setters:
                other = f"so {setters[key]}", _LEAVE_ONE_OUT
            elif other is not None and line is not None:
                other = f"{other[0]} (line {line})", other[1]
            setters[key] = f"{does} ({where})"
            if other is not None:
                yield Fault(where, f"{whose} sets {key}, but {other[0]}", other[1])


def _other_setter(
    study: Study, table: RowTable, key: str, settings: Collection[str]
) -> tuple[str, str] | None:
    """Say what else than a table and a plain value gives a number, with a hint; None for nothing.

    Cases replace what the command line sets, and the middle of a number that is not drawn.
    """
    values = study.numbers.get(key)
    if key in settings and not table.is_of_cases:
        return f"--set {key} does, too", _LEAVE_ONE_OUT
    if key in study.words or (values is not None and values.is_axis):
        return f"{key} is an axis of this study", _LEAVE_ONE_OUT
    if key in study.uncertain and not table.is_of_cases:
        return f"{key} is uncertain in this study", _LEAVE_ONE_OUT
    if key in study.uncertain and study.drawing is not None:
        hint = "[uncertainty] draws = 0 takes its middle in the other cases"
        return f"{key} is uncertain in this study, and drawn", hint
    if key in study.body_numbers:
        hint = f"give {key} in the study, too: then it holds for everyone, except in these rows"
        return f"{key} comes from the body of each person", hint
    curves = curves_in(study)
    if key in curves:
        return f"{key} follows the joint in this study", _LEAVE_ONE_OUT
    common, _ = split_side(key)
    if key not in study.numbers and common in curves:
        hint = f"give {key} in the study, too: then it holds except in these rows"
        return f"{common} follows the joint in this study", hint
    other = _also_given(study).get(key)
    return None if other is None else (f"{other} also gives it", _LEAVE_ONE_OUT)
