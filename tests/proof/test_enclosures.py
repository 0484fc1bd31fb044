"""Proofs by intervals enclose what they say, hold where nothing is broken, and find what is."""

from dataclasses import replace

import numpy as np
import pytest

from tendon_cli.model.actuator import evaluate
from tendon_cli.model.kinematics import Spline
from tendon_cli.model.motor import select_points
from tendon_cli.proof import enclosed_states
from tendon_cli.proof.series import COMPUTED, Series
from tests.model import rationals
from tests.model.designs import SIDES, baseline, design

RNG = np.random.default_rng(3)
FUNCTIONS = {
    "product": lambda t: t * t * t - 2.0 * t,
    "quotient": lambda t: (t + 2.0) / (t * t + 1.0),
    "root": lambda t: np.sqrt(t * t + 0.3),
    "exp": lambda t: np.exp(t * -0.7),
    "circular": lambda t: np.sin(t * 2.0) * np.cos(t),
    "elongation": lambda t: (t * t - 0.2).elongation(),
    "larger": lambda t: np.maximum(1.0, np.exp(t) + 1.0),
}
PLAIN = FUNCTIONS | {
    "elongation": lambda t: np.expm1(t * t - 0.2) / (t * t - 0.2),
    "larger": lambda t: np.exp(t) + 1.0,
}
"""The same functions for complex numbers."""


def taylor_coefficients(function, points, count, radius=0.05):
    """Return Taylor coefficients (count, points) by Cauchy's formula: no derivative of ours."""
    turns = np.exp(2j * np.pi * np.arange(32) / 32)[:, np.newaxis]
    around = function(points + radius * turns)  # (turns, points)
    orders = range(count)
    return [np.mean(around * turns**-order, axis=0).real / radius**order for order in orders]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_series_encloses_the_function_and_its_derivatives_over_each_cell(name):
    middle = RNG.uniform(-1.0, 1.5, 200)
    half = 10.0 ** RNG.uniform(-6.0, -0.7, 200)
    terms = FUNCTIONS[name](Series.variable(middle, half, 4)).terms
    for share in (-1.0, -0.3, 0.0, 0.8, 1.0):
        coefficients = taylor_coefficients(PLAIN[name], middle + share * half, len(terms))
        for order, (term, expected) in enumerate(zip(terms, coefficients, strict=True)):
            value, radius = term or (0.0, 0.0)
            rounding = 1e-12 / 0.05**order
            assert (np.abs(expected - value) <= radius + rounding).all(), order


def test_a_number_of_a_box_encloses_its_interval():
    middle, radius = Series.number(np.array([3.0]), np.array([0.5]), np.array([1.0]), 0).value
    assert middle - radius <= 2.5
    assert middle + radius >= 3.5


def test_what_may_be_divided_by_zero_has_no_bound():
    with np.errstate(invalid="ignore"):
        terms = (1.0 / Series.variable(np.array([0.1]), np.array(0.2), 2)).terms
    assert not np.isfinite(terms[0][1]).any()


# --- States ---------------------------------------------------------------------------------------


def random_numbers(rng, count):
    """Return numbers of random designs, (count, 1, 1), as `designs.baseline` takes them."""

    def drawn(low, high):
        return rng.uniform(low, high, (count, 1, 1))

    return baseline(
        a1=drawn(0.03, 0.05),
        b1=drawn(0.13, 0.17),
        a2=drawn(0.01, 0.03),
        b2=drawn(0.13, 0.17),
        elbow_radius=drawn(0.035, 0.05),
        upper_arm_angle=drawn(-0.3, 0.5),
        friction=drawn(0.0, 0.2),
        spring_stiffness=drawn(1e3, 9e3),
        ratio=drawn(0.4, 1.0),
        load_mass=drawn(0.0, 10.0),
    )


def bending(made, rng):
    """Return a design whose flexor's sheath bends with the joint, which has a torque of its own."""
    knots = np.linspace(0.0, 2.5, 6)
    bend = Spline(knots, np.array([0.0, 0.0, 0.6, 2.4])[:, np.newaxis] + 0.0 * knots[:-1])
    bend.coefficients[3] = 2.4 + 0.6 * knots[:-1]
    torque = Spline(np.array([0.0, 2.5]), rng.normal(size=(4, 1)))
    arm = replace(made.arm, torque=torque)
    return replace(made, arm=arm, flexor=replace(made.flexor, bend_angle=bend))


