"""Maps of the designs of a run: by how much they are taut or slack, which limits they break."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.cube import labels
from tendon_cli.cube.columns import ColumnArray
from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import ColumnLabel, as_read, reading, symbol
from tendon_cli.cube.outcomes import (
    EXTENSOR_SLACK,
    FLEXOR_SLACK,
    OF_OUTCOMES,
    OUTCOMES,
    is_flexor_slack,
    outcomes,
)
from tendon_cli.cube.room import bounded_column, is_default, sign_of
from tendon_cli.errors import UsageError
from tendon_cli.figures.backend import mpl
from tendon_cli.figures.frame import Page, framed
from tendon_cli.figures.limit_remarks import crosses_zero, limit_remarks
from tendon_cli.figures.scales import caption
from tendon_cli.figures.slices import (
    Area,
    Border,
    Colours,
    PanelGrid,
    Slice,
    draw_pages,
    grid_of,
)
from tendon_cli.figures.style import BLUES, INK, LIMIT_COLOURS, MARGIN, MARGIN_FLEXOR
from tendon_cli.model.kinematics import Array, Rows
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.figures import FigureSpec
from tendon_cli.studies.space.axis import Axis

OF_MARGIN = "margin"
STIFFNESS = "min_elbow_stiffness"
_UNSTABLE: dict[str, Any] = {
    "facecolor": "none",
    "hatch": "xxxx",
    "edgecolor": LIMIT_COLOURS[0],
}
_FLEXOR: dict[str, Any] = {"facecolor": "none", "hatch": "...", "edgecolor": FLEXOR_SLACK.colour}


def draw_maps(
    cube: Cube,
    axes: tuple[Axis, Axis],
    chosen: Mapping[str, Rows],
    spec: FigureSpec,
    width: float,
    height: float | None,
) -> list[Page]:
    """Draw the pages of a map of designs.

    Args:
        cube: The table of designs.
        axes: Axes across and up.
        chosen: Positions to choose from, by the column of the axis.
        spec: The figure as the user asks for it.
        width: Width of a page, mm.
        height: Height of a page, mm; None if the panels may have their usual height.

    Raises:
        UsageError: The table does not have what the map shows, or nothing of it.
    """
    name = _value_shown(cube, spec)
    grid = grid_of(cube, axes, chosen, width, spec.units)
    names = dict.fromkeys((name, *OF_OUTCOMES, *cube.defining, *cube.columns_of_names))
    read = cube.gather(grid.rows, [column for column in names if column in cube.columns])
    if not np.isfinite(read[name]).any():
        if name == OF_MARGIN:
            raise UsageError("no design has a margin, each has elbow angles without equilibrium")
        raise UsageError(f"no row of the table has a value of {name}")
    # The limit on stiffness comes first, as in the key.
    limits = dict.fromkeys((STIFFNESS, *cube.limits))
    rooms = {limit: cube.room(limit, grid.rows) for limit in limits}
    part = _slice(cube, spec, grid, name, read, rooms)
    lines, _ = caption(cube, spec, read, varied=[axis.column for axis in axes])
    notes = [*lines, *grid.notes]
    if name == OF_MARGIN:
        notes.insert(0, meaning_of_margin(cube, has_lines=part.has_lines))
    if part.others.any():
        notes.insert(
            0,
            f"Below zero: orange where the extensor goes slack ({EXTENSOR_SLACK.letter}), "
            f"red and dotted where the flexor alone does ({FLEXOR_SLACK.letter}).",
        )

    def begin(seen: list[int], added: str, panels: float) -> Page:
        places = [grid.titles[panel] for panel in seen] if len(seen) > 1 else [""]
        return framed(
            f"{spec.title or cube.title}{added}",
            panels,
            part.key(seen),
            [*_remarks(cube, spec, part, rooms, seen, places), *notes],
            width=width,
            height=height,
            study=cube.source,
        )

    return draw_pages(part, width, begin)


def _value_shown(cube: Cube, spec: FigureSpec) -> str:
    """Return the column of the map's values: one asked for that is no axis, or else the margin."""
    columns = {axis.column for axis in cube.axes}
    names = [cube.table_columns.find_numbers(name, "--quantity") for name in spec.quantity]
    asked = [name for name in names if name not in columns]
    if len(asked) > 1:
        hint = f"leave out {asked[1]}, or draw it in a figure of its own"
        raise UsageError("a map shows one quantity", where="--quantity", hint=hint)
    if not asked and OF_MARGIN not in cube.columns:
        raise UsageError("the table has no column of margins, which a map shows")
    return asked[0] if asked else OF_MARGIN


