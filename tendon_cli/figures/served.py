"""Figures of a population: who is served by a pretension, how probable that is, and why not all.

They are drawn from the record of an answer and from its table of persons, or of draws, by column
(NaN and "" for null).
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.answer_record import (
    AnswerRecord,
    ChoiceRecord,
    PopulationRecord,
    ReasonRecord,
    SobolRecord,
    as_read,
    population_of,
)
from tendon_cli.cube.choice_grid import pretension_name, upper_ends
from tendon_cli.cube.labels import plain, with_symbols
from tendon_cli.figures.answer_page import gauge_text
from tendon_cli.figures.backend import Axes, Line2D, Patch
from tendon_cli.figures.frame import Page, framed, source_of
from tendon_cli.figures.style import FAINT, INK, MARKERS, OKABE_ITO, house_style
from tendon_cli.model.kinematics import Flags
from tendon_cli.quantities import QUANTITIES
from tendon_cli.registry import by_name
from tendon_cli.space.axis import evenly_spaced
from tendon_cli.tables.read import open_table
from tendon_cli.tables.schema import as_numpy

Values = npt.NDArray[np.float64]
Table = Mapping[str, npt.NDArray[Any]]

_ENDS = ("pretension_from", "pretension_to")
_SERVED = OKABE_ITO[5]
_CURVE = OKABE_ITO[0]
_LEFT_OUT = OKABE_ITO[1]
_INDICES = {"total": ("with all others", OKABE_ITO[5]), "first": ("alone", OKABE_ITO[0])}
"""Sobol indices: text in the key, and colour."""
_ENOUGH: dict[str, Any] = {"color": FAINT, "linestyle": (0, (4, 3)), "linewidth": 0.8}
_LIMIT: dict[str, Any] = {"color": INK, "linewidth": 0.8, "linestyle": (0, (3, 2))}
_PAPER: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.8}
"""Background of a text in a panel."""
_MOST_LINES = 4000
_MOST_REASONS = 4
_FEWEST_BODIES = 3
"""Fewest persons whose bodies are drawn."""
_ROOM = 1.6
"""Height of the figure over the highest lower end if windows have no upper end, as a factor."""
_USUAL = ("weight", "forearm_circumference")
"""Dimensions of the body that are drawn if those not served differ in none."""


def draw_population(
    name: str, folder: Path, record: AnswerRecord, known: Mapping[str, Any]
) -> list[Page]:
    """Draw the persons or draws of the answer in a folder, or how sure the answer is of them.

    Args:
        name: "for_whom" or "how_sure".
        folder: The folder.
        record: Record of the answer.
        known: The same as the folder has it.

    Raises:
        InputError: The table is damaged or missing.
    """
    if name == "how_sure":
        with house_style():
            return [how_sure(as_read(record))]
    kind = "persons" if "person" in population_of(record).counts else "draws"
    table = open_table(folder / f"{kind}.parquet", by_name(known)).read()
    rows = {name: as_numpy(table.column(name)) for name in table.column_names}
    if record.question.shows_own_f0 and record.best is not None:
        rows |= {name: _on_gauge(record.best, rows[name]) for name in _ENDS}
    with house_style():
        return [for_whom(as_read(record), rows)]


def _reading_name(record: AnswerRecord) -> str:
    """Return the label of what is set, without its unit."""
    return pretension_name({"setting": {"read": record.question.read}})


def _on_gauge(best: ChoiceRecord, pretensions: Values) -> Values:
    """Return F0 of the study's own arm, N, as a gauge in the flexor shows it: a line in F0."""
    shown = best.set_flexor_tension
    least = best.set_flexor_tension_from
    if best.pretension is None or best.pretension_from is None or shown is None or least is None:
        return pretensions
    distance = best.pretension - best.pretension_from
    gain = (shown - least) / distance if distance else 1.0
    return np.asarray(shown + gain * (pretensions - best.pretension))


def _nan_if_null(value: float | None) -> float:
    """Return a value of the record, or NaN for null."""
    return np.nan if value is None else float(value)


