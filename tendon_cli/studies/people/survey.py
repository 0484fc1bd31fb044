"""Means, deviations and correlations of a survey of bodies: what bodies are drawn from, and what completes them."""

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
from tendon_cli.studies.toml_reading import read_toml
from tendon_cli.units import shorten

SEXES = ("male", "female")

PLAUSIBLE = dict(
    zip(
        DIMENSIONS,
        (
            (0.8, 2.5),
            (15.0, 350.0),
            (0.12, 0.60),
            (0.10, 0.50),
            (0.12, 0.65),
            (0.10, 0.80),
            (0.10, 0.60),
            (0.07, 0.35),
        ),
        strict=True,
    )
)
"""Least and largest value of each dimension that someone has, in SI: wide, so that what is outside is a slip."""
LEAST = 3.0
"""Standard deviations below the mean under which no body is drawn: the survey tells of no smallest, and a normal
distribution has lighter bodies than anyone measured."""
_MOST_SCATTER = 1.0 / 3.0
"""Deviation over mean, beyond which bodies drawn as normal would be below 0."""

_SI = np.array(
    [1.0 if name == "weight" else 1e-3 for name in DIMENSIONS]
)  # the survey has kg and mm


@dataclass(frozen=True, eq=False)
class Statistics:
    """Bodies of one kind as a normal distribution; dimensions in the order of `DIMENSIONS`, SI units."""

    persons: int
    """How many were measured."""
    mean: Array
    """Shape (8,)."""
    covariance: Array
    """Shape (8, 8)."""
    least: Array
    """No body is drawn with less, shape (8,)."""

    @cached_property
    def factor(self) -> Array:
        """Lower triangular L with L Lᵀ = covariance; raises ValueError where that is not positive definite."""
        return cholesky(self.covariance)

    @property
    def mean_body(self) -> Body:
        """The body that is average in every dimension."""
        return Body(*self.mean)

    def completed(self, values: Array, normal: Array | None = None) -> Array:
        """Bodies of shape (n, 8) with what is missing (NaN) as expected of those given: linear regression on these.

        With `normal` numbers, (n, 8), they scatter around that as real bodies do, but none below the least.
        """
        complete = values.copy()
        missing = np.isnan(values)
        patterns, pattern_of = np.unique(missing, axis=0, return_inverse=True)
        for at, lacks in enumerate(patterns):
            rows = pattern_of == at
            given = ~lacks
            if not lacks.any():
                continue
            across = self.covariance[np.ix_(given, lacks)]
            solved = np.linalg.solve(self.covariance[np.ix_(given, given)], across)
            bodies = self.mean[lacks] + (values[np.ix_(rows, given)] - self.mean[given]) @ solved
            if normal is not None:
                rest = self.covariance[np.ix_(lacks, lacks)] - across.T @ solved
                bodies = scattered(
                    bodies, cholesky(0.5 * (rest + rest.T)), normal[np.ix_(rows, lacks)]
                )
                bodies = np.maximum(bodies, self.least[lacks])
            complete[np.ix_(rows, lacks)] = bodies
        return complete


@dataclass(frozen=True, eq=False)
class Survey:
    """The statistics of men and of women."""

    male: Statistics
    female: Statistics

    @property
    def share_of_women(self) -> float:
        """Women among the persons measured."""
        return self.female.persons / (self.male.persons + self.female.persons)

    def of(self, sex: str) -> Statistics:
        """Those of one of `SEXES`."""
        return self.male if sex == "male" else self.female

    def both(self, women: float | None = None) -> Statistics:
        """Mean and covariance of men and women mixed, `women` being the share of women."""
        share = self.share_of_women if women is None else women
        apart = self.female.mean - self.male.mean
        covariance = (1.0 - share) * self.male.covariance + share * self.female.covariance
        return Statistics(
            self.male.persons + self.female.persons,
            self.male.mean + share * apart,
            covariance + share * (1.0 - share) * np.outer(apart, apart),
            np.minimum(self.male.least, self.female.least),
        )


