"""A motion in time beside a study: how it is smoothed, what comes of it, and every way it can be wrong."""

import json

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.errors import TendonError

STUDY = {"tendon": {"pretension": "150 N"}, "spool": {"ratio": 0.6}, "load": {"mass": [0.0, 1.0]}}


def rows(time, angle):
    return (
        "time (s),angle (deg)\n"
        + "\n".join(f"{t},{a}" for t, a in zip(time, angle, strict=True))
        + "\n"
    )


TIME = np.round(np.arange(0.0, 4.0, 0.01), 9)
SWING = 50.0 - 30.0 * np.cos(np.pi * TIME)


@pytest.fixture
def file(tmp_path):
    """Writes a study over a trajectory's text, and gives its path."""

    def written(text, **motion):
        (tmp_path / "reach.csv").write_text(text, encoding="utf-8")
        study = tmp_path / "study.json.yaml"
        study.write_text(
            json.dumps({**STUDY, "motion": {"trajectory": "reach.csv", **motion}}), encoding="utf-8"
        )
        return study

    return written


def test_smoothing_leaves_slow_motion_in_place_and_time(file):
    trajectory = tendon.load_study(file(rows(TIME, SWING))).trajectory
    inner = slice(50, -50)
    turn = np.pi * trajectory.time
    assert (
        np.degrees(np.abs(trajectory.angle - np.radians(50.0 - 30.0 * np.cos(turn)))[inner].max())
        < 0.01
    )
    speed, acceleration = (
        np.radians(30.0) * np.pi * np.sin(turn),
        np.radians(30.0) * np.pi**2 * np.cos(turn),
    )
    np.testing.assert_allclose(trajectory.speed[inner], speed[inner], atol=2e-3)
    np.testing.assert_allclose(trajectory.acceleration[inner], acceleration[inner], atol=2e-2)


def test_a_lower_cutoff_takes_more_noise(file):
    noisy = SWING + np.random.default_rng(1).normal(0.0, 0.5, len(SWING))
    peaks = [
        np.abs(
            tendon.load_study(
                file(rows(TIME, noisy), cutoff=f"{cutoff} Hz")
            ).trajectory.acceleration[20:-20]
        )
        for cutoff in (3, 6, 12)
    ]
    assert peaks[0].max() < peaks[1].max() < peaks[2].max()


def test_uneven_samples_in_other_units_are_the_same_motion(file):
    some = np.sort(np.random.default_rng(2).choice(len(TIME), 300, replace=False))
    some[[0, -1]] = 0, len(TIME) - 1
    even = tendon.load_study(file(rows(TIME, SWING))).trajectory
    text = "time (ms);angle (rad)\n" + "\n".join(
        f"{1000 * TIME[at]:.3f};{np.radians(SWING[at]):.9f}".replace(".", ",") for at in some
    )
    uneven = tendon.load_study(file("# a goniometer\n" + text)).trajectory
    assert np.interp(uneven.time, even.time, even.angle) == pytest.approx(
        uneven.angle, abs=np.radians(0.15)
    )


def test_the_study_reads_back_from_its_record_and_has_what_was_made_of_the_file(file):
    study = tendon.load_study(file(rows(TIME, SWING), inertia="0.08 kg m2"))
    again = tendon.study(study.document())
    assert again.hash == study.hash
    np.testing.assert_array_equal(again.angles, study.angles)
    assert "low-pass of 6 Hz" in study.notes[0]
    assert "trajectory of 3.99 s from 19.9" in study.text


def test_a_sweep_along_it_has_a_row_per_sample_and_the_motor_over_time(file):
    run = tendon.sweep(file(rows(TIME, SWING), inertia="0.08 kg m2"))
    states, designs = run.states, run.designs
    assert list(states.columns[7:11]) == ["time", "direction", "elbow_angle", "elbow_speed"]
    assert len(states) == 2 * len(TIME)
    first = states[states["design"] == 0]
    assert first["direction"].iloc[:99].eq("flexion").all()
    assert first["direction"].iloc[110:190].eq("extension").all()
    torque = first["motor_torque"].to_numpy()
    assert designs["rms_motor_torque"][0] == pytest.approx(np.sqrt(np.mean(torque**2)), rel=5e-3)
    assert designs["peak_motor_torque"].abs()[0] == np.abs(torque).max()
    assert designs["max_backlash"].isna().all()
    assert (designs["braking_work"] >= 0.0).all()
    assert run.to_xarray()["motor_torque"].dims == ("load_mass", "time")


