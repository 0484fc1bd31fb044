"""Is every design of a run within its limits: which is not, by how much, and in which state."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from tendon_cli.checks.check_text import NO_EQUILIBRIUM, SLACK, WORST, Checked, finite, verdict_text
from tendon_cli.checks.compare import TOLERANCE, compare
from tendon_cli.cube.cube import cube_of
from tendon_cli.engine.plan import Plan
from tendon_cli.engine.results import AnyResult, Run, folder_of, verified_record
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMITS
from tendon_cli.model.statics import SLACK_TOLERANCE
from tendon_cli.space.axis import SIDES
from tendon_cli.studies.load import recorded_study
from tendon_cli.studies.study import Study
from tendon_cli.tables.read import TableFiles
from tendon_cli.tables.schema import as_numpy

Breach = dict[str, Any]
"""A limit that a design breaks, as in the record."""


def check(
    run: AnyResult,
    baseline: AnyResult | None = None,
    *,
    tolerance: float = TOLERANCE,
    apart: Sequence[str] = (),
    worst: int = WORST,
) -> Checked:
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
        return compare(
            folder, folder_of(baseline), tolerance=tolerance, apart=tuple(apart), worst=worst
        )
    record = verified_record(folder)
    if record["verb"] == "design":
        return _answer(record)
    table = Run(record, folder).kept("designs")
    result = _check_designs(table, recorded_study(table.facts["study"]), worst)
    return Checked(
        result["holds"], verdict_text(result, cube_of(table), record["name"]), finite(result)
    )


def _answer(record: dict[str, Any]) -> Checked:
    choices, feasible = record["choices"], record["feasible"]
    lines = [f"{record['name']}: {feasible:,} of {choices:,} choices have a window of pretension"]
    lines += [
        f"  {' against '.join(each['limits'])}" for each in record["conflicts"] if not feasible
    ]
    kept = {
        "choices": choices,
        "feasible": feasible,
        "conflicts": record["conflicts"],
        "holds": feasible > 0,
    }
    return Checked(feasible > 0, "\n".join(lines), kept)


def _check_designs(table: TableFiles, study: Study, worst: int) -> dict[str, Any]:
    """Check all rows of a table of designs, part by part; of the breaches the `worst` are listed with their states."""
    limits, plan = dict(study.limits.items()), Plan(study)
    names = ["design", "feasible", "taut", "margin", "required_pretension"]
    names += [name for limit in limits for name in _columns_of(limit)]
    breaches, broken, designs, feasible = list[Breach](), Counter[str](), 0, 0
    for _, part in table.parts(
        [name for name in dict.fromkeys(names) if name in table.schema.names]
    ):
        columns = {name: as_numpy(part[name]) for name in part.column_names}
        here = list(_breaches(columns, limits))
        designs, feasible = designs + part.num_rows, feasible + int(columns["feasible"].sum())
        broken.update(breach["limit"] for breach in here)
        breaches = sorted(
            [*breaches, *here], key=lambda breach: (-breach["excess"], breach["design"])
        )[:worst]
    return {
        "designs": designs,
        "feasible": feasible,
        "breaches": [_with_state(breach, plan) for breach in breaches],
        "broken": dict(broken.most_common()),
        "holds": feasible == designs,
    }


def _columns_of(limit: str) -> list[str]:
    """The column that a limit bounds, and those of the sides if they differ in it."""
    column = LIMITS[limit].column
    return [column, *(f"{column}_{side}" for side in SIDES)]


def _breaches(columns: Mapping[str, Array], limits: Mapping[str, float]) -> Iterator[Breach]:
    """Every limit that each of some designs breaks, in SI; of slack its margin of pretension."""
    needed, margin = columns["required_pretension"], columns["margin"]
    failing, nowhere = columns["feasible"] == 0.0, np.isnan(needed)
    slack, nothing = (columns["taut"] == 0.0) & ~nowhere, np.full(len(needed), np.nan)
    beyond = [(NO_EQUILIBRIUM, nothing, np.nan, np.where(nowhere, np.inf, -np.inf))]
    beyond += [(SLACK, margin, 0.0, np.where(slack, -margin / np.maximum(needed, 1e-300), -np.inf))]
    for limit, bound in limits.items():
        for name in _columns_of(limit):
            if name in columns:
                excess = LIMITS[limit].beyond(columns[name], bound) / (abs(bound) or 1.0)
                beyond.append(
                    (
                        limit,
                        columns[name],
                        bound,
                        np.where(excess > SLACK_TOLERANCE, excess, -np.inf),
                    )
                )
    for limit, values, bound, excess in beyond:
        for row in np.flatnonzero(failing & (excess > -np.inf)):
            yield {
                "design": int(columns["design"][row]),
                "limit": limit,
                "value": float(values[row]),
                "bound": bound,
                "excess": float(excess[row]),
                "direction": None,
                "elbow_angle": None,
            }


def _with_state(breach: Breach, plan: Plan) -> Breach:
    """With direction and elbow angle (rad) of the state that breaks it worst, unless no single state does."""
    limit, speed = LIMITS.get(breach["limit"]), plan.study.motion.speed
    if limit is not None and limit.forms is None:
        return breach
    worst = -np.inf
    for block in plan.blocks(range(breach["design"], breach["design"] + 1)):
        directions, angles = plan.directions[block.directions], plan.elbow_angles[block.angles]
        state = plan.state(block)
        if limit is not None:
            badness: Array = limit.beyond(
                limit.value(state, np.nan if speed is None else speed.single), 0.0
            )
        elif breach["limit"] == SLACK:
            badness = state.response.required
        else:
            badness = np.where(np.isnan(state.elbow_torque), 1.0, 0.0)
        values = np.broadcast_to(badness, block.shape).reshape(len(directions), -1)
        if np.isnan(values).all() or np.nanmax(values) <= worst:
            continue
        worst = float(np.nanmax(values))
        direction, angle = np.unravel_index(int(np.nanargmax(values)), values.shape)
        flexion = np.broadcast_to(plan.motion(block)[1], values.shape)[direction, angle]
        breach |= {
            "direction": "flexion" if flexion else "extension",
            "elbow_angle": float(angles[angle]),
        }
    return breach