@pytest.mark.parametrize("kind", ["plain", "bending"])
def test_states_over_cells_hold_the_models_own(kind):
    rng = np.random.default_rng(5)
    count = 60
    made = design(random_numbers(rng, count))
    if kind == "bending":
        made = bending(made, rng)
    flat = select_points(made, (count, 1, 1), (np.arange(count), 0, 0))
    middle = rng.uniform(0.1, 2.0, count)
    half = 10.0 ** rng.uniform(-4.0, -1.5, count)
    flexion = rng.random(count) < 0.5
    pretension = rng.uniform(50.0, 300.0, count)
    if kind == "bending":  # one piece of each curve
        middle = 0.25 + 0.5 * np.floor(middle / 0.5)
    sides = {side: replace(getattr(flat, side), pretension=pretension) for side in SIDES}
    taut = replace(flat, unilateral=False, **sides)
    over_cells = enclosed_states.enclose_states(flat, middle, half, flexion, pretension, 4)
    for share in (-1.0, 0.0, 0.6, 1.0):
        state = evaluate(taut, middle + share * half, flexion)
        for series, expected in (
            (over_cells.x, state.balance.flexor),
            (over_cells.y, state.balance.extensor),
            (over_cells.stiffness, state.elbow_stiffness),
        ):
            value, radius = series.terms[0]
            assert (np.abs(expected - value) <= radius + 1e-9 * np.abs(value)).all()


# --- Against exact rationals ----------------------------------------------------------------------


def random_states(seed, count):
    """Yield flat numbers of random designs, each with an angle, a direction and a pretension."""
    rng = np.random.default_rng(seed)
    shape = (count, 1, 1)
    columns = {
        name: np.broadcast_to(values, shape).ravel()
        for name, values in random_numbers(rng, count).items()
    }
    for i in range(count):
        p = {name: float(values[i]) for name, values in columns.items()}
        angle = rng.uniform(0.0, 2.2)
        flexion = bool(rng.random() < 0.5)
        pretension = rng.uniform(30.0, 300.0)
        yield p, angle, flexion, pretension


def enclosed_at(p, angle, flexion, pretension):
    """Return value and radius of x, y, stiffness and the motor's torque at one angle."""
    made = design({name: np.array([value]) for name, value in p.items()})
    state = enclosed_states.enclose_states(
        made, np.array([angle]), np.zeros(()), np.array([flexion]), np.array([pretension]), 3
    )
    flexor_arm, extensor_arm = (Series.of(arm, COMPUTED) for arm in state.motor_arms)
    motor = flexor_arm * state.x - extensor_arm * state.y
    series = {"x": state.x, "y": state.y, "stiffness": state.stiffness, "motor": motor}
    enclosures = {}
    for name, quantity in series.items():
        value, radius = quantity.terms[0]
        enclosures[name] = float(np.ravel(value)[0]), float(np.ravel(radius)[0])
    return enclosures


def count_missed(states):
    """Return the number of quantities of states that are outside their enclosure."""
    missed = 0
    for state in states:
        exact = rationals.state(*state)
        for name, (value, radius) in enclosed_at(*state).items():
            assert radius < 1e-9 * (abs(value) + 300.0)
            missed += not exact[name].holds(value, radius)
    return missed


def test_states_are_enclosed_as_exact_rationals_have_them():
    assert count_missed(random_states(1, 40)) == 0


@pytest.mark.torture
def test_two_thousand_states_are_enclosed_as_exact_rationals_have_them():
    assert count_missed(random_states(2, 2000)) == 0


def changed_torque(real):
    return lambda made, angle: real(made, angle) * (1.0 + 1e-9)


def changed_travels(real):
    def travels(joint, angle):
        path, flexor, extensor = real(joint, angle)
        return path, flexor * (1.0 + 1e-9), extensor

    return travels


def turned_sheaths(real):
    return lambda flexor, extensor, angle, flexion: real(flexor, extensor, angle, ~flexion)


def softer_sheaths(real):
    def sheaths(*inputs):
        flexor, extensor = real(*inputs)
        return replace(flexor, spring=flexor.spring * (1.0 + 1e-9)), extensor

    return sheaths


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("_torque", changed_torque),
        ("_travels", changed_travels),
        ("sheaths_of", turned_sheaths),
        ("sheaths_of", softer_sheaths),
    ],
)
def test_a_fault_of_a_billionth_is_noticed(monkeypatch, name, change):
    monkeypatch.setattr(enclosed_states, name, change(getattr(enclosed_states, name)))
    assert count_missed(random_states(3, 6)) > 0
