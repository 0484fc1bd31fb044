"""Worst values of one choice at all elbow angles, also between the angles of the grid."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tendon_cli.engine.windows.points import Points
from tendon_cli.engine.windows.solver import Solver
from tendon_cli.engine.windows.worst import Worst
from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags
from tendon_cli.model.limits import contact_pressure, spring_room

_BESIDE = 0.01
"""Distance from the worst within which a condition may be the worst at other angles.

It is a share of the magnitude of the worst value plus its distance from the least severe one.
"""
_AT_ONCE = 2**8
"""Conditions that are worked out together."""
_PRESSURE = 5
"""Place of the strap's pressure among the quantities."""
_STEPS = 16
"""Dense steps between two angles of the grid."""


def worst_between(solver: Solver, points: Points, pretension: Array, served: Flags) -> Worst:
    """Return the worst of one choice at all angles over the conditions that it serves.

    Between two angles a quantity may exceed its values at both by an eighth of its second
    difference. Wherever twice that would make it the worst, it is worked out at denser angles and
    at the tops of the parabolas through these.

    Args:
        solver: Solver of the question.
        points: The choice.
        pretension: Its pretension, (1,), N.
        served: Conditions that it serves, (1, conditions).

    Returns:
        Its worst values; NaN if it serves no condition.
    """
    question = solver.question
    if question.conditions.groups is not None:
        return solver.worst(points, pretension, served)
    values = solver.quantities_under_each(points, pretension, served)  # (QUANTITIES, conditions)
    is_known = np.isfinite(values)
    most = values.max(axis=1)
    least = np.where(is_known, values, np.inf).min(axis=1)
    with np.errstate(invalid="ignore"):
        near = most - _BESIDE * (np.abs(most) + most - least)
    rows = np.flatnonzero((is_known & (values >= near[:, np.newaxis])).any(axis=0))
    angles = question.angles.ravel()
    dense = np.linspace(angles[0], angles[-1], _STEPS * (len(angles) - 1) + 1)[np.newaxis]
    at_pretension = points.at_pretension(pretension)
    count = len(rows) if len(angles) > 2 else 0
    for part in solver.cut(count, _AT_ONCE):
        conditions = rows[part]
        design = question.paired_designs(at_pretension, np.zeros_like(conditions), conditions)
        values = _quantities_at(design, question.angles, question.flexion, wherever=True)
        with np.errstate(invalid="ignore"):
            rise = np.abs(np.diff(values, 2)).max(axis=-1, keepdims=True) / 4.0
        largest = np.maximum(values[..., 1:], values[..., :-1]) + rise
        may_exceed = largest >= most[:, np.newaxis, np.newaxis, np.newaxis]
        for place in np.flatnonzero(may_exceed.any(axis=(0, 1, 2))):
            nearby = slice(max(0, place * _STEPS - 1), (place + 1) * _STEPS + 2)
            finer = _quantities_at(design, dense[:, nearby], question.flexion)
            tops = _tops(design, dense[:, nearby], question.flexion)
            for of_states in (finer, tops):
                most = np.fmax(most, of_states.max(axis=(1, 2, 3)))
    worst = Worst.of_quantities(np.where(np.isfinite(most), most, np.nan)[:, np.newaxis])
    names = solver.columns_of_motion
    return replace(worst, motion=solver.worst_of_motion(points, pretension, served, names))


def _quantities_at(
    design: Design, angles: Array, flexion: Flags, *, wherever: bool = False
) -> Array:
    """Return the quantities of `Worst.of_quantities` in states, the larger the worse.

    They are (QUANTITIES, designs, directions, angles), and -infinity where there is no value.

    Args:
        design: Designs, (designs, 1, 1).
        angles: Angles, (1, K), rad.
        flexion: Directions, (D, 1).
        wherever: True to give the strap's pressure also where it does not press yet.
    """
    state = State.of(design, angles, flexion)
    flexor = state.balance.flexor
    extensor = state.balance.extensor
    tension = np.maximum(
        np.maximum(flexor, state.flexor_tension_proximal),
        np.maximum(extensor, state.extensor_tension_proximal),
    )
    extension = np.maximum(flexor * state.flexor.spring, extensor * state.extensor.spring)
    torque = state.motor_torque
    quantities = (
        tension,
        extension,
        torque,
        -torque,
        -state.elbow_stiffness,
        contact_pressure(design, extensor * (state.is_pressed | wherever)),
        state.balance.flexor * state.flexor.spring - spring_room(state),
    )
    values: Array = np.stack(np.broadcast_arrays(*quantities))
    return np.where(np.isnan(values), -np.inf, values)


def _tops(design: Design, angles: Array, flexion: Flags) -> Array:
    """Return the top of the parabola through each peak and its neighbours, -infinity elsewhere.

    A strap has no pressure at tops where it does not press yet. Arguments are those of
    `_quantities_at`, and so is the result, but for the first and the last angle.
    """
    values = _quantities_at(design, angles, flexion, wherever=True)
    before = values[..., :-2]
    middle = values[..., 1:-1]
    after = values[..., 2:]
    with np.errstate(divide="ignore", invalid="ignore"):
        bend = before - 2.0 * middle + after
        top = middle - (after - before) ** 2 / (8.0 * bend)
        offset = 0.5 * (before - after) / bend
    is_peak = (middle >= before) & (middle >= after) & (top > middle)
    step = angles[0, 1] - angles[0, 0]
    angle_of_top = angles[:, 1:-1] + offset[_PRESSURE] * step
    is_peak[_PRESSURE] &= design.arm.is_pressed(angle_of_top)
    return np.where(is_peak, top, -np.inf)
