"""The way in which tendons slide along a motion, against an independent rig and by symmetry."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tendon_cli.model.bounds import Bounds
from tendon_cli.model.limits import LIMIT_NAMES
from tendon_cli.model.motion_window import window_along
from tendon_cli.model.moving import motion_columns
from tendon_cli.model.sliding import slack_passes, spool_turns
from tendon_cli.model.statics import EXTENSOR_SLACK, FLEXOR_SLACK, TAUT
from tendon_cli.model.trajectory import Trajectory
from tendon_cli.studies.measured_motion import smoothed

from .designs import SIDES
from .motions import CHECKED, Wave, checked_suit, moving, results

IN_A_CYCLE = 1000  # samples


# --- The check values -----------------------------------------------------------------------------


@pytest.mark.parametrize("name", CHECKED)
def test_a_cycle_has_the_values_that_an_independent_rig_confirmed(name):
    checked = CHECKED[name]
    time = np.arange(3 * IN_A_CYCLE + 1) / (IN_A_CYCLE * checked.wave.frequency)
    along = moving(checked_suit(checked.wave.trajectory(time, 1.0 / checked.wave.frequency)))
    found = results(along)
    for value in ("peak_motor_torque", "rms_motor_torque", "peak_motor_speed"):
        assert found[value] == pytest.approx(getattr(checked, value), rel=2e-3), value
    for value in ("peak_motor_power", "peak_braking_power"):
        assert found[value] == pytest.approx(getattr(checked, value), rel=2e-3), value
    counted = along.trajectory.counted
    turn_loss = along.sliding.turn_loss.ravel()[counted]
    loss = found["friction_loss"] - turn_loss.sum()
    assert loss == pytest.approx(checked.friction_loss, rel=6e-3)
    # The last sample begins the next cycle.
    assert turn_loss[:-1].sum() == pytest.approx(checked.turn_loss, abs=2e-3)
    assert found["opposite_fraction"] == pytest.approx(checked.opposite_fraction, abs=4e-3)
    turns = np.flatnonzero(turn_loss[:-1]) / IN_A_CYCLE
    assert turns == pytest.approx(checked.turns, abs=2e-3)


def filtered(wave, cutoff, rate, phase, cycles=2):
    """Return a wave as a record that is smoothed: only `cycles` of it count."""
    count = round((cycles / wave.frequency + 4.0 / cutoff) * rate) + 1
    time = np.arange(count) / rate
    shifted = time + phase / 360.0 / wave.frequency - 2.0 / cutoff
    angle, *derivatives = smoothed(time, wave.angle(shifted)[0], cutoff, derivatives=3)
    task = None
    if wave.task:
        task = np.array(smoothed(time, wave.torque(shifted)[0], cutoff, derivatives=1))
    return Trajectory(time, angle, np.array(derivatives), task=task, margin=2.0 / cutoff)


RECORDS = [
    (name, cutoff, rate, phase)
    for name, checked in CHECKED.items()
    for cutoff in (6.0, 15.0)
    if checked.wave.fastest <= cutoff / 4.0
    for rate in (100, 200, 500)
    for phase in (0, 45, 90, 115)
]


def assert_record_is_true(name, cutoff, rate, phase):
    """Assert that a smoothed record gives the check values."""
    checked = CHECKED[name]
    trajectory = filtered(checked.wave, cutoff, rate, phase)
    found = results(moving(checked_suit(trajectory)))
    seconds = np.ptp(trajectory.time[trajectory.counted])
    per_cycle = found["friction_loss"] / (seconds * checked.wave.frequency)
    assert found["peak_motor_torque"] == pytest.approx(checked.peak_motor_torque, rel=0.02)
    for value in ("peak_motor_speed", "peak_motor_power", "peak_braking_power"):
        assert found[value] == pytest.approx(getattr(checked, value), rel=0.03), value
    assert per_cycle == pytest.approx(checked.friction_loss + checked.turn_loss, rel=0.03)


@pytest.mark.parametrize(("name", "cutoff", "rate", "phase"), RECORDS[:: len(RECORDS) // 11])
def test_a_smoothed_record_has_the_check_values_whenever_it_begins(name, cutoff, rate, phase):
    assert_record_is_true(name, cutoff, rate, phase)


@pytest.mark.torture
@pytest.mark.parametrize(("name", "cutoff", "rate", "phase"), RECORDS)
def test_every_smoothed_record_has_the_check_values(name, cutoff, rate, phase):
    assert_record_is_true(name, cutoff, rate, phase)


def test_peaks_do_not_come_from_the_ends_of_a_record():
    """The spikes that smoothing makes at the ends are there, and count nowhere."""
    trajectory = filtered(CHECKED["A"].wave, 15.0, 500, 45)
    made = checked_suit(trajectory)
    whole = Trajectory(trajectory.time, trajectory.angle.copy(), trajectory.derivatives)
    spoiled = results(moving(checked_suit(whole)))
    assert spoiled["peak_motor_speed"] > 2.0 * CHECKED["A"].peak_motor_speed
    assert results(moving(made))["peak_motor_speed"] < 1.01 * CHECKED["A"].peak_motor_speed


# --- Turns of the spool ---------------------------------------------------------------------------


def turns_of(angle, play):
    """Return directions and turns of one spool with the same play throughout."""
    directions, turns = spool_turns(
        np.asarray(angle, dtype=float)[np.newaxis], lambda _, samples: np.full(samples.shape, play)
    )
    return directions[0], turns.sample


def test_a_turn_counts_from_the_extreme_once_half_the_play_is_back():
    angle = [0.0, 1.0, 2.0, 1.6, 1.8, 3.0, 2.6, 2.4, 2.0, 2.3, 2.55]
    directions, turns = turns_of(angle, 1.0)
    assert turns.tolist() == [5, 8]
    assert directions.tolist() == [True] * 5 + [False] * 3 + [True] * 3


def test_a_spool_that_is_free_or_at_rest_stays_as_it_was():
    angle = [1.0, 2.0, np.nan, 2.0, 2.0, 2.0, 1.0, 1.0]
    directions, turns = turns_of(angle, 0.1)
    assert turns.tolist() == [5]
    assert directions.tolist() == [True] * 5 + [False] * 3


@settings(max_examples=40)
@given(st.integers(0, 1000), st.floats(0.0, 1.0))
def test_turns_are_those_of_a_search_sample_by_sample(seed, play):
    angle = np.cumsum(np.random.default_rng(seed).normal(0.0, 0.3, 80))
    sign = np.sign(angle[1] - angle[0])
    furthest = 0
    expected = []
    for place in range(1, len(angle)):
        back = sign * (angle[furthest] - angle[place])
        if back > 0.5 * play:
            expected.append(furthest)
            sign = -sign
        if back > 0.5 * play or back <= 0.0:
            furthest = place
    _, turns = turns_of(angle, play)
    assert turns.tolist() == expected


@settings(max_examples=8)
@given(st.integers(0, 10**6))
def test_many_designs_at_once_slide_as_each_alone(seed):
    rng = np.random.default_rng(seed)
    wave = Wave(50, rng.uniform(5, 35), rng.uniform(0.5, 2.5))
    trajectory = wave.trajectory(np.linspace(0.0, 2.0 / wave.frequency, 120))
    loads = rng.uniform(0.0, 4.0, (3, 1, 1, 1))
    friction = rng.uniform(0.0, 0.3, (2, 1, 1))
    together = moving(checked_suit(trajectory, load_mass=loads, friction=friction)).sliding
    for row in range(3):
        for column in range(2):
            here = {"load_mass": loads[row].item(), "friction": friction[column].item()}
            one = moving(checked_suit(trajectory, **here)).sliding
            for name, values in vars(together).items():
                expected = getattr(one, name)
                np.testing.assert_allclose(values[row, column], expected, atol=1e-9)


def test_without_inertia_or_task_the_spool_goes_with_the_joint():
    """The elbow's stiffness is positive here, so that nothing turns the spool but the joint."""
    trajectory = Wave(50, 30, 1.0).trajectory(np.linspace(0.0, 2.0, 401))
    made = checked_suit(trajectory)
    still = replace(made, arm=replace(made.arm, inertia=0.0), load_mass=0.0)
    sliding = moving(still).sliding
    moves = np.abs(trajectory.speed) > 0.05 * np.abs(trajectory.speed).max()
    np.testing.assert_array_equal(sliding.flexion[0, moves], trajectory.is_flexing[moves])


