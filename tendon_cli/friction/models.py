"""Lines through points by generalised least squares, a random intercept per stroke, averaged over their evidence.

Every set of effects is a model, weighed by its evidence (Laplace: likelihood, prior, and the share of the prior's room
that its numbers take up); μ is the mean over the models, and what they differ by is in its error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tendon_cli.friction.effects import DELAY, ENTRY, FORCE, OFFSETS, PER_STROKE, EffectModel, Points, sets_of
from tendon_cli.friction.reading.readings import Floats

_GAIN = 0.1
"""Standard deviation of the log gain before anything is read: cells are calibrated to a few per cent."""
_STRICT = {OFFSETS: 0.0, DELAY: 5.0, FORCE: 5.0, ENTRY: 3.0}
"""Log odds against an effect. Every cell has a zero error; few loggers are late, and a force dependence mimics
offsets."""
_LARGE, _GAIN_MOVES, _UNKNOWN = 1.5, 0.06, 0.20
"""A model is refused if its effects exceed 1.5 μφ, if it needs 6 % more gain, or leaves μ known to 20 % only: it
explains the readings by what cancels."""
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


@dataclass(frozen=True, eq=False)
class Products:
    """Cross products of columns within strokes and between them: all that a likelihood needs.

    The columns are those of the line, the target, and any others.
    """

    within: Floats
    between: Floats
    """Per length of stroke."""
    lengths: Floats
    strokes: Floats
    """How many of each length."""
    kappa: float
    """Share of the points within strokes that are independent."""

    @classmethod
    def of(cls, columns: list[Floats], points: Points, kappa: float) -> Products:
        """Of columns with a value per point."""
        count = np.bincount(points.stroke)
        mean = np.stack([np.bincount(points.stroke, column) / count for column in columns], axis=1)
        inner = np.column_stack(columns) - mean[points.stroke]
        lengths, many = np.unique(count, return_counts=True)
        between = np.stack([mean[count == length].T @ mean[count == length] for length in lengths])
        return cls(inner.T @ inner, between, lengths.astype(np.float64), many.astype(np.float64), kappa)

    def whitened(self, ratios: Floats) -> Floats:
        """Σ z V⁻¹ z for V = I + ratio J per stroke, for each ratio of variances between strokes and within."""
        weight = self.lengths / (1.0 + ratios[:, None] * self.lengths)
        return np.asarray(self.kappa * self.within + np.einsum("rl,lij->rij", weight, self.between))

    @property
    def size(self) -> float:
        """Independent points."""
        return float(self.kappa * np.sum(self.strokes * (self.lengths - 1.0)) + np.sum(self.strokes))


@dataclass(frozen=True, eq=False)
class Line:
    """A line at one ratio of variances between strokes and within."""

    values: Floats
    variance: float
    """Within strokes."""
    ratio: float
    loglik: float


def _line(products: Products, unknown: int, ratios: Floats, least: float) -> Line:
    """The line at the ratio that is likeliest of those given, by the restricted likelihood."""
    gram = products.whitened(ratios)[:, : unknown + 1, : unknown + 1]
    normal = gram[:, :unknown, :unknown]
    scale = np.sqrt(np.maximum(np.diagonal(normal, axis1=1, axis2=2), 1e-300))
    roots, vectors = np.linalg.eigh(normal / (scale[:, :, None] * scale[:, None, :]))
    kept = roots > 1e-13 * roots[:, -1:]
    inverse = np.einsum("rik,rk,rjk->rij", vectors, np.where(kept, 1.0 / np.where(kept, roots, 1.0), 0.0), vectors)
    target = gram[:, :unknown, -1] / scale
    values = np.einsum("rij,rj->ri", inverse, target)
    size, free = products.size, max(products.size - unknown, 1.0)
    left = gram[:, -1, -1] - np.einsum("ri,ri->r", values, target) + least * (size - np.sum(products.strokes))
    left = np.maximum(left, 0.01 * least * size)  # a tenth of that from stroke to stroke
    volume = np.log1p(ratios[:, None] * products.lengths) @ products.strokes
    determinant = np.sum(np.log(np.where(kept, roots, 1.0)), axis=1) + 2.0 * np.sum(np.log(scale), axis=1)
    at = int(np.argmax(-(free * np.log(left / free) + volume + determinant)))
    loglik = -0.5 * (size * math.log(left[at] / size) + volume[at])
    return Line(values[at] / scale[at], float(left[at]) / free, float(ratios[at]), float(loglik))


def _best_line(products: Products, unknown: int, least: float, between: int) -> Line:
    """At the ratio of variances that is likeliest; strokes of one point each, or as few as their numbers, have none."""
    if np.all(products.lengths == 1.0) or np.sum(products.strokes) <= between:
        return _line(products, unknown, np.zeros(1), least)
    grid = np.concatenate([[0.0], np.geomspace(1e-3, 1e5, 17)])
    for _ in range(3):  # to about 1 %, which moves no line
        line = _line(products, unknown, grid, least)
        at = int(np.searchsorted(grid, line.ratio))
        grid = np.linspace(grid[max(at - 1, 0)], grid[min(at + 1, len(grid) - 1)], 12)
    return line


def fit_model(points: Points, effects: tuple[str, ...], priors: dict[str, float], kappa: float) -> EffectModel:
    """One set of effects; `kappa` is the share of the points of a stroke that are independent."""
    at, offsets, zeros = 1 + int(points.both_ways), OFFSETS in effects, np.zeros(2)
    least = (_EXACT * float(np.median(np.abs(points.log_ratio)))) ** 2 * max(1.0, points.strokes / 2.0)
    limit = 0.9 * np.array([points.motor.min(), points.load.min()])
    tau = np.array([priors[name] for name in effects for _ in range(2 if name == OFFSETS else 1)])
    for step in range(_STEPS if offsets else 1):
        columns = points.columns(effects, zeros)
        target = np.log((points.motor - zeros[0]) / (points.load - zeros[1]))
        if offsets:  # the target is linear in them about where they stand
            target = target + columns[at] * zeros[0] + columns[at + 1] * zeros[1]
        unknown = len(columns)
        products = Products.of([*columns, target, 1.0 / points.motor, -1.0 / points.load], points, kappa)
        if step in {0, 3}:  # the ratio of variances changes little from step to step
            line = _best_line(products, unknown, least, at)
        else:
            line = _line(products, unknown, np.array([line.ratio]), least)
        gram = products.whitened(np.array([line.ratio]))[0]
        values, inverse, cost = _posterior(line, gram, tau)
        if offsets:
            before, zeros = zeros, np.clip(values[at : at + 2], -limit, limit)
            if step > 3 and np.all(np.abs(zeros - before) <= 1e-9 * limit):
                break
    pull = inverse[0] @ gram[:unknown, unknown + 1 :]
    evidence = line.loglik * min(1.0, _ENOUGH / points.strokes) - 0.5 * cost - sum(_STRICT[name] for name in effects)
    if at == 2:
        evidence -= 0.5 * (float(values[1]) / _GAIN) ** 2
    return EffectModel(
        effects, values, inverse * line.variance, evidence, target - np.column_stack(columns) @ values,
        points.strokes - at if points.strokes > at else max(len(target) - unknown, 1),
        (0.0, 0.0) if offsets else (float(pull[0]), float(pull[1])), at == 2,
    )  # fmt: skip


def _posterior(line: Line, gram: Floats, tau: Floats) -> tuple[Floats, Floats, float]:
    """Values and (X'V⁻¹X + σ²T⁻¹)⁻¹ if effects are 0 ± tau before anything is read, and what that costs in evidence.

    An effect that the readings do not show keeps its prior, and μ is as uncertain as that leaves it.
    """
    unknown, at = len(line.values), len(line.values) - len(tau)
    normal, target = gram[:unknown, :unknown], gram[:unknown, unknown]
    precision = normal + np.diag(np.concatenate([np.zeros(at), line.variance / tau**2]))
    scale = np.sqrt(np.maximum(np.diag(precision), 1e-300))
    back = np.outer(scale, scale)
    inverse = np.linalg.pinv(precision / back, rcond=1e-13, hermitian=True) / back
    values = inverse @ target
    moved, cross = values - line.values, precision[at:, :at]
    schur = precision[at:, at:] - cross @ np.linalg.pinv(precision[:at, :at], hermitian=True) @ cross.T
    room = float(np.linalg.slogdet(np.outer(tau, tau) * schur / line.variance)[1])
    cost = float(moved @ normal @ moved) / line.variance + float(np.sum((values[at:] / tau) ** 2)) + max(room, 0.0)
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
        return math.sqrt(float(self.weights @ [(model.friction - self.friction) ** 2 for model in self.models]))

    def share(self, effect: str) -> float:
        """Probability of an effect."""
        return float(self.weights @ [effect in model.effects for model in self.models])


def average_of(points: Points, priors: dict[str, float]) -> Average:
    """Every set of effects that is plausible, weighed by its evidence."""
    sets = sets_of(priors)
    plain = fit_model(points, (), priors, 1.0)
    kappa = _independent(points, fit_model(points, max(sets, key=len), priors, 1.0).residual)
    models = [fit_model(points, effects, priors, kappa) for effects in sets]
    models = [models[0], *(model for model in models[1:] if _is_plausible(model, plain, points))]
    evidence = np.array([model.evidence for model in models])
    weights = np.exp(evidence - evidence.max())
    return Average(tuple(models), weights / weights.sum())


def _is_plausible(model: EffectModel, plain: EffectModel, points: Points) -> bool:
    """Whether a model explains the readings by effects of a size that rigs have, and still knows μ."""
    if model.friction <= 0.0 or model.error > _UNKNOWN * model.friction:
        return False
    if abs(model.log_gain) > abs(plain.log_gain) + _GAIN_MOVES:
        return False
    shape = points.log_ratio - model.residual - model.friction * points.way * points.bend - model.log_gain
    return float(np.max(np.abs(shape))) <= _LARGE * model.friction * float(np.median(points.bend))


def _independent(points: Points, residual: Floats) -> float:
    """Share of points that are independent, from the correlation of successive ones of a stroke."""
    left = residual - (np.bincount(points.stroke, residual) / np.bincount(points.stroke))[points.stroke]
    near = points.stroke[1:] == points.stroke[:-1]
    if np.count_nonzero(near) < PER_STROKE or not np.any(np.abs(left) > 1e-14):
        return 1.0
    alike = float(left[1:][near] @ left[:-1][near]) / float(left @ left) + 1.0 / PER_STROKE
    alike = min(max(alike, 0.0), _ALIKE)
    return (1.0 - alike) / (1.0 + alike)
