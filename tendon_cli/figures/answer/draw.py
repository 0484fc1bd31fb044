"""The figures of an answer: a map of the tolerance, the window along each choice, and the front."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tendon_cli.cube.columns import quantity_in
from tendon_cli.cube.labels import Shown
from tendon_cli.figures.answer.data import ChoiceTable, Slice
from tendon_cli.figures.engine import Axes, Line2D, ListedColormap, Patch, mpl
from tendon_cli.figures.frame import Frame, grid_shape
from tendon_cli.figures.scales import Scale
from tendon_cli.figures.style import INK, OKABE_ITO, PAGE_WIDTH, broken, hatch_key, house_style, unknown_hatch
from tendon_cli.tables.read import open_table

_PALE = ("#f6d9c5", "#e9e2f3", "#dcebe4", "#f7ecc8", "#e5e5e5", "#dbe7f3")
"""Grounds of what has no window, one for each pair of limits; the others share the last."""
_OPEN = ListedColormap([mpl.colormaps["Blues"](at) for at in np.linspace(0.15, 0.95, 256)], name="tendon_open")
_MOST_ALONG = 4
_MOST_WRITTEN = 120
"""Cells of a map that have room for their window in figures."""
_HATCHES = ("", "....", "----", "\\\\\\\\", "xxxx", "++++")


def draw_answer(folder: Path, record: dict[str, Any]) -> tuple[list[str], list[str]]:
    """Draw into the folder of an answer, whose tables stand; returns the files and what could not be drawn.

    A figure never costs an answer: what goes wrong is told, not raised.
    """
    files: list[str] = []
    faults: list[str] = []
    table = ChoiceTable(open_table(folder / "choices.parquet"))
    for name, draw in (("tolerance_map", draw_map), ("window", draw_windows), ("front", draw_front)):
        try:
            with house_style():
                page = draw(table, record)
                if page is not None:
                    files.append(page.save(folder / f"{name}.png", must_fit=False).name)
        except Exception as error:  # noqa: BLE001
            faults.append(f"the figure {name} cannot be drawn: {type(error).__name__}: {error}")
    return files, faults


def first_named(record: dict[str, Any]) -> dict[str, Any]:
    """The choice that the answer names first, or where none has a window the one nearest to have one."""
    best = record["best"]
    if best is None:
        nearest: dict[str, Any] = record["conflicts"][0]["nearest"]
        return nearest
    chosen: dict[str, Any] = best if "pretension_from" in best else next(iter(best.values()))
    return chosen


def _frame(record: dict[str, Any], title: str, key: list[Any], notes: list[str]) -> Frame:
    named = record["title"] or record["name"]
    study = f"{record['name']} {record['study_hash'][:12]}"
    return Frame(PAGE_WIDTH, f"{named}: {title}", key, notes, study=study)


# --- Tolerance over two choices --------------------------------------------------------------------------------------


def draw_map(table: ChoiceTable, record: dict[str, Any]) -> Any:
    """The tolerance over the first two axes of more than one value; None where there are not two."""
    axes = [axis for axis in table.axes if len(table.values(axis)) > 1][:2]
    if len(axes) < 2:
        return None
    chosen = first_named(record)
    found = table.slice(axes, chosen)
    pairs = [str(pair) for pair in np.unique(found.pairs) if pair]
    key: list[Any] = [
        Patch(facecolor=_PALE[min(at, 5)], hatch=_HATCHES[min(at, 5)], edgecolor="#8a8a8a", linewidth=0.4, label=pair)
        for at, pair in enumerate(pairs)
    ]
    if chosen["feasible"]:
        key.append(Line2D([], [], color=INK, marker="*", markersize=9, linestyle="", label=_choice_said(table, chosen)))
    meaning = (
        "Tolerance: the share by which the pretension may be off on either side of the middle of its window. Pale: no "
        "pretension suits all conditions, for the two limits named are in conflict."
    )
    notes = [meaning, f"At {found.title}."] if found.title else [meaning]
    frame = _frame(record, "by how much the pretension may be off", key, notes)
    page = frame.page(95.0)
    panel = page.figure.subplots()
    _draw_tolerance(panel, found, pairs)
    if chosen["feasible"]:
        x, y = (_place(table, axis, chosen[axis], scale) for axis, scale in zip(axes, found.scales, strict=True))
        above = 0.3 * np.diff(found.scales[1].edges).min() if found.tolerance.size <= _MOST_WRITTEN else 0.0
        panel.plot(x, y + above, marker="*", color=INK, markersize=11, markeredgecolor="white", zorder=5)
    return page


def _draw_tolerance(panel: Axes, found: Slice, pairs: list[str]) -> None:
    x, y = found.scales
    for at, pair in enumerate(pairs):
        cells = np.ma.masked_where(found.pairs != pair, np.zeros(found.low.shape))
        panel.pcolor(x.edges, y.edges, cells, cmap=ListedColormap([_PALE[min(at, 5)]]), edgecolor="#8a8a8a",
                     hatch=_HATCHES[min(at, 5)], linewidth=0.0)  # fmt: skip
    percent = np.ma.masked_invalid(100.0 * found.tolerance)
    if percent.count():
        most = max(float(percent.max()), 1e-9)
        mesh = panel.pcolormesh(x.edges, y.edges, percent, cmap=_OPEN, vmin=0.0, vmax=most)
        bar = panel.figure.colorbar(mesh, ax=panel, aspect=28, pad=0.02)
        bar.set_label("tolerance of pretension (± %)")
        bar.outline.set_linewidth(0.5)
        if percent.size <= _MOST_WRITTEN:
            _write_cells(panel, x, y, found, most)
    x.apply(panel, "x", cells=True)
    y.apply(panel, "y", cells=True)
    panel.set_xlabel(x.label)
    panel.set_ylabel(y.label)


def _write_cells(panel: Axes, x: Scale, y: Scale, found: Slice, most: float) -> None:
    """The windows themselves, where there is room for them."""
    for row, column in np.argwhere(found.low <= found.high):
        low, high = found.low[row, column], found.high[row, column]
        text = f"{low:.0f}–{high:.0f} N" if np.isfinite(high) else f"from {low:.0f} N"
        dark = 100.0 * found.tolerance[row, column] > 0.55 * most
        at = x.edges[column : column + 2].mean(), y.edges[row : row + 2].mean()
        panel.text(*at, text, ha="center", va="center", size=6.0, color="white" if dark else INK)


def _place(table: ChoiceTable, axis: str, value: Any, scale: Scale) -> float:
    how = table.shown(axis)
    return float(scale.names.index(str(value))) if how is None else float(how.scaled(value))


def _choice_said(table: ChoiceTable, choice: dict[str, Any]) -> str:
    return ", ".join(table.said(axis, choice[axis]) for axis in table.axes)


# --- The window along each choice ------------------------------------------------------------------------------------


def draw_windows(table: ChoiceTable, record: dict[str, Any]) -> Any:
    """The window against each axis, all else as in the choice named first; None where there is no axis of numbers."""
    along = [axis for axis in table.axes if table.shown(axis) is not None and len(table.values(axis)) > 1][:_MOST_ALONG]
    if not along:
        return None
    chosen = first_named(record)
    key = [
        Patch(facecolor="#b4d4ea", label="window: pretensions that suit all conditions"),
        hatch_key("no window: the lower limit lies above the upper one"),
    ]
    notes = ["At each end stands the limit that binds there. Elsewhere in the choices the window may be another."]
    frame = _frame(record, "the window of pretension", key, notes)
    rows, columns = grid_shape(len(along), most=2)
    page = frame.page(rows * 68.0)
    grid = page.figure.subplots(rows, columns, squeeze=False)
    for panel, axis in zip(grid.flat, along, strict=False):
        found = table.slice([axis], chosen)
        _draw_window(panel, found)
        panel.set_title(found.title or " ")
        if chosen["feasible"]:
            how = table.shown(axis)
            at = 0.0 if how is None else float(how.scaled(chosen[axis]))
            panel.plot([at], [chosen["pretension"]], marker="*", color=INK, markersize=9, clip_on=False, zorder=5)
    for panel in list(grid.flat)[len(along) :]:
        panel.set_visible(False)
    return page


def _draw_window(panel: Axes, found: Slice) -> None:
    (x,) = found.scales
    low, high = found.low, np.where(np.isinf(found.high), np.nan, found.high)
    known = np.concatenate([low[np.isfinite(low)], high[np.isfinite(high)]])
    top = 1.15 * float(known.max()) if len(known) else 1.0
    roof = np.where(np.isinf(found.high), top, high)
    places = x.places
    style: dict[str, Any] = {"interpolate": True, "step": None}
    panel.fill_between(places, low, roof, where=(roof >= low).tolist(), facecolor="#b4d4ea", **style)
    panel.fill_between(places, roof, low, where=(roof <= low).tolist(), **unknown_hatch(), **style)
    ends = ((low, found.low_by, OKABE_ITO[1], "top"), (high, found.high_by, OKABE_ITO[0], "bottom"))
    for values, by, colour, side in ends:
        panel.plot(places, values, color=colour, marker="o" if len(places) < 12 else "", markersize=2.5)
        _name_limits(panel, x, values, by, np.abs(roof - low), colour=colour, side=side)
    x.apply(panel, "x")
    panel.set_ylim(0.0, top)
    panel.set_xlabel(x.label)
    panel.set_ylabel("pretension F₀ (N)")


def _name_limits(panel: Axes, x: Scale, values: Any, by: Any, room: Any, *, colour: str, side: str) -> None:
    """Where a limit binds along a line, its name, once for each stretch, where the other line is farthest."""
    starts = np.flatnonzero(np.concatenate([[True], by[1:] != by[:-1]]))
    for start, stop in zip(starts, [*starts[1:], len(by)], strict=True):
        inner = slice(start + 1, stop - 1) if stop - start > 4 else slice(start, stop)
        middle = inner.start + int(np.argmax(np.nan_to_num(room[inner])))
        if not np.isfinite(values[middle]) or not str(by[middle]).strip():
            continue
        offset = 5 if side == "bottom" else -5
        inward = "left" if middle == 0 else "right" if middle == len(by) - 1 else "center"  # the panel cuts the rest
        panel.annotate(str(by[middle]), (x.places[middle], values[middle]), (0, offset), textcoords="offset points",
                       ha=inward, va=side, size=6.5, color=colour, clip_on=True,
                       bbox={"facecolor": "white", "alpha": 0.75, "linewidth": 0, "pad": 0.8})  # fmt: skip


# --- The front -------------------------------------------------------------------------------------------------------


def draw_front(table: ChoiceTable, record: dict[str, Any]) -> Any:
    """Choices with a window by the first two goals, and the front; None without two goals or a front."""
    goals = [goal["column"] for goal in record["goals"]][:2]
    if len(goals) < 2 or not record["front"]:
        return None
    axes = [Shown.of(goal, quantity_in(table.table.schema.field(goal))) for goal in goals]
    parts = [part.filter(part["feasible"]) for _, part in table.table.parts([*goals, "feasible"])]
    clouds = [np.concatenate([part[goal].to_numpy() for part in parts]) for goal in goals]
    front = sorted(([row[goal] for goal in goals] for row in record["front"]), key=lambda pair: pair[0])
    key = [
        Line2D([], [], color="#b8c4cc", marker="o", linestyle="", label="choice with a window"),
        Line2D([], [], color=OKABE_ITO[1], marker="o", label="front: no other is better in every goal"),
        Line2D([], [], color=INK, marker="*", markersize=9, linestyle="",
               label=f"knee: {_choice_said(table, record['best'])}"),
    ]  # fmt: skip
    notes = [] if len(record["goals"]) == 2 else ["The front is one of more goals than the two that are drawn."]
    page = _frame(record, "what one goal costs the other", key, notes).page(95.0)
    panel = page.figure.subplots()
    step = max(1, len(clouds[0]) // 20_000)
    panel.plot(*(how.scaled(cloud[::step]) for how, cloud in zip(axes, clouds, strict=True)),
               color="#b8c4cc", marker="o", linestyle="", markersize=2.5)  # fmt: skip
    line = list(zip(*front, strict=True))
    panel.plot(*(how.scaled(values) for how, values in zip(axes, line, strict=True)), color=OKABE_ITO[1], marker="o")
    knee = [how.scaled(record["best"][goal]) for how, goal in zip(axes, goals, strict=True)]
    panel.plot(*knee, marker="*", color=INK, markersize=11, markeredgecolor="white", zorder=5)
    panel.set_xlabel(broken(_goal_label(axes[0], record["goals"][0]), 60))
    panel.set_ylabel(broken(_goal_label(axes[1], record["goals"][1]), 40))
    return page


def _goal_label(how: Shown, goal: dict[str, Any]) -> str:
    return f"{how.label}, {'the more' if goal['maximise'] else 'the less'} the better"
