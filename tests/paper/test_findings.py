"""What the tables of the paper say of each finding, without the code that judges them; numbers are in test_claims.

Fig. n is the paper's; the baseline is that of its section 3.
"""

import numpy as np
import pandas as pd
import pytest


@pytest.fixture
def figure(paper):
    """The states and the designs of a study of the paper."""
    return lambda name: (paper[name].states, paper[name].designs)


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


def gains(states, direction):
    """What the elbow torque is above the motor torque: a column a load, by elbow angle."""
    moved = at(states, direction=direction)
    moved["gain"] = moved["elbow_torque"] - moved["motor_torque"]
    return moved.pivot_table(values="gain", index="degrees", columns="load_mass")


def difference_of_directions(states, end):
    """Largest difference between flexion and extension over the largest tension: a row a load, a column a side."""
    columns = [f"{side}_tension_{end}" for side in ("flexor", "extensor")]
    flexion, extension = (
        at(states, direction=way).set_index("load_mass", append=True)[columns] for way in ("flexion", "extension")
    )
    peak = np.maximum(flexion.abs().groupby("load_mass").max(), extension.abs().groupby("load_mass").max())
    return (flexion - extension).abs().groupby("load_mass").max() / peak


def test_f4_the_ratio_of_the_radii_exceeds_one_at_90_degrees_and_falls_with_the_angle(figure):
    states = at(figure("fig04")[0])
    ratio = states["flexor_travel"] / states["extensor_travel"]
    assert ratio.loc[90.0] > 1.0
    assert falls(ratio.iloc[::-1])


def test_f6_elbow_torque_exceeds_motor_torque_but_at_the_first_angles_of_flexion_and_the_more_the_heavier(figure):
    flexion, extension = (gains(figure("fig06")[0], way) for way in ("flexion", "extension"))
    for mass in flexion.columns:
        gain = flexion[mass]
        first = int((gain < 0.0).sum())
        assert 0.0 < gain.index[first] < 30.0
        assert (gain.iloc[first:] > 0.0).all()
    assert (extension > 0.0).all(axis=None)
    for gain in (flexion, extension):
        assert (gain[gain.index > 0.0].diff(axis=1).iloc[:, 1:] > 0.0).all(axis=None)


def test_f7_distal_tensions_fall_or_first_rise_with_the_load_and_nearly_coincide(figure):
    states = figure("fig07")[0]
    for mass in states["load_mass"].unique().tolist():
        moved = at(states, load_mass=mass, direction="flexion")
        flexor, extensor = moved["flexor_tension_distal"], moved["extensor_tension_distal"]
        falling, rising = (extensor, flexor) if mass > 0.0 else (flexor, extensor)
        assert falls(falling)
        assert rising.iloc[1] > rising.iloc[0]
    assert difference_of_directions(states, "distal").lt(0.01).all(axis=None)


def test_f8_near_the_motor_friction_shows_and_the_loaded_extensor_goes_slack(figure):
    states = figure("fig08")[0]
    assert difference_of_directions(states, "proximal").gt(0.3).all(axis=None)
    assert (states[["flexor_tension_proximal", "flexor_tension_distal"]] > 0.0).all(axis=None)
    for mass, moved in states.groupby("load_mass"):
        assert (moved["status"] == "extensor slack").any() == (mass > 0.0)
        assert (moved["extensor_tension_distal"] < 0.0).any() == (mass > 0.0)


BASELINE = {"spring_stiffness": 3000.0, "spool_ratio": 1.0, "friction": 0.07, "bend_angle": np.pi, "pretension": 100.0}
VARIED = {"fig09": "pretension", "fig10": "spring_stiffness", "fig11": "spool_ratio"}


@pytest.mark.parametrize("name", ["fig04", "fig06", "fig07", "fig08", "fig09", "fig10", "fig11"])
def test_every_study_is_the_baseline_but_for_what_its_figure_varies(figure, name):
    states, designs = figure(name)
    for column, value in BASELINE.items():
        if column != VARIED.get(name):
            assert np.isclose(designs[column], value).all(), column
    assert states[["flexor_slack", "extensor_slack"]].isna().all(axis=None)  # bilateral
    assert not (states["status"] == "no equilibrium").any()
    assert np.degrees(states["elbow_angle"]).max() == pytest.approx(90.0)
    assert isinstance(states, pd.DataFrame)