def _slice(
    cube: Cube,
    spec: FigureSpec,
    grid: PanelGrid,
    name: str,
    read: Mapping[str, ColumnArray],
    rooms: Mapping[str, Array],
) -> Slice:
    """Return what is drawn: values, where the flexor is slack, limits, a letter in each cell."""
    shown = column_shown(cube, spec, name)
    values = shown.scaled(read[name])
    is_margin = name == OF_MARGIN
    has_outcomes = set(OF_OUTCOMES) <= set(read)
    others = np.zeros(values.shape, dtype=np.bool_)
    areas = []
    if is_margin and has_outcomes:
        others = (values < 0.0) & is_flexor_slack(read)
        areas.append(Area("flexor slack", FLEXOR_SLACK.label, _FLEXOR, others))
    least = _bound_text(cube, spec, STIFFNESS)
    unstable = f"unstable: elbow stiffness below {least} at some angle"
    areas.append(Area("unstable", unstable, _UNSTABLE, rooms[STIFFNESS]))
    has_lines = not (grid.x.names or grid.y.names)
    borders = []
    for place, (limit, room) in enumerate(rooms.items()):
        text = limit_text(cube, spec, limit)
        label = text if has_lines else f"inside breaks {text}"
        if limit != STIFFNESS or has_lines:
            borders.append(Border(limit, label, room, limit_colour(place)))
    if is_margin and has_lines:
        label = "margin = 0, ticks on the slack side"
        borders.append(Border("boundary", label, values, INK, 1.2))
    return Slice(
        grid,
        values,
        _colours(shown, values, is_margin=is_margin),
        others,
        areas,
        borders,
        _texts(values, outcomes(read)) if has_outcomes and not has_lines else (),
        unknown="no equilibrium at some elbow angle" if is_margin else "no value",
    )


def _texts(values: Array, codes: npt.NDArray[np.int64]) -> tuple[npt.NDArray[Any], ...]:
    """Return the letter of each cell with its value below, beside, and the letter alone."""
    letters = np.array([outcome.letter for outcome in OUTCOMES], dtype=object)[codes]
    numbers = [
        labels.number(float(f"{value:.3g}")) if np.isfinite(value) else ""
        for value in values.ravel()
    ]
    pairs = list(zip(letters.ravel(), numbers, strict=True))
    beside = [f"{letter} {number}".strip() for letter, number in pairs]
    below = [f"{letter}\n{number}".strip() for letter, number in pairs]
    texts = (np.array(forms, dtype=object).reshape(values.shape) for forms in (beside, below))
    return (*texts, letters)


def _colours(shown: ColumnLabel, values: Array, *, is_margin: bool) -> Colours:
    """Return one scale of colours for all panels, whose ends are round."""
    finite = values[np.isfinite(values)]
    low = float(finite.min())
    high = float(finite.max())
    if not is_margin:
        return Colours(
            BLUES, mpl.colors.Normalize(low, high if high > low else low + 1.0), shown.label
        )
    limit, levels, extend = colour_scale(values)
    label = f"← slack   {shown.label}   taut →"
    norm = mpl.colors.Normalize(-limit, limit)
    return Colours(MARGIN, norm, label, levels, extend, MARGIN_FLEXOR)


