"""Every number on the page of `tendon state`, worked out again here from the study's own, line by line."""

import math

import numpy as np
import pytest

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
PER_SIDE = {
    "friction": (0.07, 0.09),
    "bend": (170, 200),
    "length": (2, 1.8),
    "diameter": (1.5e-3, 1.2e-3),
    "modulus": (145e9, 130e9),
    "spring": (1 / 3e3, 1 / 4e3),
}
ARM = {"a1": 0.038, "b1": 0.145, "a2": 0.022, "b2": 0.155, "radius": 0.043}
SPOOL, ETA = 0.028, 0.8


def path(angle):
    """Distance of the flexor's anchors, and its moment arm by differences."""
    turned = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    return float(np.linalg.norm(turned @ (ARM["a2"], -ARM["b2"]) - (ARM["a1"], ARM["b1"])))


def slope(function, at, step=1e-4):
    return (
        8 * (function(at + step) - function(at - step))
        - (function(at + 2 * step) - function(at - 2 * step))
    ) / (12 * step)


def arm_of(angle):
    return -slope(path, angle)


def sheath_lines(given):
    """Lines of the section on sheaths, and per side the sign of friction, the compliance and e^(σμφ)."""
    signs = (-1, 1) if given["direction"] == "flexion" else (1, -1)
    bends = [
        mu * math.radians(bend)
        for mu, bend in zip(PER_SIDE["friction"], PER_SIDE["bend"], strict=True)
    ]
    capstan = [math.exp(sign * bend) for sign, bend in zip(signs, bends, strict=True)]
    tendon = [
        length / (math.pi * d**2 / 4 * modulus) * (1 - 1 / c) / (sign * bend)
        for length, d, modulus, c, sign, bend in zip(
            *(PER_SIDE[key] for key in ("length", "diameter", "modulus")),
            capstan,
            signs,
            bends,
            strict=True,
        )
    ]
    stiff = [one + other for one, other in zip(tendon, PER_SIDE["spring"], strict=True)]
    pretension = given["pretension"], given["extensor_pretension"]
    return {
        "μφ": bends,
        "e^(σμφ)": capstan,
        "c_Ten": tendon,
        "1/K_SE": PER_SIDE["spring"],
        "c_f, c_e": stiff,
        "F0": pretension,
    }


STRAIGHT = {
    "angle": 0.0,
    "inclination": 0.0,
    "mass": 0.0,
    "direction": "extension",
    "slack": "bilateral",
}


def page(given):
    """Every line by its symbol: the state, and the same suit where its pretension is set."""
    there = state_lines(given | STRAIGHT)
    c_f, c_e = there["c_f, c_e"]
    setting = {
        "F_o,set": there["F_o"],
        "F_I,set": there["F_I"],
        "dF0/dl": ((1 + ETA) / (ETA * c_f + c_e),),
    }
    return state_lines(given) | setting


