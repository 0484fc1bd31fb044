"""The turn of the motion, against a chain of springs in a sheath that sticks.

The chain knows no exponential.
"""

from dataclasses import replace

import numpy as np
import pytest

from tendon_cli.model.actuator import evaluate
from tendon_cli.model.reversal import reversal
from tendon_cli.model.statics import BOTH_SLACK
from verification.friction_rigs import rig

from .designs import baseline, design

PIECES = 500
FLEXOR_RADIUS = 0.03  # m
RATIO = 0.8
SPOOL_RADIUS = {"flexor": FLEXOR_RADIUS, "extensor": RATIO * FLEXOR_RADIUS}
TENDON_COMPLIANCE = 2.0 / (np.pi * (1.5e-3 / 2) ** 2 * 145e9)  # m/N


def turned(friction, bend, tension, compliance, direction, steps=400):
    """Turn the motor back until the whole tendon slips the other way.

    Returns:
        Way of the motor from the turn on, and the tension there, (2, steps until it slips).
    """
    angles = np.full((1, PIECES), bend / PIECES)
    stiffness = np.array([(PIECES + 1) / compliance])
    chain = rig.Tendon(np.array([tension]), angles, stiffness, np.zeros(1))
    mu = np.array([friction])
    exponent = friction * bend
    whole_turn = 4.0 * tension * compliance * np.sinh(exponent / 2.0) ** 2 / exponent
    step = np.array([whole_turn / steps])
    while not chain.move(5 * step, direction, mu).all():
        pass
    start = chain.motor.copy()
    positions = [0.0]
    tensions = [chain.tension[0, 0]]
    while not chain.move(step, -direction, mu).all():
        positions.append(float(direction * (start - chain.motor)[0]))
        tensions.append(chain.tension[0, 0])
    return np.array(positions), np.array(tensions)


def stored_energy(tension, tension_at_motor):
    """Return the energy in a tendon whose tension falls or rises evenly in its logarithm, J."""
    station = np.linspace(0.0, 1.0, 20_001)
    profile = tension_at_motor * (tension / tension_at_motor) ** station
    return np.trapezoid(profile**2, station) * TENDON_COMPLIANCE / 2.0


@pytest.mark.parametrize("flexion", [True, False])
@pytest.mark.parametrize(("friction", "bend"), [(0.07, np.pi), (0.2, 3.0), (0.02, 9.0)])
@pytest.mark.parametrize("side", ["flexor", "extensor"])
def test_the_turn_is_that_of_a_sticking_chain(side, friction, bend, flexion):
    p = baseline(friction=friction, bend_angle=bend, load_mass=3.0, pretension=250.0, ratio=RATIO)
    angle = np.radians(60.0)
    state = evaluate(design(p), angle, flexion)
    result = getattr(reversal(state, angle, flexion), side)
    tension = float(getattr(state.balance, side))
    radius = SPOOL_RADIUS[side]
    direction = 1.0 if (side == "flexor") == flexion else -1.0
    positions, at_motor = turned(friction, bend, tension, TENDON_COMPLIANCE, direction)
    assert float(result.turn) == pytest.approx(positions[-1] / radius, rel=0.01)
    assert float(result.tension_after) == pytest.approx(at_motor[-1], rel=0.01)
    np.testing.assert_allclose(result.tension(positions / radius), at_motor, rtol=0.01)
    # Friction takes the motor's work on the chain that the chain does not store.
    work = -direction * np.sum(0.5 * (at_motor[1:] + at_motor[:-1]) * np.diff(positions))
    stored = stored_energy(tension, at_motor[-1]) - stored_energy(tension, at_motor[0])
    assert float(result.loss) == pytest.approx(work - stored, rel=0.02)
    assert float(result.loss) > 0.0


def test_far_ends_follow_at_different_angles_and_the_torque_becomes_that_of_the_way_back():
    made = design(baseline(load_mass=3.0, pretension=200.0))
    flexing = evaluate(made, np.radians(75.0), True)
    extending = evaluate(made, np.radians(75.0), False)
    result = reversal(flexing, 0.0, True)
    assert 0.0 < float(result.extensor.turn) < float(result.flexor.turn)
    both = max(float(result.flexor.turn), float(result.extensor.turn))
    torques = result.motor_torque(np.linspace(0.0, both, 200))
    assert torques[0] == pytest.approx(float(flexing.motor_torque))
    assert (np.diff(torques) < 0.0).all()
    # On the way back the elbow's tensions differ by the stretch of the tendons: 0.5 % (claim C6 of
    # the paper).
    assert torques[-1] == pytest.approx(float(extending.motor_torque), rel=0.02)


def test_a_spring_at_the_motor_lets_out_what_its_tension_says():
    """The spool turns by the length that tendon and spring let out, at every tension on the way."""
    made = design(baseline(load_mass=3.0, pretension=250.0, ratio=RATIO))
    flexor = replace(made.flexor, spring_at_motor=True)
    extensor = replace(made.extensor, spring_at_motor=True)
    moved = replace(made, flexor=flexor, extensor=extensor)
    share = np.linspace(0.0, 1.0, 50)
    for flexion in (True, False):
        state = evaluate(moved, np.radians(60.0), flexion)
        result = reversal(state, np.radians(60.0), flexion)
        for name, radius in SPOOL_RADIUS.items():
            side = getattr(result, name)
            of_spring = (side.tension_before - side.tension_after) / 3e3
            of_tendon = radius * side.turn * np.sign(of_spring) - of_spring
            tension = side.tension_before * (1.0 + share * (side.ratio - 1.0)) ** 2
            let_out = of_tendon * share**2 + (side.tension_before - tension) / 3e3
            np.testing.assert_allclose(side.tension(np.abs(let_out) / radius), tension, rtol=1e-9)
            assert float(side.loss) > 0.0
            assert np.sign(of_tendon) == np.sign(of_spring)


@pytest.mark.parametrize("changed", [{"friction": 0.0}, {"bend_angle": 0.0}])
def test_without_friction_the_far_ends_follow_at_once(changed):
    state = evaluate(design(baseline(pretension=200.0, **changed)), np.radians(45.0), True)
    result = reversal(state, 0.0, True)
    assert float(result.flexor.turn) == 0.0
    assert float(result.extensor.turn) == 0.0
    assert float(result.flexor.loss) == pytest.approx(0.0, abs=1e-15)
    assert float(result.motor_torque(np.array(0.1))) == pytest.approx(float(state.motor_torque))


def test_a_slack_tendon_has_no_turn():
    state = evaluate(design(baseline(load_mass=10.0)), np.radians(90.0), True)
    result = reversal(state, 0.0, True)
    assert np.isnan(result.extensor.turn).all()
    assert np.isnan(result.extensor.loss).all()
    assert np.isnan(result.extensor.tension_after).all()
    assert float(result.motor_torque(np.array(0.0))) == pytest.approx(float(state.motor_torque))
    loose = evaluate(design(baseline(forearm_mass=0.0, pretension=30.0)), np.radians(60.0), True)
    assert loose.status == BOTH_SLACK
    assert float(reversal(loose, 0.0, True).motor_torque(np.array(0.1))) == 0.0
