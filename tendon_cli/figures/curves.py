"""Curves: quantities of states or designs, line by line, with slack made visible."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tendon_cli.figures.curve_data import CurveData, Curves
from tendon_cli.figures.engine import Axes, Figure, Line2D
from tendon_cli.figures.frame import Frame, grid_shape
from tendon_cli.figures.map_panel import hatch_key
from tendon_cli.figures.marks import hatch_unknown
from tendon_cli.figures.scales import plain_numbers
from tendon_cli.figures.style import (
    COLUMN_WIDTH,
    INK,
    MARKERS,
    OKABE_ITO,
    PAGE_HEIGHT,
    broken,
    sequence,
    wrapped,
)

_DASHES: tuple[Any, ...] = ("solid", (0, (3.2, 1.4)))
_BAND = 4.2
"""Width of the pale band behind a line whose tendon is slack, pt."""
_FEW_POINTS = 12


def draw_curves(data: CurveData, width: float, height: float | None) -> list[Figure]:
    """One page; where several quantities meet several panels in more than a row each, a page per panel."""
    if len(data.curves) > 1 and len(data.panels) > 1:
        if len(data.curves) * len(data.panels) > 12:
            pages = [[(found, at) for found in data.curves] for at in range(len(data.panels))]
            return [_page(data, cells, 2, data.panels[at], width, height) for at, cells in enumerate(pages)]
        cells = [(found, at) for found in data.curves for at in range(len(data.panels))]
        return [_page(data, cells, len(data.panels), "", width, height)]
    cells = [(found, at) for found in data.curves for at in range(max(1, len(data.panels)))]
    columns = 2 if len(data.curves) > 1 else grid_shape(len(cells))[1]
    return [_page(data, cells, columns, "", width, height)]


def _page(
    data: CurveData,
    cells: Sequence[tuple[Curves, int]],
    columns: int,
    subtitle: str,
    width: float,
    height: float | None,
) -> Figure:
    columns = 1 if width <= COLUMN_WIDTH else columns
    rows = -(-len(cells) // columns)
    frame = Frame(width, data.title, _key(data, cells), data.notes, subtitle)
    each = (width - 16.0) / columns
    tall = min(PAGE_HEIGHT, rows * min(0.62 * each + 6.0, 70.0) + 8.0)
    figure = frame.figure(tall if height is None else max(30.0, height - frame.head - frame.foot))
    grid = figure.subplots(rows, columns, sharex=True, squeeze=False)
    for (curves, panel), axes in zip(cells, grid.flat, strict=False):
        _draw(axes, data, curves, panel)
        axes.set_title(wrapped(_title(data, curves, panel), int(each / 1.7)))
    for at, axes in enumerate(grid.flat):
        axes.set_visible(at < len(cells))
        is_lowest = at + columns >= len(cells)
        axes.tick_params(labelbottom=is_lowest)
        if is_lowest:
            axes.set_xlabel(broken(data.x_label, int(each / 1.5)))
    like_left = _share_y(grid, cells, columns)
    for at, (curves, _) in enumerate(cells):
        _finish(grid.flat[at], data, curves, labelled=not like_left[at], width=int(0.8 * tall / rows / 1.5))
    return figure


def _draw(axes: Axes, data: CurveData, curves: Curves, panel: int) -> None:
    """All lines of one panel; along x, by colour and by dashes."""
    values = curves.values[panel]
    colours = _colours(data)
    for colour, dash in np.ndindex(values.shape[0], values.shape[1]):
        at = (panel, colour, dash)
        order = np.argsort(data.x_values[at], kind="stable") if data.x else np.arange(values.shape[2])
        x, y = data.x_values[at][order], curves.values[at][order]
        sign = _sign(data, colours, colour, dash, len(x))
        if curves.slack.any() and not (data.x and data.x.names):
            slack = np.where(curves.slack[at][order], y, np.nan)
            axes.plot(x, slack, color=sign["color"], alpha=0.25, linewidth=_BAND, solid_capstyle="butt", gid="slack")
        axes.plot(x, y, **sign, gid="curve", label=_line_label(data, colour, dash))
    if data.x is not None:
        data.x.apply(axes, "x")
        unknown = ~np.isfinite(values).any(axis=(0, 1))[data.x.order]
        hatch_unknown(axes, data.x, unknown)
    else:
        axes.xaxis.set_major_formatter(plain_numbers())


def _sign(data: CurveData, colours: Sequence[Any], colour: int, dash: int, points: int) -> dict[str, Any]:
    """How a line looks: told apart by colour, and in grey print by its markers and lightness."""
    lines = max(1, len(colours))
    step = max(2, points // 6)
    # No two lines have their markers at the same place, so that lines that coincide are seen to.
    start = round(step * ((colour + 0.5) / lines + 0.5 * dash)) % step
    every: Any = 1 if points <= _FEW_POINTS else (start, step)
    return {
        "color": colours[colour],
        "linestyle": "none" if data.x is not None and data.x.names else _DASHES[dash],
        "marker": MARKERS[colour % len(MARKERS)] if lines > 1 or points <= _FEW_POINTS else "none",
        "markersize": 2.8,
        "markevery": every,
        "markerfacecolor": colours[colour] if dash == 0 else "white",
        "markeredgewidth": 0.8,
    }


def _colours(data: CurveData) -> list[Any]:
    count = max(1, len(data.colours))
    return sequence(count) if data.is_ordered or count == 1 else [OKABE_ITO[at % len(OKABE_ITO)] for at in range(count)]


def _line_label(data: CurveData, colour: int, dash: int) -> str:
    texts = (data.colours[colour] if data.colours else "", data.dashes[dash] if data.dashes else "")
    return ", ".join(filter(None, texts)) or "_line"


def _key(data: CurveData, cells: Sequence[tuple[Curves, int]]) -> list[Line2D]:
    """Colours, then dashes, then the band of slack and the hatching, as far as they are there."""
    colours = _colours(data)
    points = data.x_values.shape[-1]
    key: list[Any] = []
    for at, text in enumerate(data.colours):
        key.append(Line2D([], [], **{**_sign(data, colours, at, 0, points), "markevery": 1}, label=text))
    if not (data.x and data.x.names):
        key += [Line2D([], [], color=INK, linestyle=_DASHES[at], label=text) for at, text in enumerate(data.dashes)]
    if any(curves.slack.any() for curves, _ in cells) and not (data.x and data.x.names):
        key.append(Line2D([], [], color=INK, alpha=0.25, linewidth=_BAND, label="a tendon is slack"))
    if data.x is not None and any(_unknown(curves, panel).any() for curves, panel in cells):
        key.append(
            hatch_key(
                "no value"
                if "first_slack_angle" in {curves.quantity.column for curves, _ in cells}
                else "no equilibrium"
            )
        )
    return key


def _unknown(curves: Curves, panel: int) -> Any:
    return ~np.isfinite(curves.values[panel]).any(axis=(0, 1))


def _title(data: CurveData, curves: Curves, panel: int) -> str:
    texts = [curves.quantity.titled] if _has_several(data) else []
    if data.panels and not (_has_several(data) and len(data.curves) * len(data.panels) > 12):
        texts.append(data.panels[panel])
    return ", ".join(texts)


def _has_several(data: CurveData) -> bool:
    return len(data.curves) > 1


def _share_y(grid: Any, cells: Sequence[tuple[Curves, int]], columns: int) -> list[bool]:
    """Panels of one quantity share y, so do those in a row that have the same unit; which have the labels on the left.

    True stands for a panel whose y axis is that of its left neighbour, which then labels both.
    """
    is_one = len({curves.quantity.column for curves, _ in cells}) == 1
    flat = list(grid.flat)[: len(cells)]
    like_left = []
    for at, axes in enumerate(flat):
        row = at - at % columns
        first = 0 if is_one else row
        same = cells[first][0].quantity.dimension_shown == cells[at][0].quantity.dimension_shown
        if same and at != first:
            axes.sharey(flat[first])
        like_left.append(same and at != row)
        axes.tick_params(labelleft=not like_left[-1])
    return like_left


def _finish(axes: Axes, data: CurveData, curves: Curves, *, labelled: bool, width: int) -> None:
    """Label y, and shade what lies below zero where a tension does."""
    axes.yaxis.set_major_formatter(plain_numbers())
    axes.autoscale(axis="y")
    axes.margins(y=0.05)
    low, high = axes.get_ylim()
    if low < 0.0 < high:
        axes.axhline(0.0, color=INK, linewidth=0.5, zorder=1.2)
    if labelled:
        quantity = curves.quantity
        axes.set_ylabel(broken(quantity.label if not _has_several(data) else quantity.short_label, width))
