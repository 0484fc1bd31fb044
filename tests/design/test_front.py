"""Fronts against the definition, row by row."""

import numpy as np
import pytest

from tendon_cli.answers.asked import Goal
from tendon_cli.answers.candidates import best, compromise, front, losses


@pytest.mark.parametrize("goals", [1, 2, 3, 4])
def test_the_front_is_what_no_row_beats(goals):
    rng = np.random.default_rng(goals)
    worth = rng.integers(0, 9, (300, goals)).astype(float)
    found = front(worth)
    beaten = [any((other >= row).all() and (other > row).any() for other in worth) for row in worth]
    firsts = [not any((worth[j] == worth[i]).all() for j in range(i)) for i in range(len(worth))]
    np.testing.assert_array_equal(found, [i for i in range(300) if not beaten[i] and firsts[i]])


def test_a_front_of_thousands_is_whole():
    angle = np.linspace(0.0, np.pi / 2, 5000)
    worth = np.column_stack([np.cos(angle), np.sin(angle)])
    inner = 0.9 * worth
    np.testing.assert_array_equal(front(np.concatenate([inner, worth])), np.arange(5000, 10000))


def test_the_knee_gives_up_least_of_what_it_gives_up_most():
    worth = np.array([[1.0, 0.0], [0.8, 0.7], [0.5, 0.8], [0.0, 1.0]])
    assert compromise(worth) == 1
    np.testing.assert_allclose(losses(worth)[1], [0.2, 0.3])


def test_a_torque_counts_by_its_magnitude_and_null_is_worst():
    goal = Goal("peak_motor_torque", maximise=False)
    assert np.argsort(goal.score(np.array([-9.0, 3.0, np.nan, 5.0]))).tolist() == [2, 0, 3, 1]


def test_of_equals_the_larger_tolerance_is_best():
    assert best(np.array([1.0, 1.0, 0.5, 1.0]), np.array([0.1, 0.3, 0.9, 0.3])) == 1
    assert best(np.array([0.2, 0.5]), np.array([0.9, 0.1])) == 1
