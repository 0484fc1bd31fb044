"""Which choices are best: by one goal, or by several a front of those that no other beats in every goal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tendon_cli.model.kinematics import Array
from tendon_cli.space.axis import Rows
from tendon_cli.studies.study import Study

_AT_ONCE = 2**11


@dataclass(frozen=True)
class Goal:
    """A column of the choices that is to be as small, or as large, as can be."""

    column: str
    maximise: bool

    def score(self, values: Array) -> Array:
        """The larger the better; a torque counts by its magnitude, and what is null is worst."""
        sized = np.abs(values) if self.column == "peak_motor_torque" else np.asarray(values, dtype=np.float64)
        return np.where(np.isnan(sized), -np.inf, sized if self.maximise else -sized)


USUAL = (
    Goal("tolerance", maximise=True),
    Goal("pretension", maximise=False),
    Goal("max_tension", maximise=False),
    Goal("max_spring_extension", maximise=False),
    Goal("peak_motor_torque", maximise=False),
)
"""Where a study names no goal, the best by each of these."""
SERVED = Goal("served", maximise=True)
"""Before them where there are people or draws: the most universal choice."""


def goals_of(study: Study) -> tuple[Goal, ...]:
    """The goals of a study, in its order; none where it leaves them open."""
    least = tuple(Goal(column, maximise=False) for column in study.design.minimise)
    return (*least, *(Goal(column, maximise=True) for column in study.design.maximise))


def best(scores: Array, tolerance: Array) -> int:
    """The row of the largest scores, (rows,); of equals the one of the largest tolerance, then the first."""
    return int(np.lexsort((-tolerance, -scores))[0])


def front(scores: Array) -> Rows:
    """Rows, ascending, that no other row beats: is as good in every goal and better in one. `scores` is (rows, goals).

    Of rows that are equal in every goal the first stands for all.
    """
    _, first = np.unique(scores, axis=0, return_index=True)
    order = first[np.lexsort(scores[first].T)[::-1]]  # no row is beaten by one that comes after it
    kept = np.empty(0, dtype=np.int64)
    for at in range(0, len(order), _AT_ONCE):
        some = order[at : at + _AT_ONCE]
        some = some[~_beaten(scores[some], scores[kept])]
        kept = np.append(kept, some[~_beaten(scores[some], scores[some])])
    return np.sort(kept)


def _beaten(scores: Array, others: Array) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Which rows are beaten by any of the others."""
    beaten = np.zeros(len(scores), dtype=np.bool_)
    for other in others:
        beaten |= np.all(other >= scores, axis=1) & np.any(other > scores, axis=1)
    return beaten


def losses(scores: Array) -> Array:
    """What each row of a front gives up of each goal, as a share of what the front spans: 0 is best, 1 worst."""
    span = np.ptp(scores, axis=0)
    return np.asarray((scores.max(axis=0) - scores) / np.where(span > 0.0, span, 1.0))


def compromise(scores: Array) -> int:
    """The row of a front, (rows, goals), that gives up the least of the goal of which it gives up most."""
    given_up = losses(scores)
    return int(np.lexsort((given_up.sum(axis=1), given_up.max(axis=1)))[0])
