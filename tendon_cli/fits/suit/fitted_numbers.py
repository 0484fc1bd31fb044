"""Fitted numbers: value, standard deviation, interval, prior, and how much a log told of each."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations as pairs_of
from typing import Any

import numpy as np

from tendon_cli import say
from tendon_cli.fits.suit.parameters import Parameter
from tendon_cli.fits.suit.suit_estimate import SuitEstimate
from tendon_cli.fits.suit.suit_log import Floats
from tendon_cli.quantities import SIDES
from tendon_cli.space.axis import of_side, split_side
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
_CORRELATED = 0.9
"""Correlation from which two numbers are known only together."""
_TOGETHER = 0.6
"""Relative deviation of a combination, over that of each of its numbers, at most."""
_MOST_PAIRS = 4
_STEP = 1e-4


@dataclass(frozen=True)
class FittedNumber:
    """A number of the study or an error of a sensor, after a log was read."""

    key: str
    value: float
    """Value of the best fit, SI."""
    std: float
    interval_95: tuple[float, float]
    prior: str
    """Law before the log was read, in words."""
    learned: float
    """1 less the variance over the prior's, 0 to 1."""
    unit: str
    score: float
    """Normal score under the prior."""
    is_sensor: bool
    is_stated: bool
    """True if the study itself says that the number is uncertain."""

    @property
    def is_told(self) -> bool:
        """True if the log tells the number."""
        return self.learned >= TOLD

    @property
    def record(self) -> dict[str, Any]:
        """The number as plain JSON values."""
        return {
            "value": self.value,
            "std": self.std,
            "interval_95": list(self.interval_95),
            "prior": self.prior,
            "learned": self.learned,
            "unit": self.unit,
        }

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


@dataclass(frozen=True)
class Combination:
    """Numbers of which a log tells one combination better than each."""

    keys: tuple[str, ...]
    name: str
    """The combination, in words or as a formula."""
    value: float | None
    std: float | None
    unit: str

    @property
    def record(self) -> dict[str, Any]:
        """The combination as plain JSON values."""
        return {
            "keys": list(self.keys),
            "name": self.name,
            "value": self.value,
            "std": self.std,
            "unit": self.unit,
        }

    @property
    def text(self) -> str:
        """The combination in words."""
        if self.value is None or self.std is None:
            return self.name
        unit = "" if self.unit == "1" else f" {self.unit}"
        known = f"known best: {self.name} = {say.number(self.value, 3)}{unit}"
        if not self.value:
            return known
        share = say.number(100.0 * self.std / abs(self.value), 1)
        return f"{known}, to within {share} % (one standard deviation)"


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
    values = parameter.value(grid)
    prior = np.exp(-0.5 * np.square(grid))
    prior /= prior.sum()
    information = max(1.0 / deviation**2 - 1.0, 0.0)
    weights = prior
    if information > _NO_INFORMATION:
        middle = score / (deviation**2 * information)
        felt = _felt(parameter.key, values)
        near = _felt(parameter.key, parameter.value(score + np.array([0.0, -_STEP, _STEP])))
        slope = (near[2] - near[1]) / (2.0 * _STEP)
        centre = near[0] + slope * (middle - score)
        spread = abs(slope) / math.sqrt(information) * coverage / _NORMAL_COVERAGE
        with np.errstate(divide="ignore", over="ignore"):
            exponent = -0.5 * np.square((felt - centre) / max(spread, 1e-300))
        weights = prior * np.exp(exponent - exponent.max())
        weights /= weights.sum()
    if np.max(weights) > _TOO_NARROW:
        # The grid is too coarse for what is known this well, and the law is normal.
        ends = parameter.value(score + coverage * deviation * np.array([-1.0, 0.0, 1.0]))
        std = float(ends[2] - ends[0]) / (2.0 * coverage)
    else:
        below = np.cumsum(weights) - 0.5 * weights
        ends = np.interp([0.025, 0.5, 0.975], below, values)
        mean = float(weights @ values)
        std = math.sqrt(float(weights @ np.square(values - mean)))
    prior_mean = float(prior @ values)
    prior_variance = float(prior @ np.square(values - prior_mean))
    number = FittedNumber(
        key=parameter.key,
        value=float(ends[1]),
        std=std,
        interval_95=(float(ends[0]), float(ends[2])),
        prior="",
        learned=float(np.clip(1.0 - std**2 / prior_variance, 0.0, 1.0)),
        unit=parameter.unit,
        score=float(score),
        is_sensor=parameter.is_sensor,
        is_stated=parameter.is_stated,
    )
    return replace(number, prior=_prior_text(parameter, number))


def _felt(key: str, values: Floats) -> Floats:
    """Return what the tendons feel of a number: of a stiffness in series its compliance."""
    is_series = split_side(key)[0] in _IN_SERIES
    return np.asarray(1.0 / values if is_series else values)


