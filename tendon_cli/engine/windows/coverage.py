"""The share of persons, draws or conditions that one pretension serves, and the few best suits.

The share changes only where a window begins or ends, so that everything follows from the sorted
ends. Windows are closed: two that only touch share one pretension. For the best few suits only the
largest sets of persons matter that a suit serves at one pretension. Each is found where a window
begins and the next end is one at which a window ends. To choose the few sets that together serve
most is a problem of maximal coverage.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from tendon_cli import say
from tendon_cli.model.kinematics import Array, Flags

ROUNDING = 1e-12
"""Relative difference of shares or pretensions that are equal but for rounding."""


@dataclass(frozen=True, eq=False)
class Coverage:
    """Windows and shares that one pretension can serve, for each choice, (choices,)."""

    low: Array
    """Lower end of the widest interval that serves enough, N; NaN if no pretension does."""
    high: Array
    """Upper end, N; infinite if nothing bounds it."""
    windows: npt.NDArray[np.int64]
    """Number of intervals that serve enough."""
    served: Array
    """Largest share that one pretension serves."""
    best_low: Array
    """Lower end of the widest interval that serves this share, N; NaN if none serves any."""
    best_high: Array
    """Upper end, N."""


def share_served(low: Array, high: Array, weighting: Array, *, serve: float = 1.0) -> Coverage:
    """Return the windows and shares of groups that one pretension can serve.

    Args:
        low: Lower ends of the windows, (choices, groups), N. A window is empty where low > high, or
            where an end is NaN.
        high: Upper ends.
        weighting: Weights of the groups, (groups,).
        serve: Share of the weighting that one pretension must serve.
    """
    is_open = low <= high
    weight = np.where(is_open, normalise(weighting), 0.0)
    starts = np.where(is_open, low, np.inf)
    stops = np.where(is_open, high, np.inf)
    ends = np.concatenate([starts, stops], axis=1)
    # A stable sort leaves starts before stops at the same pretension: windows that touch overlap
    # there.
    order = np.argsort(ends, axis=1, kind="stable")
    sorted_ends = np.take_along_axis(ends, order, axis=1)
    changes = np.take_along_axis(np.concatenate([weight, -weight], axis=1), order, axis=1)
    share = np.cumsum(changes, axis=1)
    served = np.max(share, axis=1)
    served = np.where(served > 1.0 - ROUNDING, 1.0, np.maximum(served, 0.0))
    served = np.where(is_open.any(axis=1), served, 0.0)
    is_most = share >= np.maximum(served, ROUNDING)[:, np.newaxis] - ROUNDING / 2
    best_low, best_high, _ = _widest(sorted_ends, is_most)
    is_enough = share >= max(serve, ROUNDING) - ROUNDING / 2
    widest_low, widest_high, windows = _widest(sorted_ends, is_enough)
    return Coverage(widest_low, widest_high, windows, served, best_low, best_high)


def _widest(ends: Array, is_enough: Flags) -> tuple[Array, Array, npt.NDArray[np.int64]]:
    """Find the widest run of ends after which the share is enough.

    Args:
        ends: Sorted ends of windows, (choices, ends), N.
        is_enough: True where the share after an end is enough.

    Returns:
        First end of the run and the end after it, (choices,) N, NaN if there is no run; and the
        number of runs.
    """
    places = np.arange(ends.shape[1])
    is_enough_before = np.zeros_like(is_enough)
    is_enough_before[:, 1:] = is_enough[:, :-1]
    begins = is_enough & ~is_enough_before
    stops = is_enough_before & ~is_enough
    began = np.maximum.accumulate(np.where(begins, places, 0), axis=1)
    start = np.take_along_axis(ends, began, axis=1)
    with np.errstate(invalid="ignore"):
        width = np.where(stops, ends - start, -1.0)
    widest = np.argmax(width, axis=1)[:, np.newaxis]
    low = np.take_along_axis(start, widest, axis=1)[:, 0]
    high = np.take_along_axis(ends, widest, axis=1)[:, 0]
    has_run = stops.any(axis=1)
    return np.where(has_run, low, np.nan), np.where(has_run, high, np.nan), np.sum(stops, axis=1)


def serves(low: Array, high: Array, pretension: Array | float) -> Flags:
    """Return True where pretensions lie in windows, apart from rounding."""
    with np.errstate(invalid="ignore"):
        is_above_low = low <= pretension * (1 + ROUNDING)
        is_below_high = pretension <= high * (1 + ROUNDING)
    return np.asarray(is_above_low & is_below_high)


def normalise(weighting: Array) -> Array:
    """Return weights that add up to 1, whatever their size."""
    scaled = weighting / np.max(weighting)
    return np.asarray(scaled / np.sum(scaled))


WORST_SHARE = 0.95
"""Share of the persons or draws served that no worst value told exceeds."""


def upper_quantile(values: Array, weighting: Array) -> Array:
    """Return the smallest value that `WORST_SHARE` of the known values do not exceed, (...).

    Args:
        values: Values of groups, (..., groups); -infinity where one is unknown.
        weighting: Weights of the groups, (groups,).
    """
    if np.ptp(weighting) == 0.0:
        in_order = np.sort(values, axis=-1)
        known = np.sum(~np.isneginf(values), axis=-1)
        above = np.floor((1.0 - WORST_SHARE) * known + ROUNDING).astype(np.int64)
        place = values.shape[-1] - 1 - above
        return np.take_along_axis(in_order, place[..., np.newaxis], axis=-1)[..., 0]
    order = np.argsort(-values, axis=-1, kind="stable")
    in_order = np.take_along_axis(values, order, axis=-1)
    weights = np.where(np.isneginf(in_order), 0.0, weighting[order])
    above = np.cumsum(weights, axis=-1) - weights
    of_all = weights.sum(axis=-1, keepdims=True)
    is_left = above <= (1.0 - WORST_SHARE) * of_all * (1.0 + ROUNDING)
    place = np.sum(is_left, axis=-1) - 1
    return np.take_along_axis(in_order, np.maximum(place, 0)[..., np.newaxis], axis=-1)[..., 0]


def effective_count(weighting: Array) -> float:
    """Return the number of equally weighted persons that tell as much: (Σw)² / Σw² (Kish)."""
    return float(1.0 / np.sum(np.square(normalise(weighting))))


def effective_count_of_strata(
    is_served: Flags, weighting: Array, strata: npt.NDArray[np.int64]
) -> float:
    """Return the size of a simple sample whose share would be known as well.

    It is p(1 − p) over the variance of the share p of a stratified sample, Σ W² q(1 − q)/n (Cochran
    1977, 5.2), with the weight W, the size n and the share q of each stratum; q has half a member
    more on either side, so that a stratum that is served as a whole is not taken as certain. It is
    at least the size by weights alone.

    Args:
        is_served: True for members that are served, (members,).
        weighting: Weights of the members, equal within a stratum.
        strata: Stratum of each member, from 0.
    """
    weights = normalise(weighting)
    size = np.bincount(strata)
    weight = np.bincount(strata, weights)
    share = (np.bincount(strata, is_served) + 0.5) / (size + 1.0)
    variance = float(np.sum(np.square(weight) * share * (1.0 - share) / size))
    of_all = float(weights @ is_served)
    return max(of_all * (1.0 - of_all) / variance, effective_count(weighting))


def share_at(pretension: Array | float, low: Array, high: Array, weighting: Array) -> Array:
    """Return the share of windows that contain each pretension.

    Args:
        pretension: Pretensions, N.
        low: Lower ends of the windows, (windows,), N; a window may be empty or NaN.
        high: Upper ends.
        weighting: Weights of the windows.
    """
    is_open = low <= high
    weights = normalise(weighting)[is_open]
    begun = _weight_up_to(np.asarray(pretension), low[is_open], weights, "right")
    ended = _weight_up_to(np.asarray(pretension), high[is_open], weights, "left")
    return np.clip(begun - ended, 0.0, 1.0)


def _weight_up_to(
    places: Array, ends: Array, weighting: Array, side: Literal["left", "right"]
) -> Array:
    """Sum the weights of ends below each place; with side "right" also of those at the place."""
    order = np.argsort(ends, kind="stable")
    sums = np.concatenate([[0.0], np.cumsum(weighting[order])])
    return np.asarray(sums[np.searchsorted(ends[order], places, side=side)])


@dataclass(frozen=True, eq=False)
class Curve:
    """The share that is served over pretension.

    It is constant between ends of windows, which belong to the windows.
    """

    pretension: Array
    """Ends of all windows, ascending, each twice, N."""
    share: Array
    """Share at that end, then between it and the next."""
    low: Array
    """Lower end of the 95 % interval of each share."""
    high: Array
    """Upper end of the 95 % interval."""

    @property
    def best(self) -> float:
        """Middle of the first stretch of pretension that serves most, N; NaN if none serves any."""
        if not len(self.share):
            return math.nan
        is_most = self.share >= self.share.max() - ROUNDING
        first = int(np.argmax(is_most))
        after = first + int(np.argmin(np.append(is_most[first:], False)))
        last = min(after, len(self.pretension) - 1)
        return float(self.pretension[first] + self.pretension[last]) / 2.0


def curve(low: Array, high: Array, weighting: Array) -> Curve:
    """Return the curve of the share served, from the lowest to the highest end of a window.

    Args:
        low: Lower ends of the windows, (windows,), N.
        high: Upper ends.
        weighting: Weights of the windows.
    """
    is_open = low <= high
    ends = np.unique(np.concatenate([low[is_open], high[is_open]]))
    ends = ends[np.isfinite(ends)]
    between = np.append((ends[:-1] + ends[1:]) / 2.0, np.nextafter(ends[-1:], np.inf))
    at_ends = share_at(ends, low, high, weighting)
    after_ends = share_at(between, low, high, weighting)
    share = np.column_stack([at_ends, after_ends]).ravel()
    count = effective_count(weighting)
    intervals = np.reshape([say.interval(value, count) for value in share.tolist()], (-1, 2))
    return Curve(np.repeat(ends, 2), share, intervals[:, 0], intervals[:, 1])


# --- A few suits ----------------------------------------------------------------------------------


class Sizes(NamedTuple):
    """The suits that together serve most."""

    choices: tuple[int, ...]
    """Choice of each suit, as a row of the windows, ascending."""
    pretensions: tuple[float, ...]
    """Pretension of each suit, N: the middle of those at which it serves the same persons."""
    share: float
    """Share of the weighting."""


def best_sizes(
    low: Array,
    high: Array,
    weighting: Array,
    most: int,
    check_stopped: Callable[[], None] = lambda: None,
) -> tuple[Sizes, ...]:
    """Return the suits that serve the largest share, with one suit, with two, and so on.

    If a further suit does not serve more, the suits before it are returned again.

    Args:
        low: Lower ends of the windows, (choices, persons), N. A window is empty where low > high,
            or where an end is NaN.
        high: Upper ends.
        weighting: Weights of the persons.
        most: Largest number of suits.
        check_stopped: Called before each search; it may raise to end it.
    """
    choice, pretension, is_served = _largest_sets(low, high)
    weights = normalise(weighting)
    best = [Sizes((), (), 0.0)]
    for count in range(1, most + 1):
        check_stopped()
        covering = _covering(is_served, weights, count) if len(choice) else []
        chosen = _without_idle(is_served, weights, covering)
        chosen.sort(key=lambda row: (choice[row], pretension[row]))
        served = is_served[chosen].any(axis=0)
        share = 1.0 if served.all() else float(min(weights[served].sum(), 1.0))
        sizes = Sizes(tuple(choice[chosen].tolist()), tuple(pretension[chosen].tolist()), share)
        best.append(sizes if share > best[-1].share + ROUNDING else best[-1])
    return tuple(best[1:])


def _largest_sets(low: Array, high: Array) -> tuple[npt.NDArray[np.int64], Array, Flags]:
    """Return the largest sets of persons that a choice serves at one pretension.

    Args:
        low: Lower ends of the windows, (choices, persons), N.
        high: Upper ends.

    Returns:
        Choice and pretension (N) of each set, (sets,), and its persons, (sets, persons). No other
        set of the same choice contains them.
    """
    choices = []
    pretensions = [np.empty(0)]
    is_served = [np.empty((0, low.shape[1]), dtype=np.bool_)]
    for choice, (starts, stops) in enumerate(zip(low, high, strict=True)):
        is_open = starts <= stops
        ends = np.concatenate([starts[is_open], stops[is_open]])
        order = np.argsort(ends, kind="stable")  # windows that touch overlap
        is_beginning = order < is_open.sum()
        last = np.flatnonzero(is_beginning[:-1] & ~is_beginning[1:])
        begin = ends[order[last]]
        end = ends[order[last + 1]]
        is_served.append((starts <= begin[:, np.newaxis]) & (begin[:, np.newaxis] <= stops))
        choices += [choice] * len(last)
        pretensions.append(np.where(np.isinf(end), begin, (begin + end) / 2.0))
    return np.array(choices, dtype=np.int64), np.concatenate(pretensions), np.concatenate(is_served)


def _covering(is_served: Flags, weights: Array, most: int) -> list[int]:
    """Choose at most `most` sets, (sets, persons), whose union weighs most.

    In the mixed-integer program a variable is 1 for a chosen set, and for a person whom a chosen
    set serves.
    """
    if most == 1:
        return [int(np.argmax(is_served @ weights))]
    from scipy.optimize import Bounds, LinearConstraint, milp
    from scipy.sparse import csr_array, eye_array, hstack

    # Persons whom the same sets serve count as one.
    kinds, kind_of = np.unique(is_served, axis=1, return_inverse=True)
    weight = np.bincount(kind_of.ravel(), weights=weights, minlength=kinds.shape[1])
    sets, persons = kinds.shape
    # A person counts at most as often as chosen sets serve them; at most `most` sets are chosen.
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


def _without_idle(is_served: Flags, weights: Array, chosen: list[int]) -> list[int]:
    """Return the chosen sets without those whose persons are all served by the others."""
    for row in sorted(chosen, key=lambda row: float(is_served[row] @ weights)):
        others = [other for other in chosen if other != row]
        if not (is_served[row] & ~is_served[others].any(axis=0)).any():
            chosen = others
    return chosen
