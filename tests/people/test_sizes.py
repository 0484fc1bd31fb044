"""A few suits instead of one: against every combination of them."""

import itertools

import numpy as np
import pytest

from tendon_cli.answers.coverage import best_sizes, share_served
from tendon_cli.errors import Stopped


def all_combinations(low, high, weighting, most):
    """The largest share of any `most` pretensions of any choices."""
    ends = np.concatenate([low, high], axis=1)
    sets = {
        tuple((low[choice] <= at) & (at <= high[choice]))
        for choice in range(len(low))
        for at in ends[choice][np.isfinite(ends[choice])]
    }
    weigh = [np.array(some) for some in sets] or [np.zeros(low.shape[1], dtype=bool)]
    groups = itertools.combinations_with_replacement(weigh, most)
    return max(weighting[np.logical_or.reduce(group)].sum() for group in groups) / weighting.sum()


@pytest.mark.parametrize("most", [1, 2, 3])
@pytest.mark.parametrize("seed", range(12))
def test_no_combination_serves_more(most, seed):
    random = np.random.default_rng(seed)
    choices, persons = random.integers(1, 4), random.integers(1, 8)
    low = random.normal(100.0, 10.0, (choices, persons)).round()
    high = low + random.normal(4.0, 6.0, (choices, persons)).round()
    if seed % 3 == 0:
        low[0, 0], high[-1, -1] = np.nan, np.inf
    weighting = random.integers(0, 3, persons) + 0.5 * (seed % 2) + (np.arange(persons) == 0)
    found = best_sizes(low, high, weighting, most)[-1]
    assert found.share == pytest.approx(all_combinations(low, high, weighting, most), abs=1e-12)
    served = np.zeros(persons, dtype=bool)
    for choice, at in zip(found.choices, found.pretensions, strict=True):
        served |= (low[choice] <= at) & (at <= high[choice])
    assert weighting[served].sum() / weighting.sum() == pytest.approx(found.share, abs=1e-12)
    assert len(found.choices) <= most


def test_one_suit_is_what_one_pretension_serves_and_more_serve_more():
    random = np.random.default_rng(5)
    low = 100.0 + 10.0 * random.normal(size=150) + np.linspace(0.0, 20.0, 4)[:, np.newaxis]
    high = low + random.uniform(0.0, 20.0, 150)
    one, two, three = best_sizes(low, high, np.ones(150), 3)
    assert one.share == pytest.approx(share_served(low, high, np.ones(150)).served.max(), abs=1e-12)
    assert one.share < two.share < three.share < 1.0


def test_nobody_is_served_or_everybody_by_one():
    empty = best_sizes(np.array([[2.0, np.nan]]), np.array([[1.0, np.nan]]), np.ones(2), 3)[-1]
    assert (empty.choices, empty.pretensions, empty.share) == ((), (), 0.0)
    one = best_sizes(
        np.array([[1.0, 2.0], [1.0, 5.0]]), np.array([[3.0, np.inf], [3.0, 9.0]]), np.ones(2), 3
    )[-1]
    assert (one.choices, one.share) == ((0,), 1.0)
    assert 2.0 <= one.pretensions[0] <= 3.0


@pytest.mark.parametrize("after", [1, 3])
def test_a_search_that_is_to_end_ends_before_its_next_step(after):
    asked = []

    def check_stopped():
        asked.append(True)
        if len(asked) == after:
            raise Stopped

    low = 100.0 + 10.0 * np.random.default_rng(5).normal(size=(4, 60))
    with pytest.raises(Stopped):
        best_sizes(low, low + 3.0, np.ones(60), 3, check_stopped)
    assert len(asked) == after
