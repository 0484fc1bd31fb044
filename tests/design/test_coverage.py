"""The share that one pretension serves, against a dense scan; fronts, against their definition."""

import numpy as np
import pytest

from tendon_cli.engine.windows.candidates import front, least_losses, losses
from tendon_cli.engine.windows.coverage import share_at, share_served
from tendon_cli.engine.windows.groups import Groups
from tendon_cli.engine.windows.question import Goal


def sets_of_windows(seed, count=50):
    """Yield the ends of random windows and their weights.

    They lie on a coarse grid, so that many touch. Some are empty, some have no upper end, and
    some (NaN) belong to people whom no pretension suits.
    """
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
    """Return pretensions in every gap and at every end of windows, and the share each serves."""
    pretensions = np.arange(0.0, 40.0, 0.25)
    served = [
        weighting[(low <= pretension) & (pretension <= high)].sum() for pretension in pretensions
    ]
    return pretensions, np.array(served) / weighting.sum()


def runs_of(is_true):
    """Return the first index of every run of true values and the one after its last, (runs, 2)."""
    padded = np.concatenate([[False], is_true, [False]])
    return np.flatnonzero(np.diff(padded.astype(int))).reshape(-1, 2)


@pytest.mark.parametrize("enough", [1.0, 0.8, 0.5])
def test_the_share_served_is_that_of_a_dense_scan(enough):
    touching = 0
    for low, high, weighting in sets_of_windows(seed=3, count=200):
        pretensions, share = scanned(low, high, weighting)
        coverage = share_served(low[np.newaxis], high[np.newaxis], weighting, serve=enough)
        assert coverage.served[0] == pytest.approx(share.max(), abs=1e-12)
        runs = runs_of(share >= enough - 1e-9)
        assert coverage.windows[0] == len(runs)
        if not len(runs):
            assert np.isnan(coverage.low[0])
            assert np.isnan(coverage.high[0])
            continue
        spans = []
        for first, after in runs:
            end = np.inf if after == len(pretensions) else pretensions[after - 1]
            spans.append((pretensions[first], end))
        widest = max(end - start for start, end in spans)
        assert coverage.high[0] - coverage.low[0] == widest
        assert (coverage.low[0], coverage.high[0]) in spans
        touching += widest == 0.0
    assert touching > 3


def test_the_best_pretensions_serve_most():
    for low, high, weighting in sets_of_windows(seed=8):
        coverage = share_served(low[np.newaxis], high[np.newaxis], weighting)
        if coverage.served[0] == 0.0:
            assert np.isnan(coverage.best_low[0])
            continue
        first = coverage.best_low[0]
        last = min(coverage.best_high[0], first + 50.0)
        for pretension in (first, 0.5 * (first + last), last):
            share = share_at(pretension, low, high, weighting)
            assert share == pytest.approx(coverage.served[0], abs=1e-12)


def test_many_choices_at_once_are_the_same_as_one_by_one():
    rng = np.random.default_rng(0)
    low = rng.uniform(0.0, 10.0, (40, 30))
    high = low + rng.uniform(-2.0, 8.0, low.shape)
    weighting = rng.uniform(0.5, 2.0, 30)
    together = share_served(low, high, weighting, serve=0.6)
    for row in range(len(low)):
        alone = share_served(low[row : row + 1], high[row : row + 1], weighting, serve=0.6)
        for name in ("low", "high", "windows", "served", "best_low", "best_high"):
            np.testing.assert_array_equal(getattr(together, name)[row], getattr(alone, name)[0])


def test_a_person_counts_only_where_every_load_is_held():
    low = np.array([[1.0, 5.0, 2.0, np.nan, 0.0]])
    high = np.array([[9.0, 7.0, 1.0, np.nan, np.inf]])
    person = np.array([0, 0, 1, 2, 3])
    groups = Groups(person, np.ones(4), {})
    person_low, person_high = groups.windows(low, high)
    np.testing.assert_array_equal(person_low[0], [5.0, 2.0, np.nan, 0.0])
    np.testing.assert_array_equal(person_high[0], [7.0, 1.0, np.nan, np.inf])
    coverage = groups.coverage(person_low, person_high)
    assert coverage.served[0] == 0.5
    assert (coverage.best_low[0], coverage.best_high[0]) == (5.0, 7.0)


# --- Fronts ---------------------------------------------------------------------------------------


def beats(first, second):
    """Return true if a row of scores is as good as another in all and better in some."""
    return (first >= second).all() and (first > second).any()


@pytest.mark.parametrize("goals", [1, 2, 3, 4])
def test_no_row_beats_the_front_and_it_has_every_such_row_once(goals):
    rng = np.random.default_rng(goals)
    scores = rng.integers(0, 9, (300, goals)).astype(float)
    expected = []
    for row, own in enumerate(scores):
        is_beaten = any(beats(rival, own) for rival in scores)
        is_repeated = any((rival == own).all() for rival in scores[:row])
        if not is_beaten and not is_repeated:
            expected.append(row)
    np.testing.assert_array_equal(front(scores), expected)


def test_the_largest_loss_of_the_compromise_is_the_smallest():
    scores = np.array([[1.0, 0.0], [0.8, 0.7], [0.5, 0.8], [0.0, 1.0]])
    assert least_losses(scores).tolist() == [1]
    np.testing.assert_allclose(losses(scores)[1], [0.2, 0.3])


def test_an_infinite_score_loses_nothing_and_all_else_loses_everything_to_it():
    scores = np.array([[np.inf, 1.0, -4.0], [np.inf, 2.0, -np.inf], [5.0, 3.0, -2.0]])
    expected = [[0.0, 1.0, 1.0], [0.0, 0.5, 1.0], [1.0, 0.0, 0.0]]
    np.testing.assert_array_equal(losses(scores), expected)
    assert least_losses(scores[:, :2]).tolist() == [1]


def test_a_torque_counts_by_its_magnitude_and_null_is_worst():
    goal = Goal("peak_motor_torque", maximise=False)
    assert np.argsort(goal.score(np.array([-9.0, 3.0, np.nan, 5.0]))).tolist() == [2, 0, 3, 1]
