"""What no single key can know: keys that contradict each other, and combinations that cannot be."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from tendon_cli.errors import Fault, StudyError
from tendon_cli.model.design import F0
from tendon_cli.model.forms import Need
from tendon_cli.model.limits import LIMITS, SPEED
from tendon_cli.model.setting import Reading
from tendon_cli.space.axis import CASE_AXIS, NAMED_AXES, PRETENSION, SIDES, of_side, split_side
from tendon_cli.space.space import ANCHORS, Space
from tendon_cli.studies.axes import case_axis, number_axis, single_numbers, space_of
from tendon_cli.studies.contents import case_numbers
from tendon_cli.studies.curves import CurveTable, bends_of, not_covered
from tendon_cli.studies.design import CHOICE_RESULTS
from tendon_cli.studies.fields import nearest
from tendon_cli.studies.figures import figure_faults
from tendon_cli.studies.study import Study, keys
from tendon_cli.studies.values import Grid, Values
from tendon_cli.units import shorten

_MOST_READINGS, _ROUNDING = 10**6, 1e-6
MAX_FRICTION_EXPONENT = 100.0
"""Largest μφ: a tendon that loses 43 orders of magnitude of its tension is a slip of the pen."""

_MOST_ARMS_TO_CHECK = 100_000


def contradictions(study: Study, at_fault: set[str]) -> list[Fault]:
    """Every fault between keys of a study; those of `at_fault` are wrong by themselves and were left out of it."""
    return [
        *_two_sources(study, at_fault),
        *_case_faults(study),
        *_output_faults(study, at_fault),
        *_limit_faults(study, at_fault),
        *_joint_faults(study, at_fault),
        *_setting_faults(study),
        *_curve_faults(study),
        *_goal_faults(study, at_fault),
        *_people_faults(study),
        *_draw_faults(study),
        *figure_faults(
            study.figure, {n: k.number.quantity for p, k in keys().items() for n in (p, k.column)}, at_fault
        ),
    ]


def _draw_faults(study: Study) -> Iterator[Fault]:
    """A number that is drawn and that a case gives, too."""
    for at, case in enumerate(study.cases if study.uncertainty is not None else ()):
        for key in set(case_numbers(case)).intersection(study.uncertain):
            yield Fault(f"cases.{at}.{key}", "is uncertain in this study and drawn, so a case cannot set it")


def _people_faults(study: Study) -> Iterator[Fault]:
    """Keys of people that do not go together, and numbers of the body that a case gives and the study does not."""
    if study.people is None:
        return
    yield from study.people.contradictions()
    for at, case in enumerate(study.cases):
        for key in set(case_numbers(case)).intersection(study.of_the_body):
            hint = f"state {key} in the study, too: then it holds for everyone but this case"
            yield Fault(f"cases.{at}.{key}", "comes from the body of each person", hint)


def without_intervals(study: Study) -> Study:
    """The study; raises StudyError if numbers of it are intervals, which hold no values to sweep over."""
    faults = []
    for key, values in study.numbers.items():
        if not values.is_interval or not isinstance(values.source, Grid):
            continue
        ends = f"from = {values.source.start.quoted}, to = {values.source.stop.quoted}"
        problem = "is an interval, a condition of `tendon design`; `tendon sweep` needs single values"
        faults.append(Fault(key, problem, f"give it a num, as in {{ {ends}, num = 5 }}"))
    if faults:
        raise StudyError(faults)
    return study


def impossibilities(study: Study) -> list[Fault]:
    """Combinations of numbers, those of its files included, that cannot be."""
    return [*_friction_faults(study), *_anchor_faults(study), *_faults_of_by(study), *_reading_faults(study)]


def _faults_of_by(study: Study) -> Iterator[Fault]:
    """Shares by a column that the people do not have."""
    if study.design.by is None:
        return
    if study.people is None:
        yield Fault("design.by", "gives shares of people, and this study has none", 'add [people] source = "ansur2"')
    elif not study.people.population.sexes:
        hint = 'a column "sex" with male or female, or people.sex if all are alike'
        yield Fault("design.by", "gives shares by sex, which the file of people does not say", hint)


def _reading_faults(study: Study) -> Iterator[Fault]:
    """A pretension that no gauge can show, as even without pretension it shows more."""
    if study.setting.read == F0 or len(space := space_of(study)) > _MOST_READINGS:
        return
    design = space.design()
    least = float(np.nanmax(Reading.of(design, design.read).shown(0.0)))
    if np.nanmin(design.flexor.pretension) < -_ROUNDING:
        problem = f"cannot be read as {design.read}, which shows {least:.4g} N or more in the setting of every design"
        yield Fault(PRETENSION, problem, f"such as {1.5 * least:.0f} N, or another [setting]")


def _two_sources(study: Study, at_fault: set[str]) -> Iterator[Fault]:
    """A number that is given twice, as itself and by a file, or a smoothing of no file."""
    for key, sheath in _sheaths(study):
        for number, file in (("friction", "friction_from"), ("bend_angle", "path")):
            if number in sheath.model_fields_set and getattr(sheath, file) is not None:
                yield Fault(f"{key}.{number}", f"stands beside {file}, which gives it too", "leave one of them out")
        if sheath.path_smoothing is not None and sheath.path is None and f"{key}.path" not in at_fault:
            problem = "smooths a route, but this table names none"
            yield Fault(f"{key}.path_smoothing", problem, 'add path = "route.csv", or leave it out')


def _output_faults(study: Study, at_fault: set[str]) -> Iterator[Fault]:
    if study.output.states and "states" not in study.output.tables and "output.tables" not in at_fault:
        hint = 'leave it out, or add "states" to tables'
        yield Fault("output.states", "names columns of a table that is not written", hint)


def _limit_faults(study: Study, at_fault: set[str]) -> Iterator[Fault]:
    """Limits of what cannot be known without another key."""
    for name in study.limits:
        for need in LIMITS[name].needs:
            if not is_stated(study, need) and not any(key.endswith(need.key) for key in at_fault):
                yield Fault(f"limits.{name}", f"needs {need.what}", f'such as {need.key} = "{need.example}"')
    if "min_spring_room" in study.limits and (problem := _no_room(study)):
        yield Fault("limits.min_spring_room", problem, "leave it out")


def _no_room(study: Study) -> str | None:
    """Why there is no room between the anchors for the flexor's spring to speak of."""
    if study.joint.excursion is not None:
        return "needs the flexor's path, which measured travels do not tell"
    springs = [study.spring, *(spring for case in study.cases if (spring := getattr(case, "spring", None)) is not None)]
    for spring in springs:
        side = spring.flexor
        if (getattr(side, "at", None) or spring.at) == "motor":
            return "is of a spring at the joint, but the flexor's sits at the motor"
        stiffness = getattr(side, "stiffness", None) or spring.stiffness
        if stiffness is not None and math.isinf(stiffness.extremes[1]):
            return "is of a spring, but the flexor has none"
    return None


