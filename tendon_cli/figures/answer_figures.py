"""Figures of an answer by name, and their files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.cube.columns import column_named
from tendon_cli.cube.cube import Cube, CubeAsRead, cube_of
from tendon_cli.cube.labels import plain
from tendon_cli.errors import UsageError
from tendon_cli.figures.answer_page import (
    answer_page,
    is_settable,
    long_axes,
    set_text,
    settable_label,
    star,
)
from tendon_cli.figures.backend import Axes
from tendon_cli.figures.choice_maps import draw_served, draw_tolerance
from tendon_cli.figures.frame import Page, fitted, numbered, panels_of, save_pages
from tendon_cli.figures.layout import is_of_rows
from tendon_cli.figures.served import draw_population
from tendon_cli.figures.style import OKABE_ITO, PAGE_WIDTH, STAR, WHOLE, house_style, key_line
from tendon_cli.figures.windows import draw_between, draw_rows, draw_trade_off, draw_windows
from tendon_cli.model.kinematics import Array
from tendon_cli.studies.space.axis import Axis, evenly_spaced
from tendon_cli.studies.study import Study
from tendon_cli.tables.read import open_table
from tendon_cli.units import shorten
from tendon_cli.verbs.answer_record import (
    AnswerRecord,
    ChoiceRecord,
    TradeOffRecord,
    as_answer,
    as_read,
    named_first,
    value_of,
)
from tendon_cli.verbs.registry import by_name

_CHOICE = "#b8c4cc"
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

AnswerFigure = Callable[..., list[Page]]
"""Function that draws the pages of a figure of an answer, or none if there is nothing to draw."""


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
    cube = cube_of(open_table(folder / "choices.parquet", by_name(record)), study, ("choices",))
    for name, draw in _figures(folder, cube, record).items():
        try:
            files += [file.name for file in save_pages(numbered(draw(), out / f"{name}.png"))]
        except Exception as error:  # noqa: BLE001
            faults.append(f"the figure {name} cannot be drawn: {type(error).__name__}: {error}")
    return files, faults, None


def _figures(
    folder: Path, cube: Cube, record: Mapping[str, Any]
) -> dict[str, Callable[[], list[Page]]]:
    """Return what draws each figure of an answer, but for `between`, which is drawn on request."""
    drawn: dict[str, Callable[[], list[Page]]] = {
        name: partial(answer_pages, name, cube, record) for name in FIGURES if name != "between"
    }
    answer = as_answer(record)
    if answer.population is not None:
        drawn["for_whom"] = partial(draw_population, "for_whom", folder, answer, record)
        drawn["how_sure"] = partial(draw_population, "how_sure", folder, answer, record)
    return drawn


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
    drawn = {name: draw() for name, draw in _figures(folder, choices, record).items()}
    figures = {name: pages for name, pages in drawn.items() if pages}
    if not figures:
        hint = f"`tendon report {folder}` writes a page with what it says"
        raise UsageError("the answer has no figure to draw", where=str(folder), hint=hint)
    files = []
    for name, pages in figures.items():
        if out is not None and len(figures) > 1 and not out.is_dir():
            problem = f"{out.name} is one file, and the answer has {len(figures)} figures"
            raise UsageError(problem, where="--out", hint="name a folder that exists")
        files += numbered(pages, _file_of(name, record, out, form))
    return save_pages(files, overwrite=overwrite)


def answer_pages(name: str, cube: Cube, record: Mapping[str, Any], **how: Any) -> list[Page]:
    """Draw the pages of one of FIGURES by its name; none if there is nothing to draw.

    Args:
        name: Name of the figure.
        cube: Choices of the answer.
        record: Record of the answer.
        **how: Further arguments of the figure's function.
    """
    cube, answer = _as_gauges_show(cube, record)
    chosen = named_first(answer)
    if chosen is None:
        return []
    with house_style(say.joint_name(record)):
        return FIGURES[name](cube, answer, chosen, **how)


def _as_gauges_show(cube: Cube, record: Mapping[str, Any]) -> tuple[Cube, AnswerRecord]:
    """Return choices and record with pretensions as they are read, where they are set."""
    answer = as_answer(record)
    if answer.question.shows_own_f0:
        cube = CubeAsRead.of(cube)
    return cube, as_read(answer)


def answer_figure(name: str, cube: Cube, record: Mapping[str, Any]) -> Page | None:
    """Draw the first page of one of FIGURES; None if there is nothing to draw."""
    return next(iter(answer_pages(name, cube, record)), None)


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
    return page.save(_file_of("between", record, out), overwrite=overwrite)


def _file_of(name: str, record: Mapping[str, Any], out: Path | None, form: str = "png") -> Path:
    """Return the file of a figure: `out`, or one named after the study in this or that folder."""
    if out is not None and not out.is_dir():
        return out
    return (out or Path()) / f"{record['name']}-{name}.{form}"


def draw_over(
    choices: Cube,
    record: Mapping[str, Any],
    x: str,
    y: str | None,
    out: Path | None,
    *,
    width: float = PAGE_WIDTH,
    height: float | None = None,
    form: str = "png",
    overwrite: bool = False,
) -> list[Path]:
    """Draw the trade-off of an answer along a limit, or its map over two axes of choices.

    Args:
        choices: Choices of the answer.
        record: Record of the answer.
        x: Key or column of the axis across: without `y` of a limit, or of the table whose rows set
            it.
        y: Key or column of the axis up; None for the trade-off.
        out: The file; by default in the working directory, named after the study.
        width: Width of the page of a trade-off, mm.
        height: Height of that page, mm; None for the usual one.
        form: Format of the file if `out` does not say it.
        overwrite: True to replace a file that tendon did not write.

    Raises:
        UsageError: The answer has nothing of this, or tendon did not write the file.
    """
    choices, answer = _as_gauges_show(choices, record)
    column = column_named(x)
    with house_style(say.joint_name(record)):
        if y is None:
            trade_off = _find(choices, answer, column)
            pages = [draw_trade_off(choices, answer, trade_off, column, width, height)]
        else:
            pages = _map_over(choices, answer, column, column_named(y))
    target = _file_of(column.removeprefix("limit_"), record, out, form)
    return save_pages(numbered(pages, target), overwrite=overwrite)


def _map_over(cube: Cube, record: AnswerRecord, x: str, y: str) -> list[Page]:
    """Draw how far the setting may be off over two axes; raise UsageError if they are none."""
    axes = []
    for option, column in (("--x", x), ("--quantity", y)):
        axis = cube.axis(column)
        if axis is None:
            hint = f"axes: {', '.join(axis.column for axis in cube.axes)}"
            problem = f"{shorten(column)} is not an axis of the choices"
            raise UsageError(problem, where=option, hint=hint)
        axes.append(axis)
    chosen = named_first(record)
    if chosen is None or axes[0] is axes[1]:
        raise UsageError("a map needs two different axes of choices", where="--x")
    return draw_tolerance(cube, record, chosen, axes=(axes[0], axes[1]))


def _find(cube: Cube, record: AnswerRecord, column: str) -> TradeOffRecord:
    """Return the trade-off along the column of a limit; raise UsageError if there is none."""
    axis = cube.axis(column)
    if axis is None and column in cube.columns_of_names:
        axis, _ = cube.columns_of_names[column]
    known = {trade_off.column: trade_off for trade_off in record.trade_offs}
    if axis is not None and axis.column in known:
        return known[axis.column]
    keys = [trade_off.key for trade_off in known.values()]
    hint = f"limits on which its choices differ: {', '.join(keys)}"
    if not keys:
        example = '[limits] max_tension = ["300 N", "400 N"]'
        hint = f"no limit has several values in this answer, as in {example}"
    problem = f"the answer has no trade-off along {shorten(column)}"
    raise UsageError(problem, where="--x", hint=hint)


def _draw_first_trade_off(cube: Cube, record: AnswerRecord, _chosen: ChoiceRecord) -> list[Page]:
    """Draw the trade-off along the first limit on which choices differ, if there is one."""
    drawn = [of_limit for of_limit in record.trade_offs if any(of_limit.best)]
    return [draw_trade_off(cube, record, one, one.column) for one in drawn[:1]]


# --- The front ------------------------------------------------------------------------------------


def draw_front(cube: Cube, record: AnswerRecord, _chosen: ChoiceRecord) -> list[Page]:
    """Draw the choices that have a window over the first two goals, and the front.

    Returns:
        The page; none if there are fewer than two goals, or nothing on the front to draw.
    """
    goals = record.goals[:2]
    best = record.best
    if len(goals) < 2 or best is None or not record.front or cube.table is None:
        return []
    names = [goal.column for goal in goals]
    on_front = [row for row in record.front if _has_numbers(row, names)]
    if not on_front:
        return []
    shown = [cube.shown(name) for name in names]
    ends = ["pretension_from", "pretension_to", "tolerance_length"]
    wanted = [*dict.fromkeys([*names, *ends, "feasible"])]
    values = cube.gather(evenly_spaced(cube.table.rows, _MOST_POINTS), wanted)
    has_window = values["feasible"] == 1.0
    high = np.where(np.isnan(values["pretension_to"]), np.inf, values["pretension_to"])
    length = np.where(np.isinf(high), np.inf, values["tolerance_length"])
    settable = is_settable(record, length, 0.5 * (high - values["pretension_from"]))
    front = sorted(on_front, key=lambda row: [value_of(row, name) for name in names])
    rows = [axis for axis in long_axes(cube) if is_of_rows(axis)]
    joined = "" if rows else "-"  # there is nothing between two parts
    of_front: dict[str, Any] = {"color": OKABE_ITO[1], "marker": "o", "linestyle": joined}
    of_front |= WHOLE
    text = "Pareto front: none is as good in all goals and better in one"
    key = [
        key_line(**_NOT_SETTABLE, label="choice with a window"),
        key_line(**_IS_SETTABLE, label=settable_label(record)),
        key_line(**of_front, label=text),
    ]
    is_best_drawn = _has_numbers(best, names)
    if is_best_drawn:
        key.append(star(f"best compromise: {set_text(cube, record, best)}"))
    notes = []
    endless = len(record.front) - len(on_front)
    if endless:
        counted = say.counted(endless, "choice")
        notes.append(f"Not drawn: {counted} of the front whose window has no upper end.")
    if len(record.goals) > 2:
        notes.append("The front is one of more goals than the two drawn.")
    if cube.table.rows > _MOST_POINTS:
        drawn = f"{_MOST_POINTS:,} of {cube.table.rows:,} choices"
        notes.append(f"Shown: {drawn}, evenly spaced, and the whole front.")
    page = answer_page(cube, record, "what one goal costs the other", 95.0, key, notes)
    (panel,) = panels_of(page, 1, 1, 1)

    x, y = (quantity.scaled(values[name]) for quantity, name in zip(shown, names, strict=True))
    for is_drawn, style in (
        (has_window & ~settable, _NOT_SETTABLE),
        (has_window & settable, _IS_SETTABLE),
    ):
        panel.plot(x[is_drawn], y[is_drawn], **style)

    def places(choices: Sequence[ChoiceRecord]) -> list[Array]:
        """Return x and y of choices, in the units shown."""
        return [
            quantity.scaled([value_of(row, name) for row in choices])
            for quantity, name in zip(shown, names, strict=True)
        ]

    front_x, front_y = places(front)
    panel.plot(front_x, front_y, **of_front)
    panel.margins(y=0.1)
    if len(front) <= _MOST_TOLD:
        _write_tolerances(panel, front, front_x, front_y, rows)
    if is_best_drawn:
        panel.plot(*places([best]), **STAR)
    labels = [
        f"{quantity.label}, the {'more' if goal.maximise else 'less'} the better"
        for quantity, goal in zip(shown, goals, strict=True)
    ]
    panel.set(xlabel=fitted(labels[0], 140.0), ylabel=fitted(labels[1], 90.0))
    return [page]


def _has_numbers(choice: ChoiceRecord, names: Sequence[str]) -> bool:
    """Return True if a choice has a number in all of some columns.

    The tolerance of a window without an upper end is null.
    """
    return all(value_of(choice, name) is not None for name in names)


def _write_tolerances(
    panel: Axes, front: Sequence[ChoiceRecord], x: Array, y: Array, rows: Sequence[Axis]
) -> None:
    """Write next to each choice of a front its rows of tables, and how far it may be off."""
    left, right = panel.get_xlim()
    for number, row in enumerate(front):
        length = row.tolerance_length
        text = "no upper end" if length is None else f"± {say.length_to_spare(length)}"
        if rows:
            parts = ", ".join(str(value_of(row, axis.column)) for axis in rows)
            text = f"{plain(parts)}: {text}"
        is_right = x[number] > left + _FAR_RIGHT * (right - left)
        panel.annotate(
            text,
            (x[number], y[number]),
            (-5 if is_right else 5, 4 if number % 2 == 0 else -9),  # neighbours do not touch
            ha="right" if is_right else "left",
            size=6.5,
            textcoords="offset points",
        )


FIGURES: dict[str, AnswerFigure] = {
    "tolerance_map": draw_tolerance,
    "served_map": draw_served,
    "window": draw_windows,
    "rows": draw_rows,
    "front": draw_front,
    "trade_off": _draw_first_trade_off,
    "between": draw_between,
}
"""Functions that draw the figures of an answer.

Each takes the choices, the record and the choice named first, and returns the pages, none if there
is nothing to draw.
"""
