"""A page of a slack map: panels under one title, with one colour bar and one key."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tendon_cli.figures.engine import Figure, mpl
from tendon_cli.figures.frame import Frame, grid_shape
from tendon_cli.figures.labels import Shown
from tendon_cli.figures.map_data import MapData, Panel
from tendon_cli.figures.map_panel import ColourScale, boundary_key, colour_scale, crosses_zero, draw_panel, hatch_key
from tendon_cli.figures.style import DIVERGING, INK, PAGE_HEIGHT, broken, wrapped

MEANING = "Margin: pretension in hand above F₀*, the smallest that leaves no slack at any elbow angle of the study."
_BAR = 35.0
"""Width of labels and colour bar, mm."""
_NARROWEST = 42.0
"""Width that a panel takes up at least, mm."""


def draw_page(data: MapData, panels: Sequence[Panel], name: str, width: float, height: float | None) -> Figure:
    """One page; `name` is its title, `width` and `height` are in mm."""
    if data.y is None:
        raise ValueError("a map has two axes")
    rows, columns = grid_shape(len(panels), data.in_row, most=max(1, int(width / _NARROWEST)))
    each = (width - _BAR) / columns
    if len(panels) == 1 and height is None:
        each *= 0.8
    meaning = f"{MEANING} Its zero is interpolated between designs."
    frame = Frame(width, name, _key(panels), (meaning, *remarks(panels), *data.notes))
    tall = min(PAGE_HEIGHT, rows * min(0.8 * each + 6.0, 80.0) + 8.0)
    figure = frame.figure(tall if height is None else max(30.0, height - frame.head - frame.foot))
    colours = colour_scale([panel.margin for panel in data.panels])
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for axes, panel in zip(grid.flat, panels, strict=False):
        draw_panel(axes, data.x, data.y, panel.margin, colours, ticks=max(2, min(6, int(each / 9.0))))
        axes.set_title(wrapped(panel.title, int(each / 1.9)))
    for at, axes in enumerate(grid.flat):
        axes.set_visible(at < len(panels))
        is_lowest = at + columns >= len(panels)
        axes.tick_params(labelbottom=is_lowest)
        if is_lowest:
            axes.set_xlabel(broken(data.x.label, int(each / 1.5)))
        if at % columns == 0:
            axes.set_ylabel(broken(data.y.label, int(0.7 * tall / rows / 1.5)))
    _colour_bar(figure, grid, data.margin, colours)
    return figure


def remarks(panels: Sequence[Panel]) -> list[str]:
    """What the reader might look for in vain."""
    margins = np.concatenate([panel.margin.ravel() for panel in panels])
    known = margins[np.isfinite(margins)]
    if len(known) and known.min() >= 0.0:
        return ["No design goes slack."]
    if len(known) and known.max() < 0.0:
        return ["Every design goes slack."]
    return []


def _key(panels: Sequence[Panel]) -> list[Any]:
    boundary = [boundary_key()] if any(crosses_zero(panel.margin) for panel in panels) else []
    return boundary if all(np.isfinite(panel.margin).all() for panel in panels) else [*boundary, hatch_key()]


def _colour_bar(figure: Figure, grid: Any, margin: Shown, colours: ColourScale) -> None:
    colour = mpl.cm.ScalarMappable(norm=colours.norm, cmap=DIVERGING)
    bar = figure.colorbar(colour, ax=grid, extend=colours.extend, spacing="proportional", aspect=28, pad=0.02,
                          fraction=0.08, ticks=list(colours.levels))  # fmt: skip
    bar.set_label(f"{margin.label}\n←  slack             taut  →", linespacing=1.4)
    bar.ax.axhline(0.0, color=INK, linewidth=1.2)
    bar.outline.set_linewidth(0.5)
