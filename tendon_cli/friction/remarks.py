"""What a reader of the coefficient should be told: the rig's checks, what may be wrong, and what it is sensitive to."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from tendon_cli.friction.effects import DELAY, DRIFT, FORCE, GAIN_DRIFT, OFFSETS, Effect, Fitted, offset_columns
from tendon_cli.friction.estimate import ASSUMED_SCATTER, Linear
from tendon_cli.friction.reading.header import force_factor
from tendon_cli.friction.result import Check, Fit

_MATTERS = 0.02
"""Sensitivity of μ, as a share, that is worth a word."""
_APART = 0.05
"""Difference of the forces of the two directions, as a share, from which an offset does not act on both alike."""
_WORDS = {
    OFFSETS: "zero offsets of the cells",
    DELAY: "a delay between the cells",
    FORCE: "friction that depends on the force",
    DRIFT: "friction that drifts along the log",
    GAIN_DRIFT: "a gain that drifts along the log",
}


def judged(fit: Fit, fitted: Fitted, known: dict[str, Effect]) -> Fit:
    """The fit with its checks, notes and warnings."""
    tried = {
        name: fitted.linear if _has(fitted, name) else fitted.with_effect(effect) for name, effect in known.items()
    }
    checks = _checks(fit, fitted, known, tried)
    notes = list(fit.notes)
    warnings = list(fit.warnings)
    _about_effects(fitted, checks, notes, warnings)
    _about_offsets(fit, fitted, known, tried, notes, warnings)
    _about_sample(fit, fitted, notes, warnings)
    return replace(fit, checks=checks, notes=tuple(notes), warnings=tuple(warnings))


def _has(fitted: Fitted, name: str) -> bool:
    return any(effect.name == name for effect in fitted.effects)


def _checks(fit: Fit, fitted: Fitted, known: dict[str, Effect], tried: dict[str, Linear]) -> tuple[Check, ...]:
    unit, time = fit.unit or "unit of the file", "unit of the file's time"
    wanted = [
        ("offset_motor", OFFSETS, 0, unit), ("offset_load", OFFSETS, 1, unit), ("delay", DELAY, 0, time),
        ("gain", None, 0, "1"), ("force_dependence", FORCE, 0, "1"), ("drift", DRIFT, 0, "1"),
    ]  # fmt: skip
    if _has(fitted, GAIN_DRIFT) and not _has(fitted, DRIFT):
        wanted[-1] = ("drift", GAIN_DRIFT, 0, "1")
    return tuple(
        _gain_check(fitted) if name is None else _check(label, fitted, known.get(name), tried.get(name), part, unit)
        for label, name, part, unit in wanted
    )


def _gain_check(fitted: Fitted) -> Check:
    if not fitted.with_gain:
        return Check("gain", None, None, "1", None, None)
    error = fitted.linear.error(1)
    found = not fitted.linear.assumed and abs(fitted.log_gain) > 3.0 * error and abs(fitted.log_gain) > 1e-3
    return Check("gain", math.exp(fitted.log_gain), error, "1", found, 0.0)


def _check(label: str, fitted: Fitted, effect: Effect | None, linear: Linear | None, part: int, unit: str) -> Check:
    """One effect: fitted, or as it would be if it were; None where it would be known too badly to say anything."""
    own = fitted.value(effect.name, part) if effect else None
    if effect is None or linear is None or (fitted.linear.assumed and not own):
        return Check(label, None, None, unit, None, None)
    at = len(linear.values) - len(effect.columns) + part
    value, error = own or (float(linear.values[at]), linear.error(at))
    bias = fitted.bias(effect.columns[part]) / fitted.friction
    scale = fitted.friction if effect.name in {FORCE, DRIFT} else 1.0
    share = (value / scale, error / scale)
    if own:
        return Check(label, *share, unit, effect.name not in fitted.rivals, value * bias)
    reach = float(np.ptp(effect.columns[part])) / float(np.max(fitted.points.bend_angle)) / fitted.friction
    blind = error <= 0.0 or 2.0 * error * max(abs(bias), 0.3 * reach) > _MATTERS
    blind = blind or effect.name in fitted.rivals
    if blind:
        return Check(label, None, None, unit, None, None)
    return Check(label, *share, unit, found=False, effect=value * bias)


def _about_effects(fitted: Fitted, checks: tuple[Check, ...], notes: list[str], warnings: list[str]) -> None:
    """What was fitted; where another effect explains the same and gives another μ, the number is in doubt."""
    notes += [f"{_WORDS[effect.name]} found in the readings and fitted" for effect in fitted.effects]
    for name, friction in fitted.rivals.items():
        if _has(fitted, name):
            continue
        apart = abs(friction / fitted.friction - 1.0)
        if apart > max(0.01, fitted.linear.error(0) / fitted.friction):
            mine = " and ".join(_WORDS[effect.name] for effect in fitted.effects)
            warnings.append(f"the readings may as well show {_WORDS[name]}, not {mine}: then μ = {friction:.4g}")
        else:
            notes.append(f"the readings may as well show {_WORDS[name]}; μ would be the same")
    for name in (FORCE, DRIFT):
        found = next((check for check in checks if check.name == name), None)
        if found and found.value is not None and _has(fitted, name):
            what = (
                f"μ goes with the force to the power {found.value:.2g}: the number holds for the readings' mean force"
                if name == FORCE
                else f"friction drifts: μ changes by {100.0 * found.value:.1f} % along the log, the number is its mean"
            )
            warnings.append(what)


def _about_offsets(
    fit: Fit,
    fitted: Fitted,
    known: dict[str, Effect],
    tried: dict[str, Linear],
    notes: list[str],
    warnings: list[str],
) -> None:
    """The second opinion of slopes where the force varies; else what a zero error would do."""
    if _has(fitted, OFFSETS) or not fitted.with_gain:
        return
    # Without a unit, a share of the force stands for 1 N.
    usual = 0.01 * float(np.mean(fitted.points.force))
    newton = 1.0 / (force_factor(fit.unit) or 1.0) if fit.unit else usual
    motor, load = (abs(fitted.bias(column)) * newton / fitted.friction for column in offset_columns(fitted))
    if OFFSETS in known and not tried[OFFSETS].assumed:
        slopes, error = float(tried[OFFSETS].values[0]), tried[OFFSETS].error(0)
        if 2.0 * error < max(0.5 * motor, _MATTERS) * fitted.friction:
            notes.append(f"from the slopes alone, free of offsets and gain: μ = {slopes:.4f} ± {error:.2g}")
            if abs(slopes - fitted.friction) > max(3.0 * error, 0.01 * fitted.friction):
                warnings.append(
                    f"μ from the slopes of force against force is {slopes:.4f}: offsets, a delay or a dependence on"
                    " force make the two differ"
                )
            return
    amount = "1 N" if fit.unit else "1 % of the force"
    text = f"{amount} of zero error in a cell would move μ by {100.0 * max(motor, load):.1f} %"
    if OFFSETS in known and fitted.tells(tried[OFFSETS]):
        notes.append(f"{text}; the interval counts what these readings may hide of it")
    elif _levels_apart(fitted) > _APART and max(motor, load) > _MATTERS:
        warnings.append(f"the forces of the two directions lie far apart: {text}, and an offset cannot be told")
    elif motor > 0.002:
        notes.append(f"{text}; at these forces an offset cannot be told")


def _levels_apart(fitted: Fitted) -> float:
    """By how much the forces at the load differ between the directions, as a share; a weight is the same both ways."""
    log_force, way = np.log(fitted.points.force), fitted.points.way
    there, back = log_force[way > 0], log_force[way < 0]
    return abs(float(np.mean(there) - np.mean(back))) if len(there) and len(back) else 0.0


def _about_sample(fit: Fit, fitted: Fitted, notes: list[str], warnings: list[str]) -> None:
    """Too little, or too odd, to be relied on."""
    widest = max(fit.bend_angles)
    if not fit.gain_estimated:
        share = 100.0 * 0.01 / widest / fit.friction
        notes.append(
            "one direction only: gain and offsets of the cells hide in μ; 1 % between the gains would change it by"
            f" {share:.1f} %"
        )
    elif abs(math.log(fit.gain_ratio)) > 0.05:
        notes.append(f"the gains of the cells differ by {100.0 * (fit.gain_ratio - 1.0):.1f} %: calibrate them")
    if fitted.linear.assumed:
        warnings.append(
            f"{fit.strokes} {'stroke' if fit.strokes == 1 else 'strokes'}: how strokes scatter cannot be seen, so"
            f" {100.0 * ASSUMED_SCATTER:.0f} % is assumed; repeat the measurement"
        )
    elif fit.uncertainty.degrees_of_freedom < 4.0:
        notes.append(f"{fit.strokes} strokes give a wide interval: more of them narrow it quickly")
    if any(part.friction <= 0.0 for part in fit.by_direction.values()):
        notes.append(
            "with equal gains, friction would help the motion in one direction: only the joint estimate counts"
        )
    if widest > 4.0 * math.pi:
        warnings.append(f"a bend angle of {widest:.4g} rad is {widest / 2.0 / math.pi:.1f} turns: are its units right?")
    if fit.friction > 1.0:
        warnings.append("a coefficient above 1 is not plausible for a tendon in a sheath: check units and bend angle")
    if fit.uncertainty.interval_95[0] <= 0.0:
        warnings.append("the 95 % interval reaches 0: the readings do not show that there is friction")
    used = int(fit.rows.used.sum())
    if fit.is_log and used < 0.4 * len(fit.rows.used):
        notes.append(f"only {100.0 * used / len(fit.rows.used):.0f} % of the log slips: make the strokes longer")
    saturated = sum(part.rows for part in fit.set_aside if part.reason.startswith("saturated"))
    if saturated > 0.1 * len(fit.rows.used):
        warnings.append(
            f"{saturated} rows are saturated, at the largest reading of a cell: what slips there is not known"
        )
