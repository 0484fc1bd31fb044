"""Fitted numbers: value, standard deviation, interval, prior, and how much a log told of each."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.fits.log_rows import Floats
from tendon_cli.fits.suit.parameters import Parameter
from tendon_cli.fits.suit.suit_estimate import SuitEstimate
from tendon_cli.fits.written import plain
from tendon_cli.studies.space.axis import split_side
from tendon_cli.studies.study import keys

TOLD = 0.5
"""Least share of the prior's variance that a log takes away from a number that it tells."""
_REACH = 6.0
"""Largest normal score of the grid on which the law of a number is worked out."""
_POINTS = 4001
_TOO_NARROW = 0.2
"""Weight of one point of the grid from which the grid is too coarse."""
_NO_INFORMATION = 1e-6
_NORMAL_COVERAGE = 1.959963984540054
"""Half-width of a 95 % interval over the standard deviation of a normal law."""
_IN_SERIES = ("spring.stiffness", "anchor.stiffness", "tendon.youngs_modulus")
"""Stiffnesses whose compliances add up."""
_STEP = 1e-4
_RECORDED = ("value", "std", "interval_95", "prior", "learned", "unit")
"""Fields that the record has under the same names."""


@dataclass(frozen=True, kw_only=True)
class FittedNumber(Parameter):
    """A number of the study or an error of a sensor, after a log was read."""

    value: float
    """Value of the best fit, SI."""
    std: float
    interval_95: tuple[float, float]
    learned: float
    """1 less the variance over the prior's, 0 to 1."""
    score: float
    """Normal score under the prior."""

    @property
    def is_told(self) -> bool:
        """True if the log tells the number."""
        return self.learned >= TOLD

    @property
    def prior(self) -> str:
        """Law before the log was read, in words."""
        law = self.law
        if self.log is not None:
            return "any"
        if law.kind == "uniform":
            low = self.text(law.middle - law.spread)
            return f"{low} to {self.text(law.middle + law.spread)}"
        usual = "" if self.is_stated else " (usual)"
        if law.kind == "log-normal":
            return f"{self.text(law.middle)} within a factor of {math.exp(law.spread):.3g}{usual}"
        return f"{self.text(law.middle)} ± {self.text(law.spread, 2)}{usual}"

    @property
    def record(self) -> dict[str, Any]:
        """The number as plain JSON values."""
        return dict(plain({name: getattr(self, name) for name in _RECORDED}))

    def text(self, value: float, digits: int = 3) -> str:
        """Return a value of the number in the unit in which people read it."""
        if not self.is_sensor:
            return say.quantity(keys()[self.key].number.quantity, value, digits)
        if self.unit == "rad":
            return f"{say.number(math.degrees(value), digits)} deg"
        if self.unit == "s":
            return f"{say.number(1e3 * value, digits)} ms"
        if self.unit == "1":
            return f"{say.number(100.0 * value, digits)} %"
        return f"{say.number(value, digits)} {self.unit}"


def fitted_numbers(estimate: SuitEstimate) -> list[FittedNumber]:
    """Return all numbers of an estimate."""
    deviations = np.sqrt(np.diag(estimate.covariance))
    return [
        _fitted(parameter, score, deviation, estimate.coverage_factor)
        for parameter, score, deviation in zip(
            estimate.model.parameters, estimate.scores, deviations, strict=True
        )
    ]


def _fitted(parameter: Parameter, score: float, deviation: float, coverage: float) -> FittedNumber:
    """Return one number with its interval.

    What the logs say of a number is normal in what the tendons feel of it: in itself, or for a
    stiffness in the compliance 1/K. That likelihood follows from the estimate of the normal score,
    which is the product of prior and likelihood; with it and the exact prior the law of the number
    is worked out on a grid of scores.
    """
    grid = np.linspace(-_REACH, _REACH, _POINTS)
    values = parameter.at(grid)
    prior = np.exp(-0.5 * np.square(grid))
    prior /= prior.sum()
    information = max(1.0 / deviation**2 - 1.0, 0.0)
    weights = prior
    if information > _NO_INFORMATION:
        middle = score / (deviation**2 * information)
        felt = _felt(parameter.key, values)
        near = _felt(parameter.key, parameter.at(score + np.array([0.0, -_STEP, _STEP])))
        slope = (near[2] - near[1]) / (2.0 * _STEP)
        centre = near[0] + slope * (middle - score)
        spread = abs(slope) / math.sqrt(information) * coverage / _NORMAL_COVERAGE
        with np.errstate(divide="ignore", over="ignore"):
            exponent = -0.5 * np.square((felt - centre) / max(spread, 1e-300))
        weights = prior * np.exp(exponent - exponent.max())
        weights /= weights.sum()
    if np.max(weights) > _TOO_NARROW:
        # The grid is too coarse for what is known this well, and the law is normal.
        ends = parameter.at(score + coverage * deviation * np.array([-1.0, 0.0, 1.0]))
        std = float(ends[2] - ends[0]) / (2.0 * coverage)
    else:
        below = np.cumsum(weights) - 0.5 * weights
        ends = np.interp([0.025, 0.5, 0.975], below, values)
        mean = float(weights @ values)
        std = math.sqrt(float(weights @ np.square(values - mean)))
    prior_mean = float(prior @ values)
    prior_variance = float(prior @ np.square(values - prior_mean))
    return FittedNumber(
        **vars(parameter),
        value=float(ends[1]),
        std=std,
        interval_95=(float(ends[0]), float(ends[2])),
        learned=float(np.clip(1.0 - std**2 / prior_variance, 0.0, 1.0)),
        score=float(score),
    )


def _felt(key: str, values: Floats) -> Floats:
    """Return what the tendons feel of a number: of a stiffness in series its compliance."""
    is_series = split_side(key)[0] in _IN_SERIES
    return 1.0 / values if is_series else values
