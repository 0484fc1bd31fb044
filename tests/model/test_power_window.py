"""Windows within limits of the motor, against the cycle worked out at many pretensions."""

import numpy as np
import pytest

from tendon_cli.model.bounds import Bounds
from tendon_cli.model.limits import LIMIT_NAMES, POWER
from tendon_cli.model.motor import cycle_columns
from tendon_cli.model.power_window import within_power

from .designs import BOTH_DIRECTIONS, baseline, design, window_of

ANGLES = np.radians(np.linspace(0.0, 90.0, 10)).reshape(1, -1)
SPEED = np.radians(60.0)
RATIOS = (0.6, 0.8, 1.0)
LOADS = (0.0, 3.0, 8.0)


def grid_windows(**limits):
    """Return the window without limits and the one within them, for all ratios and loads."""
    ratio = np.array(RATIOS).reshape(-1, 1, 1, 1)
    load = np.array(LOADS).reshape(1, -1, 1, 1)
    made = design(baseline(ratio=ratio, load_mass=load))
    bounds = Bounds(speed=SPEED, **limits)
    wide = window_of(made, ANGLES, BOTH_DIRECTIONS, Bounds())
    of_forms = window_of(made, ANGLES, BOTH_DIRECTIONS, bounds)
    return wide, within_power(of_forms, made, ANGLES, BOTH_DIRECTIONS, bounds)


def results_at(pretension, name, **changes):
    """Return a result of the cycle at each of many pretensions of one design."""
    made = design(baseline(**changes, pretension=pretension.reshape(-1, 1, 1)))
    values = cycle_columns(made, ANGLES, BOTH_DIRECTIONS, SPEED)[name]
    return np.broadcast_to(values, pretension.shape)


def result_at(pretension, name, **changes):
    """Return a result of the cycle at one pretension."""
    made = design(baseline(**changes, pretension=float(pretension)))
    return float(cycle_columns(made, ANGLES, BOTH_DIRECTIONS, SPEED)[name])


@pytest.mark.parametrize(
    ("name", "limit"),
    [
        ("peak_motor_speed", 4.2),
        ("peak_motor_power", 10.0),
        ("peak_motor_power", 18.0),
    ],
)
def test_what_is_left_of_a_window_is_what_the_cycle_allows(name, limit):
    wide, left = grid_windows(**{name: limit})
    code = LIMIT_NAMES.index(name)
    for row, ratio in enumerate(RATIOS):
        for column, load in enumerate(LOADS):
            place = (row, column)
            if not wide.is_open[place]:
                assert not left.is_open[place]
                continue
            pretension = np.linspace(wide.low[place], wide.high[place], 42)[1:-1]
            within = (left.low[place] <= pretension) & (pretension <= left.high[place])
            kept = results_at(pretension, name, ratio=ratio, load_mass=load) <= limit
            np.testing.assert_array_equal(within, kept)
            low_moved = left.low[place] != wide.low[place]
            high_moved = left.high[place] != wide.high[place]
            assert (left.low_by[place] == code) == low_moved
            assert (left.high_by[place] == code) == high_moved


def test_ends_are_exact():
    _, left = grid_windows(peak_motor_power=10.0)
    cut = left.is_open & (left.low_by == POWER)
    assert cut.any()
    for row, column in np.argwhere(cut):
        changes = {"ratio": RATIOS[row], "load_mass": LOADS[column]}
        power = result_at(left.low[row, column], "peak_motor_power", **changes)
        assert power == pytest.approx(10.0, rel=1e-9)


def test_limits_together_leave_what_each_leaves():
    limits = {"peak_motor_power": 18.0, "peak_motor_speed": 4.2, "max_tension": 400.0}
    wide, left = grid_windows(**limits)
    left_by_one = [grid_windows(**{name: limit})[1] for name, limit in limits.items()]
    low = np.max([result.low for result in left_by_one], axis=0)
    high = np.min([result.high for result in left_by_one], axis=0)
    is_open = left.is_open
    np.testing.assert_array_equal(is_open, low <= high)
    np.testing.assert_allclose(left.low[is_open], low[is_open])
    np.testing.assert_allclose(left.high[is_open], high[is_open])
    assert (left.low >= wide.low)[is_open].all()


def test_a_limit_that_no_pretension_keeps_is_the_reason():
    wide, left = grid_windows(peak_motor_power=0.01)
    was_open = wide.is_open
    assert np.isnan(left.low[was_open]).all()
    assert {LIMIT_NAMES[code] for code in left.low_by[was_open]} == {"peak_motor_power"}
    assert not left.is_open.any()


def test_the_widest_interval_that_keeps_a_limit_is_used():
    """The motor's power first falls and then rises with pretension."""
    changes = {"load_mass": 3.0, "ratio": 0.7}
    made = design(baseline(**changes))
    wide = window_of(made, ANGLES, BOTH_DIRECTIONS, Bounds())
    pretension = np.linspace(float(wide.low), float(wide.high), 200)
    power = results_at(pretension, "peak_motor_power", **changes)
    limit = float(np.quantile(power, 0.5))
    bounds = Bounds(speed=SPEED, peak_motor_power=limit)
    left = within_power(wide, made, ANGLES, BOTH_DIRECTIONS, bounds)
    allowed = power <= limit
    edges = np.diff(allowed.astype(int), prepend=0, append=0)
    runs = np.flatnonzero(edges == -1) - np.flatnonzero(edges == 1)
    within = (pretension >= float(left.low)) & (pretension <= float(left.high))
    assert (allowed[within]).all()
    assert within.sum() == runs.max()


def test_without_an_upper_end_the_window_ends_where_a_limit_does():
    made = design(baseline(load_mass=3.0))
    wide = window_of(made, ANGLES, BOTH_DIRECTIONS, Bounds(min_elbow_stiffness=-np.inf))
    assert np.isinf(wide.high)

    def left_by(most):
        bounds = Bounds(speed=SPEED, peak_motor_power=most)
        return within_power(wide, made, ANGLES, BOTH_DIRECTIONS, bounds)

    power = result_at(left_by(100.0).high, "peak_motor_power", load_mass=3.0)
    assert power == pytest.approx(100.0, rel=1e-9)
    assert np.isinf(left_by(1e15).high)
