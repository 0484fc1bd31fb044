"""Curves: quantities of states or designs as lines, on which slack and instability are seen."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tendon_cli.figures.backend import Axes, Line2D
from tendon_cli.figures.curve_data import CurveData, Floats
from tendon_cli.figures.frame import Page, fitted, framed, grid_shape, panels_of
from tendon_cli.figures.motion_marks import (
    band_key,
    draw_band,
    ends_key,
    hatch_ends,
    shade_turning,
    stretches,
    turning_key,
)
from tendon_cli.figures.scales import Scale, plain_numbers
from tendon_cli.figures.style import (
    COLUMN_WIDTH,
    INK,
    LIMIT_COLOURS,
    MARKERS,
    PAGE_HEIGHT,
    hatch_key,
    unknown_hatch,
)
from tendon_cli.studies.filters import Truth

_DASHES: tuple[Any, ...] = ("solid", (0, (3.2, 1.4)))
_BAND = 4.2
"""Width of the pale band behind a line whose tendon is slack, pt."""
_UNSTABLE: dict[str, Any] = {
    "color": INK,
    "linewidth": 1.7,
    "linestyle": (0, (0.6, 0.9)),
    "marker": "none",
}
_SLACK_POINT: dict[str, Any] = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 8.0,
    "markeredgewidth": 0.0,
    "alpha": 0.3,
    "clip_on": False,
}
"""Pale disc behind a point whose tendon is slack."""
_UNSTABLE_POINT: dict[str, Any] = {
    "clip_on": False,
    "linestyle": "none",
    "marker": "x",
    "markersize": 6.0,
    "markeredgewidth": 1.1,
    "color": INK,
}
"""Cross on a point at which the elbow is unstable."""
_KINK: dict[str, Any] = {
    "linestyle": "none",
    "marker": "|",
    "markersize": 6.0,
    "markeredgewidth": 1.0,
    "color": INK,
}
_FEW_POINTS = 12
"""Lines of at most so many points have a marker at each."""
_CROWD = 200
"""From this number on points that no line joins have smaller markers."""
_MOST_CELLS = 12
"""Largest number of panels on a page of several quantities."""
_MOST_IN_ROW = 4
"""Largest number of panels side by side that each have several quantities."""
_MOST_UNLIKE = 5.0
"""Panels whose values differ by more than this factor do not share an axis."""
_SLACK_AREA = "#fbeae0"
_SLACK_WORD = "#8a3b12"

Cell = tuple[int, int]
"""A panel on a page: indices of its quantity and of its value among the data's panels."""


