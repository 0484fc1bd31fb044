"""A page with a figure: a title above the panels, the key to the signs and a few honest lines below, and its file.

Whoever draws begins here, in `house_style()`: `framed` gives a page to draw on, `Page.save` writes it with its caption
and its study in the file's metadata.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.cube.labels import plain, without_formulas
from tendon_cli.errors import UsageError
from tendon_cli.figures.backend import Axes, ConstrainedLayoutEngine, Figure, FigureCanvasAgg, Text
from tendon_cli.figures.style import MM, PAGE_WIDTH, format_of, render
from tendon_cli.files import write_whole

_TITLE_LINE, _NOTE_LINE, _KEY_LINE, _PAD = 4.0, 3.3, 4.4, 1.5
_TITLE_SIGN, _NOTE_SIGN = 1.75, 1.25
"""Mean width of a sign of the title and of a note, mm."""
_KEY_SIGN, _KEY_HANDLE = 1.42, 11.0


@dataclass(frozen=True)
class Page:
    """A figure, and what it says of itself in its file."""

    figure: Figure
    title: str
    says: str
    study: str
    """Name and hash of the study shown."""
    width: float
    height: float
    head: float
    """Above the panels; all in mm."""
    foot: float

    @property
    def inner(self) -> float:
        """Height of all panels, mm."""
        return self.height - self.head - self.foot

    def of_joint(self, study: Any) -> Page:
        """With the word for the study's joint in what we say, which is of the elbow; the title is the user's."""
        word = say.joint_word(study)
        for text in self.figure.findobj(Text) if word != "elbow" else ():
            if text.get_gid() != "title":
                text.set_text(say.of_joint(text.get_text(), word))
        return replace(self, says=say.of_joint(self.says, word))

    def save(self, path: Path) -> Path:
        """Write it whole or not at all, in the format of the path's ending; raises OutputError, UsageError."""
        about = {"title": self.title, "says": self.says, "study": self.study}
        write_whole(path, render(self.figure, format_of(path, "--out"), about))
        return path


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
) -> Page:
    """A page to draw on, in mm: its panels are `panels` high in all, or what a `height` of the page leaves for them.

    `title` is as the user wrote it, `key` are artists with a label, `notes` and `subtitle` may hold formulas, `study`
    is its name and hash for the file's metadata.
    """
    heads = [
        *plain(title, width=int(width / _TITLE_SIGN)).splitlines(),
        *([subtitle] if subtitle else []),
    ]
    lines = [
        line
        for note in notes
        for line in textwrap.wrap(note, int(width / _NOTE_SIGN), break_long_words=False)
    ]
    texts, columns, key_height = _key_shape([str(entry.get_label()) for entry in key], width)
    head, notes_height = (
        len(heads) * _TITLE_LINE + _PAD if heads else 0.0,
        len(lines) * _NOTE_LINE + _PAD,
    )
    foot = key_height + notes_height
    panels = panels if height is None else max(30.0, height - head - foot)
    height = head + panels + foot
    layout = ConstrainedLayoutEngine(rect=(0.0, foot / height, 1.0, panels / height))
    figure = Figure(figsize=(width * MM, height * MM), layout=layout)
    text_of: dict[str, Any] = {"color": "#4d4d4d", "size": 6.5, "va": "bottom", "gid": "notes"}
    figure.text(
        _PAD / width,
        1.0 - 0.8 * _PAD / height,
        "\n".join(heads),
        va="top",
        size=9.0,
        weight="bold",
        gid="title",
    )
    figure.text(_PAD / width, 0.7 * _PAD / height, "\n".join(lines), **text_of)
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
    says = without_formulas(" ".join(filter(None, (subtitle, *notes))))
    return Page(figure, title, says, study, width, height, head, foot)


def _key_shape(texts: Sequence[str], width: float) -> tuple[list[str], int, float]:
    """What a key says, broken to a width; how many entries stand side by side; and how high it is, mm."""
    room = max(8, int((width - _KEY_HANDLE) / _KEY_SIGN))
    broken = [
        "\n".join(textwrap.wrap(text, room, break_long_words=False)) if len(text) > room else text
        for text in texts
    ]
    longest = max((_KEY_HANDLE + len(text) * _KEY_SIGN for text in broken), default=1.0)
    columns = max(1, min(len(texts), int((width + 4.0) / longest)))
    return (
        broken,
        columns,
        (math.ceil(len(texts) / columns) + sum(text.count("\n") for text in broken)) * _KEY_LINE,
    )


