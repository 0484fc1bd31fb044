"""Texts in a panel at places where no line crosses them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tendon_cli.figures.backend import Axes, FigureCanvasAgg

Offset = tuple[float, float]
"""Distance of a text from its point to the right and upward, pt."""


def annotate_clear(
    panel: Axes, text: str, point: tuple[float, float], offsets: Sequence[Offset], **style: Any
) -> None:
    """Write a text beside a point, at the first offset at which no line of the panel crosses it.

    If there is none, the first offset is taken. The layout of the figure must be settled.

    Args:
        panel: The panel.
        text: The text.
        point: The point in the units of the axes.
        offsets: Offsets to try; a text to the left of its point ends there.
        **style: Style of the text.
    """
    canvas: Any = FigureCanvasAgg(panel.get_figure(root=True))
    renderer = canvas.get_renderer()
    place: dict[str, Any] = {"xytext": offsets[0], "textcoords": "offset points", "va": "center"}
    note = panel.annotate(text, point, **place, **style)
    for offset in (*offsets, offsets[0]):
        across, _ = offset
        note.set_position(offset)
        note.set_horizontalalignment("right" if across < 0.0 else "left")
        box = note.get_window_extent(renderer)
        is_inside = panel.bbox.containsx(box.x0) and panel.bbox.containsx(box.x1)
        if is_inside and not any(crosses(line, box) for line in panel.lines):
            break


def crosses(line: Any, box: Any) -> bool:
    """Return True if a line, as it is drawn, crosses a box in pixels."""
    if line.get_linestyle() == "None" or not line.get_visible():
        return False
    path = line.get_path().cleaned(line.get_transform(), remove_nans=True)
    return bool(path.intersects_bbox(box, filled=False))
