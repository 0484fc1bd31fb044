"""The worst of every quantity of a choice at its pretension, over all conditions that this serves."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tendon_cli import kernel
from tendon_cli.answers.factors import Numbers
from tendon_cli.answers.problem import Flags, Problem, Rows
from tendon_cli.model import extremes
from tendon_cli.model.actuator import Situation
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import contact_pressure

WORST = (
    "max_tension",
    "max_spring_extension",
    "peak_motor_torque",
    "min_elbow_stiffness",
    "max_contact_pressure",
)
"""What is told of a choice at its pretension, over all conditions that this serves."""


def worst(problem: Problem, numbers: Numbers, pretension: Array, held: Flags) -> dict[str, Array]:
    """The worst over the conditions that are held at a pretension, (choices,); NaN where none is."""
    largest = np.full((6, len(pretension)), np.nan)
    for rows, conditions, found in _quantities(problem, numbers, pretension):
        here = np.fmax.reduce(np.where(held[rows, conditions], found, np.nan), axis=2)
        largest[:, rows] = np.fmax(largest[:, rows], here)
    tension, extension, forward, backward, softness, pressure = largest
    torque = np.where(backward > forward, -backward, forward)
    return dict(zip(WORST, (tension, extension, torque, -softness, pressure), strict=True))


def severest(problem: Problem, numbers: Numbers, pretension: Array, held: Flags, most: int) -> Rows:
    """The conditions, `most` for each quantity, that are the worst for one choice."""
    whole = np.full((6, len(problem.conditions)), -np.inf)
    for rows, conditions, found in _quantities(problem, numbers, pretension):
        whole[:, conditions] = np.where(held[rows, conditions] & ~np.isnan(found), found, -np.inf)[:, 0]
    return np.unique(np.argsort(-whole, axis=1, kind="stable")[:, :most])


def _quantities(problem: Problem, numbers: Numbers, pretension: Array) -> Iterator[tuple[slice, slice, Array]]:
    """Of choices under conditions six quantities, the larger the worse, (6, choices, conditions)."""
    for rows, conditions in problem.chunks(len(pretension)):
        part = {key: values[rows] for key, values in numbers.items()}
        under = {key: values[conditions] for key, values in problem.condition_numbers.items()}
        design = problem.design(part, under, pretension[rows])
        shape = rows.stop - rows.start, conditions.stop - conditions.start
        found = _extremes(problem, design, shape)
        pressure = contact_pressure(design, found["max_extensor_distal"][..., np.newaxis, np.newaxis])[..., 0, 0]
        quantities = (
            found["max_tension"],
            found["max_spring_extension"],
            found["highest_motor_torque"],
            -found["lowest_motor_torque"],
            -found["min_elbow_stiffness"],
            np.broadcast_to(pressure, shape),
        )
        yield rows, conditions, np.stack(quantities)


def _extremes(problem: Problem, design: Design, shape: tuple[int, ...]) -> extremes.Found:
    """What designs of a shape, (choices, conditions), come to over all their states."""
    found, states = extremes.begin(shape), (*shape, problem.flexion.size, problem.angles.size)
    kernel.fold_extremes(
        found, Situation.of(design, problem.angles, problem.flexion), problem.angles.ravel(), states
    )  # fmt: skip
    return found
