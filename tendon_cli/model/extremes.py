"""Extremes of designs over all their states: smallest, largest, counted. A fold of states.

A fold starts from `begin`, takes states in any order and in any portions by `fold`, and ends in
`finish`, whose results are the columns of a table of designs. Only the values of single states are
rounded, as in the rows of states, so that the columns are the extremes of the rows to the last bit.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np

from tendon_cli.model.actuator import State
from tendon_cli.model.design import Design
from tendon_cli.model.kinematics import Array, Flags, Real
from tendon_cli.model.limits import LIMITS, contact_pressure, spring_room
from tendon_cli.model.setting import Reading
from tendon_cli.model.statics import SLACK_TOLERANCE
from tendon_cli.quantities import OF_DESIGNS, QUANTITIES

Extremes = dict[str, Array]
"""Extremes of designs over their states, by name, each of the shape of the designs."""

_SMALLEST = (
    "min_flexor_tension",
    "min_extensor_tension",
    "min_elbow_stiffness",
    "min_room",
    "first_slack_angle",
    "margin",
    "lowest_elbow_torque",
    "lowest_motor_torque",
)
_LARGEST = (
    "max_tension",
    "max_strap_tension",
    "max_spring_extension",
    "max_slack",
    "required_pretension",
    "highest_elbow_torque",
    "highest_motor_torque",
)
_NO_COLUMNS = (
    "max_strap_tension",
    "min_room",
    "lowest_elbow_torque",
    "highest_elbow_torque",
    "lowest_motor_torque",
    "highest_motor_torque",
)
"""Extremes that are no columns of designs, but of which columns are made."""
COUNTS = ("slack", "no_equilibrium", "unstable")
"""Names of the counts of states."""
OVER_STATES = {
    quantity.name: (quantity.value, quantity.over)
    for quantity in (QUANTITIES[name] for name in OF_DESIGNS)
    if quantity.value is not None and quantity.over is not None
}
"""Columns that only `quantities` defines: for each its values in states, and their reduction."""


def begin(shape: tuple[int, ...]) -> Extremes:
    """Return the extremes over no state yet, for designs of a shape.

    States of the same designs may then be folded in several portions.
    """
    starts = (
        dict.fromkeys(_SMALLEST, np.inf)
        | dict.fromkeys(_LARGEST, -np.inf)
        | dict.fromkeys(COUNTS, 0.0)
    )
    return {name: np.full(shape, start) for name, start in starts.items()}


def fold(folded: Extremes, at: State, elbow_angle: Array) -> None:
    """Fold more states into the extremes of designs, in place.

    Args:
        folded: Extremes so far.
        at: States, whose last two axes are directions and elbow angles; the others are those of
            `folded`.
        elbow_angle: The elbow angles, rad.
    """
    motor_torque = at.motor_torque
    stiffness = at.elbow_stiffness
    lower_pretension = np.minimum(at.design.flexor.pretension, at.design.extensor.pretension)
    columns = _tension_columns(at) | {
        "lowest_elbow_torque": at.elbow_torque,
        "highest_elbow_torque": at.elbow_torque,
        "lowest_motor_torque": motor_torque,
        "highest_motor_torque": motor_torque,
        "min_elbow_stiffness": stiffness,
        "required_pretension": at.response.required,
        "margin": np.fmin(at.balance.margin, lower_pretension),
        "unstable": stiffness < 0.0,
        "no_equilibrium": np.isnan(at.coupling.moment_arm),
    }
    motion_shape = np.broadcast_shapes(at.flexor.capstan.shape, np.shape(elbow_angle))[-2:]
    of_designs = {}
    for name, column in columns.items():
        values = np.atleast_2d(column)  # not broadcast: most columns vary along few axes
        if name in COUNTS:
            values = np.broadcast_to(values, (*values.shape[:-2], *motion_shape))
        of_designs[name] = _reduction(name).reduce(values, axis=(-2, -1))
    of_designs |= _slack_columns(at, elbow_angle, of_designs["no_equilibrium"])
    for name, values in of_designs.items():
        _reduction(name)(folded[name], values, out=folded[name])


def merge_tensions(folded: Extremes, others: Extremes) -> None:
    """Merge the extremes of tensions, and of what follows from them, over other states, in place.

    Counts and the elbow stiffness stay as they are.

    Args:
        folded: Extremes of designs.
        others: Extremes of the same designs over other states.
    """
    for name in (*_SMALLEST, *_LARGEST):
        if name != "min_elbow_stiffness":
            _reduction(name)(folded[name], others[name], out=folded[name])


def _tension_columns(at: State) -> dict[str, Array]:
    """Return the columns of `fold` on tensions and on the springs, which follow them."""
    flexor = at.balance.flexor
    extensor = at.balance.extensor
    flexor_at_motor = at.flexor_tension_proximal
    extensor_at_motor = at.extensor_tension_proximal
    max_flexor = np.fmax(flexor, flexor_at_motor)
    max_extensor = np.fmax(extensor, extensor_at_motor)
    flexor_extension = flexor * at.flexor.spring
    return {
        "min_flexor_tension": np.fmin(flexor, flexor_at_motor),
        "min_extensor_tension": np.fmin(extensor, extensor_at_motor),
        "max_tension": np.fmax(max_flexor, max_extensor),
        "max_strap_tension": extensor * at.is_pressed,
        "max_spring_extension": np.fmax(flexor_extension, extensor * at.extensor.spring),
        "min_room": spring_room(at) - flexor_extension,
    }


def _slack_columns(at: State, elbow_angle: Array, no_equilibrium: Array) -> Extremes:
    """Return the columns of `fold` on slack states, over designs.

    Args:
        at: States, as `fold` takes them.
        elbow_angle: The elbow angles, rad.
        no_equilibrium: Number of states without equilibrium, by design.
    """
    motion_shape = np.broadcast_shapes(at.flexor.capstan.shape, np.shape(elbow_angle))[-2:]
    is_slack = at.balance.is_slack
    slack = np.broadcast_to(is_slack, np.broadcast_shapes(is_slack.shape, motion_shape))
    count = np.add.reduce(slack, axis=(-2, -1), dtype=np.float64)
    lengths = np.where(slack, at.loose_length, np.nan)
    any_taut = math.prod(motion_shape) > count + no_equilibrium
    unilateral = np.reshape(at.design.unilateral, np.shape(at.design.unilateral)[:-2])
    taut_length = np.where(any_taut & unilateral, 0.0, np.nan)
    return {
        "slack": count,
        "first_slack_angle": np.fmin.reduce(np.where(slack, elbow_angle, np.inf), axis=(-2, -1)),
        "max_slack": np.fmax(np.fmax.reduce(lengths, axis=(-2, -1)), taut_length),
    }


def _reduction(name: str) -> np.ufunc:
    """Return the function that reduces values of states to an extreme or a count."""
    if name in COUNTS:
        return np.add
    if name in _SMALLEST:
        return np.fmin
    return np.fmax


def finish(folded: Extremes, states: int) -> Extremes:
    """Return the result columns of designs, from the extremes over all `states` of each.

    Results are NaN where no state has one. Minus zero becomes zero: which of the two is the
    smallest depends on the order of the states.
    """
    is_unanswerable = folded["no_equilibrium"] > 0
    failing = folded["slack"] + folded["no_equilibrium"]
    known = {}
    for name in (*_SMALLEST, *_LARGEST):
        values = folded[name] + 0.0
        known[name] = nan_where(np.isinf(values), values)
    required = np.maximum(0.0, known["required_pretension"])
    columns = {name: values for name, values in known.items() if name not in _NO_COLUMNS}
    return columns | {
        "peak_elbow_torque": _larger_magnitude(
            known["lowest_elbow_torque"], known["highest_elbow_torque"]
        ),
        "peak_motor_torque": _larger_magnitude(
            known["lowest_motor_torque"], known["highest_motor_torque"]
        ),
        "slack_fraction": failing / states,
        "unstable_fraction": folded["unstable"] / states,
        "required_pretension": nan_where(is_unanswerable, required),
        "margin": nan_where(is_unanswerable, known["margin"]),
    }


def nan_where(is_missing: Flags, values: Array) -> Array:
    """Return values with NaN where they are missing; `np.where` takes several times as long."""
    known = np.array(values)
    np.copyto(known, np.nan, where=is_missing)
    return known


def as_read(columns: Extremes, design: Design) -> Extremes:
    """Return the columns with pretensions in the reading in which the design's own is given."""
    if design.shows_f0:
        return columns
    reading = Reading.of(design)
    pretension = design.flexor.pretension
    required = columns["required_pretension"][..., np.newaxis, np.newaxis]
    margin = columns["margin"][..., np.newaxis, np.newaxis]
    margin_read = reading.shown(pretension) - reading.shown(pretension - margin)
    return columns | {
        "required_pretension": reading.shown(required)[..., 0, 0],
        "margin": margin_read[..., 0, 0],
    }


