"""Any joint: travels from curves, sheaths that bend with it, a torque of its own; against a rig that integrates."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from tendon_cli.model import actuator, window
from tendon_cli.model.actuator import State
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import Design, Limb, Posture, Side
from tendon_cli.model.kinematics import Excursion, Spline
from tendon_cli.model.motor import motor_rates
from tendon_cli.model.statics import NO_EQUILIBRIUM, TAUT

from . import rig
from .designs import baseline, design

BOTH = np.array([[True], [False]])
STEP = 5e-3
"""rad, of differences of sixth order."""


def tabled(function, low=0.0, high=1.9, beyond=0.1):
    """A function as a table of 400 rows that reaches beyond the motion, and the spline through it."""
    angles = np.linspace(low - beyond, high + beyond, 400)
    found = CubicSpline(angles, function(angles))
    return Spline(found.x, found.c)


class Exact(Spline):
    """A function in the place of a curve, its slope by a complex step, the slope of that by differences."""

    coefficients = np.zeros((4, 1))

    def __init__(self, function):
        self.function = function

    def __call__(self, angle, derivative=0):
        at = np.asarray(angle)
        if derivative == 0:
            return self.function(at) + 0.0 * at
        if derivative == 1:
            return self.function(at + 1e-30j).imag / 1e-30 + 0.0 * at
        return rig.derivative(lambda t: self(t, 1), at, STEP)


FIRST = (
    lambda t: 0.035 * t - 0.04 / 0.9 * np.cos(0.9 * t),
    lambda t: 0.028 * t + 0.008 / 1.3 * np.sin(1.3 * t - 0.4),
)
SECOND = lambda t: 0.05 * t - 0.006 * t**2, lambda t: 0.02 * t + 0.0075 * t**2


def passive(angle):
    return 9.0 * np.sin(angle) - 1.5 * (angle - 0.9) + 0.6 * np.exp(2.0 * (angle - 1.6))


def following(angle):
    return 2.4 + 0.7 * angle


def of_the_checks(travels, torque, bend, curve=Exact, start=0.3, pretension=0.0):
    """Section 15's suit on a joint: mu 0.12, L 1.4 m, K 6 and 9 kN/m, eta 0.55, R_f 25 mm."""
    bent = curve(bend) if callable(bend) else bend
    sides = (
        Side(0.12, bent, 1.4, 1.5e-3, 145e9, stiffness, pretension) for stiffness in (6e3, 9e3)
    )
    limb = Limb(Excursion(*map(curve, travels), start), 0.0, 0.0, 0.0, 0.0, torque=curve(torque))
    return Design(limb, *sides, 0.025, 0.55, 0.0, setting=Posture(start))


def window_of(made):
    found = window.window(made, np.linspace(0.0, 1.9, 20)[np.newaxis], BOTH, Bounds())
    return float(found.low), float(found.high)


def test_the_state_and_the_window_of_a_joint_whose_arms_both_change():
    state = actuator.evaluate(of_the_checks(FIRST, passive, following, pretension=140.0), 0.9, True)
    assert float(state.balance.flexor) == pytest.approx(181.516858512, rel=1e-10)
    assert float(state.balance.extensor) == pytest.approx(130.811298850, rel=1e-10)
    assert float(state.elbow_stiffness) == pytest.approx(32.426351369, rel=1e-9)
    for curve, share in ((Exact, 1e-10), (tabled, 2e-6), (partial(tabled, beyond=0.0), 2e-5)):
        found = window_of(of_the_checks(FIRST, passive, following, curve))
        assert found == pytest.approx((84.654056308, 777.431276238), rel=share)


def test_stiffness_may_bound_pretension_from_below():
    made = of_the_checks(SECOND, lambda t: 22.0 + 19.0 * np.cos(1.8 * t), 2.4)
    found = window.window(made, np.linspace(0.0, 1.6, 9)[np.newaxis], BOTH, Bounds())
    assert float(found.low) == pytest.approx(572.162102383, abs=2e-5)
    assert np.isinf(found.high)


