"""Every limit of a design, once: an entry of LIMITS says all that the rest of the package knows of it.

From this table follow the schema of `[limits]`, the bounds that windows are held to, here and in compiled code, the
column of designs that a limit bounds, `feasible`, the state that breaks it worst, its words, and its row of the
reference. In a taut state the tensions x and y and the elbow stiffness k are straight lines in the common pretension F
(`response.Response`), so a limit on a *form*, a x + b y + c k + d, is a half-line in F. What is no form compares states
of the whole motion (`motor_window`). SI units, angles in radians; arguments broadcast as in `actuator`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Array, Real

if TYPE_CHECKING:
    from tendon_cli.model.actuator import Situation, State
    from tendon_cli.model.design import Design
    from tendon_cli.model.intervals import Measure
    from tendon_cli.model.motor_window import Lines, Motor

Codes = npt.NDArray[np.int8]


@dataclass(frozen=True, eq=False)
class Form:
    """A quantity of a state: flexor x + extensor y + stiffness k + constant. A share that is 0.0 has no part in it."""

    flexor: Real = 0.0
    extensor: Real = 0.0
    stiffness: Real = 0.0
    constant: Real = 0.0

    def of(self, flexor: Array, extensor: Array, stiffness: Array) -> Array:
        """The quantity but for its constant, from both distal tensions (N) and the elbow stiffness (N m/rad)."""
        parts = ((self.flexor, flexor), (self.extensor, extensor), (self.stiffness, stiffness))
        return np.asarray(sum(share * value for share, value in parts if not is_nothing(share)))


def is_nothing(share: Real) -> bool:
    """Whether a form has no such part."""
    return isinstance(share, float) and share == 0.0


@dataclass(frozen=True)
class Need:
    """What a study must state for a limit."""

    key: str
    what: str
    example: str


SPEED = Need("motion.speed", "the speed of the elbow", "60 deg/s")
CONTACT_WIDTH = Need("arm.contact_width", "the width of the strap around the elbow", "40 mm")


@dataclass(frozen=True, eq=False)
class Limit:
    """One limit: on forms of single states, on a number of the design, or on the whole motion."""

    name: str
    """Key of `[limits]` and name of its quantity: min_ bounds from below, max_ from above, peak_ in magnitude."""
    accepts: tuple[float, float]
    """What a study may say, SI."""
    broken: str
    """What happens if it is not kept; {} is the bound."""
    forms: Callable[[Situation, Real], tuple[Form, ...]] | None = None
    """Of each state, and of the elbow's speed (rad/s): every one of them is held."""
    of_design: Callable[[Design], Array] | None = None
    """Of a design whatever its state."""
    lines: Callable[[Motor], Lines | None] | None = None
    """Of the whole motion, straight lines in pretension; in magnitude."""
    excess: Callable[[Motor, Real], Measure] | None = None
    """Of the whole motion, by how much a bound is exceeded; no straight line."""
    column: str = ""
    """The column of designs that it bounds; by default of its name."""
    needs: tuple[Need, ...] = ()
    optional: bool = False
    """Its column is in tables only if a study states what it needs."""
    default: float | None = None
    """Its bound if a study says nothing."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "column", self.column or self.name)

    @property
    def from_below(self) -> bool:
        """Whether it is the smallest that is bounded."""
        return self.name.startswith("min_")

    @property
    def of_motion(self) -> bool:
        """Whether it compares states of the whole motion."""
        return self.lines is not None or self.excess is not None

    def range_of(self, bound: Real) -> tuple[Real | None, Real | None]:
        """The least and the largest that its quantity may be."""
        if self.from_below:
            return bound, None
        return (-np.asarray(bound) if self.name.startswith("peak_") else None), bound

    def is_asked(self, bound: Real) -> bool:
        """Whether a bound is one, for any design."""
        return not bool(np.all(np.isinf(bound)))

    def beyond(self, values: Array, bound: Real) -> Array:
        """By how much values are outside of the bound: above 0 they break it."""
        if self.from_below:
            return np.asarray(bound - values)
        return np.asarray((np.abs(values) if self.name.startswith("peak_") else values) - bound)

    def value(self, state: State, speed: Real = np.nan) -> Array:
        """Its quantity in states, of several forms the one nearest to the bound. Raises TypeError without forms."""
        if self.forms is None:
            raise TypeError(f"{self.name} is no limit on single states")
        at = state.balance.flexor, state.balance.extensor, state.elbow_stiffness
        values = [form.of(*at) + form.constant for form in self.forms(state.situation, speed)]
        worst = values[0]
        for other in values[1:]:
            worst = np.where(self.beyond(other, 0.0) > self.beyond(worst, 0.0), other, worst)
        return np.asarray(worst)


def spool_to_tendon(design: Design) -> Array:
    """Smaller spool's diameter over its tendon's: what bending over the spool does to a rope."""
    flexor = 2.0 * np.asarray(design.flexor_radius) / design.flexor.diameter
    extensor = 2.0 * np.asarray(design.ratio) * design.flexor_radius / design.extensor.diameter
    return np.minimum(flexor, extensor)


def contact_pressure(design: Design, extensor_tension: Array) -> Array:
    """p = T / (R_elb w) of the extensor's strap around the elbow (Pa), T its distal tension (N)."""
    return np.asarray(extensor_tension / (np.asarray(design.arm.anchors.elbow_radius) * design.arm.contact_width))


