"""Curves of one choice over the motion: the pretensions that each limit allows."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tendon_cli.engine.windows.question import Question
from tendon_cli.engine.windows.solutions import Solutions
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.motion_window import OF_WHAT_HOLDS
from tendon_cli.model.moving import Moving
from tendon_cli.model.whole_motion import end_curves
from tendon_cli.model.window import Ends
from tendon_cli.tables.schema import finite_or_none
from tendon_cli.verbs.answer_record import CurvesRecord


def curves_of(solver: Solver, choice: Solutions, ends: Ends) -> CurvesRecord:
    """Return the pretensions that each limit allows one choice over the motion, as recorded.

    The limit on power has no curve. Along a trajectory the states count that hold at the
    end of the choice's window, and where tendons turn there those of the other direction.

    Args:
        solver: Solver of the question.
        choice: The choice.
        ends: Ends of its windows as they are read, (1, conditions). If its pretension does not
            serve all conditions, only those that it serves count (`all_conditions`).

    Returns:
        `elbow_angle`, rad, and along a trajectory `time`, s; by limit in `lower` the least and in
        `upper` the largest pretension over both directions and all conditions, N, null where the
        limit asks for nothing; `samples`, the angles of the study, rad.
    """
    lower: dict[str, Array] = {}
    upper: dict[str, Array] = {}
    question = solver.question
    trajectory = question.study.trajectory
    pretension = choice.pretension[:1]
    is_served = (ends.low <= pretension) & (pretension <= ends.high)
    counts = is_served if is_served.any() else ~is_served
    of_ends = [pretension]
    if trajectory is not None:
        of_ends = [
            _known(end, pretension) for end in (choice.pretension_from, choice.pretension_to)
        ]
    for place, at_end in enumerate(of_ends):
        for _, conditions, design in solver.portions(choice.points.at_pretension(at_end)):
            part_counts = counts[:, conditions, np.newaxis, np.newaxis]
            for bounds, which in _counted(question, design, part_counts):
                part_lower, part_upper = end_curves(
                    design, question.angles, question.flexion, bounds, which
                )
                if place == 0:
                    _tighten(lower, part_lower, np.maximum)
                if place == len(of_ends) - 1:
                    _tighten(upper, part_upper, np.minimum)
    return CurvesRecord(
        elbow_angle=question.angles.ravel().tolist(),
        time=None if trajectory is None else trajectory.time.tolist(),
        at_record_end=None if trajectory is None else trajectory.is_at_end.tolist(),
        samples=np.unique(question.study.angles).tolist(),
        all_conditions=bool(counts.all()),
        lower={name: [*map(finite_or_none, values.tolist())] for name, values in lower.items()},
        upper={name: [*map(finite_or_none, values.tolist())] for name, values in upper.items()},
    )


def _known(end: Array, pretension: Array) -> Array:
    """Return an end of a window, (1,), or if it is not finite the choice's pretension."""
    return end[:1] if np.isfinite(end[:1]).all() else pretension


def _tighten(curves: dict[str, Array], others: dict[str, Array], tighter: np.ufunc) -> None:
    """Put the tighter of both curves of each limit into `curves`, in place."""
    for name, values in others.items():
        curves[name] = tighter(values, curves.get(name, values))


def _counted(question: Question, design: Design, counts: Flags) -> Iterator[tuple[Bounds, Flags]]:
    """Yield limits and the states of designs, (..., directions, angles), in which they count.

    Args:
        question: The question.
        design: Designs at their pretension.
        counts: True for the designs that count, (..., 1, 1).
    """
    bounds = question.bounds
    trajectory = question.study.trajectory
    if trajectory is None:
        yield bounds, counts
        return
    sliding = Moving.of(design, trajectory).sliding
    is_held = np.concatenate([sliding.flexion, ~sliding.flexion], axis=-2)
    is_inside = counts & ~trajectory.is_at_end
    of_what_holds = {name: bound for name, bound in bounds.items() if name in OF_WHAT_HOLDS}
    of_both = {name: bound for name, bound in bounds.items() if name not in OF_WHAT_HOLDS}
    yield (
        Bounds(speed=bounds.speed, min_elbow_stiffness=-np.inf, **of_both),
        is_inside & (is_held | sliding.turning),
    )
    yield Bounds(speed=bounds.speed, **of_what_holds), is_inside & is_held & ~sliding.passing
