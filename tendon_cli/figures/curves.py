"""Curves: quantities of states or designs, line by line, with slack and instability made visible."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tendon_cli.figures.curve_data import CurveData, Curves, Floats
from tendon_cli.figures.engine import Axes, Line2D
from tendon_cli.figures.frame import Page, empty_panels, framed, grid_shape, settle
from tendon_cli.figures.scales import plain_numbers
from tendon_cli.figures.style import COLUMN_WIDTH, INK, MARKERS, PAGE_HEIGHT, broken, hatch_key, unknown_hatch, wrapped
from tendon_cli.studies.filters import Truth

_DASHES: tuple[Any, ...] = ("solid", (0, (3.2, 1.4)))
_BAND = 4.2
"""Width of the pale band behind a line whose tendon is slack, pt."""
_UNSTABLE: dict[str, Any] = {"color": INK, "linewidth": 1.7, "linestyle": (0, (0.6, 0.9)), "marker": "none"}
_KINK: dict[str, Any] = {"linestyle": "none", "marker": "|", "markersize": 6.0, "markeredgewidth": 1.0, "color": INK}
_FEW_POINTS = 12
_MOST_CELLS = 12
_MOST_UNLIKE = 5.0
"""Panels whose values differ more than that do not share an axis."""
_SLACK_AREA, _SLACK_WORD = "#fbeae0", "#8a3b12"

Cell = tuple[Curves, int]
"""A quantity, and which panel of it."""


def draw_curves(data: CurveData, width: float, height: float | None) -> list[Page]:
    """One page; where several quantities meet several panels in more than a row each, a page per panel."""
    panels = max(1, len(data.panels))
    cells = [(curves, at) for curves in data.curves for at in range(panels)]
    if len(data.curves) > 1 and panels > 1:
        if len(cells) <= _MOST_CELLS:
            return [_page(data, cells, panels, "", width, height)]
        pages = [[(curves, at) for curves in data.curves] for at in range(panels)]
        return [_page(data, cells, 2, data.panels[at], width, height) for at, cells in enumerate(pages)]
    columns = 2 if len(data.curves) > 1 else grid_shape(len(cells))[1]
    return [_page(data, cells, columns, "", width, height)]


def _page(
    data: CurveData, cells: Sequence[Cell], columns: int, subtitle: str, width: float, height: float | None
) -> Page:
    columns = 1 if width <= COLUMN_WIDTH else columns
    rows = -(-len(cells) // columns)
    each = (width - 16.0) / columns
    usual = min(PAGE_HEIGHT, rows * min(0.62 * each + 6.0, 70.0) + 8.0)
    page = framed(data.title, usual, _key(data, cells), data.notes, width=width, height=height, subtitle=subtitle,
                  study=data.study)  # fmt: skip
    grid = empty_panels(page, rows, columns, sharex=True)
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
        _finish(grid.flat[at], data, curves, labelled=not like_left[at], width=int(0.8 * page.inner / rows / 1.5))
    shown = np.concatenate([curves.values[at].ravel() for curves, at in cells])
    reaches_below = np.nanmin(shown, initial=0.0) < -0.01 * np.nanmax(shown, initial=0.0)  # so far that it is seen
    for axes in grid.flat[: len(cells)] if data.is_slack_below_zero and reaches_below else ():
        shade_slack(axes)
    settle(page, grid)
    return page


def _draw(axes: Axes, data: CurveData, curves: Curves, panel: int) -> None:
    """All lines of one panel; along x, by colour and by dashes."""
    values = curves.values[panel]
    for colour, dash in np.ndindex(values.shape[0], values.shape[1]):
        at = (panel, colour, dash)
        order = np.argsort(data.x_values[at], kind="stable") if data.x else np.arange(values.shape[2])
        x, y, slack, turned, unstable = (
            each[at][order] for each in (data.x_values, curves.values, curves.slack, curves.turned, curves.unstable)
        )
        sign = _sign(data, colour, dash, len(x))
        is_line = not (data.x and data.x.names)
        if slack.any() and is_line:
            style = {"color": sign["color"], "alpha": 0.25, "linewidth": _BAND, "solid_capstyle": "butt"}
            axes.plot(*_stretches(x, y, slack), **style, gid="slack")
        names = (data.colours[colour][0], data.dashes[dash] if data.dashes else "")
        axes.plot(x, y, **sign, gid="curve", label=", ".join(filter(None, names)) or "_line")
        if unstable.any() and is_line:
            axes.plot(*_stretches(x, y, unstable), **_UNSTABLE, gid="unstable")
        if data.has_kinks and is_line and data.x:  # half way between the last taut state and the first slack one
            change = turned[:-1] != turned[1:]
            axes.plot(_middle(x)[change], _middle(y)[change], **_KINK, gid="kink")
    if data.x is not None:
        data.x.apply(axes, "x")
        unknown = ~np.isfinite(values).any(axis=(0, 1))[data.x.order]  # where no line has a value
        changes = np.flatnonzero(np.diff(np.concatenate(([False], unknown, [False])).astype(np.int8)))
        for start, stop in changes.reshape(-1, 2):
            axes.axvspan(*data.x.edges[[start, stop]], zorder=0.6, **unknown_hatch())
    else:
        axes.xaxis.set_major_formatter(plain_numbers())


def _stretches(x: Floats, y: Floats, holds: Truth) -> tuple[Floats, Floats]:
    """A line where something holds, up to half way to where it does not, so that a single point has length, too."""
    places, values = (np.empty(2 * len(each) - 1) for each in (x, y))
    kept = np.empty(len(places), dtype=np.bool_)
    places[::2], values[::2], kept[::2] = x, y, holds
    places[1::2], values[1::2], kept[1::2] = _middle(x), _middle(y), holds[:-1] | holds[1:]
    return places, np.where(kept, values, np.nan)


def _middle(values: Floats) -> Floats:
    return np.asarray((values[:-1] + values[1:]) / 2.0)


def _sign(data: CurveData, colour: int, dash: int, points: int) -> dict[str, Any]:
    """How a line looks: distinguished by colour, and in grey print by its markers and lightness."""
    lines = len(data.colours)
    step = max(2, points // 6)
    # No two lines have their markers at the same place, so that lines that coincide are seen to.
    start = round(step * ((colour + 0.5) / lines + 0.5 * dash)) % step
    every: Any = 1 if points <= _FEW_POINTS else (start, step)
    chosen = data.colours[colour][1]
    return {
        "color": chosen,
        "linestyle": "none" if data.x is not None and data.x.names else _DASHES[dash],
        "marker": MARKERS[colour % len(MARKERS)] if lines > 1 or points <= _FEW_POINTS else "none",
        "markersize": 2.8,
        "markevery": every,
        "markerfacecolor": chosen if dash == 0 else "white",
        "markeredgewidth": 0.8,
    }


def _key(data: CurveData, cells: Sequence[Cell]) -> list[Any]:
    """Colours, then dashes with filled and open markers, then slack, instability and what has no value."""
    points = data.x_values.shape[-1]
    is_line = not (data.x and data.x.names)
    key: list[Any] = []
    for at, (text, _) in enumerate(data.colours):
        if text:
            key.append(Line2D([], [], **{**_sign(data, at, 0, points), "markevery": 1}, label=text))
    for at, text in enumerate(data.dashes):
        sign = {**_sign(data, 0, at, points), "markevery": 1, "color": INK, "markerfacecolor": ("black", "white")[at]}
        marked = "" if sign["marker"] == "none" else f", {('filled', 'open')[at]}"
        key.append(Line2D([], [], **{**sign, "marker": "o" if marked else "none"}, label=f"{text}{marked}"))
    if is_line and any(curves.slack[at].any() for curves, at in cells):
        key.append(Line2D([], [], color=INK, alpha=0.25, linewidth=_BAND, label="a tendon is slack"))
    turns = any((curves.turned[at][..., 1:] != curves.turned[at][..., :-1]).any() for curves, at in cells)
    if is_line and turns and data.has_kinks and data.x:
        key.append(Line2D([], [], **_KINK, label="one goes slack"))
    if is_line and any(curves.unstable[at].any() for curves, at in cells):
        key.append(Line2D([], [], **_UNSTABLE, label="unstable elbow"))
    if data.x is not None and any(~np.isfinite(curves.values[at]).any(axis=(0, 1)).all() for curves, at in cells):
        key.append(hatch_key(data.missing))
    return key


def _title(data: CurveData, curves: Curves, panel: int) -> str:
    several = len(data.curves) > 1
    texts = [curves.quantity.titled] if several else []
    if data.panels and not (several and len(data.curves) * len(data.panels) > _MOST_CELLS):
        texts.append(data.panels[panel])
    return ", ".join(texts)


def _share_y(grid: Any, cells: Sequence[Cell], columns: int) -> list[bool]:
    """Panels of one quantity share y, and those in a row of one unit and like size; who has the labels on the left.

    True stands for a panel whose y axis is that of its left neighbour, which then labels both.
    """
    is_one = len({curves.quantity.column for curves, _ in cells}) == 1
    sizes = [float(np.nanmax(np.abs(curves.values[at]), initial=0.0)) for curves, at in cells]
    like_left = []
    for at, axes in enumerate(grid.flat[: len(cells)]):
        row = at - at % columns
        first = 0 if is_one else row
        small, large = sorted((sizes[first], sizes[at]))
        same = cells[first][0].quantity.dimension_shown == cells[at][0].quantity.dimension_shown
        same = same and (is_one or large <= _MOST_UNLIKE * small)
        if same and at != first:
            axes.sharey(grid.flat[first])
        like_left.append(same and at != row)
        axes.tick_params(labelleft=not like_left[-1])
    return like_left


def _finish(axes: Axes, data: CurveData, curves: Curves, *, labelled: bool, width: int) -> None:
    """Label y, and draw where it is zero."""
    axes.yaxis.set_major_formatter(plain_numbers())
    axes.autoscale(axis="y")
    axes.margins(y=0.05)
    low, high = axes.get_ylim()
    if low < 0.0 < high:
        axes.axhline(0.0, color=INK, linewidth=0.5, zorder=1.2)
    if labelled:
        quantity = curves.quantity
        axes.set_ylabel(broken(quantity.label if len(data.curves) == 1 else quantity.short_label, width))


def shade_slack(axes: Axes) -> None:
    """Shade and name what lies below zero in a panel, where negative means slack."""
    low, high = axes.get_ylim()
    if low >= 0.0:
        return
    axes.axhspan(low, 0.0, facecolor=_SLACK_AREA, linewidth=0.0, zorder=0.3, gid="slack area")
    axes.axhline(0.0, color=INK, linewidth=0.5, zorder=1.2)
    axes.text(0.02, 0.03, "slack", transform=axes.transAxes, color=_SLACK_WORD, style="italic", gid="slack word")
    axes.set_ylim(low, high)
