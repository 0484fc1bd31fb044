"""Windows of pretension of choices: along each axis, row by row, over a limit, over the motion.

The limit that ends a window has the same colour in all of them. Between listed values there is
nothing, so that their windows are bars; those of a range are an area.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from tendon_cli import say
from tendon_cli.cube.choice_grid import (
    OverMotion,
    over_motion,
    position,
    pretension_name,
    served_words,
    upper_ends,
    value_text,
)
from tendon_cli.cube.columns import ColumnArray
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import number, plain, reading_unit
from tendon_cli.errors import UsageError
from tendon_cli.figures.answer_page import (
    answer_page,
    choice_text,
    gauge_text,
    long_axes,
    set_text,
    star,
)
from tendon_cli.figures.backend import Axes, Patch
from tendon_cli.figures.frame import Page, fitted, grid_shape, panels_of
from tendon_cli.figures.layout import MOST_NAMES, MOST_NUMBERS, is_of_rows, numbers_that_vary
from tendon_cli.figures.motion_marks import cell_edges, ends_key, hatch_ends
from tendon_cli.figures.scales import Scale, axis_scale, scale_of_names
from tendon_cli.figures.style import (
    FAINT,
    INK,
    MARKERS,
    NO_WINDOW,
    PAGE_WIDTH,
    STAR,
    WHOLE,
    WINDOW,
    Colour,
    key_line,
    largest,
    limit_colours,
)
from tendon_cli.model.kinematics import Array
from tendon_cli.studies import limit_phrases
from tendon_cli.studies.space.axis import Axis, evenly_spaced
from tendon_cli.verbs.answer_record import AnswerRecord, ChoiceRecord, TradeOffRecord, value_of

_PANELS_OF_PAGE = 6
_MOST_POINTS = 20_000
"""Largest number of points of a panel."""
_SINGLE_MARKERS = 400
"""Points up to which each is drawn large."""
_ROOM = 1.15
"""Height of a panel over its largest value, as a factor."""
_MEANING_OF_POINTS = (
    "Above zero: the width of the window of pretension; below: by how much the limits miss each "
    "other. Colour: the limit at the upper end."
)
_POINT: dict[str, Any] = {"marker": "o", "linestyle": "", "markersize": 4.0, **WHOLE}
_ENDS = ("pretension_from", "pretension_to", "from_by", "to_by")
_AT_PLACE = "#e3eef6"
_WORKS = "#8fbfe0"
_END: dict[str, Any] = {"marker": "o", "linestyle": "", "markersize": 4.0, "zorder": 4, **WHOLE}
_WINDOW_END: dict[str, Any] = {
    "color": "white",
    "marker": "D",
    "markeredgecolor": INK,
    "markersize": 5.5,
    "linestyle": "",
    **WHOLE,
}


class Windows(NamedTuple):
    """Ends of windows along an axis, N, and the limits that set them."""

    low: Array
    """Lower ends; NaN where no pretension balances the arm."""
    high: Array
    """Upper ends; infinite where nothing bounds a window."""
    lower: ColumnArray
    """Names of the limits that set the lower ends, "" for none."""
    upper: ColumnArray

    @classmethod
    def of(cls, read: Mapping[str, ColumnArray]) -> Windows:
        """Return the windows of columns of choices, in which an end that nothing sets is NaN."""
        low, high, lower, upper = (read[name] for name in _ENDS)
        return cls(low, upper_ends(low, high), lower, upper)

    @property
    def limits(self) -> list[str]:
        """Names of the limits that set an end, each once."""
        return [str(name) for name in dict.fromkeys([*self.lower, *self.upper]) if name]


# --- One panel of windows -------------------------------------------------------------------------


def draw_panel(
    panel: Axes,
    scale: Scale,
    windows: Windows,
    colours: Mapping[str, Colour],
    most: float | None = None,
) -> None:
    """Draw windows over an axis: bars of listed values, an area of a range.

    Args:
        panel: The panel.
        scale: The axis.
        windows: Windows in the order of the scale.
        colours: Colours of the limits that end them.
        most: Another value for which the panel has room, N.
    """
    x = scale.places
    low, high, lower, upper = windows
    top = _top(windows, most or 0.0)
    roof = np.where(np.isinf(high), top, high)
    is_window = low <= roof
    is_gap = ~is_window & ~np.isnan(low)
    for holds, fill in ((is_window, WINDOW), (is_gap, NO_WINDOW)):
        if scale.names and holds.any():
            panel.vlines(
                x[holds], low[holds], roof[holds], color=fill, linewidth=6.0, gid="windows"
            )
        elif holds.any():
            where = holds.tolist()
            panel.fill_between(x, low, roof, where=where, facecolor=fill, interpolate=True)
    for all_ends, by in ((low, lower), (high, upper)):
        ends = np.where((all_ends >= 0.0) & (all_ends <= top), all_ends, np.nan)
        for marker, (name, colour) in zip(
            itertools.cycle(MARKERS[1:]), colours.items(), strict=False
        ):
            holds = np.asarray(by == name)
            style: dict[str, Any] = {"color": colour, "gid": name}
            size = _END["markersize"]
            if not scale.names:
                joined = holds.copy()
                joined[1:] |= holds[:-1]  # up to the next value, at which another limit binds
                panel.plot(x, np.where(joined, ends, np.nan), **style)
                size = 2.5
            panel.plot(
                x[holds], ends[holds], **{**_END, "marker": marker, "markersize": size}, **style
            )
    unknown = x[np.isnan(low)]
    panel.plot(unknown, 0.0 * unknown, color=FAINT, marker="x", linestyle="", **WHOLE)
    panel.set_ylim(0.0, top)


def _top(windows: Windows, most: float) -> float:
    """Return the upper edge of a panel: above all windows, or without any above all ends, N.

    Where there is no window, a lower end may be as far up as it likes.
    """
    low, high, _, _ = windows
    is_window = low <= high
    highest = largest([*low, *high, most])
    if is_window.any():
        highest = min(highest, 1.5 * largest([*low[is_window], *high[is_window], most]))
    return _ROOM * highest or 1.0


def window_key(
    parts: Sequence[Windows],
    colours: Mapping[str, Colour],
    bounds: limit_phrases.LimitValues,
    meaning: str,
    none: str = "no pretension works, whatever the limits",
) -> list[Any]:
    """Return the key of panels of windows.

    Args:
        parts: Windows of each panel.
        colours: Colours of the limits.
        bounds: Limits of the study, SI; None for one that differs between choices.
        meaning: Text of the area of a window.
        none: Text of the cross where there are no ends.
    """
    key: list[Any] = [Patch(facecolor=WINDOW, label=meaning)]
    if any((part.low > part.high).any() for part in parts):
        key.append(Patch(facecolor=NO_WINDOW, label="no window: the lower limit is above"))
    if any(np.isnan(part.low).any() for part in parts):
        key.append(key_line(color=FAINT, marker="x", linestyle="", label=none))
    for marker, (name, colour) in zip(itertools.cycle(MARKERS[1:]), colours.items(), strict=False):
        label = f"ends where: {_limit_label(name, bounds)}"
        key.append(key_line(color=colour, marker=marker, markersize=3.5, label=label))
    return key


def _limit_label(name: str, bounds: limit_phrases.LimitValues) -> str:
    """Return a limit in words; "no limit" for an end that nothing sets."""
    return limit_phrases.limit_words(name, bounds).label if name else "no limit"


def _pretension_label(cube: Cube) -> str:
    return f"{pretension_name(cube.document)} ({reading_unit(cube.document)})"


# --- Along each choice ----------------------------------------------------------------------------


class Along(NamedTuple):
    """Windows of some choices along an axis."""

    scale: Scale
    windows: Windows
    """In the order of the scale."""
    title: str
    best: int
    """Place of the choice named first."""


def draw_windows(cube: Cube, record: AnswerRecord, chosen: ChoiceRecord) -> list[Page]:
    """Draw the window against each axis, all else as in the choice named first.

    Returns:
        The pages; none if no axis of numbers has more than one value, or no window a known end.
    """
    parts = []
    for axis in long_axes(cube):
        if axis.is_text:
            continue
        scale = axis_scale(cube, axis, slice(None), {}, has_cells=True)
        at = {other.column: position(other, value_of(chosen, other.column)) for other in cube.axes}
        texts = [
            value_text(cube, other, other.values[at[other.column][0]])
            for other in cube.axes
            if other is not axis
        ]
        best = int(np.flatnonzero(scale.order == at[axis.column])[0])
        rows = cube.rows([axis.column], at | {axis.column: scale.order.astype(np.int64)})
        windows = Windows.of(cube.gather(rows, _ENDS))
        parts.append(Along(scale, windows, ", ".join(texts), best))
    if not any(np.isfinite([part.windows.low, part.windows.high]).any() for part in parts):
        return []
    meaning = f"window: pretensions that work for {served_words(record)}"
    notes = ["Windows of other choices may differ."]
    return _window_pages(cube, record, chosen, parts, "the window of pretension", meaning, notes)


def _window_pages(
    cube: Cube,
    record: AnswerRecord,
    chosen: ChoiceRecord,
    parts: Sequence[Along],
    title: str,
    meaning: str,
    notes: Sequence[str] = (),
    height: float = 62.0,
) -> list[Page]:
    """Draw windows along each of some axes in a panel of a height in mm."""
    pretension = chosen.pretension if chosen.feasible else None
    colours = limit_colours(name for part in parts for name in part.windows.limits)
    key = window_key([part.windows for part in parts], colours, cube.limits, meaning)
    if pretension is not None:
        key.append(star(set_text(cube, record, chosen)))
    pages = []
    for start in range(0, len(parts), _PANELS_OF_PAGE):
        seen = parts[start : start + _PANELS_OF_PAGE]
        rows, columns = grid_shape(len(seen), most=2)
        width = PAGE_WIDTH / columns - 15.0
        names = max(part.scale.height_of_names(width) for part in seen)
        page = answer_page(cube, record, title, rows * (height + names), key, notes)
        for panel, part in zip(panels_of(page, rows, columns, len(seen)), seen, strict=True):
            draw_panel(panel, part.scale, part.windows, colours, pretension)
            part.scale.apply(panel, "x", width)
            panel.set_xlabel(fitted(part.scale.label, width))
            panel.set_title(fitted(part.title, width), y=1.0)
            panel.set_ylabel(_pretension_label(cube))
            if pretension is not None:
                panel.plot([part.scale.places[part.best]], [pretension], gid="best", **STAR)
        pages.append(page)
    return pages


# --- Row by row -----------------------------------------------------------------------------------


def draw_rows(cube: Cube, record: AnswerRecord, chosen: ChoiceRecord) -> list[Page]:
    """Draw the windows of all choices: by name if they are few, else as points over each number.

    Points are never joined, because there is nothing between two rows.

    Args:
        cube: Choices of the answer.
        record: Record of the answer.
        chosen: The choice that the answer names first.

    Returns:
        The page; none if no table of rows is among the choices.
    """
    axes = long_axes(cube)
    if cube.table is None or not any(map(is_of_rows, axes)):
        return []
    count = cube.table.rows
    if count > MOST_NAMES:
        return [_draw_points(cube, record, chosen, count)]
    texts = [
        [str(value) if axis.is_text else value_text(cube, axis, value) for value in axis.values]
        for axis in axes
    ]
    names = [", ".join(words) for words in itertools.product(*texts)]
    rows = np.arange(count)
    windows = Windows.of(cube.gather(rows, _ENDS))
    part = Along(scale_of_names("", names, rows), windows, "", chosen.choice)
    title = "the window of each choice"
    return _window_pages(cube, record, chosen, [part], title, "window of pretension", height=90.0)


def _draw_points(cube: Cube, record: AnswerRecord, chosen: ChoiceRecord, count: int) -> Page:
    """Draw the width of each window over each number that varies, coloured by its upper end."""
    rows = evenly_spaced(count, _MOST_POINTS)
    columns = numbers_that_vary(cube)
    drawn = columns[:MOST_NUMBERS]
    read = cube.gather(rows, [*_ENDS, *drawn])
    part = Windows.of(read)
    with np.errstate(invalid="ignore"):
        width = part.high - part.low
    top = 1.1 * largest(width) or 1.0
    notes = [_MEANING_OF_POINTS]
    if np.isinf(width).any():
        notes.append("Windows without an upper end stand at the upper edge.")
    width = np.minimum(width, top)
    colours = limit_colours(str(name) for name in np.unique(part.upper))
    key: list[Any] = [
        key_line(color=colour, label=_limit_label(name, cube.limits), **_POINT)
        for name, colour in colours.items()
    ]
    if chosen.feasible:
        key.append(star(set_text(cube, record, chosen)))
    told = [f"each point is one of {count:,} choices"]
    if len(rows) < count:
        told = [f"Shown: {len(rows):,} of {count:,} choices, evenly spaced"]
    if len(drawn) < len(columns):
        told.append(f"over {len(drawn)} of the {len(columns)} numbers that vary")
    lost = int(np.isnan(width).sum())
    if lost:
        told.append(f"not drawn: {say.counted(lost, 'choice')} without any pretension that works")
    lines, in_row = grid_shape(len(drawn), most=3)
    title = "the window of each choice"
    page = answer_page(cube, record, title, 58.0 * lines, key, notes, subtitle="; ".join(told))
    panels = panels_of(page, lines, in_row, len(drawn), sharey=True)
    size = 3.5 if len(rows) <= _SINGLE_MARKERS else 1.8
    for panel, column in zip(panels, drawn, strict=True):
        shown = cube.shown(column)
        x = shown.scaled(np.where(np.isinf(read[column]), np.nan, read[column]))
        for name, colour in colours.items():
            holds = part.upper == name
            panel.plot(x[holds], width[holds], color=colour, **{**_POINT, "markersize": size})
        panel.axhline(0.0, color=FAINT, linewidth=0.6)
        panel.set_xlabel(fitted(shown.label, PAGE_WIDTH / in_row - 15.0))
        panel.set_ylabel(f"width of the window ({reading_unit(cube.document)})")
        at = np.flatnonzero(rows == chosen.choice)
        if chosen.feasible and len(at):
            panel.plot(x[at], width[at], gid="best", **STAR)
    return page


# --- Over a limit ---------------------------------------------------------------------------------


def draw_trade_off(
    cube: Cube,
    record: AnswerRecord,
    trade_off: TradeOffRecord,
    column: str,
    width: float = PAGE_WIDTH,
    height: float | None = None,
) -> Page:
    """Draw window and tension of the best choice with each value of a limit.

    Args:
        cube: Choices of the answer.
        record: Record of the answer.
        trade_off: Best choices along the limit, or along rows that set it.
        column: Column along x: that of the trade-off, or a limit that its rows set.
        width: Width of the page, mm.
        height: Height of the page, mm; None for the usual one.

    Raises:
        UsageError: No choice has a window.
    """
    axis = cube.axis(trade_off.column)
    if axis is None or not any(trade_off.best):
        raise UsageError("no choice has a window, whichever limit is taken", where="--x")
    order, names, label = _places(cube, axis, column)
    choices = [trade_off.best[place] for place in order]
    others = [
        ", ".join(
            value_text(cube, other, value_of(choice, other.column))
            for other in long_axes(cube)
            if choice is not None and other is not axis
        )
        for choice in choices
    ]
    if len(set(filter(None, others))) > 1:
        pairs = zip(names, others, strict=True)
        names = [": ".join(filter(None, pair)) for pair in pairs]
    scale = scale_of_names(label, names, order)
    part = Windows.of({name: _column(choices, name) for name in _ENDS})
    pretension = _column(choices, "pretension")
    colours = limit_colours(part.limits)
    meaning = f"window that works for {served_words(record)}"
    key = window_key([part], colours, cube.limits, meaning, "no choice has a window")
    key.append(key_line(label="pretension to set", color=INK, **_END))
    best = record.best
    at = [
        place
        for place, choice in enumerate(choices)
        if choice is not None and best is not None and choice.choice == best.choice
    ]
    if at and best is not None:
        key.append(star(f"named first among all: {gauge_text(record, best) or 'to set'}"))
    named = "is the best compromise" if len(record.goals) > 1 else "would be named first"
    if axis.is_text:
        title = f"what each {plain(axis.key)} gives"
        note = f"{named} with this {plain(axis.key)} alone"
    else:
        title = f"what the {limit_phrases.limit_on(axis.key.partition('.')[2])} buys"
        note = f"{named} if the limit had this value alone"
    notes = [f"Window and tension are those of the choice that {note}."]
    total = 104.0 + scale.height_of_names(width - 20.0)
    page = answer_page(cube, record, title, total, key, notes, width=width, height=height)
    panels = panels_of(page, 2, 1, 2, sharex=True, height_ratios=[3.0, 2.0])
    draw_panel(panels[0], scale, part, colours, largest(pretension))
    panels[0].set_ylabel(_pretension_label(cube))
    tension = cube.shown("max_tension")
    tensions = tension.scaled(_column(choices, "max_tension"))
    for panel, values in zip(panels, (pretension, tensions), strict=True):
        panel.plot(scale.places, values, color=INK, gid="best of each", **_END)
        if at:
            panel.plot(scale.places[at], values[at], gid="best", **STAR)
    panels[1].set_ylabel(tension.label)
    panels[1].set_ylim(0.0, _ROOM * largest(tensions))  # from 0: a millinewton is no step
    scale.apply(panels[1], "x", width - 20.0, cells=True)
    panels[1].set_xlabel(scale.label)
    return page


def _places(cube: Cube, axis: Axis, column: str) -> tuple[Any, list[str], str]:
    """Return the order of the values of a trade-off, their names, and the label of their axis.

    Rows of a table stand in the order of the limit that they set, if `column` asks for it.
    """
    if column != axis.column:
        _, of_rows = cube.columns_of_names[column]
        if not np.isnan(of_rows.values).any():
            limit = cube.shown(of_rows.column)
            order = np.argsort(of_rows.values, kind="stable")
            names = [f"{limit.text(of_rows.values[row])} ({axis.names[row]})" for row in order]
            return order, names, limit.titled
    scale = axis_scale(cube, axis, slice(None), {}, has_cells=True)
    listed = [number(place) for place in scale.places.tolist()]
    return scale.order, list(scale.names) or listed, scale.label


def _column(choices: Iterable[ChoiceRecord | None], column: str) -> ColumnArray:
    """Return a column of choices, SI; NaN or "" without a choice or a value."""
    values = [None if choice is None else value_of(choice, column) for choice in choices]
    if column in ("from_by", "to_by"):
        return np.array([value or "" for value in values], dtype=object)
    return np.array(values, dtype=np.float64)


# --- Over the motion ------------------------------------------------------------------------------


def draw_between(cube: Cube, record: AnswerRecord, chosen: ChoiceRecord) -> list[Page]:
    """Draw the bounds that limits set on the pretension at each angle or time.

    Args:
        cube: Choices of the answer.
        record: Record of the answer.
        chosen: The choice that the answer names first.

    Returns:
        The page; none if the answer has no window over the motion.
    """
    drawn = over_motion(record)
    if drawn is None:
        return []
    floor, roof = drawn.tightest
    colours = limit_colours(name for bounds in drawn.ends for name in bounds)
    lines = [(name, values) for bounds in drawn.ends for name, values in bounds.items()]
    in_picture = {name for name, values in lines if (drawn.shown(values) > 0.0).any()}
    key: list[Any] = [
        key_line(color=colour, label=limit_phrases.limit_words(name, cube.limits).label)
        for name, colour in colours.items()
        if name in in_picture
    ]
    window, at_place = drawn.works
    key.append(key_line(color=INK, linewidth=2.2, label=f"thick: binds at that {drawn.word}"))
    if len(drawn.samples):
        key.append(key_line(color=INK, label="angle of the study", **_POINT))
    key.append(Patch(facecolor=_WORKS, label=f"window: {window}"))
    key.append(Patch(facecolor=_AT_PLACE, label=at_place))
    if not drawn.does_count.all():
        key.append(ends_key())
    unit = reading_unit(cube.document)
    ends = [_end_of_window(drawn, chosen, end, unit) for end in ("from", "to")]
    label = f"ends of the window: {' '.join(text for text, _, _ in ends)}"
    key.append(key_line(label=label, **_WINDOW_END))
    pretension = chosen.pretension
    if pretension is not None:
        key.append(star(gauge_text(record, chosen) or "pretension to set"))
    text = choice_text(cube, chosen)
    title = "the window over time" if drawn.is_in_time else "the window over the angle"
    page = answer_page(cube, record, title, 92.0, key, [*drawn.texts], subtitle=text)
    (panel,) = panels_of(page, 1, 1, 1)
    has_window = (floor <= roof).tolist()
    panel.fill_between(
        drawn.along,
        floor,
        np.minimum(roof, drawn.top),
        where=has_window,
        color=_AT_PLACE,
        linewidth=0.0,
        zorder=0.5,
    )
    low, high = drawn.window
    panel.axhspan(low, min(high, drawn.top), color=_WORKS, linewidth=0.0, zorder=0.9)
    first = float(drawn.along[0])
    last = float(drawn.along[-1])
    panel.set_xlim((first, last) if first < last else (first - 1.0, last + 1.0))
    panel.set_ylim(0.0, drawn.top)
    panel.set_xlabel(fitted(drawn.axis_label, PAGE_WIDTH))
    panel.set_ylabel(_pretension_label(cube))
    for end, bounds, tightest, samples in zip(
        ("from", "to"), drawn.ends, drawn.tightest, drawn.at_samples, strict=True
    ):
        for name, values in bounds.items():
            shown = drawn.shown(values)
            binding = np.where(values == tightest, shown, np.nan)
            style: dict[str, Any] = {"color": colours[name]}
            panel.plot(drawn.along, shown, linewidth=0.9, gid=f"{end} {name}", **style)
            panel.plot(drawn.along, binding, linewidth=2.2, zorder=3, gid="binds", **style)
        panel.plot(
            drawn.samples, samples, "o", color=INK, gid="samples", markersize=2.4, zorder=4, **WHOLE
        )
    if not drawn.does_count.all():
        hatch_ends(panel, ~drawn.does_count, cell_edges(drawn.along))
    if pretension is not None:
        panel.axhline(pretension, color=FAINT, linewidth=0.8, linestyle=(0, (4, 3)))
        panel.plot([drawn.along[0]], [pretension], gid="best", **STAR)
    for _, place, value in ends:
        if place is not None:
            panel.plot([place], [value], zorder=6, **_WINDOW_END)
    return [page]


def _end_of_window(
    drawn: OverMotion, chosen: ChoiceRecord, end: str, unit: str
) -> tuple[str, float | None, float]:
    """Return an end of the window ("from" or "to") in words, where it binds, and its value.

    An end that no state sets, such as the smallest pretension at all, binds nowhere.
    """
    value = drawn.window[("from", "to").index(end)]
    if not np.isfinite(value):
        return "no upper end", None, value
    text = f"{end} {say.number(value)} {unit}"
    stated = value_of(chosen, f"{end}_{drawn.place}")
    if stated is None:
        return text, None, value
    place = float(stated) if drawn.is_in_time else float(np.degrees(stated))
    return f"{text} (at {say.number(place, 3)}{' s' if drawn.is_in_time else '°'})", place, value
