"""A page with a figure: a title above the panels, the key and a few sentences below, and its file.

Every figure begins here, in `house_style()`: `framed` gives a page to draw on, `Page.save` writes
it with its caption and its study in the file's metadata.
"""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.cube.labels import plain, with_symbols, without_formulas
from tendon_cli.errors import UsageError
from tendon_cli.figure_marks import is_figure
from tendon_cli.figures.backend import (
    Axes,
    ConstrainedLayoutEngine,
    Figure,
    FigureCanvasAgg,
    Text,
    ticker,
)
from tendon_cli.figures.style import MM, PAGE_WIDTH, format_of, named, preview, render, text_width
from tendon_cli.files import check_output, result_path, write_output
from tendon_cli.studies.study import Study
from tendon_cli.typed_record import Record

_TITLE: dict[str, Any] = {"size": 9.0, "weight": "bold"}
_NOTE_SIZE = 6.5
"""Size of the notes, pt."""
_FEWEST_CHARACTERS = 8
"""Fewest characters of a line."""
_TITLE_LINE = 4.0
"""Height of a line of the title, mm."""
_NOTE_LINE = 3.3
"""Height of a line of a note, mm."""
_KEY_LINE = 4.4
"""Height of a line of the key, mm."""
_PAD = 1.5
"""Space around title and notes, mm."""
_TITLE_CHARACTER = 1.75
"""Mean width of a character of the title, mm."""
_NOTE_CHARACTER = 1.25
"""Mean width of a character of a note, mm."""
_KEY_CHARACTER = 1.42
"""Mean width of a character of the key, mm."""
_KEY_HANDLE = 11.0
"""Width of the sample in the key, with the space around it, mm."""
_LOWEST_PANELS = 30.0
"""Least height of all panels if the page has a given height, mm."""
_FEWEST_DECADES = 3
"""Fewest powers of ten that are enough as the only ticks of a logarithmic axis."""
_NO_BREAK = "\u00a0"
_IN_EQUATION = re.compile(r" (?=[=±≤≥])|(?<=[=±≤≥]) |(?<=\d) (?=[A-Za-z%°])|(?<=\d N) (?=m\b)")
"""Spaces in an equation and before a unit, at which no line is broken."""


@dataclass(frozen=True)
class Page:
    """A figure, and the text about it that its file holds; lengths in mm."""

    figure: Figure
    title: str
    says: str
    """Caption, without formulas, for the file's metadata."""
    study: str
    """Name and hash of the study shown."""
    width: float
    height: float
    head: float
    """Height of the title with the space around it."""
    foot: float
    """Height of the key and the notes."""

    @property
    def inner(self) -> float:
        """Height of all panels, mm."""
        return self.height - self.head - self.foot

    def of_joint(self, study: Any) -> Page:
        """Return this page with the word for the study's joint instead of "elbow".

        The title stays as it is, because it is the user's.
        """
        word = say.joint_name(study)
        if word != "elbow":
            for text in self.figure.findobj(Text):
                if text.get_gid() != "title":
                    text.set_text(named(text.get_text(), word))
        return replace(self, says=named(self.says, word))

    def save(self, path: Path, *, overwrite: bool = False) -> Path:
        """Write the file whole or not at all, in the format of its ending.

        Args:
            path: The file.
            overwrite: True to replace a file that tendon did not write.

        Raises:
            OutputError: The file cannot be written.
            UsageError: The ending is not that of a figure, or tendon did not write the file.
        """
        kind = format_of(path, "--out")
        check_output(path, is_figure, overwrite=overwrite)
        about = {"title": self.title, "says": self.says, "study": self.study}
        content = render(self.figure, kind, about)
        write_output(path, content, is_figure, overwrite=overwrite)
        return path

    def png(self) -> bytes:
        """Return the page as a small PNG, for a notebook."""
        return preview(self.figure)

    def shown(self, out: str | PathLike[str] | None = None, *, overwrite: bool = False) -> Figure:
        """Return the figure, which a notebook shows as a PNG; write it to a file as well.

        Args:
            out: The file; None for none.
            overwrite: True to replace a file that tendon did not write.

        Raises the errors of `save`.
        """
        if out is not None:
            self.save(result_path(out), overwrite=overwrite)
        self.figure._repr_png_ = self.png  # type: ignore[attr-defined]
        return self.figure


