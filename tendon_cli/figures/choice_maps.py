"""Choices of an answer by two of their axes as maps: the tolerance, and the share that one pretension serves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.cube.choice_grid import conflicts_of, position, value_text
from tendon_cli.cube.columns import Values
from tendon_cli.cube.cube import Cube
from tendon_cli.figures.backend import Axes, Line2D, ListedColormap, Patch, mpl
from tendon_cli.figures.frame import Page, framed
from tendon_cli.figures.scales import Scale, axis_scale, off_default
from tendon_cli.figures.style import INK, SEQUENTIAL
from tendon_cli.space.axis import Axis

_PALE = ("#f6d9c5", "#e9e2f3", "#dcebe4", "#f7ecc8", "#e5e5e5", "#dbe7f3")
"""Grounds of what has no window, one for each pair of limits; the others share the last."""
_HATCHES = ("", "....", "----", "\\\\\\\\", "xxxx", "++++")
_BLUES = ListedColormap(
    [mpl.colormaps["Blues"](at) for at in np.linspace(0.15, 0.95, 256)], name="tendon_window"
)
_MOST_WRITTEN = 120
"""Cells of a map that have room for their value in figures."""
_MEANING = (
    "Tolerance: the share by which the pretension may be off on either side of the middle of its window. Pale: no "
    "pretension suits all conditions, for the reason given."
)
_READ = ("pretension_from", "pretension_to", "tolerance", "served", "from_by", "to_by")


@dataclass(frozen=True)
class Slice:
    """Choices of the grid along one or two of its axes, all else as in one choice; arrays of shape (y, x) or (x,)."""

    axes: tuple[Axis, ...]
    """Of x, and of y."""
    scales: tuple[Scale, ...]
    columns: dict[str, Values]
    title: str
    """The values of the other axes."""
    bounds: dict[str, float]

    @classmethod
    def of(cls, cube: Cube, axes: Sequence[Axis], choice: dict[str, Any]) -> Slice:
        """Those through a choice, in the order of the scales."""
        scales = [axis_scale(cube, axis, slice(None), {}, is_log=False) for axis in axes]
        at = {
            axis.column: position(axis, choice[axis.column])
            for axis in cube.axes
            if axis not in axes
        }
        title = ", ".join(
            value_text(cube, axis, axis.values[at[axis.column][0]])
            for axis in cube.axes
            if axis not in axes
        )
        places = {
            axis.column: scale.order.astype(np.int64)
            for axis, scale in zip(axes, scales, strict=True)
        }
        rows = cube.rows([axis.column for axis in reversed(axes)], at | places)
        return cls(tuple(axes), tuple(scales), cube.gather(rows, _READ), title, cube.limits)

    @property
    def low(self) -> Values:
        """N; not a number where no pretension could do."""
        return self.columns["pretension_from"]

    @property
    def high(self) -> Values:
        """N; infinite where nothing bounds it."""
        high = self.columns["pretension_to"]
        return np.where(np.isnan(high) & ~np.isnan(self.low), np.inf, high)

    @property
    def conflicts(self) -> Values:
        """Why each choice has no window, in words; empty if it has one."""
        return conflicts_of(self.columns, self.bounds)


def answer_page(
    cube: Cube, record: dict[str, Any], title: str, panels: float, key: list[Any], notes: list[str]
) -> Page:
    """A page of an answer's figure; its panels are so many mm high."""
    named = record["title"] or record["name"]
    study = f"{record['name']} {record['study_hash'][:12]}"
    given = off_default(cube.asked, [axis.column for axis in cube.axes], {})
    asked = [f"With {', '.join(given)}; all else by default."] if given else []
    return framed(
        f"{named}: {title}",
        panels,
        key,
        [*notes, *_bench_text(record["best"]), *asked],
        study=study,
    )


def _bench_text(best: Mapping[str, Any] | None) -> list[str]:
    """What the choice named first is set to."""
    ends = (
        "set_flexor_tension",
        "set_extensor_tension",
        "set_flexor_tension_motor",
        "set_extensor_tension_motor",
    )
    if best is None or any(best.get(name) is None for name in ends):
        return []
    flexor, extensor, *motor = (say.quantity(name, best[name], 4) for name in ends)
    joint = f"{flexor} in the flexor and {extensor} in the extensor at the joint"
    return [f"The best is set to {joint}, {' and '.join(motor)} at the motor."]


def star(**more: Any) -> Line2D:
    """The sign of the choice named first, for the key."""
    return Line2D([], [], color=INK, marker="*", markersize=9, linestyle="", **more)


def choice_text(cube: Cube, choice: dict[str, Any]) -> str:
    """A choice by its values."""
    return ", ".join(value_text(cube, axis, choice[axis.column]) for axis in cube.axes)


def long_axes(cube: Cube) -> list[Axis]:
    """Axes of more than one value."""
    return [axis for axis in cube.axes if axis.length > 1]


def place_of(cube: Cube, axis: Axis, value: Any, scale: Scale) -> float:
    """Where a value stands on a figure."""
    if scale.names:
        return float(
            scale.names.index(
                str(value) if axis.is_text else cube.shown(axis.column).text(float(value))
            )
        )
    return float(cube.shown(axis.column).scaled(value))


