"""Parts that the choice named first needs: strap, rope, spools, springs and motor, in numbers."""

from __future__ import annotations

from functools import partial
from typing import Literal, cast

import numpy as np

from tendon_cli.engine.plan import columns_of_motion
from tendon_cli.engine.windows.advice import (
    FLEXIBLE_ROPES,
    HURTS,
    NARROW,
    NO_ROOM,
    PAIN,
    ROPE_SAFETY,
    WEAK,
    WIDTHS,
    is_stated,
    least_rope,
    least_spool,
)
from tendon_cli.engine.windows.question import Question
from tendon_cli.engine.windows.solutions import Solutions
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.engine.windows.study_arm import study_arm
from tendon_cli.engine.windows.worst_between import worst_between
from tendon_cli.model.actuator import evaluate
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags, Spline
from tendon_cli.model.limits import BREAKING_FORCE, FREE_LENGTH
from tendon_cli.model.moving import Moving
from tendon_cli.model.winding import least_free_length
from tendon_cli.model.window import Ends
from tendon_cli.quantities import SIDES
from tendon_cli.studies.space.axis import of_side
from tendon_cli.tables.schema import finite_or_none
from tendon_cli.verbs.answer_record import (
    FailingPart,
    MotorRecord,
    PartsRecord,
    RopeRecord,
    SpoolRecord,
    SpringRecord,
    StrapRecord,
)

_WIDTH = "arm.contact_width"
_WORN_PASS = 0.69
"""Share of the tension that sheaths of steel pass once they are worn."""
_USUAL_ROPE: Literal["7x7"] = "7x7"
"""Construction of a rope if the study states none: the one that asks for the wider spool."""
_ROPE_DIAMETER = 1.5875e-3
"""Diameter of a stainless 7x7 rope of 1/16 inch, m."""
_ROPE_STRENGTH = 2.1e3
"""Tension at which this rope breaks, N; that of others goes with the square of their diameter."""
_CODES: dict[FailingPart, int] = {
    "spring": NO_ROOM,
    "strap": HURTS,
    "rope": WEAK,
    "spool": NARROW,
}


def parts_record(solver: Solver, choice: Solutions, ends: Ends) -> PartsRecord | None:
    """Return the parts that a choice needs at its pretension, over the conditions that it serves.

    None if it serves nobody.

    Args:
        solver: Solver of the question.
        choice: The choice, solved with its worst values.
        ends: Ends of its windows, (1, conditions), as they are read.
    """
    question = solver.question
    groups = question.groups
    is_served = groups.served_at(ends.low, ends.high, choice.pretension)
    served = is_served[:, groups.of]  # (1, conditions)
    if not served.any():
        return None
    of_served = solver.for_question(question.within_groups(np.flatnonzero(served[0])))
    design = of_served.question.designs(choice.points.at_pretension(choice.pretension))
    failed = int(choice.advice[0])
    return PartsRecord(
        strap=_strap(of_served, choice, design),
        rope=_rope(question, choice, design),
        spool=_spool(question, study_arm(question, choice.points)),
        spring=_spring(of_served, choice, design),
        motor=_motor(of_served, choice),
        fails=[part for part, code in _CODES.items() if failed & code],
    )


def _everyone(question: Question) -> Flags:
    """Return True for one choice under every condition."""
    return np.ones((1, len(question.conditions)), dtype=np.bool_)


def _least(values: Array | float) -> float:
    """Return the least of numbers of designs; NaN if one is not known."""
    return float(np.fmin.reduce(np.asarray(values), axis=None))


def _strap(solver: Solver, choice: Solutions, design: Design) -> StrapRecord | None:
    """Return the strap that presses no harder than pain; None if its radius is not known."""
    question = solver.question
    count = len(question.conditions)
    a_metre_wide = solver.for_question(question.with_numbers({_WIDTH: np.ones(count)}))
    worst_of = a_metre_wide.worst
    if question.study.trajectory is None:
        worst_of = partial(worst_between, a_metre_wide)
    worst = worst_of(choice.points, choice.pretension, _everyone(question))
    force_per_length = float(worst.max_contact_pressure[0])  # T/R, N/m
    if np.isnan(force_per_length):
        return None
    width = _least(design.arm.contact_width)
    pressure = float(choice.worst.max_contact_pressure[0])
    if np.isfinite(width * pressure):
        force_per_length = width * pressure  # of the sample that set the choice
    return StrapRecord(
        width=finite_or_none(width),
        pressure=finite_or_none(pressure),
        most_pressure=PAIN,
        least_width=force_per_length / PAIN,
    )


def _rope(question: Question, choice: Solutions, design: Design) -> RopeRecord:
    """Return the rope that bears the largest tension with the customary reserve."""
    tension = float(choice.worst.max_tension[0])
    least = ROPE_SAFETY * tension
    return RopeRecord(
        tension=tension,
        reserve=ROPE_SAFETY,
        least_breaking_force=least,
        least_diameter=_ROPE_DIAMETER * float(np.sqrt(max(0.0, least) / _ROPE_STRENGTH)),
        kinds={
            kind: float(least_rope(strength, np.asarray(tension)))
            for kind, (strength, _) in FLEXIBLE_ROPES.items()
        },
        spools={kind: float(least_spool(kind, np.asarray(tension))) for kind in FLEXIBLE_ROPES},
        breaking_force=finite_or_none(_least(design.given[BREAKING_FORCE])),
        construction=question.study.tendon.rope,
    )


