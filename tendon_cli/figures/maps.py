"""Pages of a slack map.

The margin is in colour. Lines show where a tendon goes slack and where a limit is just kept, and an
unstable elbow is hatched.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.cube import labels
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
from tendon_cli.figures.limit_remarks import crosses_zero, limit_remarks
from tendon_cli.figures.map_data import STIFFNESS, Floats, MapData
from tendon_cli.figures.scales import Scale
from tendon_cli.figures.style import (
    DIVERGING,
    INK,
    LIMIT_COLOURS,
    PAGE_HEIGHT,
    broken,
    hatch_key,
    unknown_hatch,
    wrapped,
)

_BAR = 35.0
"""Width of labels and colour bar, mm."""
_NARROWEST = 42.0
"""Least width of a panel with its labels, mm."""
_ROW_HEIGHT = 8.0
"""Height of a row of cells by name, mm."""
_LOWEST_TABLE = 40.0
"""Least height of a panel of cells by name, mm."""
_MOST_WRITTEN = 160
"""Largest number of cells by name with their margin written in them."""
_MOST_WRITTEN_IN_ROW = 12
"""Largest number of cells side by side with their margin written in them."""
_BOUNDARY_WIDTH = 1.2
_LIMIT_WIDTH = 0.8
_HATCH = "xxxx"
_HATCH_EDGE: dict[str, Any] = {"edgecolor": LIMIT_COLOURS[0], "linewidth": 0.0}
# Contours run with the higher values on their left. The ticks are on the right, where a limit is
# broken.
_EFFECTS = [
    TickedStroke(spacing=5.0, angle=-90.0, length=0.45, linewidth=0.6),
    mpl.patheffects.Normal(),
]
_HALO = withStroke(linewidth=2.6, foreground="white")


def draw_maps(data: MapData, width: float, height: float | None) -> list[Page]:
    """Draw the pages of a map.

    Args:
        data: The map.
        width: Width of a page, mm.
        height: Height of a page, mm; None if the panels may have their usual height.
    """
    count = len(data.titles)
    starts = range(0, count, PANELS_PER_PAGE)
    pages = []
    for number, start in enumerate(starts, 1):
        panels = range(start, min(count, start + PANELS_PER_PAGE))
        title = data.title
        if len(starts) > 1:
            title = f"{title} (page {number} of {len(starts)})"
        pages.append(_page(data, panels, title, width, height))
    return pages


def _page(data: MapData, panels: range, title: str, width: float, height: float | None) -> Page:
    """Draw some of the panels on a page with a colour bar."""
    most_columns = max(1, int(width / _NARROWEST))
    rows, columns = grid_shape(len(panels), data.in_row, most=most_columns)
    share = 0.8 if len(panels) == 1 and height is None else 1.0
    panel_width = (width - _BAR) / columns * share
    usual_panel = min(0.8 * panel_width + 6.0, 80.0)
    if _has_cells(data):
        usual_panel = max(_LOWEST_TABLE, _ROW_HEIGHT * len(data.y.names) + 6.0)
    usual = min(PAGE_HEIGHT, rows * usual_panel + 8.0)
    seen = slice(panels.start, panels.stop)
    key = _key(data, seen)
    notes = (*_remarks(data.margins[seen]), *_limit_remarks(data, panels), *data.notes)
    page = framed(title, usual, key, notes, width=width, height=height, study=data.study)
    limit, levels, extend = colour_scale(data.margins)
    colour = mpl.cm.ScalarMappable(TwoSlopeNorm(0.0, -limit, limit), DIVERGING)
    grid = empty_panels(page, rows, columns, len(panels), sharex=True, sharey=True)
    ticks = max(2, min(6, int(panel_width / 9.0)))
    title_width = int(panel_width / 1.9)
    for axes, panel in zip(grid.flat, panels, strict=False):
        _draw_panel(axes, data, panel, colour, ticks)
        # With y given, matplotlib does not search for the title's place.
        axes.set_title(wrapped(data.titles[panel], title_width), y=1.0)
    # Narrow panels have one label for all of them, in the middle: side by side they would run into
    # each other.
    if columns > 2 and rows * columns == len(panels):
        place = 0.5 if columns % 2 else 1.07
        grid[-1, (columns - 1) // 2].set_xlabel(data.x.label, x=place)
    else:
        for axes in lowest(grid, len(panels)):
            axes.set_xlabel(broken(data.x.label, title_width))
    for axes in grid[:, 0]:
        axes.set_ylabel(broken(data.y.label, int(0.7 * page.inner / rows / 1.5)))
    bar_axes = page.figure.add_axes((0.85, 0.2, 0.03, 0.6), label="<colorbar>")
    scale: dict[str, Any] = {"extend": extend, "spacing": "proportional", "ticks": levels}
    bar = page.figure.colorbar(colour, cax=bar_axes, **scale)
    bar.set_label(f"{data.margin.label}\n←  slack             taut  →", linespacing=1.4)
    bar_axes.axhline(0.0, color=INK, linewidth=1.2)
    bar.outline.set_linewidth(0.5)
    settle(page, grid, bar_axes, must_fit=height is not None)
    return page


def colour_scale(margins: Floats) -> tuple[float, list[float], str]:
    """Return one scale of colours for all panels, round and symmetric about zero.

    The positive side is shown whole. A far longer negative side is cut off.

    Returns:
        The scale's limit, its levels, and which of its ends values lie beyond: "neither", "min",
        "max" or "both".
    """
    finite = margins[np.isfinite(margins)]
    most = float(finite.max())
    least = float(finite.min())
    usual = max(most, float(np.quantile(np.abs(finite), 0.9)))
    bound = max(most, -least)
    if bound > 1.5 * usual:
        bound = usual
    bound = bound or 1.0
    levels = list(mpl.ticker.MaxNLocator(10, steps=[1, 2, 2.5, 5, 10]).tick_values(-bound, bound))
    extend = {
        (False, False): "neither",
        (True, False): "min",
        (False, True): "max",
        (True, True): "both",
    }
    return levels[-1], levels, extend[least < levels[0], most > levels[-1]]


def _draw_panel(axes: Axes, data: MapData, panel: int, colour: Any, ticks: int) -> None:
    """Draw the margins and limits of one panel, with at most so many ticks on x."""
    x = data.x
    y = data.y
    margin = np.ma.masked_invalid(data.margins[panel])
    if margin.mask.any():
        axes.patch.set(**unknown_hatch())
    style: dict[str, Any] = {"cmap": colour.cmap, "norm": colour.norm, "rasterized": True}
    axes.pcolormesh(x.edges, y.edges, margin, gid="margin", **style)
    if _has_cells(data):
        _mark_cells(axes, data, panel)
        x.apply(axes, "x", ticks=ticks, cells=True)
        y.apply(axes, "y", cells=True)
        axes.invert_yaxis()  # the first row of a table is its top one
        return
    for place, (limit, rooms) in enumerate(data.rooms.items()):
        if limit == STIFFNESS:
            _hatch_negative(axes, x, y, rooms[panel])
        line_colour = _limit_colour(place)
        _draw_limit(axes, x, y, rooms[panel], gid=limit, width=_LIMIT_WIDTH, colour=line_colour)
    margins = data.margins[panel]
    _draw_limit(axes, x, y, margins, gid="boundary", width=_BOUNDARY_WIDTH, colour=INK)
    x.apply(axes, "x", ticks=ticks, cells=True)
    y.apply(axes, "y", cells=True)


def _has_cells(data: MapData) -> bool:
    """Return True if both axes are of names, so that each cell stands for itself."""
    return bool(data.x.names and data.y.names)


def _mark_cells(axes: Axes, data: MapData, panel: int) -> None:
    """Mark each cell of a panel: its margin, a hatch if it is unstable, broken limits as squares.

    Nothing is drawn between cells, because nothing was computed there.
    """
    if STIFFNESS in data.rooms:
        _hatch_negative(axes, data.x, data.y, data.rooms[STIFFNESS][panel])
    margins = data.margins[panel]
    if margins.size <= _MOST_WRITTEN and len(data.x.names) <= _MOST_WRITTEN_IN_ROW:
        style: dict[str, Any] = {"ha": "center", "va": "center", "size": 6.5, "gid": "value"}
        for row, column in np.argwhere(np.isfinite(margins)):
            words = labels.number(float(f"{margins[row, column]:.3g}"))
            axes.text(column, row, words, path_effects=[_HALO], zorder=4, **style)
    limits = [name for name in data.limits if name != STIFFNESS]
    for place, limit in enumerate(limits):
        rows, columns = np.nonzero(data.rooms[limit][panel] < 0.0)
        across = columns - 0.38 + 0.1 * place
        axes.plot(across, rows, gid=limit, **_broken_style(list(data.limits).index(limit)))


def _broken_style(place: int) -> dict[str, Any]:
    """Return the style of the square that marks a broken limit, by the limit's place."""
    style: dict[str, Any] = {"marker": "s", "linestyle": "none", "markersize": 4.0, "zorder": 5}
    return {**style, "color": _limit_colour(place), "markeredgecolor": "white"}


