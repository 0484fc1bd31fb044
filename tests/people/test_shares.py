"""Shares, their errors and the curve of a probability, against counting and plain simulation."""

import numpy as np
import pytest

from tendon_cli import say
from tendon_cli.engine.windows.coverage import curve, effective_count, share_at


def random_windows(count, seed):
    """Return the ends of windows and their weights; the first has none, the second no upper end."""
    random = np.random.default_rng(seed)
    low = random.normal(100.0, 10.0, count)
    high = low + random.normal(12.0, 8.0, count)
    low[0] = np.nan
    high[1] = np.inf
    return low, high, random.uniform(0.0, 2.0, count)


def test_a_share_is_that_of_windows_counted_one_by_one():
    low, high, weighting = random_windows(200, 1)

    def counted(pretension):
        is_served = (low <= pretension) & (pretension <= high)
        return weighting[is_served].sum() / weighting.sum()

    for pretension in [0.0, *low[1:], *high[2:], 1e6]:
        share = share_at(pretension, low, high, weighting)
        assert share == pytest.approx(counted(pretension), abs=1e-12)
    probability = curve(low, high, weighting)
    ends = probability.pretension[::2]
    np.testing.assert_allclose(probability.share[::2], [counted(pretension) for pretension in ends])
    middles = (probability.pretension[:-2:2] + probability.pretension[2::2]) / 2
    np.testing.assert_allclose(probability.share[1:-2:2], [counted(middle) for middle in middles])
    assert np.all((probability.low <= probability.share) & (probability.share <= probability.high))


def test_without_any_window_the_curve_is_empty():
    empty = curve(np.array([2.0, np.nan]), np.array([1.0, np.nan]), np.ones(2))
    assert empty.pretension.size == empty.share.size == 0


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