def state_lines(given):
    """Every line of one state by its symbol."""
    angle, psi = math.radians(given["angle"]), math.radians(given["inclination"])
    reference = path(0) if given["reference"] == "initial" else ARM["b1"] + ARM["b2"]
    sheaths = sheath_lines(given)
    (c_f, c_e), (f_f, f_e), (w_f, w_e) = sheaths["c_f, c_e"], sheaths["F0"], sheaths["e^(σμφ)"]
    moment_arm, travel, drawn = arm_of(angle), reference - path(angle), ARM["radius"] * angle
    moment = 1.6 * 0.17 + given["mass"] * 0.31
    torque = 9.81 * moment * math.sin(angle + psi)
    miss = drawn - ETA * travel
    preload = miss + ETA * c_f * f_f + c_e * f_e
    matrix = np.array([[moment_arm, -ARM["radius"]], [ETA * c_f, c_e]])
    x_both, y_both = np.linalg.solve(matrix, [torque, preload])
    x, y = x_both, y_both
    if given["slack"] == "unilateral":
        y = max(y_both, 0.0, -torque / ARM["radius"])
        x = (torque + ARM["radius"] * y) / moment_arm
    loose = ETA * c_f * x + c_e * y - preload
    on_flexor = x < 1e-9 < y
    wound = drawn - c_e * (y - f_e) if on_flexor else ETA * (travel + c_f * (x - f_f))
    stiffness = 9.81 * moment * math.cos(angle + psi) - x * slope(arm_of, angle, 1e-2)
    stiffness += 0 if on_flexor else moment_arm**2 / c_f
    stiffness += ARM["radius"] ** 2 / c_e if y > 1e-9 or given["slack"] == "bilateral" else 0
    lines = {
        "a1, b1": (ARM["a1"], ARM["b1"]),
        "a2, b2": (ARM["a2"], ARM["b2"]),
        "θ": (angle,),
        "L_c": (path(angle),),
        "H_f": (travel,),
        "H_e": (drawn,),
        "J": (moment_arm,),
        "R_elb": (ARM["radius"],),
        **sheaths,
        "M": (moment,),
        "θ + ψ": (angle + psi,),
        "τ_a": (torque,),
        "η": (ETA,),
        "h": (miss,),
        "D": (preload,),
        "Δ": (np.linalg.det(matrix),),
        "x_b": (x_both,),
        "y_b": (y_both,),
        "y": (y,),
        "x": (x,),
        "σ": (loose,),
        "F_o": (x, y),
        "F_I": (x / w_f, y / w_e),
        "ΔL_Ten": tuple(
            c * (t - f) for c, t, f in zip(sheaths["c_Ten"], (x, y), sheaths["F0"], strict=True)
        ),
        "ΔL_SE": tuple(
            c * (t - f) for c, t, f in zip(PER_SIDE["spring"], (x, y), sheaths["F0"], strict=True)
        ),
        "τ_m": ((x / w_f - ETA * y / w_e) * SPOOL,),
        "α": (wound / ETA / SPOOL,),
        "k": (stiffness,),
    }
    if given["slack"] == "unilateral":
        lines["s"] = (loose / ETA, 0.0) if on_flexor else (0.0, loose)
    return lines


@pytest.mark.parametrize("case", CASES)
def test_every_number_on_the_page_of_a_state_and_its_print(tendon, workplace, case):
    given = BASE | CASES[case]
    (workplace / "study.toml").write_text(STUDY.format(**given))
    record, text = tendon("state", "study.toml", "--json").json, tendon("state", "study.toml").out
    expected = page(given)
    assert {line["symbol"] for line in record["lines"]} == set(expected)
    printed = {
        line[2:].split("  ")[0].strip(): line for line in text.splitlines() if line.startswith("  ")
    }
    for line in record["lines"]:
        symbol = line["symbol"]
        assert line["values"] == pytest.approx(list(expected[symbol]), rel=1e-6, abs=1e-12), symbol
        shown = printed[
            next(key for key in printed if key == symbol or key.startswith(symbol + " "))
        ]
        assert all(f"{value:.7g}" in shown for value in line["values"]), symbol
        assert line["unit"] in shown
    assert record["status"] == case.partition(",")[0]
    assert text.rstrip().endswith(f"Status: {record['status']}")


def test_notes_say_what_chooses_and_fit_a_terminal(tendon, workplace):
    (workplace / "study.toml").write_text(
        "[sheath]\nfriction = { mean = 0.07, std = 0.004 }\n[uncertainty]\ndraws = 16\n"
        '[spring]\nstiffness = ["3 kN/m", "5 kN/m"]\n[people]\ncount = 3\n'
    )
    shown = tendon("state", "study.toml")
    assert max(map(len, shown.out.partition("\n\n")[0].splitlines())) <= 80
    notes = tendon("state", "study.toml", "--json").json["notes"]
    assert [note for note in notes if "sheath.friction" in note]
    assert [note for note in notes if "spring.stiffness" in note]
    chosen = ("--set", "sheath.friction=0.07", "--set", "spring.stiffness=5 kN/m")
    notes = tendon("state", "study.toml", "--json", *chosen).json["notes"]
    assert not [note for note in notes if "sheath.friction" in note or "spring.stiffness" in note]
