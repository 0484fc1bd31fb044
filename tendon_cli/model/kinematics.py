"""A joint: how far both tendons travel as it turns, and by which moment arms (Eqs. 1-3).

A joint says at each angle by how much the flexor's path has shortened and the extensor's lengthened, with the slopes of
these curves: more of it does not enter the model. `Anchors` is the arm of the paper, whose flexor tendon runs straight
from the anchor r on the upper arm to the anchor q on the forearm (Fig. 2) while the extensor tendon wraps a virtual
pulley at the elbow; `Excursion` is any other joint, by measured travels. A value whose slope came from another curve
would not close the balance of energy. All functions broadcast their arguments; lengths in metres, angles in radians.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

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
            slope = (
                forward * up_rate - up * forward_rate - speed_squared + moment_arm * moment_arm
            ) / path
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


def _dead_centre(anchors: Anchors) -> Array:
    """A moment arm below which it is a rounded zero: a straight arm with both anchors on the bone has 7e-17 m."""
    return np.asarray(DEAD_CENTRE * (anchors.b1 + anchors.b2 + anchors.a1 + anchors.a2))


def _anchor_offset(anchors: Anchors, elbow_angle: Real) -> tuple[Array, Array]:
    """Components of q - r: forward, and up the upper arm (the two squares in Eq. 1)."""
    sine, cosine = np.sin(elbow_angle), np.cos(elbow_angle)
    forward = anchors.b2 * sine + anchors.a2 * cosine - anchors.a1
    up = anchors.a2 * sine - anchors.b2 * cosine - anchors.b1
    return np.asarray(forward), np.asarray(up)


class Spline:
    """A piecewise cubic: `coefficients` (4, pieces), highest power first, from each of the ascending `knots` on."""

    def __init__(self, knots: Array, coefficients: Array) -> None:
        self.knots, self.coefficients = knots, coefficients

    def __call__(self, angle: Real, derivative: int = 0) -> Array:
        """Values, or derivatives, at angles (rad), of their shape; beyond the ends the last piece goes on."""
        # Of complex numbers, for derivatives, and of series, for proofs, the real part says in what piece they are.
        piece = np.clip(
            np.searchsorted(self.knots, angle.real, side="right") - 1, 0, len(self.knots) - 2
        )
        from_knot, total = angle - self.knots[piece], np.zeros(np.shape(piece))
        for power, coefficient in zip((3, 2, 1, 0), self.coefficients, strict=True):
            if power >= derivative:
                factor = float(np.prod(np.arange(power - derivative + 1, power + 1)))
                total = total * from_knot + factor * coefficient[piece]
        return total


@dataclass(frozen=True, eq=False)
class Excursion:
    """A joint by measured travels of both tendons, from its angle `origin` on."""

    flexor: Spline
    """By how much the flexor's path shortens with the angle, m, from any zero."""
    extensor: Spline
    """By how much the extensor's path lengthens, m."""
    origin: Real = 0.0
    """The posture in which both travels are zero, rad."""
    scale: Real = 1.0
    """Travels over those measured, on another body."""
    strap_radius: Real = np.nan
    """Radius of curvature of the extensor's strap, m; a table of travels does not tell it."""

    def motion(self, angle: Real) -> Travels:
        """Travels and moment arms at angles of the joint."""

        def along(curve: Spline, derivative: int) -> Array:
            return np.asarray(self.scale * curve(angle, derivative))

        flexor_arm, extensor_arm = along(self.flexor, 1), along(self.extensor, 1)
        least = DEAD_CENTRE * (
            np.ptp(self.flexor.coefficients[3]) + np.ptp(self.extensor.coefficients[3])
        )
        balances = (flexor_arm > least) & (extensor_arm > least)
        return Travels(
            flexor_travel=np.asarray(self.scale * (self.flexor(angle) - self.flexor(self.origin))),
            extensor_travel=np.asarray(
                self.scale * (self.extensor(angle) - self.extensor(self.origin))
            ),
            flexor_moment_arm=flexor_arm,
            extensor_moment_arm=extensor_arm,
            flexor_moment_arm_slope=along(self.flexor, 2),
            extensor_moment_arm_slope=along(self.extensor, 2),
            pulling_arm=np.where(balances, flexor_arm, np.nan),
        )


AnyJoint: TypeAlias = Anchors | Excursion
"""One degree of freedom that two tendons pull on."""
