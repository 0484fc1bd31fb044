"""Joints, torques and bends from curves: their files, and every fault of a file."""

import json

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.studies.angle_curves import EXCURSION, read_curve
from tendon_cli.studies.load import load_study, recorded_study

from .csv_text import csv_text


def first_joint():
    """Return the excursions and the torque of the first joint of section 15 as CSV.

    Their 400 rows reach 0.1 rad beyond the motion.
    """
    angle = np.linspace(-0.1, 2.0, 400)  # rad
    flexor = 0.035 * angle - 0.04 / 0.9 * np.cos(0.9 * angle)  # m
    extensor = 0.028 * angle + 0.008 / 1.3 * np.sin(1.3 * angle - 0.4)  # m
    torque = 9.0 * np.sin(angle) - 1.5 * (angle - 0.9) + 0.6 * np.exp(2.0 * (angle - 1.6))  # N m
    excursion = csv_text(
        "angle (rad),flexor (mm),extensor [mm]", angle, 1e3 * flexor, 1e3 * extensor
    )
    task = csv_text("# task\nangle_deg,torque_Nm", np.degrees(angle), torque)
    return excursion, task


STUDY = """
[joint]
name = "ankle"
excursion = "exc.csv"
{torque}
[load]
{load}
[arm]
forearm_mass = 0
[sheath]
friction = 0.12
bend_angle = {{ angle = ["0 rad", "1.9 rad"], bend = ["2.4 rad", "3.73 rad"] }}
[tendon]
length = "1.4 m"
pretension = "140 N"
[spring]
flexor = {{ stiffness = "6 kN/m" }}
extensor = {{ stiffness = "9 kN/m" }}
[spool]
ratio = 0.55
flexor_radius = "25 mm"
[setting]
angle = "0.3 rad"
[motion]
elbow_angle = {{ from = "0 rad", to = "1.9 rad", num = 20 }}
"""


@pytest.fixture
def write(tmp_path):
    """Return a function that writes a study and its curves and returns the path of the study."""

    def write_study(text=STUDY, torque='torque = "tau.csv"', load="", **files):
        excursion, task = first_joint()
        curves = {"exc": excursion, "tau": task} | files
        for name, content in curves.items():
            (tmp_path / f"{name}.csv").write_text(content, encoding="utf-8")
        path = tmp_path / "ankle.toml"
        path.write_text(text.format(torque=torque, load=load), encoding="utf-8")
        return path

    return write_study


def flexor_moment_arms(path):
    """Return the moment arms of the flexor in the states of a study, m."""
    return tendon.sweep(load_study(path)).states["flexor_moment_arm"]


def test_a_joint_of_files_is_the_one_of_the_checks(write):
    study = load_study(write())
    at_one_angle = study.vary(**{"motion.elbow_angle": "0.9 rad", "motion.direction": "flexion"})
    state = tendon.sweep(at_one_angle).states.iloc[0]
    assert state["flexor_tension_distal"] == pytest.approx(181.516858512, rel=1e-6)
    assert state["extensor_tension_distal"] == pytest.approx(130.811298850, rel=1e-6)
    assert state["elbow_stiffness"] == pytest.approx(32.426351369, rel=1e-6)
    choice = tendon.design(study).choices.iloc[0]
    assert choice.pretension_from == pytest.approx(84.654056308, rel=2e-6)
    assert choice.pretension_to == pytest.approx(777.431276238, rel=2e-6)


def test_a_task_is_a_joints_torque_but_for_the_setting(write):
    whole = tendon.sweep(load_study(write())).states
    task = tendon.sweep(load_study(write(torque="", load='torque = "tau.csv"'))).states
    for name in ("flexor_tension_distal", "motor_torque", "elbow_torque", "elbow_stiffness"):
        np.testing.assert_array_equal(whole[name], task[name])
    path = write(torque="", load='torque = "tau.csv"\nscale = [0.5, 1.0]')
    scaled = tendon.sweep(load_study(path)).states
    torque = scaled["elbow_torque"].to_numpy().reshape(2, -1)  # (scales, states), N m
    np.testing.assert_allclose(torque[0], 0.5 * torque[1], rtol=1e-12)


def test_what_a_run_keeps_needs_no_files(write):
    study = load_study(write())
    again = recorded_study(json.loads(json.dumps(study.record)))
    assert again.hash == study.hash
    expected = tendon.sweep(study).states["motor_torque"]
    np.testing.assert_array_equal(tendon.sweep(again).states["motor_torque"], expected)


