"""What a design is: the arm that wears it, two tendons in sheaths with springs, and a motor's spool.

All fields are scalars or arrays that broadcast against each other. SI units, angles in radians.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Anchors, Flag, Real


@dataclass(frozen=True, eq=False)
class Limb:
    """The arm, its anchors and its weight."""

    anchors: Anchors
    forearm_mass: Real
    """Mass of forearm and hand, kg."""
    forearm_com: Real
    """Distance of its centre from the elbow, m."""
    load_distance: Real
    """Distance of the load from the elbow, m."""
    upper_arm_angle: Real
    """ψ, inclination of the upper arm, forward positive, rad."""
    contact_width: Real = np.nan
    """Width of the extensor's strap around the elbow, m."""


@dataclass(frozen=True, eq=False)
class Side:
    """One tendon with its sheath and its series spring."""

    friction: Real
    """μ."""
    bend_angle: Real
    """φ = ∫κ ds, rad."""
    length: Real
    """L, m."""
    diameter: Real
    """d, m."""
    youngs_modulus: Real
    """E, Pa."""
    spring_stiffness: Real
    """K_SE, N/m."""
    pretension: Real
    """F0, distal tension before motion, N."""


@dataclass(frozen=True, eq=False)
class Design:
    """Everything that a state depends on besides elbow angle and direction."""

    arm: Limb
    flexor: Side
    extensor: Side
    flexor_radius: Real
    """R_m^f, m."""
    ratio: Real
    """η = R_m^e / R_m^f."""
    load_mass: Real
    """kg."""
    from_initial: Flag = False
    """Measure the flexor's travel from L_c(0) instead of b1 + b2."""
    unilateral: Flag = True
    """A tendon cannot push; otherwise the paper's bilateral model."""
    given: Mapping[str, Real] = field(default_factory=dict)
    """Numbers that a limit alone needs, by key (`limits.GIVEN`); what a side may have of its own is the flexor's."""


Made = TypeVar("Made")


def changed(made: Made, change: Callable[[npt.NDArray[Any]], npt.NDArray[Any]]) -> Made:
    """A design, or what is made of one, with each of its arrays changed; numbers are left as they are."""

    def anew(value: Any) -> Any:
        if isinstance(value, np.ndarray):
            return change(value) if value.ndim else value
        if isinstance(value, Mapping):
            return {key: anew(each) for key, each in value.items()}
        return changed(value, change) if is_dataclass(value) else value

    return type(made)(**{each.name: anew(getattr(made, each.name)) for each in fields(made)})  # type: ignore[arg-type]