def judge(columns: Extremes, limits: Mapping[str, Real]) -> dict[str, Flags]:
    """Return which designs are `taut` in every state, `stable` in each, and `feasible`.

    A feasible design is both, and within every limit on a column as well. Limits are compared with
    the tolerance of slack. Limits on missing columns are skipped. NaN counts as within a limit.

    Args:
        columns: Result columns of designs, SI.
        limits: Bounds by the name of the limit, SI; arrays broadcast to the shape of the columns.
    """
    taut = columns["slack_fraction"] == 0.0
    stable = ~(columns["min_elbow_stiffness"] < limits["min_elbow_stiffness"])
    feasible = taut & stable
    for name, bound in limits.items():
        limit = LIMITS[name]
        column = name if limit.of_design else limit.column
        if column in columns and name != "min_elbow_stiffness":
            excess = limit.beyond(columns[column], bound)
            feasible = feasible & ~(excess > SLACK_TOLERANCE * np.abs(bound))
    return {"taut": taut, "stable": stable, "feasible": feasible}


def of_design(design: Design, folded: Extremes) -> Extremes:
    """Return the quantities of whole designs that limits bound, by the limit's name.

    They include the contact pressure (Pa) at the largest tension of the extensor where its strap
    presses.
    """
    values = {
        name: limit.of_design(design)
        for name, limit in LIMITS.items()
        if limit.of_design is not None
    }
    tension = folded["max_strap_tension"][..., np.newaxis, np.newaxis]
    values["max_contact_pressure"] = contact_pressure(design, tension)
    shape = (*folded["slack"].shape, 1, 1)
    return {name: np.broadcast_to(value, shape)[..., 0, 0] for name, value in values.items()}


