"""Certificate of one choice: a proof of its window, tightened until it can be proved.

A limit is linear in pretension. What is kept at a pretension below the window and at another above
it is kept in all of the window. A cell that was proved once therefore stays proved as the window
narrows, and all of the proof is one subdivision of the motion, the box and the postures.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from tendon_cli.engine.windows.question import with_enough
from tendon_cli.engine.windows.sampling_error import estimate_error
from tendon_cli.engine.windows.solutions import Solutions, solve_windows
from tendon_cli.engine.windows.solver import Folded, Solver
from tendon_cli.engine.windows.study_arm import given_pretensions
from tendon_cli.engine.windows.worst_between import worst_between
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.window import Ends
from tendon_cli.proof.arcs import ConditionArcs
from tendon_cli.proof.scope import Scope
from tendon_cli.proof.subdivision import (
    Cells,
    Verdict,
    cells_at_once,
    concatenate,
    most_cells,
)
from tendon_cli.proof.tightening import tighten
from tendon_cli.studies import limit_phrases

Report: TypeAlias = Callable[[int, int], None]
"""Called with the numbers of cells that were examined, and of most cells, while a proof lasts."""

_MARGIN = 1e-6
"""Distance from both ends within which a window is not proved, N: there a limit is just kept."""
_ROUNDS = 24
"""Times that a proof may tighten the ends."""
_TO_PROVE = 0.75
"""Share of the cells for the proof itself; the others bound the error of a window left open."""
_LEAST_ERROR = 1e-3
"""Least bound of the error of an open window that is tried, N."""
_LARGER_ERROR = 2.0
"""Factor from one such bound to the next."""
_PROBES = 64
"""Cells by which the first of such bounds is chosen."""
_PROBES_LEFT = 8
"""Probes for which the first bound need not suffice, as halved cells need less."""


@dataclass(frozen=True, eq=False)
class Certificate:
    """Result of the proof of one choice's window between the samples."""

    status: str
    """One of `limit_phrases.STATUSES`."""
    cells: int
    """Number of cells that were tried."""
    margin: float
    """Distance from both ends within which the window is not proved, N."""
    estimate: float | None
    """Error of the ends that are not proved, N, estimated if they are sampled, and a bound if they
    are open; None if it is not known."""
    scope: Scope
    """Values of angles, loads and intervals for which the window is proved."""
    ends: Ends
    """Ends of the windows under each condition, as they are read, (1, conditions); tightened around
    each state at which a limit was found broken."""
    solution: Solutions
    """The choice, solved from these ends."""


def certify(
    solver: Solver, solution: Solutions, report: Report = lambda _cells, _most: None
) -> Certificate:
    """Prove the window of one choice; tighten it around each state that breaks a limit.

    A choice that a second sample has set keeps its window and its setting: what is proved is then
    the window that serves enough of the question's own sample.

    Args:
        solver: Solver of the question.
        solution: The solved choice.
        report: Called as the proof goes on.

    Raises:
        Stopped: The run was cancelled.
    """
    question = solver.question
    points = solution.points
    is_set_already = question.sample.sets_by_sample
    if is_set_already:
        question = with_enough(question, question.serve)
        solver = solver.for_question(question)
    folded = solver.fold(points)
    if question.sample.enough < 1.0:
        solver.seek_everywhere(folded, points)
    else:
        solver.seek(folded, points, given_pretensions(question, points))
    of_sample = solution
    if is_set_already:
        of_sample, _ = solve_windows(solver, points, solver.read(folded, points))
    proof = _Proof(solver, of_sample, folded, report)
    is_sampled = question.for_choice(solution.points).is_sampled
    status = limit_phrases.SAMPLED
    if _is_in_window(of_sample) and question.study.trajectory is None:
        is_proved = proof.run()
        status = limit_phrases.OPEN
        if is_proved:
            status = limit_phrases.SAMPLED if is_sampled else limit_phrases.PROVEN
    is_open = status == limit_phrases.OPEN
    estimate = None
    if proof.solution.has_window.item():
        if not is_open:
            estimate = estimate_error(solver, proof.solution, proof.folded)
        elif not is_sampled:
            estimate = proof.error_bound()
    if not is_set_already:
        solution = proof.with_worst()
    return Certificate(
        status=status,
        cells=proof.examined,
        margin=0.0 if is_open else proof.margin,
        estimate=estimate,
        scope=Scope.of(question),
        ends=solver.read(proof.folded, solution.points),
        solution=replace(
            solution, between_samples=np.array([limit_phrases.STATUSES.index(status)])
        ),
    )


