"""A value over two axes of a table, in panels for all other axes, and how that is drawn.

Slack maps and the maps of an answer are slices. Between listed values there is nothing, so that
their cells are hatched and outlined whole; between the values of a range limits are lines.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from contourpy import contour_generator

from tendon_cli.cube.axes import LOAD
from tendon_cli.cube.cube import Cube
from tendon_cli.figures.backend import Axes, Patch, TickedStroke, mpl, withStroke
from tendon_cli.figures.frame import Page, fitted, grid_shape, panels_of, text_width
from tendon_cli.figures.layout import fewer, thin_out
from tendon_cli.figures.scales import Scale, axis_scale, value_texts
from tendon_cli.figures.style import INK, PAGE_HEIGHT, STAR, hatch_key, key_line, unknown_hatch
from tendon_cli.model.kinematics import Array, Flags, Rows
from tendon_cli.studies.space.axis import Axis

MOST_PAGES = 12
"""Largest number of pages of panels; of more panels some are drawn, and the figure says so."""
_MOST_CELLS = 2000
"""Largest number of cells along an axis: more than a page has dots."""
_NARROWEST = 36.0
"""Least width of a panel with its labels, mm."""
_BAR = 15.0
"""Height of the colour bar with its labels, mm."""
_ASPECT = 0.62
"""Usual height of a panel over its width."""
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
class PanelGrid:
    """Rows of a table in panels over two axes."""

    x: Scale
    y: Scale
    rows: Rows
    """Row numbers (panels, y, x) in the order of the scales."""
    titles: tuple[str, ...]
    in_row: int
    """Number of neighbouring panels that differ in one axis only."""
    notes: tuple[str, ...]
    """Sentence on what is left out, if not all is drawn."""


@dataclass(frozen=True)
class Area:
    """Part of a map that a style marks."""

    name: str
    label: str
    style: Mapping[str, Any]
    inside: Array | Flags
    """True in cells that are marked whole, or negative where a limit is broken, (panels, y, x)."""


@dataclass(frozen=True)
class Border:
    """A limit: a line where its room is zero, or around the cells that break it."""

    name: str
    label: str
    room: Array
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

    grid: PanelGrid
    values: Array
    colours: Colours
    others: Flags
    """Cells whose values below zero have the colours `below`."""
    areas: Sequence[Area] = ()
    borders: Sequence[Border] = ()
    texts: Sequence[npt.NDArray[Any]] = ()
    """Texts of the cells, ever shorter: the first that have room are written."""
    star: tuple[int, int, int] | None = None
    """Panel, row and column of the choice named first."""
    unknown: str = ""
    """Label of cells without a value."""
    is_in_cells: bool = False
    """True if nothing is drawn between the cells, even of ranges."""

    @property
    def has_lines(self) -> bool:
        """True if both axes are ranges of several values, between which limits are lines."""
        is_listed = bool(self.grid.x.names or self.grid.y.names) or self.is_in_cells
        return not is_listed and min(self.values.shape[1:]) > 1

    def key(self, panels: Sequence[int]) -> list[Any]:
        """Return the key to what is drawn over the colours of some panels."""
        key: list[Any] = [
            key_line(label=border.label, **_line_style(border))
            for border in self.borders
            if any(_has_line(self, border.room[panel]) for panel in panels)
        ]
        key += [
            Patch(label=area.label, **{"linewidth": 0.4, **area.style})
            for area in self.areas
            if _is_inside(area.inside[panels]).any()
        ]
        if self.unknown and not np.isfinite(self.values[panels]).all():
            key.append(hatch_key(self.unknown))
        return key


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
    others.reverse()
    most_rows, most_columns = _most_panels(width)
    counts = [len(chosen[axis.column]) for axis in others]
    counts = fewer(counts, MOST_PAGES * most_rows * most_columns)
    most = dict.fromkeys(axes, _MOST_CELLS) | dict(zip(others, counts, strict=True))
    positions, notes = thin_out(cube, chosen, most)
    units = units or {}
    x, y = (axis_scale(cube, axis, positions[axis.column], units, has_cells=True) for axis in axes)
    if axes[1].is_text:
        y = y.reversed()  # the first row of a table is the top one
    rows = cube.rows([axis.column for axis in (*others, axes[1], axes[0])], positions)
    rows = rows.reshape(-1, *rows.shape[-2:])[:, y.order][..., x.order]
    texts = [value_texts(cube, axis, positions[axis.column], units) for axis in others]
    titles = tuple(", ".join(reversed(words)) for words in itertools.product(*texts))
    return PanelGrid(x, y, rows, titles, len(texts[-1]) if texts else 1, notes)


def _most_panels(width: float) -> tuple[int, int]:
    """Return the most rows and columns of panels on a page of a width in mm."""
    columns = max(1, int(width / _NARROWEST))
    return max(1, int((PAGE_HEIGHT - _BAR) / (_ASPECT * width / columns + 7.0))), columns


# --- Pages ----------------------------------------------------------------------------------------


def draw_pages(
    part: Slice,
    width: float,
    begin: Callable[[list[int], str, float], Page],
) -> list[Page]:
    """Draw the panels of a slice with their colour bar, on as many pages as they need.

    Args:
        part: The slice.
        width: Width of a page, mm.
        begin: Function that begins a page with its title and key. It takes the numbers of its
            panels, what to add to the title, and the height of all panels, mm.
    """
    titles = part.grid.titles
    most_rows, most_columns = _most_panels(width)
    starts = range(0, len(titles), most_rows * most_columns)
    pages = []
    for number, start in enumerate(starts, 1):
        seen = list(range(start, min(len(titles), start + starts.step)))
        rows, columns = grid_shape(len(seen), part.grid.in_row, most=most_columns)
        across = (width - _SIDE) / columns - 2.0
        up = min(85.0, max(_ASPECT * across, 3.2 * len(part.grid.y.names)))
        total = min(PAGE_HEIGHT, rows * (up + 7.0) + 8.0 + _BAR)
        added = f" (page {number} of {len(starts)})" if len(starts) > 1 else ""
        page = begin(seen, added, total)
        up = (page.inner - _BAR - 8.0) / rows - 7.0
        panels = panels_of(page, rows, columns, len(seen), sharex=True, sharey=True)
        for panel, axes in zip(seen, panels, strict=True):
            part.grid.x.apply(axes, "x", across, cells=not part.has_lines)
            part.grid.y.apply(axes, "y", up, cells=not part.has_lines)
            _draw_panel(axes, part, panel)
            _write_cells(axes, part, panel, across, up)
            # With y given, matplotlib does not search for the title's place.
            axes.set_title(fitted(titles[panel], across), y=1.0)
            axes.set_xlabel(fitted(part.grid.x.label, across))
            axes.set_ylabel(fitted(part.grid.y.label, max(up, 20.0)))
        _draw_bar(page, part, panels)
        pages.append(page)
    return pages


def _is_inside(inside: Array | Flags) -> Flags:
    """Return the cells that an area marks, or that break a limit."""
    return np.asarray(inside if inside.dtype == np.bool_ else inside < 0.0, dtype=np.bool_)


def _field(part: Slice, inside: Array | Flags) -> tuple[Array, Array, Any]:
    """Return x, y and a value that is zero around an area of a panel, for contours.

    Each edge of a cell stands twice, so that the value jumps there.
    """
    if part.has_lines and inside.dtype != np.bool_:
        return part.grid.x.places, part.grid.y.places, np.ma.masked_invalid(inside)
    signs = np.where(_is_inside(inside), -1.0, 1.0).repeat(2, axis=0).repeat(2, axis=1)
    x, y = (scale.edges.repeat(2) for scale in (part.grid.x, part.grid.y))
    return x, y, np.pad(signs, 1, constant_values=1.0)


def _has_line(part: Slice, room: Array) -> bool:
    """Return True if a panel shows the line of a limit.

    Without the value of one corner a contour is drawn in the triangle of the other three.
    """
    return bool(contour_generator(*_field(part, room), corner_mask=True).lines(0.0))


def _line_style(border: Border) -> dict[str, Any]:
    style: dict[str, Any] = {"color": border.colour, "linewidth": border.width}
    return {**style, "path_effects": _TICKS} if border.has_ticks else style


def _draw_panel(axes: Axes, part: Slice, panel: int) -> None:
    values = np.ma.masked_invalid(part.values[panel])
    if values.mask.any():
        axes.patch.set(**unknown_hatch())
    for is_drawn, colours, name in (
        (~values.mask, part.colours.map, "value"),
        (part.others[panel], part.colours.below, "other"),
    ):
        if name == "value" or is_drawn.any():
            axes.pcolormesh(
                part.grid.x.edges,
                part.grid.y.edges,
                np.ma.masked_where(~is_drawn, values),
                cmap=colours,
                norm=part.colours.norm,
                rasterized=True,
                gid=name,
            )
    for area in part.areas:
        if _is_inside(area.inside[panel]).any():
            field = _field(part, area.inside[panel])
            colour = area.style["facecolor"]
            drawn = axes.contourf(
                *field, levels=[-np.inf, 0.0], colors=[colour], hatches=[area.style["hatch"]]
            )
            drawn.set(gid=area.name, edgecolor=area.style["edgecolor"], linewidth=0.0)
    for border in part.borders:
        if _has_line(part, border.room[panel]):
            drawn = axes.contour(
                *_field(part, border.room[panel]),
                levels=[0.0],
                colors=border.colour,
                linewidths=border.width,
            )
            halo = [_HALO] if part.has_lines else []
            ticks = _TICKS if border.has_ticks else []
            drawn.set(path_effects=[*halo, *ticks], gid=border.name, clip_on=part.has_lines)
    if part.star is not None and part.star[0] == panel:
        _, row, column = part.star
        axes.plot(part.grid.x.places[column], part.grid.y.places[row], gid="best", **STAR)


def _write_cells(axes: Axes, part: Slice, panel: int, width: float, height: float) -> None:
    """Write the longest texts that have room in the cells of a panel; its size is in mm."""
    grid = part.grid
    shares = [float(np.diff(edges).min() / np.ptp(edges)) for edges in (grid.x.edges, grid.y.edges)]
    cell_width = 0.9 * shares[0] * width
    cell_height = 0.94 * shares[1] * height

    def fits(text: str, room: float) -> bool:
        lines = text.count("\n") + 1
        return text_width(text, _TEXT_SIZE) <= cell_width and lines * _TEXT_HEIGHT <= room

    if part.values[panel].size > 4 * width * height / _TEXT_HEIGHT**2:
        return
    forms = [
        texts
        for texts in part.texts
        if all(fits(text, cell_height) for text in set(texts.ravel().tolist()))
    ]
    if not forms:
        return
    values = np.nan_to_num(part.values[panel])
    shades = part.colours.map(part.colours.norm(values))
    is_dark = (shades[..., :3] @ [0.299, 0.587, 0.114] < 0.5) & np.isfinite(part.values[panel])
    is_hatched = np.any([_is_inside(area.inside[panel]) for area in part.areas], axis=0)
    is_hatched = np.broadcast_to(is_hatched, is_dark.shape)
    for row, column in np.ndindex(*is_dark.shape):
        across = float(grid.x.edges[column : column + 2].mean())
        up = float(grid.y.edges[row : row + 2].mean())
        text = forms[0][panel, row, column]
        if part.star == (panel, row, column):  # below the star
            room = (cell_height - _STAR_HEIGHT) / 2.0
            shorter = [form[panel, row, column] for form in forms]
            text = next((words for words in shorter if fits(words, room)), "")
            up -= (cell_height - room) / 2.0 / height * float(np.ptp(grid.y.edges))
        colour, around = ("white", INK) if is_dark[row, column] else (INK, "white")
        written = axes.text(
            across,
            up,
            text,
            color=colour,
            ha="center",
            va="center",
            size=_TEXT_SIZE,
            gid="text",
            in_layout=False,
        )
        if is_hatched[row, column]:
            written.set_path_effects([withStroke(linewidth=2.0, foreground=around)])


def _draw_bar(page: Page, part: Slice, panels: Sequence[Axes]) -> None:
    """Draw the colour bar; both kinds of values below zero stand in it side by side."""
    if not np.isfinite(part.values).any():
        return
    colours = part.colours
    bar = page.figure.colorbar(
        mpl.cm.ScalarMappable(colours.norm, colours.map),
        ax=list(panels),
        aspect=50,
        location="bottom",
        extend=colours.extend,
        ticks=colours.ticks,
    )
    bar.set_label(fitted(colours.label, page.width - _SIDE))
    bar.outline.set_linewidth(0.5)
    low = colours.norm.vmin
    if part.others.any():
        steps = np.linspace(low, 0.0, 65)
        half = np.array([0.5, 1.0])
        ramp = np.linspace(low, 0.0, 64)[np.newaxis]
        bar.ax.pcolormesh(steps, half, ramp, cmap=colours.below, norm=colours.norm)
    if low < 0.0:
        bar.ax.axvline(0.0, color=INK, linewidth=1.2)
