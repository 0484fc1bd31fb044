"""Prediction of each log, or of a third of the strokes, from the others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tendon_cli.fits.log_rows import Integers
from tendon_cli.fits.suit.log_columns import SPOOL_ANGLE
from tendon_cli.fits.suit.parameters import unit_of
from tendon_cli.fits.suit.stroke_parts import Parts
from tendon_cli.fits.suit.suit_estimate import SuitEstimate

_THIRDS = 3


@dataclass(frozen=True)
class ChannelMisfit:
    """Misfit of one channel."""

    channel: str
    rms: float
    """Root mean square of measured less fitted means, SI."""
    predicted_rms: float
    """The same for parts that had no share in the fit, SI."""
    share: float
    """`predicted_rms` over the root mean square of the signal about its mean."""

    @property
    def record(self) -> dict[str, Any]:
        """The misfit as plain JSON values."""
        return {
            "rms": self.rms,
            "unit": unit_of(self.channel),
            "predicted_rms": self.predicted_rms,
            "share": self.share,
        }


def groups_of(parts: Parts) -> tuple[Integers, str]:
    """Return the group that each part is predicted with, and the groups' name."""
    logs = len(np.unique(parts.log))
    if logs > 1:
        return parts.log, "log"
    _, rank = np.unique(parts.stroke, return_inverse=True)
    # Strokes of both directions that follow each other belong together.
    return np.asarray((rank // 2) % _THIRDS, dtype=np.int64), "third of the strokes"


def misfits(estimate: SuitEstimate) -> list[ChannelMisfit]:
    """Return the misfit of each channel, fitted and predicted."""
    parts = estimate.parts
    groups, _ = groups_of(parts)
    count = len(estimate.channels)
    predicted = np.empty((count, len(parts)))
    for group in np.unique(groups):
        left_out = groups == group
        scores = estimate.scores
        if not left_out.all():
            scores, _ = estimate.without(left_out)
        shown = estimate.model.predict(scores[np.newaxis], parts, estimate.channels)[0]
        predicted[:, left_out] = shown[:, left_out]
    found = []
    for row, channel in enumerate(estimate.channels):
        values = parts.values[channel]
        away = values - predicted[row]
        if channel == SPOOL_ANGLE:
            # The zero of a log is known only from the log itself.
            for log in np.unique(parts.log):
                away[parts.log == log] -= away[parts.log == log].mean()
        signal = float(np.sqrt(np.mean(np.square(values - values.mean()))))
        rms = float(np.sqrt(np.mean(np.square(estimate.residual[row]))))
        predicted_rms = float(np.sqrt(np.mean(np.square(away))))
        found.append(ChannelMisfit(channel, rms, predicted_rms, predicted_rms / signal))
    return found
