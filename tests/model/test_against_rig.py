"""The closed forms agree with an integration along the sheath and a root search for the spool."""

from collections import Counter
from itertools import product
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
    """Return random parameters, elbow angles and directions."""
    draw, count = request.param
    return draw(count, seed=20240)


@pytest.fixture(scope="module")
def outcomes(drawn):
    """Return the outcomes on the rig."""
    return rig.run(*drawn)


@pytest.fixture(scope="module")
def state(drawn):
    """Return the states of the closed forms."""
    p, angle, flexion = drawn
    return actuator.evaluate(design(p), angle, flexion)


@pytest.fixture(scope="module")
def largest(drawn, state):
    """Return the largest tension, length and stiffness of each state: errors are shares of them."""
    p, *_ = drawn
    motion = state.motion
    balance = state.balance
    pretensions = [p["flexor_pretension"], p["extensor_pretension"]]
    tensions = np.abs([balance.flexor, balance.extensor, *pretensions])
    wound = p["flexor_radius"] * state.spool_angle
    lengths = np.abs([motion.flexor_path, motion.extensor_travel, wound])
    stiffness = (
        motion.flexor_moment_arm**2 / state.flexor.compliance
        + p["elbow_radius"] ** 2 / state.extensor.compliance
        + np.abs(balance.flexor * motion.flexor_moment_arm_slope)
        + np.abs(state.elbow_torque)
    )
    return {
        "tension": np.nanmax(tensions, axis=0),
        "length": np.nanmax(lengths, axis=0),
        "stiffness": np.where(np.isnan(stiffness), 1.0, stiffness),
    }


def column(outcomes, name):
    """Return one reading of all outcomes, NaN if there is none."""
    return np.array([getattr(outcome, name) for outcome in outcomes], dtype=float)


def assert_same(values, expected, scale):
    np.testing.assert_array_equal(np.isnan(values), np.isnan(expected))
    error = np.abs(values - expected) / scale
    worst = np.nanmax(error)
    assert worst <= TIGHT, f"worst is number {np.nanargmax(error)}, off by {worst:.3g}"


def test_the_draw_holds_every_kind_of_state_in_both_directions_and_models(drawn, outcomes):
    p, _, flexion = drawn
    statuses = [outcome.status for outcome in outcomes]
    kinds = Counter(zip(p["unilateral"].tolist(), flexion.tolist(), statuses, strict=True))
    is_ideal = len(flexion) == COUNT
    fewest = 12 if is_ideal else 0
    fewest_in_all = 80 if is_ideal else 5
    for name in STATUS_NAMES:
        counts = [kinds[*sides, name] for sides in product((True, False), repeat=2)]
        assert min(counts) >= fewest, kinds
        assert sum(counts) >= fewest_in_all, kinds


def test_the_rig_finds_the_same_kind_of_state(state, outcomes):
    names = [STATUS_NAMES[index] for index in state.status]
    assert names == [outcome.status for outcome in outcomes]


@pytest.mark.parametrize("side", rig.SIDES)
def test_the_rig_finds_the_same_sheath(drawn, state, side):
    p, _, flexion = drawn
    gain, tendon, spring = rig.compliances(p, flexion)[side]
    sheath = getattr(state, side)
    np.testing.assert_allclose(sheath.capstan, 1 / gain, rtol=1e-11)
    np.testing.assert_allclose(sheath.tendon, tendon, rtol=1e-11)
    np.testing.assert_allclose(sheath.compliance, tendon + spring, rtol=1e-11)
    if "joint_stiffness" not in p:
        np.testing.assert_allclose(sheath.spring * p[f"{side}_spring_stiffness"], 1.0, rtol=1e-14)


@pytest.mark.parametrize("side", rig.SIDES)
def test_the_rig_finds_the_same_of_each_side(drawn, state, outcomes, largest, side):
    p, _, flexion = drawn
    distal = column(outcomes, side)
    slack = column(outcomes, f"{side}_slack")
    gain, _, _ = rig.compliances(p, flexion)[side]
    assert_same(getattr(state.balance, side), distal, largest["tension"])
    scale = np.fmax(largest["tension"], np.abs(gain * distal))
    assert_same(getattr(state, f"{side}_tension_proximal"), gain * distal, scale)
    assert_same(getattr(state, f"{side}_slack"), slack, largest["length"])


