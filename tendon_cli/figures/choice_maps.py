"""Maps of an answer's choices over two of their axes.

One map shows how far the setting may be off, the other the share that one pretension serves.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

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
from tendon_cli.cube.labels import reading, reading_unit
from tendon_cli.figures.backend import Axes, Line2D, ListedColormap, Patch, mpl
from tendon_cli.figures.frame import Page, framed, source_of, turn_names
from tendon_cli.figures.layout import is_of_rows
from tendon_cli.figures.scales import Scale, axis_scale, off_default
from tendon_cli.figures.style import INK, MM, PAGE_WIDTH, text_width, wrapped
from tendon_cli.space.axis import Axis

_PALE = ("#f6d9c5", "#e9e2f3", "#dcebe4", "#f7ecc8", "#e5e5e5", "#dbe7f3")
"""Background of cells without a window, one for each reason; further reasons share the last."""
_HATCHES = ("", "....", "----", "\\\\\\\\", "xxxx", "++++")
_BLUES = ListedColormap(
    [mpl.colormaps["Blues"](place) for place in np.linspace(0.15, 0.95, 256)], name="tendon_window"
)
_STARS = (11.0, 8.0, 6.0)
"""Sizes of the star that marks a choice, pt. It is as large as the value beside it allows."""
_STAR_EDGE = 1.0
"""Width of the white edge of the star, pt."""
_VALUE_SIZE = 6.0
"""Size of the values written in cells, pt."""
_LINE_SPACING = 1.2
"""Height of a line of text, as a factor of its size."""
_PANEL_HEIGHT = 220.0
"""About the height of the panel of a map, pt."""
_PANEL_WIDTH = 350.0
"""About the width of the panel of a map, pt."""
_MOST_WRITTEN = 120
"""Largest number of cells of a map whose values are also written in them."""
_MEANING = (
    "Colour: half the window, as a length taken from both tendons: how far the setting may be off "
    "on either side of the middle; in brackets, its share of the pretension. Pale: no pretension "
    "works for {}, for the reason given."
)
_NO_END = "Windows without an upper end have the darkest colour."
_SETTABLE: dict[str, Any] = {"color": "#d55e00", "linewidth": 1.6}
"""Line around the choices that can be set well enough."""
_SLICE_COLUMNS = (
    "pretension_from",
    "pretension_to",
    "tolerance",
    "tolerance_length",
    "served",
    "from_by",
    "to_by",
    "advice",
)
"""Columns that a slice reads, as far as the answer has them."""
_MOST_FAULTS = 3
"""Most kinds of failed advice with a hatch of their own; further kinds share the last."""
_FAULT_HATCHES = ("////", "\\\\\\\\", "xxxx")


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
    bounds: say.LimitValues
    """Limits of the study by name, SI; None for one that differs between choices."""

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
        columns = cube.gather(rows, [name for name in _SLICE_COLUMNS if name in cube.columns])
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
    def length(self) -> ColumnArray:
        """Tolerance of each window, m; infinite where nothing bounds it, NaN without a window."""
        return np.where(np.isinf(self.high), np.inf, self.columns["tolerance_length"])

    @property
    def faults(self) -> ColumnArray:
        """Advice in words that a choice with a window fails; empty if it keeps all of it."""
        none = np.full(self.low.shape, "", dtype=object)
        failed = self.columns.get("advice", none)
        return np.where(self.low <= self.high, failed, none)

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
    width: float = PAGE_WIDTH,
    height: float | None = None,
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
        width: Width of the page, mm.
        height: Height of the page, mm; None for one that fits.
    """
    study_title = record["title"] or record["name"]
    lines = [*notes, *_bench_text(record)]
    # An answer chooses its pretensions, whichever the study has for its designs.
    told = [*(axis.column for axis in cube.axes), "pretension"]
    given = off_default(cube.study, told, {})
    if given:
        tables = [say.spaced(axis.key) for axis in cube.axes if is_of_rows(axis)]
        rest = "all else by default"
        if tables:
            word = "table" if len(tables) == 1 else "tables"
            rest = f"all else from the {word} {say.join_words(tables)}, or by default"
        lines.append(f"With {', '.join(given)}; {rest}.")
    return framed(
        f"{study_title}: {title}",
        panels,
        key,
        lines,
        study=source_of(record),
        subtitle=wrapped(subtitle, 90),
        width=width,
        height=height,
    )


