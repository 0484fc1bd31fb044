"""Is every design of a run within its limits: which is not, by how much, and in which state."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from heapq import heappush, heappushpop
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.compute as pc

from tendon_cli.checks.compare import compare
from tendon_cli.checks.shared import WORST, Checked, designs_in
from tendon_cli.checks.text import NO_EQUILIBRIUM, SLACK, finite, verdict_text
from tendon_cli.cube.cube import cube_of
from tendon_cli.engine.plan import Plan
from tendon_cli.engine.results import AnyResult, folder_of, verified_record
from tendon_cli.model.actuator import State
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMITS
from tendon_cli.model.response import SLACK_TOLERANCE
from tendon_cli.space.axis import SIDES
from tendon_cli.studies.load import recorded_study
from tendon_cli.studies.study import Study
from tendon_cli.tables.read import TableFiles, as_numpy

Breach = dict[str, Any]
"""A limit that a design breaks, as in the record."""
TOLERANCE = 1e-9
"""The share of a column's scale by which numbers may differ."""


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
    table = designs_in(folder, record)
    result = _check_designs(table, recorded_study(table.facts["study"]), worst)
    return Checked(result["holds"], verdict_text(result, cube_of(table), record["name"]), finite(result))


def _answer(record: dict[str, Any]) -> Checked:
    choices, feasible = record["choices"], record["feasible"]
    lines = [f"{record['name']}: {feasible:,} of {choices:,} choices have a window of pretension"]
    lines += [f"  {' against '.join(each['limits'])}" for each in record["conflicts"] if not feasible]
    kept = {"choices": choices, "feasible": feasible, "conflicts": record["conflicts"], "holds": feasible > 0}
    return Checked(feasible > 0, "\n".join(lines), kept)


def _check_designs(table: TableFiles, study: Study, worst: int) -> dict[str, Any]:
    """Check all rows of a table of designs, part by part; of the breaches the `worst` are listed with their states."""
    limits, plan = dict(study.limits.items()), Plan(study)
    names = ["design", "feasible", "taut", "margin", "required_pretension"]
    names += [name for limit in limits for name in _columns_of(limit)]
    heap, order = list[tuple[float, int, int, Breach]](), itertools.count()
    broken: dict[str, int] = {}
    designs = feasible = 0
    for _, part in table.parts([name for name in dict.fromkeys(names) if name in table.schema.names]):
        failing = part.filter(pc.invert(part.column("feasible")))
        designs += part.num_rows
        feasible += part.num_rows - failing.num_rows
        for breach in _breaches(failing, limits):
            broken[breach["limit"]] = broken.get(breach["limit"], 0) + 1
            entry = (breach["excess"], -breach["design"], next(order), breach)
            if len(heap) < worst:
                heappush(heap, entry)
            elif worst:
                heappushpop(heap, entry)
    worst_first = [breach for *_, breach in sorted(heap, key=lambda each: each[:2], reverse=True)]
    return {
        "designs": designs,
        "feasible": feasible,
        "breaches": [_with_state(breach, plan) for breach in worst_first],
        "broken": dict(sorted(broken.items(), key=lambda each: -each[1])),
        "holds": feasible == designs,
    }


def _breach(design: int, limit: str, value: float | None, bound: float | None, excess: float) -> Breach:
    """A limit that a design breaks, in SI; of slack its margin of pretension."""
    state = {"direction": None, "elbow_angle": None}
    return {"design": design, "limit": limit, "value": value, "bound": bound, "excess": excess, **state}


def _columns_of(limit: str) -> list[str]:
    """The column that a limit bounds, and those of the sides if they differ in it."""
    column = LIMITS[limit].column
    return [column, *(f"{column}_{side}" for side in SIDES)]


def _breaches(table: pa.Table, limits: Mapping[str, float]) -> Iterator[Breach]:
    """Every limit that each of some designs breaks."""
    if not table.num_rows:
        return
    columns = {name: as_numpy(table.column(name)) for name in table.schema.names}
    numbers = columns["design"]
    nowhere = np.isnan(columns["required_pretension"])
    for row in np.flatnonzero(nowhere):
        yield _breach(int(numbers[row]), NO_EQUILIBRIUM, None, None, float("inf"))
    for row in np.flatnonzero(~nowhere & ~columns["taut"].astype(bool)):
        margin, needed = float(columns["margin"][row]), float(columns["required_pretension"][row])
        yield _breach(int(numbers[row]), SLACK, margin, 0.0, -margin / max(needed, 1e-300))
    for limit, bound in limits.items():
        for name in _columns_of(limit):
            if name in columns:
                yield from _beyond(numbers, limit, bound, columns[name])


def _beyond(numbers: npt.NDArray[Any], limit: str, bound: float, values: npt.NDArray[np.float64]) -> Iterator[Breach]:
    short = LIMITS[limit].beyond(values, bound)
    scale = abs(bound) or 1.0
    for row in np.flatnonzero(short > SLACK_TOLERANCE * scale):
        yield _breach(int(numbers[row]), limit, float(values[row]), bound, float(short[row] / scale))


def _with_state(breach: Breach, plan: Plan) -> Breach:
    """With direction and elbow angle (rad) of the state that breaks it worst, unless no single state does."""
    limit, speed = LIMITS.get(breach["limit"]), plan.study.motion.speed
    if limit is not None and limit.forms is None:
        return breach
    worst = -np.inf
    for block in plan.blocks(range(breach["design"], breach["design"] + 1)):
        directions, angles = plan.directions[block.directions], plan.elbow_angles[block.angles]
        state = State.of(plan.inputs(block))
        if limit is not None:
            badness: Array = limit.beyond(limit.value(state, np.nan if speed is None else speed.single), 0.0)
        elif breach["limit"] == SLACK:
            badness = state.inputs.response.required
        else:
            badness = np.where(np.isnan(state.elbow_torque), 1.0, 0.0)
        values = np.broadcast_to(badness, block.shape).reshape(len(directions), -1)
        if np.isnan(values).all() or np.nanmax(values) <= worst:
            continue
        worst = float(np.nanmax(values))
        direction, angle = np.unravel_index(int(np.nanargmax(values)), values.shape)
        flexion = np.broadcast_to(plan.motion(block)[1], values.shape)[direction, angle]
        breach |= {"direction": "flexion" if flexion else "extension", "elbow_angle": float(angles[angle])}
    return breach
