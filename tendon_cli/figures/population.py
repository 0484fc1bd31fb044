"""Figures of people and draws: whose window holds a pretension and whose does not, how probable that is, and why."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.cube.axes import evenly
from tendon_cli.cube.labels import plain
from tendon_cli.figures.engine import Axes, Line2D, Patch
from tendon_cli.figures.frame import Frame
from tendon_cli.figures.style import (
    FAINT,
    INK,
    MARKERS,
    OKABE_ITO,
    PAGE_WIDTH,
    house_style,
)

Values = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

_SERVED, _LEFT_OUT = OKABE_ITO[0], OKABE_ITO[1]
_OF_BARS = {"with all others": OKABE_ITO[5], "alone": OKABE_ITO[0]}
_MOST_LINES = 4000
_ROOM = 1.6
"""How far above the highest beginning of a window the figure goes where windows have no end, as a factor."""


@dataclass(frozen=True, eq=False)
class Group:
    """Some of those who are left out, for one reason."""

    label: str
    members: npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Bars:
    """Shares of the variance of one end of the window."""

    label: str
    first: Values
    first_error: Values
    total: Values
    total_error: Values


def draw_for_whom(
    path: Path, title: str, low: Values, high: Values, served: Flags, band: tuple[float, float], pretension: float,
    bodies: tuple[Values, Values] | None = None, labels: tuple[str, str] = ("", ""), groups: Sequence[Group] = (),
    kind: str = "persons",
) -> Path:  # fmt: skip
    """Everyone's window as a line, N, the pretensions that serve enough shaded; next to it the bodies not served.

    `bodies` are two dimensions of everyone's, in the units of their labels. Raises OutputError, UsageError.
    """
    with_bodies = bodies is not None and len(low) > 2
    is_open = ~np.isnan(low) & (low <= high)
    nowhere = int(np.isnan(low).sum())
    key: list[Any] = []
    for colour, label, members in (
        (_SERVED, "served", served), (_LEFT_OUT, "window elsewhere", is_open & ~served),
        (FAINT, "no window: by how much the upper end lies below the lower one", ~is_open & ~np.isnan(low)),
    ):  # fmt: skip
        key += [Patch(facecolor=colour, label=label)] if members.any() else []
    if np.isfinite(band).all():
        key.append(Line2D([], [], color=INK, linewidth=0.8, linestyle=(0, (3, 2)), label="serves enough between"))
    for at, group in enumerate(groups if with_bodies else ()):
        key.append(Line2D([], [], linestyle="", label=plain(group.label, width=60, lines=2), **_sign(at)))
    notes = [f"{nowhere} of {len(low)} {kind} have no pretension at all at which the arm balances."] if nowhere else []
    with house_style():
        page = Frame(PAGE_WIDTH, title, key, notes).page(68.0)
        shape: dict[str, Any] = {"ncols": 2, "width_ratios": [1.5, 1.0]} if with_bodies else {}
        panels = page.figure.subplots(1, squeeze=False, **shape)[0]
        _windows(panels[0], low, high, served, band, pretension, kind)
        if bodies is not None and with_bodies:
            _bodies(panels[1], bodies, labels, groups)
        return page.save(path, must_fit=False)


def _sign(at: int) -> dict[str, Any]:
    """How a group of those who are left out looks."""
    style = {"color": OKABE_ITO[(at + 1) % len(OKABE_ITO)], "markersize": 3.2, "markeredgewidth": 0.0}
    return {"marker": MARKERS[at % len(MARKERS)], **style}


def _windows(
    axes: Axes, low: Values, high: Values, served: Flags, band: tuple[float, float], pretension: float, kind: str
) -> None:
    able = np.flatnonzero(~np.isnan(low))
    order = able[np.lexsort((high[able], low[able]))]
    order = order[evenly(len(order), _MOST_LINES)]
    place = (np.arange(len(order)) + 0.5) / max(len(order), 1) * 100.0
    top = _ROOM * float(np.nanmax(low, initial=pretension if np.isfinite(pretension) else 1.0))
    ends = np.minimum(high[order], max(top, float(np.max(high[np.isfinite(high)], initial=0.0))))
    begin, is_open, width = low[order], low[order] <= high[order], max(0.25, 230.0 / max(len(order), 1))
    for chosen, colour in ((served[order], _SERVED), (is_open & ~served[order], _LEFT_OUT)):
        axes.vlines(place[chosen], begin[chosen], ends[chosen], colors=colour, linewidth=width)
    axes.vlines(place[~is_open], ends[~is_open], begin[~is_open], colors=FAINT, linewidth=min(width, 1.5))
    if np.isfinite(band).all():
        axes.axhspan(*band, color="white", alpha=0.4, linewidth=0.0, zorder=3)
        for end in band:
            axes.axhline(end, color=INK, linewidth=0.8, linestyle=(0, (3, 2)), zorder=4)
    if np.isfinite(pretension):
        axes.axhline(pretension, color=INK, linewidth=0.9, zorder=4)
        axes.annotate(
            f"{pretension:.4g} N", (0.01, pretension), xycoords=("axes fraction", "data"), xytext=(0, 2),
            textcoords="offset points", ha="left", va="bottom", zorder=5,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.8},
        )  # fmt: skip
    axes.set_xlabel(f"{kind}, in the order of the least pretension they need (%)" if len(low) > 1 else "")
    axes.set_ylabel("window of pretension (N)")
    axes.set_xlim(0.0, 100.0)
    axes.set_ylim(0.0, max(axes.get_ylim()[1], 1.05 * float(begin.max(initial=0.0))))
    if len(low) == 1:
        axes.set_xticks([])


def _bodies(axes: Axes, bodies: tuple[Values, Values], labels: tuple[str, str], groups: Sequence[Group]) -> None:
    rest = np.ones(len(bodies[0]), dtype=np.bool_)
    for group in groups:
        rest[group.members] = False
    axes.plot(bodies[0][rest], bodies[1][rest], ".", color=_SERVED, alpha=0.5, markersize=2.5, zorder=1)
    for at, group in enumerate(groups):
        axes.plot(bodies[0][group.members], bodies[1][group.members], linestyle="", zorder=2, **_sign(at))
    axes.set_xlabel(plain(labels[0]))
    axes.set_ylabel(plain(labels[1]))


def draw_how_sure(
    path: Path, title: str, pretension: Values, share: Values, low: Values, high: Values, chosen: float, enough: float,
    inputs: Sequence[str] = (), bars: Sequence[Bars] = (),
) -> Path:  # fmt: skip
    """The probability that a pretension (N) is in its window, with its 95 % band; next to it Sobol indices as bars.

    Raises OutputError, UsageError.
    """
    key = [Patch(facecolor=colour, label=label) for label, colour in _OF_BARS.items()] if bars else []
    with house_style():
        page = Frame(PAGE_WIDTH, title, key).page(66.0)
        panels = page.figure.subplots(1, 1 + len(bars), width_ratios=[1.6, *[1.0] * len(bars)], squeeze=False)[0]
        _probability(panels[0], pretension, share, low, high, chosen, enough)
        for at, each in enumerate(bars):
            _bars(panels[1 + at], each, inputs if at == 0 else [""] * len(inputs))
        return page.save(path, must_fit=False)


def _probability(
    axes: Axes, pretension: Values, share: Values, low: Values, high: Values, chosen: float, enough: float
) -> None:
    axes.fill_between(pretension, 100 * low, 100 * high, step="post", color=_SERVED, alpha=0.22, linewidth=0.0)
    axes.plot(pretension, 100 * share, drawstyle="steps-post", color=_SERVED)
    axes.axhline(100 * enough, color=FAINT, linestyle=(0, (4, 3)), linewidth=0.8)
    axes.annotate(
        f"enough: {100 * enough:g} %", (0.99, 100 * enough), xycoords=("axes fraction", "data"), xytext=(0, 2),
        textcoords="offset points", color=FAINT, ha="right",
    )  # fmt: skip
    if np.isfinite(chosen):
        axes.axvline(chosen, color=INK, linewidth=0.9)
        axes.annotate(
            f"{chosen:.4g} N", (chosen, 0.02), xycoords=("data", "axes fraction"), xytext=(3, 0),
            textcoords="offset points",
        )  # fmt: skip
    if len(pretension) and pretension[0] < pretension[-1]:
        axes.set_xlim(pretension[0], pretension[-1])
    axes.set_ylim(0.0, 104.0)
    axes.set_xlabel("pretension (N)")
    axes.set_ylabel("in the window (%), band of 95 %")


def _bars(axes: Axes, bars: Bars, inputs: Sequence[str]) -> None:
    place = np.arange(len(inputs), dtype=np.float64)[::-1]
    for shift, values, errors, colour in (
        (0.2, bars.total, bars.total_error, _OF_BARS["with all others"]),
        (-0.2, bars.first, bars.first_error, _OF_BARS["alone"]),
    ):
        axes.barh(
            place + shift, 100 * values, 0.36, xerr=196 * errors, color=colour,
            error_kw={"elinewidth": 0.7, "capsize": 1.5},
        )  # fmt: skip
    axes.set_yticks(place, [plain(name, width=18) for name in inputs])
    axes.set_xlim(left=0.0)
    axes.set_xlabel("share of its variance (%)")
    axes.set_title(plain(bars.label), loc="left")
