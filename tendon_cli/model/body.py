"""The body of a wearer, and the measures of the arm that follow from it.

The arm of the paper is taken as that of an average man. On another body each anchor scales with the
dimension that it lies along or around, and mass and centre of mass of forearm and hand follow from
the body itself. All arguments broadcast; lengths in metres, masses in kilograms.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from tendon_cli.model.kinematics import Array, Real

FOREARM_MASS_SHARE = 0.022
"""Mass of forearm and hand as a share of body mass (Winter 2009, Table 4.1)."""

FOREARM_COM_SHARE = 0.682
"""Distance of their centre of mass from the elbow, as a share of the length from elbow to ulnar
styloid (Winter 2009, Table 4.1)."""


@dataclass(frozen=True, eq=False)
class Body:
    """Measures of a person by tape and scale; scalars or arrays of one shape."""

    stature: Real
    """Body height, m; no part of the arm follows from it."""
    weight: Real
    """Body mass, kg."""
    acromion_radiale_length: Real
    """Distance from shoulder to elbow, m."""
    radiale_stylion_length: Real
    """Distance from elbow to wrist, m."""
    forearm_grip_length: Real
    """Distance from elbow to the centre of a held rod, m."""
    biceps_circumference: Real
    """Circumference of the flexed upper arm, m."""
    forearm_circumference: Real
    """Circumference of the flexed forearm, m."""
    wrist_circumference: Real
    """Circumference of the wrist, m; no part of the arm follows from it."""


DIMENSIONS = tuple(field.name for field in fields(Body))

ANCHOR_ALONG = {
    "a1": "biceps_circumference",
    "b1": "acromion_radiale_length",
    "a2": "forearm_circumference",
    "b2": "radiale_stylion_length",
    "elbow_radius": "forearm_circumference",
}
"""Body dimension to which each measure of `Anchors` is proportional."""


def anchor_scales(body: Body, reference: Body) -> dict[str, Array]:
    """Return the ratio of each measure of `Anchors` on a body to that on the reference.

    Args:
        body: Body that wears the suit.
        reference: Body for which the suit was drawn.
    """
    return {
        anchor: np.asarray(np.divide(getattr(body, dimension), getattr(reference, dimension)))
        for anchor, dimension in ANCHOR_ALONG.items()
    }


def arm_volume(body: Body) -> Array:
    """Return l_ar C_bi² + l_rs C_fo², the volume of a cylindrical upper arm and forearm times 4π.

    The passive stiffness of the elbow grows with the volume of the arm (Wiegner & Watts 1986).
    """
    upper_arm = np.multiply(body.acromion_radiale_length, np.square(body.biceps_circumference))
    forearm = np.multiply(body.radiale_stylion_length, np.square(body.forearm_circumference))
    return np.asarray(upper_arm + forearm)


def stiffness_scale(body: Body, reference: Body) -> Array:
    """Return the ratio of the joint's stiffness on a body to that on the reference.

    Args:
        body: Body that wears the suit.
        reference: Body for which the stiffness is stated.
    """
    return np.asarray(arm_volume(body) / arm_volume(reference))


def forearm_mass(body: Body) -> Array:
    """Return the mass of forearm and hand, kg."""
    return np.asarray(np.multiply(FOREARM_MASS_SHARE, body.weight))


def forearm_com(body: Body) -> Array:
    """Return the distance of the centre of mass of forearm and hand from the elbow, m."""
    return np.asarray(np.multiply(FOREARM_COM_SHARE, body.radiale_stylion_length))


def load_distance(body: Body) -> Array:
    """Distance of a held load from the elbow, m."""
    return np.asarray(body.forearm_grip_length, dtype=np.float64)
