"""A body and the arm on it that a suit is put on.

The paper's one arm is taken as that of a mean man; on another body each anchor moves with the
dimension that it lies along or around, and weight and lever of forearm and hand follow from the
body itself. All arguments broadcast; lengths in metres, masses in kilograms.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from tendon_cli.model.kinematics import Array, Real

FOREARM_MASS_SHARE = 0.022
"""Mass of forearm and hand over that of the body (Winter 2009, Table 4.1)."""

FOREARM_COM_SHARE = 0.682
"""Distance of their centre from the elbow over the length from elbow to ulnar styloid (Winter 2009,
Table 4.1)."""


@dataclass(frozen=True, eq=False)
class Body:
    """Measures of a person by tape and scale; scalars or arrays of one shape."""

    stature: Real
    """Body height, m; no part of the arm follows from it."""
    weight: Real
    """Body mass, kg."""
    acromion_radiale_length: Real
    """Shoulder to elbow, m."""
    radiale_stylion_length: Real
    """Elbow to wrist, m."""
    forearm_grip_length: Real
    """Elbow to the centre of a held rod, m."""
    biceps_circumference: Real
    """Around the flexed upper arm, m."""
    forearm_circumference: Real
    """Around the flexed forearm, m."""
    wrist_circumference: Real
    """Around the wrist, m; no part of the arm follows from it."""


DIMENSIONS = tuple(field.name for field in fields(Body))

ANCHOR_ALONG = {
    "a1": "biceps_circumference",
    "b1": "acromion_radiale_length",
    "a2": "forearm_circumference",
    "b2": "radiale_stylion_length",
    "elbow_radius": "forearm_circumference",
}
"""Dimension of the body to which each of `Anchors` is in proportion."""


def anchor_scales(body: Body, reference: Body) -> dict[str, Array]:
    """Return the ratio of each of `Anchors` on a body to that on the reference.

    Args:
        body: Body that wears the suit.
        reference: Body for which the suit was drawn.
    """
    return {
        anchor: np.asarray(np.divide(getattr(body, dimension), getattr(reference, dimension)))
        for anchor, dimension in ANCHOR_ALONG.items()
    }


def forearm_mass(body: Body) -> Array:
    """Mass of forearm and hand, kg."""
    return np.asarray(np.multiply(FOREARM_MASS_SHARE, body.weight))


def forearm_com(body: Body) -> Array:
    """Distance of the centre of mass of forearm and hand from the elbow, m."""
    return np.asarray(np.multiply(FOREARM_COM_SHARE, body.radiale_stylion_length))


def load_distance(body: Body) -> Array:
    """Distance of a held load from the elbow, m."""
    return np.asarray(body.forearm_grip_length, dtype=np.float64)
