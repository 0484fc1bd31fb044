"""The torque of a task over time: one reader, one clock, and one message for each bad file."""

import json

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.errors import TendonError
from tendon_cli.studies.angle_curves import CurveTable
from tendon_cli.studies.json_schema import schema_text
from tendon_cli.studies.measured_motion import task_at_samples

from .csv_text import csv_text

TIME = np.round(np.arange(0.0, 4.0, 0.01), 9)  # s
ANGLE = 50.0 - 30.0 * np.cos(np.pi * TIME)  # deg
TASK = 1.0 - 12.0 * np.sin(np.pi * TIME)  # N m
MOTION = csv_text("time (s),angle (deg)", TIME, ANGLE)
WITH_TASK = csv_text("time (s),angle (deg),torque (N m)", TIME, ANGLE, TASK)
SIGN = "positive torque is what the flexor must give"


@pytest.fixture
def load(tmp_path):
    """Return a function that loads a study beside some files."""

    def load_study(content, **files):
        for name, text in files.items():
            (tmp_path / f"{name}.csv").write_text(text, encoding="utf-8")
        (tmp_path / "study.yaml").write_text(json.dumps(content), encoding="utf-8")
        return tendon.load_study(tmp_path / "study.yaml")

    return load_study


def content(torque=None, motion="gait.csv", **load):
    """Return a study of a motion in time with a torque of its load."""
    stated = {} if torque is None else {"torque": torque}
    return {"motion": {"trajectory": motion}, "load": {**stated, **load}}


def test_a_column_a_file_and_lists_are_the_same_study(load):
    lists = {"time": TIME.tolist(), "torque": TASK.tolist()}
    task = csv_text("time (s),torque (N m)", TIME, TASK)
    in_other_units = csv_text("torque_Nmm;time (ms)", 1000.0 * TASK, 1000.0 * TIME)
    studies = [
        load(content(), gait=WITH_TASK),
        load(content("gait.csv"), gait=WITH_TASK),
        load(content("task.csv"), gait=MOTION, task=task),
        load(content(lists), gait=MOTION),
        load(content("task.csv"), gait=MOTION, task=in_other_units.replace(",", ";")),
    ]
    first = studies[0]
    assert [study.hash for study in studies[:4]] == [first.hash] * 4
    np.testing.assert_allclose(studies[4].load.torque.columns["torque"], TASK, atol=1e-12)
    assert tendon.study(first.document()).hash == first.hash
    assert SIGN in first.notes[0]
    assert SIGN in studies[2].notes[1]


def test_a_file_with_angles_and_times_is_read_over_what_the_motion_is_in(load):
    both = csv_text("time (s),angle (deg),torque (N m)", TIME[:100], ANGLE[:100], TASK[:100])
    angle = {"motion": {"elbow_angle": ["30 deg", "60 deg"]}, "load": {"torque": "task.csv"}}
    over_angle = load(angle, task=both)
    assert not over_angle.load.torque.is_in_time
    assert "task.csv: columns not read: time (s)" in over_angle.warnings
    longer = csv_text("time (s),angle (deg),torque (N m)", TIME, ANGLE, TASK)
    over_time = load(content("task.csv"), gait=MOTION, task=longer)
    assert over_time.load.torque.is_in_time
    assert "task.csv: columns not read: angle (deg)" in over_time.warnings


def test_a_torque_over_the_angle_stays_one_along_a_motion_in_time(load):
    envelope = {"angle": ["0 deg", "50 deg", "90 deg"], "torque": [1.0, 2.0, 4.0]}
    study = load(content(envelope), gait=MOTION)
    assert not study.load.torque.is_in_time


ROWS = csv_text("time (s),torque (N m)", TIME, TASK)


@pytest.mark.parametrize(
    ("stated", "files", "words"),
    [
        (content("task.csv"), {"task": csv_text("time,torque (N m)", TIME, TASK)}, "no unit"),
        (content("task.csv"), {"task": csv_text("time (s),force (N)", TIME, TASK)}, SIGN),
        (content("task.csv"), {"task": csv_text("cycle (1),torque (N m)", TIME, TASK)}, SIGN),
        (
            content("task.csv"),
            {"task": csv_text("time (s),torque (N m)", TIME[:300], TASK[:300])},
            "reaches from 0 to 2.99 s, but motion.trajectory from 0 to 3.99 s",
        ),
        (
            content("task.csv"),
            {"task": csv_text("time (s),torque (N m)", TIME + 1.0, TASK)},
            "on the same clock",
        ),
        (
            content("task.csv"),
            {"task": csv_text("time (s),torque (N m)", TIME[::-1], TASK)},
            "times that go back",
        ),
        (content("task.csv"), {"task": ROWS, "gait": WITH_TASK}, "leave one of them out"),
        (content({"time": [0, 5], "torque": [0, 9000]}), {}, "far from any arm"),
        (content({"time": [0, 3], "torque": [0, 9]}), {}, "on the same clock"),
        (content({"time": [0, 5], "angle": [0, 9]}), {}, SIGN),
        ({"load": {"torque": "task.csv"}}, {"task": ROWS}, "no motion in time"),
        ({"load": {"torque": {"time": [0, 5], "torque": [0, 9]}}}, {}, "no motion in time"),
        (
            {"motion": {"trajectory": {"time": [0, 1], "angle": ["0 deg", "9 deg"]}}}
            | {"load": {"torque": {"time": [0, 5], "torque": [0, 9]}}},
            {},
            "12 at least",
        ),
    ],
)
def test_each_bad_task_has_one_message(load, stated, files, words):
    with pytest.raises(TendonError) as caught:
        load(stated, **{"gait": MOTION, **files})
    faults = getattr(caught.value, "faults", ())
    told = [str(fault) for fault in faults] or [f"{caught.value.message} {caught.value.hint}"]
    assert len(told) == 1
    assert words in told[0]
    assert caught.value.exit in (2, 3)


def test_the_sign_is_said_where_the_torque_is_described():
    properties = schema_text()
    assert properties.count(SIGN) == 2


@pytest.mark.parametrize("step", [0.001, 0.01, 0.04])
def test_samples_of_a_task_do_not_depend_on_how_often_it_is_read(step):
    times = np.arange(0.0, 4.0 + step, step)  # s
    slow = 5.0 * np.sin(2.0 * np.pi * 0.5 * times)  # N m
    hum = 3.0 * np.sin(2.0 * np.pi * 99.7 * times) if step < 0.01 else 0.0  # of a force plate
    task = CurveTable({"time": tuple(times), "torque": tuple(slow + hum)})
    samples, rate = task_at_samples(task, TIME, 6.0)
    truth = 5.0 * np.sin(2.0 * np.pi * 0.5 * TIME)
    slope = 5.0 * np.pi * np.cos(np.pi * TIME)
    inner = slice(40, -40)
    np.testing.assert_allclose(samples[inner], truth[inner], atol=0.02)
    np.testing.assert_allclose(rate[inner], slope[inner], atol=0.1)
