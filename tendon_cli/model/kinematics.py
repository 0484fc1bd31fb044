"""A joint: how far both tendons travel as it turns, and by which moment arms (Eqs. 1-3).

A joint says at each angle by how much the flexor's path has shortened and the extensor's lengthened, with the slopes of
these curves: more of it does not enter the model. `Anchors` is the arm of the paper, whose flexor tendon runs straight
from the anchor r on the upper arm to the anchor q on the forearm (Fig. 2) while the extensor tendon wraps a virtual
pulley at the elbow. All functions broadcast their arguments; lengths in metres, angles in radians.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Real = float | Array
Flags = npt.NDArray[np.bool_]
Flag = bool | Flags

DEAD_CENTRE = 1e-9
"""A moment arm below this share of all anchor offsets together is none."""


@dataclass(frozen=True, eq=False)
class Travels:
    """Both tendons' travels at some angles of a joint, with their first and second derivatives."""

    flexor_travel: Array
    """H_f, by how much the flexor path is shorter than its reference, m."""
    extensor_travel: Array
    """H_e, by how much the extensor path is longer than its reference, m."""
    flexor_moment_arm: Array
    """J_f = dH_f/dθ, m; not a number where the anchors coincide."""
    extensor_moment_arm: Real
    """J_e = dH_e/dθ, m."""
    flexor_moment_arm_slope: Array
    """dJ_f/dθ, m/rad."""
    extensor_moment_arm_slope: Real
    """dJ_e/dθ, m/rad."""
    pulling_arm: Array
    """J_f where both tendons can turn the joint; not a number from the dead centre on, where J_f <= 0 but for rounding,
    or where J_e <= 0, m."""
    flexor_path: Array | None = None
    """L_c, length of the flexor's path outside of its sheath (Eq. 1), m; None where the joint does not tell."""

    def mismatch(self, ratio: Real) -> Array:
        """h = H_e - η H_f, what the springs must give for the spool's ratio η, m."""
        return np.asarray(self.extensor_travel - ratio * self.flexor_travel)


class AnyJoint(Protocol):
    """One degree of freedom that two tendons pull on."""

    def motion(self, angle: Real) -> Travels:
        """Travels and moment arms at angles of the joint."""
        ...

    @property
    def strap_radius(self) -> Real:
        """Radius of curvature of the extensor's strap on the joint, m; NaN where the joint does not tell."""
        ...


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
    from_initial: Flag = False
    """Measure the flexor's travel from L_c(0) instead of b1 + b2, as published: that is off by L_c(0) - (b1 + b2),
    0.7 mm for the paper's arm, so that H_f(0) is not zero."""

    @property
    def strap_radius(self) -> Real:
        """The strap lies on the virtual pulley, m."""
        return self.elbow_radius

    def motion(self, angle: Real) -> Travels:
        """Path, travels and moment arms with their derivatives, analytically (Eqs. 1-3)."""
        forward, up = _anchor_offset(self, angle)
        path = np.sqrt(forward * forward + up * up)
        # As the forearm turns, the offset moves at a right angle to the position of q: (forward + a1, up + b1).
        forward_rate = -(up + self.b1)
        up_rate = forward + self.a1
        with np.errstate(divide="ignore", invalid="ignore"):
            moment_arm = -(forward * forward_rate + up * up_rate) / path
            # d²(L_c²/2)/dθ² = L_c'² + L_c L_c'', and q moves on a circle: its acceleration is minus its position.
            speed_squared = forward_rate * forward_rate + up_rate * up_rate
            slope = (forward * up_rate - up * forward_rate - speed_squared + moment_arm * moment_arm) / path
        reference = np.where(self.from_initial, flexor_path(self, 0.0), np.add(self.b1, self.b2))
        return Travels(
            flexor_travel=reference - path,
            extensor_travel=np.multiply(self.elbow_radius, angle),
            flexor_moment_arm=moment_arm,
            extensor_moment_arm=self.elbow_radius,
            flexor_moment_arm_slope=slope,
            extensor_moment_arm_slope=0.0,
            pulling_arm=np.where(moment_arm >= _dead_centre(self), moment_arm, np.nan),
            flexor_path=path,
        )


def flexor_path(anchors: Anchors, elbow_angle: Real) -> Array:
    """Distance L_c between the flexor's anchors (Eq. 1), m."""
    forward, up = _anchor_offset(anchors, elbow_angle)
    return np.sqrt(forward * forward + up * up)


def no_slack_radius_ratio(motion: Travels) -> Array:
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
