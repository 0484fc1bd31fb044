"""Comparison of runs, on the designs that both have: margins with their sign, limits by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tendon_cli import say
from tendon_cli.checks.check_text import NO_EQUILIBRIUM, SLACK, place_text
from tendon_cli.checks.compare import TablePair
from tendon_cli.checks.compare_answers import any_value, judge
from tendon_cli.checks.comparison_record import (
    BesideFirst,
    BrokenRecord,
    ComparedResult,
    ComparisonRecord,
    Judgement,
    MarginRecord,
    MoveRecord,
    QuantityRecord,
)
from tendon_cli.checks.study_differences import study_differences
from tendon_cli.cube.columns import ColumnArray
from tendon_cli.cube.cube import Cube, cube_of
from tendon_cli.engine.results import Run
from tendon_cli.errors import UsageError
from tendon_cli.model.kinematics import Array
from tendon_cli.quantities import (
    OF_CYCLES,
    OF_DESIGNS,
    OF_TRAJECTORIES,
    QUANTITIES,
    unit_of_reading,
)
from tendon_cli.tables.read import TableInMemory
from tendon_cli.tables.schema import finite_or_none

_MOST_NAMES = 5
"""Most designs that are named."""
_ROUNDING = 1e-9
"""Share of the largest margin by which margins may differ by rounding."""
_BETTER = {
    "margin": 1,
    "required_pretension": -1,
    "motor_work_in": -1,
    "friction_loss": -1,
    "efficiency": 1,
    "spool_travel": -1,
    "rms_motor_torque": -1,
}
"""Columns whose names do not say it: 1 if more is better, -1 if less is."""
_NEUTRAL = ("peak_elbow_torque",)
"""Columns that follow from the task, not from the suit."""
_BY_PREFIX = {"min_": 1, "max_": -1, "peak_": -1}
_LIMIT_WORDS = {
    SLACK: "a tendon goes slack",
    NO_EQUILIBRIUM: "a state has no equilibrium",
}
"""Words for what counts as a limit and is none of the study."""


def compare_runs(
    runs: Sequence[Run], labels: Sequence[str], choice: int | None
) -> ComparisonRecord:
    """Return the comparison of runs with the first of them.

    Args:
        runs: The runs.
        labels: Name of each for texts.
        choice: Row of a choice; runs have none.

    Raises:
        UsageError: A choice is asked for, or a run has no table of designs.
        InputError: A table is damaged.
    """
    if choice is not None:
        hint = "`tendon design` answers for choices"
        raise UsageError("runs have no choices to compare", where="--choice", hint=hint)
    cubes = [_designs(run) for run in runs]
    notes: list[str] = []
    pairs = [
        _pair(cubes[0], cube, notes, label)
        for cube, label in zip(cubes[1:], labels[1:], strict=True)
    ]
    return {
        "results": [_result(run, label) for run, label in zip(runs, labels, strict=True)],
        "differences": study_differences(
            [run.study for run in runs], [run.record["versions"].get("tendon", "") for run in runs]
        ),
        "quantities": _quantities(cubes, pairs),
        "binds": [None] * len(runs),
        "beside": [_beside(pair) for pair in pairs],
        "notes": notes,
    }


def _designs(run: Run) -> Cube:
    """Return the designs of a run, in its folder or in memory."""
    if run.folder is None:
        return cube_of(TableInMemory(run.table("designs")), run.study)
    return cube_of(run.kept("designs"), run.study)


def _pair(first: Cube, other: Cube, notes: list[str], label: str) -> TablePair | None:
    """Match the designs of a run with those of the first; None, and a note, without any."""
    try:
        pair = TablePair.of(other, first)
    except UsageError as error:
        notes.append(f"{label}: the runs share no design, because {error.message}.")
        return None
    common = int(np.prod(pair.shape))
    sizes = (first.table.rows if first.table else 0, other.table.rows if other.table else 0)
    if sizes != (common, common):
        in_first = say.counted(sizes[0], "design")
        notes.append(
            f"{label}: {say.counted(common, 'design')} in both, out of {in_first} of the first and "
            f"{sizes[1]:,} of {label}; only these are compared."
        )
    return pair


def margins_of(first: Run, other: Run) -> tuple[Array, Array]:
    """Return the margins of the designs in two runs, (designs,) each, N: the first's, the other's.

    Raises:
        UsageError: The runs have no design in common.
    """
    now, before = TablePair.of(_designs(other), _designs(first)).both("margin")
    return before, now


def _result(run: Run, label: str) -> ComparedResult:
    """Return name, folder and summary of a run."""
    record = run.record
    feasible = say.share(record["feasible"], record["designs"], "design")
    slack = say.share(record["slack"], record["states"], "state")
    return {
        "label": label,
        "folder": None if run.folder is None else str(run.folder),
        "name": record["name"],
        "title": record["title"],
        "verb": record["verb"],
        "choice": "",
        "study_hash": record["study_hash"],
        "sentence": f"{feasible} feasible: taut, stable and within every limit; {slack} slack.",
        "unit": unit_of_reading(run.study.setting.read),
    }


# --- Quantities -----------------------------------------------------------------------------------


def _quantities(cubes: Sequence[Cube], pairs: Sequence[TablePair | None]) -> list[QuantityRecord]:
    """Return the worst value of each column over the designs that a run shares with the first.

    Where none are shared it is over all designs.
    """
    columns = (*OF_DESIGNS, *OF_CYCLES, *OF_TRAJECTORIES)
    names = [name for name in columns if better_of(name) and name in cubes[0].columns]
    quantities = [_feasible(cubes, pairs)]
    for name in ("margin", *(name for name in names if name != "margin")):
        values = [_worst(name, columns) for columns in _both(name, cubes, pairs)]
        quantity: QuantityRecord = {
            "name": name,
            "label": _label(name),
            "unit": QUANTITIES[name].unit,
            "values": values,
            "spans": [None] * len(cubes),
            "verdicts": [None, *(_judge(name, values[0], value) for value in values[1:])],
            "intervals": [None] * len(cubes),
        }
        if any_value(quantity):
            quantities.append(quantity)
    return quantities


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
    words = say.column(name)
    if words.startswith(("min ", "max ", "peak ")):
        extreme = "least" if words.startswith("min ") else "largest"
        return f"{extreme} {words.partition(' ')[2]}"
    return f"least {words}" if better_of(name) > 0 else f"largest {words}"


def _both(name: str, cubes: Sequence[Cube], pairs: Sequence[TablePair | None]) -> list[ColumnArray]:
    """Return a column of every run, on the designs that it shares with the first.

    The first run has those that it shares with the second.
    """
    columns: list[ColumnArray] = []
    for place, cube in enumerate(cubes):
        pair = pairs[max(place - 1, 0)]
        has_column = name in cube.columns
        if not has_column:
            columns.append(np.array([np.nan]))
        elif pair is None:
            rows = np.arange(cube.table.rows if cube.table else 0)
            columns.append(cube.gather(rows, [name])[name])
        else:
            owner, axes = (pair.here, pair.at_here) if place else (pair.there, pair.at_there)
            order = [axis.column for axis in pair.axes]
            columns.append(owner.gather(owner.rows(order, axes), [name])[name].ravel())
    return columns


def _worst(name: str, values: ColumnArray) -> float | None:
    """Return the worst value of a column; None if no design has one."""
    numbers = np.asarray(values, dtype=np.float64)
    if name.startswith("peak_"):
        numbers = np.abs(numbers)
    known = numbers[~np.isnan(numbers)]
    if not known.size:
        return None
    worst = known.min() if better_of(name) > 0 else known.max()
    return finite_or_none(float(worst))


def _judge(name: str, before: float | None, now: float | None) -> Judgement | None:
    """Judge the worst value of a column beside that of the first run."""
    if before is None or now is None:
        return None
    return judge(better_of(name), before, now)


def _feasible(cubes: Sequence[Cube], pairs: Sequence[TablePair | None]) -> QuantityRecord:
    """Return the share of designs that are feasible."""
    shares = [float(np.mean(values)) for values in _both("feasible", cubes, pairs)]
    return {
        "name": "feasible",
        "label": "feasible designs",
        "unit": "1",
        "values": [*shares],
        "spans": [None] * len(shares),
        "verdicts": [None, *(judge(1, shares[0], share) for share in shares[1:])],
        "intervals": [None] * len(shares),
    }


# --- Design by design -----------------------------------------------------------------------------


def _beside(pair: TablePair | None) -> BesideFirst:
    """Return which designs are gained and lost, how margins moved, and which limits are broken."""
    if pair is None:
        return {
            "gained": None,
            "lost": None,
            "why_gained": [],
            "why_lost": [],
            "paired": False,
            "margins": None,
            "broken": [],
        }
    flips = pair.flips()
    designs = int(np.prod(pair.shape))
    moves: list[MoveRecord] = []
    for is_gained in (True, False):
        found = [flip["where"] for flip in flips if flip["now"] is is_gained]
        moves.append(
            {
                "kind": "designs",
                "count": len(found),
                "of": designs,
                "share": len(found) / designs,
                "names": [place_text(where, pair.here) for where in found[:_MOST_NAMES]],
                "named": len(found),
                "named_kind": "designs",
                "named_of": designs,
            }
        )
    return {
        "gained": moves[0],
        "lost": moves[1],
        "why_gained": [],
        "why_lost": [],
        "paired": False,
        "margins": _margins(pair),
        "broken": _broken(pair),
    }


def _margins(pair: TablePair) -> MarginRecord:
    """Return how the margins of the designs in both runs moved."""
    now, before = pair.both("margin")
    moved = np.asarray(now - before, dtype=np.float64)
    known = np.isfinite(moved)
    scale = max(_largest(now), _largest(before))
    moved = np.where(known, moved, 0.0)
    least = _ROUNDING * scale
    largest = int(np.argmax(moved))
    smallest = int(np.argmin(moved))
    has_rise = bool(moved[largest] > least)
    has_fall = bool(moved[smallest] < -least)
    return {
        "designs": int(known.sum()),
        "rose": int((moved > least).sum()),
        "fell": int((moved < -least).sum()),
        "median": float(np.median(moved[known])) if known.any() else None,
        "largest_rise": float(moved[largest]) if has_rise else None,
        "rise_at": place_text(pair.where(largest), pair.here) if has_rise else "",
        "largest_fall": float(moved[smallest]) if has_fall else None,
        "fall_at": place_text(pair.where(smallest), pair.here) if has_fall else "",
    }


def _largest(values: Array) -> float:
    """Return the largest magnitude; 0 if nothing is finite."""
    return float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0))


def _broken(pair: TablePair) -> list[BrokenRecord]:
    """List the limits that designs in both runs break, those newly broken first."""
    now, before = pair.breaking()
    records: list[BrokenRecord] = []
    limits = {**pair.there.limits, **pair.here.limits}
    for limit in dict.fromkeys((*now, *before)):
        newly = sorted(now[limit] - before[limit])
        records.append(
            {
                "limit": limit,
                "label": _limit_label(limit, limits),
                "before": len(before[limit]),
                "now": len(now[limit]),
                "newly": len(newly),
                "no_longer": len(before[limit] - now[limit]),
                "first": [place_text(pair.where(row), pair.here) for row in newly[:_MOST_NAMES]],
            }
        )
    return sorted(records, key=lambda record: -record["newly"])


def _limit_label(limit: str, limits: Mapping[str, float | None]) -> str:
    """Say what happens if a limit is broken."""
    if limit in _LIMIT_WORDS:
        return _LIMIT_WORDS[limit]
    return say.limit_words(limit, limits).broken
