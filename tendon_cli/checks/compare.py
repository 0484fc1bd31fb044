"""What changed between two runs, on the designs and states that both have."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.checks.check_text import WORST, Checked, comparison_text, finite
from tendon_cli.cube.axes import Ints
from tendon_cli.cube.columns import Values
from tendon_cli.cube.cube import Cube, cube_of
from tendon_cli.engine.records import differences
from tendon_cli.engine.results import open_run
from tendon_cli.engine.table_columns import JUDGEMENTS
from tendon_cli.errors import UsageError
from tendon_cli.quantities import OF_CYCLES, OF_DESIGNS, OF_STATES
from tendon_cli.space.axis import Axis
from tendon_cli.studies.fields import nearest
from tendon_cli.studies.json_schema import key_words
from tendon_cli.studies.load import recorded_study
from tendon_cli.studies.study import Study
from tendon_cli.tables.read import TableFiles
from tendon_cli.units import counted, shorten

FLAGS = ("status", *JUDGEMENTS)
"""Columns of words and truths, which are compared exactly."""
TOLERANCE = 1e-9
"""The share of a column's scale by which numbers may differ."""
_MAY_DIFFER = (
    "motion.elbow_angle",
    "motion.direction",
    "cases",
    "name",
    "title",
    "output",
    "figure",
)
"""What a study says of its rows, and what changes no number."""

Record = dict[str, Any]
"""A change, a flip, or all of them, for text and programs alike."""


def compare(
    folder: Path,
    baseline: Path,
    *,
    tolerance: float = TOLERANCE,
    apart: Sequence[str] = (),
    worst: int = WORST,
) -> Checked:
    """What changed since another run: columns beyond the tolerance, flags exactly, designs that became feasible or not.

    Raises InputError for what is damaged or is no run, UsageError where the studies differ in more than the values of
    axes and the keys `apart`.
    """
    runs, missing = [open_run(each) for each in (folder, baseline)], list[str]()
    ours, theirs = (recorded_study(run.record) for run in runs)
    tables = [run.kept("designs") for run in runs]
    _check_studies(ours, theirs, apart)
    pairs = [Pair.of(tables, ours, theirs)]
    kept = ["states" in run.record["study"]["output"]["tables"] for run in runs]
    if all(kept):
        pairs.append(Pair.of([run.kept("states") for run in runs], ours, theirs))
    elif any(kept):
        missing.append(f"states: a table in {'this run' if kept[0] else 'the baseline'} only")
    changes = [change for pair in pairs for change in pair.changes(tolerance)]
    missing += [line for pair in pairs for line in pair.columns_of_one]
    left_out = {key: text for pair in pairs for key, text in pair.left_out.items()}
    excepted = {key: text for key, text in left_out.items() if _is_within(key, apart)}
    missing += [text for key, text in left_out.items() if key not in excepted]
    beyond, flips = [change for change in changes if change.pop("is_beyond")], pairs[0].flips()
    record: Record = {
        "states": 0,
        **{pair.here.kind: math.prod(pair.shape) for pair in pairs},
        "columns": {pair.here.kind: len(pair.columns) for pair in pairs},
        "missing": missing,
        "excepted": list(excepted.values()),
        "within": max(
            (c for c in changes if c not in beyond),
            key=lambda change: change["share"],
            default=None,
        ),
        "changes": beyond,
        "flips": flips[:worst],
        "flipped": len(flips),
        "holds": not beyond and not flips and not missing,
    }
    names = str(folder), str(baseline)
    return Checked(record["holds"], comparison_text(record, pairs[0].here, names), finite(record))


def _check_studies(ours: Study, theirs: Study, apart: Sequence[str]) -> None:
    """Raises UsageError where two studies differ in more than the values of axes and the keys `apart`."""
    known = {
        key.rsplit(".", depth)[0] for key in key_words() for depth in range(key.count(".") + 1)
    }
    if unknown := [key for key in apart if key not in known.union(Study.model_fields)]:
        hint = nearest(unknown[0], known) or "`tendon schema` lists every key"
        raise UsageError(f'a study has no key "{shorten(unknown[0])}"', where="--except", hint=hint)
    varied = {*ours.axes, *theirs.axes, *_MAY_DIFFER, *apart}
    every = differences(theirs.document(), ours.document())
    if lines := [line for line in every if not _is_within(line.partition(" ")[0], varied)]:
        hint = f"--except {lines[0].partition(' ')[0]} compares them all the same"
        raise UsageError(f"the baseline is of another study: {'; '.join(lines[:4])}", hint=hint)


def _is_within(key: str, tables: Sequence[str] | set[str]) -> bool:
    """Whether a key is one of some, or in a table of these."""
    return any(f"{key}.".startswith(f"{each}.") for each in tables)


