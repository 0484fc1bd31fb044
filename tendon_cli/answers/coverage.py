"""Which share of conditions one pretension serves, exactly: by a sweep over the ends of the windows.

The share served changes only where a window begins or ends, so the pretensions that serve most, and those that serve
enough, are known from the sorted ends. Windows are closed: two that only touch share one pretension.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Array

Flags = npt.NDArray[np.bool_]

ROUNDING = 1e-12
"""Shares that are equal but for the rounding of sums."""


@dataclass(frozen=True, eq=False)
class Coverage:
    """What one pretension can serve, for each choice."""

    low: Array
    """Where the widest interval that serves enough begins, N; NaN where no pretension serves enough."""
    high: Array
    """And where it ends, N; infinite where nothing bounds it."""
    windows: npt.NDArray[np.int64]
    """How many such intervals there are."""
    served: Array
    """The largest share that one pretension serves."""
    best_low: Array
    """The widest interval of those pretensions, N; NaN where none serves any."""
    best_high: Array


def share_served(low: Array, high: Array, weighting: Array, *, enough: float = 1.0) -> Coverage:
    """Coverage of the windows of groups, (choices, groups), by their weighting, (groups,).

    A window is from `low` to `high` (N), empty where low > high or not a number. `enough` is a share of the weighting.
    """
    is_open = low <= high
    weight = np.where(is_open, weighting / np.sum(weighting), 0.0)
    ends = np.concatenate([np.where(is_open, low, np.inf), np.where(is_open, high, np.inf)], axis=1)
    # Beginnings stand before ends, and stay so where both are at one pretension: windows that touch overlap there.
    order = np.argsort(ends, axis=1, kind="stable")
    at = np.take_along_axis(ends, order, axis=1)
    share = np.cumsum(np.take_along_axis(np.concatenate([weight, -weight], axis=1), order, axis=1), axis=1)
    served = np.max(share, axis=1)
    served = np.where(served > 1.0 - ROUNDING, 1.0, np.maximum(served, 0.0))
    served = np.where(is_open.any(axis=1), served, 0.0)
    best_low, best_high, _ = _widest(at, share >= np.maximum(served, ROUNDING)[:, np.newaxis] - ROUNDING / 2)
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


def share_at(low: Array, high: Array, weighting: Array, pretension: Array) -> Array:
    """The share that each choice's pretension, (choices,), serves."""
    at = pretension[:, np.newaxis]
    with np.errstate(invalid="ignore"):
        held = (low <= at) & (at <= high)
    return np.asarray((held * weighting).sum(axis=1) / np.sum(weighting))