def save_pages(pages: Sequence[tuple[Page, Path]], *, overwrite: bool = False) -> list[Path]:
    """Write pages to their files, or none of them if a file is not tendon's.

    Raises the errors of `Page.save`.
    """
    for _, path in pages:
        check_output(path, is_figure, overwrite=overwrite)
    return [page.save(path, overwrite=overwrite) for page, path in pages]


def source_of(record: Mapping[str, Any] | Record) -> str:
    """Return name and hash of the study of a record, by which `is_figure` knows a figure."""
    return f"tendon study {record['name']} {record['study_hash']}"


def source_of_study(study: Study) -> str:
    """Return name and hash of a study, for a figure's file."""
    return f"tendon study {study.name} {study.hash}"


def framed(
    title: str,
    panels: float,
    key: Sequence[Any] = (),
    notes: Sequence[str] = (),
    *,
    width: float = PAGE_WIDTH,
    height: float | None = None,
    subtitle: str = "",
    study: str = "",
    is_of_answer: bool = False,
) -> Page:
    """Begin a page with its title, key and notes, and with room for its panels.

    Args:
        title: The title as the user wrote it, or a sentence of an answer.
        panels: Height of all panels, mm.
        key: Artists with a label.
        notes: Sentences below the panels; they may hold formulas.
        width: Width of the page, mm.
        height: Height of the page, mm. If it is given, the panels have what it leaves for them.
        subtitle: Second title, which may hold formulas and line breaks.
        study: Name and hash of the study for the file's metadata.
        is_of_answer: True if the title is a sentence of an answer, whose symbols are to be set as
            formulas.
    """
    drawn = with_symbols if is_of_answer else plain
    subtitle = named(subtitle)
    notes = [named(note) for note in notes]
    labels = [named(str(entry.get_label())) for entry in key]
    room = width - 2.0 * _PAD
    characters = int(width / _TITLE_CHARACTER)
    heads = _fit_lines(lambda count: drawn(title, width=count).splitlines(), characters, room)
    for line in subtitle.splitlines():
        heads += _fit_lines(partial(_wrap, line), max(characters, len(line)), room)
    lines: list[str] = []
    for note in notes:
        characters = int(width / _NOTE_CHARACTER)
        lines += _fit_lines(partial(_wrap_note, note), characters, room, size=_NOTE_SIZE)
    texts, columns, key_height = _key_shape(labels, width)
    head = len(heads) * _TITLE_LINE + _PAD if heads else 0.0
    notes_height = len(lines) * _NOTE_LINE + _PAD
    foot = key_height + notes_height
    if height is not None:
        panels = max(_LOWEST_PANELS, height - head - foot)
    height = head + panels + foot
    layout = ConstrainedLayoutEngine(rect=(0.0, foot / height, 1.0, panels / height))
    figure = Figure(figsize=(width * MM, height * MM), layout=layout)
    left = _PAD / width
    top = 1.0 - 0.8 * _PAD / height
    title_style: dict[str, Any] = {**_TITLE, "va": "top", "gid": "title"}
    figure.text(left, top, "\n".join(heads), **title_style)
    bottom = 0.7 * _PAD / height
    note_style: dict[str, Any] = {"color": "#4d4d4d", "va": "bottom", "gid": "notes"}
    figure.text(left, bottom, "\n".join(lines), size=_NOTE_SIZE, **note_style)
    if key:
        anchor = (0.0, notes_height / height, 1.0, key_height / height)
        figure.legend(
            handles=list(key),
            labels=texts,
            loc="center",
            bbox_to_anchor=anchor,
            ncols=columns,
            borderaxespad=0.0,
            columnspacing=1.6,
            handletextpad=0.6,
        )
    says = without_formulas(" ".join(text for text in (subtitle, *notes) if text))
    return Page(figure, title, says, study, width, height, head, foot)


