"""Ends of windows that are tightened around states at which a proof finds a limit broken."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tendon_cli.model.kinematics import Array, Rows
from tendon_cli.model.whole_motion import refine_ends
from tendon_cli.model.window import Ends
from tendon_cli.proof.arcs import ConditionArcs
from tendon_cli.proof.subdivision import Cells

_CLIMBS = 60
"""Steps in intervals to the point where a limit asks for most."""
_MOST_CLIMBED = 16
"""Points in intervals from which such steps are taken."""
_AT_ONCE = 2**10
"""Points at which ends are sought together, as each takes some kB."""
_FIRST_STEP = 0.25
"""First step in an interval, as a share of half its width."""
_LAST_STEP = 1e-4
"""Last step in an interval: the error of an end goes with the square of this."""


def tighten(conditions: ConditionArcs, ends: Ends, broken: Cells) -> Ends:
    """Return ends of one choice, tightened around the states that break a limit.

    Args:
        conditions: Conditions of the choice.
        ends: Ends over all angles, (1, conditions), as F0.
        broken: Cells in whose middle a limit is not kept.
    """
    ends = Ends(**{name: values.copy() for name, values in vars(ends).items()})
    question = conditions.question
    angles = question.angles.ravel()
    middle = broken.middle
    direction = (broken.flexion[:, np.newaxis] == question.flexion.ravel()).argmax(axis=1)
    nearest = np.abs(middle[:, :1] - angles).argmin(axis=1)
    state = direction * len(angles) + nearest
    sides = (
        (False, ends.low, ends.low_state, ends.low_angle),
        (True, ends.high, ends.high_state, ends.high_angle),
    )
    for upper, value, binding_state, binding_angle in sides:
        which = np.flatnonzero(broken.upper == upper)
        # The first of several cells stands for those that differ only within intervals.
        kinds = np.stack([broken.row[which], state[which]])
        which = which[np.unique(kinds, axis=1, return_index=True)[1]]
        if not len(which):
            continue
        search = _Search(conditions, upper=upper)
        rows, tightest = search.tightest_ends(broken.row[which], middle[which], state[which])
        for row, end, end_state, end_angle in zip(rows, *tightest, strict=True):
            before = value[0, row]
            is_tighter = end < before if upper else end > before
            if is_tighter:
                value[0, row] = end
                binding_state[0, row] = end_state
                binding_angle[0, row] = end_angle
    return ends


@dataclass(frozen=True)
class _Search:
    """Search for the tightest lower or upper ends of windows."""

    conditions: ConditionArcs
    upper: bool
    """True for upper ends."""

    @property
    def sign(self) -> float:
        """Factor on an end, by which a larger product is tighter."""
        return -1.0 if self.upper else 1.0

    def ends_at(
        self, row: Rows, places: Array, state: Rows, start: Array | None = None
    ) -> list[Any]:
        """Return ends (N, as F0), states and angles (rad) at points of intervals.

        Args:
            row: Row of the condition of each.
            places: Place of each in the box, and its posture, (points, numbers + 1).
            state: Nearest state of each.
            start: Angle to begin from, rad; see `refine_ends`.
        """
        question = self.conditions.question
        unbounded = np.full(len(state), -self.sign * np.inf)
        return list(
            refine_ends(
                self.conditions.design(row, places[:, :-1], places[:, -1]),
                state,
                unbounded,
                question.angles.ravel(),
                question.flexion,
                question.bounds,
                upper=self.upper,
                start=start,
            )
        )

    def ends_near(self, row: Rows, points: Array, state: Rows) -> list[Any]:
        """Return the tighter of the ends sought from states and from the angles of points."""
        from_states = self.ends_at(row, points[:, 1:], state)
        from_points = self.ends_at(row, points[:, 1:], state, points[:, 0])
        is_tighter = self.sign * from_points[0] > self.sign * from_states[0]
        return [
            np.where(is_tighter, new, old)
            for new, old in zip(from_points, from_states, strict=True)
        ]

    def tightest_ends(self, row: Rows, points: Array, state: Rows) -> tuple[Rows, list[Any]]:
        """Seek the tightest ends near points at which a limit is broken.

        Args:
            row: Row of the condition of each point.
            points: An angle, rad, a place in the box, and a posture, rad, for each.
            state: Nearest state of each.

        Returns:
            The conditions, and for each the end (N, as F0), its state and its angle (rad). If there
            are intervals, only the tightest ends are returned.
        """
        parts = []
        for start in range(0, len(row), _AT_ONCE):
            part = slice(start, start + _AT_ONCE)
            parts.append(self.ends_near(row[part], points[part], state[part]))
        best = [np.concatenate(values) for values in zip(*parts, strict=True)]
        question = self.conditions.question
        least = np.full(len(question.box) + 1, -1.0)
        most = np.full(len(question.box) + 1, 1.0)
        least[-1], most[-1] = self.conditions.postures
        is_interval = least < most
        if not is_interval.any():
            return row, best

        # Climb in the intervals from the tightest ends: each step tries both directions of all.
        tightest_first = np.argsort(-self.sign * best[0])[:_MOST_CLIMBED]
        row = row[tightest_first]
        places = points[tightest_first, 1:]
        best = [values[tightest_first] for values in best]
        step = _FIRST_STEP
        forward = np.diag(0.5 * (most - least))[is_interval]
        directions = np.concatenate([forward, -forward])
        starts = np.arange(len(row))
        tried = np.repeat(starts, len(directions))
        for _ in range(_CLIMBS):
            moves = step * np.tile(directions, (len(row), 1))
            around = np.clip(places[tried] + moves, least, most)
            tightest = self.ends_at(row[tried], around, best[1][tried])
            of_starts = (self.sign * tightest[0]).reshape(len(row), -1)
            top = of_starts.argmax(axis=1) + starts * len(directions)
            is_tighter = self.sign * tightest[0][top] > self.sign * best[0]
            places = np.where(is_tighter[:, np.newaxis], around[top], places)
            best = [
                np.where(is_tighter, new[top], old) for new, old in zip(tightest, best, strict=True)
            ]
            if not is_tighter.any():
                step *= 0.5
                if step < _LAST_STEP:
                    break
        return row, best
