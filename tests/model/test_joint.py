"""Any joint: travels from curves, sheaths that bend with it, a torque of its own.

The states are held against a rig that integrates.
"""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from tendon_cli.model import actuator
from tendon_cli.model.actuator import State
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import Design, Limb, Posture, Side
from tendon_cli.model.kinematics import Excursion, Spline
from tendon_cli.model.motor import motor_rates
from tendon_cli.model.statics import NO_EQUILIBRIUM, TAUT
from tests.sampled import quick_and_torture

from . import rig
from .designs import BOTH_DIRECTIONS, baseline, design, stored_energy, window_of

STEP = 5e-3
"""Step of differences of sixth order, rad."""

REACH = 3
"""Steps that these differences reach to either side."""


def tabled(function, low=0.0, high=1.9, beyond=0.1):
    """Return the spline through a function's table of 400 rows that reaches beyond the motion."""
    angles = np.linspace(low - beyond, high + beyond, 400)
    spline = CubicSpline(angles, function(angles))
    return Spline(spline.x, spline.c)


class Exact(Spline):
    """A function in the place of a curve.

    Its slope is found by a complex step, the slope of that by differences.
    """

    coefficients = np.zeros((4, 1))

    def __init__(self, function):
        self.function = function

    def __call__(self, angle, derivative=0):
        angle = np.asarray(angle)
        if derivative == 0:
            return self.function(angle) + 0.0 * angle
        if derivative == 1:
            return self.function(angle + 1e-30j).imag / 1e-30 + 0.0 * angle
        return rig.derivative(lambda t: self(t, 1), angle, STEP)


FIRST = (
    lambda t: 0.035 * t - 0.04 / 0.9 * np.cos(0.9 * t),
    lambda t: 0.028 * t + 0.008 / 1.3 * np.sin(1.3 * t - 0.4),
)
SECOND = (
    lambda t: 0.05 * t - 0.006 * t**2,
    lambda t: 0.02 * t + 0.0075 * t**2,
)


def passive(angle):
    return 9.0 * np.sin(angle) - 1.5 * (angle - 0.9) + 0.6 * np.exp(2.0 * (angle - 1.6))


def following(angle):
    return 2.4 + 0.7 * angle


def suit_of_the_checks(travels, torque, bend, curve=Exact, start=0.3, pretension=0.0):
    """Return the suit of Section 15: mu 0.12, L 1.4 m, K 6 and 9 kN/m, eta 0.55, R_f 25 mm."""
    bend_angle = curve(bend) if callable(bend) else bend
    flexor = Side(0.12, bend_angle, 1.4, 1.5e-3, 145e9, 6e3, pretension)
    extensor = replace(flexor, spring_stiffness=9e3)
    flexor_travel, extensor_travel = travels
    joint = Excursion(curve(flexor_travel), curve(extensor_travel), start)
    limb = Limb(joint, 0.0, 0.0, 0.0, 0.0, torque=curve(torque))
    return Design(limb, flexor, extensor, 0.025, 0.55, 0.0, setting=Posture(start))


def window_from_0_to(last, count, suit):
    """Return the window of a suit over angles from 0 to the last, rad."""
    angles = np.linspace(0.0, last, count)[np.newaxis]
    return window_of(suit, angles, BOTH_DIRECTIONS, Bounds())


def test_the_state_and_the_window_of_a_joint_whose_arms_both_change():
    suit = suit_of_the_checks(FIRST, passive, following, pretension=140.0)
    state = actuator.evaluate(suit, 0.9, True)
    assert float(state.balance.flexor) == pytest.approx(181.516858512, rel=1e-10)
    assert float(state.balance.extensor) == pytest.approx(130.811298850, rel=1e-10)
    assert float(state.elbow_stiffness) == pytest.approx(32.426351369, rel=1e-9)
    for curve, share in ((Exact, 1e-10), (tabled, 2e-6), (partial(tabled, beyond=0.0), 2e-5)):
        ends = window_from_0_to(1.9, 20, suit_of_the_checks(FIRST, passive, following, curve))
        assert float(ends.low) == pytest.approx(84.654056308, rel=share)
        assert float(ends.high) == pytest.approx(777.431276238, rel=share)


def test_stiffness_may_bound_pretension_from_below():
    suit = suit_of_the_checks(SECOND, lambda t: 22.0 + 19.0 * np.cos(1.8 * t), 2.4)
    ends = window_from_0_to(1.6, 9, suit)
    assert float(ends.low) == pytest.approx(572.162102383, abs=2e-5)
    assert np.isinf(ends.high)