def grid_shape(panels: int, in_row: int = 1, *, most: int = 4) -> tuple[int, int]:
    """Rows and columns for a number of panels on a page; `in_row` panels belong side by side, where there are more."""
    fits = 2 <= in_row <= most and panels % in_row == 0 and panels > in_row
    columns = min(most, in_row if fits else {1: 1, 2: 2, 3: 3, 4: 2}.get(panels, 3))
    return math.ceil(panels / columns), columns


_EDGE, _GAP, _PANEL_LINE, _PANEL_PAD = 1.2, 4.5, 3.6, 2.0
"""Around the panels, between them, and for each line of a title, mm."""
_BAR, _BAR_GAP = 4.0, 4.0
_SMALLEST = 4.0
"""Side of a panel, mm."""


def empty_panels(page: Page, rows: int, columns: int, count: int, **shared: Any) -> Any:
    """Axes in an array of shape (rows, columns), `count` of them seen; `shared` are `sharex` and `sharey`."""
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
    """Those of the first `count` panels that have none below them."""
    return list(grid.flat[max(0, count - grid.shape[1]) : count])


def settle(page: Page, grid: Any, bar: Axes | None = None, *, must_fit: bool = True) -> None:
    """Put panels, and perhaps a colour bar at their right, in their places once all labels are written.

    Constrained layout does the same by drawing everything twice. Raises UsageError where there is no room.
    """
    FigureCanvasAgg(page.figure)
    reach = np.array(
        [[_reach(page, axes) for axes in row] for row in grid]
    )  # left, below, right, above
    left, over = reach[..., 0].max(axis=0), max(_EDGE, reach[:, -1, 2].max() + 0.3)
    below, above = reach[..., 1].max(axis=1), reach[..., 3].max(axis=1)
    at_bar = 0.0 if bar is None else _BAR_GAP + _BAR + _reach(page, bar)[2]
    rows, columns = grid.shape
    width = (page.width - _EDGE - left.sum() - _GAP * (columns - 1) - over - at_bar) / columns
    height = (page.inner - below.sum() - above.sum() - _GAP * (rows - 1)) / rows
    if must_fit and min(width, height) < _SMALLEST:
        hint = "a larger one, or fewer panels and quantities"
        raise UsageError("the panels do not fit into this size", where="--size", hint=hint)
    width, height, top = max(width, 1.0), max(height, 1.0), page.height - page.head
    scale = np.array([page.width, page.height, page.width, page.height])
    for row, column in np.ndindex(rows, columns):
        x = _EDGE + left[: column + 1].sum() + column * (width + _GAP)
        y = top - above[: row + 1].sum() - below[:row].sum() - row * _GAP - (row + 1) * height
        grid[row, column].set_position(np.array([x, y, width, height]) / scale)
    if bar is not None:
        low = page.foot + below[-1]
        bar.set_position(
            np.array([page.width - at_bar - _EDGE + _BAR_GAP, low, _BAR, top - above[0] - low])
            / scale
        )


def _reach(page: Page, axes: Axes) -> tuple[float, float, float, float]:
    """How far the labels of a panel reach beyond it at its left, below, at its right, and its title above, mm."""
    if not axes.get_visible():
        return 0.0, 0.0, 0.0, _EDGE
    panel, under, aside = axes.bbox, axes.xaxis.get_tightbbox(), axes.yaxis.get_tightbbox()
    left, right = (panel.x0 - aside.x0, aside.x1 - panel.x1) if aside else (0.0, 0.0)
    below, over = (panel.y0 - under.y0, under.x1 - panel.x1) if under else (0.0, 0.0)
    title = axes.get_title()
    above = _PANEL_PAD + _PANEL_LINE * (title.count("\n") + 1) if title else _EDGE
    beyond = over if axes.get_label() != "<colorbar>" else right
    to_mm = 1.0 / page.figure.dpi / MM
    return max(0.0, left * to_mm), max(0.0, below * to_mm), max(0.0, beyond * to_mm), above