def _spool(question: Question, design: Design) -> SpoolRecord:
    """Return the spool that is the narrower for its rope, and the ropes that it suits."""
    radius = np.asarray(design.flexor_radius)
    diameters = (2.0 * radius, 2.0 * np.asarray(design.ratio) * radius)
    ropes = (np.asarray(design.flexor.diameter), np.asarray(design.extensor.diameter))
    ratios = [spool / rope for spool, rope in zip(diameters, ropes, strict=True)]
    place = int(np.argmin([_least(ratio) for ratio in ratios]))
    narrowest = np.argmin(ratios[place])
    shape = ratios[place].shape
    spool = float(np.broadcast_to(diameters[place], shape).flat[narrowest])
    rope = float(np.broadcast_to(ropes[place], shape).flat[narrowest])
    construction = question.study.tendon.rope
    return SpoolRecord(
        side=cast("Literal['flexor', 'extensor']", SIDES[place]),
        diameter=spool,
        rope_diameter=rope,
        ratio=spool / rope,
        construction=construction,
        least_diameter=WIDTHS[construction or _USUAL_ROPE] * rope,
        least_ratios=dict(WIDTHS),
        largest_ropes={name: spool / ratio for name, ratio in WIDTHS.items()},
    )


def _spring(solver: Solver, choice: Solutions, design: Design) -> SpringRecord | None:
    """Return the travel of the springs and the room for the flexor's; None if both are rigid."""
    nominal = study_arm(solver.question, choice.points)
    sides = (nominal.flexor, nominal.extensor)
    stiffnesses = [_least(side.spring_stiffness) for side in sides]
    travel = float(choice.worst.max_spring_extension[0])
    if not np.isfinite(stiffnesses).any():
        return None
    room = float(choice.worst.spring_room[0])
    keys = (FREE_LENGTH.key, of_side(FREE_LENGTH.key, SIDES[0]))
    free_length: float | None = None
    if any(is_stated(solver.question, key) for key in keys):
        free_length = float(np.nanmax(np.asarray(design.given[FREE_LENGTH.key])))
    record: SpringRecord = SpringRecord(
        stiffness=finite_or_none(stiffnesses[0]),
        travel=travel,
        free_length=free_length,
        room=finite_or_none(room),
        least_length=None,
        extension=None,
        distance=None,
    )
    if np.isfinite(stiffnesses[0]):
        force = stiffnesses[0] * travel
        record.least_length = float(least_free_length(stiffnesses[0], force))
    if np.isfinite(room):
        record.extension, record.distance = _tightest(solver, choice)
    return record


def _tightest(solver: Solver, choice: Solutions) -> tuple[float, float]:
    """Return the extension of the flexor's spring and its anchors' distance, m, in the worst state.

    It is the state with the least room among those at the angles of the question.
    """
    question = solver.question
    served = _everyone(question)
    values = solver.quantities_under_each(choice.points, choice.pretension, served)
    room = -values[-1]
    nearest = np.argmin(np.abs(room - choice.worst.spring_room[0]))
    few = question.for_conditions(np.array([nearest]))
    design = few.designs(choice.points.at_pretension(choice.pretension))
    trajectory = question.study.trajectory
    if trajectory is None:
        state = evaluate(design, few.angles, few.flexion)
    else:
        state = Moving.of(design, trajectory).counted_states[0]
    extension = np.asarray(state.balance.flexor * state.flexor.spring)
    path = np.asarray(state.motion.flexor_path, dtype=np.float64)
    room = np.where(design.flexor.spring_at_motor, np.nan, path - extension)
    tightest = int(np.nanargmin(room))
    return (
        float(np.broadcast_to(extension, room.shape).flat[tightest]),
        float(np.broadcast_to(path, room.shape).flat[tightest]),
    )


def _worn_torque(solver: Solver, choice: Solutions) -> float | None:
    """Return the largest motor torque with worn sheaths, N m; None if the study's pass less."""
    question = solver.question
    flexor = study_arm(question, choice.points).flexor
    bend = flexor.bend_angle
    if isinstance(bend, Spline):
        return None
    angle = float(np.ravel(bend)[0])
    friction = float(np.ravel(flexor.friction)[0])
    if angle <= 0.0 or np.exp(-friction * angle) <= _WORN_PASS:
        return None
    worn = np.full(len(question.conditions), -np.log(_WORN_PASS) / angle)
    both_sides = ("sheath.flexor.friction", "sheath.extensor.friction")
    with_worn = solver.for_question(question.with_numbers(dict.fromkeys(both_sides, worn)))
    worst = with_worn.worst(choice.points, choice.pretension, _everyone(question))
    return abs(float(worst.peak_motor_torque[0]))


def _motor(solver: Solver, choice: Solutions) -> MotorRecord:
    """Return the largest torque, and speed and power if the study says how fast the joint moves."""
    question = solver.question
    peaks: dict[str, Array] = {}
    if columns_of_motion(question.study):
        names = ("peak_motor_speed", "peak_motor_power")
        everyone = _everyone(question)
        peaks = solver.worst_of_motion(choice.points, choice.pretension, everyone, names)
    return MotorRecord(
        torque=abs(float(choice.worst.peak_motor_torque[0])),
        worn_torque=_worn_torque(solver, choice),
        speed=finite_or_none(peaks["peak_motor_speed"][0]) if peaks else None,
        power=finite_or_none(peaks["peak_motor_power"][0]) if peaks else None,
    )
