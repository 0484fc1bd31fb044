"""The figure of a friction fit.

Readings are drawn with the fitted line: in colour if they slip, in grey if they are set aside.
Below are the residuals, two checks of the rig, the hysteresis loop, and the error budget or the
speeds.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli.cube.labels import plain
from tendon_cli.figures.backend import Axes, Figure, Line2D
from tendon_cli.figures.frame import Page, framed
from tendon_cli.figures.style import format_of, house_style, key_line
from tendon_cli.studies.space.axis import evenly_spaced

_PULLED = "#0063a6"
_DRAGGED = "#b4490a"
_ASIDE = "#a6a6a6"
_LINE = "#1a1a1a"
_HEIGHT = 205.0
"""Height of the panels, mm."""
MARK = "tendon fit-friction"
"""Mark in the metadata of a figure, which `is_figure` of `files.py` looks for."""
_MOST_POINTS = 20_000
"""Readings of a log are thinned out to about this number."""
_STROKE_POINTS = 60
"""Largest number of points of the fitted line of a stroke."""
_LEVEL = 0.02
"""Values along x that vary by a smaller share than this are drawn close together."""
_TESTS = {
    "offset_motor": "zero of the motor's cell",
    "offset_load": "zero of the load's cell",
    "gain": "gain of the cells",
    "delay": "a late cell",
    "force_dependence": "dependence on the force",
    "drift": "drift",
}
"""Checks of a fit, and what each of them tests."""
_NEVER_TESTED = "the bend angle"
"""Name of what no reading shows."""
_DIRECTIONS = ((1, _PULLED, "o", "toward motor"), (-1, _DRAGGED, "s", "toward load"))
"""Sign, colour, marker and name of each direction of slip."""


def draw(fit: Any, path: Path, *, overwrite: bool = False) -> None:
    """Write the figure of a fit as PNG, SVG or PDF, by the file's ending.

    The same fit (a `friction.Fit`) gives the same bytes. A file that tendon did not write is
    replaced only if `overwrite` is true.

    Raises:
        UsageError: The ending is not that of a figure, or tendon did not write the file.
        OutputError: The file cannot be written.
    """
    format_of(path, "--plot")
    fit_page(fit).save(path, overwrite=overwrite)


def fit_page(fit: Any) -> Page:
    """Draw readings and fit, what may be wrong with the rig, and the residuals."""
    low, high = fit.uncertainty.interval_95
    name = "Friction over the bend μφ"
    if fit.bend.text != "not given":
        name = "Friction coefficient μ"
    title = f"{name} = {fit.fitted:.4f} (95 % interval {low:.4f} to {high:.4f})"
    source = fit.source[:60]
    note = f"{source}, bend angle {fit.bend.text}, gain ratio {fit.gain_ratio:.4f}"
    verdict = _verdict(fit)
    colour = _DRAGGED if fit.warnings else _LINE
    # ASCII, which every format keeps as it is, so that tendon recognises its own figure.
    study = f"{MARK} {source.encode('ascii', 'replace').decode()}, SHA-256 {fit.sha256}"
    with house_style():
        page = framed(title, _HEIGHT, _key(fit), [plain(note), *_thinned(fit)], study=study)
        upper = _draw_panels(page.figure, fit)
        text = "\n".join(plain(sentence, width=105) for sentence in verdict)
        upper.set_title(text, loc="left", fontsize=7.5, color=colour)
    return replace(page, says=" ".join((*verdict, page.says)))


def _thinned(fit: Any) -> list[str]:
    """Return a sentence that says how many readings are drawn, if not all."""
    every = len(fit.rows) // _MOST_POINTS
    if not fit.is_log or every < 2:
        return []
    shown = -(-len(fit.rows) // every)
    return [f"Shown: {shown:,} of {len(fit.rows):,} readings, evenly spaced."]


def _draw_panels(figure: Figure, fit: Any) -> Axes:
    """Draw the panels. Return the uppermost."""
    grid = figure.add_gridspec(4, 2, height_ratios=[2.2, 1.0, 1.2, 1.4])
    upper = figure.add_subplot(grid[0, :])
    lower = figure.add_subplot(grid[1, :], sharex=upper)
    upper.tick_params(labelbottom=False)
    by_force = figure.add_subplot(grid[2, 0])
    by_rate = figure.add_subplot(grid[2, 1])
    by_rate.sharey(by_force)
    unit = f" (1/{fit.unit})" if fit.unit else ""
    _draw_check(by_force, fit, "zero", "Zero error of a cell?", f"1 / force at load{unit}")
    _draw_check(by_rate, fit, "delay", "A late cell?", "d ln F/dt (per unit of time)")
    by_force.set_ylabel("residual, other\neffects taken off")
    by_rate.tick_params(labelleft=False)
    _draw_loop(figure.add_subplot(grid[3, 0]), fit)
    last = figure.add_subplot(grid[3, 1])
    if fit.speed is None:
        _draw_budget(last, fit)
    else:
        _draw_speed(last, fit)
    if fit.is_log:
        _draw_log(upper, lower, fit)
    else:
        _draw_settled(upper, lower, fit)
    _leave_out(upper, fit)
    upper.set_ylabel("ln (force at motor / force at load)")
    lower.set_ylabel("residual")
    lower.axhline(0.0, color=_LINE, linewidth=1.0, zorder=1)
    # A symmetrical scale, so that a one-sided residual looks one-sided.
    largest = 1.15 * float(np.nanmax(np.abs(fit.rows.residual), initial=1e-9))
    lower.set_ylim(-largest, largest)
    return upper


def _leave_out(axes: Axes, fit: Any) -> None:
    """Keep the rows that are in no stroke, such as those without load, from widening the axis."""
    ratios = fit.rows["log_ratio"]
    of_strokes = ratios[fit.rows["run"] >= 0]
    low = float(of_strokes.min())
    high = float(of_strokes.max())
    margin = max(0.1 * (high - low), 1e-9)
    if ratios.min() < low - margin or ratios.max() > high + margin:
        axes.set_ylim(low - margin, high + margin)


def _key(fit: Any) -> list[Line2D]:
    """Return the key to the markers and lines in the figure."""
    rows = fit.rows.to_records(index=False)
    entries = [
        (f"slipping {name}" if fit.is_log else name, colour, marker)
        for sign, colour, marker, name in _DIRECTIONS
        if np.any(rows.used & (rows.way == sign))
    ]
    if np.any(~rows.used & np.isfinite(rows.log_ratio)):
        entries.append(("set aside", _ASIDE, "x"))
    if np.any(fit.points.effects):
        entries.append(("effects fitted", _LINE, "."))
    key = [
        key_line(linestyle="", marker="." if fit.is_log else marker, color=colour, label=text)
        for text, colour, marker in entries
    ]
    settled = "fit: slope μ, height at 0 = ln gain ratio"
    label = "fit; below, mean of a stroke" if fit.is_log else settled
    return [*key, key_line(color=_LINE, linewidth=1.6, label=label)]


def _verdict(fit: Any) -> list[str]:
    """Return sentences that say what may be wrong with the readings, or what was not tested."""
    sentences = [f"Warning: {text}" for text in fit.warnings]
    if not sentences:
        tested = {check.name for check in fit.checks if check.found is not None}
        untested = [name for check, name in _TESTS.items() if check not in tested]
        found = [_TESTS[check.name] for check in fit.checks if check.found and check.name in _TESTS]
        start = f"Found and allowed for: {', '.join(found)}" if found else "No fault found"
        sentences.append(f"{start}; not tested: {', '.join([*untested, _NEVER_TESTED])}.")
    sentences += [
        f"Note: {text}" for text in fit.notes if "zero error" in text or "without load" in text
    ]
    return sentences


def _draw_check(axes: Axes, fit: Any, effect: str, name: str, label: str) -> None:
    """Draw what one effect of the rig may explain, and the part of it that was fitted.

    Offsets show as a slope along 1/F, a delay as one along d ln F/dt. The parts of the other
    effects are taken off, so that points are level if the rig is free of this one, whatever else it
    has.

    Args:
        axes: The panel.
        fit: The fit.
        effect: "zero" for the cells' offsets, "delay" for a late cell.
        name: The question that the panel answers.
        label: Label of x.
    """
    _set_title(axes, f"{name} A slope would show it", label)
    axes.axhline(0.0, color=_LINE, linewidth=0.8, zorder=1)
    if effect == "delay" and "rate" not in fit.points:
        axes.text(0.5, 0.8, "no time in the file", transform=axes.transAxes, ha="center")
        axes.set_xticks([])
        return
    along = 1.0 / fit.points["force"] if effect == "zero" else fit.points["rate"]
    delay = fit.points["delay"]
    zero = fit.points["effects"] - delay
    fitted, others = (zero, delay) if effect == "zero" else (delay, zero)
    left = fit.points["misfit"] - others
    points = fit.points.assign(along=along, left=left, fitted=fitted)
    has_effect = np.any(fitted)
    for sign, colour, marker, _ in _DIRECTIONS:
        part = points[points["way"] == sign]
        x = part["along"]
        axes.plot(x, part["left"], marker, color=colour, markersize=2.5, alpha=0.6)
        if has_effect:
            axes.plot(x, part["fitted"], ".", color=_LINE, markersize=2.0)
    _widen(axes, along, 0.5)


def _set_title(axes: Axes, title: str, label: str) -> None:
    """Set the title of a panel and the label of its x axis."""
    axes.set_title(title, loc="left", fontsize=7.5)
    axes.set_xlabel(label)
    axes.locator_params(axis="x", nbins=5)


def _widen(axes: Axes, along: Any, margin: float) -> None:
    """Widen the view of values that hardly vary, so that they are in the middle of the panel."""
    if np.ptp(along) < _LEVEL * float(np.max(np.abs(along))):
        axes.margins(x=margin)


def _draw_loop(axes: Axes, fit: Any) -> None:
    """Draw the hysteresis loop: the force at the motor over its position.

    If the file has no position, it is drawn over the force at the load.
    """
    rows = fit.rows.to_records(index=False)
    unit = f" ({fit.unit})" if fit.unit else ""
    has_position = "position" in fit.rows
    across = rows.position if has_position else rows.load
    known = np.flatnonzero(np.isfinite(rows.log_ratio) & np.isfinite(across))
    known = known[:: max(1, len(known) // _MOST_POINTS)]
    groups = [(~rows.used, _ASIDE)]
    groups += [(rows.used & (rows.way == sign), colour) for sign, colour, _, _ in _DIRECTIONS]
    size = 2.5 if fit.is_log else 7.0
    for is_member, colour in groups:
        part = known[is_member[known]]
        axes.plot(
            across[part], rows.motor[part], ".", color=colour, markersize=size, rasterized=True
        )
    title = "Loop of hysteresis" if fit.is_log else "Forces of the readings"
    label = "position of the motor, as in the file" if has_position else f"force at load{unit}"
    _set_title(axes, title, label)
    axes.set_ylabel(f"force at motor{unit}")
    of_strokes = known[rows.run[known] >= 0] if fit.is_log else known
    if len(of_strokes) < len(known):
        # The rows without load would squeeze the strokes into a corner.
        _zoom(axes, across[of_strokes], rows.motor[of_strokes])
    _widen(axes, across[of_strokes], 2.0)


def _zoom(axes: Axes, across: Any, up: Any) -> None:
    """Limit a panel to some of its points."""
    for values, set_limits in ((across, axes.set_xlim), (up, axes.set_ylim)):
        low = float(values.min())
        high = float(values.max())
        room = max(0.08 * (high - low), _LEVEL * abs(high), 1e-9)
        set_limits(low - room, high + room)


def _draw_budget(axes: Axes, fit: Any) -> None:
    """Draw each contribution to the standard error, in per cent of the fitted number."""
    parts = sorted(fit.uncertainty.parts, key=lambda part: part.contribution)
    widths = [100.0 * part.contribution / fit.fitted for part in parts]
    axes.barh(range(len(parts)), widths, color=_PULLED, height=0.55)
    for row, (part, width) in enumerate(zip(parts, widths, strict=True)):
        text = f" {part.name} (type {part.type}), {width:.2g} %"
        axes.text(0.0, row + 0.42, text, fontsize=6.5, va="center")
    axes.set_ylim(-0.6, max(len(parts), 3) - 0.1)
    axes.set_yticks([])
    label = "part of the standard error (% of the number)"
    _set_title(axes, "What the standard error is made of", label)


def _draw_speed(axes: Axes, fit: Any) -> None:
    """Draw the coefficient of each stroke over the motor's speed."""
    for _, colour, marker, name in _DIRECTIONS:
        strokes = fit.stroke_table[fit.stroke_table["direction"] == name]
        axes.plot(strokes["speed"], strokes["friction"], marker, color=colour, markersize=3.5)
    power = f"{fit.speed.power:.3f} ± {fit.speed.standard_error:.2g}"
    _set_title(axes, f"Against speed: to the power {power}", "speed of the motor, as in the file")
    axes.set_ylabel("coefficient of a stroke")


