"""Figures of an answer: maps over two choices, the window along each choice, and the front."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.answer_record import (
    AnswerRecord,
    ChoiceRecord,
    as_answer,
    named_first,
    value_of,
)
from tendon_cli.cube.choice_grid import pretension_name, served_words
from tendon_cli.cube.cube import Cube, choices_of
from tendon_cli.cube.labels import ColumnLabel, plain, reading_unit
from tendon_cli.errors import UsageError
from tendon_cli.figures.backend import Axes, FigureCanvasAgg, Line2D, Patch
from tendon_cli.figures.choice_maps import (
    Slice,
    answer_page,
    draw_served,
    draw_tolerance,
    is_settable,
    long_axes,
    place_of,
    set_text,
    settable_label,
    star,
)
from tendon_cli.figures.frame import Page, grid_shape, save_pages
from tendon_cli.figures.layout import has_many_rows, is_of_rows
from tendon_cli.figures.row_figures import draw_rows
from tendon_cli.figures.served import draw_population
from tendon_cli.figures.style import INK, OKABE_ITO, broken, hatch_key, house_style, unknown_hatch
from tendon_cli.figures.trade_off import draw_first_trade_off
from tendon_cli.figures.window_over_motion import draw_between
from tendon_cli.registry import by_name
from tendon_cli.space.axis import Axis, evenly_spaced
from tendon_cli.studies.study import Study
from tendon_cli.tables.read import open_table

_WINDOW = "#b4d4ea"
_CHOICE = "#b8c4cc"
_LOWER = OKABE_ITO[1]
_UPPER = OKABE_ITO[0]
_MOST_PANELS = 4
"""Largest number of axes along which the window is drawn."""
_MOST_POINTS = 20_000
"""Largest number of choices drawn next to the front."""
_NOT_SETTABLE: dict[str, Any] = {
    "color": _CHOICE,
    "marker": "o",
    "linestyle": "",
    "markersize": 3.5,
    "markerfacecolor": "none",
}
"""Style of a choice that cannot be set well enough: hollow."""
_IS_SETTABLE = {**_NOT_SETTABLE, "markerfacecolor": _CHOICE}
_FAR_RIGHT = 0.7
"""Share of a panel's width from which names stand to the left of their points."""
_MOST_TOLD = 12
"""Most choices of a front next to which their tolerance is written."""
_LABEL_SIZE = 6.5
"""Size of the names of limits, pt."""
_LABEL_GAP = 3.0
"""Distance of the name of a limit from its line, pt."""
_LETTER = 0.58
"""Mean width of a letter as a share of its size."""

Floats = npt.NDArray[np.float64]
AnswerFigure = Callable[[Cube, AnswerRecord, ChoiceRecord], Page | None]
"""Function that draws a figure of an answer, or returns None if there is nothing to draw."""


def draw_answer(
    study: Study, folder: Path, out: Path, record: Mapping[str, Any]
) -> tuple[list[str], list[str], None]:
    """Draw the figures of an answer, as far as there is something to draw.

    The figure `between` is drawn only on request, by `draw_between_samples`. A figure never costs
    an answer: errors are reported, not raised.

    Args:
        study: Study of the answer.
        folder: Folder of the answer, whose tables are complete.
        out: Folder of the figures.
        record: Record of the answer.

    Returns:
        The names of the files; a sentence for each figure that could not be drawn; and None, as no
        slack map is expected.
    """
    files: list[str] = []
    faults: list[str] = []
    cube = choices_of(open_table(folder / "choices.parquet", by_name(record)), study)
    for name in FIGURES:
        if name == "between":
            continue  # is drawn on request only
        try:
            page = answer_figure(name, cube, record)
            if page is not None:
                files.append(page.save(out / f"{name}.png").name)
        except Exception as error:  # noqa: BLE001
            faults.append(f"the figure {name} cannot be drawn: {type(error).__name__}: {error}")
    answer = as_answer(record)
    if answer["population"] is not None:
        pages = draw_population(folder, answer, record)
        files += [page.save(out / f"{name}.png").name for name, page in pages.items()]
    return files, faults, None


