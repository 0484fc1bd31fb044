"""Limits of a taut state, each a straight line in its pretension with the most that it may be.

In a taut state the tensions are straight lines in the common pretension F (`response.Response`), and so are both
proximal tensions, spring extension, motor torque, contact pressure and elbow stiffness. Arguments broadcast as in
`actuator`; SI units, angles in radians.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.model.actuator import Situation
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flag, Real
from tendon_cli.model.response import Response, respond
from tendon_cli.model.statics import springs

(
    FLEXOR_SLACK, EXTENSOR_SLACK, FLEXOR_LEAST, EXTENSOR_LEAST, FLEXOR_MOST, EXTENSOR_MOST, FLEXOR_SPRING,
    EXTENSOR_SPRING, TORQUE_FORWARD, TORQUE_BACKWARD, PRESSURE, STIFFNESS, PRETENSION, SPOOL, NO_EQUILIBRIUM,
) = range(15)  # fmt: skip
NOTHING = -1
"""No limit binds: no pretension is below 0, and none need be too high."""

LIMIT_NAMES = (
    "flexor slack", "extensor slack", "min_flexor_tension", "min_extensor_tension", "max_tension", "max_tension",
    "max_spring_extension", "max_spring_extension", "peak_motor_torque", "peak_motor_torque", "max_contact_pressure",
    "min_elbow_stiffness", "max_pretension", "min_spool_to_tendon", "no equilibrium", "max_spool_travel",
    "max_backlash", "max_torque_band", "peak_motor_speed", "peak_motor_power", "max_motor_work_in",
    "max_friction_loss", "min_efficiency",
)  # fmt: skip
"""What each limit is called: as the column of designs that it bounds. Those of the motor are of `motor_window`."""
OF_THE_MOTOR = LIMIT_NAMES.index("max_spool_travel")
"""From here on they are the motor's."""

OF_FLEXOR = (FLEXOR_LEAST, FLEXOR_MOST, FLEXOR_SPRING)

Codes = npt.NDArray[np.int8]


@dataclass(frozen=True, eq=False)
class Bounds:
    """What a design's states are held to, in SI; infinite where nothing is asked. Slack is never allowed."""

    min_flexor_tension: Real = -np.inf
    """At both ends of the sheath, N."""
    min_extensor_tension: Real = -np.inf
    """At both ends of the sheath, N."""
    max_tension: Real = np.inf
    """Of either tendon at both ends of its sheath, N."""
    max_spring_extension: Real = np.inf
    """From free length, m."""
    peak_motor_torque: Real = np.inf
    """In magnitude, N m."""
    max_contact_pressure: Real = np.inf
    """Of the extensor's strap on the elbow, Pa."""
    min_elbow_stiffness: Real = 0.0
    """N m/rad; negative where the joint's own stiffness is counted on."""
    max_pretension: Real = np.inf
    """N."""
    min_spool_to_tendon: Real = 0.0
    """Diameter of a spool over that of its tendon."""


@dataclass(frozen=True, eq=False)
class Line:
    """A quantity of a taut state over its surplus v = F - shortfall: base + gain v, which may be `most` at most."""

    limit: int | Codes
    """Index into LIMIT_NAMES."""
    base: Array
    gain: Array
    most: Real

    @property
    def end(self) -> Array:
        """The surplus at which the limit is just kept."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray((self.most - self.base) / self.gain)


def spool_to_tendon(design: Design) -> Array:
    """Smaller spool's diameter over its tendon's: what bending over the spool does to a rope."""
    flexor = 2.0 * np.asarray(design.flexor_radius) / design.flexor.diameter
    extensor = 2.0 * np.asarray(design.ratio) * design.flexor_radius / design.extensor.diameter
    return np.minimum(flexor, extensor)


def contact_pressure(design: Design, extensor_tension: Array) -> Array:
    """p = T / (R_elb w) of the extensor's strap around the elbow (Pa), T its distal tension (N)."""
    return np.asarray(extensor_tension / (np.asarray(design.arm.anchors.elbow_radius) * design.arm.contact_width))


