"""Designs are the fold of their states, to the same bits, by whatever code."""

import numpy as np
import pytest

from tendon_cli import kernel
from tendon_cli.model import extremes
from tendon_cli.model.design import Design, Limb, Side
from tendon_cli.model.kinematics import Anchors
from tendon_cli.model.statics import NO_EQUILIBRIUM, TAUT
from tests.model.designs import BOTH_DIRECTIONS
from tests.sampled import quick_and_torture

from .filling import kinds_of_code, needs_code, same_bits
from .random_states import States, random_states

SLACKS = ["unilateral", "bilateral", "both"]


def seeded_states(seed, slack):
    return random_states(np.random.default_rng([seed, len(slack)]), slack)


def rows_of(states):
    """Return every column of the states by the chosen code, (designs' axes, states of each)."""
    shape = states.shape
    count = int(np.prod(shape))
    columns = {name: np.empty(count) for name in states.state.columns()}
    columns["status"] = np.empty(count, np.int8)
    kernel.row_writer(states.state, shape, {})(columns, range(count))
    return {name: column.reshape(*shape[:-2], -1) for name, column in columns.items()}


def largest_in_magnitude(values):
    """Return the value of largest magnitude with its sign; the positive of two that are equal."""
    magnitude = np.fmax.reduce(np.abs(values), axis=-1)
    low = np.fmin.reduce(values, axis=-1)
    high = np.fmax.reduce(values, axis=-1)
    return np.where((-low == magnitude) & (high < magnitude), low, magnitude)


def expected_extremes(states):
    """Return the extremes of designs from their rows alone; NaN for those of no state."""
    rows = rows_of(states)
    status = rows["status"]
    angles = np.broadcast_to(states.angles, states.shape).reshape(status.shape)

    def over_states(ufunc, *names):
        values = np.concatenate([rows[name] for name in names], axis=-1)
        return ufunc.reduce(values, axis=-1)

    def extensions(side):
        spring = np.broadcast_to(getattr(states.state, side).spring, states.shape)
        return rows[f"{side}_tension_distal"] * spring.reshape(status.shape)

    is_slack = (status != TAUT) & (status != NO_EQUILIBRIUM)
    extension = np.fmax(extensions("flexor"), extensions("extensor"))
    flexor_tensions = ("flexor_tension_distal", "flexor_tension_proximal")
    extensor_tensions = ("extensor_tension_distal", "extensor_tension_proximal")
    count = status.shape[-1]
    return {
        "min_flexor_tension": over_states(np.fmin, *flexor_tensions),
        "min_extensor_tension": over_states(np.fmin, *extensor_tensions),
        "max_tension": over_states(np.fmax, *flexor_tensions, *extensor_tensions),
        "max_spring_extension": np.fmax.reduce(extension, axis=-1),
        "peak_elbow_torque": largest_in_magnitude(rows["elbow_torque"]),
        "peak_motor_torque": largest_in_magnitude(rows["motor_torque"]),
        "min_elbow_stiffness": over_states(np.fmin, "elbow_stiffness"),
        "max_slack": over_states(np.fmax, "flexor_slack", "extensor_slack"),
        "slack_fraction": (status != TAUT).sum(axis=-1) / count,
        "unstable_fraction": (rows["elbow_stiffness"] < 0.0).sum(axis=-1) / count,
        "first_slack_angle": np.fmin.reduce(np.where(is_slack, angles, np.nan), axis=-1),
    }


def folded(states):
    """Return the fold over all states by the chosen code."""
    result = extremes.begin(states.shape[:-2])
    kernel.fold_extremes(result, states.state, states.angles, states.shape)
    return result


@needs_code
@pytest.mark.parametrize("slack", SLACKS)
@pytest.mark.parametrize("seed", quick_and_torture(range(10), range(10, 40)))
def test_designs_are_the_fold_of_their_states_to_the_same_bits(seed, slack):
    states = seeded_states(seed, slack)
    state_count = states.shape[-1] * states.shape[-2]
    with kinds_of_code() as (kinds, choose):
        choose(None)
        by_numpy = extremes.finish(folded(states), state_count)
        for kind in kinds:
            choose(kind)
            results = extremes.finish(folded(states), state_count)
            for name, values in expected_extremes(states).items():
                assert same_bits(values + 0.0, results[name]), (kind, name)
            for name, values in results.items():
                assert same_bits(values, by_numpy[name]), (kind, name)


