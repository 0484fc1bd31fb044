"""Report of a friction fit: a summary in words, a fragment for a study, and a table of strokes."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from tendon_cli import say
from tendon_cli.files import write_whole
from tendon_cli.friction.fit_result import Check, Fit
from tendon_cli.units import counted, shorten
from tendon_cli.version import __version__

_STROKES_MARK = "# strokes of a log, by tendon fit-friction"
_MARK = "# A friction coefficient fitted by `tendon fit-friction`."
"""Beginning of a fragment; a file without it is never overwritten."""
_HEADER = f"""\
{_MARK} To use it in a study:
#     [sheath]
#     friction_from = "friction.toml"
"""
_OF_THE_RIG = "# The bend angle is that of the rig, not of the study's sheath.\n"
_OF_ONE_SHEATH = (
    '#     bend_angle = "..."      # not known here: give that of this sheath'
    " when μφ was measured\n"
)


def summary_text(fit: Fit) -> str:
    """Return the result in words, one line for each number, note and warning."""
    uncertainty = fit.uncertainty
    digits = _digits(uncertainty.standard_error)
    low, high = uncertainty.interval_95
    interval = f"{low:.{digits}f} to {high:.{digits}f}"
    rows = [
        ("95 % interval", f"{interval}, standard error {uncertainty.standard_error:.2g}"),
        ("bend angle", _bend_text(fit)),
        ("gain ratio", _gain_text(fit)),
    ]
    for name, direction in fit.by_direction.items():
        text = f"{direction.friction:.{digits}f}"
        if direction.standard_error is not None:
            text += f" ± {direction.standard_error:.{digits}f}"
        text += f" with a gain ratio of 1, {counted(direction.used, 'reading')}"
        rows.append((say.spaced(name), text))
    rows.append(("plain answer", _plain_text(fit, digits)))
    for place, part in enumerate(uncertainty.parts):
        kind = f"type {part.type}"
        if not math.isinf(part.degrees_of_freedom):
            kind += f", {part.degrees_of_freedom:.0f} degrees of freedom"
        name = "standard error from" if place == 0 else ""
        rows.append((name, f"{part.contribution:.2g} {part.name} ({kind})"))
    rows += _readings_rows(fit)
    answer = "friction over the bend  μφ" if fit.friction is None else "friction coefficient  μ"
    lines = [f"{answer} = {fit.fitted:.{digits}f}"]
    lines += [f"  {name:<20}{text}" for name, text in rows]
    lines += [f"note: {text}" for text in fit.notes]
    lines += [f"warning: {text}" for text in fit.warnings]
    return "\n".join(lines)


def _readings_rows(fit: Fit) -> list[tuple[str, str]]:
    """Return rows on the readings used, and on what else they show."""
    where = "on the limit" if fit.is_log else "settled"
    used = f"{fit.rows['used'].sum():,} of {len(fit.rows):,} {where}"
    rows = [("readings", f"{used}, in {counted(fit.strokes, 'stroke')}")]
    rows += [("set aside", f"{aside.rows}: {aside.reason}") for aside in fit.set_aside]
    if speed := fit.speed:
        span = f"from {speed.slowest:.3g} to {speed.fastest:.3g}"
        rows.append(("power of speed", f"{speed.power:+.3f} ± {speed.standard_error:.2g}, {span}"))
    if presliding := fit.presliding:
        stiffness = f"stiffness {presliding.stiffness:.3g}, backlash {presliding.backlash:.3g}"
        reversals = counted(presliding.reversals, "reversal")
        rows.append(("before it slides", f"{stiffness}, {reversals}"))
    for file in fit.files:
        text = "nothing used" if file["friction"] is None else f"{file['friction']:.4g}"
        rows.append((shorten(file["file"], 18), f"{text}, {counted(file['strokes'], 'stroke')}"))
    for check in fit.checks:
        if check.found and check.name != "gain":
            rows.append((say.spaced(check.name), _check_text(check)))
    return rows


def _check_text(check: Check) -> str:
    """Return the size of an effect that was found, and the change of μ without it."""
    text = f"{check.value:.3g} ± {check.standard_error:.2g}"
    if check.unit != "1":
        text += f" {check.unit}"
    if check.effect_on_friction:
        text += f", fitted: {100.0 * check.effect_on_friction:+.1f} % of μ without it"
    return text


def _digits(error: float) -> int:
    """Return the decimals that show a standard error with two significant digits."""
    return min(9, max(2, 1 - math.floor(math.log10(error))))


def _bend_text(fit: Fit) -> str:
    """Return the bend angle with its uncertainty, and μφ."""
    text = fit.bend.text
    product = f"μφ = {fit.friction_bend:.4g}"
    if not fit.bend_angles:
        return "not given, so the answer is μφ; --bend-angle makes it μ"
    if fit.bend.uncertainty_text:
        return f"{text} +/- {fit.bend.uncertainty_text}; {product}"
    if len(fit.bend_angles) > 1:
        return text
    share = 100.0 * math.radians(1.0) / fit.bend_angles[0]
    return f"{text} (taken as exact; 1 deg more is {share:.1f} % less μ); {product}"


def _gain_text(fit: Fit) -> str:
    """Return the gain of the motor's cell over that of the load's."""
    if len(fit.by_direction) == 1:
        return "1, assumed (one direction only)"
    return f"{fit.gain_ratio:.4f}, motor's cell (cell {fit.motor}) over load's, removed from μ"


def _plain_text(fit: Fit, digits: int) -> str:
    """Return the plain answer, which ten lines of NumPy give, and why the fit differs."""
    plain = fit.plain
    changes = {"by rows set aside": plain.moved_by_rows, "by what is fitted": plain.moved_by_fit}
    reasons = [
        f"{100.0 * share:+.1f} % {reason}"
        for reason, share in changes.items()
        if abs(share) >= 5e-4
    ]
    text = f"{plain.friction:.{digits}f}, median |ln ratio|"
    text += f"; the fit is {100.0 * fit.from_plain:+.1f} % from it"
    return f"{text}: {', '.join(reasons)}" if reasons else text


def write_fragment(fit: Fit, path: Path) -> None:
    """Write the coefficient (or μφ) for a study, with its uncertainty and its source.

    The file is written whole or not at all.

    Raises:
        OutputError: if it cannot be written.
    """
    values: dict[str, Any] = {}
    if fit.friction is not None:
        values = {
            "coefficient": fit.friction,
            "standard_error": fit.standard_error,
            "interval_95": fit.interval_95,
            "bend_angle": fit.bend.text,
            "bend_angle_uncertainty": fit.bend.uncertainty_text,
        }
    values |= {
        "friction_bend": fit.friction_bend,
        "friction_bend_standard_error": fit.friction_bend_standard_error,
        "gain_ratio": fit.gain_ratio,
        "source": fit.source,
        "sha256": fit.sha256,
        "rows_used": int(fit.rows["used"].sum()),
        "rows_set_aside": int((~fit.rows["used"]).sum()),
        "tendon_version": __version__,
    }
    lines = [f"{key} = {_toml(value)}" for key, value in values.items() if value not in {None, ""}]
    header = _HEADER + (_OF_ONE_SHEATH if fit.friction is None else _OF_THE_RIG)
    write_whole(path, "\n".join([header, "[friction]", *lines, ""]).encode())


def _toml(value: Any) -> str:
    """Write a value in TOML.

    A basic string has the escapes of JSON, and one for DEL, which JSON leaves as it is.
    """
    if isinstance(value, tuple):
        return repr(list(value))
    if not isinstance(value, str):
        return repr(value)
    text = value.encode("utf-8", "replace").decode()
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def write_strokes(fit: Fit, path: Path) -> None:
    """Write the table of strokes as CSV.

    Raises:
        OutputError: if the file cannot be written.
    """
    write_whole(path, f"{_STROKES_MARK}\n{fit.stroke_table.to_csv(index=False)}".encode())
