"""Pages of `tendon state` with a speed and `--reversal` agree with themselves and their figure."""

import numpy as np
import pytest

import tendon_cli as tendon_library
from tendon_cli.engine.plan import Block, Plan
from tendon_cli.model.motor import cycle_columns
from tendon_cli.state_page.plot import stroke_of, turn_of

TEXT = """
[tendon]
pretension = "160 N"
[spool]
ratio = 0.8
[load]
mass = "{load} kg"
[motion]
speed = "60 deg/s"
direction = ["{direction}"]
elbow_angle = [{angles}]
[limits]
peak_motor_torque = "8 N m"
peak_motor_power = "25 W"
"""
ALL_ANGLES = '"75 deg", "0 deg", "30 deg", "90 deg"'
BOTH_DIRECTIONS = 'flexion", "extension'
SPEED = np.radians(60.0)  # rad/s, as in the text
SPOOL_RADII = np.array([0.03, 0.024])  # m, of the flexor and, by the ratio, the extensor


def study_text(*, load=3, direction="flexion", angles=ALL_ANGLES):
    return TEXT.format(load=load, direction=direction, angles=angles)


@pytest.fixture
def page(tendon, write_study):
    """Return a function that runs `tendon state`.

    It returns the values by the first word of their section and by their symbol.
    """

    def read(*words, **study):
        write_study(study_text(**study))
        record = tendon("state", "study.toml", *words, "--json").json
        sections = {}
        for line in record["lines"]:
            section = sections.setdefault(line["section"].split()[0], {})
            section[line["symbol"]] = line["values"]
        return sections

    return read


@pytest.mark.parametrize("direction", ["flexion", "extension"])
@pytest.mark.parametrize("load", [0, 3, 10])
def test_the_powers_of_a_state_add_up_and_turn_with_the_direction(page, load, direction):
    sections = page(load=load, direction=direction)
    results = sections["Results"]
    powers = {symbol: value for symbol, (value,) in sections["Motor"].items()}
    sign = 1.0 if direction == "flexion" else -1.0
    assert powers["θ̇"] == pytest.approx(sign * SPEED)
    assert powers["α̇"] == pytest.approx(powers["dα/dθ"] * powers["θ̇"])
    assert powers["P_m"] == pytest.approx(results["τ_m"][0] * powers["α̇"])
    assert powers["P_a"] == pytest.approx(sections["Load"]["τ_a"][0] * powers["θ̇"])
    assert powers["P_m"] == pytest.approx(powers["P_a"] + powers["P_U"] + powers["P_μ"])
    assert powers["P_μ"] > 0.0
    flexor_compliance, extensor_compliance = sections["Sheath,"]["c_f, c_e"]
    force_per_angle = sections["Geometry"]["J"][0] / flexor_compliance  # N/rad
    is_slack = results["s"][1] > 0.0
    if not is_slack:
        force_per_angle += 0.8 * sections["Geometry"]["R_elb"][0] / extensor_compliance
    assert powers["dα/dθ"] == pytest.approx(results["k"][0] / 0.03 / force_per_angle)


def test_the_cycle_is_over_all_angles_and_both_directions_of_the_study(page):
    both_ways = page(direction=BOTH_DIRECTIONS)["Over"]
    assert both_ways["peak α̇"][0] >= abs(page()["Motor"]["α̇"][0])
    efficiency = 1.0 - both_ways["W_μ"][0] / both_ways["W_m"][0]
    assert both_ways["ε"][0] == pytest.approx(efficiency)
    one_way = page()["Over"]
    assert one_way["max δα"] == [None]
    assert one_way["max δτ_m"] == [None]
    assert 0.0 < one_way["W_μ"][0] < both_ways["W_μ"][0]


def test_a_turn_says_when_each_far_end_follows_and_how_the_torque_goes(page):
    sections = page("--reversal")
    turn = sections["Where"]
    results = sections["Results"]
    sheath = sections["Sheath,"]
    distal = np.array(results["F_o"])  # of flexor and extensor, as all that follow
    capstan = np.array(sheath["e^(σμφ)"])
    exponent = np.array(sheath["μφ"])
    before = distal / capstan
    after = distal * capstan
    # A slip is L/(AE) 4 sinh²(μφ/2)/(μφ) per newton at the elbow.
    compliance = 2.0 / (np.pi * 1.5e-3**2 / 4 * 145e9)  # L/(AE), m/N
    slips = distal * compliance * 4.0 * np.sinh(exponent / 2.0) ** 2 / exponent
    turns = slips / SPOOL_RADII
    sooner, later = np.argsort(turns)
    share = np.sqrt(turns[sooner] / turns[later])
    halfway = after.copy()  # of the side that follows later, when the other side follows
    halfway[later] = before[later] * (1.0 + share * (capstan[later] - 1.0)) ** 2
    torques = [(flexor - 0.8 * extensor) * 0.03 for flexor, extensor in (halfway, after)]
    expected = {"F_I": before, "F_I'": after, "δ": slips, "Δα": turns, "τ_m''": torques}
    for symbol, values in expected.items():
        np.testing.assert_allclose(turn[symbol], values, err_msg=symbol)
    assert turn["τ_m'"] == pytest.approx(results["τ_m"])
    assert (np.array(turn["W_μ"]) > 0.0).all()


