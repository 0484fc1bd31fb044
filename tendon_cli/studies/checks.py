"""What no single key can know: keys that contradict each other, and combinations that cannot be."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from tendon_cli.errors import Fault, StudyError
from tendon_cli.model.design import F0
from tendon_cli.model.forms import Need
from tendon_cli.model.limits import LIMITS, SPEED
from tendon_cli.space.axis import NAMED_AXES, PRETENSION, SIDES, of_side, split_side
from tendon_cli.space.space import ANCHORS
from tendon_cli.studies.angle_curves import CurveTable, bends_of, not_covered
from tendon_cli.studies.contents import case_numbers
from tendon_cli.studies.design_section import CHOICE_RESULTS
from tendon_cli.studies.fields import nearest
from tendon_cli.studies.figures import figure_faults
from tendon_cli.studies.measured_motion import trajectory_fault
from tendon_cli.studies.spaces import word_of
from tendon_cli.studies.study import Study, keys
from tendon_cli.studies.values import Grid
from tendon_cli.units import shorten


def contradictions(study: Study, at_fault: set[str]) -> list[Fault]:
    """Every fault between keys of a study; those of `at_fault` are wrong by themselves and were left out of it."""
    quantities = {
        name: key.number.quantity for path, key in keys().items() for name in (path, key.column)
    }
    people = study.people.contradictions() if study.people is not None else ()
    return [
        *_key_faults(study, at_fault),
        *_joint_faults(study, at_fault),
        *_case_faults(study),
        *_limit_faults(study, at_fault),
        *curve_faults(study),
        *((wrong,) if (wrong := trajectory_fault(study.motion)) is not None else ()),
        *_goal_faults(study, at_fault),
        *people,
        *figure_faults(study.figure, quantities, at_fault),
    ]


def without_intervals(study: Study) -> Study:
    """The study; raises StudyError if numbers of it are intervals, which hold no values to sweep over."""
    faults = []
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


_ONE = "leave one of them out"
_GIVEN_BY: tuple[tuple[str, tuple[str, ...], str], ...] = (
    ("joint", ("torque",), "joint.stiffness"),
    ("arm", ANCHORS, "joint.excursion"),
    ("motion", ("elbow_angle", "direction", "speed"), "motion.trajectory"),
)
"""Keys of a table that cannot stand beside another key."""
_OF_ANOTHER = (
    ("joint", ("smoothing", "scale_with"), "excursion", "measured travels"),
    ("motion", ("cutoff", "reversal", "inertia"), "trajectory", "a trajectory"),
)
"""Keys of a table that need another one of it, and of what they are."""


def _key_faults(study: Study, at_fault: set[str]) -> Iterator[Fault]:
    """What is given twice, what lacks another key, and what is of no file and no table."""
    for table, given, other in _GIVEN_BY:
        room, _, by = other.partition(".")
        if getattr(getattr(study, room), by) is not None:
            for name in sorted(getattr(study, table).model_fields_set.intersection(given)):
                yield Fault(f"{table}.{name}", f"stands beside {other}, which gives it, too", _ONE)
    for table, names, needed, of in _OF_ANOTHER:
        for name in names:
            if (
                getattr(getattr(study, table), needed) is None
                and getattr(getattr(study, table), name) is not None
            ):
                yield Fault(
                    f"{table}.{name}",
                    f"is of {of}, but the study has none",
                    f"add {table}.{needed}",
                )
    for at, sheath in _sheaths(study):
        for number, file in (("friction", "friction_from"), ("bend_angle", "path")):
            if number in sheath.model_fields_set and getattr(sheath, file) is not None:
                yield Fault(f"{at}.{number}", f"stands beside {file}, which gives it, too", _ONE)
        if (
            sheath.path_smoothing is not None
            and sheath.path is None
            and f"{at}.path" not in at_fault
        ):
            hint = 'add path = "route.csv", or leave it out'
            yield Fault(f"{at}.path_smoothing", "smooths a route, but this table names none", hint)
    if study.output.states and not {"states", "output.tables"} & {*study.output.tables, *at_fault}:
        hint = 'leave it out, or add "states" to tables'
        yield Fault("output.states", "names columns of a table that is not written", hint)


def _joint_faults(study: Study, at_fault: set[str]) -> Iterator[Fault]:
    """A stiffness of the joint without its angle, readings per side, and limits that a motion in time does not have."""
    stiffness, rest = (Need(f"joint.{name}", "", "") for name in ("stiffness", "rest_angle"))
    if is_stated(study, stiffness) and not is_stated(study, rest) and rest.key not in at_fault:
        problem = "needs the angle at which the joint itself asks for no torque"
        yield Fault(stiffness.key, problem, f'such as {rest.key} = "73 deg"')
    if study.setting.read != F0:
        given = {*study.numbers, *(key for case in study.cases for key in case_numbers(case))}
        problem = f'cannot stand beside setting.read = "{study.setting.read}", which is one reading for both'
        for key in sorted({of_side(PRETENSION, side) for side in SIDES} & given):
            yield Fault(key, problem, "leave it out")
    if study.motion.trajectory is not None:
        problem = "compares the directions at one angle, which a trajectory does not"
        for name in sorted({"max_backlash", "max_torque_band"} & study.limits.keys()):
            yield Fault(f"limits.{name}", problem, "leave it out")


def _limit_faults(study: Study, at_fault: set[str]) -> Iterator[Fault]:
    """Limits of what cannot be known without another key."""
    for name in study.limits:
        for need in LIMITS[name].needs:
            if not is_stated(study, need) and not _is_of(need, at_fault):
                yield Fault(
                    f"limits.{name}", f"needs {need.what}", f'such as {need.key} = "{need.example}"'
                )
    if "min_spring_room" in study.limits and (problem := _no_room(study)):
        yield Fault("limits.min_spring_room", problem, "leave it out")
    if (
        "max_contact_pressure" in study.limits
        and study.joint.excursion
        and study.arm.contact_radius is None
    ):
        problem = "needs the radius of the strap, which measured travels do not tell"
        yield Fault("limits.max_contact_pressure", problem, 'such as arm.contact_radius = "45 mm"')


def _no_room(study: Study) -> str | None:
    """Why there is no room between the anchors for the flexor's spring to speak of."""
    if study.joint.excursion is not None:
        return "needs the anchors, which measured travels do not tell"
    springs = [
        study.spring,
        *(spring for case in study.cases if (spring := getattr(case, "spring", None)) is not None),
    ]
    for spring in springs:
        side = spring.flexor
        if "motor" in ((getattr(side, "at", None) or spring.at) or ""):
            return "is of a spring at the joint, but the flexor's sits at the motor"
        stiffness = getattr(side, "stiffness", None) or spring.stiffness
        if stiffness is not None and math.isinf(stiffness.extremes[1]):
            return "is of a spring, but the flexor has none"
    return None