def _draw_settled(upper: Axes, lower: Axes, fit: Any) -> None:
    """Draw settled readings over the bend angle, positive if they slip toward the motor.

    The slope of the line is the coefficient, its height at 0 the log of the gain ratio.
    """
    rows = fit.rows.to_records(index=False)
    signed = np.degrees(rows.way * rows.bend_angle)
    reach = 1.15 * float(np.max(np.abs(signed)))
    ends = np.array([-reach, reach])
    height = fit.fitted * np.radians(ends) + np.log(fit.gain_ratio)
    upper.plot(ends, height, color=_LINE, linewidth=1.2, zorder=1)
    upper.axhline(0.0, color="#cccccc", linewidth=0.8, zorder=0)
    upper.axvline(0.0, color="#cccccc", linewidth=0.8, zorder=0)
    for sign, colour, marker, _ in _DIRECTIONS:
        part = rows.used & (rows.way == sign)
        style: dict[str, Any] = {"color": colour, "markersize": 5, "alpha": 0.8}
        upper.plot(signed[part], rows.log_ratio[part], marker, **style)
        lower.plot(signed[part], rows.residual[part], marker, **style)
    aside = ~rows.used & np.isfinite(rows.log_ratio)
    upper.plot(signed[aside], rows.log_ratio[aside], "x", color=_ASIDE, markersize=5)
    lower.set_xlabel("bend angle (deg), + pulled toward the motor, − toward the load")


