"""The pages of a slack map: margin in colour, where a tendon goes slack, where the elbow is unstable."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tendon_cli.cube.labels import Shown
from tendon_cli.figures.engine import Axes, Figure, Line2D, Patch, TickedStroke, TwoSlopeNorm, mpl, withStroke
from tendon_cli.figures.frame import Frame, Page, Panels, grid_shape
from tendon_cli.figures.maps.data import STIFFNESS, Floats, MapData, Panel
from tendon_cli.figures.plan import PANELS_PER_PAGE
from tendon_cli.figures.scales import Scale
from tendon_cli.figures.style import DIVERGING, INK, PAGE_HEIGHT, broken, hatch_key, unknown_hatch, wrapped

_BAR = 35.0
"""Width of labels and colour bar, mm."""
_NARROWEST = 42.0
"""Width that a panel takes up at least, mm."""
_BOUNDARY_WIDTH = 1.2
_UNSTABLE: dict[str, Any] = {"hatch": "xxxx", "edgecolor": "#4d4d4d"}
_FEWEST_FOR_LEVELS = 6
_ROUND = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0)
# Contours run with the higher values on their left; the ticks stand on the right, where a limit is not held.
_TICKS = TickedStroke(spacing=5.0, angle=-90.0, length=0.45, linewidth=0.6)
_HALO = withStroke(linewidth=2.6, foreground="white")
_EFFECTS = [_TICKS, mpl.patheffects.Normal()]
_LINES = (INK, "#006b4e", "#8f2d72", "#5a4a00", "#7a0019", "#003a70", "#4d4d4d")
"""Of limits."""


def draw_maps(data: MapData, width: float, height: float | None) -> list[Page]:
    """The pages of a map, of a size in mm."""
    parts = [data.panels[at : at + PANELS_PER_PAGE] for at in range(0, len(data.panels), PANELS_PER_PAGE)]
    names = [f"{data.title} (page {page} of {len(parts)})" for page in range(1, len(parts) + 1)]
    titles = names if len(parts) > 1 else [data.title]
    return [_page(data, panels, title, width, height) for panels, title in zip(parts, titles, strict=True)]


def _page(data: MapData, panels: Sequence[Panel], title: str, width: float, height: float | None) -> Page:
    rows, columns = grid_shape(len(panels), data.in_row, most=max(1, int(width / _NARROWEST)))
    each = (width - _BAR) / columns
    if len(panels) == 1 and height is None:
        each *= 0.8
    frame = Frame(width, title, _key(data, panels), (*_remarks(panels), *data.notes), study=data.study)
    tall = frame.panels_height(height, min(PAGE_HEIGHT, rows * min(0.8 * each + 6.0, 80.0) + 8.0))
    page = frame.page(tall)
    colours = colour_scale([panel.margin for panel in data.panels])
    panels_on = Panels.on(page, rows, columns, sharex=True, sharey=True)
    grid = panels_on.grid
    for axes, panel in zip(grid.flat, panels, strict=False):
        _draw_panel(axes, data, panel, colours, ticks=max(2, min(6, int(each / 9.0))))
        axes.set_title(wrapped(panel.title, int(each / 1.9)), y=1.0)  # placed without a search
    # Narrow panels have one label for all of them, in the middle: side by side they would run into each other.
    is_full = columns > 2 and rows * columns == len(panels)
    if is_full:
        grid[-1, (columns - 1) // 2].set_xlabel(data.x.label, x=0.5 if columns % 2 else 1.07)
    for at, axes in enumerate(grid.flat):
        axes.set_visible(at < len(panels))
        is_lowest = at + columns >= len(panels)
        axes.tick_params(labelbottom=is_lowest)
        if is_lowest and not is_full:
            axes.set_xlabel(broken(data.x.label, int(each / 1.9)))
        if at % columns == 0:
            axes.set_ylabel(broken(data.y.label, int(0.7 * tall / rows / 1.5)))
    bar = _colour_bar(page.figure, data.margin, colours)
    replace(panels_on, bar=bar).settle(must_fit=height is not None)
    return page


@dataclass(frozen=True)
class ColourScale:
    """Symmetric about zero and round; wide enough for all but the far ends."""

    limit: float
    levels: tuple[float, ...]
    extend: str
    """Which ends of the colour bar stand for values beyond it."""

    @property
    def norm(self) -> TwoSlopeNorm:
        """From a margin to its colour."""
        return TwoSlopeNorm(0.0, -self.limit, self.limit)


def colour_scale(margins: list[Floats]) -> ColourScale:
    """One scale for all panels: the positive side is shown whole, a far longer negative side is cut off."""
    finite = np.concatenate([panel[np.isfinite(panel)] for panel in margins]) if margins else np.zeros(0)
    most, least = (float(finite.max()), float(finite.min())) if len(finite) else (1.0, -1.0)
    usual = float(np.quantile(np.abs(finite), 0.9)) if len(finite) else 1.0
    bound = max(most, -least)
    if bound > 1.5 * max(usual, most):
        bound = max(usual, most)
    limit = _round_up(bound or 1.0)
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    levels = mpl.ticker.MaxNLocator(8, steps=[1, 2, 2.5, 5, 10]).tick_values(-limit, limit)
    inside = tuple(float(level) for level in levels if abs(level) <= limit * (1 + 1e-9))
    return ColourScale(limit, inside, extend[least < -limit, most > limit])


def _draw_panel(axes: Axes, data: MapData, panel: Panel, colours: ColourScale, ticks: int) -> None:
    """One panel, its cells whole, with at most so many ticks on x."""
    x, y = data.x, data.y
    margin = np.ma.masked_invalid(panel.margin)
    if margin.mask.any():
        axes.patch.set(**unknown_hatch())
    axes.pcolormesh(x.edges, y.edges, margin, cmap=DIVERGING, norm=colours.norm, rasterized=True, gid="margin")
    if not (x.names or y.names) and min(margin.shape) >= _FEWEST_FOR_LEVELS:
        levels = [level for level in colours.levels if level != 0.0 and margin.min() < level < margin.max()]
        axes.contour(*_to_the_edges(x, y, panel.margin), levels=levels, colors="#00000055", linewidths=0.35,
                     linestyles="solid") if levels else None  # fmt: skip
    for at, (limit, room) in enumerate(zip(data.limits, panel.rooms, strict=True)):
        if limit.key == STIFFNESS:
            _hatch_negative(axes, x, y, room, gid="unstable", **_UNSTABLE)
        draw_limit(axes, x, y, room, gid=limit.key, linewidth=0.8, color=_LINES[at % len(_LINES)])
    draw_limit(axes, x, y, panel.margin, gid="boundary", linewidth=_BOUNDARY_WIDTH)
    x.apply(axes, "x", ticks=ticks, cells=True)
    y.apply(axes, "y", cells=True)


def draw_limit(axes: Axes, x: Scale, y: Scale, room: Floats, *, gid: str, linewidth: float, color: str = INK) -> None:
    """The line where `room`, what is left up to a limit, is zero; ticks on the side where the limit is not held.

    `room` has the shape (y, x), in the order of the scales. Over names there is a stroke per name instead.
    """
    style: dict[str, Any] = {"color": color, "linewidth": linewidth, "gid": gid}
    effects = [_HALO, *_EFFECTS]
    if x.names or y.names:
        for xy in _strokes(x, y, room):
            axes.plot(*xy, path_effects=effects, solid_capstyle="butt", **style)
    elif min(room.shape) > 1 and crosses_zero(room):
        lines = axes.contour(*_to_the_edges(x, y, room), levels=[0.0], colors=color, linewidths=linewidth)
        lines.set(path_effects=effects, gid=gid)


def crosses_zero(room: Floats) -> bool:
    """Whether some designs hold a limit and others do not."""
    return bool(np.nanmin(room, initial=np.inf) < 0.0 <= np.nanmax(room, initial=-np.inf))


def zero_crossings(places: Floats, values: Floats) -> list[tuple[float, bool]]:
    """Where values along an axis cross zero, linearly between two of them, and whether they rise there."""
    crossings = []
    for at in range(len(values) - 1):
        low, high = values[at], values[at + 1]
        if np.isfinite(low) and np.isfinite(high) and (low < 0.0) != (high < 0.0):
            share = low / (low - high)
            crossings.append((float(places[at] + share * (places[at + 1] - places[at])), bool(high > low)))
    return crossings


def _hatch_negative(axes: Axes, x: Scale, y: Scale, room: Floats, *, gid: str, hatch: str, edgecolor: str) -> None:
    """Hatch where `room` is negative: over names cell by cell, else up to the line where it is zero."""
    if not (room < 0.0).any():
        return  # NaN is not: there is no equilibrium
    if x.names or y.names or min(room.shape) == 1:
        cells = np.ma.masked_where(~(room < 0.0), room)
        axes.pcolor(x.edges, y.edges, cells, hatch=hatch, facecolor="none", edgecolor=edgecolor, linewidth=0.0, gid=gid)
        return
    area = axes.contourf(*_to_the_edges(x, y, room), levels=[-np.inf, 0.0], colors="none", hatches=[hatch])
    area.set(edgecolor=edgecolor, linewidth=0.0, gid=gid)


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
        values = np.concatenate((1.5 * first - 0.5 * second, values, 1.5 * last - 0.5 * before), axis)
    return places[0], places[1], np.ma.masked_invalid(values)


def _remarks(panels: Sequence[Panel]) -> list[str]:
    """What the reader might look for in vain."""
    margins = np.concatenate([panel.margin.ravel() for panel in panels])
    known = margins[np.isfinite(margins)]
    remarks = []
    if len(known) and known.min() >= 0.0:
        remarks.append("No design goes slack.")
    if len(known) and known.max() < 0.0:
        remarks.append("Every design goes slack.")
    return remarks


def _key(data: MapData, panels: Sequence[Panel]) -> list[Any]:
    key: list[Any] = []
    if any(crosses_zero(panel.margin) for panel in panels):
        label = "margin = 0, ticks on the slack side"
        key.append(Line2D([], [], color=INK, linewidth=_BOUNDARY_WIDTH, path_effects=_EFFECTS, label=label))
    for at, limit in enumerate(data.limits):
        if limit.key == STIFFNESS and any((panel.rooms[at] < 0.0).any() for panel in panels):
            key.append(Patch(facecolor="none", linewidth=0.0, label=limit.label, **_UNSTABLE))
        elif any(crosses_zero(panel.rooms[at]) for panel in panels):
            key.append(
                Line2D([], [], color=_LINES[at % len(_LINES)], linewidth=0.8, path_effects=_EFFECTS, label=limit.label)
            )
    if not all(np.isfinite(panel.margin).all() for panel in panels):
        key.append(hatch_key("no equilibrium at some elbow angle"))
    return key


def _colour_bar(figure: Figure, margin: Shown, colours: ColourScale) -> Axes:
    colour = mpl.cm.ScalarMappable(norm=colours.norm, cmap=DIVERGING)
    axes = figure.add_axes((0.85, 0.2, 0.03, 0.6), label="<colorbar>")
    bar = figure.colorbar(colour, cax=axes, extend=colours.extend, spacing="proportional", ticks=list(colours.levels))
    bar.set_label(f"{margin.label}\n←  slack             taut  →", linespacing=1.4)
    bar.ax.axhline(0.0, color=INK, linewidth=1.2)
    bar.outline.set_linewidth(0.5)
    return bar.ax


def _round_up(value: float) -> float:
    """The next of the round numbers times a power of ten."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(step * power for step in _ROUND if step * power >= value * (1 - 1e-9)))
