"""Curves: quantities of states or designs, line by line, with slack and instability made visible."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tendon_cli.cube.labels import Shown
from tendon_cli.figures.backend import Axes, Line2D
from tendon_cli.figures.curve_data import CurveData, Floats
from tendon_cli.figures.frame import Page, empty_panels, framed, grid_shape, lowest, settle
from tendon_cli.figures.scales import plain_numbers
from tendon_cli.figures.style import (
    COLUMN_WIDTH,
    INK,
    MARKERS,
    PAGE_HEIGHT,
    broken,
    hatch_key,
    unknown_hatch,
    wrapped,
)
from tendon_cli.studies.filters import Truth

_DASHES: tuple[Any, ...] = ("solid", (0, (3.2, 1.4)))
_BAND = 4.2
"""Width of the pale band behind a line whose tendon is slack, pt."""
_UNSTABLE: dict[str, Any] = {
    "color": INK,
    "linewidth": 1.7,
    "linestyle": (0, (0.6, 0.9)),
    "marker": "none",
}
_KINK: dict[str, Any] = {
    "linestyle": "none",
    "marker": "|",
    "markersize": 6.0,
    "markeredgewidth": 1.0,
    "color": INK,
}
_FEW_POINTS = 12
_MOST_CELLS = 12
_MOST_UNLIKE = 5.0
"""Panels whose values differ more than that do not share an axis."""
_SLACK_AREA, _SLACK_WORD = "#fbeae0", "#8a3b12"

Cell = tuple[int, int]
"""A panel on a page: which quantity, and which of the data's panels."""


def draw_curves(data: CurveData, width: float, height: float | None) -> list[Page]:
    """One page; where several quantities meet several panels in more than a row each, a page per panel."""
    quantities, panels = data.values.shape[:2]
    cells = list(np.ndindex(quantities, panels))
    if quantities > 1 and panels > 1 and len(cells) > _MOST_CELLS:
        return [
            _page(
                data, [(each, at) for each in range(quantities)], 2, data.panels[at], width, height
            )
            for at in range(panels)
        ]
    columns = grid_shape(len(cells))[1] if quantities == 1 else panels if panels > 1 else 2
    return [_page(data, cells, columns, "", width, height)]


def _page(
    data: CurveData,
    cells: Sequence[Cell],
    columns: int,
    subtitle: str,
    width: float,
    height: float | None,
) -> Page:
    columns = 1 if width <= COLUMN_WIDTH else columns
    rows = -(-len(cells) // columns)
    each = (width - 16.0) / columns
    usual = min(PAGE_HEIGHT, rows * min(0.62 * each + 6.0, 70.0) + 8.0)
    shown = np.array([data.values[cell] for cell in cells])
    page = framed(
        data.title,
        usual,
        _key(data, cells),
        data.notes,
        width=width,
        height=height,
        subtitle=subtitle,
        study=data.study,
    )
    grid = empty_panels(page, rows, columns, len(cells), sharex=True)
    for cell, axes in zip(cells, grid.flat, strict=False):
        _draw(axes, data, cell)
        axes.set_title(wrapped(_title(data, cell), int(each / 1.7)))
    for axes in lowest(grid, len(cells)):
        axes.set_xlabel(broken(data.x_label, int(each / 1.5)))
    like_left = _share_y(grid, data, cells, columns)
    for axes, (quantity, _), is_like in zip(grid.flat, cells, like_left, strict=False):
        _finish(
            axes,
            data,
            data.quantities[quantity],
            labelled=not is_like,
            width=int(0.8 * page.inner / rows / 1.5),
        )
    reaches_below = np.nanmin(shown, initial=0.0) < -0.01 * np.nanmax(
        shown, initial=0.0
    )  # so far that it is seen
    for axes in grid.flat[: len(cells)] if data.is_slack_below_zero and reaches_below else ():
        shade_slack(axes)
    settle(page, grid)
    return page


def _draw(axes: Axes, data: CurveData, cell: Cell) -> None:
    """All lines of one panel; along x, by colour and by dashes."""
    values = data.values[cell]
    for colour, dash in np.ndindex(*values.shape[:2]):
        at = (*cell, colour, dash)
        order = (
            np.argsort(data.x_values[at[1:]], kind="stable")
            if data.x
            else np.arange(values.shape[2])
        )
        x, y = data.x_values[at[1:]][order], data.values[at][order]
        slack, turned, unstable = (
            marks[at][order] for marks in (data.slack, data.turned, data.unstable)
        )
        sign = _sign(data, colour, dash, len(x))
        if slack.any() and data.is_line:
            style = {
                "color": sign["color"],
                "alpha": 0.25,
                "linewidth": _BAND,
                "solid_capstyle": "butt",
            }
            axes.plot(*_stretches(x, y, slack), **style, gid="slack")
        names = (data.colours[colour][0], data.dashes[dash] if data.dashes else "")
        axes.plot(x, y, **sign, gid="curve", label=", ".join(filter(None, names)) or "_line")
        if unstable.any() and data.is_line:
            axes.plot(*_stretches(x, y, unstable), **_UNSTABLE, gid="unstable")
        if (
            data.has_kinks and data.is_line and data.x
        ):  # half way between the last taut state and the first slack one
            change = turned[:-1] != turned[1:]
            axes.plot(_middle(x)[change], _middle(y)[change], **_KINK, gid="kink")
    if data.x is None:
        axes.xaxis.set_major_formatter(plain_numbers())
        return
    data.x.apply(axes, "x")
    unknown = ~np.isfinite(values).any(axis=(0, 1))[data.x.order]  # where no line has a value
    changes = np.flatnonzero(np.diff(np.concatenate(([False], unknown, [False])).astype(np.int8)))
    for start, stop in changes.reshape(-1, 2):
        axes.axvspan(*data.x.edges[[start, stop]], zorder=0.6, **unknown_hatch())


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
        "linestyle": _DASHES[dash] if data.is_line else "none",
        "marker": MARKERS[colour % len(MARKERS)] if lines > 1 or points <= _FEW_POINTS else "none",
        "markersize": 2.8,
        "markevery": every,
        "markerfacecolor": chosen if dash == 0 else "white",
        "markeredgewidth": 0.8,
    }


