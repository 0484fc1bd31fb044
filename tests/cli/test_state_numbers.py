"""The page of `tendon state` has the numbers that are worked out again here, line by line."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import tendon_cli
from tests.cli.conftest import set_options

STUDY = """
[arm]
a1 = "38 mm"
b1 = "145 mm"
a2 = "22 mm"
b2 = "155 mm"
elbow_radius = "43 mm"
forearm_mass = "1.6 kg"
forearm_com = "170 mm"
load_distance = "310 mm"
upper_arm_angle = "{inclination} deg"
[sheath]
friction = 0.07
bend_angle = "170 deg"
[sheath.extensor]
friction = 0.09
bend_angle = "200 deg"
[tendon]
length = "2 m"
diameter = "1.5 mm"
youngs_modulus = "145 GPa"
pretension = "{pretension} N"
[tendon.extensor]
length = "1.8 m"
diameter = "1.2 mm"
youngs_modulus = "130 GPa"
pretension = "{extensor_pretension} N"
[spring]
stiffness = "3 kN/m"
[spring.extensor]
stiffness = "4 kN/m"
[spool]
flexor_radius = "28 mm"
ratio = 0.8
[load]
mass = "{mass} kg"
[motion]
direction = "{direction}"
elbow_angle = "{angle} deg"
[model]
slack = "{slack}"
reference = "{reference}"
"""
BASE = {
    "inclination": 20,
    "pretension": 110,
    "extensor_pretension": 140,
    "mass": 2,
    "direction": "flexion",
    "angle": 60,
    "slack": "unilateral",
    "reference": "published",
}
CASES = {
    "taut": {},
    "taut, extension, from the initial length": {"direction": "extension", "reference": "initial"},
    "extensor slack": {"mass": 10},
    "flexor slack": {
        "inclination": -100,
        "pretension": 5,
        "extensor_pretension": 5,
        "direction": "extension",
    },
    "extensor slack, bilateral": {"mass": 10, "slack": "bilateral"},
}
ARM = {"a1": 0.038, "b1": 0.145, "a2": 0.022, "b2": 0.155, "radius": 0.043}  # m
SPOOL_RADIUS = 0.028  # m
RATIO = 0.8
GRAVITY = 9.81  # m/s²
# Of the flexor and the extensor:
FRICTION = np.array([0.07, 0.09])
BEND_ANGLE = np.radians([170.0, 200.0])
LENGTH = np.array([2.0, 1.8])  # m
DIAMETER = np.array([1.5e-3, 1.2e-3])  # m
YOUNGS_MODULUS = np.array([145e9, 130e9])  # Pa
SPRING_COMPLIANCE = 1.0 / np.array([3e3, 4e3])  # m/N


def path(angle):
    """Return the distance of the flexor's anchors, m."""
    rotation = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    distal = rotation @ (ARM["a2"], -ARM["b2"])
    proximal = np.array([ARM["a1"], ARM["b1"]])
    return float(np.linalg.norm(distal - proximal))


def slope(function, place, step=1e-4):
    """Return the derivative of a function by central differences of the fourth order."""
    near = function(place + step) - function(place - step)
    far = function(place + 2 * step) - function(place - 2 * step)
    return (8 * near - far) / (12 * step)


def arm_of(angle):
    """Return the moment arm of the flexor, m."""
    return -slope(path, angle)


def sheath_lines(given):
    """Return the lines of the section on sheaths by symbol, each of the flexor and the extensor."""
    signs = np.array([-1, 1])
    if given["direction"] == "extension":
        signs = -signs
    exponents = FRICTION * BEND_ANGLE
    capstan = np.exp(signs * exponents)
    area = np.pi * DIAMETER**2 / 4
    share = (1 - 1 / capstan) / (signs * exponents)  # of the stretch without friction
    tendon = LENGTH / (area * YOUNGS_MODULUS) * share
    return {
        "μφ": exponents,
        "e^(σμφ)": capstan,
        "c_Ten": tendon,
        "1/K_SE": SPRING_COMPLIANCE,
        "c_f, c_e": tendon + SPRING_COMPLIANCE,
        "F0": np.array([given["pretension"], given["extensor_pretension"]]),
    }


