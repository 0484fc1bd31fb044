"""Trade-off of an answer: window and tension of the best choice with each value of a limit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.answer_record import AnswerRecord, ChoiceRecord, TradeOffRecord, as_answer, value_of
from tendon_cli.cube.choice_grid import pretension_name, served_words, value_text
from tendon_cli.cube.columns import column_named
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import plain, reading_unit
from tendon_cli.errors import UsageError
from tendon_cli.figures.backend import Axes, Line2D, Patch
from tendon_cli.figures.choice_maps import answer_page, star
from tendon_cli.figures.frame import Page, turn_names
from tendon_cli.figures.scales import Scale, axis_scale
from tendon_cli.figures.style import (
    FAINT,
    INK,
    OKABE_ITO,
    PAGE_WIDTH,
    hatch_key,
    house_style,
    text_width,
    unknown_hatch,
)
from tendon_cli.space.axis import Axis
from tendon_cli.units import shorten

_WINDOW = "#b4d4ea"
_MOST_COLOURS = 6
"""Most choices that differ in colour."""
_PANEL = 62.0
"""Height of the panel of windows, mm."""
_LOWER_PANEL = 42.0
"""Height of the panel of tensions, mm."""
_SIDES = 15.0
"""Width of the labels beside the panels, mm."""
_ROOM = 1.15
"""Height of a panel over its largest value, as a factor."""
_MOST_NAMES = 12
"""Most rows whose names stand above their values."""
_NAME_SIZE = 6.5
"""Size of these names, pt."""
_HALF_BAR = 0.3
"""Half the width of a bar, as a share of the distance between two values."""

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class _Along:
    """Best choices along an axis, by the places of its values."""

    scale: Scale
    choices: tuple[ChoiceRecord | None, ...]
    """Best choice at each place of the scale; None where no choice has a window."""
    others: tuple[str, ...]
    """Choice on all other axes in words; empty where no choice has a window."""
    names: tuple[str, ...]
    """Names of rows at the places of the limit that they set; empty for an axis."""
    is_joined: bool
    """True for values of an axis, between which lines may be drawn."""

    def values(self, column: str) -> Floats:
        """Return a column of the best choices, SI; NaN without a value."""
        values = [None if choice is None else value_of(choice, column) for choice in self.choices]
        return np.array([np.nan if value is None else value for value in values], dtype=np.float64)

    @property
    def has_window(self) -> npt.NDArray[np.bool_]:
        """True where a choice has a window."""
        return np.array([choice is not None for choice in self.choices])


def draw_trade_off(
    choices: Cube,
    record: Mapping[str, Any],
    x: str,
    out: Path | None,
    *,
    width: float = PAGE_WIDTH,
    height: float | None = None,
    form: str = "png",
    overwrite: bool = False,
) -> Path:
    """Draw the trade-off of an answer along a limit.

    Args:
        choices: Choices of the answer.
        record: Record of the answer.
        x: Key or column of the limit, or of the table whose rows set it.
        out: The file; by default in the working directory, named after the study.
        width: Width of the page, mm.
        height: Height of the page, mm; None for the usual one.
        form: Format of the file if `out` does not say it.
        overwrite: True to replace a file that tendon did not write.

    Raises:
        UsageError: The answer has no such trade-off, or tendon did not write the file.
    """
    answer = as_answer(record)
    column = column_named(x)
    trade_off = _find(choices, answer, column)
    with house_style(say.joint_name(record)):
        page = trade_off_page(choices, answer, trade_off, column, width, height)
    name = f"{record['name']}-{column.removeprefix('limit_')}.{form}"
    return page.of_joint(record).save(out or Path(name), overwrite=overwrite)


def _find(cube: Cube, record: AnswerRecord, column: str) -> TradeOffRecord:
    """Return the trade-off along the column of a limit; raise UsageError if there is none."""
    axis = cube.axis(column)
    if axis is None and column in cube.columns_of_names:
        axis, _ = cube.columns_of_names[column]
    known = {trade_off.column: trade_off for trade_off in record.trade_offs}
    if axis is not None and axis.column in known:
        return known[axis.column]
    keys = [trade_off["key"] for trade_off in known.values()]
    hint = f"limits on which its choices differ: {', '.join(keys)}"
    if not keys:
        example = '[limits] max_tension = ["300 N", "400 N"]'
        hint = f"no limit has several values in this answer, as in {example}"
    problem = f"the answer has no trade-off along {shorten(column)}"
    raise UsageError(problem, where="--x", hint=hint)


def draw_first_trade_off(cube: Cube, record: AnswerRecord, _chosen: ChoiceRecord) -> Page | None:
    """Draw the trade-off along the first limit on which choices differ; None if there is none."""
    drawn = [of_limit for of_limit in record["trade_offs"] if any(of_limit["best"])]
    return trade_off_page(cube, record, drawn[0], drawn[0]["column"]) if drawn else None


def trade_off_page(
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
        trade_off: Best choices along the limit.
        column: Column along x: that of the trade-off, or a limit that its rows set.
        width: Width of the page, mm.
        height: Height of the page, mm; None for the usual one.

    Raises:
        UsageError: No choice has a window.
    """
    axis = cube.axis(trade_off["column"])
    if axis is None or not any(trade_off["best"]):
        raise UsageError("no choice has a window, whichever limit is taken", where="--x")
    along = _along(cube, axis, trade_off, column)
    colours = _colours(along.others)
    meaning = f"window that works for {served_words(record)}"
    key: list[Any] = [Patch(facecolor=_WINDOW, label=meaning)]
    key.append(Line2D([], [], label="pretension to set", **_point(INK)))
    if not along.has_window.all():
        key.append(hatch_key("no choice has a window"))
    key += [Line2D([], [], label=text, **_point(colour)) for text, colour in colours.items()]
    best = record["best"]
    place_of_best = _place_of(along, best)
    if place_of_best is not None:
        key.append(star(label="named first among all values"))
    notes = [_meaning(record)]
    if len(set(filter(None, along.others))) > _MOST_COLOURS:
        notes.append("The choices differ in more than colours can show.")
    page = answer_page(
        cube,
        record,
        f"what the {_name(axis)} buys",
        _PANEL + _LOWER_PANEL,
        key,
        notes,
        width=width,
        height=height,
    )
    ratios = {"height_ratios": [_PANEL, _LOWER_PANEL]}
    upper, lower = page.figure.subplots(2, 1, sharex=True, gridspec_kw=ratios)
    _draw_windows(upper, along, colours, width - _SIDES)
    unit = reading_unit(cube.document)
    upper.set_ylabel(f"{pretension_name(cube.document)} ({unit})")
    shown = cube.shown("max_tension")
    tension = shown.scaled(along.values("max_tension"))
    _draw_points(lower, along, tension, colours)
    lower.set_ylabel(shown.label)
    if place_of_best is not None:
        _mark_best((upper, lower), along, colours, place_of_best)
    lower.set_ylim(0.0, _ROOM * float(np.nanmax(tension)))  # from 0: a millinewton is no step
    along.scale.apply(lower, "x", cells=True)
    turn_names(lower.xaxis, width - _SIDES)
    lower.set_xlabel(axis.column if along.scale.names else along.scale.label)
    return page


