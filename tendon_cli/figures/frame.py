"""A page with a figure: a title above the panels, the key to the signs and a few honest lines below, and its file.

Whoever draws begins here, in `house_style()`: a Frame says what stands around the panels, `page` gives the figure to
draw into, `Page.save` writes it with its caption and its study in the file's metadata.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli.cube.labels import plain, without_formulas
from tendon_cli.errors import UsageError
from tendon_cli.figures.engine import Axes, Figure, FigureCanvasAgg
from tendon_cli.figures.style import MM, new_figure, save

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

    def save(self, path: Path, *, must_fit: bool = True) -> Path:
        """Write it whole or not at all, in the format of the path's ending.

        Raises OutputError, UsageError for another format, or where its panels have no room and `must_fit`.
        """
        about = {"title": self.title, "says": self.says, "study": self.study}
        return save(self.figure, path, must_fit=must_fit, about=about)


@dataclass(frozen=True)
class Frame:
    """Title, key and notes of a figure; how high they are follows from the width, in mm."""

    width: float
    title: str
    """As the user wrote it."""
    key: Sequence[Any] = ()
    """Artists with a label."""
    notes: Sequence[str] = ()
    """Ready to draw, as is `subtitle`: they may hold formulas."""
    subtitle: str = ""
    study: str = ""
    """Name and hash of the study shown, for the file's metadata."""

    @property
    def title_lines(self) -> list[str]:
        """The title, broken to the width."""
        lines = plain(self.title, width=int(self.width / _TITLE_SIGN)).splitlines()
        return [*lines, self.subtitle] if self.subtitle else lines

    @property
    def note_lines(self) -> list[str]:
        """The notes, broken to the width."""
        width = int(self.width / _NOTE_SIGN)
        return [line for note in self.notes for line in textwrap.wrap(note, width, break_long_words=False)]

    @property
    def key_texts(self) -> list[str]:
        """What the key says, broken to the width."""
        width = max(8, int((self.width - _KEY_HANDLE) / _KEY_SIGN))
        texts = [str(entry.get_label()) for entry in self.key]
        return [
            "\n".join(textwrap.wrap(text, width, break_long_words=False)) if len(text) > width else text
            for text in texts
        ]

    @property
    def key_columns(self) -> int:
        """How many entries of the key fit side by side."""
        longest = max((_KEY_HANDLE + len(text) * _KEY_SIGN for text in self.key_texts), default=1.0)
        return max(1, min(len(self.key), int((self.width + 4.0) / longest)))

    @property
    def head(self) -> float:
        """Height above the panels, mm."""
        return len(self.title_lines) * _TITLE_LINE + _PAD if self.title_lines else 0.0

    @property
    def foot(self) -> float:
        """Height below the panels, mm."""
        return self._key_height + len(self.note_lines) * _NOTE_LINE + _PAD

    def panels_height(self, height: float | None, usual: float) -> float:
        """What is left for the panels of a figure of a height in mm; without one their usual height."""
        return usual if height is None else max(30.0, height - self.head - self.foot)

    def page(self, panels_height: float) -> Page:
        """A page to draw on, whose panels are `panels_height` mm high in all."""
        says = without_formulas(" ".join(filter(None, (self.subtitle, *self.notes))))
        height = self.head + panels_height + self.foot
        return Page(self.figure(panels_height), self.title, says, self.study, self.width, height, self.head, self.foot)

    def figure(self, panels_height: float) -> Figure:
        """A figure whose panels are `panels_height` mm high in all, framed."""
        height = self.head + panels_height + self.foot
        figure = new_figure(self.width, height, (0.0, self.foot / height, 1.0, panels_height / height))
        if self.title_lines:
            x, y = _PAD / self.width, 1.0 - 0.8 * _PAD / height
            figure.text(x, y, "\n".join(self.title_lines), va="top", size=9.0, weight="bold", gid="title")
        if self.note_lines:
            text = "\n".join(self.note_lines)
            y = 0.7 * _PAD / height
            figure.text(_PAD / self.width, y, text, va="bottom", size=6.5, color="#4d4d4d", gid="notes")
        if self.key:
            anchor = (0.0, (len(self.note_lines) * _NOTE_LINE + _PAD) / height, 1.0, self._key_height / height)
            figure.legend(handles=list(self.key), labels=self.key_texts, loc="center", bbox_to_anchor=anchor,
                          ncols=self.key_columns, borderaxespad=0.0, columnspacing=1.6, handletextpad=0.6)  # fmt: skip
        return figure

    @property
    def _key_height(self) -> float:
        if not self.key:
            return 0.0
        broken = sum(text.count("\n") for text in self.key_texts)
        return (math.ceil(len(self.key) / self.key_columns) + broken) * _KEY_LINE