def curve_faults(study: Study) -> Iterator[Fault]:
    """Curves in the study that do not reach as far as the joint moves."""
    joint = study.joint
    inline = {
        "joint.torque": joint.torque,
        "joint.excursion": joint.excursion,
        "load.torque": study.load.torque,
    }
    for key, table in (inline | bends_of(study)).items():
        is_travel = key == "joint.excursion"
        if isinstance(table, CurveTable) and (
            beyond := not_covered(study, table, is_travel=is_travel)
        ):
            yield Fault(key, beyond, "extend the curve, or ask for fewer angles")


def is_stated(study: Study, need: Need) -> bool:
    """Whether a study, or each of its cases, says what a limit needs."""
    if need == SPEED:
        return study.motion.speed is not None or study.motion.trajectory is not None
    sides = {need.key, of_side(need.key, SIDES[0])}
    cases = [sides & case_numbers(case).keys() for case in study.cases]
    return bool(sides & study.numbers.keys()) or (bool(cases) and all(cases))


def _lacking(study: Study, column: str, at_fault: set[str]) -> str:
    """The key that a column of the choices needs and the study does not state; empty if it lacks none."""
    needs = LIMITS[column].needs if column in LIMITS else ()
    return next(
        (need.key for need in needs if not is_stated(study, need) and not _is_of(need, at_fault)),
        "",
    )