def _meaning(record: AnswerRecord) -> str:
    """Say which choice is drawn at each value of the limit."""
    named = "would be named first"
    if len(record["goals"]) > 1:
        named = "is the best compromise"
    return (
        f"Window and tension are those of the choice that {named} if the limit had this value"
        " alone."
    )


def _name(axis: Axis) -> str:
    """Return the name of a limit, or of the table that sets it, in a title."""
    return axis.key if axis.is_text else say.limit_on(axis.key.partition(".")[2])


def _along(cube: Cube, axis: Axis, trade_off: TradeOffRecord, column: str) -> _Along:
    """Return the best choices in the order of the places of their values.

    Rows of a table have the places of the limit that they set, if `column` asks for it.
    """
    shown = axis
    names: tuple[str, ...] = ()
    if column != axis.column:
        _, of_rows = cube.columns_of_names[column]
        if not np.isnan(of_rows.values).any():
            shown = of_rows
            names = axis.names
    scale = axis_scale(cube, shown, slice(None), {}, is_log=False)
    choices = tuple(trade_off["best"][place] for place in scale.order.tolist())
    others = tuple(
        "" if choice is None else _others(cube, axis, choice) or "the design" for choice in choices
    )
    in_order = tuple(plain(names[place]) for place in scale.order.tolist()) if names else ()
    shown_names = in_order if len(names) <= _MOST_NAMES else ()
    return _Along(scale, choices, others, shown_names, is_joined=not axis.is_text)


