"""The window of pretension against bisection on the model, which the independent rig holds to."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tendon_cli.model import actuator, extremes, limits
from tendon_cli.model.bounds import Bounds, limit_end
from tendon_cli.model.limits import LIMIT_NAMES, NOTHING
from tendon_cli.model.motor import motor_rates

from .designs import BOTH_DIRECTIONS, SIDES, baseline, design, window_of, worn

ANGLES = np.radians(np.arange(91.0))[np.newaxis]
MAX_TENSION = LIMIT_NAMES.index("max_tension")
LOADS = np.array([0.0, 3.0, 5.0, 10.0]).reshape(-1, 1, 1)


def windows(loads=LOADS, bounds=None, angles=ANGLES, **changes):
    """Return the windows of the baseline with changes, one for each load."""
    made = design(baseline(load_mass=loads, **changes))
    return window_of(made, angles, BOTH_DIRECTIONS, bounds or Bounds())


def common_window(result, loads=slice(None)):
    """Return both ends of the pretension that suits all loads."""
    return result.low[loads].max(), result.high[loads].min()


@pytest.mark.parametrize(
    ("stiffness", "ratio", "empty_hand", "five", "both", "four"),
    [
        (3e3, 1.0, (96.8, 122.8), (158.6, 296.6), None, None),
        (1e3, 1.0, (39.6, 60.9), (101.2, 234.7), None, None),
        (3e3, 0.7, (43.2, 118.6), (94.1, 286.2), (94.1, 118.6), None),
        (3e3, 0.6, (20.8, 116.9), (67.2, 281.9), (67.2, 116.9), (113.5, 116.9)),
        (5e3, 0.6, (29.3, 173.9), (75.7, 338.9), (75.7, 173.9), (122.1, 173.9)),
    ],
)
def test_the_windows_of_the_papers_arm(stiffness, ratio, empty_hand, five, both, four):
    result = windows(spring_stiffness=stiffness, ratio=ratio)
    np.testing.assert_allclose((result.low[0], result.high[0]), empty_hand, atol=0.051)
    np.testing.assert_allclose((result.low[2], result.high[2]), five, atol=0.051)
    for loads, expected in (([0, 2], both), ([0, 1, 2, 3], four)):
        low, high = common_window(result, loads)
        if expected is None:
            assert low > high
        else:
            np.testing.assert_allclose((low, high), expected, atol=0.051)
    assert {LIMIT_NAMES[code] for code in result.low_by} == {"extensor slack"}
    assert {LIMIT_NAMES[code] for code in result.high_by} == {"min_elbow_stiffness"}


def test_the_joints_own_stiffness_does_not_save_the_papers_arm():
    loads = np.array([0.0, 5.0]).reshape(-1, 1, 1)
    bounds = Bounds(min_elbow_stiffness=-2.0)
    for stiffness in (3e3, 1e3):
        low, high = common_window(windows(loads, bounds, spring_stiffness=stiffness))
        assert low > high


def test_limits_of_torque_and_tension_instead_of_stiffness():
    bounds = Bounds(min_elbow_stiffness=-np.inf, peak_motor_torque=14.0, max_tension=400.0)
    loads = np.array([0.0, 10.0]).reshape(-1, 1, 1)
    angles = np.radians(np.linspace(0.0, 90.0, 10))[np.newaxis]
    result = windows(loads, bounds, angles, ratio=0.8)
    np.testing.assert_allclose(common_window(result), (172.867, 185.365), atol=5.1e-4)
    tightest = np.argmin(result.high)
    assert result.high_by[tightest] == MAX_TENSION


# --- Random designs, limits and loads -------------------------------------------------------------

COUNT = 200
LOAD_COUNT = 4
STATES = (2, 6)
"""Directions and angles."""

NAMES = (
    "min_flexor_tension",
    "min_extensor_tension",
    "max_tension",
    "max_spring_extension",
    "peak_motor_torque",
    "max_contact_pressure",
    "min_spring_room",
    "min_elbow_stiffness",
    "peak_motor_speed",
)
CONTACT_WIDTH = 0.04  # m
CONTACT_FROM = 0.7  # rad
FREE_LENGTH = 0.07  # of the spring, m
SPEED = 1.3  # of the elbow, rad/s


def random_bounds(rng):
    """Return limits (n, 1, 1, 1), each of which four designs in ten have."""

    def drawn(low, high, otherwise):
        values = rng.uniform(low, high, (COUNT, 1, 1, 1))
        return np.where(rng.random(values.shape) < 0.4, values, otherwise)

    return Bounds(
        min_flexor_tension=drawn(1.0, 40.0, -np.inf),
        min_extensor_tension=drawn(1.0, 40.0, -np.inf),
        max_tension=drawn(150.0, 2000.0, np.inf),
        max_spring_extension=drawn(0.01, 0.4, np.inf),
        peak_motor_torque=drawn(3.0, 40.0, np.inf),
        max_contact_pressure=drawn(2e4, 6e5, np.inf),
        min_elbow_stiffness=drawn(-5.0, 5.0, -np.inf),
        min_spring_room=drawn(-0.1, 0.1, -np.inf),
        peak_motor_speed=drawn(2.0, 20.0, np.inf),
        speed=SPEED,
    )


@pytest.fixture(scope="module")
def problem():
    """Return numbers of designs (n, 1, 1, 1) with four loads each, angles (1, 6), and limits."""
    seed = 77
    rng = np.random.default_rng(seed)
    numbers, *_ = worn(COUNT, seed)
    p = {name: np.asarray(values).reshape(-1, 1, 1, 1) for name, values in numbers.items()}
    for side in SIDES:
        p[f"{side}_pretension"] = np.zeros_like(p["ratio"])
    p["load_mass"] = rng.uniform(0.0, 10.0, (COUNT, LOAD_COUNT, 1, 1))
    p["upper_arm_angle"] = rng.choice([0.0, 0.4, -2.4], (COUNT, 1, 1, 1))
    angles = np.append(np.sort(rng.uniform(0.05, 1.8, STATES[1] - 1)), 2.2)[np.newaxis]
    return p, angles, random_bounds(rng)


@pytest.fixture(scope="module")
def ends(problem):
    """Return the windows of the problem."""
    p, angles, bounds = problem
    return window_of(bilateral(p), angles, BOTH_DIRECTIONS, bounds)


def bilateral(p, pretension=0.0):
    """Return the bilateral designs at a pretension of both sides."""
    pretensions = {f"{side}_pretension": pretension for side in SIDES}
    made = design(p | {"unilateral": False} | pretensions)
    arm = replace(made.arm, contact_width=CONTACT_WIDTH, contact_from=CONTACT_FROM)
    return replace(made, arm=arm, given={"spring.free_length": FREE_LENGTH})


def excesses(problem, pretension):
    """Return the amounts by which each limit is broken in each state, as the model computes them.

    The pretension may be in any shape of designs and loads.
    """
    p, angles, bounds = problem
    made = bilateral(p, pretension.reshape(COUNT, LOAD_COUNT, 1, 1))
    state = actuator.evaluate(made, angles, BOTH_DIRECTIONS)
    x = state.balance.flexor
    y = state.balance.extensor
    x_proximal = state.flexor_tension_proximal
    y_proximal = state.extensor_tension_proximal
    tension = np.maximum(np.maximum(x, x_proximal), np.maximum(y, y_proximal))
    flexor_extension = x * state.flexor.spring
    extension = np.maximum(flexor_extension, y * state.extensor.spring)
    pressure = y / (p["elbow_radius"] * CONTACT_WIDTH)
    pressure = np.where(angles >= CONTACT_FROM, pressure, 0.0)
    spring_room = state.motion.flexor_path - FREE_LENGTH - flexor_extension
    speed = np.abs(SPEED * motor_rates(state).spool_speed)
    return {
        "flexor slack": -x,
        "extensor slack": -y,
        "min_flexor_tension": bounds["min_flexor_tension"] - np.minimum(x, x_proximal),
        "min_extensor_tension": bounds["min_extensor_tension"] - np.minimum(y, y_proximal),
        "max_tension": tension - bounds["max_tension"],
        "max_spring_extension": extension - bounds["max_spring_extension"],
        "peak_motor_torque": np.abs(state.motor_torque) - bounds["peak_motor_torque"],
        "max_contact_pressure": pressure - bounds["max_contact_pressure"],
        "min_elbow_stiffness": bounds["min_elbow_stiffness"] - state.elbow_stiffness,
        "min_spring_room": bounds["min_spring_room"] - spring_room,
        "peak_motor_speed": speed - bounds["peak_motor_speed"],
    }


def keeps_limits(problem, pretension):
    """Return True for designs and loads of which no state breaks a limit."""
    kept = [
        np.all(~(values > 0.0), axis=(-2, -1)) for values in excesses(problem, pretension).values()
    ]
    return np.all(kept, axis=0)


def breaks_limits(problem, pretension):
    """Return True for designs and loads of which a state breaks a limit, or has no number."""
    broken = [
        np.any(~(values <= 0.0), axis=(-2, -1)) for values in excesses(problem, pretension).values()
    ]
    return np.any(broken, axis=0)


def test_the_draw_has_every_kind_of_window(ends):
    assert 100 < ends.is_open.sum() < 700
    assert np.isinf(ends.high).sum() > 5
    assert (np.isnan(ends.low) & (ends.low_by == limits.NO_EQUILIBRIUM)).sum() > 10
    codes = np.append(ends.low_by[ends.is_open], ends.high_by[ends.is_open])
    binding = {LIMIT_NAMES[code] for code in codes if code >= 0}
    assert binding >= {"flexor slack", "extensor slack", *NAMES}


def bisected(holds, good, bad):
    """Return the pretensions up to which `holds` is true, from good ones towards bad ones."""
    for _ in range(70):
        middle = 0.5 * (good + bad)
        inside = holds(middle)
        good = np.where(inside, middle, good)
        bad = np.where(inside, bad, middle)
    return good


def test_both_ends_are_where_bisection_on_the_model_finds_them(problem, ends):
    opened = ends.is_open & (ends.high - ends.low > 1e-6)
    low = np.where(opened, ends.low, 1.0)
    high = np.where(opened, np.minimum(ends.high, 1e5), 2.0)
    inside = 0.5 * (low + high)

    def holds(pretension):
        return keeps_limits(problem, pretension)

    assert holds(inside)[opened].all()
    bounded = opened & np.isfinite(ends.high)
    assert not holds(np.where(bounded, ends.high + 0.01, 0.0))[bounded].any()
    floor = opened & (ends.low_by != NOTHING)
    assert not holds(np.where(floor, ends.low - 0.01, 0.0))[floor & (ends.low > 0.01)].any()
    upper = bisected(holds, inside, np.where(bounded, ends.high + 10.0, inside + 1.0))
    np.testing.assert_allclose(upper[bounded], ends.high[bounded], rtol=1e-8)
    lower = bisected(holds, inside, np.zeros_like(inside))
    np.testing.assert_allclose(lower[floor], ends.low[floor], rtol=1e-8, atol=1e-8)
    assert holds(np.full_like(inside, 1e7))[ends.is_open & np.isinf(ends.high)].all()


def test_no_pretension_at_all_keeps_the_limits_of_an_empty_window(problem, ends):
    shut = ~ends.is_open
    assert shut.sum() > 50
    clearly_shut = np.isnan(ends.low) | (ends.low - ends.high > 1e-9 * ends.low)
    low = np.where(np.isfinite(ends.low), np.maximum(ends.low, 0.0), 0.0)
    high = np.where(np.isfinite(ends.high), np.maximum(ends.high, 0.0), 0.0)
    everywhere = [np.full_like(low, value) for value in np.geomspace(0.1, 3e4, 150)]
    for pretension in (low, high, 0.5 * (low + high), *everywhere):
        assert breaks_limits(problem, pretension)[shut & clearly_shut].all()


@pytest.mark.parametrize("end", ["low", "high"])
def test_the_named_limit_binds_in_the_named_state(problem, ends, end):
    """The excess is zero at the end, and beyond the end the limit is broken."""
    at_end = getattr(ends, end)
    codes = getattr(ends, f"{end}_by")
    states = getattr(ends, f"{end}_state")
    outward = -0.01 if end == "low" else 0.01
    chosen = np.argwhere(np.isfinite(ends.low) & (codes != NOTHING) & (at_end < 1e5))
    assert len(chosen) > 150
    pretension = np.where(np.isfinite(at_end), at_end, 0.0)
    exactly = excesses(problem, pretension)
    at_half = excesses(problem, pretension * 0.5)
    beyond = excesses(problem, pretension + outward)
    for number, load in chosen:
        name = LIMIT_NAMES[codes[number, load]]
        place = (number, load, *np.unravel_index(states[number, load], STATES))
        excess = exactly[name][place]
        size = abs(excess - at_half[name][place]) + 1e-9
        assert abs(excess) <= 1e-7 * size, name
        assert beyond[name][place] > 0.0 or at_end[number, load] <= 0.02, name


# --- Edges ----------------------------------------------------------------------------------------


def test_a_limit_that_pretension_cannot_change_is_the_reason():
    result = windows(bounds=Bounds(min_spool_to_tendon=30.0), ratio=0.7)
    assert np.isnan(result.low).all()
    assert np.isnan(result.high).all()
    assert {LIMIT_NAMES[code] for code in result.low_by} == {"min_spool_to_tendon"}
    kept_just = windows(bounds=Bounds(min_spool_to_tendon=28.0 * (1 - 1e-12)), ratio=0.7)
    np.testing.assert_array_equal(kept_just.low, windows(ratio=0.7).low)


def test_a_largest_pretension_belongs_to_no_state():
    result = windows(bounds=Bounds(max_pretension=110.0))
    assert result.high[0] == 110.0
    assert LIMIT_NAMES[result.high_by[0]] == "max_pretension"
    assert result.high_state[0] == -1


def test_beyond_the_joints_centre_there_is_no_equilibrium():
    result = windows(angles=np.radians([[0.0, 90.0, 165.0]]))
    assert {LIMIT_NAMES[code] for code in result.low_by} == {"no equilibrium"}
    assert np.isnan(result.low).all()
    assert set(result.low_state) == {2}


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("friction", 0.07),
        ("bend_angle", 3.0),
        ("diameter", 1.5e-3),
        ("b1", 0.15),
        ("elbow_radius", 0.045),
        ("ratio", 0.8),
        ("load_mass", 3.0),
    ],
)
def test_every_number_has_a_derivative_by_complex_step(name, size):
    angle = ANGLES[..., 90:]
    flexion = BOTH_DIRECTIONS[1:]
    bounds = Bounds(max_tension=300.0)

    def end(value):
        made = design(baseline(**{name: value}))
        return limit_end(MAX_TENSION, made, angle, flexion, bounds, upper=True).item()

    step = 1e-4 * size
    near = end(size + step) - end(size - step)
    far = end(size + 2 * step) - end(size - 2 * step)
    expected = (8 * near - far) / (12 * step)
    assert end(size + 1e-30j).imag / 1e-30 == pytest.approx(expected, rel=1e-7, abs=1e-7)


def test_a_peak_of_a_form_is_the_value_of_largest_magnitude_with_its_sign(monkeypatch):
    form = SimpleNamespace(value=lambda at: at, from_below=False, in_magnitude=True)
    monkeypatch.setitem(limits.LIMITS, "peak_form", form)
    over_states = extremes.of_forms(["peak_form"], np.array([[[-80.0, 20.0]], [[-3.0, 50.0]]]))
    assert over_states["peak_form"].tolist() == [-80.0, 50.0]
