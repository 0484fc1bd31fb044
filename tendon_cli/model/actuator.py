"""The whole actuator: arm, two sheathed tendons with springs and one motor, from a design to its states.

Composes `kinematics`, `sheath` and `statics`. All fields of `Design` and both `elbow_angle` and `flexion` are scalars
or arrays that broadcast against each other; a result has the shape of what it depends on. SI units, angles in radians.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_cli.model import sheath, statics
from tendon_cli.model.kinematics import Anchors, Array, Kinematics, Real, kinematics
from tendon_cli.model.statics import Balance, Coupling, Flag, Status

STANDARD_GRAVITY = 9.81
"""g in m/s², as the paper's findings assume."""


@dataclass(frozen=True, eq=False)
class Arm:
    """The arm, its anchors and its weight."""

    anchors: Anchors
    forearm_mass: Real
    """Mass of forearm and hand, kg."""
    forearm_com: Real
    """Distance of its centre from the elbow, m."""
    load_distance: Real
    """Distance of the load from the elbow, m."""
    upper_arm_angle: Real
    """ψ, inclination of the upper arm, forward positive, rad."""
    contact_width: Real = np.nan
    """Width of the extensor's strap around the elbow, m."""


@dataclass(frozen=True, eq=False)
class Side:
    """One tendon with its sheath and its series spring."""

    friction: Real
    """μ."""
    bend_angle: Real
    """φ = ∫κ ds, rad."""
    length: Real
    """L, m."""
    diameter: Real
    """d, m."""
    youngs_modulus: Real
    """E, Pa."""
    spring_stiffness: Real
    """K_SE, N/m."""
    pretension: Real
    """F0, distal tension before motion, N."""


@dataclass(frozen=True, eq=False)
class Design:
    """Everything that a state depends on besides elbow angle and direction."""

    arm: Arm
    flexor: Side
    extensor: Side
    flexor_radius: Real
    """R_m^f, m."""
    ratio: Real
    """η = R_m^e / R_m^f."""
    load_mass: Real
    """kg."""
    from_initial: Flag = False
    """Measure the flexor's travel from L_c(0) instead of b1 + b2."""
    unilateral: Flag = True
    """A tendon cannot push; otherwise the paper's bilateral model."""


@dataclass(frozen=True, eq=False)
class Transmission:
    """What a sheathed tendon and its spring do to distal tension, per side and direction."""

    capstan: Array
    """Distal over proximal tension."""
    tendon: Array
    """Elongation of the tendon per distal newton, m/N."""
    spring: Array
    """1 / K_SE, m/N."""

    @property
    def compliance(self) -> Array:
        """c, elongation of tendon and spring per distal newton, m/N."""
        return np.asarray(self.tendon + self.spring)


@dataclass(frozen=True, eq=False)
class State:
    """One state of each design, direction and elbow angle: everything the tables hold, as arrays.

    Where status is NO_EQUILIBRIUM all but the motion is NaN; where both tendons are slack the spool angle and the slack
    lengths are not determined, and NaN; slack lengths are NaN in the bilateral model, which has none.
    """

    motion: Kinematics
    flexor: Transmission
    extensor: Transmission
    coupling: Coupling
    balance: Balance
    flexor_tension_proximal: Array
    extensor_tension_proximal: Array
    flexor_slack: Array
    extensor_slack: Array
    elbow_torque: Array
    motor_torque: Array
    spool_angle: Array
    elbow_stiffness: Array

    @property
    def status(self) -> Status:
        """Index into `statics.STATUS_NAMES`."""
        return self.balance.status


def gravity_moment(arm: Arm, load_mass: Real) -> Array:
    """Moment of forearm and load about the elbow where the forearm is level, N m."""
    return np.asarray(STANDARD_GRAVITY * (arm.forearm_mass * arm.forearm_com + load_mass * arm.load_distance))


def gravity_torque(arm: Arm, load_mass: Real, elbow_angle: Real) -> tuple[Array, Array]:
    """τ_a that holds forearm and load against gravity, quasi-static (N m), and its derivative dτ_a/dθ (N m/rad)."""
    moment = gravity_moment(arm, load_mass)
    inclination = np.add(elbow_angle, arm.upper_arm_angle)
    return np.asarray(moment * np.sin(inclination)), np.asarray(moment * np.cos(inclination))


def transmission(side: Side, toward: Real) -> Transmission:
    """Capstan ratio and distal compliances of one side (Eqs. 6 and 13); `toward` is σ of `sheath`."""
    return Transmission(
        capstan=sheath.capstan_ratio(side.friction, side.bend_angle, toward),
        tendon=sheath.tendon_compliance(
            side.length, side.diameter, side.youngs_modulus, side.friction, side.bend_angle, toward
        ),
        spring=np.asarray(1.0 / np.asarray(side.spring_stiffness)),
    )


