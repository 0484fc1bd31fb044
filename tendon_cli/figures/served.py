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
from tendon_cli.cube.choice_grid import pretension_name, upper_ends
from tendon_cli.cube.labels import plain, with_symbols
from tendon_cli.figures.answer_page import gauge_text
from tendon_cli.figures.backend import Axes, Line2D, Patch
from tendon_cli.figures.frame import Page, framed, panels_of, source_of
from tendon_cli.figures.style import FAINT, INK, MARKERS, OKABE_ITO, house_style, key_line, largest
from tendon_cli.model.kinematics import Array
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.space.axis import evenly_spaced
from tendon_cli.tables.read import open_table
from tendon_cli.tables.schema import as_numpy
from tendon_cli.verbs.answer_record import (
    AnswerRecord,
    ChoiceRecord,
    PopulationRecord,
    ReasonRecord,
    SobolRecord,
    as_read,
    population_of,
)
from tendon_cli.verbs.registry import by_name

Table = Mapping[str, npt.NDArray[Any]]

_ENDS = ("pretension_from", "pretension_to")
_SERVED = OKABE_ITO[5]
_CURVE = OKABE_ITO[0]
_LEFT_OUT = OKABE_ITO[1]
_INDICES = {"total": ("with all others", OKABE_ITO[5]), "first": ("alone", OKABE_ITO[0])}
"""Sobol indices: text in the key, and colour."""
_ENOUGH: dict[str, Any] = {"color": FAINT, "linestyle": (0, (4, 3)), "linewidth": 0.8}
_LIMIT: dict[str, Any] = {"color": INK, "linewidth": 0.8, "linestyle": (0, (3, 2))}
_ERRORS: dict[str, Any] = {"error_kw": {"elinewidth": 0.7, "capsize": 1.5}}
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


def _on_gauge(best: ChoiceRecord, pretensions: Array) -> Array:
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

    The pretensions (N) that serve enough are between two lines.

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
    groups = [
        (is_served, _SERVED, "served"),
        ((low <= high) & ~is_served, _LEFT_OUT, "window elsewhere"),
        (low > high, FAINT, "no window: by how much the upper end lies below the lower one"),
    ]
    band = [_nan_if_null(end) for end in population.window]
    has_bodies = "weight" in rows and len(low) >= _FEWEST_BODIES
    reasons = population.not_served[:_MOST_REASONS] if has_bodies else []
    styles = [_reason_style(place) for place in range(len(reasons))]
    key: list[Any] = [
        Patch(facecolor=colour, label=label) for holds, colour, label in groups if holds.any()
    ]
    if np.isfinite(band).all():
        label = f"between these lines at least {say.percent(record.serve)} of them are served"
        key.append(key_line(label=label, **_LIMIT))
    key += _key_of_setting(record, pretension)
    for reason, style in zip(reasons, styles, strict=True):
        key.append(key_line(label=with_symbols(reason.text, width=60, lines=2), **style))
    balanced = np.flatnonzero(~np.isnan(low))
    unbalanced = len(low) - len(balanced)
    notes = []
    if unbalanced:
        notes.append(
            f"For {unbalanced} of {len(low)} {kind} the arm balances at no pretension at all."
        )
    if len(balanced) > _MOST_LINES:
        notes.append(
            f"Shown: {_MOST_LINES:,} of {len(balanced):,} windows, evenly spaced in their order."
        )
    page = framed(population.title, 68.0, key, notes, study=source_of(record), is_of_answer=True)
    widths = [1.5, 1.0] if has_bodies else [1.0]
    panels = panels_of(page, 1, len(widths), len(widths), width_ratios=widths)
    order = balanced[np.lexsort((high[balanced], low[balanced]))]
    order = order[evenly_spaced(len(order), _MOST_LINES)]
    place = (np.arange(len(order)) + 0.5) / max(len(order), 1) * 100.0
    least = pretension if np.isfinite(pretension) else 1.0
    top = max(
        _ROOM * largest([*low, least]),
        largest(high),
    )
    width = max(0.25, 230.0 / max(len(order), 1))
    axes = panels[0]
    for holds, colour, _ in groups:
        part = holds[order]
        ends = np.minimum(high[order], top)[part]
        axes.vlines(place[part], low[order][part], ends, colors=colour, linewidth=width)
    for bound in band:
        axes.axhline(bound, zorder=4, **_LIMIT)
    axes.axhline(pretension, color=INK, linewidth=0.9, zorder=4)
    name = _reading_name(record)
    axes.set(
        xlim=(0.0, 100.0),
        ylim=(0.0, max(axes.get_ylim()[1], 1.05 * float(low[order].max(initial=0.0)))),
        ylabel=f"{name} ({record.question.unit})",
        xlabel=f"{kind}, sorted by the least {name.partition(' in the ')[0]} they need (%)",
    )
    if has_bodies:
        of_reasons = [members(rows, reason, pretension) for reason in reasons]
        _draw_bodies(panels[1], population, rows, of_reasons, styles)
    return page


