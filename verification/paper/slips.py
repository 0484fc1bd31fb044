"""Slips of print and gaps of the paper: each is run as printed, beside the reading used.

No result uses an equation of this module: `tendon_cli.model` has the reading used, and
docs/physics.md compares the two.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from tendon_cli.model import statics
from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.quantities import SIDES
from verification.paper.runs import Paper, PaperTables, relative_difference
from verification.paper.statements import Check, Evidence

_RISE = 1.5
"""Factor of a tension that rises far, against Fig. 7."""
_NEGATIVE = -500.0
"""Tension far below any in a study of the paper, N."""
_VISIBLE = 10.0
"""Deviation that shows in a figure, % of the peak."""
_TOO_SMALL = 0.065
"""Friction coefficient below any that Table A.1 may have meant."""
_AS_PRINTED = 0.07
"""Friction coefficient above which the digits of Table A.1 lie."""

Tensions = tuple[Array, Array]
"""Distal tensions of flexor and extensor by printed equations, (designs, directions, angles), N."""


def _eq_12(paper: Paper) -> Evidence:
    """Judge S1: with Eq. 12 as printed no slack would ever occur."""
    run = paper["fig07"]
    printed = np.array(eq_12_as_printed(*run.inputs()))  # (sides, designs, directions, angles), N
    loaded = printed[:, run.is_selected(load_mass=5.0), 0]
    ends = loaded[..., [0, -1]].reshape(2, 2)  # (sides, first and last angle), N
    lowest = printed.min()
    used = _least_extensor(run).min()
    rises_far = (ends[:, 1] / ends[:, 0]).min() > _RISE
    return [lowest > 0.0 and rises_far and used < 0.0], lowest, *ends.ravel(), used


def _eq_11(paper: Paper) -> Evidence:
    """Judge S2: Eq. 11 first explains Fig. 6, but tensions without load are against Fig. 7."""
    torques = paper["fig06"]
    by_eq_11 = crossings_by_eq_11(torques)
    used_crossings = torques.crossings()
    run = paper["fig07"]
    printed = np.array(eq_11_first(*run.inputs()))  # (sides, designs, directions, angles), N
    flexor, extensor = printed[:, run.is_selected(load_mass=0.0)][:, 0]  # (directions, angles), N
    difference = relative_difference(np.array([flexor, extensor])).max()
    used_difference = run.difference("tension_distal", load_mass=0.0).max()
    used = run.line("flexor_tension_distal", load_mass=0.0)
    rises = flexor[0, 1] > flexor[0, 0] and extensor[0, 1] < extensor[0, 0]
    return (
        [
            rises and difference > _VISIBLE and used[1] < used[0],
            max(by_eq_11) < min(used_crossings),
        ],
        by_eq_11,
        used_crossings,
        torques.loads,
        flexor[0, :2],
        extensor[0, :2],
        difference,
        used[:2],
        used_difference,
    )


def _labels(paper: Paper) -> Evidence:
    """Judge S3: the ratio without slack is the inverse of the one that Eqs. 2 and 3 print."""
    flexor, extensor = (float(paper["fig04"].line(f"{side}_travel")[-1]) for side in SIDES)
    printed = flexor / extensor
    used = extensor / flexor
    missed_as_printed = abs(1e3 * (extensor - printed * flexor))  # mm
    missed_as_used = abs(1e3 * (extensor - used * flexor))  # mm
    holds = missed_as_printed > 1.0 > missed_as_used and printed > 1.0 > used
    return [holds], printed, used, missed_as_printed, missed_as_used


def _reference(paper: Paper) -> Evidence:
    """Judge S4: H_f counts from b₁ + b₂ and not from L_c(0)."""
    at_zero = 1e3 * float(paper["fig07"].line("flexor_travel", load_mass=0.0)[0])  # mm
    published = paper["fig04"].travel_ratio()
    initial = paper["fig04-initial"].travel_ratio()
    zero = np.interp(0.0, paper["fig04"].line("flexor_travel"), paper["fig04"].degrees)
    holds = at_zero < -0.1 and published[0] < 0.0 < initial[0]
    return [holds], at_zero, published[0], zero, initial[0]


def _stiffness(paper: Paper) -> Evidence:
    """Judge S5: only springs of 3 kN/m fit the figures, not those of 30 kN/m."""
    with_30 = _least_extensor(paper["fig06-30kN"])
    with_3 = _least_extensor(paper["fig06"])
    return [with_30.max() < _NEGATIVE < with_3.min()], with_30, with_3, paper["fig06"].loads


def _least_extensor(run: PaperTables) -> Array:
    """Return the least extensor tension at the elbow, by design, N."""
    return run.smallest("extensor_tension_distal")


def _a_9(_: Paper) -> Evidence:
    """Judge S6: Eq. A.9 has a slip of sign, but its result, A.17, stands."""
    friction = 0.07
    bend = math.pi
    pressed = normal_force(100.0, bend / 2.0, 1e-3, friction)
    passed = transmitted(friction, bend)
    exact = math.exp(-friction * bend)
    return [pressed < 0.0 and abs(passed - exact) < 1e-3], pressed, passed, exact


def _wrap_angle(paper: Paper) -> Evidence:
    """Judge S7: the wrap angle that the paper prints does not give its friction coefficients."""
    directions = ("toward_motor", "toward_load")
    by_pi = [paper.fit_at_pi.by_direction[name].friction for name in directions]
    used = [paper.fit.by_direction[name].friction for name in directions]
    return [max(by_pi) < _TOO_SMALL and min(used) > _AS_PRINTED], by_pi, used


# --- Equations as they are printed ---------------------------------------------------------------


def eq_12_as_printed(design: Design, elbow_angle: Array, flexion: Flags) -> Tensions:
    """Solve Eq. 12 with its printed right side, η H_f + H_e; all else as in the reading used.

    The reading used has H_e - η H_f.

    Args:
        design: Designs, ready to broadcast.
        elbow_angle: Elbow angles, rad.
        flexion: True where the joint flexes.
    """
    at = State.of(design, elbow_angle, flexion)
    travels = at.motion
    mismatch = np.asarray(design.ratio * travels.flexor_travel + travels.extensor_travel)
    printed = replace(at.coupling, mismatch=mismatch)
    response = statics.respond(printed, unilateral=False)
    pretension = printed.common_pretension(design.flexor.pretension, design.extensor.pretension)
    balance = statics.Balance(printed, response, pretension)
    return balance.flexor, balance.extensor


def motor_torque_by_eq_11(state: State) -> Array:
    """Return τ_m of Eq. 11 as printed, from the elbow's torque and the flexor alone, N m.

    Args:
        state: States of designs.
    """
    coupling = state.coupling
    arm = coupling.moment_arm * state.flexor.capstan
    return np.asarray(coupling.elbow_torque * state.design.flexor_radius / arm)


def crossings_by_eq_11(run: PaperTables) -> list[float]:
    """Return the angles of flexion up to which τ_m of Eq. 11 exceeds τ_a, by design, deg."""
    state = State.of(*run.inputs())
    gain = np.asarray(state.coupling.elbow_torque - motor_torque_by_eq_11(state))
    return run.crossings_of(gain[:, 0])


def eq_11_first(design: Design, elbow_angle: Array, flexion: Flags) -> Tensions:
    """Solve Eqs. 17 to 20 with the motor torque of Eq. 11.

    Eq. 11 leaves the extensor out of the elbow's balance. τ_m / R_f = τ_a / (J α_t) is given; Eq.
    20 then has both proximal tensions. The right side of Eq. 12 is that of the reading used, so
    that this slip is seen by itself.

    Args:
        design: Designs, ready to broadcast.
        elbow_angle: Elbow angles, rad.
        flexion: True where the joint flexes.
    """
    at = State.of(design, elbow_angle, flexion)
    flexor = at.flexor
    extensor = at.extensor
    coupling = at.coupling
    pull = motor_torque_by_eq_11(at) / design.flexor_radius
    xi_t = coupling.flexor_compliance * flexor.capstan
    xi_r = coupling.extensor_compliance * extensor.capstan
    pretensioned = (
        design.ratio * coupling.flexor_compliance * design.flexor.pretension
        + coupling.extensor_compliance * design.extensor.pretension
    )
    right = coupling.mismatch + pretensioned
    at_motor = (right - design.ratio * xi_t * pull) / (np.square(design.ratio) * xi_t + xi_r)
    return (pull + design.ratio * at_motor) * flexor.capstan, at_motor * extensor.capstan


def normal_force(tension: float, curvature: float, length: float, friction: float) -> float:
    """Return |N_o| by Eq. A.9 as printed, the force that presses on an element of the sheath, N.

    F κ ds + |N_o| - μ |N_o| κ ds / 2 = 0.

    Args:
        tension: Tension F, N.
        curvature: Curvature κ, rad/m.
        length: Length ds of the element, m.
        friction: Friction coefficient μ.
    """
    return -tension * curvature * length / (1.0 - friction * curvature * length / 2.0)


def transmitted(friction: float, bend_angle: float, steps: int = 100_000) -> float:
    """Return F_o / F_I by Eqs. A.8 and A.9 as printed, along a sheath of length 1.

    Args:
        friction: Friction coefficient μ.
        bend_angle: Bend angle of the sheath, rad.
        steps: Number of elements of the sheath.
    """
    step = 1.0 / steps
    force = normal_force(1.0, bend_angle, step, friction)
    gain = 1.0 + force * (bend_angle * step / 2.0 + friction)
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
"""Checks of the slips and gaps."""
