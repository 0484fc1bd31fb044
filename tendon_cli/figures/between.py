"""The window of the choice named first over the angle: what each limit asks for, what binds where, and the samples."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.cube.choices import bounds_of, lines_texts
from tendon_cli.cube.cube import Cube
from tendon_cli.figures.choice_maps import answer_page, choice_text
from tendon_cli.figures.engine import Axes, Line2D, Patch
from tendon_cli.figures.frame import Page
from tendon_cli.figures.scales import plain_numbers
from tendon_cli.figures.style import FAINT, INK, MARKERS, OKABE_ITO

Array = npt.NDArray[np.float64]

_WINDOW, _THERE = "#8fbfe0", "#e3eef6"
_ROOM = 1.6
"""How far above the window the figure goes, as a factor."""
_BOUND: dict[str, Any] = {"linewidth": 2.2, "zorder": 3}


def draw_between(cube: Cube, record: dict[str, Any], chosen: dict[str, Any]) -> Page | None:
    """What the limits ask of the pretension at each angle; None for an answer that has no such curves."""
    between = record.get("between_samples")
    if not between or not chosen["feasible"]:
        return None
    curves, bounds = between["curves"], bounds_of(cube)
    angle = np.degrees(curves["elbow_angle"])
    lower, upper = ({name: _array(values) for name, values in curves[end].items()} for end in ("lower", "upper"))
    looks: dict[str, dict[str, Any]] = {
        name: {"color": OKABE_ITO[at % len(OKABE_ITO)], "label": say.limit_words(name, bounds).label}
        for at, name in enumerate(dict.fromkeys((*lower, *upper)))
    }
    notes = [*filter(None, lines_texts(between, float(chosen["pretension"])))]
    what = choice_text(cube, chosen)
    title = ", ".join(filter(None, ("the window over the angle", what)))
    page = answer_page(
        cube, record, title, 92.0, [*(Line2D([], [], **look) for look in looks.values()), *_key()], notes
    )
    panel = page.figure.subplots()
    low, high = chosen["pretension_from"], np.inf if chosen["pretension_to"] is None else chosen["pretension_to"]
    top = _ROOM * (high if np.isfinite(high) else max(2.0 * low, 1.0))
    floor, roof = _tightest(lower, np.fmax, 0.0), _tightest(upper, np.fmin, np.inf)
    panel.fill_between(
        angle, floor, np.minimum(roof, top), where=(floor <= roof).tolist(), color=_THERE, linewidth=0.0, zorder=0.5
    )
    panel.axhspan(low, min(high, top), color=_WINDOW, linewidth=0.0, zorder=0.9)
    samples = np.degrees(curves["samples"])
    for of_end, tight, end, place in ((lower, floor, low, "from"), (upper, roof, high, "to")):
        for name, values in of_end.items():
            shown = np.where((values >= 0.0) & (values <= 1.02 * top), values, np.nan)
            panel.plot(angle, shown, linewidth=0.9, color=looks[name]["color"], gid=f"{place} {name}")
            panel.plot(
                angle, np.where(values == tight, shown, np.nan), color=looks[name]["color"], gid="binds", **_BOUND
            )
        on_line = np.interp(samples, angle, tight)
        panel.plot(
            samples, np.where(on_line <= top, on_line, np.nan), "o", color=INK, markersize=2.4, zorder=4, gid="samples"
        )
        if np.isfinite(end):
            _mark_end(panel, chosen, place, float(end))
    panel.axhline(chosen["pretension"], color=FAINT, linewidth=0.8, linestyle=(0, (4, 3)))
    panel.plot([angle[0]], [chosen["pretension"]], marker="*", color=INK, markersize=9, clip_on=False, zorder=5)
    panel.set(xlim=(angle[0], angle[-1]), ylim=(0.0, top), xlabel="elbow angle θ (deg)", ylabel="pretension F₀ (N)")
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_formatter(plain_numbers())
    return page


def _key() -> list[Any]:
    """The signs that do not depend on the limits."""
    return [
        Line2D([], [], color=INK, linewidth=_BOUND["linewidth"], label="thick: binds at that angle"),
        Line2D([], [], color=INK, marker="o", markersize=3.0, linestyle="", label="angle of the study"),
        Patch(facecolor=_WINDOW, label="window: works at every angle"),
        Patch(facecolor=_THERE, label="works at that angle"),
    ]


def _mark_end(panel: Axes, chosen: Mapping[str, Any], end: str, value: float) -> None:
    """An end of the window where it binds, with its number."""
    at = float(np.degrees(chosen[f"{end}_elbow_angle"]))
    sign: dict[str, Any] = {"marker": MARKERS[3], "color": "white", "markeredgecolor": INK, "markersize": 6}
    panel.plot([at], [value], clip_on=False, zorder=6, **sign)
    left, right = panel.get_xlim()
    align, shift = ("right", -8) if at > (left + right) / 2.0 else ("left", 8)
    text, place = f"{say.number(value)} N at {say.number(at, 3)}°", (shift, -9 if end == "from" else 9)
    panel.annotate(text, (at, value), xytext=place, textcoords="offset points", ha=align, va="center", size=7.0,
                   zorder=7, bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8})  # fmt: skip


def _tightest(curves: Mapping[str, Array], of: np.ufunc, nothing: float) -> Array:
    return np.asarray(of.reduce([*curves.values(), np.full(len(next(iter(curves.values()))), nothing)]))


def _array(values: list[float | None]) -> Array:
    return np.array([np.nan if value is None else value for value in values])
