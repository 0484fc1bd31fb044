"""Scope of a proof: the values of angles, loads and intervals for which a window is proved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

from tendon_cli.engine.windows.question import LOADS, Question
from tendon_cli.model.kinematics import Array

Range = tuple[float, float]
"""Least and largest value, SI."""


@dataclass(frozen=True)
class Scope:
    """Values between which a window is proved, the ends included."""

    angles: Range
    """First and last elbow angle, rad."""
    ranges: Mapping[str, Range]
    """Ranges of loads and of intervals by their dotted keys."""

    @classmethod
    def of(cls, question: Question) -> Self:
        """Return the scope of a proof.

        A limit is linear in pretension and load together. A window that suits two loads therefore
        suits all loads between them.
        """
        ranges = {
            axis.key: _range(axis.values)
            for axis in question.conditions.axes
            if (axis.key in LOADS or axis.is_interval) and len(axis) > 1
        }
        return cls(_range(question.angles), ranges)


def _range(values: Array) -> Range:
    """Return the least and the largest of values."""
    return float(values.min()), float(values.max())