def test_the_rig_finds_the_same_spool_angle_motor_torque_and_stiffness(
    drawn, state, outcomes, largest
):
    """The rig's stiffness comes from solving again with the motor held."""
    p, _, flexion = drawn
    radius = p["flexor_radius"]
    sheaths = rig.compliances(p, flexion)
    wound = radius * column(outcomes, "spool_angle")
    assert_same(radius * state.spool_angle, wound, largest["length"])
    on_flexor_spool = radius * sheaths["flexor"][0] * column(outcomes, "flexor")
    on_extensor_spool = p["ratio"] * radius * sheaths["extensor"][0] * column(outcomes, "extensor")
    larger_torque = np.fmax(np.abs(on_flexor_spool), on_extensor_spool)
    scale = np.fmax(largest["tension"] * radius, larger_torque)
    assert_same(state.motor_torque, on_flexor_spool - on_extensor_spool, scale)
    assert_same(state.elbow_stiffness, column(outcomes, "stiffness"), largest["stiffness"])


def test_the_rig_finds_the_same_loose_path_also_where_both_tendons_are_slack(
    drawn, state, outcomes, largest
):
    p, *_ = drawn
    unilateral = p["unilateral"]
    on_the_rig = column(outcomes, "loose")
    loose = np.where(unilateral, state.balance.loose, np.nan)
    assert_same(loose, on_the_rig, largest["length"])
    both_slack = unilateral & (on_the_rig > 0) & np.isnan(column(outcomes, "spool_angle"))
    fewest = 40 if len(both_slack) == COUNT else 5
    assert both_slack.sum() >= fewest
    in_balance = ~unilateral & (state.motion.flexor_moment_arm > 0)
    np.testing.assert_array_equal(state.balance.loose[in_balance], 0.0)


def test_vectors_give_the_same_paths_travels_moment_arms_and_weights(drawn, state):
    p, angles, _ = drawn
    rows = [rig.row(p, i) for i in range(len(angles))]

    def on_the_rig(function):
        return np.array([function(row, angle) for row, angle in zip(rows, angles, strict=True)])

    path, moment_arm = on_the_rig(rig.line_of_action).T
    shorter, longer = on_the_rig(rig.travels).T
    weight = on_the_rig(rig.weight_moment)
    motion = state.motion
    np.testing.assert_allclose(motion.flexor_path, path, rtol=1e-12)
    np.testing.assert_allclose(motion.flexor_moment_arm, moment_arm, rtol=0, atol=1e-12)
    np.testing.assert_allclose(motion.flexor_travel, shorter, rtol=0, atol=1e-14)
    np.testing.assert_allclose(motion.extensor_travel, longer, rtol=1e-15)
    held = np.where(moment_arm > 0, weight, np.nan)
    np.testing.assert_allclose(state.elbow_torque, held, rtol=1e-12, atol=1e-14)


def test_where_the_bends_lie_along_the_sheath_matters_little_to_the_tensions():
    """The ratio needs the total bend alone (Eq. A.17); Eq. 13's elongation supposes an even bend.

    That elongation is small.
    """
    angle = np.radians(np.tile(np.arange(5.0, 91.0, 5.0), 2))
    flexion = np.repeat([True, False], len(angle) // 2)
    numbers = baseline(load_mass=3.0, pretension=200.0)
    p = {name: np.full(len(angle), value) for name, value in numbers.items()}
    state = actuator.evaluate(design(p), angle, flexion)
    for profile in (lambda s: 2 * s, lambda s: 2 - 2 * s):
        outcomes = rig.run(p, angle, flexion, profile=profile)
        for side in rig.SIDES:
            change = np.abs(getattr(state.balance, side) - column(outcomes, side)) / 200.0
            assert 0 < change.max() < 0.005


def test_the_comparison_with_mujoco_takes_the_model_as_it_is(monkeypatch):
    """The comparison itself is made elsewhere, where MuJoCo is installed."""
    monkeypatch.syspath_prepend(Path(__file__).parents[2])
    from verification.cases import draw_cases
    from verification.tool import answers

    results = answers(draw_cases(20))
    assert {values.shape for values in results.values.values()} == {(20,)}
