"""Where the letter of the paper fails: each slip run as it is printed, beside the reading used."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tendon_cli.friction.result import FrictionFit
from tendon_cli.paper import letter
from tendon_cli.paper.entry import Entry, listed, number
from tendon_cli.paper.findings import apart
from tendon_cli.paper.letter import Tensions
from tendon_cli.paper.runs import Array, Run

FIGURE = "slips.png"
_HEAVY = 5.0
_TAUT, _FAR_ABOVE = 0.0, 1.5
_NEGATIVE = -500.0
"""N; no study of the paper comes near it."""


@dataclass(frozen=True)
class Evidence:
    """The letter's tensions of the study of Fig. 7: loads, directions, elbow angles."""

    eq_12: Tensions
    eq_11: Tensions


def evidence(fig07: Run) -> Evidence:
    """Run the two letters that give whole curves."""
    inputs = fig07.inputs()
    return Evidence(letter.eq_12_as_printed(*inputs), letter.eq_11_first(*inputs))


def slips(runs: Mapping[str, Run], found: Evidence, at_pi: FrictionFit, used: FrictionFit) -> list[Entry]:
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


def _eq_12(run: Run, printed: Tensions) -> Entry:
    at = run.values("load_mass").index(_HEAVY)
    least = min(float(printed.flexor.min()), float(printed.extensor.min()))
    ends = [float(side[at, 0, -1] / side[at, 0, 0]) for side in (printed.flexor, printed.extensor)]
    ours = min(float(run.line("extensor_tension_distal", load_mass=load).min()) for load in run.values("load_mass"))
    numbers = [float(value) for side in (printed.flexor, printed.extensor) for value in side[at, 0, [0, -1]]]
    value = (
        f"as printed: never below {number(least)} N at any load; at 5 kg the flexor rises from {number(numbers[0])} to "
        f"{number(numbers[1])} N, the extensor from {number(numbers[2])} to {number(numbers[3])} N. "
        f"Used: the extensor falls to {number(ours)} N at 10 kg"
    )
    text = "Eq. 12 prints ηH_f + H_e. No slack would ever occur, against Figs. 7–11; used is H_e − ηH_f"
    return Entry("S1", text, least > _TAUT and min(ends) > _FAR_ABOVE and ours < 0.0, value, FIGURE)


def _eq_11(run: Run, printed: Tensions) -> Entry:
    at = run.values("load_mass").index(0.0)
    flexor, extensor = printed.flexor[at], printed.extensor[at]
    share = max(_apart(side) for side in (flexor, extensor))
    ours = run.line("flexor_tension_distal", load_mass=0.0)
    rises = bool(flexor[0, 1] > flexor[0, 0] and extensor[0, 1] < extensor[0, 0])
    used = apart(run, "distal", 0.0)
    value = (
        f"Eq. 11 first, no load, 0° to 1°: flexor {listed(flexor[0, :2])} N, extensor {listed(extensor[0, :2])} N, "
        f"directions {number(100.0 * share)} % of the peak apart. Used: flexor {listed(ours[:2])} N, "
        f"{number(100.0 * used, 2)} % apart"
    )
    text = (
        "Eq. 11 gives the motor torque before the extensor is known. The unloaded flexor tension would rise from the "
        "start and the directions differ at the elbow, against Fig. 7; used is Eq. 5 together with Eq. 12"
    )
    return Entry("S2", text, rises and share > 0.1 and bool(ours[1] < ours[0]), value, FIGURE)


def _apart(side: Array) -> float:
    """Largest difference between the two directions over the peak."""
    return float(np.abs(side[0] - side[1]).max() / np.abs(side).max())