def _curve_faults(study: Study) -> Iterator[Fault]:
    """Curves beside what says the same, or that do not reach as far as the joint moves."""
    joint = study.joint
    if joint.torque is not None and joint.stiffness is not None:
        yield Fault("joint.torque", "stands beside stiffness, which gives it too", "leave one of them out")
    if joint.excursion is None:
        for key in ("smoothing", "scale_with"):
            if getattr(joint, key) is not None:
                yield Fault(f"joint.{key}", "is of measured travels, but the study has none", "add joint.excursion")
    else:
        for name in sorted(set(ANCHORS) & study.arm.model_fields_set):
            yield Fault(f"arm.{name}", "stands beside joint.excursion, which gives the travels", "leave it out")
        if "max_contact_pressure" in study.limits and study.arm.contact_radius is None:
            problem = "needs the radius of the strap, which measured travels do not tell"
            yield Fault("limits.max_contact_pressure", problem, 'such as arm.contact_radius = "45 mm"')
        if "min_spring_room" in study.limits:
            yield Fault(
                "limits.min_spring_room", "needs the anchors, which measured travels do not tell", "leave it out"
            )
    inline = {"joint.torque": joint.torque, "joint.excursion": joint.excursion, "load.torque": study.load.torque}
    for key, table in (inline | bends_of(study)).items():
        if isinstance(table, CurveTable):
            beyond = not_covered(study, table, is_travel=key == "joint.excursion")
            if beyond is not None:
                yield Fault(key, beyond, "extend the curve, or ask for fewer angles")


