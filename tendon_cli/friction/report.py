"""A friction fit as people read it, as programs do, and as a file that a study takes."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli.files import write_whole
from tendon_cli.friction.budget import BudgetPart
from tendon_cli.friction.result import Check, DirectionFit, Fit
from tendon_cli.units import counted, shorten
from tendon_cli.version import __version__

_MARK = "# A friction coefficient fitted by `tendon fit-friction`."
"""The first line of a fragment; a file without it is nobody's to write over."""
_HEADER = f"""\
{_MARK} A study takes it by
#     [sheath]
#     friction_from = "friction.toml"
# The bend angle is that of the rig, not of the study's sheath.
"""
_HEADER_OF_A_PRODUCT = f"""\
{_MARK} Its bend angle was not given: it is μφ of one sheath.
#     [sheath]
#     friction_from = "friction.toml"
#     bend_angle = "..."      # of the same sheath, as it was when μφ was measured
"""
_DIRECTION_NAMES = {"toward_motor": "toward motor", "toward_load": "toward load"}
_MOST_RESIDUALS = 20


def headline(fit: Fit) -> list[str]:
    """The number, its interval and what it rests on."""
    error, name = fit.uncertainty, "μφ" if fit.friction is None else "μ"
    digits = _digits(error.standard_error)
    low, high = error.interval_95
    what = "friction over the bend  " if fit.friction is None else "friction coefficient  "
    lines = [
        f"{what}{name} = {fit.fitted:.{digits}f}",
        f"  95 % interval       {low:.{digits}f} to {high:.{digits}f}, standard error {error.standard_error:.2g}",
        f"  bend angle          {_bend_text(fit)}",
        f"  gain ratio          {_gain_text(fit)}",
        f"  readings            {_used_text(fit)}",
    ]
    return lines + [f"  warnings            {len(fit.warnings)}"] * bool(fit.warnings)


def summary_lines(fit: Fit) -> str:
    """A short readable summary."""
    error = fit.uncertainty
    digits = _digits(error.standard_error)
    lines = headline(fit)[:4]
    for name, part in fit.by_direction.items():
        lines.append(f"  {_DIRECTION_NAMES[name]:<20}{_direction_text(part, digits)}")
    lines.append(f"  {'plain answer':<20}{_plain_text(fit, digits)}")
    lines += [f"  {'standard error from':<20}{_part_text(part)}" for part in error.parts[:1]]
    lines += [f"  {'':<20}{_part_text(part)}" for part in error.parts[1:]]
    lines.append(f"  {'readings':<20}{_used_text(fit)}")
    lines += [f"  {'set aside':<20}{part.rows}: {part.reason}" for part in fit.set_aside]
    if fit.speed:
        low, high = fit.speed.slowest, fit.speed.fastest
        power = f"{fit.speed.power:+.3f} ± {fit.speed.standard_error:.2g}, from {low:.3g} to {high:.3g}"
        lines.append(f"  {'power of speed':<20}{power}")
    if fit.presliding:
        stiff = f"stiffness {fit.presliding.stiffness:.3g}, backlash {fit.presliding.backlash:.3g}"
        lines.append(f"  {'before it slides':<20}{stiff}, {counted(fit.presliding.reversals, 'reversal')}")
    lines += [f"  {shorten(each['file'], 18):<20}{_file_text(each)}" for each in fit.files]
    lines += [_check_text(check) for check in fit.checks if check.found and check.name != "gain"]
    lines += [f"note: {text}" for text in fit.notes]
    lines += [f"warning: {text}" for text in fit.warnings]
    return "\n".join(lines)


def _digits(error: float) -> int:
    """Decimals that show the standard error with two significant digits."""
    return 4 if error <= 0.0 else min(9, max(2, 1 - math.floor(math.log10(error))))


def _short(value: float) -> str:
    return f"{value:.2g}"


def _bend_text(fit: Fit) -> str:
    if not fit.bend_angles:
        return "not given, so the answer is μφ; --bend-angle makes it μ"
    text = fit.bend_angle_text
    if fit.bend_angle_uncertainty_text:
        return f"{text} +/- {fit.bend_angle_uncertainty_text}; μφ = {fit.friction_bend:.4g}"
    if len(fit.bend_angles) > 1:
        return text
    share = 100.0 * math.radians(1.0) / fit.bend_angles[0]
    return f"{text} (taken as exact; 1 deg more is {share:.1f} % less μ); μφ = {fit.friction_bend:.4g}"


def _gain_text(fit: Fit) -> str:
    if not fit.gain_estimated:
        return "1, assumed (one direction only)"
    return f"{fit.gain_ratio:.4f}, motor's cell (cell {fit.motor}) over load's, removed from μ"


def _direction_text(part: DirectionFit, digits: int) -> str:
    error = f" ± {part.standard_error:.{digits}f}" if part.standard_error is not None else ""
    return f"{part.friction:.{digits}f}{error} with a gain ratio of 1, {counted(part.used, 'reading')}"


def _plain_text(fit: Fit, digits: int) -> str:
    """What ten lines of NumPy give, and why the fit differs."""
    plain = fit.plain
    away = 100.0 * (fit.fitted / plain.friction - 1.0) if plain.friction else 0.0
    why = [
        f"{100.0 * share:+.1f} % {what}"
        for share, what in ((plain.set_aside, "by rows set aside"), (plain.fitted, "by what is fitted"))
        if abs(share) >= 5e-4
    ]
    return f"{plain.friction:.{digits}f}, median |ln ratio|; the fit is {away:+.1f} % from it" + (
        f": {', '.join(why)}" if why else ""
    )