def _limit_colour(place: int) -> str:
    """Return the colour of a limit by its place among the limits; the first is on stiffness."""
    if place == 0:
        return LIMIT_COLOURS[0]
    return LIMIT_COLOURS[1 + (place - 1) % (len(LIMIT_COLOURS) - 1)]


def _draw_limit(
    axes: Axes, x: Scale, y: Scale, room: Floats, *, gid: str, width: float, colour: str
) -> None:
    """Draw the line where a limit is just kept, with ticks on the side where it is broken.

    If an axis is of names, there is a stroke across each name instead.

    Args:
        axes: The panel.
        x: Scale of x.
        y: Scale of y.
        room: Distance to the limit (y, x), in the order of the scales.
        gid: Name of the line in the file.
        width: Width of the line, pt.
        colour: Colour of the line.
    """
    effects = [_HALO, *_EFFECTS]
    if x.names or y.names:
        style: dict[str, Any] = {"solid_capstyle": "butt", "color": colour, "linewidth": width}
        for stroke_x, stroke_y in _strokes(x, y, room):
            axes.plot(stroke_x, stroke_y, path_effects=effects, gid=gid, **style)
    elif _has_line(x, y, room):
        places = _extend_to_edges(x, y, room)
        lines = axes.contour(*places, levels=[0.0], colors=colour, linewidths=width)
        lines.set(path_effects=effects, gid=gid)


