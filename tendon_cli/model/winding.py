"""The shortest extension spring that can be wound for a stiffness and a force.

A coil of wire d and mean diameter D = C d is stressed by τ = 8 F C K_w / (π d²), with Wahl's
factor K_w = (4C - 1)/(4C - 4) + 0.615/C. Music wire bears 0.45 of its tensile strength A d^-m in a
spring that is stretched often (Shigley, Mechanical Engineering Design, 10-4 and table 10-4). The
stiffness asks for n = G d / (8 C³ k) coils. Unloaded, n + 1 coils touch, and each hook is as long
as the inner diameter: L = (n + 1) d + 2 (C - 1) d.
"""

from __future__ import annotations

import numpy as np

from tendon_cli.model.kinematics import Array, Real

_STRENGTH = 2211e6
"""Tensile strength A of music wire of 1 mm, Pa."""
_EXPONENT = 0.145
"""Exponent m by which thicker wire is weaker."""
_SHARE = 0.45
"""Share of the tensile strength that the wire bears in torsion."""
_SHEAR_MODULUS = 79.3e9
"""Shear modulus G of music wire, Pa."""
_INDICES = np.linspace(4.0, 20.0, 321)
"""Ratios C of the coil's mean diameter to the wire's that can be wound."""
MOST_TRAVEL = 1.2
"""Largest travel of an extension spring, as a multiple of its unloaded length."""


def least_free_length(stiffness: Real, force: Real) -> Array:
    """Return the shortest unloaded length of a spring, hooks included, m; 0 for a rigid one.

    Args:
        stiffness: Stiffness, N/m.
        force: Largest force, N.
    """
    rate = np.asarray(stiffness, dtype=np.float64)[..., np.newaxis]
    load = np.asarray(force, dtype=np.float64)[..., np.newaxis]
    index = _INDICES
    wahl = (4.0 * index - 1.0) / (4.0 * index - 4.0) + 0.615 / index
    strength_per_diameter = _SHARE * _STRENGTH * 1e-3**_EXPONENT  # at 1 m, Pa m^m
    diameter = (8.0 * load * index * wahl / (np.pi * strength_per_diameter)) ** (
        1.0 / (2.0 - _EXPONENT)
    )
    coils = _SHEAR_MODULUS * diameter / (8.0 * index**3 * rate)
    length = (coils + 1.0) * diameter + 2.0 * (index - 1.0) * diameter
    shortest = length.min(axis=-1)
    return np.where(np.isinf(rate[..., 0]), 0.0, shortest)