def _draw_log(upper: Axes, lower: Axes, fit: Any) -> None:
    """Draw a log over its time, or over its lines if it has no time.

    The log ratio goes back and forth between two levels, one for each direction of slip. Readings
    on the way from one to the other are set aside and grey.
    """
    rows = fit.rows.to_records(index=False)
    has_time = "time" in fit.rows
    place = rows.time if has_time else rows.line.astype(np.float64)
    shown = np.arange(0, len(place), max(1, len(place) // _MOST_POINTS))
    fitted = rows.log_ratio - rows.residual
    mean_residual = fit.rows[fit.rows["used"]].groupby("run")["residual"].mean()
    aside = shown[~rows.used[shown]]
    style: dict[str, Any] = {"ls": "none", "marker": ".", "mew": 0, "ms": 4, "rasterized": True}
    upper.plot(place[aside], rows.log_ratio[aside], color=_ASIDE, **style)
    for sign, colour, _, _ in _DIRECTIONS:
        is_sliding = rows.used & (rows.way == sign)
        part = shown[is_sliding[shown]]
        upper.plot(place[part], rows.log_ratio[part], color=colour, **style)
        lower.plot(place[part], rows.residual[part], color=colour, alpha=0.35, **style)
        for run in np.unique(rows.run[part]):
            stroke = np.flatnonzero(rows.used & (rows.run == run))
            stroke = stroke[evenly_spaced(len(stroke), _STROKE_POINTS)]
            ends = stroke[[0, -1]]
            upper.plot(place[stroke], fitted[stroke], color=_LINE, linewidth=1.2)
            lower.plot(place[ends], [mean_residual[run]] * 2, color=_LINE, linewidth=1.6)
    lower.set_xlabel("time, as in the file" if has_time else "line of the file")
