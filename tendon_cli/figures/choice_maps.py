"""Maps of an answer's choices over two of their axes.

One map shows the tolerance, the other the share that one pretension serves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.answer_record import AnswerRecord, ChoiceRecord, value_of
from tendon_cli.cube.choice_grid import (
    conflicts_of,
    position,
    recorded_number,
    served_words,
    value_text,
)
from tendon_cli.cube.columns import ColumnArray
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import reading_unit
from tendon_cli.figures.backend import Axes, Line2D, ListedColormap, Patch, mpl
from tendon_cli.figures.frame import Page, framed, source_of
from tendon_cli.figures.scales import Scale, axis_scale, off_default
from tendon_cli.figures.style import INK, SEQUENTIAL, wrapped
from tendon_cli.space.axis import Axis

_PALE = ("#f6d9c5", "#e9e2f3", "#dcebe4", "#f7ecc8", "#e5e5e5", "#dbe7f3")
"""Background of cells without a window, one for each reason; further reasons share the last."""
_HATCHES = ("", "....", "----", "\\\\\\\\", "xxxx", "++++")
_BLUES = ListedColormap(
    [mpl.colormaps["Blues"](place) for place in np.linspace(0.15, 0.95, 256)], name="tendon_window"
)
_STAR = 11.0
"""Size of the star that marks a choice, pt."""
_STAR_PLACE = 0.72
"""Place of the star in its cell, above the value, as a share of the cell's height."""
_VALUE_PLACE = 0.28
"""Place of the value below the star, as a share of the cell's height."""
_PANEL_HEIGHT = 220.0
"""About the height of the panel of a map, pt."""
_MOST_WRITTEN = 120
"""Largest number of cells of a map whose values are also written in them."""
_MEANING = (
    "Tolerance: the share by which the pretension may be off on either side of the middle of its "
    "window. Pale: no pretension suits {}, for the reason given."
)
_SLICE_COLUMNS = ("pretension_from", "pretension_to", "tolerance", "served", "from_by", "to_by")


@dataclass(frozen=True)
class Slice:
    """Choices along one or two axes of the grid, all else as in one choice.

    Arrays are of shape (y, x) or (x,).
    """

    axes: tuple[Axis, ...]
    """Axis of x, and of y if there are two."""
    scales: tuple[Scale, ...]
    """Scale of each of these axes."""
    columns: dict[str, ColumnArray]
    title: str
    """Values of the other axes, in words."""
    bounds: dict[str, float]
    """Limits of the study by name, SI."""

    @classmethod
    def of(cls, cube: Cube, axes: Sequence[Axis], choice: ChoiceRecord) -> Slice:
        """Read the choices that differ from a choice along some axes only, in the scales' order."""
        scales = [axis_scale(cube, axis, slice(None), {}, is_log=False) for axis in axes]
        positions = {}
        texts = []
        for axis in cube.axes:
            if axis not in axes:
                place = position(axis, value_of(choice, axis.column))
                positions[axis.column] = place
                texts.append(value_text(cube, axis, axis.values[place[0]]))
        for axis, scale in zip(axes, scales, strict=True):
            positions[axis.column] = scale.order.astype(np.int64)
        rows = cube.rows([axis.column for axis in reversed(axes)], positions)
        columns = cube.gather(rows, _SLICE_COLUMNS)
        return cls(tuple(axes), tuple(scales), columns, ", ".join(texts), cube.limits)

    @property
    def low(self) -> ColumnArray:
        """Lower end of each window, N; NaN where no pretension balances the arm."""
        return self.columns["pretension_from"]

    @property
    def high(self) -> ColumnArray:
        """Upper end of each window, N; infinite where nothing bounds it."""
        high = self.columns["pretension_to"]
        is_open = np.isnan(high) & ~np.isnan(self.low)
        return np.where(is_open, np.inf, high)

    @property
    def conflicts(self) -> ColumnArray:
        """Reason in words why each choice has no window; empty if it has one."""
        return conflicts_of(self.columns, self.bounds)


def answer_page(
    cube: Cube,
    record: AnswerRecord,
    title: str,
    panels: float,
    key: list[Any],
    notes: list[str],
    *,
    subtitle: str = "",
) -> Page:
    """Begin a page of an answer's figure.

    Below the notes it says to which tensions the best choice is set, and which values of the study
    are not the default.

    Args:
        cube: Choices of the answer.
        record: Record of the answer.
        title: Title after the name of the study.
        panels: Height of the panels, mm.
        key: Artists with a label.
        notes: Sentences below the panels.
        subtitle: Second title, which may hold formulas.
    """
    study_title = record["title"] or record["name"]
    lines = [*notes, *_bench_text(record["best"])]
    given = off_default(cube.study, [axis.column for axis in cube.axes], {})
    if given:
        lines.append(f"With {', '.join(given)}; all else by default.")
    return framed(
        f"{study_title}: {title}",
        panels,
        key,
        lines,
        study=source_of(record),
        subtitle=wrapped(subtitle, 90),
    )


