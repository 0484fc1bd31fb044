"""A suit in MuJoCo: its logs against the rig of elastic links, and the engine's own laws."""

import io
from importlib.util import find_spec

import numpy as np
import pandas as pd
import pytest

from verification.rigs import mujoco_suit
from verification.rigs.elastic_links import Motion, simulate
from verification.rigs.mujoco_suit import CACHE, SEEDS, kept_history, mujoco_log, run_log
from verification.rigs.suit_logs import LOADS, rig_of, session_of

needs_mujoco = pytest.mark.skipif(find_spec("mujoco") is None, reason="MuJoCo is not installed")


def test_what_is_kept_is_small():
    assert CACHE.stat().st_size < 300_000


def test_a_log_of_mujoco_reads_as_any_other():
    log = mujoco_log(SEEDS[1], with_tension=True)
    frames = [pd.read_csv(io.StringIO(text)) for text in log.texts]
    assert len(frames) == len(LOADS)
    for frame in frames:
        assert frame["elbow_angle (rad)"].max() > 1.3
        assert (frame["flexor_tension_proximal (N)"] > 0.0).all()


@pytest.mark.parametrize("log", [0, 2])
def test_two_engines_agree(log):
    """Lead the rig of elastic links along the joint's motion in MuJoCo."""
    seed = SEEDS[0]
    history = kept_history(seed, log).select(slice(0, 600))
    session = session_of(seed, "none")
    load = session.loads[log]
    arm = session.suit["arm"]
    inertia = arm["forearm_mass"] * arm["forearm_com"] ** 2 + load * arm["load_distance"] ** 2
    speed = np.gradient(history.angle, history.time)
    acceleration = np.gradient(speed, history.time)
    dynamic = inertia * acceleration + mujoco_suit.DAMPING * speed
    motion = Motion(history.time, history.angle, acceleration, dynamic)
    (rig,) = simulate([rig_of(session, load)], [motion], nodes=6)
    rows = slice(200, None)
    apart = (history.spool_angle - rig.spool_angle)[rows]
    torque = (history.motor_torque - rig.motor_torque)[rows]
    assert np.median(np.abs(apart - np.median(apart))) < 5e-3
    assert np.median(np.abs(torque)) < 0.02 * np.ptp(rig.motor_torque)


@needs_mujoco
@pytest.mark.torture
def test_logs_are_those_of_the_engine(monkeypatch):
    monkeypatch.setattr(mujoco_suit, "CYCLES", 1)
    found = run_log(session_of(SEEDS[0], "none"), 1)
    kept = kept_history(SEEDS[0], 1)
    rows = len(found["angle"])
    assert found["angle"] == pytest.approx(kept.angle[:rows], abs=0.02)
    assert found["spool_angle"] == pytest.approx(kept.spool_angle[:rows], abs=1e-3)