def for_whom(record: AnswerRecord, rows: Table) -> Page:
    """Draw everyone's window as a line, and next to it the bodies of those not served, if known.

    The pretensions (N) that serve enough are shaded.

    Args:
        record: Record of the answer.
        rows: Table of persons, or of draws, by column.
    """
    population = population_of(record)
    pretension = _nan_if_null(population.pretension)
    kind = "draws" if population.kind == "draws" else "persons"
    low = rows["pretension_from"]
    high = upper_ends(low, rows["pretension_to"])
    is_served = rows["served"] >= min(1.0, record.serve) - 1e-9
    band_low, band_high = map(_nan_if_null, population.window)
    band = (band_low, band_high)
    has_bodies = "weight" in rows and len(low) >= _FEWEST_BODIES
    reasons = population.not_served[:_MOST_REASONS] if has_bodies else []
    styles = [_reason_style(place) for place in range(len(reasons))]
    key = _window_key(low, high, is_served)
    if np.isfinite(band).all():
        label = f"between these lines at least {say.percent(record.serve)} of them are served"
        key.append(Line2D([], [], label=label, **_LIMIT))
    best = record.best
    if best is not None and gauge_text(record, best):
        label = f"set: {gauge_text(record, best)}"
        key.append(Line2D([], [], color=INK, linewidth=0.9, label=label))
    for reason, style in zip(reasons, styles, strict=True):
        key.append(Line2D([], [], label=with_symbols(reason.text, width=60, lines=2), **style))
    unbalanced = int(np.isnan(low).sum())
    notes = []
    if unbalanced:
        notes.append(
            f"For {unbalanced} of {len(low)} {kind} the arm balances at no pretension at all."
        )
    balanced = len(low) - unbalanced
    if balanced > _MOST_LINES:
        notes.append(
            f"Shown: {_MOST_LINES:,} of {balanced:,} windows, evenly spaced in their order."
        )
    page = framed(population.title, 68.0, key, notes, study=source_of(record), is_of_answer=True)
    shape: dict[str, Any] = {"ncols": 2, "width_ratios": [1.5, 1.0]} if has_bodies else {}
    panels = page.figure.subplots(1, squeeze=False, **shape)[0]
    set_to = _setting_text(record, pretension)
    _draw_windows(panels[0], low, high, is_served, band, pretension, set_to)
    name = _reading_name(record)
    panels[0].set_ylabel(f"{name} ({record.question.unit})")
    if len(low) > 1:
        read = name.partition(" in the ")[0]
        panels[0].set_xlabel(f"{kind}, sorted by the least {read} they need (%)")
    if has_bodies:
        groups = [members(rows, reason, pretension) for reason in reasons]
        _draw_bodies(panels[1], population, rows, groups, styles)
    return page


def _window_key(low: Values, high: Values, is_served: Flags) -> list[Any]:
    """Return the key to the kinds of windows that are in the figure."""
    is_known = ~np.isnan(low)
    has_window = is_known & (low <= high)
    entries = (
        (_SERVED, "served", is_served),
        (_LEFT_OUT, "window elsewhere", has_window & ~is_served),
        (
            FAINT,
            "no window: by how much the upper end lies below the lower one",
            ~has_window & is_known,
        ),
    )
    return [
        Patch(facecolor=colour, label=label)
        for colour, label, is_member in entries
        if is_member.any()
    ]


def _reason_style(place: int) -> dict[str, Any]:
    """Return the marker of those who are not served, by the index of the reason."""
    return {
        "marker": MARKERS[(place + 1) % len(MARKERS)],
        "color": OKABE_ITO[(place + 1) % len(OKABE_ITO)],
        "linestyle": "",
        "markersize": 3.6,
        "markeredgecolor": INK,
        "markeredgewidth": 0.4,
    }


