"""The window of pretension of each design agrees with the verdicts of a sweep over pretension."""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.engine import folds

LIMITS = {
    "max_tension": "420 N",
    "min_flexor_tension": "2 N",
    "max_spring_extension": "90 mm",
    "peak_motor_torque": "11 N m",
    "max_contact_pressure": "90 kPa",
    "min_elbow_stiffness": "1 N m/rad",
    "max_pretension": "280 N",
    "min_spring_room": "10 mm",
}
CONTENT = {
    "arm": {"contact_width": "40 mm", "b1": ["150 mm", "170 mm"]},
    "spring": {"stiffness": ["2 kN/m", "6 kN/m"], "free_length": "70 mm"},
    "spool": {"ratio": [1.0, 0.6]},
    "load": {"mass": ["0 kg", "4 kg", "9 kg"]},
    "motion": {"elbow_angle": {"from": "0 deg", "to": "95 deg", "num": 20}},
}


def swept(content):
    """Return the designs of a study."""
    return tendon.sweep(tendon.study(content)).designs


@pytest.mark.parametrize("slack", ["unilateral", "bilateral"])
@pytest.mark.parametrize("limits", [{}, LIMITS, *({name: value} for name, value in LIMITS.items())])
def test_a_design_is_feasible_where_its_pretension_is_in_its_window(limits, slack):
    pretension = {"from": "5 N", "to": "305 N", "num": 61}
    content = {**CONTENT, "limits": limits, "model": {"slack": slack}}
    designs = swept({**content, "tendon": {"pretension": pretension}})
    high = designs.pretension_to.fillna(np.inf)
    inside = (designs.pretension_from <= designs.pretension) & (designs.pretension <= high)
    assert (designs.feasible == inside).all()
    assert 0 < inside.sum() < len(designs)


def test_just_within_the_ends_it_is_feasible_and_just_beyond_it_is_not():
    checked = 0
    for row in swept({**CONTENT, "limits": LIMITS}).itertuples():
        low = row.pretension_from
        high = row.pretension_to
        if not low < high:
            continue
        design = {
            "arm": {"contact_width": 0.04, "b1": f"{row.arm_b1} m"},
            "spool": {"ratio": row.spool_ratio},
            "spring": {"stiffness": row.spring_stiffness, "free_length": "70 mm"},
            "load": {"mass": row.load_mass},
            "limits": LIMITS,
            "motion": CONTENT["motion"],
        }
        expected = {low: True, low - 0.01: False, high: True, high + 0.01: False}
        for pretension, feasible in expected.items():
            if pretension > 0.0:
                designs = swept({**design, "tendon": {"pretension": pretension}})
                assert designs.feasible.item() == feasible
                checked += 1
    assert checked > 30


def test_the_window_does_not_depend_on_pretension_nor_on_the_slack_model():
    base = swept({**CONTENT, "limits": LIMITS})
    for change in ({"tendon": {"pretension": "33 N"}}, {"model": {"slack": "bilateral"}}):
        changed = swept({**CONTENT, "limits": LIMITS, **change})
        for name in ("pretension_from", "pretension_to"):
            np.testing.assert_array_equal(changed[name], base[name])


def test_the_columns_of_whole_designs():
    run = tendon.sweep(tendon.study({**CONTENT, "sheath": {"friction": 0.05}}))
    designs = run.designs
    spool_to_tendon = np.where(designs.spool_ratio < 1.0, 24.0, 40.0)
    np.testing.assert_allclose(designs.min_spool_to_tendon, spool_to_tendon)
    pressed = run.states[run.states.elbow_angle > np.radians(9.99)]
    pull = pressed.groupby("design").extensor_tension_distal.max()
    np.testing.assert_allclose(designs.max_contact_pressure, pull / (0.045 * 0.04), rtol=1e-14)
    without = swept({"load": {"mass": "3 kg"}})
    assert without.max_contact_pressure.isna().all()


def test_a_thin_spool_and_no_equilibrium_leave_no_window():
    thin = swept({"spool": {"ratio": [1.0, 0.6]}, "limits": {"min_spool_to_tendon": 30}})
    assert thin.pretension_from.isna().tolist() == [False, True]
    assert thin.feasible.tolist() == [True, False]
    beyond = swept({"motion": {"elbow_angle": ["0 deg", "165 deg"]}})
    assert beyond.pretension_from.isna().all()
    assert not beyond.feasible.any()


def test_an_answers_windows_are_those_of_a_sweep_over_many_angles():
    motion = {"elbow_angle": {"from": "0 deg", "to": "95 deg", "num": 2001}}
    content = {**CONTENT, "limits": LIMITS, "arm": {"contact_width": "40 mm"}, "motion": motion}
    designs = swept(content)
    answer = tendon.design(tendon.study(content))
    choices = answer.choices
    by_choice = designs.groupby(["spring_stiffness", "spool_ratio"], sort=False)
    low = by_choice.pretension_from.max()
    high = by_choice.pretension_to.min()
    np.testing.assert_allclose(choices.pretension_from, low, rtol=1e-5)
    np.testing.assert_allclose(choices.pretension_to, high, rtol=1e-5)


@pytest.mark.parametrize(
    "most",
    [{"_MOST_WINDOWS_KEPT": 0}, {"_MOST_STATES_BEFOREHAND": 0}, {"_DESIGNS_AT_ONCE": 5}],
    ids=str,
)
def test_windows_of_all_designs_at_once_are_those_of_each_part(
    new_sweep, tmp_path, small_parts, monkeypatch, most
):
    small_parts(3000, 5)
    text = """
tendon = { pretension = ["50 N", "90 N", "200 N"] }
spring = { stiffness = ["1 kN/m", "3 kN/m"] }
load = { mass = ["0 kg", "5 kg"] }
arm = { upper_arm_angle = ["0 deg", "20 deg", "40 deg"] }
"""
    whole = new_sweep(text, tmp_path, out="whole")
    for name, value in most.items():
        monkeypatch.setattr(folds, name, value)
    assert new_sweep(text, tmp_path, out="parts").hashes == whole.hashes
    assert whole.designs["pretension_from"].nunique() > 6
