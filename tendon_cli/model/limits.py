"""Limits of designs: one entry of LIMITS says all that the package knows of a limit.

From this table follow the schema of `[limits]`, the bounds that windows are held to, here and in
compiled code, the column of designs that a limit bounds, `feasible`, the state that breaks it
worst, its words, and its row of the reference. In a taut state the tensions x and y and the elbow
stiffness k are straight lines in the common pretension F (`statics.Response`), so a limit on a
*form*, a x + b y + c k + d, is a half-line in F. Other limits bound a number of the design; power
alone is a product of two such lines (`power_window`). SI units, angles in radians; arguments
broadcast as in `actuator`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.model.design import Design
from tendon_cli.model.forms import DesignLimit, Form, LimitWords, Need
from tendon_cli.model.kinematics import Array, Real
from tendon_cli.model.setting import reading_at
from tendon_cli.quantities import OF_CYCLES, OF_DESIGNS

Codes = npt.NDArray[np.int8]
"""Indices into LIMIT_NAMES, or NOTHING."""

SPEED = Need("motion.speed", "the speed of the elbow", "60 deg/s")
FREE_LENGTH = Need("spring.free_length", "the length of the flexor's spring without load", "73 mm")
BREAKING_FORCE = "tendon.breaking_force"
"""Key of the tension at which the rope breaks."""
CONTACT_PRESSURE = "max_contact_pressure"
CONTACT_WIDTH = Need("arm.contact_width", "the width of the strap around the elbow", "40 mm")


def spool_to_tendon(design: Design) -> Array:
    """Return the smaller ratio of spool to tendon diameter; a rope wears sooner if it is small."""
    flexor = 2.0 * np.asarray(design.flexor_radius) / design.flexor.diameter
    extensor = 2.0 * np.asarray(design.ratio) * design.flexor_radius / design.extensor.diameter
    return np.minimum(flexor, extensor)


def contact_pressure(design: Design, extensor_tension: Array) -> Array:
    """Return p = T / (R w) of the extensor's strap, Pa, with R its radius of curvature.

    Args:
        design: Designs; in proofs their arms may hold series instead of numbers.
        extensor_tension: T, distal tension of the extensor, N.
    """
    pressure: Array = extensor_tension / (design.arm.strap_radius * design.arm.contact_width)
    return pressure


def _pressure_per_newton(at: Any) -> Real:
    """Return the strap's pressure per distal newton of the extensor, 0 where it does not press."""
    pressure: Real = np.where(at.is_pressed, contact_pressure(at.design, np.ones(())), 0.0)
    return pressure


def spring_room(at: Any) -> Array:
    """Return the length between the flexor's anchors less its spring's length without load, m.

    A spring whose length is not stated may be as short as 0. The room is infinite without a spring
    between the anchors: if it is rigid or at the motor, or the joint does not define their
    distance.

    Args:
        at: States.
    """
    path = at.motion.flexor_path
    side = at.design.flexor
    if path is None:
        return np.full((), np.inf)
    length = np.nan_to_num(np.asarray(at.design.given.get(FREE_LENGTH.key, 0.0)), nan=0.0)
    has_no_spring = np.asarray(side.spring_at_motor) | np.isinf(side.spring_stiffness)
    room = np.asarray(path - length)
    if not has_no_spring.any():
        return room  # of few numbers, though springs differ from design to design
    return np.where(has_no_spring, np.inf, room)


def _least_end(capstan: Array) -> Array:
    """Return the smaller of the tensions at both ends of a sheath, per distal newton.

    Along the sheath tension only scales.
    """
    return np.minimum(1.0, 1.0 / capstan)


def _largest_end(capstan: Array) -> Array:
    """Return the larger of the tensions at both ends of a sheath, per distal newton."""
    return np.maximum(1.0, 1.0 / capstan)


def _room(at: Any) -> Real:
    """Return the length between the flexor's anchors less the spring's length without load, m.

    It is infinite if the joint does not define that length.
    """
    path = np.inf if at.motion.flexor_path is None else at.motion.flexor_path
    room: Real = path - at.design.given[FREE_LENGTH.key]
    return room


def _motor_speed(at: Any, speed: Real) -> Form:
    """Return the motor's speed θ̇ dα/dθ, where k = dα/dθ R_f (J_f/c_f + η J_e/c_e).

    Along a trajectory inertia adds to θ̇ k.
    """
    coupling = at.coupling
    by_extensor = coupling.ratio * coupling.extensor_arm / coupling.extensor_compliance
    pull = coupling.moment_arm / coupling.flexor_compliance + by_extensor
    torque_per_turn = at.design.flexor_radius * pull  # of the elbow, N m/rad
    if at.rates is None:
        return Form(stiffness=speed / torque_per_turn)
    turn_per_torque = np.where(at.rates.speed < 0.0, -1.0, 1.0) / torque_per_turn
    stiffness = at.rates.speed * turn_per_torque
    return Form(stiffness=stiffness, constant=at.rates.torque * turn_per_torque)


