"""States of the whole actuator: an arm, two sheathed tendons with springs, and one motor.

A state composes a joint (`kinematics`), two sheaths (`sheath`) and their balance (`statics`). All
fields of `Design` and both `elbow_angle` and `flexion` are scalars or arrays that broadcast against
each other; a result has the broadcast shape of its inputs. SI units, angles in radians.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tendon_cli.model import statics
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flag, Flags, Real, Travels
from tendon_cli.model.sheath import Sheathed, sheaths_of, unloaded_sheaths
from tendon_cli.model.sliding import Sliding
from tendon_cli.model.statics import Balance, Coupling, Response, Status, respond
from tendon_cli.quantities import OF_MOTION_STATES, OF_STATES, QUANTITIES, SIDES


@dataclass(frozen=True, eq=False)
class JointRates:
    """Rates of the joint along a trajectory."""

    speed: Array
    """Speed, rad/s."""
    torque: Array
    """Rate of the torque of inertia and of a task over time, N m/s."""


@dataclass(frozen=True, eq=False)
class State:
    """Designs at elbow angles, moving in a direction, with all results; each is computed on demand.

    The fields hold the results of roots, sines and exponentials, each only along the axes on which
    it varies; the rest is plain arithmetic, here or in C. Where status is NO_EQUILIBRIUM everything
    but the motion is NaN. Where both tendons are slack the spool angle and the slack lengths are
    undetermined, and NaN. Slack lengths are NaN in the bilateral model, which has none.
    """

    design: Design
    elbow_angle: Real
    """Elbow angles, rad."""
    motion: Travels
    flexor: Sheathed
    extensor: Sheathed
    gravity_moment: Array
    """Moment of forearm and load about the elbow where the forearm is level, N m."""
    sine: Array
    """Sine of the forearm's inclination from the vertical."""
    cosine: Array
    """Cosine of the forearm's inclination from the vertical."""
    other_torque: Array
    """Torque for joint, task and inertia, to which that for the weights is added, N m."""
    other_slope: Array
    """Slope of that torque over the elbow angle, without inertia, N m/rad."""
    resting: tuple[Sheathed, Sheathed] | None = None
    """Both sheaths in the posture in which the pretension is set, or along a trajectory without
    friction; None if they are the same."""
    rates: JointRates | None = None
    """Rates along a trajectory; None without one."""
    sliding: Sliding | None = None
    """Way in which the tendons slide along a trajectory; None if `flexion` states it."""

    @classmethod
    def of(cls, design: Design, elbow_angle: Real, flexion: Flag) -> State:
        """Return the states of designs; all arguments broadcast.

        Args:
            design: Designs.
            elbow_angle: Elbow angles, rad.
            flexion: True in flexion, else extension.
        """
        arm = design.arm
        flexor, extensor = sheaths_of(design.flexor, design.extensor, elbow_angle, flexion)
        resting = None
        if design.has_one_length:
            resting = unloaded_sheaths(design.flexor, design.extensor, design.setting.angle)
        elif design.bend_follows_joint:
            angle = design.setting.angle
            resting = sheaths_of(design.flexor, design.extensor, angle, flexion)
        inclination = np.add(elbow_angle, arm.upper_arm_angle)
        other_torque = np.asarray(design.other_torque(elbow_angle))
        rates = None
        if design.trajectory is not None:
            speed, acceleration, jerk = design.trajectory.derivatives_at(elbow_angle)
            task, task_rate = design.trajectory.task_at(elbow_angle)
            inertia = arm.inertia + design.load_mass * np.square(arm.load_distance)
            scale = design.load_scale
            other_torque = np.asarray(other_torque + inertia * acceleration + scale * task)
            rates = JointRates(speed, np.asarray(inertia * jerk + scale * task_rate))
        return cls(
            design=design,
            elbow_angle=elbow_angle,
            motion=arm.joint.motion(elbow_angle),
            flexor=flexor,
            extensor=extensor,
            gravity_moment=design.gravity_moment,
            sine=np.sin(inclination),
            cosine=np.cos(inclination),
            other_torque=other_torque,
            other_slope=np.asarray(design.other_torque(elbow_angle, 1)),
            resting=resting,
            rates=rates,
        )

    @cached_property
    def coupling(self) -> Coupling:
        """Equations that tie the two tensions together."""
        motion = self.motion
        ratio = self.design.ratio
        resting = None
        if self.resting is not None:
            resting_flexor, resting_extensor = self.resting
            resting = (resting_flexor.compliance, resting_extensor.compliance)
        return Coupling(
            moment_arm=motion.pulling_arm,
            extensor_arm=motion.extensor_moment_arm,
            ratio=ratio,
            flexor_compliance=self.flexor.compliance,
            extensor_compliance=self.extensor.compliance,
            mismatch=motion.mismatch(ratio),
            elbow_torque=self.gravity_moment * self.sine + self.other_torque,
            resting=resting,
        )

    @cached_property
    def is_pressed(self) -> Flags:
        """True where the extensor's strap presses."""
        return self.design.arm.is_pressed(self.elbow_angle)

    @cached_property
    def arm_slopes(self) -> tuple[Array, Real]:
        """Changes of the elbow stiffness per newton of each tendon, m/rad.

        They are J_f' - J_f c_f'/c_f, which each newton of the flexor takes from the stiffness, and
        J_e' - J_e c_e'/c_e, which each newton of the extensor adds to it.
        """
        motion = self.motion
        flexor_slope = motion.flexor_moment_arm_slope
        extensor_slope = motion.extensor_moment_arm_slope
        if self.flexor.is_still and self.extensor.is_still:
            return flexor_slope, extensor_slope
        flexor_rate = self.flexor.compliance_rate / self.flexor.compliance
        extensor_rate = self.extensor.compliance_rate / self.extensor.compliance
        return (
            flexor_slope - motion.flexor_moment_arm * flexor_rate,
            extensor_slope - motion.extensor_moment_arm * extensor_rate,
        )

    @property
    def torque_slope(self) -> Array:
        """Slope of the elbow torque, dτ_a/dθ, N m/rad."""
        return np.asarray(self.gravity_moment * self.cosine + self.other_slope)

    @cached_property
    def response(self) -> Response:
        """Tensions as functions of pretension."""
        return respond(self.coupling, unilateral=self.design.unilateral)

    @cached_property
    def held_stiffness(self) -> tuple[Array, Array]:
        """Elbow stiffness without the terms of `arm_slopes`, of a taut and a slack state, N m/rad.

        It is J_f²/c_f + J_e²/c_e + dτ_a/dθ, to which a slack tendon adds nothing.
        """
        coupling = self.coupling
        flexor = np.square(coupling.moment_arm) * (1.0 / coupling.flexor_compliance)
        extensor = np.asarray(np.square(coupling.extensor_arm) / coupling.extensor_compliance)
        loaded = np.where(coupling.elbow_torque < 0.0, extensor, flexor)
        slack = np.where(self.response.idle, 0.0, loaded)
        taut = flexor + extensor
        slope = self.torque_slope
        return taut + slope, np.where(self.design.unilateral, slack, taut) + slope

    @cached_property
    def motor_arms(self) -> tuple[Array, Array]:
        """Motor torque per distal newton of flexor and, against it, extensor (Eq. 17), m."""
        radius = self.design.flexor_radius
        flexor = np.asarray(radius / self.flexor.capstan)
        extensor = np.asarray(self.design.ratio * radius / self.extensor.capstan)
        return flexor, extensor

    @cached_property
    def balance(self) -> Balance:
        """Distal tensions and slack sides."""
        sides = (self.design.flexor.pretension, self.design.extensor.pretension)
        return Balance(self.coupling, self.response, self.coupling.common_pretension(*sides))

    @property
    def flexor_tension_proximal(self) -> Array:
        """Tension of the flexor at the motor, N."""
        return np.asarray(self.balance.flexor / self.flexor.capstan)

    @property
    def extensor_tension_proximal(self) -> Array:
        """Tension of the extensor at the motor, N."""
        return np.asarray(self.balance.extensor / self.extensor.capstan)

    @property
    def flexor_slack(self) -> Array:
        """Length of the loose path if the flexor is slack, m."""
        return self._slack_length(self.balance.flexor_slack)

    @property
    def extensor_slack(self) -> Array:
        """Length of the loose path if the extensor is slack, m."""
        return self._slack_length(self.balance.extensor_slack)

    @property
    def loose_length(self) -> Array:
        """Length of the loose path where a side is slack, m; NaN if undetermined."""
        unilateral = np.asarray(self.design.unilateral)
        flexor_per_path = 1.0 / np.asarray(self.design.ratio)  # the path counts as the extensor's
        per_path = np.where(self.coupling.elbow_torque < 0.0, flexor_per_path, 1.0)
        per_path = np.where(unilateral & ~self.response.idle, per_path, np.nan)
        return np.asarray(self.balance.path * per_path)

    def _slack_length(self, is_slack: Flags) -> Array:
        """Return the length of the loose path where slack, m: 0 where taut, NaN if undetermined."""
        unilateral = np.asarray(self.design.unilateral)
        taut = np.where(unilateral & ~np.isnan(self.coupling.moment_arm), 0.0, np.nan)
        return np.where(is_slack, self.loose_length, taut)

    @property
    def elbow_torque(self) -> Array:
        """Torque τ_a that the tendons balance at the elbow, N m; NaN without equilibrium."""
        return np.where(np.isnan(self.coupling.moment_arm), np.nan, self.coupling.elbow_torque)

    @property
    def motor_torque(self) -> Array:
        """Motor torque τ_m (Eq. 17), N m."""
        flexor_arm, extensor_arm = self.motor_arms
        torque = np.asarray(self.balance.flexor * flexor_arm)
        return np.asarray(np.subtract(torque, self.balance.extensor * extensor_arm, out=torque))

    @property
    def elbow_stiffness(self) -> Array:
        """Elbow stiffness with the motor held, N m/rad.

        k = J_f²/c_f + J_e²/c_e + dτ_a/dθ - (J_f' - J_f c_f'/c_f) x + (J_e' - J_e c_e'/c_e) y

        with x and y the distal tensions of flexor and extensor. It is negative where the arm is
        unstable: there the spool must turn back while the elbow goes on, and the direction of
        friction that the state assumes is wrong.
        """
        taut, slack = self.held_stiffness
        flexor_slope, extensor_slope = self.arm_slopes
        balance = self.balance
        stiffness = np.where(balance.is_slack, slack, taut) - balance.flexor * flexor_slope
        if np.any(extensor_slope):
            stiffness = stiffness + balance.extensor * extensor_slope
        return np.asarray(stiffness)

    @property
    def spool_angle(self) -> Array:
        """Spool angle α from the pretensioned state, rad.

        It follows from a side under tension. Where both are slack it is NaN: any angle will do.
        """
        design = self.design
        motion = self.motion
        status = self.status
        flexor_path = motion.flexor_travel + self.stretch("flexor", "compliance")
        extensor_path = motion.extensor_travel - self.stretch("extensor", "compliance")
        by_flexor = np.asarray(flexor_path / design.flexor_radius)
        by_extensor = extensor_path / (design.ratio * np.asarray(design.flexor_radius))
        is_flexor_slack = (status == statics.FLEXOR_SLACK) & design.unilateral
        are_both_slack = (status == statics.BOTH_SLACK) & design.unilateral
        angle = np.where(is_flexor_slack, by_extensor, by_flexor)
        return np.where(are_both_slack, np.nan, angle)

    def stretch(self, side: str, part: str) -> Array:
        """Return the elongation of a part of a side since the pretension was set, m.

        Args:
            side: One of SIDES.
            part: "tendon", "spring", or "compliance" for all of the side.
        """
        sheath = getattr(self, side)
        resting_sheath = self.resting[SIDES.index(side)] if self.resting else sheath
        now = getattr(sheath, part)
        resting = getattr(resting_sheath, part)
        pretension = getattr(self.design, side).pretension
        change = getattr(self.balance, side) - pretension
        stretched: Array = now * change + (now - resting) * pretension
        return stretched

    @property
    def status(self) -> Status:
        """Index into `statics.STATUS_NAMES`."""
        return self.balance.status

    def columns(self, names: Iterable[str] | None = None) -> dict[str, Array]:
        """Return columns of the states table by name, as `quantities` defines them.

        By default these are all but the status.
        """
        if names is None:
            names = OF_STATES if self.sliding is None else (*OF_STATES, *OF_MOTION_STATES)
        return {name: np.asarray(_VALUES[name](self)) for name in names}


_VALUES = {
    name: value
    for name in (*OF_STATES, *OF_MOTION_STATES)
    if (value := QUANTITIES[name].value) is not None
}


def evaluate(design: Design, elbow_angle: Real, flexion: Flag) -> State:
    """Solve every state of the broadcast product of designs, elbow angles and directions.

    Args:
        design: Designs.
        elbow_angle: Elbow angles, rad.
        flexion: True in flexion, else extension.
    """
    return State.of(design, elbow_angle, flexion)


_WITHOUT_PRETENSION = ("coupling", "response", "held_stiffness", "arm_slopes", "motor_arms")
"""Quantities of a state that do not depend on pretension."""


def at_pretension(state: State, pretension: Real) -> State:
    """Return the same states with another pretension of both sides.

    What does not depend on it is worked out once for both.

    Args:
        state: The states.
        pretension: Pretension of flexor and extensor, N.
    """
    changed = replace(state, design=state.design.with_pretension(pretension))
    for name in _WITHOUT_PRETENSION:
        vars(changed)[name] = getattr(state, name)
    return changed