def test_without_friction_the_direction_does_not_matter():
    trajectory = CHECKED["C"].wave.trajectory(np.linspace(0.0, 2.0, 401))
    along = moving(checked_suit(trajectory, friction=0.0))
    np.testing.assert_allclose(along.sliding.other_torque, along.state.motor_torque, atol=1e-12)
    assert results(along)["friction_loss"] == pytest.approx(0.0, abs=1e-12)


@settings(max_examples=15)
@given(st.integers(0, 10**6))
def test_friction_gives_no_energy_outside_of_turns_and_the_balance_closes(seed):
    """τ_m α̇ = τ θ̇ + U̇ + Ẇ, and Ẇ ≥ 0 where the tendons do not turn."""
    rng = np.random.default_rng(seed)
    wave = Wave(
        50, rng.uniform(5, 40), rng.uniform(0.25, 3.0), rng.uniform(0, 4), rng.uniform(0.3, 3)
    )
    trajectory = wave.trajectory(np.linspace(0.0, 2.0 / wave.frequency, 400))
    changes = {"load_mass": rng.uniform(0, 5), "friction": rng.uniform(0.03, 0.28)}
    along = moving(checked_suit(trajectory, ratio=rng.uniform(0.5, 1.0), **changes))
    rates = along.motor_rates
    state = along.state
    at_elbow = state.elbow_torque * trajectory.speed
    expected = at_elbow + rates.storage_rate + rates.friction
    scale = np.abs(rates.power).max()
    np.testing.assert_allclose(rates.power, expected, atol=1e-9 * scale)
    slides = ~state.sliding.turning
    assert rates.friction[slides].min(initial=0.0) >= -1e-9 * scale
    negative = -np.minimum(rates.friction, 0.0).sum()
    assert negative <= 0.03 * np.abs(rates.friction).sum()