def _part_text(part: BudgetPart) -> str:
    free = "" if math.isinf(part.degrees_of_freedom) else f", {part.degrees_of_freedom:.0f} degrees of freedom"
    return f"{_short(part.contribution)} {part.name} (type {part.type}{free})"


def _used_text(fit: Fit) -> str:
    used, total = int(fit.rows.used.sum()), len(fit.rows.used)
    strokes = counted(fit.strokes, "stroke")
    if fit.is_log:
        return f"{used:,} of {total:,} on the limit, in {strokes}"
    return f"{used:,} of {total:,} settled, in {strokes}"


def _file_text(each: dict[str, Any]) -> str:
    own = "nothing used" if each["friction"] is None else f"{each['friction']:.4g}"
    return f"{own}, {counted(each['strokes'], 'stroke')}"


def _check_text(check: Check) -> str:
    name = check.name.replace("_", " ")
    unit = "" if check.unit == "1" else f" {check.unit}"
    effect = f", fitted: {100.0 * check.effect:+.1f} % of μ without it" if check.effect else ""
    return f"  {name:<20}{check.value:.3g} ± {check.standard_error:.2g}{unit}{effect}"


def as_json(fit: Fit) -> dict[str, Any]:
    """The fit as plain JSON values, angles in rad."""
    used = fit.rows.used
    interval = fit.interval_95
    left = fit.rows.residual[used]
    largest = np.argsort(-np.abs(left), kind="stable")[:_MOST_RESIDUALS]
    lines = fit.rows.line[used]
    return {
        "friction": fit.friction,
        "standard_error": fit.standard_error,
        "interval_95": None if interval is None else list(interval),
        "friction_bend": fit.friction_bend,
        "friction_bend_standard_error": fit.friction_bend_standard_error,
        "friction_bend_interval_95": list(fit.friction_bend_interval_95),
        "bend_angle": None
        if not fit.bend_angles
        else fit.bend_angles[0]
        if len(fit.bend_angles) == 1
        else list(fit.bend_angles),
        "gain_ratio": fit.gain_ratio,
        "by_direction": {name: _direction(part) for name, part in fit.by_direction.items()},
        "plain": {
            "friction": fit.plain.friction,
            "moved_by_rows": fit.plain.set_aside,
            "moved_by_fit": fit.plain.fitted,
        },
        "budget": [_part(part) for part in fit.uncertainty.parts],
        "coverage_factor": fit.uncertainty.coverage,
        "degrees_of_freedom": _finite(fit.uncertainty.degrees_of_freedom),
        "strokes": fit.strokes,
        "speed": asdict(fit.speed) if fit.speed else None,
        "presliding": asdict(fit.presliding) if fit.presliding else None,
        "files": list(fit.files),
        "used": int(used.sum()),
        "set_aside": [
            {"reason": part.reason, "rows": part.rows, "lines": [list(stretch) for stretch in part.lines]}
            for part in fit.set_aside
        ],
        "residuals": {
            "rms": float(np.sqrt(np.mean(left**2))),
            "max": float(np.max(np.abs(left))),
            "rows": [{"line": int(lines[at]), "residual": float(left[at])} for at in largest],
        },
        "warnings": list(fit.warnings),
        "notes": list(fit.notes),
        "checks": [_check(check) for check in fit.checks],
        "unit": fit.unit,
        "source": fit.source,
        "sha256": fit.sha256,
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _part(part: BudgetPart) -> dict[str, Any]:
    return {
        "name": part.name, "type": part.type, "standard_uncertainty": part.value, "unit": part.unit,
        "sensitivity": part.sensitivity, "contribution": part.contribution,
        "degrees_of_freedom": _finite(part.degrees_of_freedom),
    }  # fmt: skip


def _check(check: Check) -> dict[str, Any]:
    return {
        "name": check.name, "value": check.value, "standard_error": check.standard_error, "unit": check.unit,
        "found": check.found, "effect_on_friction": check.effect,
    }  # fmt: skip


def _direction(part: DirectionFit) -> dict[str, Any]:
    return {"friction": part.friction, "standard_error": part.standard_error, "plain": part.plain, "used": part.used}


def fragment_text(fit: Fit) -> str:
    """The coefficient (or μφ) for a study, how far it can be trusted, and where it comes from."""
    values: dict[str, str] = {}
    if fit.friction is not None and fit.interval_95 is not None:
        values = {
            "coefficient": repr(fit.friction), "standard_error": repr(fit.standard_error),
            "interval_95": repr(list(fit.interval_95)), "bend_angle": _quoted(fit.bend_angle_text),
            "bend_angle_uncertainty": _quoted(fit.bend_angle_uncertainty_text or ""),
        }  # fmt: skip
    values |= {
        "friction_bend": repr(fit.friction_bend),
        "friction_bend_standard_error": repr(fit.friction_bend_standard_error),
        "gain_ratio": repr(fit.gain_ratio),
        "source": _quoted(fit.source),
        "sha256": _quoted(fit.sha256),
        "rows_used": str(int(fit.rows.used.sum())),
        "rows_set_aside": str(int((~fit.rows.used).sum())),
        "tendon_version": _quoted(__version__),
    }
    lines = [f"{key} = {value}" for key, value in values.items() if value != _quoted("")]
    return "\n".join([_HEADER_OF_A_PRODUCT if fit.friction is None else _HEADER, "[friction]", *lines, ""])


def write_fragment(fit: Fit, path: Path) -> None:
    """Write the fragment, whole or not at all; raises OutputError."""
    write_whole(path, fragment_text(fit).encode())


def _quoted(text: str) -> str:
    """A TOML basic string; its escapes are those of JSON, and the one JSON leaves out (DEL) is written too."""
    return json.dumps(text.encode("utf-8", "replace").decode(), ensure_ascii=False).replace("\x7f", "\\u007f")
