"""A joint: travels of both tendons as it turns, and their moment arms (Eqs. 1-3).

A joint gives at each angle how much the flexor's path has shortened and the extensor's lengthened,
with the slopes of these curves; nothing else of it enters the model. `Anchors` is the arm of the
paper, whose flexor tendon runs straight from the anchor r on the upper arm to the anchor q on the
forearm (Fig. 2) while the extensor tendon wraps a virtual pulley at the elbow; `Excursion` is any
other joint, given by measured travels. Slopes are derivatives of the same curves as the values, or
else energy would not balance. All functions broadcast their arguments; lengths in metres, angles in
radians.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Real = float | Array
Flags = npt.NDArray[np.bool_]
Rows = npt.NDArray[np.int64]
"""Indices of rows, of states or of conditions."""
Flag = bool | Flags

CONTACT_FROM = float(np.radians(10.0))
"""Angle from which on a strap around the elbow presses if a study states none, rad."""
DEAD_CENTRE = 1e-9
"""Moment arm below which it counts as zero, as a share of the sum of all anchor offsets."""


@dataclass(frozen=True, eq=False)
class Travels:
    """Travels of both tendons at some angles of a joint, with first and second derivatives."""

    flexor_travel: Array
    """H_f, shortening of the flexor's path from its reference, m."""
    extensor_travel: Array
    """H_e, lengthening of the extensor's path from its reference, m."""
    flexor_moment_arm: Array
    """J_f = dH_f/dθ, m; NaN where the anchors coincide."""
    extensor_moment_arm: Real
    """J_e = dH_e/dθ, m."""
    flexor_moment_arm_slope: Array
    """dJ_f/dθ, m/rad."""
    extensor_moment_arm_slope: Real
    """dJ_e/dθ, m/rad."""
    pulling_arm: Array
    """J_f where both tendons can turn the joint, m; NaN from the dead centre on, where J_f <= 0 but
    for rounding, or where J_e <= 0."""
    flexor_path: Array | None = None
    """L_c, length of the flexor's path outside of its sheath (Eq. 1), m; None if the joint does not
    define it."""

    def mismatch(self, ratio: Real) -> Array:
        """Return h = H_e - η H_f, length that the springs must take up at spool ratio η, m."""
        return np.asarray(self.extensor_travel - ratio * self.flexor_travel)


@dataclass(frozen=True, eq=False)
class Anchors:
    """Anchors of the flexor tendon (Fig. 2) and the pulley that the extensor wraps, in m."""

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
    """Measure the flexor's travel from L_c(0) instead of b1 + b2, as published: that is off by
    L_c(0) - (b1 + b2), 0.7 mm for the paper's arm, so that H_f(0) is not zero."""

    @property
    def strap_radius(self) -> Real:
        """Radius of the virtual pulley, on which the strap lies, m."""
        return self.elbow_radius

    @property
    def contact_from(self) -> float:
        """Angle from which on the strap presses if a study states none, rad.

        At 0 neither the strap's wrap, R θ, nor its force on the elbow, 2 T sin(θ/2), exists.
        """
        return CONTACT_FROM

    def motion(self, angle: Real) -> Travels:
        """Return path, travels and moment arms with their derivatives, analytically (Eqs. 1-3).

        Args:
            angle: Elbow angles, rad.
        """
        forward, up = _anchor_offset(self, angle)
        path = np.sqrt(forward * forward + up * up)
        # As the forearm turns, the offset moves at a right angle to the position of q:
        # (forward + a1, up + b1).
        forward_rate = -(up + self.b1)
        up_rate = forward + self.a1
        with np.errstate(divide="ignore", invalid="ignore"):
            moment_arm = -(forward * forward_rate + up * up_rate) / path
            # d²(L_c²/2)/dθ² = L_c'² + L_c L_c'', and q moves on a circle: its acceleration is minus
            # its position.
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
    """Return the distance L_c between the flexor's anchors (Eq. 1), m.

    Args:
        anchors: Anchors of the arm.
        elbow_angle: Elbow angles, rad.
    """
    forward, up = _anchor_offset(anchors, elbow_angle)
    return np.sqrt(forward * forward + up * up)