def colour_scale(margins: Array) -> tuple[float, list[float], str]:
    """Return one scale of colours for all panels, round and symmetric about zero.

    The positive side is shown whole. A far longer negative side is cut off.

    Returns:
        The scale's limit, its levels, and which of its ends values lie beyond: "neither", "min",
        "max" or "both".
    """
    finite = margins[np.isfinite(margins)]
    most = float(finite.max())
    least = float(finite.min())
    usual = max(most, float(np.quantile(np.abs(finite), 0.9)))
    bound = max(most, -least)
    if bound > 1.5 * usual:
        bound = usual
    bound = bound or 1.0
    levels = list(mpl.ticker.MaxNLocator(10, steps=[1, 2, 2.5, 5, 10]).tick_values(-bound, bound))
    ends = [("min", least < levels[0]), ("max", most > levels[-1])]
    beyond = "".join(name for name, is_beyond in ends if is_beyond)
    extend = {"": "neither", "minmax": "both"}
    return levels[-1], levels, extend.get(beyond, beyond)


def limit_colour(place: int) -> str:
    """Return the colour of a limit by its place among the limits; the first is on stiffness."""
    if place == 0:
        return LIMIT_COLOURS[0]
    return LIMIT_COLOURS[1 + (place - 1) % (len(LIMIT_COLOURS) - 1)]


def _remarks(
    cube: Cube,
    spec: FigureSpec,
    part: Slice,
    rooms: Mapping[str, Array],
    seen: Sequence[int],
    places: Sequence[str],
) -> list[str]:
    """Say of a page whether all is taut or slack, what letters mean, and which limits show no line.

    Nobody need be told that designs keep a limit that the study does not state.
    """
    remarks = []
    known = part.values[seen][np.isfinite(part.values[seen])]
    if part.colours.below is not None and len(known) and not known.min() < 0.0 <= known.max():
        remarks.append(f"{'No' if known.min() >= 0.0 else 'Every'} design goes slack.")
    if part.texts:
        drawn = {str(text) for text in part.texts[-1][seen].ravel()}
        meanings = [f"{one.letter} {one.label}" for one in OUTCOMES if one.letter in drawn]
        remarks.append(f"Letters: {', '.join(meanings)}.")
    pieces = {limit: list(room[seen]) for limit, room in rooms.items()}
    limits = {}
    for limit, of_limit in pieces.items():
        is_hatched = limit == STIFFNESS and crosses_zero(np.array(of_limit))
        is_stated = not is_default(limit, cube.limits[limit])
        if not is_hatched and (is_stated or (np.array(of_limit) < 0.0).any()):
            limits[limit] = limit_text(cube, spec, limit)
    return [*remarks, *limit_remarks(limits, pieces, places)]


def limit_text(cube: Cube, spec: FigureSpec, name: str) -> str:
    """Return a limit as an inequality: "max tension ≤ 300 N", or "max tension ≤ its limit"."""
    name_shown = cube.shown(bounded_column(name), spec.units).name
    return f"{name_shown} {sign_of(name)} {_bound_text(cube, spec, name)}"


def _bound_text(cube: Cube, spec: FigureSpec, name: str) -> str:
    """Return the bound of a limit with its unit; "its limit" if it differs between designs."""
    bound = cube.limits[name]
    if bound is None:
        return "its limit"
    return cube.shown(bounded_column(name), spec.units).text(bound)


def column_shown(cube: Cube, spec: FigureSpec, column: str) -> ColumnLabel:
    """Return the label and unit by which a column is shown.

    If the pretensions of the two sides differ, the margin is the least one that both have.
    """
    shown = cube.shown(column, spec.units)
    if column != OF_MARGIN or not _has_two_pretensions(cube):
        return shown
    name = "common margin of both pretensions"
    return replace(shown, quantity=replace(shown.quantity, name=name, symbol="margin"))


def meaning_of_margin(cube: Cube, *, has_lines: bool = True) -> str:
    """Return sentences that say what the margin is, and what lines between designs are, if any."""
    if _has_two_pretensions(cube):
        return (
            "Margin: by how much both pretensions can be lowered together, "
            "or if negative must be raised, for no slack."
        )
    least = symbol(as_read(QUANTITIES["required_pretension"], cube.document).symbol)
    return (
        f"Margin: how far the {reading(cube.document)} is above {least}, "
        "the smallest that leaves no slack at any elbow angle of the study. "
        f"It is exact for each design{'; lines are drawn from design to design' * has_lines}."
    )


def _has_two_pretensions(cube: Cube) -> bool:
    """Return True if flexor and extensor have a pretension each."""
    return len(cube.with_sides("pretension")) > 1