def draw_curves(data: CurveData, width: float, height: float | None) -> list[Page]:
    """Draw curves, a panel for each quantity and value of the axis of panels, page by page.

    Args:
        data: The lines.
        width: Width of the page, mm.
        height: Height of the page, mm; None if the panels may have their usual height.
    """
    quantities, panels = data.values.shape[:2]
    cells = list(np.ndindex(quantities, panels))
    if len(cells) <= _MOST_CELLS or panels == 1:
        columns = grid_shape(len(cells))[1] if quantities == 1 else 2
        if quantities > 1 and panels > 1:
            columns = panels
        pages = [(cells, columns)]
    elif quantities == 1:
        pages = [(cells[start : start + _MOST_CELLS], 3) for start in range(0, panels, _MOST_CELLS)]
    else:  # as many panels side by side as fit, with their quantities below each other
        in_row = max(1, min(_MOST_IN_ROW, _MOST_CELLS // quantities))
        pages = []
        for start in range(0, panels, in_row):
            seen = range(start, min(panels, start + in_row))
            of_page = [(quantity, panel) for quantity in range(quantities) for panel in seen]
            pages.append((of_page, len(seen)))
    return [_page(data, of_page, columns, width, height) for of_page, columns in pages]


def _page(
    data: CurveData, cells: Sequence[Cell], columns: int, width: float, height: float | None
) -> Page:
    """Draw a page of panels in so many columns, or in one if it is as narrow as a text column."""
    if width <= COLUMN_WIDTH:
        columns = 1
    rows = -(-len(cells) // columns)
    panel_width = (width - 6.0) / columns - 10.0
    usual = min(PAGE_HEIGHT, rows * min(0.62 * panel_width + 14.0, 70.0) + 8.0)
    key = _key(data, cells)
    size: dict[str, Any] = {"width": width, "height": height, "study": data.study}
    page = framed(data.title, usual, key, data.notes, **size)
    axes_of = panels_of(page, rows, columns, len(cells), sharex=True)
    for place, (cell, axes) in enumerate(zip(cells, axes_of, strict=True)):
        _draw_lines(axes, data, cell)
        axes.set_title(fitted(_title(data, cell), panel_width), y=1.0)
        if place >= len(cells) - columns:
            axes.set_xlabel(fitted(data.x_label, panel_width))
    shares_left = _share_y(axes_of, data, cells, columns)
    panel_height = page.inner / rows - 12.0
    for axes, (quantity, _), is_shared in zip(axes_of, cells, shares_left, strict=True):
        _fit_y_axis(axes)
        if not is_shared:
            shown = data.quantities[quantity]
            label = shown.label if len(data.quantities) == 1 else shown.short_label
            axes.set_ylabel(fitted(label, max(panel_height, 15.0)))
    if data.is_slack_below_zero and _is_seen_below_zero(data, cells):
        for axes in axes_of:
            _shade_slack(axes)
    return page


def _is_seen_below_zero(data: CurveData, cells: Sequence[Cell]) -> bool:
    """Return True if values lie visibly below zero."""
    values = np.array([data.values[cell] for cell in cells])
    lowest_value = np.nanmin(values, initial=0.0)
    highest_value = np.nanmax(values, initial=0.0)
    return bool(lowest_value < -0.01 * highest_value)


def _draw_lines(axes: Axes, data: CurveData, cell: Cell) -> None:
    """Draw all lines of one panel, and hatch where none of them has a value."""
    values = data.values[cell]  # (colours, dashes, x)
    for colour, dash in np.ndindex(*values.shape[:2]):
        _draw_line(axes, data, cell, colour, dash)
    if data.x is not None and not data.x.names:
        _mark_motion(axes, data, data.x, cell)
    if data.x is None:
        axes.xaxis.set_major_formatter(plain_numbers())
        return
    data.x.apply(axes, "x")
    _hatch_unknown(axes, data.x, values)


def _draw_line(axes: Axes, data: CurveData, cell: Cell, colour: int, dash: int) -> None:
    """Draw one line with its bands of slack, its stretches of instability and its kinks."""
    place = (*cell, colour, dash)
    x = data.x_values[cell[1], colour, dash]
    order = np.argsort(x, kind="stable") if data.x else np.arange(len(x))
    x = x[order]
    y = data.values[place][order]
    slack = data.slack[place][order]
    any_slack = data.any_slack[place][order]
    unstable = data.unstable[place][order]
    style = _line_style(data, colour, dash, len(x))
    has_bands = _has_bands(data)
    if slack.any() and has_bands:
        band: dict[str, Any] = {"alpha": 0.25, "linewidth": _BAND, "solid_capstyle": "butt"}
        axes.plot(*_stretches(x, y, slack), color=style["color"], gid="slack", **band)
    elif slack.any():
        axes.plot(x[slack], y[slack], **_SLACK_POINT, color=style["color"], gid="slack")
    names = (data.colours[colour][0], data.dashes[dash] if data.dashes else "")
    label = ", ".join(name for name in names if name)
    is_crowd = not data.is_line and len(x) >= _CROWD
    axes.plot(x, y, **style, gid="curve", label=label or "_line", rasterized=is_crowd)
    if unstable.any() and has_bands:
        axes.plot(*_stretches(x, y, unstable), **_UNSTABLE, gid="unstable")
    elif unstable.any():
        axes.plot(x[unstable], y[unstable], **_UNSTABLE_POINT, gid="unstable")
    for limit, name in enumerate(data.limits):
        marked = data.broken[limit, *place[1:]][order]
        if marked.any():
            points = _stretches(x, y, marked) if has_bands else (x[marked], y[marked])
            axes.plot(*points, **_limit_style(data, limit), gid=name)
    if _may_have_kinks(data):
        # A kink is drawn half way between the last taut state and the first slack one.
        change = any_slack[:-1] != any_slack[1:]
        axes.plot(_middle(x)[change], _middle(y)[change], **_KINK, gid="kink")


def _has_bands(data: CurveData) -> bool:
    """Return True if points are so near each other that bands between them tell where slack is.

    Where each of few points has a marker, nothing is known of the stretch between two of them, so
    that only the points are marked.
    """
    points = int(data.x_values.shape[-1])
    return data.is_line and points > _FEW_POINTS


def _may_have_kinks(data: CurveData) -> bool:
    """Return True if a mark between a taut state and the next slack one is near the change."""
    has_axis = data.x is not None
    return data.has_kinks and has_axis and _has_bands(data)


def _mark_motion(axes: Axes, data: CurveData, x: Scale, cell: Cell) -> None:
    """Mark turns, the range of the torque there, and the ends of the record along a motion."""
    panel = cell[1]
    values = data.values[cell]  # (colours, dashes, x)
    at_ends = data.at_record_end[panel].any(axis=(0, 1))
    hatch_ends(axes, at_ends[x.order], x.edges)
    lines = int(np.prod(values.shape[:2]))
    for colour, dash in np.ndindex(*values.shape[:2]):
        turning = data.turning[panel, colour, dash] & ~at_ends
        shade_turning(axes, turning[x.order], x.edges, lines)
        times = data.x_values[panel, colour, dash][x.order]
        torque = values[colour, dash][x.order]
        other = np.where(at_ends, np.nan, data.others[cell][colour, dash])[x.order]
        draw_band(axes, times, torque, other, data.colours[colour][1])


def _hatch_unknown(axes: Axes, x: Scale, values: Floats) -> None:
    """Hatch the stretches of x where no line of a panel has a value."""
    is_unknown = np.asarray(~np.isfinite(values).any(axis=(0, 1)))
    for first, last in stretches(is_unknown[x.order], x.edges):
        axes.axvspan(first, last, zorder=0.6, **unknown_hatch())


def _stretches(x: Floats, y: Floats, holds: Truth) -> tuple[Floats, Floats]:
    """Return the parts of a line where something holds, with NaN between them.

    Each part reaches half way to the next point where it does not hold, so that a single point has
    a length, too.
    """
    count = 2 * len(x) - 1
    places = np.empty(count)
    values = np.empty(count)
    is_kept = np.empty(count, dtype=np.bool_)
    places[::2] = x
    places[1::2] = _middle(x)
    values[::2] = y
    values[1::2] = _middle(y)
    is_kept[::2] = holds
    is_kept[1::2] = holds[:-1] | holds[1:]
    return places, np.where(is_kept, values, np.nan)


def _middle(values: Floats) -> Floats:
    """Return the middle between each value and the next."""
    return np.asarray((values[:-1] + values[1:]) / 2.0)


def _line_style(data: CurveData, colour: int, dash: int, points: int) -> dict[str, Any]:
    """Return the style of a line; `colour` and `dash` are its indices, `points` its length.

    Points that no line joins have a marker each. Lines differ by colour, and in grey print by
    markers and lightness. No two lines have their markers at the same points, so that two lines
    that coincide are recognised.
    """
    lines = len(data.colours)
    step = max(2, points // 6)
    start = round(step * ((colour + 0.5) / lines + 0.5 * dash)) % step
    has_all_markers = points <= _FEW_POINTS or not data.is_line
    line_colour = data.colours[colour][1]
    return {
        "color": line_colour,
        "linestyle": _DASHES[dash] if data.is_line else "none",
        "marker": MARKERS[colour % len(MARKERS)] if lines > 1 or has_all_markers else "none",
        "markersize": 2.8 if data.is_line or points < _CROWD else 1.6,
        "markevery": 1 if has_all_markers else (start, step),
        "markerfacecolor": line_colour if dash == 0 else "white",
        "markeredgewidth": 0.8,
    }


def _limit_style(data: CurveData, limit: int) -> dict[str, Any]:
    """Return the style of what breaks a limit, `limit` its index.

    On a line the marks of several limits take turns; on points they are rings around each other.
    """
    colour = LIMIT_COLOURS[1 + limit % (len(LIMIT_COLOURS) - 1)]
    if not _has_bands(data):
        size = 7.5 + 2.0 * limit
        ring: dict[str, Any] = {"marker": "o", "markersize": size, "markerfacecolor": "none"}
        return {"color": colour, "linestyle": "none", "markeredgewidth": 0.8, **ring}
    gap = 1.6 * len(data.limits) - 0.6
    dashes = (-1.6 * limit, (1.0, gap))
    return {"color": colour, "linewidth": 2.6, "linestyle": dashes, "marker": "none"}


def _key(data: CurveData, cells: Sequence[Cell]) -> list[Any]:
    """Return the key: colours, dashes (filled and open markers), slack, instability, no value."""
    points = data.x_values.shape[-1]
    key: list[Any] = []
    for place, (text, _) in enumerate(data.colours):
        if text:
            style = _line_style(data, place, 0, points) | {"markevery": 1, "markersize": 2.8}
            key.append(Line2D([], [], **style, label=text))
    for place, text in enumerate(data.dashes):
        style = _line_style(data, 0, place, points) | {"markevery": 1, "color": INK}
        style["markerfacecolor"] = ("black", "white")[place]
        label = text
        if style["marker"] != "none":
            style["marker"] = "o"
            label = f"{text}, {('filled', 'open')[place]}"
        key.append(Line2D([], [], **style, label=label))
    slack = np.array([data.slack[cell] for cell in cells])
    any_slack = np.array([data.any_slack[cell] for cell in cells])
    unstable = np.array([data.unstable[cell] for cell in cells])
    if slack.any():
        band: dict[str, Any] = {"color": INK, "alpha": 0.25, "linewidth": _BAND}
        style = band if _has_bands(data) else {**_SLACK_POINT, "color": INK}
        key.append(Line2D([], [], label="a tendon is slack", **style))
    has_changes = bool((any_slack[..., 1:] != any_slack[..., :-1]).any())
    if _may_have_kinks(data) and has_changes:
        key.append(Line2D([], [], **_KINK, label="one goes slack"))
    if unstable.any():
        style = _UNSTABLE if _has_bands(data) else _UNSTABLE_POINT
        key.append(Line2D([], [], **style, label="unstable elbow"))
    for limit, text in enumerate(data.limits):
        style = _limit_style(data, limit)
        if _has_bands(data):
            style["linestyle"] = (0, (1.0, 0.6))
        key.append(Line2D([], [], **style, label=f"breaks {text}"))
    # True where some line of a panel has a value, of shape (cells, x).
    is_known = np.isfinite(np.array([data.values[cell] for cell in cells])).any(axis=(1, 2))
    if data.x is not None and not is_known.all():
        key.append(hatch_key("no value"))
    return [*key, *_motion_key(data, cells)]


def _motion_key(data: CurveData, cells: Sequence[Cell]) -> list[Any]:
    """Return the part of the key that a motion in time has: turns, their range, record's ends."""
    key: list[Any] = []
    if data.turning.any():
        key.append(turning_key())
    if np.isfinite(np.array([data.others[cell] for cell in cells])).any():
        key.append(band_key())
    if data.at_record_end.any():
        key.append(ends_key())
    return key


def _title(data: CurveData, cell: Cell) -> str:
    """Return the title of a panel: its quantity and its value, if these differ on the page."""
    quantity, panel = cell
    texts = []
    if len(data.quantities) > 1:
        texts.append(data.quantities[quantity].titled)
    if data.panels:
        texts.append(data.panels[panel])
    return ", ".join(texts)


def _share_y(
    grid: Sequence[Axes], data: CurveData, cells: Sequence[Cell], columns: int
) -> list[bool]:
    """Let panels share y if they show one quantity, or in a row one unit and similar sizes.

    Returns:
        True for each panel whose y axis is that of its left neighbour, which then labels both.
    """
    is_one = len({quantity for quantity, _ in cells}) == 1
    sizes = [float(np.nanmax(np.abs(data.values[cell]), initial=0.0)) for cell in cells]
    units = [data.quantities[quantity].kind_shown for quantity, _ in cells]
    shares_left = []
    for place, axes in enumerate(grid):
        row_start = place - place % columns
        first = 0 if is_one else row_start
        small, large = sorted((sizes[first], sizes[place]))
        is_alike = is_one or large <= _MOST_UNLIKE * small
        is_same = units[first] == units[place] and is_alike
        if is_same and place != first:
            axes.sharey(grid[first])
        is_shared = is_same and place != row_start
        axes.tick_params(labelleft=not is_shared)
        shares_left.append(is_shared)
    return shares_left


def _fit_y_axis(axes: Axes) -> None:
    """Fit the y axis to its values, and draw a line at zero if it is among them."""
    axes.yaxis.set_major_formatter(plain_numbers())
    axes.autoscale(axis="y")
    axes.margins(y=0.05)
    low, high = axes.get_ylim()
    if low < 0.0 < high:
        axes.axhline(0.0, color=INK, linewidth=0.5, zorder=1.2)


def _shade_slack(axes: Axes) -> None:
    """Shade and name the area below zero in a panel in which negative means slack."""
    low, high = axes.get_ylim()
    if low >= 0.0:
        return
    axes.axhspan(low, 0.0, facecolor=_SLACK_AREA, linewidth=0.0, zorder=0.3, gid="slack area")
    axes.axhline(0.0, color=INK, linewidth=0.5, zorder=1.2)
    word: dict[str, Any] = {"color": _SLACK_WORD, "style": "italic", "gid": "slack word"}
    axes.text(0.02, 0.03, "slack", transform=axes.transAxes, **word)
    axes.set_ylim(low, high)
