"""Fronts against the definition, row by row."""

import numpy as np
import pytest

from tendon_cli.answers.asked import Goal
from tendon_cli.answers.candidates import compromise, front, losses


@pytest.mark.parametrize("goals", [1, 2, 3, 4])
def test_the_front_is_what_no_row_beats(goals):
    rng = np.random.default_rng(goals)
    scores = rng.integers(0, 9, (300, goals)).astype(float)
    found = front(scores)
    beaten = [any((other >= row).all() and (other > row).any() for other in scores) for row in scores]
    firsts = [not any((scores[j] == scores[i]).all() for j in range(i)) for i in range(len(scores))]
    np.testing.assert_array_equal(found, [i for i in range(300) if not beaten[i] and firsts[i]])


def test_a_front_of_thousands_is_whole():
    angle = np.linspace(0.0, np.pi / 2, 5000)
    scores = np.column_stack([np.cos(angle), np.sin(angle)])
    inner = 0.9 * scores
    np.testing.assert_array_equal(front(np.concatenate([inner, scores])), np.arange(5000, 10000))


def test_the_compromise_gives_up_least_of_what_it_gives_up_most():
    scores = np.array([[1.0, 0.0], [0.8, 0.7], [0.5, 0.8], [0.0, 1.0]])
    assert compromise(scores) == 1
    np.testing.assert_allclose(losses(scores)[1], [0.2, 0.3])


def test_a_torque_counts_by_its_magnitude_and_null_is_worst():
    goal = Goal("peak_motor_torque", maximise=False)
    assert np.argsort(goal.score(np.array([-9.0, 3.0, np.nan, 5.0]))).tolist() == [2, 0, 3, 1]
