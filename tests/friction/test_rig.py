"""The simulated rig itself: it must find the sheath's law without knowing it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from verification.friction_rigs.rig import Rig, Tendon, simulate

QUIET = Rig(
    0.1, friction_scatter=0.0, gain_scatter=0.0, gain_mismatch=0.0, noise=0.0, resolution=0.0
)


@pytest.mark.parametrize("friction", [0.02, 0.1, 0.4])
@pytest.mark.parametrize("spring", [0.0, 0.6])
def test_slip_reaches_the_capstan_limit_both_ways(friction: float, spring: float) -> None:
    logs = simulate(replace(QUIET, friction=friction, load_spring=spring), 20)
    log_ratio = np.log(logs.motor_cell / logs.load_cell)
    limit = friction * QUIET.bend_angle
    assert np.allclose(np.abs(log_ratio[logs.slipping]), limit, rtol=5e-4)
    assert np.all(np.sign(log_ratio) * logs.toward[:, None] > 0, where=logs.slipping)
    assert np.all(np.abs(log_ratio) <= limit * 1.0005)


def test_every_reversal_sticks_first() -> None:
    logs = simulate(QUIET, 20)
    turns = np.flatnonzero(np.diff(logs.toward) != 0.0) + 1
    assert not logs.slipping[turns].any()
    assert logs.slipping[turns[1:] - 1].all()


def test_pieces_hold_within_their_own_limit() -> None:
    """Coulomb's law piece by piece, in a state that is half way through a reversal."""
    angles = np.full((1, 40), np.pi / 40)
    tendon = Tendon(np.array([1.0]), angles, np.array([1000.0]), np.zeros(1))
    friction = np.array([0.2])
    step = np.array([2e-4])
    for direction in [1.0] * 200 + [-1.0] * 40:
        tendon.move(step, direction, friction)
        before = tendon.tension[0, :-1]
        after = tendon.tension[0, 1:]
        limit = 0.2 * angles[0] * (before + after) / 2.0
        assert np.all(np.abs(before - after) <= limit * (1.0 + 1e-9))
    pulled = tendon.tension[0, :-1] > tendon.tension[0, 1:]
    assert 0 < pulled.sum() < 40


def test_sticking_rows_pull_a_plain_average_down_by_five_to_fifteen_percent() -> None:
    logs = simulate(QUIET, 100)
    log_ratio = np.log(logs.motor_cell / logs.load_cell)
    up = log_ratio[logs.toward > 0].mean(axis=0)
    down = log_ratio[logs.toward < 0].mean(axis=0)
    share = (up - down) / 2.0 / QUIET.bend_angle / QUIET.friction
    assert 0.80 < share.mean() < 0.95
