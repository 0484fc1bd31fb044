"""Figures of people and draws: whose window holds a pretension and whose does not, how probable that is, and why.

They are made of the record of an answer and of its table of persons, or of draws, by column (NaN and "" for null).
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.cube.axes import evenly
from tendon_cli.cube.choice_grid import pretension_name
from tendon_cli.cube.labels import plain
from tendon_cli.figures.backend import Axes, Line2D, Patch
from tendon_cli.figures.frame import Page, framed
from tendon_cli.figures.style import FAINT, INK, MARKERS, OKABE_ITO, house_style
from tendon_cli.quantities import QUANTITIES
from tendon_cli.tables.read import open_table
from tendon_cli.tables.schema import as_numpy

Values = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
Table = Mapping[str, npt.NDArray[Any]]

_SERVED, _LEFT_OUT = OKABE_ITO[0], OKABE_ITO[1]
_OF_BARS = {"total": ("with all others", OKABE_ITO[5]), "first": ("alone", OKABE_ITO[0])}
_LIMIT: dict[str, Any] = {"color": INK, "linewidth": 0.8, "linestyle": (0, (3, 2))}
_MOST_LINES, _MOST_REASONS = 4000, 4
_ROOM = 1.6
"""How far above the highest lower end the figure goes where windows have no upper end, as a factor."""
_USUAL = ("weight", "forearm_circumference")


def draw_population(folder: Path, record: dict[str, Any], out: Path) -> list[str]:
    """Draw what an answer in a folder says of persons or draws into another; raises InputError, OutputError."""
    kind = "persons" if "person" in record["population"]["counts"] else "draws"
    table = open_table(folder / f"{kind}.parquet").read()
    rows = {name: as_numpy(table.column(name)) for name in table.column_names}
    with house_style():
        pages = {"for_whom": for_whom(record, rows), "how_sure": how_sure(record)}
    return [page.save(out / f"{name}.png").name for name, page in pages.items()]


def _number(value: float | None) -> float:
    return np.nan if value is None else float(value)


def for_whom(record: Mapping[str, Any], rows: Table) -> Page:
    """Everyone's window as a line, N, the pretensions that serve enough shaded; next to it the bodies not served."""
    population, low = record["population"], rows["pretension_from"]
    pretension, kind = (
        _number(population["pretension"]),
        "draws" if population["kind"] == "draws" else "persons",
    )
    high = np.where(np.isnan(rows["pretension_to"]) & ~np.isnan(low), np.inf, rows["pretension_to"])
    served, band = (
        rows["served"] >= min(1.0, record["serve"]) - 1e-9,
        [*map(_number, population["window"])],
    )
    has_window, nowhere = ~np.isnan(low) & (low <= high), int(np.isnan(low).sum())
    key: list[Any] = [
        Patch(facecolor=colour, label=label)
        for colour, label, those in (
            (_SERVED, "served", served),
            (_LEFT_OUT, "window elsewhere", has_window & ~served),
            (
                FAINT,
                "no window: by how much the upper end lies below the lower one",
                ~has_window & ~np.isnan(low),
            ),
        )
        if those.any()
    ]
    key += (
        [Line2D([], [], label="serves enough between", **_LIMIT)] if np.isfinite(band).all() else []
    )
    reasons = population["not_served"][:_MOST_REASONS] if "weight" in rows and len(low) > 2 else []
    signs: list[dict[str, Any]] = [
        {
            "marker": MARKERS[at % len(MARKERS)],
            "color": OKABE_ITO[(at + 1) % len(OKABE_ITO)],
            "linestyle": "",
            "markersize": 3.2,
            "markeredgewidth": 0.0,
        }
        for at in range(len(reasons))
    ]
    for reason, sign in zip(reasons, signs, strict=True):
        key.append(Line2D([], [], label=plain(reason["text"], width=60, lines=2), **sign))
    notes = (
        [f"{nowhere} of {len(low)} {kind} have no pretension at all at which the arm balances."]
        if nowhere
        else []
    )
    page = framed(population["title"], 68.0, key, notes)
    has_bodies = "weight" in rows and len(low) > 2
    shape: dict[str, Any] = {"ncols": 2, "width_ratios": [1.5, 1.0]} if has_bodies else {}
    panels = page.figure.subplots(1, squeeze=False, **shape)[0]
    _windows(panels[0], low, high, served, (band[0], band[1]), pretension)
    is_set = pretension_name(record["study"])
    panels[0].set_ylabel(f"{is_set} (N)")
    if len(low) > 1:
        panels[0].set_xlabel(
            f"{kind}, in the order of the least {is_set.partition(' ')[0]} they need (%)"
        )
    if has_bodies:
        groups = [members(rows, reason, pretension) for reason in reasons]
        _bodies(panels[1], population, rows, groups, signs)
    return page