def _fit_lines(
    wrap: Callable[[int], list[str]], characters: int, room: float, **style: Any
) -> list[str]:
    """Break a text into lines, each with fewer characters until the widest line fits.

    Args:
        wrap: Function that breaks the text into lines of at most so many characters.
        characters: Characters of a line to begin with.
        room: Width that a line may have, mm.
        **style: Size and weight of the text, by default those of the title.
    """
    lines = wrap(characters)
    while characters > _FEWEST_CHARACTERS:
        widest = max((text_width(line, **(style or _TITLE)) for line in lines), default=0.0)
        if widest <= room:
            break
        characters = max(_FEWEST_CHARACTERS, min(characters - 1, int(characters * room / widest)))
        lines = wrap(characters)
    return lines


def _wrap(text: str, width: int) -> list[str]:
    """Break a text that may hold formulas into lines of so many characters."""
    return textwrap.wrap(text, width, break_long_words=False) or [""]


def _wrap_note(note: str, width: int) -> list[str]:
    """Break a sentence into lines of so many characters, none of them within "b₁ = 110 mm"."""
    joined = _IN_EQUATION.sub(_NO_BREAK, note)
    lines = textwrap.wrap(joined, width, break_long_words=False)
    return [line.replace(_NO_BREAK, " ") for line in lines]


def _key_shape(texts: Sequence[str], width: float) -> tuple[list[str], int, float]:
    """Lay out the key on a page of a width in mm.

    Returns:
        The texts, broken to the width; the number of entries side by side; and the height, mm.
    """
    room = max(8, int((width - _KEY_HANDLE) / _KEY_CHARACTER))
    broken = []
    for text in texts:
        if len(text) > room:
            broken.append("\n".join(textwrap.wrap(text, room, break_long_words=False)))
        else:
            broken.append(text)
    longest = max((_KEY_HANDLE + len(text) * _KEY_CHARACTER for text in broken), default=1.0)
    columns = max(1, min(len(texts), int((width + 4.0) / longest)))
    lines = math.ceil(len(texts) / columns) + sum(text.count("\n") for text in broken)
    return broken, columns, lines * _KEY_LINE


def grid_shape(panels: int, in_row: int = 1, *, most: int = 4) -> tuple[int, int]:
    """Return the rows and columns for panels on a page.

    Args:
        panels: Number of panels.
        in_row: Number of panels that belong side by side. It counts if they fill several rows.
        most: Largest number of columns.
    """
    fits = 2 <= in_row <= most and panels % in_row == 0 and panels > in_row
    usual = {1: 1, 2: 2, 3: 3, 4: 2}.get(panels, 3)
    columns = min(most, in_row if fits else usual)
    return math.ceil(panels / columns), columns


_EDGE = 1.2
"""Space around the panels, mm."""
_GAP = 4.5
"""Space between panels, mm."""
_PANEL_LINE = 3.6
"""Height of a line of a panel's title, mm."""
_PANEL_PAD = 2.0
"""Space around a panel's title, mm."""
_BAR = 4.0
"""Width of a colour bar, mm."""
_BAR_GAP = 4.0
"""Space between the panels and a colour bar, mm."""
_SMALLEST = 4.0
"""Least width and height of a panel, mm."""
_DIGIT = 1.57
"""Width of a digit in the label of a tick, mm."""
_NARROW = 0.8
"""Width of a point or comma there, mm."""
_TICK_GAP = 0.7
"""Least space between the labels of neighbouring ticks, mm."""
_TICK_LINE = 2.5
"""Height of a line of the label of a tick, mm."""
_TURNED_SIZE = 6.5
"""Size of names that stand upright, pt."""
_ROUNDS = 2
"""Largest number of times that panels are placed; a second time if their ticks then need more
room."""


