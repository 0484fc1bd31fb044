"""Is every design of a run within its limits: which is not, by how much, and in which state."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from heapq import heappush, heappushpop
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.compute as pc

from tendon_cli.check.states import worst_state
from tendon_cli.model.response import SLACK_TOLERANCE
from tendon_cli.study.study import Study
from tendon_cli.sweep.plan import Plan
from tendon_cli.tables.read import TableFiles

NO_EQUILIBRIUM, SLACK = "no equilibrium", "slack"
_NOT_A_COLUMN = {"max_pretension": "pretension"}


@dataclass(frozen=True)
class Breach:
    """A limit that a design breaks."""

    design: int
    limit: str
    """A key of [limits], "slack" or "no equilibrium"."""
    value: float | None
    """What the design comes to, in SI; for slack its margin of pretension."""
    bound: float | None
    excess: float
    """By how much it is broken, as a share of the bound; in SI where that is 0; infinite without equilibrium."""
    direction: str | None = None
    elbow_angle: float | None = None
    """The state that breaks it worst, rad; none for a limit that no single state breaks."""


@dataclass(frozen=True)
class LimitCheck:
    """What came of a check."""

    designs: int
    feasible: int
    breaches: tuple[Breach, ...]
    """The worst, the worst first."""
    broken: dict[str, int]
    """How many designs break each limit."""

    @property
    def holds(self) -> bool:
        """Whether every design is within every limit."""
        return self.feasible == self.designs


def check_designs(table: TableFiles, study: Study, worst: int) -> LimitCheck:
    """Check all rows of a table of designs, part by part; of the breaches the `worst` are told with their states."""
    limits = dict(study.limits.items())
    names = ["design", "feasible", "taut", "margin", "required_pretension"]
    names += [name for name in (column_of(limit) for limit in limits) if name not in names]
    found: list[tuple[float, int, Breach]] = []
    broken: dict[str, int] = {}
    designs = feasible = 0
    for _, part in table.parts([name for name in names if name in table.schema.names]):
        designs += part.num_rows
        failing = part.filter(pc.invert(part.column("feasible")))
        feasible += part.num_rows - failing.num_rows
        for breach in _breaches(failing, limits):
            broken[breach.limit] = broken.get(breach.limit, 0) + 1
            entry = (breach.excess, -breach.design, breach)
            if len(found) < worst:
                heappush(found, entry)
            elif worst:
                heappushpop(found, entry)
    plan = Plan(study)
    worst_first = [breach for *_, breach in sorted(found, key=lambda each: each[:2], reverse=True)]
    return LimitCheck(
        designs,
        feasible,
        tuple(_with_state(breach, plan) for breach in worst_first),
        dict(sorted(broken.items(), key=lambda each: -each[1])),
    )


def _with_state(breach: Breach, plan: Plan) -> Breach:
    state = worst_state(breach.limit, breach.design, plan)
    return breach if state is None else replace(breach, direction=state[0], elbow_angle=state[1])


def column_of(limit: str) -> str:
    """The column that a limit bounds."""
    return _NOT_A_COLUMN.get(limit, limit)


def _breaches(table: pa.Table, limits: Mapping[str, float]) -> Iterator[Breach]:
    """Every limit that each of some designs breaks."""
    if not table.num_rows:
        return
    columns = {name: table.column(name).to_numpy(zero_copy_only=False) for name in table.schema.names}
    numbers = columns["design"]
    nowhere = np.isnan(columns["required_pretension"].astype(float))
    for row in np.flatnonzero(nowhere):
        yield Breach(int(numbers[row]), NO_EQUILIBRIUM, None, None, float("inf"))
    for row in np.flatnonzero(~nowhere & ~columns["taut"].astype(bool)):
        margin, needed = float(columns["margin"][row]), float(columns["required_pretension"][row])
        yield Breach(int(numbers[row]), SLACK, margin, 0.0, -margin / max(needed, 1e-300))
    for limit, bound in limits.items():
        values = columns.get(column_of(limit))
        if values is not None:
            yield from _beyond(numbers, limit, bound, values.astype(float))


def _beyond(numbers: npt.NDArray[Any], limit: str, bound: float, values: npt.NDArray[np.float64]) -> Iterator[Breach]:
    sign = 1.0 if limit.startswith("min_") else -1.0
    magnitudes = np.abs(values) if limit.startswith("peak_") else values
    short = sign * (bound - magnitudes)
    scale = abs(bound) or 1.0
    for row in np.flatnonzero(short > SLACK_TOLERANCE * scale):
        yield Breach(int(numbers[row]), limit, float(values[row]), bound, float(short[row] / scale))