def _is_of(need: Need, at_fault: set[str]) -> bool:
    return any(key.endswith(need.key) for key in at_fault)


def _goal_faults(study: Study, at_fault: set[str]) -> Iterator[Fault]:
    """Conditions that are no axis of any study, and goals that are no column of the answer."""
    columns = {key.column: path for path, key in keys().items()}
    for name in study.design.conditions or ():
        if split_side(name)[0] == PRETENSION:
            problem = f'"{name}" cannot be a condition, it is what tendon design solves for'
            yield Fault("design.conditions", problem, "leave it out")
        elif name not in keys() and name not in NAMED_AXES and name not in study.words:
            hint = nearest(columns.get(name, name), (*keys(), *NAMED_AXES))
            yield Fault(
                "design.conditions", f'"{shorten(name)}" is no axis that a study can have', hint
            )
    axes = [
        key
        for key in (*study.axes, *at_fault)
        if key in keys() and split_side(key)[0] != PRETENSION
    ]
    known = (*CHOICE_RESULTS, *(keys()[key].column for key in axes if key not in study.conditions))
    for table, names in (("minimise", study.design.minimise), ("maximise", study.design.maximise)):
        for name in names:
            if name not in known:
                problem = f'there is no column "{shorten(name)}" in the choices of this study'
                yield Fault(
                    f"design.{table}",
                    problem,
                    nearest(name, known) or f"its columns: {', '.join(known)}",
                )
            elif lacking := _lacking(study, name, at_fault):
                yield Fault(
                    f"design.{table}",
                    f"no choice has a {name} without {lacking}",
                    f"state {lacking}",
                )
            elif table == "maximise" and name in study.design.minimise:
                yield Fault("design.maximise", f'"{name}" is minimised, too, expected one of both')


def _sheaths(study: Study) -> Iterator[tuple[str, Any]]:
    tables: list[tuple[str, Any]] = [("sheath", study.sheath)]
    tables += [
        (f"cases.{at}.sheath", getattr(case, "sheath", None)) for at, case in enumerate(study.cases)
    ]
    for key, sheath in tables:
        if sheath is not None:
            yield key, sheath
            yield from (
                (f"{key}.{side}", inner)
                for side in SIDES
                if (inner := getattr(sheath, side)) is not None
            )


def _case_faults(study: Study) -> Iterator[Fault]:
    """Cases of one name, and numbers of cases that something else gives."""
    names: set[str] = set()
    for at, case in enumerate(study.cases):
        name = str(getattr(case, "name", ""))
        if name in names:
            yield Fault(f"cases.{at}.name", f'"{name}" names two cases, expected each name once')
        names.add(name)
        is_axis = "is an axis of this study, so a case cannot set it"
        words = [key for key in study.words if word_of(case, key) is not None]
        numbers = [*case_numbers(case)]
        for key in words + [
            key for key in numbers if key in study.numbers and study.numbers[key].is_axis
        ]:
            yield Fault(f"cases.{at}.{key}", is_axis)
        for key in numbers:
            if study.uncertainty is not None and key in study.uncertain:
                yield Fault(
                    f"cases.{at}.{key}",
                    "is uncertain in this study and drawn, so a case cannot set it",
                )
            if key in study.of_the_body:
                hint = f"state {key} in the study, too: then it holds for everyone but this case"
                yield Fault(f"cases.{at}.{key}", "comes from the body of each person", hint)