@dataclass(frozen=True)
class Pair:
    """Two tables of one kind, and the rows that both have."""

    here: Cube
    there: Cube
    axes: tuple[Axis, ...]
    """Those that both have, slowest first."""
    at_here: Mapping[str, Ints]
    """The positions on the axes of either that both have, in the same order."""
    at_there: Mapping[str, Ints]
    left_out: Mapping[str, str] = field(default_factory=dict)
    """By the key of an axis, which of its values only one of them has."""

    @classmethod
    def of(cls, tables: Sequence[TableFiles], ours: Study, theirs: Study) -> Pair:
        """Match two tables by the values of their axes; raises UsageError where they have nothing in common."""
        here, there = map(cube_of, tables)
        others = {axis.key: axis for axis in there.axes}
        at_here, at_there, axes, left_out = {}, {}, [], {}
        for axis in here.axes:
            other = others.pop(axis.key, None)
            if other is None:
                at_here[axis.column] = _single(axis, theirs)
            else:
                axes.append(axis)
                at_here[axis.column], at_there[other.column] = _common(axis, other)
            both = len(at_here[axis.column])
            left_out[axis.key] = _only(
                axis.key, len(axis) - both, len(other) - both if other else 0
            )
        for axis in others.values():
            at_there[axis.column] = _single(axis, ours)
            left_out[axis.key] = _only(axis.key, 0, len(axis) - 1)
        return cls(
            here,
            there,
            tuple(axes),
            at_here,
            at_there,
            {key: text for key, text in left_out.items() if text},
        )

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of common values on each axis."""
        return tuple(len(self.at_here[axis.column]) for axis in self.axes)

    @property
    def columns(self) -> list[str]:
        """Results that both tables have."""
        return [name for name in _results(self.here) if name in _results(self.there)]

    @property
    def columns_of_one(self) -> list[str]:
        """Results that only one of the tables has, in words."""
        return [
            f"{self.here.kind}.{name}: a column in {which} only"
            for cube, which in ((self.here, "this run"), (self.there, "the baseline"))
            for name in _results(cube)
            if name not in self.columns
        ]

    def both(self, name: str) -> tuple[Values, Values]:
        """A column on the rows that both have."""
        order = [axis.column for axis in self.axes]
        here = self.here.gather(self.here.rows(order, self.at_here), [name])
        return here[name].ravel(), self.there.gather(self.there.rows(order, self.at_there), [name])[
            name
        ].ravel()

    def where(self, row: int) -> dict[str, float | str]:
        """A common row by its axes."""
        place: dict[str, float | str] = {}
        for axis, at in zip(self.axes, np.unravel_index(row, self.shape), strict=True):
            value = axis.values[self.at_here[axis.column][at]]
            place[axis.column] = str(value) if axis.is_text else float(value)
        return place

    def changes(self, tolerance: float) -> list[Record]:
        """Columns that differ, those first that do so by the largest share of their scale."""
        changes = []
        for name in self.columns:
            is_flag, (first, second) = name in FLAGS, self.both(name)
            size = difference(first, second, is_flag=is_flag)
            if not size.any():
                continue
            scale = 1.0 if is_flag else max(_largest(first), _largest(second))
            row, beyond = int(np.argmax(size)), size > (0.0 if is_flag else tolerance * scale)
            rows = beyond if beyond.any() else size > 0.0
            changes.append(
                {
                    "table": self.here.kind,
                    "column": name,
                    "difference": None if is_flag else float(size[row]),
                    "share": float(size.mean() if is_flag else size[row] / (scale or 1.0)),
                    "rows": int(rows.sum()),
                    "where": self.where(row),
                    "is_beyond": bool(beyond.any()),
                }
            )
        return sorted(changes, key=lambda change: -change["share"])

    def flips(self) -> list[Record]:
        """Designs that are feasible in one of the runs only, the worst first."""
        (now, before), margins = self.both("feasible"), self.both("margin")
        flips = []
        for row in np.flatnonzero(now != before).tolist():
            known = [float(each[row]) if math.isfinite(each[row]) else None for each in margins]
            place = self.where(row)
            flips.append(
                {
                    "where": place,
                    "now": bool(now[row]),
                    "margin_before": known[1],
                    "margin_now": known[0],
                }
            )
        return sorted(flips, key=_moved, reverse=True)


def _results(cube: Cube) -> list[str]:
    """Columns that are computed; the others say which design or state a row is."""
    known = {*OF_DESIGNS, *OF_CYCLES, *OF_STATES, *FLAGS}
    return (
        [name for name in cube.files.schema.names if name in known]
        if cube.files is not None
        else []
    )


def _largest(values: Values) -> float:
    return float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0))


def difference(first: Values, second: Values, *, is_flag: bool) -> npt.NDArray[np.float64]:
    """By how much each row differs: 1 for another flag, infinite where only one is null."""
    if is_flag:
        return np.asarray(first != second, dtype=np.float64)
    one_is_null = np.isnan(first) != np.isnan(second)
    return np.where(one_is_null, np.inf, np.abs(np.nan_to_num(first - second)))


def _moved(flip: Record) -> float:
    """By how much its margin moved, N; what has none, most of all."""
    before, now = flip["margin_before"], flip["margin_now"]
    return math.inf if before is None or now is None else abs(now - before)


def _only(key: str, here: int, there: int) -> str:
    """Which values of an axis one of the runs has alone; empty if both have the same."""
    parts = [f"{counted(here, 'value')} in this run only"] if here else []
    parts += [f"{counted(there, 'value')} in the baseline only"] if there else []
    return f"{key}: {', '.join(parts)}" if parts else ""


def _common(axis: Axis, other: Axis) -> tuple[Ints, Ints]:
    """The positions on two axes at which both have the same value."""
    mine, theirs = (np.array([_token(value) for value in each.values]) for each in (axis, other))
    _, first, second = np.intersect1d(mine, theirs, return_indices=True)
    if not len(first):
        raise UsageError(
            f"the runs have no value of {axis.key} in common",
            hint="runs are compared by axis values",
        )
    order = np.argsort(first)
    return first[order], second[order]


def _single(axis: Axis, other: Study) -> Ints:
    """Where an axis has the one value that the other run has of it."""
    value = other.numbers[axis.key].single if axis.key in other.numbers else None
    places = [
        at
        for at, each in enumerate(axis.values)
        if value is not None and _token(each) == _token(value)
    ]
    if places or len(axis) == 1:
        return np.array(places[:1] or [0], dtype=np.int64)
    raise UsageError(
        f"only one of the runs has the axis {axis.key}, and the other's value is not on it"
    )


def _token(value: Any) -> str:
    return value if isinstance(value, str) else f"{float(value):.12g}"
