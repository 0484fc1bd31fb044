"""Raw logs: which rows are set aside and why, and what is refused."""

from __future__ import annotations

import time

import numpy as np
import pytest

from tendon_cli.errors import InputError
from tendon_cli.friction import fit_friction

from .rig import Rig, simulate

RIG = Rig(0.1)
LOGS = simulate(RIG, 1)


def log_text(motor, load, extra: dict[str, list[str]] | None = None, header="time_s,force motor (kg),force load (kg)"):
    extra = extra or {}
    lines = [",".join([header, *extra])]
    columns = [
        [f"{row * 0.02:.2f}" for row in range(len(motor))],
        [f"{f:.3f}" for f in motor],
        [f"{f:.3f}" for f in load],
    ]
    lines += [",".join(cells) for cells in zip(*columns, *extra.values(), strict=True)]
    return "\n".join(lines) + "\n"


MOTOR, LOAD = LOGS.motor_cell[:, 0], LOGS.load_cell[:, 0]


def reasons(fit) -> dict[str, int]:
    return {part.reason.split(" (")[0]: part.rows for part in fit.set_aside}


def test_a_log_from_a_file(csv_file) -> None:
    fit = fit_friction(csv_file(log_text(MOTOR, LOAD)), bend_angle="144 deg")
    assert fit.is_log
    assert fit.strokes == RIG.strokes
    assert not np.any(fit.rows.used & ~LOGS.slipping[:, 0])
    assert fit.rows.used.sum() > 0.7 * LOGS.slipping[:, 0].sum()
    assert set(reasons(fit)) == {"inside the limits"}
    assert sum(reasons(fit).values()) + fit.rows.used.sum() == len(MOTOR)
    assert np.all(fit.rows.way[fit.rows.used] == LOGS.toward[fit.rows.used])


def test_zero_negative_and_missing_forces_are_set_aside(csv_file) -> None:
    motor = MOTOR.copy()
    motor[500:503] = 0.0
    motor[700] = -1.0
    text = log_text(motor, LOAD).splitlines()
    text[901] = text[901].split(",")[0] + ",,1.0"
    fit = fit_friction(csv_file("\n".join(text)), bend_angle="144 deg")
    assert reasons(fit)["force at or below zero"] == 4
    assert reasons(fit)["no reading"] == 1
    assert next(part for part in fit.set_aside if part.reason == "force at or below zero").lines[0] == (502, 504)
    assert fit.friction == pytest.approx(0.1, rel=0.03)


def test_a_column_of_directions_agrees_with_the_forces(csv_file) -> None:
    names = {1.0: "up", -1.0: "down", 0.0: "rest"}
    text = log_text(MOTOR, LOAD, {"direction": [names[way] for way in LOGS.toward]})
    fit = fit_friction(csv_file(text), bend_angle="144 deg")
    plain = fit_friction(csv_file(log_text(MOTOR, LOAD)), bend_angle="144 deg")
    assert fit.friction == pytest.approx(plain.friction, rel=1e-3)
    assert any(reason.startswith("at rest") for reason in reasons(fit))
    swapped = (
        text.replace("force motor", "force x").replace("force load", "force motor").replace("force x", "force load")
    )
    with pytest.raises(InputError, match="friction would help"):
        fit_friction(csv_file(swapped), bend_angle="144 deg")


def test_which_cell_is_the_motors_is_inferred_and_said(csv_file) -> None:
    header = "time_s,cell 1 (kg),cell 2 (kg)"
    fit = fit_friction(csv_file(log_text(LOAD, MOTOR, header=header)), bend_angle="144 deg")
    assert fit.motor == "2"
    assert any("cell 2 is taken as the motor's" in text for text in fit.notes)
    told = fit_friction(csv_file(log_text(LOAD, MOTOR, header=header)), bend_angle="144 deg", motor="2")
    assert told.friction == fit.friction
    assert not any("taken as" in text for text in told.notes)


def test_a_pause_and_a_stroke_that_never_slips_are_set_aside(csv_file) -> None:
    start = np.flatnonzero(np.diff(LOGS.toward))[4] + 1
    halfway = start + int(np.flatnonzero(np.abs(np.log(MOTOR[start:] / LOAD[start:])) < 0.05)[0])
    order = np.concatenate([np.arange(halfway), np.full(200, halfway), np.arange(halfway, len(MOTOR))])
    noise = 0.001 * np.random.default_rng(1).standard_normal(len(order))
    fit = fit_friction(csv_file(log_text(MOTOR[order] + noise, LOAD[order])), bend_angle="144 deg")
    assert not fit.rows.used[halfway : halfway + 200].any()
    assert fit.friction == pytest.approx(0.1, rel=0.03)


def test_a_rest_followed_by_one_direction_is_not_taken_for_two(csv_file) -> None:
    rows = np.concatenate([np.zeros(20, dtype=int) + np.arange(20), np.arange(40, 40 + 150)])
    one_way = log_text(np.concatenate([MOTOR[:20]] * 6 + [MOTOR[rows]]), np.concatenate([LOAD[:20]] * 6 + [LOAD[rows]]))
    with pytest.raises(InputError, match="back and forth"):
        fit_friction(csv_file(one_way), bend_angle="144 deg")


def test_rows_out_of_order_are_refused(csv_file) -> None:
    lines = log_text(MOTOR, LOAD).splitlines()
    lines[100], lines[101] = lines[101], lines[100]
    with pytest.raises(InputError, match="time goes back") as caught:
        fit_friction(csv_file("\n".join(lines)), bend_angle="144 deg")
    assert caught.value.where == "cells.csv, line 102"


@pytest.mark.parametrize("column", ["motor", "load", "both", "noise"])
def test_dead_and_unrelated_cells_are_refused(column: str, csv_file) -> None:
    motor = np.ones_like(MOTOR) if column in {"motor", "both"} else MOTOR
    load = np.ones_like(LOAD) if column in {"load", "both"} else LOAD
    if column == "noise":
        motor, load = 1.0 + 0.01 * np.random.default_rng(1).standard_normal((2, len(MOTOR)))
    with pytest.raises(InputError):
        fit_friction(csv_file(log_text(motor, load)), bend_angle="144 deg")


def test_two_bend_angles_in_one_log(csv_file) -> None:
    other = simulate(Rig(0.1, bend_angle=4.0), 1, first_seed=9)
    motor = np.concatenate([MOTOR, other.motor_cell[:, 0]])
    load = np.concatenate([LOAD, other.load_cell[:, 0]])
    angles = [repr(RIG.bend_angle)] * len(MOTOR) + ["4.0"] * len(other.toward)
    fit = fit_friction(csv_file(log_text(motor, load, {"bend_angle_rad": angles})), bend_angle=None)
    assert fit.strokes == 24
    assert fit.friction == pytest.approx(0.1, rel=0.02)


def test_a_few_settled_readings_with_times_are_no_log(csv_file) -> None:
    rows = [f"{t},{1.236 if t % 2 else 0.858},{1.028 if t % 2 else 1.036}" for t in range(40)]
    fit = fit_friction(csv_file("time,cell 1,cell 2\n" + "\n".join(rows)), bend_angle="144 deg")
    assert not fit.is_log
    assert fit.rows.used.all()


def test_a_long_log_is_read_in_well_under_two_seconds(csv_file) -> None:
    path = csv_file(log_text(np.tile(MOTOR, 5), np.tile(LOAD, 5)))
    begin = time.process_time()
    fit_friction(path, bend_angle="144 deg")
    assert time.process_time() - begin < 2.0
