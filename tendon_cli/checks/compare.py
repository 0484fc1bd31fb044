"""Comparison of two runs, on the designs and states that both have."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.checks.breaches import breaches_in, columns_of
from tendon_cli.checks.check_text import CheckResult, comparison_text, finite
from tendon_cli.cube.columns import ColumnArray
from tendon_cli.cube.cube import Cube, cube_of
from tendon_cli.engine.records import differences
from tendon_cli.engine.results import Run
from tendon_cli.engine.table_columns import JUDGEMENTS
from tendon_cli.errors import UsageError
from tendon_cli.model.kinematics import Rows
from tendon_cli.quantities import OF_CYCLES, OF_DESIGNS, OF_STATES
from tendon_cli.space.axis import Axis
from tendon_cli.studies.fields import hint_at_nearest
from tendon_cli.studies.json_schema import key_words
from tendon_cli.studies.study import Study
from tendon_cli.tables.schema import finite_or_none
from tendon_cli.units import counted, shorten

FLAGS = ("status", *JUDGEMENTS)
"""Columns of words, and of true or false, which are compared exactly."""
TOLERANCE = 1e-9
"""Share of a column's scale by which numbers may differ."""
_MAY_DIFFER = (
    "motion.elbow_angle",
    "motion.direction",
    "cases",
    "table",
    "name",
    "title",
    "output",
    "figure",
)
"""Keys that only say which rows a study has, or that change no number."""
_RESULTS = frozenset({*OF_DESIGNS, *OF_CYCLES, *OF_STATES, *FLAGS})
"""Columns that are computed; the others define the design or state of a row."""

Breaking = dict[str, set[int]]
"""Rows that break each limit, by its name; slack and no equilibrium count as limits."""
Record = dict[str, Any]
"""Change of a column, flip of a design, or the whole comparison, as in JSON."""


def compare_runs_since(
    run: Run, baseline: Run, tolerance: float, apart: Sequence[str], worst: int
) -> CheckResult:
    """Find what changed since another run, as `compare` does for folders."""
    runs = [run, baseline]
    ours, theirs = (run.study for run in runs)
    cubes = [cube_of(run.kept("designs"), run.study) for run in runs]
    check_studies(ours, theirs, apart, (*ours.axes, *theirs.axes, *_MAY_DIFFER))
    pairs = [TablePair.of(*cubes)]
    missing = []
    has_states = ["states" in run.record["study"]["output"]["tables"] for run in runs]
    if all(has_states):
        pairs.append(TablePair.of(*(cube_of(run.kept("states"), run.study) for run in runs)))
    elif any(has_states):
        owner = "this run" if has_states[0] else "the baseline"
        missing.append(f"states: a table in {owner} only")
    changes: list[Record] = []
    left_out: dict[str, str] = {}
    for pair in pairs:
        changes += pair.changes(tolerance)
        missing += pair.columns_of_one
        left_out |= pair.left_out
    excepted = []
    for key, text in left_out.items():
        if _is_within(key, apart):
            excepted.append(text)
        else:
            missing.append(text)
    beyond = []
    within = []
    for change in changes:
        is_beyond = change.pop("is_beyond")
        if is_beyond:
            beyond.append(change)
        else:
            within.append(change)
    flips = pairs[0].flips()
    record: Record = {
        "states": 0,
        **{pair.here.kind: math.prod(pair.shape) for pair in pairs},
        "columns": {pair.here.kind: len(pair.columns) for pair in pairs},
        "missing": missing,
        "excepted": excepted,
        "within": max(within, key=lambda change: change["share"], default=None),
        "changes": beyond,
        "flips": flips[:worst],
        "flipped": len(flips),
        "holds": not beyond and not flips and not missing,
    }
    names = (str(run.folder or "this run"), str(baseline.folder or "the baseline"))
    text = comparison_text(record, pairs[0].here, names)
    verdict = "nothing changed" if record["holds"] else "changed"
    return CheckResult(record["holds"], text, finite(record), verdict)


def check_studies(
    ours: Study, theirs: Study, apart: Sequence[str], may_differ: Sequence[str]
) -> None:
    """Raise UsageError if studies differ in other keys than `apart` and those that may differ."""
    known: set[str] = set()  # keys, and the tables that they are in
    for key in key_words():
        parts = key.split(".")
        known.update(".".join(parts[: depth + 1]) for depth in range(len(parts)))
    unknown = [key for key in apart if key not in known.union(Study.model_fields)]
    if unknown:
        hint = hint_at_nearest(unknown[0], known) or "`tendon init --schema` lists every key"
        raise UsageError(f'a study has no key "{shorten(unknown[0])}"', where="--except", hint=hint)
    varied = {*may_differ, *apart}
    lines = []
    beyond = []
    for key, line in differences(theirs.document(), ours.document(), ours.sources).items():
        if not _is_within(key, varied):
            lines.append(line)
            beyond.append(f"--except {key}")
    if lines:
        hint = f"{' '.join(beyond[:4])} compares them anyway"
        raise UsageError(
            f"the baseline belongs to another study: {'; '.join(lines[:4])}", hint=hint
        )


