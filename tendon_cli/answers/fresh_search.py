"""The least change of one number that serves enough of a fresh sample.

To judge a value by all members of the sample takes long, and few conditions of few members decide:
a value is refuted as soon as these leave out more members than may be left out of all, even if
everybody else were served. So the search goes on among the few. What it finds is judged by all
members, and the conditions that refute it join the few.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tendon_cli.answers.least_change import (
    Change,
    ChangeSearch,
    Effort,
    PrintedChange,
    overlap,
    printed_pretension,
)
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.window import Ends
from tendon_cli.space.axis import evenly_spaced
from tendon_cli.windows.coverage import effective_count, normalise, serves, share_served
from tendon_cli.windows.question import Question, is_sought
from tendon_cli.windows.solutions import Solutions, solve_windows
from tendon_cli.windows.solver import NEAR, Solver
from tendon_cli.windows.verification import Verified, Verifier, binding_conditions

_SCAN = Effort(values=18, zooms=2, sections=6, rounds=6, first=1e-3, tolerance=2e-4)
"""Effort for a change that may open a window and then close it again."""
_BISECTION = Effort(values=8, zooms=0, sections=3, rounds=14, first=1e-3, tolerance=2e-4)
"""Effort for a change that opens the more windows, the larger it is."""
_SPARING_SCAN = Effort(values=10, zooms=1, sections=5, rounds=4, first=1e-3, tolerance=1e-3)
"""Effort for the first kind where each window is sought pretension by pretension."""
_SPARING_BISECTION = Effort(values=5, zooms=0, sections=3, rounds=8, first=1e-3, tolerance=1e-3)
"""Effort for the second kind there."""
_FEW = 64
"""Members that the sieve asks."""
_ERRORS = 5.0
"""Standard errors below the share asked for at which the sieve refutes a value."""
_SPARE = 1.25
"""Weight of the first members that decide, as a multiple of the weight that may be left out."""
_FEWEST = 128
"""Members that decide beside these."""
_SPARING_FEWEST = 32
"""The same where each window is sought pretension by pretension."""
_STEP = 1e-3
"""Share of the way to the farthest value by which the search goes on from a refuted value."""


@dataclass(frozen=True, eq=False)
class FreshSearch:
    """Search for changes that serve enough of a fresh sample."""

    verifier: Verifier
    """Judge by the sample."""
    own: Solver
    """Solver of the question under the conditions of the study's own sample."""
    refuted: Verified | None = None
    """Judgement on the choice as the study has it, which serves too few; None if the study's own
    sample already finds no window."""

    def least(
        self, change: Change, start: PrintedChange | None, *, must_be_buildable: bool = False
    ) -> PrintedChange | None:
        """Return the least change that serves enough.

        If possible, it is one whose pretension serves enough of the study's own sample, too: the
        answer to the changed study then names such a pretension.

        Args:
            change: The change of one choice.
            start: First value that is judged; None to go on from the refuted choice.
            must_be_buildable: True if a choice that cannot be built does not count.

        Returns:
            The change, with the judgement; None if no value up to the farthest serves enough.
        """
        deciding = np.zeros(len(self._question.conditions), dtype=np.bool_)
        search = ChangeSearch(self.verifier.solver, change, must_be_buildable=must_be_buildable)
        of_fresh = None
        tried = start
        if start is None and self.refuted is not None:
            low, high = self.refuted.windows
            deciding = self._with_deciding(deciding, low, high, self.refuted.binding)
            tried = self._least_of_few(search, deciding)
        while tried is not None:
            ends, solved = self._solve(change, tried.value)
            if solved.feasible[0]:
                of_own = change.solve(self.own, tried.at, change.points)
                for_both = overlap(self._question, solved, of_own)
                text = printed_pretension(self._question, for_both or solved, digits=3)
                found = self._judged(change, tried._replace(judged_at=text), solved, ends)
                if for_both is not None:
                    return found
                of_fresh = of_fresh or found
                search = replace(search, beside=self.own)
            if change.is_reached(tried.value):
                break
            low, high = self._question.groups.windows(ends.low, ends.high)
            binding = binding_conditions(self._question, ends)
            deciding = self._with_deciding(deciding, low[0], high[0], binding)
            rest = replace(change, before=change.beyond(tried.value, _STEP))
            tried = self._least_of_few(replace(search, change=rest), deciding)
        return of_fresh

    @cached_property
    def has_window(self) -> bool:
        """True if the refuted choice serves enough of the sample at another pretension."""
        if self.refuted is None or self._question.placement.given is not None:
            return False
        return self.refuted.low <= self.refuted.high

    def can_be_built_within(self, choice: Solutions) -> bool:
        """Return True if the refuted choice can be built where it serves enough of the sample.

        Args:
            choice: The choice, which serves enough at another pretension (`has_window`).
        """
        if self.refuted is None:
            raise ValueError("no choice is refuted")
        low = np.array([self.refuted.low])
        high = np.array([self.refuted.high])
        pretension = float(self._question.placement.within(low, high, choice.reserve)[0])
        judged = self.verifier.judge_at(choice.points, pretension)
        return bool(self._with_worst(self._question, choice, pretension, judged).can_be_built[0])

    @property
    def _question(self) -> Question:
        """Question under the conditions of the sample."""
        return self.verifier.solver.question

    def _solve(self, change: Change, value: float) -> tuple[Ends, Solutions]:
        """Solve a value for all members.

        Returns:
            Ends of windows, (1, conditions), and the choice, both without worst values.
        """
        question, points = change.applied(self._question, value, change.points)
        solver = self.verifier.solver.for_question(question)
        ends = solver.ends(points)
        solved, _ = solve_windows(solver, points, ends)
        return ends, solved

    def _judged(
        self, change: Change, tried: PrintedChange, solved: Solutions, ends: Ends
    ) -> PrintedChange:
        """Return a change that serves enough with the judgement of all members.

        Args:
            change: The change.
            tried: The change with the pretension, as printed.
            solved: The choice.
            ends: Ends of windows of all members, (1, conditions).
        """
        pretension = float(tried.judged_at.replace(",", ""))
        question, points = change.applied(self._question, tried.value, change.points)
        verifier = self.verifier.for_question(question)
        # Ends hold over all angles near both ends of the window.
        from_low = abs(pretension - solved.pretension_from.item())
        from_high = abs(solved.pretension_to.item() - pretension)
        is_near = min(from_low, from_high) <= 0.5 * NEAR * (1.0 + abs(pretension))
        judged = verifier.judge_at(points, pretension, ends if is_near else None)
        with_worst = self._with_worst(question, solved, pretension, judged)
        return tried._replace(solved=with_worst, judged=judged)

    def _with_worst(
        self, question: Question, solved: Solutions, pretension: float, judged: Verified
    ) -> Solutions:
        """Return a choice at a pretension with its worst values for the members it serves.

        Args:
            question: Question of the sample, with a change or without.
            solved: The choice.
            pretension: The pretension, N.
            judged: Judgement on the choice at this pretension.
        """
        solver = self.verifier.solver.for_question(question)
        of_conditions = judged.is_served[np.newaxis, question.groups.of]
        worst = solver.worst(solved.points, np.array([pretension]), of_conditions)
        at_pretension = replace(
            solved, pretension=np.array([pretension]), served_at=np.array([judged.value])
        )
        return at_pretension.with_worst(question, slice(None), worst)

    # --- The few conditions that decide -----------------------------------------------------------

    def _least_of_few(self, search: ChangeSearch, deciding: Flags) -> PrintedChange | None:
        """Return the least value that the conditions which decide do not refute; None without one.

        Args:
            search: The search.
            deciding: True for the conditions that decide, (conditions,).
        """
        change = search.change
        sieve = None
        effort = _SPARING_BISECTION if is_sought(self._question) else _BISECTION
        if change.effort.values > 1:
            sieve = self._sieve
            effort = _SPARING_SCAN if is_sought(self._question) else _SCAN
        quick = replace(
            search,
            solver=self._solver_of(deciding),
            change=replace(change, effort=effort),
            sieve=sieve,
        )
        opening = quick.least()
        return None if opening is None else quick.printed(opening)

    def _solver_of(self, deciding: Flags) -> Solver:
        """Return the solver for conditions that decide, which takes all other members as served."""
        question = self._question.within_groups(np.flatnonzero(deciding))
        serve = self._share_of(self._members_of(deciding))
        return self.verifier.solver.for_question(replace(question, serve=serve))

    def _members_of(self, conditions: Flags) -> Flags:
        """Return True for the members to whom some conditions belong, (members,)."""
        groups = self._question.groups
        return np.bincount(groups.of[conditions], minlength=len(groups)) > 0

    def _share_of(self, members: Flags) -> float:
        """Return the share of some members that must be served if all others are."""
        weighting = self._question.groups.weighting
        left_out = (1.0 - self._question.serve) * weighting.sum()
        return float(1.0 - left_out / weighting[members].sum())

    @cached_property
    def _sieve(self) -> Solver | None:
        """Solver for a few members, who must be served but for what may be chance.

        None if the sample is small, or so few could refute nothing.
        """
        question = self._question
        if len(question.groups) < 2 * _FEW:
            return None
        members = evenly_spaced(len(question.groups), _FEW)
        few = question.within_groups(question.groups.conditions_of(members))
        error = math.sqrt(
            question.serve * (1.0 - question.serve) / effective_count(few.groups.weighting)
        )
        least = question.serve - _ERRORS * error
        return self.verifier.solver.for_question(replace(few, serve=least)) if least > 0.0 else None

    def _with_deciding(self, deciding: Flags, low: Array, high: Array, binding: Flags) -> Flags:
        """Add conditions that decide at a value that serves too few, so that they refute it.

        Args:
            deciding: True for the conditions that decided so far, (conditions,).
            low: Lower ends of the members' windows at this value, (members,), N.
            high: Upper ends.
            binding: True for the conditions that set these ends, (conditions,).
        """
        groups = self._question.groups
        pretension, _ = self._best(low, high, np.ones(len(groups), dtype=np.bool_))
        hardest_first = np.argsort(_margin(low, high, pretension), kind="stable")
        weight = np.cumsum(groups.weighting[hardest_first])
        left_out = (1.0 - self._question.serve) * weight[-1]
        members = self._members_of(deciding)
        fewest = _SPARING_FEWEST if is_sought(self._question) else _FEWEST
        count = int(np.searchsorted(weight, _SPARE * left_out)) + fewest
        members[hardest_first[: max(count, 2 * int(members.sum()))]] = True
        # They may be served together at another pretension, which then leaves out others.
        while not members.all():
            pretension, share = self._best(low, high, members)
            is_left_out = _margin(low, high, pretension) < 0.0
            if share < self._share_of(members) or not (is_left_out & ~members).any():
                break
            members |= is_left_out
        return deciding | (binding & members[groups.of])

    def _best(self, low: Array, high: Array, members: Flags) -> tuple[float, float]:
        """Return the pretension that serves most of some members, N, and the share of them.

        Args:
            low: Lower ends of all members' windows, (members,), N.
            high: Upper ends.
            members: True for these members, (members,).
        """
        question = self._question
        weighting = question.groups.weighting[members]
        given = question.placement.given
        if given is not None:
            is_served = serves(low[members], high[members], given)
            return given, float(normalise(weighting) @ is_served)
        covered = share_served(low[np.newaxis, members], high[np.newaxis, members], weighting)
        begin = float(covered.best_low[0])
        end = float(covered.best_high[0])
        middle = begin if math.isinf(end) else 0.5 * (begin + end)
        return middle, float(covered.served[0])


def _margin(low: Array, high: Array, pretension: float) -> Array:
    """Return the margin of windows at a pretension, (members,), N; negative outside.

    Args:
        low: Lower ends, N.
        high: Upper ends, N.
        pretension: The pretension, N.
    """
    margin = np.minimum(pretension - low, high - pretension)
    return np.where(np.isnan(margin), -np.inf, margin)