def of_forms(names: Iterable[str], at: State) -> Extremes:
    """Return the extremes of the quantities that limits bound, over the last two axes of states.

    They are NaN where no state has a result, or a limit has nothing to bound, as the room for a
    spring if it is rigid.

    Args:
        names: Names of limits on forms of states.
        at: States.
    """
    columns = {}
    for name in names:
        limit = LIMITS[name]
        values = np.atleast_2d(limit.value(at))
        values = np.where(np.isinf(values), np.nan, values)
        reduction = np.fmin if limit.from_below else np.fmax
        columns[name] = reduction.reduce(values, axis=(-2, -1))
        if limit.in_magnitude:
            lowest = np.fmin.reduce(values, axis=(-2, -1))
            columns[name] = _larger_magnitude(lowest, columns[name])
    return columns


def over_states(at: State, shape: tuple[int, ...]) -> Extremes:
    """Return the columns of OVER_STATES, from all states of a block, which have a shape."""
    return {
        name: over(np.broadcast_to(value(at), shape).reshape(*shape[:-2], -1))
        for name, (value, over) in OVER_STATES.items()
    }


def _larger_magnitude(lowest: Array, highest: Array) -> Array:
    """Return the value of larger magnitude, with its sign."""
    larger = np.array(highest)
    np.copyto(larger, lowest, where=-lowest > highest)
    return larger
