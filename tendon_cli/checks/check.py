"""Check that every design of a run is within its limits.

The result lists the designs that are not, by how much, and in which state.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from tendon_cli.checks.breaches import Breach, breaches_in, columns_that_judge
from tendon_cli.checks.check_since import TOLERANCE, check_since
from tendon_cli.checks.check_text import (
    NEGATIVE,
    NO_EQUILIBRIUM,
    SLACK,
    WORST,
    CheckResult,
    finite,
    verdict_text,
)
from tendon_cli.cube.cube import Cube, cube_of
from tendon_cli.engine.plan import Plan
from tendon_cli.engine.results import AnyResult, Run, folder_of, open_result
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMITS
from tendon_cli.model.motor import motor_rates
from tendon_cli.model.trajectory import Trajectory
from tendon_cli.registry import load
from tendon_cli.tables.schema import as_numpy


def check(
    run: AnyResult,
    baseline: AnyResult | None = None,
    *,
    tolerance: float = TOLERANCE,
    apart: Sequence[str] = (),
    worst: int = WORST,
) -> CheckResult:
    """Check that every design of a run is within its limits, or find what changed since a baseline.

    An answer holds if the choice that it names first keeps the limits for as many as its study asks
    for. Every file is verified first.

    Args:
        run: A run or an answer, or its folder.
        baseline: Another one of the same kind, or its folder; the limits are then not checked.
        tolerance: Share of a column's scale by which numbers may differ; for an answer of the
            larger of two numbers.
        apart: Keys in which the studies may differ.
        worst: Number of breaches that are listed, or of designs whose feasibility changed.

    Returns:
        The result, with `holds`, `text` and `record`.

    Raises:
        InputError: if something is damaged or is no run.
        UsageError: if the run has no designs.

    >>> import tendon_cli as tendon
    >>> study = {"limits": {"max_tension": "150 N"}}
    >>> tendon.sweep(study, "results/mine").designs.max_tension.round().item()
    151.0
    >>> tendon.check("results/mine").holds
    False
    """
    result = open_result(folder_of(run))
    if baseline is not None:
        return check_since(open_result(folder_of(baseline)), result, tolerance, apart, worst)
    if not result.kind.check:
        text = f"{result.record['name']}: every file is as it was written"
        record = {"holds": True}
        return CheckResult(
            text=text, record=record, verdict="files as they were written", holds=True
        )
    checked: CheckResult = load(result.kind.check)(result, worst)
    return checked


def check_run(run: Run, worst: int) -> CheckResult:
    """Check that every design of a run is within its limits. List the `worst` of the breaches."""
    cube = cube_of(run.kept("designs"), run.study)
    result = _check_designs(cube, worst)
    text = verdict_text(result, cube, run.record["name"])
    verdict = "within limits" if result["holds"] else NEGATIVE
    return CheckResult(result["holds"], text, finite(result), verdict)


def _check_designs(cube: Cube, worst: int) -> dict[str, Any]:
    """Check all rows of a table of designs, part by part.

    The `worst` of the breaches are listed with their states.
    """
    table: Any = cube.table
    wanted = ["design", *columns_that_judge(cube)]
    names = [name for name in wanted if name in table.schema.names]
    breaches: list[Breach] = []
    broken: Counter[str] = Counter()
    designs = 0
    feasible = 0
    for _, part in table.parts(names):
        columns = {name: as_numpy(part[name]) for name in part.column_names}
        bounds = {limit: cube.bound(limit, columns) for limit in cube.limits}
        breaches_here = list(breaches_in(columns, bounds))
        designs += part.num_rows
        feasible += int(columns["feasible"].sum())
        # A design that breaks a limit on both sides counts once.
        broken_here = [(breach["limit"], breach["design"]) for breach in breaches_here]
        broken.update(limit for limit, _ in dict.fromkeys(broken_here))
        breaches += breaches_here
        breaches.sort(key=lambda breach: (-breach["excess"], breach["design"]))
        breaches = breaches[:worst]
    plan = Plan(cube.study)
    return {
        "designs": designs,
        "feasible": feasible,
        "breaches": [_with_state(breach, plan) for breach in breaches],
        "broken": dict(broken.most_common()),
        "holds": feasible == designs,
    }


def _with_state(breach: Breach, plan: Plan) -> Breach:
    """Add direction and elbow angle (rad) of the state that breaks the limit worst, and return it.

    Nothing is added if the limit is not on states. Along a motion in time the moment is added, too.
    """
    if plan.study.trajectory is not None:
        return _with_moment(breach, plan, plan.study.trajectory)
    limit = LIMITS.get(breach["limit"])
    speed = plan.study.motion.speed
    if limit is not None and limit.forms is None:
        return breach
    worst = -np.inf
    for block in plan.blocks(range(breach["design"], breach["design"] + 1)):
        directions = plan.directions[block.directions]
        angles = plan.elbow_angles[block.angles]
        state = plan.state(block)
        severity: Array
        if limit is not None:
            value = limit.value(state, np.nan if speed is None else speed.single)
            severity = limit.beyond(value, 0.0)
        elif breach["limit"] == SLACK:
            severity = state.response.required
        else:
            severity = np.where(np.isnan(state.elbow_torque), 1.0, 0.0)
        values = np.broadcast_to(severity, block.shape).reshape(len(directions), -1)
        if np.isnan(values).all() or np.nanmax(values) <= worst:
            continue
        worst = float(np.nanmax(values))
        direction, angle = np.unravel_index(int(np.nanargmax(values)), values.shape)
        flexion = np.broadcast_to(plan.motion(block)[1], values.shape)[direction, angle]
        breach["direction"] = "flexion" if flexion else "extension"
        breach["elbow_angle"] = float(angles[angle])
    return breach


def _with_moment(breach: Breach, plan: Plan, trajectory: Trajectory) -> Breach:
    """Add the time (s) of a motion at which a limit is broken worst, and its state; return it."""
    # Only a study of motion pays for its import.
    from tendon_cli.model.motion_window import OF_WHAT_HOLDS

    limit = LIMITS.get(breach["limit"])
    design = range(breach["design"], breach["design"] + 1)
    moving = plan.moving(next(iter(plan.blocks(design))))
    held, turned = moving.counted_states
    severity: Array
    if limit is not None and limit.forms is not None:
        severity = limit.beyond(limit.value(held, np.nan), 0.0)
        if limit.name not in OF_WHAT_HOLDS:
            severity = np.fmax(severity, limit.beyond(limit.value(turned, np.nan), 0.0))
    elif breach["limit"] == "peak_motor_power":
        severity = motor_rates(held).power
    elif breach["limit"] == SLACK:
        severity = np.fmax(held.response.required, turned.response.required)
    elif breach["limit"] == NO_EQUILIBRIUM:
        severity = np.where(np.isnan(held.elbow_torque), 1.0, 0.0)
    else:
        return breach
    times = trajectory.time[trajectory.counted]
    values = np.broadcast_to(np.ravel(severity), times.shape)
    if np.isnan(values).all():
        return breach
    sample = trajectory.counted.start + int(np.nanargmax(values))
    breach["direction"] = "flexion" if trajectory.is_flexing[sample] else "extension"
    breach["elbow_angle"] = float(trajectory.angle[sample])
    breach["time"] = float(trajectory.time[sample])
    return breach
