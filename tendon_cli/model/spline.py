"""Smooth curves over the angle of a joint: cubic splines, of which all derivatives that are used are of one curve.

A value whose slope came from another curve would not close the balance of energy.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_cli.model.kinematics import DEAD_CENTRE, Array, Real, Travels


class Spline:
    """A piecewise cubic: `coefficients` (4, pieces), highest power first, from each of the ascending `knots` on."""

    def __init__(self, knots: Array, coefficients: Array) -> None:
        self.knots, self.coefficients = knots, coefficients

    def __call__(self, angle: Real, derivative: int = 0) -> Array:
        """Values, or derivatives, at angles (rad), of their shape; beyond the ends the last piece goes on."""
        at = np.asarray(angle)  # may be complex, for derivatives
        piece = np.clip(np.searchsorted(self.knots, at.real, side="right") - 1, 0, len(self.knots) - 2)
        from_knot, total = at - self.knots[piece], np.zeros(at.shape)
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
        least = DEAD_CENTRE * (np.ptp(self.flexor.coefficients[3]) + np.ptp(self.extensor.coefficients[3]))
        balances = (flexor_arm > least) & (extensor_arm > least)
        return Travels(
            flexor_travel=np.asarray(self.scale * (self.flexor(angle) - self.flexor(self.origin))),
            extensor_travel=np.asarray(self.scale * (self.extensor(angle) - self.extensor(self.origin))),
            flexor_moment_arm=flexor_arm,
            extensor_moment_arm=extensor_arm,
            flexor_moment_arm_slope=along(self.flexor, 2),
            extensor_moment_arm_slope=along(self.extensor, 2),
            pulling_arm=np.where(balances, flexor_arm, np.nan),
        )