def _setting_faults(study: Study) -> Iterator[Fault]:
    """A reading beside pretensions of the sides, of which it is one, or of one case alone."""
    if study.setting.read != F0:
        for key in (of_side(PRETENSION, side) for side in SIDES):
            if key in study.numbers or any(key in case_numbers(case) for case in study.cases):
                problem = f'cannot stand beside setting.read = "{study.setting.read}", which is one reading for both'
                yield Fault(key, problem, "leave it out")


def _joint_faults(study: Study, at_fault: set[str]) -> Iterator[Fault]:
    """A stiffness of the joint without the angle at which it asks for nothing."""
    stiffness, rest = Need("joint.stiffness", "", ""), Need("joint.rest_angle", "", "")
    if is_stated(study, stiffness) and not is_stated(study, rest) and rest.key not in at_fault:
        problem = "needs the angle at which the joint itself asks for no torque"
        yield Fault(stiffness.key, problem, f'such as {rest.key} = "73 deg"')


def is_stated(study: Study, need: Need) -> bool:
    """Whether a study, or each of its cases, says what a limit needs."""
    if need == SPEED:
        return study.motion.speed is not None
    cases = [case_numbers(case) for case in study.cases]
    table, _, name = need.key.rpartition(".")
    sides = [need.key, *(f"{table}.{side}.{name}" for side in SIDES[:1])]
    return any(key in study.numbers for key in sides) or (
        bool(cases) and all(any(key in case for key in sides) for case in cases)
    )


def _lacking(study: Study, column: str, at_fault: set[str]) -> str:
    """The key that a column of the choices needs and the study does not state; empty if it lacks none."""
    needs = LIMITS[column].needs if column in LIMITS else ()
    stated = (need for need in needs if is_stated(study, need) or any(key.endswith(need.key) for key in at_fault))
    return "" if len([*stated]) == len(needs) else needs[0].key


def _goal_faults(study: Study, at_fault: set[str]) -> Iterator[Fault]:
    """Conditions that are no axis of any study, and goals that are no column of the answer."""
    columns = {key.column: path for path, key in keys().items()}
    for name in study.design.conditions or ():
        if split_side(name)[0] == PRETENSION:
            problem = f'"{name}" cannot be a condition, it is what tendon design solves for'
            yield Fault("design.conditions", problem, "leave it out")
        elif name not in keys() and name not in NAMED_AXES:
            hint = nearest(columns.get(name, name), (*keys(), *NAMED_AXES))
            yield Fault("design.conditions", f'"{shorten(name)}" is no axis that a study can have', hint)
    axes = [key for key in (*study.axes, *at_fault) if key in keys() and split_side(key)[0] != PRETENSION]
    known = (*CHOICE_RESULTS, *(keys()[key].column for key in axes if key not in study.conditions))
    for table, names in (("minimise", study.design.minimise), ("maximise", study.design.maximise)):
        for name in names:
            if name not in known:
                problem = f'there is no column "{shorten(name)}" in the choices of this study'
                yield Fault(f"design.{table}", problem, nearest(name, known) or f"its columns: {', '.join(known)}")
            elif lacking := _lacking(study, name, at_fault):
                yield Fault(f"design.{table}", f"no choice has a {name} without {lacking}", f"state {lacking}")
            elif table == "maximise" and name in study.design.minimise:
                yield Fault("design.maximise", f'"{name}" is minimised, too, expected one of both')


