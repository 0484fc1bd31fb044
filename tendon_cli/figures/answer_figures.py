"""The figures of an answer: maps over two choices, the window along each choice, and the front."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.cube.axes import evenly
from tendon_cli.cube.choice_grid import pretension_name
from tendon_cli.cube.cube import Cube, choices_of
from tendon_cli.errors import UsageError
from tendon_cli.figures.backend import Axes, FigureCanvasAgg, Line2D, Patch
from tendon_cli.figures.choice_maps import (
    Slice,
    answer_page,
    choice_text,
    draw_served,
    draw_tolerance,
    long_axes,
    place_of,
    star,
)
from tendon_cli.figures.frame import Page, grid_shape
from tendon_cli.figures.served import draw_population
from tendon_cli.figures.style import INK, OKABE_ITO, broken, hatch_key, house_style, unknown_hatch
from tendon_cli.figures.window_over_angle import draw_between
from tendon_cli.tables.read import open_table

_WINDOW, _CHOICE = "#b4d4ea", "#b8c4cc"
_ENDS = (("from_by", OKABE_ITO[1], -1.0), ("to_by", OKABE_ITO[0], 1.0))
"""What binds at the lower and at the upper end, its colour, and the side of its line that is outside of the window."""
_MOST_ALONG = 4
_MOST_POINTS = 20_000
_LABEL_SIZE, _LABEL_GAP = 6.5, 3.0
"""Of the names of limits, pt."""


def draw_answer(folder: Path, record: dict[str, Any], out: Path) -> tuple[list[str], list[str]]:
    """Draw the answer in a folder, whose tables stand, into another; returns the files and what could not be drawn.

    A figure never costs an answer: what goes wrong is reported, not raised.
    """
    files: list[str] = []
    faults: list[str] = []
    cube = choices_of(open_table(folder / "choices.parquet"))
    for name in [*FIGURES][:-1]:  # between is drawn if it is asked for
        try:
            if (page := answer_figure(name, cube, record)) is not None:
                files.append(page.save(out / f"{name}.png").name)
        except Exception as error:  # noqa: BLE001
            faults.append(f"the figure {name} cannot be drawn: {type(error).__name__}: {error}")
    return files + (draw_population(folder, record, out) if record["population"] else []), faults


def answer_figure(name: str, cube: Cube, record: dict[str, Any]) -> Page | None:
    """One of FIGURES; None if there is nothing to draw."""
    chosen = named_first(record)
    with house_style():
        page = FIGURES[name](cube, record, chosen) if chosen else None
    return page.of_joint(record) if page is not None else None


def draw_between_samples(folder: Path, record: dict[str, Any], out: Path | None) -> Path:
    """Draw what binds where in the answer in a folder, into a file; raises UsageError if there is nothing to draw."""
    page = answer_figure("between", choices_of(open_table(folder / "choices.parquet")), record)
    if page is None:
        hint = "an answer with a window has them; `tendon design --overwrite` solves it anew"
        raise UsageError(
            "the answer has no limits over the angle to draw", where="--between", hint=hint
        )
    return page.save(out or Path(f"{record['name']}-between.png"))


def named_first(record: dict[str, Any]) -> dict[str, Any]:
    """The choice that the answer names first, or if none has a window the one nearest to have one; empty without."""
    best = record["best"]
    if best is None:
        return dict(record["conflicts"][0]["nearest"]) if record["conflicts"] else {}
    return dict(best)


# --- The window along each choice ------------------------------------------------------------------------------------


def draw_windows(cube: Cube, record: dict[str, Any], chosen: dict[str, Any]) -> Page | None:
    """The window against each axis, all else as in the choice named first; None if there is no axis of numbers."""
    along = [axis for axis in long_axes(cube) if not axis.is_text][:_MOST_ALONG]
    if not along:
        return None
    parts = [Slice.of(cube, [axis], chosen) for axis in along]
    has_none = any((part.low > part.high).any() for part in parts)
    key = [
        Patch(facecolor=_WINDOW, label="window: pretensions that suit all conditions"),
        *([hatch_key("no window: the lower limit lies above the upper one")] if has_none else []),
        *([star(label="pretension recommended")] if chosen["feasible"] else []),
    ]
    notes = [
        "At each end stands the limit that binds there. Elsewhere among the choices the window may be another."
    ]
    rows, columns = grid_shape(len(along), most=2)
    page = answer_page(cube, record, "the window of pretension", rows * 68.0, key, notes)
    grid = page.figure.subplots(rows, columns, squeeze=False)
    for panel, axis, part in zip(grid.flat, along, parts, strict=False):
        _draw_window(panel, part)
        panel.set_ylabel(f"{pretension_name(cube.study)} (N)")
        if chosen["feasible"]:
            at = place_of(cube, axis, chosen[axis.column], part.scales[0])
            panel.plot(
                [at],
                [chosen["pretension"]],
                marker="*",
                color=INK,
                markersize=9,
                clip_on=False,
                zorder=5,
            )
    for panel in list(grid.flat)[len(along) :]:
        panel.set_visible(False)
    FigureCanvasAgg(page.figure)
    page.figure.draw_without_rendering()  # so that it is known how steep lines are
    for panel, part in zip(grid.flat, parts, strict=False):
        _name_limits(panel, part)
    return page


def _draw_window(panel: Axes, part: Slice) -> None:
    (x,) = part.scales
    low, high = part.low, np.where(np.isinf(part.high), np.nan, part.high)
    top = 1.2 * float(np.nanmax([low, high], initial=0.0)) or 1.0
    roof = np.where(np.isinf(part.high), top, high)
    style: dict[str, Any] = {"interpolate": True, "step": None}
    panel.fill_between(
        x.places, low, roof, where=(roof >= low).tolist(), facecolor=_WINDOW, **style
    )
    panel.fill_between(
        x.places, roof, low, where=(roof <= low).tolist(), **unknown_hatch(), **style
    )
    for values, (_, colour, _) in zip((low, high), _ENDS, strict=True):
        panel.plot(
            x.places, values, color=colour, marker="o" if len(x.places) < 12 else "", markersize=2.5
        )
    x.apply(panel, "x")
    panel.set(ylim=(0.0, top), xlabel=x.label, title=part.title or " ")


def _name_limits(panel: Axes, part: Slice) -> None:
    """Where a limit binds along a line its name, once for each stretch, clear of the line and of other names.

    A name goes where the other line is farthest, outside of what lies between them. It is moved away from its line by
    as much as the line rises under it; where that leads into another name, or out of the panel, there is none.
    """
    placed: list[Any] = []
    low, high = part.low, part.high
    for values, (name, colour, up) in zip((low, high), _ENDS, strict=True):
        by = part.columns[name]
        starts = np.flatnonzero(np.concatenate([[True], by[1:] != by[:-1]]))
        stretches = sorted(
            zip(starts, [*starts[1:], len(by)], strict=True), key=lambda each: each[0] - each[1]
        )
        for start, stop in stretches:
            inner = slice(start + 1, stop - 1) if stop - start > 4 else slice(start, stop)
            places = np.arange(len(by))[inner][
                np.argsort(-np.nan_to_num(np.abs(high - low)[inner]), kind="stable")
            ]
            if by[start]:
                text = say.limit_words(str(by[start]), part.bounds).label
                sides = np.where(low > high, -up, up)
                _write(panel, part.scales[0].places, values, places, text, colour, sides, placed)


def _write(
    panel: Axes,
    x: npt.NDArray[Any],
    y: npt.NDArray[Any],
    places: npt.NDArray[Any],
    text: str,
    colour: str,
    sides: npt.NDArray[Any],
    placed: list[Any],
) -> None:
    """A name at the first of some places of a line where it fits; `sides` is 1 where it goes above, -1 below."""
    canvas: Any = panel.figure.canvas
    renderer, per_point = canvas.get_renderer(), panel.figure.dpi / 72.0
    across, upward = panel.transData.transform(np.column_stack([x, np.nan_to_num(y, posinf=0.0)])).T
    rise = np.abs(np.gradient(upward, across)) if len(x) > 1 else np.zeros(1)
    half = 0.5 * 0.58 * _LABEL_SIZE * len(text)
    for at in places[np.isfinite(y[places])]:
        align = {0: "left", len(x) - 1: "right"}.get(int(at), "center")
        clear = sides[at] * (_LABEL_GAP + rise[at] * half * (1.0 if align == "center" else 2.0))
        note = panel.annotate(
            text,
            (x[at], y[at]),
            (0, clear),
            textcoords="offset points",
            ha=align,
            va="bottom" if sides[at] > 0.0 else "top",
            size=_LABEL_SIZE,
            color=colour,
        )
        note.set_in_layout(False)
        box, room = note.get_window_extent(renderer).padded(per_point), panel.bbox
        is_inside = (
            room.y0 < box.y0
            and box.y1 < room.y1
            and room.x0 <= box.x0 + 4
            and box.x1 - 4 <= room.x1
        )
        if is_inside and not any(box.overlaps(other) for other in placed):
            placed.append(box)
            return
        note.remove()


# --- The front -------------------------------------------------------------------------------------------------------


def draw_front(cube: Cube, record: dict[str, Any], _chosen: dict[str, Any]) -> Page | None:
    """Choices with a window by the first two goals, and the front; None without two goals or a front."""
    goals = record["goals"][:2]
    if len(goals) < 2 or not record["front"] or cube.files is None:
        return None
    names = [goal["column"] for goal in goals]
    shown = [cube.shown(name) for name in names]
    read = cube.gather(evenly(cube.files.rows, _MOST_POINTS), [*names, "feasible"])
    with_window = {name: read[name][read["feasible"] == 1.0] for name in names}
    front = dict(
        zip(
            names,
            np.array(sorted([row[name] for name in names] for row in record["front"])).T,
            strict=True,
        )
    )
    key = [
        Line2D([], [], color=_CHOICE, marker="o", linestyle="", label="choice with a window"),
        Line2D(
            [], [], color=OKABE_ITO[1], marker="o", label="front: no other is better in every goal"
        ),
        star(label=f"best compromise: {choice_text(cube, record['best'])}"),
    ]
    notes = (
        []
        if len(record["goals"]) == 2
        else ["The front is one of more goals than the two that are drawn."]
    )
    page = answer_page(cube, record, "what one goal costs the other", 95.0, key, notes)
    panel = page.figure.subplots()
    looks: tuple[tuple[dict[str, Any], dict[str, Any]], ...] = (
        (with_window, {"color": _CHOICE, "marker": "o", "linestyle": "", "markersize": 2.5}),
        (front, {"color": OKABE_ITO[1], "marker": "o"}),
        (
            record["best"],
            {
                "marker": "*",
                "color": INK,
                "markersize": 11,
                "markeredgecolor": "white",
                "zorder": 5,
            },
        ),
    )
    for values, style in looks:
        panel.plot(
            *(how.scaled(values[name]) for how, name in zip(shown, names, strict=True)), **style
        )
    labels = [
        f"{how.label}, the {'more' if goal['maximise'] else 'less'} the better"
        for how, goal in zip(shown, goals, strict=True)
    ]
    panel.set(xlabel=broken(labels[0], 60), ylabel=broken(labels[1], 40))
    return page


FIGURES: dict[str, Callable[[Cube, dict[str, Any], dict[str, Any]], Page | None]] = {
    "tolerance_map": draw_tolerance,
    "served_map": draw_served,
    "window": draw_windows,
    "front": draw_front,
    "between": draw_between,
}
"""What draws each figure, of the choices, the record and the choice named first; None if there is nothing to draw."""
