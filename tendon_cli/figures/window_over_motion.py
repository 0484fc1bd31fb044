"""The window of the choice named first over the angle, or over the time of a motion in time.

The figure shows what each limit asks for, which limit binds where, and the angles of the study.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.answer_record import AnswerRecord, ChoiceRecord
from tendon_cli.cube.choice_grid import OverMotion, over_motion, pretension_name
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import reading_unit
from tendon_cli.figures.backend import Axes, FigureCanvasAgg, Line2D, Patch
from tendon_cli.figures.choice_maps import answer_page, choice_text
from tendon_cli.figures.clear_texts import annotate_clear
from tendon_cli.figures.frame import Page
from tendon_cli.figures.motion_marks import cell_edges, ends_key, hatch_ends
from tendon_cli.figures.scales import plain_numbers
from tendon_cli.figures.style import FAINT, INK, MARKERS, limit_colours

_WINDOW = "#8fbfe0"
_AT_PLACE = "#e3eef6"
_BOUND: dict[str, Any] = {"linewidth": 2.2, "zorder": 3}
_END_SIGN: dict[str, Any] = {
    "marker": MARKERS[3],
    "color": "white",
    "markeredgecolor": INK,
    "markersize": 6,
}


def draw_between(cube: Cube, record: AnswerRecord, chosen: ChoiceRecord) -> Page | None:
    """Draw the bounds that limits set on the pretension at each angle or time.

    Args:
        cube: Choices of the answer.
        record: Record of the answer.
        chosen: The choice that the answer names first.

    Returns:
        The page; None if the answer has no window over the motion.
    """
    drawn = over_motion(record)
    if drawn is None:
        return None
    floor, roof = drawn.tightest
    top = drawn.top
    colours = limit_colours(name for bounds in drawn.ends for name in bounds)
    key: list[Any] = [
        Line2D([], [], color=colour, label=say.limit_words(name, cube.limits).label)
        for name, colour in colours.items()
    ]
    key += _key(drawn)
    text = choice_text(cube, chosen)
    title = "the window over time" if drawn.is_in_time else "the window over the angle"
    page = answer_page(cube, record, title, 92.0, key, [*drawn.texts], subtitle=text)
    panel = page.figure.subplots()
    has_window = (floor <= roof).tolist()
    area: dict[str, Any] = {"color": _AT_PLACE, "linewidth": 0.0, "zorder": 0.5}
    panel.fill_between(drawn.along, floor, np.minimum(roof, top), where=has_window, **area)
    low, high = drawn.window
    panel.axhspan(low, min(high, top), color=_WINDOW, linewidth=0.0, zorder=0.9)
    panel.set_xlim(*_room_around(drawn.along))
    panel.set_ylim(0.0, top)
    panel.set_xlabel(drawn.axis_label)
    panel.set_ylabel(f"{pretension_name(cube.document)} ({reading_unit(cube.document)})")
    for end, bounds, tightest, samples in zip(
        ("from", "to"), drawn.ends, drawn.tightest, drawn.at_samples, strict=True
    ):
        for name, values in bounds.items():
            colour = colours[name]
            shown = drawn.shown(values)
            binding = np.where(values == tightest, shown, np.nan)
            panel.plot(drawn.along, shown, linewidth=0.9, color=colour, gid=f"{end} {name}")
            panel.plot(drawn.along, binding, color=colour, gid="binds", **_BOUND)
        panel.plot(drawn.samples, samples, "o", color=INK, markersize=2.4, zorder=4, gid="samples")
    if not drawn.does_count.all():
        hatch_ends(panel, ~drawn.does_count, cell_edges(drawn.along))
    pretension = chosen["pretension"]
    if pretension is not None:
        panel.axhline(pretension, color=FAINT, linewidth=0.8, linestyle=(0, (4, 3)))
        star: dict[str, Any] = {"marker": "*", "color": INK, "markersize": 9, "clip_on": False}
        panel.plot([drawn.along[0]], [pretension], zorder=5, **star)
    panel.xaxis.set_major_formatter(plain_numbers())
    panel.yaxis.set_major_formatter(plain_numbers())
    FigureCanvasAgg(page.figure)
    page.figure.draw_without_rendering()  # so that texts find their places between the lines
    for end, value in zip(("from", "to"), drawn.window, strict=True):
        if np.isfinite(value):
            _mark_end(panel, drawn, chosen, end, reading_unit(cube.document))
    return page


def _room_around(along: npt.NDArray[np.float64]) -> tuple[float, float]:
    """Return the ends of the axis of angles (deg) or times (s); a single angle has a degree."""
    first = float(along[0])
    last = float(along[-1])
    return (first, last) if first < last else (first - 1.0, last + 1.0)


def _key(drawn: OverMotion) -> list[Any]:
    """Return the part of the key that is the same for all limits.

    Args:
        drawn: The window over the motion.
    """
    window, at_place = drawn.works
    thick = _BOUND["linewidth"]
    dot: dict[str, Any] = {"marker": "o", "markersize": 3.0, "linestyle": ""}
    key: list[Any] = [
        Line2D([], [], color=INK, linewidth=thick, label=f"thick: binds at that {drawn.word}")
    ]
    if len(drawn.samples):
        key.append(Line2D([], [], color=INK, label="angle of the study", **dot))
    key.append(Patch(facecolor=_WINDOW, label=f"window: {window}"))
    key.append(Patch(facecolor=_AT_PLACE, label=at_place))
    if not drawn.does_count.all():
        key.append(ends_key())
    return key


def _mark_end(panel: Axes, drawn: OverMotion, chosen: ChoiceRecord, end: str, unit: str) -> None:
    """Mark an end of the window ("from" or "to") where it binds, and write its value.

    An end that no state sets, such as the smallest pretension at all, is written at the left.
    """
    value = drawn.window[("from", "to").index(end)]
    left, right = panel.get_xlim()
    place = left
    text = f"{say.number(value)} {unit}"
    stated = chosen[f"{end}_{drawn.place}"]
    if stated is not None:
        place = float(stated) if drawn.is_in_time else float(np.degrees(stated))
        text += f" at {say.number(place, 3)}"
        text += " s" if drawn.is_in_time else "°"
        panel.plot([place], [value], clip_on=False, zorder=6, **_END_SIGN)
    across = -8.0 if place > (left + right) / 2.0 else 8.0
    outside = -9.0 if end == "from" else 9.0
    offsets = [(across, up) for up in (outside, -outside, 2.0 * outside, -2.0 * outside)]
    paper: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8}
    annotate_clear(panel, text, (place, value), offsets, size=7.0, zorder=7, bbox=paper)