def _bench_text(best: ChoiceRecord | None) -> list[str]:
    """Return a sentence with the tensions to which the best choice is set, if they are known."""
    names = (
        "set_flexor_tension",
        "set_extensor_tension",
        "set_flexor_tension_motor",
        "set_extensor_tension_motor",
    )
    if best is None or any(value_of(best, name) is None for name in names):
        return []
    flexor, extensor, *motor = (say.quantity(name, value_of(best, name), 4) for name in names)
    joint = f"{flexor} in the flexor and {extensor} in the extensor at the joint"
    return [f"The best is set to {joint}, {' and '.join(motor)} at the motor."]


def star(**more: Any) -> Line2D:
    """Return the star that marks the choice named first, for the key."""
    return Line2D([], [], color=INK, marker="*", markersize=9, linestyle="", **more)


def choice_text(cube: Cube, choice: ChoiceRecord) -> str:
    """Describe a choice by its values."""
    return ", ".join(value_text(cube, axis, value_of(choice, axis.column)) for axis in cube.axes)


def long_axes(cube: Cube) -> list[Axis]:
    """Return the axes of more than one value."""
    return [axis for axis in cube.axes if axis.length > 1]


def place_of(cube: Cube, axis: Axis, value: Any, scale: Scale) -> float:
    """Return the coordinate of a value on an axis of a figure, by the scale of that axis."""
    if axis.is_text:
        return float(scale.names.index(str(value)))
    shown = cube.shown(axis.column)
    number = recorded_number(value)
    if scale.names:
        return float(scale.names.index(shown.text(number)))
    return float(shown.scaled(number))


# --- Maps over two choices ------------------------------------------------------------------------


def draw_tolerance(cube: Cube, record: AnswerRecord, chosen: ChoiceRecord) -> Page | None:
    """Draw the tolerance over the first two axes of more than one value.

    Cells without a window have a pale background for the reason.

    Args:
        cube: Choices of the answer.
        record: Record of the answer.
        chosen: The choice that the answer names first.

    Returns:
        The page; None if there are not two such axes.
    """
    axes = long_axes(cube)[:2]
    if len(axes) < 2:
        return None
    part = Slice.of(cube, axes, chosen)
    reasons = part.conflicts
    backgrounds = _backgrounds(reasons)
    key = [Patch(label=reason, linewidth=0.4, **style) for reason, style in backgrounds.items()]
    title = "by how much the pretension may be off"
    meaning = _MEANING.format(served_words(record))
    page, panel = _begin_map(cube, record, chosen, part, title, key, [meaning])
    x, y = part.scales
    for reason, style in backgrounds.items():
        cells = np.ma.masked_where(reasons != reason, np.zeros(part.low.shape))
        panel.pcolor(
            x.edges,
            y.edges,
            cells,
            cmap=ListedColormap([style["facecolor"]]),
            hatch=style["hatch"],
            edgecolor=style["edgecolor"],
            linewidth=0.0,
        )
    percent = np.ma.masked_invalid(100.0 * part.columns["tolerance"])
    if percent.count():
        most = max(float(percent.max()), 1e-9)
        texts = [
            _window_text(low, high, reading_unit(cube.document))
            for low, high in zip(part.low.ravel(), part.high.ravel(), strict=True)
        ]
        is_dark = percent.filled(0.0) > 0.55 * most
        _draw_cells(
            panel,
            part,
            percent,
            _BLUES,
            most,
            "tolerance of pretension (± %)",
            texts,
            is_dark,
            _starred(cube, part, chosen),
        )
    return page


def _backgrounds(reasons: ColumnArray) -> dict[str, dict[str, Any]]:
    """Select a colour and a hatch for each reason why choices have no window."""
    backgrounds: dict[str, dict[str, Any]] = {}
    last = len(_PALE) - 1
    for reason in dict.fromkeys(reasons.ravel().tolist()):
        if reason:
            place = min(len(backgrounds), last)
            style = {"facecolor": _PALE[place], "hatch": _HATCHES[place], "edgecolor": "#8a8a8a"}
            backgrounds[str(reason)] = style
    return backgrounds


def _window_text(low: float, high: float, unit: str) -> str:
    """Write a window; empty if there is none."""
    if np.isnan(high):
        return ""
    if np.isinf(high):
        return f"from {_short(low)} {unit}"
    return f"{_short(low)}–{_short(high)} {unit}"


def _short(value: float) -> str:
    """Write a number without decimals, or a small one to two digits."""
    return f"{value:.0f}" if abs(value) >= 10.0 or value == 0.0 else f"{value:.2g}"


