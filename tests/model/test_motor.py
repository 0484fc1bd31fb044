"""Motor, springs and friction: the energy balance, and friction's work element by element."""

import numpy as np
import pytest

from tendon_cli.model.actuator import evaluate
from tendon_cli.model.motor import cycle_columns, motor_rates
from tendon_cli.model.statics import BOTH_SLACK, EXTENSOR_SLACK, FLEXOR_SLACK, NO_EQUILIBRIUM, TAUT

from . import rig
from .designs import BOTH_DIRECTIONS, baseline, design, scattered, stored_energy

SPEED = np.radians(60.0)
CASES = {
    "taut": baseline(load_mass=3.0, pretension=150.0),
    "no load": baseline(),
    "extensor slack": baseline(load_mass=5.0),
    "flexor slack": baseline(load_mass=3.0, upper_arm_angle=np.radians(-120.0), pretension=60.0),
    "both slack": baseline(forearm_mass=0.0, pretension=30.0),
    "bilateral": baseline(load_mass=10.0, unilateral=False),
    "no friction": baseline(load_mass=5.0, friction=0.0),
    "straight sheath": baseline(load_mass=5.0, bend_angle=0.0),
    "sides differ": baseline(
        load_mass=5.0,
        ratio=0.7,
        extensor_pretension=140.0,
        extensor_friction=0.2,
        extensor_spring_stiffness=5e3,
        flexor_bend_angle=4.0,
    ),
    "soft tendon, much friction": baseline(
        load_mass=2.0, friction=0.3, youngs_modulus=2e9, pretension=200.0
    ),
}


def degrees(low, high, count):
    """Return angles along the last of two axes, rad."""
    return np.radians(np.linspace(low, high, count)).reshape(1, -1)


def cycle_of(p, angles, directions=BOTH_DIRECTIONS, speed=SPEED):
    """Return the results of a cycle as plain numbers by name."""
    results = cycle_columns(design(p), angles, directions, speed)
    return {name: float(value) for name, value in results.items()}


# --- States ---------------------------------------------------------------------------------------


def test_what_the_motor_gives_is_held_stored_or_lost_in_every_state():
    p, angle, flexion = scattered(4000, seed=11)
    state = evaluate(design(p), angle, flexion)
    rates = motor_rates(state)
    status = state.balance.status
    every_status = {TAUT, FLEXOR_SLACK, EXTENSOR_SLACK, BOTH_SLACK, NO_EQUILIBRIUM}
    assert set(np.unique(status)) == every_status
    answered = status != NO_EQUILIBRIUM
    all_terms = np.array([rates.power, -state.elbow_torque, -rates.storage_rate, -rates.friction])
    terms = all_terms[:, answered]
    assert np.isfinite(terms).all()
    scale = np.abs(terms).max(axis=0) + 1e-12
    imbalance = np.abs(terms.sum(axis=0)) / scale
    assert imbalance.max() < 1e-6
    assert np.median(imbalance) < 1e-14
    both = (status == BOTH_SLACK) & np.asarray(p["unilateral"])
    assert np.isnan(rates.spool_speed[both]).all()
    assert np.isnan(rates.spool_speed[~answered]).all()
    assert not np.isnan(rates.spool_speed[answered & ~both]).any()


@pytest.mark.parametrize("name", ["taut", "extensor slack", "flexor slack", "sides differ"])
@pytest.mark.parametrize("flexion", [True, False])
def test_the_spool_turns_as_in_an_engine_that_searches_for_its_angle(name, flexion):
    p = CASES[name]
    angle = np.radians(70.0)
    step = 1e-4
    twice = {key: np.full(2, value) for key, value in p.items()}
    around = np.array([angle - step, angle + step])
    before, after = rig.run(twice, around, np.full(2, flexion))
    slope = (after.spool_angle - before.spool_angle) / (2 * step)
    rates = motor_rates(evaluate(design(p), angle, flexion))
    assert float(rates.spool_speed) == pytest.approx(slope, rel=1e-6)


def loss_by_elements(p, angles, flexion, elements=500):
    """Sum friction's work over a stroke.

    For each element of both sheaths it is its step of tension times the length that slides by.
    """
    state = evaluate(design(p), angles, flexion)
    station = np.linspace(0.0, 1.0, elements + 1)[:, np.newaxis]
    ends = {
        "flexor": (state.balance.flexor, state.motion.flexor_travel),
        "extensor": (state.balance.extensor, -state.motion.extensor_travel),
    }
    total = 0.0
    for side, (distal, travel) in ends.items():
        toward = -1.0 if (side == "flexor") == flexion else 1.0
        friction = p[f"{side}_friction"]
        bend_angle = p[f"{side}_bend_angle"]
        tension = distal * np.exp(-toward * friction * bend_angle * station)
        section = np.pi * p[f"{side}_diameter"] ** 2 / 4
        mean = 0.5 * (tension[1:] + tension[:-1])
        stretch = mean * p[f"{side}_length"] / elements / section / p[f"{side}_youngs_modulus"]
        spring = distal / p[f"{side}_spring_stiffness"]
        place = travel + spring + np.cumsum(stretch, axis=0) - 0.5 * stretch
        held = np.diff(tension, axis=0)
        total += (0.5 * (held[:, 1:] + held[:, :-1]) * np.diff(place, axis=1)).sum()
    return total if flexion else -total


