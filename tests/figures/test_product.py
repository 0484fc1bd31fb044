"""Rows and values of a table's axes are those of the cube, whole or in parts."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tendon_cli.cube.cube import cube_of
from tendon_cli.cube.rows import rows_in
from tendon_cli.cube.source import table_at
from tendon_cli.engine import plan
from tendon_cli.errors import UsageError
from tests.figures.runs import LOADS, designs, grid, states, sweep

CONTENT = {
    "tendon": {"pretension": grid("0 N", "200 N", 5), "flexor": {"length": ["1 m", "2 m"]}},
    "load": {"mass": LOADS},
    "cases": [{"name": "child", "arm": {"forearm_mass": "0.6 kg"}}, {"name": "adult"}],
}


def test_rows_follow_the_order_of_the_table(tmp_path: Path) -> None:
    cube = cube_of(states(tmp_path / "run", CONTENT))
    whole = cube.files.read().to_pydict()
    assert [axis.column for axis in cube.axes] == [
        "case",
        "pretension",
        "tendon_length_flexor",
        "load_mass",
        "direction",
        "elbow_angle",
    ]
    assert math.prod(axis.length for axis in cube.axes) == cube.files.rows
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


def test_many_files_are_read_as_one_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = states(tmp_path / "one", CONTENT).read().to_pydict()
    monkeypatch.setattr(plan, "STATES_PER_PART", 700)
    monkeypatch.setattr(plan, "STATES_PER_FILE", 700)
    many = cube_of(states(tmp_path / "many", CONTENT))
    assert len(many.files.files) > 3
    rows = np.arange(many.files.rows)[::-7].reshape(1, -1)
    np.testing.assert_array_equal(
        many.gather(rows, ["motor_torque"])["motor_torque"][0], whole["motor_torque"][::-7]
    )


ONLY_DESIGNS = {"output": {"tables": ["designs"]}}


def test_states_that_were_not_kept_are_those_that_would_have_been(tmp_path: Path) -> None:
    whole = states(tmp_path / "whole", CONTENT)
    states(tmp_path / "some", {**CONTENT, "output": {"states": ["status"]}})
    sweep(
        tmp_path / "few",
        {"motion": {"elbow_angle": grid("0 deg", "90 deg", 16)}, **CONTENT, **ONLY_DESIGNS},
    )
    for folder in (tmp_path / "few", tmp_path / "some"):
        found = table_at(folder, None, ["motor_torque", "load.mass"])
        pd.testing.assert_frame_equal(
            found.read(whole.schema.names).to_pandas(), whole.read().to_pandas()
        )
        cube, kept = cube_of(found), cube_of(whole)
        rows = np.arange(found.rows)[::-8].reshape(2, -1)
        names = ("status", "flexor_elongation", "case", "motor_torque")
        worked_out, read = cube.gather(rows, names), kept.gather(rows, names)
        for name in names:
            np.testing.assert_array_equal(worked_out[name], read[name])
    with pytest.raises(UsageError, match="no column"):
        rows_in(tmp_path / "few", where=["margin > 5 N"], columns=["motor_torque"]).head(1)
    (stretch,) = rows_in(
        tmp_path / "few", where=["flexor_elongation > 2 mm"], columns=["flexor_elongation"]
    ).batches()
    known = kept.gather(np.arange(whole.rows), ["flexor_elongation"])["flexor_elongation"]
    np.testing.assert_array_equal(stretch["flexor_elongation"], known[known > 2e-3])


@pytest.mark.parametrize(
    ("text", "count"), [("taut = yes", 4), ("taut = true", 4), ("taut != no", 4), ("taut = 0", 1)]
)
def test_a_filter_means_the_same_of_rows_and_of_axes(tmp_path: Path, text: str, count: int) -> None:
    table = designs(tmp_path / "run", {"tendon": {"pretension": grid("80 N", "200 N", 5)}})
    cube = cube_of(table)
    (condition,) = cube.of.conditions([text])
    held = condition.holds(cube.gather(np.arange(table.rows), ["taut"])["taut"])
    assert rows_in(tmp_path / "run", where=[text]).head(0)[1] == int(held.sum()) == count
