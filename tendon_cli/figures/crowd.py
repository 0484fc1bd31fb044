"""Figures of a crowd: whose window holds a pretension and whose does not, how probable that is, and what it owes to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tendon_cli.cube.labels import plain
from tendon_cli.figures.engine import Axes
from tendon_cli.figures.style import (
    FAINT,
    INK,
    MARKERS,
    OKABE_ITO,
    PAGE_WIDTH,
    SEQUENTIAL,
    house_style,
    new_figure,
    save,
)

Values = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

_SERVED, _LEFT_OUT = OKABE_ITO[0], OKABE_ITO[1]
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
    """Everyone's window as a line, N, the pretensions that serve enough shaded; beside it the bodies left out.

    `bodies` are two dimensions of everyone's, in the units of their labels. Raises OutputError, UsageError.
    """
    with house_style():
        figure = new_figure(PAGE_WIDTH, 85.0)
        panels = figure.subplots(1, 2, width_ratios=[1.5, 1.0]) if bodies is not None else [figure.subplots()]
        figure.suptitle(plain(title, width=110), x=0.01, ha="left")
        _windows(panels[0], low, high, served, band, pretension, kind)
        if bodies is not None:
            _bodies(panels[1], bodies, labels, groups)
    return save(figure, path)


def _windows(
    axes: Axes, low: Values, high: Values, served: Flags, band: tuple[float, float], pretension: float, kind: str
) -> None:
    able = np.flatnonzero(~np.isnan(low))
    order = able[np.lexsort((high[able], low[able]))]
    if len(order) > _MOST_LINES:
        order = order[np.linspace(0, len(order) - 1, _MOST_LINES).round().astype(np.int64)]
    place = (np.arange(len(order)) + 0.5) / max(len(order), 1) * 100.0
    top = _ROOM * float(np.nanmax(low, initial=pretension if np.isfinite(pretension) else 1.0))
    ends = np.minimum(high[order], max(top, float(np.max(high[np.isfinite(high)], initial=0.0))))
    begin, is_open, width = low[order], low[order] <= high[order], max(0.25, 250.0 / max(len(order), 1))
    for chosen, colour, label in (
        (served[order], _SERVED, "served"),
        (is_open & ~served[order], _LEFT_OUT, "window elsewhere"),
    ):
        if chosen.any():
            axes.vlines(place[chosen], begin[chosen], ends[chosen], colors=colour, linewidth=width, label=label)
    if (~is_open).any():
        axes.plot(place[~is_open], begin[~is_open], ".", color=FAINT, markersize=2.0, label="no window at all")
    if np.isfinite(band).all():
        axes.axhspan(*band, color="white", alpha=0.4, linewidth=0.0, zorder=3)
        for end, label in zip(band, ("serves enough between", "_"), strict=True):
            axes.axhline(end, color=INK, linewidth=0.8, linestyle=(0, (3, 2)), zorder=4, label=label)
    if np.isfinite(pretension):
        axes.axhline(pretension, color=INK, linewidth=0.9, zorder=4)
        axes.annotate(
            f"{pretension:.4g} N", (0.01, pretension), xycoords=("axes fraction", "data"), xytext=(0, 2),
            textcoords="offset points", ha="left", va="bottom", zorder=5,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.8},
        )  # fmt: skip
    axes.set_xlabel(f"{kind}, in the order of the least pretension they need (%)")
    axes.set_ylabel("window of pretension (N)")
    axes.set_xlim(0.0, 100.0)
    axes.set_ylim(bottom=0.0)
    if len(order):
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=2)
    if beyond := int(np.isnan(low).sum()):
        axes.set_title(f"{beyond} of {len(low)} {kind} stand nowhere: no pretension is possible", loc="left")


def _bodies(axes: Axes, bodies: tuple[Values, Values], labels: tuple[str, str], groups: Sequence[Group]) -> None:
    rest = np.ones(len(bodies[0]), dtype=np.bool_)
    for group in groups:
        rest[group.members] = False
    axes.plot(bodies[0][rest], bodies[1][rest], ".", color="#b8c4cc", markersize=2.0, label="served", zorder=1)
    for at, group in enumerate(groups):
        axes.plot(
            bodies[0][group.members], bodies[1][group.members], MARKERS[at % len(MARKERS)],
            color=OKABE_ITO[(at + 1) % len(OKABE_ITO)], markersize=3.2, markeredgewidth=0.0, zorder=2,
            label=plain(group.label, width=34),
        )  # fmt: skip
    axes.set_xlabel(plain(labels[0]))
    axes.set_ylabel(plain(labels[1]))
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=1)


def draw_how_sure(
    path: Path, title: str, pretension: Values, share: Values, low: Values, high: Values, chosen: float, enough: float,
    inputs: Sequence[str] = (), bars: Sequence[Bars] = (),
) -> Path:  # fmt: skip
    """The probability that a pretension (N) is in its window, with its 95 % band; beside it Sobol indices as bars.

    Raises OutputError, UsageError.
    """
    with house_style():
        figure = new_figure(PAGE_WIDTH, 80.0)
        panels = figure.subplots(1, 1 + len(bars), width_ratios=[1.6, *[1.0] * len(bars)], squeeze=False)[0]
        figure.suptitle(plain(title, width=110), x=0.01, ha="left")
        _probability(panels[0], pretension, share, low, high, chosen, enough)
        for at, each in enumerate(bars):
            _bars(panels[1 + at], each, inputs if at == 0 else [""] * len(inputs), is_first=at == 0)
    return save(figure, path)


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


def _bars(axes: Axes, bars: Bars, inputs: Sequence[str], *, is_first: bool) -> None:
    place = np.arange(len(inputs), dtype=np.float64)[::-1]
    for shift, values, errors, colour, label in (
        (0.2, bars.total, bars.total_error, OKABE_ITO[5], "total"),
        (-0.2, bars.first, bars.first_error, OKABE_ITO[0], "alone"),
    ):
        axes.barh(
            place + shift, 100 * values, 0.36, xerr=196 * errors, color=colour, label=label,
            error_kw={"elinewidth": 0.7, "capsize": 1.5},
        )  # fmt: skip
    axes.set_yticks(place, [plain(name, width=18) for name in inputs])
    axes.set_xlim(left=0.0)
    axes.set_xlabel("share of its variance (%)")
    axes.set_title(plain(bars.label), loc="left")
    if is_first:
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=2)


def draw_served_map(
    path: Path, title: str, x: Values, y: Values, served: Values, labels: tuple[str, str], best: tuple[float, float]
) -> Path:
    """The share that one pretension serves, 0 to 1, over two numbers of the choices; `served` is (len(y), len(x)).

    Raises OutputError, UsageError.
    """
    with house_style():
        figure = new_figure(110.0, 85.0)
        axes = figure.subplots()
        figure.suptitle(plain(title, width=70), x=0.01, ha="left")
        order_x, order_y = np.argsort(x), np.argsort(y)
        shares = 100.0 * served[np.ix_(order_y, order_x)]
        mesh = axes.pcolormesh(
            np.arange(len(x) + 1), np.arange(len(y) + 1), shares, cmap=SEQUENTIAL.reversed(), vmin=0.0, vmax=100.0
        )
        dark = shares < 45.0
        if served.size <= 150:
            for (row, column), share in np.ndenumerate(shares):
                axes.text(
                    column + 0.5, row + 0.5, f"{share:.3g}", ha="center", va="center", fontsize=6.0,
                    color="white" if dark[row, column] else INK,
                )  # fmt: skip
        for set_ticks, values in ((axes.set_xticks, x[order_x]), (axes.set_yticks, y[order_y])):
            every = max(1, len(values) // 10)
            set_ticks(np.arange(len(values))[::every] + 0.5, [f"{value:.4g}" for value in values[::every]])
        column, row = (int(np.argmin(np.abs(np.sort(of) - at))) for of, at in zip((x, y), best, strict=True))
        axes.plot(column + 0.5, row + 0.86, "v", color=INK, markersize=4.0)
        axes.set_xlabel(plain(labels[0]))
        axes.set_ylabel(plain(labels[1]))
        figure.colorbar(mesh, ax=axes, label="served by one pretension (%)")
    return save(figure, path)
