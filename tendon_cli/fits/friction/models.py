"""Lines through points by generalised least squares, averaged over sets of effects.

A line has a random intercept per stroke. Every set of effects is a model, weighed by its evidence
(Laplace: likelihood, prior, and the share of the prior's room that its numbers take up); μ is the
mean over the models, and its error includes their spread.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tendon_cli.fits.friction.effects import (
    DELAY,
    FORCE,
    OFFSETS,
    STRICT,
    EffectModel,
    columns_of,
    sets_of,
    with_one_force,
)
from tendon_cli.fits.friction.usable_rows import Log
from tendon_cli.fits.log_rows import Floats, means_by

_GAIN = 0.1
"""Prior standard deviation of the log gain: cells are calibrated to a few per cent."""
_GAIN_MOVES = 0.06
"""Increase of the log gain from which a model is refused: it explains the readings by a gain,
which cancels between the directions."""
_UNKNOWN = 0.20
"""Standard error of μ, as a share of it, from which a model is refused, for the same reason."""
_LARGEST_ZERO = 0.25
"""Zero error, as a share of the usual force, from which a model is refused: it explains by zero
errors that nobody overlooks how the force bends the line for another reason."""
_EXACT = 1e-3
"""Least scatter, as a share of the log ratio: no rig keeps to the formula more closely, so a
smaller one is no evidence. A rig departs from the formula in the same way in every stroke, so the
departure counts as that of one stroke each way, however many there are."""
_ENOUGH = 40
"""Strokes beyond which a log has no more evidence of an effect: the departure of a rig from the
formula repeats itself in each of them. A log of 40 strokes and ten copies of it in a row find the
same effects."""
REFUTED = 7.0
"""Log odds from which the readings refute an explanation, one in a thousand: they repeat their
departure from the formula, and smaller odds come about by that."""
_SIMPLER = math.log(2.0)
"""Log odds of one number before two that explain the readings as well."""
_ALIKE = 0.8
"""Largest correlation of successive points that is believed."""
_STEPS = 8
"""Largest number of Gauss-Newton steps: only the offsets are not linear, and settle in three."""
_RATIOS = np.concatenate([[0.0], np.geomspace(1e-3, 1e5, 17)])
"""Ratios of the variance between strokes to that within them that are tried first."""
_RIDGE = 1e-14
"""Ridge of the scaled normal matrix, so that collinear columns have a solution."""


@dataclass(frozen=True, eq=False)
class CrossProducts:
    """Cross products of columns within strokes and between them: all that a likelihood needs."""

    within: Floats
    """Sum over all strokes (columns, columns)."""
    between: Floats
    """Sums over the means of strokes of each length (lengths, columns, columns)."""
    lengths: Floats
    """Numbers of points that strokes have."""
    strokes: Floats
    """Number of strokes of each length."""
    size: float
    """Number of independent points."""

    @classmethod
    def of(cls, columns: list[Floats], points: Log, kappa: float) -> CrossProducts:
        """Return the products of columns; `kappa` is the share of points that are independent."""
        count = np.bincount(points.stroke)
        mean = np.stack([means_by(points.stroke, column) for column in columns], axis=1)
        inner = np.column_stack(columns) - mean[points.stroke]
        lengths, strokes = np.unique(count, return_counts=True)
        between = np.stack([mean[count == length].T @ mean[count == length] for length in lengths])
        return cls(
            within=kappa * inner.T @ inner,
            between=between,
            lengths=lengths.astype(np.float64),
            strokes=strokes.astype(np.float64),
            size=kappa * (len(inner) - len(count)) + len(count),
        )

    def whitened(self, ratios: Floats) -> Floats:
        """Return Σ zᵀV⁻¹z with V = I + ratio J per stroke (ratios, columns, columns).

        Each ratio is that of the variance between strokes to the variance within.
        """
        weight = self.lengths / (1.0 + ratios[:, None] * self.lengths)  # (ratios, lengths)
        return np.asarray(self.within + np.einsum("rl,lij->rij", weight, self.between))


@dataclass(frozen=True, eq=False)
class Line:
    """Line that is fitted to points, with the variances of the points."""

    values: Floats
    """Fitted numbers: μ, ln g and the effects."""
    variance: float
    """Variance within strokes."""
    ratio: float
    """Variance between strokes over that within."""
    loglik: float
    """Log likelihood."""


def _line(products: CrossProducts, unknown: int, ratios: Floats, least: float) -> Line:
    """Fit the line at each ratio of variances, and return the likeliest.

    Args:
        products: Cross products of `unknown` columns, of the target, and of more that are not used.
        unknown: Number of columns that the line is fitted to.
        ratios: Ratios of the variance between strokes to the variance within.
        least: Least variance of a point.

    Returns:
        The line of largest restricted likelihood.
    """
    gram = products.whitened(ratios)  # (ratios, columns, columns)
    strokes = products.strokes.sum()
    diagonal = np.diagonal(gram, axis1=1, axis2=2)[:, :unknown]
    scale = np.sqrt(np.maximum(diagonal, 1e-300))  # (ratios, unknown)
    outer = scale[:, :, None] * scale[:, None, :]
    normal = gram[:, :unknown, :unknown] / outer + _RIDGE * np.eye(unknown)
    target = gram[:, :unknown, unknown] / scale
    values = np.linalg.solve(normal, target[:, :, None])[:, :, 0]
    size = products.size
    free = max(size - unknown, 1.0)
    squares = gram[:, unknown, unknown] - np.sum(values * target, axis=1)
    squares = squares + least * (size - strokes)
    squares = np.maximum(squares, 0.01 * least * size)  # a tenth of the least scatter
    log_det_v = np.log1p(ratios[:, None] * products.lengths) @ products.strokes
    log_det_normal = np.linalg.slogdet(normal)[1] + 2.0 * np.sum(np.log(scale), axis=1)
    cost = free * np.log(squares / free) + log_det_v + log_det_normal
    best = int(np.argmax(-cost))
    loglik = -0.5 * (size * math.log(squares[best] / size) + log_det_v[best])
    return Line(
        values=values[best] / scale[best],
        variance=squares[best] / free,
        ratio=ratios[best],
        loglik=float(loglik),
    )


def _best_line(products: CrossProducts, unknown: int, least: float, base: int) -> Line:
    """Return the line at the likeliest ratio of variances.

    The ratio is 0 if strokes have one point each, or are as few as the `base` numbers that every
    model has: nothing then tells the two variances apart.
    """
    if np.all(products.lengths == 1.0) or products.strokes.sum() <= base:
        return _line(products, unknown, np.zeros(1), least)
    grid = _RATIOS
    for _ in range(3):  # to about 1 %, which moves no line
        line = _line(products, unknown, grid, least)
        place = int(np.searchsorted(grid, line.ratio))
        low = grid[max(place - 1, 0)]
        high = grid[min(place + 1, len(grid) - 1)]
        grid = np.linspace(low, high, 12)
    return line


def fit_model(
    points: Log, effects: tuple[str, ...], priors: dict[str, float], kappa: float
) -> EffectModel:
    """Fit one set of effects.

    Args:
        points: Means over parts of strokes.
        effects: Names of the effects that are fitted beside μ and the gain.
        priors: Prior standard deviation of each effect.
        kappa: Share of the points of a stroke that are independent.
    """
    base = 1 + points.both_ways  # μ, and ln g if it can be told from μ
    unknown = base + len(effects)
    strokes = points.strokes
    places = [base + effects.index(name) if name in effects else None for name in OFFSETS]
    fits_offsets = places != [None, None]
    zeros = np.zeros(2)  # offsets of the motor's and of the load's cell
    least = (_EXACT * np.median(np.abs(points.log_ratio))) ** 2 * max(1.0, strokes / 2.0)
    limit = 0.9 * np.array([points.motor.min(), points.load.min()])
    tau = np.array([priors[name] for name in effects])
    steps = _STEPS if fits_offsets else 1
    forces = with_one_force(points)
    rate = np.zeros(len(points.way)) if points.rate is None else points.rate
    for step in range(steps):
        columns = columns_of(forces, effects, zeros)
        target = np.log((points.motor - zeros[0]) / (points.load - zeros[1]))
        for cell, place in enumerate(places):
            if place is not None:  # the target is linear in an offset about its last value
                target = target + columns[place] * zeros[cell]
        unseen = [1.0 / points.motor, -1.0 / points.load, rate]
        products = CrossProducts.of([*columns, target, *unseen], points, kappa)
        if step in {0, 3}:  # the ratio of variances changes little from step to step
            line = _best_line(products, unknown, least, base)
        else:
            line = _line(products, unknown, np.array([line.ratio]), least)
        gram = products.whitened(np.array([line.ratio]))[0]
        values, inverse, cost = _posterior(line, gram, tau)
        if fits_offsets:
            before = zeros
            fitted = [0.0 if place is None else values[place] for place in places]
            zeros = np.clip(fitted, -limit, limit)
            tau = np.maximum(tau, _room_of(effects, values[base:]))
            if step > 3 and np.all(np.abs(zeros - before) <= 1e-9 * limit):
                break
    slopes = inverse[0] @ gram[:unknown, unknown + 1 :]
    cost += 2.0 * sum(STRICT.get(name, 0.0) for name in effects)
    if base == 2:
        cost += (values[1] / _GAIN) ** 2
    unfitted = [place is None for place in places]
    return EffectModel(
        effects=effects,
        values=values,
        covariance=inverse * line.variance,
        evidence=line.loglik * min(1.0, _ENOUGH / strokes) - 0.5 * cost,
        residual=target - np.column_stack(columns) @ values,
        free=strokes - base if strokes > base else max(len(target) - unknown, 1),
        zero=(slopes[0] * unfitted[0], slopes[1] * unfitted[1]),
        late=slopes[2] * (DELAY not in effects),
    )


def _room_of(effects: tuple[str, ...], values: Floats) -> Floats:
    """Return by how much each effect may widen its prior, so that a large one is not drawn in.

    One cell may have a zero error beyond any prior. Both do not have the same: as much of the zero
    errors as is alike is friction that seems to depend on the force.
    """
    room = np.abs(values)
    if set(OFFSETS) <= set(effects):
        both = [effects.index(name) for name in OFFSETS]
        room[both] = abs(values[both[0]] - values[both[1]])
    return room


def _posterior(line: Line, gram: Floats, tau: Floats) -> tuple[Floats, Floats, float]:
    """Return the line's values under the prior that the effects are 0 ± tau.

    An effect that the readings do not show keeps its prior, and μ is as uncertain as that leaves
    it.

    Returns:
        Values, (X'V⁻¹X + σ²T⁻¹)⁻¹, and the cost of the prior in evidence.
    """
    unknown = len(line.values)
    base = unknown - len(tau)
    normal = gram[:unknown, :unknown]
    target = gram[:unknown, unknown]
    precision = normal + np.diag(np.concatenate([np.zeros(base), line.variance / tau**2]))
    scale = np.sqrt(np.maximum(np.diag(precision), 1e-300))
    outer = np.outer(scale, scale)
    inverse = np.linalg.inv(precision / outer + _RIDGE * np.eye(unknown)) / outer
    values = inverse @ target
    moved = values - line.values
    # The room of the effects, ln det of their prior over their posterior covariance, which is part
    # of the inverse.
    posterior = inverse[base:, base:] * line.variance
    room = -np.linalg.slogdet(posterior / np.outer(tau, tau))[1]
    misfit = float(moved @ normal @ moved) / line.variance
    departure = np.sum((values[base:] / tau) ** 2)
    cost = misfit + departure + max(room, 0.0)
    return values, inverse, cost


@dataclass(frozen=True, eq=False)
class ModelAverage:
    """Models with their weights, and μ over them."""

    models: tuple[EffectModel, ...]
    weights: Floats

    @property
    def best(self) -> EffectModel:
        """Likeliest model."""
        return self.models[int(np.argmax(self.weights))]

    def share_of(self, effect: str) -> float:
        """Return the probability of an effect."""
        return sum(
            float(weight)
            for model, weight in zip(self.models, self.weights, strict=True)
            if effect in model.effects
        )

    @property
    def friction(self) -> float:
        """μ, the mean over the models."""
        return float(self.weights @ [model.friction for model in self.models])

    @property
    def log_gain(self) -> float:
        """ln g, the mean over the models."""
        return float(self.weights @ [model.log_gain for model in self.models])

    @property
    def scatter(self) -> float:
        """Standard error of μ from the scatter of the strokes, averaged over the models."""
        return math.sqrt(self.weights @ [model.error**2 for model in self.models])

    @property
    def spread(self) -> float:
        """Standard deviation of μ over the models."""
        squares = [(model.friction - self.friction) ** 2 for model in self.models]
        return math.sqrt(self.weights @ squares)


def average_of(points: Log, priors: dict[str, float]) -> ModelAverage:
    """Fit every set of effects, and weigh those that are plausible by their evidence."""
    sets = sets_of(priors)
    largest = fit_model(points, max(sets, key=len), priors, 1.0)
    kappa = _independent(points, largest.residual)
    plain, *others = (fit_model(points, effects, priors, kappa) for effects in sets)
    models = (plain, *(model for model in others if _is_plausible(model, plain, points)))
    evidence = _judged(models)
    weights = np.exp(evidence - evidence.max())
    return ModelAverage(models, weights / weights.sum())


def _judged(models: tuple[EffectModel, ...]) -> Floats:
    """Return the evidence of each model, in which what looks alike counts alike.

    Zero errors of both cells that are more alike than different add to the log ratio a constant
    over the force, with the sign of the motion. So does a late cell while the force changes
    steadily, and friction that depends on the force or, behind a spring, on the place. If such zero
    errors are the likeliest, each other explanation that the readings do not refute is as likely,
    and a single number the likelier by `_SIMPLER`. μ then is a mean over all.
    """
    evidence = np.array([model.evidence for model in models])
    best = int(np.argmax(evidence))
    if not models[best].has_alike_zeros:
        return evidence
    for place, model in enumerate(models):
        rare = [name for name in (DELAY, FORCE) if name in model.effects]
        # Strictness says how rare an effect is, and not what the readings say of it.
        alone = evidence[place] + sum(STRICT[name] for name in rare)
        is_rival = len(rare) == 1 and not set(OFFSETS) <= set(model.effects)
        if is_rival and alone > evidence[best] - REFUTED:
            evidence[place] = evidence[best] + _SIMPLER * (len(model.effects) == 1)
    return evidence


def _is_plausible(model: EffectModel, plain: EffectModel, points: Log) -> bool:
    """True if a model leaves μ known, and needs no zero error and no gain that no rig has."""
    is_known = model.error < _UNKNOWN * model.friction
    largest = _LARGEST_ZERO * np.median(np.minimum(points.motor, points.load))
    has_small_zeros = all(
        abs(model.value(offset)[0]) <= largest for offset in OFFSETS if offset in model.effects
    )
    has_same_gain = abs(model.log_gain) <= abs(plain.log_gain) + _GAIN_MOVES
    return is_known and has_small_zeros and has_same_gain


def _independent(points: Log, residual: Floats) -> float:
    """Estimate the share of points that are independent, by the correlation of successive ones."""
    deviation = residual - means_by(points.stroke, residual)[points.stroke]
    is_next = points.stroke[1:] == points.stroke[:-1]
    if not is_next.any() or not np.any(np.abs(deviation) > 1e-14):
        return 1.0
    products = float(deviation[1:][is_next] @ deviation[:-1][is_next])
    # The mean of a stroke is taken off, which lowers the correlation by one over its points.
    most = float(np.bincount(points.stroke).max())
    correlation = products / float(deviation @ deviation) + 1.0 / most
    correlation = min(max(correlation, 0.0), _ALIKE)
    return (1.0 - correlation) / (1.0 + correlation)