def limit_end(limit: int, design: Design, elbow_angle: Real, flexion: Flag, bounds: Bounds) -> Array:
    """The pretension at which one limit is just kept in each state, N; also of complex numbers, for derivatives."""
    if limit == PRETENSION:
        return np.asarray(bounds.max_pretension)
    shortfall, found = lines_of(Situation.of(design, elbow_angle, flexion), bounds)
    if limit in (FLEXOR_SLACK, EXTENSOR_SLACK):
        return shortfall
    return np.asarray(shortfall + next(line.end for line in found if np.all(line.limit == limit)))


def lines_of(at: Situation, bounds: Bounds) -> tuple[Array, list[Line]]:
    """The shortfall of states, and the lines of all limits that are asked for, slack first."""
    response = respond(at.coupling)
    slack = np.where(at.coupling.elbow_torque < 0.0, np.int8(FLEXOR_SLACK), np.int8(EXTENSOR_SLACK))
    found = [Line(slack, np.zeros(()), np.full((), -1.0), 0.0)]
    found += _of_tensions(at, response, bounds)
    found += _of_torque(at, response, bounds)
    found += _of_stiffness(at, response, bounds)
    return response.shortfall, found


def bounds_of_tension(at: Situation, bounds: Bounds) -> dict[int, Real]:
    """Along a sheath tension only scales, so all bounds on tensions are bounds on the distal ones, by limit, N."""
    flexor, extensor = at.flexor, at.extensor
    found: dict[int, Real] = {}
    if _asked(bounds.min_flexor_tension):
        found[FLEXOR_LEAST] = bounds.min_flexor_tension * np.maximum(1.0, flexor.capstan)
    if _asked(bounds.min_extensor_tension):
        found[EXTENSOR_LEAST] = bounds.min_extensor_tension * np.maximum(1.0, extensor.capstan)
    if _asked(bounds.max_tension):
        found[FLEXOR_MOST] = bounds.max_tension * np.minimum(1.0, flexor.capstan)
        found[EXTENSOR_MOST] = bounds.max_tension * np.minimum(1.0, extensor.capstan)
    if _asked(bounds.max_spring_extension):
        found[FLEXOR_SPRING] = bounds.max_spring_extension / flexor.spring
        found[EXTENSOR_SPRING] = bounds.max_spring_extension / extensor.spring
    if _asked(bounds.max_contact_pressure):
        area = np.asarray(at.design.arm.anchors.elbow_radius) * at.design.arm.contact_width
        found[PRESSURE] = bounds.max_contact_pressure * area
    return found


def _of_tensions(at: Situation, response: Response, bounds: Bounds) -> Iterator[Line]:
    x, y = (response.flexor_floor, response.flexor_gain), (response.extensor_floor, response.extensor_gain)
    for limit, bound in bounds_of_tension(at, bounds).items():
        base, gain = x if limit in OF_FLEXOR else y
        if limit in (FLEXOR_LEAST, EXTENSOR_LEAST):
            yield Line(limit, -base, -gain, -bound)
        else:
            yield Line(limit, base, gain, bound)


def _of_torque(at: Situation, response: Response, bounds: Bounds) -> Iterator[Line]:
    if _asked(bounds.peak_motor_torque):
        flexor_arm, extensor_arm = at.motor_arms
        base = response.flexor_floor * flexor_arm - response.extensor_floor * extensor_arm
        gain = response.flexor_gain * flexor_arm - response.extensor_gain * extensor_arm
        yield Line(TORQUE_FORWARD, base, gain, bounds.peak_motor_torque)
        yield Line(TORQUE_BACKWARD, -base, -gain, bounds.peak_motor_torque)


def _of_stiffness(at: Situation, response: Response, bounds: Bounds) -> Iterator[Line]:
    """k falls with the flexor's tension where the moment arm grows, and rises where it shrinks."""
    if _asked(bounds.min_elbow_stiffness):
        (flexor, extensor), slope = springs(at.coupling), at.motion.flexor_moment_arm_slope
        base = flexor + extensor + at.torque_slope - response.flexor_floor * slope
        yield Line(STIFFNESS, -base, response.flexor_gain * slope, -np.asarray(bounds.min_elbow_stiffness))


def _asked(bound: Real) -> bool:
    return not np.all(np.isinf(bound))