def _least_end(capstan: Array) -> Array:
    """The smaller of the tensions at both ends of a sheath, per distal newton: along it tension only scales."""
    return np.minimum(1.0, 1.0 / capstan)


def _largest_end(capstan: Array) -> Array:
    return np.maximum(1.0, 1.0 / capstan)


def _turning(at: Situation, speed: Real) -> Form:
    """The motor's speed: θ̇ dα/dθ, with k = dα/dθ R_f (J/c_f + η R_elb/c_e)."""
    tied = at.coupling
    pull = (
        tied.moment_arm / tied.flexor_compliance + tied.ratio * np.asarray(tied.elbow_radius) / tied.extensor_compliance
    )
    return Form(stiffness=speed / (at.design.flexor_radius * pull))


_ALL = (
    Limit(
        "min_flexor_tension", (0.0, 1e7), "the flexor has less than {}",
        forms=lambda at, _: (Form(flexor=_least_end(at.flexor.capstan)),),
    ),
    Limit(
        "min_extensor_tension", (0.0, 1e7), "the extensor has less than {}",
        forms=lambda at, _: (Form(extensor=_least_end(at.extensor.capstan)),),
    ),
    Limit(
        "max_tension", (0.0, 1e9), "a tendon has more than {}",
        forms=lambda at, _: (
            Form(flexor=_largest_end(at.flexor.capstan)), Form(extensor=_largest_end(at.extensor.capstan)),
        ),
    ),
    Limit(
        "max_spring_extension", (0.0, 100.0), "a spring is extended by more than {}",
        forms=lambda at, _: (Form(flexor=at.flexor.spring), Form(extensor=at.extensor.spring)),
    ),
    Limit(
        "peak_motor_torque", (0.0, 1e7), "the motor needs more than {}",
        forms=lambda at, _: (Form(flexor=at.motor_arms[0], extensor=-at.motor_arms[1]),),
    ),
    Limit(
        "max_contact_pressure", (0.0, 1e12), "the strap presses with more than {}", needs=(CONTACT_WIDTH,),
        forms=lambda at, _: (Form(extensor=contact_pressure(at.design, np.ones(()))),),
    ),
    Limit(
        "min_elbow_stiffness", (-1e6, 1e6), "the elbow is less stiff than {}", default=0.0,
        forms=lambda *_: (Form(stiffness=1.0),),
    ),
    Limit(
        "max_pretension", (0.0, 1e7), "it is more than {}", column="pretension",
        of_design=lambda design: np.maximum(design.flexor.pretension, design.extensor.pretension),
    ),
    Limit(
        "min_spool_to_tendon", (0.0, 1e6), "a spool is less than {} tendons across", of_design=spool_to_tendon,
    ),
    Limit(
        "max_spool_travel", (0.0, 1e6), "the spool turns by more than {}", column="spool_travel", needs=(SPEED,),
        excess=lambda motor, most: lambda at: np.ptp(motor.spool_angle.at(at), axis=1) - most,
    ),
    Limit(
        "max_backlash", (0.0, 1e6), "the spool differs by more than {} between the directions", needs=(SPEED,),
        lines=lambda motor: motor.between(motor.spool_angle),
    ),
    Limit(
        "max_torque_band", (0.0, 1e7), "the motor torque differs by more than {} between the directions",
        needs=(SPEED,), lines=lambda motor: motor.between(motor.torque),
    ),
    Limit(
        "peak_motor_speed", (0.0, 1e6), "the motor turns faster than {}", needs=(SPEED,),
        forms=lambda at, speed: (_turning(at, speed),),
    ),
    Limit(
        "peak_motor_power", (0.0, 1e9), "the motor gives more than {}", needs=(SPEED,),
        excess=lambda motor, most: lambda at: np.max(motor.power(at), axis=1) - most,
    ),
    Limit(
        "max_motor_work_in", (0.0, 1e9), "the motor works more than {} a cycle", column="motor_work_in",
        needs=(SPEED,), excess=lambda motor, most: lambda at: motor.work(at) - most,
    ),
    Limit(
        "max_friction_loss", (0.0, 1e9), "friction takes more than {} a cycle", column="friction_loss",
        needs=(SPEED,), excess=lambda motor, most: lambda at: motor.loss(at) - most,
    ),
    # Without work there is no efficiency, and nothing that could be held to one.
    Limit(
        "min_efficiency", (-1e6, 1.0), "friction leaves less than {} of the motor's work", column="efficiency",
        needs=(SPEED,),
        excess=lambda motor, least: lambda at: np.where(
            motor.work(at) > 0.0, motor.loss(at) - (1.0 - least) * motor.work(at), -np.inf
        ),
    ),
)  # fmt: skip
LIMITS: Mapping[str, Limit] = {limit.name: limit for limit in _ALL}
LIMIT_NAMES = ("flexor slack", "extensor slack", "no equilibrium", *LIMITS)
"""What ends a window, by its code. Slack and states without equilibrium are always limits."""
FLEXOR_SLACK, EXTENSOR_SLACK, NO_EQUILIBRIUM = range(3)
PRETENSION = LIMIT_NAMES.index("max_pretension")
NOTHING = -1
"""No limit binds: no pretension is below 0, and none need be too high."""
ALWAYS_BROKEN = {
    "flexor slack": "the flexor goes slack",
    "extensor slack": "the extensor goes slack",
    "no equilibrium": "the flexor has passed the joint's centre",
}
