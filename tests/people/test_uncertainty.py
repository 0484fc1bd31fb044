"""Sobol indices of results whose indices are known, and of windows against a plain estimate.

The plain estimate has ten times the size.
"""

import numpy as np
import pytest

from tendon_cli.answers import sensitivity
from tendon_cli.answers.sensitivity import BODY, indices, sobol
from tendon_cli.engine.windows.question import question_of
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.studies.load import study_from
from tendon_cli.verbs.typed_record import to_json

ALL_POINTS = True


def indices_in(record, order):
    """Return the indices of an order, "first" or "total", of a recorded end."""
    return np.array([values[order] for values in to_json(record)["inputs"].values()])


def errors_in(record, order):
    """Return the standard errors of the indices of an order of a recorded end."""
    return indices_in(record, f"{order}_standard_error")


def test_a_linear_result_has_the_shares_of_its_variance():
    slopes = np.array([3.0, 1.0, 0.5])

    def ends(points):
        return np.stack([points @ slopes, 7.0 - points @ slopes[::-1]])

    first, second = sobol(ends, ("a", "b", "c"), ("low", "high"), 1024, seed=1)
    shares = slopes**2 / np.sum(slopes**2)
    for record, true in ((first, shares), (second, shares[::-1])):
        for order in ("first", "total"):
            index = indices_in(record, order)
            error = errors_in(record, order)
            np.testing.assert_allclose(index, true, atol=0.03)
            assert np.all(np.abs(index - true) < 5.0 * error + 0.003)
    deviation = np.sqrt(np.sum(slopes**2) / 12.0)
    assert first.standard_deviation == pytest.approx(deviation, rel=0.01)


def test_the_same_question_has_the_same_answer_and_errors_are_those_of_repeated_draws():
    def ends(points):
        return (points[:, :1] + points[:, 1:] ** 2).T

    def indices_of(seed):
        (record,) = sobol(ends, ("a", "b"), ("low",), 256, seed)
        return record

    assert indices_of(1) == indices_of(1)
    records = [indices_of(seed) for seed in range(40)]
    for order in ("first", "total"):
        scatter = np.std([indices_in(record, order) for record in records], axis=0)
        error = np.mean([errors_in(record, order) for record in records], axis=0)
        # Sobol points scatter less than the independent ones that a bootstrap supposes, never more.
        assert np.all(scatter < 1.5 * error)
        assert np.all(error < 0.2)


def test_a_product_has_an_interaction_that_the_total_index_includes():
    def ends(points):
        return (points[:, :1] * points[:, 1:]).T

    (record,) = sobol(ends, ("a", "b"), ("low",), 2048, seed=2)
    # The shares of two uniform factors
    alone = 3.0 / 7.0
    both = 1.0 / 7.0
    np.testing.assert_allclose(indices_in(record, "first"), alone, atol=0.03)
    np.testing.assert_allclose(indices_in(record, "total"), alone + both, atol=0.03)


def test_a_result_that_never_changes_or_is_not_finite_has_no_indices():
    def ends(points):
        share = points[:, 0]
        constant = np.full(len(points), 3.0)
        infinite = np.where(share > 0.9, np.inf, 1.0)
        return np.stack([constant, infinite, share])

    (record,) = sobol(ends, ("a", "b"), ("constant", "infinite", "fine"), 256, seed=3)
    assert record.end == "fine"


UNCERTAIN = {
    "spring": {"stiffness": {"value": "5 kN/m", "tolerance": "10 %"}},
    "sheath": {"friction": {"mean": 0.07, "std": 0.02}},
    "spool": {"ratio": 0.6},
    "load": {"mass": [0.0, 5.0]},
    "motion": {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 7}},
    "uncertainty": {"draws": 64},
}


def saltelli(values_a, values_b, mixed):
    """Return first and total indices as plain averages (Saltelli 2010, Jansen 1999)."""
    both = np.concatenate([values_a, values_b])
    variance = np.var(both)
    first = [np.mean((values_b - both.mean()) * (values - values_a)) / variance for values in mixed]
    total = [np.mean((values_a - values) ** 2) / (2.0 * variance) for values in mixed]
    return np.array(first), np.array(total)


@pytest.mark.parametrize("people", [{"people": {"count": 300}}])
def test_indices_of_windows_are_those_of_a_plain_estimate_of_ten_times_the_size(
    people, monkeypatch
):
    question = question_of(study_from(UNCERTAIN | people))
    calls = []

    def recorded(ends, inputs, names, count, seed):
        calls.append((ends, inputs))
        return sobol(ends, inputs, names, count, seed)

    monkeypatch.setattr(sensitivity, "sobol", recorded)
    monkeypatch.setattr(
        sensitivity, "_STATES", 1024 * 5 * len(question.conditions) * question.states_per_design
    )
    records = to_json(indices(Solver(question), question.all_points()))
    ends, inputs = calls[-1]
    expected_inputs = ["sheath.friction", "spring.stiffness"]
    if people:
        expected_inputs.append(BODY)
    assert inputs == tuple(expected_inputs)
    random = np.random.default_rng(4)
    points_a, points_b = random.random((2, 8192, len(inputs)))
    values_a = ends(points_a)  # (ends, points)
    values_b = ends(points_b)
    mixed = []
    for column in range(len(inputs)):
        points = points_a.copy()
        points[:, column] = points_b[:, column]
        mixed.append(ends(points))
    assert [record["end"] for record in records] == ["pretension_from", "pretension_to"]
    for row, record in enumerate(records):
        first, total = saltelli(values_a[row], values_b[row], [values[row] for values in mixed])
        np.testing.assert_allclose(indices_in(record, "first"), first, atol=0.08)
        np.testing.assert_allclose(indices_in(record, "total"), total, atol=0.08)
        assert 0.9 < indices_in(record, "first").sum() < 1.1
