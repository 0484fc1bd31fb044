"""What the resolution of the readings costs: a floor under the standard error."""

from __future__ import annotations

import numpy as np

from tendon_cli.friction.reading.readings import Floats, Integers

_FINEST_DECIMALS = 9
_ENOUGH_VALUES = 10
_ENOUGH_TO_DITHER = 20


def resolution_of(readings: Floats) -> float:
    """Smallest step of the readings of one cell.

    Ten different values show it; with fewer it is the last decimal that is written, since three readings 0.378 apart
    do not say that the cell counts in steps of 0.378.
    """
    values = np.unique(readings)
    if len(values) >= _ENOUGH_VALUES:
        # A logger that writes binary fractions repeats a value with a last digit more or less.
        steps = np.diff(values)
        return float(steps[steps > 1e-9 * values[-1]].min(initial=values[-1]))
    scale = float(np.max(np.abs(values)))
    for decimals in range(_FINEST_DECIMALS + 1):
        if np.all(np.abs(values - np.round(values, decimals)) <= 1e-12 * scale):
            return float(10.0**-decimals)
    return 0.0


def resolution_floor(cells: tuple[Floats, Floats], stroke: Integers, weights: Floats) -> float:
    """Standard error of Σ weights · ln(cell 1 / cell 2) from the rounding of the readings alone.

    Rounding moves all readings that show the same value by the same amount, so repeating a reading does not average it
    out; readings that show different values are rounded independently. Noise of half a step or more within a
    stroke does average it out (dither): the mean is then off by no more than exp(-2π²·variance/step²) of it.
    """
    variance = 0.0
    for cell in cells:
        step = resolution_of(cell)
        if step == 0.0:
            continue
        share = weights / cell * _undithered(cell, stroke, step)
        _, value = np.unique(cell, return_inverse=True)
        variance += float(np.sum(np.bincount(value, share) ** 2)) * step**2 / 12.0
    return float(np.sqrt(variance))


def _undithered(cell: Floats, stroke: Integers, step: float) -> Floats:
    """Per reading, the share of the rounding error that noise within its stroke leaves."""
    count = np.maximum(np.bincount(stroke), 1)
    mean = np.bincount(stroke, cell) / count
    variance = np.bincount(stroke, (cell - mean[stroke]) ** 2) / count
    noise = np.maximum(variance - step**2 / 12.0, 0.0)
    # A steady change of force averages rounding out as well, but for its first and last step.
    ends = 0.5 * step / np.maximum(np.sqrt(noise), 0.5 * step)
    left = np.where(count >= _ENOUGH_TO_DITHER, np.maximum(np.exp(-2.0 * np.pi**2 * noise / step**2), ends), 1.0)
    return np.asarray(left[stroke], dtype=np.float64)
