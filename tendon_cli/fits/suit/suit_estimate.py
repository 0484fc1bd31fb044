"""SuitEstimate of a suit's parameters: least squares with priors, and how well they are known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tendon_cli.fits.log_rows import Floats, Integers
from tendon_cli.fits.suit.log_columns import SPOOL_ANGLE
from tendon_cli.fits.suit.misfit import Misfit, first_misfit, kernels_of, lower_factor, sized
from tendon_cli.fits.suit.parameters import range_of
from tendon_cli.fits.suit.stroke_parts import Parts
from tendon_cli.fits.suit.suit_model import SuitModel
from tendon_cli.quantities import QUANTITIES
from tendon_cli.units import SI_UNIT

_ROUNDS = 2
"""Rounds in which parameters and the sizes of the misfit are found in turn."""
_TOLERANCE = 1e-7
"""Relative change at which the least squares end."""
_MOST_STEPS = 40
_THIRDS = 3


@dataclass(frozen=True)
class ChannelMisfit:
    """Misfit of one channel."""

    rms: float
    """Root mean square of measured less fitted means, SI."""
    unit: str
    predicted_rms: float
    """The same for parts that had no share in the fit, SI."""
    share: float
    """`predicted_rms` over the root mean square of the signal about its mean."""


@dataclass(frozen=True, eq=False)
class SuitEstimate:
    """Parameters that fit best, with all that their covariance follows from."""

    model: SuitModel
    parts: Parts
    channels: tuple[str, ...]
    misfit: Misfit
    scores: Floats
    """Normal scores, (parameters,)."""
    predicted: Floats
    """Predictions at the scores, (channels * parts,), SI."""
    slopes: Floats
    """Derivatives of the predictions by the scores, (channels * parts, parameters)."""

    @cached_property
    def kernels(self) -> Floats:
        """Correlations of the terms of the misfit, (terms, parts, parts)."""
        return kernels_of(self.parts)

    @cached_property
    def measured(self) -> Floats:
        """Measured means, (channels * parts,), SI."""
        return measured(self.parts, self.channels)

    @property
    def residual(self) -> Floats:
        """Measured less predicted, (channels, parts), SI."""
        return (self.measured - self.predicted).reshape(len(self.channels), -1)

    @cached_property
    def whitened(self) -> Floats:
        """Derivatives of the predictions in units of their misfit."""
        factors = self.misfit.factors(self.kernels)
        return whiten(factors, self.slopes)

    @cached_property
    def information(self) -> Floats:
        """Inverse of the covariance of the scores, prior included, (parameters, parameters)."""
        return self.whitened.T @ self.whitened + np.eye(len(self.scores))

    @cached_property
    def covariance(self) -> Floats:
        """Covariance of the normal scores, (parameters, parameters)."""
        return np.asarray(np.linalg.inv(self.information))

    @cached_property
    def strokes(self) -> int:
        """Number of strokes used."""
        return len(np.unique(self.parts.stroke))

    @property
    def coverage_factor(self) -> float:
        """Half-width of a 95 % interval over the standard deviation, for few strokes."""
        from scipy.stats import t

        return t.ppf(0.975, max(2, self.strokes - 2))

    def without(self, parts: Floats) -> tuple[Floats, Floats]:
        """Return scores and covariance as they are without some parts, to first order.

        Args:
            parts: True for the parts that are left out, (parts,).
        """
        kept = ~np.asarray(parts, dtype=bool)
        count = len(self.channels)
        rows = np.tile(kept, count)
        covariances = self.misfit.covariance(self.kernels[:, kept][:, :, kept])
        factors = [lower_factor(matrix) for matrix in covariances]
        slopes = whiten(factors, self.slopes[rows])
        residual = whiten(factors, (self.measured - self.predicted)[rows])
        information = slopes.T @ slopes + np.eye(len(self.scores))
        covariance = np.linalg.inv(information)
        change = covariance @ (slopes.T @ residual - self.scores)
        return self.scores + change, np.asarray(covariance)


def measured(parts: Parts, channels: Sequence[str]) -> Floats:
    """Return the measured means of channels, (channels * parts,), SI."""
    return np.concatenate([parts.values[name] for name in channels])


def whiten(factors: Sequence[Floats], values: Floats) -> Floats:
    """Return values in units of a misfit with these Cholesky factors, channel by channel."""
    from scipy.linalg import solve_triangular

    parts = len(factors[0])
    solved = [
        solve_triangular(factor, values[row * parts : (row + 1) * parts], lower=True)
        for row, factor in enumerate(factors)
    ]
    return np.concatenate(solved)


def fitted(model: SuitModel, parts: Parts, start: SuitEstimate | None = None) -> SuitEstimate:
    """Return the estimate for parts of strokes.

    Args:
        model: The study with its parameters.
        parts: Parts of strokes.
        start: Estimate for nearly the same parts; without one the priors' middles.
    """
    channels = tuple(parts.values)
    scales = {name: max(range_of(parts.values[name]), 1e-9) for name in channels}
    misfit = first_misfit(channels, scales) if start is None else start.misfit
    kernels = kernels_of(parts)
    data = measured(parts, channels)
    scores = np.zeros(len(model.parameters)) if start is None else start.scores
    rounds = _ROUNDS if start is None else 1
    for _ in range(rounds):
        scores = _least_squares(model, parts, channels, misfit.factors(kernels), data, scores)
        predicted, slopes = model.jacobian(scores, parts, channels)
        at_zero = data - predicted + slopes @ scores
        misfit = sized(misfit, kernels, at_zero, slopes)
    scores = _least_squares(model, parts, channels, misfit.factors(kernels), data, scores)
    predicted, slopes = model.jacobian(scores, parts, channels)
    return SuitEstimate(model, parts, channels, misfit, scores, predicted, slopes)


def _least_squares(
    model: SuitModel,
    parts: Parts,
    channels: Sequence[str],
    factors: Sequence[Floats],
    data: Floats,
    start: Floats,
) -> Floats:
    """Return the scores that minimise the squares of misfits and of scores."""
    from scipy.optimize import least_squares

    solved: dict[bytes, tuple[Floats, Floats]] = {}

    def solve(scores: Floats) -> tuple[Floats, Floats]:
        """Return predictions and derivatives, once for each set of scores."""
        key = scores.tobytes()
        if key not in solved:
            solved.clear()
            solved[key] = model.jacobian(scores, parts, channels)
        return solved[key]

    def misfits(scores: Floats) -> Floats:
        """Return misfits in units of their size, and the scores themselves."""
        return np.concatenate([whiten(factors, data - solve(scores)[0]), scores])

    def derivatives(scores: Floats) -> Floats:
        """Return the derivatives of `misfits`."""
        slopes = whiten(factors, solve(scores)[1])
        return np.concatenate([-slopes, np.eye(len(scores))])

    found = least_squares(
        misfits,
        start,
        jac=derivatives,
        method="lm",
        xtol=_TOLERANCE,
        ftol=_TOLERANCE,
        max_nfev=_MOST_STEPS,
    )
    return found.x


def predicted_with(parts: Parts) -> tuple[Integers, str]:
    """Return the group that each part is predicted with, and the groups' name."""
    if len(np.unique(parts.log)) > 1:
        return parts.log, "log"
    _, rank = np.unique(parts.stroke, return_inverse=True)
    # Strokes of both directions that follow each other belong together.
    return (rank // 2) % _THIRDS, "third of the strokes"


def channel_misfits(estimate: SuitEstimate) -> dict[str, ChannelMisfit]:
    """Return the misfit of each channel, fitted and predicted from the other groups."""
    parts = estimate.parts
    groups, _ = predicted_with(parts)
    predicted = np.empty((len(estimate.channels), len(parts)))
    for group in np.unique(groups):
        left_out = groups == group
        scores = estimate.scores
        if not left_out.all():
            scores, _ = estimate.without(left_out)
        shown = estimate.model.predict(scores[np.newaxis], parts, estimate.channels)[0]
        predicted[:, left_out] = shown[:, left_out]
    found = {}
    for row, channel in enumerate(estimate.channels):
        values = parts.values[channel]
        away = values - predicted[row]
        if channel == SPOOL_ANGLE:
            # The zero of a log is known only from the log itself.
            for log in np.unique(parts.log):
                away[parts.log == log] -= away[parts.log == log].mean()
        predicted_rms = _rms(away)
        found[channel] = ChannelMisfit(
            rms=_rms(estimate.residual[row]),
            unit=SI_UNIT[QUANTITIES[channel].dimension],
            predicted_rms=predicted_rms,
            share=predicted_rms / _rms(values - values.mean()),
        )
    return found


def _rms(values: Floats) -> float:
    """Return a root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))
