"""The whole actuator: arm, two sheathed tendons with springs and one motor, from a design to its states.

Composes `kinematics`, `sheath` and `statics`. All fields of `Design` and both `elbow_angle` and `flexion` are scalars
or arrays that broadcast against each other; a result has the shape of what it depends on. SI units, angles in radians.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tendon_cli.model import sheath, statics
from tendon_cli.model.design import Design, Limb, Side
from tendon_cli.model.kinematics import Array, Kinematics, Real, kinematics
from tendon_cli.model.statics import Balance, Coupling, Flag, Status

STANDARD_GRAVITY = 9.81
"""g in m/s², as the paper's findings assume."""


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
class Situation:
    """A design at an elbow angle, moving in a direction: all that the balance of the state depends on.

    Here are the roots, sines and exponentials, each where it varies; what follows is plain arithmetic, here or in C.
    """

    design: Design
    motion: Kinematics
    flexor: Transmission
    extensor: Transmission
    gravity_moment: Array
    """Of forearm and load about the elbow where the forearm is level, N m."""
    sine: Array
    """Of the forearm's inclination from the vertical."""
    cosine: Array

    @classmethod
    def of(cls, design: Design, elbow_angle: Real, flexion: Flag) -> Situation:
        """From arrays that broadcast: elbow angle in rad, and whether it is flexion, else extension."""
        flexor, extensor = transmissions(design, flexion)
        inclination = np.add(elbow_angle, design.arm.upper_arm_angle)
        return cls(
            design=design,
            motion=kinematics(design.arm.anchors, elbow_angle, from_initial=design.from_initial),
            flexor=flexor,
            extensor=extensor,
            gravity_moment=gravity_moment(design.arm, design.load_mass),
            sine=np.sin(inclination),
            cosine=np.cos(inclination),
        )

    @cached_property
    def coupling(self) -> Coupling:
        """What ties the two tensions together."""
        return statics.coupling(
            moment_arm=self.motion.pulling_arm,
            elbow_radius=self.design.arm.anchors.elbow_radius,
            ratio=self.design.ratio,
            flexor_compliance=self.flexor.compliance,
            extensor_compliance=self.extensor.compliance,
            flexor_travel=self.motion.flexor_travel,
            extensor_travel=self.motion.extensor_travel,
            elbow_torque=self.gravity_moment * self.sine,
        )


@dataclass(frozen=True, eq=False)
class State:
    """One state of each design, direction and elbow angle: everything the tables hold, as arrays.

    Where status is NO_EQUILIBRIUM all but the motion is NaN; where both tendons are slack the spool angle and the slack
    lengths are not determined, and NaN; slack lengths are NaN in the bilateral model, which has none.
    """

    situation: Situation
    balance: Balance
    flexor_tension_proximal: Array
    extensor_tension_proximal: Array
    flexor_slack: Array
    extensor_slack: Array
    elbow_torque: Array
    motor_torque: Array
    spool_angle: Array
    elbow_stiffness: Array

    @classmethod
    def of(cls, situation: Situation) -> State:
        """Solve every state of the broadcast product of a situation."""
        design, tied = situation.design, situation.coupling
        pretensions = design.flexor.pretension, design.extensor.pretension
        balance = statics.solve(tied, *pretensions, unilateral=design.unilateral)
        flexor_arm, extensor_arm = motor_arms(design, situation.flexor, situation.extensor)
        flexor_slack, extensor_slack = _slack_lengths(design, balance)
        return cls(
            situation=situation,
            balance=balance,
            flexor_tension_proximal=balance.flexor / situation.flexor.capstan,
            extensor_tension_proximal=balance.extensor / situation.extensor.capstan,
            flexor_slack=flexor_slack,
            extensor_slack=extensor_slack,
            elbow_torque=np.where(np.isnan(tied.moment_arm), np.nan, tied.elbow_torque),
            motor_torque=np.asarray(balance.flexor * flexor_arm - balance.extensor * extensor_arm),
            spool_angle=_spool_angle(situation, balance),
            elbow_stiffness=statics.elbow_stiffness(
                tied,
                balance,
                situation.motion.flexor_moment_arm_slope,
                situation.gravity_moment * situation.cosine,
                unilateral=design.unilateral,
            ),
        )

    @property
    def status(self) -> Status:
        """Index into `statics.STATUS_NAMES`."""
        return self.balance.status

    @property
    def motion(self) -> Kinematics:
        """Path, travels and moment arms."""
        return self.situation.motion

    @property
    def flexor(self) -> Transmission:
        """What the flexor's sheath and spring do."""
        return self.situation.flexor

    @property
    def extensor(self) -> Transmission:
        """And the extensor's."""
        return self.situation.extensor

    @property
    def coupling(self) -> Coupling:
        """What ties the two tensions together."""
        return self.situation.coupling

    def columns(self) -> dict[str, Array]:
        """The result columns of a table of states, by name, but for the status."""
        at, balance, motion = self.situation, self.balance, self.situation.motion
        flexor_change = balance.flexor - at.design.flexor.pretension
        extensor_change = balance.extensor - at.design.extensor.pretension
        return {
            "flexor_tension_proximal": self.flexor_tension_proximal,
            "flexor_tension_distal": balance.flexor,
            "extensor_tension_proximal": self.extensor_tension_proximal,
            "extensor_tension_distal": balance.extensor,
            "flexor_tendon_stretch": at.flexor.tendon * flexor_change,
            "extensor_tendon_stretch": at.extensor.tendon * extensor_change,
            "flexor_spring_stretch": at.flexor.spring * flexor_change,
            "extensor_spring_stretch": at.extensor.spring * extensor_change,
            "flexor_slack": self.flexor_slack,
            "extensor_slack": self.extensor_slack,
            "elbow_torque": self.elbow_torque,
            "motor_torque": self.motor_torque,
            "spool_angle": self.spool_angle,
            "elbow_stiffness": self.elbow_stiffness,
            "flexor_moment_arm": motion.flexor_moment_arm,
            "flexor_travel": motion.flexor_travel,
            "extensor_travel": motion.extensor_travel,
        }