def _has_line(x: Scale, y: Scale, room: Floats) -> bool:
    """Return True if a line shows in a panel (y, x) where a limit is just kept.

    If all designs of a panel keep the limit or all break it, there is none, although in a straight
    line beyond the outermost designs there might be one.
    """
    if x.names or y.names:
        return bool(_strokes(x, y, room))
    if min(room.shape) == 1 or not crosses_zero(room):
        return False
    # Without the value of one corner a contour is drawn in the triangle of the other three.
    _, _, values = _extend_to_edges(x, y, room)
    values = values.filled(np.nan)
    corners = np.stack([values[:-1, :-1], values[:-1, 1:], values[1:, :-1], values[1:, 1:]])
    is_drawn = np.isfinite(corners).sum(axis=0) >= 3
    is_above = (corners > 0.0).any(axis=0)
    is_below = (corners <= 0.0).any(axis=0)
    return bool((is_drawn & is_above & is_below).any())


def _zero_crossings(places: Floats, values: Floats) -> list[tuple[float, bool]]:
    """Return the places where values cross zero, and whether they rise there.

    Values are interpolated linearly between places.
    """
    low = values[:-1]
    high = values[1:]
    is_known = np.isfinite(low) & np.isfinite(high)
    before = np.flatnonzero(is_known & ((low < 0.0) != (high < 0.0)))
    step = places[before + 1] - places[before]
    zeros = places[before] + low[before] / (low[before] - high[before]) * step
    rises = high[before] > low[before]
    return list(zip(zeros.tolist(), rises.tolist(), strict=True))


def _hatch_negative(axes: Axes, x: Scale, y: Scale, room: Floats) -> None:
    """Hatch where `room` is negative, up to the line where it is zero.

    If there is no such line, because an axis is of names or has one value or because no design has
    room, whole cells are hatched. Cells of NaN (no equilibrium) are not.
    """
    is_negative = room < 0.0
    if not is_negative.any():
        return
    if x.names or y.names or not _has_line(x, y, room):
        cells = np.ma.masked_where(~is_negative, room)
        style: dict[str, Any] = {"facecolor": "none", "hatch": _HATCH, **_HATCH_EDGE}
        axes.pcolor(x.edges, y.edges, cells, gid="unstable", **style)
        return
    places = _extend_to_edges(x, y, room)
    area = axes.contourf(*places, levels=[-np.inf, 0.0], colors="none", hatches=[_HATCH])
    area.set(gid="unstable", **_HATCH_EDGE)


def _strokes(x: Scale, y: Scale, room: Floats) -> list[tuple[Sequence[float], Sequence[float]]]:
    """Return x and y of a stroke across each name where `room` changes its sign.

    One of the axes is of names. A stroke is drawn so that the higher side is on its left, as that
    of a contour is.
    """
    strokes: list[tuple[Sequence[float], Sequence[float]]] = []
    if x.names:
        for place, line in enumerate(room.T):
            for zero, rises in _zero_crossings(y.places, line):
                across = (place - 0.5, place + 0.5)
                strokes.append((across if rises else across[::-1], [zero, zero]))
    else:
        for place, line in enumerate(room):
            for zero, rises in _zero_crossings(x.places, line):
                across = (place - 0.5, place + 0.5)
                strokes.append(([zero, zero], across[::-1] if rises else across))
    return strokes


