"""The figure of a friction fit: readings against the fitted line, slip and stick told apart, residuals below."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli.cube.labels import plain
from tendon_cli.figures.backend import Axes, Figure, Line2D
from tendon_cli.figures.frame import Page, framed
from tendon_cli.figures.style import format_of, house_style

_PULLED, _DRAGGED, _ASIDE, _LINE = "#0063a6", "#b4490a", "#a6a6a6", "#1a1a1a"
_HEIGHT = 205.0
"""Of the panels, mm."""
MARK = "tendon fit-friction"
"""In what a figure says of itself; a file without it is nobody's to write over."""
_MOST_POINTS = 20_000
_LEVEL = 0.02
"""A force that varies by less, as a share, is drawn as the constant it is."""
_WAYS = ((1, _PULLED, "o", "toward motor"), (-1, _DRAGGED, "s", "toward load"))


def draw(fit: Any, path: Path) -> None:
    """Write the figure as PNG, SVG or PDF, by the file's ending; the same fit (a `friction.Fit`) gives the same bytes.

    Raises UsageError for another ending, OutputError where the file cannot be written.
    """
    format_of(path, "--plot")
    fit_page(fit).save(path)


def fit_page(fit: Any) -> Page:
    """Readings and fit, what may be wrong with the rig, and the residuals."""
    low, high = fit.uncertainty.interval_95
    what = "Friction coefficient μ" if fit.bend.text != "not given" else "Friction over the bend μφ"
    title = f"{what} = {fit.fitted:.4f} (95 % interval {low:.4f} to {high:.4f})"
    note = f"{fit.source[:60]}, bend angle {fit.bend.text}, gain ratio {fit.gain_ratio:.4f}"
    words, colour = _verdict(fit)
    # In letters that every format keeps as they are, so that tendon knows its own figure again.
    study = f"{MARK} {fit.source[:60].encode('ascii', 'replace').decode()}, SHA-256 {fit.sha256}"
    with house_style():
        page = framed(title, _HEIGHT, _key(fit), [plain(note)], study=study)
        upper = _compose(page.figure, fit)
        upper.set_title(
            "\n".join(plain(text, width=105) for text in words),
            loc="left",
            fontsize=7.5,
            color=colour,
        )
    return replace(page, says=" ".join((*words, page.says)))


def _compose(figure: Figure, fit: Any) -> Axes:
    """Draw the panels; gives the uppermost."""
    grid = figure.add_gridspec(4, 2, height_ratios=[2.2, 1.0, 1.2, 1.4])
    upper = figure.add_subplot(grid[0, :])
    lower = figure.add_subplot(grid[1, :], sharex=upper)
    upper.tick_params(labelbottom=False)
    by_force, by_rate = figure.add_subplot(grid[2, 0]), figure.add_subplot(grid[2, 1])
    by_rate.sharey(by_force)
    unit = f" / {fit.unit}$^{{-1}}$" if fit.unit else ""
    _draw_check(
        by_force,
        fit,
        1.0 / fit.points["force"],
        "Zero error of a cell?",
        f"1 / force at load{unit}",
    )
    _draw_check(by_rate, fit, fit.points.get("rate"), "A late cell?", "d ln F/dt, per unit of time")
    by_force.set_ylabel("residual before\noffsets and delay")
    by_rate.tick_params(labelleft=False)
    _draw_loop(figure.add_subplot(grid[3, 0]), fit)
    (_draw_budget if fit.speed is None else _draw_speed)(figure.add_subplot(grid[3, 1]), fit)
    (_draw_log if fit.is_log else _draw_settled)(upper, lower, fit)
    upper.set_ylabel("ln (force at motor / force at load)")
    lower.set_ylabel("residual")
    lower.axhline(0.0, color=_LINE, linewidth=1.0, zorder=1)
    # A symmetrical scale, so that a one-sided residual looks one-sided.
    largest = 1.15 * float(np.nanmax(np.abs(fit.rows.residual), initial=1e-9))
    lower.set_ylim(-largest, largest)
    return upper


