"""The pages of a slack map: margin in colour, where a tendon goes slack, where the elbow is unstable."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tendon_cli.figures.backend import (
    Axes,
    Line2D,
    Patch,
    TickedStroke,
    TwoSlopeNorm,
    mpl,
    withStroke,
)
from tendon_cli.figures.frame import Page, empty_panels, framed, grid_shape, lowest, settle
from tendon_cli.figures.layout import PANELS_PER_PAGE
from tendon_cli.figures.map_data import STIFFNESS, Floats, MapData
from tendon_cli.figures.scales import Scale
from tendon_cli.figures.style import (
    DIVERGING,
    INK,
    PAGE_HEIGHT,
    broken,
    hatch_key,
    unknown_hatch,
    wrapped,
)

_BAR = 35.0
"""Width of labels and colour bar, mm."""
_NARROWEST = 42.0
"""Width that a panel takes up at least, mm."""
_BOUNDARY_WIDTH = 1.2
_UNSTABLE: dict[str, Any] = {"hatch": "xxxx", "edgecolor": "#4d4d4d", "linewidth": 0.0}
# Contours run with the higher values on their left; the ticks stand on the right, where a limit is not held.
_EFFECTS = [
    TickedStroke(spacing=5.0, angle=-90.0, length=0.45, linewidth=0.6),
    mpl.patheffects.Normal(),
]
_HALO = withStroke(linewidth=2.6, foreground="white")
_LINES = (INK, "#006b4e", "#8f2d72", "#5a4a00", "#7a0019", "#003a70", "#4d4d4d")
"""Of limits."""


def draw_maps(data: MapData, width: float, height: float | None) -> list[Page]:
    """The pages of a map, of a size in mm."""
    count = len(data.titles)
    parts = [range(at, min(count, at + PANELS_PER_PAGE)) for at in range(0, count, PANELS_PER_PAGE)]
    names = [f"{data.title} (page {page} of {len(parts)})" for page in range(1, len(parts) + 1)]
    titles = names if len(parts) > 1 else [data.title]
    return [
        _page(data, panels, title, width, height)
        for panels, title in zip(parts, titles, strict=True)
    ]


def _page(data: MapData, panels: range, title: str, width: float, height: float | None) -> Page:
    rows, columns = grid_shape(len(panels), data.in_row, most=max(1, int(width / _NARROWEST)))
    each = (width - _BAR) / columns * (0.8 if len(panels) == 1 and height is None else 1.0)
    usual = min(PAGE_HEIGHT, rows * min(0.8 * each + 6.0, 80.0) + 8.0)
    seen = slice(panels.start, panels.stop)
    key, notes = _key(data, seen), (*_remarks(data.margins[seen]), *data.notes)
    page = framed(title, usual, key, notes, width=width, height=height, study=data.study)
    limit, levels, extend = colour_scale(data.margins)
    colour = mpl.cm.ScalarMappable(TwoSlopeNorm(0.0, -limit, limit), DIVERGING)
    grid = empty_panels(page, rows, columns, len(panels), sharex=True, sharey=True)
    for axes, panel in zip(grid.flat, panels, strict=False):
        _draw_panel(axes, data, panel, colour, ticks=max(2, min(6, int(each / 9.0))))
        axes.set_title(
            wrapped(data.titles[panel], int(each / 1.9)), y=1.0
        )  # placed without a search
    # Narrow panels have one label for all of them, in the middle: side by side they would run into each other.
    if columns > 2 and rows * columns == len(panels):
        grid[-1, (columns - 1) // 2].set_xlabel(data.x.label, x=0.5 if columns % 2 else 1.07)
    else:
        for axes in lowest(grid, len(panels)):
            axes.set_xlabel(broken(data.x.label, int(each / 1.9)))
    for axes in grid[:, 0]:
        axes.set_ylabel(broken(data.y.label, int(0.7 * page.inner / rows / 1.5)))
    place = page.figure.add_axes((0.85, 0.2, 0.03, 0.6), label="<colorbar>")
    bar = page.figure.colorbar(
        colour, cax=place, extend=extend, spacing="proportional", ticks=levels
    )
    bar.set_label(f"{data.margin.label}\n←  slack             taut  →", linespacing=1.4)
    place.axhline(0.0, color=INK, linewidth=1.2)
    bar.outline.set_linewidth(0.5)
    settle(page, grid, place, must_fit=height is not None)
    return page


def colour_scale(margins: Floats) -> tuple[float, list[float], str]:
    """One scale for all panels, symmetric about zero and round: its limit, levels, and the ends that lie beyond it.

    The positive side is shown whole, a far longer negative side is cut off.
    """
    finite = margins[np.isfinite(margins)]
    most, least = float(finite.max()), float(finite.min())
    usual = max(most, float(np.quantile(np.abs(finite), 0.9)))
    bound = max(most, -least)
    bound = (usual if bound > 1.5 * usual else bound) or 1.0
    levels = list(mpl.ticker.MaxNLocator(10, steps=[1, 2, 2.5, 5, 10]).tick_values(-bound, bound))
    extend = {
        (False, False): "neither",
        (True, False): "min",
        (False, True): "max",
        (True, True): "both",
    }
    return levels[-1], levels, extend[least < levels[0], most > levels[-1]]


def _draw_panel(axes: Axes, data: MapData, panel: int, colour: Any, ticks: int) -> None:
    """One panel, its cells whole, with at most so many ticks on x."""
    x, y = data.x, data.y
    margin = np.ma.masked_invalid(data.margins[panel])
    if margin.mask.any():
        axes.patch.set(**unknown_hatch())
    axes.pcolormesh(
        x.edges, y.edges, margin, cmap=colour.cmap, norm=colour.norm, rasterized=True, gid="margin"
    )
    for at, (limit, rooms) in enumerate(data.rooms.items()):
        if limit == STIFFNESS:
            _hatch_negative(axes, x, y, rooms[panel])
        _draw_limit(
            axes, x, y, rooms[panel], gid=limit, linewidth=0.8, color=_LINES[at % len(_LINES)]
        )
    _draw_limit(
        axes, x, y, data.margins[panel], gid="boundary", linewidth=_BOUNDARY_WIDTH, color=INK
    )
    x.apply(axes, "x", ticks=ticks, cells=True)
    y.apply(axes, "y", cells=True)


def _draw_limit(
    axes: Axes, x: Scale, y: Scale, room: Floats, *, gid: str, linewidth: float, color: str
) -> None:
    """The line where `room`, what is left up to a limit, is zero; ticks on the side where the limit is not held.

    `room` has the shape (y, x), in the order of the scales. Over names there is a stroke per name instead.
    """
    effects = [_HALO, *_EFFECTS]
    if x.names or y.names:
        for xy in _strokes(x, y, room):
            axes.plot(
                *xy,
                path_effects=effects,
                solid_capstyle="butt",
                color=color,
                linewidth=linewidth,
                gid=gid,
            )
    elif min(room.shape) > 1 and _crosses_zero(room):
        lines = axes.contour(
            *_to_the_edges(x, y, room), levels=[0.0], colors=color, linewidths=linewidth
        )
        lines.set(path_effects=effects, gid=gid)


def _crosses_zero(room: Floats) -> bool:
    """Whether some designs hold a limit and others do not."""
    return bool(np.nanmin(room, initial=np.inf) < 0.0 <= np.nanmax(room, initial=-np.inf))


def zero_crossings(places: Floats, values: Floats) -> list[tuple[float, bool]]:
    """Where values along an axis cross zero, linearly between two of them, and whether they rise there."""
    low, high = values[:-1], values[1:]
    at = np.flatnonzero(np.isfinite(low) & np.isfinite(high) & ((low < 0.0) != (high < 0.0)))
    zeros = places[at] + low[at] / (low[at] - high[at]) * (places[at + 1] - places[at])
    return list(zip(zeros.tolist(), (high[at] > low[at]).tolist(), strict=True))


def _hatch_negative(axes: Axes, x: Scale, y: Scale, room: Floats) -> None:
    """Hatch where `room` is negative: over names cell by cell, else up to the line where it is zero."""
    if not (room < 0.0).any():
        return  # NaN is not: there is no equilibrium
    if x.names or y.names or min(room.shape) == 1:
        cells = np.ma.masked_where(~(room < 0.0), room)
        axes.pcolor(x.edges, y.edges, cells, facecolor="none", gid="unstable", **_UNSTABLE)
        return
    hatch, *edge = _UNSTABLE.values()
    area = axes.contourf(
        *_to_the_edges(x, y, room), levels=[-np.inf, 0.0], colors="none", hatches=[hatch]
    )
    area.set(edgecolor=edge[0], linewidth=edge[1], gid="unstable")


def _strokes(x: Scale, y: Scale, room: Floats) -> list[tuple[Sequence[float], Sequence[float]]]:
    """Where one axis is of names: per name, a stroke where `room` changes its sign."""
    along_x = not x.names
    places, table = (x.places, room) if along_x else (y.places, room.T)
    strokes: list[tuple[Sequence[float], Sequence[float]]] = []
    for at, line in enumerate(table):
        for zero, rises in zero_crossings(places, line):
            across = (at - 0.5, at + 0.5)
            # Drawn so that the higher side is on the left, as contours are.
            up = across if rises != along_x else across[::-1]
            strokes.append(([zero, zero], up) if along_x else (up, [zero, zero]))
    return strokes


def _to_the_edges(x: Scale, y: Scale, values: Floats) -> tuple[Floats, Floats, Any]:
    """Places and values with those at the outer edges of the cells, half a cell on in a straight line."""
    places = [np.concatenate((each.edges[:1], each.places, each.edges[-1:])) for each in (x, y)]
    for axis in (0, 1):
        first, second, last, before = (np.take(values, [at], axis) for at in (0, 1, -1, -2))
        values = np.concatenate(
            (1.5 * first - 0.5 * second, values, 1.5 * last - 0.5 * before), axis
        )
    return places[0], places[1], np.ma.masked_invalid(values)


def _remarks(margins: Floats) -> list[str]:
    """What the reader might look for in vain."""
    known = margins[np.isfinite(margins)]
    if not len(known) or known.min() < 0.0 <= known.max():
        return []
    return ["No design goes slack." if known.min() >= 0.0 else "Every design goes slack."]


def _key(data: MapData, seen: slice) -> list[Any]:
    key: list[Any] = []

    def line(label: str, width: float, colour: str) -> None:
        key.append(
            Line2D([], [], color=colour, linewidth=width, path_effects=_EFFECTS, label=label)
        )

    if any(map(_crosses_zero, data.margins[seen])):
        line("margin = 0, ticks on the slack side", _BOUNDARY_WIDTH, INK)
    for at, (limit, label) in enumerate(data.limits.items()):
        rooms = data.rooms[limit][seen]
        if limit == STIFFNESS and (rooms < 0.0).any():
            key.append(Patch(facecolor="none", label=label, **_UNSTABLE))
        elif any(map(_crosses_zero, rooms)):
            line(label, 0.8, _LINES[at % len(_LINES)])
    if not np.isfinite(data.margins[seen]).all():
        key.append(hatch_key("no equilibrium at some elbow angle"))
    return key
