"""The findings of the paper, each from the tables that its study writes; numbers as checked by two computations.

Fig. n is the paper's; the baseline is that of its section 3.
"""

import itertools

import numpy as np
import pandas as pd
import pytest

STIFFEST = 3000.0


def at(states, **values):
    """The states with these values, by elbow angle in degrees, rising."""
    for column, value in values.items():
        states = (
            states[np.isclose(states[column], value)] if isinstance(value, float) else states[states[column] == value]
        )
    assert len(states)
    return states.assign(degrees=np.degrees(states["elbow_angle"]).round(9)).set_index("degrees").sort_index()


def falls(series):
    return bool((np.diff(series) < 0.0).all())


def rises_first(series):
    return bool(series.iloc[1] > series.iloc[0])


def difference_of_directions(states, end):
    """Largest difference between flexion and extension over the largest tension, for each side."""
    shares = []
    for side in ("flexor", "extensor"):
        column = f"{side}_tension_{end}"
        flexion, extension = (at(states, direction=direction)[column] for direction in ("flexion", "extension"))
        shares.append(float((flexion - extension).abs().max() / max(flexion.abs().max(), extension.abs().max())))
    return shares


# --- Fig. 4 ----------------------------------------------------------------------------------------------------------


def test_f4_ratio_of_the_radii_exceeds_one_at_90_degrees_and_falls_with_the_angle(figure):
    states = at(figure("fig04")[0])
    ratio = states["flexor_travel"] / states["extensor_travel"]
    assert ratio.loc[90.0] == pytest.approx(1.835, abs=5e-4)
    assert ratio.loc[1.0] == pytest.approx(-0.168, abs=5e-4)
    assert falls(ratio.iloc[::-1])
    assert np.interp(1.0, ratio, ratio.index) == pytest.approx(25.7, abs=0.05)


# --- Fig. 6 ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("mass", "first_angles"), [(0.0, 23.8), (3.0, 15.0), (5.0, 12.5), (10.0, 9.2)])
def test_f6a_elbow_torque_exceeds_motor_torque_but_at_the_first_angles_of_flexion(figure, mass, first_angles):
    states = figure("fig06")[0]
    flexion = at(states, load_mass=mass, direction="flexion")
    gain = flexion["elbow_torque"] - flexion["motor_torque"]
    last = int((gain < 0.0).sum()) - 1
    assert (gain.iloc[: last + 1] < 0.0).all()
    assert (gain.iloc[last + 1 :] > 0.0).all()
    crossing = gain.index[last] - gain.iloc[last] / (gain.iloc[last + 1] - gain.iloc[last])
    assert crossing == pytest.approx(first_angles, abs=0.06)


@pytest.mark.parametrize("mass", [0.0, 3.0, 5.0, 10.0])
def test_f6a_elbow_torque_always_exceeds_motor_torque_in_extension(figure, mass):
    extension = at(figure("fig06")[0], load_mass=mass, direction="extension")
    assert (extension["elbow_torque"] > extension["motor_torque"]).all()


@pytest.mark.parametrize("direction", ["flexion", "extension"])
def test_f6b_the_gain_of_torque_grows_with_the_load_at_every_angle(figure, direction):
    states = figure("fig06")[0]
    gains = []
    for mass in (0.0, 3.0, 5.0, 10.0):
        moved = at(states, load_mass=mass, direction=direction)
        gains.append((moved["elbow_torque"] - moved["motor_torque"])[moved.index > 0.0])
    assert all((heavier > lighter).all() for lighter, heavier in itertools.pairwise(gains))


# --- Fig. 7 ----------------------------------------------------------------------------------------------------------


def loads(states):
    return sorted(states["load_mass"].unique())


def test_f7a_without_load_the_distal_flexor_tension_falls_throughout_flexion(figure):
    assert falls(at(figure("fig07")[0], load_mass=0.0, direction="flexion")["flexor_tension_distal"])


def test_f7b_with_load_it_first_rises(figure):
    states = figure("fig07")[0]
    loaded = [mass for mass in loads(states) if mass > 0.0]
    assert loaded
    for mass in loaded:
        assert rises_first(at(states, load_mass=mass, direction="flexion")["flexor_tension_distal"])


def test_f7c_with_load_the_distal_extensor_tension_falls_throughout_and_without_it_first_rises(figure):
    states = figure("fig07")[0]
    for mass in loads(states):
        tension = at(states, load_mass=mass, direction="flexion")["extensor_tension_distal"]
        assert falls(tension) if mass > 0.0 else rises_first(tension)


def test_f7d_near_the_elbow_flexion_and_extension_nearly_coincide(figure):
    states = figure("fig07")[0]
    for mass in loads(states):
        assert max(difference_of_directions(at(states, load_mass=mass), "distal")) < 0.01


def test_the_two_tensions_of_the_straight_arm_are_not_the_pretension(figure):
    straight = at(figure("fig07")[0], load_mass=0.0, direction="flexion").loc[0.0]
    assert straight["pretension"] == 100.0
    assert straight["flexor_tension_distal"] == pytest.approx(121.2, abs=0.05)
    assert straight["extensor_tension_distal"] == pytest.approx(80.6, abs=0.05)


