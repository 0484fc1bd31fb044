"""What changed between two runs, on the designs and states that both have."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.cube.axes import Ints, RowAxis
from tendon_cli.cube.cube import Cube
from tendon_cli.engine.columns import JUDGEMENTS
from tendon_cli.engine.records import differences
from tendon_cli.errors import UsageError
from tendon_cli.quantities import OF_CYCLES, OF_DESIGNS, OF_STATES
from tendon_cli.studies.fields import nearest
from tendon_cli.studies.schema import key_words
from tendon_cli.studies.study import Study, keys
from tendon_cli.units import shorten

_ROWS_AT_ONCE = 2**18
FLAGS = ("status", *JUDGEMENTS)
"""Columns of words and truths, which are compared exactly."""

_NOT_ASKED = ("name", "title", "output", "figure")
"""What a study says that changes no number."""

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
    """What two runs have in common, and what changed."""

    designs: int
    states: int
    changes: tuple[Change, ...]
    """Columns that differ by more than the tolerance, the worst first."""
    flips: tuple[Flip, ...]
    """The worst first, as many as were asked for."""
    flipped: int

    @property
    def holds(self) -> bool:
        """Whether nothing changed."""
        return not self.changes and not self.flipped


@dataclass(frozen=True)
class Shared:
    """Rows that both tables have: positions on the axes of either, in the same order."""

    axes: tuple[RowAxis, ...]
    """Those that both have, slowest first."""
    here: Mapping[str, Ints]
    there: Mapping[str, Ints]

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of common values on each axis."""
        return tuple(len(self.here[axis.column]) for axis in self.axes)

    def where(self, row: int) -> dict[str, float | str]:
        """A common row by its axes."""
        found: dict[str, float | str] = {}
        for axis, at in zip(self.axes, np.unravel_index(row, self.shape), strict=True):
            value = axis.values[self.here[axis.column][at]]
            found[axis.column] = str(value) if axis.is_text else float(value)
        return found


def check_studies(ours: Study, theirs: Study, apart: Sequence[str]) -> None:
    """Raises UsageError where two studies differ in more than the values of axes and the keys `apart`."""
    known = {key.rsplit(".", depth)[0] for key in key_words() for depth in range(key.count(".") + 1)}
    if unknown := [key for key in apart if key not in known.union(Study.model_fields)]:
        hint = nearest(unknown[0], known) or "`tendon schema` lists every key"
        raise UsageError(f'a study has no key "{shorten(unknown[0])}"', where="--except", hint=hint)
    varied = {*ours.axes, *theirs.axes, "motion.elbow_angle", "motion.direction", "cases", *_NOT_ASKED, *apart}
    lines = [
        line
        for line in differences(theirs.document(), ours.document())
        if not any(f"{line.partition(' ')[0]}.".startswith(f"{key}.") for key in varied)
    ]
    if lines:
        hint = f"--except {lines[0].partition(' ')[0]} compares them all the same"
        raise UsageError(f"the baseline is of another study: {'; '.join(lines[:4])}", hint=hint)


def shared_rows(here: Cube, there: Cube, ours: Study, theirs: Study) -> Shared:
    """What two tables have in common, by the values of their axes; raises UsageError where that is nothing."""
    by_key = {axis.key: axis for axis in there.axes}
    at_here, at_there, axes = {}, {}, []
    for axis in here.axes:
        other = by_key.pop(axis.key, None)
        if other is None:
            at_here[axis.column] = _single(axis, theirs)
            continue
        axes.append(axis)
        at_here[axis.column], at_there[other.column] = _common(axis, other)
    for axis in by_key.values():
        at_there[axis.column] = _single(axis, ours)
    return Shared(tuple(axes), at_here, at_there)


def _common(axis: RowAxis, other: RowAxis) -> tuple[Ints, Ints]:
    places = {_token(value): at for at, value in enumerate(other.values)}
    pairs = [(at, places[_token(value)]) for at, value in enumerate(axis.values) if _token(value) in places]
    if not pairs:
        raise UsageError(f"the runs have no value of {axis.key} in common", hint="runs are compared by axis values")
    first, second = zip(*pairs, strict=True)
    return np.array(first, dtype=np.int64), np.array(second, dtype=np.int64)


def _single(axis: RowAxis, other: Study) -> Ints:
    """Where an axis has the one value that the other run has of it."""
    known = keys().get(axis.key)
    value = other.numbers[axis.key].single if known and axis.key in other.numbers else None
    found = [at for at, each in enumerate(axis.values) if value is not None and _token(each) == _token(value)]
    if found or len(axis.values) == 1:
        return np.array(found[:1] or [0], dtype=np.int64)
    raise UsageError(f"only one of the runs has the axis {axis.key}, without the other's value of it")


def _token(value: Any) -> str:
    return value if isinstance(value, str) else f"{float(value):.12g}"


def compare_tables(here: Cube, there: Cube, shared: Shared, tolerance: float) -> tuple[Change, ...]:
    """Columns of both tables that differ by more than a share of their scale; flags and words exactly."""
    columns = [name for name in _results(here) if name in _results(there)]
    scale = dict.fromkeys(columns, 0.0)
    for _, first, second in _together(here, there, shared, columns):
        for name in columns:
            for values in (first[name], second[name]):
                if name not in FLAGS and np.isfinite(values).any():
                    scale[name] = max(scale[name], float(np.nanmax(np.abs(values))))
    found: dict[str, Change] = {}
    for start, first, second in _together(here, there, shared, columns):
        for name in columns:
            change = _change(here.kind, name, first[name], second[name], scale[name], tolerance, shared, start)
            if change is not None:
                found[name] = _worse(found.get(name), change)
    return tuple(sorted(found.values(), key=lambda change: -change.share))


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
    found: list[Flip] = []
    count = 0
    for start, first, second in _together(here, there, shared, ("feasible", "margin")):
        for row in np.flatnonzero(first["feasible"] != second["feasible"]):
            count += 1
            margins = [_finite(side["margin"][row]) for side in (second, first)]
            found.append(Flip(shared.where(start + int(row)), bool(first["feasible"][row]), *margins))
        found = sorted(found, key=lambda flip: -flip.size)[:most]
    return tuple(found), count


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