def _is_within(key: str, keys: Collection[str]) -> bool:
    """Return True if a key is one of `keys`, or in a table that is."""
    return any(f"{key}.".startswith(f"{table}.") for table in keys)


@dataclass(frozen=True)
class TablePair:
    """Two tables of one kind, and the rows that both have."""

    here: Cube
    there: Cube
    axes: tuple[Axis, ...]
    """Axes that both have, slowest first."""
    at_here: Mapping[str, Rows]
    """Common positions on each axis of this table, by its column."""
    at_there: Mapping[str, Rows]
    """The same positions on each axis of the other table, in the same order."""
    left_out: Mapping[str, str] = field(default_factory=dict)
    """Values that only one of them has, in words, by the key of the axis."""

    @classmethod
    def of(cls, here: Cube, there: Cube) -> TablePair:
        """Match two tables by the values of their axes.

        Raises:
            UsageError: if they have nothing in common.
        """
        others = {axis.key: axis for axis in there.axes}
        axes: list[Axis] = []
        at_here: dict[str, Rows] = {}
        at_there: dict[str, Rows] = {}
        left_out: dict[str, str] = {}
        for axis in here.axes:
            other = others.pop(axis.key, None)
            if other is None:
                at_here[axis.column] = _single(axis, there.study)
                left_out[axis.key] = _only(axis.key, len(axis) - 1, 0)
                continue
            axes.append(axis)
            first, second = _common(axis, other)
            at_here[axis.column] = first
            at_there[other.column] = second
            left_out[axis.key] = _only(axis.key, len(axis) - len(first), len(other) - len(first))
        for axis in others.values():
            at_there[axis.column] = _single(axis, here.study)
            left_out[axis.key] = _only(axis.key, 0, len(axis) - 1)
        left_out = {key: text for key, text in left_out.items() if text}
        return cls(here, there, tuple(axes), at_here, at_there, left_out)

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
        common = self.columns
        lines = []
        for cube, owner in ((self.here, "this run"), (self.there, "the baseline")):
            names = [name for name in _results(cube) if name not in common]
            lines += [f"{self.here.kind}.{name}: a column in {owner} only" for name in names]
        return lines

    def both(self, name: str) -> tuple[ColumnArray, ColumnArray]:
        """Return a column of both tables, on the rows that both have."""
        order = [axis.column for axis in self.axes]
        here = self.here.gather(self.here.rows(order, self.at_here), [name])
        there = self.there.gather(self.there.rows(order, self.at_there), [name])
        return here[name].ravel(), there[name].ravel()

    def where(self, row: int) -> dict[str, float | str]:
        """Return the values of a common row on the axes."""
        values: dict[str, float | str] = {}
        for axis, place in zip(self.axes, np.unravel_index(row, self.shape), strict=True):
            value = axis.values[self.at_here[axis.column][place]]
            values[axis.column] = str(value) if axis.is_text else float(value)
        return values

    def changes(self, tolerance: float) -> list[Record]:
        """List the columns that differ, that with the largest share of its scale first."""
        changes = []
        for name in self.columns:
            change = self._change(name, tolerance)
            if change is not None:
                changes.append(change)
        return sorted(changes, key=lambda change: -change["share"])

    def _change(self, name: str, tolerance: float) -> Record | None:
        """Describe the largest change of a column. Return None if there is none."""
        is_flag = name in FLAGS
        first, second = self.both(name)
        size = difference(first, second, is_flag=is_flag)
        if not size.any():
            return None
        row = int(np.argmax(size))
        if is_flag:
            beyond = size > 0.0
            share = size.mean()
        else:
            scale = max(_largest(first), _largest(second))
            beyond = size > tolerance * scale
            share = size[row] / (scale or 1.0)
        rows = beyond if beyond.any() else size > 0.0
        return {
            "table": self.here.kind,
            "column": name,
            "difference": None if is_flag else float(size[row]),
            "share": float(share),
            "rows": int(rows.sum()),
            "where": self.where(row),
            "is_beyond": bool(beyond.any()),
        }

    def flips(self) -> list[Record]:
        """List the designs that are feasible in only one of the runs, the worst first."""
        now, before = self.both("feasible")
        margin_now, margin_before = self.both("margin")
        breaking_now, breaking_before = self.breaking()
        flips = []
        for row in np.flatnonzero(now != before).tolist():
            breaking = breaking_before if now[row] else breaking_now
            flip = {
                "where": self.where(row),
                "now": bool(now[row]),
                "limits": [limit for limit, rows in breaking.items() if row in rows],
                "margin_before": finite_or_none(margin_before[row]),
                "margin_now": finite_or_none(margin_now[row]),
            }
            flips.append(flip)
        return sorted(flips, key=_margin_change, reverse=True)

    def breaking(self) -> tuple[Breaking, Breaking]:
        """Return the common rows that break each limit of this run, and of the other one."""
        here, there = (self._breaking(cube, place) for place, cube in enumerate(self._cubes))
        return here, there

    @property
    def _cubes(self) -> tuple[Cube, Cube]:
        """Both tables, in the order of `both`."""
        return self.here, self.there

    def _breaking(self, cube: Cube, place: int) -> Breaking:
        """Return the common rows that break each limit of one of the runs.

        Args:
            cube: Designs of the run.
            place: Place of the run in `both`.
        """
        names = ["feasible", "taut", "margin", "required_pretension"]
        for limit in cube.limits:
            names += [*columns_of(limit), *cube.columns_of_bound(limit)]
        known = [name for name in dict.fromkeys(names) if name in cube.columns]
        common = [name for name in known if all(name in each.columns for each in self._cubes)]
        columns: dict[str, Any] = {name: self.both(name)[place] for name in common}
        columns["design"] = np.arange(math.prod(self.shape))
        found: Breaking = defaultdict(set)
        bounds = {limit: cube.bound(limit, columns) for limit in cube.limits}
        for breach in breaches_in(columns, bounds):
            found[breach["limit"]].add(breach["design"])
        return found