def test_a_mirrored_time_of_a_slow_motion_slides_the_other_way():
    """Backward in time every speed changes its sign, so a slow motion has the other friction."""
    time = np.linspace(0.0, 8.0, 801)
    wave = Wave(50, 30, 0.25)
    forward = moving(checked_suit(wave.trajectory(time))).sliding
    angle, speed, acceleration, jerk = wave.angle(time)[:, ::-1]
    back = Trajectory(time, angle, np.array([-speed, acceleration, -jerk]))
    backward = moving(checked_suit(back)).sliding
    slides = ~forward.turning[0] & ~backward.turning[0, ::-1]
    assert slides.mean() > 0.6
    mirrored = backward.flexion[0, ::-1]
    np.testing.assert_array_equal(forward.flexion[0, slides], ~mirrored[slides])


# --- Slack that passes from side to side ----------------------------------------------------------


def test_slack_passes_where_one_side_takes_it_from_the_other():
    states = [TAUT, FLEXOR_SLACK, FLEXOR_SLACK, EXTENSOR_SLACK, EXTENSOR_SLACK, TAUT, FLEXOR_SLACK]
    passes = slack_passes(np.array([states], dtype=np.int8))
    assert passes[0].tolist() == [False, False, True, True, False, False, False]


def test_no_speed_is_claimed_where_slack_passes():
    """A task that pushes and pulls an arm without pretension takes slack from side to side."""
    wave = Wave(75, 15, 0.5, 6.0, 1.0)
    trajectory = wave.trajectory(np.linspace(0.0, 4.0, 401))
    along = moving(checked_suit(trajectory, pretension=1.0, ratio=1.0, load_mass=0.0))
    passing = along.sliding.passing[0]
    assert 2 <= passing.sum() < 40
    assert along.sliding.turning[0, passing].all()
    found = results(along)
    speeds = np.abs(along.motor_rates.spool_speed[0])
    assert found["peak_motor_speed"] == np.nanmax(speeds[~passing])
    # A difference of spool angles across the jump would claim many times that.
    jumps = np.abs(np.diff(along.state.spool_angle[0])) / np.diff(trajectory.time)
    assert np.nanmax(jumps) > 5.0 * found["peak_motor_speed"]


