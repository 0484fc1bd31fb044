"""What designs come to over all their states: smallest, largest, counted. A fold of the rows of states.

A fold starts from `begin`, takes states in any order and in any portions by `fold`, and ends in `finished`, whose
results are the columns of a table of designs. Nothing is rounded on the way but what the rows are, so that the columns
are the extremes of the rows to the last bit.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
import numpy.typing as npt

from tendon_cli.model.actuator import State
from tendon_cli.model.design import F0, Design
from tendon_cli.model.kinematics import Array
from tendon_cli.model.limits import LIMITS, contact_pressure
from tendon_cli.model.setting import Reading
from tendon_cli.model.statics import SLACK_TOLERANCE
from tendon_cli.quantities import OF_DESIGNS, QUANTITIES

Found = dict[str, Array]
"""Over designs, by name."""

_SMALLEST = (
    "min_flexor_tension",
    "min_extensor_tension",
    "min_elbow_stiffness",
    "first_slack_angle",
    "margin",
    "lowest_elbow_torque",
    "lowest_motor_torque",
)
_LARGEST = (
    "max_tension",
    "max_extensor_distal",
    "max_spring_extension",
    "max_slack",
    "required_pretension",
    "highest_elbow_torque",
    "highest_motor_torque",
)
COUNTS = ("slack", "no_equilibrium", "unstable")
OVER_STATES = {
    each.name: (each.value, each.over)
    for each in (QUANTITIES[name] for name in OF_DESIGNS)
    if each.value is not None and each.over is not None
}
"""Columns of which `quantities` says all: their values in states, and what is made of these."""


def begin(shape: tuple[int, ...]) -> Found:
    """No state yet, for designs of a shape; other axes or angles of the same designs may be folded in turn."""
    starts = (
        dict.fromkeys(_SMALLEST, np.inf)
        | dict.fromkeys(_LARGEST, -np.inf)
        | dict.fromkeys(COUNTS, 0.0)
    )
    return {name: np.full(shape, start) for name, start in starts.items()}


def fold(folded: Found, at: State, elbow_angle: Array) -> None:
    """Take in states, whose last two axes are directions and elbow angles (rad); the others are those of `folded`."""
    x, y, slack = at.balance.flexor, at.balance.extensor, at.balance.is_slack
    near_x, near_y, stiffness = (
        at.flexor_tension_proximal,
        at.extensor_tension_proximal,
        at.elbow_stiffness,
    )
    least = np.minimum(at.design.flexor.pretension, at.design.extensor.pretension)
    values = {
        "min_flexor_tension": np.fmin(x, near_x),
        "min_extensor_tension": np.fmin(y, near_y),
        "max_tension": np.fmax(np.fmax(x, near_x), np.fmax(y, near_y)),
        "max_extensor_distal": y,
        "max_spring_extension": np.fmax(x * at.flexor.spring, y * at.extensor.spring),
        "lowest_elbow_torque": at.elbow_torque,
        "highest_elbow_torque": at.elbow_torque,
        "lowest_motor_torque": at.motor_torque,
        "highest_motor_torque": at.motor_torque,
        "min_elbow_stiffness": stiffness,
        "max_slack": at.longest_slack,
        "required_pretension": at.response.required,
        "margin": np.fmin(at.balance.margin, least),
        "first_slack_angle": np.where(slack, elbow_angle, np.inf),
        "slack": slack,
        "unstable": stiffness < 0.0,
        "no_equilibrium": np.isnan(at.coupling.moment_arm),
    }
    motion = np.broadcast_shapes(at.flexor.capstan.shape, np.shape(elbow_angle))[-2:]
    for name, each in values.items():  # along the axes that it has: most differ along few
        ufunc = np.add if name in COUNTS else np.fmin if name in _SMALLEST else np.fmax
        its = np.atleast_2d(each)
        over = ufunc.reduce(np.broadcast_to(its, (*its.shape[:-2], *motion)), axis=(-2, -1))
        ufunc(folded[name], over, out=folded[name])


def finished(folded: Found, states: int) -> Found:
    """The result columns of designs, from the extremes over all `states` of each; NaN where no state has a result."""
    unanswerable, failing = folded["no_equilibrium"] > 0, folded["slack"] + folded["no_equilibrium"]
    known = {
        name: np.where(np.isinf(folded[name]), np.nan, folded[name])
        for name in (*_SMALLEST, *_LARGEST)
    }
    columns = {
        name: values for name, values in known.items() if not name.endswith(("_torque", "_distal"))
    } | {
        "peak_elbow_torque": _with_sign(
            known["lowest_elbow_torque"], known["highest_elbow_torque"]
        ),
        "peak_motor_torque": _with_sign(
            known["lowest_motor_torque"], known["highest_motor_torque"]
        ),
        "slack_fraction": failing / states,
        "unstable_fraction": folded["unstable"] / states,
        "required_pretension": np.where(
            unanswerable, np.nan, np.maximum(0.0, known["required_pretension"])
        ),
        "margin": np.where(unanswerable, np.nan, known["margin"]),
    }
    # Minus zero becomes zero: which of the two is the smallest depends on the order in which states are taken.
    return {name: values + 0.0 for name, values in columns.items()}


def as_read(columns: Found, design: Design) -> Found:
    """The result columns of designs with what is a pretension as the design's own is read."""
    if design.read == F0:
        return columns
    line, set_to = Reading.of(design), design.flexor.pretension
    least = {
        name: columns[name][..., np.newaxis, np.newaxis]
        for name in ("required_pretension", "margin")
    }
    required = line.shown(least["required_pretension"])
    margin = line.shown(set_to) - line.shown(set_to - least["margin"])
    return columns | {"required_pretension": required[..., 0, 0], "margin": margin[..., 0, 0]}


