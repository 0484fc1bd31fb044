"""Raw logs: which rows are set aside and why, and what is refused."""

from __future__ import annotations

import re
import time

import numpy as np
import pandas as pd
import pytest

from tendon_cli.errors import InputError
from tendon_cli.fits.friction import fit_friction
from verification.friction_rigs.cases import mentions
from verification.friction_rigs.rig import Rig, simulate

RIG = Rig(0.1)
LOGS = simulate(RIG, 1)
MOTOR = LOGS.motor_cell[:, 0]
LOAD = LOGS.load_cell[:, 0]
ENDS = ("force motor (kg)", "force load (kg)")


def log_of(motor, load, names=ENDS, **columns) -> pd.DataFrame:
    """Return a log of 50 rows a second, as a logger writes it."""
    cells = {names[0]: np.round(motor, 3), names[1]: np.round(load, 3)}
    return pd.DataFrame({"time_s": np.round(0.02 * np.arange(len(motor)), 2), **cells, **columns})


def fit_of(*cells, **columns):
    return fit_friction(log_of(*cells, **columns), bend_angle="144 deg")


def reasons(fit) -> dict[str, int]:
    """Return the number of rows set aside for each reason."""
    return {part.reason.split(" (")[0]: part.rows for part in fit.set_aside}


def test_a_log() -> None:
    fit = fit_of(MOTOR, LOAD)
    assert fit.is_log
    assert fit.strokes == RIG.strokes
    assert not np.any(fit.rows.used & ~LOGS.slipping[:, 0])
    assert fit.rows.used.sum() > 0.7 * LOGS.slipping[:, 0].sum()
    assert reasons(fit) == {"inside the limits": len(MOTOR) - fit.rows.used.sum()}
    assert np.all(fit.rows.way[fit.rows.used] == LOGS.toward[fit.rows.used])


def test_zero_negative_and_missing_forces_are_set_aside(csv_file) -> None:
    motor = MOTOR.copy()
    motor[[500, 501, 502, 700, 899]] = 0.0, 0.0, 0.0, -1.0, np.nan
    path = csv_file("")
    log_of(motor, LOAD).to_csv(path, index=False)
    fit = fit_friction(path, bend_angle="144 deg")
    assert reasons(fit)["force at or below zero"] == 4
    assert reasons(fit)["no reading"] == 1
    at_zero = next(part for part in fit.set_aside if part.reason == "force at or below zero")
    assert at_zero.lines[0] == (502, 504)
    assert fit.friction == pytest.approx(0.1, rel=0.03)


def test_a_column_of_directions_agrees_with_the_forces() -> None:
    names = {1.0: "up", -1.0: "down", 0.0: "rest"}
    direction = [names[toward] for toward in LOGS.toward]
    fit = fit_of(MOTOR, LOAD, direction=direction)
    assert fit.friction == pytest.approx(fit_of(MOTOR, LOAD).friction, rel=1e-3)
    assert any(reason.startswith("at rest") for reason in reasons(fit))
    with pytest.raises(InputError, match="friction would help"):
        fit_of(MOTOR, LOAD, names=ENDS[::-1], direction=direction)


def test_which_cell_is_the_motors_is_inferred_and_said() -> None:
    log = log_of(LOAD, MOTOR, names=("cell 1 (kg)", "cell 2 (kg)"))
    inferred = fit_friction(log, bend_angle="144 deg", motor=None)
    stated = fit_friction(log, bend_angle="144 deg", motor="2")
    assert inferred.motor == "2"
    assert stated.friction == inferred.friction
    assert mentions(inferred.notes, "cell 2 is taken as the motor's")
    assert not mentions(stated.notes, "taken as")


def test_a_pause_and_a_stroke_that_never_slips_are_set_aside() -> None:
    start = np.flatnonzero(np.diff(LOGS.toward))[4] + 1
    log_ratio = np.abs(np.log(MOTOR[start:] / LOAD[start:]))
    halfway = start + int(np.flatnonzero(log_ratio < 0.05)[0])
    rows = np.arange(len(MOTOR))
    order = np.concatenate([rows[:halfway], np.full(200, halfway), rows[halfway:]])
    noise = 0.001 * np.random.default_rng(1).standard_normal(len(order))
    fit = fit_of(MOTOR[order] + noise, LOAD[order])
    assert not fit.rows.used[halfway : halfway + 200].any()
    assert fit.friction == pytest.approx(0.1, rel=0.03)


def test_a_rest_followed_by_one_direction_is_not_taken_for_two() -> None:
    rest = np.tile(np.arange(20), 7)
    rows = np.concatenate([rest, np.arange(40, 40 + 150)])
    with pytest.raises(InputError, match="back and forth"):
        fit_of(MOTOR[rows], LOAD[rows])


def test_rows_out_of_order_are_refused(csv_file) -> None:
    path = csv_file("")
    log = log_of(MOTOR, LOAD)
    log.loc[[99, 100], "time_s"] = log.loc[[100, 99], "time_s"].to_numpy()
    log.to_csv(path, index=False)
    with pytest.raises(InputError, match="time goes back") as caught:
        fit_friction(path, bend_angle="144 deg")
    assert caught.value.where == "cells.csv, line 102"


@pytest.mark.parametrize("column", ["motor", "load", "both", "noise"])
def test_dead_and_unrelated_cells_are_refused(column: str) -> None:
    motor = np.ones_like(MOTOR) if column in {"motor", "both"} else MOTOR
    load = np.ones_like(LOAD) if column in {"load", "both"} else LOAD
    if column == "noise":
        random = np.random.default_rng(1)
        motor, load = 1.0 + 0.01 * random.standard_normal((2, len(MOTOR)))
    with pytest.raises(InputError):
        fit_of(motor, load)


def test_two_bend_angles_in_one_log() -> None:
    other = simulate(Rig(0.1, bend_angle=4.0), 1, first_seed=9)
    motor = np.append(MOTOR, other.motor_cell[:, 0])
    load = np.append(LOAD, other.load_cell[:, 0])
    angles = np.repeat([RIG.bend_angle, 4.0], [len(MOTOR), len(other.toward)])
    fit = fit_friction(log_of(motor, load, bend_angle_rad=angles))
    assert fit.strokes == 24
    assert fit.friction == pytest.approx(0.1, rel=0.02)


def test_a_few_settled_readings_with_times_are_no_log() -> None:
    fit = fit_of([0.858, 1.236] * 20, [1.036, 1.028] * 20, ("cell 1", "cell 2"))
    assert not fit.is_log
    assert fit.rows.used.all()


def test_a_long_log_is_read_in_well_under_two_seconds(csv_file) -> None:
    path = csv_file("")
    log_of(np.tile(MOTOR, 5), np.tile(LOAD, 5)).to_csv(path, index=False)
    begin = time.process_time()
    fit_friction(path, bend_angle="144 deg")
    assert time.process_time() - begin < 2.0


def test_a_bend_taken_as_exact_says_what_one_degree_more_gives() -> None:
    fit = fit_of(MOTOR, LOAD)
    more = fit_friction(log_of(MOTOR, LOAD), bend_angle="145 deg")
    share = re.search(r"1 deg more gives ([\d.]+) % less μ", fit.text)
    assert share
    assert float(share[1]) == pytest.approx(100.0 * (1.0 - more.friction / fit.friction), abs=0.06)
