"""The window of pretension: between which pretensions of both sides a design keeps every limit, exactly.

In a taut state the tensions are straight lines in the common pretension F (`statics.Response`), and so are both
proximal tensions, spring extension, motor torque, contact pressure and elbow stiffness. A limit on one of these is a
half-line in F, so a design's window over its states is one interval, and each of its ends belongs to one limit in one
state. Nothing is searched. Arguments broadcast as in `actuator`; SI units, angles in radians.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from tendon_cli.model.actuator import Transmission, couple, gravity_torque, motor_arms
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Real
from tendon_cli.model.statics import SLACK_TOLERANCE, Coupling, Flag, Response, respond

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

Codes = npt.NDArray[np.int8]
Positions = npt.NDArray[np.int64]
Kind = TypeVar("Kind", bound=np.generic)


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


@dataclass(frozen=True, eq=False)
class Window:
    """The pretensions at which designs keep all limits in all states: from `low` to `high`; empty where low > high.

    Both are NaN where no pretension could do: `low_by` is then the reason.
    """

    low: Array
    """Smallest pretension of both sides, at least 0, N."""
    high: Array
    """Largest, N; infinite where nothing bounds it."""
    low_by: Codes
    """The limit that binds, an index into LIMIT_NAMES, or NOTHING."""
    high_by: Codes
    low_state: Positions
    """The state that binds, by its place among the design's states; -1 where the limit belongs to none."""
    high_state: Positions

    @property
    def is_open(self) -> npt.NDArray[np.bool_]:
        """Whether any pretension keeps all limits."""
        return np.asarray(self.low <= self.high)


def spool_to_tendon(design: Design) -> Array:
    """Smaller spool's diameter over its tendon's: what bending over the spool does to a rope."""
    flexor = 2.0 * np.asarray(design.flexor_radius) / design.flexor.diameter
    extensor = 2.0 * np.asarray(design.ratio) * design.flexor_radius / design.extensor.diameter
    return np.minimum(flexor, extensor)


def contact_pressure(design: Design, extensor_tension: Array) -> Array:
    """p = T / (R_elb w) of the extensor's strap around the elbow (Pa), T its distal tension (N)."""
    return np.asarray(extensor_tension / (np.asarray(design.arm.anchors.elbow_radius) * design.arm.contact_width))


def window(design: Design, elbow_angle: Real, flexion: Flag, bounds: Bounds) -> Window:
    """The windows of designs over their states, which lie along the last two axes of the broadcast product.

    Every line of `lines` bounds each state from one side (the side its slope says), or not at all where pretension
    changes nothing; the tightest over all states are the ends.
    """
    shortfall, (slack, *others) = _all_lines(design, elbow_angle, flexion, bounds)
    low, high = slack.end, np.full((), np.inf)
    low_by = high_by = np.asarray(slack.limit, dtype=np.int8)
    blocked = np.where(np.isnan(shortfall), np.int8(NO_EQUILIBRIUM), np.int8(NOTHING))
    for line in others:
        end, gain = line.end, line.gain
        below = np.where(gain < 0.0, end, -np.inf)
        above = np.where(gain > 0.0, end, np.inf)
        hopeless = (gain == 0.0) & (line.base - line.most > SLACK_TOLERANCE * np.abs(line.most))
        blocked = np.where(hopeless & (blocked == NOTHING), line.limit, blocked)
        low_by, low = np.where(below > low, line.limit, low_by), np.maximum(low, below)
        high_by, high = np.where(above < high, line.limit, high_by), np.minimum(high, above)
    return _over_states(design, bounds, shortfall + low, shortfall + high, low_by, high_by, blocked)


def limit_end(limit: int, design: Design, elbow_angle: Real, flexion: Flag, bounds: Bounds) -> Array:
    """The pretension at which one limit is just kept in each state, N; also of complex numbers, for derivatives."""
    if limit == PRETENSION:
        return np.asarray(bounds.max_pretension)
    shortfall, found = _all_lines(design, elbow_angle, flexion, bounds)
    if limit in (FLEXOR_SLACK, EXTENSOR_SLACK):
        return shortfall
    return np.asarray(shortfall + next(line.end for line in found if np.all(line.limit == limit)))


def _all_lines(design: Design, elbow_angle: Real, flexion: Flag, bounds: Bounds) -> tuple[Array, list[Line]]:
    motion, flexor, extensor, tied = couple(design, elbow_angle, flexion)
    response = respond(tied)
    backward = np.asarray(tied.elbow_torque < 0.0)
    slack = np.where(backward, np.int8(FLEXOR_SLACK), np.int8(EXTENSOR_SLACK))
    found = [Line(slack, np.zeros(()), np.full((), -1.0), 0.0)]
    found += _of_tensions(design, flexor, extensor, response, bounds)
    found += _of_torque(design, flexor, extensor, response, bounds)
    torque_slope = gravity_torque(design.arm, design.load_mass, elbow_angle)[1]
    found += _of_stiffness(tied, response, motion.flexor_moment_arm_slope, torque_slope, bounds)
    return response.shortfall, found