def test_the_papers_arm_as_a_table_of_its_own_excursions():
    suit = design(baseline(load_mass=5.0, pretension=180.0, ratio=0.6, from_initial=True))
    table_angles = np.linspace(-0.2, np.pi / 2 + 0.2, 1200)
    motion = suit.arm.joint.motion(table_angles)
    flexor = CubicSpline(table_angles, motion.flexor_travel)
    extensor = CubicSpline(table_angles, motion.extensor_travel)
    table = Excursion(Spline(flexor.x, flexor.c), Spline(extensor.x, extensor.c))
    with_table = replace(suit, arm=replace(suit.arm, joint=table))
    angles = np.linspace(0.0, np.pi / 2, 37)[np.newaxis]
    columns = State.columns(actuator.evaluate(with_table, angles, BOTH_DIRECTIONS))
    for name, expected in State.columns(actuator.evaluate(suit, angles, BOTH_DIRECTIONS)).items():
        values = columns[name]
        near = 1e-6 * np.nanmax(np.abs(expected))
        np.testing.assert_allclose(values, expected + 0.0 * values, atol=near, err_msg=name)


# --- Random joints against the rig ----------------------------------------------------------------


def random_suit(seed, *, at_motor):
    """Return a suit drawn at random, by functions, at 300 N."""
    rng = np.random.default_rng(seed)
    a = rng.uniform(0.02, 0.05)
    b = rng.uniform(-0.01, 0.01)
    c = rng.uniform(0.015, 0.04)
    d = rng.uniform(-0.006, 0.006)
    start = rng.uniform(0.0, 0.6)
    slope = rng.uniform(-2.0, 2.0)
    swing = rng.uniform(2.0, 12.0)
    turned = rng.uniform(-0.8, 0.8)
    flexor_travel = Exact(lambda t: a * t + b * np.sin(1.1 * t))
    extensor_travel = Exact(lambda t: c * t + d * np.sin(0.8 * t + 0.5))
    joint = Excursion(flexor_travel, extensor_travel, start)

    def random_side():
        return Side(
            friction=rng.uniform(0.02, 0.2),
            bend_angle=Exact(lambda t: 2.6 + turned * t),
            length=rng.uniform(0.5, 2.0),
            diameter=1.5e-3,
            youngs_modulus=145e9,
            spring_stiffness=rng.uniform(2e3, 12e3),
            pretension=300.0,
            anchor_stiffness=rng.choice([np.inf, 2e4, 6e3]),
            spring_at_motor=at_motor,
        )

    flexor = random_side()
    extensor = random_side()
    torque = Exact(lambda t: swing * np.sin(t) + slope * (t - 0.4))
    limb = Limb(joint, 0.0, 0.0, 0.0, 0.0, torque=torque)
    ratio = rng.uniform(0.5, 1.1)
    setting = Posture(start)
    return Design(limb, flexor, extensor, 0.03, ratio, 0.0, unilateral=False, setting=setting)


@dataclass
class Bench:
    """A suit in one direction at an angle, its spool turned until the joint balances, then held."""

    suit: Design
    angle: float
    flexion: bool

    def __post_init__(self):
        """Walk along both sheaths at the angle, some steps away from it, and at the setting."""
        angles = self.angle + STEP * np.arange(-REACH, REACH + 1)
        resting_angle = np.array([self.suit.setting.angle])
        self.gains = {}
        self.compliances = {}
        self.resting_compliances = {}
        for side in rig.SIDES:
            self.gains[side], self.compliances[side] = self._walk(side, angles)
            _, self.resting_compliances[side] = self._walk(side, resting_angle)

    def _walk(self, name, angles):
        """Return proximal over distal tension, and the compliance per distal newton."""
        side = getattr(self.suit, name)
        toward_elbow = self.flexion if name == "extensor" else not self.flexion
        gain, mean = rig.walk_along_sheath(
            side.friction, side.bend_angle.function(angles), np.full(len(angles), toward_elbow)
        )
        rope = mean * side.length / (np.pi * (side.diameter / 2) ** 2 * side.youngs_modulus)
        spring = (gain if side.spring_at_motor else 1.0) / side.spring_stiffness
        return gain, rope + spring + 1.0 / side.anchor_stiffness

    def tensions(self, step, turn, pretension):
        """Return the distal tensions some steps of angle away, at a turn of the spool."""
        suit = self.suit
        joint = suit.arm.joint
        angle = self.angle + STEP * step
        flexor_travel = joint.flexor.function(angle) - joint.flexor.function(joint.origin)
        extensor_travel = joint.extensor.function(angle) - joint.extensor.function(joint.origin)
        at_rest = {side: self.resting_compliances[side][0] * pretension for side in rig.SIDES}
        wound = suit.flexor_radius * turn
        flexor_stretch = at_rest["flexor"] + wound - flexor_travel
        extensor_stretch = at_rest["extensor"] + extensor_travel - suit.ratio * wound
        place = REACH + step
        flexor = flexor_stretch / self.compliances["flexor"][place]
        extensor = extensor_stretch / self.compliances["extensor"][place]
        return flexor, extensor

    def proximal(self, flexor, extensor):
        """Return the tensions at the motor."""
        return self.gains["flexor"][REACH] * flexor, self.gains["extensor"][REACH] * extensor

    def needed(self, step, turn, pretension):
        """Return the torque that the joint asks for beyond the moments of both tendons."""
        flexor, extensor = self.tensions(step, turn, pretension)
        angle = self.angle + STEP * step
        arm = self.suit.arm
        flexor_arm = rig.derivative(arm.joint.flexor.function, angle, STEP)
        extensor_arm = rig.derivative(arm.joint.extensor.function, angle, STEP)
        return arm.torque.function(angle) - flexor_arm * flexor + extensor_arm * extensor

    def read(self, pretension):
        """Return both tensions, the turn of the spool, and the stiffness with it held."""
        turn = rig.find_root(lambda turn: self.needed(0, turn, pretension), -1e3, 1e3)
        per_step = rig.derivative(lambda step: self.needed(step, turn, pretension), 0, 1)
        return *self.tensions(0, turn, pretension), turn, per_step / STEP


