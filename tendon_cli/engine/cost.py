"""The cost of a sweep before it is run: exact rows, and bytes and time from a sample of designs."""

from __future__ import annotations

import io
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tendon_cli import say
from tendon_cli.engine.folder import free_bytes
from tendon_cli.engine.plan import STATES_PER_PART, Plan
from tendon_cli.engine.sweep import Sweep
from tendon_cli.engine.threads import available_cores
from tendon_cli.studies.axis_words import name_words
from tendon_cli.studies.space.axis import Axis
from tendon_cli.studies.study import Study, keys
from tendon_cli.tables.schema import ROW_GROUP
from tendon_cli.tables.write import RowGroups
from tendon_cli.units import factor_of

# Measured on 64-bit Linux.
_BYTES_AT_REST = 110_000_000
"""Memory of the interpreter with its libraries, bytes."""
_ARRAYS_PER_BLOCK = 35
"""Arrays with a number for each state of a block, as many as are in memory at once."""
_RESULTS = 16
"""Numbers that are kept for each design of a part."""
_SECONDS_TO_START = 0.3
_SECONDS_FOR_FIGURES = 1.5

_SAMPLES = 8
"""Ranges of designs in a sample, if the study has a table of states."""
_MOST_STATES = 2**26
"""Most states in a sample, if it has none."""


@dataclass(frozen=True)
class AxisLine:
    """An axis in the units that people read: its key, number of values, first and last value."""

    key: str
    count: int
    first: str
    last: str


@dataclass(frozen=True)
class Estimate:
    """Size and cost of a sweep."""

    axes: tuple[AxisLine, ...]
    designs: int
    states: int
    rows: dict[str, int]
    """Rows of each table."""
    kept: tuple[str, ...] | None
    """Results of the states that the study keeps; None for all."""
    bytes: int
    """Size of the tables on the disk."""
    seconds: float
    """Time for all, figures included, s."""
    figure_seconds: float
    """Time for the figures, s."""
    peak_memory: int
    """Largest memory in use, bytes."""
    parts: int

    def record(self) -> dict[str, Any]:
        """Return the estimate as a dictionary for JSON, its times rounded."""
        rounded = {
            "seconds": round(self.seconds, 2),
            "figure_seconds": round(self.figure_seconds, 2),
        }
        return asdict(self) | rounded

    def text(self, name: str, free: int) -> str:
        """Return the page of --dry-run.

        Args:
            name: Name of the study.
            free: Space that the disk has free, bytes.
        """
        width = max(len(axis.key) for axis in self.axes)
        lines = [f"{name}: --dry-run writes nothing", "  axes, slowest first"]
        for axis in self.axes:
            span = axis.first if axis.count == 1 else f"{axis.first} to {axis.last}"
            lines.append(f"    {axis.key:<{width}}  {axis.count:>8,}  {span}")
        lines.append(f"  designs      {self.designs:,}")
        lines.append(f"  states       {self.states:,}")
        lines += [f"  rows         {rows:,} in {table}" for table, rows in self.rows.items()]
        if self.kept:
            lines.append(f"  kept         {', '.join(self.kept)} of the states' results")
        size = f"{say.byte_size(self.bytes)} in {say.counted(self.parts, 'part')}"
        lines.append(f"  disk         {size}, {say.byte_size(free)} free")
        drawing = ""
        if self.figure_seconds:
            drawing = f", {say.duration(self.figure_seconds)} of it for figures"
        lines.append(f"  time         about {say.duration(self.seconds)}{drawing}")
        lines.append(f"  peak memory  about {say.byte_size(self.peak_memory)}")
        return "\n".join(lines)


class _Nowhere(io.RawIOBase):
    """A file that forgets what is written to it."""

    def write(self, data: Any) -> int:
        return len(data)

    def seek(self, offset: int, _whence: int = 0) -> int:
        return offset