def draw_served(cube: Cube, record: AnswerRecord, chosen: ChoiceRecord) -> Page | None:
    """Draw the largest share of the population that one pretension serves, over the same axes.

    Returns:
        The page; None if there are not two such axes, or if the answer is not for a population.
    """
    axes = long_axes(cube)[:2]
    if len(axes) < 2 or record["population"] is None:
        return None
    part = Slice.of(cube, axes, chosen)
    title = "the largest share that one pretension serves"
    page, panel = _begin_map(cube, record, chosen, part, title, [], [])
    percent = np.ma.masked_invalid(100.0 * part.columns["served"])
    filled = percent.filled(0.0)
    texts = [f"{share:.3g} %" for share in filled.ravel()]
    colours = SEQUENTIAL.reversed()
    label = "served by one pretension (%)"
    starred = _starred(cube, part, chosen)
    _draw_cells(panel, part, percent, colours, 100.0, label, texts, filled < 45.0, starred)
    return page


def _begin_map(
    cube: Cube,
    record: AnswerRecord,
    chosen: ChoiceRecord,
    part: Slice,
    title: str,
    key: list[Any],
    notes: list[str],
) -> tuple[Page, Axes]:
    """Begin the page of a map over two axes of choices, and mark the choice named first in it."""
    entries = list(key)
    if chosen["feasible"]:
        entries.append(star(label=choice_text(cube, chosen)))
    lines = list(notes)
    if part.title:
        lines.append(f"At {part.title}.")
    page = answer_page(cube, record, title, 95.0, entries, lines)
    panel = page.figure.subplots()
    x, y = part.scales
    x.apply(panel, "x", cells=True)
    y.apply(panel, "y", cells=True)
    panel.set(xlabel=x.label, ylabel=y.label)
    if chosen["feasible"]:
        x_axis, y_axis = part.axes
        across = place_of(cube, x_axis, value_of(chosen, x_axis.column), x)
        up = place_of(cube, y_axis, value_of(chosen, y_axis.column), y)
        size = _STAR
        starred = _starred(cube, part, chosen)
        if starred is not None and part.low.size <= _MOST_WRITTEN:
            row, _ = starred
            low, high = y.edges[row : row + 2]
            up = low + _STAR_PLACE * (high - low)  # above the value written in the cell
            size = min(_STAR, 0.5 * _row_height(y, row))
        style: dict[str, Any] = {"color": INK, "markersize": size, "markeredgecolor": "white"}
        panel.plot(across, up, marker="*", zorder=5, gid="best", **style)
    return page, panel


def _starred(cube: Cube, part: Slice, chosen: ChoiceRecord) -> tuple[int, int] | None:
    """Return row and column of the cell of the choice named first; None if it has no window."""
    if not chosen["feasible"]:
        return None
    places = []
    for axis, scale in zip(part.axes, part.scales, strict=True):
        place = place_of(cube, axis, value_of(chosen, axis.column), scale)
        places.append(int(np.searchsorted(scale.edges, place)) - 1)
    column, row = places
    return row, column


def _row_height(y: Scale, row: int) -> float:
    """Return about the height of a row of a map, pt."""
    share = (y.edges[row + 1] - y.edges[row]) / (y.edges[-1] - y.edges[0])
    return float(abs(share)) * _PANEL_HEIGHT


def _draw_cells(
    panel: Axes,
    part: Slice,
    values: Any,
    colours: Any,
    most: float,
    label: str,
    texts: Sequence[str],
    is_dark: Any,
    starred: tuple[int, int] | None,
) -> None:
    """Draw the cells of a map with their colour bar, and a text in each if there is room.

    Args:
        panel: The panel.
        part: The choices drawn.
        values: Values (y, x), masked where there is none.
        colours: Colour map.
        most: Value at the upper end of the colour bar.
        label: Label of the colour bar.
        texts: Text of each cell, row by row.
        is_dark: True for each cell (y, x) that is so dark that its text is white.
        starred: Row and column of the cell with the star, whose text is below it; None without one.
    """
    x, y = part.scales
    mesh = panel.pcolormesh(x.edges, y.edges, values, cmap=colours, vmin=0.0, vmax=most)
    bar = panel.figure.colorbar(mesh, ax=panel, aspect=28, pad=0.02)
    bar.set_label(label)
    bar.outline.set_linewidth(0.5)
    if values.size > _MOST_WRITTEN:
        return
    columns = values.shape[1]
    for row, column in np.argwhere(~np.ma.getmaskarray(values)):
        across = x.edges[column : column + 2].mean()
        low, high = y.edges[row : row + 2]
        place = _VALUE_PLACE if (row, column) == starred else 0.5
        up = low + place * (high - low)
        colour = "white" if is_dark[row, column] else INK
        text = texts[row * columns + column]
        panel.text(across, up, text, ha="center", va="center", size=6.0, color=colour)