def _prior_text(parameter: Parameter, number: FittedNumber) -> str:
    """Return the prior of a number in words."""
    law = parameter.law
    if parameter.log is not None:
        return "any"
    if law.kind == "uniform":
        low = number.text(law.middle - law.spread)
        high = number.text(law.middle + law.spread)
        return f"{low} to {high}"
    usual = "" if parameter.is_stated else " (usual)"
    return f"{number.text(law.middle)} ± {number.text(law.spread, 2)}{usual}"


# --- What is known only together ------------------------------------------------------------------


def _series(first: Floats, second: Floats) -> Floats:
    """Return the stiffness of two springs in series, N/m."""
    return np.asarray(1.0 / (1.0 / first + 1.0 / second))


def _product(first: Floats, second: Floats) -> Floats:
    """Return the product of two numbers."""
    return np.asarray(first * second)


@dataclass(frozen=True)
class _Candidate:
    """Two numbers of a suit of which logs may tell one combination."""

    first: str
    second: str
    name: str
    unit: str
    formula: Callable[[Floats, Floats], Floats]

    def values(self, values: Mapping[str, Floats]) -> Floats:
        """Return the combination of values by key."""
        return self.formula(values[self.first], values[self.second])

    def of_side(self, side: str) -> _Candidate:
        """Return the same combination of one side."""
        return replace(
            self,
            first=of_side(self.first, side),
            second=of_side(self.second, side),
            name=f"{self.name} of the {side}",
        )


_SERIES = _Candidate(
    "spring.stiffness", "anchor.stiffness", "spring and tissue in series", "N/m", _series
)
_BENT = _Candidate(
    "sheath.friction", "sheath.bend_angle", "friction over the bend μφ", "1", _product
)
_MOMENT = _Candidate(
    "arm.forearm_mass", "arm.forearm_com", "moment of the forearm m_f d_com", "kg m", _product
)


def _candidates(known: Sequence[str]) -> list[_Candidate]:
    """Return the combinations of a suit whose numbers are both fitted."""
    all_of_them = [_MOMENT]
    for both in (_SERIES, _BENT):
        all_of_them += [both, *(both.of_side(side) for side in SIDES)]
    return [one for one in all_of_them if one.first in known and one.second in known]


def combinations(estimate: SuitEstimate, numbers: Sequence[FittedNumber]) -> list[Combination]:
    """Return what a log tells only together: of a suit's parts, and of any correlated pair."""
    known = [number.key for number in numbers]
    shares = {
        number.key: number.std / abs(number.value) if number.value else math.inf
        for number in numbers
    }
    found = []
    named: set[frozenset[str]] = set()
    for candidate in _candidates(known):
        members = (candidate.first, candidate.second)
        value, slope = _gradient(estimate, candidate)
        std = math.sqrt(float(slope @ estimate.covariance @ slope))
        told = 1.0 - std**2 / max(float(slope @ slope), 1e-300)
        named.add(frozenset(members))
        is_better = std / abs(value) < _TOGETHER * min(shares[key] for key in members)
        if told >= TOLD and is_better:
            found.append(Combination(members, candidate.name, value, std, candidate.unit))
    return found + _pairs(estimate, numbers, named)


def _pairs(
    estimate: SuitEstimate, numbers: Sequence[FittedNumber], named: set[frozenset[str]]
) -> list[Combination]:
    """Return the most correlated pairs of numbers of which no more is known than both together."""
    covariance = estimate.covariance
    deviation = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(deviation, deviation)
    found = []
    for first, second in pairs_of(range(len(numbers)), 2):
        both = (numbers[first], numbers[second])
        strength = float(correlation[first, second])
        is_zero = any("zero" in number.key and number.unit == "rad" for number in both)
        members = frozenset(number.key for number in both)
        if abs(strength) < _CORRELATED or members in named or is_zero:
            continue
        one, other = (_short(number.key) for number in both)
        name = f"{one} rises as {other} falls"
        if strength > 0.0:
            name = f"{one} and {other} rise together"
        if all(number.key.startswith("load ") for number in both):
            name = (
                f"an error in the {_mass(both[0].key)} load and one in the {_mass(both[1].key)}"
                " load cannot be told apart"
            )
        found.append((abs(strength), Combination(tuple(sorted(members)), name, None, None, "1")))
    found.sort(key=lambda pair: -pair[0])
    return [combination for _, combination in found[:_MOST_PAIRS]]


def _mass(key: str) -> str:
    """Return the stated mass of a load that the logs name, "2 kg" of "load 2 kg"."""
    return key.removeprefix("load ")


def _short(key: str) -> str:
    """Return a key without its table, in words."""
    common, side = split_side(key)
    name = common.rpartition(".")[2].replace("_", " ")
    table = common.partition(".")[0]
    if name in ("stiffness", "length"):
        name = f"{table} {name}"
    return f"{name} of the {side}" if side else name


def _gradient(estimate: SuitEstimate, candidate: _Candidate) -> tuple[float, Floats]:
    """Return a combination of values at an estimate, and its slopes by the scores."""
    count = len(estimate.scores)
    sets = np.tile(estimate.scores, (count + 1, 1))
    sets[1:] += _STEP * np.eye(count)
    values = candidate.values(estimate.model.values(sets))
    return float(values[0]), np.asarray((values[1:] - values[0]) / _STEP)
