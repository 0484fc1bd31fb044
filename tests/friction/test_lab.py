"""Additions of a lab: motor position, zeros of the cells, files, strokes, speed, arrays."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import tendon_cli as tendon
from tendon_cli.errors import InputError, UsageError
from tendon_cli.fits.friction import write_strokes
from verification.friction_rigs.cases import mentions
from verification.friction_rigs.rig import Rig, simulate

RIG = Rig(0.1, load_spring=0.5, strokes=8)
LOGS = simulate(RIG, 2)


def frame(seed: int = 0, rig: Rig = RIG, speed: float = 1.0, **changed: float) -> pd.DataFrame:
    """Return a log with the motor's position."""
    if rig == RIG and not changed:
        logs = LOGS
        column = seed
    else:
        logs = simulate(replace(rig, **changed), 1, first_seed=seed)
        column = 0
    return pd.DataFrame(
        {
            "time_s": 0.02 * np.arange(len(logs.toward)) / speed,
            "force_motor_N": 10.0 * logs.motor_cell[:, column],
            "force_load_N": 10.0 * logs.load_cell[:, column],
            "position_mm": np.round(np.cumsum(logs.toward), 3),
        }
    )


def fit_of(readings, **options):
    return tendon.fit_friction(readings, "144 deg", **options)


def written(folder: Path, table: pd.DataFrame, name: str = "log.csv") -> Path:
    """Write a table into the folder and return its path."""
    table.to_csv(folder / name, index=False)
    return folder / name


def test_a_frame_arrays_and_a_file_are_the_same_fit(tmp_path: Path) -> None:
    table = frame()
    of_file = fit_of(written(tmp_path, table))
    of_frame = fit_of(table)
    of_arrays = fit_of({name: table[name].array for name in table})
    assert of_frame.friction == of_arrays.friction
    assert of_frame.friction == pytest.approx(of_file.friction, rel=1e-12)
    assert len(repr(of_frame).splitlines()) <= 15
    assert of_frame.sha256 == of_arrays.sha256
    with pytest.raises(UsageError, match="int is not"):
        fit_of(3)
    with pytest.raises(InputError, match="no header names the two load cells"):
        fit_of({"a": [1.0], "b": [2.0]})


def test_the_position_gives_direction_and_rests() -> None:
    toward = simulate(replace(RIG, dwell=60), 1).toward
    table = frame(dwell=60)
    fit = fit_of(table, position="position_mm")
    resting = next(part for part in fit.set_aside if part.reason.startswith("at rest"))
    assert resting.rows == pytest.approx(np.count_nonzero(toward == 0.0), rel=0.05)
    moved = fit.rows.used & (toward != 0.0)  # where a rest begins is known to a row or two
    assert np.all(fit.rows.way[moved] == toward[moved])
    assert np.count_nonzero(fit.rows.used & (toward == 0.0)) < 0.02 * moved.sum()
    low, high = fit.interval_95
    assert low < 0.1 < high
    assert fit.presliding.reversals >= 4
    assert fit.presliding.backlash < 3.0
    table["position_mm"] *= -1.0  # whatever sign the encoder has
    assert fit_of(table, position="position_mm").friction == fit.friction


def test_a_position_that_says_nothing_is_refused() -> None:
    with pytest.raises(InputError, match="never moves"):
        fit_of(frame().assign(position_mm=5.0), position="position_mm")
    with pytest.raises(UsageError, match="no column"):
        fit_of(frame(), position="angle")


def test_stated_zeros_are_taken_off_and_their_uncertainty_is_in_the_budget() -> None:
    table = frame()
    off = table.assign(
        force_motor_N=table.force_motor_N + 2.0, force_load_N=table.force_load_N - 1.0
    )
    fit = fit_of(off, zero_motor="2 N", zero_load=-1.0)
    assert fit.friction == pytest.approx(fit_of(table).friction, rel=1e-9)
    budget = fit_of(table, cell_uncertainty="0.2 N, 0.5 %").record["budget"]
    parts = {part["name"]: part for part in budget}
    assert parts["zero of the motor's cell"]["standard_uncertainty"] == 0.2
    with pytest.raises(InputError, match="larger than its forces"):
        fit_of(table, zero_motor="100 N")
    with pytest.raises(UsageError):
        fit_of(table, zero_motor="2 mm")


def test_a_stated_zero_error_moves_a_constant_force_as_the_budget_says() -> None:
    """The sensitivity agrees with the fit of readings that are off by that error."""
    table = frame(load_spring=0.0)
    fit = fit_of(table, cell_uncertainty="0.01 N")
    part = next(part for part in fit.uncertainty.parts if part.name == "zero of the motor's cell")
    moved = fit_of(table.assign(force_motor_N=table.force_motor_N + 0.01)).friction - fit.friction
    assert part.sensitivity * 0.01 == pytest.approx(moved, rel=0.1)


def test_several_files_are_one_fit_that_says_whether_they_agree(tmp_path: Path) -> None:
    first = written(tmp_path, frame(0), "0.csv")
    second = written(tmp_path, frame(1), "1.csv")
    both = fit_of([first, second])
    assert both.strokes == 16
    assert [part["strokes"] for part in both.files] == [8, 8]
    assert not mentions(both.warnings, "do not agree")
    rougher = written(tmp_path, frame(friction=0.13), "rougher.csv")
    assert mentions(fit_of([first, rougher]).warnings, "do not agree")
    kilograms = frame().rename(columns=lambda name: name.replace("_N", "_kg"))
    with pytest.raises(InputError, match="is in"):
        fit_of([first, written(tmp_path, kilograms, "kg.csv")])


def test_friction_that_goes_with_speed_is_warned_of() -> None:
    parts = []
    for seed, speed in enumerate((0.5, 1.0, 2.0, 4.0)):
        part = frame(seed, speed=speed, strokes=4, friction=0.1 * speed**0.1)
        if parts:
            last = parts[-1].iloc[-1]
            part["time_s"] += last["time_s"] + 0.02
            part["position_mm"] += last["position_mm"]
        parts.append(part)
    fit = fit_of(pd.concat(parts, ignore_index=True), position="position_mm")
    assert mentions(fit.warnings, "varies with the speed")
    assert not mentions(fit.warnings, "drift")
    assert fit.speed.power == pytest.approx(0.1, abs=0.03)
    assert fit.speed.fastest / fit.speed.slowest == pytest.approx(8.0, rel=0.2)


def test_strokes_are_written_one_a_row(tmp_path: Path) -> None:
    fit = fit_of(frame(), position="position_mm")
    write_strokes(fit, tmp_path / "strokes.csv")
    rows = pd.read_csv(tmp_path / "strokes.csv", comment="#")
    assert len(rows) == RIG.strokes
    assert rows.used.sum() == np.count_nonzero(fit.rows.used)
    assert rows.friction.mean() == pytest.approx(fit.friction, rel=0.01)
    assert json.dumps(fit.record)