def empty_panels(page: Page, rows: int, columns: int, count: int, **shared: Any) -> Any:
    """Add a grid of panels to a page.

    Args:
        page: The page.
        rows: Number of rows.
        columns: Number of columns.
        count: Number of panels that are shown; the last ones are hidden.
        **shared: `sharex` and `sharey` of `Figure.subplots`.

    Returns:
        The axes (rows, columns).
    """
    page.figure.set_layout_engine("none")
    sides = {
        "left": 14.0 / page.width,
        "right": 1.0 - 3.0 / page.width,
        "bottom": (page.foot + 8.0) / page.height,
        "top": 1.0 - (page.head + 5.0) / page.height,
    }
    grid = page.figure.subplots(rows, columns, squeeze=False, gridspec_kw=sides, **shared)
    for axes in grid.flat[count:]:
        axes.set_visible(False)
    for axes in lowest(grid, count):
        axes.tick_params(labelbottom=True)
    return grid


def lowest(grid: Any, count: int) -> list[Axes]:
    """Return the lowest panel of each column, if the first `count` panels of a grid are shown."""
    return list(grid.flat[max(0, count - grid.shape[1]) : count])


def settle(page: Page, grid: Any, bar: Axes | None = None, *, must_fit: bool = True) -> None:
    """Place panels, and a colour bar to their right, so that there is room for all labels.

    All labels must be written before. Constrained layout would do the same, but would draw
    everything twice.

    Args:
        page: The page.
        grid: Axes (rows, columns).
        bar: Axes of the colour bar.
        must_fit: True to raise an error if there is no room; otherwise panels get tiny.

    Raises:
        UsageError: There is no room for the panels.
    """
    FigureCanvasAgg(page.figure)
    for _ in range(_ROUNDS):
        before = _longest_ticks(grid)
        width, height = _place(page, grid, bar, must_fit=must_fit)
        shown = [axes for axes in grid.flat if axes.get_visible()]
        turned = [turn_names(axes.xaxis, width) for axes in shown]
        if any(turned):
            width, height = _place(page, grid, bar, must_fit=must_fit)
        for axes in shown:
            separate_ticks(axes.xaxis, width)
            separate_ticks(axes.yaxis, height)
        if not (_longest_ticks(grid) > before).any():
            break


def _longest_ticks(grid: Any) -> Any:
    """Return the length of the longest label of a tick on y in each panel, in characters."""
    return np.array([max(map(len, _tick_texts(axes.yaxis)), default=0) for axes in grid.flat])


def _tick_texts(axis: Any) -> list[str]:
    """Return the labels of the ticks of an axis that are in view."""
    texts: list[str] = axis.get_major_formatter().format_ticks(_ticks_in_view(axis))
    return texts