def judged(columns: Found, limits: Mapping[str, float]) -> dict[str, npt.NDArray[np.bool_]]:
    """Which designs are taut in every state, stable in each, and within every limit on a column as well, SI.

    Limits are kept with the tolerance of slack. Those on what `columns` have not are left out, and what is no number
    keeps them.
    """
    taut, stable = (
        columns["slack_fraction"] == 0.0,
        ~(columns["min_elbow_stiffness"] < limits["min_elbow_stiffness"]),
    )
    feasible = taut & stable
    for name, bound in limits.items():
        column = name if LIMITS[name].of_design else LIMITS[name].column
        if column in columns and name != "min_elbow_stiffness":
            feasible = feasible & ~(
                LIMITS[name].beyond(columns[column], bound) > SLACK_TOLERANCE * abs(bound)
            )
    return {"taut": taut, "stable": stable, "feasible": feasible}


def of_design(design: Design, folded: Found) -> Found:
    """What limits bound of designs that no state has, by the limit's name, and the contact pressure (Pa)."""
    pressure = contact_pressure(design, folded["max_extensor_distal"][..., np.newaxis, np.newaxis])
    values = {
        name: limit.of_design(design)
        for name, limit in LIMITS.items()
        if limit.of_design is not None
    }
    values["max_contact_pressure"] = pressure
    shape = folded["slack"].shape
    return {
        name: np.broadcast_to(value, (*shape, 1, 1))[..., 0, 0] for name, value in values.items()
    }


def of_forms(names: Iterable[str], at: State) -> Found:
    """What designs come to in limits on forms of states, over the last two axes; NaN where no state has a result."""
    columns = {}
    for name in names:
        limit = LIMITS[name]
        values = np.atleast_2d(limit.value(at))
        columns[name] = (np.fmin if limit.from_below else np.fmax).reduce(values, axis=(-2, -1))
        if limit.in_magnitude:
            columns[name] = _with_sign(np.fmin.reduce(values, axis=(-2, -1)), columns[name])
    return columns


def over_states(at: State, shape: tuple[int, ...]) -> Found:
    """The columns of OVER_STATES, from all states of designs: a block of a shape."""
    return {
        name: over(np.broadcast_to(value(at), shape).reshape(*shape[:-2], -1))
        for name, (value, over) in OVER_STATES.items()
    }


def _with_sign(lowest: Array, highest: Array) -> Array:
    """Of two values the one of larger magnitude, with its sign."""
    return np.where(-lowest > highest, lowest, highest)
