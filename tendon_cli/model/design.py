"""A design: the arm of its wearer, two sheathed tendons with springs, and the motor's spool.

All fields are scalars or arrays that broadcast against each other. SI units, angles in radians.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any

import numpy as np

from tendon_cli.model.kinematics import AnyJoint, Array, Flag, Flags, Real, Spline
from tendon_cli.model.trajectory import Trajectory

_SAME_ANGLE = 1e-12
"""Distance within which two angles are the same but for rounding, rad."""


@dataclass(frozen=True, eq=False)
class Limb:
    """A joint, the limb beyond it and its weight."""

    joint: AnyJoint
    forearm_mass: Real
    """Mass of forearm and hand, kg."""
    forearm_com: Real
    """Distance of their centre of mass from the elbow, m."""
    load_distance: Real
    """Distance of the load from the elbow, m."""
    upper_arm_angle: Real
    """Inclination of the upper arm ψ, forward positive, rad."""
    contact_width: Real = np.nan
    """Width of the extensor's strap around the elbow, m."""
    contact_radius: Real = np.nan
    """Radius of curvature of that strap, m; NaN to take it from the joint."""
    contact_from: Real = np.nan
    """Angle from which on that strap presses, rad; NaN to take it from the joint."""
    stiffness: Real = 0.0
    """Stiffness of the joint itself, N m/rad."""
    rest_angle: Real = 0.0
    """Angle at which that stiffness exerts no torque, rad."""
    torque: Spline | None = None
    """Passive torque of the joint, N m over rad, instead of stiffness and rest angle."""
    inertia: Real = 0.0
    """Moment of inertia of forearm and hand about the joint, kg m²."""

    @property
    def strap_radius(self) -> Array:
        """Radius of curvature of the extensor's strap, m."""
        return np.where(np.isnan(self.contact_radius), self.joint.strap_radius, self.contact_radius)

    @property
    def first_contact(self) -> Array:
        """Angle from which on the extensor's strap presses, rad."""
        stated = np.asarray(self.contact_from).real
        return np.where(np.isnan(stated), self.joint.contact_from, stated)

    def is_pressed(self, angle: Real, half_width: Real = 0.0) -> Flags:
        """Return True where the extensor's strap presses.

        Args:
            angle: Angles of the joint, or middles of cells of it, rad.
            half_width: Half-width of these cells, rad.
        """
        first = self.first_contact
        middle = np.asarray(angle).real
        has_middle = middle >= first - _SAME_ANGLE
        has_end = middle + half_width > first + _SAME_ANGLE
        return np.asarray(has_middle | has_end)

    def passive(self, angle: Real, derivative: int = 0) -> Real:
        """Return the passive torque of the joint, positive where it resists flexion.

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
    """Coefficient of friction μ between tendon and sheath."""
    bend_angle: Real | Spline
    """Total curvature of the sheath φ = ∫κ ds, rad; a curve over the joint's angle if the sheath
    follows the joint."""
    length: Real
    """Length of the tendon L, m."""
    diameter: Real
    """Diameter of the tendon d, m."""
    youngs_modulus: Real
    """Young's modulus of the tendon E, Pa."""
    spring_stiffness: Real
    """Stiffness of the series spring K_SE, N/m; infinite without a spring."""
    pretension: Real
    """Distal tension before motion F0, N."""
    anchor_stiffness: Real = np.inf
    """Stiffness of tissue and cuff behind the anchor K_t, N/m."""
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
MOTOR_TORQUE = "motor torque"
TENSIONS = ("flexor at joint", "extensor at joint", "flexor at motor", "extensor at motor")
READINGS = (F0, *TENSIONS, MOTOR_TORQUE)
"""Readings of a pretension: F0 of the model, or a tension or the torque of the motor in the posture
in which it is set."""


@dataclass(frozen=True, eq=False)
class Posture:
    """Posture in which the pretension is set; the limb rests after a motion in one direction."""

    angle: Real = 0.0
    """Angle of the joint θ0, rad."""
    upper_arm_angle: Real = 0.0
    """Inclination of the upper arm ψ, rad."""
    load_mass: Real = 0.0
    """Mass in the hand, kg."""
    after_flexion: Flag = False
    """True after flexion, else after extension."""
    reading_error: Real = 0.0
    """Error of the gauge: what it shows above what it should, in the unit of the reading."""


