"""Statistics of a survey of bodies: means, deviations and correlations.

Bodies are drawn from them, and completed by them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import resources
from typing import Any

import numpy as np

from tendon_cli.errors import InputError, StudyError
from tendon_cli.model.body import DIMENSIONS, Body
from tendon_cli.model.kinematics import Array
from tendon_cli.quantities import PLAUSIBLE
from tendon_cli.studies.toml_reading import read_toml
from tendon_cli.units import shorten

SEXES = ("male", "female")

LEAST = 3.0
"""Number of standard deviations below the mean at which draws are cut off: the survey does not say
who was smallest, and a normal distribution has lighter bodies than anyone measured."""
_MOST_SCATTER = 1.0 / 3.0
"""Largest ratio of deviation to mean: beyond it, three deviations below the mean are below 0."""

_SI = np.array([1.0 if name == "weight" else 1e-3 for name in DIMENSIONS])
"""SI value of the unit of each dimension in a survey, kg or mm."""


@dataclass(frozen=True, eq=False)
class Statistics:
    """Bodies of one kind as a normal distribution.

    Dimensions are in the order of `DIMENSIONS`, in SI units.
    """

    persons: int
    """Number of persons measured."""
    mean: Array
    """Mean, (8,)."""
    covariance: Array
    """Covariance, (8, 8)."""
    least: Array
    """Dimensions below which no body is drawn, (8,)."""

    @cached_property
    def factor(self) -> Array:
        """Lower triangular L with L Lᵀ = covariance.

        Raises ValueError if the covariance is not positive definite.
        """
        return cholesky(self.covariance)

    @property
    def mean_body(self) -> Body:
        """Body that is average in every dimension."""
        return Body(*self.mean)

    def completed(self, values: Array, normal: Array | None = None) -> Array:
        """Complete bodies by the dimensions expected of bodies with the given ones.

        These follow by linear regression on the given dimensions.

        Args:
            values: Bodies, (n, 8), NaN where a dimension is missing.
            normal: Normal numbers, (n, 8), by which bodies scatter around the expected ones as
                real ones do, but none below `least`; None for no scatter.
        """
        complete = values.copy()
        missing = np.isnan(values)
        patterns, pattern_of = np.unique(missing, axis=0, return_inverse=True)
        for number, lacks in enumerate(patterns):
            if not lacks.any():
                continue
            rows = pattern_of == number
            given = ~lacks
            cross_covariance = self.covariance[np.ix_(given, lacks)]
            coefficients = np.linalg.solve(self.covariance[np.ix_(given, given)], cross_covariance)
            deviations = values[np.ix_(rows, given)] - self.mean[given]
            bodies = self.mean[lacks] + deviations @ coefficients
            if normal is not None:
                explained = cross_covariance.T @ coefficients
                residual = self.covariance[np.ix_(lacks, lacks)] - explained
                factor = cholesky(0.5 * (residual + residual.T))
                bodies = scattered(bodies, factor, normal[np.ix_(rows, lacks)])
                bodies = np.maximum(bodies, self.least[lacks])
            complete[np.ix_(rows, lacks)] = bodies
        return complete


@dataclass(frozen=True, eq=False)
class Survey:
    """The statistics of men and of women."""

    male: Statistics
    """Statistics of men."""
    female: Statistics
    """Statistics of women."""

    @property
    def share_of_women(self) -> float:
        """Share of women among the persons measured."""
        return self.female.persons / (self.male.persons + self.female.persons)

    def of(self, sex: str) -> Statistics:
        """Return the statistics of one of `SEXES`."""
        return self.male if sex == "male" else self.female

    def both(self, women: float | None = None) -> Statistics:
        """Return mean and covariance of men and women mixed.

        Args:
            women: Share of women; by default that among the persons measured.
        """
        share = self.share_of_women if women is None else women
        difference = self.female.mean - self.male.mean
        covariance = (1.0 - share) * self.male.covariance + share * self.female.covariance
        return Statistics(
            self.male.persons + self.female.persons,
            self.male.mean + share * difference,
            covariance + share * (1.0 - share) * np.outer(difference, difference),
            np.minimum(self.male.least, self.female.least),
        )


@cache
def ansur2() -> Survey:
    """Return the survey that comes with tendon."""
    content = resources.files(__package__).joinpath("ansur2_arm.toml").read_bytes()
    return read_survey(content, "ansur2")


def read_survey(given: bytes, where: str) -> Survey:
    """Return the statistics of a survey from TOML, in kg and mm.

    Raises:
        InputError: The text is not such statistics.
    """
    try:
        content = read_toml(given.decode("utf-8-sig")).content
        order = _order(content["dimensions"])
        return Survey(*(_statistics(content[sex], order, sex) for sex in SEXES))
    except (StudyError, KeyError, TypeError, AttributeError, ValueError, RecursionError) as error:
        reason = shorten(str(error), 150) or type(error).__name__
        hint = (
            f"expected dimensions ({', '.join(DIMENSIONS)}), and in [male] and [female] persons, "
            "mean, standard_deviation (kg and mm) and correlation"
        )
        raise InputError(f"not statistics of a survey: {reason}", where=where, hint=hint) from None


def _order(names: Any) -> list[int]:
    """Return the place of each of `DIMENSIONS` among names. Raises ValueError if one is missing."""
    missing = [name for name in DIMENSIONS if name not in names]
    if missing:
        raise ValueError(f"its dimensions lack {', '.join(missing)}")
    return [names.index(name) for name in DIMENSIONS]


def _statistics(table: dict[str, Any], order: list[int], sex: str) -> Statistics:
    """Return the statistics of one sex.

    Args:
        table: Table of the file, in kg and mm.
        order: Place of each of `DIMENSIONS` in the table.
        sex: Name of the table.

    Raises:
        ValueError: The statistics are not possible.
    """
    size = len(DIMENSIONS)
    persons = int(table["persons"])
    mean = np.array(table["mean"], dtype=np.float64)
    deviation = np.array(table["standard_deviation"], dtype=np.float64)
    correlation = np.array(table["correlation"], dtype=np.float64)
    has_shapes = mean.shape == deviation.shape == (size,) and correlation.shape == (size, size)
    if not has_shapes or persons < 1:
        raise ValueError(
            f"[{sex}] does not have persons, {size} means, {size} deviations and {size} x {size} "
            "correlations"
        )
    if not (
        np.all(mean > 0.0) and np.all(deviation > 0.0) and np.all(np.isfinite(mean + deviation))
    ):
        raise ValueError(f"a mean or standard deviation in [{sex}] is not above 0")
    if np.any(np.diag(correlation) != 1.0) or np.any(correlation != correlation.T):
        raise ValueError(f"the correlation in [{sex}] is not symmetric with ones on its diagonal")
    mean = mean[order]
    deviation = deviation[order]
    correlation = correlation[np.ix_(order, order)]
    for name, middle, scatter, unit_size in zip(DIMENSIONS, mean, deviation, _SI, strict=True):
        unit = "kg" if unit_size == 1.0 else "mm"
        low, high = (end / unit_size for end in PLAUSIBLE[name])
        if not low <= middle <= high:  # perhaps in another unit
            raise ValueError(
                f"the mean {name} is {middle:g} {unit}, expected {low:g} to {high:g} {unit}"
            )
        if scatter > _MOST_SCATTER * middle:
            raise ValueError(
                f"the deviation of {name} is {scatter:g} {unit} at a mean of {middle:g} {unit}, "
                "so that bodies would be below 0"
            )
    cholesky(correlation)
    scale = deviation * _SI
    return Statistics(
        persons,
        mean=mean * _SI,
        covariance=correlation * np.outer(scale, scale),
        least=mean * _SI - LEAST * scale,
    )


def scattered(middle: Array, factor: Array, normal: Array) -> Array:
    """Scatter bodies around others by normal numbers.

    Args:
        middle: Bodies, (n, m).
        factor: Lower triangular L with L Lᵀ = their covariance, (m, m).
        normal: Normal numbers, (n, m).
    """
    bodies = middle.copy()
    for row, factors in enumerate(factor):
        for column in range(row + 1):  # in this order everywhere, unlike a matrix product
            bodies[:, row] += factors[column] * normal[:, column]
    return bodies


def cholesky(matrix: Array) -> Array:
    """Return the lower triangular L with L Lᵀ = matrix, (n, n).

    It is written out, so that a seed gives the same bodies to the last bit whatever linear algebra
    NumPy was built with.

    Raises:
        ValueError: The matrix is not positive definite.
    """
    size = len(matrix)
    factor = np.zeros((size, size))
    for row in range(size):
        for column in range(row + 1):
            rest = float(matrix[row, column])
            for before in range(column):
                rest -= float(factor[row, before]) * float(factor[column, before])
            if column < row:
                factor[row, column] = rest / factor[column, column]
            elif rest <= 1e-12 * float(matrix[row, row]):
                name = DIMENSIONS[row] if size == len(DIMENSIONS) else row
                raise ValueError(
                    f"correlations are not positive definite: {name} follows from the others"
                )
            else:
                factor[row, row] = math.sqrt(rest)
    return factor