def _bodies(
    axes: Axes, population: Mapping[str, Any], rows: Table, groups: list[Any], signs: list[Any]
) -> None:
    """Everyone by the two dimensions in which those not served differ most, whatever the reason."""
    apart = dict.fromkeys(_USUAL, 0.0)
    for reason in population["not_served"]:
        for name, each in reason["bodies"].items():
            apart[name] = apart.get(name, 0.0) + reason["share"] * abs(each["deviations"])
    names = sorted(apart, key=lambda name: -apart[name])[:2]
    x, y = (rows[name] / say.factor_of(QUANTITIES[name]) for name in names)
    rest = ~np.isin(np.arange(len(x)), np.concatenate([[-1], *groups]))
    axes.plot(x[rest], y[rest], ".", color=_SERVED, alpha=0.5, markersize=2.5, zorder=1)
    for those, sign in zip(groups, signs, strict=True):
        axes.plot(x[those], y[those], zorder=2, **sign)
    labels = [plain(f"{say.column(name)} ({QUANTITIES[name].shown_in})") for name in names]
    axes.set(xlabel=labels[0], ylabel=labels[1])


def members(rows: Table, reason: Mapping[str, Any], pretension: float) -> npt.NDArray[np.int64]:
    """Who of a table is not served by a pretension (N) for a reason of the record, as places in it."""
    low, high, limits = rows["pretension_from"], rows["pretension_to"], reason["limits"]
    with np.errstate(invalid="ignore"):
        has_window = ~np.isnan(low) & ~(low > high)
        chosen = {
            "more": has_window & (low > pretension) & (rows["from_by"] == limits[0]),
            "less": has_window & (high < pretension) & (rows["to_by"] == limits[0]),
            "another suit": ~has_window
            & (rows["from_by"] == limits[0])
            & np.isin(rows["to_by"], [*limits, ""]),
        }[reason["needs"]]
    return np.flatnonzero((rows["served"] < 1.0) & chosen)


def _windows(
    axes: Axes,
    low: Values,
    high: Values,
    served: Flags,
    band: tuple[float, float],
    pretension: float,
) -> None:
    able = np.flatnonzero(~np.isnan(low))
    order = able[np.lexsort((high[able], low[able]))]
    order = order[evenly(len(order), _MOST_LINES)]
    place = (np.arange(len(order)) + 0.5) / max(len(order), 1) * 100.0
    top = _ROOM * float(np.nanmax(low, initial=pretension if np.isfinite(pretension) else 1.0))
    ends = np.minimum(high[order], max(top, float(np.max(high[np.isfinite(high)], initial=0.0))))
    begin, has_window, width = (
        low[order],
        low[order] <= high[order],
        max(0.25, 230.0 / max(len(order), 1)),
    )
    for chosen, colour in ((served[order], _SERVED), (has_window & ~served[order], _LEFT_OUT)):
        axes.vlines(place[chosen], begin[chosen], ends[chosen], colors=colour, linewidth=width)
    axes.vlines(
        place[~has_window],
        ends[~has_window],
        begin[~has_window],
        colors=FAINT,
        linewidth=min(width, 1.5),
    )
    if np.isfinite(band).all():
        axes.axhspan(*band, color="white", alpha=0.4, linewidth=0.0, zorder=3)
        for end in band:
            axes.axhline(end, zorder=4, **_LIMIT)
    if np.isfinite(pretension):
        axes.axhline(pretension, color=INK, linewidth=0.9, zorder=4)
        axes.annotate(
            f"{pretension:.4g} N",
            (0.01, pretension),
            xycoords=("axes fraction", "data"),
            xytext=(0, 2),
            textcoords="offset points",
            ha="left",
            va="bottom",
            zorder=5,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.8},
        )
    axes.set(xlim=(0.0, 100.0))
    axes.set_ylim(0.0, max(axes.get_ylim()[1], 1.05 * float(begin.max(initial=0.0))))
    if len(low) == 1:
        axes.set_xticks([])