def _bench_text(record: AnswerRecord) -> list[str]:
    """Return a sentence with the tensions to which the best choice is set, if they are known.

    It also says how far this setting may be off.
    """
    best = record["best"]
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
    meaning = ""
    pretension = best["pretension"]
    if pretension is not None and record["question"]["read"] == "pretension":
        meaning = f" (F₀ = {say.quantity('pretension', pretension, 4)})"
    lines = [f"The best is set to {joint}, {' and '.join(motor)} at the motor{meaning}."]
    setting = record["setting"]
    if setting is not None and setting["too_long"] is not None:
        longer = say.length_to_spare(setting["too_long"])
        shorter = "by any length"
        if setting["too_short"] is not None:
            shorter = f"by {say.length_to_spare(setting['too_short'])}"
        lines.append(f"Both tendons may be too long by {longer}, or too short {shorter}.")
    return lines


def star(**more: Any) -> Line2D:
    """Return the star that marks the choice named first, for the key."""
    return Line2D([], [], color=INK, marker="*", markersize=9, linestyle="", **more)


def set_text(cube: Cube, choice: ChoiceRecord) -> str:
    """Describe a choice by its values, and give its pretension or what is read instead."""
    if choice["pretension"] is None:
        return choice_text(cube, choice)
    value = f"{say.number(choice['pretension'])} {reading_unit(cube.document)}"
    words = reading(cube.document)
    if words == "pretension":
        return f"{choice_text(cube, choice)}: F₀ = {value}"
    return f"{choice_text(cube, choice)}: {value} of {words}"


def is_settable(record: AnswerRecord, length: ColumnArray, half: ColumnArray) -> ColumnArray:
    """Return True where a window is wide enough for the accuracy of setting.

    Args:
        record: Record of the answer.
        length: Tolerances as a length of both tendons, m; infinite without an upper end.
        half: Half the windows, N.
    """
    question = record["question"]
    accuracy = question["accuracy"]
    with np.errstate(invalid="ignore"):
        if accuracy["tension"] is not None:
            return np.asarray(half >= question["needed"] * accuracy["tension"])
        return np.asarray(length >= question["needed"] * (accuracy["length"] or 0.0))


def settable_label(record: AnswerRecord) -> str:
    """Say what it takes to be set well enough: "can be set well enough (± 6 mm)"."""
    return f"can be set well enough (± {say.tolerance_that_is_enough(record['question'])})"


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


def longest_tolerance(cube: Cube, chosen: ChoiceRecord) -> float:
    """Return the largest bounded tolerance of a map over the first two axes, m; 0 without one."""
    part = Slice.of(cube, long_axes(cube)[:2], chosen)
    bounded = (part.conflicts == "") & np.isfinite(part.length)
    return float(np.max(part.length[bounded], initial=0.0))


def draw_tolerance(
    cube: Cube, record: AnswerRecord, chosen: ChoiceRecord, longest: float | None = None
) -> Page | None:
    """Draw by how much the setting may be off, over the first two axes of more than one value.

    Cells without a window have a pale background for the reason.

    Args:
        cube: Choices of the answer.
        record: Record of the answer.
        chosen: The choice that the answer names first.
        longest: Tolerance at the end of the colour scale, m; None for the largest of the map.

    Returns:
        The page; None if there are not two such axes.
    """
    axes = long_axes(cube)[:2]
    if len(axes) < 2:
        return None
    part = Slice.of(cube, axes, chosen)
    reasons = part.conflicts
    backgrounds = _backgrounds(reasons)
    key: list[Any] = []
    for reason, style in backgrounds.items():
        key.append(Patch(label=reason, linewidth=0.4, **style))
    with np.errstate(invalid="ignore"):
        half = 0.5 * (part.high - part.low)
    settable = is_settable(record, part.length, half)
    if settable.any():
        key.append(Line2D([], [], label=f"inside the line: {settable_label(record)}", **_SETTABLE))
    faults = _fault_hatches(part.faults)
    for fault, hatch in faults.items():
        key.append(Patch(facecolor="none", edgecolor=INK, hatch=hatch, linewidth=0.4, label=fault))
    title = "how far the setting may be off"
    notes = [_MEANING.format(served_words(record))]
    if np.isinf(part.high).any():
        notes.append(_NO_END)
    page, panel, marked = _begin_map(cube, record, chosen, part, title, key, notes)
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
    has_window = reasons == ""
    if has_window.any():
        decided = record["decided"]
        if longest is None:
            longest = longest_tolerance(cube, chosen)
        if longest == 0.0 and decided is not None:
            longest = decided["needed"]
        most = 1e3 * longest or 1.0
        millimetres = np.minimum(1e3 * part.length, most)
        masked = np.ma.masked_where(~has_window, millimetres)
        texts = _tolerance_texts(part, reading_unit(cube.document))
        is_dark = masked.filled(0.0) > 0.55 * most
        _draw_cells(
            panel,
            part,
            masked,
            _BLUES,
            most,
            "how far the setting may be off (± mm)",
            texts,
            is_dark,
            marked,
        )
        for fault, hatch in faults.items():
            cells = np.ma.masked_where(part.faults != fault, np.zeros(part.low.shape))
            clear = ListedColormap([(0.0, 0.0, 0.0, 0.0)])
            hatched: dict[str, Any] = {"hatch": hatch, "edgecolor": INK, "linewidth": 0.0}
            panel.pcolor(x.edges, y.edges, cells, cmap=clear, **hatched)
        _draw_outline(panel, part, settable)
    return page