def _key(fit: Any) -> list[Line2D]:
    """The signs of what is in the figure."""
    rows = fit.rows.to_records(index=False)
    key = []
    for way, colour, marker, name in _WAYS:
        if np.any(rows.used & (rows.way == way)):
            sign, label = (".", f"slipping {name}") if fit.is_log else (marker, name)
            key.append(Line2D([], [], linestyle="none", marker=sign, color=colour, label=label))
    line = (
        "fit; below, mean of a stroke"
        if fit.is_log
        else "fit: slope μ, height at 0 = ln gain ratio"
    )
    key.append(Line2D([], [], color=_LINE, linewidth=1.6, label=line))
    if np.any(~rows.used & np.isfinite(rows.log_ratio)):
        sign = "." if fit.is_log else "x"
        key.append(Line2D([], [], linestyle="none", marker=sign, color=_ASIDE, label="set aside"))
    if np.any(fit.points.effects):
        key.append(
            Line2D(
                [],
                [],
                linestyle="none",
                marker=".",
                markersize=2.0,
                color=_LINE,
                label="effects fitted",
            )
        )
    return key


def _verdict(fit: Any) -> tuple[list[str], str]:
    """What is wrong in words, if anything, and its colour."""
    notes = [f"Note: {text}" for text in fit.notes if "zero error" in text]
    warnings = [f"Warning: {text}" for text in fit.warnings] or [
        "Nothing in the readings makes this number wrong."
    ]
    return [*warnings, *notes], _DRAGGED if fit.warnings else _LINE


def _draw_check(axes: Axes, fit: Any, along: Any, name: str, across: str) -> None:
    """What offsets (along 1/F) or a delay (along d ln F/dt) make of the log ratio: nothing where points lie level."""
    _name(axes, f"{name} A slope would show it", across)
    axes.axhline(0.0, color=_LINE, linewidth=0.8, zorder=1)
    if along is None:
        axes.text(0.5, 0.8, "no time in the file", transform=axes.transAxes, ha="center")
        axes.set_xticks([])
        return
    points = fit.points.assign(along=along)
    for way, colour, marker, _ in _WAYS:
        mine = points[points["way"] == way]
        axes.plot(mine["along"], mine["misfit"], marker, color=colour, markersize=2.5, alpha=0.6)
        if np.any(points["effects"]):
            axes.plot(mine["along"], mine["effects"], ".", color=_LINE, markersize=2.0)
    _widen(axes, along, 0.5)


def _name(axes: Axes, text: str, across: str) -> None:
    """What a panel shows, and over what."""
    axes.set_title(text, loc="left", fontsize=7.5)
    axes.set_xlabel(across)
    axes.locator_params(axis="x", nbins=5)


def _widen(axes: Axes, along: Any, margin: float) -> None:
    """Leave what hardly varies in the middle of its panel."""
    if np.ptp(along) < _LEVEL * float(np.max(np.abs(along))):
        axes.margins(x=margin)


