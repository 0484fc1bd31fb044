"""Panels of a page in rows and columns, each side given the room that its labels take: measured once, not searched."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tendon_cli.errors import UsageError
from tendon_cli.figures.engine import Axes, FigureCanvasAgg
from tendon_cli.figures.frame import Page
from tendon_cli.figures.style import MM

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
