"""A run checked: against its limits, or against another run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tendon_cli.checks.compare import Change, Comparison, check_studies, compare_tables, flips, shared_rows
from tendon_cli.checks.limits import check_designs
from tendon_cli.checks.text import comparison_text, record_of, verdict_text
from tendon_cli.cube.cube import Cube, cube_of
from tendon_cli.engine.results import open_run, verified_record
from tendon_cli.errors import UsageError
from tendon_cli.studies.load import recorded_study
from tendon_cli.tables.read import TableFiles, open_table

WORST = 10
"""How many breaches or flips are told."""


@dataclass(frozen=True)
class Checked:
    """What came of it."""

    holds: bool
    text: str
    record: dict[str, Any]


def check(folder: Path, *, worst: int = WORST) -> Checked:
    """Is every design of a run, or at least one choice of an answer, within its limits.

    Every file is verified first. Raises InputError for what is damaged or is no run, UsageError for a run whose designs
    were not written.
    """
    record = verified_record(folder)
    if record["verb"] == "design":
        return _answer(record)
    table = _designs(folder, record)
    found = check_designs(table, recorded_study(table.facts["study"]), worst)
    return Checked(found.holds, verdict_text(found, cube_of(table), record["name"]), record_of(found))


def _answer(record: dict[str, Any]) -> Checked:
    choices, feasible = record["choices"], record["feasible"]
    text = f"{record['name']}: {feasible:,} of {choices:,} choices have a window of pretension"
    nothing = {"choices": choices, "feasible": feasible, "conflicts": record["conflicts"], "holds": feasible > 0}
    if not feasible:
        text += "\n" + "\n".join(f"  {' against '.join(each['limits'])}" for each in record["conflicts"])
    return Checked(feasible > 0, text, nothing)


def compare(
    folder: Path, baseline: Path, *, tolerance: float, apart: Sequence[str] = (), worst: int = WORST
) -> Checked:
    """What changed since another run: columns beyond the tolerance, flags exactly, designs that became feasible or not.

    Raises InputError for what is damaged or is no run, UsageError where the studies differ in more than the values of
    axes and the keys `apart`.
    """
    runs = [open_run(each) for each in (folder, baseline)]
    tables = [_designs(each, run.record) for each, run in zip((folder, baseline), runs, strict=True)]
    ours, theirs = (recorded_study(table.facts["study"]) for table in tables)
    check_studies(ours, theirs, apart)
    here, there = (cube_of(table) for table in tables)
    shared = shared_rows(here, there, ours, theirs)
    changes: tuple[Change, ...] = compare_tables(here, there, shared, tolerance)
    flipped, count = flips(here, there, shared, worst)
    states = _states(folder, baseline, [run.record for run in runs])
    rows = 0
    if states is not None:
        of_states = shared_rows(*states, ours, theirs)
        rows = math.prod(of_states.shape)
        changes += compare_tables(*states, of_states, tolerance)
    found = Comparison(math.prod(shared.shape), rows, changes, flipped, count)
    names = str(folder), str(baseline)
    return Checked(found.holds, comparison_text(found, here, names), record_of(found))


def _designs(folder: Path, record: dict[str, Any]) -> TableFiles:
    if "designs" not in record["study"]["output"]["tables"]:
        hint = '[output] tables needs "designs"'
        raise UsageError("the run has no table of designs to check", where=str(folder), hint=hint)
    return open_table(folder / "designs.parquet")


def _states(folder: Path, baseline: Path, records: list[dict[str, Any]]) -> tuple[Cube, Cube] | None:
    if any("states" not in record["study"]["output"]["tables"] for record in records):
        return None
    return cube_of(open_table(folder / "states.parquet")), cube_of(open_table(baseline / "states.parquet"))
