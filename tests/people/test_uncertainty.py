"""Sobol indices: of results whose indices are known, and of windows against a plain estimate of ten times the size."""

import numpy as np
import pytest

from tendon_cli.answers import sensitivity
from tendon_cli.answers.problem import question
from tendon_cli.answers.sensitivity import BODY, indices, sobol
from tendon_cli.studies.load import study_from


def indices_in(found, order):
    """Indices of a recorded end, and their standard errors."""
    names = (order, f"{order}_standard_error")
    return tuple(np.array([each[name] for each in found["inputs"].values()]) for name in names)


def test_a_linear_result_has_the_shares_of_its_variance():
    slopes = np.array([3.0, 1.0, 0.5])

    def ends(points):
        return np.stack([points @ slopes, 7.0 - points @ slopes[::-1]])

    first, second = sobol(ends, ("a", "b", "c"), ("low", "high"), 1024, seed=1)
    shares = slopes**2 / np.sum(slopes**2)
    for found, true in ((first, shares), (second, shares[::-1])):
        for index, error in (indices_in(found, "first"), indices_in(found, "total")):
            np.testing.assert_allclose(index, true, atol=0.03)
            assert np.all(np.abs(index - true) < 5.0 * error + 0.003)
    assert first["standard_deviation"] == pytest.approx(np.sqrt(np.sum(slopes**2) / 12.0), rel=0.01)


def test_the_same_question_has_the_same_answer_and_errors_are_those_of_repeated_draws():
    def indices_of(seed):
        (found,) = sobol(
            lambda points: (points[:, :1] + points[:, 1:] ** 2).T, ("a", "b"), ("low",), 256, seed
        )
        return found

    assert indices_of(1) == indices_of(1)
    many = [indices_of(seed) for seed in range(40)]
    for name in ("first", "total"):
        scatter = np.std([indices_in(each, name)[0] for each in many], axis=0)
        told = np.mean([indices_in(each, name)[1] for each in many], axis=0)
        # Sobol points scatter less than the independent ones that a bootstrap supposes, never more.
        assert np.all(scatter < 1.5 * told)
        assert np.all(told < 0.2)


def test_a_product_has_an_interaction_that_the_total_tells():
    (found,) = sobol(
        lambda points: (points[:, :1] * points[:, 1:]).T, ("a", "b"), ("low",), 2048, seed=2
    )
    alone, both = 3.0 / 7.0, 1.0 / 7.0  # of two uniform factors
    np.testing.assert_allclose(indices_in(found, "first")[0], alone, atol=0.03)
    np.testing.assert_allclose(indices_in(found, "total")[0], alone + both, atol=0.03)


def test_what_never_changes_or_is_not_finite_has_no_indices():
    def ends(points):
        return np.stack(
            [np.full(len(points), 3.0), np.where(points[:, 0] > 0.9, np.inf, 1.0), points[:, 0]]
        )

    (found,) = sobol(ends, ("a", "b"), ("constant", "infinite", "fine"), 256, seed=3)
    assert found["end"] == "fine"


UNCERTAIN = {
    "spring": {"stiffness": {"value": "5 kN/m", "tolerance": "10 %"}},
    "sheath": {"friction": {"mean": 0.07, "std": 0.02}},
    "spool": {"ratio": 0.6},
    "load": {"mass": [0.0, 5.0]},
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
    "uncertainty": {"draws": 64},
}


def saltelli(values_a, values_b, mixed):
    """First-order and total indices as plain averages (Saltelli 2010, Jansen 1999)."""
    both = np.concatenate([values_a, values_b])
    variance = np.var(both)
    first = [np.mean((values_b - both.mean()) * (each - values_a)) / variance for each in mixed]
    total = [np.mean((values_a - each) ** 2) / (2.0 * variance) for each in mixed]
    return np.array(first), np.array(total)


@pytest.mark.parametrize("people", [{}, {"people": {"count": 300}}])
def test_indices_of_windows_are_those_of_a_plain_estimate_of_ten_times_the_size(
    people, monkeypatch
):
    problem = question(study_from(UNCERTAIN | people))
    numbers = problem.choices.numbers(np.arange(1))
    taken = {}

    def spied(ends, inputs, names, count, seed):
        taken.update(ends=ends, inputs=inputs)
        return sobol(ends, inputs, names, count, seed)

    monkeypatch.setattr(sensitivity, "sobol", spied)
    monkeypatch.setattr(
        sensitivity, "_STATES", 1024 * 5 * len(problem.conditions) * problem.states_per_design
    )
    found = indices(problem, numbers)
    assert taken["inputs"] == ("sheath.friction", "spring.stiffness", *([BODY] if people else []))
    random = np.random.default_rng(4)
    a, b = random.random((2, 8192, len(taken["inputs"])))
    values = [taken["ends"](points) for points in (a, b)]
    mixed = []
    for at in range(a.shape[1]):
        points = a.copy()
        points[:, at] = b[:, at]
        mixed.append(taken["ends"](points))
    assert [each["end"] for each in found] == ["pretension_from", "pretension_to"]
    for at, each in enumerate(found):
        first, total = saltelli(values[0][at], values[1][at], [one[at] for one in mixed])
        np.testing.assert_allclose(indices_in(each, "first")[0], first, atol=0.08)
        np.testing.assert_allclose(indices_in(each, "total")[0], total, atol=0.08)
        assert 0.9 < indices_in(each, "first")[0].sum() < 1.1
