"""Covariance of measured means about a model's prediction.

The misfit of a channel is the sum of four independent terms, of which a log shows the sizes:

    white     noise of each part by itself
    stroke    smooth over the angle, another one in each stroke
    kind      smooth over the angle, the same in all strokes of one direction and load
    common    smooth over the angle, the same in all strokes

The last three say that parts of one stroke, and strokes of one kind, are wrong together: repeating
a motion does not make a model more right. Sizes come from the marginal likelihood, that is with
what the parameters can explain taken into account.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tendon_cli.fits.log_rows import Floats
from tendon_cli.fits.suit.stroke_parts import Parts

TERMS = ("white", "stroke", "kind", "common")
_SMOOTH_OVER = 0.25
"""Angle over which a smooth misfit changes, as a share of the range of the angle."""
_OFFSET = 0.5
"""Share of the variance of a smooth misfit that is the same at all angles."""
FLOORS = {"white": 2e-4, "stroke": 2e-4, "kind": 2e-4, "common": 2e-4}
"""Least standard deviations, as shares of the range of a channel: the closed form of the sheath is
no better."""
_LARGEST = 0.5
_STARTS = {"white": 3e-3, "stroke": 1e-3, "kind": 1e-3, "common": 1e-3}
_ROUNDS = 12
"""Most steps in which sizes are found."""
_SAME_SIZE = 0.1
"""Change of the logarithm of a variance that no longer matters."""


@dataclass(frozen=True, eq=False)
class Misfit:
    """Covariance of the misfits of all channels over parts of strokes."""

    channels: tuple[str, ...]
    scales: Mapping[str, float]
    """Range of each channel, SI."""
    sizes: Floats
    """Standard deviations as shares of the ranges, (channels, terms)."""

    def deviation(self, channel: str, term: str) -> float:
        """Return the standard deviation of one term of a channel, SI."""
        row = self.channels.index(channel)
        return float(self.sizes[row, TERMS.index(term)] * self.scales[channel])

    def covariance(self, kernels: Floats) -> list[Floats]:
        """Return the covariance of each channel, (parts, parts), SI squared.

        Args:
            kernels: Correlations of the terms, (terms, parts, parts).
        """
        return [
            np.tensordot(np.square(size * self.scales[name]), kernels, axes=1)
            for name, size in zip(self.channels, self.sizes, strict=True)
        ]

    def factors(self, kernels: Floats) -> list[Floats]:
        """Return the Cholesky factor of the covariance of each channel."""
        return [lower_factor(matrix) for matrix in self.covariance(kernels)]


def lower_factor(matrix: Floats) -> Floats:
    """Return the lower Cholesky factor of a covariance."""
    return np.asarray(np.linalg.cholesky(matrix), dtype=np.float64)


def kernels_of(parts: Parts) -> Floats:
    """Return the correlations of the terms between parts, (terms, parts, parts)."""
    span = max(np.ptp(parts.angle), 1e-6)
    apart = (parts.angle[:, np.newaxis] - parts.angle) / (_SMOOTH_OVER * span)
    smooth = _OFFSET + (1.0 - _OFFSET) * np.exp(-0.5 * np.square(apart))
    same_stroke = parts.stroke[:, np.newaxis] == parts.stroke
    load = np.nan_to_num(parts.load, nan=-1.0)
    same_kind = (parts.flexion[:, np.newaxis] == parts.flexion) & (load[:, np.newaxis] == load)
    few = np.sqrt(np.median(parts.count) / parts.count)
    white = np.diag(np.square(few))
    return np.stack([white, smooth * same_stroke, smooth * same_kind, smooth])


def first_misfit(channels: Sequence[str], scales: Mapping[str, float]) -> Misfit:
    """Return the misfit that is assumed before any is seen."""
    sizes = np.tile([_STARTS[term] for term in TERMS], (len(channels), 1))
    return Misfit(tuple(channels), dict(scales), sizes)


def sized(misfit: Misfit, kernels: Floats, residual: Floats, slopes: Floats) -> Misfit:
    """Return the misfit whose sizes make the data most likely, the parameters integrated out.

    The logarithms of the variances are found by Fisher scoring. With M = J J' + Σ v_i K_i the
    covariance of the data, N(0, 1) being the law of the scores, the gradient of the log likelihood
    by ln v_i is v_i/2 (r' M⁻¹ K_i M⁻¹ r - tr M⁻¹ K_i), and its information
    v_i v_j/2 tr M⁻¹ K_i M⁻¹ K_j.

    Args:
        misfit: Misfit to begin with.
        kernels: Correlations of the terms, (terms, parts, parts).
        residual: Measured less predicted at normal scores of 0, (channels * parts,).
        slopes: Derivatives of the predictions by the scores, (channels * parts, parameters).
    """
    parts = kernels.shape[1]
    scale = np.repeat([misfit.scales[name] for name in misfit.channels], parts)
    residual = residual / scale
    slopes = slopes / scale[:, np.newaxis]
    explained = slopes @ slopes.T
    count = len(misfit.channels)
    blocks = [slice(row * parts, (row + 1) * parts) for row in range(count)]
    lowest = np.tile([2.0 * np.log(FLOORS[term]) for term in TERMS], count)
    logs = 2.0 * np.log(misfit.sizes).ravel()
    for _ in range(_ROUNDS):
        variances = np.exp(logs)
        total = explained.copy()
        for row, block in enumerate(blocks):
            of_channel = variances[row * len(TERMS) : (row + 1) * len(TERMS)]
            total[block, block] += np.tensordot(of_channel, kernels, axes=1)
        inverse = np.linalg.inv(total)
        weighted = inverse @ residual
        columns = []
        slope = np.empty(len(logs))
        for row, block in enumerate(blocks):
            for place, kernel in enumerate(kernels):
                at = row * len(TERMS) + place
                turned = kernel @ weighted[block]
                trace = np.sum(inverse[block, block] * kernel)
                slope[at] = 0.5 * variances[at] * (weighted[block] @ turned - trace)
                columns.append((block, inverse[:, block] @ kernel))
        information = np.empty((len(logs), len(logs)))
        for i, (first, left) in enumerate(columns):
            for j, (second, right) in enumerate(columns[: i + 1]):
                trace = np.sum(left[second] * right[first].T)
                information[i, j] = 0.5 * variances[i] * variances[j] * trace
                information[j, i] = information[i, j]
        # A size at its floor that would fall further stays there.
        is_free = (logs > lowest + 1e-9) | (slope > 0.0)
        step = np.zeros(len(logs))
        of_free = information[np.ix_(is_free, is_free)] + 0.05 * np.eye(int(is_free.sum()))
        step[is_free] = np.linalg.solve(of_free, slope[is_free])
        new = np.clip(logs + np.clip(step, -2.0, 2.0), lowest, 2.0 * np.log(_LARGEST))
        change = np.max(np.abs(new - logs))
        logs = new
        if change < _SAME_SIZE:
            break
    return Misfit(misfit.channels, misfit.scales, np.exp(0.5 * logs).reshape(count, -1))