@cache
def ansur2() -> Survey:
    """The survey that comes with tendon."""
    return read_survey(
        resources.files(__package__).joinpath("ansur2_arm.toml").read_bytes(), "ansur2"
    )


def read_survey(given: bytes, where: str) -> Survey:
    """Check and take over the statistics of a survey in TOML, in kg and mm; raises InputError."""
    try:
        content = read_toml(given.decode("utf-8-sig")).content
        names = content["dimensions"]
        if missing := [name for name in DIMENSIONS if name not in names]:
            raise ValueError(f"its dimensions lack {', '.join(missing)}")  # noqa: TRY301 - reported below
        order = [names.index(name) for name in DIMENSIONS]
        return Survey(*(_statistics(content[sex], order, sex) for sex in SEXES))
    except (StudyError, KeyError, TypeError, AttributeError, ValueError, RecursionError) as error:
        problem = f"not statistics of a survey: {shorten(str(error), 150) or type(error).__name__}"
        hint = f"expected dimensions ({', '.join(DIMENSIONS)}), and in [male] and [female] persons, mean, "
        hint += "standard_deviation (kg and mm) and correlation"
        raise InputError(problem, where=where, hint=hint) from None


def _statistics(table: dict[str, Any], order: list[int], sex: str) -> Statistics:
    """Those of one sex; raises ValueError for what cannot be."""
    size, persons = len(DIMENSIONS), int(table["persons"])
    mean, deviation, correlation = (
        np.array(table[key], dtype=np.float64)
        for key in ("mean", "standard_deviation", "correlation")
    )
    if (
        mean.shape != (size,)
        or deviation.shape != (size,)
        or correlation.shape != (size, size)
        or persons < 1
    ):
        raise ValueError(
            f"[{sex}] has not {size} means, {size} deviations, {size} x {size} correlations of persons"
        )
    if not (
        np.all(mean > 0.0) and np.all(deviation > 0.0) and np.all(np.isfinite(mean + deviation))
    ):
        raise ValueError(f"a mean or standard deviation in [{sex}] is not above 0")
    if np.any(np.diag(correlation) != 1.0) or np.any(correlation != correlation.T):
        raise ValueError(f"the correlation in [{sex}] is not symmetric with ones on its diagonal")
    mean, deviation, correlation = mean[order], deviation[order], correlation[np.ix_(order, order)]
    for name, middle, scatter, per in zip(DIMENSIONS, mean, deviation, _SI, strict=True):
        low, high = (end / per for end in PLAUSIBLE[name])
        unit = "kg" if per == 1.0 else "mm"
        if not low <= middle <= high:  # as in another unit
            raise ValueError(
                f"the mean {name} is {middle:g} {unit}, expected {low:g} to {high:g} {unit}"
            )
        if scatter > _MOST_SCATTER * middle:
            spread = f"the deviation of {name} is {scatter:g} {unit} at a mean of {middle:g} {unit}"
            raise ValueError(f"{spread}, so that bodies would be below 0")
    cholesky(correlation)
    scale = deviation * _SI
    return Statistics(
        persons, mean * _SI, correlation * np.outer(scale, scale), mean * _SI - LEAST * scale
    )


def scattered(middle: Array, factor: Array, normal: Array) -> Array:
    """Bodies around some middle ones, (n, m), by normal numbers, (n, m), and L with L Lᵀ = their covariance."""
    bodies = middle.copy()
    for row, factors in enumerate(
        factor
    ):  # added up in this order everywhere, unlike a matrix product
        for column in range(row + 1):
            bodies[:, row] += factors[column] * normal[:, column]
    return bodies


def cholesky(matrix: Array) -> Array:
    """Lower triangular L with L Lᵀ = matrix, shape (n, n); raises ValueError where it is not positive definite.

    Written out, so that a seed gives the same bodies to the last bit whatever linear algebra NumPy was built with.
    """
    size = len(matrix)
    factor = np.zeros((size, size))
    for row in range(size):
        for column in range(row + 1):
            rest = float(matrix[row, column])
            for at in range(column):
                rest -= float(factor[row, at]) * float(factor[column, at])
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