def _others(cube: Cube, axis: Axis, choice: ChoiceRecord) -> str:
    """Say what a choice is on all other axes of more than one value."""
    return ", ".join(
        value_text(cube, other, value_of(choice, other.column))
        for other in cube.axes
        if other is not axis and len(other) > 1
    )


def _colours(others: Sequence[str]) -> dict[str, str]:
    """Return a colour for each different choice; none for one choice, or too many."""
    different = list(dict.fromkeys(text for text in others if text))
    if not 1 < len(different) <= _MOST_COLOURS:
        return {}
    return {text: OKABE_ITO[place % len(OKABE_ITO)] for place, text in enumerate(different)}


def _point(colour: str) -> dict[str, Any]:
    """Return the style of a point."""
    return {"color": colour, "marker": "o", "linestyle": "", "markersize": 4.0}


def _have_room(along: _Along, width: float) -> bool:
    """Return True if the names of rows fit side by side above a panel of a width in mm."""
    if not along.names:
        return False
    first, last = along.scale.limits(cells=True)
    per_unit = width / (last - first)
    at = per_unit * along.scale.places  # mm
    halves = np.array([0.5 * text_width(name, _NAME_SIZE) for name in along.names])
    is_apart = np.diff(at) > halves[:-1] + halves[1:] + 1.0
    is_inside = (at - per_unit * first > halves) & (per_unit * last - at > halves)
    return bool(is_apart.all() and is_inside.all())


def _draw_windows(panel: Axes, along: _Along, colours: Mapping[str, str], width: float) -> None:
    """Draw the window of each value as a bar, and the pretension to set as a point in it.

    Names of rows stand above the bars if they have room in the width of the panel, mm.
    """
    low = along.values("pretension_from")
    high = along.values("pretension_to")
    pretension = along.values("pretension")
    top = _ROOM * float(np.nanmax([low, high, pretension]))
    places = along.scale.places
    edges = along.scale.edges
    half = _HALF_BAR * float(np.diff(edges).min())
    for cell, is_open in enumerate(along.has_window):
        if not is_open and along.is_joined:
            panel.axvspan(edges[cell], edges[cell + 1], **unknown_hatch())
        elif not is_open:
            panel.axvspan(places[cell] - half, places[cell] + half, **unknown_hatch())
    roof = np.where(np.isnan(high), top, high)
    has_window = along.has_window
    panel.bar(
        places[has_window],
        (roof - low)[has_window],
        2.0 * half,
        low[has_window],
        color=_WINDOW,
        gid="windows",
    )
    panel.set_ylim(0.0, top)
    if _have_room(along, width):
        for place, name in zip(places, along.names, strict=False):
            panel.annotate(
                name,
                (place, 1.0),
                (0.0, 2.0),
                xycoords=("data", "axes fraction"),
                textcoords="offset points",
                ha="center",
                size=_NAME_SIZE,
            )
    _draw_points(panel, along, pretension, colours)


def _draw_points(panel: Axes, along: _Along, values: Floats, colours: Mapping[str, str]) -> None:
    """Draw a value of each best choice as a point in the colour of the choice."""
    of_each = np.array([colours.get(text, INK) for text in along.others])
    for colour in dict.fromkeys(of_each.tolist()):
        of_colour = np.where(of_each == colour, values, np.nan)
        if along.is_joined:
            panel.plot(along.scale.places, of_colour, color=FAINT, linewidth=0.8, zorder=2)
        panel.plot(along.scale.places, of_colour, zorder=3, **_point(colour))


def _place_of(along: _Along, best: ChoiceRecord | None) -> int | None:
    """Return the place of the choice that the answer names first; None if it is not drawn.

    That choice need not be the first at its own value.
    """
    if best is None:
        return None
    of_places = [None if choice is None else choice["choice"] for choice in along.choices]
    return of_places.index(best["choice"]) if best["choice"] in of_places else None


def _mark_best(panels: Sequence[Axes], along: _Along, colours: Mapping[str, str], at: int) -> None:
    """Mark the choice at a place, named first in the answer, in both panels."""
    colour = colours.get(along.others[at], INK)
    style: dict[str, Any] = {"color": colour, "markeredgecolor": INK, "markersize": 10}
    for panel in panels:
        for line in panel.lines:
            values = np.asarray(line.get_ydata(), dtype=np.float64)
            if line.get_linestyle() == "None" and not np.isnan(values[at]):
                place = along.scale.places[at]
                panel.plot([place], [values[at]], marker="*", zorder=5, **style)
                break
