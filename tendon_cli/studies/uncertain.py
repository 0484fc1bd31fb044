"""A number that is known up to a distribution."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Uncertain:
    """The distribution of a number, in SI.

    A uniform one reaches from middle - spread to middle + spread. A normal one has the mean `middle` and the standard
    deviation `spread`; what lies outside of `low` and `high`, where the number is impossible, is cut off.
    """

    kind: Literal["uniform", "normal"]
    middle: float
    spread: float
    low: float
    high: float
    said: float | str
    """Tolerance or standard deviation as a study says it, exactly."""

    @property
    def cut_share(self) -> float:
        """The share of a normal distribution that is cut off."""
        if self.kind == "uniform":
            return 0.0
        ends = (self.middle - self.low, self.high - self.middle)
        return sum(math.erfc(end / self.spread / math.sqrt(2.0)) for end in ends) / 2.0

    @property
    def reach(self) -> tuple[float, float]:
        """Smallest and largest value that may well be drawn: four standard deviations, or where they are cut off."""
        width = self.spread if self.kind == "uniform" else 4.0 * self.spread
        return max(self.low, self.middle - width), min(self.high, self.middle + width)

    def document(self, middle: float | str) -> dict[str, float | str]:
        """The number as a study file would say it."""
        names = ("value", "tolerance") if self.kind == "uniform" else ("mean", "std")
        return dict(zip(names, (middle, self.said), strict=True))
