"""Comparison of two runs, on the designs and states that both have."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TypeAlias

import numpy as np

from tendon_cli import say
from tendon_cli.checks.check_text import place_text
from tendon_cli.checks.comparison_record import (
    Compared,
    ComparedResult,
    Judgement,
    Move,
    Number,
    Unserved,
)
from tendon_cli.checks.table_pair import FLAGS, TablePair, difference
from tendon_cli.cube.columns import ColumnArray
from tendon_cli.cube.cube import Cube, cube_of
from tendon_cli.engine.results import Run
from tendon_cli.errors import UsageError
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.quantities import QUANTITIES, unit_of_reading
from tendon_cli.studies.study_differences import Difference
from tendon_cli.tables.read import TableInMemory
from tendon_cli.tables.schema import finite_or_none

ROUNDING = 1e-9
"""Share of a number by which two numbers may differ by rounding."""
MOST_NAMES = 5
"""Most persons, draws or designs that are named."""
_BETTER = {
    "margin": 1,
    "required_pretension": -1,
    "motor_work_in": -1,
    "friction_loss": -1,
    "efficiency": 1,
    "spool_travel": -1,
    "rms_motor_torque": -1,
    "tolerance_length": 1,
}
"""Columns whose names do not say it: 1 if more is better, -1 if less is."""
_NEUTRAL = ("peak_elbow_torque",)
"""Columns that follow from the task, not from the suit."""
_BY_PREFIX = {"min_": 1, "max_": -1, "peak_": -1}


Judged: TypeAlias = tuple[float | None, float | None, Judgement | None]
"""Both values of a column, and the judgement on the second."""


def judge(better: int, before: float, now: float) -> Judgement:
    """Judge a number beside another one, apart from rounding.

    Args:
        better: 1 if more is better, -1 if less is.
        before: Number of the first result.
        now: Number of the second.
    """
    if before == now or math.isclose(before, now, rel_tol=ROUNDING):
        return "no difference"
    return "better" if (now > before) == (better > 0) else "worse"


def compare_runs(
    runs: tuple[Run, Run],
    labels: tuple[str, str],
    differences: list[Difference],
    choice: int | None,
) -> Compared:
    """Compare a run with the first one.

    Args:
        runs: The runs.
        labels: Name of each for texts.
        differences: Keys in which their studies differ.
        choice: Row of a choice; runs have none.

    Raises:
        UsageError: A choice is asked for, or a run has no table of designs.
        InputError: A table is damaged.
    """
    if choice is not None:
        hint = "`tendon design` answers for choices"
        raise UsageError("runs have no choices to compare", where="--choice", hint=hint)
    first, second = (_side(run, label) for run, label in zip(runs, labels, strict=True))
    try:
        pair = pair_of_designs(runs)
    except UsageError as error:
        if error.hint and "[output]" in error.hint:
            raise
        note = f"{second.label}: the runs share no design, because {error.message}."
        return Compared(first, second, differences, [], left_out={"": note}, notes=[note])
    pairs = [pair]
    left_out = dict(pair.left_out)
    has_states = ["states" in run.record["study"]["output"]["tables"] for run in runs]
    if all(has_states):
        pairs.append(TablePair.of(*(_cube(run, "states") for run in runs)))
        left_out |= pairs[1].left_out
    elif any(has_states):
        owner = "the first" if has_states[0] else "the second"
        left_out["states"] = f"states: a table in {owner} only"
    counts = []
    for each in pairs:
        left_out |= dict(each.columns_of_one)
        noun = each.first.kind.removesuffix("s")
        counts.append(
            f"{say.counted(len(each.columns), 'column')} of {say.counted(each.rows, noun)}"
        )
    feasible = pair.both("feasible")
    return Compared(
        first,
        second,
        differences,
        [number for each in pairs for number in _numbers(each)],
        gained=_move(pair, feasible[1] > feasible[0], pair.breaking(0)),
        lost=_move(pair, feasible[0] > feasible[1], pair.breaking(1)),
        compared=" and ".join(counts),
        left_out=left_out,
        notes=[*_notes(pair, labels[1])],
    )


def _cube(run: Run, table: str) -> Cube:
    """Return a table of a run, in its folder or in memory."""
    if run.folder is None:
        return cube_of(TableInMemory(run.table(table)), run.study)
    return cube_of(run.kept(table), run.study)


def pair_of_designs(runs: tuple[Run, Run]) -> TablePair:
    """Match the designs of two runs; raises UsageError if they have none in common."""
    return TablePair.of(*(_cube(run, "designs") for run in runs))


def _side(run: Run, label: str) -> ComparedResult:
    """Return name, folder and summary of a run."""
    record = run.record
    feasible = say.share(record["feasible"], record["designs"], "design")
    slack = say.share(record["slack"], record["states"], "state")
    sentence = f"{feasible} feasible: taut, stable and within every limit; {slack} slack."
    return ComparedResult.of(run, label, sentence, unit_of_reading(run.study.setting.read))


def _notes(pair: TablePair, label: str) -> Iterator[str]:
    """Say how many designs are compared, if not all of both."""
    sizes = [0 if cube.table is None else cube.table.rows for cube in (pair.first, pair.second)]
    if sizes != [pair.rows, pair.rows]:
        yield (
            f"{label}: {say.counted(pair.rows, 'design')} in both, out of "
            f"{say.counted(sizes[0], 'design')} of the first and {sizes[1]:,} of {label}; only "
            "these are compared."
        )


# --- Columns --------------------------------------------------------------------------------------


def _numbers(pair: TablePair) -> Iterator[Number]:
    """Yield every column that both tables have, the margin first."""
    for name in sorted(pair.columns, key=lambda name: (name != "feasible", name != "margin")):
        first, second = pair.both(name)
        is_flag = name in FLAGS
        size = difference(first, second, is_flag=is_flag)
        row = int(np.argmax(size))
        most = float(size[row])
        change = math.inf if is_flag and most else most
        if most and not is_flag:
            change = most / (max(_largest(first), _largest(second)) or 1.0)
        values = _judged(name, pair, first, second, row)
        yield Number(
            name,
            _label(name),
            "1" if is_flag else QUANTITIES[name].unit,
            *values,
            table=pair.first.kind,
            change=change,
            most=None if is_flag else most,
            rows=int((size > 0.0).sum()),
            where=pair.where(row) if most else {},
            at=place_text(pair.where(row), pair.first) if most else "",
        )


def better_of(name: str) -> int:
    """Return 1 if more of a column of designs is better, -1 if less is, 0 if neither is."""
    if name in _NEUTRAL:
        return 0
    for prefix, better in _BY_PREFIX.items():
        if name.startswith(prefix):
            return better
    return _BETTER.get(name, 0)


def _label(name: str) -> str:
    """Say the worst value of a column in words."""
    if name == "feasible":
        return "feasible designs"
    words = say.column(name)
    if words.startswith(("min ", "max ", "peak ")):
        extreme = "least" if words.startswith("min ") else "largest"
        return f"{extreme} {words.partition(' ')[2]}"
    if not better_of(name):
        return words
    return f"least {words}" if better_of(name) > 0 else f"largest {words}"


def _judged(
    name: str, pair: TablePair, first: ColumnArray, second: ColumnArray, row: int
) -> Judged:
    """Return the values of a column: shares of flags, the worst, or those that differ most."""
    if name == "status":
        return None, None, None
    if name in FLAGS:
        shares = (float(np.mean(first)), float(np.mean(second)))
        return *shares, judge(1, *shares) if name == "feasible" else None
    better = better_of(name)
    if not better or pair.first.kind != "designs":
        return finite_or_none(float(first[row])), finite_or_none(float(second[row])), None
    a, b = (_worst(name, values) for values in (first, second))
    verdict = None if a is None or b is None else judge(better, a, b)
    return a, b, verdict


def _worst(name: str, values: Array) -> float | None:
    """Return the worst value of a column; None if no design has one."""
    magnitudes = np.abs(values) if name.startswith("peak_") else values
    known = magnitudes[~np.isnan(magnitudes)]
    if not known.size:
        return None
    return finite_or_none(float(known.min() if better_of(name) > 0 else known.max()))


def _largest(values: Array) -> float:
    """Return the largest magnitude in a column; 0 if nothing in it is finite."""
    return float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0))


# --- Design by design -----------------------------------------------------------------------------


def _move(pair: TablePair, is_moved: Flags, breaking: dict[str, set[int]]) -> Move:
    """Return the designs that only one of the runs has feasible.

    Args:
        pair: Designs of both.
        is_moved: True for these designs.
        breaking: Designs of the other run that break each limit.
    """
    rows = np.flatnonzero(is_moved).tolist()
    names = {row: place_text(pair.where(row), pair.first) for row in rows[:MOST_NAMES]}
    why = []
    for row, name in names.items():
        broken = [limit for limit, broken_by in breaking.items() if row in broken_by]
        why.append(Unserved(name, ", ".join(broken)))
    return Move(
        kind="designs",
        count=len(rows),
        of=pair.rows,
        share=len(rows) / pair.rows,
        names=[*names.values()],
        named=len(rows),
        named_kind="designs",
        named_of=pair.rows,
        why=why,
    )
