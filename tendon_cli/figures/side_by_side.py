"""Results side by side on one scale: windows of answers, margins of runs, maps of choices."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from tendon_cli import say
from tendon_cli.cube.cube import Cube
from tendon_cli.figures.answer_figures import answer_pages
from tendon_cli.figures.answer_page import star
from tendon_cli.figures.backend import Axes, Line2D, Patch
from tendon_cli.figures.choice_maps import longest_tolerance
from tendon_cli.figures.frame import Page, framed, text_width
from tendon_cli.figures.style import FAINT, INK, OKABE_ITO, PAGE_WIDTH, STAR, WINDOW, house_style
from tendon_cli.model.kinematics import Array

_ROW = 11.0
"""Height of the row of an answer, mm."""
_PANEL = 0.75
"""Share of the width of the page that the panel has."""
_PAD = 0.015
"""Space beside the name of a limit, as a share of the width of the panel."""
_NAME_SIZE = 6.0
_MOST_POINTS = 20_000
"""Largest number of designs that are drawn, evenly spread."""


class WindowRow(NamedTuple):
    """The window of an answer, in the unit that is read."""

    label: str
    low: float | None
    """Lower end; None without a window."""
    high: float | None
    """Upper end; None if nothing bounds it."""
    pretension: float | None
    """Pretension that is set."""
    fresh: tuple[float, float | None] | None
    """Window of the fresh sample."""
    limits: tuple[str, str]
    """Limits that bind below and above, in words."""


def windows_page(
    rows: Sequence[WindowRow],
    title: str,
    read: str,
    unit: str,
    study: str,
    width: float = PAGE_WIDTH,
) -> Page:
    """Draw the windows of answers below each other over one axis.

    Args:
        rows: The windows.
        title: Title of the page.
        read: What is read, in words.
        unit: Its unit.
        study: Name and hash of the study for the file's metadata.
        width: Width of the page, mm.
    """
    ends = [end for row in rows for end in (row.low, row.high, row.pretension) if end is not None]
    names = [text_width(row.limits[1], _NAME_SIZE) for row in rows]
    for_names = max(names, default=0.0) / (_PANEL * width) + 2.0 * _PAD
    right = max(ends, default=1.0) / (1.0 - for_names) or 1.0
    key: list[Any] = [Patch(facecolor=WINDOW, label="window of the study's own conditions")]
    if any(row.fresh is not None for row in rows):
        key.append(Line2D([], [], color=INK, linewidth=1.2, label="window of the fresh sample"))
    key.append(star("what is set"))
    with house_style():
        page = framed(title, 14.0 + _ROW * len(rows), key, study=study, width=width)
        panel = page.figure.subplots()
        for place, row in enumerate(rows):
            _draw_row(panel, row, place, right, _PANEL * width)
        panel.set_yticks(range(len(rows)), [row.label for row in rows])
        panel.set(xlim=(0.0, right), ylim=(len(rows) - 0.4, -0.6), xlabel=f"{read} ({unit})")
    return page


def _draw_row(panel: Axes, row: WindowRow, place: int, right: float, width: float) -> None:
    """Draw the window of one answer in its row of a panel that is `width` mm wide."""
    small: dict[str, Any] = {"size": _NAME_SIZE, "color": INK, "va": "center"}
    if row.low is None:
        panel.text(0.5 * right, place, "no window", ha="center", **small)
        return
    high = right if row.high is None else row.high
    panel.barh(place, high - row.low, 0.5, row.low, color=WINDOW)
    if row.fresh is not None:
        low, fresh_high = row.fresh
        panel.plot([low, right if fresh_high is None else fresh_high], [place, place], color=INK)
    if row.pretension is not None:
        panel.plot([row.pretension], [place], **STAR)
    below, above = row.limits
    pad = _PAD * right
    if below and row.low > text_width(below, _NAME_SIZE) / width * right + 2.0 * pad:
        panel.text(row.low - pad, place, below, ha="right", **small)
    elif below:
        panel.text(row.low, place + 0.4, below, ha="left", **small)
    if above and row.high is not None:
        panel.text(high + pad, place, above, ha="left", **small)


def margins_page(
    before: Array,
    now: Array,
    labels: tuple[str, str],
    title: str,
    study: str,
    width: float = PAGE_WIDTH,
) -> Page:
    """Draw the margins of the designs in two runs over each other, on one scale.

    Args:
        before: Margins in the first run, (designs,), N; NaN without equilibrium.
        now: Margins in the later one.
        labels: Names of both.
        title: Title of the page.
        study: Name and hash of the study for the file's metadata.
        width: Width of the page, mm.
    """
    known = np.flatnonzero(np.isfinite(before) & np.isfinite(now))
    every = max(1, math.ceil(len(known) / _MOST_POINTS))
    shown = known[::every]
    notes = ["Above the line the margin is larger in the later run."]
    if len(known) < len(before):
        left_out = say.counted(len(before) - len(known), "design")
        notes.append(f"Not shown: {left_out} without equilibrium in one of the runs.")
    if every > 1:
        notes.append(f"Shown: {len(shown):,} of {len(known):,} designs, evenly spaced.")
    ends = np.concatenate([before[shown], now[shown], [0.0]])
    pad = 0.05 * float(np.ptp(ends)) or 1.0
    low = float(ends.min()) - pad
    high = float(ends.max()) + pad
    with house_style():
        page = framed(title, 95.0, (), notes, study=study, width=width)
        panel = page.figure.subplots()
        panel.plot([low, high], [low, high], color=FAINT, linewidth=0.8)
        panel.axhline(0.0, color=FAINT, linewidth=0.5)
        panel.axvline(0.0, color=FAINT, linewidth=0.5)
        points: dict[str, Any] = {"marker": "o", "linestyle": "", "color": OKABE_ITO[0]}
        panel.plot(before[shown], now[shown], markersize=2.5, alpha=0.6, **points)
        first, later = labels
        panel.set(
            xlim=(low, high),
            ylim=(low, high),
            aspect="equal",
            xlabel=f"margin, {first} (N)",
            ylabel=f"margin, {later} (N)",
        )
    return page


def maps_on_one_scale(
    cubes: Sequence[Cube], records: Sequence[Mapping[str, Any]], width: float = PAGE_WIDTH
) -> list[Page | None]:
    """Draw the map of each answer's choices with colours of one scale.

    Args:
        cubes: Choices of the answers.
        records: Records of the answers.
        width: Width of the pages, mm.

    Returns:
        A page for each answer; None for one without two axes of choices.
    """
    longest = max((longest_tolerance(cube) for cube in cubes), default=0.0)
    how: dict[str, Any] = {"longest": longest, "width": width}
    drawn = [
        answer_pages("tolerance_map", cube, record, **how)
        for cube, record in zip(cubes, records, strict=True)
    ]
    return [next(iter(pages), None) for pages in drawn]