def test_the_papers_arm_as_a_table_of_its_own_excursions():
    arm = design(baseline(load_mass=5.0, pretension=180.0, ratio=0.6, from_initial=True))
    angles = np.linspace(-0.2, np.pi / 2 + 0.2, 1200)
    moved = arm.arm.joint.motion(angles)
    splines = (
        CubicSpline(angles, values) for values in (moved.flexor_travel, moved.extensor_travel)
    )
    table = Excursion(*(Spline(each.x, each.c) for each in splines))
    of_table = replace(arm, arm=replace(arm.arm, joint=table))
    at = np.linspace(0.0, np.pi / 2, 37)[np.newaxis]
    for name, expected in State.columns(actuator.evaluate(arm, at, BOTH)).items():
        found = State.columns(actuator.evaluate(of_table, at, BOTH))[name]
        np.testing.assert_allclose(
            found, expected + 0.0 * found, atol=1e-6 * np.nanmax(np.abs(expected)), err_msg=name
        )


# --- Random joints against the rig ----------------------------------------------------------------


def suit(seed, *, at_motor):
    """A suit drawn at random, by functions, at 300 N."""
    rng = np.random.default_rng(seed)
    a, b, c, d = (
        rng.uniform(0.02, 0.05),
        rng.uniform(-0.01, 0.01),
        rng.uniform(0.015, 0.04),
        rng.uniform(-0.006, 0.006),
    )
    start, slope, swing = rng.uniform(0.0, 0.6), rng.uniform(-2.0, 2.0), rng.uniform(2.0, 12.0)
    turned = rng.uniform(-0.8, 0.8)
    joint = Excursion(
        Exact(lambda t: a * t + b * np.sin(1.1 * t)),
        Exact(lambda t: c * t + d * np.sin(0.8 * t + 0.5)),
        start,
    )
    sides = [
        Side(
            rng.uniform(0.02, 0.2),
            Exact(lambda t: 2.6 + turned * t),
            rng.uniform(0.5, 2.0),
            1.5e-3,
            145e9,
            rng.uniform(2e3, 12e3),
            300.0,
            anchor_stiffness=rng.choice([np.inf, 2e4, 6e3]),
            spring_at_motor=at_motor,
        )
        for _ in rig.SIDES
    ]
    limb = Limb(
        joint, 0.0, 0.0, 0.0, 0.0, torque=Exact(lambda t: swing * np.sin(t) + slope * (t - 0.4))
    )
    return Design(
        limb, *sides, 0.03, rng.uniform(0.5, 1.1), 0.0, unilateral=False, setting=Posture(start)
    )


@dataclass
class Bench:
    """A suit in one direction at an angle, its spool turned until the joint balances, and then held."""

    made: Design
    angle: float
    flexion: bool

    def __post_init__(self):
        steps = STEP * np.arange(-3, 4)
        (self.ends, self.gives), (_, self.resting) = (
            zip(*(self._sheath(name, angles) for name in rig.SIDES), strict=True)
            for angles in (self.angle + steps, np.array([self.made.setting.angle]))
        )

    def _sheath(self, name, angles):
        """By walking along it: proximal over distal tension, and all that gives, per distal newton."""
        side = getattr(self.made, name)
        toward_elbow = self.flexion if name == "extensor" else not self.flexion
        gain, mean = rig.walk_along_sheath(
            side.friction, side.bend_angle.function(angles), np.full(len(angles), toward_elbow)
        )
        rope = mean * side.length / (np.pi * (side.diameter / 2) ** 2 * side.youngs_modulus)
        spring = (gain if side.spring_at_motor else 1.0) / side.spring_stiffness
        return gain, rope + spring + 1.0 / side.anchor_stiffness

    def tensions(self, step, turn, pretension):
        """Of both tendons some steps of angle away, at a turn of the spool."""
        made, joint, at = self.made, self.made.arm.joint, self.angle + STEP * step
        h_f, h_e = (
            each.function(at) - each.function(joint.origin)
            for each in (joint.flexor, joint.extensor)
        )
        stretch_f = self.resting[0][0] * pretension + made.flexor_radius * turn - h_f
        stretch_e = self.resting[1][0] * pretension + h_e - made.ratio * made.flexor_radius * turn
        return stretch_f / self.gives[0][3 + step], stretch_e / self.gives[1][3 + step]

    def left_over(self, step, turn, pretension):
        """What the joint asks for beyond the moments of both tendons."""
        x, y = self.tensions(step, turn, pretension)
        at, arm = self.angle + STEP * step, self.made.arm
        arms = [
            rig.derivative(each.function, at, STEP)
            for each in (arm.joint.flexor, arm.joint.extensor)
        ]
        return arm.torque.function(at) - arms[0] * x + arms[1] * y

    def read(self, pretension):
        """Both tensions, the turn of the spool, and the stiffness with it held."""
        turn = brentq(
            lambda turn: self.left_over(0, turn, pretension),
            -1e3,
            1e3,
            xtol=1e-300,
            rtol=1e-15,
            maxiter=500,
        )
        weights = ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60))
        moved = {step: self.left_over(step, turn, pretension) for step in (-3, -2, -1, 1, 2, 3)}
        return (
            *self.tensions(0, turn, pretension),
            turn,
            sum(w * (moved[n] - moved[-n]) for n, w in weights) / STEP,
        )


