"""What sheathed tendons and their springs do to tension, per side and direction (Eqs. 6 and 13)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_cli.model import sheath
from tendon_cli.model.design import Design, Side
from tendon_cli.model.kinematics import Array, Flag, Real


@dataclass(frozen=True, eq=False)
class Transmission:
    """What a sheathed tendon and its spring do to distal tension, per side and direction."""

    capstan: Array
    """Distal over proximal tension."""
    tendon: Array
    """Elongation of the tendon per distal newton, m/N."""
    spring: Array
    """1 / K_SE, m/N."""

    @property
    def compliance(self) -> Array:
        """c, elongation of tendon and spring per distal newton, m/N."""
        return np.asarray(self.tendon + self.spring)


def transmission(side: Side, toward: Real) -> Transmission:
    """Capstan ratio and distal compliances of one side (Eqs. 6 and 13); `toward` is σ of `sheath`."""
    return Transmission(
        capstan=sheath.capstan_ratio(side.friction, side.bend_angle, toward),
        tendon=sheath.tendon_compliance(
            side.length, side.diameter, side.youngs_modulus, side.friction, side.bend_angle, toward
        ),
        spring=np.asarray(1.0 / np.asarray(side.spring_stiffness)),
    )


def transmissions(design: Design, flexion: Flag) -> tuple[Transmission, Transmission]:
    """Flexor and extensor. In flexion the flexor is pulled toward the motor, the extensor dragged toward the elbow."""
    pulled = np.where(flexion, sheath.TOWARD_MOTOR, sheath.TOWARD_ELBOW)
    return transmission(design.flexor, pulled), transmission(design.extensor, -pulled)