def _of_tensions(
    design: Design, flexor: Transmission, extensor: Transmission, response: Response, bounds: Bounds
) -> Iterator[Line]:
    """Along a sheath tension only scales, so bounds at both ends are bounds on the distal tensions."""
    x, x_gain, y, y_gain = (
        response.flexor_floor, response.flexor_gain, response.extensor_floor, response.extensor_gain
    )  # fmt: skip
    if _asked(bounds.min_flexor_tension):
        yield Line(FLEXOR_LEAST, -x, -x_gain, -bounds.min_flexor_tension * np.maximum(1.0, flexor.capstan))
    if _asked(bounds.min_extensor_tension):
        yield Line(EXTENSOR_LEAST, -y, -y_gain, -bounds.min_extensor_tension * np.maximum(1.0, extensor.capstan))
    if _asked(bounds.max_tension):
        yield Line(FLEXOR_MOST, x, x_gain, bounds.max_tension * np.minimum(1.0, flexor.capstan))
        yield Line(EXTENSOR_MOST, y, y_gain, bounds.max_tension * np.minimum(1.0, extensor.capstan))
    if _asked(bounds.max_spring_extension):
        yield Line(FLEXOR_SPRING, x, x_gain, bounds.max_spring_extension / flexor.spring)
        yield Line(EXTENSOR_SPRING, y, y_gain, bounds.max_spring_extension / extensor.spring)
    if _asked(bounds.max_contact_pressure):
        area = np.asarray(design.arm.anchors.elbow_radius) * design.arm.contact_width
        yield Line(PRESSURE, y, y_gain, bounds.max_contact_pressure * area)


def _of_torque(
    design: Design, flexor: Transmission, extensor: Transmission, response: Response, bounds: Bounds
) -> Iterator[Line]:
    if _asked(bounds.peak_motor_torque):
        flexor_arm, extensor_arm = motor_arms(design, flexor, extensor)
        base = response.flexor_floor * flexor_arm - response.extensor_floor * extensor_arm
        gain = response.flexor_gain * flexor_arm - response.extensor_gain * extensor_arm
        yield Line(TORQUE_FORWARD, base, gain, bounds.peak_motor_torque)
        yield Line(TORQUE_BACKWARD, -base, -gain, bounds.peak_motor_torque)


def _of_stiffness(
    tied: Coupling, response: Response, moment_arm_slope: Array, torque_slope: Array, bounds: Bounds
) -> Iterator[Line]:
    """k falls with the flexor's tension where the moment arm grows, and rises where it shrinks."""
    if _asked(bounds.min_elbow_stiffness):
        springs = np.square(tied.moment_arm) / tied.flexor_compliance
        springs = springs + np.square(tied.elbow_radius) / tied.extensor_compliance
        base = springs + (torque_slope - response.flexor_floor * moment_arm_slope)
        gain = -response.flexor_gain * moment_arm_slope
        yield Line(STIFFNESS, -base, -gain, -np.asarray(bounds.min_elbow_stiffness))


def _asked(bound: Real) -> bool:
    return not np.all(np.isinf(bound))


def _over_states(
    design: Design, bounds: Bounds, low: Array, high: Array, low_by: Codes, high_by: Codes, blocked: Codes
) -> Window:
    """The tightest ends over the last two axes, and what holds for the whole design."""
    is_thin, ceiling = spool_to_tendon(design) < bounds.min_spool_to_tendon, np.asarray(bounds.max_pretension)
    given = (low, high, low_by, high_by, blocked, is_thin, ceiling)
    shape = np.broadcast_shapes(*(each.shape for each in given), (1, 1))
    low, high = (np.broadcast_to(end, shape).reshape(*shape[:-2], -1) for end in (low, high))
    limits = (np.broadcast_to(codes, shape).reshape(*shape[:-2], -1) for codes in (low_by, high_by, blocked))
    low_by, high_by, blocked = limits
    at_low = np.argmax(np.where(np.isnan(low), -np.inf, low), axis=-1)
    at_high = np.argmin(np.where(np.isnan(high), np.inf, high), axis=-1)
    low, low_by, high, high_by = _at(low, at_low), _at(low_by, at_low), _at(high, at_high), _at(high_by, at_high)
    reason = _at(blocked, at_block := np.argmax(blocked != NOTHING, axis=-1))
    is_thin, ceiling = _over_design(is_thin), _over_design(ceiling)
    reason, at_block = np.where(is_thin, SPOOL, reason), np.where(is_thin, -1, at_block)
    by_ceiling, by_floor, shut = ceiling < high, ~(low > 0.0), reason != NOTHING
    low, high = np.maximum(low, 0.0), np.minimum(high, ceiling)
    low_by = np.where(by_floor, NOTHING, low_by)
    high_by = np.where(by_ceiling, PRETENSION, np.where(np.isinf(high), NOTHING, high_by))
    return Window(
        low=np.where(shut, np.nan, low),
        high=np.where(shut, np.nan, high),
        low_by=np.where(shut, reason, low_by).astype(np.int8),
        high_by=np.where(shut, reason, high_by).astype(np.int8),
        low_state=np.where(shut, at_block, np.where(by_floor, -1, at_low)),
        high_state=np.where(shut, at_block, np.where(by_ceiling | np.isinf(high), -1, at_high)),
    )


def _at(values: npt.NDArray[Kind], where: Positions) -> npt.NDArray[Kind]:
    taken: npt.NDArray[Kind] = np.take_along_axis(values, where[..., np.newaxis], axis=-1)[..., 0]
    return taken


def _over_design(values: npt.NDArray[Kind]) -> npt.NDArray[Kind]:
    """Values of designs, which have two axes of one state where they have any."""
    return values.reshape(values.shape[:-2]) if values.ndim else values
