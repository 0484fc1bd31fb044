"""Shares, their errors and the curve of a probability, against counting and plain simulation."""

import numpy as np
import pytest

from tendon_cli import say
from tendon_cli.answers.coverage import curve, effective_count, share_at


def some_windows(count, seed):
    random = np.random.default_rng(seed)
    low = random.normal(100.0, 10.0, count)
    high = low + random.normal(12.0, 8.0, count)
    low[0], high[1] = np.nan, np.inf
    return low, high, random.uniform(0.0, 2.0, count)


def counted(pretension, low, high, weighting):
    return weighting[(low <= pretension) & (pretension <= high)].sum() / weighting.sum()


def test_a_share_is_that_of_windows_counted_one_by_one():
    low, high, weighting = some_windows(200, 1)
    for place in [0.0, *low[1:], *high[2:], 1e6]:
        assert share_at(place, low, high, weighting) == pytest.approx(
            counted(place, low, high, weighting), abs=1e-12
        )
    found = curve(low, high, weighting)
    np.testing.assert_allclose(
        found.share[::2], [counted(at, low, high, weighting) for at in found.pretension[::2]]
    )
    middles = (found.pretension[:-2:2] + found.pretension[2::2]) / 2
    np.testing.assert_allclose(
        found.share[1:-2:2], [counted(at, low, high, weighting) for at in middles]
    )
    assert np.all((found.low <= found.share) & (found.share <= found.high))


def test_without_any_window_the_curve_is_empty():
    found = curve(np.array([2.0, np.nan]), np.array([1.0, np.nan]), np.ones(2))
    assert found.pretension.size == found.share.size == 0


@pytest.mark.parametrize("true", [0.02, 0.5, 0.93, 1.0])
def test_the_interval_covers_the_true_share_and_is_as_wide_as_samples_scatter(true):
    shares = np.random.default_rng(3).binomial(400, true, 3000) / 400
    low, high = np.transpose([say.interval(share, 400) for share in shares])
    assert 0.93 < np.mean((low <= true) & (true <= high)) <= 1.0
    if 0.1 < true < 0.99:
        assert np.mean(high - low) / 3.92 == pytest.approx(shares.std(), rel=0.05)
    assert np.all(high > low)


def test_unequal_weighting_counts_for_fewer():
    assert effective_count(np.ones(7)) == 7.0
    assert effective_count(np.array([1e-300, 0.0, 0.0])) == 1.0
    assert 2.0 < effective_count(np.array([1.0, 1.0, 0.2])) < 3.0
