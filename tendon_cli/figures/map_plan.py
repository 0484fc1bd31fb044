"""Which designs a slack map shows: two axes for x and y, panels for the others, and what had to be left out."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tendon_cli.figures.product import Axis, Ints, Product, evenly

LOAD = "load_mass"
CELLS_PER_AXIS = 400
PANELS_PER_PAGE = 12
MOST_PANELS = 24
MOST_LINES = 8


@dataclass(frozen=True)
class MapPlan:
    """Axes and positions of all panels."""

    x: Axis
    y: Axis | None
    """None where only one axis is long enough: then a line for each panel, all in one."""
    positions: Mapping[str, Ints]
    """Positions drawn along x and y."""
    panels: tuple[Mapping[str, int], ...]
    """Position on every other axis, for each panel."""
    titled: tuple[Axis, ...]
    """Axes that differ between the panels, the load first."""
    common: tuple[Axis, ...]
    """Axes of which only one of several values was chosen."""
    notes: tuple[str, ...]

    def rows(self, product: Product, panel: Mapping[str, int]) -> Ints:
        """Rows of one panel, of shape (y, x); without y, (x,)."""
        fixed = {column: np.array([at], dtype=np.int64) for column, at in panel.items()}
        order = [axis.column for axis in (self.y, self.x) if axis is not None]
        return product.rows(order, {**fixed, **self.positions})


def plan_maps(product: Product, chosen: Mapping[str, Ints]) -> MapPlan | str:
    """Lay the designs out over panels; `chosen` are the positions to choose from. A text says why there is no map."""
    long = [axis for axis in product.axes if axis.column != LOAD and len(chosen[axis.column]) > 1]
    if not long:
        return "no axis other than the load has more than one value"
    x, y = long[0], long[1] if len(long) > 1 else None
    notes: list[str] = []
    positions = {}
    for axis in (x, y):
        if axis is not None:
            at = chosen[axis.column]
            kept = evenly(len(at), CELLS_PER_AXIS)
            positions[axis.column] = at[kept]
            if len(kept) < len(at):
                notes.append(f"{len(kept)} of {len(at)} values of {words(axis)} drawn, evenly chosen.")
    others = [axis for axis in product.axes if axis not in (x, y)]
    several = [axis for axis in others if len(chosen[axis.column]) > 1]
    several.sort(key=lambda axis: axis.column != LOAD)
    fixed = {axis.column: int(chosen[axis.column][0]) for axis in others if axis not in several}
    places, note = _thinned(several, chosen, *((MOST_PANELS, PANELS_PER_PAGE) if y else (MOST_LINES, MOST_LINES)))
    fixed |= {column: int(at[0]) for column, at in places.items() if len(at) == 1}
    titled = [axis for axis in several if len(places[axis.column]) > 1]
    # The load varies fastest, so that the loads of one design stand side by side.
    turned = [axis.column for axis in reversed(titled)]
    panels = tuple(
        {**fixed, **dict(zip(turned, map(int, at), strict=True))}
        for at in itertools.product(*(places[column] for column in turned))
    )
    common = [axis for axis in several if axis not in titled]
    return MapPlan(x, y, positions, panels, tuple(titled), tuple(common), (*notes, *note))


def words(axis: Axis) -> str:
    """An axis named in a sentence."""
    return axis.column.replace("_", " ")


def _thinned(axes: list[Axis], chosen: Mapping[str, Ints], most: int, fewer: int) -> tuple[dict[str, Ints], list[str]]:
    """All positions where their combinations fit, else a few of each axis, evenly chosen, and a note of it."""
    lengths = [len(chosen[axis.column]) for axis in axes]
    total = math.prod(lengths)
    counts = lengths if total <= most else _counts(lengths, fewer)
    kept = {
        axis.column: chosen[axis.column][evenly(length, count)]
        for axis, length, count in zip(axes, lengths, counts, strict=True)
    }
    drawn = math.prod(counts)
    if drawn == total:
        return kept, []
    names = ", ".join(words(axis) for axis in axes)
    return kept, [f"{drawn} of {total} combinations of {names} drawn, evenly chosen; the table has all."]


def _counts(lengths: list[int], most: int) -> list[int]:
    """How many values of each axis, so that their product is at most `most`: the first axis, the load, gets most."""
    counts = [1] * len(lengths)
    for at, length in enumerate(lengths):
        counts[at] = max(1, min(length, most // math.prod(counts), 4 if at == 0 and len(lengths) > 1 else length))
    return counts
