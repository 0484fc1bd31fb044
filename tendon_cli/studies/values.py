"""A number of a study: one value, a list, or an evenly spaced grid; exact until it is used."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import lcm
from typing import Literal

import numpy as np
import numpy.typing as npt

from tendon_cli.model.kinematics import Array
from tendon_cli.studies.magnitude import Slip
from tendon_cli.units import SI_UNIT, Measure

MAX_AXIS_LENGTH = 10**7
"""Largest number of values of an axis."""


@dataclass(frozen=True)
class Uncertain:
    """Distribution of a number, in SI.

    A uniform one reaches from middle - spread to middle + spread. A normal one has the mean
    `middle` and the standard deviation `spread`; it is cut off below `low` and above `high`, where
    the number is impossible. The logarithm of a log-normal one is normal, with the median `middle`
    and the standard deviation `spread` of the logarithm.
    """

    kind: Literal["uniform", "normal", "log-normal"]
    """Shape of the distribution."""
    middle: float
    """Middle of a uniform distribution, mean of a normal one, SI."""
    spread: float
    """Half the width of a uniform distribution, standard deviation of a normal one, SI."""
    low: float
    """Smallest possible value, SI."""
    high: float
    """Largest possible value, SI."""
    document: Mapping[str, float | str] | str | float
    """The number as a study file would say it, in SI, exactly."""

    @property
    def cut_share(self) -> float:
        """Share of a normal distribution that is cut off."""
        if self.kind == "uniform":
            return 0.0
        ends = (self.middle - self.low, self.high - self.middle)
        return sum(math.erfc(end / self.spread / math.sqrt(2.0)) for end in ends) / 2.0

    @property
    def reach(self) -> tuple[float, float]:
        """Smallest and largest value that may well be drawn, SI.

        A normal distribution reaches four standard deviations, or to where it is cut off.
        """
        width = self.spread if self.kind == "uniform" else 4.0 * self.spread
        return max(self.low, self.middle - width), min(self.high, self.middle + width)


def quantile(distribution: Uncertain, share: Array) -> Array:
    """Return the values below which shares of a distribution lie, SI.

    Args:
        distribution: The distribution; a normal one has no values where it is cut off.
        share: Shares, 0 to 1, any shape.
    """
    middle = distribution.middle
    spread = distribution.spread
    if distribution.kind == "uniform":
        return np.asarray(middle + spread * (2.0 * share - 1.0))
    from scipy.special import ndtr, ndtri  # only uncertain numbers pay for its import

    if distribution.kind == "log-normal":
        return np.asarray(middle * np.exp(spread * ndtri(share)))
    below_low = ndtr((distribution.low - middle) / spread)
    below_high = ndtr((distribution.high - middle) / spread)
    value = middle + spread * ndtri(below_low + (below_high - below_low) * share)
    return np.asarray(np.clip(value, distribution.low, distribution.high))


Stream = tuple[int, ...]
"""Words that tell a stream of random numbers from the others of the same seed."""
OF_THE_STUDY: Stream = ()
"""Streams of the persons and draws of the study itself."""
OF_FRESH_BODIES: Stream = (1,)
"""Stream of the bodies of a fresh sample."""
OF_FRESH_DRAWS: Stream = (2,)
"""Stream of the uncertain numbers of a fresh sample."""
OF_SECOND_BODIES: Stream = (4,)
"""Stream of the bodies of the sample by which the best choices are set."""
OF_SECOND_DRAWS: Stream = (5,)
"""Stream of the draws of that sample."""
OF_TABLES: Stream = (3,)
"""Stream of the samples that are tables of a study."""


def random_numbers(seed: int, purpose: int, stream: Stream = OF_THE_STUDY) -> np.random.Generator:
    """Return a generator of random numbers.

    Generators of different streams of a seed are independent, however many numbers are drawn.

    Args:
        seed: Seed of the study.
        purpose: Number that tells what is drawn, such as bodies of women.
        stream: The stream.
    """
    return np.random.default_rng(np.random.SeedSequence([seed, purpose], spawn_key=stream))


Mixing = Callable[[Array, Mapping[str, int]], Array]
"""Function that correlates independent normal scores, (draws, numbers), whose columns it takes by
the keys of the numbers."""
Sampler = Literal["sobol", "latin-hypercube", "random", "even"]
"""Way to draw points: scrambled Sobol points, the first of the next power of two of them; a Latin
hypercube, with a point in every 1/count of each number; independent points. `even` is a Latin
hypercube without SciPy, which is slow to import."""
_SAMPLE_DIGITS = 12
"""Significant digits of the numbers of a sample: libraries of machines differ in the last ones."""


def draw_numbers(
    uncertain: Mapping[str, Uncertain],
    count: int,
    seed: int,
    mixing: Mixing | None = None,
    *,
    sampler: Sampler = "sobol",
    stream: Stream = OF_THE_STUDY,
) -> dict[str, Array]:
    """Draw values of uncertain numbers.

    Args:
        uncertain: The distribution of each number, by its key.
        count: Number of draws.
        seed: Seed; the same seed gives the same draws.
        mixing: Correlates the numbers; None if they are independent.
        sampler: Way to draw points.
        stream: Stream of the random numbers.

    Returns:
        The draws of each number, by its key, shape (count,), SI.
    """
    numbers = len(uncertain)
    random = random_numbers(seed, numbers, stream)
    if sampler == "even":
        strata = random.permuted(np.tile(np.arange(count), (numbers, 1)), axis=1).T
        shares = (strata + random.random((count, numbers))) / count
    elif sampler == "random":
        shares = random.random((count, numbers))
    else:
        from scipy.stats import qmc

        if sampler == "sobol":
            power = max(0, count - 1).bit_length()
            shares = qmc.Sobol(numbers, scramble=True, rng=random).random_base2(power)[:count]
        else:
            shares = qmc.LatinHypercube(numbers, rng=random).random(count)
    if mixing is not None:
        from scipy.special import ndtr, ndtri

        places = {key: place for place, key in enumerate(uncertain)}
        shares = ndtr(mixing(ndtri(shares), places))
    return {
        key: quantile(known, shares[:, at]) for at, (key, known) in enumerate(uncertain.items())
    }


def sample_numbers(
    uncertain: Mapping[str, Uncertain], sampler: Sampler, count: int, seed: int
) -> dict[str, Array]:
    """Draw the rows of a sample as `draw_numbers` does, the same on every machine."""
    drawn = draw_numbers(uncertain, count, seed, sampler=sampler, stream=OF_TABLES)
    for key, values in drawn.items():
        rounded = [float(f"{value:.{_SAMPLE_DIGITS}g}") for value in values.tolist()]
        low, high = uncertain[key].reach
        drawn[key] = np.clip(rounded, low, high)
    return drawn


@dataclass(frozen=True)
class Grid:
    """Values between two ends, both included, spaced evenly or by a constant factor."""

    start: Measure
    """First value."""
    stop: Measure
    """Last value."""
    num: int
    """Number of values."""
    log: bool = False
    """True if a constant factor lies between neighbours, instead of a constant step."""

    def array(self) -> npt.NDArray[np.float64]:
        """Return the values in SI, shape (num,).

        Even grids are computed in rational numbers and each value is rounded once, so that 0.7 to
        1.0 in four steps holds the same 0.8 as a list that says 0.8, on every machine.
        """
        if self.num == 1:
            return np.array([self.start.si])
        if self.log:
            values = np.geomspace(self.start.si, self.stop.si, self.num)
            values[0] = self.start.si
            values[-1] = self.stop.si
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
class StudyNumber:
    """Number that a study gives for one key: one value, a list of values, or a grid.

    It is an axis of the product of designs unless it is a single value.
    """

    source: tuple[float, ...] | Grid
    """SI values, or a grid that is only written out when it is needed."""
    is_axis: bool
    """True if the number is an axis, even one of a single value."""
    uncertain: Uncertain | None = None
    """Distribution of a single value around the one in `source`; None for an exact number."""
    is_interval: bool = False
    """True if every value between two is meant; `source` is then a grid of these two."""
    slips: tuple[Slip, ...] = field(default=(), compare=False)
    """Values as they were written that are far from any arm."""
    dimension: str | None = None
    """Dimension in which a reading is stated, a force or a torque; None for a bare number and for
    any other quantity."""

    @classmethod
    def of(cls, value: float, slips: tuple[Slip, ...] = ()) -> StudyNumber:
        """Return a single SI value."""
        return cls((value,), is_axis=False, slips=slips)

    def __len__(self) -> int:
        return self.source.num if isinstance(self.source, Grid) else len(self.source)

    @cached_property
    def array(self) -> npt.NDArray[np.float64]:
        """All values in SI, in the order given; read-only."""
        source = self.source
        values = source.array() if isinstance(source, Grid) else np.array(source, dtype=np.float64)
        values.flags.writeable = False
        return values

    @property
    def extremes(self) -> tuple[float, float]:
        """Smallest and largest value in SI; a grid is not written out."""
        if isinstance(self.source, Grid):
            ends: tuple[float, ...] = (self.source.start.si, self.source.stop.si)
        else:
            ends = self.source
        return min(ends), max(ends)

    @property
    def single(self) -> float:
        """The value of a number that is no axis, SI.

        Raises:
            ValueError: The number is an axis.
        """
        if self.is_axis or isinstance(self.source, Grid):
            raise ValueError("an axis has no single value")
        return self.source[0]

    def document(self, dimension: str) -> object:
        """Return the number as a study file would say it, in SI.

        A grid stays as short as it was written.
        """
        if isinstance(self.source, Grid):
            ends = {"from": self.source.start.document(), "to": self.source.stop.document()}
            if self.is_interval:
                return ends
            spacing = {"spacing": "log"} if self.source.log else {}
            return {**ends, "num": self.source.num, **spacing}
        if self.uncertain is not None:
            return self.uncertain.document
        values = [si_document(value, dimension) for value in self.source]
        return values if self.is_axis else values[0]


RIGID = "rigid"
"""Word for an infinite stiffness."""


def si_document(value: float, dimension: str) -> float | str:
    """Return an SI number as a study may say it: with its unit only if it is an angle."""
    if math.isinf(value):
        return RIGID
    return f"{value!r} {SI_UNIT[dimension]}" if dimension == "angle" else value
