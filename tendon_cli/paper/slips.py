"""Where the paper as printed fails: each slip is run as it is printed, and compared with the reading used.

NOTHING of what is printed is used for any result: the reading is in `tendon_cli.model`; docs/physics.md compares them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tendon_cli.friction.result import Fit
from tendon_cli.model import statics
from tendon_cli.model.actuator import Situation
from tendon_cli.model.design import Design
from tendon_cli.paper.entry import Entry, judge
from tendon_cli.paper.measures import apart, least
from tendon_cli.paper.runs import Array, PaperTables

FIGURE = "slips.png"
_HEAVY = 5.0
_TAUT, _FAR_ABOVE = 0.0, 1.5
_NEGATIVE = -500.0
"""N; no study of the paper comes near it."""


Flags = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Tensions:
    """Distal tensions by equations as printed, N, in the shape of designs, directions and elbow angles."""

    flexor: Array
    extensor: Array


@dataclass(frozen=True)
class Evidence:
    """The tensions of equations as printed, for the study of Fig. 7: loads, directions, elbow angles."""

    eq_12: Tensions
    eq_11: Tensions


def evidence(fig07: PaperTables) -> Evidence:
    """Run the two slips that give whole curves."""
    inputs = fig07.inputs()
    return Evidence(eq_12_as_printed(*inputs), eq_11_first(*inputs))


def slips(runs: Mapping[str, PaperTables], found: Evidence, at_pi: Fit, used: Fit) -> list[Entry]:
    """All slips; the fits are those of Table A.1 with a wrap of π and with the angle that its coefficients imply."""
    return [
        _eq_12(runs["fig07"], found.eq_12),
        _eq_11(runs["fig07"], found.eq_11),
        _labels(runs["fig04"]),
        _reference(runs["fig07"], runs["fig04"], runs["fig04-initial"]),
        _stiffness(runs["fig06"], runs["fig06-30kN"]),
        _a_9(),
        _wrap_angle(at_pi, used),
    ]


def _eq_12(run: PaperTables, printed: Tensions) -> Entry:
    at = run.values("load_mass").index(_HEAVY)
    sides = (printed.flexor, printed.extensor)
    lowest = min(float(side.min()) for side in sides)
    ends = np.array([side[at, 0, [0, -1]] for side in sides])
    ours = min(float(run.line("extensor_tension_distal", load_mass=load).min()) for load in run.values("load_mass"))
    text = "Eq. 12 prints ηH_f + H_e. No slack would ever occur, against Figs. 7–11; used is H_e − ηH_f"
    return judge(
        [lowest > _TAUT and (ends[:, 1] / ends[:, 0]).min() > _FAR_ABOVE and ours < 0.0],
        "as printed: never below {:1} N at any load; at 5 kg the flexor rises from {:1} to {:1} N, the extensor from "
        "{:1} to {:1} N. Used: the extensor falls to {:1} N at 10 kg",
        lowest, *ends.ravel(), ours,
    ).entry("S1", text, FIGURE)  # fmt: skip


def _eq_11(run: PaperTables, printed: Tensions) -> Entry:
    at = run.values("load_mass").index(0.0)
    flexor, extensor = printed.flexor[at], printed.extensor[at]
    share = max(_apart(side) for side in (flexor, extensor))
    ours = run.line("flexor_tension_distal", load_mass=0.0)
    used = max(apart(run, "tension_distal", load_mass=0.0))
    rises = flexor[0, 1] > flexor[0, 0] and extensor[0, 1] < extensor[0, 0]
    text = (
        "Eq. 11 gives the motor torque before the extensor is known. The unloaded flexor tension would rise from the "
        "start and the directions differ at the elbow, against Fig. 7; used is Eq. 5 together with Eq. 12"
    )
    return judge(
        [rises and share > 10.0 and ours[1] < ours[0]],
        "Eq. 11 first, no load, 0° to 1°: flexor {:1} N, extensor {:1} N, directions {:1} % of the peak apart. Used: "
        "flexor {:1} N, {:2} % apart",
        flexor[0, :2], extensor[0, :2], share, ours[:2], used,
    ).entry("S2", text, FIGURE)  # fmt: skip


def _apart(side: Array) -> float:
    """Largest difference between the two directions over the peak, %."""
    return float(100.0 * np.abs(side[0] - side[1]).max() / np.abs(side).max())


def _labels(run: PaperTables) -> Entry:
    flexor, extensor = (float(run.line(f"{side}_travel")[-1]) for side in ("flexor", "extensor"))
    printed, used = eq_3_as_labelled(flexor, extensor), extensor / flexor
    missed = [abs(1e3 * (extensor - ratio * flexor)) for ratio in (printed, used)]
    text = (
        "Eqs. 2 and 3 call H_f/H_e the ratio R_e/R_f. With η = R_e/R_f as in Eqs. 12–17 the ratio without slack is its "
        "inverse"
    )
    return judge(
        [missed[0] > 1.0 > missed[1] and printed > 1.0 > used],
        "at 90°: H_f/H_e = {:3}, H_e/H_f = {:3}. With η = H_f/H_e the spools miss the path by {:1} mm, with H_e/H_f by "
        "{:1} mm",
        printed, used, *missed,
    ).entry("S3", text, "fig04.png")  # fmt: skip


def _reference(fig07: PaperTables, fig04: PaperTables, initial: PaperTables) -> Entry:
    at_zero = 1e3 * float(fig07.line("flexor_travel", load_mass=0.0)[0])
    ratio, better = (run.line("flexor_travel") / run.line("extensor_travel") for run in (fig04, initial))
    zero = np.interp(0.0, fig04.line("flexor_travel"), fig04.degrees)
    text = (
        "H_f counts from b₁ + b₂ and not from L_c(0): it is not 0 at 0°, where Eq. 3 diverges. Kept as published by "
        'default; reference = "initial" counts from L_c(0)'
    )
    return judge(
        [at_zero < -0.1 and ratio[0] < 0.0 < better[0]],
        "H_f(0) = {:3} mm; Eq. 3 is {:3} at 1° and 0 at {:2}°. From L_c(0): {:3} at 1°",
        at_zero, ratio[0], zero, better[0],
    ).entry("S4", text, FIGURE)  # fmt: skip


def _stiffness(run: PaperTables, stiff: PaperTables) -> Entry:
    loads = run.values("load_mass")
    with_30, with_3 = ([least(each, "extensor_tension_distal", load_mass=load) for load in loads]
                       for each in (stiff, run))  # fmt: skip
    text = "The text at Fig. 6 gives springs of 30 kN/m, section 3 gives 3 kN/m; only 3 kN/m fits the figures"
    return judge(
        [max(with_30) < _NEGATIVE < min(with_3)],
        "least extensor tension at the elbow with 30 kN/m: {:0} N; with 3 kN/m: {:0} N ({:0} kg)",
        with_30, with_3, loads,
    ).entry("S5", text, FIGURE)  # fmt: skip


def _a_9() -> Entry:
    friction, bend = 0.07, math.pi
    pressed = normal_force(100.0, bend / 2.0, 1e-3, friction)
    passed, exact = transmitted(friction, bend), math.exp(-friction * bend)
    text = "Eq. A.9 has a slip of sign: the magnitude |N_o| comes out negative. The result, A.17, stands"
    return judge(
        [pressed < 0.0 and abs(passed - exact) < 1e-3],
        "|N_o| = {:3} N on 1 mm of the baseline's sheath (π over 2 m) at 100 N. A.8 and A.9, integrated, pass on {:3} "
        "of the tension; A.17 says {:3}",
        pressed, passed, exact,
    ).entry("S6", text, None)  # fmt: skip


def _wrap_angle(at_pi: Fit, used: Fit) -> Entry:
    by_pi, ours = ([fit.by_direction[way].friction for way in ("toward_motor", "toward_load")] for fit in (at_pi, used))
    text = (
        "Table A.1's wrap angle is not printed. Section 3's π does not give its coefficients; they imply 2.51 to 2.53 "
        "rad (144°)"
    )
    return judge(
        [max(by_pi) < 0.065 and min(ours) > 0.07],
        f"with π: μ = {{:4}}; with {used.bend_angle_text}: {{:4}}; printed: 0.073, 0.075 (rising, falling)",
        by_pi, ours,
    ).entry("S7", text, "table_a1.png")  # fmt: skip


# --- Equations as they are printed ------------------------------------------------------------------------------------


def eq_12_as_printed(design: Design, elbow_angle: Array, flexion: Flags) -> Tensions:
    """Eq. 12 with its printed right side, η H_f + H_e, where the reading used has H_e - η H_f; all else equal."""
    at = Situation.of(design, elbow_angle, flexion)
    motion, tied = at.motion, at.coupling
    printed = replace(tied, mismatch=np.asarray(design.ratio * motion.flexor_travel + motion.extensor_travel))
    balance = statics.solve(printed, design.flexor.pretension, design.extensor.pretension, unilateral=False)
    return Tensions(balance.flexor, balance.extensor)


def eq_11_first(design: Design, elbow_angle: Array, flexion: Flags) -> Tensions:
    """Eqs. 17 to 20 with the motor torque of Eq. 11, which leaves the extensor out of the elbow's balance.

    τ_m / R_f = τ_a / (J α_t) is given; Eq. 20 then has both proximal tensions. The right side of Eq. 12 is that of the
    reading used, so that this slip is seen by itself.
    """
    at = Situation.of(design, elbow_angle, flexion)
    flexor, extensor, tied = at.flexor, at.extensor, at.coupling
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
