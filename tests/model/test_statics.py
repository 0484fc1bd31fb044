"""Balance, slack, required pretension and stiffness over random designs (Eqs. 4, 5 and 12-20)."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from tendon_cli.model import actuator, statics
from tendon_cli.model.statics import EXTENSOR_SLACK, FLEXOR_SLACK, NO_EQUILIBRIUM, TAUT

from . import rig
from .designs import SIDES, design, scattered

COUNT = 3000


def drawn(seed, **fixed):
    """Return random parameters, some of them fixed, with elbow angles and directions."""
    p, angle, flexion = scattered(COUNT, seed)
    fixed_values = {name: np.full(COUNT, value) for name, value in fixed.items()}
    return p | fixed_values, angle, flexion


def evaluate(p, angle, flexion):
    return actuator.evaluate(design(p), angle, flexion)


def test_both_models_agree_on_everything_where_nothing_is_slack():
    p, angle, flexion = drawn(6, unilateral=True)
    hard = evaluate(p, angle, flexion)
    soft = evaluate(p | {"unilateral": np.zeros(COUNT, bool)}, angle, flexion)
    taut = hard.status == TAUT
    for name in (
        "flexor_tension_proximal",
        "extensor_tension_proximal",
        "motor_torque",
        "spool_angle",
        "elbow_stiffness",
    ):
        np.testing.assert_array_equal(getattr(hard, name)[taut], getattr(soft, name)[taut])


def pretension_of_tautness(numbers, compliances, angle):
    """Search the rig for the pretension at which the looser tendon is about to go slack."""

    def least_tension(pretension):
        pretensions = {f"{side}_pretension": pretension for side in SIDES}
        outcome = rig.Bench(numbers | pretensions, *compliances).settle(angle)
        return min(outcome.flexor, outcome.extensor)

    return brentq(least_tension, -1e4, 1e4, xtol=1e-9)


def test_a_search_on_the_rig_finds_the_same_required_pretension():
    p, angle, flexion = drawn(23, unilateral=False)
    coupling = actuator.State.of(design(p), angle, flexion).coupling
    required = statics.respond(coupling).required
    compliances = rig.total_compliances(p, flexion)
    for i in np.flatnonzero(np.abs(required) < 2e3)[:150]:
        both_compliances = [compliances[side][i] for side in SIDES]
        expected = pretension_of_tautness(rig.row(p, i), both_compliances, float(angle[i]))
        assert required[i] == pytest.approx(expected, abs=1e-7)


@pytest.mark.parametrize("unilateral", [True, False])
@pytest.mark.parametrize("tightened", [("flexor",), ("extensor",), ("flexor", "extensor")])
def test_more_pretension_on_any_side_never_lowers_a_tension(unilateral, tightened):
    p, angle, flexion = drawn(25, unilateral=unilateral)
    more = p | {f"{side}_pretension": p[f"{side}_pretension"] + 20.0 for side in tightened}
    before = evaluate(p, angle, flexion)
    after = evaluate(more, angle, flexion)
    answered = before.status != NO_EQUILIBRIUM
    taut = (before.status == TAUT)[answered]
    for side in SIDES:
        rise = (getattr(after.balance, side) - getattr(before.balance, side))[answered]
        assert (rise >= 0).all()
        assert (rise[taut] > 0).all()
    assert (after.balance.loose[answered] <= before.balance.loose[answered]).all()


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
    p |= {f"{side}_{name}": np.zeros(COUNT) for side in SIDES}
    flexing = evaluate(p, angle, np.full(COUNT, True))
    extending = evaluate(p, angle, np.full(COUNT, False))
    for result in EVERY_RESULT:
        np.testing.assert_array_equal(getattr(flexing, result), getattr(extending, result))
    np.testing.assert_array_equal(flexing.flexor_tension_proximal, flexing.balance.flexor)
    np.testing.assert_array_equal(flexing.extensor_tension_proximal, flexing.balance.extensor)


def result_of(state, name):
    """Return a result of a state or of its balance."""
    holder = state.balance if name == "loose" else state
    return getattr(holder, name)


def assert_scaled(before, after, factors):
    answered = before.status != NO_EQUILIBRIUM
    np.testing.assert_array_equal(before.status, after.status)
    for name, factor in factors.items():
        old = result_of(before, name)
        new = result_of(after, name)
        size = np.max(np.abs(old[np.isfinite(old)]), initial=0.0)
        np.testing.assert_allclose(
            new[answered], factor * old[answered], rtol=1e-9, atol=factor * size * 1e-12
        )


MASSES = ("forearm_mass", "load_mass")
LENGTHS = ("a1", "b1", "a2", "b2", "elbow_radius", "forearm_com", "load_distance", "flexor_radius")


@dataclass(frozen=True)
class Scaling:
    """Inputs that are scaled by a factor, and the powers of it by which results follow."""

    of_arm: tuple[str, ...]
    """Inputs scaled by the factor itself."""
    of_sides: dict[str, int]
    """Power of the factor for inputs of each side."""
    of_results: dict[str, int]
    """Power of the factor for results."""


SCALINGS = {
    "forces": Scaling(
        MASSES,
        {"pretension": 1, "spring_stiffness": 1, "youngs_modulus": 1},
        {
            "flexor_tension_proximal": 1,
            "motor_torque": 1,
            "elbow_torque": 1,
            "elbow_stiffness": 1,
            "spool_angle": 0,
            "flexor_slack": 0,
            "extensor_slack": 0,
            "loose": 0,
        },
    ),
    # The tendon's section stays: its compliance grows with its length, the spring's with 1/K.
    "lengths": Scaling(
        LENGTHS,
        {"length": 1, "spring_stiffness": -1},
        {
            "flexor_tension_proximal": 0,
            "motor_torque": 1,
            "elbow_torque": 1,
            "elbow_stiffness": 1,
            "spool_angle": 0,
            "flexor_slack": 1,
            "extensor_slack": 1,
            "loose": 1,
        },
    ),
}


@pytest.mark.parametrize("unilateral", [True, False])
@pytest.mark.parametrize("factor", [1 / 16, 3.0])
@pytest.mark.parametrize("scaled", SCALINGS)
def test_all_forces_and_all_lengths_scale_together(scaled, factor, unilateral):
    p, angle, flexion = drawn(32, unilateral=unilateral)
    scaling = SCALINGS[scaled]
    q = p | {name: factor * p[name] for name in scaling.of_arm}
    for side in SIDES:
        for name, power in scaling.of_sides.items():
            q[f"{side}_{name}"] = p[f"{side}_{name}"] * factor**power
    factors = {name: factor**power for name, power in scaling.of_results.items()}
    assert_scaled(evaluate(p, angle, flexion), evaluate(q, angle, flexion), factors)


def test_a_larger_flexor_spool_turns_less_with_more_torque_at_the_same_tensions():
    p, angle, flexion = drawn(34, unilateral=True)
    q = p | {"flexor_radius": 2 * p["flexor_radius"]}
    before = evaluate(p, angle, flexion)
    after = evaluate(q, angle, flexion)
    np.testing.assert_array_equal(before.balance.flexor, after.balance.flexor)
    np.testing.assert_array_equal(before.motor_torque * 2, after.motor_torque)
    np.testing.assert_array_equal(before.spool_angle, after.spool_angle * 2)


POSITIVE = st.floats(0.01, 0.2)
COMPLIANCE = st.floats(1e-5, 2e-3)
PRETENSION = st.floats(0.0, 400.0)


def balance_at(coupling, flexor_pretension, extensor_pretension, *, unilateral=True):
    """Return the balance of a state at pretensions of both sides."""
    response = statics.respond(coupling, unilateral=unilateral)
    pretension = coupling.common_pretension(flexor_pretension, extensor_pretension)
    return statics.Balance(coupling, response, pretension)


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
    """An arm's flexor is its mirror image's extensor, with the ratio 1/η and travels exchanged."""
    arm_itself = statics.Coupling(
        moment_arm=np.asarray(arm),
        extensor_arm=radius,
        ratio=ratio,
        flexor_compliance=np.asarray(c_f),
        extensor_compliance=np.asarray(c_e),
        mismatch=np.asarray(h_e - ratio * h_f),
        elbow_torque=np.asarray(torque),
    )
    mirror_image = statics.Coupling(
        moment_arm=np.asarray(radius),
        extensor_arm=arm,
        ratio=1 / ratio,
        flexor_compliance=np.asarray(c_e),
        extensor_compliance=np.asarray(c_f),
        mismatch=np.asarray(h_e / ratio - h_f),
        elbow_torque=np.asarray(-torque),
    )
    a = balance_at(arm_itself, f_f, f_e, unilateral=unilateral)
    b = balance_at(mirror_image, f_e, f_f, unilateral=unilateral)
    compliance = ratio * c_f + c_e
    largest_force = max(
        f_f, f_e, abs(a.flexor), abs(a.extensor), abs(torque / arm), abs(torque / radius)
    )
    force_of_travels = (abs(h_f) * ratio + abs(h_e)) / compliance * max(1.0, radius / arm)
    near = 1e-10 * largest_force + 1e-10 * force_of_travels
    assert a.flexor == pytest.approx(float(b.extensor), abs=near)
    assert a.extensor == pytest.approx(float(b.flexor), abs=near)
    assert a.loose == pytest.approx(ratio * float(b.loose), abs=near * compliance)
    required = statics.respond(arm_itself).required
    mirrored_required = statics.respond(mirror_image).required
    assert required == pytest.approx(float(mirrored_required), abs=near)
    slack_force = abs(float(a.loose)) / compliance
    least_tension = min(abs(a.flexor), abs(a.extensor))
    margin = slack_force if unilateral else least_tension
    if margin > 1e-6 * (f_f + f_e + 1) and margin > 2 * near:
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
            balance = balance_at(edge, share * least, share * least, unilateral=unilateral)
            assert balance.status == status
    mirrored = replace(edge, elbow_torque=np.asarray(-7.0))
    least = float(statics.respond(mirrored).required)
    assert balance_at(mirrored, least, least).status == TAUT
    assert balance_at(mirrored, least * (1 - 1e-7), least * (1 - 1e-7)).status == FLEXOR_SLACK
