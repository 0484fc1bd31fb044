"""Comparison of two runs, on the designs and states that both have."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tendon_cli import say
from tendon_cli.checks.check_text import place_text
from tendon_cli.checks.compared import (
    MOST_NAMES,
    Compared,
    ComparedResult,
    Move,
    Number,
    Unserved,
    better_of,
    difference,
    judge,
)
from tendon_cli.checks.table_pair import FLAGS, TablePair
from tendon_cli.cube.cube import cube_in
from tendon_cli.engine.results import Run
from tendon_cli.engine.study_differences import Difference
from tendon_cli.errors import UsageError
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.quantities import QUANTITIES, unit_of_reading
from tendon_cli.tables.schema import finite_or_none


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
    cubes = [cube_in(run, "designs") for run in runs]
    try:
        pairs = [TablePair.of(*cubes)]
    except UsageError as error:
        note = f"{labels[1]}: the runs share no design, because {error.message}."
        return Compared(first, second, differences, [], left_out={"": note}, notes=[note])
    left_out = dict(pairs[0].left_out)
    has_states = ["states" in run.record["study"]["output"]["tables"] for run in runs]
    if all(has_states):
        pairs.append(TablePair.of(*(cube_in(run, "states") for run in runs)))
        left_out |= pairs[1].left_out
    elif any(has_states):
        owner = "the first" if has_states[0] else "the second"
        left_out["states"] = f"states: a table in {owner} only"
    designs = pairs[0]
    before, now = designs.both("feasible")
    counts = []
    for pair in pairs:
        columns = say.counted(len(pair.columns), "column")
        counts.append(f"{columns} of {say.counted(pair.rows[0].size, pair.kind.removesuffix('s'))}")
    notes = []
    sizes = [cube.table.rows for cube in cubes if cube.table is not None]
    if sizes != [before.size, before.size]:
        notes.append(
            f"{labels[1]}: {say.counted(before.size, 'design')} in both, out of "
            f"{say.counted(sizes[0], 'design')} of the first and {sizes[1]:,} of {labels[1]}; only "
            "these are compared."
        )
    return Compared(
        first,
        second,
        differences,
        [number for pair in pairs for number in _numbers(pair)],
        gained=_move(designs, now > before, 0),
        lost=_move(designs, before > now, 1),
        compared=" and ".join(counts),
        left_out=left_out,
        notes=notes,
    )


def pair_of_designs(runs: tuple[Run, Run]) -> TablePair:
    """Match the designs of two runs; raises UsageError if they have none in common."""
    return TablePair.of(*(cube_in(run, "designs") for run in runs))


def _side(run: Run, label: str) -> ComparedResult:
    """Return name, folder and summary of a run."""
    record = run.record
    feasible = say.share(record["feasible"], record["designs"], "design")
    slack = say.share(record["slack"], record["states"], "state")
    sentence = f"{feasible} feasible: taut, stable and within every limit; {slack} slack."
    return ComparedResult.of(run, label, sentence, unit_of_reading(run.study.setting.read))


def _numbers(pair: TablePair) -> Iterator[Number]:
    """Yield every column that both tables have, the margin first."""
    for name in sorted(pair.columns, key=lambda name: (name != "feasible", name != "margin")):
        columns = pair.both(name)
        is_flag = name in FLAGS
        size = difference(*columns, is_flag=is_flag)
        changes = Number.changes(size, *columns, is_flag=is_flag)
        row = int(np.argmax(size))
        better = better_of(name) if pair.kind == "designs" else 0
        verdict = None
        a: float | None = None
        b: float | None = None
        if is_flag and name != "status":
            a, b = (float(np.mean(values)) for values in columns)
            verdict = judge(int(name == "feasible"), a, b)
        elif better:
            a, b = (_worst(name, values) for values in columns)
            verdict = judge(better, a, b)
        elif not is_flag:
            a, b = (finite_or_none(float(values[row])) for values in columns)
        place = pair.where(row) if changes["rows"] else None
        yield Number(
            name,
            _label(name),
            "1" if is_flag else QUANTITIES[name].unit,
            a,
            b,
            verdict,
            table=pair.kind,
            where=place or {},
            at="" if place is None else place_text(place, pair.cubes[0]),
            **changes,
        )


def _label(name: str) -> str:
    """Say the worst value of a column in words."""
    if name == "feasible":
        return "feasible designs"
    words = say.column(name)
    better = better_of(name)
    if words.startswith(("min ", "max ", "peak ")):
        better = 1 if words.startswith("min ") else -1
        words = words.partition(" ")[2]
    if not better:
        return words
    return f"least {words}" if better > 0 else f"largest {words}"


def _worst(name: str, values: Array) -> float | None:
    """Return the worst value of a column; None if no design has one."""
    magnitudes = np.abs(values) if name.startswith("peak_") else values
    known = magnitudes[~np.isnan(magnitudes)]
    if not known.size:
        return None
    return finite_or_none(float(known.min() if better_of(name) > 0 else known.max()))


def _move(pair: TablePair, is_moved: Flags, loser: int) -> Move:
    """Return the designs that only one of the runs has feasible, and which limits the other breaks.

    Args:
        pair: Designs of both.
        is_moved: True for these designs.
        loser: 0 if they break limits in the first run, 1 for the second.
    """
    why = [
        Unserved(place_text(pair.where(row), pair.cubes[0]), ", ".join(pair.broken(loser, row)))
        for row in np.flatnonzero(is_moved).tolist()[:MOST_NAMES]
    ]
    return Move.named_ones("designs", int(is_moved.sum()), len(is_moved), why)