@dataclass(frozen=True, eq=False)
class Design:
    """Everything that a state depends on besides elbow angle and direction."""

    arm: Limb
    flexor: Side
    extensor: Side
    flexor_radius: Real
    """Radius of the flexor's spool R_m^f, m."""
    ratio: Real
    """Extensor over flexor radius of the spool, η = R_m^e / R_m^f."""
    load_mass: Real
    """Mass of the load, kg."""
    unilateral: Flag = True
    """True where a tendon cannot push; otherwise the paper's bilateral model."""
    load_torque: Spline | None = None
    """Torque that a task needs besides that for the weights, N m over rad."""
    load_scale: Real = 1.0
    """Factor of that torque."""
    trajectory: Trajectory | None = None
    """Motion in time, at the samples of which inertia needs torque, too; None if quasi-static."""
    one_length: bool = False
    """True if each tendon has one natural length in both directions, also without a trajectory."""
    setting: Posture = field(default_factory=Posture)
    read: str = F0
    """Reading in which the pretension is given, one of READINGS."""
    given: Mapping[str, Real] = field(default_factory=dict)
    """Numbers that only a limit needs, by key (`limits.GIVEN`); those of the flexor if both sides
    have them."""
    limits: Mapping[str, Real] = field(default_factory=dict)
    """Bounds of limits that designs do not share, by the name of the limit, SI; NaN for a design
    without that limit."""

    @property
    def shows_f0(self) -> bool:
        """True if what is read of every design is F0 itself, without an error."""
        return self.read == F0 and not np.any(self.setting.reading_error)

    @property
    def has_one_length(self) -> bool:
        """True if each tendon has one natural length in both directions.

        That is so along a trajectory, where the tendons turn. Else F0 stretches them by the
        compliance of the direction, as in Eq. 13.
        """
        return self.one_length or self.trajectory is not None

    def at_rest(self, **changes: Any) -> Design:
        """Return the design without its trajectory, with the same tendons, and with changes."""
        return replace(self, trajectory=None, one_length=self.has_one_length, **changes)

    def with_pretension(self, pretension: Real) -> Design:
        """Return the design with another pretension of both sides, N."""
        flexor = replace(self.flexor, pretension=pretension)
        extensor = replace(self.extensor, pretension=pretension)
        return replace(self, flexor=flexor, extensor=extensor)

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
        """Angles at which a derivative of any of the design's curves has a kink, rad."""
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
        """Return the torque that joint and task need, to which that for the weights is added.

        Args:
            angle: Angles of the joint, rad.
            derivative: 0 for the torque, N m, or 1 for its slope, N m/rad.
        """
        joint = self.arm.passive(angle, derivative)
        if self.load_torque is None:
            return joint
        return joint + self.load_scale * self.load_torque(angle, derivative)


def map_arrays(part: Any, change: Callable[..., Any], *others: Any) -> Any:
    """Return a design, or other data, with each of its arrays changed.

    Args:
        part: Dataclass, such as a design; a dataclass, mapping or tuple in it; or an array.
        change: Function of an array, and of the same array of each of the others.
        others: Data with the same structure.
    """
    if isinstance(part, np.ndarray):
        return change(part, *others)
    if isinstance(part, Mapping):
        return {
            key: map_arrays(value, change, *(other[key] for other in others))
            for key, value in part.items()
        }
    if isinstance(part, tuple):
        places = zip(part, *others, strict=True)
        return tuple(map_arrays(first, change, *rest) for first, *rest in places)
    if not is_dataclass(part):
        return part
    changed = {}
    for name in (entry.name for entry in fields(part)):
        of_others = (getattr(other, name) for other in others)
        changed[name] = map_arrays(getattr(part, name), change, *of_others)
    return replace(part, **changed)  # type: ignore[type-var]


def shape_of(design: Design) -> tuple[int, ...]:
    """Return the shape of designs, without the axes of directions and angles."""
    shapes: list[tuple[int, ...]] = []

    def note(values: Array) -> Array:
        shapes.append(values.shape[:-2])
        return values

    map_arrays(design, note)
    return np.broadcast_shapes(*shapes)
