"""A tendon in a curved sheath with Coulomb friction (Eqs. 6 and 13, Appendix A).

Along the sheath dF/ds = σ μ κ F, where σ is -1 for a tendon that is pulled toward the motor and +1 for one that is
dragged toward the elbow. For the ratio of the tensions only the total curvature φ = ∫κ ds matters (Eq. A.17), whatever
the route in three dimensions; the elongation (Eq. 13) supposes that the curvature is spread evenly along the sheath.
`Sheathed` is all that the model asks of one: nobody else knows μφ.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tendon_cli.model.design import Side
from tendon_cli.model.kinematics import Array, Flag, Real

_SERIES_BELOW, _TERMS = 0.3, 14  # leaves 1e-17 of the derivative

TOWARD_MOTOR = -1.0
TOWARD_ELBOW = 1.0


def capstan_ratio(friction: Real, bend_angle: Real, toward: Real) -> Array:
    """Distal over proximal tension, e^{σμφ} (Eqs. 6 and A.17); `toward` is σ."""
    return np.exp(np.multiply(np.multiply(toward, friction), bend_angle))


def relative_elongation(exponent: Any) -> Any:
    """(e^z - 1)/z, the elongation of a tendon over that without friction; 1 in the limit z → 0.

    With z = σμφ it is per proximal tension, with z = -σμφ per distal tension (Eq. 13, β/L).
    """
    if hasattr(exponent, "elongation"):  # of series, in proofs
        return exponent.elongation()
    z = np.asarray(exponent)
    with np.errstate(invalid="ignore"):
        return np.where(z == 0.0, 1.0, np.expm1(z) / z)


def tendon_compliance(
    length: Real,
    diameter: Real,
    youngs_modulus: Real,
    friction: Real,
    bend_angle: Real,
    toward: Real,
) -> Array:
    """Elongation of a round tendon per newton at its distal end (Eq. 13), m/N."""
    area = np.pi * np.square(diameter) / 4.0
    exponent = np.multiply(np.multiply(-np.asarray(toward), friction), bend_angle)
    compliance: Array = length / (area * youngs_modulus) * relative_elongation(exponent)
    return compliance


def elongation_slope(exponent: Real) -> Array:
    """Derivative of `relative_elongation`: (e^z - (e^z - 1)/z)/z, 1/2 in the limit z → 0."""
    z = np.asarray(exponent)
    series = np.zeros(z.shape)
    for term in range(_TERMS, 0, -1):  # Σ n z^(n-1)/(n+1)!
        series = 1.0 + series * z * (term + 1) / (term * (term + 2))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(
            np.abs(z) < _SERIES_BELOW, 0.5 * series, (np.exp(z) - relative_elongation(z)) / z
        )


@dataclass(frozen=True, eq=False)
class Sheathed:
    """What a sheathed tendon, its spring and its anchor do to tension, in a direction and at the joint's angles."""

    capstan: Array
    """Distal over proximal tension."""
    tendon: Array
    """Elongation of the tendon per distal newton, m/N."""
    spring: Array
    """Extension of the spring per distal newton: 1 / K_SE at the joint, e^(-σμφ) / K_SE at the motor, m/N."""
    anchor: Array
    """1 / K_t, by how much the tissue behind the anchor gives per newton, m/N."""
    at_motor: Flag = False
    """Whether the spring sits at the motor's end, else at the joint's."""
    exponent_rate: Real = 0.0
    """-σμ dφ/dθ, where the bend follows the joint."""

    @cached_property
    def compliance(self) -> Array:
        """c, elongation of tendon, spring and anchor per distal newton, m/N."""
        return self.tendon + self.spring + self.anchor

    @property
    def compliance_rate(self) -> Array:
        """dc/dθ, m/(N rad)."""
        return np.asarray(
            self._tendon_rate + self.spring * np.where(self.at_motor, self.exponent_rate, 0.0)
        )

    @property
    def exponent(self) -> Array:
        """-σμφ: proximal over distal tension is e to that."""
        return np.asarray(-np.log(self.capstan))

    @property
    def _tendon_rate(self) -> Array:
        share = elongation_slope(self.exponent) / relative_elongation(self.exponent)
        return np.asarray(self.tendon * share * self.exponent_rate)

    @property
    def strain(self) -> Array:
        """∫ (F/T)² ds / AE, twice the tendon's strain energy over the square of its distal tension T, m/N.

        With F = T e^(as/L) from the elbow on it is L/(AE) (e^(2a) - 1)/(2a), where c_Ten has a once.
        """
        return np.asarray(
            self.tendon
            * relative_elongation(2.0 * self.exponent)
            / relative_elongation(self.exponent)
        )

    @property
    def _strain_rate(self) -> Array:
        slope = 2.0 * elongation_slope(2.0 * self.exponent) * self.exponent_rate
        return np.asarray(self.tendon * slope / relative_elongation(self.exponent))

    @property
    def _spring_energy(self) -> Array:
        return np.where(self.at_motor, self.spring / self.capstan, self.spring)

    @property
    def gives(self) -> Array:
        """Twice the energy that tendon, spring and anchor store over the square of the distal tension, m/N."""
        return np.asarray(self._spring_energy + self.anchor + self.strain)

    def storing(self, tension: Array, tension_rate: Array, turning: Real = 1.0) -> Array:
        """dU/dθ of the energy that they store, by the distal tension and its rate (N, N/rad), N m.

        Per second if the rate is and the joint turns by `turning` (rad/s).
        """
        rate = self._strain_rate + 2.0 * self._spring_energy * np.where(
            self.at_motor, self.exponent_rate, 0.0
        )
        return np.asarray(
            self.gives * tension * tension_rate + 0.5 * rate * tension * tension * turning
        )

    def friction_rate(
        self, tension: Array, tension_rate: Array, path_rate: Real, turning: Real = 1.0
    ) -> Array:
        """∫ dF/ds du/dθ ds over the sheath: what friction takes, N m, by the distal tension T and its rate (N, N/rad).

        The path outside of the sheath shortens by `path_rate` (m/rad), so that the tendon moves toward the motor by
        that and by what gives at the joint's end. Further along it moves faster by dT/dθ w(s), w the elongation from
        the joint to s per newton, so that the integral is (e^a - 1) T slides + T dT/dθ ∫ (dF/ds)/T w ds; by parts the
        last one is e^a c_Ten less `strain`. A bend that follows the joint adds T² (e^a dc_Ten/dθ - dstrain/dθ / 2).
        """
        near = 1.0 / self.capstan
        slides = (
            path_rate + (self.anchor + np.where(self.at_motor, 0.0, self.spring)) * tension_rate
        )
        bending = (near * self._tendon_rate - 0.5 * self._strain_rate) * turning
        along = tension_rate * (near * self.tendon - self.strain) + tension * bending
        return np.asarray(tension * ((near - 1.0) * slides + along))