@pytest.mark.parametrize("at_motor", [False, True])
@pytest.mark.parametrize("flexion", [True, False])
@pytest.mark.parametrize("seed", quick_and_torture(range(5), range(5, 12)))
def test_random_joints_settle_as_on_the_rig(seed, flexion, at_motor):
    suit = random_suit(seed, at_motor=at_motor)
    for angle in (0.2, 0.9, 1.5):
        bench = Bench(suit, angle, flexion)
        flexor, extensor, turn, stiffness = bench.read(300.0)
        flexor_proximal, extensor_proximal = bench.proximal(flexor, extensor)
        torque = suit.flexor_radius * (flexor_proximal - suit.ratio * extensor_proximal)
        state = actuator.evaluate(suit, angle, flexion)
        size = max(abs(flexor), abs(extensor), 300.0)
        near = 1e-8 * size
        assert float(state.balance.flexor) == pytest.approx(flexor, abs=near)
        assert float(state.balance.extensor) == pytest.approx(extensor, abs=near)
        assert float(state.elbow_stiffness) == pytest.approx(stiffness, rel=1e-7, abs=1e-7 * size)
        assert float(state.flexor_tension_proximal) == pytest.approx(flexor_proximal, abs=near)
        assert float(state.spool_angle) == pytest.approx(turn, abs=1e-8)
        assert float(state.motor_torque) == pytest.approx(torque, abs=near * suit.flexor_radius)


@pytest.mark.parametrize("at_motor", [False, True])
@pytest.mark.parametrize("flexion", [True, False])
@pytest.mark.parametrize("seed", range(6))
def test_energy_closes_as_a_joint_moves(seed, flexion, at_motor):
    """Along a motion τ_m dα = τ dθ + dU + dW at every angle, the loss by friction's own work.

    dα/dθ and dU/dθ are slopes.
    """
    suit = random_suit(seed, at_motor=at_motor)
    angles = np.linspace(0.1, 1.5, 29)

    def shifted(shift):
        return actuator.evaluate(suit, angles + shift, flexion)

    def turn(shift):
        return motor_rates(shifted(shift)).spool_angle

    def stored(shift):
        return stored_energy(shifted(shift))

    state = shifted(0.0)
    rates = motor_rates(state)
    assert (state.status == TAUT).mean() > 0.5
    taken = state.elbow_torque + rates.storage_rate + rates.friction
    np.testing.assert_allclose(rates.power, taken, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(rates.spool_speed, rig.derivative(turn, 0.0), rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(
        rates.storage_rate, rig.derivative(stored, 0.0), rtol=1e-6, atol=1e-5
    )
    sign = 1.0 if flexion else -1.0
    assert (rates.friction * sign > 0.0).mean() > 0.9


@pytest.mark.parametrize("falling", [0, 1])
def test_a_joint_that_does_not_rise_has_no_equilibrium(falling):
    travels = [lambda t: 0.03 * t, lambda t: 0.03 * t]
    travels[falling] = lambda t: 0.03 * np.sin(2.0 * t)
    suit = suit_of_the_checks(travels, np.sin, 2.4, tabled, 0.0, pretension=100.0)
    status = actuator.evaluate(suit, np.array([0.3, 1.2]), True).status
    assert (status == NO_EQUILIBRIUM).tolist() == [False, True]
