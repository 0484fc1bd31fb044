"""`tendon state` with a speed, `--reversal` and `--plot`: the numbers against each other, the figure against both."""

import numpy as np
import pytest

import tendon_cli as tendon_library
from tendon_cli.engine.plan import Block, Plan
from tendon_cli.model.motor import cycle
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
ALL = ", ".join(f'"{angle} deg"' for angle in (75, 0, 30, 90))


@pytest.fixture
def page(tendon, workplace):
    def lines(*words, load=3, direction="flexion", angles=ALL):
        (workplace / "study.toml").write_text(
            TEXT.format(load=load, direction=direction, angles=angles)
        )
        record = tendon("state", "study.toml", *words, "--json").json
        found = {}
        for line in record["lines"]:
            found.setdefault(line["section"].split()[0], {})[line["symbol"]] = line["values"]
        return found

    return lines


@pytest.mark.parametrize("direction", ["flexion", "extension"])
@pytest.mark.parametrize("load", [0, 3, 10])
def test_the_powers_of_a_state_add_up_and_turn_with_the_direction(page, load, direction):
    found = page(load=load, direction=direction)
    powers = {symbol: value for symbol, (value,) in found["Motor"].items()}
    sign = 1.0 if direction == "flexion" else -1.0
    assert powers["θ̇"] == pytest.approx(sign * np.radians(60.0))
    assert powers["α̇"] == pytest.approx(powers["dα/dθ"] * powers["θ̇"])
    assert powers["P_m"] == pytest.approx(found["Results"]["τ_m"][0] * powers["α̇"])
    assert powers["P_a"] == pytest.approx(found["Load"]["τ_a"][0] * powers["θ̇"])
    assert powers["P_m"] == pytest.approx(powers["P_a"] + powers["P_U"] + powers["P_μ"])
    assert powers["P_μ"] > 0.0
    c_f, c_e = found["Sheath,"]["c_f, c_e"]
    arms = found["Geometry"]["J"][0] / c_f, 0.8 * found["Geometry"]["R_elb"][0] / c_e
    slack = found["Results"]["s"][1] > 0.0
    assert powers["dα/dθ"] == pytest.approx(
        found["Results"]["k"][0] / 0.03 / (arms[0] + (0.0 if slack else arms[1]))
    )


def test_the_cycle_is_over_all_angles_and_both_directions_of_the_study(page):
    both = 'flexion", "extension'
    over = page(direction=both)["Over"]
    assert over["peak α̇"][0] >= abs(page()["Motor"]["α̇"][0])
    assert over["ε"][0] == pytest.approx(1.0 - over["W_μ"][0] / over["W_m"][0])
    one_way = page()["Over"]
    assert one_way["max δα"] == one_way["max δτ_m"] == [None]
    assert 0.0 < one_way["W_μ"][0] < over["W_μ"][0]


def test_a_turn_says_when_each_far_end_follows_and_how_the_torque_goes(page):
    found = page("--reversal")
    turn, results, sheath = found["Where"], found["Results"], found["Sheath,"]
    distal, capstan, exponent = (
        np.array(results["F_o"]),
        np.array(sheath["e^(σμφ)"]),
        np.array(sheath["μφ"]),
    )
    before, after = distal / capstan, distal * capstan
    # L/(AE) 4 sinh²(μφ/2)/(μφ) per newton at the elbow.
    rigid = 2.0 / (np.pi * 1.5e-3**2 / 4 * 145e9)
    slips = distal * rigid * 4.0 * np.sinh(exponent / 2.0) ** 2 / exponent
    turns = slips / [0.03, 0.024]
    sooner, later = np.argsort(turns)
    halfway = after.copy()  # of the side that follows later, when the other one follows
    halfway[later] = (
        before[later] * (1.0 + np.sqrt(turns[sooner] / turns[later]) * (capstan[later] - 1.0)) ** 2
    )
    torques = [(flexor - 0.8 * extensor) * 0.03 for flexor, extensor in (halfway, after)]
    for symbol, value in {
        "F_I": before,
        "F_I'": after,
        "δ": slips,
        "Δα": turns,
        "τ_m''": torques,
    }.items():
        np.testing.assert_allclose(turn[symbol], value, err_msg=symbol)
    assert turn["τ_m'"] == pytest.approx(results["τ_m"])
    assert (np.array(turn["W_μ"]) > 0.0).all()


def test_a_slack_tendon_has_no_turn_on_the_page(page):
    turn = page("--reversal", load=10, angles='"90 deg"')["Where"]
    assert turn["Δα"][1] is None
    assert len(turn["τ_m''"]) == 1


def test_a_page_without_speed_and_reversal_is_as_before(tendon, workplace):
    (workplace / "study.toml").write_text("")
    sections = {
        line["section"].split()[0] for line in tendon("state", "study.toml", "--json").json["lines"]
    }
    assert sections == {"Geometry", "Sheath,", "Load", "Balance", "Results", "Setting"}


# --- The figure -----------------------------------------------------------------------------------


SPEED = np.radians(60.0)


def drawn(tmp_path, load):
    """What the figure of a study draws of its first design, and its state at 75 degrees in flexion."""
    (tmp_path / "study.toml").write_text(
        TEXT.format(load=load, direction='flexion", "extension', angles=ALL)
    )
    plan = Plan(tendon_library.load_study(tmp_path / "study.toml"))
    first = (slice(0, 1),) * len(plan.axes)
    state = plan.state(Block(0, first, slice(0, 1), slice(0, 1)))
    return plan, state, {way: stroke_of(state.design, plan, way, SPEED) for way in plan.directions}


@pytest.mark.parametrize("load", [3, 10])
def test_the_area_of_the_loop_is_what_friction_takes(tmp_path, load):
    plan, state, strokes = drawn(tmp_path, load)
    x, y = (
        np.concatenate([getattr(stroke, name) for stroke in strokes.values()])
        for name in ("spool_angle", "motor_torque")
    )
    area = 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    loss = cycle(state.design, plan.elbow_angles[np.newaxis], np.array([[True], [False]]), SPEED)[
        "friction_loss"
    ]
    assert area == pytest.approx(float(loss.ravel()[0]), rel=0.005)  # but for the turns


def test_the_curves_are_the_states(tmp_path):
    plan, state, strokes = drawn(tmp_path, 3)
    there = strokes["flexion"]
    assert np.degrees(there.elbow_angle[[0, -1]]) == pytest.approx([0.0, 90.0])
    assert np.degrees(strokes["extension"].elbow_angle[[0, -1]]) == pytest.approx([90.0, 0.0])
    speed = np.gradient(there.spool_angle, there.elbow_angle) * SPEED
    np.testing.assert_allclose(there.motor_speed[2:-2], speed[2:-2], rtol=1e-3)
    _, torque, follows = turn_of(state, plan)
    assert torque[0] == pytest.approx(
        np.interp(np.radians(75.0), there.elbow_angle, there.motor_torque)
    )
    assert set(follows) == {"flexor", "extensor"}


def test_the_figure_has_the_limits_in_it(tendon, workplace):
    (workplace / "study.toml").write_text(
        TEXT.format(load=3, direction='flexion", "extension', angles=ALL)
    )
    assert tendon("state", "study.toml", "--reversal", "--plot", "motor.svg").exit == 0
    written = (workplace / "motor.svg").read_bytes()
    for text in (
        b"Torque against speed",
        b"Hysteresis",
        b"Turn from flexion at 75",
        b"8 N m, 25 W",
    ):
        assert text in written
