"""The turn of the motion, against a chain of springs in a sheath that sticks, which knows no exponential."""

from dataclasses import replace

import numpy as np
import pytest

from tendon_cli.model.actuator import evaluate
from tendon_cli.model.reversal import reversal
from tendon_cli.model.statics import BOTH_SLACK
from tests.friction import rig

from .designs import baseline, design

PIECES = 500


def turned(friction, bend, tension, compliance, way, steps=400):
    """Where the motor is, from the turn on, and the tension there, until the whole tendon slips the other way."""
    angles = np.full((1, PIECES), bend / PIECES)
    stiffness = np.array([(PIECES + 1) / compliance])
    chain = rig.Tendon(np.array([tension]), angles, stiffness, np.zeros(1))
    mu, full = (
        np.array([friction]),
        4.0 * tension * compliance * np.sinh(friction * bend / 2.0) ** 2 / (friction * bend),
    )
    step = np.array([full / steps])
    while not chain.move(5 * step, way, mu).all():
        pass
    start, found = chain.motor.copy(), [(0.0, chain.tension[0, 0])]
    while not chain.move(step, -way, mu).all():
        found.append((float(way * (start - chain.motor)[0]), chain.tension[0, 0]))
    return np.array(found).T


@pytest.mark.parametrize("flexion", [True, False])
@pytest.mark.parametrize(("friction", "bend"), [(0.07, np.pi), (0.2, 3.0), (0.02, 9.0)])
@pytest.mark.parametrize("side", ["flexor", "extensor"])
def test_the_turn_is_that_of_a_sticking_chain(side, friction, bend, flexion):
    p = baseline(friction=friction, bend_angle=bend, load_mass=3.0, pretension=250.0, ratio=0.8)
    state = evaluate(design(p), np.radians(60.0), flexion)
    found = getattr(reversal(state, np.radians(60.0), flexion), side)
    section = np.pi * (1.5e-3 / 2) ** 2
    tension = float(getattr(state.balance, side))
    radius = 0.03 if side == "flexor" else 0.8 * 0.03
    way = 1.0 if (side == "flexor") == flexion else -1.0
    moved, at_motor = turned(friction, bend, tension, 2.0 / (section * 145e9), way)
    assert float(found.turn) == pytest.approx(moved[-1] / radius, rel=0.01)
    assert float(found.tension_after) == pytest.approx(at_motor[-1], rel=0.01)
    np.testing.assert_allclose(found.tension(moved / radius), at_motor, rtol=0.01)
    stored = 0.0  # what friction takes: the motor's work on the chain that the chain does not store
    work = -way * np.sum(0.5 * (at_motor[1:] + at_motor[:-1]) * np.diff(moved))
    for sign, total in ((-1.0, at_motor[0]), (1.0, at_motor[-1])):
        station = np.linspace(0.0, 1.0, 20_001)
        profile = total * (tension / total) ** station
        stored += sign * np.trapezoid(profile**2, station) * 2.0 / (section * 145e9) / 2.0
    assert float(found.loss) == pytest.approx(work - stored, rel=0.02)
    assert float(found.loss) > 0.0


def test_the_far_ends_follow_at_different_angles_and_the_torque_goes_over_into_that_of_the_way_back():
    p = baseline(load_mass=3.0, pretension=200.0)
    there, back = (evaluate(design(p), np.radians(75.0), way) for way in (True, False))
    found = reversal(there, 0.0, True)
    assert 0.0 < float(found.extensor.turn) < float(found.flexor.turn)
    both = max(float(found.flexor.turn), float(found.extensor.turn))
    torques = found.motor_torque(np.linspace(0.0, both, 200))
    assert torques[0] == pytest.approx(float(there.motor_torque))
    assert (np.diff(torques) < 0.0).all()
    # On the way back the elbow's tensions are other ones, by what tendons stretch: 0.5 % (claim C6 of the paper).
    assert torques[-1] == pytest.approx(float(back.motor_torque), rel=0.02)


def test_a_spring_at_the_motor_lets_out_what_its_tension_says():
    """At every tension on the way the spool has turned by what tendon and spring let out."""
    p = design(baseline(load_mass=3.0, pretension=250.0, ratio=0.8))
    moved = replace(
        p,
        flexor=replace(p.flexor, spring_at_motor=True),
        extensor=replace(p.extensor, spring_at_motor=True),
    )
    for flexion in (True, False):
        state = evaluate(moved, np.radians(60.0), flexion)
        found = reversal(state, np.radians(60.0), flexion)
        for side, radius in ((found.flexor, 0.03), (found.extensor, 0.8 * 0.03)):
            of_spring = (side.tension_before - side.tension_after) / 3e3
            of_tendon = radius * side.turn * np.sign(of_spring) - of_spring
            q = np.linspace(0.0, 1.0, 50)
            tension = side.tension_before * (1.0 + q * (side.ratio - 1.0)) ** 2
            let_out = of_tendon * q**2 + (side.tension_before - tension) / 3e3
            np.testing.assert_allclose(side.tension(np.abs(let_out) / radius), tension, rtol=1e-9)
            assert float(side.loss) > 0.0
            assert np.sign(of_tendon) == np.sign(of_spring)


@pytest.mark.parametrize("changed", [{"friction": 0.0}, {"bend_angle": 0.0}])
def test_without_friction_the_far_ends_follow_at_once(changed):
    p = design(baseline(pretension=200.0, **changed))
    state = evaluate(p, np.radians(45.0), True)
    found = reversal(state, 0.0, True)
    assert float(found.flexor.turn) == float(found.extensor.turn) == 0.0
    assert float(found.flexor.loss) == pytest.approx(0.0, abs=1e-15)
    assert float(found.motor_torque(np.array(0.1))) == pytest.approx(float(state.motor_torque))


def test_a_slack_tendon_has_no_turn():
    p = design(baseline(load_mass=10.0))
    state = evaluate(p, np.radians(90.0), True)
    found = reversal(state, 0.0, True)
    assert np.isnan([found.extensor.turn, found.extensor.loss, found.extensor.tension_after]).all()
    assert float(found.motor_torque(np.array(0.0))) == pytest.approx(float(state.motor_torque))
    loose = design(baseline(forearm_mass=0.0, pretension=30.0))
    state = evaluate(loose, np.radians(60.0), True)
    assert state.status == BOTH_SLACK
    assert float(reversal(state, 0.0, True).motor_torque(np.array(0.1))) == 0.0
