"""The window of pretension against bisection on the model, which the independent rig holds to."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tendon_cli.model import actuator, extremes, limits, window
from tendon_cli.model.bounds import Bounds, limit_end
from tendon_cli.model.limits import LIMIT_NAMES, NOTHING
from tendon_cli.model.motor import motor_rates

from .designs import baseline, design, worn

ANGLES = np.radians(np.arange(91.0))[np.newaxis]
BOTH = np.array([[True], [False]])
MOST = LIMIT_NAMES.index("max_tension")
LOADS = np.array([0.0, 3.0, 5.0, 10.0]).reshape(-1, 1, 1)


def windows(loads=LOADS, bounds=None, angles=ANGLES, **changes):
    return window.window(
        design(baseline(load_mass=loads, **changes)), angles, BOTH, bounds or Bounds()
    )


def common(found):
    return found.low.max(), found.high.min()


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
    found = windows(spring_stiffness=stiffness, ratio=ratio)
    np.testing.assert_allclose((found.low[0], found.high[0]), empty_hand, atol=0.051)
    np.testing.assert_allclose((found.low[2], found.high[2]), five, atol=0.051)
    for chosen, expected in (([0, 2], both), ([0, 1, 2, 3], four)):
        low, high = found.low[chosen].max(), found.high[chosen].min()
        if expected is None:
            assert low > high
        else:
            np.testing.assert_allclose((low, high), expected, atol=0.051)
    assert {LIMIT_NAMES[code] for code in found.low_by} == {"extensor slack"}
    assert {LIMIT_NAMES[code] for code in found.high_by} == {"min_elbow_stiffness"}


def test_the_joints_own_stiffness_does_not_save_the_papers_arm():
    for stiffness in (3e3, 1e3):
        found = windows(
            np.array([0.0, 5.0]).reshape(-1, 1, 1),
            Bounds(min_elbow_stiffness=-2.0),
            spring_stiffness=stiffness,
        )
        low, high = common(found)
        assert low > high


def test_limits_of_torque_and_tension_instead_of_stiffness():
    bounds = Bounds(min_elbow_stiffness=-np.inf, peak_motor_torque=14.0, max_tension=400.0)
    loads = np.array([0.0, 10.0]).reshape(-1, 1, 1)
    found = windows(loads, bounds, np.radians(np.linspace(0.0, 90.0, 10))[np.newaxis], ratio=0.8)
    np.testing.assert_allclose(common(found), (172.867, 185.365), atol=5.1e-4)
    at = np.argmin(found.high)
    assert found.high_by[at] == MOST


# --- Random designs, limits and loads -------------------------------------------------------------

COUNT, STATES = 200, (2, 6)
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
WIDTH, FREE_LENGTH, SPEED = 0.04, 0.07, 1.3


def drawn(seed=77):
    """Designs (n, 1, 1, 1) with four loads (n, 4, 1, 1), angles (1, 6), and limits, some of each not asked."""
    rng = np.random.default_rng(seed)
    p, *_ = worn(COUNT, seed)
    p = {name: np.asarray(values).reshape(-1, 1, 1, 1) for name, values in p.items()}
    for side in ("flexor", "extensor"):
        p[f"{side}_pretension"] = np.zeros_like(p["ratio"])
    p["load_mass"] = rng.uniform(0.0, 10.0, (COUNT, 4, 1, 1))
    p["upper_arm_angle"] = rng.choice([0.0, 0.4, -2.4], (COUNT, 1, 1, 1))
    angles = np.append(np.sort(rng.uniform(0.05, 1.8, STATES[1] - 1)), 2.2)[np.newaxis]

    def some(low, high, otherwise):
        values = rng.uniform(low, high, (COUNT, 1, 1, 1))
        return np.where(rng.random(values.shape) < 0.4, values, otherwise)

    bounds = Bounds(
        min_flexor_tension=some(1.0, 40.0, -np.inf),
        min_extensor_tension=some(1.0, 40.0, -np.inf),
        max_tension=some(150.0, 2000.0, np.inf),
        max_spring_extension=some(0.01, 0.4, np.inf),
        peak_motor_torque=some(3.0, 40.0, np.inf),
        max_contact_pressure=some(2e4, 6e5, np.inf),
        min_elbow_stiffness=some(-5.0, 5.0, -np.inf),
        min_spring_room=some(-0.1, 0.1, -np.inf),
        peak_motor_speed=some(2.0, 20.0, np.inf),
        speed=SPEED,
    )
    return p, angles, bounds


def the_design(p, pretension=0.0):
    made = design(
        p
        | {"unilateral": False, "flexor_pretension": pretension, "extensor_pretension": pretension}
    )
    return replace(
        made, arm=replace(made.arm, contact_width=WIDTH), given={"spring.free_length": FREE_LENGTH}
    )


def excesses(p, angles, bounds, pretension):
    """By how much each limit is broken in each state, as the model works the states out at a pretension."""
    state = actuator.evaluate(the_design(p, pretension), angles, BOTH)
    x, y, near_x, near_y = (
        state.balance.flexor,
        state.balance.extensor,
        state.flexor_tension_proximal,
        state.extensor_tension_proximal,
    )
    extension = np.maximum(x * state.flexor.spring, y * state.extensor.spring)
    return {
        "flexor slack": -x,
        "extensor slack": -y,
        "min_flexor_tension": bounds["min_flexor_tension"] - np.minimum(x, near_x),
        "min_extensor_tension": bounds["min_extensor_tension"] - np.minimum(y, near_y),
        "max_tension": np.maximum(np.maximum(x, near_x), np.maximum(y, near_y))
        - bounds["max_tension"],
        "max_spring_extension": extension - bounds["max_spring_extension"],
        "peak_motor_torque": np.abs(state.motor_torque) - bounds["peak_motor_torque"],
        "max_contact_pressure": y / (p["elbow_radius"] * WIDTH) - bounds["max_contact_pressure"],
        "min_elbow_stiffness": bounds["min_elbow_stiffness"] - state.elbow_stiffness,
        "min_spring_room": bounds["min_spring_room"]
        - (state.motion.flexor_path - FREE_LENGTH - x * state.flexor.spring),
        "peak_motor_speed": np.abs(SPEED * motor_rates(state).spool_speed)
        - bounds["peak_motor_speed"],
    }


def kept(p, angles, bounds, pretension):
    found = excesses(p, angles, bounds, pretension.reshape(COUNT, 4, 1, 1))
    return np.all([np.all(~(values > 0.0), axis=(-2, -1)) for values in found.values()], axis=0)


@pytest.fixture(scope="module")
def problem():
    return drawn()


@pytest.fixture(scope="module")
def found(problem):
    p, angles, bounds = problem
    return window.window(the_design(p), angles, BOTH, bounds)


def test_the_draw_has_every_kind_of_window(found):
    assert 100 < found.is_open.sum() < 700
    assert np.isinf(found.high).sum() > 5
    assert (np.isnan(found.low) & (found.low_by == limits.NO_EQUILIBRIUM)).sum() > 10
    bind = {
        LIMIT_NAMES[code]
        for code in np.append(found.low_by[found.is_open], found.high_by[found.is_open])
        if code >= 0
    }
    assert bind >= {"flexor slack", "extensor slack", *NAMES}


def bisected(holds, good, bad):
    """Where `holds` ends between arrays of good and bad pretensions."""
    for _ in range(70):
        middle = 0.5 * (good + bad)
        inside = holds(middle)
        good, bad = np.where(inside, middle, good), np.where(inside, bad, middle)
    return good


def test_both_ends_are_where_bisection_on_the_model_finds_them(problem, found):
    p, angles, bounds = problem
    opened = found.is_open & (found.high - found.low > 1e-6)
    low, high = np.where(opened, found.low, 1.0), np.where(opened, np.minimum(found.high, 1e5), 2.0)
    inside = 0.5 * (low + high)

    def holds(pretension):
        return kept(p, angles, bounds, pretension)

    assert holds(inside)[opened].all()
    bounded = opened & np.isfinite(found.high)
    assert not holds(np.where(bounded, found.high + 0.01, 0.0))[bounded].any()
    floor = opened & (found.low_by != NOTHING)
    assert not holds(np.where(floor, found.low - 0.01, 0.0))[floor & (found.low > 0.01)].any()
    upper = bisected(holds, inside, np.where(bounded, found.high + 10.0, inside + 1.0))
    np.testing.assert_allclose(upper[bounded], found.high[bounded], rtol=1e-8)
    lower = bisected(holds, inside, np.zeros_like(inside))
    np.testing.assert_allclose(lower[floor], found.low[floor], rtol=1e-8, atol=1e-8)
    assert holds(np.full_like(inside, 1e7))[found.is_open & np.isinf(found.high)].all()


def test_no_pretension_at_all_keeps_the_limits_of_an_empty_window(problem, found):
    p, angles, bounds = problem
    shut = ~found.is_open
    assert shut.sum() > 50
    ends = [
        np.where(np.isfinite(end), np.maximum(end, 0.0), 0.0) for end in (found.low, found.high)
    ]
    for pretension in (
        *ends,
        0.5 * (ends[0] + ends[1]),
        *(np.full_like(ends[0], f) for f in np.geomspace(0.1, 3e4, 150)),
    ):
        loosely = excesses(p, angles, bounds, pretension.reshape(COUNT, 4, 1, 1))
        broken = np.any(
            [np.any(~(values <= 0.0), axis=(-2, -1)) for values in loosely.values()], axis=0
        )
        assert broken[
            shut & (np.isnan(found.low) | (found.low - found.high > 1e-9 * found.low))
        ].all()


@pytest.mark.parametrize("end", ["low", "high"])
def test_the_named_limit_binds_in_the_named_state(problem, found, end):
    """There its excess is zero, and beyond the end it is broken."""
    p, angles, bounds = problem
    at_end, codes, states = (getattr(found, f"{end}{which}") for which in ("", "_by", "_state"))
    chosen = np.argwhere(np.isfinite(found.low) & (codes != NOTHING) & (at_end < 1e5))
    assert len(chosen) > 150
    pretension = np.where(np.isfinite(at_end), at_end, 0.0).reshape(COUNT, 4, 1, 1)
    just, less = (excesses(p, angles, bounds, pretension * share) for share in (1.0, 0.5))
    beyond = excesses(p, angles, bounds, pretension + (-0.01 if end == "low" else 0.01))
    for at, load in chosen:
        name, place = (
            LIMIT_NAMES[codes[at, load]],
            (at, load, *np.unravel_index(states[at, load], STATES)),
        )
        size = abs(just[name][place] - less[name][place]) + 1e-9
        assert abs(just[name][place]) <= 1e-7 * size, name
        assert beyond[name][place] > 0.0 or at_end[at, load] <= 0.02, name


# --- Edges ----------------------------------------------------------------------------------------


def test_a_limit_that_pretension_cannot_change_is_the_reason():
    found = windows(bounds=Bounds(min_spool_to_tendon=30.0), ratio=0.7)
    assert np.isnan(found.low).all()
    assert np.isnan(found.high).all()
    assert {LIMIT_NAMES[code] for code in found.low_by} == {"min_spool_to_tendon"}
    kept_just = windows(bounds=Bounds(min_spool_to_tendon=28.0 * (1 - 1e-12)), ratio=0.7)
    np.testing.assert_array_equal(kept_just.low, windows(ratio=0.7).low)


def test_a_largest_pretension_belongs_to_no_state():
    found = windows(bounds=Bounds(max_pretension=110.0))
    assert found.high[0] == 110.0
    assert LIMIT_NAMES[found.high_by[0]] == "max_pretension"
    assert found.high_state[0] == -1


def test_beyond_the_joints_centre_there_is_no_equilibrium():
    found = windows(angles=np.radians([[0.0, 90.0, 165.0]]))
    assert {LIMIT_NAMES[code] for code in found.low_by} == {"no equilibrium"}
    assert np.isnan(found.low).all()
    assert set(found.low_state) == {2}


@pytest.mark.parametrize(
    "name", ["friction", "bend_angle", "diameter", "b1", "elbow_radius", "ratio", "load_mass"]
)
def test_every_number_has_a_derivative_by_complex_step(name):
    angle, flexion = ANGLES[..., 90:], BOTH[1:]
    bounds = Bounds(max_tension=300.0)
    sizes = {
        "friction": 0.07,
        "bend_angle": 3.0,
        "diameter": 1.5e-3,
        "b1": 0.15,
        "elbow_radius": 0.045,
        "ratio": 0.8,
    }
    size = sizes.get(name, 3.0)

    def end(value):
        return limit_end(
            MOST, design(baseline(**{name: value})), angle, flexion, bounds, upper=True
        ).item()

    step = 1e-4 * size
    expected = (
        -end(size + 2 * step) + 8 * end(size + step) - 8 * end(size - step) + end(size - 2 * step)
    ) / (12 * step)
    assert end(size + 1e-30j).imag / 1e-30 == pytest.approx(expected, rel=1e-7, abs=1e-7)


def test_a_peak_of_a_form_is_the_value_of_largest_magnitude_with_its_sign(monkeypatch):
    monkeypatch.setitem(
        limits.LIMITS,
        "peak_form",
        SimpleNamespace(value=lambda at: at, from_below=False, in_magnitude=True),
    )
    over_states = extremes.of_forms(["peak_form"], np.array([[[-80.0, 20.0]], [[-3.0, 50.0]]]))
    assert over_states["peak_form"].tolist() == [-80.0, 50.0]