def state_lines(given):
    """Return the lines of one state by symbol."""
    angle = math.radians(given["angle"])
    inclination = math.radians(given["inclination"])
    reference = ARM["b1"] + ARM["b2"]
    if given["reference"] == "initial":
        reference = path(0)
    is_bilateral = given["slack"] == "bilateral"
    sheaths = sheath_lines(given)
    compliance_f, compliance_e = sheaths["c_f, c_e"]
    pretension_f, pretension_e = sheaths["F0"]

    radius = ARM["radius"]
    moment_arm = arm_of(angle)
    travel_f = reference - path(angle)
    travel_e = radius * angle
    moment = 1.6 * 0.17 + given["mass"] * 0.31
    torque = GRAVITY * moment * math.sin(angle + inclination)
    mismatch = travel_e - RATIO * travel_f
    preload = mismatch + RATIO * compliance_f * pretension_f + compliance_e * pretension_e

    # Tensions with both tendons taut, then with a tendon that cannot push.
    matrix = np.array([[moment_arm, -radius], [RATIO * compliance_f, compliance_e]])
    both_f, both_e = np.linalg.solve(matrix, [torque, preload])
    tension_f = both_f
    tension_e = both_e
    if not is_bilateral:
        tension_e = max(both_e, 0.0, -torque / radius)
        tension_f = (torque + radius * tension_e) / moment_arm
    tensions = np.array([tension_f, tension_e])
    proximal = tensions / sheaths["e^(σμφ)"]
    loose = RATIO * compliance_f * tension_f + compliance_e * tension_e - preload
    is_flexor_slack = tension_f < 1e-9 < tension_e

    if is_flexor_slack:
        wound = travel_e - compliance_e * (tension_e - pretension_e)
    else:
        wound = RATIO * (travel_f + compliance_f * (tension_f - pretension_f))
    stiffness = GRAVITY * moment * math.cos(angle + inclination)
    stiffness -= tension_f * slope(arm_of, angle, 1e-2)
    if not is_flexor_slack:
        stiffness += moment_arm**2 / compliance_f
    if tension_e > 1e-9 or is_bilateral:
        stiffness += radius**2 / compliance_e

    lines = {
        "a1, b1": (ARM["a1"], ARM["b1"]),
        "a2, b2": (ARM["a2"], ARM["b2"]),
        "θ": (angle,),
        "L_c": (path(angle),),
        "H_f": (travel_f,),
        "H_e": (travel_e,),
        "J": (moment_arm,),
        "R_elb": (radius,),
        **sheaths,
        "M": (moment,),
        "θ + ψ": (angle + inclination,),
        "τ_a": (torque,),
        "η": (RATIO,),
        "h": (mismatch,),
        "D": (preload,),
        "Δ": (np.linalg.det(matrix),),
        "x_b": (both_f,),
        "y_b": (both_e,),
        "y": (tension_e,),
        "x": (tension_f,),
        "σ": (loose,),
        "F_o": tensions,
        "F_I": proximal,
        "ΔL_Ten": sheaths["c_Ten"] * (tensions - sheaths["F0"]),
        "ΔL_SE": SPRING_COMPLIANCE * (tensions - sheaths["F0"]),
        "τ_m": ((proximal[0] - RATIO * proximal[1]) * SPOOL_RADIUS,),
        "α": (wound / RATIO / SPOOL_RADIUS,),
        "k": (stiffness,),
    }
    if not is_bilateral:
        lines["s"] = (0.0, loose)
        if is_flexor_slack:
            lines["s"] = (loose / RATIO, 0.0)
    return lines


