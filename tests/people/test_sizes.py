"""Several suits instead of one, against every combination of them."""

import itertools

import numpy as np
import pytest

from tendon_cli.engine.windows.coverage import best_sizes, share_served
from tendon_cli.errors import Stopped


def all_combinations(low, high, weighting, most):
    """Return the largest share of any `most` pretensions of any choices."""
    sets = set()
    for choice_low, choice_high in zip(low, high, strict=True):
        ends = np.concatenate([choice_low, choice_high])
        for pretension in ends[np.isfinite(ends)]:
            sets.add(tuple((choice_low <= pretension) & (pretension <= choice_high)))
    if not sets:
        return 0.0
    members = [np.array(served) for served in sets]
    groups = itertools.combinations_with_replacement(members, most)
    return max(weighting[np.logical_or.reduce(group)].sum() for group in groups) / weighting.sum()


@pytest.mark.parametrize("most", [1, 2, 3])
@pytest.mark.parametrize("seed", range(12))
def test_no_combination_serves_more(most, seed):
    random = np.random.default_rng(seed)
    choices = random.integers(1, 4)
    persons = random.integers(1, 8)
    low = random.normal(100.0, 10.0, (choices, persons)).round()
    high = low + random.normal(4.0, 6.0, (choices, persons)).round()
    if seed % 3 == 0:
        low[0, 0] = np.nan
        high[-1, -1] = np.inf
    weighting = random.integers(0, 3, persons) + 0.5 * (seed % 2) + (np.arange(persons) == 0)
    sizes = best_sizes(low, high, weighting, most)[-1]
    assert sizes.share == pytest.approx(all_combinations(low, high, weighting, most), abs=1e-12)
    served = np.zeros(persons, dtype=bool)
    for choice, pretension in zip(sizes.choices, sizes.pretensions, strict=True):
        served |= (low[choice] <= pretension) & (pretension <= high[choice])
    assert weighting[served].sum() / weighting.sum() == pytest.approx(sizes.share, abs=1e-12)
    assert len(sizes.choices) <= most


def test_one_suit_serves_as_one_pretension_does_and_more_suits_serve_more():
    random = np.random.default_rng(5)
    low = 100.0 + 10.0 * random.normal(size=150) + np.linspace(0.0, 20.0, 4)[:, np.newaxis]
    high = low + random.uniform(0.0, 20.0, 150)
    one, two, three = best_sizes(low, high, np.ones(150), 3)
    served = share_served(low, high, np.ones(150)).served
    assert one.share == pytest.approx(served.max(), abs=1e-12)
    assert one.share < two.share < three.share < 1.0


def test_nobody_is_served_or_one_suit_serves_everybody():
    nobody = best_sizes(np.array([[2.0, np.nan]]), np.array([[1.0, np.nan]]), np.ones(2), 3)[-1]
    assert (nobody.choices, nobody.pretensions, nobody.share) == ((), (), 0.0)
    low = np.array([[1.0, 2.0], [1.0, 5.0]])
    high = np.array([[3.0, np.inf], [3.0, 9.0]])
    everybody = best_sizes(low, high, np.ones(2), 3)[-1]
    assert everybody.choices == (0,)
    assert everybody.share == 1.0
    assert 2.0 <= everybody.pretensions[0] <= 3.0


@pytest.mark.parametrize("after", [1, 3])
def test_a_search_that_is_to_end_ends_before_its_next_step(after):
    calls = []

    def check_stopped():
        calls.append(True)
        if len(calls) == after:
            raise Stopped

    low = 100.0 + 10.0 * np.random.default_rng(5).normal(size=(4, 60))
    with pytest.raises(Stopped):
        best_sizes(low, low + 3.0, np.ones(60), 3, check_stopped)
    assert len(calls) == after
