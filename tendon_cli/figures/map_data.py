"""What a slack map shows, read from the table of designs."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tendon_cli.cube.cube import Cube
from tendon_cli.cube.labels import Shown, as_read, reading, symbol
from tendon_cli.errors import UsageError
from tendon_cli.figures.layout import MapPlan
from tendon_cli.figures.scales import Scale, axis_scale, caption, value_texts
from tendon_cli.quantities import QUANTITIES
from tendon_cli.studies.figures import FigureSpec

Floats = npt.NDArray[np.float64]

MARGIN, STIFFNESS = "margin", "min_elbow_stiffness"


@dataclass(frozen=True)
class MapData:
    """Everything that the pages of a slack map show; arrays of shape (panels, y, x) in the order of the scales."""

    title: str
    study: str
    x: Scale
    y: Scale
    margin: Shown
    margins: Floats
    """In the unit shown."""
    rooms: Mapping[str, Floats]
    """What is left up to each limit; negative where it is not held."""
    limits: Mapping[str, str]
    """What the key says of each limit."""
    titles: tuple[str, ...]
    """Of panels."""
    in_row: int
    """How many neighbouring panels differ in one axis only, the load if there is one."""
    notes: tuple[str, ...]


def map_data(cube: Cube, plan: MapPlan, spec: FigureSpec) -> MapData:
    """Read what the panels show, and nothing else; raises UsageError where there is no margin."""
    if MARGIN not in cube.columns:
        raise UsageError("the table has no column of margins, which a map shows")
    limits = [
        key
        for key in dict.fromkeys((STIFFNESS, *cube.study.get("limits", ())))
        if _column(key) in cube.columns
    ]
    names = (MARGIN, *map(_column, limits), *cube.defining)
    read = cube.gather(plan.rows(cube), [name for name in names if name in cube.columns])
    if not np.isfinite(read[MARGIN]).any():
        raise UsageError("no design has a margin, each has elbow angles without equilibrium")
    x, y = (
        axis_scale(cube, axis, plan.positions[axis.column], spec.units) for axis in (plan.x, plan.y)
    )
    margin = margin_shown(cube, spec)
    shown = {key: _room(read[_column(key)], key, cube.limit(key)) for key in limits}
    shown = {key: each[:, y.order][..., x.order] for key, each in shown.items()}
    margins = margin.scaled(read[MARGIN])[:, y.order][..., x.order]
    texts = [
        value_texts(cube, axis, plan.positions[axis.column], spec.units)
        for axis in reversed(plan.titled)
    ]
    groups: dict[bytes, list[tuple[int, str]]] = {}  # panels that would repeat a picture are one
    for at, words in enumerate(itertools.product(*texts)):
        picture = b"".join(each[at].tobytes() for each in (margins, *shown.values()))
        groups.setdefault(picture, []).append((at, ", ".join(reversed(words))))
    first = [same[0][0] for same in groups.values()]
    names_of = [[title for _, title in same] for same in groups.values()]
    repeated = [f"The same picture for {', '.join(titles)}." for titles in names_of if titles[1:]]
    lines, fixed = caption(cube, spec, read, varied=[plan.x.column, plan.y.column])
    titles = [_joined(titles) for titles in names_of]
    if titles == [""]:
        titles = [next((text for text in fixed if text.endswith(" load")), "")]
    return MapData(
        spec.title or cube.title,
        cube.source,
        x,
        y,
        margin,
        margins[first],
        {key: each[first] for key, each in shown.items()},
        {key: _words(cube, spec, key) for key in limits},
        tuple(titles),
        len(plan.positions[plan.titled[0].column]) if plan.titled else 1,
        (meaning_of_margin(cube), *lines, *plan.notes, *repeated),
    )


def _column(key: str) -> str:
    return "pretension" if key == "max_pretension" else key


def _room(values: Floats, key: str, limit: float) -> Floats:
    """What is left up to a limit: min_ bounds from below, max_ from above, peak_ by magnitude; rounding breaks none."""
    size = np.abs(values) if key.startswith("peak_") else values
    room = values - limit if key.startswith("min_") else limit - size
    return np.where(np.abs(room) <= 1e-9 * np.maximum(np.abs(size), abs(limit)), 0.0, room)


def _words(cube: Cube, spec: FigureSpec, key: str) -> str:
    shown = cube.shown(_column(key), spec.units)
    if key == STIFFNESS:
        return f"unstable: elbow stiffness below {shown.text(cube.limit(key))} at some angle"
    return f"{shown.name} {'≥' if key.startswith('min_') else '≤'} {shown.text(cube.limit(key))}"


def _joined(titles: list[str]) -> str:
    return ", ".join(titles) if len(titles) < 3 else f"{titles[0]} and {len(titles) - 1} others"


def margin_shown(cube: Cube, spec: FigureSpec) -> Shown:
    """The margin by its name; of sides that differ in pretension it is the least that both have in hand."""
    margin = cube.shown(MARGIN, spec.units)
    if not _differ(cube):
        return margin
    return replace(
        margin,
        quantity=replace(
            margin.quantity, name="common margin of both pretensions", symbol="margin"
        ),
    )


def meaning_of_margin(cube: Cube) -> str:
    """What the margin is, in a sentence."""
    if _differ(cube):
        return "Margin: by how much both pretensions can be lowered together, or if negative must be raised, for no slack."
    least = symbol(as_read(QUANTITIES["required_pretension"], cube.study).symbol)
    return (
        f"Margin: {reading(cube.study)} in hand above {least}, the smallest that leaves no slack at any elbow angle of "
        "the study. "
        "It is exact for each design; lines are drawn from design to design."
    )


def _differ(cube: Cube) -> bool:
    return len(cube.with_sides("pretension")) > 1
