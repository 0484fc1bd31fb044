"""Rows of a log: the types of their columns, their noise, and rows that no sensor saw."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from tendon_cli.model.design import map_arrays

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]

SAME_READING = 1e-9
"""Difference of two readings, as a share of the largest, up to which they are one."""
_SPIKE_MEDIANS = 10.0
"""Median deviations that a spike exceeds."""
_SPIKE_NOISE = 6.0
"""Standard deviations of noise that a spike exceeds: one row in 1e9 does so by chance."""
_SPIKE_WINDOW = 7
"""Rows of the median that spikes are compared with: it passes over up to three bad rows in
succession."""
_MOST_SPIKES = 0.2
"""Share of the rows from which seeming spikes are the corners of steep strokes."""


@dataclass(frozen=True, eq=False)
class LogRows:
    """Rows of a log: a field that is an array, or a mapping of arrays, has a value per row."""

    def select(self, rows: Mask | Integers | slice) -> Self:
        """Select rows by mask, index or slice."""
        selected: Self = map_arrays(self, lambda column: column[rows])
        return selected


def means_by(group: Integers, values: Floats) -> Floats:
    """Return the mean of the values of each group 0, 1, ..."""
    return np.bincount(group, values) / np.bincount(group)


def noise_of(values: Floats, side: Integers | None = None) -> float:
    """Return the standard deviation of a row about its neighbours.

    It comes from second differences, in which a steady change cancels. `side` divides the rows into
    strokes: differences across its changes are left out.
    """
    deviations = np.abs(np.diff(values, 2)) / np.sqrt(6.0)
    if side is not None and len(side) > 2:
        deviations = deviations[(side[2:] == side[1:-1]) & (side[1:-1] == side[:-2])]
    if not len(deviations):
        return 0.0
    noise = 1.4826 * float(np.median(deviations))
    # A steady change cancels up to the last binary digit.
    if noise > SAME_READING * np.max(np.abs(values)):
        return noise
    # Most differences of a coarse cell are zero, and a mean without the largest tenth still sees
    # its steps.
    smallest = np.sort(deviations)[: max(1, int(0.9 * len(deviations)))]
    return 1.3 * float(np.sqrt(np.mean(smallest**2)))


def spikes(values: Floats, least: float) -> Mask:
    """Select the rows far from the median of their neighbours, by more than `least`."""
    from scipy.ndimage import median_filter

    away = np.abs(values - median_filter(values, _SPIKE_WINDOW, mode="nearest"))
    by_noise = max(_SPIKE_MEDIANS * np.median(away), _SPIKE_NOISE * noise_of(values))
    found = away > max(by_noise, least)
    return np.asarray(found & (np.mean(found) < _MOST_SPIKES))
