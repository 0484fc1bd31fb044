"""Balance, slack, required pretension and stiffness over random designs (Eqs. 4, 5 and 12-20)."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from tendon_cli.model import actuator, statics
from tendon_cli.model.statics import (
    EXTENSOR_SLACK,
    FLEXOR_SLACK,
    NO_EQUILIBRIUM,
    TAUT,
)

from . import rig
from .designs import design, scattered

COUNT = 3000
SLACK_SIDES = ("flexor", "extensor")


def drawn(seed, **fixed):
    p, angle, flexion = scattered(COUNT, seed)
    return p | {name: np.full(COUNT, value) for name, value in fixed.items()}, angle, flexion


def evaluate(p, angle, flexion):
    return actuator.evaluate(design(p), angle, flexion)


def test_both_models_agree_on_everything_where_nothing_is_slack():
    p, angle, flexion = drawn(6, unilateral=True)
    hard, soft = (
        evaluate(p, angle, flexion),
        evaluate(p | {"unilateral": np.zeros(COUNT, bool)}, angle, flexion),
    )
    taut = hard.status == TAUT
    for name in (
        "flexor_tension_proximal",
        "extensor_tension_proximal",
        "motor_torque",
        "spool_angle",
    ):
        np.testing.assert_array_equal(getattr(hard, name)[taut], getattr(soft, name)[taut])
    np.testing.assert_array_equal(hard.elbow_stiffness[taut], soft.elbow_stiffness[taut])


def test_a_search_on_the_rig_finds_the_same_required_pretension():
    p, angle, flexion = drawn(23, unilateral=False)
    tied = actuator.State.of(design(p), angle, flexion).coupling
    required = statics.respond(tied).required
    sheaths = rig.compliances(p, flexion)
    stiff = {side: tendon + spring for side, (_, tendon, spring) in sheaths.items()}
    for i in np.flatnonzero(np.abs(required) < 2e3)[:150]:

        def least_tension(pretension, i=i):
            values = rig.row(p, i) | {
                "flexor_pretension": pretension,
                "extensor_pretension": pretension,
            }
            outcome = rig.Bench(values, stiff["flexor"][i], stiff["extensor"][i]).settle(
                float(angle[i])
            )
            return min(outcome.flexor, outcome.extensor)

        found = brentq(least_tension, -1e4, 1e4, xtol=1e-9)
        assert required[i] == pytest.approx(found, abs=1e-7)


@pytest.mark.parametrize("unilateral", [True, False])
@pytest.mark.parametrize("tightened", [("flexor",), ("extensor",), ("flexor", "extensor")])
def test_more_pretension_on_any_side_never_lowers_a_tension(unilateral, tightened):
    p, angle, flexion = drawn(25, unilateral=unilateral)
    more = p | {f"{side}_pretension": p[f"{side}_pretension"] + 20.0 for side in tightened}
    before, after = evaluate(p, angle, flexion), evaluate(more, angle, flexion)
    here = before.status != NO_EQUILIBRIUM
    for side in SLACK_SIDES:
        rise = (getattr(after.balance, side) - getattr(before.balance, side))[here]
        assert (rise >= 0).all()
        taut = (before.status == TAUT)[here]
        assert (rise[taut] > 0).all()
    assert (after.balance.loose[here] <= before.balance.loose[here]).all()


# --- Limits and symmetries ------------------------------------------------------------------------

EVERY_RESULT = (
    "flexor_tension_proximal",
    "extensor_tension_proximal",
    "flexor_slack",
    "extensor_slack",
    "elbow_torque",
    "motor_torque",
    "spool_angle",
    "elbow_stiffness",
    "status",
)


@pytest.mark.parametrize("name", ["friction", "bend_angle"])
@pytest.mark.parametrize("unilateral", [True, False])
def test_without_friction_or_bend_both_directions_are_the_same(name, unilateral):
    p, angle, _ = drawn(30, unilateral=unilateral)
    p |= {f"{side}_{name}": np.zeros(COUNT) for side in SLACK_SIDES}
    there, back = (evaluate(p, angle, np.full(COUNT, flexion)) for flexion in (True, False))
    for result in EVERY_RESULT:
        np.testing.assert_array_equal(getattr(there, result), getattr(back, result))
    np.testing.assert_array_equal(there.flexor_tension_proximal, there.balance.flexor)
    np.testing.assert_array_equal(there.extensor_tension_proximal, there.balance.extensor)


FORCES = ("pretension", "spring_stiffness", "youngs_modulus")
LENGTHS = ("a1", "b1", "a2", "b2", "elbow_radius", "forearm_com", "load_distance", "flexor_radius")


def assert_scaled(before, after, factors):
    here = before.status != NO_EQUILIBRIUM
    np.testing.assert_array_equal(before.status, after.status)
    for name, factor in factors.items():
        old, new = (
            getattr(state.balance if name == "loose" else state, name) for state in (before, after)
        )
        size = np.max(np.abs(old[np.isfinite(old)]), initial=0.0)
        np.testing.assert_allclose(
            new[here], factor * old[here], rtol=1e-9, atol=factor * size * 1e-12
        )


MASSES = ("forearm_mass", "load_mass")
SAME = dict.fromkeys(
    ("flexor_tension_proximal", "spool_angle", "flexor_slack", "extensor_slack", "loose"), 0
)
TIMES = dict.fromkeys(("motor_torque", "elbow_torque", "elbow_stiffness"), 1)
SCALES = {
    "forces": (dict.fromkeys(FORCES, 1), MASSES, SAME | TIMES | {"flexor_tension_proximal": 1}),
    # The tendon's section stays, so that its compliance grows with its length as the spring's does with 1/K.
    "lengths": (
        {"length": 1, "spring_stiffness": -1},
        LENGTHS,
        SAME | TIMES | dict.fromkeys(("flexor_slack", "extensor_slack", "loose"), 1),
    ),
}


@pytest.mark.parametrize("unilateral", [True, False])
@pytest.mark.parametrize("factor", [1 / 16, 3.0])
@pytest.mark.parametrize("scaled", SCALES)
def test_all_forces_and_all_lengths_scale_together(scaled, factor, unilateral):
    p, angle, flexion = drawn(32, unilateral=unilateral)
    of_sides, names, powers = SCALES[scaled]
    q = p | {name: factor * p[name] for name in names}
    q |= {
        f"{side}_{name}": p[f"{side}_{name}"] * factor**power
        for side in SLACK_SIDES
        for name, power in of_sides.items()
    }
    factors = {name: factor**power for name, power in powers.items()}
    assert_scaled(evaluate(p, angle, flexion), evaluate(q, angle, flexion), factors)


def test_a_larger_flexor_spool_turns_less_with_more_torque_at_the_same_tensions():
    p, angle, flexion = drawn(34, unilateral=True)
    q = p | {"flexor_radius": 2 * p["flexor_radius"]}
    before, after = evaluate(p, angle, flexion), evaluate(q, angle, flexion)
    np.testing.assert_array_equal(before.balance.flexor, after.balance.flexor)
    np.testing.assert_array_equal(before.motor_torque * 2, after.motor_torque)
    np.testing.assert_array_equal(before.spool_angle, after.spool_angle * 2)


POSITIVE = st.floats(0.01, 0.2)
COMPLIANCE = st.floats(1e-5, 2e-3)
PRETENSION = st.floats(0.0, 400.0)


@given(
    POSITIVE,
    POSITIVE,
    st.floats(0.3, 3.0),
    COMPLIANCE,
    COMPLIANCE,
    st.floats(-0.2, 0.2),
    st.floats(-0.2, 0.2),
    st.floats(-30.0, 60.0),
    PRETENSION,
    PRETENSION,
    st.booleans(),
)
@settings(max_examples=500)
def test_exchanging_the_tendons_turns_the_spool_ratio_over(
    arm, radius, ratio, c_f, c_e, h_f, h_e, torque, f_f, f_e, unilateral
):
    """What flexes in one arm extends in its mirror image, with the ratio 1/η and both travels exchanged."""
    one = statics.Coupling(
        moment_arm=np.asarray(arm),
        extensor_arm=radius,
        ratio=ratio,
        flexor_compliance=np.asarray(c_f),
        extensor_compliance=np.asarray(c_e),
        mismatch=np.asarray(h_e - ratio * h_f),
        elbow_torque=np.asarray(torque),
    )
    other = statics.Coupling(
        moment_arm=np.asarray(radius),
        extensor_arm=arm,
        ratio=1 / ratio,
        flexor_compliance=np.asarray(c_e),
        extensor_compliance=np.asarray(c_f),
        mismatch=np.asarray(h_e / ratio - h_f),
        elbow_torque=np.asarray(-torque),
    )
    a = statics.solve(one, f_f, f_e, unilateral=unilateral)
    b = statics.solve(other, f_e, f_f, unilateral=unilateral)
    near = 1e-10 * max(
        f_f, f_e, abs(a.flexor), abs(a.extensor), abs(torque / arm), abs(torque / radius)
    )
    near += 1e-10 * (abs(h_f) * ratio + abs(h_e)) / (ratio * c_f + c_e) * max(1.0, radius / arm)
    assert a.flexor == pytest.approx(float(b.extensor), abs=near)
    assert a.extensor == pytest.approx(float(b.flexor), abs=near)
    assert a.loose == pytest.approx(ratio * float(b.loose), abs=near * (ratio * c_f + c_e))
    assert statics.respond(one).required == pytest.approx(
        float(statics.respond(other).required), abs=near
    )
    least = (
        min(abs(a.flexor), abs(a.extensor))
        if not unilateral
        else abs(float(a.loose)) / (ratio * c_f + c_e)
    )
    if least > 1e-6 * (f_f + f_e + 1) and least > 2 * near:
        exchanged = {FLEXOR_SLACK: EXTENSOR_SLACK, EXTENSOR_SLACK: FLEXOR_SLACK}
        assert int(b.status) == exchanged.get(int(a.status), int(a.status))


def test_exactly_at_the_edge_rounding_does_not_make_a_state_slack():
    edge = statics.Coupling(
        moment_arm=np.asarray(0.1),
        extensor_arm=0.05,
        ratio=1.0,
        flexor_compliance=np.asarray(3e-4),
        extensor_compliance=np.asarray(3e-4),
        mismatch=np.asarray(-0.01),
        elbow_torque=np.asarray(7.0),
    )
    least = float(statics.respond(edge).required)
    for share, status in ((1 + 1e-11, TAUT), (1 - 1e-11, TAUT), (1 - 1e-7, EXTENSOR_SLACK)):
        for unilateral in (True, False):
            balance = statics.solve(edge, share * least, share * least, unilateral=unilateral)
            assert balance.status == status
    mirrored = replace(edge, elbow_torque=np.asarray(-7.0))
    least = float(statics.respond(mirrored).required)
    assert statics.solve(mirrored, least, least).status == TAUT
    assert statics.solve(mirrored, least * (1 - 1e-7), least * (1 - 1e-7)).status == FLEXOR_SLACK
