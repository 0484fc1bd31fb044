"""Scope of a proof: the values of angles, loads and intervals for which a window is proved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np

from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.space.axis import Axis
from tendon_cli.windows.question import LOADS, Question

Range = tuple[float, float]
"""Least and largest value, SI."""


@dataclass(frozen=True)
class Scope:
    """Values between which a window is proved, the ends included."""

    angles: Range
    """First and last elbow angle, rad."""
    ranges: Mapping[str, Range]
    """Ranges of loads and of intervals by their dotted keys."""
    served: str | None
    """Noun of the conditions for which it is proved as far as they are served; None if a window
    serves all of them, or all of each person or draw that it serves."""

    @classmethod
    def of(cls, question: Question, low: Array, high: Array) -> Self:
        """Return the scope of a proof.

        A limit is linear in pretension and load together. A window that suits two loads therefore
        suits all loads between them, whether or not it suits others.

        Args:
            question: The question.
            low: Lower ends of what was proved of the window under each condition, (conditions,), N.
            high: Upper ends; below `low` under a condition that need not be served.
        """
        ranged = [
            (place, axis)
            for place, axis in enumerate(question.conditions.axes)
            if (axis.key in LOADS or axis.is_interval) and len(axis) > 1
        ]
        ranges = {}
        noun = None
        if question.counts_conditions:
            noun = question.groups.noun
            shape = tuple(len(axis) for axis in question.conditions.axes)
            is_open = low <= high
            is_whole = is_open & (low <= low[is_open].min(initial=np.inf))
            is_whole &= high >= high[is_open].max(initial=-np.inf)
            for place, axis in ranged:
                is_served = np.moveaxis(is_open.reshape(shape), place, -1)
                is_always_served = np.moveaxis(is_whole.reshape(shape), place, -1)
                served = _served_range(axis, is_served, is_always_served)
                if served is not None:
                    ranges[axis.key] = served
        else:
            ranges = {axis.key: _range(axis.values) for _, axis in ranged}
        return cls(_range(question.angles), ranges, noun)


def _range(values: Array) -> Range:
    """Return the least and the largest of values."""
    return float(values.min()), float(values.max())


def _served_range(axis: Axis, is_served: Flags, is_always_served: Flags) -> Range | None:
    """Return the widest range of loads that a whole window suits wherever it serves any load.

    Args:
        axis: The loads.
        is_served: True where part of the window serves a condition, (..., loads).
        is_always_served: True where all of the window does.

    Returns:
        The range; None if it would be a single load or none.
    """
    of_served = is_always_served[is_served.any(axis=-1)].reshape(-1, len(axis))
    loads = axis.values
    least = np.where(of_served, loads, np.inf).min(axis=1).max(initial=-np.inf)
    largest = np.where(of_served, loads, -np.inf).max(axis=1).min(initial=np.inf)
    has_range = len(of_served) > 0 and least < largest
    return (float(least), float(largest)) if has_range else None
