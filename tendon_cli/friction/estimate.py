"""μ, gain and what is wrong with the rig from strokes: linear least squares, strokes being the sample.

The rows of one stroke share its friction, its load and its cells, so their number says little. Each stroke is cut into
a few points so that the force within it shows; points scatter about their stroke and strokes about the line (a random
intercept). Both variances are estimated, the rows whitened by them, and the rest is `np.linalg.lstsq`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.friction.rate import rates_of
from tendon_cli.friction.reading.readings import Floats, Integers
from tendon_cli.model.sheath import capstan_ratio

PER_STROKE = 8
ASSUMED_SCATTER = 0.03
"""Standard deviation of the friction from stroke to stroke, relative, where too few strokes show none."""

_LEAST_SCATTER = 1e-3
"""The same, and within a stroke, of readings without noise: no rig keeps to the formula more closely."""

_FEWEST_WITHIN = 6
"""Degrees of freedom from which the scatter within strokes is told from theirs."""


@dataclass(frozen=True, eq=False)
class Slipping:
    """The readings in use: forces, way, bend angle and stroke (0, 1, ... without gaps) of each; time where known."""

    motor: Floats
    load: Floats
    way: Integers
    bend_angle: Floats
    stroke: Integers
    place: Floats
    """Along the log, from -1/2 to 1/2."""
    time: Floats | None = None

    @property
    def log_ratio(self) -> Floats:
        """ln(force at motor / force at load)."""
        return np.asarray(np.log(self.motor / self.load))

    def of(self, chosen: npt.NDArray[np.bool_]) -> Slipping:
        """Some of the readings, their strokes numbered anew."""
        _, stroke = np.unique(self.stroke[chosen], return_inverse=True)
        time = None if self.time is None else self.time[chosen]
        return Slipping(
            self.motor[chosen], self.load[chosen], self.way[chosen], self.bend_angle[chosen], stroke,
            self.place[chosen], time,
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Points:
    """Means over parts of strokes."""

    log_ratio: Floats
    force: Floats
    """At the load, where it does not depend on friction as the motor's does."""
    rate: Floats | None
    """d ln F/dt, in the file's unit of time; None where there is none."""
    way: Integers
    bend_angle: Floats
    place: Floats
    stroke: Integers
    part: Integers
    """Which point each reading belongs to."""


@dataclass(frozen=True, eq=False)
class Linear:
    """A linear fit: the values of its columns, their covariance, and what is left."""

    values: Floats
    covariance: Floats
    residual: Floats
    likelihood: float
    """Logarithm, but for a constant."""
    degrees_of_freedom: int
    """Of μ: strokes less parameters."""
    within: int
    """Of what changes within strokes: points less strokes and parameters."""
    scatter: tuple[float, float]
    """Standard deviations: of strokes about the line, of points about their stroke."""
    assumed: bool
    """Whether strokes are too few to show their scatter, so that `ASSUMED_SCATTER` stands for it."""

    def error(self, column: int) -> float:
        """Standard error of one value."""
        return float(np.sqrt(max(self.covariance[column, column], 0.0)))


def log_ratio_of(friction: float, log_gain: float, way: Integers, bend_angle: Floats) -> Floats:
    """The fitted line: motor over load is the inverse of the sheath's distal over proximal, times the gain ratio."""
    return np.asarray(log_gain - np.log(capstan_ratio(friction, bend_angle, -way.astype(np.float64))))


