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
from tendon_cli.figures.frame import framed
from tendon_cli.figures.style import FAINT, INK, MARKERS, OKABE_ITO, house_style

Values = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

_SERVED, _LEFT_OUT = OKABE_ITO[0], OKABE_ITO[1]
_OF_BARS = {"with all others": OKABE_ITO[5], "alone": OKABE_ITO[0]}
_LIMIT: dict[str, Any] = {"color": INK, "linewidth": 0.8, "linestyle": (0, (3, 2))}
_MOST_LINES = 4000
_ROOM = 1.6
"""How far above the highest lower end the figure goes where windows have no upper end, as a factor."""


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
    bodies = bodies if len(low) > 2 else None
    has_window, nowhere = ~np.isnan(low) & (low <= high), int(np.isnan(low).sum())
    signs: list[dict[str, Any]] = [
        {"marker": MARKERS[at % len(MARKERS)], "color": OKABE_ITO[(at + 1) % len(OKABE_ITO)], "linestyle": "",
         "markersize": 3.2, "markeredgewidth": 0.0}
        for at in range(len(groups))
    ]  # fmt: skip
    key: list[Any] = [
        Patch(facecolor=colour, label=label)
        for colour, label, members in (
            (_SERVED, "served", served), (_LEFT_OUT, "window elsewhere", has_window & ~served),
            (FAINT, "no window: by how much the upper end lies below the lower one", ~has_window & ~np.isnan(low)),
        ) if members.any()
    ]  # fmt: skip
    key += [Line2D([], [], label="serves enough between", **_LIMIT)] if np.isfinite(band).all() else []
    for group, sign in zip(groups, signs, strict=True) if bodies else ():
        key.append(Line2D([], [], label=plain(group.label, width=60, lines=2), **sign))
    notes = [f"{nowhere} of {len(low)} {kind} have no pretension at all at which the arm balances."] if nowhere else []
    with house_style():
        page = framed(title, 68.0, key, notes)
        shape: dict[str, Any] = {"ncols": 2, "width_ratios": [1.5, 1.0]} if bodies else {}
        panels = page.figure.subplots(1, squeeze=False, **shape)[0]
        _windows(panels[0], low, high, served, band, pretension, kind)
        if bodies:
            rest = ~np.isin(np.arange(len(low)), np.concatenate([[-1], *(group.members for group in groups)]))
            panels[1].plot(bodies[0][rest], bodies[1][rest], ".", color=_SERVED, alpha=0.5, markersize=2.5, zorder=1)
            for group, sign in zip(groups, signs, strict=True):
                panels[1].plot(bodies[0][group.members], bodies[1][group.members], zorder=2, **sign)
            panels[1].set(xlabel=plain(labels[0]), ylabel=plain(labels[1]))
    return page.save(path)


def _windows(
    axes: Axes, low: Values, high: Values, served: Flags, band: tuple[float, float], pretension: float, kind: str
) -> None:
    able = np.flatnonzero(~np.isnan(low))
    order = able[np.lexsort((high[able], low[able]))]
    order = order[evenly(len(order), _MOST_LINES)]
    place = (np.arange(len(order)) + 0.5) / max(len(order), 1) * 100.0
    top = _ROOM * float(np.nanmax(low, initial=pretension if np.isfinite(pretension) else 1.0))
    ends = np.minimum(high[order], max(top, float(np.max(high[np.isfinite(high)], initial=0.0))))
    begin, has_window, width = low[order], low[order] <= high[order], max(0.25, 230.0 / max(len(order), 1))
    for chosen, colour in ((served[order], _SERVED), (has_window & ~served[order], _LEFT_OUT)):
        axes.vlines(place[chosen], begin[chosen], ends[chosen], colors=colour, linewidth=width)
    axes.vlines(place[~has_window], ends[~has_window], begin[~has_window], colors=FAINT, linewidth=min(width, 1.5))
    if np.isfinite(band).all():
        axes.axhspan(*band, color="white", alpha=0.4, linewidth=0.0, zorder=3)
        for end in band:
            axes.axhline(end, zorder=4, **_LIMIT)
    if np.isfinite(pretension):
        axes.axhline(pretension, color=INK, linewidth=0.9, zorder=4)
        axes.annotate(
            f"{pretension:.4g} N", (0.01, pretension), xycoords=("axes fraction", "data"), xytext=(0, 2),
            textcoords="offset points", ha="left", va="bottom", zorder=5,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.8},
        )  # fmt: skip
    axes.set(ylabel="window of pretension (N)", xlim=(0.0, 100.0))
    axes.set_ylim(0.0, max(axes.get_ylim()[1], 1.05 * float(begin.max(initial=0.0))))
    if len(low) == 1:
        axes.set_xticks([])
    else:
        axes.set_xlabel(f"{kind}, in the order of the least pretension they need (%)")


def draw_how_sure(
    path: Path, title: str, pretension: Values, share: Values, low: Values, high: Values, chosen: float, enough: float,
    inputs: Sequence[str] = (), bars: Sequence[Bars] = (),
) -> Path:  # fmt: skip
    """The probability that a pretension (N) is in its window, with its 95 % band; next to it Sobol indices as bars.

    Raises OutputError, UsageError.
    """
    key = [Patch(facecolor=colour, label=label) for label, colour in _OF_BARS.items()] if bars else []
    with house_style():
        page = framed(title, 66.0, key)
        panels = page.figure.subplots(1, 1 + len(bars), width_ratios=[1.6, *[1.0] * len(bars)], squeeze=False)[0]
        _probability(panels[0], pretension, 100 * np.array([share, low, high]), chosen, 100 * enough)
        for at, (axes, each) in enumerate(zip(panels[1:], bars, strict=True)):
            place = np.arange(len(inputs), dtype=np.float64)[::-1]
            pairs = ((each.total, each.total_error), (each.first, each.first_error))
            for shift, (values, errors), colour in zip((0.2, -0.2), pairs, _OF_BARS.values(), strict=True):
                style: dict[str, Any] = {"color": colour, "error_kw": {"elinewidth": 0.7, "capsize": 1.5}}
                axes.barh(place + shift, 100 * values, 0.36, xerr=196 * errors, **style)
            axes.set_yticks(place, [plain(name, width=18) if at == 0 else "" for name in inputs])
            axes.set(xlabel="share of its variance (%)")
            axes.set_xlim(left=0.0)
            axes.set_title(plain(each.label), loc="left")
    return page.save(path)


def _probability(axes: Axes, pretension: Values, percent: Values, chosen: float, enough: float) -> None:
    share, low, high = percent
    axes.fill_between(pretension, low, high, step="post", color=_SERVED, alpha=0.22, linewidth=0.0)
    axes.plot(pretension, share, drawstyle="steps-post", color=_SERVED)
    axes.axhline(enough, color=FAINT, linestyle=(0, (4, 3)), linewidth=0.8)
    beside: dict[str, Any] = {"textcoords": "offset points"}
    axes.annotate(f"enough: {enough:g} %", (0.99, enough), xycoords=("axes fraction", "data"), xytext=(0, 2),
                  color=FAINT, ha="right", **beside)  # fmt: skip
    if np.isfinite(chosen):
        axes.axvline(chosen, color=INK, linewidth=0.9)
        axes.annotate(f"{chosen:.4g} N", (chosen, 0.02), xycoords=("data", "axes fraction"), xytext=(3, 0), **beside)
    if len(pretension) and pretension[0] < pretension[-1]:
        axes.set_xlim(pretension[0], pretension[-1])
    axes.set(ylim=(0.0, 104.0), xlabel="pretension (N)", ylabel="in the window (%), band of 95 %")
