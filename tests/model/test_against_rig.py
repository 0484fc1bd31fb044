"""Every result of the closed forms against an integration along the sheath and a root search for the spool angle."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from tendon_cli.model import actuator
from tendon_cli.model.statics import STATUS_NAMES

from . import rig
from .designs import baseline, design, scattered, worn

COUNT = 2400
TIGHT = 1e-9


@pytest.fixture(scope="module", params=[(scattered, COUNT), (worn, 800)], ids=["ideal", "worn"])
def drawn(request):
    draw, count = request.param
    return draw(count, seed=20240)


@pytest.fixture(scope="module")
def outcomes(drawn):
    return rig.run(*drawn)


@pytest.fixture(scope="module")
def state(drawn):
    p, angle, flexion = drawn
    return actuator.evaluate(design(p), angle, flexion)


@pytest.fixture(scope="module")
def largest(drawn, state):
    """Per state the largest tension, length, and moment per radian, as the measures of what counts as equal."""
    p, *_ = drawn
    tensions = np.abs(
        [
            state.balance.flexor,
            state.balance.extensor,
            p["flexor_pretension"],
            p["extensor_pretension"],
        ]
    )
    motion = state.motion
    lengths = np.abs(
        [motion.flexor_path, motion.extensor_travel, p["flexor_radius"] * state.spool_angle]
    )
    stiffness = (
        motion.flexor_moment_arm**2 / state.flexor.compliance
        + p["elbow_radius"] ** 2 / state.extensor.compliance
        + np.abs(state.balance.flexor * motion.flexor_moment_arm_slope)
        + np.abs(state.elbow_torque)
    )
    return {
        "tension": np.nanmax(tensions, axis=0),
        "length": np.nanmax(lengths, axis=0),
        "stiffness": np.where(np.isnan(stiffness), 1.0, stiffness),
    }


def column(outcomes, name):
    return np.array([getattr(outcome, name) for outcome in outcomes], dtype=float)


def assert_same(found, expected, scale):
    np.testing.assert_array_equal(np.isnan(found), np.isnan(expected))
    error = np.abs(found - expected) / scale
    assert np.nanmax(error) <= TIGHT, (
        f"worst is number {np.nanargmax(error)}, off by {np.nanmax(error):.3g}"
    )


def test_the_draw_holds_every_kind_of_state_in_both_directions_and_models(drawn, outcomes):
    p, _, flexion = drawn
    kinds = Counter(
        (bool(u), bool(f), outcome.status)
        for u, f, outcome in zip(p["unilateral"], flexion, outcomes, strict=True)
    )
    rare = min(
        kinds[u, f, name] for u in (True, False) for f in (True, False) for name in STATUS_NAMES
    )
    share = len(flexion) / COUNT
    assert rare >= (12 if share == 1.0 else 0), kinds
    for name in STATUS_NAMES:
        assert sum(kinds[u, f, name] for u in (True, False) for f in (True, False)) >= (
            80 if share == 1.0 else 5
        ), kinds


def test_the_rig_finds_the_same_kind_of_state(state, outcomes):
    assert [STATUS_NAMES[index] for index in state.status] == [
        outcome.status for outcome in outcomes
    ]


@pytest.mark.parametrize("side", rig.SIDES)
def test_the_rig_finds_the_same_sheath(drawn, state, side):
    p, _, flexion = drawn
    gain, tendon, spring = rig.compliances(p, flexion)[side]
    found = getattr(state, side)
    np.testing.assert_allclose(found.capstan, 1 / gain, rtol=1e-11)
    np.testing.assert_allclose(found.tendon, tendon, rtol=1e-11)
    np.testing.assert_allclose(found.compliance, tendon + spring, rtol=1e-11)
    if "joint_stiffness" not in p:
        np.testing.assert_allclose(found.spring * p[f"{side}_spring_stiffness"], 1.0, rtol=1e-14)


@pytest.mark.parametrize("side", rig.SIDES)
def test_the_rig_finds_the_same_of_each_side(drawn, state, outcomes, largest, side):
    p, _, flexion = drawn
    distal, gain = column(outcomes, side), rig.compliances(p, flexion)[side][0]
    assert_same(getattr(state.balance, side), distal, largest["tension"])
    scale = np.fmax(largest["tension"], np.abs(gain * distal))
    assert_same(getattr(state, f"{side}_tension_proximal"), gain * distal, scale)
    assert_same(
        getattr(state, f"{side}_slack"), column(outcomes, f"{side}_slack"), largest["length"]
    )


def test_the_rig_finds_the_same_spool_angle_motor_torque_and_stiffness(
    drawn, state, outcomes, largest
):
    """The stiffness by solving again with the motor held."""
    p, _, flexion = drawn
    radius, sheaths = p["flexor_radius"], rig.compliances(p, flexion)
    assert_same(
        radius * state.spool_angle, radius * column(outcomes, "spool_angle"), largest["length"]
    )
    on_flexor_spool = radius * sheaths["flexor"][0] * column(outcomes, "flexor")
    on_extensor_spool = p["ratio"] * radius * sheaths["extensor"][0] * column(outcomes, "extensor")
    scale = np.fmax(
        largest["tension"] * radius, np.fmax(np.abs(on_flexor_spool), on_extensor_spool)
    )
    assert_same(state.motor_torque, on_flexor_spool - on_extensor_spool, scale)
    assert_same(state.elbow_stiffness, column(outcomes, "stiffness"), largest["stiffness"])


def test_the_rig_finds_the_same_loose_path_also_where_both_tendons_are_slack(
    drawn, state, outcomes, largest
):
    unilateral = drawn[0]["unilateral"]
    found = np.where(unilateral, state.balance.loose, np.nan)
    assert_same(found, column(outcomes, "loose"), largest["length"])
    both = unilateral & (column(outcomes, "loose") > 0) & np.isnan(column(outcomes, "spool_angle"))
    assert both.sum() >= (40 if len(both) == COUNT else 5)
    in_balance = ~unilateral & (state.motion.flexor_moment_arm > 0)
    np.testing.assert_array_equal(state.balance.loose[in_balance], 0.0)


def test_vectors_give_the_same_paths_travels_moment_arms_and_weights(drawn, state):
    p, angle, _ = drawn
    rows = [rig.row(p, i) for i in range(len(angle))]
    path, moment_arm = np.array(
        [rig.line_of_action(one, at) for one, at in zip(rows, angle, strict=True)]
    ).T
    shorter, longer = np.array(
        [rig.travels(one, at) for one, at in zip(rows, angle, strict=True)]
    ).T
    weight = np.array([rig.weight_moment(one, at) for one, at in zip(rows, angle, strict=True)])
    motion = state.motion
    np.testing.assert_allclose(motion.flexor_path, path, rtol=1e-12)
    np.testing.assert_allclose(motion.flexor_moment_arm, moment_arm, rtol=0, atol=1e-12)
    np.testing.assert_allclose(motion.flexor_travel, shorter, rtol=0, atol=1e-14)
    np.testing.assert_allclose(motion.extensor_travel, longer, rtol=1e-15)
    held = np.where(moment_arm > 0, weight, np.nan)
    np.testing.assert_allclose(state.elbow_torque, held, rtol=1e-12, atol=1e-14)


def test_where_the_bends_lie_along_the_sheath_matters_little_to_the_tensions():
    """The ratio needs only the total (Eq. A.17); the elongation of Eq. 13 supposes an even bend, and is small."""
    angle = np.radians(np.tile(np.arange(5.0, 91.0, 5.0), 2))
    flexion = np.repeat([True, False], len(angle) // 2)
    p = {
        name: np.full(len(angle), value)
        for name, value in baseline(load_mass=3.0, pretension=200.0).items()
    }
    state = actuator.evaluate(design(p), angle, flexion)
    for profile in (lambda s: 2 * s, lambda s: 2 - 2 * s):
        outcomes = rig.run(p, angle, flexion, profile=profile)
        for side in rig.SIDES:
            moved = np.abs(getattr(state.balance, side) - column(outcomes, side)) / 200.0
            assert 0 < moved.max() < 0.005


def test_the_comparison_with_mujoco_takes_the_model_as_it_is(monkeypatch):
    """What is compared elsewhere, where MuJoCo is installed."""
    monkeypatch.syspath_prepend(Path(__file__).parents[2])
    from verification.cases import draw_cases
    from verification.tool import answers

    found = answers(draw_cases(20))
    assert {values.shape for values in found.values.values()} == {(20,)}