def points_of(slipping: Slipping, *, robust: bool = False) -> Points:
    """The readings with each stroke cut into up to eight parts of as many rows; if robust, its median."""
    order = np.argsort(slipping.stroke, kind="stable")
    stroke = slipping.stroke[order]
    most = 1 if robust else PER_STROKE
    position = np.arange(len(stroke)) - np.searchsorted(stroke, stroke)
    length = np.bincount(stroke)[stroke]
    _, part = np.unique(stroke * most + position * np.minimum(most, length) // length, return_inverse=True)
    count = np.bincount(part)

    def mean(column: npt.NDArray[np.generic]) -> Floats:
        return np.asarray(np.bincount(part, column[order].astype(np.float64)) / count)

    motor, load = mean(slipping.motor), mean(slipping.load)
    log_ratio = np.log(motor / load)
    if robust:
        splits = np.cumsum(count)[:-1]
        log_ratio = np.array([np.median(values) for values in np.split(slipping.log_ratio[order], splits)])
    of_part = np.rint(mean(slipping.stroke)).astype(np.int64)
    rate = None
    if slipping.time is not None:
        # Of both cells together, so that it stands half way between the prompt and the late one.
        both = 0.5 * np.bincount(part, np.log(slipping.motor * slipping.load)[order]) / count
        rate = rates_of(mean(slipping.time), both, of_part)
    way = np.rint(mean(slipping.way)).astype(np.int64)
    point = np.empty_like(part)
    point[order] = part
    return Points(log_ratio, load, rate, way, mean(slipping.bend_angle), mean(slipping.place), of_part, point)


def solve(points: Points, columns: list[Floats], *, robust: bool = False) -> Linear:
    """Least squares of the log ratio on columns, the first of them ±φ, whose value is μ."""
    design = np.stack(columns, axis=1)
    size = np.maximum(np.max(np.abs(design), axis=0), 1e-300)
    scaled = design / size
    weight = np.ones(int(points.stroke.max()) + 1)
    for _ in range(15 if robust else 1):
        found = _whitened(points, scaled, weight)
        if robust:
            left = np.abs(_means(points.stroke, found.residual))
            spread = max(1.4826 * float(np.median(left)), 1e-9)
            weight = np.minimum(1.0, 1.345 * spread / np.maximum(left, 1e-300))
    return Linear(
        found.values / size, found.covariance / np.outer(size, size), found.residual, found.likelihood,
        found.degrees_of_freedom, found.within, found.scatter, found.assumed,
    )  # fmt: skip


def _means(stroke: Integers, values: Floats) -> Floats:
    return np.asarray(np.bincount(stroke, values) / np.bincount(stroke))


def _whitened(points: Points, design: Floats, weight: Floats) -> Linear:
    """Within and between strokes apart, each over its own standard deviation."""
    stroke, count = points.stroke, np.bincount(points.stroke)
    both = np.column_stack([design, points.log_ratio])
    mean = np.stack([_means(stroke, column) for column in both.T], axis=1)
    within = both - mean[stroke]
    within[:, np.max(np.abs(within), axis=0) < 1e-12] = 0.0  # what does not vary within a stroke, but for rounding
    inner, inner_free = _scatter(within, len(stroke) - len(count))
    outer, outer_free = _scatter(mean * np.sqrt(weight)[:, None], len(count))
    level = float(np.mean(np.abs(mean[:, -1] - np.mean(mean[:, -1]) if len(count) > 1 else mean[:, -1])))
    if inner_free < _FEWEST_WITHIN and len(count) < len(stroke):  # too few to tell: rows scatter as strokes do
        inner = max(inner, outer)
    inner = max(inner * _inflation(within, stroke), _LEAST_SCATTER * level, 1e-13)
    own = outer**2 - inner**2 * float(np.mean(1.0 / count))
    assumed = outer_free < 1
    own = max(own, ((ASSUMED_SCATTER if assumed else _LEAST_SCATTER) * level) ** 2)
    within /= inner
    between = mean * np.sqrt(weight / (own + inner**2 / count))[:, None]
    white = np.concatenate([between, within])
    values, _, rank, _ = np.linalg.lstsq(white[:, :-1], white[:, -1], rcond=1e-10)
    left = white[:, -1] - white[:, :-1] @ values
    covariance = np.linalg.pinv(white[:, :-1].T @ white[:, :-1], rcond=1e-20, hermitian=True)
    free = max(len(count) - int(rank), 0)
    residual = points.log_ratio - design @ values
    spread = np.sum(np.log(own + inner**2 / count)) + 2.0 * (len(stroke) - len(count)) * np.log(inner)
    likelihood = -0.5 * float(left @ left + spread)
    return Linear(
        values, covariance, residual, likelihood, free, inner_free, (float(np.sqrt(own)), float(inner)), assumed
    )


def _inflation(within: Floats, stroke: Integers) -> float:
    """By how much successive points of a stroke, where they are alike, count for less than independent ones."""
    values, *_ = np.linalg.lstsq(within[:, :-1], within[:, -1], rcond=1e-9)
    left = within[:, -1] - within[:, :-1] @ values
    next_to = stroke[1:] == stroke[:-1]
    if np.count_nonzero(next_to) < PER_STROKE or not np.any(left):
        return 1.0
    alike = float(left[1:][next_to] @ left[:-1][next_to]) / float(left @ left) + 1.0 / PER_STROKE
    alike = min(max(alike, 0.0), 0.8)
    return float(np.sqrt((1.0 + alike) / (1.0 - alike)))


def _scatter(rows: Floats, independent: int) -> tuple[float, int]:
    """Standard deviation left by least squares of the last column on the others, and its degrees of freedom."""
    values, _, rank, _ = np.linalg.lstsq(rows[:, :-1], rows[:, -1], rcond=1e-9)
    free = independent - int(rank)
    left = rows[:, -1] - rows[:, :-1] @ values
    return (float(np.sqrt(left @ left / free)), free) if free > 0 else (0.0, free)
