"""A study that has everything, and the numbers of each of its designs, written by hand in SI."""

from __future__ import annotations

import itertools
import math

from tendon_cli.model.design import Design, Limb, Side
from tendon_cli.model.kinematics import Anchors

STUDY = """
name = "everything"

[arm]
upper_arm_angle = "20 deg"

[tendon]
pretension = ["60 N", "250 N"]

[tendon.extensor]
length = "1.5 m"

[sheath]
friction = [0.05, 0.1]

[load]
mass = ["0 kg", "6 kg"]

[[cases]]
name = "as it is"

[[cases]]
name = "bilateral"
model = { slack = "bilateral" }
spool = { ratio = 0.8 }

[[cases]]
name = "rough extensor"
model = { reference = "initial" }
sheath = { bend_angle = "270 deg", extensor = { friction = 0.2 } }
spring = { flexor = { stiffness = "2 kN/m" } }

[[cases]]
name = "weightless"
arm = { forearm_mass = "0 kg", b1 = "160 mm", upper_arm_angle = "-60 deg" }
spool = { flexor_radius = "25 mm" }

[motion]
direction = ["extension", "flexion"]
elbow_angle = ["90 deg", "-30 deg", "0 deg", "15 deg", "60 deg", "130 deg", "175 deg"]
"""

NEVER_PAST_THE_CENTRE = STUDY.replace('"-30 deg", ', "").replace(', "175 deg"', "")
"""The same with angles at which the flexor always has a moment arm."""

PRETENSION_PER_SIDE = NEVER_PAST_THE_CENTRE.replace(
    'name = "rough extensor"',
    'name = "rough extensor"\ntendon = { flexor = { pretension = "90 N" } }',
).replace('pretension = ["60 N", "250 N"]', 'pretension = "150 N"\ndiameter = ["1 mm", "2 mm"]')

BASE = {
    "arm.a1": 0.04,
    "arm.b1": 0.15,
    "arm.a2": 0.02,
    "arm.b2": 0.15,
    "arm.elbow_radius": 0.045,
    "arm.forearm_mass": 1.54,
    "arm.forearm_com": 0.174,
    "arm.load_distance": 0.32,
    "arm.upper_arm_angle": math.radians(20.0),
    "sheath.bend_angle": math.pi,
    "tendon.length": 2.0,
    "tendon.extensor.length": 1.5,
    "tendon.diameter": 0.0015,
    "tendon.youngs_modulus": 145e9,
    "spring.stiffness": 3000.0,
    "spool.flexor_radius": 0.03,
    "spool.ratio": 1.0,
    "unilateral": True,
    "from_initial": False,
}

CASES = {
    "as it is": {},
    "bilateral": {"unilateral": False, "spool.ratio": 0.8},
    "rough extensor": {
        "from_initial": True,
        "sheath.bend_angle": 1.5 * math.pi,
        "sheath.extensor.friction": 0.2,
        "spring.flexor.stiffness": 2000.0,
    },
    "weightless": {
        "arm.forearm_mass": 0.0,
        "arm.b1": 0.16,
        "arm.upper_arm_angle": math.radians(-60.0),
        "spool.flexor_radius": 0.025,
    },
}

AXES = {"tendon.pretension": (60.0, 250.0), "sheath.friction": (0.05, 0.1), "load.mass": (0.0, 6.0)}
AXES_PER_SIDE = {
    "tendon.diameter": (0.001, 0.002),
    "sheath.friction": (0.05, 0.1),
    "load.mass": (0.0, 6.0),
}

RANGES = {
    "arm.a1": (0.0, 0.07),
    "arm.b1": (0.08, 0.30),
    "arm.a2": (0.0, 0.05),
    "arm.b2": (0.04, 0.20),
    "arm.elbow_radius": (0.02, 0.07),
    "arm.forearm_mass": (0.3, 3.0),
    "arm.load_distance": (0.2, 0.4),
    "arm.upper_arm_angle": (-2.0, 1.2),
    "load.mass": (0.0, 12.0),
    "spool.ratio": (0.5, 2.0),
    "spool.flexor_radius": (0.01, 0.06),
    "sheath.friction": (0.0, 0.25),
    "sheath.extensor.friction": (0.0, 0.25),
    "sheath.bend_angle": (0.0, 9.0),
    "tendon.length": (0.3, 3.0),
    "tendon.diameter": (0.5e-3, 3e-3),
    "tendon.youngs_modulus": (2e9, 2e11),
    "spring.stiffness": (400.0, 60e3),
    "spring.flexor.stiffness": (400.0, 60e3),
}
"""Least and largest value of the numbers that may differ between designs."""

SIDE_KEYS = {
    "friction": "sheath.friction",
    "bend_angle": "sheath.bend_angle",
    "length": "tendon.length",
    "diameter": "tendon.diameter",
    "youngs_modulus": "tendon.youngs_modulus",
    "spring_stiffness": "spring.stiffness",
    "pretension": "tendon.pretension",
}


def all_numbers():
    """Yield the numbers of every design of STUDY, in the order of the product."""
    for case, *values in itertools.product(CASES, *AXES.values()):
        yield BASE | CASES[case] | dict(zip(AXES, values, strict=True))


def all_numbers_per_side():
    """Yield the numbers of every design of PRETENSION_PER_SIDE."""
    for case, *values in itertools.product(CASES, *AXES_PER_SIDE.values()):
        numbers = BASE | {"tendon.pretension": 150.0} | CASES[case]
        if case == "rough extensor":
            numbers["tendon.flexor.pretension"] = 90.0
        yield numbers | dict(zip(AXES_PER_SIDE, values, strict=True))


def on_side(numbers, key, side):
    """Return the value that counts on a side: its own before the common one."""
    table, name = key.split(".")
    return numbers.get(f"{table}.{side}.{name}", numbers.get(key))


def design_of(numbers) -> Design:
    """Return the model's design of plain numbers."""

    def side_of(side):
        return Side(**{name: on_side(numbers, key, side) for name, key in SIDE_KEYS.items()})

    def of_arm(*names):
        return [numbers[f"arm.{name}"] for name in names]

    lengths = of_arm("a1", "b1", "a2", "b2", "elbow_radius")
    weight = of_arm("forearm_mass", "forearm_com", "load_distance", "upper_arm_angle")
    return Design(
        arm=Limb(Anchors(*lengths, numbers["from_initial"]), *weight),
        flexor=side_of("flexor"),
        extensor=side_of("extensor"),
        flexor_radius=numbers["spool.flexor_radius"],
        ratio=numbers["spool.ratio"],
        load_mass=numbers["load.mass"],
        unilateral=numbers["unilateral"],
    )