def _place(page: Page, grid: Any, bar: Axes | None, *, must_fit: bool) -> tuple[float, float]:
    """Place panels and a colour bar by the reach of their labels as they are.

    Returns:
        Width and height of each panel, mm.
    """
    # Reach of the labels to the left, below, to the right and above, and of those of x alone to
    # the left, (rows, columns, 5), mm.
    reach = np.array([[_reach(page, axes) for axes in row] for row in grid])
    left = reach[..., 0].max(axis=0)
    below = reach[..., 1].max(axis=1)
    above = reach[..., 3].max(axis=1)
    right = max(_EDGE, reach[:, -1, 2].max() + 0.3)
    # The labels of the ticks on x reach beyond both ends of a panel, towards its neighbours.
    between = reach[:, :-1, 2].max(axis=0) + reach[:, 1:, 4].max(axis=0) + _TICK_GAP
    gaps = np.maximum(_GAP, between - left[1:])
    at_bar = 0.0 if bar is None else _BAR_GAP + _BAR + _reach(page, bar)[2]
    rows, columns = grid.shape
    width = (page.width - _EDGE - left.sum() - gaps.sum() - right - at_bar) / columns
    height = (page.inner - below.sum() - above.sum() - _GAP * (rows - 1)) / rows
    if must_fit and min(width, height) < _SMALLEST:
        hint = "choose a larger size, or fewer panels and quantities"
        raise UsageError("the panels do not fit into this size", where="--size", hint=hint)
    width = max(width, 1.0)
    height = max(height, 1.0)
    top = page.height - page.head
    scale = np.array([page.width, page.height, page.width, page.height])
    for row, column in np.ndindex(rows, columns):
        x = _EDGE + left[: column + 1].sum() + column * width + gaps[:column].sum()
        y = top - above[: row + 1].sum() - below[:row].sum() - row * _GAP - (row + 1) * height
        grid[row, column].set_position(np.array([x, y, width, height]) / scale)
    if bar is not None:
        x = page.width - at_bar - _EDGE + _BAR_GAP
        y = page.foot + below[-1]
        bar.set_position(np.array([x, y, _BAR, top - above[0] - y]) / scale)
    return width, height


def turn_names(axis: Any, length: float) -> bool:
    """Turn the names along an x axis upright if they have no room side by side.

    Args:
        axis: The x axis of a panel.
        length: Its length, mm.

    Returns:
        True if they were turned.
    """
    if not isinstance(axis.get_major_formatter(), ticker.FixedFormatter):
        return False
    if not _labels_touch(axis, _ticks_in_view(axis), _tick_texts(axis), length):
        return False
    was_turned = _is_turned(axis)
    axis.set_tick_params(labelsize=_TURNED_SIZE, labelrotation=90)
    return not was_turned


def _is_turned(axis: Any) -> bool:
    """Return True if the labels of the ticks of an axis stand upright."""
    return bool(axis.get_tick_params(which="major").get("rotation", 0.0) == 90.0)


def separate_ticks(axis: Any, length: float) -> None:
    """Take ticks of an axis away until no label touches the next.

    Ticks at round numbers get fewer, on a logarithmic axis those at powers of ten remain if there
    are some. Of those at given values only the ones that touch a neighbour go; both ends stay if
    they have room.

    Args:
        axis: Axis of a panel.
        length: Its length, mm.
    """
    locator = axis.get_major_locator()
    places = _ticks_in_view(axis)
    texts = _tick_texts(axis)
    if not _labels_touch(axis, places, texts, length):
        return
    if isinstance(locator, ticker.MaxNLocator):
        for bins in range(len(places) - 1, 0, -1):
            locator.set_params(nbins=bins)
            if not _labels_touch(axis, _ticks_in_view(axis), _tick_texts(axis), length):
                return
    if isinstance(locator, ticker.LogLocator):
        powers = np.log10(places)
        decades = np.flatnonzero(np.isclose(powers, np.round(powers)))
        of_decades = [texts[place] for place in decades]
        are_some = len(decades) >= _FEWEST_DECADES
        if are_some and not _labels_touch(axis, places[decades], of_decades, length):
            axis.set_major_locator(ticker.FixedLocator(places[decades]))
            return
    if isinstance(locator, ticker.FixedLocator | ticker.LogLocator):
        kept = _labels_apart(*_label_extents(axis, places, texts, length))
        axis.set_major_locator(ticker.FixedLocator(places[kept]))
        if isinstance(axis.get_major_formatter(), ticker.FixedFormatter):
            axis.set_major_formatter(ticker.FixedFormatter([texts[place] for place in kept]))