def _sheaths(study: Study) -> Iterator[tuple[str, Any]]:
    tables: list[tuple[str, Any]] = [("sheath", study.sheath)]
    tables += [(f"cases.{at}.sheath", getattr(case, "sheath", None)) for at, case in enumerate(study.cases)]
    for key, sheath in tables:
        if sheath is not None:
            yield key, sheath
            yield from ((f"{key}.{side}", inner) for side in SIDES if (inner := getattr(sheath, side)) is not None)


def _case_faults(study: Study) -> Iterator[Fault]:
    seen: set[str] = set()
    axes = {key for key, values in study.numbers.items() if values.is_axis}
    for at, case in enumerate(study.cases):
        name = str(getattr(case, "name", ""))
        if name in seen:
            yield Fault(f"cases.{at}.name", f'"{name}" names two cases, expected each name once')
        seen.add(name)
        for key in case_numbers(case):
            if key in axes:
                yield Fault(f"cases.{at}.{key}", "is an axis of this study, so a case cannot set it")


def _friction_faults(study: Study) -> Iterator[Fault]:
    """A product of friction and bend angle, on one side, beyond any sheath."""
    largest = {key: _largest(values) for key, values in study.numbers.items() if key.startswith("sheath.")}
    space = Space((case_axis(study),) if study.cases else (), largest)
    for side in SIDES:
        friction, bend_angle = (
            space.number(f"sheath.{name}", side).within(space.whole) for name in ("friction", "bend_angle")
        )
        reached = np.ravel(friction * bend_angle)
        at = int(np.argmax(reached > MAX_FRICTION_EXPONENT))
        if reached[at] > MAX_FRICTION_EXPONENT:
            problem = f"friction x bend_angle reaches {reached[at]:.4g} on the {side}'s side{_in_case(space, at)}"
            problem += f", expected {MAX_FRICTION_EXPONENT:g} at most"
            yield Fault("sheath.friction", problem, "a bend angle without unit is in rad")
            return


def _largest(values: Values) -> float:
    """The largest value that a number has, or may well be drawn with."""
    return values.uncertain.reach[1] if values.uncertain else values.extremes[1]


def _in_case(space: Space, row: int) -> str:
    """How an error names the case of a design; nothing in a study without cases."""
    cases = space.axes[0] if space.axes and space.axes[0].key == CASE_AXIS else None
    return "" if cases is None else f' in the case "{shorten(cases.names[np.unravel_index(row, space.shape)[0]])}"'


def _anchor_faults(study: Study) -> Iterator[Fault]:
    """An elbow angle asked for at which the flexor's two anchors coincide: its path has no direction there."""
    anchors = {name: f"arm.{name}" for name in ("a1", "b1", "a2", "b2")}
    axes = [case_axis(study)] if study.cases else []
    axes += [number_axis(study, key) for key in study.axes if key in anchors.values()]
    space = Space(tuple(axes), single_numbers(study))
    if len(space) > _MOST_ARMS_TO_CHECK:
        return  # such states are found one by one when the study runs, as states without equilibrium
    given = (space.number(key).within(space.whole) for key in anchors.values())
    a1, b1, a2, b2 = (np.broadcast_to(each, (*space.shape, 1, 1)).ravel() for each in given)
    meeting = np.pi - np.arctan2(a1, b1) - np.arctan2(a2, b2)
    alike = np.abs(np.hypot(a1, b1) - np.hypot(a2, b2)) <= 1e-12 * b1
    angles = study.motion.elbow_angle
    low, high = angles.extremes
    for row in np.flatnonzero(alike & (low <= meeting) & (meeting <= high)):
        if np.min(np.abs(angles.array - meeting[row])) < 1e-9:
            yield Fault(
                "arm",
                f"the flexor's anchors coincide (L_c = 0) at the elbow angle {np.degrees(meeting[row]):.6g} deg"
                + _in_case(space, int(row)),
                "make a1, b1 and a2, b2 differ, or leave this angle out",
            )
            return
