"""How fast a force changes, from few and noisy points."""

from __future__ import annotations

import numpy as np
import pytest

from tendon_cli.friction.rate import rates_of

STROKES, POINTS = 10, 8
TIME = np.tile(np.linspace(0.0, 1.2, POINTS), STROKES) + np.repeat(3.0 * np.arange(STROKES), POINTS)
STROKE = np.repeat(np.arange(STROKES), POINTS)
INTO = TIME - 3.0 * STROKE


@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_a_smooth_force_has_the_rate_of_its_curve(noise: float) -> None:
    random = np.random.default_rng(3)
    force = 0.2 * INTO - 0.05 * INTO**2
    rate = rates_of(TIME, force + noise * random.standard_normal(len(TIME)), STROKE)
    assert rate is not None
    true = 0.2 - 0.1 * INTO
    # Differences of points of this noise would scatter by 0.007, and at the ends by 0.015.
    assert np.std(rate - true) <= max(3.5 * noise, 1e-9)
    assert np.polyfit(rate, true, 1)[0] == pytest.approx(1.0, abs=0.1)


def test_a_pause_is_not_smoothed_over() -> None:
    moving = (INTO < 0.45) | (INTO > 0.75)
    force = np.cumsum(np.where(moving, 0.03, 0.0)) - 0.4 * STROKE
    rate = rates_of(TIME, force, STROKE)
    assert rate is not None
    assert abs(rate[STROKE == 2]).min() < 0.5 * abs(rate[STROKE == 2]).max()


def test_time_that_stands_gives_no_rate() -> None:
    assert rates_of(np.zeros(6), np.arange(6.0), np.zeros(6, dtype=np.int64)) is None
