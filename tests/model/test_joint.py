"""Any joint: travels from curves, sheaths that bend with it, a torque of its own; against a rig that integrates."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from tendon_cli.model import actuator, window
from tendon_cli.model.actuator import State
from tendon_cli.model.bounds import Bounds
from tendon_cli.model.design import Design, Limb, Posture, Side
from tendon_cli.model.kinematics import Excursion, Spline, Travels
from tendon_cli.model.motor import motor_rates
from tendon_cli.model.statics import NO_EQUILIBRIUM, TAUT

from . import rig
from .designs import baseline, design

BOTH = np.array([[True], [False]])


def curve(function, low, high, rows=400, beyond=0.1):
    """A function as a table that reaches beyond the motion, and the spline through it."""
    angles = np.linspace(low - beyond, high + beyond, rows)
    found = CubicSpline(angles, function(angles))
    return Spline(found.x, found.c)


class Exact(Spline):
    """A function with its derivatives, in the place of a curve."""

    def __init__(self, *functions):
        self.functions = functions

    def __call__(self, angle, derivative=0):
        return self.functions[derivative](np.asarray(angle)) + 0.0 * np.asarray(angle)


@dataclass(frozen=True)
class ExactJoint:
    """Travels by functions with two derivatives."""

    flexor: Exact
    extensor: Exact
    start: float
    strap_radius: float = np.nan

    def motion(self, angle):
        travels = [each(angle) - each(self.start) for each in (self.flexor, self.extensor)]
        arms = [each(angle, 1) for each in (self.flexor, self.extensor)]
        slopes = [each(angle, 2) for each in (self.flexor, self.extensor)]
        return Travels(*travels, *arms, *slopes, pulling_arm=arms[0])


@dataclass(frozen=True)
class Joint:
    """Travels of the checks in closed form, both zero at `start`."""

    shortens: object
    lengthens: object
    start: float = 0.3

    def excursion(self, low, high, **how):
        return Excursion(curve(self.shortens, low, high, **how), curve(self.lengthens, low, high, **how), self.start)


FIRST = Joint(
    lambda t: 0.035 * t - 0.04 / 0.9 * np.cos(0.9 * t),
    lambda t: 0.028 * t + 0.008 / 1.3 * np.sin(1.3 * t - 0.4),
)
SECOND = Joint(lambda t: 0.05 * t - 0.006 * t**2, lambda t: 0.02 * t + 0.0075 * t**2)


def passive(angle):
    return 9.0 * np.sin(angle) - 1.5 * (angle - 0.9) + 0.6 * np.exp(2.0 * (angle - 1.6))


def of_the_checks(joint, torque, bend, low, high, pretension=0.0, **how):
    """Section 15's suit on a joint: mu 0.12, L 1.4 m, K 6 and 9 kN/m, eta 0.55, R_f 25 mm."""
    flexor, extensor = (Side(0.12, bend, 1.4, 1.5e-3, 145e9, stiffness, pretension) for stiffness in (6e3, 9e3))
    limb = Limb(joint.excursion(low, high, **how), 0.0, 0.0, 0.0, 0.0, torque=curve(torque, low, high, **how))
    return Design(limb, flexor, extensor, 0.025, 0.55, 0.0, setting=Posture(joint.start))


PASSIVE = Exact(
    passive, lambda t: 9.0 * np.cos(t) - 1.5 + 1.2 * np.exp(2.0 * (t - 1.6)),
)  # fmt: skip
FIRST_EXACT = ExactJoint(
    Exact(FIRST.shortens, lambda t: 0.035 + 0.04 * np.sin(0.9 * t), lambda t: 0.036 * np.cos(0.9 * t)),
    Exact(FIRST.lengthens, lambda t: 0.028 + 0.008 * np.cos(1.3 * t - 0.4), lambda t: -0.0104 * np.sin(1.3 * t - 0.4)),
    0.3,
)


def exactly():
    """The first check of section 15 without any table."""
    bend = Exact(lambda t: 2.4 + 0.7 * t, lambda t: 0.7 + 0.0 * t)
    made = of_the_checks(FIRST, passive, bend, 0.0, 1.9)
    return replace(made, arm=replace(made.arm, joint=FIRST_EXACT, torque=PASSIVE))


