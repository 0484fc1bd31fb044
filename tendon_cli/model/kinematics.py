"""How the tendon paths change as the elbow bends (Eqs. 1-3).

The flexor tendon runs straight from the anchor r on the upper arm to the anchor q on the forearm (Fig. 2); the
extensor tendon wraps a virtual pulley at the elbow. All functions broadcast their arguments; lengths in metres,
angles in radians.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Real = float | Array
Flags = npt.NDArray[np.bool_]
Flag = bool | Flags

DEAD_CENTRE = 1e-9
"""A moment arm below this share of all anchor offsets together is none."""


@dataclass(frozen=True, eq=False)
class Anchors:
    """Where the flexor tendon is fixed (Fig. 2) and what the extensor wraps. All in m, scalars or arrays."""

    a1: Real
    """Distance of the proximal anchor r in front of the upper arm's line."""
    b1: Real
    """Distance of the proximal anchor r from the elbow along the upper arm."""
    a2: Real
    """Distance of the distal anchor q in front of the forearm's line."""
    b2: Real
    """Distance of the distal anchor q from the elbow along the forearm."""
    elbow_radius: Real
    """Radius of the virtual pulley, the constant moment arm of the extensor."""


@dataclass(frozen=True, eq=False)
class Kinematics:
    """The flexor path at some elbow angles and both travels."""

    flexor_path: Array
    """L_c, distance between the anchors q and r (Eq. 1), m."""
    flexor_travel: Array
    """H_f, by how much the flexor path is shorter than its reference, m."""
    extensor_travel: Array
    """H_e = R_elb θ, by how much the extensor path is longer than at θ = 0, m."""
    flexor_moment_arm: Array
    """J = dH_f/dθ, m; not a number where the anchors coincide."""
    flexor_moment_arm_slope: Array
    """dJ/dθ, m/rad."""
    pulling_arm: Array
    """J where the flexor can flex the elbow; not a number from the dead centre on, where J <= 0 but for rounding, m."""


def flexor_path(anchors: Anchors, elbow_angle: Real) -> Array:
    """Distance L_c between the flexor's anchors (Eq. 1), m."""
    forward, up = _anchor_offset(anchors, elbow_angle)
    return np.sqrt(forward * forward + up * up)


def kinematics(anchors: Anchors, elbow_angle: Real, *, from_initial: Flag = False) -> Kinematics:
    """Path, travels and moment arm with its derivative, analytically (Eqs. 1-3).

    Travel is measured from b1 + b2, as published, or from L_c(0) where `from_initial`: the published reference is off
    by L_c(0) - (b1 + b2), 0.7 mm for the paper's arm, so that H_f(0) is not zero.
    """
    forward, up = _anchor_offset(anchors, elbow_angle)
    path = np.sqrt(forward * forward + up * up)
    # As the forearm turns, the offset moves at a right angle to the position of q, which is (forward + a1, up + b1).
    forward_rate = -(up + anchors.b1)
    up_rate = forward + anchors.a1
    with np.errstate(divide="ignore", invalid="ignore"):
        moment_arm = -(forward * forward_rate + up * up_rate) / path
        # d²(L_c²/2)/dθ² = L_c'² + L_c L_c'', and q moves on a circle: its acceleration is minus its position.
        speed_squared = forward_rate * forward_rate + up_rate * up_rate
        slope = (forward * up_rate - up * forward_rate - speed_squared + moment_arm * moment_arm) / path
    straight = flexor_path(anchors, 0.0)
    reference = np.where(from_initial, straight, np.add(anchors.b1, anchors.b2))
    return Kinematics(
        flexor_path=path,
        flexor_travel=reference - path,
        extensor_travel=np.multiply(anchors.elbow_radius, elbow_angle),
        flexor_moment_arm=moment_arm,
        flexor_moment_arm_slope=slope,
        pulling_arm=np.where(moment_arm >= _dead_centre(anchors), moment_arm, np.nan),
    )


def no_slack_radius_ratio(motion: Kinematics) -> Array:
    """H_f / H_e (Eq. 3 and Fig. 4): flexor over extensor radius that would wind both paths without slack.

    The paper prints it as R_e / R_f, with the labels of Eq. 2 exchanged; it diverges at θ = 0.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(motion.flexor_travel / motion.extensor_travel)


def _dead_centre(anchors: Anchors) -> Array:
    """A moment arm below which it is a rounded zero: a straight arm with both anchors on the bone has 7e-17 m."""
    return np.asarray(DEAD_CENTRE * (anchors.b1 + anchors.b2 + anchors.a1 + anchors.a2))


def _anchor_offset(anchors: Anchors, elbow_angle: Real) -> tuple[Array, Array]:
    """Components of q - r: forward, and up the upper arm (the two squares in Eq. 1)."""
    sine, cosine = np.sin(elbow_angle), np.cos(elbow_angle)
    forward = anchors.b2 * sine + anchors.a2 * cosine - anchors.a1
    up = anchors.a2 * sine - anchors.b2 * cosine - anchors.b1
    return np.asarray(forward), np.asarray(up)
