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
from tendon_cli.cube.cube import cube_in
from tendon_cli.cube.room import designs_at
from tendon_cli.engine.results import AnyResult, Run, folder_of, open_result
from tendon_cli.model.actuator import State
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMITS
from tendon_cli.model.motor import motor_rates
from tendon_cli.studies.study import Study
from tendon_cli.tables.schema import as_numpy
from tendon_cli.verbs.registry import load


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
    """Check that every design of a run is within its limits, part by part of their table.

    The `worst` of the breaches are listed with their states.
    """
    cube = cube_in(run, "designs")
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
    holds = feasible == designs
    result = {
        "designs": designs,
        "feasible": feasible,
        "breaches": [_with_state(breach, cube.study) for breach in breaches],
        "broken": dict(broken.most_common()),
        "holds": holds,
    }
    text = verdict_text(result, cube, run.record["name"])
    return CheckResult(holds, text, finite(result), "within limits" if holds else NEGATIVE)


def _with_state(breach: Breach, study: Study) -> Breach:
    """Add direction, elbow angle (rad) and, along a motion, time (s) of the state that is worst.

    Nothing is added if the limit is not on states.
    """
    name = breach["limit"]
    limit = LIMITS.get(name)
    trajectory = study.trajectory
    has_power = trajectory is not None and name == "peak_motor_power"
    if limit is not None and limit.forms is None and not has_power:
        return breach
    design = designs_at(study, np.array([breach["design"]]))
    if trajectory is None:
        speed = study.motion.speed
        state = State.of(design, study.angles.reshape(1, -1), study.flexion)
        severity = _severity(name, state, np.nan if speed is None else speed.single)
        shape = np.broadcast_shapes(study.flexion.shape, (len(study.angles),))
        values = np.broadcast_to(severity, (1, *shape))[0]  # (directions, angles)
        is_flexing = np.broadcast_to(study.flexion, shape)
        of_states = {"elbow_angle": np.broadcast_to(study.angles, shape)}
    else:
        # Only a study of motion pays for their import.
        from tendon_cli.model.motion_window import OF_WHAT_HOLDS
        from tendon_cli.model.moving import Moving

        held, turned = Moving.of(design, trajectory).counted_states
        severity = motor_rates(held).power if has_power else _severity(name, held, np.nan)
        if not has_power and name not in (*OF_WHAT_HOLDS, NO_EQUILIBRIUM):
            severity = np.fmax(severity, _severity(name, turned, np.nan))
        counted = trajectory.counted
        is_flexing = trajectory.is_flexing[counted]
        values = np.broadcast_to(np.ravel(severity), is_flexing.shape)
        of_states = {"elbow_angle": trajectory.angle[counted], "time": trajectory.time[counted]}
    if not np.isnan(values).all():
        place = np.unravel_index(int(np.nanargmax(values)), values.shape)
        breach |= {name: float(of_state[place]) for name, of_state in of_states.items()}
        breach["direction"] = "flexion" if is_flexing[place] else "extension"
    return breach


def _severity(name: str, state: State, speed: float) -> Array:
    """Return by how much states break a limit; the largest is the worst."""
    limit = LIMITS.get(name)
    if limit is not None:
        return limit.beyond(limit.value(state, speed), 0.0)
    if name == SLACK:
        return state.response.required
    return np.where(np.isnan(state.elbow_torque), 1.0, 0.0)
