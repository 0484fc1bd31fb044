"""Rows and values of a table's axes are those of the product, whole or in parts."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from tendon_cli.figures.axes import evenly
from tendon_cli.figures.product import product_of
from tendon_cli.space import plan
from tests.figures.runs import LOADS, grid, states

CONTENT = {
    "tendon": {"pretension": grid("0 N", "200 N", 5), "flexor": {"length": ["1 m", "2 m"]}},
    "load": {"mass": LOADS},
    "cases": [{"name": "child", "arm": {"forearm_mass": "0.6 kg"}}, {"name": "adult"}],
}


def test_rows_follow_the_order_of_the_table(tmp_path: Path) -> None:
    product = product_of(states(tmp_path / "run", CONTENT))
    whole = product.files.read().to_pydict()
    assert [axis.column for axis in product.axes] == [
        "case", "pretension", "tendon_length_flexor", "load_mass", "direction", "elbow_angle",
    ]  # fmt: skip
    assert math.prod(axis.length for axis in product.axes) == product.files.rows
    positions = {axis.column: np.array([axis.length - 1]) for axis in product.axes}
    positions |= {"load_mass": np.arange(4), "elbow_angle": np.array([0, 15, 3])}
    rows = product.rows(["elbow_angle", "load_mass"], positions)
    assert rows.shape == (3, 4)
    read = product.gather(rows, ("elbow_angle", "load_mass", "motor_torque", "case", "direction"))
    assert set(read["case"].ravel()) == {"adult"}
    assert set(read["direction"].ravel()) == {"extension"}
    np.testing.assert_array_equal(read["load_mass"], np.broadcast_to([0.0, 3.0, 5.0, 10.0], (3, 4)))
    np.testing.assert_array_equal(read["motor_torque"], np.array(whole["motor_torque"])[rows])
    for axis in product.axes:
        assert list(axis.values) == list(dict.fromkeys(whole[axis.column]))


def test_many_files_are_read_as_one_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = states(tmp_path / "one", CONTENT).read().to_pydict()
    monkeypatch.setattr(plan, "STATES_PER_PART", 700)
    monkeypatch.setattr(plan, "STATES_PER_FILE", 700)
    many = product_of(states(tmp_path / "many", CONTENT))
    assert len(many.files.files) > 3
    rows = np.arange(many.files.rows)[::-7].reshape(1, -1)
    np.testing.assert_array_equal(many.gather(rows, ["motor_torque"])["motor_torque"][0], whole["motor_torque"][::-7])


def test_evenly_keeps_both_ends() -> None:
    assert list(evenly(3, 5)) == [0, 1, 2]
    assert list(evenly(101, 3)) == [0, 50, 100]
    assert list(evenly(5, 1)) == [2]
    assert len(evenly(10**7, 1000)) == 1000