# --- Maps over two choices -------------------------------------------------------------------------------------------


def draw_tolerance(cube: Cube, record: dict[str, Any], chosen: dict[str, Any]) -> Page | None:
    """The tolerance over the first two axes of more than one value; None if there are not two."""
    if len(axes := long_axes(cube)[:2]) < 2:
        return None
    part = Slice.of(cube, axes, chosen)
    conflicts = [str(each) for each in dict.fromkeys(part.conflicts.ravel().tolist()) if each]
    grounds: list[dict[str, Any]] = [
        {"facecolor": _PALE[min(at, 5)], "hatch": _HATCHES[min(at, 5)], "edgecolor": "#8a8a8a"}
        for at in range(len(conflicts))
    ]
    key: list[Any] = [
        Patch(label=each, linewidth=0.4, **ground)
        for each, ground in zip(conflicts, grounds, strict=True)
    ]
    page, panel = _map(
        cube, record, chosen, part, "by how much the pretension may be off", key, [_MEANING]
    )
    x, y = part.scales
    for each, ground in zip(conflicts, grounds, strict=True):
        cells = np.ma.masked_where(part.conflicts != each, np.zeros(part.low.shape))
        style = {**ground, "cmap": ListedColormap([ground["facecolor"]]), "linewidth": 0.0}
        del style["facecolor"]
        panel.pcolor(x.edges, y.edges, cells, **style)
    percent = np.ma.masked_invalid(100.0 * part.columns["tolerance"])
    if percent.count():
        most = max(float(percent.max()), 1e-9)
        texts = [
            ""
            if np.isnan(high)
            else f"from {low:.0f} N"
            if np.isinf(high)
            else f"{low:.0f}–{high:.0f} N"
            for low, high in zip(part.low.ravel(), part.high.ravel(), strict=True)
        ]
        dark = percent.filled(0.0) > 0.55 * most
        _cells(panel, part, percent, _BLUES, most, "tolerance of pretension (± %)", texts, dark)
    return page


def draw_served(cube: Cube, record: dict[str, Any], chosen: dict[str, Any]) -> Page | None:
    """The largest share that one pretension serves, over the same axes; None for one condition after another."""
    if len(axes := long_axes(cube)[:2]) < 2 or not record.get("population"):
        return None
    part = Slice.of(cube, axes, chosen)
    page, panel = _map(
        cube, record, chosen, part, "the largest share that one pretension serves", [], []
    )
    percent = np.ma.masked_invalid(100.0 * part.columns["served"])
    filled = percent.filled(0.0)
    texts = [f"{each:.3g} %" for each in filled.ravel()]
    _cells(
        panel,
        part,
        percent,
        SEQUENTIAL.reversed(),
        100.0,
        "served by one pretension (%)",
        texts,
        filled < 45.0,
    )
    return page


def _map(
    cube: Cube,
    record: dict[str, Any],
    chosen: dict[str, Any],
    part: Slice,
    title: str,
    key: list[Any],
    notes: list[str],
) -> tuple[Page, Axes]:
    """A page with one panel over two choices, and where the choice named first stands."""
    key = [*key, *([star(label=choice_text(cube, chosen))] if chosen["feasible"] else [])]
    page = answer_page(
        cube, record, title, 95.0, key, [*notes, *([f"At {part.title}."] if part.title else [])]
    )
    panel = page.figure.subplots()
    x, y = part.scales
    x.apply(panel, "x", cells=True)
    y.apply(panel, "y", cells=True)
    panel.set(xlabel=x.label, ylabel=y.label)
    if chosen["feasible"]:
        places = zip(part.axes, part.scales, strict=True)
        across, up = (place_of(cube, axis, chosen[axis.column], scale) for axis, scale in places)
        up += 0.3 * float(np.diff(y.edges).min()) if part.low.size <= _MOST_WRITTEN else 0.0
        panel.plot(
            across, up, marker="*", color=INK, markersize=11, markeredgecolor="white", zorder=5
        )
    return page, panel


def _cells(
    panel: Axes,
    part: Slice,
    values: Any,
    colours: Any,
    most: float,
    label: str,
    texts: Any,
    dark: Any,
) -> None:
    """The cells of a map with their colour bar, and their values in figures if there is room for them."""
    x, y = part.scales
    mesh = panel.pcolormesh(x.edges, y.edges, values, cmap=colours, vmin=0.0, vmax=most)
    bar = panel.figure.colorbar(mesh, ax=panel, aspect=28, pad=0.02)
    bar.set_label(label)
    bar.outline.set_linewidth(0.5)
    for row, column in (
        np.argwhere(~np.ma.getmaskarray(values)) if values.size <= _MOST_WRITTEN else ()
    ):
        at = x.edges[column : column + 2].mean(), y.edges[row : row + 2].mean()
        ink = "white" if dark[row, column] else INK
        text = texts[row * values.shape[1] + column]
        panel.text(*at, text, ha="center", va="center", size=6.0, color=ink)
