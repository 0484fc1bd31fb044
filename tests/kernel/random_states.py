"""States of random designs along random axes, in random directions and at random elbow angles."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design, Limb, Posture, Side
from tendon_cli.model.kinematics import Anchors, Excursion, Spline
from tests.model.designs import BOTH_DIRECTIONS

ANGLE_COUNTS = (1, 2, 3, 7, 8, 9, 16, 17, 31, 33, 97, 257, 300)
SIDE = {
    "friction": (0.0, 0.25),
    "bend_angle": (0.0, 9.0),
    "length": (0.3, 3.0),
    "diameter": (0.5e-3, 3e-3),
    "youngs_modulus": (2e9, 2e11),
    "spring_stiffness": (400.0, 60e3),
    "pretension": (0.0, 400.0),
}
"""Smallest and largest value of each number of a side."""


@dataclass(frozen=True)
class States:
    """States of designs along their axes, in each direction and at each elbow angle."""

    design: Design
    flexion: np.ndarray
    angles: np.ndarray
    shape: tuple[int, ...]
    """Lengths of the designs' axes, directions and angles."""

    @cached_property
    def state(self) -> State:
        """State of all of them, as the model has it."""
        return self.at(self.angles)

    def at(self, angles) -> State:
        """Return the states of the same designs at other angles."""
        return State.of(self.design, angles.reshape(1, -1), self.flexion)


def random_states(rng, slack) -> States:
    """Return states of random designs, some of them past the dead centre.

    `slack` is "unilateral", "bilateral" or "both".
    """
    shape = tuple(rng.integers(1, 5, rng.integers(1, 4)))
    has_table, may_follow, has_anchors, has_springs_at_motor, has_torque = rng.random(5) < 0.25
    states_contact = rng.random() < 0.5

    def drawn(low, high):
        """Draw numbers that vary along some of the axes."""
        varies = rng.random(len(shape)) < 0.4
        return rng.uniform(low, high, (*np.where(varies, shape, 1), 1, 1))

    on_the_bone = rng.random() < 0.1
    a1 = 0.0 if on_the_bone else drawn(0.0, 0.07)
    b1 = drawn(0.08, 0.3)
    a2 = 0.0 if on_the_bone else drawn(0.0, 0.05)
    b2 = drawn(0.04, 0.2)
    elbow_radius = drawn(0.02, 0.07)

    is_loaded = rng.random() < 0.8
    forearm_mass = drawn(0.3, 3.0) * is_loaded
    load_distance = drawn(0.2, 0.4)
    upper_arm_angle = 0.0 if rng.random() < 0.3 else drawn(-2.0, 1.2)

    common_pretension = None
    if rng.random() < 0.7:
        levels = np.linspace(0.0, 300.0, shape[0])
        common_pretension = levels.reshape(-1, *[1] * (len(shape) + 1))

    def random_side():
        numbers = {name: drawn(low, high) for name, (low, high) in SIDE.items()}
        if may_follow and rng.random() < 0.7:
            numbers["bend_angle"] = rising_curve(rng, 2.0, 6.0)
        if has_anchors:
            numbers["anchor_stiffness"] = drawn(3e3, 4e4)
        if has_springs_at_motor:
            numbers["spring_at_motor"] = drawn(0.0, 1.0) > 0.3
        if common_pretension is not None:
            numbers["pretension"] = common_pretension
        return Side(**numbers)

    mixed = drawn(0.0, 1.0) > 0.5
    unilateral = {"unilateral": True, "bilateral": False, "both": mixed}[slack]
    from_initial = drawn(0.0, 1.0) > 0.5
    joint = Anchors(a1, b1, a2, b2, elbow_radius, from_initial=from_initial)
    if has_table:
        flexor_travel = rising_curve(rng, 0.0, 0.06)
        extensor_travel = rising_curve(rng, 0.0, 0.05)
        joint = Excursion(flexor_travel, extensor_travel, drawn(-0.2, 0.4), drawn(0.8, 1.2))
    limb = Limb(joint, forearm_mass, 0.17, load_distance, upper_arm_angle)
    if states_contact:
        limb = replace(limb, contact_from=drawn(-1.0, 3.5))
    if has_torque:
        limb = replace(limb, stiffness=drawn(0.0, 2.0), rest_angle=drawn(0.0, 1.5))
    design = Design(
        limb,
        flexor=random_side(),
        extensor=random_side(),
        flexor_radius=drawn(0.01, 0.06),
        ratio=drawn(0.5, 2.0),
        load_mass=drawn(0.0, 12.0) * is_loaded,
        unilateral=unilateral,
        setting=Posture(drawn(0.0, 0.4) if may_follow else 0.0),
    )

    angles = rng.uniform(-0.5, 3.0, rng.choice(ANGLE_COUNTS))
    if on_the_bone:
        angles = np.append(0.0, angles)  # there the flexor has no moment arm
    flexion = BOTH_DIRECTIONS[: rng.integers(1, 3)]
    return States(design, flexion, angles, (*shape, len(flexion), len(angles)))


def rising_curve(rng, low, high):
    """Return a curve that rises over most of the angles, and falls somewhere."""
    angles = np.linspace(-0.6, 3.1, 8)
    values = np.linspace(low, high, 8) + 0.06 * high * rng.standard_normal(8)
    spline = CubicSpline(angles, values)
    return Spline(spline.x, spline.c)