def test_travels_are_proportional_to_a_dimension_of_the_body(write):
    text = STUDY.replace('name = "ankle"', 'name = "ankle"\nscale_with = "forearm_circumference"')
    text += "[people]\nsource = 'ansur2'\ncount = 3\n"
    study = load_study(write(text))
    states = tendon.sweep(study).states
    people = study.people.population
    scale = people.body.forearm_circumference / people.reference.forearm_circumference
    travel = states["flexor_travel"].to_numpy().reshape(3, -1)  # (people, states), m
    np.testing.assert_allclose(travel[1] * scale[0], travel[0] * scale[1], rtol=1e-12)


def test_noise_of_a_tape_is_smoothed_on_request(write):
    excursion, _ = first_joint()
    header, *lines = excursion.splitlines()
    table = np.array([line.split(",") for line in lines], float)
    table[:, 1:] += np.random.default_rng(1).normal(0.0, 0.5, (len(lines), 2))
    noisy = csv_text(header, *table.T)
    smoothing = STUDY.replace('"exc.csv"', '"exc.csv"\nsmoothing = "0.5 mm"')
    exact = flexor_moment_arms(write())
    smooth = flexor_moment_arms(write(smoothing, exc=noisy))
    rough = flexor_moment_arms(write(exc=noisy))
    assert np.abs(smooth - exact).max() < 0.1 * exact.max() < np.abs(rough - exact).max()


HEADER = "angle (deg),flexor (mm),extensor (mm)\n0,0,0\n"


@pytest.mark.parametrize(
    ("content", "problem", "line"),
    [
        (HEADER + "90,9,9\n", "2 rows, expected 3 at least", 3),
        (HEADER.replace(" (deg)", ""), "the column angle has no unit", 1),
        (HEADER.replace("flexor (mm)", "flexor (N)"), 'flexor: "N" is a force', 1),
        ("angle (deg),flexor (mm)\n0,0\n", "no column extensor", 1),
        (HEADER + "50,1,1\n40,2,2\n120,3,3\n", "angles that go back and forth", 4),
        (HEADER + "50,1,1\n50,2,2\n120,3,3\n", "the same angle twice", 4),
        (HEADER + "50,nan,1\n120,3,3\n", 'flexor is "nan", expected a number', 3),
        (HEADER + "30,1,1\n60,2,2\n", "elbow_angle needs 108.862 deg", None),
        (HEADER + "60,-9,9\n120,-20,20\n", "the flexor falls throughout", None),
    ],
)
def test_each_fault_of_a_file_is_refused_with_its_line(write, content, problem, line):
    path = write(exc=content)
    with pytest.raises(tendon.TendonError) as caught:
        load_study(path)
    error = caught.value
    assert error.exit == 3
    assert problem in str(error)
    assert "exc.csv" in str(error.where)
    if line is not None:
        assert f"line {line}" in str(error.where)


@pytest.mark.parametrize("key", ["joint", "load"])
def test_two_points_of_a_torque_are_the_line_of_three(key, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "two.csv").write_text("angle (deg),torque (N m)\n0,1\n120,-2\n")
    torques = {
        "file": "two.csv",
        "two": {"angle": ["0 deg", "120 deg"], "torque": ["1 N m", "-2 N m"]},
        "three": {"angle": ["0 deg", "40 deg", "120 deg"], "torque": ["1 N m", "0 N m", "-2 N m"]},
    }
    windows = {}
    stiffness = {}
    for name, torque in torques.items():
        content = {"spring": {"stiffness": "5 kN/m"}, "spool": {"ratio": 0.6}}
        content[key] = {"torque": torque}
        choices = tendon.design(content).choices
        windows[name] = choices[["pretension_from", "pretension_to"]].to_numpy()
        stiffness[name] = tendon.sweep(content).states["elbow_stiffness"].to_numpy()
    assert np.isfinite(windows["three"]).all()
    for name in ("file", "two"):
        assert windows[name] == pytest.approx(windows["three"], rel=1e-9)
        assert stiffness[name] == pytest.approx(stiffness["three"], rel=1e-9)


@pytest.mark.parametrize("key", ["joint", "load"])
def test_one_point_of_a_torque_is_no_line(key):
    with pytest.raises(tendon.StudyError, match="1 row, expected 2 at least"):
        tendon.study({key: {"torque": {"angle": ["0 deg"], "torque": ["1 N m"]}}})


@pytest.mark.parametrize(
    ("last", "is_warned_of"), [(1.93, True), (1.97, False)], ids=["two rows beyond", "five"]
)
def test_a_motion_that_comes_near_the_tables_end_is_warned_of(write, last, is_warned_of):
    angle = np.arange(-0.1, last, 0.0125)
    travel = 0.03 * angle
    excursion = csv_text("angle (rad),flexor (m),extensor (m)", angle, travel, travel)
    study = load_study(write(exc=excursion))
    message = "reaches 108.9 deg, within 3 rows of the table"
    assert any(message in warning for warning in study.warnings) == is_warned_of