def draw_again(
    folder: Path,
    choices: Cube,
    record: Mapping[str, Any],
    out: Path | None,
    *,
    form: str = "png",
    overwrite: bool = False,
) -> list[Path]:
    """Draw the figures that stand beside the tables of an answer once more.

    Args:
        folder: Folder of the answer.
        choices: Choices of the answer.
        record: Record of the answer.
        out: Folder of the figures, by default the working directory, where they are named after the
            study; or the file, if there is a single figure.
        form: Format of the files.
        overwrite: True to replace files that tendon did not write.

    Returns:
        The files.

    Raises:
        UsageError: There is nothing to draw, or tendon did not write a file.
        OutputError: A file cannot be written.
    """
    pages: dict[str, Page] = {}
    for name in FIGURES:
        page = None if name == "between" else answer_figure(name, choices, record)
        if page is not None:
            pages[name] = page
    answer = as_answer(record)
    if answer["population"] is not None:
        pages |= draw_population(folder, answer, record)
    if not pages:
        hint = f"`tendon report {folder}` writes a page with what it says"
        raise UsageError("the answer has no figure to draw", where=str(folder), hint=hint)
    if out is None or out.is_dir():
        files = [(out or Path()) / f"{record['name']}-{name}.{form}" for name in pages]
    elif len(pages) == 1:
        files = [out]
    else:
        problem = f"{out.name} is one file, and the answer has {len(pages)} figures"
        raise UsageError(problem, where="--out", hint="name a folder that exists")
    return save_pages(list(zip(pages.values(), files, strict=True)), overwrite=overwrite)


def answer_figure(name: str, cube: Cube, record: Mapping[str, Any]) -> Page | None:
    """Draw one of FIGURES by its name. Return None if there is nothing to draw."""
    answer = as_answer(record)
    chosen = named_first(answer)
    if chosen is None:
        return None
    with house_style(say.joint_name(record)):
        page = FIGURES[name](cube, answer, chosen)
    return None if page is None else page.of_joint(record)


def draw_between_samples(
    choices: Cube, record: Mapping[str, Any], out: Path | None, *, overwrite: bool = False
) -> Path:
    """Draw the window over the angle for an answer.

    Args:
        choices: Choices of the answer.
        record: Record of the answer.
        out: The file; by default a PNG in the working directory, named after the study.
        overwrite: True to replace a file that tendon did not write.

    Raises:
        UsageError: The answer has no window over the angle, or tendon did not write the file.
    """
    page = answer_figure("between", choices, record)
    if page is None:
        problem = "the answer has no window, so none over the angle to draw"
        hint = "`tendon report` writes a page that says why, and what would help"
        raise UsageError(problem, where="--between", hint=hint)
    return page.save(out or Path(f"{record['name']}-between.png"), overwrite=overwrite)


# --- The window along each choice -----------------------------------------------------------------


def draw_windows(cube: Cube, record: AnswerRecord, chosen: ChoiceRecord) -> Page | None:
    """Draw the window against each axis, all else as in the choice named first.

    Returns:
        The page; None if no axis of numbers has more than one value, or no window a known end.
    """
    along = [axis for axis in long_axes(cube) if not axis.is_text][:_MOST_PANELS]
    parts = [Slice.of(cube, [axis], chosen) for axis in along]
    if not any(np.isfinite([part.low, part.high]).any() for part in parts):
        return None
    meaning = f"window: pretensions that work for {served_words(record)}"
    key: list[Any] = [Patch(facecolor=_WINDOW, label=meaning)]
    if any((part.low > part.high).any() for part in parts):
        key.append(hatch_key("no window: the lower limit lies above the upper one"))
    if chosen["feasible"]:
        key.append(star(label=f"recommended {pretension_name(cube.document)}"))
    note = (
        "The limit that sets an end of the window is written next to it. "
        "Windows of other choices may differ."
    )
    rows, columns = grid_shape(len(along), most=2)
    page = answer_page(cube, record, "the window of pretension", rows * 68.0, key, [note])
    grid = page.figure.subplots(rows, columns, squeeze=False)
    for panel, axis, part in zip(grid.flat, along, parts, strict=False):
        _draw_window(panel, part, chosen["pretension"] if chosen["feasible"] else None)
        panel.set_ylabel(f"{pretension_name(cube.document)} ({reading_unit(cube.document)})")
        if chosen["feasible"]:
            place = place_of(cube, axis, value_of(chosen, axis.column), part.scales[0])
            style: dict[str, Any] = {"color": INK, "markersize": 9, "clip_on": False}
            panel.plot([place], [chosen["pretension"]], marker="*", zorder=5, **style)
    for panel in list(grid.flat)[len(along) :]:
        panel.set_visible(False)
    FigureCanvasAgg(page.figure)
    page.figure.draw_without_rendering()  # so that transforms know how steep lines are
    for panel, part in zip(grid.flat, parts, strict=False):
        _name_limits(panel, part)
    return page