def how_sure(record: Mapping[str, Any]) -> Page:
    """The probability that a pretension (N) is in its window, with its 95 % band; next to it Sobol indices as bars."""
    population = record["population"]
    ends = population["sobol"]
    key = (
        [Patch(facecolor=colour, label=label) for label, colour in _OF_BARS.values()]
        if ends
        else []
    )
    page = framed(population["title"], 66.0, key)
    panels = page.figure.subplots(
        1, 1 + len(ends), width_ratios=[1.6, *[1.0] * len(ends)], squeeze=False
    )[0]
    pretension, *shares = (
        np.array(population["curve"][name]) for name in ("pretension", "share", "low", "high")
    )
    _probability(
        panels[0],
        pretension,
        100 * np.array(shares),
        _number(population["pretension"]),
        100 * record["serve"],
    )
    panels[0].set_xlabel(f"{pretension_name(record['study'])} (N)")
    for at, (axes, end) in enumerate(zip(panels[1:], ends, strict=True)):
        _bars(axes, end, with_names=at == 0)
    return page


def _bars(axes: Axes, end: Mapping[str, Any], *, with_names: bool) -> None:
    """What share of the variance of one end of the window each input makes."""
    inputs = end["inputs"].values()
    place = np.arange(len(inputs), dtype=np.float64)[::-1]
    for shift, (order, (_, colour)) in zip((0.2, -0.2), _OF_BARS.items(), strict=True):
        share, error = (
            np.array([each[name] for each in inputs]) for name in (order, f"{order}_standard_error")
        )
        style: dict[str, Any] = {"color": colour, "error_kw": {"elinewidth": 0.7, "capsize": 1.5}}
        axes.barh(place + shift, 100 * share, 0.36, xerr=196 * error, **style)
    axes.set_yticks(place, [plain(each["name"], width=18) if with_names else "" for each in inputs])
    axes.set(xlabel="share of its variance (%)")
    axes.set_xlim(left=0.0)
    which = "lower" if end["end"] == "pretension_from" else "upper"
    axes.set_title(
        plain(f"{which} end, ± {say.number(end['standard_deviation'], 2)} N"), loc="left"
    )


def _probability(
    axes: Axes, pretension: Values, percent: Values, chosen: float, enough: float
) -> None:
    share, low, high = percent
    axes.fill_between(pretension, low, high, step="post", color=_SERVED, alpha=0.22, linewidth=0.0)
    axes.plot(pretension, share, drawstyle="steps-post", color=_SERVED)
    axes.axhline(enough, color=FAINT, linestyle=(0, (4, 3)), linewidth=0.8)
    beside: dict[str, Any] = {"textcoords": "offset points"}
    axes.annotate(
        f"enough: {enough:g} %",
        (0.99, enough),
        xycoords=("axes fraction", "data"),
        xytext=(0, 2),
        color=FAINT,
        ha="right",
        **beside,
    )
    if np.isfinite(chosen):
        axes.axvline(chosen, color=INK, linewidth=0.9)
        axes.annotate(
            f"{chosen:.4g} N",
            (chosen, 0.02),
            xycoords=("data", "axes fraction"),
            xytext=(3, 0),
            **beside,
        )
    if len(pretension) and pretension[0] < pretension[-1]:
        axes.set_xlim(pretension[0], pretension[-1])
    axes.set(ylim=(0.0, 104.0), ylabel="in the window (%), band of 95 %")
