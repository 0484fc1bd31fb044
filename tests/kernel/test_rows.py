"""The compiled code writes, bit for bit, the rows of the states table that NumPy writes."""

import itertools
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
from tests.sampled import quick_and_torture

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
"""A study of designs that are taut and slack on either side, up to and past the dead centre."""

WEIGHTLESS = {
    "arm.forearm_mass": 0.0,
    "tendon.pretension": [0.0, 5.0, 500.0],
    "motion.elbow_angle": [-0.2, 0.0, 1.2],
}


def statuses(blocks):
    return set(all_states(blocks, "status").tolist())


def test_the_models_and_references_side_by_side():
    """Each case of a block has the results that it has alone."""
    choices = list(itertools.product(("unilateral", "bilateral"), ("published", "initial")))
    cases = [{"name": " ".join(choice), "model": model(*choice)} for choice in choices]
    (mixed,) = assert_same_rows(plan_of(VARIED | {"cases": cases}), [0.2, 0.6])
    for case, (slack, reference) in enumerate(choices):
        plan = plan_of(VARIED | {"model": model(slack, reference)})
        (alone,) = assert_same_rows(plan, [0.37])
        assert statuses([alone]) >= {TAUT, FLEXOR_SLACK, EXTENSOR_SLACK, NO_EQUILIBRIUM}
        assert np.isnan(alone["flexor_slack"]).all() == (slack == "bilateral")
        for name in (
            "status",
            "flexor_tension_distal",
            "spool_angle",
            "extensor_slack",
            "elbow_stiffness",
        ):
            of_case = np.split(mixed[name], len(choices))[case]
            assert same_bits(of_case, alone[name]), name


@pytest.mark.parametrize("slack", ["unilateral", "bilateral"])
def test_no_load_at_all(slack):
    """The tendons of a weightless arm go slack together, and the spool may turn as it likes."""
    numbers = WEIGHTLESS | {"model": model(slack), "arm.upper_arm_angle": [-0.3, 0.0]}
    blocks = assert_same_rows(plan_of(numbers))
    assert statuses(blocks) == {TAUT, BOTH_SLACK}
    both_slack = all_states(blocks, "status") == BOTH_SLACK
    is_free = both_slack & (slack == "unilateral")
    assert np.array_equal(np.isnan(all_states(blocks, "spool_angle")), is_free)


@pytest.mark.parametrize("slack", ["unilateral", "bilateral"])
def test_angles_past_the_dead_centre_only(slack):
    plan = plan_of({"motion.elbow_angle": [2.9, 2.95, 3.0], "model": model(slack)})
    blocks = assert_same_rows(plan)
    assert statuses(blocks) == {NO_EQUILIBRIUM}
    assert np.isfinite(all_states(blocks, "flexor_moment_arm")).all()
    assert np.isnan(all_states(blocks, "motor_torque")).all()


def test_coincident_anchors():
    """The flexor has no direction where its anchors are in one place to the last bit."""
    sine_of_half_a_turn = float(np.sin(np.pi))
    meet_at_180_degrees = {"a1": 0.15 * sine_of_half_a_turn, "b1": 0.15, "a2": 0.0, "b2": 0.15}
    angles = [1.0, math.pi, 3.0, 3.2]
    blocks = assert_same_rows(
        plan_of({"motion.elbow_angle": angles}, unchecked=meet_at_180_degrees)
    )
    assert np.isnan(all_states(blocks, "flexor_moment_arm")).sum() == 2
    meet_at_90_degrees = {"a1": 0.15, "b1": 0.0, "a2": 0.0, "b2": 0.15}
    angles = [0.3, 0.5 * math.pi, 1.9]
    blocks = assert_same_rows(plan_of({"motion.elbow_angle": angles}, unchecked=meet_at_90_degrees))
    assert statuses(blocks) >= {TAUT, NO_EQUILIBRIUM}


