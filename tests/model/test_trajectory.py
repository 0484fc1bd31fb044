"""A motion in time: inertia, friction's direction and the motor's sums along it, against formulas and fine sums."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tendon_cli.model.actuator import State, evaluate
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.motor import along, cycle
from tendon_cli.model.motor_window import narrowed
from tendon_cli.model.reversal import drift
from tendon_cli.model.trajectory import Trajectory, ways
from tendon_cli.model.window import window

from .designs import baseline, design

MIDDLE, SWING, RATE = 0.9, 0.6, 1.5  # rad, rad, rad/s


def swing(count=2001, cycles=1.0, rate=RATE):
    """θ = 0.9 - 0.6 cos(rate t), in closed form."""
    time = np.linspace(0.0, cycles * 2.0 * np.pi / rate, count)
    turn = rate * time
    angle = MIDDLE - SWING * np.cos(turn)
    derivatives = SWING * np.array(
        [rate * np.sin(turn), rate**2 * np.cos(turn), -(rate**3) * np.sin(turn)]
    )
    return Trajectory(time, angle, derivatives, 0.0)


def moved(trajectory, inertia=0.08, **changes):
    made = design(baseline(**changes))
    return replace(made, trajectory=trajectory, arm=replace(made.arm, inertia=inertia))


def along_states(made):
    trajectory = made.trajectory
    return evaluate(made, trajectory.angle[np.newaxis], trajectory.flexion[np.newaxis])


def test_inertia_asks_for_torque_and_leaves_the_stiffness_as_it_is():
    trajectory = swing(301)
    made, still = moved(trajectory, load_mass=2.0), design(baseline(load_mass=2.0))
    angle, flexion = trajectory.angle[np.newaxis], trajectory.flexion[np.newaxis]
    at, rest = (State.of(each, angle, flexion) for each in (made, still))
    asked = (0.08 + 2.0 * 0.32**2) * trajectory.acceleration
    np.testing.assert_allclose(
        at.coupling.elbow_torque - rest.coupling.elbow_torque, asked[np.newaxis], atol=1e-12
    )
    np.testing.assert_array_equal(at.torque_slope, rest.torque_slope)


def test_each_sample_is_known_by_its_angle_though_the_joint_rests():
    rates = np.array([np.arange(5.0), -np.arange(5.0), np.ones(5)])
    trajectory = Trajectory(np.arange(5.0), np.zeros(5), rates, 0.0)
    assert len(set(trajectory.angle)) == 5
    assert np.abs(trajectory.angle).max() < 1e-300
    np.testing.assert_array_equal(trajectory.at(trajectory.angle), rates)
    np.testing.assert_array_equal(trajectory.at(1.0), 0.0)


def test_where_a_joint_drifts_and_where_it_is_set_it_stands_still():
    made, still = moved(swing(), pretension=200.0), design(baseline(pretension=200.0))
    first = float(made.trajectory.angle[0])
    assert drift(made, first, 1.5) == drift(still, first, 1.5)


def test_slow_full_swings_come_to_what_a_cycle_does():
    """Without inertia a swing there and back is both strokes: the same work, loss, travel and peaks."""
    changes = {"forearm_mass": 4.0, "forearm_com": 0.25, "pretension": 200.0}
    trajectory = swing(40_001)
    found, low = along(moved(trajectory, inertia=0.0, **changes), trajectory), MIDDLE - SWING
    angles = np.linspace(low, MIDDLE + SWING, 91)[np.newaxis]
    strokes = cycle(design(baseline(**changes)), angles, np.array([[True], [False]]), 1.0)
    for name in ("motor_work_in", "friction_loss", "spool_travel", "efficiency"):
        assert float(found[name]) == pytest.approx(float(strokes[name]), rel=2e-4), name


def test_work_in_less_braking_is_what_the_elbow_takes_stores_and_friction_loses():
    """Along an open motion, with inertia: ∫τ_m dα = ∫τ_a dθ + ΔU + loss, all from the columns and states."""
    trajectory = swing(60_001, cycles=0.45)
    made = moved(trajectory, load_mass=3.0, pretension=250.0)
    found, state = along(made, trajectory), along_states(made)
    elbow = float(np.sum(state.elbow_torque[0] * trajectory.speed * trajectory.weights))
    x, y = state.balance.flexor[0], state.balance.extensor[0]
    stored = 0.5 * (state.flexor.gives * x * x + state.extensor.gives * y * y)[0]
    by_motor = float(found["motor_work_in"] - found["braking_work"])
    assert by_motor == pytest.approx(
        elbow + stored[-1] - stored[0] + float(found["friction_loss"]), rel=1e-6
    )


def test_peaks_and_the_root_mean_square_are_those_of_the_states():
    trajectory = swing(5001)
    made = moved(trajectory, load_mass=3.0, pretension=250.0)
    found, torque = along(made, trajectory), along_states(made).motor_torque[0]
    turned = along_states(made).spool_angle[0]
    speed = np.gradient(turned, trajectory.time)
    assert float(found["rms_motor_torque"]) == pytest.approx(np.sqrt(np.mean(torque**2)), rel=1e-3)
    one_way = trajectory.flexion[:-1] == trajectory.flexion[1:]
    assert float(found["peak_motor_power"]) == pytest.approx(
        (torque * speed)[:-1][one_way].max(), rel=1e-3
    )
    assert np.isnan(found["max_backlash"]).all()


LIMITS = (
    "peak_motor_torque",
    "peak_motor_speed",
    "peak_motor_power",
    "max_motor_work_in",
    "max_friction_loss",
)


@pytest.mark.parametrize("name", LIMITS)
def test_windows_along_a_trajectory_are_where_its_columns_keep_the_limit(name):
    trajectory = swing(121)
    at, flexion = trajectory.angle[np.newaxis], trajectory.flexion[np.newaxis]
    made = moved(trajectory, load_mass=2.0, ratio=0.7)
    wide = window(made, at, flexion, Bounds())

    def value(pretension):
        held = moved(trajectory, load_mass=2.0, ratio=0.7, pretension=pretension)
        if name == "peak_motor_torque":
            return float(np.abs(along_states(held).motor_torque).max())
        return float(along(held, trajectory)[name.removeprefix("max_")])

    bounds = Bounds(**{name: value(0.6 * float(wide.low) + 0.4 * float(wide.high))})
    found = narrowed(window(made, at, flexion, bounds), made, at, flexion, bounds)
    ends = [(float(found.low), float(wide.low), -1.0), (float(found.high), float(wide.high), 1.0)]
    assert any(end != wider for end, wider, _ in ends)
    for end, wider, outward in ends:
        assert value(end) <= bounds[name] * (1.0 + 1e-9)
        assert end == wider or value(end + 1e-3 * outward) > bounds[name]


# --- The direction of friction --------------------------------------------------------------------


def test_friction_turns_once_the_angle_has_come_back_far_enough():
    angle = np.radians([0.0, 0.5, 2.0, 5.0, 4.5, 4.2, 3.9, 2.0, 2.5, 3.5, 3.5, 3.5])
    expected = [True, True, True, True, True, True, False, False, False, True, True, True]
    assert ways(angle, np.radians(1.0)).tolist() == expected


def test_noise_smaller_than_the_reversal_turns_nothing():
    rng = np.random.default_rng(1)
    angle = np.concatenate([np.linspace(0.0, 1.0, 200), np.linspace(1.0, 0.2, 200)])
    flexion = ways(angle + rng.uniform(-0.004, 0.004, 400), 0.0175)
    assert np.flatnonzero(np.diff(flexion)).size == 1
    assert flexion[0]
    assert not flexion[-1]


@given(st.integers(0, 1000), st.floats(0.0, 0.3))
def test_a_mirrored_motion_has_the_other_friction(seed, reversal):
    angle = np.cumsum(np.random.default_rng(seed).normal(0.0, 0.1, 60))
    there, back = ways(angle, reversal), ways(-angle, reversal)
    if np.abs(angle - angle[0]).max() > reversal:
        np.testing.assert_array_equal(there, ~back)