def _draw_window(panel: Axes, part: Slice, pretension: float | None) -> None:
    """Draw both ends of the window over one axis, and shade what lies between them.

    The panel has room for the pretension (N) of the choice that is starred, if there is one.
    """
    (x,) = part.scales
    low = part.low
    is_open = np.isinf(part.high)
    high = np.where(is_open, np.nan, part.high)
    known = [*low, *high, 0.0 if pretension is None else pretension]
    top = 1.2 * float(np.nanmax(known, initial=0.0)) or 1.0
    roof = np.where(is_open, top, high)
    fill: dict[str, Any] = {"interpolate": True, "step": None}
    window = (roof >= low).tolist()
    no_window = (roof <= low).tolist()
    panel.fill_between(x.places, low, roof, where=window, facecolor=_WINDOW, **fill)
    panel.fill_between(x.places, roof, low, where=no_window, **unknown_hatch(), **fill)
    marker = "o" if len(x.places) < 12 else ""
    panel.plot(x.places, low, color=_LOWER, marker=marker, markersize=2.5)
    panel.plot(x.places, high, color=_UPPER, marker=marker, markersize=2.5)
    x.apply(panel, "x")
    panel.set(ylim=(0.0, top), xlabel=x.label, title=part.title or " ")


def _name_limits(panel: Axes, part: Slice) -> None:
    """Name the limits that bind along the lower and the upper end of the window.

    A name goes outside of the window, clear of its line and of other names, once for each stretch
    along which one limit binds. Where the lower end lies above the upper one, names change sides.
    """
    boxes: list[Any] = []
    upward = np.where(part.low > part.high, -1.0, 1.0)
    _name_stretches(panel, part, part.low, part.columns["from_by"], _LOWER, -upward, boxes)
    _name_stretches(panel, part, part.high, part.columns["to_by"], _UPPER, upward, boxes)


def _name_stretches(
    panel: Axes,
    part: Slice,
    values: Floats,
    limits: npt.NDArray[Any],
    colour: str,
    sides: Floats,
    boxes: list[Any],
) -> None:
    """Name the limit of each stretch of a line, the longest stretch first.

    Each name is tried first where the window is widest.

    Args:
        panel: The panel.
        part: Choices along one axis.
        values: The line, N.
        limits: Limit that binds at each place of the line, or "".
        colour: Colour of the line.
        sides: 1 where a name goes above the line, -1 where it goes below.
        boxes: Boxes of the names written so far, pixels; those of new names are appended.
    """
    width = np.nan_to_num(np.abs(part.high - part.low))
    starts = np.flatnonzero(np.concatenate([[True], limits[1:] != limits[:-1]]))
    stops = [*starts[1:], len(limits)]
    stretches = sorted(zip(starts, stops, strict=True), key=lambda stretch: stretch[0] - stretch[1])
    for start, stop in stretches:
        if not limits[start]:
            continue
        places = np.arange(start, stop)
        if len(places) > 4:
            places = places[1:-1]
        places = places[np.argsort(-width[places], kind="stable")]
        text = say.limit_words(str(limits[start]), part.bounds).label
        _write_name(panel, part.scales[0].places, values, places, text, colour, sides, boxes)