# --- Windows --------------------------------------------------------------------------------------

SWEPT = 200
LIMITS = {
    "peak_motor_torque": 1.1,
    "peak_motor_speed": 1.02,
    "peak_motor_power": 1.03,
    "max_tension": 1.2,
}
"""Limits, as shares of the value at 150 N."""


def values_at(made, pretensions):
    """Return what limits bound at pretensions, by limit, and where a tendon may be slack."""
    along = moving(made).at_pretension(pretensions[:, np.newaxis, np.newaxis])
    counted = along.trajectory.counted
    held, turned = along.counted_states
    columns = motion_columns(along)
    names = [f"{side}_tension_{end}" for side in SIDES for end in ("proximal", "distal")]
    tensions = [list(at.columns(names).values()) for at in (held, turned)]
    slack = held.balance.is_slack | turned.balance.is_slack
    return {
        "peak_motor_torque": np.abs([held.motor_torque, turned.motor_torque]).max(axis=(0, 2, 3)),
        "peak_motor_speed": columns["peak_motor_speed"],
        "peak_motor_power": columns["peak_motor_power"],
        "max_tension": np.max(tensions, axis=(0, 1, 3, 4)),
        "stiffness": held.elbow_stiffness.min(axis=(1, 2)),
        "slack": slack.any(axis=(1, 2)),
    }, counted


def keeps(values, limit, bound):
    """Return True where values keep a limit, taut and stable."""
    is_stable = values["stiffness"] >= -1e-12
    return (values[limit] <= bound * (1.0 + 1e-12)) & ~values["slack"] & is_stable


@pytest.mark.parametrize("name", CHECKED)
def test_a_window_is_where_a_sweep_over_pretensions_keeps_its_limit(name):
    wave = CHECKED[name].wave
    time = np.linspace(0.0, 2.0 / wave.frequency, 161)
    made = checked_suit(wave.trajectory(time, 0.5 / wave.frequency))
    pretensions = np.linspace(10.0, 400.0, SWEPT)
    swept, _ = values_at(made, pretensions)
    at_150, _ = values_at(made, np.array([150.0]))
    for limit, share in LIMITS.items():
        bound = share * float(at_150[limit][0])
        window = window_along(made, made.trajectory, Bounds(**{limit: bound}))
        is_inside = (pretensions >= window.low) & (pretensions <= window.high)
        np.testing.assert_array_equal(keeps(swept, limit, bound), is_inside, err_msg=limit)
        inward = 1e-6 * np.array([1.0, -1.0])
        at_low, _ = values_at(made, float(window.low) * (1.0 + inward))
        at_high, _ = values_at(made, float(window.high) * (1.0 - inward))
        assert keeps(at_low, limit, bound).tolist() == [True, False], limit
        assert keeps(at_high, limit, bound).tolist() == [True, False], limit


def test_limits_on_speed_and_power_name_the_moment_of_their_worst():
    wave = CHECKED["D"].wave
    time = np.linspace(0.0, 4.0, 401)
    made = checked_suit(wave.trajectory(time, 1.0))
    for limit, worst in (("peak_motor_speed", "spool_speed"), ("peak_motor_power", "power")):
        values, counted = values_at(made, np.array([150.0]))
        bound = LIMITS[limit] * float(values[limit][0])
        window = window_along(made, made.trajectory, Bounds(**{limit: bound}))
        bounded = "low" if LIMIT_NAMES[int(window.low_by)] == limit else "high"
        end = np.full((1, 1, 1), float(getattr(window, bounded)))
        rates = moving(made).at_pretension(end).motor_rates
        series = np.abs(getattr(rates, worst)).ravel()[counted]
        moment = counted.start + int(series.argmax())
        assert int(getattr(window, f"{bounded}_state")) % len(time) == moment
