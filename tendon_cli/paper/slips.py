"""Where the paper as printed fails: each slip is run as it is printed, and compared with the reading used.

NOTHING of what is printed is used for any result: the reading is in `tendon_cli.model`; docs/physics.md compares them.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from tendon_cli.model import statics
from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.paper.runs import SIDES, Array, Paper, PaperTables, apart
from tendon_cli.paper.statements import Check, Evidence

_TAUT, _FAR_ABOVE = 0.0, 1.5
_NEGATIVE = -500.0
"""N; no study of the paper comes near it."""

Flags = npt.NDArray[np.bool_]
Tensions = tuple[Array, Array]
"""Distal tensions of flexor and extensor by equations as printed, N: designs, directions, elbow angles."""


def _eq_12(paper: Paper) -> Evidence:
    run = paper["fig07"]
    at, sides = run.places(load_mass=5.0), np.array(eq_12_as_printed(*run.inputs()))
    ends, lowest, ours = (
        sides[:, at, 0][..., [0, -1]].reshape(2, 2),
        sides.min(),
        _least_extensor(run).min(),
    )
    return (
        [lowest > _TAUT and (ends[:, 1] / ends[:, 0]).min() > _FAR_ABOVE and ours < 0.0],
        lowest,
        *ends.ravel(),
        ours,
    )


def _eq_11(paper: Paper) -> Evidence:
    run = paper["fig07"]
    flexor, extensor = np.array(eq_11_first(*run.inputs()))[:, run.places(load_mass=0.0)][:, 0]
    share, used = (
        apart(np.array([flexor, extensor])).max(),
        run.apart("tension_distal", load_mass=0.0).max(),
    )
    ours = run.line("flexor_tension_distal", load_mass=0.0)
    rises = flexor[0, 1] > flexor[0, 0] and extensor[0, 1] < extensor[0, 0]
    return (
        [rises and share > 10.0 and ours[1] < ours[0]],
        flexor[0, :2],
        extensor[0, :2],
        share,
        ours[:2],
        used,
    )


def _labels(paper: Paper) -> Evidence:
    flexor, extensor = (float(paper["fig04"].line(f"{side}_travel")[-1]) for side in SIDES)
    printed, used = flexor / extensor, extensor / flexor
    missed = [abs(1e3 * (extensor - ratio * flexor)) for ratio in (printed, used)]
    return [missed[0] > 1.0 > missed[1] and printed > 1.0 > used], printed, used, *missed


def _reference(paper: Paper) -> Evidence:
    at_zero = 1e3 * float(paper["fig07"].line("flexor_travel", load_mass=0.0)[0])
    ratio, better = (paper[name].travel_ratio() for name in ("fig04", "fig04-initial"))
    zero = np.interp(0.0, paper["fig04"].line("flexor_travel"), paper["fig04"].degrees)
    return [at_zero < -0.1 and ratio[0] < 0.0 < better[0]], at_zero, ratio[0], zero, better[0]


def _stiffness(paper: Paper) -> Evidence:
    with_30, with_3 = (_least_extensor(paper[name]) for name in ("fig06-30kN", "fig06"))
    return [with_30.max() < _NEGATIVE < with_3.min()], with_30, with_3, paper["fig06"].loads


def _least_extensor(run: PaperTables) -> Array:
    return run.least("extensor_tension_distal")


def _a_9(_: Paper) -> Evidence:
    friction, bend = 0.07, math.pi
    pressed = normal_force(100.0, bend / 2.0, 1e-3, friction)
    passed, exact = transmitted(friction, bend), math.exp(-friction * bend)
    return [pressed < 0.0 and abs(passed - exact) < 1e-3], pressed, passed, exact


def _wrap_angle(paper: Paper) -> Evidence:
    by_pi, ours = (
        [fit.by_direction[way].friction for way in ("toward_motor", "toward_load")]
        for fit in (paper.fit_at_pi, paper.fit)
    )
    return [max(by_pi) < 0.065 and min(ours) > 0.07], by_pi, ours


# --- Equations as they are printed ------------------------------------------------------------------------------------


def eq_12_as_printed(design: Design, elbow_angle: Array, flexion: Flags) -> Tensions:
    """Eq. 12 with its printed right side, η H_f + H_e, where the reading used has H_e - η H_f; all else equal."""
    at = State.of(design, elbow_angle, flexion)
    motion, tied = at.motion, at.coupling
    printed = replace(
        tied, mismatch=np.asarray(design.ratio * motion.flexor_travel + motion.extensor_travel)
    )
    balance = statics.solve(
        printed, design.flexor.pretension, design.extensor.pretension, unilateral=False
    )
    return balance.flexor, balance.extensor


def eq_11_first(design: Design, elbow_angle: Array, flexion: Flags) -> Tensions:
    """Eqs. 17 to 20 with the motor torque of Eq. 11, which leaves the extensor out of the elbow's balance.

    τ_m / R_f = τ_a / (J α_t) is given; Eq. 20 then has both proximal tensions. The right side of Eq. 12 is that of the
    reading used, so that this slip is seen by itself.
    """
    at = State.of(design, elbow_angle, flexion)
    flexor, extensor, tied = at.flexor, at.extensor, at.coupling
    pull = tied.elbow_torque / (tied.moment_arm * flexor.capstan)
    xi_t, xi_r = (
        tied.flexor_compliance * flexor.capstan,
        tied.extensor_compliance * extensor.capstan,
    )
    pretensioned = (
        design.ratio * tied.flexor_compliance * design.flexor.pretension
        + tied.extensor_compliance * design.extensor.pretension
    )
    right = tied.mismatch + pretensioned
    at_motor = (right - design.ratio * xi_t * pull) / (np.square(design.ratio) * xi_t + xi_r)
    return (pull + design.ratio * at_motor) * flexor.capstan, at_motor * extensor.capstan


def normal_force(tension: float, curvature: float, length: float, friction: float) -> float:
    """|N_o| by Eq. A.9 as printed, F κ ds + |N_o| - μ |N_o| κ ds / 2 = 0: the force that presses on the sheath, N."""
    return -tension * curvature * length / (1.0 - friction * curvature * length / 2.0)


def transmitted(friction: float, bend_angle: float, steps: int = 100_000) -> float:
    """F_o / F_I by Eqs. A.8 and A.9 as printed, element by element along a sheath of length 1."""
    step = 1.0 / steps
    gain = 1.0 + normal_force(1.0, bend_angle, step, friction) * (
        bend_angle * step / 2.0 + friction
    )
    return float(gain**steps)


SLIPS: dict[str, Check] = {
    "S1": _eq_12,
    "S2": _eq_11,
    "S3": _labels,
    "S4": _reference,
    "S5": _stiffness,
    "S6": _a_9,
    "S7": _wrap_angle,
}