_ALL = (
    DesignLimit(
        "min_flexor_tension",
        (0.0, 1e7),
        LimitWords(
            "flexor tension too low",
            "flexor tension",
            "the flexor has less than {}",
        ),
        forms=lambda at, _: (Form(flexor=_least_end(at.flexor.capstan)),),
    ),
    DesignLimit(
        "min_extensor_tension",
        (0.0, 1e7),
        LimitWords(
            "extensor tension too low",
            "extensor tension",
            "the extensor has less than {}",
        ),
        forms=lambda at, _: (Form(extensor=_least_end(at.extensor.capstan)),),
    ),
    DesignLimit(
        "max_tension",
        (0.0, 1e9),
        LimitWords(
            "tension too high",
            "tension",
            "a tendon carries more than {}",
        ),
        forms=lambda at, _: (
            Form(flexor=_largest_end(at.flexor.capstan)),
            Form(extensor=_largest_end(at.extensor.capstan)),
        ),
    ),
    DesignLimit(
        "max_spring_extension",
        (0.0, 100.0),
        LimitWords(
            "spring stretched too far",
            "spring extension",
            "a spring is stretched by more than {}",
        ),
        forms=lambda at, _: (Form(flexor=at.flexor.spring), Form(extensor=at.extensor.spring)),
    ),
    DesignLimit(
        "peak_motor_torque",
        (0.0, 1e7),
        LimitWords(
            "motor torque too high",
            "motor torque",
            "the motor needs more than {}",
        ),
        forms=lambda at, _: (Form(flexor=at.motor_arms[0], extensor=-at.motor_arms[1]),),
    ),
    DesignLimit(
        CONTACT_PRESSURE,
        (0.0, 1e12),
        LimitWords(
            "strap presses too hard",
            "strap pressure",
            "the strap presses with more than {}",
        ),
        needs=(CONTACT_WIDTH,),
        forms=lambda at, _: (Form(extensor=_pressure_per_newton(at)),),
    ),
    DesignLimit(
        "min_spring_room",
        (-1.0, 10.0),
        LimitWords(
            "spring does not fit",
            "room for the spring",
            "the spring leaves less than {} between the anchors",
        ),
        needs=(FREE_LENGTH,),
        forms=lambda at, _: (Form(flexor=-at.flexor.spring, constant=_room(at)),),
    ),
    DesignLimit(
        "min_elbow_stiffness",
        (-1e6, 1e6),
        LimitWords(
            "elbow too soft",
            "stiffness",
            "the elbow is less stiff than {}",
        ),
        default=0.0,
        forms=lambda *_: (Form(stiffness=1.0),),
    ),
    DesignLimit(
        "max_pretension",
        (0.0, 1e7),
        LimitWords(
            "pretension too high",
            "the largest pretension",
            "the pretension is above {}",
        ),
        column="pretension",
        of_design=lambda design: reading_at(
            design, np.maximum(design.flexor.pretension, design.extensor.pretension)
        ),
    ),
    DesignLimit(
        "min_spool_to_tendon",
        (0.0, 1e6),
        LimitWords(
            "spool too small",
            "spool size",
            "a spool is less than {} tendon diameters wide",
        ),
        of_design=spool_to_tendon,
    ),
    DesignLimit(
        "peak_motor_speed",
        (0.0, 1e6),
        LimitWords(
            "motor too fast",
            "motor speed",
            "the motor turns faster than {}",
        ),
        needs=(SPEED,),
        forms=lambda at, speed: (_motor_speed(at, speed),),
    ),
    DesignLimit(
        "peak_motor_power",
        (0.0, 1e9),
        LimitWords(
            "motor power too high",
            "motor power",
            "the motor gives more than {}",
        ),
        needs=(SPEED,),
    ),
)
LIMITS: Mapping[str, DesignLimit] = {limit.name: limit for limit in _ALL}
"""Limits by name, in the order of the table."""
ADDED = tuple(
    limit
    for limit in _ALL
    if limit.forms is not None and limit.column not in (*OF_DESIGNS, *OF_CYCLES)
)
"""Limits on forms that add a column to designs, the extreme of their form."""
LIMIT_NAMES = ("flexor slack", "extensor slack", "no equilibrium", *LIMITS)
"""Names of limits by code. Slack and states without equilibrium are always limits."""
FLEXOR_SLACK, EXTENSOR_SLACK, NO_EQUILIBRIUM = range(3)
PRETENSION = LIMIT_NAMES.index("max_pretension")
POWER = LIMIT_NAMES.index("peak_motor_power")
"""Code of the one limit on states that is neither on a form nor on a number of the design."""
NOTHING = -1
"""Code if no limit binds: the window begins at 0, or has no upper end."""
GIVEN = (
    *dict.fromkeys(
        need.key for limit in _ALL for need in limit.needs if need not in (SPEED, CONTACT_WIDTH)
    ),
    BREAKING_FORCE,
)
"""Keys of numbers that only limits or advice need; a study's designs have them in `Design.given`,
NaN if it states none."""
ALWAYS = {
    "flexor slack": LimitWords(
        "flexor slack",
        "slack",
        "the flexor goes slack",
    ),
    "extensor slack": LimitWords(
        "extensor slack",
        "slack",
        "the extensor goes slack",
    ),
    "no equilibrium": LimitWords(
        "no equilibrium",
        "equilibrium",
        "the flexor has passed the joint's centre",
    ),
}
"""Words of the limits that always hold."""
