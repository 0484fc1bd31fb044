"""The window of the choice named first over the angle.

The figure shows what each limit asks for, which limit binds where, and the angles of the study.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.answer_record import AnswerRecord, ChoiceRecord
from tendon_cli.cube.choice_grid import over_angle, pretension_name
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import reading_unit, without_formulas
from tendon_cli.figures.backend import Axes, Line2D, Patch
from tendon_cli.figures.choice_maps import answer_page, choice_text
from tendon_cli.figures.frame import Page
from tendon_cli.figures.scales import plain_numbers
from tendon_cli.figures.style import FAINT, INK, MARKERS, OKABE_ITO

_WINDOW = "#8fbfe0"
_AT_ANGLE = "#e3eef6"
_BOUND: dict[str, Any] = {"linewidth": 2.2, "zorder": 3}
_END_SIGN: dict[str, Any] = {
    "marker": MARKERS[3],
    "color": "white",
    "markeredgecolor": INK,
    "markersize": 6,
}


def draw_between(cube: Cube, record: AnswerRecord, chosen: ChoiceRecord) -> Page | None:
    """Draw the bounds that limits set on the pretension at each angle.

    Args:
        cube: Choices of the answer.
        record: Record of the answer.
        chosen: The choice that the answer names first.

    Returns:
        The page; None if the answer has no window over the angle.
    """
    drawn = over_angle(record)
    if drawn is None:
        return None
    floor, roof = drawn.tightest
    top = drawn.top
    colours = _limit_colours(*drawn.ends)
    key: list[Any] = [
        Line2D([], [], color=colour, label=say.limit_words(name, cube.limits).label)
        for name, colour in colours.items()
    ]
    key += _key(*drawn.works)
    text = without_formulas(choice_text(cube, chosen))
    page = answer_page(
        cube, record, "the window over the angle", 92.0, key, [*drawn.texts], subtitle=text
    )
    panel = page.figure.subplots()
    has_window = (floor <= roof).tolist()
    area: dict[str, Any] = {"color": _AT_ANGLE, "linewidth": 0.0, "zorder": 0.5}
    panel.fill_between(drawn.angle, floor, np.minimum(roof, top), where=has_window, **area)
    low, high = drawn.window
    panel.axhspan(low, min(high, top), color=_WINDOW, linewidth=0.0, zorder=0.9)
    panel.set_xlim(*_room_around(drawn.angle))
    panel.set_ylim(0.0, top)
    panel.set_xlabel("elbow angle θ (deg)")
    panel.set_ylabel(f"{pretension_name(cube.document)} ({reading_unit(cube.document)})")
    for end, bounds, tightest, samples, value in zip(
        ("from", "to"), drawn.ends, drawn.tightest, drawn.at_samples, drawn.window, strict=True
    ):
        for name, values in bounds.items():
            colour = colours[name]
            shown = drawn.shown(values)
            binding = np.where(values == tightest, shown, np.nan)
            panel.plot(drawn.angle, shown, linewidth=0.9, color=colour, gid=f"{end} {name}")
            panel.plot(drawn.angle, binding, color=colour, gid="binds", **_BOUND)
        panel.plot(drawn.samples, samples, "o", color=INK, markersize=2.4, zorder=4, gid="samples")
        if np.isfinite(value):
            _mark_end(panel, chosen, end, value, reading_unit(cube.document))
    pretension = chosen["pretension"]
    if pretension is not None:
        panel.axhline(pretension, color=FAINT, linewidth=0.8, linestyle=(0, (4, 3)))
        star: dict[str, Any] = {"marker": "*", "color": INK, "markersize": 9, "clip_on": False}
        panel.plot([drawn.angle[0]], [pretension], zorder=5, **star)
    panel.xaxis.set_major_formatter(plain_numbers())
    panel.yaxis.set_major_formatter(plain_numbers())
    return page


def _room_around(angles: npt.NDArray[np.float64]) -> tuple[float, float]:
    """Return the ends of the axis of angles, deg; a single angle has a degree on either side."""
    first = float(angles[0])
    last = float(angles[-1])
    return (first, last) if first < last else (first - 1.0, last + 1.0)


def _limit_colours(*ends: Mapping[str, Any]) -> dict[str, str]:
    """Select a colour for each limit of both ends of the window."""
    names = dict.fromkeys(name for bounds in ends for name in bounds)
    return {name: OKABE_ITO[place % len(OKABE_ITO)] for place, name in enumerate(names)}


def _key(window: str, at_angle: str) -> list[Any]:
    """Return the part of the key that is the same for all limits.

    Args:
        window: For whom the window works.
        at_angle: For whom the shaded pretensions work at an angle.
    """
    thick = _BOUND["linewidth"]
    dot: dict[str, Any] = {"marker": "o", "markersize": 3.0, "linestyle": ""}
    return [
        Line2D([], [], color=INK, linewidth=thick, label="thick: binds at that angle"),
        Line2D([], [], color=INK, label="angle of the study", **dot),
        Patch(facecolor=_WINDOW, label=f"window: {window}"),
        Patch(facecolor=_AT_ANGLE, label=at_angle),
    ]


def _mark_end(panel: Axes, chosen: Mapping[str, Any], end: str, value: float, unit: str) -> None:
    """Mark an end of the window ("from" or "to") where it binds, and write its value.

    An end that no state sets, such as the smallest pretension at all, is written at the left.
    """
    left, right = panel.get_xlim()
    angle = left
    text = f"{say.number(value)} {unit}"
    if chosen[f"{end}_elbow_angle"] is not None:
        angle = float(np.degrees(chosen[f"{end}_elbow_angle"]))
        text += f" at {say.number(angle, 3)}°"
        panel.plot([angle], [value], clip_on=False, zorder=6, **_END_SIGN)
    is_right = angle > (left + right) / 2.0
    panel.annotate(
        text,
        (angle, value),
        xytext=(-8 if is_right else 8, -9 if end == "from" else 9),
        textcoords="offset points",
        ha="right" if is_right else "left",
        va="center",
        size=7.0,
        zorder=7,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8},
    )
