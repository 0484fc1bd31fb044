"""The flexor's path, its moment arm and what follows from them (Eqs. 1-3)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tendon_cli.model import actuator, statics
from tendon_cli.model.kinematics import Anchors, flexor_path

from .designs import baseline, design, kinematics
from .rig import derivative

OFFSETS = st.floats(0.005, 0.08)
ALONG_UPPER_ARM = st.floats(0.16, 0.35)
ALONG_FOREARM = st.floats(0.03, 0.12)
ARMS = st.builds(Anchors, OFFSETS, ALONG_UPPER_ARM, OFFSETS, ALONG_FOREARM, st.floats(0.02, 0.08))
ANGLES = st.floats(-0.8, 3.1)


@given(ARMS, ANGLES)
def test_the_moment_arm_is_the_rate_at_which_the_path_shortens(arm, angle):
    def path(at):
        return float(flexor_path(arm, at))

    def travel(at):
        return float(kinematics(arm, at).flexor_travel)

    rate = -derivative(path, angle, 2e-3)
    assert kinematics(arm, angle).flexor_moment_arm == pytest.approx(rate, abs=1e-10)
    assert derivative(travel, angle, 2e-3) == pytest.approx(rate, abs=1e-10)


@given(ARMS, ANGLES)
def test_the_slope_of_the_moment_arm_is_its_rate(arm, angle):
    def moment_arm(at):
        return float(kinematics(arm, at).flexor_moment_arm)

    rate = derivative(moment_arm, angle, 2e-3)
    assert kinematics(arm, angle).flexor_moment_arm_slope == pytest.approx(rate, abs=1e-9)


@given(ARMS, ANGLES)
def test_exchanging_upper_arm_and_forearm_changes_nothing(arm, angle):
    exchanged = Anchors(arm.a2, arm.b2, arm.a1, arm.b1, arm.elbow_radius)
    mirrored = kinematics(exchanged, angle)
    motion = kinematics(arm, angle)
    path = float(motion.flexor_path)
    moment_arm = float(motion.flexor_moment_arm)
    slope = float(motion.flexor_moment_arm_slope)
    assert mirrored.flexor_path == pytest.approx(path, rel=1e-13)
    assert mirrored.flexor_moment_arm == pytest.approx(moment_arm, abs=1e-13)
    assert mirrored.flexor_moment_arm_slope == pytest.approx(slope, abs=1e-12)


@given(ARMS, ANGLES)
def test_the_two_references_differ_by_the_same_length_at_every_angle(arm, angle):
    published = kinematics(arm, angle)
    initial = kinematics(arm, angle, from_initial=True)
    offset = float(flexor_path(arm, 0.0)) - (arm.b1 + arm.b2)
    assert initial.flexor_travel - published.flexor_travel == pytest.approx(offset, abs=1e-15)
    assert initial.flexor_moment_arm == published.flexor_moment_arm
    assert kinematics(arm, 0.0, from_initial=True).flexor_travel == 0.0


@pytest.mark.parametrize("unilateral", [True, False])
@pytest.mark.parametrize("flexion", [True, False])
def test_coincident_anchors_have_no_moment_arm_and_no_equilibrium(flexion, unilateral):
    p = baseline(a1=0.04, b1=0.15, a2=0.04, b2=-0.15, unilateral=unilateral)
    state = actuator.evaluate(design(p), 0.0, flexion)
    assert state.motion.flexor_path == 0.0
    assert np.isnan(state.motion.flexor_moment_arm)
    assert state.status == statics.NO_EQUILIBRIUM


@given(st.floats(-1.5, 3.0), st.floats(-1.5, 1.5), st.floats(0.0, 20.0))
def test_the_weight_is_held_against_gravity_along_the_path_of_the_masses(angle, inclination, load):
    held = design(baseline(upper_arm_angle=inclination, load_mass=load))
    mass_moment = held.arm.forearm_mass * held.arm.forearm_com + load * held.arm.load_distance

    def energy(at):
        return -9.81 * mass_moment * np.cos(at + inclination)

    def torque(at):
        return float(actuator.State.of(held, at, flexion=True).coupling.elbow_torque)

    state = actuator.State.of(held, angle, flexion=True)
    assert torque(angle) == pytest.approx(derivative(energy, angle, 2e-3), abs=1e-9)
    assert state.torque_slope == pytest.approx(derivative(torque, angle, 2e-3), abs=1e-9)


def test_a_moment_arm_of_rounding_noise_is_none():
    """A straight arm with both anchors on the bone stands at its dead centre.

    It stands there a full turn before and after, too.
    """
    on_the_bone = design(baseline(a1=0.0, a2=0.0))
    turns = np.array([-2.0 * np.pi, 0.0, 2.0 * np.pi])
    straight = actuator.evaluate(on_the_bone, turns, flexion=True)
    beyond = actuator.evaluate(on_the_bone, np.array([1e-6]), flexion=True)
    assert 0.0 < straight.motion.flexor_moment_arm.max() < 1e-15
    assert (straight.status == statics.NO_EQUILIBRIUM).all()
    assert np.isnan(straight.balance.flexor).all()
    assert beyond.motion.flexor_moment_arm == pytest.approx(0.075e-6, rel=1e-6)
    assert beyond.status != statics.NO_EQUILIBRIUM


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_what_counts_as_none_goes_with_the_size_of_the_arm(size):
    """J = size sin(θ/2) for anchors on the bone, each as far from the elbow as the size."""
    anchors = Anchors(0.0, size, 0.0, size, 0.045)
    assert np.isnan(kinematics(anchors, 4.0 * 0.5e-9).pulling_arm)
    assert not np.isnan(kinematics(anchors, 4.0 * 1.5e-9).pulling_arm)
