"""A value over two axes of a table, in panels for all other axes, and how that is drawn.

Slack maps and the maps of an answer are slices. Between listed values there is nothing, so that
their cells are hatched and outlined whole; between the values of a range limits are lines.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.cube.axes import LOAD
from tendon_cli.cube.cube import Cube
from tendon_cli.figures.backend import (
    Axes,
    Line2D,
    Outline,
    Patch,
    PathPatch,
    TickedStroke,
    mpl,
    withStroke,
)
from tendon_cli.figures.frame import Page, fitted, grid_shape, label_panels, panels_of, text_width
from tendon_cli.figures.layout import fewer, thin_out
from tendon_cli.figures.limit_remarks import crosses_zero
from tendon_cli.figures.scales import Scale, axis_scale, value_texts
from tendon_cli.figures.style import INK, PAGE_HEIGHT, STAR, hatch_key, unknown_hatch
from tendon_cli.model.kinematics import Rows
from tendon_cli.space.axis import Axis

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

MOST_PAGES = 12
"""Largest number of pages of panels; of more panels some are drawn, and the figure says so."""
_MOST_CELLS = 2000
"""Largest number of cells along an axis: more than a page has dots."""
_NARROWEST = 36.0
"""Least width of a panel with its labels, mm."""
_BAR = 20.0
"""Width of a colour bar with its labels, mm."""
_NARROW_PAGE = 100.0
"""Width up to which a page has its colour bar below the panels, mm."""
_SIDE = 12.0
"""Width of the labels beside all panels, mm."""
_TEXT_SIZE = 6.0
"""Size of the texts in cells, pt."""
_TEXT_HEIGHT = 2.7
"""Height of a line of them, mm."""
_STAR_HEIGHT = 4.5
"""Height that a star takes of its cell, mm."""
# Contours run with the higher values on their left. The ticks are on the right, where a limit is
# broken.
_TICKS = [
    TickedStroke(spacing=5.0, angle=-90.0, length=0.45, linewidth=0.6),
    mpl.patheffects.Normal(),
]
_HALO = withStroke(linewidth=2.6, foreground="white")


@dataclass(frozen=True)
class Area:
    """Cells that a style marks whole, or the part of a map of ranges in which `room` is negative.

    Arrays are of shape (panels, y, x).
    """

    name: str
    label: str
    style: Mapping[str, Any]
    holds: Flags
    room: Floats | None = None


@dataclass(frozen=True)
class Border:
    """A limit: a line where its room is zero, or around the cells that break it."""

    name: str
    label: str
    room: Floats
    """Room that the limit leaves, negative where it is broken, (panels, y, x)."""
    colour: str
    width: float = 0.8
    has_ticks: bool = True


@dataclass(frozen=True)
class Colours:
    """Colours of the values of a map, and their bar; dark is more."""

    map: Any
    norm: Any
    label: str
    ticks: Sequence[float] | None = None
    extend: str = "neither"
    below: Any = None
    """Other colours of the values below zero that `Slice.others` marks; None without any."""


@dataclass(frozen=True)
class Slice:
    """A value over two axes of a table, in panels for the rest; arrays (panels, y, x)."""

    x: Scale
    y: Scale
    titles: tuple[str, ...]
    """Titles of the panels."""
    in_row: int
    """Number of neighbouring panels that differ in one axis only."""
    values: Floats
    colours: Colours
    others: Flags | None = None
    """Cells whose values below zero have the colours `below`."""
    areas: tuple[Area, ...] = ()
    borders: tuple[Border, ...] = ()
    texts: tuple[npt.NDArray[Any], ...] = ()
    """Texts of the cells, ever shorter: the first that have room are written."""
    star: tuple[int, float, float] | None = None
    """Panel of the choice named first, and its coordinates."""
    unknown: str = ""
    """Label of cells without a value."""
    is_in_cells: bool = False
    """True if nothing is drawn between the cells, even of ranges."""

    @property
    def has_lines(self) -> bool:
        """True if both axes are ranges of several values, between which limits are lines."""
        is_listed = bool(self.x.names or self.y.names) or self.is_in_cells
        return not is_listed and min(self.values.shape[1:]) > 1

    def at(self, panels: Sequence[int]) -> Slice:
        """Return some of the panels."""
        chosen = list(panels)
        star = self.star
        if star is not None:
            star = (chosen.index(star[0]), *star[1:]) if star[0] in chosen else None
        return replace(
            self,
            titles=tuple(self.titles[panel] for panel in chosen),
            values=self.values[chosen],
            others=None if self.others is None else self.others[chosen],
            areas=tuple(
                replace(
                    area,
                    holds=area.holds[chosen],
                    room=None if area.room is None else area.room[chosen],
                )
                for area in self.areas
            ),
            borders=tuple(replace(border, room=border.room[chosen]) for border in self.borders),
            texts=tuple(texts[chosen] for texts in self.texts),
            star=star,
        )

    def key(self) -> list[Any]:
        """Return the key to what is drawn over the colours."""
        key: list[Any] = [
            Line2D([], [], label=border.label, **_line_style(border))
            for border in self.borders
            if any(map(self.shows, border.room))
        ]
        key += [
            Patch(label=area.label, **{"linewidth": 0.4, **area.style})
            for area in self.areas
            if area.holds.any()
        ]
        if self.unknown and not np.isfinite(self.values).all():
            key.append(hatch_key(self.unknown))
        return key

    def shows(self, room: Floats) -> bool:
        """Return True if a panel (y, x) shows the line of a limit."""
        if not self.has_lines:
            return bool((room < 0.0).any())
        if not crosses_zero(room):
            return False
        # Without the value of one corner a contour is drawn in the triangle of the other three.
        _, _, values = _to_edges(self.x, self.y, room)
        values = values.filled(np.nan)
        corners = np.stack([values[:-1, :-1], values[:-1, 1:], values[1:, :-1], values[1:, 1:]])
        is_drawn = np.isfinite(corners).sum(axis=0) >= 3
        is_above = (corners > 0.0).any(axis=0)
        is_below = (corners <= 0.0).any(axis=0)
        return bool((is_drawn & is_above & is_below).any())


@dataclass(frozen=True)
class PanelGrid:
    """Rows of a table in panels over two axes."""

    x: Scale
    y: Scale
    rows: Rows
    """Row numbers (panels, y, x) in the order of the scales."""
    titles: tuple[str, ...]
    in_row: int
    notes: tuple[str, ...]
    """Sentence on what is left out, if not all is drawn."""


def grid_of(
    cube: Cube,
    axes: tuple[Axis, Axis],
    chosen: Mapping[str, Rows],
    width: float,
    units: Mapping[str, str] | None = None,
) -> PanelGrid:
    """Lay rows of a table out in panels; the load varies fastest, so that it is seen side by side.

    Args:
        cube: The table.
        axes: Axes across and up.
        chosen: Positions to choose from, by the column of the axis.
        width: Width of a page, mm.
        units: Units to show, by dimension.
    """
    others = [axis for axis in cube.axes if axis not in axes and len(chosen[axis.column]) > 1]
    others.sort(key=lambda axis: axis.column != LOAD)
    rows_of_page, columns = _most_panels(width)
    counts = [len(chosen[axis.column]) for axis in others]
    counts = fewer(counts, MOST_PAGES * rows_of_page * columns)
    most = dict.fromkeys(axes, _MOST_CELLS) | dict(zip(others, counts, strict=True))
    positions, notes = thin_out(cube, chosen, most)
    units = units or {}
    scales = [
        axis_scale(cube, axis, positions[axis.column], units, has_cells=True) for axis in axes
    ]
    if axes[1].is_text:
        scales[1] = scales[1].reversed()  # the first row of a table is the top one
    order = [axis.column for axis in (*reversed(others), axes[1], axes[0])]
    rows = cube.rows(order, positions)
    rows = rows.reshape(-1, *rows.shape[-2:])[:, scales[1].order][..., scales[0].order]
    texts = [value_texts(cube, axis, positions[axis.column], units) for axis in reversed(others)]
    titles = tuple(", ".join(reversed(words)) for words in itertools.product(*texts))
    in_row = len(positions[others[0].column]) if others else 1
    return PanelGrid(scales[0], scales[1], rows, titles, in_row, notes)


def _most_panels(width: float) -> tuple[int, int]:
    """Return the most rows and columns of panels on a page of a width in mm."""
    room = width - _bar_width(width)
    columns = max(1, int(room / _NARROWEST))
    return max(1, int(PAGE_HEIGHT / (0.8 * room / columns + 7.0))), columns


def _bar_width(width: float) -> float:
    """Return the width of the colour bar, mm; on a narrow page it is below the panels."""
    return _BAR if width > _NARROW_PAGE else 0.0


# --- Pages ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Shape:
    """Rows and columns of panels on a page, and about the size of a panel, mm."""

    rows: int
    columns: int
    width: float
    height: float
    bar: float
    """Height of the colour bar, if it is below the panels, mm."""

    @property
    def total(self) -> float:
        """Height of all panels with their titles and labels, mm."""
        return min(PAGE_HEIGHT, self.rows * (self.height + 7.0) + 8.0) + self.bar


def pages_of_panels(part: Slice, width: float) -> list[tuple[Slice, Shape]]:
    """Divide a slice into pages of at most so many panels as fit, each with its shape.

    Args:
        part: The slice.
        width: Width of a page, mm.
    """
    most_rows, most_columns = _most_panels(width)
    count = len(part.titles)
    per_page = most_rows * most_columns
    pages = []
    for start in range(0, count, per_page):
        chosen = range(start, min(count, start + per_page))
        rows, columns = grid_shape(len(chosen), part.in_row, most=most_columns)
        panel = (width - _bar_width(width) - _SIDE) / columns - 2.0
        height = 0.8 * panel
        if count == 1:
            height = 0.62 * panel
        if part.y.names:
            height = max(height, 3.2 * len(part.y.names))
        height = min(height, 85.0)
        bar = 0.0 if _bar_width(width) else 14.0
        pages.append((part.at(chosen), Shape(rows, columns, panel, height, bar)))
    return pages


def draw_slice(page: Page, part: Slice, shape: Shape) -> None:
    """Draw the panels of a slice on a page, with their colour bar."""
    count = len(part.titles)
    panels = panels_of(page, shape.rows, shape.columns, count, sharex=True, sharey=True)
    height = (page.inner - shape.bar - 8.0) / shape.rows - 7.0
    for place, axes in enumerate(panels):
        part.x.apply(axes, "x", shape.width, cells=True)
        part.y.apply(axes, "y", height, cells=True)
        _draw_panel(axes, part, place)
        _write_cells(axes, part, place, shape.width, height)
        # With y given, matplotlib does not search for the title's place.
        axes.set_title(fitted(part.titles[place], shape.width), y=1.0)
    label_panels(panels, part.x.label, part.y.label, shape.width, height)
    _draw_bar(page, part, panels)


def _draw_panel(axes: Axes, part: Slice, panel: int) -> None:
    values = np.ma.masked_invalid(part.values[panel])
    edges = part.x.edges, part.y.edges
    if values.mask.any():
        axes.patch.set(**unknown_hatch())
    colours = part.colours
    style: dict[str, Any] = {"norm": colours.norm, "rasterized": True}
    axes.pcolormesh(*edges, values, cmap=colours.map, gid="value", **style)
    if part.others is not None and part.others[panel].any():
        of_others = np.ma.masked_where(~part.others[panel], values)
        axes.pcolormesh(*edges, of_others, cmap=colours.below, gid="other", **style)
    for area in part.areas:
        if area.holds[panel].any():
            _draw_area(axes, part, area, panel)
    for border in part.borders:
        if part.shows(border.room[panel]):
            _draw_border(axes, part, border, panel)
    if part.star is not None and part.star[0] == panel:
        _, across, up = part.star
        axes.plot([across], [up], gid="best", **STAR)


def _draw_area(axes: Axes, part: Slice, area: Area, panel: int) -> None:
    """Draw whole cells as one patch, or in a map of ranges the part where room is negative."""
    style = {**area.style, "linewidth": 0.0}
    if part.has_lines and area.room is not None:
        places = _to_edges(part.x, part.y, area.room[panel])
        hatched = axes.contourf(
            *places, levels=[-np.inf, 0.0], colors="none", hatches=[style["hatch"]]
        )
        hatched.set(gid=area.name, edgecolor=style["edgecolor"], linewidth=0.0)
        return
    x = part.x.edges
    y = part.y.edges
    rows, columns = np.nonzero(area.holds[panel])
    left = x[columns]
    right = x[columns + 1]
    low = y[rows]
    high = y[rows + 1]
    across = np.stack([left, right, right, left, left], axis=1)
    up = np.stack([low, low, high, high, low], axis=1)
    corners = np.stack([across, up], axis=-1).reshape(-1, 2)
    codes = np.tile([Outline.MOVETO, *[Outline.LINETO] * 3, Outline.CLOSEPOLY], len(rows))
    axes.add_patch(PathPatch(Outline(corners, codes), gid=area.name, **style))


def _line_style(border: Border) -> dict[str, Any]:
    style: dict[str, Any] = {"color": border.colour, "linewidth": border.width}
    return {**style, "path_effects": _TICKS} if border.has_ticks else style


def _draw_border(axes: Axes, part: Slice, border: Border, panel: int) -> None:
    """Draw the line of a limit, with ticks on the side where it is broken."""
    room = border.room[panel]
    style = _line_style(border)
    if part.has_lines:
        effects = [_HALO, *style.get("path_effects", ())]
        places = _to_edges(part.x, part.y, room)
        drawn = axes.contour(*places, levels=[0.0], colors=border.colour, linewidths=border.width)
        drawn.set(path_effects=effects, gid=border.name)
        return
    ends = _outline(part.x.edges, part.y.edges, room < 0.0)
    codes = np.tile([Outline.MOVETO, Outline.LINETO], len(ends))
    outline = Outline(ends.reshape(-1, 2), codes)
    style["edgecolor"] = style.pop("color")
    patch = PathPatch(outline, fill=False, gid=border.name, zorder=4, clip_on=False, **style)
    patch.set_in_layout(False)
    axes.add_patch(patch)


def _outline(x: Floats, y: Floats, inside: Flags) -> Floats:
    """Return the edges around some cells (y, x), with these on their right, (edges, 2, 2)."""
    padded = np.pad(inside.astype(np.int8), 1)
    edges = []
    steps = np.diff(padded, axis=1)[1:-1]
    for row, column in np.argwhere(steps != 0):
        ends = y[[row, row + 1]][:: steps[row, column]]
        edges.append([(x[column], end) for end in ends])
    steps = np.diff(padded, axis=0)[:, 1:-1]
    for row, column in np.argwhere(steps != 0):
        ends = x[[column, column + 1]][:: -steps[row, column]]
        edges.append([(end, y[row]) for end in ends])
    return np.array(edges)


def _to_edges(x: Scale, y: Scale, values: Floats) -> tuple[Floats, Floats, Any]:
    """Return places and values, extended in a straight line to the outer edges of the cells."""
    x_places = np.concatenate((x.edges[:1], x.places, x.edges[-1:]))
    y_places = np.concatenate((y.edges[:1], y.places, y.edges[-1:]))
    for axis in (0, 1):
        first, second, last, next_to_last = (np.take(values, [at], axis) for at in (0, 1, -1, -2))
        start = 1.5 * first - 0.5 * second
        end = 1.5 * last - 0.5 * next_to_last
        values = np.concatenate((start, values, end), axis)
    return x_places, y_places, np.ma.masked_invalid(values)


def _write_cells(axes: Axes, part: Slice, panel: int, width: float, height: float) -> None:
    """Write the longest texts that have room in the cells of a panel; its size is in mm."""
    shares = [float(np.diff(edges).min() / np.ptp(edges)) for edges in (part.x.edges, part.y.edges)]
    cell_width = 0.9 * shares[0] * width
    cell_height = 0.94 * shares[1] * height
    for texts in part.texts:
        known = [text for text in texts.ravel().tolist() if text]
        if len(known) > 4 * width * height / _TEXT_HEIGHT**2:
            continue
        lines = max((text.count("\n") + 1 for text in known), default=1)
        widest = max((text_width(text, _TEXT_SIZE) for text in known), default=0.0)
        if widest <= cell_width and lines * _TEXT_HEIGHT <= cell_height:
            _write(axes, part, panel, texts[panel], cell_height)
            return


def _write(axes: Axes, part: Slice, panel: int, texts: npt.NDArray[Any], height: float) -> None:
    """Write a text into each cell of a height in mm; below the star one that has room for both."""
    starred = None
    if part.star is not None and part.star[0] == panel:
        _, across, up = part.star
        starred = (
            int(np.searchsorted(part.y.edges, up)) - 1,
            int(np.searchsorted(part.x.edges, across)) - 1,
        )
    values = part.values[panel]
    shades = part.colours.map(part.colours.norm(np.nan_to_num(values)))
    is_dark = (shades[..., :3] @ [0.299, 0.587, 0.114] < 0.5) & np.isfinite(values)
    is_hatched = np.zeros(texts.shape, dtype=np.bool_)
    for area in part.areas:
        is_hatched |= area.holds[panel]
    style: dict[str, Any] = {"ha": "center", "va": "center", "size": _TEXT_SIZE, "gid": "text"}
    style["in_layout"] = False
    for row, column in np.ndindex(*texts.shape):
        across = part.x.edges[column : column + 2].mean()
        low, high = part.y.edges[row : row + 2]
        up = (low + high) / 2.0
        words: Any = texts[row, column]
        if (row, column) == starred:
            shorter = [words, *(form[panel, row, column] for form in part.texts)]
            room = (height - _STAR_HEIGHT) / 2.0  # below the star, mm
            fits = int(room / _TEXT_HEIGHT)
            words = next((form for form in shorter if form.count("\n") < fits), "")
            up = low + room / 2.0 / height * (high - low)
        colours = ("white", INK) if is_dark[row, column] else (INK, "white")
        text = axes.text(across, up, words, color=colours[0], **style)
        if is_hatched[row, column]:
            text.set_path_effects([withStroke(linewidth=2.0, foreground=colours[1])])


def _draw_bar(page: Page, part: Slice, panels: Sequence[Axes]) -> None:
    """Draw the colour bar; both kinds of values below zero stand in it side by side."""
    if not np.isfinite(part.values).any():
        return
    colours = part.colours
    mappable = mpl.cm.ScalarMappable(colours.norm, colours.map)
    is_narrow = page.width <= _NARROW_PAGE
    bar = page.figure.colorbar(
        mappable,
        ax=list(panels),
        aspect=28,
        pad=0.02,
        location="bottom" if is_narrow else "right",
        extend=colours.extend,
        ticks=colours.ticks,
    )
    bar.set_label(fitted(colours.label, page.width if is_narrow else page.inner), linespacing=1.3)
    bar.outline.set_linewidth(0.5)
    low = colours.norm.vmin
    if part.others is not None and part.others.any():
        ramp = np.linspace(low, 0.0, 64)
        steps = np.linspace(low, 0.0, 65)
        half = np.array([0.5, 1.0])
        style: dict[str, Any] = {"cmap": colours.below, "norm": colours.norm}
        if is_narrow:
            bar.ax.pcolormesh(steps, half, ramp[np.newaxis], **style)
        else:
            bar.ax.pcolormesh(half, steps, ramp[:, np.newaxis], **style)
    if low < 0.0:
        line = bar.ax.axvline if is_narrow else bar.ax.axhline
        line(0.0, color=INK, linewidth=1.2)
