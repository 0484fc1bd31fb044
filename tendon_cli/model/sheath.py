"""A tendon in a curved sheath with Coulomb friction (Eqs. 6 and 13, Appendix A).

Along the sheath dF/ds = σ μ κ F, where σ is -1 for a tendon that is pulled toward the motor and +1
for one that is dragged toward the elbow. For the ratio of the tensions only the total curvature
φ = ∫κ ds matters (Eq. A.17), whatever the route in three dimensions; the elongation (Eq. 13)
supposes that the curvature is spread evenly along the sheath. The rest of the model takes only
`Sheathed` from here: nothing else knows μφ.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from tendon_cli.model.design import Side
from tendon_cli.model.kinematics import Array, Flag, Real

_LEAST_EXPONENT = 1e-100
"""Magnitude of z below which (e^z - 1)/z is 1 + z/2: complex numbers so small cannot be divided."""
_SERIES_BELOW = 0.3
"""Magnitude of the exponent below which the slope of the elongation is summed as a series."""
_TERMS = 14
"""Terms of that series; they leave 1e-17 of the slope."""

TOWARD_MOTOR = -1.0
TOWARD_ELBOW = 1.0


def capstan_ratio(friction: Real, bend_angle: Real, toward: Real) -> Array:
    """Return the ratio of distal to proximal tension, e^{σμφ} (Eqs. 6 and A.17).

    Args:
        friction: μ.
        bend_angle: φ, rad.
        toward: σ, TOWARD_MOTOR or TOWARD_ELBOW.
    """
    return np.exp(np.multiply(np.multiply(toward, friction), bend_angle))


def relative_elongation(exponent: Any) -> Any:
    """Return (e^z - 1)/z, the elongation of a tendon over that without friction.

    It is 1 in the limit z → 0. With z = σμφ it is per proximal tension, with z = -σμφ per distal
    tension (Eq. 13, β/L).

    Args:
        exponent: z, of any shape.
    """
    if hasattr(exponent, "elongation"):  # a series, in proofs
        return exponent.elongation()
    z = np.asarray(exponent)
    is_limit = np.abs(z) < _LEAST_EXPONENT
    with np.errstate(invalid="ignore"):
        divisor = np.where(is_limit, 1.0, z)
        return np.where(is_limit, 1.0 + z / 2.0, np.expm1(divisor) / divisor)


def tendon_compliance(
    length: Real,
    diameter: Real,
    youngs_modulus: Real,
    friction: Real,
    bend_angle: Real,
    toward: Real,
) -> Array:
    """Return the elongation of a round tendon per newton at its distal end (Eq. 13), m/N.

    Args:
        length: L, m.
        diameter: d, m.
        youngs_modulus: E, Pa.
        friction: μ.
        bend_angle: φ, rad.
        toward: σ, TOWARD_MOTOR or TOWARD_ELBOW.
    """
    area = np.pi * np.square(diameter) / 4.0
    exponent = np.multiply(np.multiply(-np.asarray(toward), friction), bend_angle)
    compliance: Array = length / (area * youngs_modulus) * relative_elongation(exponent)
    return compliance


def elongation_slope(exponent: Real) -> Array:
    """Return the derivative of `relative_elongation`, (e^z - (e^z - 1)/z)/z.

    It is 1/2 in the limit z → 0.

    Args:
        exponent: z, of any shape.
    """
    z = np.asarray(exponent)
    is_near_limit = np.abs(z) < _SERIES_BELOW
    if is_near_limit.all():
        return _slope_near_limit(z)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.asarray((np.exp(z) - relative_elongation(z)) / z)
    if is_near_limit.any():
        slope = np.where(is_near_limit, _slope_near_limit(z), slope)
    return slope


def _slope_near_limit(z: Array) -> Array:
    """Return the slope of the elongation as a series, Σ n z^(n-1)/(n+1)!."""
    series = np.zeros(z.shape)
    for term in range(_TERMS, 0, -1):
        series = 1.0 + series * z * (term + 1) / (term * (term + 2))
    return np.asarray(0.5 * series)


@dataclass(frozen=True, eq=False)
class Sheathed:
    """A tendon in its sheath with spring and anchor, in a direction and at angles of the joint."""

    capstan: Array
    """Distal over proximal tension."""
    tendon: Array
    """Elongation of the tendon per distal newton, m/N."""
    spring: Array
    """Extension of the spring per distal newton: 1 / K_SE at the joint, e^(-σμφ) / K_SE at the
    motor, m/N."""
    anchor: Array
    """Displacement of the tissue behind the anchor per newton, 1 / K_t, m/N."""
    at_motor: Flag = False
    """True where the spring sits at the motor's end, else at the joint's."""
    exponent_rate: Real = 0.0
    """Derivative of `exponent` by θ, -σμ dφ/dθ; 0 unless the bend follows the joint."""

    @cached_property
    def compliance(self) -> Array:
        """Elongation of tendon, spring and anchor per distal newton, c, m/N."""
        return self.tendon + self.spring + self.anchor

    @property
    def is_still(self) -> bool:
        """True if the bend of the sheath stays as it is as the joint turns."""
        return not np.any(self.exponent_rate)

    @cached_property
    def compliance_rate(self) -> Array:
        """Derivative of the compliance by θ, dc/dθ, m/(N rad)."""
        spring_exponent_rate = np.where(self.at_motor, self.exponent_rate, 0.0)
        return np.asarray(self._tendon_rate + self.spring * spring_exponent_rate)

    @cached_property
    def exponent(self) -> Array:
        """Natural logarithm of proximal over distal tension, -σμφ."""
        return np.asarray(-np.log(self.capstan))

    @cached_property
    def _tendon_rate(self) -> Array:
        """Derivative of `tendon` by θ, m/(N rad)."""
        if self.is_still:
            return np.zeros(())
        share = elongation_slope(self.exponent) / relative_elongation(self.exponent)
        return np.asarray(self.tendon * share * self.exponent_rate)

    @cached_property
    def strain(self) -> Array:
        """Twice the tendon's strain energy over T², ∫ (F/T)² ds / AE, m/N; T is the distal tension.

        With F = T e^(as/L) from the elbow on it is L/(AE) (e^(2a) - 1)/(2a), where c_Ten has
        a instead of 2a.
        """
        doubled = self.tendon * relative_elongation(2.0 * self.exponent)
        return np.asarray(doubled / relative_elongation(self.exponent))

    @property
    def _strain_rate(self) -> Array:
        """Derivative of `strain` by θ, m/(N rad)."""
        if self.is_still:
            return np.zeros(())
        slope = 2.0 * elongation_slope(2.0 * self.exponent) * self.exponent_rate
        return np.asarray(self.tendon * slope / relative_elongation(self.exponent))

    @property
    def _spring_energy(self) -> Array:
        """Twice the spring's energy over the square of the distal tension, m/N."""
        return np.where(self.at_motor, self.spring / self.capstan, self.spring)

    @cached_property
    def energy_compliance(self) -> Array:
        """Twice the energy of tendon, spring and anchor over the distal tension squared, m/N."""
        return np.asarray(self._spring_energy + self.anchor + self.strain)

    def storage_rate(self, tension: Array, tension_rate: Array, turning: Real = 1.0) -> Array:
        """Return dU/dθ, the rate of the energy that tendon, spring and anchor store, N m.

        Args:
            tension: Distal tension, N.
            tension_rate: Its rate, N/rad; with N/s the result is per second, W.
            turning: Rate of the joint: 1, or its speed in rad/s if rates are per second.
        """
        spring_exponent_rate = np.where(self.at_motor, self.exponent_rate, 0.0)
        rate = self._strain_rate + 2.0 * self._spring_energy * spring_exponent_rate
        return np.asarray(
            self.energy_compliance * tension * tension_rate
            + 0.5 * rate * tension * tension * turning
        )

    def sliding_speeds(
        self, tension: Array, tension_rate: Array, path_rate: Real, turning: Real = 1.0
    ) -> tuple[Array, Array]:
        """Return the speeds toward the motor at which the tendon slides at both ends of the sheath.

        The first is that at the joint, the second that at the motor, m/rad or m/s. Between its ends
        the speed of a tendon is monotone. Arguments are those of `friction_rate`.
        """
        give_at_joint = self.anchor + np.where(self.at_motor, 0.0, self.spring)
        at_joint = np.asarray(path_rate + give_at_joint * tension_rate)
        stretching = self.tendon * tension_rate
        if not self.is_still:
            stretching = stretching + self._tendon_rate * tension * turning
        return at_joint, np.asarray(at_joint + stretching)

    def friction_rate(
        self, tension: Array, tension_rate: Array, path_rate: Real, turning: Real = 1.0
    ) -> Array:
        """Return ∫ dF/ds du/dθ ds over the sheath, the rate of the work that friction takes, N m.

        The path outside of the sheath shortens by `path_rate`, so that the tendon moves toward the
        motor by that and by the give at the joint's end. Further along it moves faster by dT/dθ
        w(s), w the elongation from the joint to s per newton, so that the integral is (e^a - 1) T
        sliding + T dT/dθ ∫ (dF/ds)/T w ds; by parts the last one is e^a c_Ten less `strain`. A bend
        that follows the joint adds T² (e^a dc_Ten/dθ - dstrain/dθ / 2).

        Args:
            tension: Distal tension T, N.
            tension_rate: dT/dθ, N/rad; with N/s the result is per second, W.
            path_rate: Shortening of the path outside of the sheath, m/rad or m/s.
            turning: Rate of the joint: 1, or its speed in rad/s if rates are per second.
        """
        proximal = 1.0 / self.capstan  # tension over distal tension
        give_at_joint = self.anchor + np.where(self.at_motor, 0.0, self.spring)
        sliding = path_rate + give_at_joint * tension_rate
        bending = (proximal * self._tendon_rate - 0.5 * self._strain_rate) * turning
        along = tension_rate * (proximal * self.tendon - self.strain) + tension * bending
        return np.asarray(tension * ((proximal - 1.0) * sliding + along))


