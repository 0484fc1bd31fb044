"""A design: the arm that wears it, two tendons in sheaths with springs, and a motor's spool.

All fields are scalars or arrays that broadcast against each other. SI units, angles in radians.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any

import numpy as np

from tendon_cli.model.kinematics import AnyJoint, Array, Flag, Real, Spline
from tendon_cli.model.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class Limb:
    """A joint, the limb beyond it and its weight."""

    joint: AnyJoint
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
    contact_radius: Real = np.nan
    """Radius of curvature of that strap, m; NaN if the joint tells."""
    stiffness: Real = 0.0
    """Stiffness of the joint itself, N m/rad."""
    rest_angle: Real = 0.0
    """Angle at which that stiffness asks for no torque, rad."""
    torque: Spline | None = None
    """Torque that the joint asks for by itself, N m over rad, instead of the two."""
    inertia: Real = 0.0
    """Moment of inertia of forearm and hand about the joint, kg m²."""

    @property
    def strap_radius(self) -> Array:
        """Radius of curvature of the extensor's strap, m."""
        return np.where(np.isnan(self.contact_radius), self.joint.strap_radius, self.contact_radius)

    def passive(self, angle: Real, derivative: int = 0) -> Real:
        """Return the torque that the joint asks for by itself to be flexed further.

        Args:
            angle: Angles of the joint, rad.
            derivative: 0 for the torque, N m, or 1 for its slope, N m/rad.
        """
        if self.torque is not None:
            return self.torque(angle, derivative)
        if derivative == 0:
            return self.stiffness * np.subtract(angle, self.rest_angle)
        return self.stiffness


@dataclass(frozen=True, eq=False)
class Side:
    """One tendon with its sheath, its series spring and its anchor."""

    friction: Real
    """μ."""
    bend_angle: Real | Spline
    """φ = ∫κ ds, rad; a curve over the joint's angle if the sheath follows the joint."""
    length: Real
    """L, m."""
    diameter: Real
    """d, m."""
    youngs_modulus: Real
    """E, Pa."""
    spring_stiffness: Real
    """K_SE, N/m; infinite without a spring."""
    pretension: Real
    """F0, distal tension before motion, N."""
    anchor_stiffness: Real = np.inf
    """K_t, of tissue and cuff behind the anchor, N/m."""
    spring_at_motor: Flag = False
    """True where the spring sits at the motor's end of the tendon, else at the joint's."""

    def bend(self, angle: Real) -> tuple[Real, Real]:
        """Return φ (rad) and dφ/dθ at angles of the joint (rad)."""
        if isinstance(self.bend_angle, Spline):
            return self.bend_angle(angle), self.bend_angle(angle, 1)
        return self.bend_angle, 0.0


STANDARD_GRAVITY = 9.81
"""g in m/s², as the paper's findings assume."""
F0 = "pretension"
READINGS = (F0, "flexor at joint", "extensor at joint", "flexor at motor", "extensor at motor")
"""Readings of a pretension: F0 of the model, or a tension in the posture in which it is set."""


@dataclass(frozen=True, eq=False)
class Posture:
    """Posture in which the pretension is set, the limb at rest after a direction of motion."""

    angle: Real = 0.0
    """θ0 of the joint, rad."""
    upper_arm_angle: Real = 0.0
    """ψ, inclination of the upper arm, rad."""
    load_mass: Real = 0.0
    """Mass in the hand, kg."""
    after_flexion: Flag = False
    """True after flexion, else after extension."""


@dataclass(frozen=True, eq=False)
class Design:
    """Everything that a state depends on besides elbow angle and direction."""

    arm: Limb
    flexor: Side
    extensor: Side
    flexor_radius: Real
    """R_m^f, m."""
    ratio: Real
    """η = R_m^e / R_m^f."""
    load_mass: Real
    """Mass of the load, kg."""
    unilateral: Flag = True
    """True where a tendon cannot push; otherwise the paper's bilateral model."""
    load_torque: Spline | None = None
    """Torque that a task asks for besides the weights, N m over rad."""
    load_scale: Real = 1.0
    """Factor of that torque."""
    trajectory: Trajectory | None = None
    """Motion in time, if it is one: at its samples inertia asks for torque, too."""
    setting: Posture = field(default_factory=Posture)
    read: str = F0
    """Reading in which the pretension is given, one of READINGS."""
    given: Mapping[str, Real] = field(default_factory=dict)
    """Numbers that a limit alone needs, by key (`limits.GIVEN`); that of the flexor if both sides
    have one."""

    @property
    def bend_follows_joint(self) -> bool:
        """True if a sheath bends as the joint turns."""
        return isinstance(self.flexor.bend_angle, Spline) or isinstance(
            self.extensor.bend_angle, Spline
        )

    @property
    def gravity_moment(self) -> Array:
        """Moment of forearm and load about the elbow where the forearm is level, N m."""
        forearm = self.arm.forearm_mass * self.arm.forearm_com
        return np.multiply(STANDARD_GRAVITY, forearm + self.load_mass * self.arm.load_distance)

    @property
    def knots(self) -> Array:
        """Angles at which any of its curves has a kink in a derivative, rad."""
        curves = [
            self.arm.torque,
            self.load_torque,
            self.flexor.bend_angle,
            self.extensor.bend_angle,
            getattr(self.arm.joint, "flexor", None),
            getattr(self.arm.joint, "extensor", None),
        ]
        knots = [curve.knots for curve in curves if isinstance(curve, Spline)]
        return np.unique(np.concatenate([np.zeros(0), *knots]))

    def other_torque(self, angle: Real, derivative: int = 0) -> Real:
        """Return the torque that joint and task ask for besides the weights.

        Args:
            angle: Angles of the joint, rad.
            derivative: 0 for the torque, N m, or 1 for its slope, N m/rad.
        """
        joint = self.arm.passive(angle, derivative)
        if self.load_torque is None:
            return joint
        return joint + self.load_scale * self.load_torque(angle, derivative)


def map_arrays(made: Any, change: Callable[..., Any], *others: Any) -> Any:
    """Return a design, or an object of one, with each of its arrays changed.

    Args:
        made: Design, a dataclass or mapping in it, or an array.
        change: Function of an array, and of the same array of each of the others.
        others: Objects that are made likewise.
    """
    if isinstance(made, np.ndarray):
        return change(made, *others)
    if isinstance(made, Mapping):
        return {
            key: map_arrays(value, change, *(other[key] for other in others))
            for key, value in made.items()
        }
    if not is_dataclass(made):
        return made
    parts = {}
    for name in (part.name for part in fields(made)):
        other_parts = (getattr(other, name) for other in others)
        parts[name] = map_arrays(getattr(made, name), change, *other_parts)
    return replace(made, **parts)  # type: ignore[type-var]
