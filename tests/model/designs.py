"""Designs to test with: the paper's, and random ones far from it in every direction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tendon_cli.model.design import Design, Limb, Side
from tendon_cli.model.kinematics import Anchors

SIDE = (
    "friction",
    "bend_angle",
    "length",
    "diameter",
    "youngs_modulus",
    "spring_stiffness",
    "pretension",
)

BASELINE = {
    "a1": 0.040,
    "b1": 0.150,
    "a2": 0.020,
    "b2": 0.150,
    "elbow_radius": 0.045,
    "forearm_mass": 1.54,
    "forearm_com": 0.174,
    "load_distance": 0.32,
    "upper_arm_angle": 0.0,
    "flexor_radius": 0.030,
    "ratio": 1.0,
    "load_mass": 0.0,
    "from_initial": False,
    "unilateral": True,
} | {
    f"{side}_{name}": value
    for side in ("flexor", "extensor")
    for name, value in zip(SIDE, (0.07, np.pi, 2.0, 1.5e-3, 145e9, 3e3, 100.0), strict=True)
}
"""The paper's arm and actuator, the forearm after Winter."""


def design(p) -> Design:
    """The package's design of flat parameters, numbers or arrays."""
    worn = {"anchor_stiffness": np.inf, "spring_at_motor": False}
    sides = {
        side: Side(
            **{name: p[f"{side}_{name}"] for name in SIDE},
            **{name: p.get(f"{side}_{name}", usual) for name, usual in worn.items()},
        )
        for side in ("flexor", "extensor")
    }
    anchors = Anchors(p["a1"], p["b1"], p["a2"], p["b2"], p["elbow_radius"], p["from_initial"])
    joint = {"stiffness": p.get("joint_stiffness", 0.0), "rest_angle": p.get("rest_angle", 0.0)}
    arm = Limb(
        anchors,
        p["forearm_mass"],
        p["forearm_com"],
        p["load_distance"],
        p["upper_arm_angle"],
        **joint,
    )
    rest = ("flexor_radius", "ratio", "load_mass", "unilateral")
    return Design(arm=arm, **sides, **{name: p[name] for name in rest})


def kinematics(arm: Anchors, angle, *, from_initial=False):
    """The motion of an arm, its travel measured from either reference."""
    return replace(arm, from_initial=from_initial).motion(angle)


def baseline(**changes):
    """The baseline's parameters with changes; `pretension`, `spring_stiffness` and the like change both sides."""
    p = dict(BASELINE)
    for name, value in changes.items():
        names = [f"flexor_{name}", f"extensor_{name}"] if name in SIDE else [name]
        assert all(known in p for known in names), names
        p |= dict.fromkeys(names, value)
    return p


def scattered(count: int, seed: int):
    """Random parameters, elbow angles and directions, as arrays of one length.

    A tenth each is without friction, without bends, without load and weightless; in a sixth the forearm hangs
    plumb, so that no moment is asked for; half measure travel from the initial path, half are bilateral.
    """
    rng = np.random.default_rng(seed)

    def even(low, high):
        return rng.uniform(low, high, count)

    def wide(low, high):
        return np.exp(even(np.log(low), np.log(high)))

    def some(share):
        return rng.random(count) < share

    p = {
        "a1": even(0.02, 0.07),
        "b1": even(0.10, 0.30),
        "a2": even(0.005, 0.05),
        "b2": even(0.04, 0.20),
        "elbow_radius": even(0.02, 0.07),
        "forearm_mass": even(0.3, 3.0),
        "forearm_com": even(0.1, 0.25),
        "load_distance": even(0.2, 0.4),
        "load_mass": np.where(some(0.1), 0.0, even(0.0, 12.0)),
        "upper_arm_angle": np.where(some(0.3), 0.0, even(-2.0, 1.2)),
        "flexor_radius": even(0.01, 0.06),
        "ratio": wide(0.5, 2.0),
        "from_initial": some(0.5),
        "unilateral": some(0.6),
    }
    for side in ("flexor", "extensor"):
        p |= {
            f"{side}_friction": np.where(some(0.1), 0.0, even(0.0, 0.25)),
            f"{side}_bend_angle": np.where(some(0.1), 0.0, even(0.0, 9.0)),
            f"{side}_length": even(0.3, 3.0),
            f"{side}_diameter": even(0.5e-3, 3e-3),
            f"{side}_youngs_modulus": wide(2e9, 210e9),
            f"{side}_spring_stiffness": wide(400.0, 60e3),
            f"{side}_pretension": np.where(some(0.05), 0.0, wide(10.0, 600.0)),
        }
    angle = even(-0.6, 3.0)
    plumb = some(1 / 6)
    p["upper_arm_angle"] = np.where(plumb, -angle, p["upper_arm_angle"])
    weightless = some(0.1)
    for mass in ("forearm_mass", "load_mass"):
        p[mass] = np.where(weightless, 0.0, p[mass])
    return p, angle, some(0.5)


def worn(count: int, seed: int):
    """The same on real arms: what gives behind the anchors, springs at the motor, and the joint's own stiffness."""
    p, angle, flexion = scattered(count, seed)
    rng = np.random.default_rng([seed, 1])
    for side in ("flexor", "extensor"):
        soft = np.exp(rng.uniform(np.log(2e3), np.log(50e3), count))
        p[f"{side}_anchor_stiffness"] = np.where(rng.random(count) < 0.2, np.inf, soft)
        p[f"{side}_spring_at_motor"] = rng.random(count) < 0.5
    p["joint_stiffness"] = np.where(rng.random(count) < 0.2, 0.0, rng.uniform(0.0, 3.0, count))
    p["rest_angle"] = rng.uniform(-0.2, 2.0, count)
    return p, angle, flexion
