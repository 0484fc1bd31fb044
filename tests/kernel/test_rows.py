"""The compiled code writes, bit for bit, the rows of the states table that NumPy writes."""

import math

import numpy as np
import pytest

from tendon_cli.model.statics import (
    BOTH_SLACK,
    EXTENSOR_SLACK,
    FLEXOR_SLACK,
    NO_EQUILIBRIUM,
    SLACK_TOLERANCE,
    TAUT,
    respond,
)

from .filling import (
    COUNTS,
    DIRECTIONS,
    all_states,
    assert_same_rows,
    model,
    needs_code,
    plan_of,
    same_bits,
)

pytestmark = needs_code

VARIED = {
    "tendon.pretension": [0.0, 3.0, 60.0, 400.0],
    "load.mass": [0.0, 6.0],
    "arm.upper_arm_angle": [-1.2, 0.3],
    "spool.ratio": [0.7, 1.1],
    "sheath.extensor.friction": 0.11,
    "spring.flexor.stiffness": 2000.0,
    "motion.elbow_angle": np.linspace(-0.6, 3.0, 13).tolist(),
}
"""Designs that are taut and slack on either side, up to and past the dead centre."""

WEIGHTLESS = {
    "arm.forearm_mass": 0.0,
    "tendon.pretension": [0.0, 5.0, 500.0],
    "motion.elbow_angle": [-0.2, 0.0, 1.2],
}


def statuses(expected):
    return set(all_states(expected, "status").tolist())


def test_the_models_and_references_side_by_side():
    """Cases in one block; each has the results that it has alone."""
    choices = [
        (slack, reference)
        for slack in ("unilateral", "bilateral")
        for reference in ("published", "initial")
    ]
    cases = [{"name": " ".join(choice), "model": model(*choice)} for choice in choices]
    (mixed,) = assert_same_rows(plan_of(VARIED | {"cases": cases}), [0.2, 0.6])
    for at, choice in enumerate(choices):
        (alone,) = assert_same_rows(plan_of(VARIED | {"model": model(*choice)}), [0.37])
        assert statuses([alone]) >= {TAUT, FLEXOR_SLACK, EXTENSOR_SLACK, NO_EQUILIBRIUM}
        assert np.isnan(alone["flexor_slack"]).all() == (choice[0] == "bilateral")
        for name in (
            "status",
            "flexor_tension_distal",
            "spool_angle",
            "extensor_slack",
            "elbow_stiffness",
        ):
            assert same_bits(np.split(mixed[name], len(choices))[at], alone[name]), name


@pytest.mark.parametrize("slack", ["unilateral", "bilateral"])
def test_no_load_at_all(slack):
    """Both tendons of a weightless arm go slack at once, and the spool may turn as it likes."""
    found = assert_same_rows(
        plan_of(WEIGHTLESS | {"model": model(slack), "arm.upper_arm_angle": [-0.3, 0.0]})
    )
    assert statuses(found) == {TAUT, BOTH_SLACK}
    unknown = np.isnan(all_states(found, "spool_angle"))
    assert np.array_equal(
        unknown, (all_states(found, "status") == BOTH_SLACK) & (slack == "unilateral")
    )


@pytest.mark.parametrize("slack", ["unilateral", "bilateral"])
def test_angles_past_the_dead_centre_only(slack):
    found = assert_same_rows(
        plan_of({"motion.elbow_angle": [2.9, 2.95, 3.0], "model": model(slack)})
    )
    assert statuses(found) == {NO_EQUILIBRIUM}
    assert np.isfinite(all_states(found, "flexor_moment_arm")).all()
    assert np.isnan(all_states(found, "motor_torque")).all()


def test_coincident_anchors():
    """At 180 degrees, where these are in one place to the last bit, the flexor has no direction at all."""
    sine_of_half_a_turn = float(np.sin(np.pi))
    level = {"a1": 0.15 * sine_of_half_a_turn, "b1": 0.15, "a2": 0.0, "b2": 0.15}
    found = assert_same_rows(
        plan_of({"motion.elbow_angle": [1.0, math.pi, 3.0, 3.2]}, unchecked=level)
    )
    assert np.isnan(all_states(found, "flexor_moment_arm")).sum() == 2
    level = {"a1": 0.15, "b1": 0.0, "a2": 0.0, "b2": 0.15}
    found = assert_same_rows(
        plan_of({"motion.elbow_angle": [0.3, 0.5 * math.pi, 1.9]}, unchecked=level)
    )
    assert statuses(found) >= {TAUT, NO_EQUILIBRIUM}


@pytest.mark.parametrize("directions", DIRECTIONS, ids=str)
@pytest.mark.parametrize("count", COUNTS)
def test_angles_on_both_sides_of_what_is_taken_at_a_time(count, directions):
    motion = {
        "motion.elbow_angle": np.linspace(-0.6, 2.9, count).tolist(),
        "motion.direction": directions,
    }
    assert_same_rows(
        plan_of({"tendon.pretension": [2.0, 90.0], "sheath.extensor.friction": 0.1} | motion)
    )


