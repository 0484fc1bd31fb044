"""Rigs from plain dictionaries with the keys of a study, SI numbers throughout.

The geometry is read off Fig. 2 of the paper by vectors, not by its Eq. 1: the elbow is the origin,
the upper arm points up, the forearm hangs at the angle θ from straight down, and the flexor runs
from its anchor beside the upper arm to its anchor beside the forearm.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from .elastic_links import Curve, Rig, Tendon
from .gripped_cables import Array

GRAVITY = 9.81
"""Acceleration of gravity, m/s²."""

BASELINE: dict[str, Any] = {
    "arm": {
        "a1": 0.040,
        "b1": 0.150,
        "a2": 0.020,
        "b2": 0.150,
        "elbow_radius": 0.045,
        "forearm_mass": 1.54,
        "forearm_com": 0.174,
        "load_distance": 0.320,
        "upper_arm_angle": 0.0,
    },
    "sheath": {"friction": 0.07, "bend_angle": np.pi},
    "tendon": {"length": 2.0, "diameter": 1.5e-3, "youngs_modulus": 145e9, "pretension": 100.0},
    "spring": {"stiffness": 3000.0, "at": "joint"},
    "anchor": {"stiffness": np.inf},
    "spool": {"flexor_radius": 0.030, "ratio": 1.0},
    "load": {"mass": 0.0},
    "joint": {},
    "motion": {"inertia": 0.0},
    "model": {"reference": "published"},
    "setting": {"angle": 0.0},
}
"""The paper's suit, from its section 3 and the notes on what it leaves out."""


