"""Shares of people or draws that a pretension serves, and how sure they are. Pure; pretensions in N."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from tendon_cli.model.kinematics import Array

_TWO_SIDED_95 = 1.959963984540054


@dataclass(frozen=True, eq=False)
class Curve:
    """The share that is served over pretension: constant between ends of windows, which belong to the windows."""

    pretension: Array
    """Every end of a window, ascending, each twice, N."""
    share: Array
    """First at that end, then between it and the next."""
    low: Array
    """The 95 % interval of each share."""
    high: Array

    @property
    def best(self) -> float:
        """The middle of the first stretch of pretension that serves most, N."""
        is_most = self.share >= self.share.max() - 1e-12
        first = int(np.argmax(is_most))
        after = first + int(np.argmin(np.append(is_most[first:], False)))
        return float(self.pretension[first] + self.pretension[min(after, len(self.pretension) - 1)]) / 2.0


def effective_count(weighting: Array) -> float:
    """How many persons of equal weighting say as much: (Σw)² / Σw² (Kish)."""
    return float(np.sum(weighting) ** 2 / np.sum(np.square(weighting)))


def standard_error(share: Array | float, weighting: Array) -> Array:
    """Standard error of a weighted share of a sample.

    Two served and two not are added to those counted (Agresti and Coull 1998), so that all or none of a sample is not
    said to be certain: of 1000 persons who are all served, the share has a standard error of 0.0014.
    """
    centre, count = _centre(np.asarray(share), weighting)
    return np.sqrt(centre * (1.0 - centre) / count)


def interval(share: Array | float, weighting: Array) -> tuple[Array, Array]:
    """The 95 % interval of a share, between 0 and 1."""
    centre, _ = _centre(np.asarray(share), weighting)
    reach = _TWO_SIDED_95 * standard_error(share, weighting)
    return np.maximum(centre - reach, 0.0), np.minimum(centre + reach, 1.0)


def _centre(share: Array, weighting: Array) -> tuple[Array, float]:
    count = effective_count(weighting)
    return (share * count + 2.0) / (count + 4.0), count + 4.0


def share_at(pretension: Array | float, low: Array, high: Array, weighting: Array) -> Array:
    """The share of windows, from `low` to `high`, that hold each pretension; a window may be empty or NaN."""
    is_open = low <= high
    starts, ends, counts = low[is_open], high[is_open], weighting[is_open]
    begun = _summed(np.asarray(pretension), starts, counts, "right")
    over = _summed(np.asarray(pretension), ends, counts, "left")
    return np.clip((begun - over) / np.sum(weighting), 0.0, 1.0)


def _summed(at: Array, ends: Array, weighting: Array, side: Literal["left", "right"]) -> Array:
    """The weighting of ends up to some places, those at the place itself included on the right."""
    order = np.argsort(ends, kind="stable")
    sums = np.concatenate([[0.0], np.cumsum(weighting[order])])
    return np.asarray(sums[np.searchsorted(ends[order], at, side=side)])


def curve(low: Array, high: Array, weighting: Array) -> Curve:
    """The share served over all pretensions from the first window's beginning to the last one's end."""
    is_open = low <= high
    ends = np.unique(np.concatenate([low[is_open], high[is_open]]))
    ends = ends[np.isfinite(ends)]
    between = np.append((ends[:-1] + ends[1:]) / 2.0, np.nextafter(ends[-1:], np.inf))
    shares = [share_at(place, low, high, weighting) for place in (ends, between)]
    share = np.column_stack(shares).ravel()
    return Curve(np.repeat(ends, 2), share, *interval(share, weighting))