def _fault_hatches(faults: ColumnArray) -> dict[str, str]:
    """Select a hatch for each kind of advice that choices fail, in alphabetical order."""
    kinds = sorted({str(fault) for fault in faults.ravel() if fault})
    last = _MOST_FAULTS - 1
    return {kind: _FAULT_HATCHES[min(place, last)] for place, kind in enumerate(kinds)}


def _tolerance_texts(part: Slice, unit: str) -> list[str]:
    """Write each window with its tolerance in millimetres and percent, row by row.

    Narrow cells have a line for each, and the narrowest the millimetres alone.
    """
    if part.low.size > _MOST_WRITTEN:
        return [""] * part.low.size
    texts_of_form: list[list[str]] = [[], [], []]
    columns = (part.low, part.high, part.length, part.columns["tolerance"])
    for low, high, length, share in zip(*(values.ravel() for values in columns), strict=True):
        window = _window_text(low, high, unit)
        millimetres = f"{say.number(1e3 * length, 2)} mm"
        percent = f"{100.0 * share:.0f} %"
        two_lines = f"{window}\n{millimetres} ({percent})"
        three_lines = f"{window}\n{millimetres}\n{percent}"
        forms = [two_lines, three_lines, millimetres]
        if not low <= high:
            forms = ["", "", ""]
        elif np.isinf(high):
            forms = [f"{window}\nno upper end", window, window]
        for texts, text in zip(texts_of_form, forms, strict=True):
            texts.append(text)
    fitting = (texts for texts in texts_of_form if _have_room(part, texts))
    return next(fitting, texts_of_form[-1])


def _have_room(part: Slice, texts: Sequence[str]) -> bool:
    """Return True if the cells are few, and each has room for the longest of their texts."""
    if len(texts) > _MOST_WRITTEN:
        return False
    x, y = part.scales
    widths = np.abs(np.diff(x.edges))
    heights = np.abs(np.diff(y.edges))
    width = float(np.min(widths) / np.sum(widths)) * _PANEL_WIDTH
    height = float(np.min(heights) / np.sum(heights)) * _PANEL_HEIGHT
    sizes = [_text_size(text) for text in texts]
    return all(size[0] <= width and size[1] <= height for size in sizes)


def _draw_outline(panel: Axes, part: Slice, inside: ColumnArray) -> None:
    """Draw a line around some cells of a map; `inside` is True for these, (y, x)."""
    x, y = part.scales
    padded = np.pad(inside.astype(np.int8), 1)
    across: list[float] = []
    up: list[float] = []
    for row, column in np.argwhere(np.diff(padded, axis=1)[1:-1] != 0):
        across += [x.edges[column], x.edges[column], np.nan]
        up += [y.edges[row], y.edges[row + 1], np.nan]
    for row, column in np.argwhere(np.diff(padded, axis=0)[:, 1:-1] != 0):
        across += [x.edges[column], x.edges[column + 1], np.nan]
        up += [y.edges[row], y.edges[row], np.nan]
    panel.plot(across, up, gid="settable", zorder=4, clip_on=False, **_SETTABLE)


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
    page, panel, marked = _begin_map(cube, record, chosen, part, title, [], [])
    percent = np.ma.masked_invalid(100.0 * part.columns["served"])
    filled = percent.filled(0.0)
    texts = [f"{share:.3g} %" for share in filled.ravel()]
    label = "served by one pretension (%)"
    _draw_cells(panel, part, percent, _BLUES, 100.0, label, texts, filled > 55.0, marked)
    return page


@dataclass(frozen=True)
class _Marked:
    """The choice named first in a map: its cell, and the star at its values."""

    row: int
    column: int
    across: float
    """Coordinate of the star along x, that of its value."""
    up: float
    """Coordinate of the star along y."""
    star: Line2D


_Box: TypeAlias = tuple[float, float, float, float]
"""Left and right side, bottom and top of a box, pt."""


