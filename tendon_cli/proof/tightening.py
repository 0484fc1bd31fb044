"""Ends of windows that are tightened around states at which a proof finds a limit broken."""

from __future__ import annotations

from typing import Any

import numpy as np

from tendon_cli.model.kinematics import Array, Rows
from tendon_cli.model.whole_motion import refine_ends
from tendon_cli.model.window import Ends
from tendon_cli.proof.arcs import ConditionArcs
from tendon_cli.proof.subdivision import Cells
from tendon_cli.windows.question import Question

_CLIMBS = 60
"""Steps in a box to the point where a limit asks for most."""
_MOST_CLIMBED = 16
"""Points in the box from which such steps are taken."""
_FIRST_STEP = 0.25
"""First step in the box, as a share of half its width."""
_LAST_STEP = 1e-4
"""Last step in the box: the error of an end goes with the square of this."""


def tighten(question: Question, ends: Ends, broken: Cells, postures: ConditionArcs) -> Ends:
    """Return ends of one choice, tightened around the states that break a limit.

    Args:
        question: The question.
        ends: Ends over all angles, (1, conditions), as F0.
        broken: Cells in whose middle a limit is not kept; their rows are places in `postures`.
        postures: Conditions in single postures.
    """
    ends = Ends(**{name: values.copy() for name, values in vars(ends).items()})
    angles = question.angles.ravel()
    middle = broken.middle  # (cells, 1 + numbers): angle, rad, and place in the box
    direction = (broken.flexion[:, np.newaxis] == question.flexion.ravel()).argmax(axis=1)
    nearest = np.abs(middle[:, :1] - angles).argmin(axis=1)
    state = direction * len(angles) + nearest
    sides = (
        (False, ends.low, ends.low_state, ends.low_angle),
        (True, ends.high, ends.high_state, ends.high_angle),
    )
    for upper, value, binding_state, binding_angle in sides:
        which = np.flatnonzero(broken.upper == upper)
        # The first of several cells stands for those that differ only within the box.
        kinds = np.stack([broken.row[which], state[which]])
        which = which[np.unique(kinds, axis=1, return_index=True)[1]]
        if not len(which):
            continue
        selected = postures.select(broken.row[which])
        conditions, tightest = _tightest_ends(selected, middle[which], state[which], upper=upper)
        for condition, end, end_state, end_angle in zip(conditions, *tightest, strict=True):
            before = value[0, condition]
            is_tighter = end < before if upper else end > before
            if is_tighter:
                value[0, condition] = end
                binding_state[0, condition] = end_state
                binding_angle[0, condition] = end_angle
    return ends


def _tightest_ends(
    postures: ConditionArcs, points: Array, state: Rows, *, upper: bool
) -> tuple[Rows, list[Any]]:
    """Seek the tightest ends near points at which a limit is broken.

    Args:
        postures: Conditions in single postures.
        points: An angle, rad, and a place in the box for each, (postures, 1 + numbers).
        state: Nearest state of each.
        upper: True for upper ends.

    Returns:
        The conditions, and for each the end (N, as F0), its state and its angle (rad). If there
        is a box, only the tightest ends are returned.
    """
    question = postures.question
    box = question.box
    sign = -1.0 if upper else 1.0
    shares = points[:, 1:]

    def ends_at(
        selected: ConditionArcs, shares: Array, state: Rows, start: Array | None = None
    ) -> list[Any]:
        """Return ends (N), states and angles (rad) at points of the box."""
        unbounded = np.full(len(state), -sign * np.inf)
        return list(
            refine_ends(
                selected.design(shares),
                state,
                unbounded,
                question.angles.ravel(),
                question.flexion,
                question.bounds,
                upper=upper,
                start=start,
            )
        )

    from_states = ends_at(postures, shares, state)
    from_points = ends_at(postures, shares, state, points[:, 0])
    is_tighter = sign * from_points[0] > sign * from_states[0]
    best = [
        np.where(is_tighter, new, old) for new, old in zip(from_points, from_states, strict=True)
    ]
    if not box:
        return postures.row, best

    # Climb in the box from the tightest ends: each step tries both directions of every number.
    tightest_first = np.argsort(-sign * best[0])[:_MOST_CLIMBED]
    postures = postures.select(tightest_first)
    shares = shares[tightest_first]
    best = [values[tightest_first] for values in best]
    step = _FIRST_STEP
    directions = np.concatenate([np.eye(len(box)), -np.eye(len(box))])
    starts = np.arange(len(postures))
    tried = np.repeat(starts, len(directions))
    for _ in range(_CLIMBS):
        moves = step * np.tile(directions, (len(postures), 1))
        points = np.clip(shares[tried] + moves, -1.0, 1.0)
        tightest = ends_at(postures.select(tried), points, best[1][tried])
        of_starts = (sign * tightest[0]).reshape(len(postures), -1)
        top = of_starts.argmax(axis=1) + starts * len(directions)
        is_tighter = sign * tightest[0][top] > sign * best[0]
        shares = np.where(is_tighter[:, np.newaxis], points[top], shares)
        best = [
            np.where(is_tighter, new[top], old) for new, old in zip(tightest, best, strict=True)
        ]
        if not is_tighter.any():
            step *= 0.5
            if step < _LAST_STEP:
                break
    return postures.row, best
