"""The slack map of a study with one axis: margin against it, a line for each load."""

from __future__ import annotations

from typing import Any

import numpy as np

from tendon_cli.figures.engine import Axes, Figure, Line2D
from tendon_cli.figures.frame import Frame
from tendon_cli.figures.map_data import MapData
from tendon_cli.figures.map_page import MEANING, remarks
from tendon_cli.figures.map_panel import hatch_key
from tendon_cli.figures.marks import hatch_unknown
from tendon_cli.figures.style import INK, MARKERS, sequence

_SHADE = "#f9e3d3"


def draw_lines(data: MapData, width: float, height: float | None) -> Figure:
    """Margin against the only axis; below zero a tendon goes slack."""
    key = _key(data)
    unknown = ~np.any([np.isfinite(panel.margin) for panel in data.panels], axis=0)
    hatch = [hatch_key()] if unknown.any() else []
    frame = Frame(min(width, 120.0), data.title, [*key, *hatch], (MEANING, *remarks(data.panels), *data.notes))
    figure = frame.figure(72.0 if height is None else max(30.0, height - frame.head - frame.foot))
    axes = figure.subplots()
    for sign, panel in zip(key, data.panels, strict=True):
        axes.plot(data.x.places, panel.margin, color=sign.get_color(), marker=sign.get_marker(), markersize=3.2,
                  linestyle=sign.get_linestyle(), markevery=max(1, len(data.x.places) // 10),
                  label=sign.get_label())  # fmt: skip
    data.x.apply(axes, "x")
    axes.margins(y=0.06)
    axes.set(xlabel=data.x.label, ylabel=data.margin.label)
    _shade_slack(axes)
    hatch_unknown(axes, data.x, unknown)
    return figure


def _key(data: MapData) -> list[Line2D]:
    """A sign for each line: light to dark in the order of the values, with a marker of its own."""
    colours = sequence(len(data.panels))
    style: Any = "none" if data.x.names else "solid"
    return [
        Line2D([], [], color=colour, marker=MARKERS[at % len(MARKERS)], linestyle=style, label=panel.title or "margin")
        for at, (colour, panel) in enumerate(zip(colours, data.panels, strict=True))
    ]


def _shade_slack(axes: Axes) -> None:
    low, high = axes.get_ylim()
    axes.axhline(0.0, color=INK, linewidth=0.8, zorder=1.5, gid="boundary")
    if low < 0.0:
        axes.axhspan(low, 0.0, color=_SHADE, zorder=0.5, linewidth=0.0, gid="slack")
        axes.text(0.985, 0.02, "slack", transform=axes.transAxes, ha="right", va="bottom", color="#9c4a1a")
    if high > 0.0:
        axes.text(0.985, 0.98, "taut", transform=axes.transAxes, ha="right", va="top", color="#2b5c85")
    axes.set_ylim(low, high)