def test_a_slack_tendon_has_no_turn_on_the_page(page):
    turn = page("--reversal", load=10, angles='"90 deg"')["Where"]
    assert turn["Δα"][1] is None
    assert len(turn["τ_m''"]) == 1


def test_a_page_without_speed_and_reversal_is_as_before(tendon, write_study):
    write_study("")
    lines = tendon("state", "study.toml", "--json").json["lines"]
    sections = {line["section"].split()[0] for line in lines}
    assert sections == {"Geometry", "Sheath,", "Load", "Balance", "Results", "Setting"}


# --- The figure -----------------------------------------------------------------------------------


def drawn(tmp_path, load):
    """Return a plan, the state of its first design at 75 degrees in flexion, and its strokes.

    The figure draws one stroke per direction.
    """
    file = tmp_path / "study.toml"
    file.write_text(study_text(load=load, direction=BOTH_DIRECTIONS))
    plan = Plan(tendon_library.study(file))
    first = (slice(0, 1),) * len(plan.axes)
    state = plan.state(Block(0, first, slice(0, 1), slice(0, 1)))
    strokes = {
        direction: stroke_of(state.design, plan, direction, SPEED) for direction in plan.directions
    }
    return plan, state, strokes


@pytest.mark.parametrize("load", [3, 10])
def test_the_area_of_the_loop_is_what_friction_takes(tmp_path, load):
    plan, state, strokes = drawn(tmp_path, load)
    angles = np.concatenate([stroke.spool_angle for stroke in strokes.values()])
    torques = np.concatenate([stroke.motor_torque for stroke in strokes.values()])
    # The shoelace formula.
    area = 0.5 * abs(np.dot(angles, np.roll(torques, -1)) - np.dot(torques, np.roll(angles, -1)))
    flexion = np.array([[True], [False]])
    loss = cycle_columns(state.design, plan.elbow_angles[np.newaxis], flexion, SPEED)[
        "friction_loss"
    ]
    assert area == pytest.approx(float(loss.ravel()[0]), rel=0.005)  # but for the turns


def test_the_curves_are_the_states(tmp_path):
    plan, state, strokes = drawn(tmp_path, 3)
    flexion = strokes["flexion"]
    extension = strokes["extension"]
    assert np.degrees(flexion.elbow_angle[[0, -1]]) == pytest.approx([0.0, 90.0])
    assert np.degrees(extension.elbow_angle[[0, -1]]) == pytest.approx([90.0, 0.0])
    speed = np.gradient(flexion.spool_angle, flexion.elbow_angle) * SPEED
    np.testing.assert_allclose(flexion.motor_speed[2:-2], speed[2:-2], rtol=1e-3)
    _, torque, follows = turn_of(state, plan)
    stroke_torque = np.interp(np.radians(75.0), flexion.elbow_angle, flexion.motor_torque)
    assert torque[0] == pytest.approx(stroke_torque)
    assert set(follows) == {"flexor", "extensor"}


def test_the_figure_has_the_limits_in_it(tendon, workplace, write_study):
    write_study(study_text(direction=BOTH_DIRECTIONS))
    assert tendon("state", "study.toml", "--reversal", "--plot", "motor.svg").exit == 0
    written = (workplace / "motor.svg").read_bytes()
    assert b"Torque against speed" in written
    assert b"Hysteresis" in written
    assert b"Turn from flexion at 75" in written
    assert b"8 N m, 25 W." in written
    assert b"outside" not in written


def test_a_limit_on_power_that_is_out_of_sight_is_not_said_to_be_dotted(
    tendon, workplace, write_study
):
    write_study(study_text(direction=BOTH_DIRECTIONS))
    far = ["--set", "limits.peak_motor_power=900 W"]
    assert tendon("state", "study.toml", *far, "--plot", "motor.svg").exit == 0
    written = (workplace / "motor.svg").read_text()
    assert "Dotted: the limits, 8 N m." in written
    assert "The limit on power, 900 W, lies outside what is shown." in written


def test_the_motor_of_a_motion_in_time_is_drawn_over_time(tendon, workplace, write_study):
    rows = "\n".join(f"{0.02 * step:.2f},{step}" for step in range(61))
    (workplace / "reach.csv").write_text(f"time (s),angle (deg)\n{rows}\n")
    write_study('[motion]\ntrajectory = "reach.csv"\n')
    ran = tendon("state", "study.toml", "--plot", "motor.svg", "--json")
    assert ran.exit == 0
    figure = (workplace / "motor.svg").read_text()
    for words in ("Torque over time", "time (s)", "end of the record"):
        assert words in figure
    assert figure.count('id="record end"') == 2
