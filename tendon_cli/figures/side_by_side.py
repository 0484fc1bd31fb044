"""Results side by side on one scale: windows of answers, margins of runs, maps of choices."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.cube.choice_grid import upper_ends
from tendon_cli.cube.cube import Cube
from tendon_cli.figures.answer_figures import answer_pages
from tendon_cli.figures.answer_page import star
from tendon_cli.figures.choice_maps import longest_tolerance
from tendon_cli.figures.frame import Page, fitted, framed, panels_of
from tendon_cli.figures.scales import scale_of_names
from tendon_cli.figures.style import (
    FAINT,
    INK,
    OKABE_ITO,
    PAGE_WIDTH,
    STAR,
    house_style,
    key_line,
    largest,
    limit_colours,
)
from tendon_cli.figures.windows import Windows, draw_panel, window_key
from tendon_cli.model.kinematics import Array
from tendon_cli.studies import limit_phrases

_MOST_POINTS = 20_000
"""Largest number of designs that are drawn, evenly spread."""


def windows_page(
    labels: Sequence[str],
    columns: Mapping[str, Sequence[Any]],
    bounds: limit_phrases.LimitValues,
    title: str,
    read: str,
    study: str,
    width: float = PAGE_WIDTH,
) -> Page:
    """Draw the windows of answers side by side over one axis.

    Args:
        labels: Names of the answers.
        columns: Ends of the windows of the study's own conditions, limits that set them and what is
            set, by the names of columns of choices; and `fresh`, both ends of the windows of the
            fresh samples. None for an end that is not.
        bounds: Limits of the studies, SI; None for one that differs.
        title: Title of the page.
        read: What is read, in words, with its unit.
        study: Name and hash of the study for the file's metadata.
        width: Width of the page, mm.
    """
    scale = scale_of_names("", labels, np.arange(len(labels)))
    *numbers, pretensions = (
        np.array(columns[name], dtype=np.float64)
        for name in ("pretension_from", "pretension_to", "pretension")
    )
    windows = Windows(
        numbers[0],
        upper_ends(*numbers),
        np.array(columns["from_by"], dtype=object),
        np.array(columns["to_by"], dtype=object),
    )
    pretensions[np.isnan(windows.low)] = np.nan
    fresh_low, fresh_high = np.array(columns["fresh"], dtype=np.float64).T
    colours = limit_colours(windows.limits)
    meaning = "window of the study's own conditions"
    key = window_key([windows], colours, bounds, meaning, "no window")
    if np.isfinite(fresh_low).any():
        key.append(key_line(color=INK, linewidth=1.2, label="window of the fresh sample"))
    key.append(star("what is set"))
    with house_style():
        page = framed(title, 66.0, key, study=study, width=width)
        (panel,) = panels_of(page, 1, 1, 1)
        draw_panel(panel, scale, windows, colours, largest(pretensions))
        fresh_high = np.minimum(upper_ends(fresh_low, fresh_high), panel.get_ylim()[1])
        panel.vlines(scale.places, fresh_low, fresh_high, color=INK)
        panel.plot(scale.places, pretensions, gid="best", **STAR)
        scale.apply(panel, "x", width - 15.0)
        panel.set_ylabel(fitted(read, 60.0))
    return page


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
    with house_style():
        page = framed(title, 95.0, (), notes, study=study, width=width)
        (panel,) = panels_of(page, 1, 1, 1)
        panel.axline((0.0, 0.0), slope=1.0, color=FAINT, linewidth=0.8)
        panel.axhline(0.0, color=FAINT, linewidth=0.5)
        panel.axvline(0.0, color=FAINT, linewidth=0.5)
        panel.plot(
            before[shown],
            now[shown],
            marker="o",
            linestyle="",
            color=OKABE_ITO[0],
            markersize=2.5,
            alpha=0.6,
        )
        ends = [*panel.get_xlim(), *panel.get_ylim()]
        span = (min(ends), max(ends))
        first, later = (f"margin, {label} (N)" for label in labels)
        panel.set(xlim=span, ylim=span, aspect="equal", xlabel=first, ylabel=later)
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
    drawn = [
        answer_pages("tolerance_map", cube, record, longest=longest, width=width)
        for cube, record in zip(cubes, records, strict=True)
    ]
    return [next(iter(pages), None) for pages in drawn]