def _dead_centre(anchors: Anchors) -> Array:
    """Return the moment arm below which it is zero but for rounding, m.

    A straight arm with both anchors on the bone has 7e-17 m.
    """
    return np.asarray(DEAD_CENTRE * (anchors.b1 + anchors.b2 + anchors.a1 + anchors.a2))


def _anchor_offset(anchors: Anchors, elbow_angle: Real) -> tuple[Array, Array]:
    """Return q - r, m: its components forward and up the upper arm, squared in Eq. 1."""
    sine = np.sin(elbow_angle)
    cosine = np.cos(elbow_angle)
    forward = anchors.b2 * sine + anchors.a2 * cosine - anchors.a1
    up = anchors.a2 * sine - anchors.b2 * cosine - anchors.b1
    return np.asarray(forward), np.asarray(up)


class Spline:
    """A piecewise cubic over an angle.

    Args:
        knots: Ascending angles at which the pieces begin, and the end of the last, rad.
        coefficients: Coefficients of each piece (4, pieces), highest power first, of the angle from
            its knot.
    """

    def __init__(self, knots: Array, coefficients: Array) -> None:
        self.knots = knots
        self.coefficients = coefficients

    def __call__(self, angle: Real, derivative: int = 0) -> Array:
        """Return values, or derivatives, at angles; beyond the ends the outer pieces go on.

        Args:
            angle: Angles of any shape, rad; also complex numbers, for derivatives, and series, for
                proofs.
            derivative: Order of the derivative, 0 for the value.

        Returns:
            Values in the shape of the angles.
        """
        # The real part says in which piece a complex number or a series is.
        piece = np.searchsorted(self.knots, angle.real, side="right") - 1
        piece = np.clip(piece, 0, len(self.knots) - 2)
        from_knot = angle - self.knots[piece]
        total = np.zeros(np.shape(piece))
        for power, coefficient in zip((3, 2, 1, 0), self.coefficients, strict=True):
            if power >= derivative:
                factor = float(np.prod(np.arange(power - derivative + 1, power + 1)))
                total = total * from_knot + factor * coefficient[piece]
        return total


@dataclass(frozen=True, eq=False)
class Excursion:
    """A joint given by measured travels of both tendons, which are zero at its angle `origin`."""

    flexor: Spline
    """Shortening of the flexor's path over the angle, m, from any zero."""
    extensor: Spline
    """Lengthening of the extensor's path over the angle, m, from any zero."""
    origin: Real = 0.0
    """Posture in which both travels are zero, rad."""
    scale: Real = 1.0
    """Factor on the measured travels, for another body."""
    strap_radius: Real = np.nan
    """Radius of curvature of the extensor's strap, m; a table of travels does not give it."""
    contact_from: Real = -np.inf
    """Angle from which on the strap presses, rad; a table of travels does not tell the wrap."""

    def motion(self, angle: Real) -> Travels:
        """Return travels and moment arms.

        Args:
            angle: Angles of the joint, rad.
        """

        def scaled(curve: Spline, derivative: int) -> Array:
            return np.asarray(self.scale * curve(angle, derivative))

        flexor_travel = self.scale * (self.flexor(angle) - self.flexor(self.origin))
        extensor_travel = self.scale * (self.extensor(angle) - self.extensor(self.origin))
        flexor_arm = scaled(self.flexor, 1)
        extensor_arm = scaled(self.extensor, 1)
        flexor_range = np.ptp(self.flexor.coefficients[3])
        extensor_range = np.ptp(self.extensor.coefficients[3])
        least_arm = DEAD_CENTRE * (flexor_range + extensor_range)
        can_turn = (flexor_arm > least_arm) & (extensor_arm > least_arm)
        return Travels(
            flexor_travel=np.asarray(flexor_travel),
            extensor_travel=np.asarray(extensor_travel),
            flexor_moment_arm=flexor_arm,
            extensor_moment_arm=extensor_arm,
            flexor_moment_arm_slope=scaled(self.flexor, 2),
            extensor_moment_arm_slope=scaled(self.extensor, 2),
            pulling_arm=np.where(can_turn, flexor_arm, np.nan),
        )


AnyJoint: TypeAlias = Anchors | Excursion
"""One degree of freedom that two tendons pull on."""