def _extend_to_edges(x: Scale, y: Scale, values: Floats) -> tuple[Floats, Floats, Any]:
    """Return places and values, extended in a straight line to the outer edges of the cells."""
    x_places = np.concatenate((x.edges[:1], x.places, x.edges[-1:]))
    y_places = np.concatenate((y.edges[:1], y.places, y.edges[-1:]))
    for axis in (0, 1):
        first, second, last, next_to_last = (np.take(values, [at], axis) for at in (0, 1, -1, -2))
        start = 1.5 * first - 0.5 * second
        end = 1.5 * last - 0.5 * next_to_last
        values = np.concatenate((start, values, end), axis)
    return x_places, y_places, np.ma.masked_invalid(values)


def _remarks(margins: Floats) -> list[str]:
    """Return a sentence if no line separates slack from taut designs, because all are alike."""
    known = margins[np.isfinite(margins)]
    if not len(known) or known.min() < 0.0 <= known.max():
        return []
    return ["No design goes slack." if known.min() >= 0.0 else "Every design goes slack."]


def _limit_remarks(data: MapData, panels: range) -> list[str]:
    """Say which limits no line on a page shows, because they leave nothing or bind nowhere.

    In cells by name, all that is left to say is which limits every design keeps.
    """
    if _has_cells(data):
        seen = slice(panels.start, panels.stop)
        kept = [
            text
            for name, text in data.limits.items()
            if name not in data.defaults and (data.rooms[name][seen] >= 0.0).all()
        ]
        return [f"Every design keeps {say.join_words(kept)}."] if kept else []
    pieces: dict[str, list[Floats]] = {name: [] for name in data.limits}
    places: list[str] = []
    for panel in panels:
        names = data.x.names or data.y.names or ("",)
        title = data.titles[panel] if len(data.titles) > 1 else ""
        places += [", ".join(text for text in (title, name) if text) for name in names]
        for limit, rooms in data.rooms.items():
            pieces[limit] += _pieces(data.x, data.y, rooms[panel])
    limits = {}
    for name, text in data.limits.items():
        is_broken = any((room < 0.0).any() for room in pieces[name])
        is_hatched = name == STIFFNESS and crosses_zero(
            data.rooms[name][panels.start : panels.stop]
        )
        if not is_hatched and (is_broken or name not in data.defaults):
            limits[name] = text
    return limit_remarks(limits, pieces, places)


def _pieces(x: Scale, y: Scale, room: Floats) -> list[Floats]:
    """Return the pieces of a panel (y, x) that have lines of their own: each name has some."""
    if x.names:
        return [*room.T]
    if y.names:
        return [*room]
    return [room]


def _key(data: MapData, seen: slice) -> list[Any]:
    """Return the key to the lines and hatches in the panels seen."""
    key: list[Any] = []
    if _has_cells(data):
        return _key_of_cells(data, seen)
    if any(_has_line(data.x, data.y, margins) for margins in data.margins[seen]):
        label = "margin = 0, ticks on the slack side"
        key.append(_key_line(label, _BOUNDARY_WIDTH, INK))
    for place, (limit, label) in enumerate(data.limits.items()):
        rooms = data.rooms[limit][seen]
        if limit == STIFFNESS and (rooms < 0.0).any():
            key.append(Patch(facecolor="none", label=data.unstable, hatch=_HATCH, **_HATCH_EDGE))
        if any(_has_line(data.x, data.y, room) for room in rooms):
            key.append(_key_line(label, _LIMIT_WIDTH, _limit_colour(place)))
    if not np.isfinite(data.margins[seen]).all():
        key.append(hatch_key("no equilibrium at some elbow angle"))
    return key


def _key_of_cells(data: MapData, seen: slice) -> list[Any]:
    """Return the key to the hatches and squares in the cells of the panels seen."""
    key: list[Any] = []
    for place, (limit, label) in enumerate(data.limits.items()):
        if not (data.rooms[limit][seen] < 0.0).any():
            continue
        if limit == STIFFNESS:
            key.append(Patch(facecolor="none", label=data.unstable, hatch=_HATCH, **_HATCH_EDGE))
        else:
            key.append(Line2D([], [], label=f"breaks {label}", **_broken_style(place)))
    if not np.isfinite(data.margins[seen]).all():
        key.append(hatch_key("no equilibrium at some elbow angle"))
    return key


def _key_line(label: str, width: float, colour: str) -> Line2D:
    """Return the line of a limit for the key; `width` is in pt."""
    style: dict[str, Any] = {"color": colour, "linewidth": width, "path_effects": _EFFECTS}
    return Line2D([], [], label=label, **style)
