"""Lines through points by generalised least squares, a random intercept per stroke, averaged over their evidence.

Every set of effects is a model, weighed by its evidence (Laplace: likelihood, prior, and the share of the prior's room
that its numbers take up); μ is the mean over the models, and what they differ by is in its error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tendon_cli.friction.effects import DELAY, ENTRY, FORCE, OFFSETS, PER_STROKE, EffectModel, EffectPriors, Points
from tendon_cli.friction.reading.readings import Floats

_GAIN = 0.1
"""Standard deviation of the log gain before anything is read: cells are calibrated to a few per cent."""
_STRICT = {OFFSETS: 0.0, DELAY: 5.0, FORCE: 5.0, ENTRY: 3.0}
"""Log odds against an effect. Every cell has a zero error; few loggers are late, and a force dependence mimics
offsets."""
_LARGE, _GAIN_MOVES, _UNKNOWN = 1.5, 0.06, 0.20
"""A model is refused if its effects exceed 1.5 μφ, if it needs 6 % more gain, or leaves μ known to 20 % only: it
explains
the readings by what cancels."""
_EXACT = 1e-3
"""No rig keeps to the formula more closely than 0.1 % of its log ratio; less scatter than that is no evidence."""
_ALIKE = 0.8
"""Largest correlation of successive points that is believed."""


@dataclass(frozen=True, eq=False)
class Products:
    """Cross products of columns within strokes and between them: all that a likelihood needs."""

    within: Floats
    between: Floats
    """Per length of stroke."""
    lengths: Floats
    strokes: Floats
    """How many of each length."""
    kappa: float
    """Share of the points within strokes that are independent."""

    def whitened(self, ratios: Floats) -> Floats:
        """Σ z V⁻¹ z for V = I + ratio J per stroke, for each ratio."""
        weight = self.lengths / (1.0 + ratios[:, None] * self.lengths)
        return np.asarray(self.kappa * self.within + np.einsum("rl,lij->rij", weight, self.between))

    @property
    def size(self) -> float:
        """Independent points."""
        return float(self.kappa * np.sum(self.strokes * (self.lengths - 1.0)) + np.sum(self.strokes))


def products_of(columns: Floats, points: Points, kappa: float) -> Products:
    """Of columns of shape (points, columns)."""
    count = np.bincount(points.stroke)
    mean = np.stack([np.bincount(points.stroke, column) / count for column in columns.T], axis=1)
    inner = columns - mean[points.stroke]
    lengths = np.unique(count)
    between = np.stack([mean[count == length].T @ mean[count == length] for length in lengths])
    many = np.array([np.count_nonzero(count == length) for length in lengths], dtype=np.float64)
    return Products(inner.T @ inner, between, lengths.astype(np.float64), many, kappa)


@dataclass(frozen=True, eq=False)
class Line:
    """A line at one ratio of variances."""

    values: Floats
    inverse: Floats
    """(X'V⁻¹X)⁻¹, to be multiplied by `variance`."""
    variance: float
    ratio: float
    loglik: float


def _line(products: Products, unknown: int, ratios: Floats, least: float) -> Line:
    """The line at the ratio that is likeliest of those given, by the restricted likelihood."""
    gram = products.whitened(ratios)
    own = gram[:, :unknown, :unknown]
    scale = np.sqrt(np.maximum(np.diagonal(own, axis1=1, axis2=2), 1e-300))
    scaled = own / (scale[:, :, None] * scale[:, None, :])
    roots, vectors = np.linalg.eigh(scaled)
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
    back = np.outer(scale[at], scale[at])
    return Line(values[at] / scale[at], inverse[at] / back, float(left[at]) / free, float(ratios[at]), float(loglik))


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


def fit_model(points: Points, effects: tuple[str, ...], candidates: EffectPriors, kappa: float) -> EffectModel:
    """One set of effects by Gauss and Newton: only the offsets are not linear, and three steps settle them."""
    both = points.both_ways
    zeros = np.zeros(2)
    at = 1 + int(both)
    least = (_EXACT * float(np.median(np.abs(points.log_ratio)))) ** 2
    limit = 0.9 * np.array([points.motor.min(), points.load.min()])
    for step in range(8 if OFFSETS in effects else 1):
        columns = points.columns(effects, zeros)
        target = np.log((points.motor - zeros[0]) / (points.load - zeros[1]))
        if OFFSETS in effects:  # offsets come first among effects; the target is linear in them about where they stand
            target = target + columns[at] * zeros[0] + columns[at + 1] * zeros[1]
        lean = np.stack([1.0 / points.motor, -1.0 / points.load], axis=1)
        table = np.column_stack([*columns, lean, target])
        products = products_of(table, points, kappa)
        unknown = len(columns)
        bare = _without(products, unknown)
        if OFFSETS not in effects:
            line = _best_line(bare, unknown, least, at)
            break
        # The ratio of variances changes little from step to step.
        line = (
            _best_line(bare, unknown, least, at)
            if step in {0, 3}
            else _line(bare, unknown, np.array([line.ratio]), least)
        )
        new = np.clip(line.values[at : at + 2], -limit, limit)
        settled, zeros = bool(np.all(np.abs(new - zeros) <= 1e-9 * limit)), new
        if settled and step > 3:
            break
    gram = products.whitened(np.array([line.ratio]))[0]
    pull = (line.inverse @ gram[:unknown, unknown : unknown + 2])[0]
    zero = (0.0, 0.0) if OFFSETS in effects else (float(pull[0]), float(pull[1]))
    residual = target - np.column_stack(columns) @ line.values
    covariance = line.inverse * line.variance
    free = points.strokes - at if points.strokes > at else max(len(target) - unknown, 1)
    return EffectModel(
        effects, line.values, covariance, _evidence(line, covariance, effects, candidates, both), residual,
        math.sqrt(line.ratio * line.variance), math.sqrt(line.variance), free, zero, both,
    )  # fmt: skip


def _without(products: Products, unknown: int) -> Products:
    """The products of the line's own columns and the target."""
    keep = np.r_[:unknown, unknown + 2]
    return Products(
        products.within[np.ix_(keep, keep)], products.between[:, keep][:, :, keep], products.lengths,
        products.strokes, products.kappa,
    )  # fmt: skip


def _evidence(line: Line, covariance: Floats, effects: tuple[str, ...], candidates: EffectPriors, both: bool) -> float:
    """Log of the probability of the readings under a model, but for a constant."""
    at = 1 + int(both)
    gain = float(line.values[1]) if both else 0.0
    tau = np.array([candidates.prior[name] for name in effects for _ in range(2 if name == OFFSETS else 1)])
    log = line.loglik - 0.5 * (gain / _GAIN) ** 2 - sum(_STRICT[name] for name in effects)
    if len(tau):
        own = covariance[at:, at:]
        log -= 0.5 * float(np.sum((line.values[at:] / tau) ** 2))
        log -= 0.5 * max(
            float(np.linalg.slogdet(np.eye(len(tau)) + np.diag(tau**2) @ np.linalg.pinv(own, hermitian=True))[1]), 0.0
        )
    return float(log)


@dataclass(frozen=True, eq=False)
class Average:
    """The models with their weights, and μ over them."""

    models: tuple[EffectModel, ...]
    weights: Floats
    candidates: EffectPriors

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
        return math.sqrt(float(self.weights @ [model.covariance[0, 0] for model in self.models]))

    @property
    def doubt(self) -> float:
        """Standard deviation of μ over the models."""
        return math.sqrt(float(self.weights @ [(model.friction - self.friction) ** 2 for model in self.models]))

    def share(self, effect: str) -> float:
        """Probability of an effect."""
        return float(sum(w for w, model in zip(self.weights, self.models, strict=True) if effect in model.effects))


def average_of(points: Points, candidates: EffectPriors) -> Average:
    """Every set of effects that is plausible, weighed."""
    plain = fit_model(points, (), candidates, 1.0)
    richest = max(candidates.sets(), key=len)
    kappa = _independent(points, fit_model(points, richest, candidates, 1.0).residual)
    models = [fit_model(points, effects, candidates, kappa) for effects in candidates.sets()]
    models = [models[0]] + [model for model in models[1:] if _is_plausible(model, plain, points)]
    evidence = np.array([model.evidence for model in models])
    weights = np.exp(evidence - evidence.max())
    return Average(tuple(models), weights / weights.sum(), candidates)


def _is_plausible(model: EffectModel, plain: EffectModel, points: Points) -> bool:
    """Whether a model explains the readings by effects of a size that rigs have, and still knows μ."""
    error = math.sqrt(max(float(model.covariance[0, 0]), 0.0))
    if model.friction <= 0.0 or error > _UNKNOWN * model.friction:
        return False
    if abs(model.log_gain) > abs(plain.log_gain) + _GAIN_MOVES:
        return False
    shape = points.log_ratio - model.residual - model.friction * points.way * points.bend - model.log_gain
    return float(np.max(np.abs(shape))) <= _LARGE * model.friction * float(np.median(points.bend))


def _independent(points: Points, residual: Floats) -> float:
    """Share of points that are independent, from the correlation of successive ones of a stroke."""
    count = np.bincount(points.stroke)
    left = residual - (np.bincount(points.stroke, residual) / count)[points.stroke]
    near = points.stroke[1:] == points.stroke[:-1]
    if np.count_nonzero(near) < PER_STROKE or not np.any(np.abs(left) > 1e-14):
        return 1.0
    alike = float(left[1:][near] @ left[:-1][near]) / float(left @ left) + 1.0 / PER_STROKE
    alike = min(max(alike, 0.0), _ALIKE)
    return (1.0 - alike) / (1.0 + alike)
