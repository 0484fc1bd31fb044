"""μ, gain and offsets from strokes, with their standard error: SciPy's least squares around the model's own sheath.

One stroke is one observation. Its rows share its friction, its load and its cells, so their number says little; what
is averaged is the mean log ratio of each stroke, and strokes are what is counted (Student's t with strokes minus
parameters degrees of freedom, exact for strokes that scatter alike).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tendon_cli.friction.reading.readings import Floats, Integers
from tendon_cli.model.sheath import capstan_ratio

_MOST_GROUPS = 60
_PIECES = 8


@dataclass(frozen=True, eq=False)
class Slipping:
    """The readings in use: forces, way, bend angle and stroke (0, 1, ... without gaps) of each."""

    motor: Floats
    load: Floats
    way: Integers
    bend_angle: Floats
    stroke: Integers

    @property
    def log_ratio(self) -> Floats:
        """ln(force at motor / force at load)."""
        return np.asarray(np.log(self.motor / self.load))

    def of(self, chosen: npt.NDArray[np.bool_]) -> Slipping:
        """Some of the readings, their strokes numbered anew."""
        _, stroke = np.unique(self.stroke[chosen], return_inverse=True)
        return Slipping(self.motor[chosen], self.load[chosen], self.way[chosen], self.bend_angle[chosen], stroke)


@dataclass(frozen=True, eq=False)
class Estimate:
    """μ with the standard error that the scatter of the strokes gives it."""

    friction: float
    log_gain: float
    offsets: tuple[float, float] | None
    standard_error: float
    degrees_of_freedom: int
    weights: Floats
    """Share of each reading's log ratio in μ."""


def log_ratio_of(friction: float, log_gain: float, way: Integers, bend_angle: Floats) -> Floats:
    """The fitted line: motor over load is the inverse of the sheath's distal over proximal, times the gain ratio."""
    return np.asarray(log_gain - np.log(capstan_ratio(friction, bend_angle, -way.astype(np.float64))))


def per_stroke(slipping: Slipping, values: Floats, average: Callable[[Floats], np.floating] = np.mean) -> Floats:
    """The average of each stroke."""
    if average is np.mean:
        return np.asarray(np.bincount(slipping.stroke, values) / np.bincount(slipping.stroke))
    order = np.argsort(slipping.stroke, kind="stable")
    parts = np.split(values[order], np.cumsum(np.bincount(slipping.stroke))[:-1])
    return np.array([average(part) for part in parts])


def by_least_squares(slipping: Slipping, with_gain: bool) -> Estimate:
    """μ, and the gain if it can be told, from the mean log ratio of each stroke; strokes count alike."""
    from scipy.optimize import curve_fit

    way = np.sign(per_stroke(slipping, slipping.way.astype(np.float64))).astype(np.int64)
    angle = per_stroke(slipping, slipping.bend_angle)

    def line(_: Floats, friction: float, log_gain: float = 0.0) -> Floats:
        return log_ratio_of(friction, log_gain, way, angle)

    mean = per_stroke(slipping, slipping.log_ratio)
    start = [0.1, 0.0] if with_gain else [0.1]
    # The line is straight in both parameters, so its slopes are known; finite differences fail where the gain is 1.
    design = np.stack([way * angle, np.ones(len(way))][: len(start)], axis=1)
    values, covariance = curve_fit(line, angle, mean, p0=start, jac=lambda *_: design, xtol=1e-14, ftol=1e-14)
    share = np.linalg.pinv(design)[0] / np.bincount(slipping.stroke)
    return Estimate(
        friction=float(values[0]),
        log_gain=float(values[1]) if with_gain else 0.0,
        offsets=None,
        standard_error=float(np.sqrt(covariance[0, 0])),
        degrees_of_freedom=len(mean) - len(start),
        weights=share[slipping.stroke],
    )


def by_leaving_out(slipping: Slipping, with_gain: bool, offset: bool, robust: bool) -> Estimate:
    """The same with a robust loss or with the cells' zero offsets, standard error by leaving out one stroke at a time.

    Neither has an exact standard error; the jackknife over strokes has the right clusters and is, if anything, wide.
    """
    plain = by_least_squares(slipping, with_gain)
    values = _solve(slipping, with_gain, offset, robust)
    groups = np.arange(slipping.stroke.max() + 1) * min(_MOST_GROUPS, slipping.stroke.max() + 1)
    group = (groups // (slipping.stroke.max() + 1))[slipping.stroke]
    count = int(group.max()) + 1
    without = np.array([_solve(slipping.of(group != left), with_gain, offset, robust)[0] for left in range(count)])
    variance = (count - 1) / count * float(np.sum((without - values[0]) ** 2))
    return Estimate(
        friction=float(values[0]),
        log_gain=float(values[1]),
        offsets=(float(values[2]), float(values[3])) if offset else None,
        standard_error=float(np.sqrt(variance)),
        degrees_of_freedom=count - 1 - int(with_gain) - 2 * int(offset),
        weights=plain.weights,
    )


def _solve(slipping: Slipping, with_gain: bool, offset: bool, robust: bool) -> Floats:
    """μ, log gain, offset of the motor's cell, offset of the load's cell."""
    from scipy.optimize import least_squares

    points = pieces_of(slipping) if offset else slipping
    average: Callable[[Floats], np.floating] = np.median if robust else np.mean
    way, angle, motor, load = (
        per_stroke(points, column, average)
        for column in (points.way.astype(np.float64), points.bend_angle, points.motor, points.load)
    )
    mean = per_stroke(points, points.log_ratio, average)
    free = np.array([True, with_gain, offset, offset])
    size = np.array([1.0, 1.0, float(np.mean(motor)), float(np.mean(load))])
    limit = np.array([np.inf, np.inf, 0.999 * motor.min(), 0.999 * load.min()]) / size

    def residuals(given: Floats) -> Floats:
        values = np.zeros(4)
        values[free] = given
        values *= size
        seen = np.log((motor - values[2]) / (load - values[3])) if offset else mean
        return seen - log_ratio_of(values[0], values[1], way.astype(np.int64), angle)

    start = by_least_squares(slipping, with_gain)
    first = np.array([start.friction, start.log_gain, 0.0, 0.0])[free]
    left = residuals(first)
    spread = 1.4826 * float(np.median(np.abs(left - np.median(left))))
    found = least_squares(
        residuals,
        first,
        bounds=(-np.inf, limit[free]),
        x_scale=0.1,
        xtol=1e-13,
        ftol=1e-13,
        gtol=1e-13,
        loss="soft_l1" if robust else "linear",
        f_scale=max(spread, 1e-6),
    )
    values = np.zeros(4)
    values[free] = found.x
    return np.asarray(values * size)


def pieces_of(slipping: Slipping) -> Slipping:
    """The readings with each stroke cut into up to eight pieces, so that the force levels within it show."""
    position = np.arange(len(slipping.stroke)) - np.searchsorted(slipping.stroke, slipping.stroke)
    length = np.bincount(slipping.stroke)[slipping.stroke]
    piece = slipping.stroke * _PIECES + position * np.minimum(_PIECES, length) // length
    _, stroke = np.unique(piece, return_inverse=True)
    return Slipping(slipping.motor, slipping.load, slipping.way, slipping.bend_angle, stroke)