def window_of(made):
    found = window.window(made, np.linspace(0.0, 1.9, 20)[np.newaxis], BOTH, Bounds())
    return float(found.low), float(found.high)


def test_the_state_and_the_window_of_a_joint_whose_arms_both_change():
    bend = curve(lambda t: 2.4 + 0.7 * t, 0.0, 1.9)
    made = of_the_checks(FIRST, passive, bend, 0.0, 1.9, pretension=140.0)
    state = actuator.evaluate(made, 0.9, True)
    assert float(state.balance.flexor) == pytest.approx(181.516858512, rel=1e-6)
    assert float(state.balance.extensor) == pytest.approx(130.811298850, rel=1e-6)
    assert float(state.elbow_stiffness) == pytest.approx(32.426351369, rel=1e-6)
    assert window_of(made) == pytest.approx((84.654056308, 777.431276238), rel=2e-6)
    assert window_of(exactly()) == pytest.approx((84.654056308, 777.431276238), rel=1e-11)
    just_covered = of_the_checks(FIRST, passive, bend, 0.0, 1.9, beyond=0.0)
    assert window_of(just_covered) == pytest.approx((84.654056308, 777.431276238), rel=2e-5)


def test_stiffness_may_bound_pretension_from_below():
    made = of_the_checks(SECOND, lambda t: 22.0 + 19.0 * np.cos(1.8 * t), 2.4, 0.0, 1.6)
    found = window.window(made, np.linspace(0.0, 1.6, 9)[np.newaxis], BOTH, Bounds())
    assert float(found.low) == pytest.approx(572.162102383, abs=2e-5)
    assert np.isinf(found.high)


def test_the_papers_arm_as_a_table_of_its_own_excursions():
    arm = design(baseline(load_mass=5.0, pretension=180.0, ratio=0.6, from_initial=True))
    angles = np.linspace(-0.2, np.pi / 2 + 0.2, 1200)
    moved = arm.arm.joint.motion(angles)
    splines = (CubicSpline(angles, values) for values in (moved.flexor_travel, moved.extensor_travel))
    table = Excursion(*(Spline(each.x, each.c) for each in splines))
    tabled = replace(arm, arm=replace(arm.arm, joint=table))
    at = np.linspace(0.0, np.pi / 2, 37)[np.newaxis]
    for name, expected in State.columns(actuator.evaluate(arm, at, BOTH)).items():
        found = State.columns(actuator.evaluate(tabled, at, BOTH))[name]
        np.testing.assert_allclose(found, expected + 0.0 * found, atol=1e-6 * np.nanmax(np.abs(expected)), err_msg=name)


# --- Random joints against the rig -----------------------------------------------------------------------------------


@dataclass
class Suit:
    """A suit drawn at random, in closed form for the rig and as the model's design."""

    joint: Joint
    torque: object
    bend: object
    made: Design
    spring_at_motor: bool


def suit(seed, *, at_motor):
    rng = np.random.default_rng(seed)
    a, b, c, d = rng.uniform(0.02, 0.05), rng.uniform(-0.01, 0.01), rng.uniform(0.015, 0.04), rng.uniform(-0.006, 0.006)
    joint = Joint(
        lambda t: a * t + b * np.sin(1.1 * t), lambda t: c * t + d * np.sin(0.8 * t + 0.5), float(rng.uniform(0.0, 0.6))
    )
    slope, swing = rng.uniform(-2.0, 2.0), rng.uniform(2.0, 12.0)

    def torque(t):
        return swing * np.sin(t) + slope * (t - 0.4)

    turned = rng.uniform(-0.8, 0.8)

    def bend(t):
        return 2.6 + turned * t

    sides = [
        Side(rng.uniform(0.02, 0.2), curve(bend, 0.0, 1.6), rng.uniform(0.5, 2.0), 1.5e-3, 145e9,
             rng.uniform(2e3, 12e3), 0.0, anchor_stiffness=rng.choice([np.inf, 2e4, 6e3]), spring_at_motor=at_motor)
        for _ in rig.SIDES
    ]  # fmt: skip
    limb = Limb(joint.excursion(0.0, 1.6), 0.0, 0.0, 0.0, 0.0, torque=curve(torque, 0.0, 1.6))
    made = Design(limb, *sides, 0.03, float(rng.uniform(0.5, 1.1)), 0.0, unilateral=False, setting=Posture(joint.start))
    return Suit(joint, torque, bend, made, at_motor)