def sheath_of(side: Side, toward: Real, angle: Real) -> Sheathed:
    """Return capstan ratio and distal compliances of a side (Eqs. 6 and 13).

    Args:
        side: Tendon, sheath, spring and anchor.
        toward: σ, TOWARD_MOTOR or TOWARD_ELBOW.
        angle: Angles of the joint, rad.
    """
    bend, bend_rate = side.bend(angle)
    capstan = capstan_ratio(side.friction, bend, toward)
    spring = np.divide(1.0, side.spring_stiffness)
    if np.any(side.spring_at_motor):
        spring = np.where(side.spring_at_motor, spring / capstan, spring)
    return Sheathed(
        capstan=capstan,
        tendon=tendon_compliance(
            side.length, side.diameter, side.youngs_modulus, side.friction, bend, toward
        ),
        spring=spring,
        anchor=np.divide(1.0, side.anchor_stiffness),
        at_motor=side.spring_at_motor,
        exponent_rate=np.multiply(np.multiply(-np.asarray(toward), side.friction), bend_rate),
    )


def sheaths_of(
    flexor: Side, extensor: Side, angle: Real, flexion: Flag
) -> tuple[Sheathed, Sheathed]:
    """Return the sheaths of flexor and extensor.

    In flexion the flexor is pulled toward the motor and the extensor dragged toward the elbow.

    Args:
        flexor: Side of the flexor.
        extensor: Side of the extensor.
        angle: Angles of the joint, rad.
        flexion: True in flexion, else extension.
    """
    pulled = np.where(flexion, TOWARD_MOTOR, TOWARD_ELBOW)
    return sheath_of(flexor, pulled, angle), sheath_of(extensor, -pulled, angle)


def unloaded_sheaths(flexor: Side, extensor: Side, angle: Real) -> tuple[Sheathed, Sheathed]:
    """Return the sheaths of flexor and extensor without friction, whichever way they slide.

    Their compliances give each tendon one natural length: that at which F0 stretches it in a sheath
    without friction. With the compliance of the direction (Eq. 13) the length would change in a
    turn, by 0.2 mm in the baseline and by more where friction is high and the tendon thin.

    Args:
        flexor: Side of the flexor.
        extensor: Side of the extensor.
        angle: Angle of the joint at which the pretension is set, rad.
    """
    smooth = (replace(flexor, friction=0.0), replace(extensor, friction=0.0))
    return sheaths_of(*smooth, angle, flexion=True)
