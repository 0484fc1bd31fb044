"""What designs come to over all their states: smallest, largest, counted. A fold of the rows of states.

A fold starts from `begin`, takes states in any order and in any portions by `fold`, and ends in `finished`, whose
results are the columns of a table of designs. Nothing is rounded on the way but what the rows are, so that the columns
are the extremes of the rows to the last bit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np
import numpy.typing as npt

from tendon_cli.model import statics
from tendon_cli.model.actuator import Situation, State
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Real
from tendon_cli.model.limits import contact_pressure, spool_to_tendon

Found = dict[str, Array]
"""Over designs, by name."""

_SMALLEST = (
    "min_flexor_tension", "min_extensor_tension", "min_elbow_stiffness", "first_slack_angle", "margin",
    "lowest_elbow_torque", "lowest_motor_torque",
)  # fmt: skip
_LARGEST = (
    "max_tension", "max_extensor_distal", "max_spring_extension", "max_slack", "required_pretension",
    "highest_elbow_torque", "highest_motor_torque",
)  # fmt: skip
COUNTS = ("slack", "no_equilibrium", "unstable")
STATES_AT_ONCE = 2**16
"""More than a few passes over them would have the processor fetch from memory."""


def begin(shape: tuple[int, ...]) -> Found:
    """Nothing found yet, for designs of a shape; other axes or angles of the same designs may be folded in turn."""
    starts = dict.fromkeys(_SMALLEST, np.inf) | dict.fromkeys(_LARGEST, -np.inf) | dict.fromkeys(COUNTS, 0.0)
    return {name: np.full(shape, start) for name, start in starts.items()}


def fold(found: Found, at: Situation, elbow_angle: Array) -> None:
    """Take in states, whose last two axes are directions and elbow angles (rad); the others are those of `found`."""
    states = np.broadcast_shapes(at.flexor.capstan.shape, np.shape(elbow_angle))[-2:]
    required = np.fmax.reduce(at.response.shortfall, axis=-1)
    _take(found, _before_pretension(at, states) | {"required_pretension": np.fmax.reduce(required, axis=-1)})
    for place, pretensions in _stretches(at, (*found["slack"].shape, *states)):
        here = {name: values[place] if place else values for name, values in found.items()}  # () gives no view
        _take(here, _at_pretension(State(at, *pretensions), required, elbow_angle))


def _before_pretension(at: Situation, states: tuple[int, ...]) -> Found:
    """What states come to whatever their pretension."""
    unanswerable = np.isnan(at.coupling.moment_arm)
    torque = np.where(unanswerable, np.nan, at.coupling.elbow_torque)
    whole = np.broadcast_to(unanswerable, (*unanswerable.shape[:-2], *states))
    return {
        "lowest_elbow_torque": _over(np.fmin, torque),
        "highest_elbow_torque": _over(np.fmax, torque),
        "no_equilibrium": _over(np.add, whole),
    }


def _at_pretension(state: State, required: Array, elbow_angle: Array) -> Found:
    """What states come to at their pretensions; `required` is the smallest that keeps all of a direction taut, N."""
    motor, stiffness, slack = state.motor_torque, state.elbow_stiffness, state.balance.is_slack
    smaller = np.minimum(state.flexor_pretension, state.extensor_pretension)
    surplus = _of_designs(state.balance.pretension) - required
    values = _tensions(state) | {
        "max_slack": np.fmax(_over(np.fmax, state.flexor_slack), _over(np.fmax, state.extensor_slack)),
        "lowest_motor_torque": _over(np.fmin, motor),
        "highest_motor_torque": _over(np.fmax, motor),
        "min_elbow_stiffness": _over(np.fmin, stiffness),
        "margin": np.fmin(np.fmin.reduce(surplus, axis=-1), _of_designs(_of_designs(smaller))),
    }
    if slack.any():
        values["slack"] = _over(np.add, slack)
        values["first_slack_angle"] = _over(np.fmin, np.where(slack, elbow_angle, np.nan))
    if (unstable := stiffness < 0.0).any():
        values["unstable"] = _over(np.add, unstable)
    return values


def _tensions(state: State) -> Found:
    """Tension only scales along a sheath, and the spring's extension with it, so those of each direction suffice."""
    at, x, y = state.situation, state.balance.flexor, state.balance.extensor
    low_x, high_x, low_y, high_y = (ufunc.reduce(each, axis=-1) for each in (x, y) for ufunc in (np.fmin, np.fmax))
    capstan_x, capstan_y = _of_designs(at.flexor.capstan), _of_designs(at.extensor.capstan)
    spring_x, spring_y = _of_designs(at.flexor.spring), _of_designs(at.extensor.spring)
    highest = np.fmax(np.fmax(high_x, high_x / capstan_x), np.fmax(high_y, high_y / capstan_y))
    return {
        "min_flexor_tension": np.fmin.reduce(np.fmin(low_x, low_x / capstan_x), axis=-1),
        "min_extensor_tension": np.fmin.reduce(np.fmin(low_y, low_y / capstan_y), axis=-1),
        "max_tension": np.fmax.reduce(highest, axis=-1),
        "max_extensor_distal": np.fmax.reduce(high_y, axis=-1),
        "max_spring_extension": np.fmax.reduce(np.fmax(high_x * spring_x, high_y * spring_y), axis=-1),
    }


