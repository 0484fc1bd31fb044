"""The share served by one pretension against a dense scan of pretensions; fronts against the definition."""

import numpy as np
import pytest

from tendon_cli.answers.candidates import compromise, front, losses
from tendon_cli.answers.coverage import grouped, share_at, share_served
from tendon_cli.answers.question import Goal


def sets_of_windows(seed, count=50):
    """Random windows on a coarse grid, so that many touch: some empty, some without an end, some that no one has."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        groups = int(rng.integers(1, 9))
        low = rng.integers(0, 12, groups).astype(float)
        high = low + rng.integers(-3, 6, groups)
        high = np.where(rng.random(groups) < 0.2, np.inf, high)
        nobody = rng.random(groups) < 0.1
        weighting = np.where(rng.random(groups) < 0.5, 1.0, rng.uniform(0.1, 3.0, groups))
        yield np.where(nobody, np.nan, low), np.where(nobody, np.nan, high), weighting


def scanned(low, high, weighting):
    """Shares at every quarter of the grid on which windows begin and end: in every gap, and at every end."""
    at = np.arange(0.0, 40.0, 0.25)
    return at, np.array([weighting[(low <= f) & (f <= high)].sum() for f in at]) / weighting.sum()


@pytest.mark.parametrize("enough", [1.0, 0.8, 0.5])
def test_the_share_served_is_that_of_a_dense_scan(enough):
    touching = 0
    for low, high, weighting in sets_of_windows(seed=3, count=200):
        at, share = scanned(low, high, weighting)
        found = share_served(low[np.newaxis], high[np.newaxis], weighting, enough=enough)
        assert found.served[0] == pytest.approx(share.max(), abs=1e-12)
        serves = share >= enough - 1e-9
        runs = np.flatnonzero(np.diff(np.concatenate([[False], serves, [False]]).astype(int)))
        assert found.windows[0] == len(runs) // 2
        if not serves.any():
            assert np.isnan(found.low[0])
            assert np.isnan(found.high[0])
            continue
        spans = [(at[a], np.inf if b == len(at) else at[b - 1]) for a, b in runs.reshape(-1, 2)]
        widest = max(end - start for start, end in spans)
        assert found.high[0] - found.low[0] == widest or (
            np.isinf(found.high[0]) and np.isinf(widest)
        )
        assert (found.low[0], found.high[0]) in spans
        touching += widest == 0.0
    assert touching > 3


def test_the_best_pretensions_serve_most_and_none_beside_them_does():
    for low, high, weighting in sets_of_windows(seed=8):
        found = share_served(low[np.newaxis], high[np.newaxis], weighting)
        if found.served[0] == 0.0:
            assert np.isnan(found.best_low[0])
            continue
        inside = min(found.best_high[0], found.best_low[0] + 50.0)
        for at in (found.best_low[0], 0.5 * (found.best_low[0] + inside), inside):
            held = share_at(at, low, high, weighting)
            assert held == pytest.approx(found.served[0], abs=1e-12)


def test_many_choices_at_once_are_the_same_as_one_by_one():
    rng = np.random.default_rng(0)
    low = rng.uniform(0.0, 10.0, (40, 30))
    high = low + rng.uniform(-2.0, 8.0, low.shape)
    weighting = rng.uniform(0.5, 2.0, 30)
    together = share_served(low, high, weighting, enough=0.6)
    for row in range(len(low)):
        alone = share_served(low[row : row + 1], high[row : row + 1], weighting, enough=0.6)
        for name in ("low", "high", "windows", "served", "best_low", "best_high"):
            np.testing.assert_array_equal(getattr(together, name)[row], getattr(alone, name)[0])


def test_a_person_counts_only_where_every_load_is_held():
    low = np.array([[1.0, 5.0, 2.0, np.nan, 0.0]])
    high = np.array([[9.0, 7.0, 1.0, np.nan, np.inf]])
    person = np.array([0, 0, 1, 2, 3])
    by_person = grouped(low, high, person)
    np.testing.assert_array_equal(by_person[0][0], [5.0, 2.0, np.nan, 0.0])
    np.testing.assert_array_equal(by_person[1][0], [7.0, 1.0, np.nan, np.inf])
    found = share_served(*by_person, np.ones(4))
    assert found.served[0] == 0.5
    assert (found.best_low[0], found.best_high[0]) == (5.0, 7.0)


# --- Fronts ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("goals", [1, 2, 3, 4])
def test_the_front_is_what_no_row_beats(goals):
    rng = np.random.default_rng(goals)
    scores = rng.integers(0, 9, (300, goals)).astype(float)
    found = front(scores)
    beaten = [
        any((other >= row).all() and (other > row).any() for other in scores) for row in scores
    ]
    firsts = [not any((scores[j] == scores[i]).all() for j in range(i)) for i in range(len(scores))]
    np.testing.assert_array_equal(found, [i for i in range(300) if not beaten[i] and firsts[i]])


def test_the_compromise_gives_up_least_of_what_it_gives_up_most():
    scores = np.array([[1.0, 0.0], [0.8, 0.7], [0.5, 0.8], [0.0, 1.0]])
    assert compromise(scores) == 1
    np.testing.assert_allclose(losses(scores)[1], [0.2, 0.3])


def test_a_torque_counts_by_its_magnitude_and_null_is_worst():
    goal = Goal("peak_motor_torque", maximise=False)
    assert np.argsort(goal.score(np.array([-9.0, 3.0, np.nan, 5.0]))).tolist() == [2, 0, 3, 1]
