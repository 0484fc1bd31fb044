"""Figure of an answer whose choices are rows of tables: windows by name, or points over numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.answer_record import AnswerRecord, ChoiceRecord, value_of
from tendon_cli.cube.choice_grid import conflicts_of, pretension_name, value_text
from tendon_cli.cube.columns import ColumnArray
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import reading_unit
from tendon_cli.figures.backend import Axes, Line2D
from tendon_cli.figures.choice_maps import answer_page, long_axes, set_text, star
from tendon_cli.figures.frame import Page, grid_shape
from tendon_cli.figures.layout import MOST_NAMES, MOST_NUMBERS, is_of_rows, numbers_that_vary
from tendon_cli.figures.scales import short_names
from tendon_cli.figures.style import (
    COLOUR_OF_LIMIT,
    FAINT,
    INK,
    Colour,
    broken,
    limit_colours,
    text_width,
)
from tendon_cli.model.kinematics import Rows
from tendon_cli.space.axis import Axis, evenly_spaced

_MOST_POINTS = 20_000
"""Largest number of points of a panel."""
_MOST_KINDS = 7
"""Largest number of reasons with a colour of their own."""
_OTHERS = "other reasons"
_SINGLE_MARKERS = 400
"""Points up to which each is drawn large."""
_ENDS = ("pretension_from", "pretension_to", "from_by", "to_by")

Floats = npt.NDArray[np.float64]


def draw_rows(cube: Cube, record: AnswerRecord, chosen: ChoiceRecord) -> Page | None:
    """Draw the windows of all choices: by name if they are few, else as points over each number.

    Points are never joined, because there is nothing between two rows.

    Args:
        cube: Choices of the answer.
        record: Record of the answer.
        chosen: The choice that the answer names first.

    Returns:
        The page; None if no table of rows is among the choices.
    """
    axes = long_axes(cube)
    if cube.table is None or not any(map(is_of_rows, axes)):
        return None
    count = int(np.prod([len(axis) for axis in cube.axes]))
    if count <= MOST_NAMES:
        return _draw_by_name(cube, record, chosen, axes, np.arange(count))
    return _draw_points(cube, record, chosen, evenly_spaced(count, _MOST_POINTS), count)


# --- By name --------------------------------------------------------------------------------------


def _draw_by_name(
    cube: Cube, record: AnswerRecord, chosen: ChoiceRecord, axes: Sequence[Axis], rows: Rows
) -> Page:
    """Draw the window of each choice as a bar, with the limits that end it."""
    read = cube.gather(rows, list(_ENDS))
    low = read["pretension_from"]
    is_open = np.isnan(read["pretension_to"]) & ~np.isnan(low)
    top = 1.15 * float(np.nanmax([low, read["pretension_to"]], initial=0.0)) or 1.0
    high = np.where(is_open, top, read["pretension_to"])
    has_window = low <= high
    has_gap = ~has_window & ~np.isnan(low)
    limits = _kinds(np.concatenate([read["from_by"], read["to_by"]]), cube)
    key = []
    if has_window.any():
        key.append(_bar_key(_BAR, "window of pretension"))
    if has_gap.any():
        key.append(_bar_key(_GAP, "no window: the lower limit is above"))
    key += _key_of(limits)
    if chosen["feasible"]:
        key.append(star(label=set_text(cube, chosen)))
    notes = ["Each bar is one choice; a mark at its end has the colour of the limit that ends it."]
    if np.isnan(low).any():
        notes.append("A cross marks a choice for which no pretension works, whatever the limits.")
    names = [_name_of(cube, axes, int(row)) for row in rows]
    texts = short_names(names, _LONGEST_TURNED)
    longest = max(text_width(text, _NAME_SIZE) for text in texts)
    is_crowded = len(names) > _MOST_UPRIGHT or max(map(len, names)) > _LONGEST_UPRIGHT
    # The panel keeps its height, however long the names below it are.
    height = _HEIGHT + (max(0.0, longest - _USUAL_NAME) if is_crowded else 0.0)
    page = answer_page(cube, record, "the window of each choice", height, key, notes)
    panel = page.figure.subplots()
    places = np.arange(len(rows), dtype=np.float64)
    for is_drawn, shade in ((has_window, _BAR), (has_gap, _GAP)):
        panel.vlines(places[is_drawn], low[is_drawn], high[is_drawn], color=shade, linewidth=6)
    for name, colour in limits.items():
        for ends, by in ((low, read["from_by"]), (high, read["to_by"])):
            is_drawn = (_shared(_labels(by, cube), limits) == name) & ~np.isnan(ends)
            panel.plot(places[is_drawn], ends[is_drawn], color=colour, **_POINT)
    unknown = np.isnan(low)
    panel.plot(places[unknown], 0.0 * places[unknown], color=FAINT, marker="x", linestyle="")
    if chosen["feasible"]:
        place = names.index(_joined(cube, {axis: value_of(chosen, axis.column) for axis in axes}))
        best: dict[str, Any] = {"marker": "*", "color": INK, "markersize": 9, "zorder": 5}
        panel.plot([place], [chosen["pretension"] or np.nan], **best)
    panel.set_xticks(places, texts, rotation=90 if is_crowded else 0)
    panel.tick_params(axis="x", labelsize=_NAME_SIZE if is_crowded else 8)
    label = f"{pretension_name(cube.document)} ({reading_unit(cube.document)})"
    panel.set(xlim=(-0.6, len(rows) - 0.4), ylim=(0.0, top), ylabel=label)
    return page


def _bar_key(colour: Colour, label: str) -> Line2D:
    """Return the sample of a bar for the key."""
    return Line2D([], [], color=colour, linewidth=6, solid_capstyle="butt", label=label)


_HEIGHT = 95.0
"""Height of the panel with usual names below it, mm."""
_NAME_SIZE = 7.0
"""Size of names that stand upright, pt."""
_LONGEST_TURNED = 60
"""Most characters of the name of a choice."""
_USUAL_NAME = 25.0
"""Length of usual names, mm."""
_BAR = "#b4d4ea"
_GAP = "#f6d9c5"
_MOST_UPRIGHT = 10
"""Most names that stand upright along an axis."""
_LONGEST_UPRIGHT = 12
"""Characters of the longest name that stands upright."""
_POINT: dict[str, Any] = {"marker": "o", "linestyle": "", "markersize": 4, "zorder": 4}


def _name_of(cube: Cube, axes: Sequence[Axis], row: int) -> str:
    """Return the name of a choice by its values on the axes that vary: "S5, M12"."""
    places = np.unravel_index(row, [len(axis) for axis in cube.axes])
    of_axis = dict(zip((axis.column for axis in cube.axes), places, strict=True))
    return _joined(cube, {axis: axis.values[int(of_axis[axis.column])] for axis in axes})


def _joined(cube: Cube, values: Mapping[Axis, Any]) -> str:
    """Join the values of a choice, by axis, into its name."""
    return ", ".join(
        str(value) if axis.is_text else value_text(cube, axis, value)
        for axis, value in values.items()
    )


# --- Points over each number ----------------------------------------------------------------------


def _draw_points(
    cube: Cube, record: AnswerRecord, chosen: ChoiceRecord, rows: Rows, count: int
) -> Page:
    """Draw the width of each window over each number that varies, coloured by what binds."""
    columns = numbers_that_vary(cube)
    drawn = columns[:MOST_NUMBERS]
    read = cube.gather(rows, [*_ENDS, *drawn])
    width = read["pretension_to"] - read["pretension_from"]
    is_open = np.isnan(read["pretension_to"]) & ~np.isnan(read["pretension_from"])
    top = 1.1 * float(np.nanmax(width, initial=0.0)) or 1.0
    width = np.where(is_open, top, width)
    conflicts = conflicts_of(read, cube.limits)
    reasons = np.where(conflicts == "", _labels(read["to_by"], cube), conflicts)
    kinds = _kinds_of(reasons, cube)
    shown = _shared(reasons, kinds)
    key = _key_of(kinds)
    if chosen["feasible"]:
        key.append(star(label=set_text(cube, chosen)))
    told = [f"each point is one of {count:,} choices"]
    if len(rows) < count:
        told = [f"Shown: {len(rows):,} of {count:,} choices, evenly spaced"]
    if len(drawn) < len(columns):
        told.append(f"over {len(drawn)} of the {len(columns)} numbers that vary")
    lost = int(np.isnan(width).sum())
    if lost:
        told.append(f"not drawn: {say.counted(lost, 'choice')} without any pretension that works")
    meaning = (
        "Above zero: the width of the window of pretension, in the colour of the limit that ends "
        "it; below: by how much the limits miss each other, in the colour of the reason."
    )
    notes = [meaning]
    if is_open.any():
        notes.append("Windows without an upper end stand at the upper edge.")
    panels, in_row = grid_shape(len(drawn), most=3)
    title = "the window of each choice"
    height = 62.0 * panels
    page = answer_page(cube, record, title, height, key, notes, subtitle="; ".join(told))
    grid = page.figure.subplots(panels, in_row, squeeze=False, sharey=True)
    for place, (panel, column) in enumerate(zip(grid.flat, drawn, strict=False)):
        _draw_over(panel, cube, column, read[column], width, shown, kinds)
        if chosen["feasible"] and value_of(chosen, column) is not None:
            _draw_star(panel, cube, column, chosen)
        if place % in_row == 0:
            unit = reading_unit(cube.document)
            panel.set_ylabel(broken(f"width of the window ({unit})", 30))
    for panel in list(grid.flat)[len(drawn) :]:
        panel.set_visible(False)
    return page


def _draw_over(
    panel: Axes,
    cube: Cube,
    column: str,
    values: Floats,
    width: Floats,
    reasons: ColumnArray,
    kinds: Mapping[str, Colour],
) -> None:
    """Draw the widths of windows over one number as points."""
    quantity = cube.shown(column)
    x = quantity.scaled(np.where(np.isinf(values), np.nan, values))
    size = 3.5 if len(x) <= _SINGLE_MARKERS else 1.8
    for kind, colour in kinds.items():
        is_drawn = reasons == kind
        style: dict[str, Any] = {"marker": "o", "linestyle": "", "markersize": size}
        panel.plot(x[is_drawn], width[is_drawn], color=colour, **style)
    panel.axhline(0.0, color=FAINT, linewidth=0.6)
    panel.set_xlabel(broken(quantity.label, 34))


def _draw_star(panel: Axes, cube: Cube, column: str, chosen: ChoiceRecord) -> None:
    """Mark the choice that the answer names first."""
    low = chosen["pretension_from"]
    high = chosen["pretension_to"]
    value = value_of(chosen, column)
    if low is None or high is None or not isinstance(value, float | int):
        return
    x = float(cube.shown(column).scaled(float(value)))
    panel.plot([x], [high - low], marker="*", color=INK, markersize=9, zorder=5)


# --- What binds -----------------------------------------------------------------------------------


def _labels(limits: Iterable[object], cube: Cube) -> ColumnArray:
    """Say each limit in a few words, "" for none."""
    names = [str(name) for name in limits]
    labels = {name: say.limit_words(name, cube.limits).label for name in set(names) if name}
    return np.array([labels.get(name, "") for name in names], dtype=object)


def _kinds(limits: Iterable[object], cube: Cube) -> dict[str, Colour]:
    """Return the colours of limits by their words."""
    return _kinds_of(_labels(limits, cube), cube)


def _kinds_of(reasons: ColumnArray, cube: Cube) -> dict[str, Colour]:
    """Return the colours of reasons, the most frequent first; rare ones share the last entry.

    A limit has the colour that it has in every figure.
    """
    labels, counts = np.unique(reasons[reasons != ""].astype(str), return_counts=True)
    ordered = [str(label) for label in labels[np.argsort(-counts, kind="stable")]]
    if len(ordered) > _MOST_KINDS:
        ordered = [*ordered[: _MOST_KINDS - 1], _OTHERS]
    names = {say.limit_words(name, cube.limits).label: name for name in COLOUR_OF_LIMIT}
    colours = limit_colours(names.get(label, label) for label in ordered)
    return {label: colours[names.get(label, label)] for label in ordered}


def _shared(reasons: ColumnArray, kinds: Mapping[str, Colour]) -> ColumnArray:
    """Return the entry of the key of each reason, "" for none."""
    return np.array(
        [reason if reason in kinds or not reason else _OTHERS for reason in reasons], dtype=object
    )


def _key_of(kinds: Mapping[str, Colour]) -> list[Line2D]:
    """Return the entries of reasons in a key."""
    return [
        Line2D([], [], color=colour, marker="o", linestyle="", markersize=4, label=name)
        for name, colour in kinds.items()
    ]
