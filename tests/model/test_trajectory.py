"""A motion in time, against formulas and fine sums.

Inertia asks for torque, friction has a direction, and the motor's results are sums along it.
"""

from dataclasses import replace

import numpy as np
import pytest

from tendon_cli.model.actuator import State
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.motion_window import window_along
from tendon_cli.model.motor import cycle_columns
from tendon_cli.model.moving import Moving, motion_columns
from tendon_cli.model.reversal import drift
from tendon_cli.model.trajectory import Trajectory

from .designs import BOTH_DIRECTIONS, baseline, design

MIDDLE = 0.9  # rad
SWING = 0.6  # rad
RATE = 1.5  # rad/s
INERTIA = 0.08  # kg m²


def swing(count=2001, cycles=1.0):
    """Return θ = 0.9 - 0.6 cos(rate t), in closed form."""
    time = np.linspace(0.0, cycles * 2.0 * np.pi / RATE, count)
    turn = RATE * time
    angle = MIDDLE - SWING * np.cos(turn)
    speed = RATE * np.sin(turn)
    acceleration = RATE**2 * np.cos(turn)
    jerk = -(RATE**3) * np.sin(turn)
    derivatives = SWING * np.array([speed, acceleration, jerk])
    return Trajectory(time, angle, derivatives)


def moved(trajectory, inertia=INERTIA, **changes):
    """Return the baseline with changes that moves along a trajectory."""
    made = design(baseline(**changes))
    return replace(made, trajectory=trajectory, arm=replace(made.arm, inertia=inertia))


def samples(trajectory):
    """Return angles and directions of a trajectory, each (1, samples)."""
    return trajectory.angle[np.newaxis], trajectory.is_flexing[np.newaxis]


def along(made):
    """Return a design along its trajectory."""
    return Moving.of(made, made.trajectory)


def states_of(made):
    """Return the states of a design that hold along its trajectory."""
    return along(made).state


def results_of(made):
    """Return the motor's results along the trajectory of a design as plain numbers by name."""
    return {name: float(value) for name, value in motion_columns(along(made)).items()}


def test_inertia_asks_for_torque_and_leaves_the_stiffness_as_it_is():
    trajectory = swing(301)
    angle, flexion = samples(trajectory)
    moving = State.of(moved(trajectory, load_mass=2.0), angle, flexion)
    still = State.of(design(baseline(load_mass=2.0)), angle, flexion)
    extra = moving.coupling.elbow_torque - still.coupling.elbow_torque
    expected = (INERTIA + 2.0 * 0.32**2) * trajectory.acceleration
    np.testing.assert_allclose(extra, expected[np.newaxis], atol=1e-12)
    np.testing.assert_array_equal(moving.torque_slope, still.torque_slope)


def test_each_sample_is_known_by_its_angle_though_the_joint_rests():
    rates = np.array([np.arange(5.0), -np.arange(5.0), np.ones(5)])
    trajectory = Trajectory(np.arange(5.0), np.zeros(5), rates)
    assert len(set(trajectory.angle)) == 5
    assert np.abs(trajectory.angle).max() < 1e-300
    np.testing.assert_array_equal(trajectory.derivatives_at(trajectory.angle), rates)
    np.testing.assert_array_equal(trajectory.derivatives_at(1.0), 0.0)


def test_where_a_joint_drifts_and_where_it_is_set_it_stands_still():
    moving = moved(swing(), pretension=200.0)
    still = design(baseline(pretension=200.0))
    first = float(moving.trajectory.angle[0])
    assert drift(moving, first, 1.5) == drift(still, first, 1.5)


def test_slow_full_swings_come_to_what_a_cycle_does():
    """Without inertia a full swing has the work and travel of both strokes, and adds the turns."""
    changes = {"forearm_mass": 4.0, "forearm_com": 0.25, "pretension": 200.0}
    made = moved(swing(40_001), inertia=0.0, **changes)
    results = results_of(made)
    results["friction_loss"] -= float(along(made).sliding.turn_loss.sum())
    angles = np.linspace(MIDDLE - SWING, MIDDLE + SWING, 91)[np.newaxis]
    strokes = cycle_columns(design(baseline(**changes)), angles, BOTH_DIRECTIONS, 1.0)
    for name in ("motor_work_in", "friction_loss", "spool_travel"):
        assert results[name] == pytest.approx(float(strokes[name]), rel=2e-4), name


def test_work_in_less_braking_is_what_the_elbow_takes_stores_and_friction_loses():
    """Along an open motion, with inertia, ∫τ_m dα = ∫τ_a dθ + ΔU + loss."""
    trajectory = swing(60_001, cycles=0.45)
    made = moved(trajectory, load_mass=3.0, pretension=250.0)
    results = results_of(made)
    state = states_of(made)
    elbow_work = float(np.sum(state.elbow_torque[0] * trajectory.speed * trajectory.weights))
    x = state.balance.flexor[0]
    y = state.balance.extensor[0]
    stored = (
        0.5 * (state.flexor.energy_compliance * x * x + state.extensor.energy_compliance * y * y)[0]
    )
    motor_work = results["motor_work_in"] - results["braking_work"]
    lost = results["friction_loss"] - float(state.sliding.turn_loss.sum())
    expected = elbow_work + stored[-1] - stored[0] + lost
    assert motor_work == pytest.approx(expected, rel=1e-6)


def test_peaks_and_the_root_mean_square_are_those_of_the_states():
    trajectory = swing(5001)
    made = moved(trajectory, load_mass=3.0, pretension=250.0)
    results = results_of(made)
    state = states_of(made)
    torque = state.motor_torque[0]
    root_mean_square = np.sqrt(np.mean(torque**2))
    assert results["rms_motor_torque"] == pytest.approx(root_mean_square, rel=1e-3)
    power = torque * np.gradient(state.spool_angle[0], trajectory.time)
    flexion = state.sliding.flexion[0]
    keeps_direction = flexion[:-2] == flexion[2:]
    peak = power[1:-1][keeps_direction].max()
    assert results["peak_motor_power"] == pytest.approx(peak, rel=1e-3)
    assert np.isnan(results["max_backlash"])


LIMITS = ("peak_motor_torque", "peak_motor_speed", "peak_motor_power")


@pytest.mark.parametrize("name", LIMITS)
def test_windows_along_a_trajectory_are_where_its_columns_keep_the_limit(name):
    trajectory = swing(121)
    changes = {"load_mass": 2.0, "ratio": 0.7}
    made = moved(trajectory, **changes)
    wide = window_along(made, trajectory, Bounds())

    def value(pretension):
        held = moved(trajectory, **changes, pretension=pretension)
        if name == "peak_motor_torque":
            held = along(held)
            torques = [held.state.motor_torque, held.turned.motor_torque]
            return float(np.abs(torques).max())
        return results_of(held)[name]

    limit = value(0.6 * float(wide.low) + 0.4 * float(wide.high))
    left = window_along(made, trajectory, Bounds(**{name: limit}))
    ends = [
        (float(left.low), float(wide.low), -1.0),
        (float(left.high), float(wide.high), 1.0),
    ]
    assert any(end != wide_end for end, wide_end, _ in ends)
    for end, wide_end, outward in ends:
        assert value(end) <= limit * (1.0 + 1e-9)
        assert end == wide_end or value(end + 1e-3 * outward) > limit