def merged(base: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return a dictionary of dictionaries with some of its entries replaced."""
    result = dict(base)
    for key, value in changes.items():
        if isinstance(value, Mapping) and isinstance(result.get(key), Mapping):
            result[key] = merged(result[key], value)
        else:
            result[key] = value
    return result


def anchor_line(arm: Mapping[str, float], angle: Array) -> tuple[Array, Array]:
    """Return the line from the upper arm's anchor to the forearm's, and the latter, m.

    Both have shape (2, …): forward and upward. The upper arm's anchor lies b1 above the elbow
    and a1 in front of the bone; the forearm's lies b2 along the forearm and a2 in front of it.
    """
    angle = np.asarray(angle, dtype=float)
    along = np.stack([np.sin(angle), -np.cos(angle)])
    in_front = np.stack([np.cos(angle), np.sin(angle)])
    forearm = arm["b2"] * along + arm["a2"] * in_front
    upper_arm = np.stack([np.full_like(angle, arm["a1"]), np.full_like(angle, arm["b1"])])
    return forearm - upper_arm, forearm


def flexor_length(arm: Mapping[str, float], angle: Array) -> Array:
    """Return the distance between the flexor's anchors, m."""
    line, _ = anchor_line(arm, angle)
    return np.hypot(line[0], line[1])


def flexor_lever(arm: Mapping[str, float], angle: Array) -> Array:
    """Return the lever of the flexor's line about the elbow, m, by the cross product."""
    line, forearm = anchor_line(arm, angle)
    pull = -line / np.hypot(line[0], line[1])
    return forearm[0] * pull[1] - forearm[1] * pull[0]


def curve_of(value: float | Mapping[str, Sequence[float]], name: str) -> Curve:
    """Return a number, or a table of it over the angle, as a function.

    Two points are a line, more a cubic spline that is smooth at all inner points.
    """
    if not isinstance(value, Mapping):
        return lambda angle: np.full_like(np.asarray(angle, dtype=float), value)
    at = np.asarray(value["angle"], dtype=float)
    values = np.asarray(value[name], dtype=float)
    if len(at) == 2:
        slope = (values[1] - values[0]) / (at[1] - at[0])
        return lambda angle: values[0] + slope * (np.asarray(angle) - at[0])
    return CubicSpline(at, values)


def joint_torque(joint: Mapping[str, Any]) -> Curve:
    """Return the torque that the joint itself asks for, N m."""
    stiffness = joint.get("stiffness", 0.0)
    rest = joint.get("rest_angle", 0.0)
    table = joint.get("torque")
    further = curve_of(table, "torque") if table else curve_of(0.0, "torque")
    return lambda angle: stiffness * (angle - rest) + further(angle)


def travels(suit: Mapping[str, Any]) -> tuple[Curve, Curve, Curve, Curve]:
    """Return flexor's and extensor's travels and moment arms over the angle.

    Travels of an excursion table count from the setting's angle. Those of the arm count from
    the straight arm: the published flexor's from b1 + b2, the initial one's from its length.
    """
    excursion = suit["joint"].get("excursion")
    if excursion:
        flexor = CubicSpline(excursion["angle"], excursion["flexor"])
        extensor = CubicSpline(excursion["angle"], excursion["extensor"])
        setup = suit["setting"]["angle"]
        return (
            lambda angle: flexor(angle) - flexor(setup),
            lambda angle: extensor(angle) - extensor(setup),
            flexor.derivative(),
            extensor.derivative(),
        )
    arm = suit["arm"]
    is_published = suit["model"]["reference"] == "published"
    longest = arm["b1"] + arm["b2"] if is_published else flexor_length(arm, np.zeros(()))
    radius = arm["elbow_radius"]
    return (
        lambda angle: longest - flexor_length(arm, angle),
        lambda angle: radius * np.asarray(angle),
        lambda angle: flexor_lever(arm, angle),
        curve_of(radius, "radius"),
    )


def side_of(part: Mapping[str, Any], side: str) -> dict[str, Any]:
    """Return a part's numbers on one side: its own where it states them, else the common ones."""
    return merged(part, part.get(side, {}))


def make_tendon(suit: Mapping[str, Any], side: str) -> Tendon:
    """Make one cable of a suit; `side` is "flexor" or "extensor"."""
    tendon = side_of(suit["tendon"], side)
    sheath = side_of(suit["sheath"], side)
    spring = side_of(suit["spring"], side)
    anchor = side_of(suit["anchor"], side)
    area = np.pi * tendon["diameter"] ** 2 / 4.0
    return Tendon(
        cable=tendon["length"] / (area * tendon["youngs_modulus"]),
        spring=1.0 / spring["stiffness"],
        tissue=1.0 / anchor["stiffness"],
        friction=sheath["friction"],
        bend=curve_of(sheath["bend_angle"], "bend"),
        pretension=tendon["pretension"],
        spring_at_motor=spring["at"] == "motor",
    )


def make_rig(changes: Mapping[str, Any]) -> Rig:
    """Make a rig of the paper's suit with some numbers replaced.

    Args:
        changes: Parts and their numbers, named as a study names them, in SI units. `motion` may
            have an `inertia` of the forearm alone, to which the load's m d² is added.
    """
    suit = merged(BASELINE, changes)
    arm = suit["arm"]
    load = suit["load"]["mass"]
    moment = arm["forearm_mass"] * arm["forearm_com"] + load * arm["load_distance"]
    flexor_travel, extensor_travel, flexor_arm, extensor_arm = travels(suit)
    inertia = suit["motion"]["inertia"]
    return Rig(
        flexor=make_tendon(suit, "flexor"),
        extensor=make_tendon(suit, "extensor"),
        flexor_travel=flexor_travel,
        extensor_travel=extensor_travel,
        flexor_arm=flexor_arm,
        extensor_arm=extensor_arm,
        flexor_radius=suit["spool"]["flexor_radius"],
        ratio=suit["spool"]["ratio"],
        weight_moment=GRAVITY * moment,
        upper_arm_angle=arm["upper_arm_angle"],
        inertia=inertia + load * arm["load_distance"] ** 2 if inertia else 0.0,
        joint_torque=joint_torque(suit["joint"]),
        setup_angle=suit["setting"]["angle"],
    )