def _of_designs(values: Real) -> Real:
    """Values that are the same along the last axis, where they have any, without it."""
    return values[..., 0] if isinstance(values, np.ndarray) and values.ndim else values


def _over(ufunc: np.ufunc, values: npt.NDArray[np.generic]) -> Array:
    """Values of states over directions and elbow angles."""
    reduced: Array = ufunc.reduce(values, axis=(-2, -1), dtype=np.float64)
    return reduced


def _take(found: Found, values: Found) -> None:
    """Fold what some states come to into what was found."""
    for name, value in values.items():
        ufunc = np.add if name in COUNTS else np.fmin if name in _SMALLEST else np.fmax
        ufunc(found[name], value, out=found[name])


def _stretches(at: Situation, shape: tuple[int, ...]) -> Iterator[tuple[tuple[slice, ...], tuple[Real, Real]]]:
    """States of a shape in stretches along an axis that nothing but pretension depends on, and their pretensions.

    So what does not depend on it is worked out once, and what does stays within the processor's cache.
    """
    sides = at.design.flexor.pretension, at.design.extensor.pretension
    known = np.broadcast_shapes((1,) * len(shape), at.response.flexor_limit.shape, at.motor_arms[0].shape)
    free = [axis for axis, length in enumerate(known[:-2]) if length == 1 < shape[axis]]
    if not free:
        yield (), sides
        return
    axis = max(free, key=shape.__getitem__)
    most = max(1, STATES_AT_ONCE * shape[axis] // math.prod(shape))
    for start in range(0, shape[axis], most):
        place = (*[slice(None)] * axis, slice(start, start + most))
        flexor, extensor = (
            side if np.ndim(side) < len(shape) or np.shape(side)[axis] == 1 else np.asarray(side)[place]
            for side in sides
        )
        yield place, (flexor, extensor)


def finished(found: Found, states: int) -> Found:
    """The result columns of designs, from the extremes over all `states` of each; NaN where no state has a result."""
    unanswerable, failing = found["no_equilibrium"] > 0, found["slack"] + found["no_equilibrium"]
    known = {name: np.where(np.isinf(found[name]), np.nan, found[name]) for name in (*_SMALLEST, *_LARGEST)}
    columns = {name: values for name, values in known.items() if not name.endswith(("_torque", "_distal"))} | {
        "peak_elbow_torque": _with_sign(known["lowest_elbow_torque"], known["highest_elbow_torque"]),
        "peak_motor_torque": _with_sign(known["lowest_motor_torque"], known["highest_motor_torque"]),
        "slack_fraction": failing / states,
        "unstable_fraction": found["unstable"] / states,
        "required_pretension": np.where(unanswerable, np.nan, np.maximum(0.0, known["required_pretension"])),
        "margin": np.where(unanswerable, np.nan, known["margin"]),
    }
    # Minus zero becomes zero: which of the two is the smallest depends on the order in which states are taken.
    return {name: values + 0.0 for name, values in columns.items()}


def judged(columns: Found, limits: Mapping[str, float]) -> dict[str, npt.NDArray[np.bool_]]:
    """Which designs are taut in every state, stable in each, and within every limit on a column as well, SI.

    A limit bounds the column of its name: from below (min_), above (max_) or in magnitude (peak_), with the tolerance
    of slack. Limits on what `columns` have not are left out, and what is no number keeps them.
    """
    taut, stable = columns["slack_fraction"] == 0.0, ~(columns["min_elbow_stiffness"] < limits["min_elbow_stiffness"])
    feasible = taut & stable
    for name, limit in limits.items():
        if name in columns and name != "min_elbow_stiffness":
            beyond = limit - columns[name] if name.startswith("min_") else np.abs(columns[name]) - limit
            feasible = feasible & ~(beyond > statics.SLACK_TOLERANCE * abs(limit))
    return {"taut": taut, "stable": stable, "feasible": feasible}


def of_design(design: Design, found: Found) -> Found:
    """What limits bound of designs that no state has: the pretension, contact pressure (Pa), and spool over tendon."""
    values = {
        "max_pretension": np.maximum(design.flexor.pretension, design.extensor.pretension),
        "max_contact_pressure": contact_pressure(design, found["max_extensor_distal"][..., np.newaxis, np.newaxis]),
        "min_spool_to_tendon": spool_to_tendon(design),
    }
    shape = found["slack"].shape
    return {name: np.broadcast_to(value, (*shape, 1, 1))[..., 0, 0] for name, value in values.items()}


def _with_sign(lowest: Array, highest: Array) -> Array:
    """Of two values the one of larger magnitude, with its sign."""
    return np.where(-lowest > highest, lowest, highest)