def transmissions(design: Design, flexion: Flag) -> tuple[Transmission, Transmission]:
    """Flexor and extensor. In flexion the flexor is pulled toward the motor, the extensor dragged toward the elbow."""
    pulled = np.where(flexion, sheath.TOWARD_MOTOR, sheath.TOWARD_ELBOW)
    return transmission(design.flexor, pulled), transmission(design.extensor, -pulled)


def motor_arms(design: Design, flexor: Transmission, extensor: Transmission) -> tuple[Array, Array]:
    """τ_m per distal newton of the flexor and, against it, of the extensor (Eq. 17), m."""
    radius = design.flexor_radius
    return np.asarray(radius / flexor.capstan), np.asarray(design.ratio * radius / extensor.capstan)


def tie(
    design: Design, motion: Kinematics, flexor: Transmission, extensor: Transmission, elbow_torque: Array
) -> Coupling:
    """What ties the tensions of a state together, from its parts."""
    return statics.coupling(
        moment_arm=motion.pulling_arm,
        elbow_radius=design.arm.anchors.elbow_radius,
        ratio=design.ratio,
        flexor_compliance=flexor.compliance,
        extensor_compliance=extensor.compliance,
        flexor_travel=motion.flexor_travel,
        extensor_travel=motion.extensor_travel,
        elbow_torque=elbow_torque,
    )


def couple(design: Design, elbow_angle: Real, flexion: Flag) -> tuple[Kinematics, Transmission, Transmission, Coupling]:
    """What a state knows before any pretension: motion, both transmissions, and how they are tied together."""
    motion = kinematics(design.arm.anchors, elbow_angle, from_initial=design.from_initial)
    flexor, extensor = transmissions(design, flexion)
    torque = gravity_torque(design.arm, design.load_mass, elbow_angle)[0]
    return motion, flexor, extensor, tie(design, motion, flexor, extensor, torque)


def evaluate(design: Design, elbow_angle: Real, flexion: Flag) -> State:
    """Solve every state of the broadcast product of `design`, `elbow_angle` (rad) and `flexion` (else extension)."""
    motion, flexor, extensor, tied = couple(design, elbow_angle, flexion)
    balance = statics.solve(tied, design.flexor.pretension, design.extensor.pretension, unilateral=design.unilateral)
    torque_slope = gravity_torque(design.arm, design.load_mass, elbow_angle)[1]
    flexor_proximal, extensor_proximal = balance.flexor / flexor.capstan, balance.extensor / extensor.capstan
    flexor_slack, extensor_slack = _slack_lengths(design, balance)
    return State(
        motion=motion,
        flexor=flexor,
        extensor=extensor,
        coupling=tied,
        balance=balance,
        flexor_tension_proximal=flexor_proximal,
        extensor_tension_proximal=extensor_proximal,
        flexor_slack=flexor_slack,
        extensor_slack=extensor_slack,
        elbow_torque=np.where(np.isnan(tied.moment_arm), np.nan, tied.elbow_torque),
        motor_torque=np.asarray((flexor_proximal - design.ratio * extensor_proximal) * design.flexor_radius),
        spool_angle=_spool_angle(design, motion, tied, balance),
        elbow_stiffness=statics.elbow_stiffness(
            tied, balance, motion.flexor_moment_arm_slope, torque_slope, unilateral=design.unilateral
        ),
    )


def _slack_lengths(design: Design, balance: Balance) -> tuple[Array, Array]:
    """Slack of flexor and extensor: the loose path belongs to the slack side, at the spool's ratio."""
    known = np.where((balance.status == statics.BOTH_SLACK) | ~np.asarray(design.unilateral), np.nan, balance.loose)
    on_flexor = balance.status == statics.FLEXOR_SLACK
    nothing = 0.0 * known
    return np.where(on_flexor, known / design.ratio, nothing), np.where(on_flexor, nothing, known)


def _spool_angle(design: Design, motion: Kinematics, tied: Coupling, balance: Balance) -> Array:
    """α from the pretensioned state, read from a side that is under tension; any angle does where neither is."""
    flexor_stretch = tied.flexor_compliance * (balance.flexor - design.flexor.pretension)
    alpha = np.asarray((motion.flexor_travel + flexor_stretch) / design.flexor_radius)
    flexor_slack = (balance.status == statics.FLEXOR_SLACK) & np.asarray(design.unilateral)
    if flexor_slack.any():
        extensor_stretch = tied.extensor_compliance * (balance.extensor - design.extensor.pretension)
        by_extensor = (motion.extensor_travel - extensor_stretch) / (design.ratio * design.flexor_radius)
        alpha = np.where(flexor_slack, by_extensor, alpha)
    unknown = (balance.status == statics.BOTH_SLACK) & np.asarray(design.unilateral)
    return np.where(unknown, np.nan, alpha)
