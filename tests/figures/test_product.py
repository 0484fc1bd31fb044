"""Rows and values of a table's axes are those of the cube, whole or in parts."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tendon_cli.cube.cube import cube_of
from tendon_cli.cube.rows import rows_in
from tendon_cli.cube.source import table_in
from tendon_cli.errors import UsageError
from tests.figures.runs import LOADS, designs, grid, states, sweep

CONTENT = {
    "tendon": {"pretension": grid("0 N", "200 N", 5), "flexor": {"length": ["1 m", "2 m"]}},
    "load": {"mass": LOADS},
    "cases": [{"name": "child", "arm": {"forearm_mass": "0.6 kg"}}, {"name": "adult"}],
}


def test_rows_follow_the_order_of_the_table(tmp_path: Path) -> None:
    cube = cube_of(states(tmp_path / "run", CONTENT))
    whole = cube.table.read().to_pydict()
    assert [axis.column for axis in cube.axes] == [
        "case",
        "pretension",
        "tendon_length_flexor",
        "load_mass",
        "direction",
        "elbow_angle",
    ]
    assert math.prod(axis.length for axis in cube.axes) == cube.table.rows
    positions = {axis.column: np.array([axis.length - 1]) for axis in cube.axes}
    positions |= {"load_mass": np.arange(4), "elbow_angle": np.array([0, 15, 3])}
    rows = cube.rows(["elbow_angle", "load_mass"], positions)
    assert rows.shape == (3, 4)
    read = cube.gather(rows, ("elbow_angle", "load_mass", "motor_torque", "case", "direction"))
    assert set(read["case"].ravel()) == {"adult"}
    assert set(read["direction"].ravel()) == {"extension"}
    np.testing.assert_array_equal(read["load_mass"], np.broadcast_to([0.0, 3.0, 5.0, 10.0], (3, 4)))
    np.testing.assert_array_equal(read["motor_torque"], np.array(whole["motor_torque"])[rows])
    for axis in cube.axes:
        assert list(axis.values) == list(dict.fromkeys(whole[axis.column]))


def test_many_files_are_read_as_one_table(tmp_path: Path, small_parts: Callable[..., None]) -> None:
    whole = states(tmp_path / "one", CONTENT).read().to_pydict()
    small_parts(700)
    cube = cube_of(states(tmp_path / "many", CONTENT))
    assert len(cube.table.files) > 3
    rows = np.arange(cube.table.rows)[::-7].reshape(1, -1)
    read = cube.gather(rows, ["motor_torque"])
    np.testing.assert_array_equal(read["motor_torque"][0], whole["motor_torque"][::-7])


def test_states_that_were_not_kept_are_those_that_would_have_been(tmp_path: Path) -> None:
    whole = states(tmp_path / "whole", CONTENT)
    kept = cube_of(whole)
    only_status = tmp_path / "status"
    states(only_status, {**CONTENT, "output": {"states": ["status"]}})
    only_designs = tmp_path / "designs"
    motion = {"elbow_angle": grid("0 deg", "90 deg", 16)}
    sweep(only_designs, {"motion": motion, **CONTENT, "output": {"tables": ["designs"]}})
    for folder in (only_designs, only_status):
        files = table_in(folder, None, ["motor_torque", "load.mass"])
        pd.testing.assert_frame_equal(
            files.read(whole.schema.names).to_pandas(), whole.read().to_pandas()
        )
        rows = np.arange(files.rows)[::-8].reshape(2, -1)
        names = ("status", "flexor_elongation", "case", "motor_torque")
        computed = cube_of(files).gather(rows, names)
        read = kept.gather(rows, names)
        for name in names:
            np.testing.assert_array_equal(computed[name], read[name])
    with pytest.raises(UsageError, match="no column"):
        rows_in(only_designs, where=["margin > 5 N"], columns=["motor_torque"]).head(1)
    name = "flexor_elongation"
    (selected,) = rows_in(only_designs, where=[f"{name} > 2 mm"], columns=[name]).batches()
    elongations = kept.gather(np.arange(whole.rows), [name])[name]
    np.testing.assert_array_equal(selected[name], elongations[elongations > 2e-3])


@pytest.mark.parametrize(
    ("text", "count"), [("taut = yes", 4), ("taut = true", 4), ("taut != no", 4), ("taut = 0", 1)]
)
def test_a_filter_means_the_same_of_rows_and_of_axes(tmp_path: Path, text: str, count: int) -> None:
    files = designs(tmp_path / "run", {"tendon": {"pretension": grid("80 N", "200 N", 5)}})
    cube = cube_of(files)
    (condition,) = cube.conditions([text])
    is_selected = condition.holds(cube.gather(np.arange(files.rows), ["taut"])["taut"])
    assert int(is_selected.sum()) == count
    _, selected_count = rows_in(tmp_path / "run", where=[text]).head(0)
    assert selected_count == count