def _key(data: CurveData, cells: Sequence[Cell]) -> list[Any]:
    """Colours, then dashes with filled and open markers, then slack, instability and what has no value."""
    points = data.x_values.shape[-1]
    values, slack, turned, unstable = (
        np.array([part[cell] for cell in cells])
        for part in (data.values, data.slack, data.turned, data.unstable)
    )
    key: list[Any] = []
    for at, (text, _) in enumerate(data.colours):
        if text:
            key.append(Line2D([], [], **{**_sign(data, at, 0, points), "markevery": 1}, label=text))
    for at, text in enumerate(data.dashes):
        sign = {
            **_sign(data, 0, at, points),
            "markevery": 1,
            "color": INK,
            "markerfacecolor": ("black", "white")[at],
        }
        marked = "" if sign["marker"] == "none" else f", {('filled', 'open')[at]}"
        key.append(
            Line2D([], [], **{**sign, "marker": "o" if marked else "none"}, label=f"{text}{marked}")
        )
    if data.is_line and slack.any():
        key.append(
            Line2D([], [], color=INK, alpha=0.25, linewidth=_BAND, label="a tendon is slack")
        )
    if data.is_line and data.has_kinks and data.x and (turned[..., 1:] != turned[..., :-1]).any():
        key.append(Line2D([], [], **_KINK, label="one goes slack"))
    if data.is_line and unstable.any():
        key.append(Line2D([], [], **_UNSTABLE, label="unstable elbow"))
    if data.x is not None and not np.isfinite(values).any(axis=(1, 2)).all():
        key.append(hatch_key("no value"))
    return key


def _title(data: CurveData, cell: Cell) -> str:
    quantities, panels = data.values.shape[:2]
    texts = [data.quantities[cell[0]].titled] if quantities > 1 else []
    if data.panels and not (quantities > 1 and quantities * panels > _MOST_CELLS):
        texts.append(data.panels[cell[1]])
    return ", ".join(texts)


def _share_y(grid: Any, data: CurveData, cells: Sequence[Cell], columns: int) -> list[bool]:
    """Panels of one quantity share y, and those in a row of one unit and like size; who has the labels on the left.

    True stands for a panel whose y axis is that of its left neighbour, which then labels both.
    """
    is_one = len({quantity for quantity, _ in cells}) == 1
    sizes = [float(np.nanmax(np.abs(data.values[cell]), initial=0.0)) for cell in cells]
    units = [data.quantities[quantity].dimension_shown for quantity, _ in cells]
    like_left = []
    for at, axes in enumerate(grid.flat[: len(cells)]):
        row = at - at % columns
        first = 0 if is_one else row
        small, large = sorted((sizes[first], sizes[at]))
        same = units[first] == units[at] and (is_one or large <= _MOST_UNLIKE * small)
        if same and at != first:
            axes.sharey(grid.flat[first])
        like_left.append(same and at != row)
        axes.tick_params(labelleft=not like_left[-1])
    return like_left


def _finish(axes: Axes, data: CurveData, quantity: Shown, *, labelled: bool, width: int) -> None:
    """Label y, and draw where it is zero."""
    axes.yaxis.set_major_formatter(plain_numbers())
    axes.autoscale(axis="y")
    axes.margins(y=0.05)
    low, high = axes.get_ylim()
    if low < 0.0 < high:
        axes.axhline(0.0, color=INK, linewidth=0.5, zorder=1.2)
    if labelled:
        axes.set_ylabel(
            broken(quantity.label if len(data.quantities) == 1 else quantity.short_label, width)
        )


def shade_slack(axes: Axes) -> None:
    """Shade and name what lies below zero in a panel, where negative means slack."""
    low, high = axes.get_ylim()
    if low >= 0.0:
        return
    axes.axhspan(low, 0.0, facecolor=_SLACK_AREA, linewidth=0.0, zorder=0.3, gid="slack area")
    axes.axhline(0.0, color=INK, linewidth=0.5, zorder=1.2)
    axes.text(
        0.02,
        0.03,
        "slack",
        transform=axes.transAxes,
        color=_SLACK_WORD,
        style="italic",
        gid="slack word",
    )
    axes.set_ylim(low, high)