STEP = 5e-3
"""rad, of differences of sixth order."""


@dataclass
class Bench:
    """A suit in one direction at an angle, its spool turned until the joint balances, and then held."""

    suit: Suit
    angle: float
    flexion: bool

    def __post_init__(self):
        steps = STEP * np.arange(-3, 4)
        (self.ends, self.gives), (_, self.resting) = (
            zip(*(self._sheath(name, angles) for name in rig.SIDES), strict=True)
            for angles in (self.angle + steps, np.array([self.suit.joint.start]))
        )

    def _sheath(self, name, angles):
        """By walking along it: proximal over distal tension, and all that gives, per distal newton."""
        side = getattr(self.suit.made, name)
        toward_elbow = self.flexion if name == "extensor" else not self.flexion
        gain, mean = rig.walk_along_sheath(side.friction, self.suit.bend(angles), np.full(len(angles), toward_elbow))
        rope = mean * side.length / (np.pi * (side.diameter / 2) ** 2 * side.youngs_modulus)
        spring = (gain if self.suit.spring_at_motor else 1.0) / side.spring_stiffness
        return gain, rope + spring + 1.0 / side.anchor_stiffness

    def tensions(self, step, turn, pretension):
        """Of both tendons some steps of angle away, at a turn of the spool."""
        made, joint, at = self.suit.made, self.suit.joint, self.angle + STEP * step
        h_f, h_e = (each(at) - each(joint.start) for each in (joint.shortens, joint.lengthens))
        stretch_f = self.resting[0][0] * pretension + made.flexor_radius * turn - h_f
        stretch_e = self.resting[1][0] * pretension + h_e - made.ratio * made.flexor_radius * turn
        return stretch_f / self.gives[0][3 + step], stretch_e / self.gives[1][3 + step]

    def left_over(self, step, turn, pretension):
        """What the joint asks for beyond the moments of both tendons."""
        x, y = self.tensions(step, turn, pretension)
        at, joint = self.angle + STEP * step, self.suit.joint
        arms = [rig.derivative(each, at, STEP) for each in (joint.shortens, joint.lengthens)]
        return self.suit.torque(at) - arms[0] * x + arms[1] * y

    def settle(self, pretension):
        """Both tensions, and the turn of the spool."""
        turn = brentq(lambda turn: self.left_over(0, turn, pretension), -1e3, 1e3, xtol=1e-300, rtol=1e-15, maxiter=500)
        return *self.tensions(0, turn, pretension), turn

    def read(self, pretension):
        """Both tensions, the turn of the spool, and the stiffness with it held."""
        x, y, turn = self.settle(pretension)
        weights = ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60))
        moved = {step: self.left_over(step, turn, pretension) for step in (-3, -2, -1, 1, 2, 3)}
        return x, y, turn, sum(w * (moved[n] - moved[-n]) for n, w in weights) / STEP


def derivatives_of(function, at, order):
    """The first by a complex step, the second by differences of that."""
    if order == 0:
        return function(at)
    if order == 1:
        return function(at + 1e-30j).imag / 1e-30
    return rig.derivative(lambda t: derivatives_of(function, t, 1), at, STEP)


def straight(bend):
    return Exact(bend, lambda _: bend(1.0) - bend(0.0))


def smooth(torque):
    return Exact(torque, lambda t: derivatives_of(torque, t, 1))