@pytest.mark.parametrize("block_states", [2**15, 20, 7])
def test_any_cut_of_a_block_gives_the_same_rows(block_states):
    """Also of blocks that are less than a design."""
    every = np.linspace(0.0, 1.0, 103)
    motion = {
        "motion.elbow_angle": np.linspace(-0.6, 2.9, 17).tolist(),
        "motion.direction": ["extension", "flexion"],
    }
    numbers = {"tendon.pretension": [2.0, 90.0, 200.0]} | motion
    for step in (1, 2, 7, 34, 50):
        assert_same_rows(plan_of(numbers, block_states=block_states), every[::step])


def _response(state, slack="unilateral"):
    """How the tensions of a study in one block follow their pretension."""
    plan = plan_of(state)
    (block,) = plan.blocks(range(plan.designs))
    return respond(plan.state(block).coupling, unilateral=slack == "unilateral")


@pytest.mark.parametrize(
    "load",
    [
        {"arm.upper_arm_angle": -1.7},
        {"load.mass": 2.0},
        {"arm.forearm_mass": 0.0, "spool.ratio": 1.2},
    ],
    ids=str,
)
@pytest.mark.parametrize("slack", ["unilateral", "bilateral"])
def test_pretension_at_the_limit_to_the_last_bit(slack, load):
    """At its limit a state is taut, and with the next smaller pretension slack."""
    state = {"motion.elbow_angle": np.linspace(0.1, 1.5, 15).tolist(), "model": model(slack)} | load
    response = _response(state, slack)
    limits = np.fmax(response.flexor_limit, response.extensor_limit)
    limits = limits[limits > 0.0]
    pretensions = np.unique([np.nextafter(limits, 0.0), limits])
    (found,) = assert_same_rows(plan_of(state | {"tendon.pretension": pretensions.tolist()}))
    changes = np.diff((found["status"] > TAUT).reshape(len(pretensions), -1).astype(int), axis=0)
    assert np.abs(changes).sum() == len(limits) > 10


def test_a_load_that_just_counts_as_none():
    """Forces in the last bits of which it is decided whether a torque picks the slack side."""
    state = {
        "arm.forearm_mass": 0.0,
        "motion.elbow_angle": 0.4,
        "tendon.pretension": 0.0,
        "spool.ratio": 1.2,
    }
    state |= {"motion.direction": "flexion"}
    force_per_mass, mass = _response(state | {"load.mass": 1.0}).flexor_floor.item(), 0.0
    for _ in range(3):
        mass = (
            SLACK_TOLERANCE
            * abs(_response(state | {"load.mass": mass}).required.item())
            / force_per_mass
        )
    around = 1.0 + np.arange(-200, 201) * 2.0**-52
    state |= {
        "load.mass": np.unique(mass * around).tolist(),
        "spool.ratio": (1.2 * around[192:209]).tolist(),
    }
    response = _response(state)
    assert (response.flexor_floor == SLACK_TOLERANCE * np.abs(response.required)).any()
    assert statuses(assert_same_rows(plan_of(state))) == {EXTENSOR_SLACK, BOTH_SLACK}


def test_nulls_are_told_of_the_rows_that_have_them():
    """Each state of these is in a stretch of its own, some without any null."""
    numbers = {
        "tendon.pretension": [0.0, 500.0],
        "arm.forearm_mass": 0.0,
        "motion.elbow_angle": [0.5, 1.0, 2.9],
    }
    (found,) = assert_same_rows(plan_of(numbers), np.linspace(0.0, 1.0, 13) + 1e-9)
    missing = np.array(
        [np.isnan(found[name]) for name in ("spool_angle", "motor_torque", "flexor_travel")]
    )
    assert {tuple(row) for row in missing.T.tolist()} == {(1, 0, 0), (0, 0, 0), (1, 1, 0)}


@pytest.mark.parametrize("slack", ["unilateral", "bilateral"])
@pytest.mark.parametrize(
    "axis",
    [
        {"spring.stiffness": [1e-3, 1.0, 1e12]},
        {"tendon.youngs_modulus": [1e3, 1e15]},
        {"spool.ratio": [1e-3, 1e3]},
        {"tendon.diameter": [1e-6, 1.0]},
        {"arm.b1": [1e-6, 100.0]},
        {"load.mass": [1e-300, 1e4]},
        {"tendon.pretension": [1e-300, 1e7]},
        {"arm.elbow_radius": [1e-6, 100.0]},
        {"arm.a1": [1e-300, 1e-150, 100.0]},
        {"sheath.friction": [1e-300, 10.0], "sheath.bend_angle": [1e-9, 10.0]},
    ],
    ids=str,
)
def test_numbers_at_the_ends_of_what_is_allowed(axis, slack):
    numbers = {
        "arm.a2": 0.0,
        "tendon.flexor.length": [0.3, 100.0],
        "motion.elbow_angle": [-6.0, 0.0, 1e-9, 0.7, 6.0],
    }
    assert_same_rows(plan_of(numbers | axis | {"model": model(slack)}))
