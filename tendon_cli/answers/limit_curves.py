"""Curves of one choice over the elbow angle: the pretensions that each limit allows."""

from __future__ import annotations

import numpy as np

from tendon_cli.answer_record import CurvesRecord
from tendon_cli.model.kinematics import Array
from tendon_cli.model.whole_motion import end_curves
from tendon_cli.model.window import Ends
from tendon_cli.tables.schema import finite_or_none
from tendon_cli.windows.solutions import Solutions
from tendon_cli.windows.solver import Solver


def curves_of(solver: Solver, choice: Solutions, ends: Ends) -> CurvesRecord:
    """Return the pretensions that each limit allows one choice over the elbow angle, as recorded.

    Limits on the whole motion have no curve. Along a trajectory the curves are over the angles of
    the samples that count, in both directions of friction.

    Args:
        solver: Solver of the question.
        choice: The choice.
        ends: Ends of its windows as they are read, (1, conditions). If its pretension does not
            serve all conditions, only those that it serves count (`all_conditions`).

    Returns:
        `elbow_angle`, rad; by limit in `lower` the least and in `upper` the largest pretension
        over both directions and all conditions, N, null where the limit asks for nothing;
        `samples`, the angles of the study, rad.
    """
    lower: dict[str, Array] = {}
    upper: dict[str, Array] = {}
    question = solver.question
    pretension = choice.pretension[:1]
    is_served = (ends.low <= pretension) & (pretension <= ends.high)
    counts = is_served if is_served.any() else ~is_served
    for _, conditions, design in solver.portions(choice.points):
        part_counts = counts[:, conditions, np.newaxis, np.newaxis]
        part_lower, part_upper = end_curves(
            design, question.angles, question.flexion, question.bounds, part_counts
        )
        for name, values in part_lower.items():
            lower[name] = np.maximum(values, lower.get(name, values))
        for name, values in part_upper.items():
            upper[name] = np.minimum(values, upper.get(name, values))
    angles = question.angles.ravel()
    trajectory = question.study.trajectory
    if trajectory is not None:  # samples that count, in the order of their angles
        counted = np.flatnonzero(~trajectory.is_at_end)
        order = counted[np.argsort(angles[counted])]
        angles = angles[order]
        lower = {name: values[order] for name, values in lower.items()}
        upper = {name: values[order] for name, values in upper.items()}
    return {
        "elbow_angle": angles.tolist(),
        "samples": np.unique(angles if trajectory is not None else question.study.angles).tolist(),
        "all_conditions": bool(counts.all()),
        "lower": {name: [*map(finite_or_none, values.tolist())] for name, values in lower.items()},
        "upper": {name: [*map(finite_or_none, values.tolist())] for name, values in upper.items()},
    }
