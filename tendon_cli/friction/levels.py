"""The two limits that the log ratio of the forces goes to and fro between, met in noisy rows."""

from __future__ import annotations

import numpy as np

from tendon_cli.friction.reading.readings import Floats

_WIDEST = 501


def noise_of(log_ratio: Floats) -> float:
    """Standard deviation of a row: about its level, but no more than thrice what successive rows show."""
    if len(log_ratio) < 3:
        return 0.0
    middle, half = levels_of(log_ratio)
    about = np.abs(np.abs(log_ratio - middle) - half)
    steps = np.diff(log_ratio)
    successive = 1.4826 * float(np.median(np.abs(steps - np.median(steps)))) / np.sqrt(2.0)
    # Steps of one unit of resolution, most of them zero, still scatter.
    successive = max(successive, float(np.std(steps)) / 10.0)
    # A steady climb is no noise.
    successive = min(successive, float(np.std(np.diff(steps))) / np.sqrt(6.0))
    return float(min(1.4826 * float(np.median(about)), 3.0 * successive))


def smoothed(log_ratio: Floats, noise: float, widest: int) -> tuple[Floats, float, int]:
    """A running median wide enough for the noise, the noise that is left in it, and its width."""
    from scipy.ndimage import median_filter

    low, high = np.quantile(log_ratio, (0.02, 0.98))
    wanted = (noise / max(0.03 * (high - low), 1e-12)) ** 2
    width = int(np.clip(2 * round(wanted / 2.0) + 1, 1, min(max(5, len(log_ratio) // 60 * 2 + 1), _WIDEST, widest)))
    if width == 1:
        return log_ratio, noise, width
    return median_filter(log_ratio, size=width, mode="nearest"), 1.25 * noise / np.sqrt(width), width


def levels_of(smooth: Floats) -> tuple[float, float]:
    """Middle and half distance of the two levels, by the outer quartiles of the two sides in turn.

    Outer quartiles and not medians, so that the level is met even where more than half of a stroke sticks.
    """
    middle = float(np.mean(np.quantile(smooth, (0.02, 0.98))))
    half = 0.0
    for _ in range(20):
        above, below = smooth[smooth > middle], smooth[smooth <= middle]
        if not len(above) or not len(below):
            return middle, 0.0
        upper, lower = float(np.quantile(above, 0.75)), float(np.quantile(below, 0.25))
        half = (upper - lower) / 2.0
        if (upper + lower) / 2.0 == middle:
            break
        middle = (upper + lower) / 2.0
    return middle, half
