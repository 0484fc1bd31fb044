"""Which designs a map shows: two axes for x and y, panels for the others, and what had to be left out."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tendon_cli.cube.axes import LOAD, Ints, RowAxis, evenly
from tendon_cli.cube.cube import Cube

CELLS_PER_AXIS = 400
PANELS_PER_PAGE = 12
MOST_PANELS = 24


@dataclass(frozen=True)
class MapPlan:
    """Axes and positions of all panels."""

    x: RowAxis
    y: RowAxis
    positions: Mapping[str, Ints]
    """Positions drawn along x and y."""
    panels: tuple[Mapping[str, int], ...]
    """Position on every other axis, for each panel."""
    titled: tuple[RowAxis, ...]
    """Axes that differ between the panels, the load first."""
    notes: tuple[str, ...]

    def rows(self, cube: Cube, panel: Mapping[str, int]) -> Ints:
        """Rows of one panel, of shape (y, x)."""
        fixed = {column: np.array([at], dtype=np.int64) for column, at in panel.items()}
        return cube.rows([self.y.column, self.x.column], {**fixed, **self.positions})


def long_axes(cube: Cube, chosen: Mapping[str, Ints]) -> list[RowAxis]:
    """Axes other than the load of which more than one value is chosen."""
    return [axis for axis in cube.axes if axis.column != LOAD and len(chosen[axis.column]) > 1]


def plan_maps(cube: Cube, chosen: Mapping[str, Ints]) -> MapPlan:
    """Lay the designs out over panels; `chosen` are the positions to choose from, of two long axes at least."""
    x, y = long_axes(cube, chosen)[:2]
    notes: list[str] = []
    positions = {}
    for axis in (x, y):
        at = chosen[axis.column]
        kept = evenly(len(at), CELLS_PER_AXIS)
        positions[axis.column] = at[kept]
        if len(kept) < len(at):
            notes.append(f"{len(kept)} of {len(at)} values of {axis.words} drawn, evenly chosen.")
    others = [axis for axis in cube.axes if axis not in (x, y)]
    several = [axis for axis in others if len(chosen[axis.column]) > 1]
    several.sort(key=lambda axis: axis.column != LOAD)
    fixed = {axis.column: int(chosen[axis.column][0]) for axis in others if axis not in several}
    places, note = _thinned(several, chosen)
    fixed |= {column: int(at[0]) for column, at in places.items() if len(at) == 1}
    titled = [axis for axis in several if len(places[axis.column]) > 1]
    # The load varies fastest, so that the loads of one design stand side by side.
    turned = [axis.column for axis in reversed(titled)]
    panels = tuple(
        {**fixed, **dict(zip(turned, map(int, at), strict=True))}
        for at in itertools.product(*(places[column] for column in turned))
    )
    return MapPlan(x, y, positions, panels, tuple(titled), (*notes, *note))


def _thinned(axes: list[RowAxis], chosen: Mapping[str, Ints]) -> tuple[dict[str, Ints], list[str]]:
    """All positions where their combinations fit, else a few of each axis, evenly chosen, and a note of it."""
    lengths = [len(chosen[axis.column]) for axis in axes]
    total = math.prod(lengths)
    counts = lengths if total <= MOST_PANELS else _counts(lengths, PANELS_PER_PAGE)
    kept = {
        axis.column: chosen[axis.column][evenly(length, count)]
        for axis, length, count in zip(axes, lengths, counts, strict=True)
    }
    drawn = math.prod(counts)
    if drawn == total:
        return kept, []
    names = ", ".join(axis.words for axis in axes)
    return kept, [f"{drawn} of {total} combinations of {names} drawn, evenly chosen; the table has all."]


def _counts(lengths: list[int], most: int) -> list[int]:
    """How many values of each axis, so that their product is at most `most`: the first axis, the load, gets most."""
    counts = [1] * len(lengths)
    for at, length in enumerate(lengths):
        counts[at] = max(1, min(length, most // math.prod(counts), 4 if at == 0 and len(lengths) > 1 else length))
    return counts
