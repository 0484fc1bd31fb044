"""A motion in time beside a study: its smoothing, its results, and every fault of its file."""

import json

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.errors import TendonError

from .csv_text import csv_text

STUDY = {"tendon": {"pretension": "150 N"}, "spool": {"ratio": 0.6}, "load": {"mass": [0.0, 1.0]}}


TIME = np.round(np.arange(0.0, 4.0, 0.01), 9)  # s
SWING = 50.0 - 30.0 * np.cos(np.pi * TIME)  # deg


def rows(time, angle):
    """Return a trajectory as CSV."""
    return csv_text("time (s),angle (deg)", time, angle)


@pytest.fixture
def file(tmp_path):
    """Return a function that writes a study of a trajectory and returns its path."""

    def write_study(text, **motion):
        (tmp_path / "reach.csv").write_text(text, encoding="utf-8")
        content = {**STUDY, "motion": {"trajectory": "reach.csv", **motion}}
        path = tmp_path / "study.json.yaml"
        path.write_text(json.dumps(content), encoding="utf-8")
        return path

    return write_study


def test_smoothing_leaves_slow_motion_in_place_and_time(file):
    trajectory = tendon.study(file(rows(TIME, SWING))).trajectory
    inner = slice(50, -50)
    turn = np.pi * trajectory.time
    angle = np.radians(50.0 - 30.0 * np.cos(turn))
    speed = np.radians(30.0) * np.pi * np.sin(turn)
    acceleration = np.radians(30.0) * np.pi**2 * np.cos(turn)
    error = np.abs(trajectory.angle - angle)[inner]
    assert np.degrees(error.max()) < 0.01
    np.testing.assert_allclose(trajectory.speed[inner], speed[inner], atol=2e-3)
    np.testing.assert_allclose(trajectory.acceleration[inner], acceleration[inner], atol=2e-2)


def test_a_lower_cutoff_takes_more_noise(file):
    noisy = SWING + np.random.default_rng(1).normal(0.0, 0.5, len(SWING))
    text = rows(TIME, noisy)

    def peak_acceleration(cutoff):
        trajectory = tendon.study(file(text, cutoff=cutoff)).trajectory
        return np.abs(trajectory.acceleration[20:-20]).max()

    assert peak_acceleration("3 Hz") < peak_acceleration("6 Hz") < peak_acceleration("12 Hz")


def test_samples_at_the_ends_are_flagged_for_two_periods_of_the_cutoff(file):
    trajectory = tendon.study(file(rows(TIME, SWING), cutoff="5 Hz")).trajectory
    counted = trajectory.time[~trajectory.is_at_end]
    assert counted[0] == pytest.approx(0.4)
    assert counted[-1] == pytest.approx(TIME[-1] - 0.4)
    assert trajectory.weights.sum() == pytest.approx(TIME[-1] - 0.8)


def test_a_record_shorter_than_six_periods_of_the_cutoff_is_refused(file):
    enough = TIME <= 2.0
    assert tendon.study(file(rows(TIME[enough], SWING[enough]), cutoff="3 Hz"))
    path = file(rows(TIME[enough], SWING[enough]), cutoff="2.9 Hz")
    with pytest.raises(TendonError, match=r"lasts 2 s, expected at least 2\.069 s") as caught:
        tendon.study(path)
    assert caught.value.exit == 3
    assert "raise motion.cutoff to 3 Hz at least" in str(caught.value.hint)


def test_the_record_says_what_the_cutoff_decides(file):
    of_clean = tendon.sweep(file(rows(TIME, SWING), inertia="0.08 kg m2"))
    clean = of_clean.record["checks"]["cutoff"]
    assert clean["cutoff"] == 6.0
    assert clean["lower"] == 4.2
    assert not clean["decides"]
    assert clean["peak_motor_power"][1] == pytest.approx(clean["peak_motor_power"][0], rel=0.02)
    noisy = SWING + np.random.default_rng(1).normal(0.0, 0.5, len(SWING))
    of_noisy = tendon.sweep(file(rows(TIME, noisy), inertia="0.08 kg m2"))
    check = of_noisy.record["checks"]["cutoff"]
    assert check["decides"]
    assert "note" not in dict(of_clean.facts())
    assert "cutoff" in dict(of_noisy.facts())["note"]
    assert check["peak_motor_power"][0] > 1.1 * clean["peak_motor_power"][0]


def test_uneven_samples_in_other_units_are_the_same_motion(file):
    samples = np.sort(np.random.default_rng(2).choice(len(TIME), 300, replace=False))
    samples[0] = 0
    samples[-1] = len(TIME) - 1
    times = 1000 * TIME[samples]  # ms
    angles = np.radians(SWING[samples])
    lines = [f"{time:.3f};{angle:.9f}" for time, angle in zip(times, angles, strict=True)]
    table = "\n".join(lines).replace(".", ",")
    text = "# a goniometer\ntime (ms);angle (rad)\n" + table
    even = tendon.study(file(rows(TIME, SWING))).trajectory
    uneven = tendon.study(file(text)).trajectory
    angle = np.interp(uneven.time, even.time, even.angle)
    assert angle == pytest.approx(uneven.angle, abs=np.radians(0.15))


def test_the_study_reads_back_from_its_record_and_has_what_was_made_of_the_file(file):
    study = tendon.study(file(rows(TIME, SWING), inertia="0.08 kg m2"))
    again = tendon.study(study.document())
    assert again.hash == study.hash
    np.testing.assert_array_equal(again.angles, study.angles)
    assert "low-pass of 6 Hz" in study.notes[0]
    assert "trajectory of 3.99 s from 19.9" in study.text


