"""Certificate of one choice: a proof of its window, tightened until it can be proved."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tendon_cli import say
from tendon_cli.model.kinematics import Array
from tendon_cli.model.window import Ends
from tendon_cli.proof.arcs import ConditionArcs
from tendon_cli.proof.scope import Scope
from tendon_cli.proof.subdivision import MOST_CELLS
from tendon_cli.proof.tightening import tighten
from tendon_cli.windows.question import Question
from tendon_cli.windows.sampling_error import estimate_error
from tendon_cli.windows.solutions import Solutions, solve_windows
from tendon_cli.windows.solver import Solver
from tendon_cli.windows.worst_between import worst_between

_MARGIN = 1e-6
"""Distance from both ends within which a window is not proved, N: there a limit is just kept."""
_ROUNDS = 24
"""Rounds in which a proof may find states by which an end is tightened."""


@dataclass(frozen=True, eq=False)
class Certificate:
    """Result of the proof of one choice's window between the samples."""

    status: str
    """One of `say.STATUSES`."""
    cells: int
    """Number of cells that were tried."""
    margin: float
    """Distance from both ends within which the window is not proved, N."""
    estimate: float | None
    """Estimated error of the ends that are not proved, N."""
    scope: Scope
    """Values of angles, loads and intervals for which the window is proved."""
    ends: Ends
    """Ends of the windows under each condition, as they are read, (1, conditions); tightened around
    each state at which a limit was found broken."""
    solution: Solutions
    """The choice, solved from these ends."""


def certify(solver: Solver, solution: Solutions) -> Certificate:
    """Prove the window of one choice; tighten it around each state that breaks a limit.

    Args:
        solver: Solver of the question.
        solution: The solved choice.

    Raises:
        Stopped: The run was cancelled.
    """
    question = solver.question
    points = solution.points
    status = say.SAMPLED
    cells = 0
    margin = 0.0
    arcs = ConditionArcs.of(question, points)
    if question.serve < 1.0:
        ends = solver.ends_over_all_angles(points)
    else:
        ends = solver.ends_that_may_bind(points)
    rounds = 0
    if solution.has_window.item() and question.study.trajectory is None:
        rounds = _ROUNDS
        solution = _solve_again(solver, solution, ends)
    for _ in range(rounds):
        low, high = _served_windows(question, solver.all_limits(ends, points), solution)
        margin = min(_MARGIN, 0.25 * float(np.max(high - low)))
        arcs = arcs.select((high - low)[arcs.row] >= 2.0 * margin)
        proof = arcs.prove(low + margin, high - margin)
        cells += proof.cells
        failing = np.unique(np.concatenate([proof.broken.row, proof.left.row]))
        if not len(failing):
            status = say.SAMPLED if question.is_sampled else say.PROVEN
            break
        status = say.OPEN
        if cells > MOST_CELLS:
            break
        broken = proof.broken
        postures = arcs
        can_halve = arcs.high[failing] > arcs.low[failing]
        if can_halve.any():
            # A limit that is broken where two tangents meet need not be broken on the arc.
            postures = arcs.select(failing).middles
            broken = postures.prove(low + margin, high - margin).broken
        if len(broken):
            ends = tighten(question, ends, broken, postures)
            solution = _solve_again(solver, solution, ends)
            if not solution.has_window.item():
                break
        elif not can_halve.any():
            break
        halves = np.zeros(len(arcs), dtype=np.bool_)
        halves[failing[can_halve]] = True
        arcs = arcs.halve(halves)
    all_ends = solver.all_limits(ends, points)
    low, high = _served_windows(question, all_ends, solution)
    is_open = status == say.OPEN
    estimate = None
    if not is_open and solution.has_window.item():
        estimate = estimate_error(solver, solution, ends)
    return Certificate(
        status=status,
        cells=cells,
        margin=0.0 if is_open else margin,
        estimate=estimate,
        scope=Scope.of(question, low, high),
        ends=all_ends,
        solution=replace(solution, between_samples=np.array([say.STATUSES.index(status)])),
    )


def _served_windows(question: Question, ends: Ends, solution: Solutions) -> tuple[Array, Array]:
    """Return the ends of the window that must hold under each condition, (conditions,).

    They are as they are read, N. The window is empty under a condition that need not be served.
    """
    low = solution.pretension_from
    high = solution.pretension_to
    if question.serve >= 1.0:
        count = len(question.conditions)
        return np.repeat(low, count), np.repeat(high, count)
    group_low, group_high = question.groups.windows(ends.low, ends.high)
    served_low = np.maximum(group_low[0], low)
    served_high = np.minimum(group_high[0], high)
    return served_low[question.groups.of], served_high[question.groups.of]


def _solve_again(solver: Solver, solution: Solutions, ends: Ends) -> Solutions:
    """Solve one choice from the ends of its windows over all angles, (1, conditions), as F0."""
    points = solution.points
    solved, served = solve_windows(solver, points, solver.all_limits(ends, points))
    worst = worst_between(solver, points, solved.pretension, served)
    return solved.with_worst(solver.question, slice(None), worst)