def test_a_design_keeps_its_limits_at_every_sample(file):
    study = tendon.load_study(file(rows(TIME, SWING), inertia="0.08 kg m2"))
    study = study.vary(
        **{"limits.peak_motor_power": "30 W", "limits.peak_motor_speed": "600 deg/s"}
    )
    answer = tendon.design(study)
    assert answer.feasible
    assert 0.0 < answer.record["between_samples"]["estimate"] < 0.1
    assert "an end may be off by" in answer.text
    at = float(answer.choices["pretension"].iloc[0])
    kept = tendon.sweep(study.vary(**{"tendon.pretension": at}))
    assert kept.designs["feasible"].all()
    assert kept.designs["pretension_from"].max() == pytest.approx(
        answer.choices["pretension_from"].iloc[0]
    )


def test_a_state_page_names_inertia(file):
    text = tendon.state(file(rows(TIME, SWING), inertia="0.5 kg m2")).text
    assert "joint, task and inertia" in text
    assert "first of the trajectory's 400 samples" in text


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (
            rows(np.insert(TIME, 20, TIME[19]), np.insert(SWING, 20, 1.0)),
            "line 22",
            "same time twice",
        ),
        (rows(np.insert(TIME, 20, 0.105), np.insert(SWING, 20, 1.0)), "line 22", "times that go"),
        (rows(TIME[::-1], SWING), "line 3", "times that go back"),
        (rows(TIME[:5], SWING[:5]), "line 6", "12 at least"),
        (rows(TIME, np.where(TIME == 0.0, np.nan, SWING)), "line 2", "expected a number"),
    ],
    ids=["time twice", "times that go back", "falling times", "too few", "not finite"],
)
def test_a_faulty_file_is_refused_with_its_line(file, text, line, words):
    with pytest.raises(TendonError) as error:
        tendon.load_study(file(text))
    assert error.value.exit == 3
    assert words in str(error.value)
    assert line in error.value.where


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"motion": {"trajectory": "reach.csv", "speed": "60 deg/s"}}, "motion.speed"),
        ({"motion": {"trajectory": "reach.csv", "elbow_angle": "10 deg"}}, "motion.elbow_angle"),
        ({"motion": {"trajectory": "reach.csv", "cutoff": "60 Hz"}}, "less than 50 Hz"),
        ({"motion": {"inertia": "0.08 kg m2"}}, "motion.inertia"),
        (
            {"motion": {"trajectory": "reach.csv"}, "limits": {"max_backlash": "5 deg"}},
            "limits.max_backlash",
        ),
        (
            {
                "motion": {"trajectory": "reach.csv"},
                "joint": {
                    "excursion": {
                        "angle": ["0 deg", "20 deg", "70 deg"],
                        "flexor": [0.0, 0.02, 0.04],
                        "extensor": [0.0, 0.02, 0.04],
                    }
                },
            },
            "motion.trajectory asks for",
        ),
    ],
)
def test_a_trajectory_that_does_not_fit_its_study_is_refused(tmp_path, changes, words):
    (tmp_path / "reach.csv").write_text(rows(TIME, SWING), encoding="utf-8")
    study = tmp_path / "study.yaml"
    study.write_text(json.dumps(changes), encoding="utf-8")
    with pytest.raises(TendonError) as error:
        tendon.load_study(study)
    assert words in "\n".join([str(error.value), *map(str, getattr(error.value, "faults", ()))])
    assert error.value.exit in (2, 3)


def test_a_gap_is_bridged_with_a_warning(file):
    kept = (TIME < 1.0) | (TIME > 1.5)
    study = tendon.load_study(file(rows(TIME[kept], SWING[kept])))
    assert any("no samples from 0.99 to 1.51 s" in warning for warning in study.warnings)