def _draw_bodies(
    axes: Axes,
    population: PopulationRecord,
    rows: Table,
    groups: list[npt.NDArray[np.int64]],
    styles: list[dict[str, Any]],
) -> None:
    """Draw everyone by the two dimensions of the body in which those not served differ most.

    Args:
        axes: The panel.
        population: Part of the record about the population.
        rows: Table of persons by column.
        groups: Rows of those not served, by reason.
        styles: Marker of each group.
    """
    deviations = dict.fromkeys(_USUAL, 0.0)
    for reason in population.not_served:
        for name, body in reason.bodies.items():
            weighted = reason.share * abs(body.deviations)
            deviations[name] = deviations.get(name, 0.0) + weighted
    names = sorted(deviations, key=lambda name: -deviations[name])[:2]
    x, y = (rows[name] / say.factor_of(QUANTITIES[name]) for name in names)
    is_rest = np.ones(len(x), dtype=np.bool_)
    for group in groups:
        is_rest[group] = False
    dots: dict[str, Any] = {"color": _SERVED, "alpha": 0.5, "markersize": 2.5}
    axes.plot(x[is_rest], y[is_rest], ".", zorder=1, **dots)
    for group, style in zip(groups, styles, strict=True):
        axes.plot(x[group], y[group], zorder=2, **style)
    labels = [plain(f"{say.column(name)} ({QUANTITIES[name].shown_in})") for name in names]
    axes.set(xlabel=labels[0], ylabel=labels[1])


def members(rows: Table, reason: ReasonRecord, pretension: float) -> npt.NDArray[np.int64]:
    """Return the rows of those whom a pretension does not serve, for the given reason.

    Args:
        rows: Table of persons, or of draws, by column.
        reason: A reason of the record: need (more, less, another suit) and the limits that bind.
        pretension: The pretension, N.
    """
    low = rows["pretension_from"]
    high = rows["pretension_to"]
    limits = reason.limits
    needs = reason.needs
    with np.errstate(invalid="ignore"):
        has_window = ~np.isnan(low) & ~(low > high)
        if needs == "more":
            fits = has_window & (low > pretension) & (rows["from_by"] == limits[0])
        elif needs == "less":
            fits = has_window & (high < pretension) & (rows["to_by"] == limits[0])
        else:  # another suit
            is_upper = np.isin(rows["to_by"], [*limits, ""])
            fits = ~has_window & (rows["from_by"] == limits[0]) & is_upper
    return np.flatnonzero((rows["served"] < 1.0) & fits)


def _setting_text(record: AnswerRecord, pretension: float) -> str:
    """Say a pretension that is set by the digits of the answer, such as "36.4 N"."""
    question = record.question
    return f"{say.number(pretension, question.setting_digits)} {question.unit}"


def _draw_windows(
    axes: Axes,
    low: Values,
    high: Values,
    is_served: Flags,
    band: tuple[float, float],
    pretension: float,
    set_to: str,
) -> None:
    """Draw windows as lines, in the order of their lower ends.

    Args:
        axes: The panel.
        low: Lower ends, N; NaN where no pretension balances the arm.
        high: Upper ends, N; infinite where nothing bounds a window.
        is_served: True for those whom the pretension serves.
        band: Pretensions that serve enough, N; NaN if there are none.
        pretension: The pretension chosen, N; NaN if there is none.
        set_to: The pretension chosen in words.
    """
    balanced = np.flatnonzero(~np.isnan(low))
    order = balanced[np.lexsort((high[balanced], low[balanced]))]
    order = order[evenly_spaced(len(order), _MOST_LINES)]
    place = (np.arange(len(order)) + 0.5) / max(len(order), 1) * 100.0
    least = pretension if np.isfinite(pretension) else 1.0
    highest = float(np.max(high[np.isfinite(high)], initial=0.0))
    top = _ROOM * float(np.nanmax(low, initial=least))
    begin = low[order]
    end = np.minimum(high[order], max(top, highest))
    has_window = low[order] <= high[order]
    width = max(0.25, 230.0 / max(len(order), 1))
    served = is_served[order]
    for holds, colour, thickness in (
        (served, _SERVED, width),
        (has_window & ~served, _LEFT_OUT, width),
        (~has_window, FAINT, min(width, 1.5)),
    ):
        style: dict[str, Any] = {"colors": colour, "linewidth": thickness}
        axes.vlines(place[holds], begin[holds], end[holds], **style)
    if np.isfinite(band).all():
        for bound in band:
            axes.axhline(bound, zorder=4, **_LIMIT)
    if np.isfinite(pretension):
        axes.axhline(pretension, color=INK, linewidth=0.9, zorder=4)
        axes.annotate(
            set_to,
            (0.01, pretension),
            xycoords=("axes fraction", "data"),
            xytext=(0, 2),
            textcoords="offset points",
            ha="left",
            va="bottom",
            zorder=5,
            bbox=_PAPER,
        )
    axes.set_xlim(0.0, 100.0)
    axes.set_ylim(0.0, max(axes.get_ylim()[1], 1.05 * float(begin.max(initial=0.0))))
    if len(low) == 1:
        axes.set_xticks([])


