"""Is every design of a run within its limits: which is not, by how much, and in which state."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from heapq import heappush, heappushpop
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.compute as pc

from tendon_cli.cube.columns import as_numpy
from tendon_cli.engine.plan import Plan
from tendon_cli.model.actuator import State
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMITS
from tendon_cli.model.response import SLACK_TOLERANCE
from tendon_cli.space.axis import SIDES
from tendon_cli.studies.study import Study
from tendon_cli.tables.read import TableFiles

NO_EQUILIBRIUM, SLACK = "no equilibrium", "slack"


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
    """Check all rows of a table of designs, part by part; of the breaches the `worst` are listed with their states."""
    limits = dict(study.limits.items())
    names = ["design", "feasible", "taut", "margin", "required_pretension"]
    names += [name for limit in limits for name in _columns_of(limit) if name not in names]
    heap: list[tuple[float, int, Breach]] = []
    broken: dict[str, int] = {}
    designs = feasible = 0
    for _, part in table.parts([name for name in names if name in table.schema.names]):
        designs += part.num_rows
        failing = part.filter(pc.invert(part.column("feasible")))
        feasible += part.num_rows - failing.num_rows
        for breach in _breaches(failing, limits):
            broken[breach.limit] = broken.get(breach.limit, 0) + 1
            entry = (breach.excess, -breach.design, breach)
            if len(heap) < worst:
                heappush(heap, entry)
            elif worst:
                heappushpop(heap, entry)
    plan = Plan(study)
    worst_first = [breach for *_, breach in sorted(heap, key=lambda each: each[:2], reverse=True)]
    return LimitCheck(
        designs,
        feasible,
        tuple(_with_state(breach, plan) for breach in worst_first),
        dict(sorted(broken.items(), key=lambda each: -each[1])),
    )


def _with_state(breach: Breach, plan: Plan) -> Breach:
    state = _worst_state(breach.limit, breach.design, plan)
    return breach if state is None else replace(breach, direction=state[0], elbow_angle=state[1])


def column_of(limit: str) -> str:
    """The column that a limit bounds."""
    return LIMITS[limit].column


def _columns_of(limit: str) -> list[str]:
    """That column, and those of the sides if they differ in it."""
    return [column_of(limit), *(f"{column_of(limit)}_{side}" for side in SIDES)]


def _breaches(table: pa.Table, limits: Mapping[str, float]) -> Iterator[Breach]:
    """Every limit that each of some designs breaks."""
    if not table.num_rows:
        return
    columns = {name: as_numpy(table.column(name)) for name in table.schema.names}
    numbers = columns["design"]
    nowhere = np.isnan(columns["required_pretension"])
    for row in np.flatnonzero(nowhere):
        yield Breach(int(numbers[row]), NO_EQUILIBRIUM, None, None, float("inf"))
    for row in np.flatnonzero(~nowhere & ~columns["taut"].astype(bool)):
        margin, needed = float(columns["margin"][row]), float(columns["required_pretension"][row])
        yield Breach(int(numbers[row]), SLACK, margin, 0.0, -margin / max(needed, 1e-300))
    for limit, bound in limits.items():
        for name in _columns_of(limit):
            if name in columns:
                yield from _beyond(numbers, limit, bound, columns[name])


def _beyond(numbers: npt.NDArray[Any], limit: str, bound: float, values: npt.NDArray[np.float64]) -> Iterator[Breach]:
    short = LIMITS[limit].beyond(values, bound)
    scale = abs(bound) or 1.0
    for row in np.flatnonzero(short > SLACK_TOLERANCE * scale):
        yield Breach(int(numbers[row]), limit, float(values[row]), bound, float(short[row] / scale))


_OF_STATES: dict[str, Callable[[State], Array]] = {
    NO_EQUILIBRIUM: lambda state: np.where(np.isnan(state.elbow_torque), 1.0, 0.0),
    SLACK: lambda state: state.situation.response.required,
}
"""What is largest in the worst state of what is no key of [limits]."""


def _worst_state(limit: str, design: int, plan: Plan) -> tuple[str, float] | None:
    """Direction and elbow angle (rad) of the state that breaks a limit worst; None where no single state does."""
    if limit not in _OF_STATES and LIMITS[limit].forms is None:
        return None
    worst, place, speed = -np.inf, None, plan.study.motion.speed
    for block in plan.blocks(range(design, design + 1)):
        directions, angles = plan.directions[block.directions], plan.elbow_angles[block.angles]
        state = State.of(plan.situation(block))
        badness = (
            _OF_STATES[limit](state)
            if limit in _OF_STATES
            else LIMITS[limit].beyond(LIMITS[limit].value(state, np.nan if speed is None else speed.single), 0.0)
        )
        values = np.broadcast_to(badness, block.shape).reshape(len(directions), -1)
        if np.isnan(values).all() or np.nanmax(values) <= worst:
            continue
        worst = float(np.nanmax(values))
        direction, angle = np.unravel_index(int(np.nanargmax(values)), values.shape)
        place = directions[direction], float(angles[angle])
    return place