def _is_in_window(solution: Solutions) -> bool:
    """Return True if one choice has a window, and is not served at a pretension outside of it.

    A given pretension may lie in another window than the widest, whose proof says nothing of it.
    """
    low = solution.pretension_from.item()
    high = solution.pretension_to.item()
    return low <= high and (
        not solution.feasible.item() or low <= solution.pretension.item() <= high
    )


class _Proof:
    """Proof of the window of one choice.

    Attributes:
        folded: Ends over all angles, (1, conditions); tightened as the proof goes on.
        solution: The choice, solved from these ends.
        windows: Ends of the window that must hold under each condition, (conditions,), N as they
            are read; the window is empty under a condition that need not be served.
        margin: Distance from both ends within which the window is not proved, N.
        examined: Number of cells that were examined.
        left: Cells that are not proved yet.
        narrow: Cells that are not proved and too narrow to be halved.
    """

    def __init__(self, solver: Solver, solution: Solutions, folded: Folded, report: Report) -> None:
        question = solver.question
        self._solver = solver
        self._report = report
        self._conditions = ConditionArcs.of(question, solution.points)
        self._at_once = cells_at_once(len(question.box))
        self._tightened = 0
        self._served: Flags | None = None
        self._low = np.full(len(question.conditions), np.inf)
        self._high = np.full(len(question.conditions), -np.inf)
        self.most = most_cells(len(question.box))
        self.folded = folded
        self.solution = solution
        self.windows = _served_windows(solver, folded, solution)
        self.margin = 0.0
        self.examined = 0
        self.left = self._conditions.first_cells(self._conditions.row[:0])
        self.narrow = self.left

    def run(self) -> bool:
        """Examine cells until all are proved, or as many as may be; return True if all are.

        Raises:
            Stopped: The run was cancelled.
        """
        self._solve_again()
        while len(self.left) and self.solution.has_window.item():
            if self.examined + len(self.left) > _TO_PROVE * self.most:
                break
            self._examine_all()
        has_window = self.solution.has_window.item()
        return has_window and not len(self.left) and not len(self.narrow)

    def with_worst(self) -> Solutions:
        """Return the choice with its worst values at all angles, as it was if nothing is proved."""
        solution = self.solution
        if self._served is None:
            return solution
        worst = worst_between(self._solver, solution.points, solution.pretension, self._served)
        return solution.with_worst(self._solver.question, slice(None), worst)

    def _solve_again(self) -> None:
        """Solve the choice from its ends, and begin anew under conditions whose window widens."""
        solver = self._solver
        points = self.solution.points
        read = solver.read(self.folded, points)
        self.solution, self._served = solve_windows(solver, points, read)
        self.windows = _served_windows(solver, self.folded, self.solution)
        low, high = self.windows
        self.margin = min(_MARGIN, 0.25 * float(np.max(high - low)))
        is_served = high - low >= 2.0 * self.margin
        low = np.where(is_served, low + self.margin, np.inf)
        high = np.where(is_served, high - self.margin, -np.inf)
        stays_proved = (low >= self._low) & (high <= self._high)
        self._low = low
        self._high = high
        rows = self._conditions.row
        anew = self._conditions.first_cells(rows[(is_served & ~stays_proved)[rows]])
        is_kept = is_served & stays_proved
        self.narrow = self.narrow.select(is_kept[self.narrow.row])
        self.left = concatenate([self.left.select(is_kept[self.left.row]), anew])

    def _examine_all(self) -> None:
        """Examine all cells that are left: halve them, or tighten the ends around broken limits."""
        broken = []
        narrow = [self.narrow]
        left = []
        for part, verdict in self._judge(self.left, 0.0):
            is_open = ~verdict.is_kept & ~verdict.is_broken
            is_halved = is_open & ~part.is_narrow
            broken.append(part.select(verdict.is_broken))
            narrow.append(part.select(is_open & ~is_halved))
            left.append(part.select(is_halved).halved(verdict.along[is_halved]))
        self.narrow = concatenate(narrow)
        self.left = concatenate(left)
        where = concatenate(broken)
        if not len(where):
            return
        if self._tightened == _ROUNDS:
            self.narrow = concatenate([self.narrow, where])
            return
        self._tightened += 1
        self.left = concatenate([where, self.left])
        tightened = tighten(self._conditions, self.folded.ends, where)
        self.folded = replace(self.folded, ends=tightened)
        self._solve_again()

    def _judge(self, cells: Cells, inward: float) -> Iterator[tuple[Cells, Verdict]]:
        """Judge cells, in portions, at a distance inward from the ends of the window, N."""
        for part in self._solver.cut(len(cells), self._at_once):
            portion = cells.select(part)
            verdict = self._conditions.judge(portion, self._low + inward, self._high - inward)
            self.examined += len(portion)
            self._report(self.examined, self.most)
            yield portion, verdict

    def error_bound(self) -> float | None:
        """Return a bound of the error of an open window, N; None if the cells do not suffice.

        Each end is one at which a limit is just kept in a state, and so not too tight. If a window
        that is narrower by this bound at both ends is proved, no end is off by more.
        """
        cells = concatenate([self.left, self.narrow])
        low = self._low[cells.row]
        high = self._high[cells.row]
        widest = 0.5 * float((high - low).min(initial=np.inf))
        probes = cells.select(slice(None, None, 1 + len(cells) // _PROBES))
        error = _LEAST_ERROR
        while error < widest and len(probes) > _PROBES_LEFT and self._has_enough_for(probes):
            probes = concatenate(
                [part.select(~verdict.is_kept) for part, verdict in self._judge(probes, error)]
            )
            error *= _LARGER_ERROR
        while error < widest and self._has_enough_for(cells):
            cells = self._halves_not_proved(cells, error)
            if not len(cells):
                return error + self.margin
            error *= _LARGER_ERROR
        return None

    def _has_enough_for(self, cells: Cells) -> bool:
        """Return True if so many cells may still be examined."""
        return self.examined + len(cells) <= self.most

    def _halves_not_proved(self, cells: Cells, inward: float) -> Cells:
        """Return the halves of cells that are not proved at a distance inward from the ends, N."""
        halves = [cells.select(slice(0))]
        for part, verdict in self._judge(cells, inward):
            is_open = ~verdict.is_kept
            halves.append(part.select(is_open).halved(verdict.along[is_open]))
        return concatenate(halves)


def _served_windows(solver: Solver, folded: Folded, solution: Solutions) -> tuple[Array, Array]:
    """Return the ends of the window that must hold under each condition, (conditions,).

    They are as they are read, N. The window is empty under a condition that need not be served.

    Args:
        solver: Solver of the question.
        folded: Ends over all angles, (1, conditions).
        solution: The choice, solved from these ends.
    """
    question = solver.question
    low = solution.pretension_from
    high = solution.pretension_to
    if question.sample.enough >= 1.0:
        count = len(question.conditions)
        return np.repeat(low, count), np.repeat(high, count)
    of_conditions = solver.read(folded, solution.points)
    group_low, group_high = question.groups.windows(of_conditions.low, of_conditions.high)
    served_low = np.maximum(group_low[0], low)
    served_high = np.minimum(group_high[0], high)
    return served_low[question.groups.of], served_high[question.groups.of]
