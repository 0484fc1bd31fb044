"""The paper's arm and actuator in numbers that were obtained twice.

They hold to all the digits they are printed with.
"""

from decimal import Decimal

import numpy as np
import pytest
from scipy.optimize import brentq

from tendon_cli.model import actuator, statics

from .designs import baseline, design, kinematics

FULL_RANGE = np.radians(np.linspace(0.0, 90.0, 901))
ANCHORS = design(baseline()).arm.joint


def assert_printed(value, printed: str):
    """Check that the value rounds to the printed digits."""
    value = float(value)
    last_digit = 10.0 ** Decimal(printed).as_tuple().exponent
    assert abs(value - float(printed)) <= 0.5001 * last_digit, f"{value!r} is not {printed}"


def least_stiffness(flexion, **changes):
    """Return the least elbow stiffness of the baseline with changes over the full range."""
    state = actuator.evaluate(design(baseline(**changes)), FULL_RANGE, flexion)
    return np.min(state.elbow_stiffness)


# --- Kinematics (Eqs. 1-3, Fig. 4) ----------------------------------------------------------------


@pytest.mark.parametrize(
    ("degrees", "path", "moment_arm"),
    [
        (0, "0.300665928", "0.0299336"),
        (60, "0.230459417", "0.1010709"),
        (90, "0.170293864", "0.1274268"),
        (120, "0.098547160", "0.1450346"),
    ],
)
def test_paths_and_moment_arms_of_the_papers_arm(degrees, path, moment_arm):
    motion = kinematics(ANCHORS, np.radians(degrees))
    assert_printed(motion.flexor_path, path)
    assert_printed(motion.flexor_moment_arm, moment_arm)


def test_the_published_travel_is_not_zero_at_the_straight_arm():
    assert_printed(1e3 * kinematics(ANCHORS, 0.0).flexor_travel, "-0.666")
    assert kinematics(ANCHORS, 0.0, from_initial=True).flexor_travel == 0.0


def ratio_at(degrees):
    """Return H_f / H_e (Eq. 3 and Fig. 4), which the paper prints as R_e / R_f."""
    motion = kinematics(ANCHORS, np.radians(degrees))
    return float(motion.flexor_travel / motion.extensor_travel)


def test_the_inverse_of_the_radius_ratio_is_the_spool_ratio_without_slack():
    assert_printed(1 / ratio_at(90.0), "0.545")
    p = baseline(ratio=1 / ratio_at(90.0))
    coupling = actuator.State.of(design(p), np.pi / 2, True).coupling
    assert coupling.mismatch == pytest.approx(0.0, abs=1e-15)


def test_the_radius_ratio_diverges_at_the_straight_arm():
    assert ratio_at(1e-6) < -1e4


def test_the_flexor_passes_the_joints_centre_near_157_and_behind_22_degrees():
    def moment_arm(degrees):
        return float(kinematics(ANCHORS, np.radians(degrees)).flexor_moment_arm)

    assert_printed(brentq(moment_arm, 120.0, 179.0), "157")
    assert_printed(brentq(moment_arm, -60.0, 0.0), "-22.5")
    for degrees, flexes in ((-23, False), (-22, True), (156, True), (158, False)):
        status = actuator.evaluate(design(baseline()), np.radians(degrees), True).status
        assert (status != statics.NO_EQUILIBRIUM) == flexes


# --- Statics (Eqs. 4-5, 12-20) --------------------------------------------------------------------


@pytest.mark.parametrize("unilateral", [True, False])
def test_equal_pretension_is_no_state_of_the_sweep(unilateral):
    made = design(baseline(unilateral=unilateral))
    flexing = actuator.evaluate(made, 0.0, True).balance
    extending = actuator.evaluate(made, 0.0, False).balance
    assert_printed(flexing.flexor, "121.2")
    assert_printed(flexing.extensor, "80.6")
    assert_printed(flexing.extensor / flexing.flexor, "0.6652")
    assert extending.flexor == pytest.approx(float(flexing.flexor), rel=2e-3)


@pytest.mark.parametrize("side", ["flexor", "extensor"])
def test_the_unstretched_length_differs_between_the_directions(side):
    flexing = actuator.State.of(design(baseline()), 0.0, True)
    extending = actuator.State.of(design(baseline()), 0.0, False)
    difference = getattr(flexing, side).compliance - getattr(extending, side).compliance
    assert_printed(1e3 * abs(100.0 * difference), "0.17")


CHECKS = [
    ((0, True, True), "39.9244 45.8149 49.7445 36.7706 0.389217 2.57821", "0"),
    ((0, True, False), "39.9244 45.8149 49.7445 36.7706 0.389217 2.57821", None),
    ((5, True, False), "134.407 -49.1461 167.467 -39.4441 6.20732 3.65551", None),
    ((5, True, True), "153.598 0 191.378 0 5.74135 3.87433", "0.0232911"),
    ((10, False, False), "229.418 -142.754 184.129 -177.866 10.8598 4.73140", None),
    ((10, False, True), "285.163 0 228.869 0 6.86607 5.36381", "0.0678031"),
]


@pytest.mark.parametrize(("case", "printed", "slack"), CHECKS)
def test_states_at_75_degrees(case, printed, slack):
    load, flexion, unilateral = case
    made = design(baseline(load_mass=load, unilateral=unilateral))
    state = actuator.evaluate(made, np.radians(75), flexion)
    results = (
        state.balance.flexor,
        state.balance.extensor,
        state.flexor_tension_proximal,
        state.extensor_tension_proximal,
        state.motor_torque,
        state.spool_angle,
    )
    for value, digits in zip(results, printed.split(), strict=True):
        assert_printed(value, digits)
    if slack is None:
        assert np.isnan(state.extensor_slack)
        assert np.isnan(state.flexor_slack)
    else:
        assert_printed(state.extensor_slack, slack)
        assert state.flexor_slack == 0.0


# --- Stiffness and required pretension ------------------------------------------------------------


def test_the_least_elbow_stiffness_of_the_unloaded_arm():
    assert_printed(least_stiffness(True), "2.09")
    assert_printed(least_stiffness(False), "2.06")


@pytest.mark.parametrize("flexion", [True, False])
def test_springs_of_1_kn_per_m_make_the_unloaded_arm_unstable(flexion):
    assert_printed(least_stiffness(flexion, spring_stiffness=1e3), "-3.5")


@pytest.mark.parametrize("flexion", [True, False])
def test_the_papers_case_of_200_n_without_load_is_unstable_below_13_degrees(flexion):
    state = actuator.evaluate(design(baseline(pretension=200.0)), FULL_RANGE, flexion)
    degrees = np.degrees(FULL_RANGE)
    unstable = degrees[state.elbow_stiffness < 0]
    assert unstable.min() == 0.0
    assert_printed(unstable.max(), "13")
    assert len(unstable) == np.searchsorted(degrees, unstable.max(), side="right")