def _labels_apart(at: Any, sizes: Any) -> list[int]:
    """Select labels that do not touch each other: first both ends, then in order what has room.

    Args:
        at: Places of the labels along the axis, mm.
        sizes: Their extents along it, mm.

    Returns:
        Indices of the labels.
    """
    order = [int(place) for place in np.argsort(at, kind="stable")]
    last = order[-1]
    kept = [order[0]]
    for place in order[1:-1]:
        is_free = [
            abs(at[place] - at[other]) >= (sizes[place] + sizes[other]) / 2.0
            for other in (kept[-1], last)
        ]
        if all(is_free):
            kept.append(place)
    if at[last] - at[kept[-1]] >= (sizes[last] + sizes[kept[-1]]) / 2.0:
        kept.append(last)
    return sorted(kept)


def _ticks_in_view(axis: Any) -> Any:
    """Return the places of the labelled ticks that are in view."""
    places = np.asarray(axis.get_majorticklocs(), dtype=np.float64)
    low, high = sorted(axis.get_view_interval())
    return places[(places >= low) & (places <= high)]


def _labels_touch(axis: Any, places: Any, texts: Sequence[str], length: float) -> bool:
    """Return True if neighbouring labels of an axis of a length (mm) touch each other."""
    if len(places) < 2:
        return False
    at, sizes = _label_extents(axis, places, texts, length)
    needed = (sizes[:-1] + sizes[1:]) / 2.0
    return bool((np.abs(np.diff(at)) < needed).any())


def _label_extents(axis: Any, places: Any, texts: Sequence[str], length: float) -> tuple[Any, Any]:
    """Return places and extents of labels along an axis of a length (mm), mm."""
    transform = axis.get_transform()
    low, high = transform.transform(np.asarray(axis.get_view_interval(), dtype=np.float64))
    at = (transform.transform(places) - low) / (high - low) * length
    is_across = axis.axis_name == "x" and not _is_turned(axis)
    extent = _tick_width if is_across else _tick_height
    return at, np.array([extent(text) for text in texts])


def _tick_width(text: str) -> float:
    """Return about the width of the label of a tick with the space beside it, mm."""
    widths = [
        sum(_NARROW if sign in ".,:" else _DIGIT for sign in line) for line in text.split("\n")
    ]
    return max(widths) + _TICK_GAP


def _tick_height(text: str) -> float:
    """Return about the height of the label of a tick, mm."""
    return _TICK_LINE * (text.count("\n") + 1)


def _labels_box(axis: Any, side: str) -> Any:
    """Return the box of the labels of an axis, pixels; None without any.

    Matplotlib would lay out all ticks to find that none has a label.
    """
    is_bar = axis.axes.get_label() == "<colorbar>"
    has_labels = is_bar or axis.get_tick_params(which="major").get(side, True)
    return axis.get_tightbbox() if has_labels or axis.get_label_text() else None


def _reach(page: Page, axes: Axes) -> tuple[float, float, float, float, float]:
    """Return the reach of a panel's labels beyond it to the left, below, right and above, mm.

    The title is above the panel. To its right reach the labels of the x axis, or for a colour bar
    those of the y axis. The last number is the reach of the labels of the x axis to the left.
    """
    if not axes.get_visible():
        return 0.0, 0.0, 0.0, _EDGE, 0.0
    panel = axes.bbox
    x_labels = _labels_box(axes.xaxis, "labelbottom")
    y_labels = _labels_box(axes.yaxis, "labelleft")
    left = panel.x0 - y_labels.x0 if y_labels else 0.0
    below = panel.y0 - x_labels.y0 if x_labels else 0.0
    right = 0.0
    if axes.get_label() == "<colorbar>":
        if y_labels:
            right = y_labels.x1 - panel.x1
    elif x_labels:
        right = x_labels.x1 - panel.x1
    title = axes.get_title()
    above = _PANEL_PAD + _PANEL_LINE * (title.count("\n") + 1) if title else _EDGE
    to_mm = 1.0 / page.figure.dpi / MM
    of_x = panel.x0 - x_labels.x0 if x_labels else 0.0
    left, below, right, of_x = (max(0.0, pixels * to_mm) for pixels in (left, below, right, of_x))
    return left, below, right, above, of_x
