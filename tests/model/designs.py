"""Designs to test with: the paper's, and random ones far from it in every direction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tendon_cli.engine.window_fold import fold_ends
from tendon_cli.model.design import Design, Limb, Side, shape_of
from tendon_cli.model.kinematics import Anchors
from tendon_cli.model.window import with_binding_limits

SIDES = ("flexor", "extensor")

BOTH_DIRECTIONS = np.array([[True], [False]])
"""Flexion, then extension, along an axis before that of the angles."""

BASELINE_SIDE = {
    "friction": 0.07,
    "bend_angle": np.pi,
    "length": 2.0,
    "diameter": 1.5e-3,
    "youngs_modulus": 145e9,
    "spring_stiffness": 3e3,
    "pretension": 100.0,
}

WORN_SIDE = {"anchor_stiffness": np.inf, "spring_at_motor": False}
"""Further numbers of a side, which designs may leave out."""

BASELINE_ARM = {
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
}

BASELINE = BASELINE_ARM | {
    f"{side}_{name}": value for side in SIDES for name, value in BASELINE_SIDE.items()
}
"""The paper's arm and actuator, the forearm after Winter."""


def design(p) -> Design:
    """Return the package's design of flat parameters, numbers or arrays."""
    anchors = Anchors(p["a1"], p["b1"], p["a2"], p["b2"], p["elbow_radius"], p["from_initial"])
    arm = Limb(
        anchors,
        p["forearm_mass"],
        p["forearm_com"],
        p["load_distance"],
        p["upper_arm_angle"],
        stiffness=p.get("joint_stiffness", 0.0),
        rest_angle=p.get("rest_angle", 0.0),
    )
    return Design(
        arm,
        design_side(p, "flexor"),
        design_side(p, "extensor"),
        flexor_radius=p["flexor_radius"],
        ratio=p["ratio"],
        load_mass=p["load_mass"],
        unilateral=p["unilateral"],
    )


def design_side(p, side) -> Side:
    """Return one side of a design."""
    numbers = {name: p[f"{side}_{name}"] for name in BASELINE_SIDE}
    worn = {name: p.get(f"{side}_{name}", usual) for name, usual in WORN_SIDE.items()}
    return Side(**numbers, **worn)


def kinematics(arm: Anchors, angle, *, from_initial=False):
    """Return the motion of an arm, its travel measured from either reference."""
    return replace(arm, from_initial=from_initial).motion(angle)


def baseline(**changes):
    """Return the baseline's parameters with changes.

    `pretension`, `spring_stiffness` and other numbers of a side change both sides.
    """
    p = dict(BASELINE)
    for name, value in changes.items():
        if name in BASELINE_SIDE:
            for side in SIDES:
                p[f"{side}_{name}"] = value
        else:
            assert name in p, name
            p[name] = value
    return p


def scattered(count: int, seed: int):
    """Return random parameters, elbow angles and directions, as arrays of one length.

    A tenth each is without friction, without bends, without load and weightless; in a sixth the
    forearm hangs plumb, so that no moment is asked for. Half measure travel from the initial path,
    four in ten are bilateral.
    """
    rng = np.random.default_rng(seed)

    def even(low, high):
        return rng.uniform(low, high, count)

    def wide(low, high):
        return np.exp(even(np.log(low), np.log(high)))

    def chance(share):
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
        "load_mass": np.where(chance(0.1), 0.0, even(0.0, 12.0)),
        "upper_arm_angle": np.where(chance(0.3), 0.0, even(-2.0, 1.2)),
        "flexor_radius": even(0.01, 0.06),
        "ratio": wide(0.5, 2.0),
        "from_initial": chance(0.5),
        "unilateral": chance(0.6),
    }
    for side in SIDES:
        p |= {
            f"{side}_friction": np.where(chance(0.1), 0.0, even(0.0, 0.25)),
            f"{side}_bend_angle": np.where(chance(0.1), 0.0, even(0.0, 9.0)),
            f"{side}_length": even(0.3, 3.0),
            f"{side}_diameter": even(0.5e-3, 3e-3),
            f"{side}_youngs_modulus": wide(2e9, 210e9),
            f"{side}_spring_stiffness": wide(400.0, 60e3),
            f"{side}_pretension": np.where(chance(0.05), 0.0, wide(10.0, 600.0)),
        }
    angle = even(-0.6, 3.0)
    plumb = chance(1 / 6)
    p["upper_arm_angle"] = np.where(plumb, -angle, p["upper_arm_angle"])
    weightless = chance(0.1)
    for mass in ("forearm_mass", "load_mass"):
        p[mass] = np.where(weightless, 0.0, p[mass])
    flexion = chance(0.5)
    return p, angle, flexion


def worn(count: int, seed: int):
    """Return `scattered` on real arms.

    Anchors give, springs may sit at the motor, and the joint has a stiffness of its own.
    """
    p, angle, flexion = scattered(count, seed)
    rng = np.random.default_rng([seed, 1])
    for side in SIDES:
        soft = np.exp(rng.uniform(np.log(2e3), np.log(50e3), count))
        p[f"{side}_anchor_stiffness"] = np.where(rng.random(count) < 0.2, np.inf, soft)
        p[f"{side}_spring_at_motor"] = rng.random(count) < 0.5
    p["joint_stiffness"] = np.where(rng.random(count) < 0.2, 0.0, rng.uniform(0.0, 3.0, count))
    p["rest_angle"] = rng.uniform(-0.2, 2.0, count)
    return p, angle, flexion


def window_of(made, angles, flexion, bounds):
    """Return the windows of designs over their states, but for a limit on power."""
    of_bounds = [np.shape(bound)[:-2] for bound in bounds.values()]
    shape = np.broadcast_shapes(shape_of(made), *of_bounds)
    ends = fold_ends(made, shape, angles, flexion, bounds)
    return with_binding_limits(ends, made, angles, flexion, bounds)


def stored_energy(state):
    """Return the elastic energy of both tendons, springs and anchors, J."""
    sides = ((state.flexor, state.balance.flexor), (state.extensor, state.balance.extensor))
    return sum(0.5 * sheathed.energy_compliance * tension**2 for sheathed, tension in sides)
