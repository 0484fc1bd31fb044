"""A run checked: against its limits, or against another run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tendon_cli.checks.compare import (
    Comparison,
    compare_tables,
    flips,
    only_in_one,
)
from tendon_cli.checks.limits import check_designs
from tendon_cli.checks.shared import check_studies, shared_rows
from tendon_cli.checks.text import comparison_text, record_of, verdict_text
from tendon_cli.cube.cube import cube_of
from tendon_cli.engine.results import AnyResult, folder_of, open_run, verified_record
from tendon_cli.errors import UsageError
from tendon_cli.studies.load import recorded_study
from tendon_cli.tables.read import TableFiles, open_table

TOLERANCE = 1e-9
"""The share of a column's scale by which numbers may differ."""
WORST = 10
"""How many breaches or flips are listed."""


@dataclass(frozen=True)
class Checked:
    """What came of it."""

    holds: bool
    text: str
    record: dict[str, Any]


def check(
    run: AnyResult, baseline: AnyResult | None = None, *, tolerance: float = TOLERANCE, apart: Sequence[str] = (),
    worst: int = WORST,
) -> Checked:  # fmt: skip
    """Whether every design of a run is within its limits, or with a baseline what changed since that run.

    An answer holds if at least one choice has a window. The result has `holds`, `text` and `record`. `tolerance` is the
    share of a column's scale by which numbers may differ, `apart` are keys in which the studies may differ. Every file
    is verified first. Raises InputError for what is damaged or is no run, UsageError for a run without designs.

    >>> import tendon_cli as tendon
    >>> tendon.sweep({"limits": {"max_tension": "150 N"}}, "results/mine").designs.max_tension.round().item()
    151.0
    >>> tendon.check("results/mine").holds
    False
    """
    folder = folder_of(run)
    if baseline is not None:
        return compare(folder, folder_of(baseline), tolerance=tolerance, apart=tuple(apart), worst=worst)
    record = verified_record(folder)
    if record["verb"] == "design":
        return _answer(record)
    table = _designs(folder, record)
    result = check_designs(table, recorded_study(table.facts["study"]), worst)
    return Checked(result.holds, verdict_text(result, cube_of(table), record["name"]), record_of(result))


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
    flipped, count = flips(here, there, shared, worst)
    compared = [compare_tables(here, there, shared, tolerance)]
    missing, left_out, rows = [*only_in_one(here, there)], dict(shared.left_out), 0
    kept = ["states" in run.record["study"]["output"]["tables"] for run in runs]
    if all(kept):
        now, before = (cube_of(open_table(each / "states.parquet")) for each in (folder, baseline))
        of_states = shared_rows(now, before, ours, theirs)
        compared.append(compare_tables(now, before, of_states, tolerance))
        rows = math.prod(of_states.shape)
        missing += only_in_one(now, before)
        left_out |= of_states.left_out
    elif any(kept):
        missing.append(f"states: a table in {'this run' if kept[0] else 'the baseline'} only")
    excepted = {key: text for key, text in left_out.items() if any(f"{key}.".startswith(f"{each}.") for each in apart)}
    missing += [text for key, text in left_out.items() if key not in excepted]
    result = Comparison(
        designs=math.prod(shared.shape),
        states=rows,
        columns={each.table: each.columns for each in compared},
        missing=tuple(missing),
        excepted=tuple(excepted.values()),
        within=max((each.within for each in compared if each.within), key=lambda change: change.share, default=None),
        changes=tuple(change for each in compared for change in each.changes),
        flips=flipped,
        flipped=count,
    )
    names = str(folder), str(baseline)
    return Checked(result.holds, comparison_text(result, here, names), record_of(result))


def _designs(folder: Path, record: dict[str, Any]) -> TableFiles:
    if "designs" not in record["study"]["output"]["tables"]:
        hint = '[output] tables needs "designs"'
        raise UsageError("the run has no table of designs to check", where=str(folder), hint=hint)
    return open_table(folder / "designs.parquet")