def grid_shape(panels: int, in_row: int = 1, *, most: int = 4) -> tuple[int, int]:
    """Rows and columns for a number of panels on a page; `in_row` panels belong side by side, where there are more."""
    fits = 2 <= in_row <= most and panels % in_row == 0 and panels > in_row
    columns = min(most, in_row if fits else {1: 1, 2: 2, 3: 3, 4: 2}.get(panels, 3))
    return math.ceil(panels / columns), columns


_PAD, _GAP, _TITLE_LINE, _TITLE_PAD = 1.2, 4.5, 3.6, 2.0
"""Around the panels, between them, and for each line of a title, mm."""
_BAR, _BAR_GAP = 4.0, 4.0
_SMALLEST = 4.0
"""Side of a panel, mm."""


@dataclass(frozen=True)
class Panels:
    """The panels of a page, some of which may be hidden, and perhaps a colour bar at their right."""

    page: Page
    grid: Any
    """Axes in an array of shape (rows, columns)."""
    bar: Axes | None = None

    @classmethod
    def on(cls, page: Page, rows: int, columns: int, **shared: Any) -> Panels:
        """Empty panels; `shared` are `sharex` and `sharey`."""
        page.figure.set_layout_engine("none")
        left, right = 14.0 / page.width, 1.0 - 3.0 / page.width
        sides = {
            "left": left,
            "right": right,
            "bottom": (page.foot + 8.0) / page.height,
            "top": 1.0 - (page.head + 5.0) / page.height,
        }
        return cls(page, page.figure.subplots(rows, columns, squeeze=False, gridspec_kw=sides, **shared))

    def settle(self, *, must_fit: bool = True) -> None:
        """Put everything in its place, once all labels are written; raises UsageError where there is no room."""
        FigureCanvasAgg(self.page.figure)
        left = np.array([max(self._beside(axes, 0) for axes in column) for column in self.grid.T])
        under = {axes: axes.xaxis.get_tightbbox() for axes in self.grid.flat if axes.get_visible()}
        below = np.array([max(self._below(axes, under.get(axes)) for axes in row) for row in self.grid])
        above = np.array([max(_title_height(axes) for axes in row) for row in self.grid])
        over = max(_PAD, *(self._over(axes, under.get(axes)) for axes in self.grid[:, -1]))
        at_bar = 0.0 if self.bar is None else _BAR_GAP + _BAR + self._beside(self.bar, 1)
        rows, columns = self.grid.shape
        width = (self.page.width - _PAD - left.sum() - _GAP * (columns - 1) - over - at_bar) / columns
        inner = self.page.height - self.page.head - self.page.foot
        height = (inner - below.sum() - above.sum() - _GAP * (rows - 1)) / rows
        if must_fit and min(width, height) < _SMALLEST:
            hint = "a larger one, or fewer panels and quantities"
            raise UsageError("the panels do not fit into this size", where="--size", hint=hint)
        width, height = max(width, 1.0), max(height, 1.0)
        top = self.page.height - self.page.head
        for row in range(rows):
            y = top - above[: row + 1].sum() - below[:row].sum() - row * _GAP - (row + 1) * height
            for column in range(columns):
                x = _PAD + left[: column + 1].sum() + column * (width + _GAP)
                self._place(self.grid[row, column], x, y, width, height)
        if self.bar is not None:
            low = self.page.foot + below[-1]
            self._place(self.bar, self.page.width - at_bar - _PAD + _BAR_GAP, low, _BAR, top - above[0] - low)

    def _place(self, axes: Axes, x: float, y: float, width: float, height: float) -> None:
        across, up = self.page.width, self.page.height
        axes.set_position((x / across, y / up, width / across, height / up))

    def _beside(self, axes: Axes, side: int) -> float:
        """Room that the y axis takes at the left (0) or the right (1) of a panel, mm."""
        box = axes.yaxis.get_tightbbox() if axes.get_visible() else None
        if box is None:
            return 0.0
        return self._mm(axes.bbox.x0 - box.x0 if side == 0 else box.x1 - axes.bbox.x1)

    def _below(self, axes: Axes, box: Any) -> float:
        return 0.0 if box is None else self._mm(axes.bbox.y0 - box.y0)

    def _over(self, axes: Axes, box: Any) -> float:
        """How far the labels of the x axis reach beyond a panel at its right, mm."""
        return 0.0 if box is None else self._mm(box.x1 - axes.bbox.x1) + 0.3

    def _mm(self, pixels: float) -> float:
        return max(0.0, pixels / self.page.figure.dpi / MM)


def _title_height(axes: Axes) -> float:
    text = axes.get_title() if axes.get_visible() else ""
    return _TITLE_PAD + _TITLE_LINE * (text.count("\n") + 1) if text else _PAD
