"""A number of a study: one value, a list, or an evenly spaced grid; exact until it is used."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import lcm
from typing import Literal

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Array
from tendon_cli.units import SI_UNIT, Measure

MAX_AXIS_LENGTH = 10**7


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

    points = qmc.Sobol(
        len(uncertain), scramble=True, rng=np.random.default_rng([seed, len(uncertain)])
    )
    shares = points.random_base2(max(0, count - 1).bit_length())[:count]
    return {
        key: quantile(known, shares[:, at]) for at, (key, known) in enumerate(uncertain.items())
    }


@dataclass(frozen=True)
class Grid:
    """`num` values from `start` to `stop`, both included, spaced evenly or, where `log`, by a constant factor."""

    start: Measure
    stop: Measure
    num: int
    log: bool = False

    def array(self) -> npt.NDArray[np.float64]:
        """The values in SI, shape (num,).

        Even grids are computed in rational numbers and each value is rounded once, so that 0.7 to 1.0 in four steps
        holds the same 0.8 as a list that says 0.8, on every machine.
        """
        if self.num == 1:
            return np.array([self.start.si])
        if self.log:
            values = np.geomspace(self.start.si, self.stop.si, self.num)
            values[0], values[-1] = self.start.si, self.stop.si
            return values
        first = self.start.exact
        step = (self.stop.exact - first) / (self.num - 1)
        common = lcm(first.denominator, step.denominator)
        offset = first.numerator * (common // first.denominator)
        stride = step.numerator * (common // step.denominator)
        return np.fromiter(
            ((offset + stride * i) / common for i in range(self.num)), np.float64, self.num
        )


@dataclass(frozen=True)
class Values:
    """What a study says for one key. It is an axis of the product unless it is a single value."""

    source: tuple[float, ...] | Grid
    """SI values, or a grid that is only written out when it is needed."""
    is_axis: bool
    uncertain: Uncertain | None = None
    """How a single value is distributed around the one in `source`, where the study says so."""
    is_interval: bool = False
    """Every value from the first to the last of two is meant, and these are its ends."""

    @classmethod
    def of(cls, value: float) -> Values:
        """A single SI value."""
        return cls((value,), is_axis=False)

    def __len__(self) -> int:
        return self.source.num if isinstance(self.source, Grid) else len(self.source)

    @cached_property
    def array(self) -> npt.NDArray[np.float64]:
        """All values in SI, in the order given."""
        values = (
            self.source.array()
            if isinstance(self.source, Grid)
            else np.array(self.source, dtype=np.float64)
        )
        values.flags.writeable = False
        return values

    @property
    def extremes(self) -> tuple[float, float]:
        """Smallest and largest value in SI, without writing a grid out."""
        ends = (
            (self.source.start.si, self.source.stop.si)
            if isinstance(self.source, Grid)
            else self.source
        )
        return min(ends), max(ends)

    @property
    def single(self) -> float:
        """The value in SI where there is only one; raises ValueError for an axis."""
        if self.is_axis or isinstance(self.source, Grid):
            raise ValueError("an axis has no single value")
        return self.source[0]

    def document(self, dimension: str) -> object:
        """The same numbers as a study file would say them, in SI; grids stay as short as they were written."""
        if isinstance(self.source, Grid):
            grid = self.source
            ends, spacing = (
                {"from": grid.start.document(), "to": grid.stop.document()},
                {"spacing": "log"},
            )
            return (
                ends
                if self.is_interval
                else {**ends, "num": grid.num, **(spacing if grid.log else {})}
            )
        if self.uncertain is not None:
            return self.uncertain.document
        values = [in_si(value, dimension) for value in self.source]
        return values if self.is_axis else values[0]


RIGID = "rigid"
"""The word for a stiffness without end."""


def in_si(value: float, dimension: str) -> float | str:
    """A number in SI as a study may say it: only angles cannot stand without their unit."""
    if math.isinf(value):
        return RIGID
    return f"{value!r} {SI_UNIT[dimension]}" if dimension == "angle" else value