def _labels(run: Run) -> Entry:
    flexor, extensor = (float(run.line(f"{side}_travel")[-1]) for side in ("flexor", "extensor"))
    printed = letter.eq_3_as_labelled(flexor, extensor)
    used = extensor / flexor
    loose = [1e3 * (extensor - ratio * flexor) for ratio in (printed, used)]
    value = (
        f"at 90°: H_f/H_e = {number(printed, 3)}, H_e/H_f = {number(used, 3)}. With η = {number(printed, 3)} "
        f"the spools miss the path by {number(abs(loose[0]))} mm, with {number(used, 3)} by {number(abs(loose[1]))} mm"
    )
    text = (
        "Eqs. 2 and 3 call H_f/H_e the ratio R_e/R_f. With η = R_e/R_f as in Eqs. 12–17 the ratio without slack is its "
        "inverse"
    )
    return Entry("S3", text, abs(loose[0]) > 1.0 > abs(loose[1]) and printed > 1.0 > used, value, "fig04.png")


def _reference(fig07: Run, fig04: Run, initial: Run) -> Entry:
    at_zero = 1e3 * float(fig07.line("flexor_travel", load_mass=0.0)[0])
    travel = fig04.line("flexor_travel")
    ratio, better = (run.line("flexor_travel") / run.line("extensor_travel") for run in (fig04, initial))
    zero = float(np.interp(0.0, travel, fig04.degrees))
    value = (
        f"H_f(0) = {number(at_zero, 3)} mm; Eq. 3 is {number(ratio[0], 3)} at 1° and 0 at {number(zero, 2)}°. "
        f"From L_c(0): {number(better[0], 3)} at 1°"
    )
    text = (
        "H_f counts from b₁ + b₂ and not from L_c(0): it is not 0 at 0°, where Eq. 3 diverges. Kept as published by "
        'default; reference = "initial" counts from L_c(0)'
    )
    return Entry("S4", text, bool(at_zero < -0.1 and ratio[0] < 0.0 < better[0]), value, FIGURE)


def _stiffness(run: Run, stiff: Run) -> Entry:
    least, ours = ([float(each.line("extensor_tension_distal", load_mass=load).min()) for load in
                    each.values("load_mass")] for each in (stiff, run))  # fmt: skip
    value = (
        f"least extensor tension at the elbow with 30 kN/m: {listed(least, 0)} N; with 3 kN/m: {listed(ours, 0)} N "
        f"({listed(run.values('load_mass'), 0)} kg)"
    )
    text = "The text at Fig. 6 gives springs of 30 kN/m, section 3 gives 3 kN/m; only 3 kN/m fits the figures"
    return Entry("S5", text, max(least) < _NEGATIVE < min(ours), value, FIGURE)


def _a_9() -> Entry:
    friction, bend = 0.07, math.pi
    pressed = letter.normal_force(100.0, bend / 2.0, 1e-3, friction)
    passed, exact = letter.transmitted(friction, bend), math.exp(-friction * bend)
    value = (
        f"|N_o| = {number(pressed, 3)} N on 1 mm of the baseline's sheath (π over 2 m) at 100 N. A.8 and A.9, "
        f"integrated, pass on {number(passed, 3)} of the tension; A.17 says {number(exact, 3)}"
    )
    text = "Eq. A.9 has a slip of sign: the magnitude |N_o| comes out negative. The result, A.17, stands"
    return Entry("S6", text, pressed < 0.0 and abs(passed - exact) < 1e-3, value, None)


def _wrap_angle(at_pi: FrictionFit, used: FrictionFit) -> Entry:
    by_pi, ours = ([fit.by_direction[way].friction for way in ("toward_motor", "toward_load")] for fit in (at_pi, used))
    value = (
        f"with π: μ = {listed(by_pi, 4)}; with {used.bend_angle_text}: {listed(ours, 4)}; printed: 0.073, 0.075 "
        "(rising, falling)"
    )
    text = (
        "Table A.1's wrap angle is not printed. Section 3's π does not give its coefficients; they imply 2.51 to 2.53 "
        "rad (144°)"
    )
    return Entry("S7", text, max(by_pi) < 0.065 and min(ours) > 0.07, value, "table_a1.png")