def _draw_loop(axes: Axes, fit: Any) -> None:
    """The loop of hysteresis: the motor's force over its position if it is read, else over the load's."""
    rows, unit = fit.rows.to_records(index=False), f", {fit.unit}" if fit.unit else ""
    moved = "position" in fit.rows
    across = rows.position if moved else rows.load
    known = np.flatnonzero(np.isfinite(rows.log_ratio) & np.isfinite(across))
    known, size = known[:: max(1, len(known) // _MOST_POINTS)], 2.5 if fit.is_log else 7.0
    for mine, colour in (
        (known[~rows.used[known]], _ASIDE),
        *((known[(rows.used & (rows.way == way))[known]], colour) for way, colour, _, _ in _WAYS),
    ):
        axes.plot(
            across[mine], rows.motor[mine], ".", color=colour, markersize=size, rasterized=True
        )
    name = "Loop of hysteresis" if fit.is_log else "Forces of the readings"
    _name(axes, name, "position of the motor, as in the file" if moved else f"force at load{unit}")
    axes.set_ylabel(f"force at motor{unit}")
    _widen(axes, across[known], 2.0)


def _draw_budget(axes: Axes, fit: Any) -> None:
    """What the standard error is made of, in per cent of the number."""
    parts = sorted(fit.uncertainty.parts, key=lambda part: part.contribution)
    widths = [100.0 * part.contribution / fit.fitted for part in parts]
    axes.barh(range(len(parts)), widths, color=_PULLED, height=0.55)
    for row, (part, width) in enumerate(zip(parts, widths, strict=True)):
        axes.text(
            0.0,
            row + 0.42,
            f" {part.name} (type {part.type}), {width:.2g} %",
            fontsize=6.5,
            va="center",
        )
    axes.set_ylim(-0.6, max(len(parts), 3) - 0.1)
    axes.set_yticks([])
    _name(axes, "What the standard error is made of", "part of the standard error, % of the number")


def _draw_speed(axes: Axes, fit: Any) -> None:
    """The coefficient of each stroke over the motor's speed."""
    for _, colour, marker, name in _WAYS:
        strokes = fit.stroke_table[fit.stroke_table["direction"] == name]
        axes.plot(strokes["speed"], strokes["friction"], marker, color=colour, markersize=3.5)
    name = f"Against speed: to the power {fit.speed.power:.3f} ± {fit.speed.standard_error:.2g}"
    _name(axes, name, "speed of the motor, as in the file")
    axes.set_ylabel("coefficient of a stroke")


def _draw_settled(upper: Axes, lower: Axes, fit: Any) -> None:
    """Every reading at plus or minus its bend angle: the slope is the coefficient, the height at 0 the gain."""
    rows = fit.rows.to_records(index=False)
    signed = np.degrees(rows.way * rows.bend_angle)
    reach = 1.15 * float(np.max(np.abs(signed)))
    ends = np.array([-reach, reach])
    height = fit.fitted * np.radians(ends) + np.log(fit.gain_ratio)
    upper.plot(ends, height, color=_LINE, linewidth=1.2, zorder=1)
    upper.axhline(0.0, color="#cccccc", linewidth=0.8, zorder=0)
    upper.axvline(0.0, color="#cccccc", linewidth=0.8, zorder=0)
    for way, colour, marker, _ in _WAYS:
        mine = rows.used & (rows.way == way)
        upper.plot(
            signed[mine], rows.log_ratio[mine], marker, color=colour, markersize=5, alpha=0.8
        )
        lower.plot(signed[mine], rows.residual[mine], marker, color=colour, markersize=5, alpha=0.8)
    aside = ~rows.used & np.isfinite(rows.log_ratio)
    upper.plot(signed[aside], rows.log_ratio[aside], "x", color=_ASIDE, markersize=5)
    lower.set_xlabel("bend angle, deg   (+ pulled toward the motor, − toward the load)")


def _draw_log(upper: Axes, lower: Axes, fit: Any) -> None:
    """The log in its own order: the two limits that the ratio reaches, and the way between them in grey."""
    rows = fit.rows.to_records(index=False)
    timed = "time" in fit.rows
    place = rows.time if timed else rows.line.astype(np.float64)
    shown = np.arange(0, len(place), max(1, len(place) // _MOST_POINTS))
    residual = fit.rows[fit.rows["used"]].groupby("run")["residual"].mean()
    aside = shown[~rows.used[shown]]
    style: dict[str, Any] = {"ls": "none", "marker": ".", "mew": 0, "ms": 4, "rasterized": True}
    upper.plot(place[aside], rows.log_ratio[aside], color=_ASIDE, **style)
    for way, colour, _, _ in _WAYS:
        mine = shown[(rows.used & (rows.way == way))[shown]]
        upper.plot(place[mine], rows.log_ratio[mine], color=colour, **style)
        lower.plot(place[mine], rows.residual[mine], color=colour, alpha=0.35, **style)
        for stroke in np.unique(rows.run[mine]):
            part = np.flatnonzero(rows.used & (rows.run == stroke))
            part = part[np.unique(np.linspace(0, len(part) - 1, 60).astype(int))]
            upper.plot(
                place[part], (rows.log_ratio - rows.residual)[part], color=_LINE, linewidth=1.2
            )
            lower.plot(place[part[[0, -1]]], [residual[stroke]] * 2, color=_LINE, linewidth=1.6)
    lower.set_xlabel("time, as in the file" if timed else "line of the file")
