"""A friction fit as people read it and as programs do."""

from __future__ import annotations

import math
from typing import Any

from tendon_cli.friction.result import Check, DirectionFit, Fit, FrictionUncertainty

_DIRECTION_NAMES = {"toward_motor": "toward motor", "toward_load": "toward load"}


def summary_lines(fit: Fit) -> str:
    """A short readable summary."""
    error = fit.uncertainty
    digits = _digits(error.standard_error)
    low, high = error.interval_95
    interval = f"95 % interval {low:.{digits}f} to {high:.{digits}f}"
    lines = [
        f"friction coefficient  μ = {fit.friction:.{digits}f}",
        f"  standard error      {error.standard_error:.{digits}f}, {interval}",
        f"  bend angle          {_bend_text(fit)}",
        f"  gain ratio          {_gain_text(fit)}",
    ]
    for name, part in fit.by_direction.items():
        lines.append(f"  {_DIRECTION_NAMES[name]:<20}{_direction_text(part, digits)}")
    lines.append(f"  standard error from {_parts_text(error)}")
    lines.append(f"  readings            {_used_text(fit)}")
    lines += [f"  set aside           {part.rows}: {part.reason}" for part in fit.set_aside]
    lines += [_check_text(check) for check in fit.checks if check.found and check.name != "gain"]
    lines += [f"note: {text}" for text in fit.notes]
    lines += [f"warning: {text}" for text in fit.warnings]
    return "\n".join(lines)


def as_json(fit: Fit) -> dict[str, Any]:
    """The same as plain JSON values, angles in rad."""
    used = fit.rows.used
    return {
        "friction": fit.friction,
        "standard_error": fit.uncertainty.standard_error,
        "interval_95": list(fit.uncertainty.interval_95),
        "bend_angle": fit.bend_angles[0] if len(fit.bend_angles) == 1 else list(fit.bend_angles),
        "gain_ratio": fit.gain_ratio,
        "by_direction": {name: _direction_json(part) for name, part in fit.by_direction.items()},
        "used": int(used.sum()),
        "set_aside": [
            {"reason": part.reason, "rows": part.rows, "lines": [list(stretch) for stretch in part.lines]}
            for part in fit.set_aside
        ],
        "residuals": [float(value) for value in fit.rows.residual[used]],
        "warnings": list(fit.warnings),
        "notes": list(fit.notes),
        "checks": [_check_json(check) for check in fit.checks],
    }


def _check_json(check: Check) -> dict[str, Any]:
    return {
        "name": check.name,
        "value": check.value,
        "standard_error": check.standard_error,
        "unit": check.unit,
        "found": check.found,
        "effect_on_friction": check.effect,
    }


def _check_text(check: Check) -> str:
    name = check.name.replace("_", " ")
    unit = "" if check.unit == "1" else f" {check.unit}"
    effect = f", {100.0 * check.effect:+.1f} % of μ, fitted" if check.effect else ""
    return f"  {name:<20}{check.value:.4g} ± {check.standard_error:.2g}{unit}{effect}"


def _direction_json(part: DirectionFit) -> dict[str, Any]:
    error = part.uncertainty
    return {
        "friction": part.friction,
        "standard_error": error.standard_error if error else None,
        "interval_95": list(error.interval_95) if error else None,
        "used": part.used,
    }


def _digits(error: float) -> int:
    """Decimals that show the standard error with two significant digits, four at least."""
    return 4 if error <= 0.0 else min(9, max(4, 1 - math.floor(math.log10(error))))


def _bend_text(fit: Fit) -> str:
    text = fit.bend_angle_text
    if fit.bend_angle_uncertainty_text:
        return f"{text} +/- {fit.bend_angle_uncertainty_text}"
    if len(fit.bend_angles) > 1:
        return text
    return f"{text} (taken as exact; 1 deg more is {100.0 * math.radians(1.0) / fit.bend_angles[0]:.1f} % less μ)"


def _gain_text(fit: Fit) -> str:
    if not fit.gain_estimated:
        return "1, assumed (one direction only)"
    return f"{fit.gain_ratio:.4f}, motor's cell (cell {fit.motor}) over load's, removed from μ"


def _direction_text(part: DirectionFit, digits: int) -> str:
    error = f" ± {part.uncertainty.standard_error:.{digits}f}" if part.uncertainty else ""
    readings = "1 reading" if part.used == 1 else f"{part.used} readings"
    return f"μ = {part.friction:.{digits}f}{error} with a gain ratio of 1, {readings}"


def _parts_text(error: FrictionUncertainty) -> str:
    largest = max(error.standard_error, 1e-300)
    names = {
        "scatter": error.scatter,
        "resolution (floor)": error.resolution,
        "bend angle": error.bend_angle,
        "what it may hide": error.doubt,
    }
    return ", ".join(f"{name} {value:.2g}" for name, value in names.items() if value > 1e-3 * largest) or "nothing"


def _used_text(fit: Fit) -> str:
    used, total = int(fit.rows.used.sum()), len(fit.rows.used)
    if fit.is_log:
        return f"{used} slipping of {total} in the log, in {fit.strokes} strokes"
    if fit.strokes == used:
        return f"{used} of {total} settled, each counted as a stroke of its own"
    return f"{used} of {total} settled, in {fit.strokes} strokes"
