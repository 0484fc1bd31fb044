"""Data of a slack map, read from the table of designs."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import ColumnLabel, as_read, reading, symbol
from tendon_cli.cube.room import bounded_column, is_default, sign_of
from tendon_cli.errors import UsageError
from tendon_cli.figures.layout import MapPlan
from tendon_cli.figures.scales import Scale, axis_scale, caption, value_texts
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.figures import FigureSpec

Floats = npt.NDArray[np.float64]

MARGIN = "margin"
STIFFNESS = "min_elbow_stiffness"


@dataclass(frozen=True)
class MapData:
    """Data of all pages of a slack map, in arrays of shape (panels, y, x) in the scales' order."""

    title: str
    study: str
    x: Scale
    y: Scale
    margin: ColumnLabel
    margins: Floats
    """Margins in the unit shown."""
    rooms: Mapping[str, Floats]
    """Room that each limit leaves, SI, by its name; negative where the limit is broken."""
    limits: Mapping[str, str]
    """Text of each limit, such as "max tension ≤ 300 N", by its name."""
    unstable: str
    """Text of the hatched area, in which the limit on stiffness is broken."""
    defaults: frozenset[str]
    """Limits whose bound is the default, which nobody need be told that designs keep."""
    titles: tuple[str, ...]
    """Titles of the panels."""
    in_row: int
    """Number of neighbouring panels that differ in one axis only, the load if there is one."""
    notes: tuple[str, ...]


def map_data(cube: Cube, plan: MapPlan, spec: FigureSpec) -> MapData:
    """Read the data of a slack map.

    Panels that would repeat a picture are one panel, and its title or a note names them all.

    Raises:
        UsageError: The table has no margin, or no design has one.
    """
    if MARGIN not in cube.columns:
        raise UsageError("the table has no column of margins, which a map shows")
    rows = plan.rows(cube)
    names = dict.fromkeys((MARGIN, *cube.defining, *cube.columns_of_names))
    read = cube.gather(rows, [name for name in names if name in cube.columns])
    if not np.isfinite(read[MARGIN]).any():
        raise UsageError("no design has a margin, each has elbow angles without equilibrium")
    x = axis_scale(cube, plan.x, plan.positions[plan.x.column], spec.units)
    y = axis_scale(cube, plan.y, plan.positions[plan.y.column], spec.units)
    if plan.is_table:
        x = x.by_value()
    margin = margin_shown(cube, spec)
    margins = _in_order(margin.scaled(read[MARGIN]), x, y)
    # The limit on stiffness comes first, as in the key.
    limits = dict.fromkeys((STIFFNESS, *cube.limits))
    rooms = {name: _in_order(cube.room(name, rows), x, y) for name in limits}
    pictures = _group_pictures(margins, rooms, _panel_titles(cube, plan, spec))
    first = [panels[0] for panels, _ in pictures]
    titles = [_join_titles(names) for _, names in pictures]
    repeated = [
        f"The same picture for {', '.join(names)}." for _, names in pictures if len(names) > 1
    ]
    lines, fixed = caption(cube, spec, read, varied=[plan.x.column, plan.y.column])
    if titles == [""]:
        titles = [next((text for text in fixed if text.endswith(" load")), "")]
    least_stiffness = _bound_text(cube, spec, STIFFNESS)
    return MapData(
        title=spec.title or cube.title,
        study=cube.source,
        x=x,
        y=y,
        margin=margin,
        margins=margins[first],
        rooms={name: room[first] for name, room in rooms.items()},
        limits={name: limit_text(cube, spec, name) for name in limits},
        unstable=f"unstable: elbow stiffness below {least_stiffness} at some angle",
        defaults=frozenset(name for name in limits if is_default(name, cube.limits[name])),
        titles=tuple(titles),
        in_row=len(plan.positions[plan.titled[0].column]) if plan.titled else 1,
        notes=(
            meaning_of_margin(cube, has_lines=not (x.names and y.names)),
            *lines,
            *plan.notes,
            *repeated,
        ),
    )


def _in_order(values: Floats, x: Scale, y: Scale) -> Floats:
    """Put values (panels, y, x) into the order of the scales."""
    return values[:, y.order][..., x.order]


def _panel_titles(cube: Cube, plan: MapPlan, spec: FigureSpec) -> list[str]:
    """Return a title for each panel. The load is first in it, and varies fastest over panels."""
    texts = [
        value_texts(cube, axis, plan.positions[axis.column], spec.units)
        for axis in reversed(plan.titled)
    ]
    return [", ".join(reversed(words)) for words in itertools.product(*texts)]


def _group_pictures(
    margins: Floats, rooms: Mapping[str, Floats], titles: list[str]
) -> list[tuple[list[int], list[str]]]:
    """Group the panels that show the same picture. Return the indices and titles of each group."""
    groups: dict[bytes, tuple[list[int], list[str]]] = {}
    for panel, title in enumerate(titles):
        picture = b"".join(values[panel].tobytes() for values in (margins, *rooms.values()))
        panels, names = groups.setdefault(picture, ([], []))
        panels.append(panel)
        names.append(title)
    return list(groups.values())


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


def _join_titles(titles: list[str]) -> str:
    """Join the titles of panels that are one picture; of three or more only the first is named."""
    return ", ".join(titles) if len(titles) < 3 else f"{titles[0]} and {len(titles) - 1} others"


def margin_shown(cube: Cube, spec: FigureSpec) -> ColumnLabel:
    """Return the label and unit by which the margin is shown.

    If the pretensions of the two sides differ, it is the least margin that both have.
    """
    margin = cube.shown(MARGIN, spec.units)
    if not _has_two_pretensions(cube):
        return margin
    name = "common margin of both pretensions"
    return replace(margin, quantity=replace(margin.quantity, name=name, symbol="margin"))


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
