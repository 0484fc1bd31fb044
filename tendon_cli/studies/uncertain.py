"""A number that is known up to a distribution, and draws of several: scrambled Sobol points, each independent."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tendon_cli.model.kinematics import Array


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
    document: Mapping[str, float | str] | str
    """The number as a study file would say it, in SI, exactly."""

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


def quantile(known: Uncertain, share: Array) -> Array:
    """The value below which a share of a distribution lies, SI; what a normal one has beyond its ends is cut off."""
    if known.kind == "uniform":
        return np.asarray(known.middle + known.spread * (2.0 * share - 1.0))
    from scipy.special import ndtr, ndtri  # only uncertain numbers pay for its import

    first, last = (ndtr((end - known.middle) / known.spread) for end in (known.low, known.high))
    value = known.middle + known.spread * ndtri(first + (last - first) * share)
    return np.asarray(np.clip(value, known.low, known.high))


def drawn(uncertain: Mapping[str, Uncertain], count: int, seed: int) -> dict[str, Array]:
    """`count` values of each number, by its key; the first so many of 2^m Sobol points."""
    from scipy.stats import qmc

    points = qmc.Sobol(len(uncertain), scramble=True, rng=np.random.default_rng([seed, len(uncertain)]))
    shares = points.random_base2(max(0, count - 1).bit_length())[:count]
    return {key: quantile(known, shares[:, at]) for at, (key, known) in enumerate(uncertain.items())}