def how_sure(record: AnswerRecord) -> Page:
    """Draw the probability that a pretension (N) is in the window, with its 95 % band.

    Next to it Sobol indices are drawn as bars, if the record has them.
    """
    population = population_of(record)
    ends = population.sobol
    enough = f"enough: {100.0 * record.serve:g} %"
    key: list[Any] = [Line2D([], [], label=enough, **_ENOUGH)]
    if ends:
        key += [Patch(facecolor=colour, label=label) for label, colour in _INDICES.values()]
    page = framed(population.title, 66.0, key, study=source_of(record), is_of_answer=True)
    widths = [1.6, *[1.0] * len(ends)]
    panels = page.figure.subplots(1, len(widths), width_ratios=widths, squeeze=False)[0]
    _draw_probability(panels[0], record)
    for place, (axes, end) in enumerate(zip(panels[1:], ends, strict=True)):
        _draw_bars(axes, end, record.question.unit, with_names=place == 0)
    return page


def _draw_bars(axes: Axes, end: SobolRecord, unit: str, *, with_names: bool) -> None:
    """Draw the Sobol indices of one end of the window, in per cent of its variance."""
    inputs = end.inputs.values()
    place = np.arange(len(inputs), dtype=np.float64)[::-1]
    for shift, (order, (_, colour)) in zip((0.2, -0.2), _INDICES.items(), strict=True):
        share = np.array([getattr(item, order) for item in inputs])
        error = np.array([getattr(item, f"{order}_standard_error") for item in inputs])
        style: dict[str, Any] = {"color": colour, "error_kw": {"elinewidth": 0.7, "capsize": 1.5}}
        axes.barh(place + shift, 100 * share, 0.36, xerr=196 * error, **style)
    names = [plain(item.name, width=18) if with_names else "" for item in inputs]
    axes.set_yticks(place, names)
    axes.set(xlabel="share of its variance (%)")
    axes.set_xlim(left=0.0)
    which = "lower" if end.end == "pretension_from" else "upper"
    deviation = say.number(end.standard_deviation, 2)
    axes.set_title(plain(f"{which} end, ± {deviation} {unit}"), loc="left")


def _draw_probability(axes: Axes, record: AnswerRecord) -> None:
    """Draw the probability that a pretension is in the window, and the pretension chosen."""
    population = population_of(record)
    curve = population.curve
    pretension = np.array(curve.pretension)
    share = 100 * np.array(curve.share)
    low = 100 * np.array(curve.low)
    high = 100 * np.array(curve.high)
    chosen = _nan_if_null(population.pretension)
    enough = 100 * record.serve
    axes.fill_between(pretension, low, high, step="post", color=_CURVE, alpha=0.22, linewidth=0.0)
    axes.plot(pretension, share, drawstyle="steps-post", color=_CURVE)
    axes.axhline(enough, **_ENOUGH)
    if np.isfinite(chosen):
        axes.axvline(chosen, color=INK, linewidth=0.9)
        axes.annotate(
            _setting_text(record, chosen),
            (chosen, 0.02),
            xycoords=("data", "axes fraction"),
            xytext=(3, 0),
            textcoords="offset points",
        )
    if len(pretension) and pretension[0] < pretension[-1]:
        axes.set_xlim(pretension[0], pretension[-1])
    axes.set_ylim(0.0, 104.0)
    axes.set_ylabel("share in the window (%), 95 % band")
    axes.set_xlabel(f"{_reading_name(record)} ({record.question.unit})")
