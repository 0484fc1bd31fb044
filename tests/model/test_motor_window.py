"""Windows within limits of the motor, against the cycle worked out at many pretensions."""

import numpy as np
import pytest

from tendon_cli.model.bounds import Bounds
from tendon_cli.model.limits import LIMIT_NAMES
from tendon_cli.model.motor import cycle
from tendon_cli.model.motor_window import narrowed
from tendon_cli.model.window import window

from .designs import baseline, design

WAYS = np.array([[True], [False]])
ANGLES = np.radians(np.linspace(0.0, 90.0, 10)).reshape(1, -1)
SPEED = np.radians(60.0)
RATIOS, LOADS = (0.6, 0.8, 1.0), (0.0, 3.0, 8.0)
COLUMNS = {
    "max_motor_work_in": "motor_work_in",
    "max_friction_loss": "friction_loss",
    "min_efficiency": "efficiency",
    "max_spool_travel": "spool_travel",
}


def both(bounds):
    ratio, load = np.array(RATIOS).reshape(-1, 1, 1, 1), np.array(LOADS).reshape(1, -1, 1, 1)
    many = design(baseline(ratio=ratio, load_mass=load))
    return window(many, ANGLES, WAYS, Bounds()), narrowed(
        window(many, ANGLES, WAYS, bounds), many, ANGLES, WAYS, bounds
    )


def kept(name, most, ratio, load, pretension):
    """Whether a limit is kept, and how far off the value is, at many pretensions of one design."""
    alone = design(baseline(ratio=ratio, load_mass=load, pretension=pretension.reshape(-1, 1, 1)))
    value = np.broadcast_to(
        cycle(alone, ANGLES, WAYS, SPEED)[COLUMNS.get(name, name)], pretension.shape
    )
    return value >= most if name.startswith("min") else value <= most


@pytest.mark.parametrize(
    ("name", "most"),
    [
        ("peak_motor_speed", 4.2),
        ("max_backlash", 0.009),
        ("max_torque_band", 3.5),
        ("max_spool_travel", 3.9),
        ("peak_motor_power", 10.0),
        ("peak_motor_power", 18.0),
        ("max_motor_work_in", 20.0),
        ("max_friction_loss", 11.0),
        ("min_efficiency", 0.2),
        ("min_efficiency", 0.5),
    ],
)
def test_what_is_left_of_a_window_is_what_the_cycle_allows(name, most):
    found, left = both(Bounds(speed=SPEED, **{name: most}))
    code = LIMIT_NAMES.index(name)
    for row, ratio in enumerate(RATIOS):
        for column, load in enumerate(LOADS):
            at = row, column
            if not found.is_open[at]:
                assert not left.is_open[at]
                continue
            pretension = np.linspace(found.low[at], found.high[at], 42)[1:-1]
            within = (left.low[at] <= pretension) & (pretension <= left.high[at])
            np.testing.assert_array_equal(within, kept(name, most, ratio, load, pretension))
            for end, by, was in (
                ("low", "low_by", found.low[at]),
                ("high", "high_by", found.high[at]),
            ):
                now = getattr(left, end)[at]
                assert (getattr(left, by)[at] == code) == (now != was)


def test_ends_are_exact():
    found, left = both(Bounds(speed=SPEED, max_friction_loss=11.0, max_backlash=0.02))
    cut = found.is_open & (left.high < found.high)
    assert cut.any()
    for row, column in np.argwhere(cut):
        at = design(
            baseline(ratio=RATIOS[row], load_mass=LOADS[column], pretension=left.high[row, column])
        )
        assert float(cycle(at, ANGLES, WAYS, SPEED)["friction_loss"]) == pytest.approx(
            11.0, rel=1e-9
        )


def test_limits_together_leave_what_each_leaves():
    limits = {
        "max_backlash": 0.009,
        "max_friction_loss": 11.0,
        "peak_motor_speed": 4.2,
        "max_spool_travel": 3.9,
    }
    found, left = both(Bounds(speed=SPEED, **limits))
    each = [both(Bounds(speed=SPEED, **{name: most}))[1] for name, most in limits.items()]
    low, high = (
        np.max([one.low for one in each], axis=0),
        np.min([one.high for one in each], axis=0),
    )
    open_ = left.is_open
    np.testing.assert_array_equal(open_, low <= high)
    np.testing.assert_allclose(left.low[open_], low[open_])
    np.testing.assert_allclose(left.high[open_], high[open_])
    assert (left.low >= found.low)[open_].all()


def test_a_limit_that_no_pretension_keeps_is_the_reason():
    found, left = both(Bounds(speed=SPEED, max_friction_loss=0.01))
    was_open = found.is_open
    assert np.isnan(left.low[was_open]).all()
    assert {LIMIT_NAMES[code] for code in left.low_by[was_open]} == {"max_friction_loss"}
    assert not left.is_open.any()


def test_the_widest_interval_that_keeps_a_limit_is_used():
    """A heavy spring pulls the limit through: the motor's power first falls, then rises with pretension."""
    one = design(baseline(load_mass=3.0, ratio=0.7))
    found = window(one, ANGLES, WAYS, Bounds())
    pretension = np.linspace(float(found.low), float(found.high), 200)
    many = design(baseline(load_mass=3.0, ratio=0.7, pretension=pretension.reshape(-1, 1, 1)))
    power = np.broadcast_to(cycle(many, ANGLES, WAYS, SPEED)["peak_motor_power"], pretension.shape)
    most = float(np.quantile(power, 0.5))
    left = narrowed(found, one, ANGLES, WAYS, Bounds(speed=SPEED, peak_motor_power=most))
    allowed = power <= most
    edges = np.diff(allowed.astype(int), prepend=0, append=0)
    runs = np.flatnonzero(edges == -1) - np.flatnonzero(edges == 1)
    within = (pretension >= float(left.low)) & (pretension <= float(left.high))
    assert (allowed[within]).all()
    assert within.sum() == runs.max()


def test_without_an_upper_end_the_window_ends_where_a_limit_does():
    one = design(baseline(load_mass=3.0))
    found = window(one, ANGLES, WAYS, Bounds(min_elbow_stiffness=-np.inf))
    left = narrowed(found, one, ANGLES, WAYS, Bounds(speed=SPEED, max_spool_travel=7.0))
    assert np.isinf(found.high)
    at = design(baseline(load_mass=3.0, pretension=float(left.high)))
    assert float(cycle(at, ANGLES, WAYS, SPEED)["spool_travel"]) == pytest.approx(7.0, rel=1e-9)
    free = narrowed(found, one, ANGLES, WAYS, Bounds(speed=SPEED, max_spool_travel=1e9))
    assert np.isinf(free.high)
