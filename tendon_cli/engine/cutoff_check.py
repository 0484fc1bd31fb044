"""Check of what the cutoff of a trajectory's low-pass decides.

Noise of the angle grows in its derivatives, and motion above the cutoff is lost. Both show in what
the peaks of the motor do at 0.7 times the cutoff: of clean motions below a quarter of the cutoff
none changed by 10 %, and every motion did whose peaks were off by 15 % for noise.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from tendon_cli.engine.plan import Plan
from tendon_cli.model.design import Design
from tendon_cli.studies.study import Study
from tendon_cli.tables.schema import finite_or_none
from tendon_cli.verbs.answer_record import CutoffCheck

_CHANGES = 0.1
"""Share by which a peak must change to be decided by the cutoff."""
_MOST_DESIGNS = 16
"""Most designs of a sweep that are looked at, evenly spread."""


def check_of_sweep(plan: Plan) -> CutoffCheck | None:
    """Check the designs of a sweep, or as many of them as are quick; None without a trajectory."""
    if plan.study.trajectory is None:
        return None
    from tendon_cli.model.motor import select_points  # only a study of motion pays for its import

    count = min(plan.designs, _MOST_DESIGNS)
    rows = np.unique(np.linspace(0, plan.designs - 1, count).round().astype(np.int64))
    shape = plan.shape or (1,)
    every = plan.space.design(plan.space.whole)
    designs = select_points(every, (*shape, 1, 1), np.unravel_index(rows, shape))
    return check_of_designs(plan.study, [designs])


def check_of_designs(study: Study, designs: Iterable[Design]) -> CutoffCheck | None:
    """Check designs along the trajectory of a study; None without one.

    Args:
        study: The study.
        designs: Designs, some at a time.
    """
    if study.trajectory is None:
        return None
    # Only a study of motion pays for the imports.
    from tendon_cli.model.moving import Moving, motion_demand
    from tendon_cli.studies.measured_motion import LOWER, cutoff_of, trajectory_of

    lower = trajectory_of(study.motion, study.load.torque, LOWER)
    if lower is None:
        return None
    demands = []
    for design in designs:
        along_lower = replace(design, trajectory=lower)
        of_cutoff = motion_demand(Moving.of(design, study.trajectory))
        demands.append([of_cutoff, motion_demand(Moving.of(along_lower, lower))])
    largest = np.fmax.reduce(np.array(demands), axis=0)  # (cutoffs, speed and power)
    cutoff = cutoff_of(study.motion)
    (speed, power), (lower_speed, lower_power) = largest.tolist()
    return CutoffCheck(
        cutoff=cutoff,
        lower=round(LOWER * cutoff, 12),
        peak_motor_speed=(finite_or_none(speed), finite_or_none(lower_speed)),
        peak_motor_power=(finite_or_none(power), finite_or_none(lower_power)),
        decides=_changes(speed, lower_speed) or _changes(power, lower_power),
    )


def _changes(value: float, lower: float) -> bool:
    """Return True if a peak at the lower cutoff differs by over 10 %."""
    return abs(lower - value) > _CHANGES * abs(value)
