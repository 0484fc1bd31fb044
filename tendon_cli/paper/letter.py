"""The letter of the paper where tendon departs from it. NOTHING HERE IS USED for any result.

These formulas stand as they are printed, only to be run beside the reading that is used and to show where they fail
(`slips.py`). The reading itself is in `tendon_cli.model`; docs/physics.md compares the two.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tendon_cli.model import statics
from tendon_cli.model.actuator import couple
from tendon_cli.model.design import Design

Array = npt.NDArray[np.float64]
Truth = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Tensions:
    """Distal tensions by the letter, N, in the shape of designs, directions and elbow angles."""

    flexor: Array
    extensor: Array


def eq_12_as_printed(design: Design, elbow_angle: Array, flexion: Truth) -> Tensions:
    """Eq. 12 with its printed right side, η H_f + H_e, where the reading used has H_e - η H_f; all else equal."""
    motion, _, _, tied = couple(design, elbow_angle, flexion)
    printed = replace(tied, mismatch=np.asarray(design.ratio * motion.flexor_travel + motion.extensor_travel))
    balance = statics.solve(printed, design.flexor.pretension, design.extensor.pretension, unilateral=False)
    return Tensions(balance.flexor, balance.extensor)


def eq_11_first(design: Design, elbow_angle: Array, flexion: Truth) -> Tensions:
    """Eqs. 17 to 20 with the motor torque of Eq. 11, which leaves the extensor out of the elbow's balance.

    τ_m / R_f = τ_a / (J α_t) is given; Eq. 20 then has both proximal tensions. The right side of Eq. 12 is that of the
    reading used, so that this slip is seen by itself.
    """
    _, flexor, extensor, tied = couple(design, elbow_angle, flexion)
    pull = tied.elbow_torque / (tied.moment_arm * flexor.capstan)
    xi_t, xi_r = tied.flexor_compliance * flexor.capstan, tied.extensor_compliance * extensor.capstan
    pretensioned = (
        design.ratio * tied.flexor_compliance * design.flexor.pretension
        + tied.extensor_compliance * design.extensor.pretension
    )
    right = tied.mismatch + pretensioned
    at_motor = (right - design.ratio * xi_t * pull) / (np.square(design.ratio) * xi_t + xi_r)
    return Tensions((pull + design.ratio * at_motor) * flexor.capstan, at_motor * extensor.capstan)


def eq_3_as_labelled(flexor_travel: float, extensor_travel: float) -> float:
    """R_e / R_f for no slack as Eq. 3 prints it, H_f / H_e."""
    return flexor_travel / extensor_travel


def normal_force(tension: float, curvature: float, length: float, friction: float) -> float:
    """|N_o| by Eq. A.9 as printed, F κ ds + |N_o| - μ |N_o| κ ds / 2 = 0: the force that presses on the sheath, N."""
    return -tension * curvature * length / (1.0 - friction * curvature * length / 2.0)


def transmitted(friction: float, bend_angle: float, steps: int = 100_000) -> float:
    """F_o / F_I by Eqs. A.8 and A.9 as printed, element by element along a sheath of length 1."""
    tension, step = 1.0, 1.0 / steps
    for _ in range(steps):
        pressed = normal_force(tension, bend_angle, step, friction)
        tension += pressed * (bend_angle * step / 2.0 + friction)
    return tension
