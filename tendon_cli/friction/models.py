"""Lines through points by generalised least squares, a random intercept per stroke, averaged over their evidence.

Every set of effects is a model, weighed by its evidence (Laplace: likelihood, prior, and the share of the prior's room
that its numbers take up); μ is the mean over the models, and what they differ by is in its error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tendon_cli.friction.effects import OFFSETS, STRICT, EffectModel, columns_of, sets_of
from tendon_cli.friction.reading.readings import Floats
from tendon_cli.friction.usable_rows import Log

_GAIN = 0.1
"""Standard deviation of the log gain before anything is read: cells are calibrated to a few per cent."""
_GAIN_MOVES, _UNKNOWN = 0.06, 0.20
"""A model is refused if it needs 6 % more gain, or leaves μ known to 20 % only: it explains the readings by what
cancels."""
_EXACT = 1e-3
"""No rig keeps to the formula more closely than 0.1 % of its log ratio; less scatter than that is no evidence. What a
rig departs by is the same in every stroke: it counts as that of one stroke each way, however many there are."""
_ENOUGH = 40
"""Strokes beyond which a log has no more evidence of an effect: what a rig departs by repeats itself in each of them.
A log of 40 strokes and ten copies of it in a row find the same effects."""
_ALIKE = 0.8
"""Largest correlation of successive points that is believed."""
_STEPS = 8
"""Of Gauss and Newton: only the offsets are not linear, and three steps settle them."""
_RIDGE = 1e-14
"""Of the scaled normal matrix, so that columns that are alike have a solution."""


@dataclass(frozen=True, eq=False)
class Products:
    """Cross products of columns within strokes and, by their length, between them: all that a likelihood needs.

    `strokes` is how many there are of each length, `size` the number of independent points.
    """

    within: Floats
    between: Floats
    lengths: Floats
    strokes: Floats
    size: float

    @classmethod
    def of(cls, columns: list[Floats], points: Log, kappa: float) -> Products:
        """`kappa` is the share of the points of a stroke that are independent."""
        count = np.bincount(points.stroke)
        mean = np.stack([np.bincount(points.stroke, column) / count for column in columns], axis=1)
        inner = np.column_stack(columns) - mean[points.stroke]
        lengths, many = np.unique(count, return_counts=True)
        between = np.stack([mean[count == length].T @ mean[count == length] for length in lengths])
        size = float(kappa * (len(inner) - len(count)) + len(count))
        return cls(
            kappa * inner.T @ inner,
            between,
            lengths.astype(np.float64),
            many.astype(np.float64),
            size,
        )

    def whitened(self, ratios: Floats) -> Floats:
        """Σ z V⁻¹ z for V = I + ratio J per stroke, for each ratio of variances between strokes and within."""
        weight = self.lengths / (1.0 + ratios[:, None] * self.lengths)
        return np.asarray(self.within + np.einsum("rl,lij->rij", weight, self.between))


@dataclass(frozen=True, eq=False)
class Line:
    """A line with its variance within strokes, at one ratio of that between strokes to it."""

    values: Floats
    variance: float
    ratio: float
    loglik: float


def _line(products: Products, unknown: int, ratios: Floats, least: float) -> Line:
    """The line at the ratio that is likeliest of those given, by the restricted likelihood."""
    gram, strokes = products.whitened(ratios), float(products.strokes.sum())
    scale = np.sqrt(np.maximum(np.diagonal(gram, axis1=1, axis2=2)[:, :unknown], 1e-300))
    normal = gram[:, :unknown, :unknown] / (
        scale[:, :, None] * scale[:, None, :]
    ) + _RIDGE * np.eye(unknown)
    target = gram[:, :unknown, unknown] / scale
    values = np.linalg.solve(normal, target[:, :, None])[:, :, 0]
    size, free = products.size, max(products.size - unknown, 1.0)
    left = gram[:, unknown, unknown] - np.sum(values * target, axis=1) + least * (size - strokes)
    left = np.maximum(left, 0.01 * least * size)  # a tenth of that from stroke to stroke
    volume = np.log1p(ratios[:, None] * products.lengths) @ products.strokes
    determinant = np.linalg.slogdet(normal)[1] + 2.0 * np.sum(np.log(scale), axis=1)
    at = int(np.argmax(-(free * np.log(left / free) + volume + determinant)))
    loglik = -0.5 * (size * math.log(left[at] / size) + volume[at])
    return Line(values[at] / scale[at], float(left[at]) / free, float(ratios[at]), float(loglik))


def _best_line(products: Products, unknown: int, least: float, base: int) -> Line:
    """At the ratio of variances that is likeliest; strokes of one point each, or as few as their numbers, have none."""
    if np.all(products.lengths == 1.0) or products.strokes.sum() <= base:
        return _line(products, unknown, np.zeros(1), least)
    grid = np.concatenate([[0.0], np.geomspace(1e-3, 1e5, 17)])
    for _ in range(3):  # to about 1 %, which moves no line
        line = _line(products, unknown, grid, least)
        at = int(np.searchsorted(grid, line.ratio))
        grid = np.linspace(grid[max(at - 1, 0)], grid[min(at + 1, len(grid) - 1)], 12)
    return line


def fit_model(
    points: Log, effects: tuple[str, ...], priors: dict[str, float], kappa: float
) -> EffectModel:
    """One set of effects; `kappa` is the share of the points of a stroke that are independent."""
    base, zeros, fits_offsets = 1 + points.both_ways, np.zeros(2), OFFSETS[0] in effects
    unknown, strokes = base + len(effects), points.strokes
    least = (_EXACT * float(np.median(np.abs(points.log_ratio)))) ** 2 * max(1.0, strokes / 2.0)
    limit = 0.9 * np.array([points.motor.min(), points.load.min()])
    tau = np.array([priors[name] for name in effects])
    for step in range(_STEPS if fits_offsets else 1):
        columns = columns_of(points, effects, zeros)
        target = np.log((points.motor - zeros[0]) / (points.load - zeros[1]))
        if fits_offsets:  # the target is linear in them about where they stand
            target = target + columns[base] * zeros[0] + columns[base + 1] * zeros[1]
        products = Products.of(
            [*columns, target, 1.0 / points.motor, -1.0 / points.load], points, kappa
        )
        if step in {0, 3}:  # the ratio of variances changes little from step to step
            line = _best_line(products, unknown, least, base)
        else:
            line = _line(products, unknown, np.array([line.ratio]), least)
        gram = products.whitened(np.array([line.ratio]))[0]
        values, inverse, cost = _posterior(line, gram, tau)
        if fits_offsets:
            before, zeros = zeros, np.clip(values[base : base + 2], -limit, limit)
            if step > 3 and np.all(np.abs(zeros - before) <= 1e-9 * limit):
                break
    pull = inverse[0] @ gram[:unknown, unknown + 1 :]
    cost += 2.0 * sum(STRICT.get(name, 0.0) for name in effects)
    cost += (float(values[1]) / _GAIN) ** 2 if base == 2 else 0.0
    return EffectModel(
        effects,
        values,
        inverse * line.variance,
        line.loglik * min(1.0, _ENOUGH / strokes) - 0.5 * cost,
        target - np.column_stack(columns) @ values,
        strokes - base if strokes > base else max(len(target) - unknown, 1),
        (0.0, 0.0) if fits_offsets else (float(pull[0]), float(pull[1])),
    )


def _posterior(line: Line, gram: Floats, tau: Floats) -> tuple[Floats, Floats, float]:
    """Values and (X'V⁻¹X + σ²T⁻¹)⁻¹ if effects are 0 ± tau before anything is read, and what that costs in evidence.

    An effect that the readings do not show keeps its prior, and μ is as uncertain as that leaves it.
    """
    unknown, base = len(line.values), len(line.values) - len(tau)
    normal, target = gram[:unknown, :unknown], gram[:unknown, unknown]
    precision = normal + np.diag(np.concatenate([np.zeros(base), line.variance / tau**2]))
    scale = np.sqrt(np.maximum(np.diag(precision), 1e-300))
    back = np.outer(scale, scale)
    inverse = np.linalg.inv(precision / back + _RIDGE * np.eye(unknown)) / back
    values = inverse @ target
    moved = values - line.values
    # The room of the effects, ln det of their prior over their posterior covariance, which is part of the inverse.
    room = -float(np.linalg.slogdet(inverse[base:, base:] * line.variance / np.outer(tau, tau))[1])
    cost = (
        float(moved @ normal @ moved) / line.variance
        + float(np.sum((values[base:] / tau) ** 2))
        + max(room, 0.0)
    )
    return values, inverse, cost


@dataclass(frozen=True, eq=False)
class Average:
    """The models with their weights, and μ over them."""

    models: tuple[EffectModel, ...]
    weights: Floats

    @property
    def best(self) -> EffectModel:
        """The likeliest."""
        return self.models[int(np.argmax(self.weights))]

    @property
    def friction(self) -> float:
        """μ, the mean over the models."""
        return float(self.weights @ [model.friction for model in self.models])

    @property
    def log_gain(self) -> float:
        """ln g, the same."""
        return float(self.weights @ [model.log_gain for model in self.models])

    @property
    def scatter(self) -> float:
        """Standard error of μ from how strokes scatter, each model given."""
        return math.sqrt(float(self.weights @ [model.error**2 for model in self.models]))

    @property
    def spread(self) -> float:
        """Standard deviation of μ over the models."""
        return math.sqrt(
            float(self.weights @ [(model.friction - self.friction) ** 2 for model in self.models])
        )


def average_of(points: Log, priors: dict[str, float]) -> Average:
    """Every set of effects that is plausible, weighed by its evidence."""
    sets = sets_of(priors)
    kappa = _independent(points, fit_model(points, max(sets, key=len), priors, 1.0).residual)
    plain, *others = (fit_model(points, effects, priors, kappa) for effects in sets)
    models = (plain, *(model for model in others if _is_plausible(model, plain)))
    evidence = np.array([model.evidence for model in models])
    weights = np.exp(evidence - evidence.max())
    return Average(models, weights / weights.sum())


def _is_plausible(model: EffectModel, plain: EffectModel) -> bool:
    return (
        model.error < _UNKNOWN * model.friction
        and abs(model.log_gain) <= abs(plain.log_gain) + _GAIN_MOVES
    )


def _independent(points: Log, residual: Floats) -> float:
    """Share of points that are independent, from the correlation of successive ones of a stroke."""
    count = np.bincount(points.stroke)
    left = residual - (np.bincount(points.stroke, residual) / count)[points.stroke]
    near = points.stroke[1:] == points.stroke[:-1]
    if not near.any() or not np.any(np.abs(left) > 1e-14):
        return 1.0
    alike = float(left[1:][near] @ left[:-1][near]) / float(left @ left) + 1.0 / float(count.max())
    alike = min(max(alike, 0.0), _ALIKE)
    return (1.0 - alike) / (1.0 + alike)
