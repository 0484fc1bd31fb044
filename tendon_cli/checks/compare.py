"""What changed between two runs, on the designs and states that both have."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.checks.shared import Shared
from tendon_cli.cube.axes import Ints, RowAxis
from tendon_cli.cube.cube import Cube
from tendon_cli.engine.columns import JUDGEMENTS
from tendon_cli.quantities import OF_CYCLES, OF_DESIGNS, OF_STATES

_ROWS_AT_ONCE = 2**18
FLAGS = ("status", *JUDGEMENTS)
"""Columns of words and truths, which are compared exactly."""

Values = npt.NDArray[Any]


@dataclass(frozen=True)
class Change:
    """By how much a column differs, and where it differs most."""

    table: str
    column: str
    difference: float | None
    """Largest, in SI; none for flags and words, which are the same or not."""
    share: float
    """Of the column's scale, its largest magnitude in either run; for flags and words of the rows."""
    rows: int
    """How many rows differ by more than the tolerance."""
    where: dict[str, float | str]
    """The row that differs most, by its axes."""


@dataclass(frozen=True)
class TableComparison:
    """What changed in the common rows and columns of two tables."""

    table: str
    columns: int
    """How many were compared."""
    changes: tuple[Change, ...]
    """Those beyond the tolerance, the worst first."""
    within: Change | None
    """The largest difference that is not."""


@dataclass(frozen=True)
class Flip:
    """A design that is feasible in one of the runs only."""

    where: dict[str, float | str]
    now: bool
    margin_before: float | None
    margin_now: float | None

    @property
    def size(self) -> float:
        """By how much its margin moved, N; what has none, most of all."""
        if self.margin_before is None or self.margin_now is None:
            return math.inf
        return abs(self.margin_now - self.margin_before)


@dataclass(frozen=True)
class Comparison:
    """What two runs have in common, what changed, and what could not be compared."""

    designs: int
    states: int
    columns: dict[str, int]
    """How many columns were compared, by table."""
    missing: tuple[str, ...]
    """What only one of the runs has: columns, rows, a table."""
    excepted: tuple[str, ...]
    """Rows that only one of the runs has by a key that may differ."""
    within: Change | None
    """The largest difference that is not beyond the tolerance; none if all else is equal."""
    changes: tuple[Change, ...]
    """Columns that differ by more than the tolerance, the worst first."""
    flips: tuple[Flip, ...]
    """The worst first, as many as were asked for."""
    flipped: int

    @property
    def holds(self) -> bool:
        """Whether nothing changed."""
        return not self.changes and not self.flipped and not self.missing


def only_in_one(here: Cube, there: Cube) -> tuple[str, ...]:
    """Columns that only one of two tables has."""
    ours, theirs = _results(here), _results(there)
    only = [(name, "this run") for name in ours if name not in theirs]
    only += [(name, "the baseline") for name in theirs if name not in ours]
    return tuple(f"{here.kind}.{name}: a column in {which} only" for name, which in only)


def compare_tables(here: Cube, there: Cube, shared: Shared, tolerance: float) -> TableComparison:
    """Columns of both tables that differ by more than a share of their scale; flags and words exactly."""
    columns = [name for name in _results(here) if name in _results(there)]
    scale = dict.fromkeys(columns, 0.0)
    for _, first, second in _together(here, there, shared, columns):
        for name in columns:
            for values in (first[name], second[name]):
                if name not in FLAGS and np.isfinite(values).any():
                    scale[name] = max(scale[name], float(np.nanmax(np.abs(values))))
    changed: dict[str, Change] = {}
    within: Change | None = None
    for start, first, second in _together(here, there, shared, columns):
        for name in columns:
            change = _change(here.kind, name, first[name], second[name], scale[name], 0.0, shared, start)
            if change is None:
                continue
            beyond = _change(here.kind, name, first[name], second[name], scale[name], tolerance, shared, start)
            if beyond is not None:
                changed[name] = _worse(changed.get(name), beyond)
            elif within is None or change.share > within.share:
                within = change
    changes = tuple(sorted(changed.values(), key=lambda change: -change.share))
    return TableComparison(here.kind, len(columns), changes, within)


def _results(cube: Cube) -> list[str]:
    """Columns that are computed; the others say which design or state a row is."""
    known = {*OF_DESIGNS, *OF_CYCLES, *OF_STATES, *FLAGS}
    return [name for name in cube.files.schema.names if name in known] if cube.files is not None else []


def _together(
    here: Cube, there: Cube, shared: Shared, columns: Sequence[str]
) -> Iterator[tuple[int, dict[str, Values], dict[str, Values]]]:
    """The common rows of both, a bounded number at once, with the number of the first."""
    total, by_key = math.prod(shared.shape), {axis.key: axis for axis in there.axes}
    for start in range(0, total, _ROWS_AT_ONCE):
        flat = np.arange(start, min(total, start + _ROWS_AT_ONCE))
        places = np.unravel_index(flat, shared.shape) if shared.shape else ()
        ours = _row_numbers(here, shared.here, shared.axes, places, flat)
        theirs = _row_numbers(there, shared.there, [by_key[axis.key] for axis in shared.axes], places, flat)
        yield start, here.gather(ours, columns), there.gather(theirs, columns)


def _row_numbers(
    cube: Cube, at: Mapping[str, Ints], axes: Sequence[RowAxis], places: Sequence[Ints], flat: Ints
) -> Ints:
    rows = np.zeros(len(flat), dtype=np.int64)
    for axis, place in zip(axes, places, strict=True):
        rows += at[axis.column][place] * axis.stride
    varied = {axis.column for axis in axes}
    return rows + sum(int(at[axis.column][0]) * axis.stride for axis in cube.axes if axis.column not in varied)


def _change(
    table: str, name: str, first: Values, second: Values, scale: float, tolerance: float, shared: Shared, start: int
) -> Change | None:
    if name in FLAGS:
        differs = first != second
        share = float(differs.mean()) if len(differs) else 0.0
        size = differs.astype(float)
    else:
        one_is_null = np.isnan(first) != np.isnan(second)
        size = np.where(one_is_null, np.inf, np.abs(np.nan_to_num(first - second)))
        differs = one_is_null | (size > tolerance * scale)
        share = float(size.max()) / scale if scale else float(size.max())
    if not differs.any():
        return None
    row = int(np.argmax(size))
    difference = None if name in FLAGS else float(size[row])
    return Change(table, name, difference, share, int(differs.sum()), shared.where(start + row))


def _worse(before: Change | None, now: Change) -> Change:
    if before is None:
        return now
    return replace(max(before, now, key=lambda change: change.share), rows=before.rows + now.rows)


def flips(here: Cube, there: Cube, shared: Shared, most: int) -> tuple[tuple[Flip, ...], int]:
    """Designs that are feasible in one of the runs only, the worst first; and how many there are."""
    flipped: list[Flip] = []
    count = 0
    for start, first, second in _together(here, there, shared, ("feasible", "margin")):
        for row in np.flatnonzero(first["feasible"] != second["feasible"]):
            count += 1
            margins = [_finite(side["margin"][row]) for side in (second, first)]
            flipped.append(Flip(shared.where(start + int(row)), bool(first["feasible"][row]), *margins))
        flipped = sorted(flipped, key=lambda flip: -flip.size)[:most]
    return tuple(flipped), count


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