def _write_name(
    panel: Axes,
    x: Floats,
    y: Floats,
    places: npt.NDArray[np.int64],
    text: str,
    colour: str,
    sides: Floats,
    boxes: list[Any],
) -> None:
    """Write a name next to a line, at the first of some places where it fits.

    The steeper the line, the farther the name is from it, so that they do not touch. If the name
    would overlap another one or leave the panel at every place, it is not written.

    Args:
        panel: The panel.
        x: Places of the line.
        y: Values of the line.
        places: Indices of points of the line, the best first.
        text: The name.
        colour: Colour of the name.
        sides: 1 where the name goes above the line, -1 where it goes below.
        boxes: Boxes of the names written so far, pixels; that of this name is appended.
    """
    canvas: Any = panel.figure.canvas
    renderer = canvas.get_renderer()
    per_point = panel.figure.dpi / 72.0
    points = np.column_stack([x, np.nan_to_num(y, posinf=0.0)])
    across, upward = panel.transData.transform(points).T
    rise = _steepness(across, upward)
    half = 0.5 * _LETTER * _LABEL_SIZE * len(text)
    ends = {0: "left", len(x) - 1: "right"}
    for place in places[np.isfinite(y[places])]:
        align = ends.get(int(place), "center")
        reach = 1.0 if align == "center" else 2.0  # in halves of the name's width
        distance = sides[place] * (_LABEL_GAP + rise[place] * half * reach)
        note = panel.annotate(
            text,
            (x[place], y[place]),
            (0, distance),  # pt
            textcoords="offset points",
            ha=align,
            va="bottom" if sides[place] > 0.0 else "top",
            size=_LABEL_SIZE,
            color=colour,
        )
        note.set_in_layout(False)
        box = note.get_window_extent(renderer).padded(per_point)
        room = panel.bbox
        fits_upward = room.y0 < box.y0 and box.y1 < room.y1
        fits_across = room.x0 <= box.x0 + 4 and box.x1 - 4 <= room.x1
        overlaps = any(box.overlaps(other) for other in boxes)
        if fits_upward and fits_across and not overlaps:
            boxes.append(box)
            return
        note.remove()


def _steepness(across: Floats, upward: Floats) -> Floats:
    """Return how steep a line is at each of its points (points,), upward or downward.

    Points at one place across, as of values too near to each other to be told apart, are as steep
    as the first of them.
    """
    distinct, first, place = np.unique(across, return_index=True, return_inverse=True)
    if len(distinct) < 2:
        return np.zeros(len(across))
    steepness: Floats = np.abs(np.gradient(upward[first], distinct))[place]
    return steepness


# --- The front ------------------------------------------------------------------------------------


