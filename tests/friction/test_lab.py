"""What a lab adds: the motor's position, zeros of the cells, several files, strokes, speed, arrays."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import tendon_cli as tendon
from tendon_cli.errors import InputError, UsageError

from .rig import Rig, simulate

RIG = Rig(0.1, load_spring=0.5, strokes=8)
LOGS = simulate(RIG, 2)
ANGLE = "144 deg"


def frame(seed: int = 0, rig: Rig = RIG, logs=LOGS, speed: float = 1.0) -> pd.DataFrame:
    """A log with the motor's position."""
    rows = len(logs.toward)
    return pd.DataFrame(
        {
            "time_s": 0.02 * np.arange(rows) / speed,
            "force_motor_N": 10.0 * logs.motor_cell[:, seed],
            "force_load_N": 10.0 * logs.load_cell[:, seed],
            "position_mm": np.round(np.cumsum(logs.toward), 3),
        }
    )


def written(folder: Path, table: pd.DataFrame, name: str = "log.csv") -> Path:
    path = folder / name
    table.to_csv(path, index=False)
    return path


def test_a_frame_arrays_and_a_file_are_the_same_fit(tmp_path: Path) -> None:
    table = frame()
    fits = [tendon.fit_friction(given, ANGLE) for given in
            (written(tmp_path, table), table, {name: table[name].to_numpy() for name in table})]  # fmt: skip
    assert fits[1].friction == fits[2].friction == pytest.approx(fits[0].friction, rel=1e-12)
    assert len(repr(fits[1]).splitlines()) <= 15
    assert fits[1].sha256 == fits[2].sha256
    with pytest.raises(UsageError, match="not int"):
        tendon.fit_friction(3, ANGLE)
    with pytest.raises(InputError, match="no column is named"):
        tendon.fit_friction({"a": [1.0], "b": [2.0]}, ANGLE)


def test_the_position_gives_direction_and_rests() -> None:
    rig = replace(RIG, dwell=60)
    logs = simulate(rig, 1)
    table = frame(rig=rig, logs=logs)
    fit = tendon.fit_friction(table, ANGLE, position="position_mm")
    resting = next(part for part in fit.set_aside if part.reason.startswith("at rest"))
    assert resting.rows == pytest.approx(np.count_nonzero(logs.toward == 0.0), rel=0.05)
    moved = fit.rows.used & (logs.toward != 0.0)  # where a rest begins is known to a row or two
    assert np.all(fit.rows.way[moved] == logs.toward[moved])
    assert np.count_nonzero(fit.rows.used & (logs.toward == 0.0)) < 0.02 * moved.sum()
    low, high = fit.interval_95
    assert low < 0.1 < high
    assert fit.presliding.reversals >= 4
    assert fit.presliding.backlash < 3.0
    table["position_mm"] *= -1.0  # whatever sign the encoder has
    assert tendon.fit_friction(table, ANGLE, position="position_mm").friction == fit.friction


def test_a_position_that_says_nothing_is_refused() -> None:
    table = frame().assign(position_mm=5.0)
    with pytest.raises(InputError, match="never moves"):
        tendon.fit_friction(table, ANGLE, position="position_mm")
    with pytest.raises(UsageError, match="no column"):
        tendon.fit_friction(table, ANGLE, position="angle")


def test_stated_zeros_are_taken_off_and_their_uncertainty_is_in_the_budget() -> None:
    table = frame()
    table["force_motor_N"] += 2.0
    table["force_load_N"] -= 1.0
    fit = tendon.fit_friction(table, ANGLE, zero_motor="2 N", zero_load=-1.0)
    assert fit.friction == pytest.approx(tendon.fit_friction(frame(), ANGLE).friction, rel=1e-9)
    given = tendon.fit_friction(frame(), ANGLE, cell_uncertainty="0.2 N, 0.5 %")
    parts = {part["name"]: part for part in given.record["budget"]}
    assert parts["zero of the motor's cell"]["standard_uncertainty"] == 0.2
    with pytest.raises(InputError, match="larger than its forces"):
        tendon.fit_friction(table, ANGLE, zero_motor="100 N")
    with pytest.raises(UsageError):
        tendon.fit_friction(table, ANGLE, zero_motor="2 mm")


def test_a_stated_zero_error_moves_a_constant_force_as_the_budget_says() -> None:
    """The sensitivity against the fit of readings that are off by so much."""
    rig = replace(RIG, load_spring=0.0)
    logs = simulate(rig, 1)
    table = frame(rig=rig, logs=logs)
    fit = tendon.fit_friction(table, ANGLE, cell_uncertainty="0.01 N")
    part = next(part for part in fit.uncertainty.parts if part.name == "zero of the motor's cell")
    moved = tendon.fit_friction(table.assign(force_motor_N=table.force_motor_N + 0.01), ANGLE).friction - fit.friction
    assert part.sensitivity * 0.01 == pytest.approx(moved, rel=0.1)


def test_several_files_are_one_fit_that_says_whether_they_agree(tmp_path: Path) -> None:
    first, second = (written(tmp_path, frame(seed), f"{seed}.csv") for seed in (0, 1))
    both = tendon.fit_friction([first, second], ANGLE)
    assert both.strokes == 16
    assert [part["strokes"] for part in both.files] == [8, 8]
    assert not any("do not agree" in text for text in both.warnings)
    other = simulate(replace(RIG, friction=0.13), 1)
    third = written(tmp_path, frame(logs=other), "other.csv")
    apart = tendon.fit_friction([first, third], ANGLE)
    assert any("do not agree" in text for text in apart.warnings)
    kilograms = frame().rename(columns={"force_motor_N": "force_motor_kg", "force_load_N": "force_load_kg"})
    with pytest.raises(InputError, match="is in"):
        tendon.fit_friction([first, written(tmp_path, kilograms, "kg.csv")], ANGLE)


def test_friction_that_goes_with_speed_is_told() -> None:
    parts = []
    for at, speed in enumerate((0.5, 1.0, 2.0, 4.0)):
        logs = simulate(replace(RIG, strokes=4, friction=0.1 * speed**0.1), 1, first_seed=at)
        parts.append(frame(logs=logs, speed=speed))
        if at:
            parts[-1]["time_s"] += parts[-2]["time_s"].iloc[-1] + 0.02
            parts[-1]["position_mm"] += parts[-2]["position_mm"].iloc[-1]
    fit = tendon.fit_friction(pd.concat(parts, ignore_index=True), ANGLE, position="position_mm")
    assert any("goes with the speed" in text for text in fit.warnings)
    assert not any("drift" in text for text in fit.warnings)
    assert fit.speed.power == pytest.approx(0.1, abs=0.03)
    assert fit.speed.fastest / fit.speed.slowest == pytest.approx(8.0, rel=0.2)


def test_strokes_are_written_one_a_row(tmp_path: Path) -> None:
    from tendon_cli.friction import write_strokes

    fit = tendon.fit_friction(frame(), ANGLE, position="position_mm")
    write_strokes(fit, tmp_path / "strokes.csv")
    lines = (tmp_path / "strokes.csv").read_text().splitlines()
    rows = list(csv.DictReader(lines[1:]))
    assert len(rows) == RIG.strokes
    assert sum(int(row["used"]) for row in rows) == np.count_nonzero(fit.rows.used)
    assert np.mean([float(row["friction"]) for row in rows]) == pytest.approx(fit.friction, rel=0.01)
    assert json.dumps(fit.record)