@pytest.mark.parametrize("directions", DIRECTIONS, ids=str)
def test_angles_on_both_sides_of_what_is_taken_at_a_time(directions):
    for count in COUNTS:
        numbers = {
            "tendon.pretension": [2.0, 90.0],
            "sheath.extensor.friction": 0.1,
            "motion.elbow_angle": np.linspace(-0.6, 2.9, count).tolist(),
            "motion.direction": directions,
        }
        assert_same_rows(plan_of(numbers))


@pytest.mark.parametrize("block_states", quick_and_torture([20], [2**15, 7]))
def test_any_cut_of_a_block_gives_the_same_rows(block_states):
    """Blocks that are less than a design may be cut, too."""
    places = np.linspace(0.0, 1.0, 103)
    numbers = {
        "tendon.pretension": [2.0, 90.0, 200.0],
        "motion.elbow_angle": np.linspace(-0.6, 2.9, 17).tolist(),
        "motion.direction": ["extension", "flexion"],
    }
    for step in (1, 2, 7, 34, 50):
        assert_same_rows(plan_of(numbers, block_states=block_states), places[::step])


def _response(numbers, slack="unilateral"):
    """Return the response to pretension of the tensions of a study in one block."""
    plan = plan_of(numbers)
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
    """A state is taut at its limit, and slack with the next smaller pretension."""
    angles = np.linspace(0.1, 1.5, 15).tolist()
    numbers = {"motion.elbow_angle": angles, "model": model(slack)} | load
    response = _response(numbers, slack)
    limits = np.fmax(response.flexor_limit, response.extensor_limit)
    limits = limits[limits > 0.0]
    pretensions = np.unique([np.nextafter(limits, 0.0), limits])
    plan = plan_of(numbers | {"tendon.pretension": pretensions.tolist()})
    (columns,) = assert_same_rows(plan)
    is_slack = (columns["status"] > TAUT).reshape(len(pretensions), -1)
    changes = np.diff(is_slack.astype(int), axis=0)
    assert np.abs(changes).sum() == len(limits)
    assert len(limits) > 10


def test_a_load_that_just_counts_as_none():
    """The last bits of forces decide whether a torque picks the slack side."""
    numbers = {
        "arm.forearm_mass": 0.0,
        "motion.elbow_angle": 0.4,
        "tendon.pretension": 0.0,
        "spool.ratio": 1.2,
        "motion.direction": "flexion",
    }
    force_per_mass = _response(numbers | {"load.mass": 1.0}).flexor_floor.item()
    mass = 0.0
    for _ in range(3):
        required = _response(numbers | {"load.mass": mass}).required.item()
        mass = SLACK_TOLERANCE * abs(required) / force_per_mass
    around = 1.0 + np.arange(-200, 201) * 2.0**-52
    numbers["load.mass"] = np.unique(mass * around).tolist()
    numbers["spool.ratio"] = (1.2 * around[192:209]).tolist()
    response = _response(numbers)
    assert (response.flexor_floor == SLACK_TOLERANCE * np.abs(response.required)).any()
    assert statuses(assert_same_rows(plan_of(numbers))) == {EXTENSOR_SLACK, BOTH_SLACK}


def test_nulls_are_told_of_the_rows_that_have_them():
    """Each state is in a stretch of its own, and some have no null."""
    numbers = {
        "tendon.pretension": [0.0, 500.0],
        "arm.forearm_mass": 0.0,
        "motion.elbow_angle": [0.5, 1.0, 2.9],
    }
    (columns,) = assert_same_rows(plan_of(numbers), np.linspace(0.0, 1.0, 13) + 1e-9)
    names = ("spool_angle", "motor_torque", "flexor_travel")
    nulls = np.transpose([np.isnan(columns[name]) for name in names])
    assert {tuple(row) for row in nulls.tolist()} == {
        (True, False, False),
        (False, False, False),
        (True, True, False),
    }


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
