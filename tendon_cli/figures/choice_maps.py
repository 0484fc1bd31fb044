"""Maps of an answer's choices: how far the setting may be off, and the share that is served."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.cube.choice_grid import conflicts_of, served_words, upper_ends
from tendon_cli.cube.columns import ColumnArray
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import reading_unit
from tendon_cli.figures.answer_page import (
    answer_page,
    is_settable,
    long_axes,
    set_text,
    settable_label,
    star,
)
from tendon_cli.figures.backend import mpl
from tendon_cli.figures.frame import Page
from tendon_cli.figures.layout import has_many_rows, map_axes
from tendon_cli.figures.slices import (
    Area,
    Border,
    Colours,
    PanelGrid,
    Slice,
    draw_pages,
    grid_of,
)
from tendon_cli.figures.style import BLUES, INK, PAGE_WIDTH, largest
from tendon_cli.studies.space.axis import Axis
from tendon_cli.verbs.answer_record import AnswerRecord, ChoiceRecord

_PALE = ("#f6d9c5", "#e9e2f3", "#dcebe4", "#f7ecc8", "#e5e5e5", "#dbe7f3")
"""Background of cells without a window, one for each reason; further reasons share the last."""
_HATCHES = ("....", "----", "\\\\\\\\", "xxxx", "++++", "||||")
_FAULT_HATCHES = ("////", "\\\\\\\\", "xxxx")
"""Hatches of the kinds of failed advice; further kinds share the last."""
_MEANING = (
    "Colour: half the window, as a length taken from both tendons: how far the setting may be off "
    "on either side of the middle; in brackets, its share of the pretension. Pale: no pretension "
    "works for {}, for the reason given."
)
_NO_END = "Windows without an upper end have the darkest colour."
_COLUMNS = (
    "pretension_from",
    "pretension_to",
    "tolerance",
    "tolerance_length",
    "served",
    "from_by",
    "to_by",
    "advice",
)
"""Columns that maps read, as far as the answer has them."""


def grid_of_choices(
    cube: Cube, axes: tuple[Axis, Axis], width: float = PAGE_WIDTH
) -> tuple[PanelGrid, dict[str, ColumnArray]]:
    """Lay all choices out over two axes, and read their columns (panels, y, x)."""
    chosen = cube.choose([])
    grid = grid_of(cube, axes, chosen, width)
    return grid, cube.gather(grid.rows, [name for name in _COLUMNS if name in cube.columns])


def axes_of_choices(cube: Cube) -> tuple[Axis, Axis] | None:
    """Select the two longest axes of the choices; None if there are not two, or too many rows."""
    if has_many_rows(long_axes(cube)):
        return None
    return map_axes(cube, cube.choose([]))


def longest_tolerance(cube: Cube) -> float:
    """Return the largest bounded tolerance of all choices, m; 0 without one."""
    axes = axes_of_choices(cube)
    if axes is None:
        return 0.0
    _, read = grid_of_choices(cube, axes)
    return largest(read["tolerance_length"][read["pretension_from"] <= read["pretension_to"]])


def draw_tolerance(
    cube: Cube,
    record: AnswerRecord,
    chosen: ChoiceRecord,
    longest: float | None = None,
    axes: tuple[Axis, Axis] | None = None,
    width: float = PAGE_WIDTH,
) -> list[Page]:
    """Draw by how much the setting may be off.

    Cells without a window have a pale background for the reason.

    Args:
        cube: Choices of the answer.
        record: Record of the answer.
        chosen: The choice that the answer names first.
        longest: Tolerance at the end of the colour scale, m; None for the largest of the map.
        axes: Axes across and up; None for the two longest.
        width: Width of a page, mm.

    Returns:
        The pages; none if there are not two such axes.
    """
    axes = axes or axes_of_choices(cube)
    if axes is None:
        return []
    grid, read = grid_of_choices(cube, axes, width)
    low = read["pretension_from"]
    high = upper_ends(low, read["pretension_to"])
    has_window = low <= high
    length = np.where(np.isinf(high), np.inf, read["tolerance_length"])
    with np.errstate(invalid="ignore"):
        settable = is_settable(record, length, 0.5 * (high - low))
    if longest is None:
        longest = largest(length[has_window])
    decided = record.decided
    if longest == 0.0 and decided is not None:
        longest = decided.needed
    most = 1e3 * longest or 1.0
    values = np.where(has_window, np.minimum(1e3 * length, most), np.nan)
    reasons = conflicts_of(read, cube.limits)
    faults = np.where(has_window, read.get("advice", np.full(low.shape, "", dtype=object)), "")
    areas = [*_areas(reasons, _PALE, _HATCHES), *_areas(faults, ("none",), _FAULT_HATCHES)]
    label = f"inside the line: {settable_label(record)}"
    border = Border("settable", label, np.where(settable, -1.0, 1.0), INK, 1.6, has_ticks=False)
    part = _slice_of(
        grid,
        chosen,
        values,
        Colours(BLUES, mpl.colors.Normalize(0.0, most), "how far the setting may be off (± mm)"),
        areas=areas,
        borders=[border],
        texts=_tolerance_texts(low, high, length, read["tolerance"], reading_unit(cube.document)),
    )
    notes = [_MEANING.format(served_words(record)), *grid.notes]
    if np.isinf(high).any():
        notes.append(_NO_END)
    return _draw_map(cube, record, chosen, part, "how far the setting may be off", notes, width)


def draw_served(cube: Cube, record: AnswerRecord, chosen: ChoiceRecord) -> list[Page]:
    """Draw the largest share of the population that one pretension serves.

    Returns:
        The pages; none if there are not two axes, or if the answer is not for a population.
    """
    axes = axes_of_choices(cube)
    if axes is None or record.population is None:
        return []
    grid, read = grid_of_choices(cube, axes)
    percent = 100.0 * read["served"]
    texts = [f"{share:.3g} %" for share in np.nan_to_num(percent).ravel()]
    part = _slice_of(
        grid,
        chosen,
        percent,
        Colours(BLUES, mpl.colors.Normalize(0.0, 100.0), "served by one pretension (%)"),
        texts=(np.array(texts, dtype=object).reshape(percent.shape),),
        unknown="no value",
    )
    title = "the largest share that one pretension serves"
    return _draw_map(cube, record, chosen, part, title, list(grid.notes))


def _slice_of(
    grid: PanelGrid, chosen: ChoiceRecord, values: ColumnArray, colours: Colours, **more: Any
) -> Slice:
    """Return a slice of choices, drawn in cells, with a star at the choice named first."""
    star = None
    places = np.argwhere(grid.rows == chosen.choice)
    if chosen.feasible and len(places):
        panel, row, column = places[0].tolist()
        star = (panel, row, column)
    others = np.zeros(values.shape, dtype=np.bool_)
    return Slice(grid, values, colours, others, star=star, is_in_cells=True, **more)


def _draw_map(
    cube: Cube,
    record: AnswerRecord,
    chosen: ChoiceRecord,
    part: Slice,
    title: str,
    notes: Sequence[str],
    width: float = PAGE_WIDTH,
) -> list[Page]:
    """Draw the pages of a map of choices, and mark the choice named first in it."""

    def begin(seen: list[int], added: str, panels: float) -> Page:
        key = part.key(seen)
        if part.star is not None and part.star[0] in seen:
            key.append(star(set_text(cube, record, chosen)))
        return answer_page(cube, record, f"{title}{added}", panels, key, notes, width=width)

    return draw_pages(part, width, begin)


def _areas(kinds: ColumnArray, colours: Sequence[str], hatches: Sequence[str]) -> list[Area]:
    """Return an area for each kind of cell, by its words; "" is none."""
    areas = []
    for place, kind in enumerate(dict.fromkeys(str(kind) for kind in kinds.ravel() if kind)):
        style: Mapping[str, Any] = {
            "facecolor": colours[min(place, len(colours) - 1)],
            "hatch": hatches[min(place, len(hatches) - 1)],
            "edgecolor": "#8a8a8a" if len(colours) > 1 else INK,
        }
        areas.append(Area(kind, kind, style, np.asarray(kinds == kind)))
    return areas


def _tolerance_texts(
    low: ColumnArray, high: ColumnArray, length: ColumnArray, share: ColumnArray, unit: str
) -> tuple[npt.NDArray[Any], ...]:
    """Write each window with its tolerance in millimetres and percent; then ever shorter."""
    texts: list[tuple[str, str, str]] = []
    for values in zip(low.ravel(), high.ravel(), length.ravel(), share.ravel(), strict=True):
        first, last, tolerance, part = values
        least = _short(first)
        millimetres = f"{say.number(1e3 * tolerance, 2)} mm"
        if not first <= last:
            texts.append(("", "", ""))
        elif np.isinf(last):
            texts.append((f"from {least} {unit}\nno upper end", f"from {least} {unit}", least))
        else:
            window = f"{least}–{_short(last)} {unit}\n{millimetres}"
            percent = f"{100.0 * part:.0f} %"
            texts.append((f"{window} ({percent})", f"{window}\n{percent}", millimetres))
    forms = zip(*texts, strict=True)
    return tuple(np.array(form, dtype=object).reshape(low.shape) for form in forms)


def _short(value: float) -> str:
    """Write a number without decimals, or a small one to two digits."""
    return f"{value:.0f}" if abs(value) >= 10.0 or value == 0.0 else f"{value:.2g}"
