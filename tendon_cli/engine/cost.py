"""What a sweep would cost, before it is run: rows exactly, bytes and time from designs computed in memory."""

from __future__ import annotations

import io
import time
from dataclasses import asdict, dataclass
from typing import Any

from tendon_cli.engine.plan import STATES_PER_PART, Plan
from tendon_cli.engine.sweep import Sweep
from tendon_cli.studies.study import keys
from tendon_cli.tables.schema import ROW_GROUP
from tendon_cli.tables.write import RowGroups
from tendon_cli.units import factor_of

# Measured on 64-bit Linux: the interpreter with its libraries, the arrays of one block, and the results of a design.
_BYTES_AT_REST = 110_000_000
_ARRAYS_PER_BLOCK = 35
_RESULTS = 16
_SAMPLES = 8
_MOST_STATES = 2**26
_SECONDS_TO_START = 0.3
_SECONDS_FOR_FIGURES = 1.5


@dataclass(frozen=True)
class AxisLine:
    """An axis as people read it."""

    key: str
    count: int
    first: str
    last: str


@dataclass(frozen=True)
class Estimate:
    """The size and cost of a sweep."""

    axes: tuple[AxisLine, ...]
    designs: int
    states: int
    rows: dict[str, int]
    kept: tuple[str, ...] | None
    """Results of the states that the study keeps; None for all."""
    bytes: int
    seconds: float
    """Of all, figures included."""
    figure_seconds: float
    peak_memory: int
    parts: int

    def record(self) -> dict[str, Any]:
        """The estimate for a program."""
        rounded = {
            "seconds": round(self.seconds, 2),
            "figure_seconds": round(self.figure_seconds, 2),
        }
        return asdict(self) | rounded


class _Nowhere(io.RawIOBase):
    """A file that forgets what is written to it."""

    def write(self, data: Any) -> int:
        return len(data)

    def seek(self, offset: int, _whence: int = 0) -> int:
        return offset


def estimate(plan: Plan, jobs: int, *, figures: bool) -> Estimate:
    """Compute as many designs as a part has, from all over the product, in memory, and scale; nothing is written."""
    task, samples = Sweep(plan), _samples(plan)
    count = sum(len(sample) for sample in samples)
    rows = {table: plan.rows(table, range(count)) for table in task.tables}
    tables = {
        table: RowGroups(_Nowhere(), task.layout(table, 0, rows[table])) for table in task.tables
    }
    _ = task.folds.known_windows  # worked out once, which the sample is not to be charged with
    started = time.perf_counter()
    for sample in samples:
        task.fill_designs(tables, sample)
    size = sum(table.close().size for table in tables.values())
    seconds = time.perf_counter() - started
    share = plan.designs / count
    workers = min(jobs, plan.parts)
    drawing = _SECONDS_FOR_FIGURES if figures else 0.0
    return Estimate(
        axes=_axis_lines(plan),
        designs=plan.designs,
        states=plan.states,
        rows={table: plan.states if table == "states" else plan.designs for table in tables},
        kept=plan.study.output.states,
        bytes=round(size * share),
        seconds=_SECONDS_TO_START + seconds * share / workers + drawing,
        figure_seconds=drawing,
        peak_memory=_BYTES_AT_REST + workers * _bytes_per_worker(task),
        parts=plan.parts,
    )


def _samples(plan: Plan) -> list[range]:
    """What is computed to know the rest: runs of designs spread evenly over the product, for the size of their rows.

    Without rows of states a stretch of a part in the middle, for designs side by side have much in common.
    """
    if "states" not in plan.study.output.tables:
        part = plan.part(plan.parts // 2)
        return [part[: max(1, _MOST_STATES // plan.states_per_design)]]
    most = min(plan.designs, plan.part_designs, max(1, STATES_PER_PART // plan.states_per_design))
    runs = 1 if most == plan.designs else min(_SAMPLES, most)
    lengths = [most * (index + 1) // runs - most * index // runs for index in range(runs)]
    starts = [
        (plan.designs - length) * index // max(1, runs - 1) for index, length in enumerate(lengths)
    ]
    return [range(start, start + length) for start, length in zip(starts, lengths, strict=True)]


def _axis_lines(plan: Plan) -> tuple[AxisLine, ...]:
    """Every axis of a study with its first and last value in the units people read."""
    ends: dict[str, Any] = {axis.key: axis.names or axis.values for axis in plan.axes}
    if plan.study.trajectory is not None:
        ends |= {"motion.trajectory": plan.study.trajectory.time}
    else:
        ends |= {"motion.direction": plan.directions, "motion.elbow_angle": plan.elbow_angles}
    return tuple(
        AxisLine(key, len(v), _shown(key, v[0]), _shown(key, v[-1])) for key, v in ends.items()
    )


def _shown(key: str, value: Any) -> str:
    """A value in SI in the unit that people read it in, or a name."""
    if isinstance(value, str):
        return value
    unit = keys()[key].number.quantity.shown_in if key in keys() else "s"
    return f"{value / factor_of(unit):.6g}{'' if unit == '1' else f' {unit}'}"


def _bytes_per_worker(task: Sweep) -> int:
    """Row groups while they are filled and encoded, the arrays of a block, and what a part's designs come to."""
    plan, part = task.plan, task.plan.part(0)
    row_groups = sum(
        2 * 8 * len(task.columns(table)) * min(ROW_GROUP, task.rows(table, 0))
        for table in task.tables
    )
    block = 8 * _ARRAYS_PER_BLOCK * min(plan.block_states, plan.rows("states", part))
    return row_groups + block + 8 * _RESULTS * len(part)