@needs_code
@pytest.mark.parametrize("seed", quick_and_torture(range(10), range(10, 40)))
def test_the_strap_pulls_where_it_presses_and_the_spring_needs_room_between_its_anchors(seed):
    states = seeded_states(seed, "unilateral")
    state = states.state
    pulls = np.where(state.is_pressed, state.balance.extensor, 0.0)
    spring = state.design.flexor
    path = np.inf if state.motion.flexor_path is None else state.motion.flexor_path
    room = path - state.balance.flexor / np.asarray(spring.spring_stiffness)
    room = np.where(spring.spring_at_motor, np.inf, room)
    expected = {
        "max_strap_tension": over_designs(np.fmax, pulls, states),
        "min_room": over_designs(np.fmin, room, states),
    }
    with kinds_of_code() as (kinds, choose):
        for kind in (None, *kinds):
            choose(kind)
            found = folded(states)
            for name, values in expected.items():
                known = ~np.isnan(values)
                np.testing.assert_allclose(
                    found[name][known], values[known], rtol=1e-12, atol=1e-15
                )


def over_designs(ufunc, values, states):
    """Return the extreme of values of states for each design."""
    return ufunc.reduce(np.broadcast_to(values, states.shape), axis=(-2, -1))


@needs_code
def test_the_studies_of_this_page_have_states_of_every_kind():
    kinds_of_state = set()
    for seed in range(40):
        for slack in SLACKS:
            kinds_of_state |= set(seeded_states(seed, slack).state.status.flat)
    assert kinds_of_state == {0, 1, 2, 3, 4}


@needs_code
@pytest.mark.parametrize("most", [1, 5, 64])
def test_states_may_come_in_portions(most):
    states = random_states(np.random.default_rng(5), "unilateral")
    at_once = folded(states)
    in_portions = extremes.begin(states.shape[:-2])
    for start in range(0, len(states.angles), most):
        angles = states.angles[start : start + most]
        shape = (*states.shape[:-1], len(angles))
        kernel.fold_extremes(in_portions, states.at(angles), angles, shape)
    for name, values in at_once.items():
        assert same_bits(values + 0.0, in_portions[name] + 0.0), name


@needs_code
@pytest.mark.parametrize("springs", [1, 3, 8, 21])
@pytest.mark.parametrize("pretensions", [2, 7, 31, 65, 100])
@pytest.mark.parametrize("last", [True, False], ids=["pretension fastest", "pretension slowest"])
def test_it_does_not_matter_how_many_pretensions_go_with_how_many_designs(
    pretensions, springs, last
):
    along_first = (-1, 1, 1, 1)
    along_second = (1, -1, 1, 1)
    pretension = np.linspace(1.0, 300.0, pretensions)
    spring = np.linspace(1e3, 8e3, springs)
    if last:
        lengths = (springs, pretensions)
        spring = spring.reshape(along_first)
        pretension = pretension.reshape(along_second)
    else:
        lengths = (pretensions, springs)
        pretension = pretension.reshape(along_first)
        spring = spring.reshape(along_second)
    limb = Limb(Anchors(0.04, 0.15, 0.02, 0.15, 0.045), 1.54, 0.174, 0.32, 0.0)
    flexor = Side(0.07, np.pi, 2.0, 1.5e-3, 145e9, spring, pretension)
    extensor = Side(0.07, np.pi, 2.0, 1.5e-3, 145e9, spring, 2.0 * pretension)
    design = Design(limb, flexor, extensor, 0.03, 0.8, 3.0)
    angles = np.linspace(0.0, 1.6, 37)
    states = States(design, BOTH_DIRECTIONS, angles, (*lengths, 2, len(angles)))
    with kinds_of_code() as (kinds, choose):
        choose(None)
        by_numpy = folded(states)
        for kind in kinds:
            choose(kind)
            for name, values in folded(states).items():
                assert same_bits(values + 0.0, by_numpy[name] + 0.0), (kind, name)


@pytest.mark.parametrize("first", [1.2, 2.9], ids=["weightless", "past the dead centre"])
def test_no_slack_length_of_states_that_have_none(first):
    limb = Limb(Anchors(0.04, 0.15, 0.02, 0.15, 0.045), 0.0, 0.174, 0.32, 0.0)
    pretension = np.reshape([0.0, 1.0, 500.0], (-1, 1, 1))
    side = Side(0.07, np.pi, 2.0, 1.5e-3, 145e9, 3e3, pretension)
    design = Design(limb, side, side, 0.03, 1.0, 0.0)
    angles = first + np.linspace(0.0, 0.2, 5)
    states = States(design, BOTH_DIRECTIONS, angles, (3, 2, 5))
    result = extremes.begin((3,))
    extremes.fold(result, states.state, angles)
    lengths = extremes.finish(result, 10)["max_slack"]
    assert same_bits(expected_extremes(states)["max_slack"] + 0.0, lengths)
    assert np.isnan(lengths[:2]).all()
