"""What changed between two runs, on the designs and states that both have."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tendon_cli.checks.shared import WORST, Checked, Shared, check_studies, designs_in, shared_rows
from tendon_cli.checks.text import comparison_text, finite
from tendon_cli.cube.axes import Ints
from tendon_cli.cube.cube import Cube, cube_of
from tendon_cli.engine.columns import JUDGEMENTS
from tendon_cli.engine.results import open_run
from tendon_cli.quantities import OF_CYCLES, OF_DESIGNS, OF_STATES
from tendon_cli.space.axis import Axis
from tendon_cli.studies.load import recorded_study
from tendon_cli.tables.read import open_table

_ROWS_AT_ONCE = 2**18
FLAGS = ("status", *JUDGEMENTS)
"""Columns of words and truths, which are compared exactly."""

Values = npt.NDArray[Any]
Record = dict[str, Any]
"""A change, a flip, or all of them, for text and programs alike."""


def compare(
    folder: Path, baseline: Path, *, tolerance: float, apart: Sequence[str] = (), worst: int = WORST
) -> Checked:
    """What changed since another run: columns beyond the tolerance, flags exactly, designs that became feasible or not.

    Raises InputError for what is damaged or is no run, UsageError where the studies differ in more than the values of
    axes and the keys `apart`.
    """
    folders, runs = (folder, baseline), [open_run(each) for each in (folder, baseline)]
    tables = [designs_in(each, run.record) for each, run in zip(folders, runs, strict=True)]
    ours, theirs = (recorded_study(table.facts["study"]) for table in tables)
    check_studies(ours, theirs, apart)
    pairs = [tuple(cube_of(table) for table in tables)]
    kept = ["states" in run.record["study"]["output"]["tables"] for run in runs]
    missing = [f"states: a table in {'this run' if kept[0] else 'the baseline'} only"] if any(kept) else []
    if all(kept):
        pairs.append(tuple(cube_of(open_table(each / "states.parquet")) for each in folders))
        missing = []
    columns, rows, changes, within = dict[str, int](), {"designs": 0, "states": 0}, list[Record](), list[Record]()
    left_out: dict[str, str] = {}
    for here, there in pairs:
        shared = shared_rows(here, there, ours, theirs)
        rows[here.kind], left_out = math.prod(shared.shape), {**left_out, **shared.left_out}
        common = [name for name in _results(here) if name in _results(there)]
        columns[here.kind] = len(common)
        beyond, small = _changes(here, there, shared, common, tolerance)
        changes, within = changes + beyond, within + small
        missing += [
            f"{here.kind}.{name}: a column in {which} only"
            for cube, which in ((here, "this run"), (there, "the baseline"))
            for name in _results(cube)
            if name not in common
        ]
    excepted = {key: text for key, text in left_out.items() if any(f"{key}.".startswith(f"{each}.") for each in apart)}
    missing += [text for key, text in left_out.items() if key not in excepted]
    here, there = pairs[0]
    flips, flipped = _flips(here, there, shared_rows(here, there, ours, theirs), worst)
    record: Record = {
        **rows,
        "columns": columns,
        "missing": missing,
        "excepted": list(excepted.values()),
        "within": max(within, key=lambda change: change["share"], default=None),
        "changes": changes,
        "flips": flips,
        "flipped": flipped,
        "holds": not changes and not flipped and not missing,
    }
    return Checked(record["holds"], comparison_text(record, here, (str(folder), str(baseline))), finite(record))


def _results(cube: Cube) -> list[str]:
    """Columns that are computed; the others say which design or state a row is."""
    known = {*OF_DESIGNS, *OF_CYCLES, *OF_STATES, *FLAGS}
    return [name for name in cube.files.schema.names if name in known] if cube.files is not None else []


def _changes(
    here: Cube, there: Cube, shared: Shared, columns: Sequence[str], tolerance: float
) -> tuple[list[Record], list[Record]]:
    """Columns that differ by more than a share of their scale, the worst first; and smaller differences."""
    numbers = [name for name in columns if name not in FLAGS]
    scale = dict.fromkeys(columns, 0.0)
    for _, *both in _together(here, there, shared, numbers):
        for name in numbers:
            for each in both:
                values = each[name][np.isfinite(each[name])]
                scale[name] = max(scale[name], float(np.max(np.abs(values), initial=0.0)))
    beyond, within = dict[str, Record](), list[Record]()
    for start, first, second in _together(here, there, shared, columns):
        for name in columns:
            size = _difference(first[name], second[name], is_flag=name in FLAGS)
            if not size.any():
                continue
            row, is_beyond = int(np.argmax(size)), size > (0.0 if name in FLAGS else tolerance * scale[name])
            share = float(size.mean() if name in FLAGS else size[row] / (scale[name] or 1.0))
            rows, where = int((is_beyond if is_beyond.any() else size > 0.0).sum()), shared.where(start + row)
            difference = None if name in FLAGS else float(size[row])
            change: Record = {"table": here.kind, "column": name, "difference": difference}
            change |= {"share": share, "rows": rows, "where": where}
            if not is_beyond.any():
                within.append(change)
            else:
                before = beyond.get(name, change | {"rows": 0})
                worst = max(before, change, key=lambda each: each["share"])
                beyond[name] = worst | {"rows": before["rows"] + rows}
    return sorted(beyond.values(), key=lambda change: -change["share"]), within


def _difference(first: Values, second: Values, *, is_flag: bool) -> npt.NDArray[np.float64]:
    """By how much each row differs: 1 for another flag, infinite where only one is null."""
    if is_flag:
        return np.asarray(first != second, dtype=np.float64)
    one_is_null = np.isnan(first) != np.isnan(second)
    return np.where(one_is_null, np.inf, np.abs(np.nan_to_num(first - second)))


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


def _row_numbers(cube: Cube, at: Mapping[str, Ints], axes: Sequence[Axis], places: Sequence[Ints], flat: Ints) -> Ints:
    rows = np.zeros(len(flat), dtype=np.int64)
    for axis, place in zip(axes, places, strict=True):
        rows += at[axis.column][place] * cube.strides[axis.column]
    varied = {axis.column for axis in axes}
    fixed = (axis.column for axis in cube.axes if axis.column not in varied)
    return rows + sum(int(at[column][0]) * cube.strides[column] for column in fixed)


def _flips(here: Cube, there: Cube, shared: Shared, most: int) -> tuple[list[Record], int]:
    """Designs that are feasible in one of the runs only, the worst first; and how many there are."""
    flipped, count = list[Record](), 0
    for start, first, second in _together(here, there, shared, ("feasible", "margin")):
        for row in np.flatnonzero(first["feasible"] != second["feasible"]):
            count += 1
            margins = [float(side["margin"][row]) for side in (second, first)]
            known = [each if math.isfinite(each) else None for each in margins]
            place, now = shared.where(start + int(row)), bool(first["feasible"][row])
            flipped.append({"where": place, "now": now, "margin_before": known[0], "margin_now": known[1]})
        flipped = sorted(flipped, key=_moved, reverse=True)[:most]
    return flipped, count


def _moved(flip: Record) -> float:
    """By how much its margin moved, N; what has none, most of all."""
    before, now = flip["margin_before"], flip["margin_now"]
    return math.inf if before is None or now is None else abs(now - before)
