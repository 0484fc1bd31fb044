"""Motor, springs and friction: the energy balance, and friction's work summed up element by element."""

import numpy as np
import pytest

from tendon_cli.model.actuator import evaluate
from tendon_cli.model.motor import cycle, motor_rates
from tendon_cli.model.statics import BOTH_SLACK, EXTENSOR_SLACK, FLEXOR_SLACK, NO_EQUILIBRIUM, TAUT

from . import rig
from .designs import baseline, design, scattered

WAYS = np.array([[True], [False]])
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
    return np.radians(np.linspace(low, high, count)).reshape(1, -1)


# --- States ---------------------------------------------------------------------------------------


def test_what_the_motor_gives_is_held_stored_or_lost_in_every_state():
    p, angle, flexion = scattered(4000, seed=11)
    state = evaluate(design(p), angle, flexion)
    rates = motor_rates(state)
    status = state.balance.status
    assert set(np.unique(status)) == {
        TAUT,
        FLEXOR_SLACK,
        EXTENSOR_SLACK,
        BOTH_SLACK,
        NO_EQUILIBRIUM,
    }
    answered = status != NO_EQUILIBRIUM
    terms = np.array([rates.power, -state.elbow_torque, -rates.storing, -rates.friction])[
        :, answered
    ]
    assert np.isfinite(terms).all()
    scale = np.abs(terms).max(axis=0) + 1e-12
    assert (np.abs(terms.sum(axis=0)) / scale).max() < 1e-6
    assert np.median(np.abs(terms.sum(axis=0)) / scale) < 1e-14
    both = (status == BOTH_SLACK) & np.asarray(p["unilateral"])
    assert np.isnan(rates.spool_speed[both]).all()
    assert np.isnan(rates.spool_speed[~answered]).all()
    assert not np.isnan(rates.spool_speed[answered & ~both]).any()


@pytest.mark.parametrize("name", ["taut", "extensor slack", "flexor slack", "sides differ"])
@pytest.mark.parametrize("flexion", [True, False])
def test_the_spool_turns_as_in_an_engine_that_searches_for_its_angle(name, flexion):
    p, angle, step = CASES[name], np.radians(70.0), 1e-4
    ways = [
        {key: np.full(2, value) for key, value in p.items()},
        np.array([angle - step, angle + step]),
    ]
    before, after = rig.run(*ways, np.full(2, flexion))
    rates = motor_rates(evaluate(design(p), angle, flexion))
    assert float(rates.spool_speed) == pytest.approx(
        (after.spool_angle - before.spool_angle) / (2 * step), rel=1e-6
    )


def by_elements(p, angles, flexion, elements=500):
    """Friction's work over a stroke: of each element of both sheaths its step of tension times how far it slides."""
    state = evaluate(design(p), angles, flexion)
    motion, total = state.motion, 0.0
    station = np.linspace(0.0, 1.0, elements + 1)[:, np.newaxis]
    ends = {
        "flexor": (state.balance.flexor, motion.flexor_travel),
        "extensor": (state.balance.extensor, -motion.extensor_travel),
    }
    for side, (distal, moved) in ends.items():
        toward = -1.0 if (side == "flexor") == flexion else 1.0
        tension = distal * np.exp(
            -toward * p[f"{side}_friction"] * p[f"{side}_bend_angle"] * station
        )
        section = np.pi * p[f"{side}_diameter"] ** 2 / 4
        middle = 0.5 * (tension[1:] + tension[:-1])
        stretch = middle * p[f"{side}_length"] / elements / section / p[f"{side}_youngs_modulus"]
        place = (
            moved
            + distal / p[f"{side}_spring_stiffness"]
            + np.cumsum(stretch, axis=0)
            - 0.5 * stretch
        )
        held = np.diff(tension, axis=0)
        total += (0.5 * (held[:, 1:] + held[:, :-1]) * np.diff(place, axis=1)).sum()
    return total if flexion else -total


@pytest.mark.parametrize("name", CASES)
def test_frictions_loss_is_that_of_its_elements(name):
    angles = degrees(5.0, 85.0, 801)
    found = cycle(design(CASES[name]), angles, WAYS, SPEED)
    expected = sum(by_elements(CASES[name], angles[0], way) for way in (True, False))
    assert float(found["friction_loss"]) == pytest.approx(expected, rel=2e-5, abs=1e-9)