@pytest.mark.parametrize("at_motor", [False, True])
@pytest.mark.parametrize("flexion", [True, False])
@pytest.mark.parametrize("seed", range(12))
def test_random_joints_settle_as_on_the_rig(seed, flexion, at_motor):
    made = suit(seed, at_motor=at_motor)
    for angle in (0.2, 0.9, 1.5):
        bench = Bench(made, angle, flexion)
        x, y, turn, stiffness = bench.read(300.0)
        near_x, near_y = (
            tension * ends[3] for tension, ends in zip((x, y), bench.ends, strict=True)
        )
        state = actuator.evaluate(made, angle, flexion)
        size = max(abs(x), abs(y), 300.0)
        assert float(state.balance.flexor) == pytest.approx(x, abs=1e-8 * size)
        assert float(state.balance.extensor) == pytest.approx(y, abs=1e-8 * size)
        assert float(state.elbow_stiffness) == pytest.approx(stiffness, rel=1e-7, abs=1e-7 * size)
        assert float(state.flexor_tension_proximal) == pytest.approx(near_x, abs=1e-8 * size)
        assert float(state.spool_angle) == pytest.approx(turn, abs=1e-8)
        needed = made.flexor_radius * (near_x - made.ratio * near_y)
        assert float(state.motor_torque) == pytest.approx(
            needed, abs=1e-8 * size * made.flexor_radius
        )


@pytest.mark.parametrize("at_motor", [False, True])
@pytest.mark.parametrize("flexion", [True, False])
@pytest.mark.parametrize("seed", range(6))
def test_energy_closes_as_a_joint_moves(seed, flexion, at_motor):
    """τ_m dα = τ dθ + dU + dW at every angle, the loss by friction's own work; and dα/dθ, dU/dθ are slopes."""
    made = suit(seed, at_motor=at_motor)
    angles = np.linspace(0.1, 1.5, 29)

    def at(shift):
        state = actuator.evaluate(made, angles + shift, flexion)
        return state, motor_rates(state)

    state, rates = at(0.0)
    assert (state.status == TAUT).mean() > 0.5
    np.testing.assert_allclose(
        rates.power, state.elbow_torque + rates.storing + rates.friction, rtol=1e-9, atol=1e-9
    )
    np.testing.assert_allclose(
        rates.spool_speed, rig.derivative(lambda s: at(s)[1].spool_angle, 0.0), rtol=1e-6, atol=1e-6
    )
    np.testing.assert_allclose(
        rates.storing, rig.derivative(lambda s: at(s)[1].stored, 0.0), rtol=1e-6, atol=1e-5
    )
    assert (rates.friction * (1.0 if flexion else -1.0) > 0.0).mean() > 0.9


@pytest.mark.parametrize("falling", [0, 1])
def test_a_joint_that_does_not_rise_has_no_equilibrium(falling):
    travels = [lambda t: 0.03 * t, lambda t: 0.03 * t]
    travels[falling] = lambda t: 0.03 * np.sin(2.0 * t)
    made = of_the_checks(travels, np.sin, 2.4, tabled, 0.0, pretension=100.0)
    status = actuator.evaluate(made, np.array([0.3, 1.2]), True).status
    assert (status == NO_EQUILIBRIUM).tolist() == [False, True]