def test_a_sweep_along_it_has_a_row_per_sample_and_the_motor_over_time(file):
    run = tendon.sweep(file(rows(TIME, SWING), inertia="0.08 kg m2"))
    states = run.states
    designs = run.designs
    assert list(states.columns[7:11]) == ["time", "direction", "elbow_angle", "elbow_speed"]
    assert len(states) == 2 * len(TIME)
    first = states[states["design"] == 0]
    assert first["direction"].iloc[:99].eq("flexion").all()
    assert first["direction"].iloc[110:190].eq("extension").all()
    counted = first[~first["at_record_end"]]
    torque = counted["motor_torque"].to_numpy()
    other = counted["motor_torque_other"].to_numpy()
    assert designs["rms_motor_torque"][0] == pytest.approx(np.sqrt(np.mean(torque**2)), rel=5e-3)
    assert designs["peak_motor_torque"].abs()[0] == np.nanmax(np.abs([torque, other]))
    assert designs["turning_fraction"][0] == pytest.approx(counted["turning"].mean())
    assert (np.isnan(other) == ~counted["turning"]).all()
    slides_back = counted["friction_direction"] < 0
    is_opposite = (counted["elbow_speed"] < 0) != slides_back
    assert designs["opposite_fraction"][0] == pytest.approx(is_opposite.mean())
    assert designs["max_backlash"].isna().all()
    assert (designs["braking_work"] >= 0.0).all()
    assert run.to_xarray()["motor_torque"].dims == ("load_mass", "time")


def test_a_design_keeps_its_limits_at_every_sample(file):
    limits = {"limits.peak_motor_power": "30 W", "limits.peak_motor_speed": "600 deg/s"}
    few = rows(TIME[::4], SWING[::4])
    study = tendon.study(file(few, inertia="0.08 kg m2")).vary(**limits)
    answer = tendon.design(study)
    assert answer.feasible
    assert 0.0 < answer.record["between_samples"]["estimate"] < 0.1
    assert "an end may be off by" in " ".join(answer.text.split())
    choice = answer.choices.iloc[0]
    run = tendon.sweep(study.vary(**{"tendon.pretension": float(choice["pretension"])}))
    assert run.designs["feasible"].all()
    assert run.designs["pretension_from"].max() == pytest.approx(choice["pretension_from"])


def test_a_state_page_names_inertia(file):
    text = tendon.state(file(rows(TIME, SWING), inertia="0.5 kg m2")).text
    assert "the joint, the task and inertia" in text
    assert "the first counted sample of the trajectory's 400" in text
    assert "0.34 s, flexion" in text
    assert "Over the motion from 0.34 s to 3.65 s" in text


LONGER_SWING = np.insert(SWING, 20, 1.0)
SWING_WITHOUT_START = np.where(TIME == 0.0, np.nan, SWING)


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (rows(np.insert(TIME, 20, TIME[19]), LONGER_SWING), "line 22", "same time twice"),
        (rows(np.insert(TIME, 20, 0.105), LONGER_SWING), "line 22", "times that go"),
        (rows(TIME[::-1], SWING), "line 3", "times that go back"),
        (rows(TIME[:5], SWING[:5]), "line 6", "12 at least"),
        (rows(TIME, SWING_WITHOUT_START), "line 2", "expected a number"),
    ],
    ids=["time twice", "times that go back", "falling times", "too few", "not finite"],
)
def test_a_faulty_file_is_refused_with_its_line(file, text, line, words):
    path = file(text)
    with pytest.raises(TendonError) as caught:
        tendon.study(path)
    assert caught.value.exit == 3
    assert words in str(caught.value)
    assert line in caught.value.where


SHORT_EXCURSION = {
    "angle": ["0 deg", "20 deg", "70 deg"],
    "flexor": [0.0, 0.02, 0.04],
    "extensor": [0.0, 0.02, 0.04],
}


def test_an_inertia_without_a_trajectory_is_for_logs_and_said():
    study = tendon.study({"motion": {"inertia": "0.08 kg m2"}})
    assert any("motion.inertia" in warning for warning in study.warnings)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ({"motion": {"trajectory": "reach.csv", "speed": "60 deg/s"}}, "motion.speed"),
        ({"motion": {"trajectory": "reach.csv", "elbow_angle": "10 deg"}}, "motion.elbow_angle"),
        ({"motion": {"trajectory": "reach.csv", "cutoff": "60 Hz"}}, "less than 50 Hz"),
        (
            {"motion": {"trajectory": "reach.csv"}, "design": {"minimise": "max_backlash"}},
            "which a trajectory does not have",
        ),
        (
            {"motion": {"trajectory": "reach.csv"}, "joint": {"excursion": SHORT_EXCURSION}},
            "motion.trajectory needs",
        ),
    ],
)
def test_a_trajectory_that_does_not_fit_its_study_is_refused(tmp_path, content, words):
    (tmp_path / "reach.csv").write_text(rows(TIME, SWING), encoding="utf-8")
    path = tmp_path / "study.yaml"
    path.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(TendonError) as caught:
        tendon.study(path)
    faults = getattr(caught.value, "faults", ())
    assert words in "\n".join([str(caught.value), *map(str, faults)])
    assert caught.value.exit in (2, 3)


def test_a_gap_is_bridged_with_a_warning(file):
    is_sampled = (TIME < 1.0) | (TIME > 1.5)
    study = tendon.study(file(rows(TIME[is_sampled], SWING[is_sampled])))
    assert any("no samples from 0.99 to 1.51 s" in warning for warning in study.warnings)
