"""What a reader of the coefficient should be told without asking."""

from __future__ import annotations

import math

from tendon_cli.friction.result import FrictionFit


def about(fit: FrictionFit) -> tuple[str, ...]:
    """Warnings, each one sentence."""
    said = []
    widest = max(fit.bend_angles)
    if not fit.gain_estimated:
        share = 0.01 / widest / fit.friction
        said.append(
            "one direction only, so the gains of the cells are taken as equal: 1 % between them would change the"
            f" coefficient by {100.0 * share:.1f} %"
        )
    elif abs(math.log(fit.gain_ratio)) > 0.05:
        said.append(f"the gains of the cells differ by {100.0 * (fit.gain_ratio - 1.0):.1f} %: calibrate them")
    if any(part.friction <= 0.0 for part in fit.by_direction.values()):
        said.append("with equal gains, friction would help the motion in one direction: only the joint estimate counts")
    if widest > 4.0 * math.pi:
        said.append(f"a bend angle of {widest:.4g} rad is {widest / 2.0 / math.pi:.1f} turns: are its units right?")
    if fit.friction > 1.0:
        said.append("a coefficient above 1 is not plausible for a tendon in a sheath: check units and bend angle")
    if fit.uncertainty.interval_95[0] <= 0.0:
        said.append("the 95 % interval reaches 0: the readings do not show that there is friction")
    used = int(fit.rows.used.sum())
    if fit.is_log and used < 0.4 * len(fit.rows.used):
        said.append(f"only {100.0 * used / len(fit.rows.used):.0f} % of the log slips: make the strokes longer")
    if fit.uncertainty.degrees_of_freedom < 4.0:
        said.append(f"{fit.strokes} strokes or readings give a wide interval: more of them narrow it quickly")
    return tuple(said)
