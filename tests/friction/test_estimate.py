"""The estimate: the paper's table, exact lines, gain, offsets, robustness, uncertainty."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import ttest_ind

from tendon_cli.errors import InputError
from tendon_cli.fits.friction import fit_friction
from tendon_cli.fits.friction.budget import BEND, RESOLUTION, SCATTER
from verification.friction_rigs.cases import CASES, fits_of, log_of, mentions, readings
from verification.friction_rigs.rig import Rig, simulate

TABLE = Path(__file__).parents[2] / "configs" / "friction" / "table_a1.csv"
ANGLE = math.radians(144.0)


def holds(fit, friction: float) -> bool:
    """Return True if the interval of a fit holds the friction."""
    low, high = fit.uncertainty.interval_95
    return bool(low <= friction <= high)


def settled(
    friction: float,
    angles,
    *,
    gain: float = 1.0,
    offsets=(0.0, 0.0),
    loads=(1.0,),
    repeats: int = 2,
) -> str:
    """Return a file of settled readings that lie exactly on the line."""
    lines = ["bend_angle_rad,direction,motor,load"]
    for angle in angles:
        for direction, name in ((1, "up"), (-1, "down")):
            for load in loads:
                motor = gain * load * math.exp(direction * friction * angle) + offsets[0]
                lines += [f"{angle!r},{name},{motor!r},{load + offsets[1]!r}"] * repeats
    return "\n".join(lines) + "\n"


def test_the_degrees_of_freedom_of_two_strokes_are_those_of_their_readings() -> None:
    """Six readings less μ and the gain leave four; two strokes show no scatter of strokes."""
    readings = {"direction": ["pull"] * 3 + ["release"] * 3, "motor (N)": [], "load (N)": []}
    readings["motor (N)"] = [12.36, 12.37, 12.35, 8.58, 8.57, 8.59]
    readings["load (N)"] = [10.28, 10.27, 10.28, 10.36, 10.35, 10.36]
    few = fit_friction(readings, 2.5).uncertainty.parts[0]
    assert few.name == "scatter of the readings within the strokes"
    assert few.degrees_of_freedom == 4.0
    many = {name: values * 3 for name, values in readings.items()}
    part = fit_friction(many, 2.5).uncertainty.parts[0]
    assert part.name == "scatter of the strokes"
    assert part.degrees_of_freedom == 4.0  # six strokes less μ and the gain


def test_table_a1() -> None:
    fit = fit_friction(TABLE, bend_angle="144 deg")
    assert [f"{part.friction:.4f}" for part in fit.by_direction.values()] == ["0.0734", "0.0752"]
    assert f"{fit.friction:.4f}" == "0.0743"
    assert fit.gain_ratio == pytest.approx(0.998, abs=5e-4)
    assert fit.motor == "1"
    straight = fit_friction(TABLE, bend_angle="180 deg").by_direction
    assert [f"{part.friction:.4f}" for part in straight.values()] == ["0.0588", "0.0601"]
    other = fit_friction(TABLE, bend_angle="144 deg", motor="2")
    assert other.friction == pytest.approx(fit.friction, rel=1e-12)
    assert other.gain_ratio == pytest.approx(1.0 / fit.gain_ratio, rel=1e-12)
    bare = fit_friction(TABLE)
    assert bare.friction is None
    assert bare.standard_error is None
    assert bare.interval_95 is None
    assert bare.friction_bend == pytest.approx(fit.friction_bend, rel=1e-12)
    assert bare.friction_bend_interval_95 == pytest.approx(fit.friction_bend_interval_95, rel=1e-9)


def test_bend_angle_uncertainty_is_carried_through() -> None:
    exact = fit_friction(TABLE, bend_angle="144 deg")
    vague = fit_friction(TABLE, bend_angle="144 deg +/- 2 deg")
    near = fit_friction(TABLE, bend_angle="144 deg ± 1 deg")
    error = exact.uncertainty.standard_error
    expected = math.hypot(error, vague.friction * 2.0 / 144.0)
    assert vague.uncertainty.standard_error == pytest.approx(expected, rel=1e-12)
    assert vague.uncertainty.degrees_of_freedom > 1000
    assert vague.friction_bend_standard_error / vague.bend_angle == pytest.approx(error, rel=1e-12)
    assert near.uncertainty.contribution_of(BEND) / near.friction == pytest.approx(0.007, abs=1e-4)


@pytest.mark.parametrize("friction", [0.001, 0.02, 0.4, 1.5])
@pytest.mark.parametrize("gain", [0.93, 1.0, 1.04])
def test_exact_lines_at_several_angles(friction: float, gain: float, csv_file) -> None:
    fit = fit_friction(csv_file(settled(friction, (0.5, 1.0, 3.0), gain=gain)))
    assert fit.friction == pytest.approx(friction, rel=1e-9)
    assert fit.gain_ratio == pytest.approx(gain, rel=1e-9)
    assert np.allclose(fit.rows.residual, 0.0, atol=1e-12)


def test_repeating_a_reading_does_not_beat_the_resolution(csv_file) -> None:
    header = "case,cell 1,cell 2\n"
    rows = "1,1.236,1.028\n2,0.858,1.036\n"
    forces = (1.236, 1.028, 0.858, 1.036)
    floor = math.sqrt(sum((0.001 / force) ** 2 for force in forces) / 12.0)
    for repeats in (3, 25):
        path = csv_file(header + rows * repeats)
        fit = fit_friction(path, bend_angle="144 deg", cell_uncertainty="0")
        assert fit.uncertainty.standard_error == pytest.approx(floor / 2.0 / ANGLE, rel=1e-6)


def codes_of_a_weight(noise: float, rows: int, *, load: float = 33.25) -> np.ndarray:
    """Return directions and codes of two coarse cells under a weight (rows, 3).

    `noise` is in codes; there are 15 strokes, whose first rows stick.
    """
    random = np.random.default_rng(3)
    limit = 0.0617 * math.radians(93.2)
    place = -1.0
    readings = []
    for stroke in range(15):
        way = 1 if stroke % 2 == 0 else -1
        for _ in range(rows):
            place = float(np.clip(place + way / 9.0, -1.0, 1.0))
            readings.append((way, load * math.exp(limit * place), load))
    table = np.array(readings)
    table[:, 1:] = np.round(table[:, 1:] + noise * random.standard_normal((len(table), 2)))
    return table


FACTORS = ((1, 0), (2.9143, 4), (math.pi, 9), (1e-3, 3))
"""Newtons of a code, and decimals that are written."""


@pytest.mark.parametrize(
    ("noise", "load"), [(0.0, 1500.0), (0.0, 33.25), (0.07, 33.25), (0.4, 1500.0), (2.0, 33.25)]
)
def test_the_same_codes_in_any_unit_are_the_same_answer(csv_file, noise: float, load: float):
    codes = codes_of_a_weight(noise, 120, load=load)
    fits = []
    for factor, decimals in FACTORS:
        lines = ["time_s,direction,force_motor (N),force_load (N)"]
        for row, (way, *cells) in enumerate(codes):
            name = "pull" if way > 0 else "release"
            written = ",".join(f"{cell * factor:.{decimals}f}" for cell in cells)
            lines.append(f"{row / 50:.2f},{name},{written}")
        zero = f"{0.0667 * factor:.9f} N"
        path = csv_file("\n".join(lines))
        fits.append(fit_friction(path, bend_angle="93.2 deg", cell_uncertainty=zero))
    first = fits[0]
    for fit in fits[1:]:
        assert fit.friction == pytest.approx(first.friction, rel=1e-6)
        interval = fit.uncertainty.interval_95
        assert interval == pytest.approx(first.uncertainty.interval_95, rel=1e-6)
        assert fit.warnings == first.warnings
    assert holds(first, 0.0617)


def test_a_load_cell_on_one_code_is_judged_alike_in_any_unit() -> None:
    coarse = codes_of_a_weight(0.07, 120)
    fine = codes_of_a_weight(4.0, 120, load=33250.0)
    fine[:, 2] = 33250.0
    for factor, _ in FACTORS:
        for codes, is_dead in ((coarse, False), (fine, True)):
            log = {"direction": codes[:, 0], "motor (N)": codes[:, 1] * factor}
            log["load (N)"] = codes[:, 2] * factor
            if is_dead:
                with pytest.raises(InputError, match="same in every row"):
                    fit_friction(log, bend_angle="93.2 deg")
            else:
                assert np.ptp(codes[:, 2]) == 0.0
                assert holds(fit_friction(log, bend_angle="93.2 deg"), 0.0617)


def test_cells_that_show_no_step_are_warned_of() -> None:
    motor = np.repeat(np.tile([37.0, 30.0], 10), 20)
    for factor in (1.0, 2.9143):
        log = {"direction": np.sign(motor - 33.0), "motor": factor * motor}
        log["load"] = np.full(len(motor), 33.0 * factor)
        fit = fit_friction(log, bend_angle="93.2 deg")
        assert mentions(fit.warnings, "do not show how finely")


def test_nominal_weights_do_not_pass_for_a_coarse_cell() -> None:
    parts = []
    for weight in (20.0, 40.0):
        rig = Rig(0.1, weights=(weight, weight), noise=0.01 * weight, gain_mismatch=0.0)
        logs = simulate(rig, 1, first_seed=3)
        parts.append((logs.toward, logs.motor_cell[:, 0], np.full(len(logs.toward), weight)))
    way, motor, load = (np.concatenate(column) for column in zip(*parts, strict=True))
    log = {"direction": way, "motor": np.round(motor, 2), "load": load}
    fit = fit_friction(log, bend_angle="144 deg")
    assert fit.uncertainty.contribution_of(RESOLUTION) < 0.005 * fit.friction
    assert not mentions(fit.warnings, "resolution")


def log_with_a_warming_cell(seed: int, drift: float) -> dict[str, np.ndarray]:
    """Return a log under four weights while the zero of the motor's cell drifts, in N."""
    random = np.random.default_rng(seed)
    limit = 0.1 * math.radians(300.0)
    place = -1.0
    rows = []
    for stroke in range(14):
        way = 1 if stroke % 2 == 0 else -1
        friction = limit * (1.0 + 0.005 * random.standard_normal())
        load = np.linspace(18.0, 42.0, 4)[(stroke // 2) % 4]
        for _ in range(100):
            place = float(np.clip(place + way / 5.0, -1.0, 1.0))
            rows.append((way, load * math.exp(friction * place), load))
    table = np.array(rows)
    table[:, 1:] += 0.06 * random.standard_normal((len(table), 2))
    table[:, 1] += drift * (1.0 - np.exp(-4.0 * np.linspace(0.0, 1.0, len(table))))
    return {
        "direction": table[:, 0],
        "force_motor (N)": table[:, 1],
        "force_load (N)": table[:, 2],
    }


@pytest.mark.parametrize("drift", [0.75, 0.0, -0.75])
def test_a_zero_that_drifts_is_warned_of(drift: float) -> None:
    for seed in range(2):
        fit = fit_friction(log_with_a_warming_cell(seed, drift), bend_angle="300 deg")
        drifts = any(text.startswith("drift: ") for text in fit.warnings)
        assert drifts == bool(drift)
        assert drifts or holds(fit, 0.1)
        check = next(check for check in fit.checks if check.name == "drift")
        assert check.found is bool(drift)


def test_the_interval_allows_for_a_usual_delay_that_the_readings_hardly_show() -> None:
    rig = CASES["delay 20 ms, varying"].rig
    logs = simulate(rig, 25, first_seed=300)
    log = log_of(rig, logs, 14)
    fit = fit_friction(log, rig.bend_angle)
    assert holds(fit, 0.1)
    assert mentions(fit.notes, "late would move μ")
    assert not holds(fit_friction(log, rig.bend_angle, cell_uncertainty="0 ms"), 0.1)


def test_readings_of_one_stroke_count_once(csv_file) -> None:
    header = "stroke,case,cell 1,cell 2"
    rows = []
    for stroke, force in enumerate((1.23, 0.87, 1.25, 0.86, 1.24, 0.87)):
        case = 1 + stroke % 2
        rows.append(f"{stroke},{case},{force},1.03")
    repeated = [row for row in rows for _ in range(10)]
    fit = fit_friction(csv_file("\n".join([header, *repeated])), bend_angle="144 deg")
    once = fit_friction(csv_file("\n".join([header, *rows])), bend_angle="144 deg")
    assert fit.strokes == once.strokes == 6
    assert fit.friction == pytest.approx(once.friction, rel=1e-12)
    assert fit.uncertainty.contribution_of(SCATTER) == pytest.approx(
        once.uncertainty.contribution_of(SCATTER), rel=0.02
    )


@pytest.mark.parametrize("strokes", [2, 3, 8])
def test_the_interval_of_settled_strokes_is_that_of_the_t_test_of_two_directions(
    csv_file, strokes
) -> None:
    direction = np.tile([1.0, -1.0], strokes)
    noise = 0.01 * np.random.default_rng(1).standard_normal(direction.size)
    ratio = np.exp(0.2 * direction + noise)
    cases = np.where(direction > 0, 1, 2)
    lines = ["case,cell 1,cell 2"]
    lines += [f"{case},{value:.15g},1.000001" for case, value in zip(cases, ratio, strict=True)]
    path = csv_file("\n".join(lines) + "\n")
    fit = fit_friction(path, bend_angle="144 deg", cell_uncertainty="0")
    test = ttest_ind(np.log(ratio[direction > 0]), np.log(ratio[direction < 0]))
    low, high = test.confidence_interval(0.95)
    expected = (float(low) / (2.0 * ANGLE), float(high) / (2.0 * ANGLE))
    assert fit.uncertainty.degrees_of_freedom == pytest.approx(2 * strokes - 2, rel=1e-6)
    assert fit.uncertainty.interval_95 == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("named", [True, False], ids=["named", "by the forces"])
@pytest.mark.parametrize("rows", [1, 2, 3], ids="{} a stroke".format)
@pytest.mark.parametrize("noise", [0.003, 0.04])
def test_settled_readings_are_all_used_whatever_they_scatter(noise, rows, named) -> None:
    held = 0
    for seed, strokes in enumerate((2, 3, 4, 6, 10, 40)):
        rng = np.random.default_rng(seed)
        direction = np.repeat(np.tile([1.0, -1.0], strokes), rows)
        load = 1.0 + 0.05 * rng.random(direction.size)
        motor = load * np.exp(0.2 * direction + noise * rng.standard_normal(direction.size))
        columns = {"cell 1": motor, "cell 2": load}
        if named:
            columns["case"] = np.where(direction > 0, "up", "down")
        fit = fit_friction(columns, bend_angle="144 deg")
        assert fit.rows.used.all()
        held += holds(fit, 0.2 / ANGLE)
    assert held >= 5


@pytest.mark.parametrize("named", [True, False], ids=["named", "by the forces"])
def test_angles_and_directions_in_random_order(named) -> None:
    held = 0
    for seed in range(8):
        rng = np.random.default_rng(seed)
        angles = np.radians([90.0, 180.0, 270.0, 360.0] * 3)
        angle = np.tile(angles, 2)
        direction = np.repeat([1.0, -1.0], len(angles))
        load = 1.0 + 0.5 * rng.random(angle.size)
        order = rng.permutation(angle.size)
        motor = load * np.exp(direction * 0.08 * angle + 0.01 * rng.standard_normal(angle.size))
        columns = {"bend_angle_rad": angle, "motor": motor, "load": load}
        if named:
            columns["direction"] = np.where(direction > 0, "up", "down")
        fit = fit_friction({name: column[order] for name, column in columns.items()})
        assert np.count_nonzero(fit.rows.used) >= angle.size - 2
        held += holds(fit, 0.08)
    assert held >= 7


def test_one_direction_takes_the_gain_as_one_and_says_so(csv_file) -> None:
    path = csv_file("cell 1,cell 2\n1.236,1.028\n1.236,1.027\n1.236,1.028\n")
    fit = fit_friction(path, bend_angle="144 deg")
    assert f"{fit.friction:.4f}" == "0.0734"
    assert fit.gain_ratio == 1.0
    assert mentions(fit.notes, "one direction only")


def test_offsets_are_found_where_the_forces_span_enough(csv_file) -> None:
    text = settled(0.1, (2.5,), gain=1.02, offsets=(0.05, -0.03), loads=(0.5, 1.0, 2.0, 3.0))
    fit = fit_friction(csv_file(text))
    assert fit.friction == pytest.approx(0.1, rel=1e-5)
    assert [check.value for check in fit.checks[:2]] == pytest.approx([0.05, -0.03], abs=1e-4)
    assert all(check.found for check in fit.checks[:2])
    assert fit.gain_ratio == pytest.approx(1.02, rel=1e-4)
    assert abs(fit.plain.friction - 0.1) > 1e-3


@pytest.mark.parametrize("outside", [0.0, 0.06])
def test_friction_outside_of_the_bend_shows_at_several_bends(csv_file, outside: float) -> None:
    """Friction at the ends of the sheath is the same at every bend, also where the bend is none."""
    rng = np.random.default_rng(4)
    lines = ["bend_angle_rad,direction,motor,load"]
    for angle in (0.8, 1.6, 2.4, 3.2) * 3:
        limit = 0.1 * angle + outside
        for direction, name in ((1, "up"), (-1, "down")):
            motor = 20.0 * math.exp(direction * limit + 0.002 * rng.standard_normal())
            lines.append(f"{angle},{name},{motor:.5f},20.0")
    fit = fit_friction(csv_file("\n".join(lines)))
    assert holds(fit, 0.1)
    assert fit.friction == pytest.approx(0.1, rel=0.02)
    check = next(check for check in fit.checks if check.name == "entry")
    assert check.found == (outside > 0.0)
    assert mentions(fit.warnings, "friction outside the bend") == (outside > 0.0)
    if outside:
        assert abs(check.value - outside) < 3.0 * check.standard_error < 0.01


def test_offsets_in_a_log_with_a_spring_at_the_load() -> None:
    rig = Rig(0.1, load_spring=10.0, offsets=(0.06, -0.04))
    for fit in fits_of(rig, 2):
        assert holds(fit, 0.1)
        assert fit.friction == pytest.approx(0.1, rel=0.03)


def test_a_bad_reading_among_many_is_left_out() -> None:
    rng = np.random.default_rng(5)
    pulled = 1.2 * np.exp(0.002 * rng.standard_normal(16))
    motor = np.concatenate([pulled, 1.0 / pulled])
    motor[3] = 1.35
    columns = {
        "time": np.arange(32.0),
        "case": np.repeat([1, 2], 16),
        "cell 1": motor,
        "cell 2": np.ones(32),
    }
    fit = fit_friction(columns, bend_angle="2.5 rad")
    assert fit.friction == pytest.approx(math.log(1.2) / 2.5, rel=2e-3)
    assert not fit.rows.used[3]


@pytest.mark.parametrize("friction", [0.05, 0.1, 0.2])
def test_a_short_history_without_noise_is_exact(friction: float) -> None:
    """The log is that of another engine's rope over a drum: 61 rows, one reversal, 13 stick."""
    rig = Rig(
        friction,
        strokes=2,
        rows_at_rest=0,
        rows_per_stroke=31,
        sticking=(0.42, 0.42),
        friction_scatter=0.0,
        gain_scatter=0.0,
        gain_mismatch=0.0,
        noise=0.0,
        resolution=0.0,
    )
    logs = simulate(rig, 2)
    for seed in range(2):
        first = int(np.flatnonzero(logs.slipping[:, seed])[0])
        log = readings(logs.motor_cell[first:, seed], logs.load_cell[first:, seed])
        fit = fit_friction(log, rig.bend_angle)
        assert fit.friction == pytest.approx(friction, rel=1e-3)
        assert fit.plain.friction == pytest.approx(friction, rel=1e-3)
        assert fit.gain_ratio == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize(("seed", "rows"), [(1, 200), (2, 60)])
def test_more_of_the_same_is_no_evidence_of_an_effect(seed: int, rows: int) -> None:
    rig = Rig(
        0.1,
        strokes=40,
        rows_per_stroke=rows,
        rows_at_rest=8,
        noise=0.002,
        load_spring=0.3,
        pieces=12,
    )
    log = simulate(rig, seed)
    motor = log.motor_cell[:, 0]
    load = log.load_cell[:, 0]
    for repeats in (1, 10):
        columns = {"motor": np.tile(motor, repeats), "load": np.tile(load, repeats)}
        fit = fit_friction(columns, "144 deg")
        assert fit.friction == pytest.approx(rig.friction, rel=0.01)
        assert not fit.warnings