def gravity_moment(arm: Limb, load_mass: Real) -> Array:
    """Moment of forearm and load about the elbow where the forearm is level, N m."""
    return np.asarray(STANDARD_GRAVITY * (arm.forearm_mass * arm.forearm_com + load_mass * arm.load_distance))


def gravity_torque(arm: Limb, load_mass: Real, elbow_angle: Real) -> tuple[Array, Array]:
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


def couple(design: Design, elbow_angle: Real, flexion: Flag) -> tuple[Kinematics, Transmission, Transmission, Coupling]:
    """What a state knows before any pretension: motion, both transmissions, and how they are tied together."""
    at = Situation.of(design, elbow_angle, flexion)
    return at.motion, at.flexor, at.extensor, at.coupling


def evaluate(design: Design, elbow_angle: Real, flexion: Flag) -> State:
    """Solve every state of the broadcast product of `design`, `elbow_angle` (rad) and `flexion` (else extension)."""
    return State.of(Situation.of(design, elbow_angle, flexion))


def _slack_lengths(design: Design, balance: Balance) -> tuple[Array, Array]:
    """Slack of flexor and extensor: the loose path belongs to the slack side, at the spool's ratio."""
    status, lengths = balance.status, (balance.loose * (1.0 / np.asarray(design.ratio)), balance.loose)
    known = np.asarray(design.unilateral) & (status < statics.BOTH_SLACK)
    flexor, extensor = (
        np.where(known, np.where(status == side, length, 0.0), np.nan)
        for side, length in zip((statics.FLEXOR_SLACK, statics.EXTENSOR_SLACK), lengths, strict=True)
    )
    return flexor, extensor


def _spool_angle(at: Situation, balance: Balance) -> Array:
    """α from the pretensioned state, read from a side that is under tension; any angle does where neither is."""
    design, motion = at.design, at.motion
    flexor_stretch = at.flexor.compliance * (balance.flexor - design.flexor.pretension)
    alpha = np.asarray((motion.flexor_travel + flexor_stretch) / design.flexor_radius)
    extensor_stretch = at.extensor.compliance * (balance.extensor - design.extensor.pretension)
    by_extensor = (motion.extensor_travel - extensor_stretch) / (design.ratio * np.asarray(design.flexor_radius))
    alpha = np.where((balance.status == statics.FLEXOR_SLACK) & design.unilateral, by_extensor, alpha)
    return np.where((balance.status == statics.BOTH_SLACK) & design.unilateral, np.nan, alpha)