# --- Fig. 8 ----------------------------------------------------------------------------------------------------------


def test_f8a_near_the_motor_flexion_and_extension_differ_by_friction(figure):
    states = figure("fig08")[0]
    for mass in loads(states):
        assert min(difference_of_directions(at(states, load_mass=mass), "proximal")) > 0.3


@pytest.mark.parametrize("mass", [0.0, 3.0, 10.0])
def test_f8b_the_flexor_stays_in_tension_and_the_loaded_extensor_goes_slack(figure, mass):
    states = at(figure("fig08")[0], load_mass=mass)
    assert (states[["flexor_tension_proximal", "flexor_tension_distal"]] > 0.0).all(axis=None)
    assert (states["status"] == "extensor slack").any() == (mass > 0.0)
    assert (states["extensor_tension_distal"] < 0.0).any() == (mass > 0.0)


# --- Fig. 9 ----------------------------------------------------------------------------------------------------------


def test_f9_at_200_newtons_there_is_slack_for_10_kilograms_alone(figure):
    designs = figure("fig09")[1]
    designs = designs[np.isclose(designs["pretension"], 200.0)].set_index("load_mass")
    assert designs.loc[[0.0, 3.0, 10.0], "taut"].tolist() == [True, True, False]
    assert designs.loc[[0.0, 3.0, 10.0], "slack_fraction"].gt(0.0).tolist() == [False, False, True]
    required = designs.loc[[0.0, 3.0, 10.0], "required_pretension"]
    np.testing.assert_allclose(required, [96.83, 133.88, 220.32], atol=0.005)


# --- Figs. 10 and 11 -------------------------------------------------------------------------------------------------


def depths(designs, by):
    """Depth of the extensor's slack, -(least distal tension)/K in mm, by a column, from its largest value down."""
    assert (designs["load_mass"] == 5.0).all()
    rows = designs.sort_values(by, ascending=False).set_index(by)
    return rows.assign(depth=-1e3 * rows["least_distal"] / rows["spring_stiffness_"])


def with_least_distal(figure, name):
    states, designs = figure(name)
    least = states.groupby("design")["extensor_tension_distal"].min()
    return designs.assign(least_distal=designs["design"].map(least), spring_stiffness_=designs["spring_stiffness"])


def test_f10_slack_shrinks_and_the_springs_extend_further_as_they_soften(figure):
    rows = depths(with_least_distal(figure, "fig10"), "spring_stiffness")
    assert rows.index.tolist() == [3000.0, 2000.0, 1000.0]
    np.testing.assert_allclose(rows["depth"], [28.9, 22.3, 1.8], atol=0.05)
    assert falls(rows["depth"])
    assert falls(rows["slack_fraction"])
    assert falls(-rows["max_spring_extension"])
    assert rows.loc[1000.0, "required_pretension"] == pytest.approx(101.24, abs=0.005)


def test_f11_slack_shrinks_with_the_ratio_of_the_spools_and_is_gone_at_seven_tenths(figure):
    designs = with_least_distal(figure, "fig11")
    rows = depths(designs, "spool_ratio")
    assert rows.index.tolist()[-3:] == [0.9, 0.8, 0.7]
    assert falls(rows["depth"])
    assert falls(rows["slack_fraction"])
    assert rows["taut"].tolist() == [False] * (len(rows) - 1) + [True]
    assert rows.loc[0.7, "slack_fraction"] == 0.0
    assert rows.loc[0.7, "required_pretension"] == pytest.approx(94.07, abs=0.005)


# --- All of them -----------------------------------------------------------------------------------------------------


BASELINE = {
    "spring_stiffness": STIFFEST,
    "spool_ratio": 1.0,
    "friction": 0.07,
    "bend_angle": np.pi,
    "pretension": 100.0,
}
VARIED = {"fig09": "pretension", "fig10": "spring_stiffness", "fig11": "spool_ratio"}


@pytest.mark.parametrize("name", ["fig04", "fig06", "fig07", "fig08", "fig09", "fig10", "fig11"])
def test_every_study_is_the_baseline_but_for_what_its_figure_varies(figure, name):
    states, designs = figure(name)
    for column, value in BASELINE.items():
        if column != VARIED.get(name):
            assert np.isclose(designs[column], value).all(), column
    assert states[["flexor_slack", "extensor_slack"]].isna().all(axis=None)  # bilateral
    assert not (states["status"] == "no equilibrium").any()
    degrees = np.degrees(states["elbow_angle"])
    assert degrees.max() == pytest.approx(90.0)
    assert isinstance(states, pd.DataFrame)


def test_required_pretension_of_the_baseline_under_every_load(figure):
    designs = figure("fig06")[1].set_index("load_mass")
    expected = [96.83, 133.88, 158.57, 220.32]
    np.testing.assert_allclose(designs.loc[[0.0, 3.0, 5.0, 10.0], "required_pretension"], expected, atol=0.005)
    flexion = at(figure("fig06")[0], load_mass=0.0, direction="flexion")
    assert flexion["elbow_stiffness"].min() == pytest.approx(2.09, abs=0.005)