def _key_of_setting(record: AnswerRecord, pretension: float) -> list[Line2D]:
    """Return the key to the line of the pretension that is set, if there is one."""
    if not np.isfinite(pretension):
        return []
    best = record.best
    question = record.question
    text = f"{say.number(pretension, question.setting_digits)} {question.unit}"
    label = f"set: {(best and gauge_text(record, best)) or text}"
    return [key_line(color=INK, linewidth=0.9, label=label)]


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
    axes.plot(x, y, ".", zorder=1, color=_SERVED, alpha=0.5, markersize=2.5)
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


def how_sure(record: AnswerRecord) -> Page:
    """Draw the probability that a pretension (N) is in the window, with its 95 % band.

    Next to it Sobol indices are drawn as bars, if the record has them.
    """
    population = population_of(record)
    ends = population.sobol
    pretension = _nan_if_null(population.pretension)
    enough = 100.0 * record.serve
    key: list[Any] = [key_line(label=f"enough: {enough:g} %", **_ENOUGH)]
    key += _key_of_setting(record, pretension)
    if ends:
        key += [Patch(facecolor=colour, label=label) for label, colour in _INDICES.values()]
    page = framed(population.title, 66.0, key, study=source_of(record), is_of_answer=True)
    widths = [1.6, *[1.0] * len(ends)]
    axes, *panels = panels_of(page, 1, len(widths), len(widths), width_ratios=widths)
    for place, (panel, end) in enumerate(zip(panels, ends, strict=True)):
        _draw_bars(panel, end, record.question.unit, with_names=place == 0)
    curve = population.curve
    along = np.array(curve.pretension)
    share, low, high = (100.0 * np.array(values) for values in (curve.share, curve.low, curve.high))
    axes.fill_between(along, low, high, step="post", color=_CURVE, alpha=0.22, linewidth=0.0)
    axes.plot(along, share, drawstyle="steps-post", color=_CURVE)
    axes.axhline(enough, **_ENOUGH)
    axes.axvline(pretension, color=INK, linewidth=0.9)
    if len(along) and along[0] < along[-1]:
        axes.set_xlim(along[0], along[-1])
    axes.set_ylim(0.0, 104.0)
    axes.set_ylabel("share in the window (%), 95 % band")
    axes.set_xlabel(f"{_reading_name(record)} ({record.question.unit})")
    return page


def _draw_bars(axes: Axes, end: SobolRecord, unit: str, *, with_names: bool) -> None:
    """Draw the Sobol indices of one end of the window, in per cent of its variance."""
    inputs = end.inputs.values()
    place = np.arange(len(inputs), dtype=np.float64)[::-1]
    for shift, (order, (_, colour)) in zip((0.2, -0.2), _INDICES.items(), strict=True):
        share = np.array([getattr(item, order) for item in inputs])
        error = np.array([getattr(item, f"{order}_standard_error") for item in inputs])
        axes.barh(place + shift, 100 * share, 0.36, xerr=196 * error, color=colour, **_ERRORS)
    names = [plain(item.name, width=18) if with_names else "" for item in inputs]
    axes.set_yticks(place, names)
    axes.set(xlabel="share of its variance (%)")
    axes.set_xlim(left=0.0)
    which = "lower" if end.end == "pretension_from" else "upper"
    deviation = say.number(end.standard_deviation, 2)
    axes.set_title(plain(f"{which} end, ± {deviation} {unit}"), loc="left")
