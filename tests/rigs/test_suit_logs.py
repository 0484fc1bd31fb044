"""Logs of suits: rows as they should be, truths that are true, faults that show."""

import dataclasses
import io

import numpy as np
import pandas as pd
import pytest

from verification.rigs.elastic_links import Tendon
from verification.rigs.suit_logs import (
    CYCLE,
    CYCLES,
    FAULTS,
    LOADS,
    RATE,
    Sensors,
    drive_sessions,
    frame_of,
    make_log,
    make_logs,
    partial,
    random_session,
    random_suits,
    session_of,
    with_backlash,
    write_log,
)

ROWS = round(CYCLE * CYCLES * RATE)


SHORT = 450
"""Rows of logs that are cut short, for speed: a cycle and the start of another."""


def cut(session):
    """Return a session whose logs end early."""

    def first(arrays):
        return tuple(array[:SHORT] for array in arrays)

    return dataclasses.replace(
        session,
        angles=first(session.angles),
        task=first(session.task),
        slip=first(session.slip),
    )


def frames(log):
    return [pd.read_csv(io.StringIO(text)) for text in log.texts]


@pytest.fixture(scope="module")
def driven():
    """Return sessions of one suit with some faults, and what the rig did in each."""
    names = ["none", "slack", "pretension falls", "high friction", "wearer helps"]
    sessions = [cut(session_of(5, name)) for name in names]
    histories = drive_sessions(sessions, nodes=2)
    return {
        name: (session, logs)
        for name, session, logs in zip(names, sessions, histories, strict=True)
    }


@pytest.fixture(scope="module")
def clean(driven):
    session, logs = driven["none"]
    return write_log(session, logs, 5, "none", FAULTS["none"])


def test_a_session_has_a_log_per_load(clean):
    assert [frame["load_mass (kg)"].unique().tolist() for frame in frames(clean)] == [
        [load] for load in LOADS
    ]
    assert [len(frame) for frame in frames(clean)] == [SHORT] * 3
    assert [len(angle) for angle in session_of(5, "none").angles] == [ROWS] * 3
    assert clean.truth["expects"] == "right"


def test_a_seed_gives_the_same_log_alone_or_among_others():
    alone = make_log(5, "one stroke", nodes=2)
    _, among = make_logs([(6, "one stroke"), (5, "one stroke")], nodes=2)
    assert alone.truth == among.truth
    assert alone.study == among.study
    assert frames(alone)[0].to_numpy() == pytest.approx(frames(among)[0].to_numpy(), abs=1e-4)


def test_what_a_study_leaves_open_is_in_the_truth(clean):
    low, high = clean.study["sheath"]["friction"].split(" to ")
    assert float(low) < clean.truth["numbers"]["sheath.friction"] < float(high)
    assert " to " in clean.study["tendon"]["pretension"]
    assert " to " not in clean.study["arm"]["b1"]


def test_a_heavier_load_asks_for_more_torque(clean):
    means = [frame["motor_torque (N m)"].mean() for frame in frames(clean)]
    assert means[0] < means[1] < means[2]


def test_errors_of_sensors_are_what_the_truth_says(driven):
    session, logs = driven["none"]
    rng = np.random.default_rng(0)

    def read(**errors):
        sensed = dataclasses.replace(session, noise=0.0, sensors=Sensors(**errors))
        frame = frame_of(sensed, 0, logs[0], rng)
        return {name: frame[name].to_numpy() for name in frame}

    exact = read()
    off = read(torque_zero=0.2, torque_gain=1.1, joint_zero=0.05, joint_gain=0.9)
    torque = 1.1 * exact["motor_torque (N m)"] + 0.2
    angle = 0.9 * exact["elbow_angle (rad)"] + 0.05
    assert off["motor_torque (N m)"] == pytest.approx(torque)
    assert off["elbow_angle (rad)"] == pytest.approx(angle)
    late = read(joint_delay=0.1)
    shift = round(0.1 * RATE)
    moved = exact["elbow_angle (rad)"][:-shift]
    assert late["elbow_angle (rad)"][shift:] == pytest.approx(moved)


def test_backlash_is_a_free_way_at_turns():
    angle = np.sin(np.linspace(0.0, 12.0, 400))
    motor = with_backlash(angle, 0.02)
    rises = np.gradient(angle) > 0.02
    falls = np.gradient(angle) < -0.02
    rises[0] = False
    assert (motor - angle)[rises] == pytest.approx(0.01)
    assert (motor - angle)[falls] == pytest.approx(-0.01)


def test_partial_strokes_have_no_jump():
    angle = partial(np.random.default_rng(4))
    assert len(angle) == ROWS
    assert np.abs(np.diff(angle)).max() < 0.03


def test_slipping_anchors_lose_tension(driven):
    last = slice(-50, None)
    pull = [driven[name][1][2].extensor_elbow[last].mean() for name in ("none", "pretension falls")]
    assert 0.8 * pull[0] < pull[1] < 0.97 * pull[0]


def test_tissue_that_hardens_is_half_as_stiff_again_at_twice_the_pretension():
    straight = np.ones_like
    tendon = Tendon(1e-6, 2e-4, 1e-4, 0.1, straight, 150.0, hardening=0.5)
    tension = np.array([149.0, 150.0, 151.0, 299.0, 300.0, 301.0])
    stretch = tendon.tissue * tension + tendon.further_give(tension)
    softness = 0.5 * (stretch[2::3] - stretch[::3])
    assert stretch[1] == pytest.approx(tendon.tissue * 150.0)
    assert softness == pytest.approx([1e-4, 1e-4 / 1.5], rel=1e-4)


def test_a_slack_log_is_slack_and_others_are_not(driven):
    slack = [name for name, (_, logs) in driven.items() if logs[2].extensor_slack.any()]
    assert slack == ["slack"]


def test_random_suits_differ_from_their_studies_as_the_tolerances_say():
    sessions = [random_session(seed) for seed in range(400)]
    shifts = [one.suit["arm"]["b1"] - one.stated["arm"]["b1"] for one in sessions]
    gains = [one.sensors.torque_gain for one in sessions]
    loads = [one.loads[2] / 4.0 for one in sessions]
    assert np.std(shifts) == pytest.approx(5e-3, rel=0.15)
    assert np.std(gains) == pytest.approx(0.05, rel=0.15)
    assert np.std(loads) == pytest.approx(0.05, rel=0.15)
    assert all(one.stated_loads == LOADS for one in sessions)


def test_there_are_at_least_twenty_five_kinds_of_fault():
    assert len(FAULTS) >= 25
    assert {fault.expects for fault in FAULTS.values()} == {"right", "warned", "either", "refused"}


@pytest.mark.torture
def test_every_kind_of_log_can_be_made_and_read():
    logs = make_logs([(7, name) for name in FAULTS])
    for log in logs + random_suits(2, seed=1):
        assert log.texts
        for text in log.texts:
            separator = ";" if log.fault == "German" else ","
            decimal = "," if log.fault == "German" else "."
            frame = pd.read_csv(io.StringIO(text), sep=separator, decimal=decimal)
            assert len(frame) >= 100
