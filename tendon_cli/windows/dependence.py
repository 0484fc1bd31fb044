"""Numbers on which no window depends, found from the windows of all choices of the grid.

A window does not depend on a number if all choices that differ in it alone have the same window. A
part of the grid may hold some of these choices only, so that each part gives digests instead: for
each value of a number, the sum of pseudo-random integers, one for each choice with this value, that
follow from its window and its other numbers. The sums of all parts are the same for all values if no
window depends on the number; by chance they are so for one question in 10^19.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Array
from tendon_cli.windows.question import Question
from tendon_cli.windows.solutions import Solutions

MOST_VALUES = 1024
"""Most values of a number of which digests are kept."""
_EQUAL = 1e-9
"""Relative width of the steps to which ends of windows are rounded."""
_SMALLEST = 1e-6
"""End of a window below which steps are as wide as there, N."""
_OFFSET = 0.1234567
"""Offset of the steps, so that no common number lies at an edge."""

Digests = npt.NDArray[np.uint64]


def digests_of_windows(question: Question, choices: Solutions) -> dict[str, list[str]]:
    """Return the digests of a part by the keys of its axes, as hexadecimal text for JSON.

    Axes of one value, or of very many, are left out.
    """
    window = _mixed(_steps(choices.pretension_from) ^ _mixed(_steps(choices.pretension_to)))
    digests = {}
    stride = 1
    for axis in reversed(question.choices.axes):
        count = len(axis)
        if 1 < count <= MOST_VALUES:
            place = choices.row // stride % count
            others = (choices.row - place * stride).astype(np.uint64)
            sums = np.zeros(count, dtype=np.uint64)
            np.add.at(sums, place, _mixed(window ^ _mixed(others)))
            digests[axis.key] = [f"{value:x}" for value in sums.tolist()]
        stride *= count
    return digests


def without_effect(digests: Iterable[Mapping[str, list[str]]]) -> list[str]:
    """Return the keys on which no window depends, sorted.

    Args:
        digests: Digests of all parts of the grid.
    """
    sums: dict[str, Digests] = {}
    for of_part in digests:
        for key, texts in of_part.items():
            values = np.array([int(text, 16) for text in texts], dtype=np.uint64)
            sums[key] = sums[key] + values if key in sums else values
    return sorted(key for key, values in sums.items() if (values == values[0]).all())


def _steps(ends: Array) -> Digests:
    """Return ends of windows in steps of equal ratio, as integers; NaN and infinity have theirs."""
    scaled = np.sign(ends) * np.log1p(np.abs(ends) / _SMALLEST)
    finite = np.where(np.isfinite(scaled), scaled, 0.0)
    steps = np.floor(finite / _EQUAL + _OFFSET).astype(np.int64)
    steps = np.where(np.isnan(ends), np.iinfo(np.int64).max, steps)
    steps = np.where(np.isinf(ends), np.iinfo(np.int64).max - 1, steps)
    return np.asarray(steps.astype(np.int64).view(np.uint64))


def _mixed(values: Digests) -> Digests:
    """Return pseudo-random integers that follow from others (the finaliser of SplitMix64)."""
    with np.errstate(over="ignore"):
        mixed = values + np.uint64(0x9E3779B97F4A7C15)
        mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        return np.asarray(mixed ^ (mixed >> np.uint64(31)))