# --- Cycles ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CASES)
def test_motor_work_less_elbow_work_less_stored_energy_is_the_loss(name):
    """With every work summed from torques and angles of fine states alone."""
    p = CASES[name]
    found = cycle(design(p), degrees(0.0, 90.0, 10), WAYS, SPEED)
    fine = degrees(0.0, 90.0, 40_001)
    state = evaluate(design(p), fine, WAYS)
    rates = motor_rates(state)

    def work(torque, turned):
        steps = np.nan_to_num(
            np.diff(turned, axis=1)
        )  # both slack: a spool that is free does no work
        return 0.5 * (torque[:, 1:] + torque[:, :-1]) * steps

    torque = np.broadcast_to(state.motor_torque, (2, fine.size))
    by_motor = work(torque, np.broadcast_to(state.spool_angle, torque.shape))
    by_elbow = work(
        np.broadcast_to(state.elbow_torque, torque.shape), np.broadcast_to(fine, torque.shape)
    ).sum(axis=1)
    stored = np.broadcast_to(rates.stored, torque.shape)
    gained = by_motor.sum(axis=1) - by_elbow - (stored[:, -1] - stored[:, 0])
    largest = np.abs(by_motor).sum()
    assert float(found["friction_loss"]) == pytest.approx(
        gained[0] - gained[1], rel=1e-6, abs=1e-6 * largest
    )
    driven = np.maximum(by_motor * np.array([[1.0], [-1.0]]), 0.0).sum()
    assert float(found["motor_work_in"]) == pytest.approx(driven, rel=1e-6, abs=1e-9)
    if driven > 0.0:
        assert float(found["efficiency"]) == pytest.approx(
            1.0 - float(found["friction_loss"]) / driven, rel=1e-5, abs=1e-6
        )


@pytest.mark.parametrize("name", ["no friction", "straight sheath"])
def test_without_friction_nothing_is_lost_and_nothing_lags(name):
    found = cycle(design(CASES[name]), degrees(0.0, 90.0, 91), WAYS, SPEED)
    assert (
        float(found["friction_loss"])
        == float(found["max_backlash"])
        == float(found["max_torque_band"])
        == 0.0
    )
    assert float(found["efficiency"]) == 1.0
    assert float(found["peak_braking_power"]) == pytest.approx(float(found["peak_motor_power"]))


def test_peaks_and_differences_are_those_of_the_states():
    p, angles = CASES["extensor slack"], degrees(0.0, 90.0, 91)
    found, state = cycle(design(p), angles, WAYS, SPEED), evaluate(design(p), angles, WAYS)
    turned = state.spool_angle + state.flexor.compliance * 100.0 / 0.03
    assert float(found["spool_travel"]) == pytest.approx(turned.max() - turned.min(), rel=1e-12)
    assert float(found["max_backlash"]) == pytest.approx(
        np.abs(turned[0] - turned[1]).max(), rel=1e-12
    )
    assert float(found["max_torque_band"]) == pytest.approx(
        np.abs(np.diff(state.motor_torque, axis=0)).max(), rel=1e-12
    )
    speed = np.abs(np.gradient(turned, angles[0], axis=1)) * SPEED
    inside = np.sort(speed[:, 1:-1].ravel())[::-1]
    assert float(found["peak_motor_speed"]) >= inside[0] * 0.98
    # No speed, torque or power is larger between two states than both rates of the study allow.
    assert (
        float(found["peak_motor_power"])
        <= float(found["peak_motor_speed"]) * np.abs(state.motor_torque).max()
    )


def test_power_goes_with_the_speed_and_work_does_not():
    p, angles = design(CASES["extensor slack"]), degrees(0.0, 90.0, 19)
    slow, fast = (cycle(p, angles, WAYS, speed) for speed in (SPEED, 3.0 * SPEED))
    for name in ("peak_motor_speed", "peak_motor_power", "peak_braking_power"):
        assert float(fast[name]) == pytest.approx(3.0 * float(slow[name]))
    for name in ("motor_work_in", "friction_loss", "spool_travel", "max_backlash"):
        assert float(fast[name]) == float(slow[name])


def test_neither_the_order_of_the_angles_nor_that_of_the_directions_matters():
    p, angles = design(CASES["extensor slack"]), degrees(0.0, 90.0, 7)
    plain, turned = cycle(p, angles, WAYS, SPEED), cycle(p, angles[:, ::-1], WAYS[::-1], SPEED)
    assert all(float(value) == pytest.approx(float(turned[name])) for name, value in plain.items())


def test_one_direction_has_no_backlash_and_one_angle_no_work():
    one_way = cycle(design(CASES["taut"]), degrees(0.0, 90.0, 7), WAYS[:1], SPEED)
    assert np.isnan([one_way["max_backlash"], one_way["max_torque_band"]]).all()
    assert 0.0 < float(one_way["friction_loss"]) < float(one_way["motor_work_in"])
    still = cycle(design(CASES["taut"]), degrees(45.0, 45.0, 1), WAYS, SPEED)
    assert float(still["motor_work_in"]) == float(still["friction_loss"]) == 0.0
    assert np.isnan(still["efficiency"])
    assert float(still["max_backlash"]) > 0.0
