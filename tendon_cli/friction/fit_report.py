"""A friction fit as people read it, as programs do, and as files: a fragment for a study, a table of strokes."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from tendon_cli.files import write_whole
from tendon_cli.friction.fit_result import Fit
from tendon_cli.units import counted, shorten
from tendon_cli.version import __version__

_STROKES_MARK = "# strokes of a log, by tendon fit-friction"
_MARK = "# A friction coefficient fitted by `tendon fit-friction`."
"""The first line of a fragment; a file without it is nobody's to write over."""
_HEADER = f"""\
{_MARK} A study takes it by
#     [sheath]
#     friction_from = "friction.toml"
"""
_OF_THE_RIG = "# The bend angle is that of the rig, not of the study's sheath.\n"
_OF_ONE_SHEATH = '#     bend_angle = "..."      # not given here: of the same sheath, as it was when μφ was measured\n'


def summary_lines(fit: Fit) -> str:
    """A short readable summary."""
    error, digits = fit.uncertainty, _digits(fit.uncertainty.standard_error)
    low, high = error.interval_95
    rows = [
        (
            "95 % interval",
            f"{low:.{digits}f} to {high:.{digits}f}, standard error {error.standard_error:.2g}",
        ),
        ("bend angle", _bend_text(fit)),
        ("gain ratio", _gain_text(fit)),
    ]
    for name, part in fit.by_direction.items():
        scatter = f" ± {part.standard_error:.{digits}f}" if part.standard_error is not None else ""
        text = f"{part.friction:.{digits}f}{scatter} with a gain ratio of 1, {counted(part.used, 'reading')}"
        rows.append((name.replace("_", " "), text))
    rows.append(("plain answer", _plain_text(fit, digits)))
    for at, each in enumerate(error.parts):
        degrees = each.degrees_of_freedom
        free = "" if math.isinf(degrees) else f", {degrees:.0f} degrees of freedom"
        text = f"{each.contribution:.2g} {each.name} (type {each.type}{free})"
        rows.append(("" if at else "standard error from", text))
    rows += _of_the_readings(fit)
    what = "friction over the bend  μφ" if fit.friction is None else "friction coefficient  μ"
    lines = [f"{what} = {fit.fitted:.{digits}f}", *(f"  {name:<20}{text}" for name, text in rows)]
    lines += [f"note: {text}" for text in fit.notes] + [f"warning: {text}" for text in fit.warnings]
    return "\n".join(lines)


def _of_the_readings(fit: Fit) -> list[tuple[str, str]]:
    """Which readings are used, and what else they show."""
    where = "on the limit" if fit.is_log else "settled"
    used = f"{fit.rows['used'].sum():,} of {len(fit.rows):,} {where}, in {counted(fit.strokes, 'stroke')}"
    rows = [
        ("readings", used),
        *(("set aside", f"{aside.rows}: {aside.reason}") for aside in fit.set_aside),
    ]
    if speed := fit.speed:
        span = f"from {speed.slowest:.3g} to {speed.fastest:.3g}"
        rows.append(("power of speed", f"{speed.power:+.3f} ± {speed.standard_error:.2g}, {span}"))
    if before := fit.presliding:
        stiff = f"stiffness {before.stiffness:.3g}, backlash {before.backlash:.3g}"
        rows.append(("before it slides", f"{stiff}, {counted(before.reversals, 'reversal')}"))
    for file in fit.files:
        text = "nothing used" if file["friction"] is None else f"{file['friction']:.4g}"
        rows.append((shorten(file["file"], 18), f"{text}, {counted(file['strokes'], 'stroke')}"))
    for check in fit.checks:
        if check.found and check.name != "gain":
            unit = "" if check.unit == "1" else f" {check.unit}"
            effect = check.effect_on_friction
            without = f", fitted: {100.0 * effect:+.1f} % of μ without it" if effect else ""
            text = f"{check.value:.3g} ± {check.standard_error:.2g}{unit}{without}"
            rows.append((check.name.replace("_", " "), text))
    return rows


def _digits(error: float) -> int:
    """Decimals that show the standard error with two significant digits."""
    return min(9, max(2, 1 - math.floor(math.log10(error))))


def _bend_text(fit: Fit) -> str:
    text, product = fit.bend.text, f"μφ = {fit.friction_bend:.4g}"
    if not fit.bend_angles:
        return "not given, so the answer is μφ; --bend-angle makes it μ"
    if fit.bend.uncertainty_text:
        return f"{text} +/- {fit.bend.uncertainty_text}; {product}"
    if len(fit.bend_angles) > 1:
        return text
    share = 100.0 * math.radians(1.0) / fit.bend_angles[0]
    return f"{text} (taken as exact; 1 deg more is {share:.1f} % less μ); {product}"


def _gain_text(fit: Fit) -> str:
    if len(fit.by_direction) == 1:
        return "1, assumed (one direction only)"
    return f"{fit.gain_ratio:.4f}, motor's cell (cell {fit.motor}) over load's, removed from μ"


def _plain_text(fit: Fit, digits: int) -> str:
    """What ten lines of NumPy give, and why the fit differs."""
    plain = fit.plain
    moves = {"by rows set aside": plain.moved_by_rows, "by what is fitted": plain.moved_by_fit}
    why = ", ".join(
        f"{100.0 * share:+.1f} % {what}" for what, share in moves.items() if abs(share) >= 5e-4
    )
    text = f"{plain.friction:.{digits}f}, median |ln ratio|; the fit is {100.0 * fit.from_plain:+.1f} % from it"
    return f"{text}: {why}" if why else text


def write_fragment(fit: Fit, path: Path) -> None:
    """Write the coefficient (or μφ) for a study, how far it can be trusted, and where it comes from.

    The file is written whole or not at all; raises OutputError.
    """
    values: dict[str, Any] = {
        "coefficient": fit.friction,
        "standard_error": fit.standard_error,
        "interval_95": fit.interval_95,
        "bend_angle": fit.bend.text,
        "bend_angle_uncertainty": fit.bend.uncertainty_text,
    }
    values = {} if fit.friction is None else values
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
    """A value in TOML; a basic string's escapes are those of JSON, and the one JSON leaves out (DEL) is written too."""
    if not isinstance(value, str):
        return repr(list(value) if isinstance(value, tuple) else value)
    return json.dumps(value.encode("utf-8", "replace").decode(), ensure_ascii=False).replace(
        "\x7f", "\\u007f"
    )


def write_strokes(fit: Fit, path: Path) -> None:
    """Write the table of strokes as CSV; raises OutputError."""
    write_whole(path, f"{_STROKES_MARK}\n{fit.stroke_table.to_csv(index=False)}".encode())