def estimate(plan: Plan, jobs: int, *, figures: bool) -> Estimate:
    """Estimate the cost of a sweep from about as many designs as a part has; nothing is written.

    The designs come from all over the product, are computed in memory, and are scaled to the whole.

    Args:
        plan: The plan of the sweep.
        jobs: Parts made at once.
        figures: True if figures are drawn.
    """
    task = Sweep(plan)
    samples = _samples(plan)
    count = sum(len(sample) for sample in samples)
    tables = {}
    for table in task.tables:
        rows = plan.rows(table, range(count))
        tables[table] = RowGroups(_Nowhere(), task.layout(table, 0, rows))
    _ = task.folds.known_windows  # worked out once, so it is no part of the sample's time
    started = time.perf_counter()
    for sample in samples:
        task.fill_designs(tables, sample)
    size = sum(table.close().size for table in tables.values())
    seconds = time.perf_counter() - started
    scale = plan.designs / count
    workers = min(jobs, plan.parts)
    drawing = _SECONDS_FOR_FIGURES if figures else 0.0
    return Estimate(
        axes=_axis_lines(plan),
        designs=plan.designs,
        states=plan.states,
        rows={table: plan.states if table == "states" else plan.designs for table in tables},
        kept=plan.study.output.states,
        bytes=round(size * scale),
        seconds=_SECONDS_TO_START + seconds * scale / workers + drawing,
        figure_seconds=drawing,
        peak_memory=_BYTES_AT_REST + workers * _bytes_per_worker(task),
        parts=plan.parts,
    )


def size_of_sweep(
    study: Study, folder: Path, jobs: int | None, figures: bool
) -> tuple[dict[str, Any], str]:
    """Return the size and cost of a sweep for --dry-run, as a record and as text."""
    cost = estimate(Sweep.of(study).plan, jobs or available_cores(), figures=figures)
    free = free_bytes(folder)
    record = {"name": study.name, **cost.record(), "free_bytes": free}
    return record, cost.text(study.name, free)


def _samples(plan: Plan) -> list[range]:
    """Return ranges of designs that are spread evenly over the product.

    So their rows are on average as large as all rows. If the study has no table of states, return
    one range of the middle part instead: designs side by side share much of their computation.
    """
    if "states" not in plan.study.output.tables:
        part = plan.part(plan.parts // 2)
        return [part[: max(1, _MOST_STATES // plan.states_per_design)]]
    most = min(plan.designs, plan.part_designs, max(1, STATES_PER_PART // plan.states_per_design))
    count = 1 if most == plan.designs else min(_SAMPLES, most)
    samples = []
    for index in range(count):
        length = most * (index + 1) // count - most * index // count
        start = (plan.designs - length) * index // max(1, count - 1)
        samples.append(range(start, start + length))
    return samples


def _axis_lines(plan: Plan) -> tuple[AxisLine, ...]:
    """Return every axis of a study with its first and last value in the units people read."""
    values: dict[str, Any] = {axis.key: _ends_of(axis) for axis in plan.axes}
    lengths = {axis.key: len(axis) for axis in plan.axes}
    if plan.study.trajectory is not None:
        values["motion.trajectory"] = plan.study.trajectory.time
    else:
        values["motion.direction"] = plan.directions
        values["motion.elbow_angle"] = plan.elbow_angles
    return tuple(
        AxisLine(key, lengths.get(key, len(along)), _shown(key, along[0]), _shown(key, along[-1]))
        for key, along in values.items()
    )


def _ends_of(axis: Axis) -> tuple[Any, Any]:
    """Return the first and the last value of an axis, or what their names say."""
    if axis.names:
        return name_words(axis, axis.names[0]), name_words(axis, axis.names[-1])
    return axis.values[0], axis.values[-1]


def _shown(key: str, value: Any) -> str:
    """Return a value in SI in the unit that people read it in; a name as it is."""
    if isinstance(value, str):
        return value
    unit = keys()[key].quantity.shown_in if key in keys() else "s"
    suffix = "" if unit == "1" else f" {unit}"
    return f"{value / factor_of(unit):.6g}{suffix}"


def _bytes_per_worker(task: Sweep) -> int:
    """Return the memory of one worker, bytes.

    It holds row groups while they are filled and encoded, the arrays of a block, and the results of
    a part's designs.
    """
    plan = task.plan
    part = plan.part(0)
    row_groups = sum(
        2 * 8 * len(task.columns(table)) * min(ROW_GROUP, task.rows(table, 0))
        for table in task.tables
    )
    block = 8 * _ARRAYS_PER_BLOCK * min(plan.block_states, plan.rows("states", part))
    return row_groups + block + 8 * _RESULTS * len(part)
