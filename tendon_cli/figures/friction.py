"""The figure of a friction fit: readings against the fitted line, slip and stick told apart, residuals below."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from tendon_cli.errors import UsageError
from tendon_cli.figures.engine import Axes, Figure
from tendon_cli.figures.style import FORMATS, PAGE_WIDTH, house_style, new_figure, save

_PULLED, _DRAGGED, _ASIDE, _LINE = "#0063a6", "#b4490a", "#a6a6a6", "#1a1a1a"
_HEIGHT = 130.0
_MOST_POINTS = 20_000
_WAYS = ((1, _PULLED, "o", "toward motor"), (-1, _DRAGGED, "s", "toward load"))


class DrawnFit(Protocol):
    """The fit that is drawn, whatever made it; `uncertainty` has `interval_95`, `rows` the readings one by one."""

    @property
    def friction(self) -> float:
        """μ."""

    @property
    def gain_ratio(self) -> float:
        """Gain of the motor's cell over that of the load's."""

    @property
    def bend_angle_text(self) -> str:
        """The bend angle as it was given."""

    @property
    def is_log(self) -> bool:
        """Whether the readings are a log with strokes, and not settled readings."""

    @property
    def source(self) -> str:
        """Name of the file."""

    @property
    def uncertainty(self) -> Any:
        """With `interval_95`."""

    @property
    def rows(self) -> Any:
        """Arrays `line`, `log_ratio`, `way`, `bend_angle`, `stroke`, `residual`, `used`, and `time` or None."""


def draw(fit: DrawnFit, path: Path) -> None:
    """Write the figure as PNG, SVG or PDF, by the file's ending; the same fit gives the same bytes.

    Raises UsageError for another ending, OutputError where the file cannot be written.
    """
    if path.suffix[1:].lower() not in FORMATS:
        raise UsageError(f'"{path.name}" has no ending of a figure', where="--plot", hint=".png, .svg or .pdf")
    with house_style():
        figure = new_figure(PAGE_WIDTH, _HEIGHT)
        _compose(figure, fit)
    save(figure, path)


def _compose(figure: Figure, fit: DrawnFit) -> None:
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[2.4, 1.0])
    if fit.is_log:
        _draw_log(upper, lower, fit)
    else:
        _draw_settled(upper, lower, fit)
    low, high = fit.uncertainty.interval_95
    upper.set_title(
        f"Friction coefficient μ = {fit.friction:.4f}   (95 % interval {low:.4f} to {high:.4f})",
        loc="left",
        fontweight="bold",
    )
    upper.set_ylabel("ln (force at motor / force at load)")
    lower.set_ylabel("residual")
    lower.axhline(0.0, color=_LINE, linewidth=1.0, zorder=1)
    # A symmetrical scale, so that a one-sided residual looks one-sided.
    largest = 1.15 * float(np.nanmax(np.abs(fit.rows.residual), initial=1e-9))
    lower.set_ylim(-largest, largest)
    handles, labels = upper.get_legend_handles_labels()
    if fit.is_log:
        figure.legend(handles, labels, loc="outside lower center", ncols=2, markerscale=2.5)
    else:
        upper.legend(handles, labels, loc="upper left")
    note = f"{fit.source[:60]}, bend angle {fit.bend_angle_text}, gain ratio {fit.gain_ratio:.4f}"
    # A dollar sign in a file's name is no formula.
    lower.annotate(
        note.replace("$", r"\$"),
        xy=(1.0, 1.0), xycoords="axes fraction", xytext=(0, 3), textcoords="offset points",
        ha="right", va="bottom", color="#555555",
    )  # fmt: skip


def _draw_settled(upper: Axes, lower: Axes, fit: DrawnFit) -> None:
    """Every reading at plus or minus its bend angle: the slope is the coefficient, the height at 0 the gain."""
    rows = fit.rows
    signed = np.degrees(rows.way * rows.bend_angle)
    reach = 1.15 * float(np.max(np.abs(signed)))
    # Residuals of one angle are spread a little, in the order of the file, or they would hide each other.
    place = signed + 0.015 * reach * _position_in_group(signed)
    ends = np.array([-reach, reach])
    height = fit.friction * np.radians(ends) + np.log(fit.gain_ratio)
    upper.plot(ends, height, color=_LINE, linewidth=1.2, label="fit: slope μ, height at 0 = ln gain ratio", zorder=1)
    upper.axhline(0.0, color="#cccccc", linewidth=0.8, zorder=0)
    upper.axvline(0.0, color="#cccccc", linewidth=0.8, zorder=0)
    for way, colour, marker, name in _WAYS:
        mine = rows.used & (rows.way == way)
        if mine.any():
            upper.plot(signed[mine], rows.log_ratio[mine], marker, color=colour, markersize=5, alpha=0.8, label=name)
            lower.plot(place[mine], rows.residual[mine], marker, color=colour, markersize=5, alpha=0.8)
    aside = ~rows.used & np.isfinite(rows.log_ratio)
    if aside.any():
        upper.plot(signed[aside], rows.log_ratio[aside], "x", color=_ASIDE, markersize=5, label="set aside")
    lower.set_xlabel("bend angle, deg   (+ pulled toward the motor, − toward the load)")


def _position_in_group(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Places from -1 to 1 for readings that share a value, in their order."""
    place = np.zeros(len(values))
    for value in np.unique(values):
        mine = np.flatnonzero(values == value)
        place[mine] = np.linspace(-1.0, 1.0, len(mine)) if len(mine) > 1 else 0.0
    return place


def _draw_log(upper: Axes, lower: Axes, fit: DrawnFit) -> None:
    """The log in its own order: the two limits that the ratio reaches, and the way between them in grey."""
    rows = fit.rows
    timed = rows.time is not None
    place = rows.time if timed else rows.line.astype(np.float64)
    thin = max(1, len(place) // _MOST_POINTS)
    shown = np.arange(0, len(place), thin)
    aside = shown[~rows.used[shown]]
    style: dict[str, Any] = {
        "linestyle": "none",
        "marker": ".",
        "markeredgewidth": 0,
        "markersize": 4,
        "rasterized": True,
    }
    upper.plot(place[aside], rows.log_ratio[aside], color=_ASIDE, label="set aside (sticking)", **style)
    first = True
    for way, colour, _, name in _WAYS:
        mine = shown[(rows.used & (rows.way == way))[shown]]
        if not len(mine):
            continue
        upper.plot(place[mine], rows.log_ratio[mine], color=colour, label=f"slipping {name}", **style)
        lower.plot(place[mine], rows.residual[mine], color=colour, alpha=0.35, **style)
        for stroke in np.unique(rows.stroke[mine]):
            part = np.flatnonzero(rows.stroke == stroke)
            ends = place[part[[0, -1]]]
            fitted = (rows.log_ratio - rows.residual)[part[[0, -1]]]
            label = "fitted limit, stroke's mean" if first else None
            upper.plot(ends, fitted, color=_LINE, linewidth=1.6, label=label)
            lower.plot(ends, [float(np.mean(rows.residual[part]))] * 2, color=_LINE, linewidth=1.6)
            first = False
    lower.set_xlabel("time, as in the file" if timed else "line of the file")
