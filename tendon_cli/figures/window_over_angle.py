"""The window of the choice named first over the angle: what each limit asks for, what binds where, and the samples."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.cube.choice_grid import over_angle, pretension_name
from tendon_cli.cube.cube import Cube
from tendon_cli.figures.backend import Axes, Line2D, Patch
from tendon_cli.figures.choice_maps import answer_page, choice_text
from tendon_cli.figures.frame import Page
from tendon_cli.figures.scales import plain_numbers
from tendon_cli.figures.style import FAINT, INK, MARKERS, OKABE_ITO

_WINDOW, _THERE = "#8fbfe0", "#e3eef6"
_BOUND: dict[str, Any] = {"linewidth": 2.2, "zorder": 3}


def draw_between(cube: Cube, record: dict[str, Any], chosen: dict[str, Any]) -> Page | None:
    """What the limits ask of the pretension at each angle; None for an answer that has no such curves."""
    drawn, bounds = over_angle(record), cube.limits
    if drawn is None:
        return None
    (lower, upper), (floor, roof), top = drawn.ends, drawn.tightest, drawn.top
    looks: dict[str, dict[str, Any]] = {
        name: {
            "color": OKABE_ITO[at % len(OKABE_ITO)],
            "label": say.limit_words(name, bounds).label,
        }
        for at, name in enumerate(dict.fromkeys((*lower, *upper)))
    }
    title = ", ".join(filter(None, ("the window over the angle", choice_text(cube, chosen))))
    key = [*(Line2D([], [], **look) for look in looks.values()), *_key(*drawn.works)]
    page = answer_page(cube, record, title, 92.0, key, [*drawn.texts])
    panel = page.figure.subplots()
    panel.fill_between(
        drawn.angle,
        floor,
        np.minimum(roof, top),
        where=(floor <= roof).tolist(),
        color=_THERE,
        linewidth=0.0,
        zorder=0.5,
    )
    low, high = drawn.window
    panel.axhspan(low, min(high, top), color=_WINDOW, linewidth=0.0, zorder=0.9)
    panel.set(
        xlim=(drawn.angle[0], drawn.angle[-1]),
        ylim=(0.0, top),
        xlabel="elbow angle θ (deg)",
        ylabel=f"{pretension_name(cube.study)} (N)",
    )
    for place, of_end, tight, on_line, end in zip(
        ("from", "to"), drawn.ends, drawn.tightest, drawn.at_samples, drawn.window, strict=True
    ):
        for name, values in of_end.items():
            colour, shown = looks[name]["color"], drawn.shown(values)
            panel.plot(drawn.angle, shown, linewidth=0.9, color=colour, gid=f"{place} {name}")
            panel.plot(
                drawn.angle,
                np.where(values == tight, shown, np.nan),
                color=colour,
                gid="binds",
                **_BOUND,
            )
        panel.plot(drawn.samples, on_line, "o", color=INK, markersize=2.4, zorder=4, gid="samples")
        if np.isfinite(end):
            _mark_end(panel, chosen, place, end)
    panel.axhline(chosen["pretension"], color=FAINT, linewidth=0.8, linestyle=(0, (4, 3)))
    panel.plot(
        [drawn.angle[0]],
        [chosen["pretension"]],
        marker="*",
        color=INK,
        markersize=9,
        clip_on=False,
        zorder=5,
    )
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_formatter(plain_numbers())
    return page


def _key(everywhere: str, there: str) -> list[Any]:
    """The signs that do not depend on the limits."""
    return [
        Line2D(
            [], [], color=INK, linewidth=_BOUND["linewidth"], label="thick: binds at that angle"
        ),
        Line2D(
            [], [], color=INK, marker="o", markersize=3.0, linestyle="", label="angle of the study"
        ),
        Patch(facecolor=_WINDOW, label=f"window: {everywhere}"),
        Patch(facecolor=_THERE, label=there),
    ]


def _mark_end(panel: Axes, chosen: Mapping[str, Any], end: str, value: float) -> None:
    """An end of the window where it binds, with its number."""
    at = float(np.degrees(chosen[f"{end}_elbow_angle"]))
    sign: dict[str, Any] = {
        "marker": MARKERS[3],
        "color": "white",
        "markeredgecolor": INK,
        "markersize": 6,
    }
    panel.plot([at], [value], clip_on=False, zorder=6, **sign)
    left, right = panel.get_xlim()
    align, shift = ("right", -8) if at > (left + right) / 2.0 else ("left", 8)
    text, place = (
        f"{say.number(value)} N at {say.number(at, 3)}°",
        (shift, -9 if end == "from" else 9),
    )
    panel.annotate(
        text,
        (at, value),
        xytext=place,
        textcoords="offset points",
        ha=align,
        va="center",
        size=7.0,
        zorder=7,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8},
    )