@pytest.mark.parametrize("name", CASES)
def test_frictions_loss_is_that_of_its_elements(name):
    p = CASES[name]
    angles = degrees(5.0, 85.0, 801)
    expected = loss_by_elements(p, angles[0], True) + loss_by_elements(p, angles[0], False)
    assert cycle_of(p, angles)["friction_loss"] == pytest.approx(expected, rel=2e-5, abs=1e-9)


# --- Cycles ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CASES)
def test_motor_work_less_elbow_work_less_stored_energy_is_the_loss(name):
    """The expected values are sums over torques and angles of fine states alone."""
    p = CASES[name]
    result = cycle_of(p, degrees(0.0, 90.0, 10))
    fine = degrees(0.0, 90.0, 40_001)
    state = evaluate(design(p), fine, BOTH_DIRECTIONS)
    shape = (2, fine.size)

    def work(torque, angle):
        torque = np.broadcast_to(torque, shape)
        # A spool that is free, with both tendons slack, has no angle and does no work.
        steps = np.nan_to_num(np.diff(np.broadcast_to(angle, shape), axis=1))
        return 0.5 * (torque[:, 1:] + torque[:, :-1]) * steps

    by_motor = work(state.motor_torque, state.spool_angle)
    by_elbow = work(state.elbow_torque, fine).sum(axis=1)
    stored = np.broadcast_to(stored_energy(state), shape)
    gained = by_motor.sum(axis=1) - by_elbow - (stored[:, -1] - stored[:, 0])
    loss = gained[0] - gained[1]
    near = 1e-6 * np.abs(by_motor).sum()
    assert result["friction_loss"] == pytest.approx(loss, rel=1e-6, abs=near)
    driven = np.maximum(by_motor * np.array([[1.0], [-1.0]]), 0.0).sum()
    assert result["motor_work_in"] == pytest.approx(driven, rel=1e-6, abs=1e-9)
    if driven > 0.0:
        efficiency = 1.0 - result["friction_loss"] / driven
        assert result["efficiency"] == pytest.approx(efficiency, rel=1e-5, abs=1e-6)


@pytest.mark.parametrize("name", ["no friction", "straight sheath"])
def test_without_friction_nothing_is_lost_and_nothing_lags(name):
    result = cycle_of(CASES[name], degrees(0.0, 90.0, 91))
    assert result["friction_loss"] == 0.0
    assert result["max_backlash"] == 0.0
    assert result["max_torque_band"] == 0.0
    assert result["efficiency"] == 1.0
    assert result["peak_braking_power"] == pytest.approx(result["peak_motor_power"])


def test_peaks_and_differences_are_those_of_the_states():
    p = CASES["extensor slack"]
    angles = degrees(0.0, 90.0, 91)
    result = cycle_of(p, angles)
    state = evaluate(design(p), angles, BOTH_DIRECTIONS)
    turned = state.spool_angle + state.flexor.compliance * 100.0 / 0.03
    travel = turned.max() - turned.min()
    backlash = np.abs(turned[0] - turned[1]).max()
    torque_band = np.abs(np.diff(state.motor_torque, axis=0)).max()
    assert result["spool_travel"] == pytest.approx(travel, rel=1e-12)
    assert result["max_backlash"] == pytest.approx(backlash, rel=1e-12)
    assert result["max_torque_band"] == pytest.approx(torque_band, rel=1e-12)
    speed = np.abs(np.gradient(turned, angles[0], axis=1)) * SPEED
    assert result["peak_motor_speed"] >= speed[:, 1:-1].max() * 0.98
    # No speed, torque or power is larger between two states than both rates of the study allow.
    largest_torque = np.abs(state.motor_torque).max()
    assert result["peak_motor_power"] <= result["peak_motor_speed"] * largest_torque


def test_power_goes_with_the_speed_and_work_does_not():
    p = CASES["extensor slack"]
    angles = degrees(0.0, 90.0, 19)
    slow = cycle_of(p, angles)
    fast = cycle_of(p, angles, speed=3.0 * SPEED)
    for name in ("peak_motor_speed", "peak_motor_power", "peak_braking_power"):
        assert fast[name] == pytest.approx(3.0 * slow[name])
    for name in ("motor_work_in", "friction_loss", "spool_travel", "max_backlash"):
        assert fast[name] == slow[name]


def test_neither_the_order_of_the_angles_nor_that_of_the_directions_matters():
    p = CASES["extensor slack"]
    angles = degrees(0.0, 90.0, 7)
    result = cycle_of(p, angles)
    turned_round = cycle_of(p, angles[:, ::-1], BOTH_DIRECTIONS[::-1])
    for name, value in result.items():
        assert value == pytest.approx(turned_round[name]), name


def test_one_direction_has_no_backlash_and_one_angle_no_work():
    one_way = cycle_of(CASES["taut"], degrees(0.0, 90.0, 7), BOTH_DIRECTIONS[:1])
    assert np.isnan(one_way["max_backlash"])
    assert np.isnan(one_way["max_torque_band"])
    assert 0.0 < one_way["friction_loss"] < one_way["motor_work_in"]
    still = cycle_of(CASES["taut"], degrees(45.0, 45.0, 1))
    assert still["motor_work_in"] == 0.0
    assert still["friction_loss"] == 0.0
    assert np.isnan(still["efficiency"])
    assert still["max_backlash"] > 0.0