def sheath_of(side: Side, toward: Real, angle: Real) -> Sheathed:
    """Capstan ratio and distal compliances of a side (Eqs. 6 and 13) at angles of the joint; `toward` is σ."""
    bend, bend_rate = side.bend(angle)
    capstan = capstan_ratio(side.friction, bend, toward)
    softness = np.divide(1.0, side.spring_stiffness)
    return Sheathed(
        capstan=capstan,
        tendon=tendon_compliance(
            side.length, side.diameter, side.youngs_modulus, side.friction, bend, toward
        ),
        spring=np.where(side.spring_at_motor, softness / capstan, softness)
        if np.any(side.spring_at_motor)
        else softness,
        anchor=np.divide(1.0, side.anchor_stiffness),
        at_motor=side.spring_at_motor,
        exponent_rate=np.multiply(np.multiply(-np.asarray(toward), side.friction), bend_rate),
    )


def sheaths_of(
    flexor: Side, extensor: Side, angle: Real, flexion: Flag
) -> tuple[Sheathed, Sheathed]:
    """Flexor and extensor. In flexion the flexor is pulled toward the motor, the extensor dragged toward the elbow."""
    pulled = np.where(flexion, TOWARD_MOTOR, TOWARD_ELBOW)
    return sheath_of(flexor, pulled, angle), sheath_of(extensor, -pulled, angle)
