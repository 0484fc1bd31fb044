"""Several suits instead of one: which few, each at its pretension, serve the largest share of people.

A suit at a pretension serves the persons whose window holds it. Along the line of pretensions only the largest such
sets matter: those between an end at which a window begins and the next one, at which a window ends. Which few of these
together serve most is a problem of maximal coverage, solved exactly as a mixed-integer linear program.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.answers.coverage import ROUNDING, normalised
from tendon_cli.model.kinematics import Array


@dataclass(frozen=True)
class Sizes:
    """The suits that together serve most."""

    choices: tuple[int, ...]
    """Rows of the windows, ascending."""
    pretensions: tuple[float, ...]
    """One for each suit, N: the middle of those at which it serves the same persons."""
    share: float
    """Of the weighting."""


@dataclass(frozen=True, eq=False)
class _Sets:
    """Sets of persons that one suit serves at one pretension."""

    choice: npt.NDArray[np.int64]
    pretension: Array
    serves: npt.NDArray[np.bool_]
    """Whether each person is served, (sets, persons)."""


def best_sizes(
    low: Array, high: Array, weighting: Array, most: int, heed: Callable[[], None] = lambda: None
) -> tuple[Sizes, ...]:
    """With one suit, two and so on to `most` those that serve the largest share; further ones only if they serve more.

    `low` and `high` are the ends of the windows, N, of shape (choices, persons), empty where low > high or NaN.
    `heed` is called before each search, and may raise to end it.
    """
    sets, weights = _largest_sets(low, high), normalised(weighting)
    best = [Sizes((), (), 0.0)]
    for count in range(1, most + 1):
        heed()
        chosen = _needed(sets.serves, weights, _covering(sets.serves, weights, count) if len(sets.choice) else [])
        chosen.sort(key=lambda at: (sets.choice[at], sets.pretension[at]))
        choices = tuple(int(sets.choice[at]) for at in chosen)
        pretensions = tuple(float(sets.pretension[at]) for at in chosen)
        sizes = Sizes(choices, pretensions, _share(sets.serves[chosen], weights))
        best.append(sizes if sizes.share > best[-1].share + ROUNDING else best[-1])
    return tuple(best[1:])


def _share(serves: npt.NDArray[np.bool_], weights: Array) -> float:
    """The weight of those whom any set serves; exactly 1 if that is everyone."""
    served = serves.any(axis=0)
    return 1.0 if served.all() else float(min(weights[served].sum(), 1.0))


def _largest_sets(low: Array, high: Array) -> _Sets:
    """For each choice the sets of persons that no other pretension serves together with more."""
    choices, pretensions, serves = [], [], [np.empty((0, low.shape[1]), dtype=np.bool_)]
    for choice, (starts, stops) in enumerate(zip(low, high, strict=True)):
        is_open = starts <= stops
        ends = np.concatenate([starts[is_open], stops[is_open]])
        order = np.argsort(ends, kind="stable")  # at one pretension windows begin before others end
        begins = order < is_open.sum()
        last = np.flatnonzero(begins[:-1] & ~begins[1:])
        begin, end = ends[order[last]], ends[order[last + 1]]
        serves.append((starts <= begin[:, np.newaxis]) & (begin[:, np.newaxis] <= stops))
        choices += [choice] * len(last)
        pretensions.append(np.where(np.isinf(end), begin, (begin + end) / 2.0))
    return _Sets(np.array(choices, dtype=np.int64), np.concatenate([np.empty(0), *pretensions]), np.concatenate(serves))


def _covering(serves: npt.NDArray[np.bool_], weights: Array, most: int) -> list[int]:
    """The at most `most` sets whose union weighs most: chosen sets are 1, a person is served by a chosen set or not."""
    if most == 1:
        return [int(np.argmax(serves @ weights))]
    from scipy.optimize import Bounds, LinearConstraint, milp
    from scipy.sparse import csr_array, eye_array, hstack

    kinds, kind_of = np.unique(serves, axis=1, return_inverse=True)  # persons whom the same sets serve are one
    weight = np.bincount(kind_of.ravel(), weights=weights, minlength=kinds.shape[1])
    sets, persons = kinds.shape
    # person <= sum of the chosen sets that serve him; the sets chosen are at most `most`.
    covered = hstack([csr_array(-kinds.T.astype(np.float64)), eye_array(persons)])
    chosen = np.concatenate([np.ones(sets), np.zeros(persons)])[np.newaxis]
    solved = milp(
        np.concatenate([np.zeros(sets), -weight]),
        integrality=np.concatenate([np.ones(sets), np.zeros(persons)]),
        bounds=Bounds(0.0, 1.0),
        constraints=[LinearConstraint(covered, ub=0.0), LinearConstraint(chosen, ub=float(most))],
        options={"mip_rel_gap": 0.0},
    )
    return np.flatnonzero(np.asarray(solved.x)[:sets] > 0.5).tolist()


def _needed(serves: npt.NDArray[np.bool_], weights: Array, chosen: list[int]) -> list[int]:
    """The chosen sets without those that serve nobody whom the others do not."""
    for at in sorted(chosen, key=lambda at: float(serves[at] @ weights)):
        others = [other for other in chosen if other != at]
        if not (serves[at] & ~serves[others].any(axis=0)).any():
            chosen = others
    return chosen
