"""Which share of persons, draws or conditions one pretension serves, and which few suits together serve most.

The share changes only where a window begins or ends, so all follows from the sorted ends. Windows are closed: two that
only touch share one pretension. Of each suit only the largest sets matter, those between an end at which a window
begins and the next one, at which a window ends; which few of these serve most is a problem of maximal coverage.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.model.kinematics import Array, Flags

ROUNDING = 1e-12  # shares that are equal but for the rounding of sums


@dataclass(frozen=True, eq=False)
class Coverage:
    """What one pretension can serve, for each choice."""

    low: Array  # where the widest interval that serves enough begins, N; NaN where no pretension serves enough
    high: Array  # and where it ends, N; infinite where nothing bounds it
    windows: npt.NDArray[np.int64]  # how many such intervals there are
    served: Array  # the largest share that one pretension serves
    best_low: Array  # the widest interval of those pretensions, N; NaN where none serves any
    best_high: Array


def share_served(low: Array, high: Array, weighting: Array, *, enough: float = 1.0) -> Coverage:
    """Coverage of the windows of groups, (choices, groups), by their weighting, (groups,).

    A window is from `low` to `high` (N), empty where low > high or not a number. `enough` is a share of the weighting.
    """
    is_open = low <= high
    weight = np.where(is_open, normalised(weighting), 0.0)
    ends = np.concatenate([np.where(is_open, low, np.inf), np.where(is_open, high, np.inf)], axis=1)
    # Beginnings stand before ends, and stay so where both are at one pretension: windows that touch overlap there.
    order = np.argsort(ends, axis=1, kind="stable")
    at = np.take_along_axis(ends, order, axis=1)
    share = np.cumsum(
        np.take_along_axis(np.concatenate([weight, -weight], axis=1), order, axis=1), axis=1
    )
    served = np.max(share, axis=1)
    served = np.where(served > 1.0 - ROUNDING, 1.0, np.maximum(served, 0.0))
    served = np.where(is_open.any(axis=1), served, 0.0)
    best_low, best_high, _ = _widest(
        at, share >= np.maximum(served, ROUNDING)[:, np.newaxis] - ROUNDING / 2
    )
    low, high, windows = _widest(at, share >= max(enough, ROUNDING) - ROUNDING / 2)
    return Coverage(low, high, windows, served, best_low, best_high)


def _widest(at: Array, enough: Flags) -> tuple[Array, Array, npt.NDArray[np.int64]]:
    """The widest run of ends after which the share is enough, with the end after it; and how many runs there are."""
    places = np.arange(at.shape[1])
    before = np.zeros_like(enough)
    before[:, 1:] = enough[:, :-1]
    began = np.maximum.accumulate(np.where(enough & ~before, places, 0), axis=1)
    stops = before & ~enough
    start = np.take_along_axis(at, began, axis=1)
    with np.errstate(invalid="ignore"):
        width = np.where(stops, at - start, -1.0)
    widest = np.argmax(width, axis=1)[:, np.newaxis]
    some = stops.any(axis=1)
    low, high = (np.take_along_axis(values, widest, axis=1)[:, 0] for values in (start, at))
    return np.where(some, low, np.nan), np.where(some, high, np.nan), np.sum(stops, axis=1)


def grouped(low: Array, high: Array, groups: npt.NDArray[np.int64]) -> tuple[Array, Array]:
    """The windows that serve every condition of a group, (choices, groups), from those of conditions.

    `groups` numbers the group of each condition, from 0 and ascending; not a number where one of its windows is none.
    """
    firsts = np.flatnonzero(np.diff(groups, prepend=-1))
    return np.maximum.reduceat(low, firsts, axis=1), np.minimum.reduceat(high, firsts, axis=1)


def serves(low: Array, high: Array, pretension: Array | float) -> Flags:
    """Whether pretensions are in windows, but for rounding."""
    with np.errstate(invalid="ignore"):
        return np.asarray(
            (low <= pretension * (1 + ROUNDING)) & (pretension <= high * (1 + ROUNDING))
        )


def normalised(weighting: Array) -> Array:
    """Weights that add up to 1, whatever their size."""
    scaled = weighting / np.max(weighting)
    return np.asarray(scaled / np.sum(scaled))


def effective_count(weighting: Array) -> float:
    """How many persons of equal weighting say as much: (Σw)² / Σw² (Kish)."""
    return float(1.0 / np.sum(np.square(normalised(weighting))))


def share_at(pretension: Array | float, low: Array, high: Array, weighting: Array) -> Array:
    """The share of windows, from `low` to `high`, that hold each pretension; a window may be empty or NaN."""
    is_open = low <= high
    starts, ends, weights = low[is_open], high[is_open], normalised(weighting)[is_open]
    begun = _summed(np.asarray(pretension), starts, weights, "right")
    over = _summed(np.asarray(pretension), ends, weights, "left")
    return np.clip(begun - over, 0.0, 1.0)


def _summed(at: Array, ends: Array, weighting: Array, side: Literal["left", "right"]) -> Array:
    """The weighting of ends up to some places, those at the place itself included on the right."""
    order = np.argsort(ends, kind="stable")
    sums = np.concatenate([[0.0], np.cumsum(weighting[order])])
    return np.asarray(sums[np.searchsorted(ends[order], at, side=side)])


@dataclass(frozen=True, eq=False)
class Curve:
    """The share that is served over pretension: constant between ends of windows, which belong to the windows."""

    pretension: Array  # every end of a window, ascending, each twice, N
    share: Array  # first at that end, then between it and the next
    low: Array  # the 95 % interval of each share
    high: Array

    @property
    def best(self) -> float:
        """The middle of the first stretch of pretension that serves most, N."""
        is_most = self.share >= self.share.max() - ROUNDING
        first = int(np.argmax(is_most))
        after = first + int(np.argmin(np.append(is_most[first:], False)))
        return (
            float(self.pretension[first] + self.pretension[min(after, len(self.pretension) - 1)])
            / 2.0
        )


def curve(low: Array, high: Array, weighting: Array) -> Curve:
    """The share served over all pretensions from the first window's beginning to the last one's end."""
    is_open = low <= high
    ends = np.unique(np.concatenate([low[is_open], high[is_open]]))
    ends = ends[np.isfinite(ends)]
    between = np.append((ends[:-1] + ends[1:]) / 2.0, np.nextafter(ends[-1:], np.inf))
    shares = [share_at(place, low, high, weighting) for place in (ends, between)]
    share, count = np.column_stack(shares).ravel(), effective_count(weighting)
    intervals = np.reshape([say.interval(each, count) for each in share.tolist()], (-1, 2))
    return Curve(np.repeat(ends, 2), share, intervals[:, 0], intervals[:, 1])


# --- A few suits -----------------------------------------------------------------------------------------------------


class Sizes(NamedTuple):
    """The suits that together serve most."""

    choices: tuple[int, ...]  # rows of the windows, ascending
    pretensions: tuple[
        float, ...
    ]  # one for each suit, N: the middle of those at which it serves the same persons
    share: float  # of the weighting


def best_sizes(
    low: Array,
    high: Array,
    weighting: Array,
    most: int,
    check_stopped: Callable[[], None] = lambda: None,
) -> tuple[Sizes, ...]:
    """With one suit, two and so on to `most` those that serve the largest share; further ones only if they serve more.

    `low` and `high` are the ends of the windows, N, of shape (choices, persons), empty where low > high or NaN.
    `check_stopped` is called before each search, and may raise to end it.
    """
    choice, pretension, serves = _largest_sets(low, high)
    weights, best = normalised(weighting), [Sizes((), (), 0.0)]
    for count in range(1, most + 1):
        check_stopped()
        chosen = _needed(serves, weights, _covering(serves, weights, count) if len(choice) else [])
        chosen.sort(key=lambda at: (choice[at], pretension[at]))
        served = serves[chosen].any(axis=0)
        share = 1.0 if served.all() else float(min(weights[served].sum(), 1.0))
        sizes = Sizes(tuple(choice[chosen].tolist()), tuple(pretension[chosen].tolist()), share)
        best.append(sizes if share > best[-1].share + ROUNDING else best[-1])
    return tuple(best[1:])


def _largest_sets(low: Array, high: Array) -> tuple[npt.NDArray[np.int64], Array, Flags]:
    """For each choice the pretensions whose set of persons served no other contains, and whom each serves."""
    choices, pretensions, serves = [], [np.empty(0)], [np.empty((0, low.shape[1]), dtype=np.bool_)]
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
    return np.array(choices, dtype=np.int64), np.concatenate(pretensions), np.concatenate(serves)


def _covering(serves: Flags, weights: Array, most: int) -> list[int]:
    """The at most `most` sets whose union weighs most: chosen sets are 1, a person is served by a chosen set or not."""
    if most == 1:
        return [int(np.argmax(serves @ weights))]
    from scipy.optimize import Bounds, LinearConstraint, milp
    from scipy.sparse import csr_array, eye_array, hstack

    kinds, kind_of = np.unique(
        serves, axis=1, return_inverse=True
    )  # persons whom the same sets serve are one
    weight = np.bincount(kind_of.ravel(), weights=weights, minlength=kinds.shape[1])
    sets, persons = kinds.shape
    # person <= sum of the chosen sets that serve him; the sets chosen are at most `most`.
    covered = hstack([csr_array(-kinds.T.astype(np.float64)), eye_array(persons)])
    chosen = np.concatenate([np.ones(sets), np.zeros(persons)])
    solved = milp(
        np.concatenate([np.zeros(sets), -weight]),
        integrality=chosen,
        bounds=Bounds(0.0, 1.0),
        constraints=[
            LinearConstraint(covered, ub=0.0),
            LinearConstraint(chosen[np.newaxis], ub=float(most)),
        ],
        options={"mip_rel_gap": 0.0},
    )
    return np.flatnonzero(np.asarray(solved.x)[:sets] > 0.5).tolist()


def _needed(serves: Flags, weights: Array, chosen: list[int]) -> list[int]:
    """The chosen sets without those that serve nobody whom the others do not."""
    for at in sorted(chosen, key=lambda at: float(serves[at] @ weights)):
        others = [other for other in chosen if other != at]
        if not (serves[at] & ~serves[others].any(axis=0)).any():
            chosen = others
    return chosen