def _begin_map(
    cube: Cube,
    record: AnswerRecord,
    chosen: ChoiceRecord,
    part: Slice,
    title: str,
    key: list[Any],
    notes: list[str],
) -> tuple[Page, Axes, _Marked | None]:
    """Begin the page of a map over two axes of choices, and mark the choice named first in it.

    Returns:
        The page, its panel, and the mark; None if that choice has no window.
    """
    entries = list(key)
    if chosen["feasible"]:
        entries.append(star(label=set_text(cube, chosen)))
    lines = list(notes)
    if part.title:
        lines.append(f"At {part.title}.")
    page = answer_page(cube, record, title, 95.0, entries, lines)
    panel = page.figure.subplots()
    x, y = part.scales
    x.apply(panel, "x", cells=True)
    y.apply(panel, "y", cells=True)
    turn_names(panel.xaxis, _PANEL_WIDTH / 72.0 / MM)
    panel.set(xlabel=x.label, ylabel=y.label)
    if not chosen["feasible"]:
        return page, panel, None
    x_axis, y_axis = part.axes
    across = place_of(cube, x_axis, value_of(chosen, x_axis.column), x)
    up = place_of(cube, y_axis, value_of(chosen, y_axis.column), y)
    style: dict[str, Any] = {
        "color": INK,
        "markersize": _STARS[0],
        "markeredgecolor": "white",
        "markeredgewidth": _STAR_EDGE,
    }
    (mark,) = panel.plot(across, up, marker="*", zorder=5, gid="best", **style)
    return page, panel, _Marked(_cell_of(y, up), _cell_of(x, across), across, up, mark)


def _cell_of(scale: Scale, place: float) -> int:
    """Return the index of the cell that holds a place on an axis."""
    return int(np.searchsorted(scale.edges, place)) - 1


def _draw_cells(
    panel: Axes,
    part: Slice,
    values: Any,
    colours: Any,
    most: float,
    label: str,
    texts: Sequence[str],
    is_dark: Any,
    marked: _Marked | None,
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
        marked: The choice named first, whose text is beside its star; None without one.
    """
    x, y = part.scales
    mesh = panel.pcolormesh(x.edges, y.edges, values, cmap=colours, vmin=0.0, vmax=most)
    bar = panel.figure.colorbar(mesh, ax=panel, aspect=28, pad=0.02)
    bar.set_label(label)
    bar.outline.set_linewidth(0.5)
    if not _have_room(part, texts):
        return
    columns = values.shape[1]
    style: dict[str, Any] = {"ha": "center", "va": "center", "size": _VALUE_SIZE, "gid": "value"}
    for row, column in np.argwhere(~np.ma.getmaskarray(values)):
        colour = "white" if is_dark[row, column] else INK
        text = texts[row * columns + column]
        across = x.edges[column : column + 2].mean()
        up = y.edges[row : row + 2].mean()
        if marked is not None and (row, column) == (marked.row, marked.column):
            text, across, up = _beside_star(part, marked, text)
        panel.text(across, up, text, color=colour, **style)


def _beside_star(part: Slice, marked: _Marked, text: str) -> tuple[str, float, float]:
    """Make room beside the star for the text of its cell.

    The star gets smaller, and then the text shorter, until there is room; at last nothing is
    written.

    Returns:
        The text, and the coordinates of its middle.
    """
    x, y = part.scales
    x_points = _PANEL_WIDTH / (x.edges[-1] - x.edges[0])
    y_points = _PANEL_HEIGHT / (y.edges[-1] - y.edges[0])
    left, right = (x_points * x.edges[marked.column : marked.column + 2]).tolist()
    bottom, top = (y_points * y.edges[marked.row : marked.row + 2]).tolist()
    cell = (left, right, bottom, top)
    middle = (x_points * marked.across, y_points * marked.up)
    for words, size in itertools.product(_ever_shorter(text), _STARS):
        marked.star.set_markersize(size)
        width, height = _text_size(words)
        half = size / 2.0 + _STAR_EDGE
        for room in _rooms_beside(cell, middle, half):
            left, right, bottom, top = room
            if width <= right - left and height <= top - bottom:
                across = (left + right) / 2.0 / x_points
                up = (bottom + top) / 2.0 / y_points
                return words, across, up
    return "", marked.across, marked.up


def _text_size(text: str) -> tuple[float, float]:
    """Return width and height of a text that is written in a cell, pt."""
    width = text_width(text, _VALUE_SIZE) * MM * 72.0
    height = _LINE_SPACING * _VALUE_SIZE * (text.count("\n") + 1)
    return width, height


def _ever_shorter(text: str) -> Iterator[str]:
    """Yield the text of a cell: whole, then without its first line, then without its share."""
    yield text
    _, _, rest = text.partition("\n")
    if rest:
        yield rest
        yield rest.partition("\n")[0].partition(" (")[0]


def _rooms_beside(cell: _Box, middle: tuple[float, float], half: float) -> Iterator[_Box]:
    """Yield the rooms of a cell below, above, to the right and to the left of a star in it.

    Args:
        cell: The cell.
        middle: Middle of the star, pt.
        half: Half its size, pt.
    """
    left, right, bottom, top = cell
    across, up = middle
    yield left, right, bottom, up - half
    yield left, right, up + half, top
    yield across + half, right, bottom, top
    yield left, across - half, bottom, top
