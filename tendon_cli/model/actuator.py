"""The whole actuator: arm, two sheathed tendons with springs and one motor, from a design to its states.

Composes a joint (`kinematics`), two sheaths (`sheath`) and their balance (`statics`). All fields of `Design` and both
`elbow_angle` and `flexion` are scalars or arrays that broadcast against each other; a result has the shape of what it
depends on. SI units, angles in radians.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tendon_cli.model import statics
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flag, Flags, Real, Travels
from tendon_cli.model.sheath import Sheathed, sheaths_of
from tendon_cli.model.statics import Balance, Coupling, Response, Status, respond
from tendon_cli.quantities import OF_STATES, QUANTITIES

SIDES = ("flexor", "extensor")


@dataclass(frozen=True, eq=False)
class State:
    """Designs at elbow angles, moving in a direction, and all that follows; what is not asked for is not worked out.

    The fields have the roots, sines and exponentials, each where it varies; all else is plain arithmetic, here or in C.
    Where status is NO_EQUILIBRIUM all but the motion is NaN; where both tendons are slack the spool angle and the slack
    lengths are not determined, and NaN; slack lengths are NaN in the bilateral model, which has none.
    """

    design: Design
    motion: Travels
    flexor: Sheathed
    extensor: Sheathed
    gravity_moment: Array
    """Of forearm and load about the elbow where the forearm is level, N m."""
    sine: Array
    """Of the forearm's inclination from the vertical."""
    cosine: Array
    other_torque: Array
    """What joint, task and inertia ask for besides the weights, N m."""
    other_slope: Array
    """Its slope but for inertia, N m/rad."""
    resting: tuple[Sheathed, Sheathed] | None = None
    """Both sheaths in the posture in which the pretension is set, if they are others there."""
    speed: Array | None = None
    """Of the joint along a trajectory, rad/s."""
    torque_rate: Array | None = None
    """By how much inertia asks for more torque there, N m/s."""

    @classmethod
    def of(cls, design: Design, elbow_angle: Real, flexion: Flag) -> State:
        """From arrays that broadcast: elbow angle in rad, and whether it is flexion, else extension."""
        arm, sides = design.arm, (design.flexor, design.extensor)
        flexor, extensor = sheaths_of(*sides, elbow_angle, flexion)
        inclination = np.add(elbow_angle, arm.upper_arm_angle)
        other_torque, speed, torque_rate = np.asarray(design.other_torque(elbow_angle)), None, None
        if design.trajectory is not None:
            speed, acceleration, jerk = design.trajectory.at(elbow_angle)
            inertia = arm.inertia + design.load_mass * np.square(arm.load_distance)
            other_torque, torque_rate = (
                np.asarray(other_torque + inertia * acceleration),
                np.asarray(inertia * jerk),
            )
        return cls(
            design=design,
            motion=arm.joint.motion(elbow_angle),
            flexor=flexor,
            extensor=extensor,
            gravity_moment=design.gravity_moment,
            sine=np.sin(inclination),
            cosine=np.cos(inclination),
            other_torque=other_torque,
            other_slope=np.asarray(design.other_torque(elbow_angle, 1)),
            resting=sheaths_of(*sides, design.setting.angle, flexion) if design.follows else None,
            speed=speed,
            torque_rate=torque_rate,
        )

    @cached_property
    def coupling(self) -> Coupling:
        """What ties the two tensions together."""
        motion, ratio = self.motion, self.design.ratio
        return Coupling(
            moment_arm=motion.pulling_arm,
            extensor_arm=motion.extensor_moment_arm,
            ratio=ratio,
            flexor_compliance=self.flexor.compliance,
            extensor_compliance=self.extensor.compliance,
            mismatch=motion.mismatch(ratio),
            elbow_torque=self.gravity_moment * self.sine + self.other_torque,
            resting=None
            if self.resting is None
            else (self.resting[0].compliance, self.resting[1].compliance),
        )

    @cached_property
    def arm_slopes(self) -> tuple[Array, Real]:
        """J_f' - J_f c_f'/c_f and J_e' - J_e c_e'/c_e: what a newton takes of, gives to the elbow's stiffness, m."""
        motion = self.motion
        of_flexor, of_extensor = motion.flexor_moment_arm_slope, motion.extensor_moment_arm_slope
        if self.resting is None:
            return of_flexor, of_extensor
        flexor, extensor = (
            side.compliance_rate / side.compliance for side in (self.flexor, self.extensor)
        )
        return (
            of_flexor - motion.flexor_moment_arm * flexor,
            of_extensor - motion.extensor_moment_arm * extensor,
        )

    @property
    def torque_slope(self) -> Array:
        """dτ_a/dθ, N m/rad."""
        return np.asarray(self.gravity_moment * self.cosine + self.other_slope)

    @cached_property
    def response(self) -> Response:
        """How the tensions follow pretension."""
        return respond(self.coupling, unilateral=self.design.unilateral)

    @cached_property
    def held_stiffness(self) -> tuple[Array, Array]:
        """J_f²/c_f + J_e²/c_e + dτ_a/dθ of a taut and of a slack state, N m/rad; a slack tendon adds nothing."""
        tied, response, slope = self.coupling, self.response, self.torque_slope
        flexor = np.square(tied.moment_arm) * (1.0 / tied.flexor_compliance)
        extensor = np.asarray(np.square(tied.extensor_arm) / tied.extensor_compliance)
        left = np.where(response.idle, 0.0, np.where(tied.elbow_torque < 0.0, extensor, flexor))
        taut = flexor + extensor
        return taut + slope, np.where(self.design.unilateral, left, taut) + slope

    @cached_property
    def motor_arms(self) -> tuple[Array, Array]:
        """τ_m per distal newton of the flexor and, against it, of the extensor (Eq. 17), m."""
        radius = self.design.flexor_radius
        return np.asarray(radius / self.flexor.capstan), np.asarray(
            self.design.ratio * radius / self.extensor.capstan
        )

    @cached_property
    def balance(self) -> Balance:
        """Distal tensions, and which side is slack."""
        design = self.design
        pretensions = design.flexor.pretension, design.extensor.pretension
        return statics.solve(
            self.coupling, *pretensions, unilateral=design.unilateral, response=self.response
        )

    @property
    def flexor_tension_proximal(self) -> Array:
        """At the motor, N."""
        return np.asarray(self.balance.flexor / self.flexor.capstan)

    @property
    def extensor_tension_proximal(self) -> Array:
        """At the motor, N."""
        return np.asarray(self.balance.extensor / self.extensor.capstan)

    @property
    def flexor_slack(self) -> Array:
        """Length of the loose path, which belongs to the slack side, m."""
        return self._slack_length(self.balance.flexor_slack)

    @property
    def extensor_slack(self) -> Array:
        """Likewise the extensor's, m."""
        return self._slack_length(self.balance.extensor_slack)

    @property
    def longest_slack(self) -> Array:
        """Length of the side that is slack, 0 where none is, m."""
        return self._slack_length(self.balance.is_slack)

    def _slack_length(self, slack: Flags) -> Array:
        unilateral = np.asarray(self.design.unilateral)
        per_path = np.where(
            self.coupling.elbow_torque < 0.0, 1.0 / np.asarray(self.design.ratio), 1.0
        )
        per_path = np.where(unilateral & ~self.response.idle, per_path, np.nan)
        taut = np.where(unilateral & ~np.isnan(self.coupling.moment_arm), 0.0, np.nan)
        return np.where(slack, self.balance.path * per_path, taut)

    @property
    def elbow_torque(self) -> Array:
        """τ_a, N m."""
        return np.where(np.isnan(self.coupling.moment_arm), np.nan, self.coupling.elbow_torque)

    @property
    def motor_torque(self) -> Array:
        """τ_m (Eq. 17), N m."""
        flexor_arm, extensor_arm = self.motor_arms
        return np.asarray(self.balance.flexor * flexor_arm - self.balance.extensor * extensor_arm)

    @property
    def elbow_stiffness(self) -> Array:
        """k = J_f²/c_f + J_e²/c_e + dτ_a/dθ - (J_f' - J_f c_f'/c_f) x + (J_e' - J_e c_e'/c_e) y, the motor held.

        In N m/rad. Negative where the arm is unstable: there the spool must turn back while the elbow goes on, and the
        direction of friction that the state assumes is wrong.
        """
        (taut, slack), (of_flexor, of_extensor), balance = (
            self.held_stiffness,
            self.arm_slopes,
            self.balance,
        )
        stiffness = np.where(balance.is_slack, slack, taut) - balance.flexor * of_flexor
        return np.asarray(
            stiffness + balance.extensor * of_extensor if np.any(of_extensor) else stiffness
        )

    @property
    def spool_angle(self) -> Array:
        """α from the pretensioned state, read from a side under tension; any angle does where neither is, rad."""
        design, motion, status = self.design, self.motion, self.status
        flexor, extensor = (self.stretch(side, "compliance") for side in SIDES)
        by_flexor = np.asarray((motion.flexor_travel + flexor) / design.flexor_radius)
        by_extensor = (motion.extensor_travel - extensor) / (
            design.ratio * np.asarray(design.flexor_radius)
        )
        alpha = np.where(
            (status == statics.FLEXOR_SLACK) & design.unilateral, by_extensor, by_flexor
        )
        return np.where((status == statics.BOTH_SLACK) & design.unilateral, np.nan, alpha)

    def stretch(self, side: str, part: str) -> Array:
        """By how much the "tendon" or "spring" of a side, or all ("compliance"), grew since pretension was set, m."""
        now, start = getattr(self, side), getattr(self.design, side).pretension
        before = self.resting[SIDES.index(side)] if self.resting else now
        change = getattr(self.balance, side) - start
        stretched: Array = (
            getattr(now, part) * change + (getattr(now, part) - getattr(before, part)) * start
        )
        return stretched

    @property
    def status(self) -> Status:
        """Index into `statics.STATUS_NAMES`."""
        return self.balance.status

    def columns(self, names: Iterable[str] = OF_STATES) -> dict[str, Array]:
        """Columns of a table of states, by name, but for the status: each as its entry in `quantities` says."""
        return {name: np.asarray(_VALUES[name](self)) for name in names}


_VALUES = {name: value for name in OF_STATES if (value := QUANTITIES[name].value) is not None}


def evaluate(design: Design, elbow_angle: Real, flexion: Flag) -> State:
    """Solve every state of the broadcast product of `design`, `elbow_angle` (rad) and `flexion` (else extension)."""
    return State.of(design, elbow_angle, flexion)