def exact(drawn):
    """The model's design of a suit without any table."""
    curves = [Exact(*(lambda t, f=f, n=n: derivatives_of(f, t, n) for n in range(3)))
              for f in (drawn.joint.shortens, drawn.joint.lengthens)]  # fmt: skip
    sides = {name: replace(getattr(drawn.made, name), bend_angle=straight(drawn.bend)) for name in rig.SIDES}
    limb = replace(drawn.made.arm, joint=ExactJoint(*curves, drawn.joint.start), torque=smooth(drawn.torque))
    return replace(drawn.made, arm=limb, **sides)


def held_at(made, pretension):
    sides = {name: replace(getattr(made, name), pretension=pretension) for name in rig.SIDES}
    return replace(made, **sides)


@pytest.mark.parametrize("at_motor", [False, True])
@pytest.mark.parametrize("flexion", [True, False])
@pytest.mark.parametrize("seed", range(12))
def test_random_joints_settle_as_on_the_rig(seed, flexion, at_motor):
    drawn, angles = suit(seed, at_motor=at_motor), (0.2, 0.9, 1.5)
    made = held_at(exact(drawn), 300.0)
    for angle in angles:
        bench = Bench(drawn, angle, flexion)
        x, y, turn, stiffness = bench.read(300.0)
        near_x, near_y = (tension * ends[3] for tension, ends in zip((x, y), bench.ends, strict=True))
        state = actuator.evaluate(made, angle, flexion)
        size = max(abs(x), abs(y), 300.0)
        assert float(state.balance.flexor) == pytest.approx(x, abs=1e-8 * size)
        assert float(state.balance.extensor) == pytest.approx(y, abs=1e-8 * size)
        assert float(state.elbow_stiffness) == pytest.approx(stiffness, rel=1e-7, abs=1e-7 * size)
        assert float(state.flexor_tension_proximal) == pytest.approx(near_x, abs=1e-8 * size)
        assert float(state.spool_angle) == pytest.approx(turn, abs=1e-8)
        needed = made.flexor_radius * (near_x - made.ratio * near_y)
        assert float(state.motor_torque) == pytest.approx(needed, abs=1e-8 * size * made.flexor_radius)


@pytest.mark.parametrize("at_motor", [False, True])
@pytest.mark.parametrize("flexion", [True, False])
@pytest.mark.parametrize("seed", range(6))
def test_energy_closes_as_a_joint_moves(seed, flexion, at_motor):
    """τ_m dα = τ dθ + dU + dW at every angle, the loss by friction's own work; and dα/dθ, dU/dθ are slopes."""
    made = held_at(suit(seed, at_motor=at_motor).made, 300.0)
    angles = np.linspace(0.1, 1.5, 29)

    def at(shift):
        state = actuator.evaluate(made, angles + shift, flexion)
        return state, motor_rates(state)

    state, rates = at(0.0)
    assert (state.status == TAUT).mean() > 0.5
    np.testing.assert_allclose(rates.power, state.elbow_torque + rates.storing + rates.friction, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(
        rates.spool_speed, rig.derivative(lambda s: at(s)[1].spool_angle, 0.0), rtol=1e-6, atol=1e-6
    )
    np.testing.assert_allclose(rates.storing, rig.derivative(lambda s: at(s)[1].stored, 0.0), rtol=1e-6, atol=1e-5)
    assert (rates.friction * (1.0 if flexion else -1.0) > 0.0).mean() > 0.9


def test_a_joint_that_does_not_rise_has_no_equilibrium():
    flat = Joint(lambda t: 0.03 * np.sin(2.0 * t), lambda t: 0.02 * t, 0.0)
    made = held_at(of_the_checks(flat, np.sin, 2.4, 0.0, 1.6), 100.0)
    state = actuator.evaluate(made, np.array([0.3, 1.2]), True)
    assert state.status.tolist()[1] == NO_EQUILIBRIUM
    assert state.status.tolist()[0] != NO_EQUILIBRIUM
    backward = Joint(lambda t: 0.03 * t, lambda t: 0.02 * np.sin(2.0 * t), 0.0)
    assert actuator.evaluate(of_the_checks(backward, np.sin, 2.4, 0.0, 1.6), 1.2, True).status == NO_EQUILIBRIUM