STRAIGHT = {
    "angle": 0.0,
    "inclination": 0.0,
    "mass": 0.0,
    "direction": "extension",
    "slack": "bilateral",
}


def page_lines(given):
    """Return the lines of a page: those of its state, and of the straight arm that is pretensioned.

    The keys of the result are symbols.
    """
    straight = state_lines(given | STRAIGHT)
    compliance_f, compliance_e = straight["c_f, c_e"]
    per_length = (1 + RATIO) / (RATIO * compliance_f + compliance_e)  # N/m
    setting = {
        "F_o,set": straight["F_o"],
        "F_I,set": straight["F_I"],
        "dF0/dl": (per_length,),
    }
    return state_lines(given) | setting


@pytest.mark.parametrize("case", CASES)
def test_every_number_on_the_page_of_a_state_and_its_print(tendon, write_study, case):
    given = BASE | CASES[case]
    write_study(STUDY.format(**given))
    record = tendon("state", "study.toml", "--json").json
    text = tendon("state", "study.toml").out
    expected = page_lines(given)
    assert {line["symbol"] for line in record["lines"]} == set(expected)
    printed = {}
    for line in text.splitlines():
        if line.startswith("  "):
            label = line[2:].split("  ")[0].strip()
            printed[label] = line
    for line in record["lines"]:
        symbol = line["symbol"]
        assert line["values"] == pytest.approx(list(expected[symbol]), rel=1e-6, abs=1e-12), symbol
        label = next(key for key in printed if key == symbol or key.startswith(symbol + " "))
        shown = printed[label]
        assert all(f"{value:.7g}" in shown for value in line["values"]), symbol
        assert line["unit"] in shown
    assert record["status"] == case.partition(",")[0]
    assert text.rstrip().endswith(f"Status: {record['status']}")


SEVERAL_VALUES = """
[sheath]
friction = { mean = 0.07, std = 0.004 }
[uncertainty]
draws = 16
[spring]
stiffness = ["3 kN/m", "5 kN/m"]
[people]
count = 3
"""


def notes_about(key, notes):
    """Return the notes that name a key."""
    return [note for note in notes if key in note]


def test_notes_say_what_chooses_and_fit_a_terminal(tendon, write_study):
    write_study(SEVERAL_VALUES)
    shown = tendon("state", "study.toml").out
    head = shown.partition("\n\n")[0]
    assert max(map(len, head.splitlines())) <= 80
    notes = tendon("state", "study.toml", "--json").json["notes"]
    assert notes_about("sheath.friction", notes)
    assert notes_about("spring.stiffness", notes)
    chosen = set_options("sheath.friction=0.07", "spring.stiffness=5 kN/m")
    notes = tendon("state", "study.toml", "--json", *chosen).json["notes"]
    assert not notes_about("sheath.friction", notes)
    assert not notes_about("spring.stiffness", notes)


def test_a_number_that_json_does_not_have_is_null():
    page = tendon_cli.state(tendon_cli.study({}))
    line = replace(page.lines[0], values=(math.inf, -math.inf, math.nan, 1.0))
    record = replace(page, lines=(line,)).record
    assert record["lines"][0]["values"] == [None, None, None, 1.0]
    json.dumps(record, allow_nan=False)


@pytest.mark.parametrize("angles", [["60 deg"], ["10 deg", "60 deg"]])
@pytest.mark.parametrize("directions", [["flexion"], ["flexion", "extension"]])
def test_the_note_on_other_states_names_what_can_be_chosen(angles, directions):
    motion = {"elbow_angle": angles, "direction": directions}
    text = " ".join(tendon_cli.state({"motion": motion}).text.split())
    assert ("motion.elbow_angle=" in text) == (len(angles) > 1)
    assert ("motion.direction=" in text) == (len(directions) > 1)
    assert ("chooses another" in text) == (len(angles) + len(directions) == 3)