def _results(cube: Cube) -> list[str]:
    """Return the columns of a table that are computed."""
    if cube.table is None:
        return []
    return [name for name in cube.table.schema.names if name in _RESULTS]


def _largest(values: ColumnArray) -> float:
    """Return the largest magnitude in a column; 0 if nothing in it is finite."""
    return float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0))


def difference(
    first: ColumnArray, second: ColumnArray, *, is_flag: bool
) -> npt.NDArray[np.float64]:
    """Return the difference in each row: for flags 0 or 1; infinite if only one value is null."""
    if is_flag:
        return np.asarray(first != second, dtype=np.float64)
    one_is_null = np.isnan(first) != np.isnan(second)
    return np.where(one_is_null, np.inf, np.abs(np.nan_to_num(first - second)))


def _margin_change(flip: Record) -> float:
    """Return the change of the margin, N; infinite if either run has none."""
    before = flip["margin_before"]
    now = flip["margin_now"]
    return math.inf if before is None or now is None else abs(now - before)


def _only(key: str, here: int, there: int) -> str:
    """Say how many values of an axis only one of the runs has; "" if there are none."""
    parts = []
    if here:
        parts.append(f"{counted(here, 'value')} in this run only")
    if there:
        parts.append(f"{counted(there, 'value')} in the baseline only")
    return f"{key}: {', '.join(parts)}" if parts else ""


def _common(axis: Axis, other: Axis) -> tuple[Rows, Rows]:
    """Find the positions of the common values on two axes, in the order of the first."""
    ours = np.array([_token(value) for value in axis.values])
    theirs = np.array([_token(value) for value in other.values])
    _, first, second = np.intersect1d(ours, theirs, return_indices=True)
    if not len(first):
        raise UsageError(
            f"the runs have no value of {axis.key} in common",
            hint="runs are compared by axis values",
        )
    order = np.argsort(first)
    return first[order], second[order]


def _single(axis: Axis, other: Study) -> Rows:
    """Find the position on an axis of the single value that the other study has of it."""
    if axis.key in other.numbers:
        value = other.numbers[axis.key].single
        if value is not None:
            for place, candidate in enumerate(axis.values):
                if _token(candidate) == _token(value):
                    return np.array([place], dtype=np.int64)
    if len(axis) == 1:
        return np.array([0], dtype=np.int64)
    raise UsageError(
        f"only one of the runs has the axis {axis.key}, "
        "and it does not contain the other run's value"
    )


def _token(value: Any) -> str:
    """Return the text by which values of two axes are matched, to 12 significant digits."""
    return value if isinstance(value, str) else f"{float(value):.12g}"