def test_where_a_travel_does_not_rise_a_warning_names_the_angles(write):
    angle = np.linspace(0.0, 2.0, 60)
    flexor = 0.03 * np.sin(1.2 * angle)
    extensor = 0.03 * angle
    excursion = csv_text("angle (rad),flexor (m),extensor (m)", angle, flexor, extensor)
    study = load_study(write(exc=excursion))
    assert any("the flexor's travel does not rise at" in warning for warning in study.warnings)
    states = tendon.sweep(study).states
    assert (states["status"] == "no equilibrium").any()


@pytest.mark.parametrize(
    ("settings", "problem"),
    [
        (["arm.a1=40 mm"], "cannot be given with joint.excursion"),
        (
            ["limits.max_contact_pressure=30 kPa", "arm.contact_width=40 mm"],
            "needs the radius of the strap",
        ),
        (
            ["joint.stiffness=1 N m/rad", "joint.rest_angle=70 deg"],
            "cannot be given with joint.stiffness",
        ),
    ],
)
def test_what_contradicts_a_curve_is_refused(write, settings, problem):
    path = write()
    with pytest.raises(tendon.TendonError, match=problem):
        load_study(path, settings)


def test_moment_arms_of_opensim_are_integrated_into_the_same_joint():
    from verification.excursions import from_opensim

    def flexor_arm(angle):
        return 0.035 + 0.04 * np.sin(0.9 * angle)

    def extensor_arm(angle):
        return 0.028 + 0.008 * np.cos(1.3 * angle - 0.4)

    degrees = np.linspace(-20.0, 120.0, 300)
    flexor = flexor_arm(np.radians(degrees))
    extensor = -extensor_arm(np.radians(degrees))
    rows = np.column_stack([degrees, flexor, extensor]).tolist()
    lines = ["moment arms", "nRows=300", "inDegrees=yes", "endheader", "time\tknee\tflex\text"]
    for time, (angle, flex, ext) in enumerate(rows):
        lines.append(f"{time}\t{angle!r}\t{flex!r}\t{ext!r}")
    text = "\n".join(lines)

    excursion = from_opensim(text, "knee", "flex", "ext").encode()
    curve, _ = read_curve(excursion, "excursion.csv", EXCURSION)
    angles = np.radians(np.linspace(0.0, 90.0, 31))
    flexor_slope = curve.spline("flexor")(angles, 1)
    extensor_slope = curve.spline("extensor")(angles, 1)
    np.testing.assert_allclose(flexor_slope, flexor_arm(angles), atol=1e-6)
    np.testing.assert_allclose(extensor_slope, extensor_arm(angles), atol=1e-6)
    with pytest.raises(ValueError, match="no column shin"):
        from_opensim(text, "knee", "shin", "ext")
    with pytest.raises(ValueError, match="name the flexor first"):
        from_opensim(text, "knee", "ext", "flex")


@pytest.mark.parametrize("length", [0.2, 0.37])
def test_lengths_of_muscles_are_not_taken_for_their_moment_arms(length):
    from verification.excursions import from_opensim

    lines = ["Length", "endheader", "ankle soleus tibialis"]
    lines += [f"{angle} {length - 0.04 * angle} {length + 0.03 * angle}" for angle in (0, 0.5, 1)]
    with pytest.raises(ValueError, match="is this the file of lengths"):
        from_opensim("\n".join(lines), "ankle", "soleus", "tibialis")


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("angle,flexor\n0,1\n", "no table of two rows or more"),
        ("endheader\nknee flex ext\n0 0.03 -0.03\n1 0.03\n", "one number for each of 3 columns"),
        ("endheader\nknee flex ext\n0 0.03 -0.03\n1 0.03 short\n", "short"),
    ],
)
def test_a_file_that_opensim_does_not_write_is_refused_in_one_line(tmp_path, capsys, text, problem):
    from verification.excursions import main

    source = tmp_path / "arm.sto"
    source.write_text(text)
    assert main([str(source), "knee", "flex", "ext", str(tmp_path / "excursion.csv")]) == 2
    said = capsys.readouterr().err
    assert said.startswith("error: ")
    assert problem in said
    assert said.count("\n") == 1
    assert not (tmp_path / "excursion.csv").exists()
    assert main(["arm.sto"]) == 2


def test_a_page_is_written_of_a_joint_without_anchors_and_its_travels_are_drawn(write, tmp_path):
    study = load_study(write())
    run = tendon.sweep(study, tmp_path / "run")
    answer = tendon.design(study, tmp_path / "answer")
    for result in (run, answer):
        page = tendon.report(result, tmp_path / "page.html")
        assert page.stat().st_size > 1000
    assert tendon.plot(study) is not None