def draw_front(cube: Cube, record: AnswerRecord, _chosen: ChoiceRecord) -> Page | None:
    """Draw the choices that have a window over the first two goals, and the front.

    Returns:
        The page; None if there are fewer than two goals, or nothing on the front to draw.
    """
    goals = record["goals"][:2]
    best = record["best"]
    if len(goals) < 2 or best is None or not record["front"] or cube.table is None:
        return None
    names = [goal["column"] for goal in goals]
    on_front = [row for row in record["front"] if _has_numbers(row, names)]
    if not on_front:
        return None
    shown = [cube.shown(name) for name in names]
    ends = ["pretension_from", "pretension_to", "tolerance_length"]
    wanted = [*dict.fromkeys([*names, *ends, "feasible"])]
    values = cube.gather(evenly_spaced(cube.table.rows, _MOST_POINTS), wanted)
    has_window = values["feasible"] == 1.0
    high = np.where(np.isnan(values["pretension_to"]), np.inf, values["pretension_to"])
    length = np.where(np.isinf(high), np.inf, values["tolerance_length"])
    settable = is_settable(record, length, 0.5 * (high - values["pretension_from"]))
    front = np.array(sorted([value_of(row, name) for name in names] for row in on_front)).T
    rows = [axis for axis in long_axes(cube) if is_of_rows(axis)]
    key = [
        Line2D([], [], **_NOT_SETTABLE, label="choice with a window"),
        Line2D([], [], **_IS_SETTABLE, label=settable_label(record)),
        Line2D(
            [],
            [],
            color=OKABE_ITO[1],
            marker="o",
            linestyle="" if rows else "-",
            label="Pareto front: none is as good in all goals and better in one",
        ),
    ]
    is_best_drawn = _has_numbers(best, names)
    if is_best_drawn:
        key.append(star(label=f"best compromise: {set_text(cube, best)}"))
    notes = []
    endless = len(record["front"]) - len(on_front)
    if endless:
        counted = say.counted(endless, "choice")
        notes.append(f"Not drawn: {counted} of the front whose window has no upper end.")
    if len(record["goals"]) > 2:
        notes.append("The front is one of more goals than the two drawn.")
    if cube.table.rows > _MOST_POINTS:
        drawn = f"{_MOST_POINTS:,} of {cube.table.rows:,} choices"
        notes.append(f"Shown: {drawn}, evenly spaced, and the whole front.")
    page = answer_page(cube, record, "what one goal costs the other", 95.0, key, notes)
    panel = page.figure.subplots()

    def draw(points: Sequence[Any], **style: Any) -> None:
        x, y = (quantity.scaled(value) for quantity, value in zip(shown, points, strict=True))
        panel.plot(x, y, **style)

    for is_drawn, style in (
        (has_window & ~settable, _NOT_SETTABLE),
        (has_window & settable, _IS_SETTABLE),
    ):
        draw([values[name][is_drawn] for name in names], **style)
    joined = "" if rows else "-"  # there is nothing between two parts
    draw(list(front), color=OKABE_ITO[1], marker="o", linestyle=joined)
    if rows:
        panel.margins(y=0.1)
    if len(on_front) <= _MOST_TOLD:
        _write_tolerances(panel, on_front, names, shown, rows)
    compromise: dict[str, Any] = {"color": INK, "markersize": 11, "markeredgecolor": "white"}
    if is_best_drawn:
        draw([value_of(best, name) for name in names], marker="*", zorder=5, **compromise)
    labels = [
        f"{quantity.label}, the {'more' if goal['maximise'] else 'less'} the better"
        for quantity, goal in zip(shown, goals, strict=True)
    ]
    panel.set(xlabel=broken(labels[0], 60), ylabel=broken(labels[1], 40))
    return page


def _has_numbers(choice: ChoiceRecord, names: Sequence[str]) -> bool:
    """Return True if a choice has a number in all of some columns.

    The tolerance of a window without an upper end is null.
    """
    return all(value_of(choice, name) is not None for name in names)


def _write_tolerances(
    panel: Axes,
    front: Sequence[ChoiceRecord],
    names: Sequence[str],
    shown: Sequence[ColumnLabel],
    rows: Sequence[Axis],
) -> None:
    """Write next to each choice of a front its rows of tables, and how far it may be off."""
    for row in front:
        length = row["tolerance_length"]
        text = "no upper end"
        if length is not None:
            text = f"± {say.length_to_spare(length)}"
        if rows:
            parts = ", ".join(str(value_of(row, axis.column)) for axis in rows)
            text = f"{plain(parts)}: {text}"
        x, y = (
            quantity.scaled(value_of(row, name))
            for quantity, name in zip(shown, names, strict=True)
        )
        style: dict[str, Any] = {"textcoords": "offset points", "size": _LABEL_SIZE}
        if not rows:
            panel.annotate(text, (x, y), (5, -3), va="top", **style)
            continue
        left, right = panel.get_xlim()
        is_right = x > left + _FAR_RIGHT * (right - left)
        place = (-5 if is_right else 5, 4)
        panel.annotate(text, (x, y), place, ha="right" if is_right else "left", **style)


def _of_few_rows(draw: AnswerFigure) -> AnswerFigure:
    """Return a figure that is left out if the names of rows are too many to stand along an axis."""

    def draw_if_few(cube: Cube, record: AnswerRecord, chosen: ChoiceRecord) -> Page | None:
        return None if has_many_rows(long_axes(cube)[:2]) else draw(cube, record, chosen)

    return draw_if_few


FIGURES: dict[str, AnswerFigure] = {
    "tolerance_map": _of_few_rows(draw_tolerance),
    "served_map": _of_few_rows(draw_served),
    "window": draw_windows,
    "rows": draw_rows,
    "front": draw_front,
    "trade_off": draw_first_trade_off,
    "between": draw_between,
}
"""Functions that draw the figures of an answer.

Each takes the choices, the record and the choice named first, and returns None if there is nothing
to draw.
"""
