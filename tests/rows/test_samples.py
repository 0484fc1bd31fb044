"""Samples: rows that are drawn, the same everywhere, between bounds and by distributions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import qmc

import tendon_cli as tendon

BETWEEN = {
    "spring.stiffness": "1 kN/m to 8 kN/m",
    "spool.ratio": "0.4 to 1.0",
    "sheath.friction": "0.07 +/- 0.02",
}


def sample(method="sobol", count=64, **more):
    table = {"name": "sample", "sample": method, "count": count, "between": BETWEEN, **more}
    return tendon.study({"table": [table]})


def numbers(study):
    return study.row_tables[0].numbers


@pytest.mark.parametrize("method", ["sobol", "latin-hypercube", "random"])
def test_rows_lie_between_their_bounds_and_repeat(method):
    drawn = numbers(sample(method))
    assert (drawn["spring.stiffness"] >= 1e3).all()
    assert (drawn["spring.stiffness"] <= 8e3).all()
    assert ((drawn["spool.ratio"] >= 0.4) & (drawn["spool.ratio"] <= 1.0)).all()
    assert (drawn["sheath.friction"] >= 0.0).all()
    again = numbers(sample(method))
    other = numbers(sample(method, seed=2))
    for key, values in drawn.items():
        assert values.tobytes() == again[key].tobytes()
        assert not np.array_equal(values, other[key])


def test_a_latin_hypercube_has_one_point_in_each_layer():
    values = numbers(sample("latin-hypercube", 50))["spool.ratio"]
    layers = np.floor((values - 0.4) / 0.6 * 50).astype(int)
    assert sorted(layers) == list(range(50))


def test_sobol_points_fill_the_cube_more_evenly_than_random_ones():
    def discrepancy(method):
        drawn = numbers(sample(method, 256))
        cube = [(drawn["spring.stiffness"] - 1e3) / 7e3, (drawn["spool.ratio"] - 0.4) / 0.6]
        return qmc.discrepancy(np.column_stack(cube))

    assert discrepancy("sobol") < 0.2 * discrepancy("random")


def test_a_normal_number_has_its_mean_and_deviation():
    friction = numbers(sample(count=1024))["sheath.friction"]
    assert np.mean(friction) == pytest.approx(0.07, abs=2e-4)
    assert np.std(friction) == pytest.approx(0.02, rel=0.02)


def test_rows_have_twelve_digits_so_that_they_are_the_same_on_every_machine():
    for values in numbers(sample()).values():
        assert [float(f"{value:.12g}") for value in values] == values.tolist()


def test_a_sample_is_the_table_of_its_rows():
    drawn = sample()
    rows = drawn.document()["table"][0]
    stated = tendon.study({"table": [rows]})
    assert stated.hash == drawn.hash
    assert drawn.row_tables[0].names[:3] == ("1", "2", "3")
    assert "sobol" in str(drawn.sources).lower()


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"count": None}, "count"),
        ({"between": None}, "between"),
        ({"between": {"spring.stifness": "1 to 2"}}, "spring.stiffness"),
        ({"between": {"spring.stiffness": "3 kN/m"}}, "neither a range nor a distribution"),
        ({"sample": "sobl"}, "sobol"),
        ({"rows": [{"name": "a"}]}, "leave one out"),
    ],
)
def test_a_bad_sample_says_what_helps(change, problem):
    table = {"name": "sample", "sample": "sobol", "count": 8, "between": BETWEEN, **change}
    given = {key: value for key, value in table.items() if value is not None}
    with pytest.raises(tendon.TendonError, match=problem):
        tendon.study({"table": [given]})
