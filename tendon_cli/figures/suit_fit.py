"""The figure of a fit to a suit's logs: measured loops with the model's, and what is left over.

Means over parts of strokes are drawn over the angle of the joint, each direction in its colour and
each load with its marker; the model's strokes are lines. Below are the residuals.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tendon_cli.cube.labels import plain
from tendon_cli.figures.backend import Axes, Figure, Line2D
from tendon_cli.figures.frame import Page, framed
from tendon_cli.figures.style import house_style, key_line
from tendon_cli.quantities import QUANTITIES

_FLEXION = "#0063a6"
_EXTENSION = "#b4490a"
_LINE = "#1a1a1a"
_DIRECTIONS = ((True, _FLEXION, "flexion"), (False, _EXTENSION, "extension"))
_MARKERS = ("o", "s", "^", "D", "v", "P", "X")
"""Markers of the loads, lightest first."""
_HEIGHT_OF_CHANNEL = 72.0
"""Height of the panels of one channel, mm."""
_MOST_WARNINGS = 2
MARK = "tendon fit-suit"
"""Mark in the metadata of a figure, which `is_figure` of `files.py` looks for."""


def suit_fit_page(fit: Any) -> Page:
    """Draw the loops of every channel, and their residuals.

    Args:
        fit: A `SuitFit`.
    """
    channels = fit.estimate.channels
    source = ", ".join(log.source for log in fit.selection.logs)[:60]
    digest = fit.selection.logs[0].sha256
    study = f"{MARK} {source.encode('ascii', 'replace').decode()}, SHA-256 {digest}"
    notes = [plain(f"Means over parts of {fit.estimate.strokes} strokes of {source}.")]
    notes += [f"Warning: {text}" for text in fit.warnings[:_MOST_WARNINGS]]
    title = "What the suit's log measured, and the fitted suit"
    with house_style():
        height = _HEIGHT_OF_CHANNEL * len(channels)
        page = framed(title, height, _key(fit), notes, study=study)
        _draw_channels(page.figure, fit, channels)
    return page


def _loads(fit: Any) -> list[float]:
    """Return the loads of the logs, lightest first, kg; NaN without any."""
    return [float(load) for load in np.unique(fit.estimate.parts.load)]


def _key(fit: Any) -> list[Line2D]:
    """Return the key to colours, markers and lines."""
    entries = [(name, colour, "o") for _, colour, name in _DIRECTIONS]
    loads = _loads(fit)
    if len(loads) > 1:
        entries += [
            (f"{load:.3g} kg", _LINE, _MARKERS[place % len(_MARKERS)])
            for place, load in enumerate(loads)
        ]
    key = [
        key_line(linestyle="", marker=marker, markersize=4, color=colour, label=label)
        for label, colour, marker in entries
    ]
    return [*key, key_line(color=_LINE, linewidth=1.0, label="fitted suit")]


def _draw_channels(figure: Figure, fit: Any, channels: Any) -> None:
    """Draw a panel of loops and one of residuals for each channel."""
    ratios = [2.4, 1.0] * len(channels)
    grid = figure.add_gridspec(2 * len(channels), 1, height_ratios=ratios)
    first: Axes | None = None
    for row, channel in enumerate(channels):
        loops = figure.add_subplot(grid[2 * row], sharex=first)
        first = first or loops
        left = figure.add_subplot(grid[2 * row + 1], sharex=first)
        _draw_channel(loops, left, fit, row, channel)
        loops.tick_params(labelbottom=False)
        left.tick_params(labelbottom=row == len(channels) - 1)
    left.set_xlabel("angle of the joint, as its sensor shows it (deg)")


def _draw_channel(loops: Axes, left: Axes, fit: Any, row: int, channel: str) -> None:
    """Draw measured means, the model's strokes and the residuals of one channel."""
    parts = fit.estimate.parts
    factor = 180.0 / np.pi if channel.endswith("angle") else 1.0
    unit = "deg" if channel.endswith("angle") else QUANTITIES[channel].unit
    angle = np.degrees(parts.angle)
    measured = parts.values[channel] * factor
    residual = fit.estimate.residual[row] * factor
    for place, load in enumerate(_loads(fit)):
        of_load = np.isnan(parts.load) if np.isnan(load) else parts.load == load
        for flexion, colour, _ in _DIRECTIONS:
            is_shown = of_load & (parts.flexion == flexion)
            style: dict[str, Any] = {
                "linestyle": "none",
                "marker": _MARKERS[place % len(_MARKERS)],
                "markersize": 2.6,
                "color": colour,
                "alpha": 0.75,
            }
            loops.plot(angle[is_shown], measured[is_shown], **style)
            left.plot(angle[is_shown], residual[is_shown], **style)
    for stroke in np.unique(parts.stroke):
        of_stroke = parts.stroke == stroke
        model = measured[of_stroke] - residual[of_stroke]
        order = np.argsort(angle[of_stroke])
        loops.plot(angle[of_stroke][order], model[order], color=_LINE, linewidth=0.7, zorder=1)
    name = channel.replace("_", " ")
    loops.set_ylabel(f"{name} ({unit})")
    left.set_ylabel(f"left over ({unit})")
    left.axhline(0.0, color=_LINE, linewidth=0.8, zorder=1)
    largest = 1.15 * float(np.max(np.abs(residual)))
    left.set_ylim(-largest, largest)
